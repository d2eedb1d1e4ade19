// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/compliance.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/grasp/moving_grasp.h"
#include "tests/support/scenes.h"
#include "tests/support/three_fingers.h"

namespace thenar::compliance_test {
namespace {

using namespace moving_grasp;

using Eigen::Index;
using Eigen::Vector3d;

// Kelvin-Voigt: under a constant force the pulp gives way by C f (1 - exp(-t / tau_r)), exactly at every step length.
// One contact without friction, on a box so easy to move (1e-10 N s/m) that its drag takes 1e-10 / (tau_r / C) of the
// force.
TEST(Memory, OneContactCreepsExponentially) {
  for (const double step_s : {0.1e-3, 1e-3, 10e-3}) {
    for (const double tau : {2e-3, 20e-3}) {
      SCOPED_TRACE(testing::Message() << "step " << step_s << ", tau_r " << tau);
      const double force_N = 0.05;
      Scene scene = pressed_thumb(0.0, {-force_N, 0.0, 0.0}, 1e-10);
      scene.step_s = step_s;
      scene.control_period_s = 1.0;  // one frame
      scene.contact.max_per_finger = 1;
      scene.contact.friction = 0.0;
      scene.contact.tolerance = 1e-14;
      scene.fingertips->material.relaxation_s = tau;
      Loop loop(std::move(scene));
      for (int tick = 1; tick <= std::lround(3.0 * tau / step_s) + 1; ++tick) {
        loop.tick();
        ASSERT_EQ(loop.frame.begin[1], 1);  // of the thumb
        const FrameContact& contact = loop.frame.contacts[0];
        const Pulp& pulp = loop.model.pulps[0];
        const double full_m = pulp.kernel(contact.control_point, contact.control_point) * force_N;
        const double u_m = contact.E_F.col(0).dot(loop.state.u_m[0].row(contact.control_point));
        EXPECT_NEAR(u_m / full_m, 1.0 - std::exp(-tick * step_s / tau), 1e-9);
      }
    }
  }
}

/// How far the box has moved along a tangent when the thumb has carried 1 N for 20 tau_r, after `time_s` under half the
/// tangential force that it can hold, tau_r = 20 ms.
double creep_m(double step_s, double time_s) {
  Scene scene = pressed_thumb(1e-3, {-1.0, 0.0, 0.0}, 0.1);
  scene.step_s = step_s;
  scene.control_period_s = step_s;
  scene.contact.friction = 0.8;
  scene.contact.tolerance = 1e-10;
  scene.contact.max_sweeps = 100'000;
  scene.fingertips->material.relaxation_s = 20e-3;
  scene.task.push = Push{{0.0, 0.4, 0.0}, 0.4, 10.0};  // half of mu F_n
  Loop loop(std::move(scene));
  loop.run(0.4);
  const Vector3d before = loop.state.X_WO.translation();
  loop.run(time_s);
  const Vector3d moved = loop.model.scene.object.X_WO.linear().transpose() * (loop.state.X_WO.translation() - before);
  return moved.y();
}

// Case T24: the exponential memory knows no step. What is left is the box's drag (0.1 N s/m against the pulp's 900 N/m:
// 0.1 ms of 20 ms, by implicit Euler), a part of 1e-3. Implicit Euler for the pulp would be 1 % off at 1 ms and 11 % at
// 10 ms.
TEST(Memory, CreepDoesNotDependOnTheStep) {
  const double fine_m = creep_m(0.1e-3, 20e-3);
  EXPECT_GT(fine_m, 100e-6);
  EXPECT_NEAR(creep_m(1e-3, 20e-3) / fine_m, 1.0, 1e-3);
  EXPECT_NEAR(creep_m(10e-3, 20e-3) / fine_m, 1.0, 1e-3);
}

// A contact that sticks under a constant load does not creep once the pulp has settled. The solver leaves 1e-12 of a
// free motion of 1 mm a tick, 5e-12 m in 5000 ticks if all of it points one way; 1e-9 m is a hundredth of a percent of
// the elastic give.
TEST(Memory, StickDoesNotDrift) {
  Scene scene = pressed_thumb(1e-3, {-1.0, 0.4, 0.0}, 1.0);
  scene.step_s = scene.control_period_s = 1e-3;
  scene.contact.tolerance = 1e-12;
  scene.contact.max_sweeps = 100'000;
  Loop loop(std::move(scene));
  loop.run(0.5);
  const Vector3d before = loop.state.X_WO.translation();
  loop.run(5.0);
  EXPECT_LE((loop.state.X_WO.translation() - before).norm(), 1e-9);
}

// The pulp moves by the compliance that the solver had where the tick has a contact; elsewhere by its mean over the
// directions across the normals of the forces, in single precision. Rounding of sums over 20 contacts: each force and
// entry is rounded once, each product and sum once, so that it is at most (20 + 3) half units of the sizes' sum.
TEST_F(MovingGrasp, PulpsDeformByOneCompliance) {
  for (int tick = 0; tick < 50; ++tick) {
    SCOPED_TRACE(tick);
    const State before = loop.state;
    loop.tick();
    const Frame& frame = loop.frame;
    const auto& E_F = loop.work.kinematics.E_F;
    for (int k = 0; k < kFingers; ++k) {
      const Pulp& pulp = model.pulps[k];
      const double rho = retained_share(pulp.material, model.scene.step_s);
      const Index begin = frame.begin[k], end = frame.begin[k + 1];
      Eigen::MatrixX3d u = rho * before.u_m[k], rounding_m = Eigen::MatrixX3d::Constant(pulp.controls(), 3, 1e-15);
      constexpr double kSingle = 23.0 * 0.5 * std::numeric_limits<float>::epsilon();
      for (Index c = 0; c < pulp.controls(); ++c) {
        const auto at_c = std::find_if(frame.contacts.begin() + begin, frame.contacts.begin() + end,
                                       [&](const FrameContact& contact) { return contact.control_point == c; });
        const Index i = at_c - frame.contacts.begin();
        for (Index j = begin; j < end; ++j) {
          const Index d = frame.contacts[j].control_point;
          const Vector3d f_C = loop.state.forces[j].f_C;
          const Vector3d mean = E_F[j] * Vector3d(1.0, pulp.tangential, pulp.tangential).cwiseProduct(f_C);
          const Vector3d moved =
              i < end ? Vector3d(E_F[i] * frame.compliance[k].entry(i - begin, j - begin, E_F[i], E_F[j]) * f_C)
                      : Vector3d(pulp.kernel(c, d) * mean);
          u.row(c) += (1.0 - rho) * moved.transpose();
          if (i == end) rounding_m.row(c) += (1.0 - rho) * kSingle * moved.transpose().cwiseAbs();
        }
      }
      EXPECT_LE(((loop.state.u_m[k] - u).cwiseAbs() - rounding_m).maxCoeff(), 0.0);
      EXPECT_LE(rounding_m.maxCoeff(), 1e-9);
    }
  }
}

}  // namespace
}  // namespace thenar::compliance_test
