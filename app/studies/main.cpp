// SPDX-License-Identifier: Apache-2.0
// The program `thenar-studies`, which `thenar` becomes for all that asks more of a scene than one run.

#include "app/host.h"
#include "app/program.h"
#include "app/studies/check.h"
#include "app/studies/grasp.h"
#include "app/studies/hand.h"
#include "app/studies/insertion.h"
#include "app/studies/solve.h"
#include "app/studies/stiffness.h"
#include "app/studies/sweep.h"
#include "engine/scenes/config.h"
#include "engine/scenes/hand_file.h"

namespace thenar::app {

namespace {

/// Of a scene, or of a hand. Throws ConfigError for a flag of the other.
int check(const Options& options) {
  const auto refuse = [&](bool asked, const char* flag, const char* why) {
    if (asked) throw ConfigError({{flag, "", options.scene.string() + why}});
  };
  if (!is_hand_file(options.scene)) {
    refuse(!options.hand.out.empty(), "--out", " is a scene, and this draws hands: thenar run --out draws a scene");
    return print(description(scene_of(options), options.parts));
  }
  refuse(!options.overrides.empty(), "--set", " is a hand, and this changes scenes");
  refuse(options.parts, "--parts", " is a hand, and this runs scenes");
  HandOptions hand = options.hand;
  hand.hand = options.scene.string();
  return run_hand(hand);
}

int run_command(int argc, char** argv) {
  const Commands commands{
      {"check", check},         {"hand", [](const Options& o) { return run_hand(o.hand); }},
      {"solve", solve},         {"grasp", grasp},
      {"new", new_scene},       {"sweep", sweep},
      {"insertion", insertion}, {"stiffness", [](const Options& o) { return run_stiffness(o.stiffness); }}};
  return run_program(argc, argv, commands, "thenar");
}

}  // namespace

}  // namespace thenar::app

int main(int argc, char** argv) {
  thenar::app::hold_standard_streams();
  return thenar::app::run_command(argc, argv);
}
