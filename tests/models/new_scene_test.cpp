// SPDX-License-Identifier: Apache-2.0
// Scenes for objects that a user brings: what is written for a mesh runs, holds, and has nothing to warn of.

#include "engine/models/new_scene.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "engine/formats/files.h"
#include "engine/models/build_model.h"
#include "engine/results/scene_run.h"
#include "engine/results/warnings.h"
#include "engine/scenes/scene_file.h"
#include "tests/support/scratch.h"

namespace thenar::new_scene_test {
namespace {

using Profile = std::vector<std::array<double, 2>>;  ///< Radius and height in mm, from axis to axis, the outside first.

constexpr int kSides = 48;

/// A closed surface of revolution about z: the mesh, in mm, of a profile that begins below and ends on the axis.
std::filesystem::path turned(const Profile& profile, int sides = kSides) {
  std::string vertices, faces;
  std::vector<int> first;  // Vertex of each point of the profile.
  int number = 0, count = 0;
  for (const auto& [r, z] : profile) {
    first.push_back(number);
    const int here = r == 0.0 ? 1 : sides;
    for (int i = 0; i < here; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / sides;
      vertices += fmt::format("{:.9g} {:.9g} {:.9g}\n", r * std::cos(angle), r * std::sin(angle), z);
    }
    number += here;
  }
  const auto corner = [&](std::size_t point, int side) {
    return profile[point][0] == 0.0 ? first[point] : first[point] + side % sides;
  };
  for (std::size_t p = 0; p + 1 < profile.size(); ++p) {
    for (int i = 0; i < sides; ++i, ++count) {
      const int a = corner(p, i), b = corner(p, i + 1), c = corner(p + 1, i + 1), d = corner(p + 1, i);
      faces += a == b   ? fmt::format("3 {} {} {}\n", a, c, d)
               : c == d ? fmt::format("3 {} {} {}\n", a, b, c)
                        : fmt::format("4 {} {} {} {}\n", a, b, c, d);
    }
  }
  const std::filesystem::path file = scratch() / "object.off";
  std::ofstream(file) << fmt::format("OFF\n{} {} 0\n", number, count) << vertices << faces;
  return file;
}

/// Writes a scene for a mesh in mm, runs what it holds for half a second, and expects nothing to be wrong with it.
void expect_no_warnings(const std::filesystem::path& mesh, double mass_kg) {
  const std::filesystem::path file = mesh.parent_path() / "new.yaml";
  (void)write_new_scene(file, {.object = mesh, .unit_m = 1e-3, .mass_kg = mass_kg});
  const Model model = build_model(load_scene(file, {"time.duration=0.5 s"}));
  for (const std::string& warning : warnings(model)) ADD_FAILURE() << "before the run: " << warning;
  State state(model);
  const Recording recording = run_scene(model, state);
  EXPECT_EQ(recording.verdict.outcome, Outcome::kHeld) << in_words(recording.verdict);
  for (const std::string& warning : warnings(model, recording)) ADD_FAILURE() << "in the run: " << warning;
}

TEST(NewScene, OfAMugWarnsOfNothing) {
  expect_no_warnings(turned({{0, 0}, {35, 0}, {35, 90}, {31.5, 90}, {31.5, 4}, {0, 4}}), 0.25);
}

TEST(NewScene, OfAnEggWarnsOfNothing) {
  Profile egg{{0, 0}};
  for (int i = 1; i < 24; ++i) {
    const double t = std::numbers::pi * i / 24.0;
    egg.push_back({22.0 * std::sin(t) * (1.0 + 0.12 * std::cos(t)), 28.0 * (1.0 - std::cos(t))});
  }
  egg.push_back({0, 56});
  expect_no_warnings(turned(egg), 0.06);
}

TEST(NewScene, OfAScrewdriverWarnsOfNothing) {
  expect_no_warnings(turned({{0, 0}, {12, 0}, {12, 95}, {3, 95}, {3, 180}, {0, 180}}), 0.07);
}

TEST(NewScene, OfABoxWarnsOfNothing) { expect_no_warnings(turned({{0, 0}, {40, 0}, {40, 80}, {0, 80}}, 4), 0.2); }

// A square of 40 mm from corner to corner, 50 mm high: 2 * 2 * 2 * 5 cm^3 of 200 g.
TEST(NewScene, NamesTheVolumeAndTheDensity) {
  const std::filesystem::path file = scratch() / "new.yaml";
  (void)write_new_scene(file,
                        {.object = turned({{0, 0}, {20, 0}, {20, 50}, {0, 50}}, 4), .unit_m = 1e-3, .mass_kg = 0.2});
  std::string text = read_file(file);
  for (std::size_t at = text.find("\n# "); at != std::string::npos; at = text.find("\n# ")) text.replace(at, 3, " ");
  EXPECT_NE(text.find("It encloses 40 cm^3, so that its mass of 200 g makes it 5 g/cm^3 dense"), std::string::npos)
      << text;
}

}  // namespace
}  // namespace thenar::new_scene_test
