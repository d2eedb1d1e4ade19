// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "engine/grasp/model.h"
#include "engine/results/recording.h"

namespace thenar {

// What others do in the place of our contact tick, in its textbook form: for maps of where methods fail.

enum class ContactLaw {
  /// A spring at each control point, without a solve: f_n = k_i times the depth of the rest shape at the start of the
  /// tick; a tangential spring k_i / c_t that slides where it exceeds mu f_n [Cundall, Strack 1979]. The k_i are a bed
  /// of springs that takes Hertz's force at the depth R/8: 4 E* A_i / (3 pi a), a = R / sqrt(8). Its damping is that
  /// of the bodies: a dashpot beside the spring, taken from the last tick's speed, only lowers the step at which it is
  /// stable. It has room for all control points that touch.
  kPenalty,
  /// Ours with the compliance and mobility of another step in W: `operator_step_s`.
  kWrongStep,
  /// Ours with |f_t1|, |f_t2| <= mu f_n, each row by itself, as engines of games have it.
  kBoxFriction,
  /// Ours by plain Gauss-Seidel sweeps over a dense W, not accelerated, as published.
  kPlainSweeps,
};

struct PlainContact {
  ContactLaw law = ContactLaw::kPenalty;
  double operator_step_s = 0.0;  ///< Of kWrongStep.
};

/// Runs a scene as run_scene does, with another law of contact. Requires deformable fingertips, a rigid object,
/// and no task.spring.
[[nodiscard]] Recording run_plain(const Model& model, const PlainContact& plain);

/// The penalty's springs are stable in explicit Euler below this step [s], by the viscosities of a scene: 2 /
/// lambda_max(J_c B^-1 J_c' K) of the contacts that are pressed at the end of the model's run with the penalty, in
/// steps of `step_s` over `duration_s`. NaN if none is.
[[nodiscard]] std::function<double(const Scene&)> penalty_step_limit(const Model& model, double step_s,
                                                                     double duration_s);

}  // namespace thenar
