// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/contact_search.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include "collision/shapes.h"
#include "engine/formats/ply_file.h"
#include "engine/grasp/finger_travel.h"
#include "engine/grasp/frame.h"
#include "engine/loops/run.h"
#include "engine/models/build_model.h"
#include "tests/grasp/grasp_frame.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"
#include "tests/support/three_fingers.h"

namespace thenar::contact_search_test {
namespace {

using namespace grasp_frame;

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Vector3d;

Isometry3d X_OF(const Model& model, const State& state, int finger) {
  HandPose pose;
  forward_kinematics(model.scene.hand, state.q, pose);
  return state.X_WO.inverse() * pose.distal(model.scene.hand, finger);
}

/// The contacts of a frame without a drive, with the object somewhere on the fingertips.
struct RandomFrame {
  RandomFrame(const Model& model, std::mt19937_64& random) : state(model), frame(model), search(model) {
    forward_kinematics(model.scene.hand, state.q, pose);
    const Fingertip& tip = model.scene.hand.fingertips[0];
    const Vector3d half_m = 0.5 * model.object.bounds().sizes();
    state.X_WO.linear() = random_rotation(random);
    const Vector3d p_O(uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0));
    state.X_WO.translation() = pose.distal(model.scene.hand, 0) * tip.centre_m +
                               uniform(random, 0.3, 1.1) * tip.radius_m * random_direction(random) -
                               state.X_WO.linear() * p_O.cwiseProduct(half_m);
    frame.X_WO = state.X_WO;
    for (int k = 0; k < kFingers; ++k) frame.X_WF[k] = pose.distal(model.scene.hand, k);
    frame.sequence = 0;
    find(model);
  }
  void find(const Model& model) { find_frame_contacts(model, pose, state, search, frame); }

  State state;
  HandPose pose;
  Frame frame;
  ContactSearch search;
};

void expect_valid(const Model& model, const RandomFrame& random) {
  const Frame& frame = random.frame;
  ASSERT_LE(frame.size(), model.max_contacts);
  ASSERT_EQ(frame.begin[0], 0);
  ASSERT_EQ(frame.begin[kFingers], frame.size());
  for (int k = 0; k < kFingers; ++k) {
    ASSERT_LE(frame.begin[k + 1] - frame.begin[k], model.scene.contact.max_per_finger);
    const Isometry3d X_FO = X_OF(model, random.state, k).inverse();
    const double r = model.scene.hand.fingertips[k].radius_m;
    for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
      const FrameContact& contact = frame.contacts[i];
      EXPECT_EQ(contact.finger, k);
      const Index last = i > frame.begin[k] ? frame.contacts[i - 1].control_point : -1;
      EXPECT_GT(contact.control_point, last);
      EXPECT_NEAR(contact.n_O.norm(), 1.0, 1e-12);
      EXPECT_LE((contact.E_F.transpose() * contact.E_F - Eigen::Matrix3d::Identity()).norm(), 1e-9);
      // A contact at an edge leans beside the pulp's own normal, and is in the middle of its part of a flat cell.
      if (!contact.fades()) {
        EXPECT_LE((contact.E_F.col(0) - X_FO.linear() * contact.n_O).norm(), 1e-9);
      }
      EXPECT_TRUE(std::isfinite(contact.curvature_per_m));
      // The pulp's own, and no deeper than half the pulp with what the object's surface may stray.
      EXPECT_NEAR((contact.p_F - model.scene.hand.fingertips[k].centre_m).norm(), r, contact.fades() ? 0.15e-3 : 1e-9);
      const double gap_m = contact_gap(contact, X_FO, Vector3d::Zero()).gap_m;
      EXPECT_TRUE(std::isfinite(gap_m));
      EXPECT_LT(gap_m, model.scene.contact.band_m + 1e-3);
    }
  }
}

/// Clouds of all kinds. A drive of nothing, so that the band is the scene's.
std::vector<Model> models() {
  Scene scene = scene_of("box_grasp", {"object.points=3000"});
  scene.control.reset();
  scene.task = {};
  scene.torques = scene.hand.at_zero();
  scene.gravity.setZero();
  std::vector<Model> all;
  const auto add = [&](const Shape& shape) {
    scene.object.shape = shape;
    all.push_back(build_model(scene));
  };
  for (const double thickness_m : {40e-3, 4e-3, 1e-3, 0.5e-3}) add(BoxShape{{40e-3, 30e-3, thickness_m}});
  for (const double radius_m : {25e-3, 3e-3}) add(SphereShape{radius_m});
  std::mt19937_64 random(9);
  PointCloud noisy = sample_sphere(20e-3, 3000);
  for (Index i = 0; i < noisy.points_m.cols(); ++i) {
    noisy.points_m.col(i) += uniform(random, -0.2e-3, 0.2e-3) * noisy.normals.col(i);
    noisy.normals.col(i) = (noisy.normals.col(i) + 0.2 * random_direction(random)).normalized();
  }
  const auto file = scratch() / "noisy.ply";
  save_ply(file, noisy, PlyFormat::kBinaryLittleEndian);
  add(CloudShape{file});
  return all;
}

// Whatever lies on the fingertips, deep or far: frames keep their promises, the forces on them are finite, and finding
// them takes no memory.
TEST(ContactSearch, FramesAreValidOnAnyCloudAtAnyPose) {
  std::size_t contacts = 0;
  for (const Model& model : models()) {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      SCOPED_TRACE(testing::Message() << "object of " << model.object.bounds().sizes().transpose() << ", seed "
                                      << seed);
      std::mt19937_64 random(seed);
      RandomFrame on(model, random);
      expect_valid(model, on);
      contacts += on.frame.contacts.size();
      if (AllocationCounter::is_available()) {
        const AllocationCounter counter;
        on.find(model);
        EXPECT_EQ(counter.count(), 0);
      }
      ContactMemory memory(model);
      ContactScratch work(model);
      State state = on.state;
      on.frame.torque_Nm.setZero();
      on.frame.wrench.setZero();
      const TickReport tick = contact_tick(model, on.frame, memory, work, state);
      EXPECT_NE(tick.solve.status, SolveStatus::kNotFinite);
      EXPECT_TRUE(state.q.allFinite() && state.X_WO.matrix().allFinite());
    }
  }
  EXPECT_GT(contacts, 2000u);
}

/// A frame's contact of a control point; null if there is none.
const FrameContact* contact_of(const Frame& frame, const FrameContact& like) {
  for (const FrameContact& contact : frame.contacts) {
    if (contact.finger == like.finger && contact.control_point == like.control_point) return &contact;
  }
  return nullptr;
}

/// Errors of contacts that are held from frame to frame, against those that a search without a memory finds.
struct HeldErrors {
  Index compared = 0, held = 0;  ///< Contacts that both have; control points that have moved since theirs was found.
  double gap_m = 0.0, turn_rad = 0.0, skew = 0.0;
  double least_unmatched_m = 1.0;  ///< The least gap of a contact that one of the two lacks.
};

ContactGap deformed(const Model& model, const State& state, const FrameContact& contact) {
  return contact_gap(contact, X_OF(model, state, contact.finger).inverse(), displacement(state, contact));
}

/// The thumb's contacts of `some` that `others` lacks.
void add_unmatched(const Model& model, const State& state, const Frame& some, const Frame& others, HeldErrors& errors) {
  for (const FrameContact& contact : std::span(some.contacts).first(some.begin[1])) {
    if (contact_of(others, contact) != nullptr) continue;
    const double rest_m = contact_gap(contact, X_OF(model, state, 0).inverse(), Vector3d::Zero()).gap_m;
    errors.least_unmatched_m = std::min({errors.least_unmatched_m, deformed(model, state, contact).gap_m, rest_m});
  }
}

void compare(const Model& model, const RandomFrame& on, HeldErrors& errors) {
  Frame anew = on.frame;
  ContactSearch search(model);
  find_frame_contacts(model, on.pose, on.state, search, anew);
  add_unmatched(model, on.state, anew, on.frame, errors);
  add_unmatched(model, on.state, on.frame, anew, errors);
  for (const FrameContact& found : std::span(anew.contacts).first(anew.begin[1])) {
    const FrameContact* const known = contact_of(on.frame, found);
    if (known == nullptr || found.fades() || known->fades()) continue;
    const ContactGap as_known = deformed(model, on.state, *known), as_found = deformed(model, on.state, found);
    ASSERT_TRUE(std::isfinite(as_known.gap_m) && as_known.n_F.allFinite() && known->E_F.allFinite());
    ++errors.compared;
    errors.gap_m = std::max(errors.gap_m, std::abs(as_known.gap_m - as_found.gap_m));
    errors.turn_rad = std::max(errors.turn_rad, (as_known.n_F - as_found.n_F).norm());
    errors.skew = std::max(errors.skew, (known->E_F.transpose() * known->E_F - Eigen::Matrix3d::Identity()).norm());
  }
  const Isometry3d X = X_OF(model, on.state, 0);
  for (const HeldContact& one : on.search.held[0]) {
    const Vector3d p_O = X * model.pulps[0].control_points_m.col(one.contact.control_point);
    errors.held += (p_O - one.p_O).norm() > 1e-7 ? 1 : 0;
  }
}

/// Whether the thumb's pulp is pressed in by so much that it may change the side that it sees: beyond the middle
/// of the thinnest of these objects.
bool is_deep(const Model& model, const RandomFrame& on) {
  return std::ranges::any_of(std::span(on.frame.contacts).first(on.frame.begin[1]), [&](const FrameContact& contact) {
    return deformed(model, on.state, contact).gap_m < -2e-3;
  });
}

/// The object creeps along, and turns on, the thumb's pulp, which is sheared, from several poses.
HeldErrors errors_of_held(const Shape& shape) {
  Scene scene = scene_of("box_grasp", {"object.points=36000"});
  scene.control.reset();
  scene.task = {};
  scene.torques = scene.hand.at_zero();
  scene.gravity.setZero();
  scene.object.shape = shape;
  scene.contact.max_per_finger = 1000;
  const Model model = build_model(scene);
  HeldErrors errors;
  int poses = 0;
  for (std::uint64_t seed = 1; poses < 4 && seed <= 1000; ++seed) {
    std::mt19937_64 random(seed);
    RandomFrame on(model, random);
    if (on.frame.begin[1] < 8 || is_deep(model, on)) continue;
    ++poses;
    SCOPED_TRACE(seed);
    const Vector3d way_m = 2e-6 * random_direction(random), axis = random_direction(random);
    const Vector3d shear_m = 1e-6 * random_direction(random);
    for (int step = 0; step < 12; ++step) {
      on.state.X_WO.translation() += way_m;
      on.state.X_WO.linear() = Eigen::AngleAxisd(5e-5, axis) * on.state.X_WO.linear();
      on.state.u_m[0].rowwise() += shear_m.transpose();
      on.frame.X_WO = on.state.X_WO;
      on.find(model);
      compare(model, on, errors);
    }
  }
  EXPECT_EQ(poses, 4);
  return errors;
}

// At the deformed point gaps are the same within a hundredth of the allowed error of distances, and so is what has a
// contact at all. Normals turn as the curvature says, so that where it changes they lag.
TEST(ContactSearch, WhatIsHeldIsWhatWouldBeFound) {
  struct Case {
    const char* name;
    Shape shape;
    double turn_rad = 1e-9;
  };
  const Case cases[]{{"box", BoxShape{{40e-3, 30e-3, 40e-3}}},
                     {"ball", SphereShape{25e-3}},
                     {"small ball", SphereShape{7e-3}},
                     {"cylinder", CylinderShape{12e-3, 60e-3}},
                     {"ellipsoid", EllipsoidShape{{25e-3, 18e-3, 12e-3}}, 1e-3},
                     {"mug", Mug{27.5e-3, 70e-3, 3e-3, MugHandle{14e-3, 7e-3}}}};
  const ContactSettings settings = scene_of("box_grasp").contact;
  for (const Case& one : cases) {
    SCOPED_TRACE(one.name);
    const HeldErrors errors = errors_of_held(one.shape);
    EXPECT_GT(errors.compared, 300);
    EXPECT_GT(errors.held, 300);
    EXPECT_LT(errors.gap_m, 1e-2 * settings.distance_error_m);
    EXPECT_LT(errors.turn_rad, one.turn_rad);
    EXPECT_LT(errors.skew, 1e-12);
    EXPECT_GT(errors.least_unmatched_m, settings.band_m - 2.0 * settings.distance_error_m);  // Of either search.
  }
}

// A wall is as curved for a pulp pressed in beyond its middle as for one that is not. The gaps of the contacts are
// those from the cylinder, but for the sag of the samples' planes (h^2 / 12 R, 9 um here), the surface points lie under
// the control points, and no control point in the wall is missed.
TEST(ContactSearch, CurvedThinWallsAreAsCurvedAsTheyAre) {
  constexpr double kOuter_m = 27.5e-3;
  Scene scene = pressed_thumb(0.0, Vector3d::Zero(), 1e9);
  const Vector3d n_W = scene.object.X_WO.linear().col(0);
  scene.object.shape = Mug{.radius_m = kOuter_m, .height_m = 60e-3, .wall_m = 3e-3, .handle = {}};
  scene.object.points = 30000;
  scene.object.X_WO.translation() += (kOuter_m - 10e-3) * n_W;  // from the middle of a box of 20 mm
  scene.contact.max_per_finger = 80;
  const Model model = build_model(scene);
  Frame frame(model);
  frame.torque_Nm.setZero();
  frame.wrench.setZero();
  ContactSearch search(model);
  HandPose pose;
  forward_kinematics(model.scene.hand, model.scene.posture, pose);
  for (const double depth_m : {0.5e-3, 1.4e-3, 1.6e-3, 2e-3, 2.5e-3}) {
    SCOPED_TRACE(depth_m);
    State state(model);
    state.X_WO.translation() -= depth_m * n_W;
    find_frame_contacts(model, pose, state, search, frame);
    const Isometry3d X = X_OF(model, state, 0);
    const auto gap_m = [&](const Vector3d& p_O) { return std::hypot(p_O.x(), p_O.y()) - kOuter_m; };
    const Pulp& pulp = model.pulps[0];
    Index in_wall = 0;
    for (Index c = 0; c < pulp.controls(); ++c) in_wall += gap_m(X * pulp.control_points_m.col(c)) < -30e-6 ? 1 : 0;
    EXPECT_GE(frame.begin[1], in_wall);
    for (Index i = 0; i < frame.begin[1]; ++i) {
      const FrameContact& contact = frame.contacts[i];
      const Vector3d p_O = X * contact.p_F;
      EXPECT_NEAR(contact_gap(contact, X.inverse(), Vector3d::Zero()).gap_m, gap_m(p_O), 25e-6);
      EXPECT_LT((p_O - contact.s_O).cross(contact.n_O).norm(), 1e-9);
    }
  }
}

// What a frame's reach relies on: no fingertip moves further against the object than was said, from the snapshot to
// the end of the frame's use; while a grip closes on a box, which then starts to fall and is carried. It is a bound at
// first order: a tenth and a tenth of the band are for what is not.
TEST(Ways, BoundTheMotionOfFingertipsWhileAFrameIsUsed) {
  const Model model =
      build_model(scene_of("box_grasp", {kCoarseBox, "time.control_period=10 ms", "time.control_delay=10 ms"}));
  GraspRun loops(model, LockstepSettings{});
  struct Said {
    PerFinger<double> way_m;
    std::array<Isometry3d, kFingers> X_OF;
  };
  std::vector<Said> said;  // of the last two frames
  double largest_m = 0.0, last_m = 1.0;
  while (loops.state.tick < 300) {
    const State before = loops.state;
    loops.tick();
    if (loops.controlled) {
      HandPose pose;
      forward_kinematics(model.scene.hand, before.q, pose);
      // Frames under way are not to be seen: its drive is that of the report, with no muscles between.
      Frame drive = loops.frame;
      drive.torque_Nm = loops.report.torques_desired_Nm - gravity_torques(model.scene.hand, pose, model.scene.gravity);
      Said now{finger_travel_m(model, pose, before, drive), {}};
      for (int k = 0; k < kFingers; ++k) now.X_OF[k] = X_OF(model, before, k);
      said.push_back(now);
      if (said.size() > 2) said.erase(said.begin());
      last_m = *std::max_element(now.way_m.begin(), now.way_m.end());
      largest_m = std::max(largest_m, last_m);
    }
    for (const Said& then : said) {
      for (int k = 0; k < kFingers; ++k) {
        const Vector3d& c = model.scene.hand.fingertips[k].centre_m;
        const double moved_m = (X_OF(model, loops.state, k) * c - then.X_OF[k] * c).norm();
        EXPECT_LE(moved_m, 1.1 * then.way_m[k] + 0.1 * model.scene.contact.band_m) << k << " at " << loops.state.tick;
      }
    }
  }
  EXPECT_GT(largest_m, 2e-3);
  EXPECT_LT(last_m, 0.1 * largest_m) << "a grip at rest needs no reach";
}

// No more than the object, whatever the drive.
TEST(Ways, AreFinite) {
  const Model model = build_model(scene_of("box_grasp", {kCoarseBox}));
  const State state(model);
  Frame frame(model);
  HandPose pose;
  forward_kinematics(model.scene.hand, state.q, pose);
  for (const double torque : {1e300, std::numeric_limits<double>::infinity(), std::nan("")}) {
    frame.torque_Nm.setConstant(torque);
    for (const double way_m : finger_travel_m(model, pose, state, frame)) EXPECT_LE(way_m, 0.1);
  }
}

TEST_F(GraspFrame, HoldsContactsOfEveryFingerInOrder) {
  ASSERT_GT(frame.size(), 30);
  EXPECT_EQ(frame.begin[0], 0);
  EXPECT_EQ(frame.begin[kFingers], frame.size());
  for (int k = 0; k < kFingers; ++k) {
    EXPECT_GT(frame.begin[k + 1], frame.begin[k]);
    EXPECT_LE(frame.begin[k + 1] - frame.begin[k], model.scene.contact.max_per_finger);
    for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
      EXPECT_EQ(frame.contacts[i].finger, k);
      if (i == frame.begin[k]) continue;
      EXPECT_LT(frame.contacts[i - 1].control_point, frame.contacts[i].control_point);
    }
  }
}

// Rigid fingertips: one contact a finger, at the object's nearest point, where the normal meets both bodies.
TEST(PointContact, IsTheNearestPointOfTheTipsSphere) {
  Loop loop(scene_of("minimal"));
  loop.control();
  ASSERT_EQ(loop.frame.size(), kFingers);
  const double R = std::get<SphereShape>(loop.model.scene.object.shape).radius_m;
  for (int k = 0; k < kFingers; ++k) {
    SCOPED_TRACE(k);
    const FrameContact& contact = loop.frame.contacts[k];
    const Fingertip& tip = loop.model.scene.hand.fingertips[k];
    const Vector3d centre_O =
        loop.state.X_WO.inverse() * (loop.controller.pose.distal(loop.model.scene.hand, k) * tip.centre_m);
    // The ball is sampled: its implicit surface lies within 0.05 mm of it (h^2 / (12 R), h = 2.2 spacings of 1 mm) and
    // its normals within 1 degree.
    EXPECT_NEAR(contact.s_O.norm(), R, 0.05e-3);
    EXPECT_LE(contact.n_O.cross(-centre_O.normalized()).norm(), 0.02);
    EXPECT_GT(contact.n_O.dot(-centre_O), 0.0);
    EXPECT_NEAR((contact.p_F - tip.centre_m).norm(), tip.radius_m, 1e-15);
    EXPECT_LE((contact.p_F - tip.centre_m - tip.radius_m * contact.E_F.col(0)).norm(), 1e-15);
  }
}

}  // namespace
}  // namespace thenar::contact_search_test
