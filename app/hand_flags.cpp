// SPDX-License-Identifier: Apache-2.0
#include "app/hand_flags.h"

#include <CLI/CLI.hpp>

#include "app/scene_flags.h"

namespace thenar::app {

namespace {

void add_hand_capacity(CLI::App& hand, CapacityOptions& options) {
  CLI::App* const command = hand.add_subcommand(
      "capacity", "Finds the largest forces that a hand's muscles can give in the posture in which a scene starts");
  add_scene(*command, options.scene, options.overrides,
            "Scene (YAML), or the name of one that comes with the program; a hand alone has no posture", true);
  command->add_option("--friction", options.friction, "Friction of the pinch; default: the scene's")
      ->type_name("NUMBER")
      ->check(within(0.0, 10.0));
  command->add_option("--json", options.json, "File for all figures")
      ->type_name("FILE")
      ->check(named())
      ->check(no_folder());
}

}  // namespace

void add_hand(CLI::App& app, HandOptions& options) {
  CLI::App* const command = app.add_subcommand(
      "hand", "Lists and draws a hand, says what its muscles can give, or makes one of an MJCF or URDF file");
  command->add_option("HAND", options.hand, "Hand file (YAML), or the name of a hand that comes with the program")
      ->type_name("HAND");
  command->add_option("--out", options.out, "The hand's picture (PNG)")
      ->type_name("FILE")
      ->check(named())
      ->check(no_folder());
  CLI::App* const import = command->add_subcommand("import", "Makes a hand file of an MJCF or URDF file");
  command->require_subcommand(0, 1);
  import->add_option("FILE", options.file, "MJCF (.xml) or URDF (.urdf)")->required()->type_name("FILE");
  import
      ->add_option(
          "--tips", options.tips,
          "The fingers, the thumb first: thumb=th_tip,index=if_tip names a body, link or site for each. Behind "
          "it, in any order, :9mm is the pulp's radius, :@0/-36/14.5mm its centre in the axes of what is "
          "named, and :-x or :0/1/0.3 the direction in which it faces. A name with : or , stands in quotes: "
          "'thumb=\"robot0:tip\"'")
      ->required()
      ->take_all()
      ->type_name("FINGER=BODY");
  import->add_option("--out", options.out, "The hand file (YAML)")
      ->required()
      ->type_name("FILE")
      ->check(named())
      ->check(no_folder());
  import
      ->add_option("--base", options.base,
                   "The body, link or site whose frame is the hand's; default: the body where the fingers part")
      ->type_name("BODY");
  import
      ->add_option("--axes", options.axes,
                   "The hand's X and Y as axes of the base, such as z,-x; Thenar's own hands have X distal, Y palmar")
      ->type_name("AXES");
  import->add_option("--lock", options.locks, "A joint that is not to move, where it is, or at JOINT=20deg")
      ->take_all()
      ->type_name("JOINT");
  import->add_flag("--uncouple", options.uncouple, "Takes coupled joints as if each had its own drive");
  import->add_flag("--mirror", options.mirror, "Makes the hand of the other side: turns z round");
  add_hand_capacity(*command, options.capacity);
}

}  // namespace thenar::app
