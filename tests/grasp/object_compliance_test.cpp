// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/object_compliance.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/grasp/compliance.h"
#include "engine/models/build_model.h"
#include "engine/problems/problem_dump.h"
#include "engine/scenes/config.h"
#include "tests/support/algebra.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scenes.h"
#include "tests/support/three_fingers.h"

namespace thenar::object_compliance_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// One thumb pressed against a soft box by 1 N, or less.
Scene soft_press(const PulpMaterial& object, double force_N = 1.0, double depth_m = 1e-3) {
  Scene scene = pressed_thumb(depth_m, {-force_N, 0.0, 0.0}, 1.0);
  scene.contact.max_per_finger = 40;
  scene.contact.tolerance = 1e-12;
  scene.contact.max_sweeps = 100'000;
  scene.object.compliance = object;
  return scene;
}

Scene soft_grasp() {
  return scene_of("box_grasp",
                  {kCoarseBox, "object.compliance={reduced_modulus: 1 MPa, poisson: 0.5, relaxation: 5 ms}"});
}

/// A frame with contacts on all fingers: control points against a surface at random places with random normals.
Frame random_frame(const Model& model, std::mt19937_64& random) {
  Frame frame(model);
  frame.X_WO = random_rotation_about({0.1, 0.0, 0.0}, random);
  for (int k = 0; k < kFingers; ++k) {
    frame.X_WF[k] = random_rotation_about({0.0, 0.1, 0.0}, random);
    frame.begin[k] = frame.size();
    const Pulp& pulp = model.pulps[k];
    const Index step = pulp.controls() / (model.max_contacts / kFingers);
    for (Index c = 0; c + step <= pulp.controls(); c += step) {
      const Vector3d n_O = random_direction(random);
      const Eigen::Matrix3d R_FO = frame.X_WF[k].linear().transpose() * frame.X_WO.linear();
      const Eigen::Matrix3d E_F = axes_of(R_FO * n_O, random_direction(random));
      frame.contacts.push_back({.finger = k,
                                .control_point = c,
                                .p_F = pulp.control_points_m.col(c),
                                .s_O = 0.02 * random_direction(random),
                                .n_O = n_O,
                                .E_F = E_F});
    }
  }
  frame.begin[kFingers] = frame.size();
  return frame;
}

/// The tensors of a frame's contacts, in the axes that they have in it.
ContactKinematics kinematics_of(const Model& model, const Frame& frame) {
  ContactKinematics now(model);
  for (Index i = 0; i < frame.size(); ++i) {
    const FrameContact& contact = frame.contacts[i];
    now.pulp_axes.middleRows<3>(3 * i) = contact.E_F.transpose();
    const Eigen::Matrix3d R_OF = frame.X_WO.linear().transpose() * frame.X_WF[contact.finger].linear();
    now.object_tensors.middleRows<3>(3 * i) = (R_OF * contact.E_F).transpose() * object_tensor(model, contact);
  }
  return now;
}

MatrixXd object_compliance(const Model& model, const Frame& frame, const ContactKinematics& now) {
  MatrixXd C = MatrixXd::Zero(3 * frame.size(), 3 * frame.size());
  add_compliance(object_compliance(model, frame, now.object_tensors), C);
  return C / (1.0 - retained_share(*model.scene.object.compliance, model.scene.step_s));
}

// Where surface points lie to one another as the control points do, an object of the pulps' material has the pulps'
// compliance along the normals, and at each point itself: the displacement is shared equally, exactly. Rounding of
// three products and a root. Between points the pulps have Cerruti's tensor across the normals, the object its mean.
TEST(SoftObject, OfThePulpsMaterialHasThePulpsCompliance) {
  Scene scene = soft_grasp();
  scene.object.compliance = scene.fingertips->material;
  const Model model = build_model(std::move(scene));
  std::mt19937_64 random(11);
  Frame frame = random_frame(model, random);
  for (FrameContact& contact : frame.contacts) {
    contact.s_O = frame.X_WO.inverse() * frame.X_WF[contact.finger] * contact.p_F;
  }
  fill_kernels(model, frame);
  const ContactKinematics now = kinematics_of(model, frame);
  const MatrixXd C_o = object_compliance(model, frame, now);
  for (int k = 0; k < kFingers; ++k) {
    const Index first = 3 * frame.begin[k], rows = 3 * frame.begin[k + 1] - first;
    MatrixXd C = MatrixXd::Zero(rows, rows);
    add_compliance(frame.compliance[k], now.pulp_axes, frame.begin[k], 1.0, C);
    const MatrixXd C_k = C_o.block(first, first, rows, rows);
    const auto normals = Eigen::seqN(0, rows / 3, 3);
    EXPECT_TRUE(C_k(normals, normals).isApprox(C(normals, normals), 1e-12));
    for (Index i = 0; i < rows; i += 3) EXPECT_TRUE((C_k.block<3, 3>(i, i).isApprox(C.block<3, 3>(i, i), 1e-12)));
  }
}

// The same in a tick: of a pulp on a flat face each body takes half. The points of the curved pulp are farther from one
// another than their projections, by up to 6 % for the steepest pair (1 / cos of 20 degrees), 1 % for most.
TEST(SoftObject, EqualHalvesShareTheDisplacement) {
  const Scene rigid = pressed_thumb(1e-3, {-1.0, 0.0, 0.0}, 1.0);
  Loop loop(soft_press(rigid.fingertips->material));
  loop.run(0.1);
  loop.tick();
  double of_pulp = 0.0, of_object = 0.0;
  for (Index i = 0; i < loop.frame.size(); ++i) {
    const Vector3d f = loop.memory.f.segment<3>(3 * i);
    of_pulp += f.dot(loop.work.kinematics.E_F[i].transpose() * displacement(loop.state, loop.frame.contacts[i]));
    of_object += f.dot(loop.work.kinematics.u_object_m.col(i));
  }
  EXPECT_GT(of_pulp, 0.2e-3);
  EXPECT_NEAR(of_object / of_pulp, 1.0, 0.03);
}

// Hertz for two bodies, 1/E* = 1/E*_1 + 1/E*_2, at any ratio of their moduli. A pulp of this spacing presses within 4 %
// of it on a rigid plane, by where its control points lie.
TEST(SoftObject, PressesLikeHertzWithBothModuli) {
  for (const double ratio : {0.5, 1.0, 4.0}) {
    SCOPED_TRACE(ratio);
    const double E_f = 0.24e6;
    Scene scene = soft_press({ratio * E_f, 0.5, 5e-3});
    scene.contact.friction = 0.0;
    Loop loop(std::move(scene));
    loop.run(0.2);
    const Fingertip& tip = loop.model.scene.hand.fingertips[0];
    const Vector3d centre_O =
        loop.state.X_WO.inverse() * (loop.work.pose.distal(loop.model.scene.hand, 0) * tip.centre_m);
    const double depth_m = tip.radius_m - (-10e-3 - centre_O.x());
    const double modulus = E_f * ratio / (1.0 + ratio);
    const double force_N = 4.0 / 3.0 * modulus * std::sqrt(tip.radius_m) * std::pow(depth_m, 1.5);
    EXPECT_NEAR(loop.state.load[0].normal_N / force_N, 1.0, 0.05);
  }
}

// A stiff object is a rigid one: a millionth of the give, and 1e-4 leaves room for what friction makes of that. The
// solver's tolerance is below both.
TEST(SoftObject, OfGreatStiffnessIsRigid) {
  const auto grasp = [](bool soft) {
    Scene scene = soft_grasp();
    scene.contact.tolerance = 1e-10;
    scene.contact.max_sweeps = 10'000;
    scene.object.compliance.reset();
    if (soft) scene.object.compliance = PulpMaterial{1e6 * 0.24e6, 0.5, 5e-3};
    Loop loop(std::move(scene));
    loop.run(0.1);
    return loop.state;
  };
  const State rigid = grasp(false), stiff = grasp(true);
  for (int k = 0; k < kFingers; ++k) {
    EXPECT_LE((stiff.u_m[k] - rigid.u_m[k]).norm(), 1e-4 * rigid.u_m[k].norm());
    EXPECT_LE((stiff.load[k].force_N - rigid.load[k].force_N).norm(), 1e-4 * rigid.load[k].force_N.norm());
  }
}

// The object's own Kelvin-Voigt law: under a constant force it gives way by C f (1 - exp(-t / tau)), exactly at every
// step. One contact without friction on an elastic pulp, and a box so easy to move that its drag takes nothing.
TEST(SoftObject, CreepsExponentially) {
  constexpr double kForce_N = 0.05, kTau_s = 20e-3, kModulus_Pa = 0.5e6;
  for (const double step_s : {0.1e-3, 1e-3, 10e-3}) {
    SCOPED_TRACE(step_s);
    Scene scene = pressed_thumb(0.0, {-kForce_N, 0.0, 0.0}, 1e-10);
    scene.step_s = step_s;
    scene.control_period_s = 1.0;  // one frame
    scene.contact.max_per_finger = 1;
    scene.contact.friction = 0.0;
    scene.contact.tolerance = 1e-14;
    scene.fingertips->material.relaxation_s = 0.0;
    scene.object.compliance = PulpMaterial{kModulus_Pa, 0.5, kTau_s};
    Loop loop(std::move(scene));
    for (int tick = 1; tick <= std::lround(3.0 * kTau_s / step_s); ++tick) {
      loop.tick();
      ASSERT_EQ(loop.frame.begin[1], 1);  // of the thumb
      const FrameContact& contact = loop.frame.contacts[0];
      const double area_m2 = loop.model.pulps[0].area_m2[contact.control_point];
      const double full_m = kForce_N * half_space_kernel(*loop.model.scene.object.compliance, 0.0, area_m2, area_m2);
      const double u_m = contact.n_O.dot(object_displacement(loop.model, loop.state, contact));
      EXPECT_NEAR(u_m / full_m, 1.0 - std::exp(-tick * step_s / kTau_s), 1e-9);
    }
  }
}

// What the solver took a step to do to the gaps is what the next tick finds: W, the memory of both bodies and the
// geometry agree in sign and size. Nothing turns here, so that only rounding is left of gaps of a millimetre.
TEST(SoftObject, GapsAreThoseThatTheSolverLeft) {
  Scene scene = soft_press({0.3e6, 0.4, 5e-3});
  scene.control_period_s = 1.0;
  scene.contact.friction = 0.3;
  scene.task.push = Push{{0.0, 0.2, 0.1}, 0.0, 1.0};
  Loop loop(std::move(scene));
  ContactKinematics after(loop.model);
  for (int tick = 0; tick < 30; ++tick) {
    loop.tick();
    HandPose pose;
    forward_kinematics(loop.model.scene.hand, loop.state.q, pose);
    contact_kinematics(loop.model, loop.frame, pose, loop.state, after);
    for (Index i = 0; i < loop.frame.size(); ++i) EXPECT_NEAR(after.gap_m[i], loop.work.delta[3 * i], 1e-12);
  }
}

// C_o is a mixture of Gaussians times a Gram matrix, as a pulp's; so W, with any contacts on any fingers.
TEST(SoftObject, ComplianceIsSymmetricPositiveDefinite) {
  const Model model = build_model(soft_grasp());
  for (unsigned seed = 0; seed < 5; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    Frame frame = random_frame(model, random);
    frame.contacts[3].s_O = frame.contacts[40].s_O;  // two fingers at one place
    fill_kernels(model, frame);
    const ContactKinematics now = kinematics_of(model, frame);
    MatrixXd C = object_compliance(model, frame, now);
    EXPECT_LE((C - C.transpose()).norm(), 1e-15 * C.norm());  // rounding
    const auto least = [](const MatrixXd& A) { return eigenvalues(A)[0] / A.diagonal().maxCoeff(); };
    EXPECT_GE(least(C), -1e-14);
    for (int k = 0; k < kFingers; ++k) {
      const Index first = 3 * frame.begin[k], rows = 3 * frame.begin[k + 1] - first;
      add_compliance(frame.compliance[k], now.pulp_axes, frame.begin[k], 1.0, C.block(first, first, rows, rows));
    }
    EXPECT_GE(least(C), 1e-3);
  }
}

// What the frame's kernel says of all contacts at once is what each contact is told by itself: of loads of its own
// contacts, and of those that are no more, which have a place of their own. Rounding of sums of up to 60.
TEST(SoftObject, DisplacementsAtOnceAreThoseOneByOne) {
  Loop loop(soft_grasp());
  Eigen::MatrixX3d u_O = Eigen::MatrixX3d::Zero(loop.model.max_contacts, 3);
  for (int tick = 0; tick < 40; ++tick) {
    loop.tick();
    State state = loop.state;
    for (std::size_t i = 0; i < state.object_loads.size(); i += 3) state.object_loads[i].control_point += 1000;
    std::sort(state.object_loads.begin(), state.object_loads.end(), [](const ObjectLoad& a, const ObjectLoad& b) {
      return std::tie(a.finger, a.control_point) < std::tie(b.finger, b.control_point);
    });
    ASSERT_GE(state.object_loads.size(), 10U);
    object_displacements(loop.model, loop.frame, state, u_O);
    for (Index i = 0; i < loop.frame.size(); ++i) {
      const Vector3d alone = object_displacement(loop.model, state, loop.frame.contacts[i]);
      EXPECT_LE((u_O.row(i).transpose() - alone).norm(), 1e-14 * alone.norm());
    }
  }
}

// Action = reaction, and the bodies move by their drive and these forces alone: compliance adds no force. Rounding of
// sums over 60 contacts.
TEST(SoftObject, MovesTheBodiesByTheForcesAlone) {
  Loop loop(soft_grasp());
  const Scene& scene = loop.model.scene;
  for (int tick = 0; tick < 50; ++tick) {
    const State before = loop.state;
    loop.tick();
    Vector6d wrench = loop.frame.wrench;
    JointVector torque = loop.frame.torque_Nm;
    HandPose pose;
    forward_kinematics(scene.hand, before.q, pose);
    for (Index i = 0; i < loop.frame.size(); ++i) {
      const int k = loop.frame.contacts[i].finger;
      const Vector3d f = loop.work.kinematics.E_W[i] * loop.state.forces[i].f_C, c = loop.work.kinematics.c_W[i];
      wrench.head<3>() += f;
      wrench.tail<3>() += (c - before.X_WO.translation()).cross(f);
      torque.segment<kJointsPerFinger>(kJointsPerFinger * k) -= finger_jacobian(scene.hand, pose, k, c).transpose() * f;
    }
    EXPECT_LE((loop.state.q - before.q - scene.step_s / scene.joint_viscosity * torque).norm(), 1e-14);
    const Vector3d dp = scene.step_s / scene.object.translation_damping * wrench.head<3>();
    EXPECT_LE((loop.state.X_WO.translation() - before.X_WO.translation() - dp).norm(), 1e-14);
    const Eigen::AngleAxisd turn(loop.state.X_WO.linear() * before.X_WO.linear().transpose());
    const Vector3d dr = scene.step_s / scene.object.rotation_damping * wrench.tail<3>();
    EXPECT_LE((turn.angle() * turn.axis() - dr).norm(), 1e-13);
  }
}

// The published grasp with a box of rubber: carried like a rigid one, and contact takes energy.
TEST(SoftObject, IsHeldAndCarried) {
  Loop loop(soft_grasp());
  double injected_J = 0.0, dissipated_J = 0.0;
  while (loop.state.tick < 1500) {
    const TickReport report = loop.tick();
    ASSERT_LE(report.solve.residual, 1e-3);
    if (loop.state.tick < 100) continue;
    injected_J += report.ledger.injected_J;
    dissipated_J += report.ledger.dissipated_J;
    for (const FingerLoad& load : loop.state.load) ASSERT_GT(load.normal_N, 0.0);
  }
  EXPECT_LE((loop.state.X_WO.translation() - loop.model.target(1.5).translation()).norm(), 1e-3);
  EXPECT_LT(injected_J, dissipated_J);
}

TEST(SoftObject, DoesNotAllocateAfterTheFirstTick) {
  if (!AllocationCounter::is_available()) GTEST_SKIP() << "malloc is not ours to count";
  Loop loop(soft_grasp());
  loop.tick();
  std::int64_t allocations = 0;
  while (loop.state.tick < 100) {
    loop.control();
    const AllocationCounter counter;
    contact_tick(loop.model, loop.frame, loop.memory, loop.work, loop.state);
    allocations += counter.count();
  }
  EXPECT_EQ(allocations, 0);
}

// However contacts come and go, there is room: the least loads are forgotten first, and all in the end.
TEST(SoftObject, ForgetsTheLeastLoads) {
  const Model model = build_model(soft_grasp());
  State state(model);
  ContactKinematics now(model);
  std::mt19937_64 random(5);
  Frame frame = random_frame(model, random);
  now.object_tensors = Eigen::Matrix3d::Identity().replicate(model.max_contacts, 1);
  VectorXd f = VectorXd::Zero(3 * model.max_contacts);
  const auto capacity = kLoadsPerContact * model.max_contacts;
  for (int round = 0; round < 10; ++round) {
    for (Index i = 0; i < frame.size(); ++i) {
      frame.contacts[i].control_point += 1;
      f[3 * i] = 1.0 + static_cast<double>(round);
    }
    remember_loads(model, frame, now.object_tensors, f, state);
    EXPECT_LE(std::ssize(state.object_loads), capacity);
    for (const FrameContact& contact : frame.contacts) {
      EXPECT_TRUE(std::any_of(state.object_loads.begin(), state.object_loads.end(), [&](const ObjectLoad& load) {
        return load.finger == contact.finger && load.control_point == contact.control_point;
      }));
    }
  }
  f.setZero();
  // 10 N fall to 1e-8 N in 21 tau.
  for (int tick = 0; tick < 21 * 5 + 1; ++tick) remember_loads(model, frame, now.object_tensors, f, state);
  EXPECT_TRUE(state.object_loads.empty());
}

std::string error_of(const std::vector<std::string>& overrides, const std::string& scene = "box_grasp") {
  try {
    (void)scene_of(scene, overrides);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(SoftObject, SceneErrorsNameTheKey) {
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  const std::string all = error_of({"object.compliance={reduced_modulus: -1 MPa, poisson: 0.7, stiffness: 3}"});
  EXPECT_TRUE(has(all, "object.compliance.reduced_modulus: -1 MPa must be at least 1 kPa")) << all;
  EXPECT_TRUE(has(all, "object.compliance.poisson")) << all;
  EXPECT_TRUE(has(all, "object.compliance.relaxation: this key is missing")) << all;
  EXPECT_TRUE(has(all, "object.compliance.stiffness")) << all;
  const std::string rigid =
      error_of({"object.compliance={reduced_modulus: 1 MPa, poisson: 0.5, relaxation: 5 ms}"}, "minimal");
  EXPECT_TRUE(has(rigid, "object.compliance: needs fingertips")) << rigid;
  EXPECT_FALSE(scene_of("box_grasp").object.compliance.has_value());
}

// A ball dragged along the thumb: at every new frame its loads go to where the contacts are then, or the gaps that the
// frame brings would be another surface's, and contact would give energy.
TEST(SoftObject, LoadsGoAlongWithASlidingContact) {
  Loop loop(scene_of("slide", {"object.compliance={reduced_modulus: 0.24 MPa, poisson: 0.5, relaxation: 5 ms}"}));
  double injected_J = 0.0, dissipated_J = 0.0;
  while (loop.state.tick < 600) {
    const TickReport report = loop.tick();
    injected_J += report.ledger.injected_J;
    dissipated_J += report.ledger.dissipated_J;
  }
  EXPECT_GT(dissipated_J, 1e-4);
  EXPECT_LT(injected_J, 0.01 * dissipated_J);
}

// What a run leaves in a problem file is what it solved: its forces keep the law with the file's W.
TEST(SoftObject, DumpsTheProblemThatItSolves) {
  Loop loop(soft_grasp());
  loop.run(0.02);
  const ContactFile problem = contact_problem_file(loop.model, loop.frame, loop.work);
  const Index rows = problem.W.rows();
  ASSERT_GT(rows, 0);
  const VectorXd delta = problem.W * loop.memory.f.head(rows) + problem.delta_free[0];
  EXPECT_LE((delta - loop.work.delta.head(rows)).norm(), 1e-9 * problem.delta_free[0].norm());
}

}  // namespace
}  // namespace thenar::object_compliance_test
