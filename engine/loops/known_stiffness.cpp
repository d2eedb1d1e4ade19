// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/known_stiffness.h"

#include <limits>
#include <span>

#include "engine/hand/muscles.h"

namespace thenar {

using Eigen::Index;

namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Returns the least forces; NaN if there are none.
Eigen::VectorXd least_forces(const Hand& hand, const JointVector& q, const JointVector& torques_Nm) {
  HandPose pose;
  forward_kinematics(hand, q, pose);
  const auto muscles = std::ssize(hand.muscles);
  Eigen::MatrixXd H(std::ssize(hand.joints), muscles);
  moment_arms(hand, pose, H);
  Eigen::VectorXd most_N(muscles), f = Eigen::VectorXd::Zero(muscles);
  for (Index m = 0; m < muscles; ++m) most_N[m] = hand.muscles[m].max_force_N;
  if (solve_muscle_forces({H, torques_Nm, most_N}, f).status != MuscleStatus::kOptimal) f.setConstant(kUnknown);
  return f;
}

}  // namespace

KnownStiffness KnownStiffness::of(const Scene& scene, const ControlReport& control) {
  if (!scene.chooses_stiffness()) return {};
  return {std::make_shared<const StiffnessRecord>(StiffnessRecord{control.stiffness, control.torques_desired_Nm}),
          nullptr, nullptr};
}

void KnownStiffness::add(double time_s, KnownStiffness& later) {
  if (later.now) {
    now = later.now;
    if (now->report.is_infeasible) {
      lacked = now;
      lacked_s = time_s;
    }
    if (now->report.share > 0.0) chosen = now;
  }
  later = *this;
}

ShownStiffness::ShownStiffness(Index muscles)
    : share(kUnknown), squeeze_N(kUnknown), lack_s(kUnknown), lack_N_per_m(kUnknown), lack_Nm_per_rad(kUnknown) {
  along_N_per_m.setConstant(kUnknown);
  about_Nm_per_rad.setConstant(kUnknown);
  lack_axis.setConstant(kUnknown);
  at_limit.setConstant(muscles, kUnknown);
  least_N.setConstant(muscles, kUnknown);
}

ShownStiffness shown_stiffness(const Model& model, const Snapshot& state, const KnownStiffness& known) {
  const Hand& hand = model.scene.hand;
  ShownStiffness shown(std::ssize(hand.muscles));
  if (known.now && known.now->report.is_chosen) {
    shown.share = known.now->report.share;
    shown.squeeze_N = known.now->report.squeeze_N;
    shown.least_N = least_forces(hand, state.q, known.now->torques_Nm);
  }
  if (known.chosen) {
    shown.along_N_per_m = known.chosen->report.K_O.topLeftCorner<3, 3>();
    shown.about_Nm_per_rad = known.chosen->report.K_O.bottomRightCorner<3, 3>();
  }
  if (known.lacked) {
    const StiffnessReport& lacked = known.lacked->report;
    shown.lack_s = known.lacked_s;
    if (lacked.axis_O) {
      shown.lack_axis = *lacked.axis_O;
      (lacked.rotates ? shown.lack_Nm_per_rad : shown.lack_N_per_m) = lacked.lacking;
    }
    for (Index m = 0; m < shown.at_limit.size(); ++m) {
      shown.at_limit[m] = static_cast<double>(lacked.at_limit >> m & 1);
    }
  }
  return shown;
}

}  // namespace thenar
