// SPDX-License-Identifier: Apache-2.0
#include "collision/cloud_repair.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "collision/cloud_holes.h"
#include "collision/implicit_surface.h"
#include "collision/normal_estimation.h"
#include "collision/shapes.h"
#include "tests/collision/distance_errors.h"

// T8..T11 are of the cases of implicit_surface_test.cpp: how exact distances are on repaired clouds.

namespace thenar::cloud_repair_test {
namespace {

using namespace distance_errors;

using Eigen::Matrix3Xd;

/// A square bar 20 mm wide and 40 mm long with open ends, samples 0.83 mm apart; its edges are chamfers of width w.
PointCloud chamfered_bar(double width_m) {
  const double spacing_m = 0.83 * kMm, side_m = 20 * kMm - std::numbers::sqrt2 * width_m;
  const double period_m = side_m + width_m;
  const auto around = static_cast<Index>(4.0 * period_m / spacing_m), along = static_cast<Index>(40 * kMm / spacing_m);
  PointCloud bar{Matrix3Xd(3, around * along), Matrix3Xd(3, around * along)};
  for (Index i = 0; i < bar.points_m.cols(); ++i) {
    // Every ring starts elsewhere, so that chamfers narrower than a spacing have samples now and then.
    const double way_m = std::fmod((static_cast<double>(i % around) + 0.618 * static_cast<double>(i / around)) *
                                       (4.0 * period_m / static_cast<double>(around)),
                                   4.0 * period_m);
    const double quarter = std::floor(way_m / period_m), at_m = way_m - quarter * period_m;
    const bool on_side = at_m < side_m;
    const double z_m = (static_cast<double>(i / around) / static_cast<double>(along) - 0.5) * 40 * kMm;
    const double slant_m = (at_m - side_m) / std::numbers::sqrt2;
    const Vector3d p_m = on_side ? Vector3d(at_m - 0.5 * side_m, -10 * kMm, z_m)
                                 : Vector3d(0.5 * side_m + slant_m, -10 * kMm + slant_m, z_m);
    const Vector3d n = on_side ? Vector3d(0, -1, 0) : Vector3d(std::numbers::sqrt2 / 2, -std::numbers::sqrt2 / 2, 0);
    const Eigen::Matrix3d R = Eigen::AngleAxisd(0.5 * std::numbers::pi * quarter, Vector3d::UnitZ()).toRotationMatrix();
    bar.points_m.col(i) = R * p_m;
    bar.normals.col(i) = R * n;
  }
  return bar;
}

TEST(CloudRepair, LeavesCleanCloudsAsTheyAre) {
  PointCloud room = sample_box({10 * kMm, 10 * kMm, 10 * kMm}, 6000);
  room.normals *= -1.0;
  std::vector<std::pair<std::string, PointCloud>> clouds = {
      {"room", room},
      {"box", sample_box({50 * kMm, 50 * kMm, 50 * kMm}, 8000)},
      {"small box", sample_box({5 * kMm, 8 * kMm, 10 * kMm}, 1000)},
      {"sphere", sample_sphere(8 * kMm, 2400)},
      {"coarse sphere", sample_sphere(8 * kMm, 150)}};
  for (const double thickness_mm : {2.0, 1.0, 0.5, 0.25}) {
    clouds.emplace_back("plate " + std::to_string(thickness_mm),
                        sample_box({30 * kMm, thickness_mm * kMm, 50 * kMm}, 6000));
  }
  for (const double width_mm : {0.1, 0.3, 0.5, 0.7, 1.0, 2.0}) {
    clouds.emplace_back("chamfer " + std::to_string(width_mm), chamfered_bar(width_mm * kMm));
  }
  for (const auto& [name, clean] : clouds) {
    SCOPED_TRACE(name);
    PointCloud cloud = clean;
    const CloudRepair report = repair(cloud, covering_support_m(cloud));
    EXPECT_EQ(report.turned + report.removed + report.outliers, 0);
    EXPECT_FALSE(report.smoothed_normals || report.smoothed_points);
    // To the last bit, and in order.
    ASSERT_EQ(cloud.points_m.cols(), clean.points_m.cols());
    EXPECT_EQ(cloud.points_m, clean.points_m);
    EXPECT_EQ(cloud.normals, clean.normals);
  }
}

TEST(CloudRepair, RemovesWhatStandsOffAndNothingElse) {
  const PointCloud clean = sample_box({50 * kMm, 50 * kMm, 50 * kMm}, 20000);
  const double h_m = covering_support_m(clean);
  for (unsigned seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 bits(seed);
    PointCloud cloud = clean;
    Index moved = 0;
    for (Index i = 0; i < cloud.points_m.cols(); ++i) {
      if (bits() % 50 != 0) continue;
      // Half a support out or in, along the normal: clear of the slab of 0.1 h.
      cloud.points_m.col(i) += (bits() % 2 == 0 ? 0.5 : -0.5) * h_m * cloud.normals.col(i);
      ++moved;
    }
    const CloudRepair report = repair(cloud, h_m);
    EXPECT_EQ(report.outliers, moved);
    EXPECT_EQ(report.turned + report.removed, 0);
    EXPECT_EQ(cloud.points_m.cols(), clean.points_m.cols() - moved);
    // What is left lies on the faces.
    EXPECT_LT((cloud.points_m.cwiseAbs().colwise().maxCoeff().array() - 25 * kMm).abs().maxCoeff(), 1e-12);
  }
}

// 400 outliers all over the box and up to 5 mm around it: alone, in pairs that agree by chance, or near the faces.
// Their normals are random, or estimated with those of the surface, when neighbours agree.
TEST(CloudRepair, RemovesWhatStandsApartFromTheSurface) {
  constexpr Index kOutliers = 400;
  const PointCloud clean = sample_box({50 * kMm, 50 * kMm, 50 * kMm}, 24000);
  const Index count = clean.points_m.cols();
  for (unsigned seed = 1; seed <= 3; ++seed) {
    for (const bool estimated : {false, true}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << (estimated ? ", estimated normals" : ""));
      std::mt19937 bits(seed);
      std::uniform_real_distribution<double> at_m(-30 * kMm, 30 * kMm), direction(-1.0, 1.0);
      PointCloud cloud{Matrix3Xd(3, count + kOutliers), Matrix3Xd(3, count + kOutliers)};
      cloud.points_m.leftCols(count) = clean.points_m;
      cloud.normals.leftCols(count) = clean.normals;
      for (Index i = count; i < count + kOutliers; ++i) {
        for (double& x_m : cloud.points_m.col(i)) x_m = at_m(bits);
        for (double& x : cloud.normals.col(i)) x = direction(bits);
        cloud.normals.col(i).normalize();
      }
      if (estimated) estimate_normals(cloud);
      const double h_m = covering_support_m(cloud);
      const CloudRepair report = repair(cloud, h_m);

      Index left = 0, far = 0;
      for (const auto p_m : cloud.points_m.colwise()) {
        const double inside_m = 25 * kMm - p_m.cwiseAbs().maxCoeff();
        const double outside_m = (p_m.cwiseAbs().array() - 25 * kMm).cwiseMax(0.0).matrix().norm();
        const double off_m = std::max(inside_m, outside_m);
        left += off_m > 0.1 * h_m ? 1 : 0;
        far += off_m > h_m ? 1 : 0;
      }
      // What lies within the support of a face may pass for a rib of it, or for a sample of an edge.
      EXPECT_LE(left, kOutliers / 20);
      EXPECT_LE(far, 2);
      // Nothing of the surface went with them.
      EXPECT_GE(cloud.points_m.cols() - left, count);
      EXPECT_GE(report.outliers + report.removed, kOutliers * 9 / 10);
      EXPECT_TRUE(find_holes(cloud, h_m, 10.0 * h_m).empty());
    }
  }
}

TEST(CloudRepair, RemovesSamplesWithNormalsAcrossTheirFace) {
  PointCloud cloud = sample_sphere(20 * kMm, 8000);
  std::mt19937 bits(5);
  Index wrong = 0;
  for (Index i = 0; i < cloud.normals.cols(); ++i) {
    if (bits() % 100 != 0) continue;
    cloud.normals.col(i) = cloud.normals.col(i).unitOrthogonal();
    ++wrong;
  }
  const CloudRepair report = repair(cloud, covering_support_m(cloud));
  // They lie on the surface, and yet belong to no face. A few have a twin of the same mistake next to them.
  const double removed = static_cast<double>(report.removed + report.outliers), all = static_cast<double>(wrong);
  EXPECT_GE(removed, 0.9 * all);
  EXPECT_LE(removed, all);
  const Eigen::ArrayXd outward = (cloud.normals.array() * cloud.points_m.array()).colwise().sum();
  EXPECT_EQ((outward < 0.9 * 20 * kMm).count(), wrong - report.removed - report.outliers);
}

TEST(CloudRepair, SmoothingKeepsASpheresRadius) {
  // Means of points on a sphere lie inside it, by 0.3 mm here; heights over arcs do not know of its curvature.
  PointCloud cloud = sample_sphere(8 * kMm, 1900);
  std::mt19937 bits(6);
  std::normal_distribution<double> noise_m(0.0, 0.1 * kMm);
  for (auto p_m : cloud.points_m.colwise()) p_m += noise_m(bits) * p_m.normalized();
  ASSERT_TRUE(repair(cloud, 1.43 * kMm).smoothed_points);
  const Eigen::VectorXd radii_m = cloud.points_m.colwise().norm();
  // Its mean: 0.1 mm / sqrt(1900) = 0.002 mm. The scatter: some ten samples under each weight, so a third of the noise.
  EXPECT_NEAR(radii_m.mean(), 8 * kMm, 0.01 * kMm);
  EXPECT_LT(std::sqrt((radii_m.array() - radii_m.mean()).square().mean()), 0.05 * kMm);
}

TEST(CloudRepair, SupportKnowsTheTwoSidesOfAPlate) {
  // 5150 samples on 2560 mm2: 0.70 mm apart on each side, which 0.5 mm through the plate does not shorten.
  const PointCloud plate = sample_box({25 * kMm, 0.5 * kMm, 49 * kMm}, 5150);
  EXPECT_NEAR(covering_support_m(plate), 2.2 * 0.70 * kMm, 0.1 * 2.2 * 0.70 * kMm);
  // An even cloud's is that of its middle sample, to the last bit.
  const PointCloud box = sample_box({50 * kMm, 50 * kMm, 50 * kMm}, 5000);
  EXPECT_EQ(covering_support_m(box), 2.2 * sample_spacing_m(box));
}

TEST(CloudRepair, SurvivesDegenerateClouds) {
  std::mt19937 bits(7);
  const auto random = [&] { return static_cast<double>(bits()) / 0x1p32 - 0.5; };
  for (const Index count : {1, 2, 3, 10, 300}) {
    PointCloud cloud{Matrix3Xd(3, count), Matrix3Xd(3, count)};
    for (Index i = 0; i < count; ++i) {
      cloud.points_m.col(i) = 3 * kMm * Vector3d(random(), random(), random());
      cloud.normals.col(i) = Vector3d(random(), random(), random()).normalized();
    }
    repair(cloud, 1 * kMm);
    EXPECT_LE(cloud.points_m.cols(), count);
    EXPECT_EQ(cloud.points_m.cols(), cloud.normals.cols());
    EXPECT_TRUE(cloud.points_m.allFinite() && cloud.normals.allFinite());
  }
}

TEST(ImplicitSurface, T8NoiseIsAveraged) {
  for (const double sd_mm : {0.05, 0.1, 0.2, 0.4}) {
    SCOPED_TRACE(sd_mm);
    Random random(8);
    PointCloud noisy = box_cloud();
    for (Index i = 0; i < noisy.points_m.cols(); ++i) noisy.points_m.col(i) += sd_mm * kMm * random.gaussian();
    const CloudRepair repaired = repair(noisy, 1.83 * kMm);
    EXPECT_TRUE(repaired.smoothed_points);
    EXPECT_NEAR(repaired.position_noise_m, sd_mm * kMm, 0.15 * sd_mm * kMm);
    const Errors errors = measure(ImplicitSurface(noisy, 1.83 * kMm), over_face(0.3));
    EXPECT_EQ(errors.undefined, 0);
    EXPECT_LE(errors.mean_mm, 0.4 * sd_mm);
  }
}

TEST(ImplicitSurface, T9OutliersDoNotMoveTheSurface) {
  for (const double share : {0.001, 0.01, 0.05}) {
    SCOPED_TRACE(share);
    Random random(9);
    PointCloud cloud = box_cloud();
    for (Index i = 0; i < cloud.points_m.cols(); ++i) {
      if (random.between(0.0, 1.0) < share) cloud.points_m.col(i) += 2.0 * kMm * random.gaussian();
    }
    repair(cloud, 1.83 * kMm);
    const ImplicitSurface surface(cloud, 1.83 * kMm);
    const Errors errors = measure(surface, over_face(0.3));
    EXPECT_EQ(errors.undefined, 0);
    EXPECT_LT(errors.max_mm, 0.1);
    const Errors at_edge = measure(surface, around_edge(0.8));
    // Beside an edge an outlier of one face may pass for a sample of the other, one in a thousand.
    EXPECT_LE(at_edge.wrong_sign, kQueries / 1000);
    EXPECT_LT(at_edge.mean_mm, 0.05);  // as T4
  }
}

TEST(ImplicitSurface, T11NoisyNormalsAreAveragedOverTheirFace) {
  struct Case {
    double noise_deg, mean_mm;
  };
  for (const auto& [noise_deg, mean_mm] : {Case{5, 0.001}, Case{15, 0.005}, Case{30, 0.014}}) {
    SCOPED_TRACE(noise_deg);
    Random random(11);
    PointCloud cloud = box_cloud();
    const double sd = std::tan(noise_deg * std::numbers::pi / 180.0) / std::numbers::sqrt2;
    for (Index i = 0; i < cloud.normals.cols(); ++i) {
      cloud.normals.col(i) = (cloud.normals.col(i) + sd * random.gaussian()).normalized();
    }
    EXPECT_TRUE(repair(cloud, 1.83 * kMm).smoothed_normals);
    const ImplicitSurface surface(cloud, 1.83 * kMm);
    const Errors errors = measure(surface, over_face(0.3));
    EXPECT_EQ(errors.undefined, 0);
    EXPECT_LT(errors.mean_mm, mean_mm);
    // Edges stay sharp, up to where normals point to the other face as often as to their own.
    if (noise_deg < 20) {
      EXPECT_LT(measure(surface, around_edge(0.8)).mean_mm, 0.05);  // as T4
    }
  }
}

TEST(ImplicitSurface, T10FlippedNormalsDoNotFlipTheSign) {
  for (const double flipped : {0.01, 0.05}) {
    SCOPED_TRACE(flipped);
    Random random(10);
    PointCloud cloud = box_cloud();
    for (Index i = 0; i < cloud.normals.cols(); ++i) {
      if (random.between(0.0, 1.0) < flipped) cloud.normals.col(i) *= -1.0;
    }
    repair(cloud, 1.83 * kMm);
    const ImplicitSurface surface(cloud, 1.83 * kMm);
    const std::vector<Query> queries = {over_face(0.3), over_face(-0.3), over_face(-1.0), around_edge(0.8),
                                        around_corner(0.8)};
    for (std::size_t i = 0; i < queries.size(); ++i) {
      SCOPED_TRACE(testing::Message() << "queries " << i);
      const Errors errors = measure(surface, queries[i]);
      EXPECT_EQ(errors.undefined, 0);
      EXPECT_EQ(errors.wrong_sign, 0);
      EXPECT_LT(errors.mean_mm, 0.2);  // as T5, the least exact of them
    }
  }
}

// Whoever loads a cloud can see how far to trust it: a clean one has no doubtful normals, one with some flipped has
// those.
TEST(ImplicitSurface, T10CountsDoubtfulNormals) {
  for (const double flipped : {0.0, 0.05, 0.2, 0.4}) {
    SCOPED_TRACE(flipped);
    Random random(12);
    PointCloud cloud = box_cloud();
    for (Index i = 0; i < cloud.normals.cols(); ++i) {
      if (random.between(0.0, 1.0) < flipped) cloud.normals.col(i) *= -1.0;
    }
    const double share = repair(cloud, 1.83 * kMm).doubtful_share;
    if (flipped == 0.0) {
      EXPECT_EQ(share, 0.0);
    } else {
      // At least those flipped, but for chance (36 000 samples: 0.3 %); with many, good ones lose votes too.
      EXPECT_GT(share, flipped - 0.01);
    }
  }
}

TEST(ImplicitSurface, SingleBadNormalsAreNoFaces) {
  Random random(11);
  PointCloud cloud = box_cloud();
  for (Index i = 0; i < cloud.normals.cols(); ++i) {
    if (random.between(0.0, 1.0) < 0.01) cloud.normals.col(i) = random.direction();
  }
  repair(cloud, 1.83 * kMm);
  const ImplicitSurface surface(cloud, 1.83 * kMm);
  for (const double gap_mm : {0.3, -0.3, -1.0}) {
    SCOPED_TRACE(gap_mm);
    const Errors errors = measure(surface, over_face(gap_mm));
    EXPECT_EQ(errors.undefined, 0);
    // One bad sample in fifteen turns the plane where it is within 60 degrees: some hundredths of the height's lever.
    EXPECT_LT(errors.mean_mm, 0.002);
  }
}

TEST(ImplicitSurface, SamplesWithADividedVoteAreIgnored) {
  // With three normals in ten flipped, votes are divided here and there; what is left still makes a surface.
  Random random(12);
  PointCloud cloud = box_cloud();
  for (Index i = 0; i < cloud.normals.cols(); ++i) {
    if (random.between(0.0, 1.0) < 0.3) cloud.normals.col(i) *= -1.0;
  }
  EXPECT_GT(repair(cloud, 1.83 * kMm).removed, 0);
  EXPECT_EQ(measure(ImplicitSurface(cloud, 1.83 * kMm), over_face(0.3)).undefined, 0);
}

TEST(ImplicitSurface, CancellingNormalsAreNoSurface) {
  // Two sheets in one place that face opposite ways have no outside: every vote is divided.
  const PointCloud face = subset(box_cloud(), [](Index i) { return box_cloud().normals(1, i) > 0.5; });
  const Index n = face.points_m.cols();
  PointCloud sheets{Matrix3Xd(3, 2 * n), Matrix3Xd(3, 2 * n)};
  sheets.points_m << face.points_m, face.points_m;
  sheets.normals << face.normals, -face.normals;
  EXPECT_EQ(repair(sheets, 1.83 * kMm).doubtful_share, 1.0);
  EXPECT_EQ(sheets.points_m.cols(), 0);
}

}  // namespace
}  // namespace thenar::cloud_repair_test
