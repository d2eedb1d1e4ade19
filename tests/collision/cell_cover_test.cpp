// SPDX-License-Identifier: Apache-2.0
// What part of a cell a solid reaches into, and how deep, is what a fine grid of lines says, and changes smoothly.

#include "collision/cell_cover.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace thenar::cell_cover_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kArea_m2 = 2e-6;

/// A plane with this outward normal, of which the third component is along N, and this height of the middle over it.
CellFace face(const Vector3d& n, double height_m) {
  const Vector3d unit = n.normalized();
  return {.slope = unit.head<2>(), .facing = -unit.z(), .height_m = height_m};
}

/// How deep the solid is at a place, by the line along -N there: negative where it is met further out, -infinity if it
/// is not met at all.
double depth_on_line_m(const std::vector<CellFace>& faces, const Vector2d& y) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double in_m = kInfinity, out_m = -kInfinity;
  for (const CellFace& f : faces) {
    const double height_m = f.height_m + f.slope.dot(y);
    if (std::abs(f.facing) < 1e-12) {
      if (height_m > 0.0) return -kInfinity;
    } else if (f.facing > 0.0) {
      in_m = std::min(in_m, -height_m / f.facing);
    } else {
      out_m = std::max(out_m, -height_m / f.facing);
    }
  }
  return out_m <= in_m ? in_m : -kInfinity;
}

/// By many lines, all around alike.
struct ByLines {
  double share = 0.0, depth_m = 0.0;
};
ByLines by_lines(const std::vector<CellFace>& faces) {
  constexpr int kLines = 200000;
  const double radius_m = std::sqrt(kArea_m2 / std::numbers::pi);
  double count = 0.0, first = 0.0, second = 0.0, third = 0.0;
  for (int k = 0; k < kLines; ++k) {
    const double r = radius_m * std::sqrt((k + 0.5) / kLines), angle = std::numbers::pi * (3.0 - std::sqrt(5.0)) * k;
    const double d = depth_on_line_m(faces, r * Vector2d(std::cos(angle), std::sin(angle)));
    if (!(d > 0.0)) continue;
    count += 1.0, first += d, second += d * d, third += d * d * d;
  }
  if (count == 0.0) return {};
  return {count / kLines, 0.5 * (second / first + third / second)};
}

TEST(CellCover, OfOneFaceIsItsDepth) {
  CellWork work;
  const CellCover cover = cell_cover(std::vector{face({0.2, 0.1, -1.0}, -3e-4)}, kArea_m2, work);
  EXPECT_EQ(cover.own, 1.0);
  EXPECT_EQ(cover.share, 1.0);
  EXPECT_NEAR(cover.depth_m, 3e-4 * Vector3d(0.2, 0.1, -1.0).norm(), 1e-15);
}

TEST(CellCover, OfAHalfIsAHalf) {
  CellWork work;
  const std::vector<CellFace> faces = {face({0.0, 0.0, -1.0}, -1e-3), face({1.0, 0.0, 0.0}, 0.0)};
  const CellCover cover = cell_cover(faces, kArea_m2, work);
  EXPECT_EQ(cover.own, 0.0);
  EXPECT_NEAR(cover.share, 0.5, 1e-12);
  EXPECT_NEAR(cover.depth_m, 1e-3, 1e-12);
  EXPECT_LT(cover.middle_m.x(), 0.0);
}

// From two radii of the cell to one the depth goes from the face's at the middle to what lines say, and not beyond.
TEST(CellCover, GoesOverFromTheFaceToThePart) {
  CellWork work;
  const double radius_m = std::sqrt(kArea_m2 / std::numbers::pi);
  std::vector<CellFace> faces = {face({0.3, 0.0, -1.0}, -1e-4), face({1.0, 0.0, 0.0}, 0.0)};
  const double own_m = 1e-4 / faces[0].facing;
  double last = 1.0;
  for (double off = 2.01; off > 0.0; off -= 0.05) {
    faces[1].height_m = -off * radius_m;
    const CellCover cover = cell_cover(faces, kArea_m2, work);
    const ByLines lines = by_lines(faces);
    EXPECT_LE(cover.own, last);
    EXPECT_NEAR(cover.own, off > 2.0 ? 1.0 : off < 1.0 ? 0.0 : cover.own, 1e-3) << off;
    EXPECT_NEAR(cover.depth_m, cover.own * own_m + (1.0 - cover.own) * lines.depth_m, 0.02 * own_m) << off;
    EXPECT_NEAR(cover.share, cover.own + (1.0 - cover.own) * lines.share, 0.012) << off;
    last = cover.own;
  }
  EXPECT_EQ(last, 0.0);
}

TEST(CellCover, IsWhatLinesSay) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  CellWork work;
  int seen = 0;
  for (int k = 0; k < 200; ++k) {
    std::vector<CellFace> faces;
    // A face, and one, two or three others, of which some are along N or look away.
    faces.push_back(face({0.4 * any(random), 0.4 * any(random), -1.0}, -1e-3 * (0.6 + 0.5 * any(random))));
    for (int other = 0; other < 1 + k % 3; ++other) {
      faces.push_back(face({any(random), any(random), k % 5 == 0 ? 0.0 : 0.9 * any(random)}, 4e-4 * any(random)));
    }
    const CellCover cover = cell_cover(faces, kArea_m2, work);
    if (cover.own > 0.0) continue;
    ++seen;
    SCOPED_TRACE(k);
    const ByLines lines = by_lines(faces);
    // A polygon of 16 corners stands for the disc.
    EXPECT_NEAR(cover.share, lines.share, 0.012);
    if (lines.share > 0.02) {
      EXPECT_NEAR(cover.depth_m, lines.depth_m, 0.02 * lines.depth_m + 2e-6);
    }
  }
  EXPECT_GT(seen, 60);
}

/// A half space under a cone of tan 1 holds (2 / 3 pi) E* d^3 [Sneddon 1965]. A disc of the cone's section, radius d,
/// with the depth d_eq holds 0.710 E* d d_eq^2: k of its area is 3.921 / (pi E* sqrt(A)), so that d_eq is 0.547 d.
TEST(CellCover, HasTheDepthThatHoldsTheEnergyOfACone) {
  constexpr int kSides = 64;
  CellWork work;
  const double d_m = 2e-4;
  std::vector<CellFace> faces;
  for (int k = 0; k < kSides; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / kSides;
    const Vector3d n(std::cos(angle), std::sin(angle), -1.0);  // tan = 1
    faces.push_back(face(n, -d_m / std::numbers::sqrt2));
  }
  const CellCover cover = cell_cover(faces, kArea_m2, work);
  EXPECT_EQ(cover.own, 0.0);
  EXPECT_NEAR(cover.share, std::numbers::pi * d_m * d_m / kArea_m2, 0.01 * cover.share);
  EXPECT_NEAR(cover.depth_m, 0.547 * d_m, 0.01 * d_m);
}

TEST(CellCover, ChangesSmoothlyAsFacesGoBy) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  CellWork work;
  for (int way = 0; way < 100; ++way) {
    std::vector<CellFace> faces = {face({0.3 * any(random), 0.3 * any(random), -1.0}, -1e-3),
                                   face({std::copysign(0.5, any(random)), any(random), 0.5 * any(random)}, 0.0)};
    SCOPED_TRACE(way);
    CellCover before;
    constexpr double kStep_m = 1e-6;
    for (int k = -3000; k <= 3000; ++k) {
      faces[1].height_m = k * kStep_m;
      const CellCover cover = cell_cover(faces, kArea_m2, work);
      if (k > -3000) {
        // A cell is 1.6 mm wide, and slopes are above a quarter: its share changes by 1 in 0.4 mm or more. Depths are
        // 1 mm.
        ASSERT_LT(std::abs(cover.share - before.share), 4e-3) << k;
        ASSERT_LT(std::abs(cover.share * std::max(0.0, cover.depth_m) - before.share * std::max(0.0, before.depth_m)),
                  8e-6)
            << k;
      }
      before = cover;
    }
  }
}

}  // namespace
}  // namespace thenar::cell_cover_test
