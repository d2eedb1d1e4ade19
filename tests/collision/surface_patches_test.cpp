// SPDX-License-Identifier: Apache-2.0
#include "collision/surface_patches.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "collision/implicit_surface.h"
#include "collision/shapes.h"
#include "tests/collision/distance_errors.h"

// What patches answer is what the surface itself would, within the error that was allowed: the largest over many
// points, not the mean.

namespace thenar::surface_patches_test {
namespace {

using namespace distance_errors;

constexpr double kDepth_m = 4.3e-3;  // a fingertip's trust and the band, as a scene has it
constexpr int kPoints = 100'000;

struct Solid {
  std::string name;
  PointCloud cloud;
};

PointCloud rough(PointCloud cloud, double noise_m) {
  Random random(5);
  for (Index i = 0; i < cloud.points_m.cols(); ++i) {
    cloud.points_m.col(i) += noise_m * random.gaussian();
    cloud.normals.col(i) = (cloud.normals.col(i) + 0.05 * random.gaussian()).normalized();
  }
  return cloud;
}

/// Flat with edges and corners, thinner than a support, curved, with a thin wall and a handle, and scanned.
const std::vector<Solid>& solids() {
  static const Mug kMug{40e-3, 90e-3, 4e-3, MugHandle{22e-3, 10e-3}};
  static const std::vector<Solid> kSolids{
      {"box of 50 mm", sample_box({50e-3, 50e-3, 50e-3}, 36000)},
      {"plate of 0.5 mm", sample_box({40e-3, 0.5e-3, 40e-3}, 36000)},
      {"ellipsoid", sample_ellipsoid({20e-3, 25e-3, 35e-3}, 20000)},
      {"capsule as thin as a support", sample_cylinder(2e-3, 40e-3, 3000)},
      {"mug", sample_mug(kMug, 36000)},
      {"rough ellipsoid", rough(sample_ellipsoid({20e-3, 25e-3, 35e-3}, 20000), 20e-6)},
  };
  return kSolids;
}

/// Somewhere in the band of a surface: 4 mm deep to 0.5 mm off a sample, and aside by up to half a support.
Vector3d in_band(const ImplicitSurface& surface, Random& random) {
  const auto samples = static_cast<double>(surface.cloud().points_m.cols());
  const auto i = static_cast<Index>(random.between(0.0, samples));
  return surface.cloud().points_m.col(i) + random.between(-4e-3, 0.5e-3) * surface.cloud().normals.col(i) +
         random.in_cube(0.5 * surface.support_m());
}

TEST(SurfacePatches, AreWithinTheErrorEverywhere) {
  for (const Solid& solid : solids()) {
    const ImplicitSurface exact(solid.cloud);
    for (const double error_m : {0.1e-6, 1e-6, 10e-6}) {
      SCOPED_TRACE(testing::Message() << solid.name << ", " << 1e6 * error_m << " um");
      ImplicitSurface surface = exact;
      surface.allow_error(error_m, kDepth_m);
      Random random(11);
      double largest_m = 0.0;
      int wrong = 0, undefined = 0, turned = 0;
      for (int k = 0; k < kPoints; ++k) {
        const Vector3d x_m = in_band(surface, random);
        const Index sample = exact.nearest(x_m, 8e-3).sample;
        if (sample < 0) {
          ++undefined;
          continue;
        }
        const SurfaceDistance d = surface.distance_from(x_m, sample), e = exact.distance_from(x_m, sample);
        largest_m = std::max(largest_m, std::abs(d.distance_m - e.distance_m));
        turned += (d.normal - e.normal).norm() > 0.01;
        wrong += d.distance_m * e.distance_m < 0.0 && std::abs(e.distance_m) > error_m;
        ASSERT_NEAR(d.normal.norm(), 1.0, 1e-6);
      }
      EXPECT_EQ(undefined, 0);
      EXPECT_EQ(wrong, 0);
      EXPECT_LE(largest_m, error_m);
      // Normals are those of the surface, but where two faces are as near.
      EXPECT_LE(turned, kPoints / 500);
    }
  }
}

// An error of 0 leaves the surface itself, to the last bit; so does a surface that no error was named for.
TEST(SurfacePatches, WithoutAnErrorThereAreNone) {
  const ImplicitSurface exact(solids()[2].cloud);
  ImplicitSurface surface = exact;
  surface.allow_error(1e-6, kDepth_m);
  surface.allow_error(0.0, kDepth_m);
  Random random(3);
  for (int k = 0; k < 1000; ++k) {
    const Vector3d x_m = in_band(surface, random);
    const auto d = surface.distance(x_m, 8e-3), e = exact.distance(x_m, 8e-3);
    ASSERT_TRUE(d && e);
    EXPECT_EQ(d->distance_m, e->distance_m);
    EXPECT_EQ(d->normal, e->normal);
  }
}

// They are worth their memory only where they answer: nearly everywhere on smooth faces, at a micrometre.
TEST(SurfacePatches, AnswerNearlyEverywhereOnSmoothFaces) {
  for (const int k : {0, 2}) {
    SCOPED_TRACE(solids()[k].name);
    ImplicitSurface surface(solids()[k].cloud);
    surface.allow_error(1e-6, kDepth_m);
    Random random(7);
    int known = 0;
    for (int i = 0; i < 10'000; ++i) {
      const auto sample = static_cast<Index>(random.between(0.0, static_cast<double>(surface.cloud().points_m.cols())));
      const Vector3d x_m = surface.cloud().points_m.col(sample) + 1e-3 * surface.cloud().normals.col(sample);
      known += surface.estimate(x_m, sample).firm_m > 0.0;
    }
    EXPECT_GE(known, k == 0 ? 9000 : 9900);  // a box has edges
  }
}

}  // namespace
}  // namespace thenar::surface_patches_test
