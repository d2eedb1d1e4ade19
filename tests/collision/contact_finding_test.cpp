// SPDX-License-Identifier: Apache-2.0
#include "collision/contact_finding.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <tuple>
#include <vector>

#include "collision/point_tree.h"
#include "collision/shapes.h"
#include "tests/support/allocation_counter.h"

namespace thenar::contact_finding_test {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kFingerRadius_m = 8e-3;
const Vector3d kFingerCentre_m(5e-3, 20e-3, -30e-3);  // in the finger's frame: its pose has a lever arm

PointCloud finger_cloud() {
  PointCloud cloud = sample_sphere(kFingerRadius_m, 2400);
  cloud.points_m.colwise() += kFingerCentre_m;
  return cloud;
}

/// A point of each of a tree's leaves.
Eigen::Matrix3Xd control_points(const PointCloud& cloud, Index leaves) {
  const std::vector<Index> order = order_by_leaves(cloud.points_m, leaves);
  std::vector<Index> chosen;
  for (const TreeNode& leaf : tree_nodes(cloud.points_m.cols(), leaves, 1)) {
    chosen.push_back(order[(leaf.begin + leaf.end) / 2]);
  }
  return cloud.points_m(Eigen::all, chosen);
}

/// The pose that turns the finger by R and puts its centre at p.
Isometry3d pose_of(const Eigen::AngleAxisd& R_SB, const Vector3d& p_SC) {
  Isometry3d X_SB = Isometry3d::Identity();
  X_SB.linear() = R_SB.toRotationMatrix();
  X_SB.translation() = p_SC - X_SB.linear() * kFingerCentre_m;
  return X_SB;
}

/// A finger, and an object whose samples are as dense as the reference scene's.
struct Scene {
  PointCloud finger = finger_cloud();
  Eigen::Matrix3Xd controls_m = control_points(finger, 320);
  Vector3d size_m{20e-3, 20e-3, 30e-3};
  ImplicitSurface box{sample_box(size_m, 7600)};
};

const Scene& scene() {
  static const Scene kScene;
  return kScene;
}

double box_distance_m(const Vector3d& p_m, const Vector3d& size_m) {
  const Vector3d beyond = p_m.cwiseAbs() - 0.5 * size_m;
  return beyond.cwiseMax(0.0).norm() + std::min(beyond.maxCoeff(), 0.0);
}

/// The definition: every control point asked, no tree.
std::vector<ContactCandidate> brute_force(const Eigen::Matrix3Xd& controls_m, const Isometry3d& X_SB,
                                          const ImplicitSurface& surface, const ContactFindingSettings& settings) {
  std::vector<ContactCandidate> found;
  for (Index i = 0; i < controls_m.cols(); ++i) {
    const Vector3d p_S = X_SB * controls_m.col(i);
    if (surface.bounds().exteriorDistance(p_S) >= settings.band_m) continue;
    const std::optional<SurfaceDistance> to = surface.distance(p_S, settings.reach_m);
    if (to && to->distance_m < settings.band_m) found.push_back({i, to->distance_m, to->point_m, to->normal});
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.gap_m < b.gap_m; });
  found.erase(found.begin() + std::min<Index>(static_cast<Index>(found.size()), settings.max_contacts), found.end());
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.control_point < b.control_point; });
  return found;
}

class Random {
 public:
  explicit Random(unsigned seed) : bits_(seed) {}
  double between(double low, double high) { return low + (high - low) * static_cast<double>(bits_()) / 0x1p32; }
  Vector3d direction() {
    for (;;) {
      const Vector3d v(between(-1, 1), between(-1, 1), between(-1, 1));
      if (v.norm() < 1.0 && v.norm() > 0.1) return v.normalized();
    }
  }
  Eigen::AngleAxisd rotation() {
    const double angle = between(0.0, std::numbers::pi);
    return {angle, direction()};
  }
  /// The finger's centre anywhere around the box, from 3 mm deep to 1 mm clear of it.
  Isometry3d pose(const Vector3d& size_m) {
    const Vector3d d = direction();
    const Vector3d on_box = d * (0.5 * size_m.array() / d.array().abs()).minCoeff();
    const Vector3d outward = (on_box.cwiseQuotient(0.5 * size_m)).array().pow(5.0).matrix().normalized();
    const Vector3d centre = on_box + (kFingerRadius_m + between(-3e-3, 1e-3)) * outward;
    return pose_of(rotation(), centre);
  }

 private:
  std::mt19937 bits_;
};

/// The same function of the same point: equal to the last bit.
void expect_same(const std::vector<ContactCandidate>& found, const std::vector<ContactCandidate>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(found[i].control_point, expected[i].control_point);
    ASSERT_EQ(found[i].gap_m, expected[i].gap_m);
    ASSERT_EQ(found[i].point_m, expected[i].point_m);
    ASSERT_EQ(found[i].normal, expected[i].normal);
  }
}

/// A cloud with noise of this size in every sample's place and normal.
PointCloud disturbed(PointCloud cloud, double noise_m, double lean) {
  Random random(99);
  for (Index i = 0; i < cloud.points_m.cols(); ++i) {
    cloud.points_m.col(i) += noise_m * random.direction();
    cloud.normals.col(i) = (cloud.normals.col(i) + lean * random.direction()).normalized();
  }
  return cloud;
}

PointCloud ellipsoid(const Vector3d& half_m, Index count) {
  PointCloud cloud = sample_sphere(1.0, count);
  for (Index i = 0; i < count; ++i) {
    const Vector3d d = cloud.points_m.col(i);
    cloud.points_m.col(i) = half_m.cwiseProduct(d);
    cloud.normals.col(i) = d.cwiseQuotient(half_m).normalized();
  }
  return cloud;
}

struct Shape {
  const char* name;
  ImplicitSurface surface;
  Vector3d size_m;
  bool round = false;

  /// The finger anywhere around it, from 3 mm deep to 1 mm clear of it.
  [[nodiscard]] Isometry3d pose(Random& random) const {
    if (!round) return random.pose(size_m);
    const Vector3d half_m = 0.5 * size_m, d = random.direction();
    const Vector3d on_surface = d / d.cwiseQuotient(half_m).norm();
    const Vector3d outward = on_surface.cwiseQuotient(half_m.cwiseAbs2()).normalized();
    const double clear_m = kFingerRadius_m + random.between(-3e-3, 1e-3);
    return pose_of(random.rotation(), on_surface + clear_m * outward);
  }
};

/// A surface whose distances may be off a little, as a scene's are unless it asks for none.
ImplicitSurface allowing_error(ImplicitSurface surface) {
  surface.allow_error(1e-6, 4.3e-3);
  return surface;
}

/// Flat, curved, rough; with edges, and too thin for the support. One without an error.
const std::vector<Shape>& shapes() {
  const Vector3d size_m = scene().size_m, plate_m(20e-3, 1e-3, 20e-3), egg_m(20e-3, 24e-3, 34e-3);
  const PointCloud egg = ellipsoid(0.5 * egg_m, 8000);
  static const std::vector<Shape> kShapes = {
      {"box", allowing_error(scene().box), size_m},
      {"exact box", scene().box, size_m},
      {"plate", allowing_error(ImplicitSurface(sample_box(plate_m, 3600))), plate_m},
      {"ellipsoid", allowing_error(ImplicitSurface(egg)), egg_m, true},
      {"noisy ellipsoid", allowing_error(ImplicitSurface(disturbed(egg, 0.05e-3, 0.1))), egg_m, true},
      {"very noisy box", allowing_error(ImplicitSurface(disturbed(sample_box(size_m, 7600), 0.2e-3, 0.5))), size_m}};
  return kShapes;
}

TEST(ContactFinding, FindsWhatBruteForceFinds) {
  for (const Shape& shape : shapes()) {
    FindingMemory memory;
    std::vector<ContactCandidate> found;
    std::size_t contacts = 0;
    for (const Index max_contacts : {0, 1, 5, 20, 1000}) {
      const ContactFindingSettings settings{0.3e-3, 4e-3, max_contacts};
      const unsigned seed = static_cast<unsigned>(max_contacts) + 1;
      Random random(seed);
      for (int trial = 0; trial < 40; ++trial) {
        SCOPED_TRACE(testing::Message() << shape.name << ", seed " << seed << ", trial " << trial);
        const Isometry3d X_SB = shape.pose(random);
        find_contacts(scene().controls_m, X_SB, shape.surface, settings, memory, found);
        expect_same(found, brute_force(scene().controls_m, X_SB, shape.surface, settings));
        if (HasFatalFailure()) return;
        contacts += found.size();
      }
    }
    EXPECT_GT(contacts, 1000U) << shape.name;  // otherwise the test compared empty lists
  }
}

TEST(ContactFinding, WhatIsRememberedChangesNothing) {
  // Walks with steps from nanometres to half a millimetre, jumps, and bands and reaches that change on the way, as when
  // the caller looks for contacts farther off.
  for (const Shape& shape : shapes()) {
    for (unsigned seed = 1; seed <= 3; ++seed) {
      Random random(seed);
      FindingMemory memory;
      std::vector<ContactCandidate> found;
      Isometry3d X_SB = shape.pose(random);
      std::size_t contacts = 0;
      for (int step = 0; step < 120; ++step) {
        SCOPED_TRACE(testing::Message() << shape.name << ", seed " << seed << ", step " << step);
        if (step % 40 == 39) X_SB = shape.pose(random);
        const double step_m = std::pow(10.0, random.between(-9.0, -3.3));
        X_SB.translation() += step_m * random.direction();
        X_SB.rotate(Eigen::AngleAxisd(step_m / kFingerRadius_m, random.direction()));
        double band_m = seed == 3 && step % 7 == 0 ? 1e-3 : 0.3e-3;
        // A little wider and narrower from call to call: sleepers are to wake for the wider one.
        if (seed == 2) band_m *= random.between(0.85, 1.25);
        const ContactFindingSettings settings{band_m, seed == 3 && step % 5 == 0 ? 2.5e-3 : 4e-3,
                                              step % 3 == 0 ? 30 : 5};
        find_contacts(scene().controls_m, X_SB, shape.surface, settings, memory, found);
        expect_same(found, brute_force(scene().controls_m, X_SB, shape.surface, settings));
        if (HasFatalFailure()) return;
        contacts += found.size();
      }
      EXPECT_GT(contacts, 100U) << shape.name;
    }
  }
}

TEST(ContactFinding, T14DeepPointsAreFoundOnDenseSurfaces) {
  // Four times the reference scene's samples: a search in a shell of the band, or of the support, loses deep points.
  const ImplicitSurface dense(sample_box(scene().size_m, 4 * 7600));
  const ContactFindingSettings settings{0.3e-3, 4e-3, 1000};
  FindingMemory memory;
  std::vector<ContactCandidate> found;
  Random random(14);
  Index total = 0;
  for (int trial = 0; trial < 14; ++trial) {
    SCOPED_TRACE(trial);
    const Vector3d aside = 1e-3 * random.direction();
    const Vector3d centre(aside.x(), 0.5 * scene().size_m.y() + kFingerRadius_m - 2.6e-3, aside.z());
    const Isometry3d X_SB = pose_of(random.rotation(), centre);
    find_contacts(scene().controls_m, X_SB, dense, settings, memory, found);
    std::vector<Index> expected, actual;
    for (Index leaf = 0; leaf < 320; ++leaf) {
      if (box_distance_m(X_SB * scene().controls_m.col(leaf), scene().size_m) < settings.band_m) {
        expected.push_back(leaf);
      }
    }
    for (const ContactCandidate& contact : found) actual.push_back(contact.control_point);
    EXPECT_EQ(actual, expected);
    total += static_cast<Index>(expected.size());
  }
  EXPECT_GE(total, 800);
}

TEST(ContactFinding, KeepsTheLeastGapsAndTiesByControlPoint) {
  // Four points at each of five heights, heights and positions exactly repeated: whole groups tie.
  PointCloud cloud{Eigen::Matrix3Xd(3, 20), Vector3d::UnitX().replicate(1, 20)};
  for (Index i = 0; i < 20; ++i)
    cloud.points_m.col(i) = Vector3d(10e-3 - 0.1e-3 * static_cast<double>(i % 5), 0.0, 0.0);
  const Eigen::Matrix3Xd controls_m = control_points(cloud, 20);
  FindingMemory memory;
  std::vector<ContactCandidate> all, kept;
  find_contacts(controls_m, Isometry3d::Identity(), scene().box, {0.3e-3, 4e-3, 100}, memory, all);
  ASSERT_EQ(all.size(), 20U);
  for (Index max_contacts = 1; max_contacts < 20; ++max_contacts) {
    SCOPED_TRACE(max_contacts);
    find_contacts(controls_m, Isometry3d::Identity(), scene().box, {0.3e-3, 4e-3, max_contacts}, memory, kept);
    ASSERT_EQ(static_cast<Index>(kept.size()), max_contacts);
    for (std::size_t i = 1; i < kept.size(); ++i) EXPECT_LT(kept[i - 1].control_point, kept[i].control_point);
    // Whoever was left out comes after everybody kept, by (gap, control point).
    for (const ContactCandidate& out : all) {
      const auto is_out = [&](const ContactCandidate& in) { return in.control_point == out.control_point; };
      if (std::any_of(kept.begin(), kept.end(), is_out)) continue;
      for (const ContactCandidate& in : kept) {
        EXPECT_LT(std::tie(in.gap_m, in.control_point), std::tie(out.gap_m, out.control_point));
      }
    }
  }
}

TEST(ContactFinding, AFingerFarAwayHasNoContacts) {
  FindingMemory memory;
  std::vector<ContactCandidate> found(3, ContactCandidate{0, 0.0, Vector3d::Zero(), Vector3d::UnitX()});
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const double clear_m = 0.5 * scene().size_m[axis] + kFingerRadius_m + 0.31e-3;
      const Isometry3d X_SB = pose_of({0.3, Vector3d::UnitX()}, side * clear_m * Vector3d::Unit(axis));
      find_contacts(scene().controls_m, X_SB, scene().box, {}, memory, found);
      EXPECT_TRUE(found.empty());
    }
  }
}

TEST(ContactFinding, BesideAnEdgeThereIsNoContact) {
  // The planes of the faces go on beyond the edge, the surface does not. The cloud is turned so that its bounds, wider
  // than the box, do not hide a wrong answer.
  PointCloud turned = sample_box(scene().size_m, 7600);
  const Eigen::Matrix3d R = Eigen::AngleAxisd(0.5, Vector3d(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
  turned.points_m = R * turned.points_m;
  turned.normals = R * turned.normals;
  const ImplicitSurface surface(turned);
  Random random(3);
  for (int trial = 0; trial < 2000; ++trial) {
    // Within 0.2 mm of the plane of the face y+, 0.8 to 3 mm beyond its edge at x+.
    const Vector3d p(0.5 * scene().size_m.x() + random.between(0.8e-3, 3e-3),
                     0.5 * scene().size_m.y() + random.between(-0.2e-3, 0.2e-3), random.between(-12e-3, 12e-3));
    const std::optional<SurfaceDistance> to = surface.distance(R * p, 4e-3);
    if (to) {
      EXPECT_GT(to->distance_m, 0.3e-3) << "trial " << trial;
    }
  }
}

TEST(ContactFinding, DoesNotAllocateAgain) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc belongs to somebody else";
  FindingMemory memory;
  std::vector<ContactCandidate> found;
  Random random(5);
  const Isometry3d far(Eigen::Translation3d(1.0, 0.0, 0.0));
  find_contacts(scene().controls_m, far, scene().box, {}, memory, found);
  const AllocationCounter counter;
  for (int trial = 0; trial < 50; ++trial) {
    find_contacts(scene().controls_m, random.pose(scene().size_m), scene().box, {}, memory, found);
  }
  EXPECT_EQ(counter.count(), 0);
}

// What find_contacts leaves out rests on this: no distance is less than its bound, nor does it fall faster than the
// point moves.
TEST(ContactFinding, BoundsHold) {
  const Mug mug{20e-3, 40e-3, 3e-3, MugHandle{8e-3, 5e-3}};
  PointCloud noisy = sample_box(scene().size_m, 4000);
  Random random(77);
  for (Index i = 0; i < noisy.points_m.cols(); ++i) noisy.points_m.col(i) += 0.05e-3 * random.direction();
  const std::vector<PointCloud> clouds = {sample_mug(mug, 12000), noisy, sample_ellipsoid({30e-3, 40e-3, 60e-3}, 8000),
                                          sample_box({20e-3, 6e-3, 20e-3}, 3000)};
  for (std::size_t k = 0; k < clouds.size(); ++k) {
    const ImplicitSurface surface = allowing_error(ImplicitSurface(clouds[k]));
    int bounded = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vector3d x =
          clouds[k].points_m.col(i % clouds[k].points_m.cols()) + random.between(0.0, 2e-3) * random.direction();
      const Index sample = surface.nearest(x, 4e-3).sample;
      ASSERT_GE(sample, 0);
      const ImplicitSurface::Estimate estimate = surface.estimate(x, sample);
      ASSERT_GE(surface.distance_from(x, sample).distance_m, estimate.least_m) << "cloud " << k << ", query " << i;
      if (!(estimate.least_m > 0.0)) continue;
      ++bounded;
      const double way = random.between(0.0, std::min(estimate.firm_m, estimate.least_m));
      const Vector3d moved = x + way * random.direction();
      ASSERT_GE(surface.distance_from(moved, sample).distance_m, estimate.least_m - way - 1e-15)
          << "cloud " << k << ", query " << i;
    }
    EXPECT_GT(bounded, 100) << "cloud " << k;
  }
}

}  // namespace
}  // namespace thenar::contact_finding_test
