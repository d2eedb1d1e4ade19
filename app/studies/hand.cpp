// SPDX-License-Identifier: Apache-2.0
#include "app/studies/hand.h"

#include <fmt/format.h>

#include <iostream>

#include "app/exit_code.h"
#include "app/results.h"
#include "app/studies/hand_capacity.h"
#include "app/studies/hand_list.h"
#include "engine/figures/gnuplot.h"
#include "engine/figures/hand_picture.h"
#include "engine/formats/files.h"
#include "engine/formats/text.h"
#include "engine/imports/hand_import.h"
#include "engine/imports/hand_text.h"
#include "engine/scenes/config.h"
#include "engine/scenes/hand_file.h"
#include "engine/scenes/shared_data.h"

namespace thenar::app {

namespace fs = std::filesystem;

namespace {

HandRequest request_of(const HandOptions& options) {
  HandRequest request;
  for (const std::string& tips : options.tips) {
    for (const std::string& tip : split_tips(tips)) request.tips.push_back(read_tip(tip));
  }
  for (const std::string& lock : options.locks) request.locks.push_back(read_lock(lock));
  request.base = options.base;
  if (!options.axes.empty()) request.R_BH = read_axes(options.axes);
  request.uncouple = options.uncouple;
  request.mirror = options.mirror;
  return request;
}

/// The comment that the hand file begins with.
std::string origin_of(const HandOptions& options, const BodyTree& tree, const Hand& hand) {
  std::string tips;
  for (std::size_t i = 0; i < options.tips.size(); ++i) tips += (i == 0 ? "" : ",") + options.tips[i];
  const bool has_quotes = tips.find('"') != std::string::npos;  // A shell takes them in single ones.
  std::string flags = has_quotes ? "--tips '" + tips + "'" : "--tips " + tips;
  for (const std::string& lock : options.locks) flags += " --lock " + lock;
  if (!options.base.empty()) flags += " --base " + options.base;
  if (!options.axes.empty()) flags += " --axes " + options.axes;
  if (options.uncouple) flags += " --uncouple";
  if (options.mirror) flags += " --mirror";
  return fmt::format("A hand of {}, {} and {}, from {} by\n# thenar hand import {} {}",
                     counted(hand.fingers(), "finger"), counted(std::ssize(hand.joints), "joint"),
                     counted(std::ssize(hand.muscles), "muscle"), tree.file, tree.file, flags);
}

int import_file(const HandOptions& options) {
  check_results({{"--out", options.out}}, {options.file});
  const BodyTree tree = read_bodies(options.file);
  const ImportedHand made = import_hand(tree, request_of(options));
  write_file(options.out, hand_text(made, origin_of(options, tree, made.hand)));
  for (const std::string& note : made.notes) std::cerr << "note: " << note << '\n';
  for (std::size_t m = 0; m < made.muscle_notes.size(); ++m) {
    if (made.muscle_notes[m].empty()) continue;
    std::cerr << fmt::format("note: muscle '{}' {}\n", made.hand.muscles[m].name, made.muscle_notes[m]);
  }
  std::cout << hand_list(load_hand(options.out), printable(options.out.string()));
  return kDone;
}

}  // namespace

int run_hand(const HandOptions& options) {
  if (!options.file.empty()) return import_file(options);
  if (!options.capacity.scene.empty()) return run_hand_capacity(options.capacity);
  if (options.hand.empty()) throw ConfigError({{"hand", "", "name a hand file, or import: thenar hand --help"}});
  const fs::path file = find_hand(options.hand);
  const Hand hand = load_hand(file);
  std::cout << hand_list(hand, printable(file.string()));
  if (options.out.empty()) {
    std::cout << "\nwith --out FILE.png it is drawn\n";
    return kDone;
  }
  check_results({{"--out", options.out}}, {file});
  if (!draw_figure(hand_picture_script(hand), options.out)) {
    throw FileError(options.out, "gnuplot, which draws it, is missing or failed");
  }
  std::cout << "\npicture in " << printable(options.out.string()) << '\n';
  return kDone;
}

}  // namespace thenar::app
