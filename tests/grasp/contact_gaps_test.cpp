// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/contact_gaps.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "engine/grasp/contact_kinematics.h"
#include "engine/grasp/object_compliance.h"
#include "tests/support/scenes.h"

namespace thenar::contact_gaps_test {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Vector3d;

Scene soft_grasp() {
  return scene_of("box_grasp",
                  {kCoarseBox, "object.compliance={reduced_modulus: 1 MPa, poisson: 0.5, relaxation: 5 ms}"});
}

/// A grasp at work, whose contacts are then each on a surface of some other curvature: planes, rods, balls, saddles,
/// hollows, and one in five at an edge.
struct CurvedGrasp {
  explicit CurvedGrasp(Scene scene) : loop(std::move(scene)), frame(loop.model) {
    loop.run(20e-3);
    loop.control();
    forward_kinematics(loop.model.scene.hand, loop.state.q, pose);
    frame = loop.frame;
    for (FrameContact& contact : frame.contacts) bend(contact);
    carry_loads(loop.model, frame, loop.state);
  }

  void bend(FrameContact& contact) {
    contact.t_O = contact.n_O.cross(random_direction(random)).normalized();
    const double tube_per_m = uniform(random, -100.0, 200.0);
    switch (random() % 5) {
      case 0:
        break;
      case 1:
        contact.curvature_per_m = tube_per_m;
        break;
      case 2:
        contact.curvature_per_m = contact.ring_curvature_per_m = tube_per_m;
        break;
      case 3:
        contact.curvature_per_m = tube_per_m;
        contact.ring_curvature_per_m = uniform(random, -1.0, 1.0) * tube_per_m;
        break;
      default:
        contact.share = contact.covered = 0.5;
        contact.press = 1.25;
        contact.lean_O = 0.2 * random_direction(random);
        contact.lean_m_per_N = 1e-5;
    }
  }

  /// The frame with contact i alone.
  [[nodiscard]] Frame alone(Index i) const {
    Frame one = frame;
    one.contacts = {frame.contacts[i]};
    for (int k = 0; k <= loop.model.fingers(); ++k) one.begin[k] = k > frame.contacts[i].finger ? 1 : 0;
    fill_object_kernel(loop.model, one);
    return one;
  }

  std::mt19937_64 random{11};
  Loop loop;
  Frame frame;
  HandPose pose;
};

// Four at once have the gap and the normal that contact_gap() finds for each, whoever else is in the lanes; that law
// has tests of its own. The terms of a gap are of the size of the hand, 0.2 m, and are rounded by 3e-17 m each. A
// normal is a sum of a dozen terms near 1, on a surface that curves by up to 200 / m: 1e-15 m turn it by 2e-13.
TEST(ContactGaps, AreThoseOfEachContactAlone) {
  constexpr double kRounding_m = 1e-15, kRounding = 2e-13;
  CurvedGrasp grasp(scene_of("box_grasp", {kCoarseBox}));
  ASSERT_GT(grasp.frame.size(), 30);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<FrameContact> contacts = grasp.loop.frame.contacts;
    for (FrameContact& contact : contacts) grasp.bend(contact);
    Isometry3d X_WO = grasp.loop.state.X_WO;
    X_WO.pretranslate(1e-3 * random_direction(grasp.random));
    for (Index first = 0; first < std::ssize(contacts); ++first) {
      const int finger = contacts[first].finger;
      const Isometry3d X_FO = grasp.pose.distal(grasp.loop.model.scene.hand, finger).inverse() * X_WO;
      for (Index count = 1; count <= lanes::kLanes; ++count) {
        if (first + count > std::ssize(contacts) || contacts[first + count - 1].finger != finger) break;
        const auto block = std::span(contacts).subspan(first, count);
        lanes::Vector u_O = {};
        for (int lane = 0; lane < count; ++lane) lanes::set(u_O, lane, 1e-4 * random_direction(grasp.random));
        const ContactGaps gaps = contact_gaps(block, X_FO, grasp.loop.state, u_O);
        for (int lane = 0; lane < count; ++lane) {
          SCOPED_TRACE(testing::Message() << "seed 11, trial " << trial << ", contact " << first << " + " << lane);
          const Vector3d u_F = displacement(grasp.loop.state, block[lane]);
          const auto [gap_m, n_F] = contact_gap(block[lane], X_FO, u_F, lanes::get(u_O, lane));
          EXPECT_EQ(lanes::get(gaps.u_F, lane), u_F);
          EXPECT_NEAR(gaps.gap_m[lane], gap_m, kRounding_m);
          EXPECT_LE((lanes::get(gaps.n_F, lane) - n_F).norm(), kRounding);
        }
      }
    }
  }
}

// Whatever a contact's neighbours are, at an edge or not, it has the kinematics that it has alone. Rounding of sums of
// a dozen terms; of a soft object, of sixty.
TEST(ContactKinematics, OfAContactAreThoseThatItHasAlone) {
  for (const bool is_soft : {false, true}) {
    const CurvedGrasp grasp(is_soft ? soft_grasp() : scene_of("box_grasp", {kCoarseBox}));
    const Model& model = grasp.loop.model;
    ASSERT_EQ(model.soft_object(), is_soft);
    ASSERT_GT(grasp.frame.size(), 30);
    Frame frame = grasp.frame;
    fill_object_kernel(model, frame);
    ContactKinematics all(model), one(model);
    contact_kinematics(model, frame, grasp.pose, grasp.loop.state, all);
    int fading = 0;
    for (Index i = 0; i < frame.size(); ++i) {
      SCOPED_TRACE(testing::Message() << (is_soft ? "soft, " : "rigid, ") << "seed 11, contact " << i);
      fading += frame.contacts[i].fades() ? 1 : 0;
      contact_kinematics(model, grasp.alone(i), grasp.pose, grasp.loop.state, one);
      const auto expect_same = [](const auto& a, const auto& b) { EXPECT_LE((a - b).norm(), 1e-13 * b.norm()); };
      EXPECT_NEAR(all.gap_m[i], one.gap_m[0], 1e-15);
      EXPECT_NEAR(all.gap_unit[i], one.gap_unit[0], 1e-13);
      expect_same(all.E_F[i], one.E_F[0]);
      expect_same(all.E_W[i], one.E_W[0]);
      expect_same(all.c_W[i], one.c_W[0]);
      expect_same(all.pulp_axes.middleRows<3>(3 * i), one.pulp_axes.topRows<3>());
      expect_same(all.pulp_axes.middleRows<3>(3 * i), all.E_F[i].transpose());
      expect_same(all.J_finger.middleRows<3>(3 * i), one.J_finger.topRows<3>());
      expect_same(all.J_object.middleRows<3>(3 * i), one.J_object.topRows<3>());
      if (!is_soft) continue;
      expect_same(all.E_O[i], one.E_O[0]);
      expect_same(all.object_tensors.middleRows<3>(3 * i), one.object_tensors.topRows<3>());
      EXPECT_LE((all.u_object_m.col(i) - one.u_object_m.col(0)).norm(), 1e-15);
    }
    EXPECT_GT(fading, 3);
    EXPECT_LT(fading, frame.size() / 2);
  }
}

// Blocks have every contact once, in order, and never contacts of two fingers. They are as large as that allows.
TEST(ContactBlocks, HaveEachContactOnce) {
  std::mt19937_64 random(12);
  FrameContact contact;
  contact.p_F = contact.s_O = contact.n_O = Vector3d::UnitX();
  for (int trial = 0; trial < 200; ++trial) {
    SCOPED_TRACE(testing::Message() << "trial " << trial << ", seed 12");
    std::vector<FrameContact> contacts;  // None in the first trial.
    for (contact.finger = 0; contact.finger < 5 && trial > 0; ++contact.finger) {
      contacts.insert(contacts.end(), random() % 7, contact);
    }
    Index next = 0;
    for_each_block(contacts, [&](Index first, std::span<const FrameContact> block) {
      EXPECT_EQ(first, next);
      EXPECT_EQ(block.data(), contacts.data() + first);
      ASSERT_GE(std::ssize(block), 1);
      ASSERT_LE(std::ssize(block), lanes::kLanes);
      for (const FrameContact& of_block : block) EXPECT_EQ(of_block.finger, block.front().finger);
      next += std::ssize(block);
      if (std::ssize(block) < lanes::kLanes && next < std::ssize(contacts)) {
        EXPECT_NE(contacts[next].finger, block.front().finger);
      }
    });
    EXPECT_EQ(next, std::ssize(contacts));
  }
}

// A tangent along the normal leaves the other axes zero, and no lane that is not a number.
TEST(Lanes, HaveNoTangentAlongTheirNormal) {
  lanes::Vector n = {}, t = {};
  for (int lane = 0; lane < lanes::kLanes; ++lane) {
    lanes::set(n, lane, Vector3d::UnitZ());
    lanes::set(t, lane, lane == 1 ? Vector3d::UnitZ() : Vector3d(3.0, 0.0, 4.0));
  }
  const lanes::Axes E = lanes::axes_of(n, t);
  for (int lane = 0; lane < lanes::kLanes; ++lane) {
    EXPECT_EQ(lanes::get(E[0], lane), Vector3d::UnitZ());
    EXPECT_EQ(lanes::get(E[1], lane), lane == 1 ? Vector3d::Zero() : Vector3d(1.0, 0.0, 0.0)) << lane;
    EXPECT_EQ(lanes::get(E[2], lane), lane == 1 ? Vector3d::Zero() : Vector3d(0.0, 1.0, 0.0)) << lane;
  }
}

// Numbers are written to their contacts, in order, and to no other's: not even to the one after the last.
TEST(Lanes, WriteTheirOwnContactsAlone) {
  for (int count = 1; count <= lanes::kLanes; ++count) {
    SCOPED_TRACE(count);
    const auto number = [](int lane, int k) { return 100.0 * lane + k; };
    std::array<lanes::Numbers, 9> numbers;
    for (int k = 0; k < 9; ++k) {
      for (int lane = 0; lane < lanes::kLanes; ++lane) numbers[k][lane] = number(lane, k);
    }
    constexpr Index kStride = 11;
    std::vector<double> to(kStride * lanes::kLanes, -1.0);
    lanes::write(numbers, count, to.data(), kStride);
    for (Index at = 0; at < std::ssize(to); ++at) {
      const int lane = static_cast<int>(at / kStride), k = static_cast<int>(at % kStride);
      EXPECT_EQ(to[at], lane < count && k < 9 ? number(lane, k) : -1.0) << at;
    }
  }
}

}  // namespace
}  // namespace thenar::contact_gaps_test
