// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "engine/stiffness/object_stiffness.h"
#include "engine/stiffness/stiffness_range.h"

namespace thenar {

struct ProbeSettings {
  /// Force and moment of a probe: no contact may reach its cone by them that it did not reach before.
  double force_N = 1e-4, moment_Nm = 1e-6;
  double rest = 2e-4;    ///< Remaining share of its motion at which it counts as at rest.
  double most_s = 10.0;  ///< Longest wait.
  double law_s = 0.1;    ///< Wait if the law continues: eventually integrals undo all motion.
  /// Share of the scene's viscosities of joints and object in probes with constant excitations: they do not affect the
  /// rest state, only the wait.
  double viscosity = 0.02;
  int threads = 2;
};

/// The response of the object to forces and moments in all directions.
struct MeasuredStiffness {
  Matrix6d C_O;           ///< Compliance: object's motion for a wrench, both about its origin, its axes.
  Matrix6d K_O;           ///< Its inverse.
  double waited_s = 0.0;  ///< Wait for the slowest probe.
  double moving = 0.0;    ///< Largest remaining share of a probe's motion.
  double drift_m = 0.0;   ///< Displacement of the object meanwhile without a probe, rotations at an arm of 20 mm.
  bool is_finite = true;  ///< True if no contact solve failed.
};

/// How a grasp with constant excitations came to rest.
struct Rest {
  bool reached = false;  ///< False: it was unstable, or still moved after the longest wait.
  double moved_m = 0.0;  ///< The object's displacement until then, rotations at an arm of 20 mm.
  double changed = 0.0;  ///< How far this has changed the predicted compliances: compliance_error().
};

/// Lets a grasp with constant excitations come to rest: the law that has acted before leaves it on its way, along which
/// contacts and the muscles' lengths change. The run's time goes on.
Rest let_rest(GraspAt& grasp, const ProbeSettings& settings);

/// Measures the stiffness by probes: half of the difference between two runs with opposite pushes, each until it rests,
/// so that the run's own motion cancels. Nothing with constant excitations and an unstable mode, as there is no rest.
[[nodiscard]] std::optional<MeasuredStiffness> probe_stiffness(const GraspAt& grasp,
                                                               const PredictedStiffness& predicted,
                                                               const ProbeSettings& settings);

/// Measures the rate at which a mode decays or, negative, grows, after a small push: over 1/rate, or `most_s`.
[[nodiscard]] double measure_rate(const GraspAt& grasp, const GraspMode& mode, const ProbeSettings& settings);

/// The results of a study of a grasp's stiffness.
struct StiffnessStudy {
  double at_s = 0.0;
  Acting acting = Acting::kMuscles;
  PredictedStiffness predicted;  ///< At rest, if that is set; else at the time.
  std::optional<Rest> rest;      ///< Set if it was probed with constant excitations.
  std::optional<MeasuredStiffness> measured;
  std::optional<double> slowest_per_s;  ///< Measured rate of the slowest mode, with constant excitations.
  std::optional<StiffnessRange> range;  ///< Set if all fingers bear load.
};

/// Studies the stiffness of a grasp. Without settings it is not probed, and a grasp without contacts never is.
[[nodiscard]] StiffnessStudy study_stiffness(const Model& model, double at_s, Acting acting,
                                             const std::optional<ProbeSettings>& settings);

}  // namespace thenar
