#include "engine/grasp/contact_gaps.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <random>
#include <span>
#include <vector>

#include "tests/grasp/grasp_frame.h"
#include "tests/support/scenes.h"

namespace thenar::contact_gaps_test {
namespace {

using namespace grasp_frame;

using Eigen::Isometry3d;
using Eigen::Vector3d;

class ContactGapsOfAGrasp : public GraspFrame {
 protected:
  /// The grasp's contacts, each on a surface of some other curvature: planes, rods, balls, saddles, hollows, and one in
  /// five at an edge.
  std::vector<FrameContact> curved_contacts(std::mt19937_64& random) const {
    std::vector<FrameContact> contacts = frame.contacts;
    for (FrameContact& contact : contacts) {
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
      }
    }
    return contacts;
  }
};

// Four at once have the gap and the normal that contact_gap() finds for each. The terms of a gap are of the size of the
// hand, 0.2 m, so that it has errors of 1e-17 m times their number.
TEST_F(ContactGapsOfAGrasp, AreThoseOfEachContactAlone) {
  constexpr double kRounding_m = 1e-15, kRounding = 1e-13;
  std::mt19937_64 random(11);
  ASSERT_GT(frame.size(), 30);
  for (int trial = 0; trial < 20; ++trial) {
    const std::vector<FrameContact> contacts = curved_contacts(random);
    Isometry3d X_WO = loop.state.X_WO;
    X_WO.pretranslate(1e-3 * random_direction(random));
    for (Index first = 0; first + 4 <= frame.size(); ++first) {
      const int finger = contacts[first].finger;
      for (Index count = 1; count <= 4 && contacts[first + count - 1].finger == finger; ++count) {
        const auto block = std::span(contacts).subspan(first, count);
        const Isometry3d X_FO = pose.distal(model.scene.hand, finger).inverse() * X_WO;
        const Vector3d u_O = 1e-4 * random_direction(random);
        lanes::Vector in_lanes;
        for (int lane = 0; lane < lanes::kLanes; ++lane) lanes::set(in_lanes, lane, u_O);
        const ContactGaps gaps = contact_gaps(block, X_FO, loop.state, in_lanes);
        for (int lane = 0; lane < count; ++lane) {
          SCOPED_TRACE(testing::Message() << "trial " << trial << ", contact " << first << " + " << lane);
          const Vector3d u_F = displacement(loop.state, block[lane]);
          const auto [gap_m, n_F] = contact_gap(block[lane], X_FO, u_F, u_O);
          EXPECT_EQ(lanes::get(gaps.u_F, lane), u_F);
          EXPECT_NEAR(gaps.gap_m[lane], gap_m, kRounding_m);
          EXPECT_LE((lanes::get(gaps.n_F, lane) - n_F).norm(), kRounding);
        }
      }
    }
  }
}

// Blocks have every contact once, in order, and never contacts of two fingers.
TEST(ContactBlocks, HaveEachContactOnce) {
  std::mt19937_64 random(12);
  for (int trial = 0; trial < 200; ++trial) {
    SCOPED_TRACE(testing::Message() << "trial " << trial << ", seed 12");
    std::vector<FrameContact> contacts;
    FrameContact contact;
    contact.p_F = contact.s_O = contact.n_O = Vector3d::UnitX();
    for (contact.finger = 0; contact.finger < 5; ++contact.finger) {
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
    });
    EXPECT_EQ(next, std::ssize(contacts));
  }
}

// Numbers are written to their contacts, in order, and to no other's: not even to the one after the last.
TEST(Lanes, WriteTheirOwnContactsAlone) {
  for (int count = 1; count <= lanes::kLanes; ++count) {
    SCOPED_TRACE(count);
    const auto number = [](int lane, int k) { return 100.0 * lane + k; };
    std::array<lanes::Real, 9> numbers;
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
