#pragma once

#include <Eigen/Core>
#include <memory>

#include "engine/control/controller.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

namespace thenar {

/// What a control period found of a stiffness that its scene chooses, and the torques that it asked of the muscles.
struct StiffnessRecord {
  StiffnessReport report;
  JointVector torques_Nm;
};

/// What is known of it, period by period. Null: nothing yet.
struct KnownStiffness {
  std::shared_ptr<const StiffnessRecord> now;             ///< Of the last period,
  std::shared_ptr<const StiffnessRecord> chosen, lacked;  ///< of the last ones that had some, and that lacked some.
  double lacked_s = 0.0;                                  ///< When the last one lacked some.

  /// Nothing of a scene that chooses none.
  [[nodiscard]] static KnownStiffness of(const Scene& scene, const ControlReport& control);
  /// Takes that of a later period, and makes it whole by what was known.
  void add(double time_s, KnownStiffness& later);
};

/// A chosen stiffness for eyes, in the object's axes. NaN: not known.
struct ShownStiffness {
  explicit ShownStiffness(Eigen::Index muscles);

  double share, squeeze_N;                          ///< As StiffnessReport has them.
  Eigen::Matrix3d along_N_per_m, about_Nm_per_rad;  ///< Turns held, and moves of the point that the scene names.
  // What was lacking last of all that was asked for, along an axis or about one.
  double lack_s, lack_N_per_m, lack_Nm_per_rad;
  Eigen::Vector3d lack_axis;
  Eigen::VectorXd at_limit;  ///< 1 for each muscle that it takes at its limit, else 0.
  Eigen::VectorXd least_N;   ///< The least muscle forces for the same torques, whatever the stiffness.
};

/// `model` chooses a stiffness; `state` is of about the time of what is known.
[[nodiscard]] ShownStiffness shown_stiffness(const Model& model, const Snapshot& state, const KnownStiffness& known);

}  // namespace thenar
