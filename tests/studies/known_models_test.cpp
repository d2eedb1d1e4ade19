// SPDX-License-Identifier: Apache-2.0
#include "engine/studies/known_models.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "engine/studies/load_model.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

namespace thenar::known_models_test {
namespace {

/// Writes a box of these half sizes [mm] as a mesh.
void write_box(const std::filesystem::path& file, double x, double y, double z) {
  std::ofstream obj(file);
  for (int i = 0; i < 8; ++i) {
    obj << "v " << ((i & 4) != 0 ? x : -x) << ' ' << ((i & 2) != 0 ? y : -y) << ' ' << ((i & 1) != 0 ? z : -z) << '\n';
  }
  obj << "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n";
}

Scene box(const std::vector<std::string>& more = {}) {
  std::vector<std::string> changes{"object.points=2000"};
  changes.insert(changes.end(), more.begin(), more.end());
  return scene_of("box_grasp", changes);
}

void expect_same(const Model& one, const Model& other) {
  EXPECT_EQ(one.object.cloud().points_m, other.object.cloud().points_m);
  EXPECT_EQ(one.object.support_m(), other.object.support_m());
  ASSERT_EQ(one.pulps.size(), other.pulps.size());
  for (std::size_t k = 0; k < one.pulps.size(); ++k) EXPECT_EQ(one.pulps[k].kernel, other.pulps[k].kernel);
  EXPECT_EQ(one.fine_edges_m, other.fine_edges_m);
  EXPECT_EQ(one.max_contacts, other.max_contacts);
}

// Whatever is known, the model is that of the scene alone: to the last bit, part by part in build_model_test.cpp.
TEST(KnownModels, LoadsWhatLoadModelLoads) {
  KnownModels known;
  for (const char* change : {"contact.friction=0.3", "contact.friction=0.5", "fingertips.leaves=160",
                             "contact.level=auto", "object.points=2001", "contact.distance_error=0 um"}) {
    SCOPED_TRACE(change);
    const Scene scene = box({change});
    const auto model = known.load(scene);
    EXPECT_EQ(model->scene.contact.friction, scene.contact.friction);
    expect_same(*model, load_model(scene));
  }
}

// A file that has changed is read again, although its name, and so the scene, is the same.
TEST(KnownModels, ReadsAFileThatHasChanged) {
  const std::filesystem::path file = scratch() / "changing.obj";
  const std::string shape = "object.shape={cloud: {file: " + file.string() + ", unit: mm}}";
  KnownModels known;
  write_box(file, 25.0, 25.0, 25.0);
  const Scene scene = box({shape});
  const auto before = known.load(scene);
  write_box(file, 25.0, 25.0, 30.0);
  const auto after = known.load(scene);
  EXPECT_NEAR(before->object.bounds().sizes().z(), 0.05, 1e-3);
  EXPECT_NEAR(after->object.bounds().sizes().z(), 0.06, 1e-3);
  expect_same(*after, load_model(scene));
}

// What it holds is bounded: of the models that nobody else has, those of the last surfaces live on, one for each.
TEST(KnownModels, HoldsOneForEachOfTheLastSurfaces) {
  KnownModels known;
  std::vector<std::weak_ptr<const Model>> models;
  const auto load = [&](int points, const char* friction) {
    models.push_back(known.load(box({"object.points=" + std::to_string(points), friction})));
  };
  for (int i = 0; i <= static_cast<int>(KnownModels::kMostModels); ++i) load(1000 + i, "contact.friction=0.5");
  EXPECT_TRUE(models.front().expired());
  for (std::size_t i = 1; i < models.size(); ++i) EXPECT_FALSE(models[i].expired()) << i;
  load(1002, "contact.friction=0.6");
  EXPECT_TRUE(models[2].expired()) << "the newer one of this surface took its place";
  EXPECT_FALSE(models.back().expired());
  EXPECT_FALSE(models[1].expired());
}

TEST(KnownModels, ServesSeveralThreads) {
  KnownModels known;
  const auto expected = load_model(box());
  std::vector<std::jthread> all;
  std::vector<std::shared_ptr<const Model>> models(4);
  for (std::size_t i = 0; i < models.size(); ++i) {
    all.emplace_back([&, i] {
      for (int turn = 0; turn < 3; ++turn) models[i] = known.load(box());
    });
  }
  all.clear();
  for (const auto& model : models) expect_same(*model, expected);
}

}  // namespace
}  // namespace thenar::known_models_test
