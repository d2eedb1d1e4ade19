// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>

#include "engine/control/controller.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

namespace thenar {

/// A control period's result for a chosen stiffness, and the torques that it commanded.
struct StiffnessRecord {
  StiffnessReport report;
  JointVector torques_Nm;
};

/// The latest known results, period by period; null: none yet.
struct KnownStiffness {
  std::shared_ptr<const StiffnessRecord> now;             ///< Result of the last period.
  std::shared_ptr<const StiffnessRecord> chosen, lacked;  ///< The last ones with a choice, and with a lack.
  double lacked_s = 0.0;                                  ///< Time of the last lack.

  /// Returns the result of a control tick; null members if the scene chooses no stiffness.
  [[nodiscard]] static KnownStiffness of(const Scene& scene, const ControlReport& control);
  /// Takes the result of a later period, and completes it by the known ones.
  void add(double time_s, KnownStiffness& later);
};

/// A chosen stiffness for display, in the object's axes. NaN: not known.
struct ShownStiffness {
  explicit ShownStiffness(Eigen::Index muscles);

  double share, squeeze_N;                          ///< See StiffnessReport.
  Eigen::Matrix3d along_N_per_m, about_Nm_per_rad;  ///< With rotation and with the scene's point fixed.
  // The last lack of the full demand, along an axis or about one.
  double lack_s, lack_N_per_m, lack_Nm_per_rad;
  Eigen::Vector3d lack_axis;
  Eigen::VectorXd at_limit;  ///< 1 for each muscle at its limit, else 0.
  Eigen::VectorXd least_N;   ///< The least muscle forces for the same torques, for any stiffness.
};

/// Requires a model that chooses a stiffness; `state` is of about the time of `known`.
[[nodiscard]] ShownStiffness shown_stiffness(const Model& model, const Snapshot& state, const KnownStiffness& known);

}  // namespace thenar
