#pragma once

#include <optional>

#include "engine/studies/object_stiffness.h"
#include "engine/studies/stiffness_range.h"

namespace thenar {

struct ProbeSettings {
  double force_N = 2e-3, moment_Nm = 2e-5;  ///< Of a probe.
  double rest = 1e-3;                       ///< It rests when so much of its motion is still to come.
  double most_s = 10.0;                     ///< It is not waited for longer.
  double law_s = 0.1;  ///< Where the law goes on, it is waited for so long: in the end integrals undo all motion.
  /// Share of the scene's viscosities of joints and object that probes have while excitations stay: what rests does not
  /// feel them, and they alone make it wait.
  double viscosity = 0.1;
  int threads = 2;
};

/// What pushes and turns of the object in all directions did to it.
struct MeasuredStiffness {
  Matrix6d C_O;           ///< Compliance: object's motion for a wrench, both about its origin, its axes.
  Matrix6d K_O;           ///< Its inverse.
  double waited_s = 0.0;  ///< Of the slowest probe.
  double moving = 0.0;    ///< The largest share of its motion that a probe had still to come.
  double drift_m = 0.0;   ///< How far the object went meanwhile without any push, a turn as the way at 20 mm.
  bool is_finite = true;  ///< No contact solve failed.
};

/// By probes: half of the difference between a run that is pushed and one that is pushed the other way, each until it
/// rests. What the run does by itself so cancels. Nothing if excitations stay and a mode goes away, for then it has no
/// rest.
[[nodiscard]] std::optional<MeasuredStiffness> probe_stiffness(const GraspAt& grasp,
                                                               const PredictedStiffness& predicted,
                                                               const ProbeSettings& settings);

/// How far two compliances are from one another: the largest entry of their difference, over the roots of the
/// predicted diagonals.
[[nodiscard]] double compliance_error(const Matrix6d& measured, const Matrix6d& predicted);

/// The rate at which a mode's amplitude falls, or, negative, grows, after a small push: over 1/rate, or `most_s`.
[[nodiscard]] double measure_rate(const GraspAt& grasp, const GraspMode& mode, const ProbeSettings& settings);

/// All that there is to say of a grasp's stiffness.
struct StiffnessStudy {
  double at_s = 0.0;
  Acting acting = Acting::kMuscles;
  PredictedStiffness predicted;
  std::optional<MeasuredStiffness> measured;
  std::optional<double> slowest_per_s;  ///< The rate of the slowest mode, measured, if excitations stay.
  std::optional<StiffnessRange> range;  ///< If all fingers bear load.
};

/// Without settings it is not probed, and a grasp without contacts never is.
[[nodiscard]] StiffnessStudy study_stiffness(const Model& model, double at_s, Acting acting,
                                             const std::optional<ProbeSettings>& settings);

}  // namespace thenar
