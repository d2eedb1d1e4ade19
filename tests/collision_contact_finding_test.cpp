#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <tuple>
#include <vector>

#include "collision/contact_finding.h"
#include "collision/shapes.h"
#include "collision/sphere_tree.h"
#include "tests/allocation_counter.h"

namespace thenar {
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

/// Those of a tree's leaves.
Eigen::Matrix3Xd control_points(const PointCloud& cloud, Index leaves) {
  const SphereTree tree(cloud, leaves);
  Eigen::Matrix3Xd points_m(3, leaves);
  for (Index i = 0; i < leaves; ++i) {
    points_m.col(i) = cloud.points_m.col(tree.nodes()[tree.leaves()[i]].representative);
  }
  return points_m;
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
  ImplicitSurface box{sample_box(size_m, 7600), 1000};
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

TEST(ContactFinding, FindsWhatBruteForceFinds) {
  FindingMemory memory;
  std::vector<ContactCandidate> found;
  Index contacts = 0;
  for (const Index max_contacts : {0, 5, 20, 1000}) {
    const ContactFindingSettings settings{0.3e-3, 4e-3, max_contacts};
    Random random(static_cast<unsigned>(max_contacts) + 1);
    for (int trial = 0; trial < 100; ++trial) {
      SCOPED_TRACE(testing::Message() << "max_contacts " << max_contacts << ", trial " << trial);
      const Isometry3d X_SB = random.pose(scene().size_m);
      find_contacts(scene().controls_m, X_SB, scene().box, settings, memory, found);
      const auto expected = brute_force(scene().controls_m, X_SB, scene().box, settings);
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t i = 0; i < found.size(); ++i) {
        // The same function of the same point: equal to the last bit.
        ASSERT_EQ(found[i].control_point, expected[i].control_point);
        ASSERT_EQ(found[i].gap_m, expected[i].gap_m);
        ASSERT_EQ(found[i].point_m, expected[i].point_m);
        ASSERT_EQ(found[i].normal, expected[i].normal);
      }
      contacts += static_cast<Index>(found.size());
    }
  }
  EXPECT_GT(contacts, 2000);  // otherwise the test compared empty lists
}

TEST(ContactFinding, T14DeepPointsAreFoundOnDenseSurfaces) {
  // Four times the reference scene's samples: a search in a shell of the band, or of the support, loses deep points.
  const ImplicitSurface dense(sample_box(scene().size_m, 4 * 7600), 4000);
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
  const ImplicitSurface surface(turned, 1000);
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

}  // namespace
}  // namespace thenar
