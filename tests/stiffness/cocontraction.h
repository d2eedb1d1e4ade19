// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>

#include "engine/stiffness/object_stiffness.h"
#include "solvers/muscles/muscle_forces.h"
#include "solvers/muscles/stiff_muscles.h"
#include "tests/support/scenes.h"

namespace thenar {

/// A scene whose muscles have stiffness, with an object that is soon there.
inline Scene stiff_scene(const std::string& name, std::vector<std::string> changes = {}) {
  changes.insert(changes.begin(), {"control.muscles={stiffness: 23.4}", kCoarseBox});
  return scene_of(name, changes);
}

/// What all muscles do to the joints, their lengths counted.
inline Eigen::VectorXd acting_torques(const GraspRun& run) {
  const Hand& hand = run.model.scene.hand;
  const double gamma = *run.model.scene.control->muscles->short_range;
  Eigen::VectorXd tau = run.controller.H * run.controller.f_muscle;
  for (const Belly& belly : run.controller.bellies) {
    const Fingertip& tip = hand.fingertips[belly.finger];
    const auto arms = belly.arms_m.head(tip.joints);
    const double k = muscle_stiffness(hand.muscles[belly.muscle], gamma, run.controller.f_muscle[belly.muscle]);
    const JointVector stretch = run.state.q - run.controller.q_rest;
    tau.segment(tip.first_joint, tip.joints) -=
        k / belly.share * arms.dot(stretch.segment(tip.first_joint, tip.joints)) * arms;
  }
  return tau;
}

/// Frozen muscles get other forces, which drive the joints as those before did.
inline void set_muscles(GraspRun& run, const Eigen::VectorXd& forces_N) {
  run.controller.f_muscle = forces_N;
  run.controller.q_rest = run.state.q;
  run.control();
  run.contact();
}

/// Muscles get the least forces that hold the object at least so stiffly about its origin, and each finger's posture.
/// False: no forces do.
inline bool stiffen(GraspRun& run, double translation_N_per_m, double rotation_Nm_per_rad,
                    double posture_Nm_per_rad = 0.02) {
  const Model& model = run.model;
  const Hand& hand = model.scene.hand;
  const auto muscles = std::ssize(hand.muscles), joints = std::ssize(hand.joints);
  run.control();
  ContactKinematics now(model);
  contact_kinematics(model, run.frame, run.controller.pose, run.state, now);
  const std::vector<ContactPlace> places = places_of(now, run.frame.size());
  StiffnessWorkspace work(model);
  const ContactLoads loads{run.state.forces, places, model.friction(run.time_s())};
  const GraspStiffness grasp = grasp_stiffness(model, run.frame, run.controller.pose, loads, model.scene.gravity, work);
  StiffMuscleData data;
  data.H = run.controller.H;
  data.tau = acting_torques(run);
  data.limit.resize(muscles);
  data.fibre_per_m.resize(muscles);
  data.tendon_N_per_m.resize(muscles);
  for (Eigen::Index m = 0; m < muscles; ++m) {
    data.limit[m] = hand.muscles[m].max_force_N;
    data.fibre_per_m[m] = *model.scene.control->muscles->short_range / *hand.muscles[m].fibre_m;
    data.tendon_N_per_m[m] = hand.muscles[m].tendon_N_per_m;
  }
  data.A = 0.5 * (grasp.A + grasp.A.transpose());
  data.B.resize(6, joints);
  data.D = Eigen::MatrixXd::Zero(joints, joints);
  data.arm = Eigen::MatrixXd::Zero(joints, muscles);
  std::vector<Eigen::Index> first_pair;
  Eigen::Index pairs = 0;
  for (int k = 0; k < hand.fingers(); ++k) {
    const auto [first, n] = std::pair(hand.fingertips[k].first_joint, hand.fingertips[k].joints);
    data.joints.push_back(n);
    data.B.middleCols(first, n) = 0.5 * (grasp.B[k] + grasp.B_joints[k]);
    data.D.block(first, first, n, n) = 0.5 * (grasp.D[k] + grasp.D[k].transpose());
    first_pair.push_back(pairs);
    pairs += n * (n + 1) / 2;
  }
  data.turn = Eigen::MatrixXd::Zero(pairs, muscles);
  for (const Belly& belly : run.controller.bellies) {
    const Fingertip& tip = hand.fingertips[belly.finger];
    data.arm.col(belly.muscle).segment(tip.first_joint, tip.joints) =
        belly.arms_m.head(tip.joints) / std::sqrt(belly.share);
    Eigen::Index pair = first_pair[belly.finger];
    for (int i = 0; i < tip.joints; ++i) {
      for (int j = 0; j <= i; ++j) data.turn(pair++, belly.muscle) = belly.slopes_m(i, j);
    }
  }
  ObjectStiffness wanted;
  wanted.translation_N_per_m.setConstant(translation_N_per_m);
  wanted.rotation_Nm_per_rad.setConstant(rotation_Nm_per_rad);
  data.K_des = wanted_stiffness(wanted, run.state.X_WO);
  data.kappa = posture_Nm_per_rad;
  Eigen::VectorXd f = run.controller.f_muscle;
  if (solve_stiff_muscles(data, f).status != MuscleStatus::kOptimal) return false;
  set_muscles(run, f);
  return true;
}

/// Muscles pull against one another, each of some with up to so much. False: not without one that pushes.
inline bool cocontract(GraspRun& run, double most_N, std::mt19937_64& random) {
  Eigen::VectorXd f = run.controller.f_muscle, more(f.size());
  for (double& one : more) one = std::max(0.0, uniform(random, -most_N, most_N));
  run.control();
  const Eigen::VectorXd tau = acting_torques(run) - run.controller.H * more;
  if (solve_muscle_forces({run.controller.H, tau}, f).status != MuscleStatus::kOptimal) return false;
  set_muscles(run, f + more);
  return true;
}

}  // namespace thenar
