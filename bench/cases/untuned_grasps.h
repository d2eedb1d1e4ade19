// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "bench/cases/random.h"
#include "engine/scenes/scene_file.h"

namespace thenar {

/// A scene with a random grasp that a hand finds by itself, and a random stiffness that its muscles are chosen for.
struct UntunedGrasp {
  std::string name;
  Scene scene;
};

/// Draws a grasp: five objects, held by three fingers of one hand or by four or five of the other. The fibres of the
/// hand of five fingers have a larger gamma than people's: with theirs no muscle forces hold the posture of its ring
/// and little finger, so that such grasps have no rest.
inline UntunedGrasp untuned_grasp(std::uint64_t seed, int leaves) {
  struct Held {
    const char *name, *shape;
  };
  struct Hands {
    const char *name, *file, *fingers, *gamma;
  };
  constexpr std::array objects{
      Held{"box", "{box: [44 mm, 50 mm, 60 mm]}"},
      Held{"cylinder", "{cylinder: {radius: 22 mm, length: 80 mm}}"},
      Held{"ball", "{sphere: 27 mm}"},
      Held{"ellipsoid", "{ellipsoid: [50 mm, 60 mm, 70 mm]}"},
      Held{"mug", "{mug: {radius: 27.5 mm, height: 70 mm, wall: 3 mm, handle: {radius: 14 mm, thickness: 7 mm}}}"},
  };
  constexpr std::array hands{
      Hands{"three fingers", "hand.yaml", "thumb, index, major", "23.4"},
      Hands{"four fingers", "hands/human5.yaml", "thumb, index, major, ring", "60"},
      Hands{"five fingers", "hands/human5.yaml", "thumb, index, major, ring, little", "60"},
  };
  Random random(seed);
  const auto between = [&](double low, double high) { return random.power_of_ten(std::log10(low), std::log10(high)); };
  const auto three = [&](double low, double high, const char* unit) {
    const double x = between(low, high), y = between(low, high), z = between(low, high);
    return fmt::format("[{:.3g} {}, {:.3g} {}, {:.3g} {}]", x, unit, y, unit, z, unit);
  };
  const std::string configs = THENAR_CONFIGS;
  const Held& object = objects[seed % objects.size()];
  const Hands& hand = hands[seed / objects.size() % hands.size()];
  const std::string press = fmt::format("{:.3g} N", between(0.8, 2.0)),
                    mass = fmt::format("{:.3g} g", between(30, 150));
  const std::string translation = three(30.0, 200.0, "N/m"), rotation = three(0.01, 0.08, "N*m/rad");
  return {
      fmt::format("{}, {}", object.name, hand.name),
      load_scene(configs + "/found_carry.yaml",
                 {fmt::format("hand={{model: {}/{}, fingers: [{}], settle: true, joint_viscosity: 0.05 N*m*s}}",
                              configs, hand.file, hand.fingers),
                  fmt::format("grasp={{fingers: [{}], seed: {}, press: {}}}", hand.fingers, seed, press),
                  fmt::format("object.shape={}", object.shape), "object.mass=" + mass, "contact.max_per_finger=32",
                  fmt::format("fingertips.leaves={}", leaves), "task={}",
                  fmt::format("control.muscles={{stiffness: {}, object_stiffness: {{translation: {}, rotation: {}}}}}",
                              hand.gamma, translation, rotation)})};
}

}  // namespace thenar
