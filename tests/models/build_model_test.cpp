// SPDX-License-Identifier: Apache-2.0
#include "engine/models/build_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/scenes/config.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"
#include "tests/support/small_scenes.h"

namespace thenar::build_model_test {
namespace {

using namespace small_scenes;

using Eigen::Vector3d;

TEST(Scene, RefusesACentreOfMassOutsideOfTheObject) {
  const std::string key = "object.centre_of_mass", box = "object.shape={box: [50 mm, 40 mm, 30 mm]}";
  EXPECT_EQ(fault_with({box, key + "=[25 mm, -20 mm, 15 mm]"}), "") << "a corner";
  EXPECT_EQ(fault_with({box, key + "=[0 mm, 0 mm, 15.1 mm]"}),
            key + ": must lie within the object: -25 .. 25, -20 .. 20, -15 .. 15 mm in its frame");
  const std::string mug =
      "object.shape={mug: {radius: 25 mm, height: 30 mm, wall: 10 mm, handle: {radius: 9 mm, "
      "thickness: 8 mm}}}";
  EXPECT_EQ(fault_with({mug, key + "=[37.9 mm, 0 mm, 0 mm]"}), "") << "in the handle";
  EXPECT_EQ(fault_with({mug, key + "=[-37.9 mm, 0 mm, 0 mm]"}).substr(0, key.size()), key);
  EXPECT_EQ(fault_with({key + "=[0, 0 mm, 0 mm]"}), key + "[0]: 0 has no unit: use m, cm, mm or um");
  EXPECT_EQ(fault_with({key + "=3 mm"}).substr(0, key.size()), key);
  EXPECT_EQ(fault_with({key + "=[0 mm, 0 mm]"}).substr(0, key.size()), key);

  // What a file holds shows when the model is made.
  Scene scene = scene_of("minimal", {box, "object.points=2000"});
  scene.object.centre_of_mass_m = Vector3d(0.0, 0.0, 0.03);
  EXPECT_THROW((void)build_model(scene), ConfigError);
}

// Whoever watches a start sees every stage as it begins, once, and the model is the one that nobody watched.
TEST(Model, TellsTheStagesOfItsStartInTheirOrder) {
  std::vector<std::string> stages;
  const auto watch = [&](const char* stage) { stages.emplace_back(stage); };
  const Scene rigid = scene_of("minimal", {"object.points=2000"});
  const Model watched = build_model(rigid, watch), unseen = build_model(rigid);
  const std::vector<std::string> surface{"the object's samples", "faults among the samples", "the object's surface",
                                         "patches of the surface"};
  EXPECT_EQ(stages, surface);
  EXPECT_EQ(watched.object.cloud().points_m, unseen.object.cloud().points_m);

  stages.clear();
  (void)build_model(scene_of("box_grasp", {"object.points=2000"}), watch);
  std::vector<std::string> all = surface;
  all.emplace_back("the fingertips");
  EXPECT_EQ(stages, all);
}

/// What a frame and a tick read of a model's fingertips and surface.
void expect_same_bits(const Model& one, const Model& other) {
  ASSERT_EQ(one.pulps.size(), other.pulps.size());
  for (std::size_t k = 0; k < one.pulps.size(); ++k) {
    EXPECT_EQ(one.pulps[k].surface.points_m, other.pulps[k].surface.points_m);
    EXPECT_EQ(one.pulps[k].control_points_m, other.pulps[k].control_points_m);
    EXPECT_EQ(one.pulps[k].kernel, other.pulps[k].kernel);
    EXPECT_EQ(one.pulps[k].a, other.pulps[k].a);
    EXPECT_EQ(one.pulps[k].b, other.pulps[k].b);
    EXPECT_EQ(one.pulps[k].area_m2, other.pulps[k].area_m2);
    EXPECT_EQ(one.pulps[k].material, other.pulps[k].material);
  }
  EXPECT_EQ(one.object.cloud().points_m, other.object.cloud().points_m);
  EXPECT_EQ(one.fine_m, other.fine_m);
  EXPECT_EQ(one.fine_edges_m, other.fine_edges_m);
  EXPECT_EQ(one.level, other.level);
  EXPECT_EQ(one.max_contacts, other.max_contacts);
  for (Eigen::Index i = 0; i < one.object.cloud().points_m.cols(); ++i) {
    ASSERT_TRUE(std::ranges::equal(one.object.beside(i), other.object.beside(i))) << i;
    // Surfaces with blunt edges are others there.
    const Vector3d above_m = one.object.cloud().points_m.col(i) + 1e-4 * Vector3d(0.3, -0.2, 0.9);
    ASSERT_EQ(one.object.distance_from(above_m, i).distance_m, other.object.distance_from(above_m, i).distance_m) << i;
  }
}

// A known model makes a start short, never another: whatever a change is about, each part that it touches is made anew,
// and each that is taken over is what a fresh start makes, to the last bit.
TEST(Model, OfAKnownOneIsTheSame) {
  const std::string few = "object.points=3000";
  const Scene scene = scene_of("mug", {few});
  const Model known = build_model(scene);
  for (const char* change :
       {"contact.friction=0.3", "contact.max_per_finger=9", "fingertips.leaves=160", "fingertips.points=1200",
        "fingertips.reduced_modulus=0.3 MPa", "fingertips.kernel=gaussian", "contact.level=1", "contact.level=auto",
        "object.points=3001"}) {
    SCOPED_TRACE(change);
    const Scene changed = scene_of("mug", {few, change});
    const Model fresh = build_model(changed);
    expect_same_bits(build_model(changed, known), fresh);
    // And from there back.
    expect_same_bits(build_model(scene, fresh), known);
  }
}

// Blunt edges of a mesh are found for deformable fingertips alone, and change its surface: a model without them, and a
// search for a grasp, get the surface as it was made.
TEST(Model, OfAKnownOneForgetsEdges) {
  const std::filesystem::path file = scratch() / "octagon.obj";
  std::ofstream obj(file);
  constexpr int kSides = 8;
  for (int i = 0; i < 2 * kSides; ++i) {
    const double angle = 2.0 * std::numbers::pi * (i / 2) / kSides;
    obj << "v " << 20.0 * std::cos(angle) << ' ' << 20.0 * std::sin(angle) << ' ' << (i % 2 == 0 ? -30 : 30) << '\n';
  }
  const auto corner = [](int side, int end) { return 2 * (side % kSides) + end + 1; };
  for (int i = 0; i < kSides; ++i) {
    obj << "f " << corner(i, 0) << ' ' << corner(i + 1, 0) << ' ' << corner(i + 1, 1) << ' ' << corner(i, 1) << '\n';
  }
  for (int i = 1; i + 1 < kSides; ++i) {
    obj << "f " << corner(0, 0) << ' ' << corner(i + 1, 0) << ' ' << corner(i, 0) << '\n';
    obj << "f " << corner(0, 1) << ' ' << corner(i, 1) << ' ' << corner(i + 1, 1) << '\n';
  }
  obj.close();
  const std::string shape = "object.shape={cloud: {file: " + file.string() + ", unit: mm}}";
  const Scene deformable = scene_of("box_grasp", {shape, "object.points=6000"});
  Scene rigid = deformable;
  rigid.fingertips.reset();
  const Model known = build_model(deformable);
  const auto has_edge = [&](Eigen::Index i) { return !known.object.beside(i).empty(); };
  Eigen::Index edges = 0;
  for (Eigen::Index i = 0; i < known.object.cloud().points_m.cols(); ++i) edges += has_edge(i) ? 1 : 0;
  ASSERT_GT(edges, 100);
  expect_same_bits(build_model(rigid, known), build_model(rigid));
  expect_same_bits(build_model(deformable, known), known);
  expect_same_bits(build_model(deformable, build_model(rigid, known)), known);
}

}  // namespace
}  // namespace thenar::build_model_test
