// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <numbers>
#include <utility>

#include "bench/cases/pads.h"
#include "bench/cases/scene_run.h"

namespace thenar {

/// What the patches of a run did: rows slip [m] and spin [rad], summed over its ticks, margin and moment about the
/// normal [N m] at its end; a column a finger.
using PatchValues = Eigen::Matrix<double, 4, Eigen::Dynamic, 0, 4, kMaxFingers>;

PatchValues patch_values(Scene scene, double duration_s);

/// How far values are from a reference, over its size: a row each.
[[nodiscard]] Eigen::Vector4d relative_errors(const PatchValues& values, const PatchValues& reference);

/// A ball between three pads, which a spring moves up by 0.6 mm and turns by 4 degrees: parts of the patches stick, and
/// others slide. All is smooth in time.
Scene turned_ball();

/// The scene with so many control points a fingertip, and room for all that may touch.
Scene with_controls(Scene scene, Eigen::Index controls);

}  // namespace thenar
