// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

/// What the program refuses: inputs as people spoil them, and what it says to each. The tables are in refused_*.h.
namespace thenar::refusals {

/// One input that is refused. The program runs in a folder that holds nothing but the file `name` with `text`.
struct Refusal {
  std::string what;     ///< What a person did wrong.
  std::string command;  ///< With FILE for the file's name.
  std::string name;     ///< Empty: there is no file.
  std::string text;
  int code;             ///< 2 for a command line, a scene or a hand, 3 for another file: docs/guide/run.md.
  std::string message;  ///< All that is printed but for the line's end, with FILE for the file's name.
  std::string shell;    ///< Words of the shell in front of the program.
};
using Refusals = std::vector<Refusal>;

/// Returns the text with its first `from` replaced by `to`.
inline std::string edited(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("nothing to replace: " + from);
  return text.replace(at, from.size(), to);
}

/// A scene that runs.
inline const std::string kScene = R"(name: ball
time: {duration: 50 ms, step: 1 ms, control_period: 1 ms}
gravity: [7.018620 m/s^2, 5.581331 m/s^2, 3.977916 m/s^2]
hand:
  model: three_finger
  posture: [0.0863 rad, 0.2539 rad, -0.1260 rad, 0.6359 rad, 0.2484 rad, -0.0424 rad,
            0.5342 rad, 0.5939 rad, 0.4201 rad, -0.0783 rad, 0.5537 rad, 0.5190 rad]
  joint_viscosity: 0.05 N*m*s
object:
  shape: {sphere: 26.09 mm}
  points: 2000
  mass: 100 g
  position: [120.187 mm, 45.770 mm, 35.908 mm]
  rotation: [[0.6853202845266846, 0.1358649520401693, -0.7154556746741104],
             [-0.4586328879447013, -0.6826124060172365, -0.568943035151027],
             [-0.5656783376723623, 0.7180397050013894, -0.405495992988526]]
  damping: {translation: 10 N*s/m, rotation: 0.005 N*m*s}
contact: {friction: 0.8, band: 0.3 mm}
control:
  law: feedforward
  gain: auto
  pulp: {normal: 50 N/mm, tangential: 33.3 N/mm}
  grasp: {friction: 0.55, internal_force: 2 N}
  position: {p: 300 N/m, i: 900 N/(m*s)}
  rotation: {p: 0.48 N*m/rad, i: 1.5 N*m/(rad*s)}
  muscles: false
)";

/// A box of 30 x 40 x 60 mm, in mm.
inline const std::string kBox = R"(v 0 0 0
v 30 0 0
v 30 40 0
v 0 40 0
v 0 0 60
v 30 0 60
v 30 40 60
v 0 40 60
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
)";

/// Returns points on a ball of 25 mm, a line each, in mm.
inline std::string ball(int points) {
  std::string lines;
  for (int i = 0; i < points; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / points, r = std::sqrt(1.0 - z * z), a = 2.399963 * i;
    lines += fmt::format("{:.3f} {:.3f} {:.3f}\n", 25.0 * r * std::cos(a), 25.0 * r * std::sin(a), 25.0 * z);
  }
  return lines;
}

/// Returns the bytes of whole numbers, little-endian.
inline std::string bytes_of(const std::vector<std::uint32_t>& numbers) {
  std::string bytes;
  for (const std::uint32_t number : numbers) {
    for (int shift = 0; shift < 32; shift += 8)
      bytes += static_cast<char>(number >> static_cast<unsigned>(shift) & 0xFFU);
  }
  return bytes;
}

}  // namespace thenar::refusals
