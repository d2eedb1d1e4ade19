// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

/// Files of hands that are made here, by formulas and seeds, with the parts that files of MJCF and URDF have.
namespace thenar {

/// A fingertip: a place on a body, and the direction in which the pulp faces, in the body's axes.
struct MadeTip {
  std::string finger, body;
  std::array<double, 3> centre_m, normal;
};

/// A joint that follows another one: its angle is `ratio` times that of the other plus `offset_rad`.
struct MadeTie {
  std::string follower, leader;
  double ratio = 1.0, offset_rad = 0.0;
};

struct MadeHand {
  std::string main;                          ///< The file to import.
  std::map<std::string, std::string> files;  ///< Contents by name, with those of included files.
  std::vector<MadeTip> tips;                 ///< The thumb first.
  std::vector<MadeTie> ties;                 ///< Those of URDF: MuJoCo passes them over.
  std::vector<std::string> noted;            ///< Words of notes that the import must have.
};

inline constexpr std::array kMadeKinds{"classes", "poses", "joints",    "masses", "strings",    "wraps",
                                       "ties",    "names", "actuators", "urdf",   "urdf_mimics"};

/// Makes a hand of a kind. Equal seeds make equal hands.
[[nodiscard]] MadeHand made_hand(const std::string& kind, std::uint64_t seed);

}  // namespace thenar
