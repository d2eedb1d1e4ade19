// SPDX-License-Identifier: Apache-2.0
// Meshes as users bring them: in millimetres, far from their frame's origin, without any symmetry. A grasp of each is
// found, and held its object when it was tried.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "engine/models/object_surface.h"
#include "engine/models/scene_grasp.h"
#include "engine/models/surface_model.h"
#include "engine/results/scene_run.h"
#include "engine/scenes/scene_text.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

namespace thenar::found_meshes_test {
namespace {

using Eigen::Vector3d;

/// A frustum over a base of these corners, seen from above against the clock: what 1 in the file measures is the
/// caller's.
std::filesystem::path frustum(const std::vector<Vector3d>& base, double height, double top_scale) {
  const std::filesystem::path file = scratch() / "frustum.off";
  std::ofstream out(file);
  const std::size_t n = base.size();
  out << fmt::format("OFF\n{} {} 0\n", 2 * n, n + 2);
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& p : base) middle += p / static_cast<double>(n);
  for (const Vector3d& p : base) out << fmt::format("{} {} {}\n", p.x(), p.y(), p.z());
  for (const Vector3d& p : base) {
    const Vector3d q = middle + top_scale * (p - middle) + height * Vector3d::UnitZ();
    out << fmt::format("{} {} {}\n", q.x(), q.y(), q.z());
  }
  for (std::size_t i = 0; i < n; ++i) out << fmt::format("4 {} {} {} {}\n", i, (i + 1) % n, n + (i + 1) % n, n + i);
  out << n;
  for (std::size_t i = 0; i < n; ++i) out << ' ' << n + i;
  out << '\n' << n;
  for (std::size_t i = n; i-- > 0;) out << ' ' << i;
  out << '\n';
  return file;
}

/// The corners of a regular base about a place.
std::vector<Vector3d> regular(int corners, double radius, const Vector3d& about) {
  std::vector<Vector3d> base;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / corners;
    base.push_back(about + radius * Vector3d(std::cos(angle), std::sin(angle), 0.0));
  }
  return base;
}

void expect_held(const std::filesystem::path& file, double unit_m, const Vector3d& size_m) {
  Scene scene = scene_of("box_grasp", {"contact.friction=0.6", "control.grasp={friction: 0.42, internal_force: 2 N}"});
  scene.object.shape = CloudShape{file, unit_m};
  scene.object.points = 8000;
  scene.task = {};
  scene.grasp = GraspWish{};
  std::vector<std::string> notes;
  const ImplicitSurface surface = make_object_surface(scene, notes);
  // Samples lie on the faces, half a spacing from their ends or nearer.
  if (!size_m.isZero(0.0)) {
    EXPECT_LT((surface.bounds().sizes() - size_m).cwiseAbs().maxCoeff(), 0.03 * size_m.maxCoeff());
  }
  scene.object.centre_of_mass_m = enclosed_centroid_m(surface.cloud());
  const FinderReport report = find_tried_grasps(scene, surface);
  ASSERT_FALSE(report.grasps.empty()) << in_words(report.refusal.value_or(Refusal{}));
  // Trials were by coarser steps, without the scene's task.
  take_grasp(report.grasps.front(), scene);
  scene.duration_s = 0.5;
  const Model model = surface_model(scene, surface);
  State state(model);
  const Verdict verdict = run_scene(model, state).verdict;
  EXPECT_EQ(verdict.outcome, Outcome::kHeld) << in_words(verdict);
}

TEST(FoundMeshes, InMillimetres) {
  expect_held(frustum(regular(24, 18.0, Vector3d::Zero()), 60.0, 1.0), 1e-3, {0.036, 0.036, 0.06});
}

TEST(FoundMeshes, FarFromTheirOrigin) {
  expect_held(frustum(regular(4, 0.03, {0.12, -0.16, 0.1}), 0.05, 1.0), 1.0, {0.06, 0.06, 0.05});
}

TEST(FoundMeshes, WithoutSymmetry) {
  const std::vector<Vector3d> base{
      {0.0, 0.0, 0.0}, {0.041, -0.006, 0.0}, {0.052, 0.021, 0.0}, {0.026, 0.044, 0.0}, {-0.007, 0.023, 0.0}};
  expect_held(frustum(base, 0.045, 0.93), 1.0, {0.059, 0.05, 0.045});
}

TEST(FoundMeshes, TheBunny) {
  const std::filesystem::path scan = config_file("bunny").parent_path() / "../out/scan/bunny.off";
  if (!std::filesystem::exists(scan)) GTEST_SKIP() << "no bunny: install Debian's libcgal-demo, and build again";
  expect_held(scan, 0.08, Vector3d::Zero());
}

}  // namespace
}  // namespace thenar::found_meshes_test
