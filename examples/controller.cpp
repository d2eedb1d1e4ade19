// SPDX-License-Identifier: Apache-2.0
// A controller of your own: the hand as a spring that keeps a box at its place. Pushed with F, it gives way by F / K.

#include <algorithm>
#include <cstdio>
#include <exception>

#include "engine/control/control_period.h"
#include "engine/control/control_tick.h"
#include "engine/grasp/contact_tick.h"
#include "engine/studies/load_model.h"
#include "solvers/grasp_forces.h"

constexpr double kStiffness_N_per_m = 300.0, kStiffness_Nm_per_rad = 0.5, kSqueeze_N = 1.5, kPush_N = 0.5;

/// Joint torques of one control period.
thenar::JointVector impedance(thenar::ControlPeriod& period) {
  const thenar::Model& model = period.model;
  const thenar::Hand& hand = model.scene.hand;
  // On the object: a spring to its target, and what bears its weight.
  thenar::Vector6d wrench = -model.weight(period.snapshot.X_WO);
  wrench.head<3>() += kStiffness_N_per_m * period.error().head<3>();
  wrench.tail<3>() += kStiffness_Nm_per_rad * period.error().tail<3>();
  // Forces of the fingers that squeeze and give that wrench: the least change does.
  Eigen::MatrixXd G(6, 3 * model.fingers());
  thenar::grasp_map(period.contacts(), period.snapshot.X_WO.translation(), G);
  Eigen::VectorXd f(3 * model.fingers());
  for (int k = 0; k < model.fingers(); ++k) f.segment<3>(3 * k) = kSqueeze_N * period.contacts()[k].axes.col(0);
  f += G.completeOrthogonalDecomposition().solve(wrench - G * f);
  // They pass through the joints, which bear the hand itself, too.
  thenar::JointVector torques = thenar::gravity_torques(hand, period.controller.pose, model.scene.gravity);
  for (int k = 0; k < model.fingers(); ++k) {
    const thenar::Fingertip& tip = hand.fingertips[k];
    torques.segment(tip.first_joint, tip.joints) +=
        period.jacobian(k).leftCols(tip.joints).transpose() * f.segment<3>(3 * k);
  }
  return torques;
}

int main(int argc, char** argv) try {
  const thenar::Model model = thenar::load_model(argc > 1 ? argv[1] : "configs/box_grasp.yaml",
                                                 {"time.control_period=5 ms", "control.muscles=false", "task={}"});
  thenar::State state(model);
  thenar::Frame frame(model);
  thenar::Controller controller(model);
  thenar::ContactMemory memory(model);
  thenar::ContactScratch work(model);
  controller.own.torques = impedance;

  const Eigen::Vector3d start = state.X_WO.translation(), aside = state.X_WO.linear().col(1);
  double gave_way_m = 0.0;
  for (int tick = 0; tick < 1500; ++tick) {
    if (model.control_is_due(tick)) thenar::control_tick(model, state, controller, frame);
    thenar::TickInput input;
    if (tick >= 500) input.wrench.head<3>() = kPush_N * aside;
    thenar::contact_tick(model, frame, memory, work, state, input);
    gave_way_m = std::max(gave_way_m, (state.X_WO.translation() - start).dot(aside));
  }
  std::printf("gave way by %.2f mm; F / K is %.2f mm\n", 1e3 * gave_way_m, 1e3 * kPush_N / kStiffness_N_per_m);
  return 0;
} catch (const std::exception& error) {  // also what a law throws
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
