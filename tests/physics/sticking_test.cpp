// SPDX-License-Identifier: Apache-2.0
// A finger that sticks stays where it is: on curved objects, too, whatever the solver reports. All is judged by how the
// bodies and the pulps have moved.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bench/cases/pads.h"
#include "bench/cases/resting.h"
#include "bench/cases/scene_run.h"
#include "engine/grasp/object_compliance.h"
#include "tests/support/scenes.h"
#include "tests/support/three_fingers.h"

namespace thenar::sticking_test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Where the finger's point of a contact is on the object's surface, which a soft object takes along; object frame.
Vector3d point_on_object(const Model& model, const State& state, const HandPose& pose, const FrameContact& contact) {
  const Vector3d point_W = pose.distal(model.scene.hand, contact.finger) * (contact.p_F - displacement(state, contact));
  return state.X_WO.inverse() * point_W - object_displacement(model, state, contact);
}

/// The fastest motion along the object's surface, over one tick of the run, of a point that carries force and is inside
/// its friction cone [m/s].
double creep_m_per_s(GraspRun& run) {
  const Model& model = run.model;
  const State before = run.state;
  HandPose pose_before, pose_after;
  forward_kinematics(model.scene.hand, before.q, pose_before);
  run.tick();
  forward_kinematics(model.scene.hand, run.state.q, pose_after);
  double fastest_m = 0.0;
  for (Index i = 0; i < run.frame.size(); ++i) {
    const Vector3d f = run.memory.f.segment<3>(3 * i);
    if (f[0] <= 1e-6 || f.tail<2>().norm() > 0.99 * model.scene.contact.friction * f[0]) continue;
    const FrameContact& contact = run.frame.contacts[i];
    const Vector3d way_O =
        point_on_object(model, run.state, pose_after, contact) - point_on_object(model, before, pose_before, contact);
    // At an edge the bodies slip along the surface, and the pulp is sheared across its own normal.
    const Vector3d sheared_F = displacement(run.state, contact) - displacement(before, contact);
    const Eigen::Matrix3d R_WF = pose_before.distal(model.scene.hand, contact.finger).linear();
    const Vector3d bodies_W = before.X_WO.linear() * way_O + R_WF * sheared_F;
    const Eigen::Vector2d slip_m = run.work.kinematics.E_W[i].rightCols<2>().transpose() * bodies_W -
                                   run.work.kinematics.E_F[i].rightCols<2>().transpose() * sheared_F;
    fastest_m = std::max(fastest_m, slip_m.norm());
  }
  return fastest_m / model.scene.step_s;
}

// --- Prediction and commit ------------------------------------------------------------------------------------------

/// How far the change of u that a tick's solve counted on and the one that was committed lie apart, at the worst loaded
/// contact [m]. The first is what of delta the motion of the bodies does not explain.
double worst_misprediction_m(GraspRun& run) {
  const Model& model = run.model;
  const State before = run.state;
  run.tick();
  const State& after = run.state;
  const ContactKinematics& now = run.work.kinematics;
  const JointVector dq = after.q - before.q;
  const Eigen::AngleAxisd turn(after.X_WO.linear() * before.X_WO.linear().transpose());
  Vector6d dx;
  dx << after.X_WO.translation() - before.X_WO.translation(), turn.angle() * turn.axis();
  double worst_m = 0.0;
  for (Index i = 0; i < run.frame.size(); ++i) {
    if (!(run.memory.f[3 * i] > 0.0)) continue;
    const FrameContact& contact = run.frame.contacts[i];
    Vector3d predicted = run.work.delta.segment<3>(3 * i);
    predicted[0] -= now.gap_m[i] + now.gap_unit[i] * run.memory.offset_m[i];
    predicted -= now.J_finger.middleRows<3>(3 * i) * model.scene.hand.of_finger(contact.finger, dq).head<4>();
    predicted -= now.J_object.middleRows<3>(3 * i).leftCols<6>() * dx;
    Vector3d committed = now.E_F[i].transpose() * (displacement(after, contact) - displacement(before, contact));
    if (model.soft_object()) {
      // Of the contacts' points in this frame, which those of the last one may have become.
      committed += now.E_O[i].transpose() * object_displacement(model, after, contact) - now.u_object_m.col(i);
    }
    worst_m = std::max(worst_m, (predicted - committed).norm());
  }
  return worst_m;
}

/// The scenes that come with the program and have pulps that move something.
std::vector<std::string> moving_scenes() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(THENAR_CONFIGS)) {
    const std::string name = entry.path().stem().string();
    if (entry.is_directory() || name == "hand" || name == "scan_grasp" || name == "bunny" || name == "minimal" ||
        name.starts_with("resting_")) {
      continue;
    }
    names.push_back(name);
  }
  std::ranges::sort(names);
  return names;
}

/// By scene, and whether it has frames of 5 ms or is in one loop.
class StickingOf : public testing::TestWithParam<std::tuple<std::string, bool>> {};

// The bound is what an object that sticks may creep in 2 ms at 0.5 um/s; what is found is rounding, and for a soft
// object the loads of 1e-8 N that it forgets.
TEST_P(StickingOf, PulpsMoveAsTheSolverCountedOn) {
  const auto& [name, has_frames] = GetParam();
  const double longest_s = has_frames ? 3.0 : 1.0;  // With a frame a tick it takes five times as long.
  std::vector<std::string> changes{"object.points=12000"};
  if (has_frames) changes.emplace_back("time.control_period=5 ms");
  for (const bool soft : {false, true}) {
    if (soft) changes.emplace_back("object.compliance={reduced_modulus: 1 MPa, poisson: 0.5, relaxation: 5 ms}");
    SCOPED_TRACE(soft ? "soft" : "rigid");
    const Model model = build_model(scene_of(name, changes));
    GraspRun run = as_threads_would(model);
    run.tick();  // It presses in what starts in the object, bodies at rest.
    double worst_m = 0.0;
    // A plate of 1 mm is no half space: where it is soft, too, the grasp is lost at 26 ms, and what flies moves on
    // by more in a tick than its first order tells.
    const double soft_until_s = name == "thin_plate" ? 0.02 : 0.3;
    const double until_s = soft ? soft_until_s : std::min(run.model.scene.duration_s, longest_s);
    while (run.time_s() < until_s) worst_m = std::max(worst_m, worst_misprediction_m(run));
    EXPECT_LE(worst_m, 1e-9);
  }
}

TEST(Sticking, IsTriedOnTheScenesThatComeWithTheProgram) { EXPECT_GE(moving_scenes().size(), 25u); }

INSTANTIATE_TEST_SUITE_P(Scenes, StickingOf, testing::Combine(testing::ValuesIn(moving_scenes()), testing::Bool()),
                         [](const auto& scene) {
                           return std::get<0>(scene.param) + (std::get<1>(scene.param) ? "_frames" : "_one_loop");
                         });

// --- Creep ----------------------------------------------------------------------------------------------------------

/// The most creep of the last 0.3 s of `duration_s`.
double creep_at_rest_m_per_s(Scene scene, double period_s, double tolerance, double duration_s) {
  scene.control_period_s = period_s;
  scene.contact.tolerance = tolerance;
  const Model model = build_model(std::move(scene));
  GraspRun run = as_threads_would(model);
  double most = 0.0;
  while (run.time_s() < duration_s) {
    const double creep = creep_m_per_s(run);
    if (run.time_s() > duration_s - 0.3) most = std::max(most, creep);
  }
  return most;
}

// At rest no point that sticks moves by more than the solver's tolerance makes it: 0.5 um/s is 10 um in 20 s, and at a
// thousandth of the tolerance there is next to nothing left. (Fingers whose compliance was pressed in one set of axes
// and committed in another walked at 1200 um/s on the mug.)
TEST(Sticking, PointsInsideTheirConesStayOnCurvedObjects) {
  for (const Resting& rest : resting()) {
    SCOPED_TRACE(rest.name);
    for (const double period_s : {1e-3, 5e-3, 20e-3}) {
      SCOPED_TRACE(period_s);
      EXPECT_LE(creep_at_rest_m_per_s(rest.scene, period_s, rest.scene.contact.tolerance, rest.at_rest_s), 0.5e-6);
    }
    EXPECT_LE(creep_at_rest_m_per_s(rest.scene, 1e-3, 1e-9, rest.at_rest_s), 0.01e-6);
  }
}

// --- Coulomb's limits -----------------------------------------------------------------------------------------------

// Three equal pads of 2 N carry a ball by friction alone: mu 6 N = m g at the limit. A pad's contacts are spread over a
// part of the ball, where normals lean: 2 % less along the weight.
TEST(Sticking, BallIsHeldToCoulombsLimit) {
  const double least = 0.1 * 9.81 / 6.0, most_kg = 0.4 * 6.0 / 9.81;
  for (const double radius_m : {15e-3, 25e-3, 40e-3}) {
    SCOPED_TRACE(radius_m);
    Pads pads = pads_round(SphereShape{radius_m}, radius_m);
    for (const double share : {0.95, 1.05}) {
      pads.mass_kg = 0.1;
      pads.friction = share * least;
      EXPECT_EQ(hold(pads), share > 1.0);
      pads.mass_kg = share * most_kg;
      pads.friction = 0.4;
      EXPECT_EQ(hold(pads), share < 1.0);
    }
  }
}

// With the weight at an eccentric place each pad carries torsion, too. Where nothing is eccentric, the ellipsoids'
// limit is Coulomb's. Found by bisection: 0.94 to 1.00 of the law. With more friction the patches twist so far before
// they slide that the weight's lever is another.
TEST(Sticking, EccentricWeightIsHeldToTheSoftFingersLimit) {
  const double modulus_Pa = scene_of("stick").fingertips->material.reduced_modulus_Pa;
  const Pads round = pads_round(SphereShape{25e-3}, 25e-3);
  EXPECT_NEAR(most_mass_kg(round, modulus_Pa), 0.8 * 6.0 / 9.81, 1e-6);

  // A pinch at one place on either side: the weight turns the box about the grip axis against torsion alone.
  const Pads pinch = pads_across(BoxShape{Vector3d(50e-3, 50e-3, 50e-3)}, 50e-3, 0.0);
  const Pads apart = pads_across(BoxShape{Vector3d(50e-3, 50e-3, 50e-3)}, 50e-3, 14e-3);
  const std::vector<std::pair<Pads, double>> cases{{round, 5e-3},  {round, 20e-3}, {pinch, 5e-3},
                                                   {pinch, 20e-3}, {apart, 5e-3},  {apart, 20e-3}};
  for (const auto& [grasp, eccentricity_m] : cases) {
    Pads pads = grasp;
    pads.friction = 0.1;
    pads.depth_m = 1.6e-3;
    pads.centre_of_mass_m.y() = eccentricity_m;
    const double most_kg = most_mass_kg(pads, modulus_Pa);
    SCOPED_TRACE(most_kg);
    for (const double share : {0.9, 1.1}) {
      pads.mass_kg = share * most_kg;
      EXPECT_EQ(hold(pads), share < 1.0);
    }
  }
}

}  // namespace
}  // namespace thenar::sticking_test
