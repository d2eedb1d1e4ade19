// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "app/studies/solve_result.h"
#include "engine/formats/problem_file.h"
#include "engine/problems/timed_solves.h"

namespace thenar::app {

/// Return the results of `thenar solve` for muscle forces by a method, without and with an object stiffness.
[[nodiscard]] std::vector<SolveResult> solve(const MuscleFile& file, const std::string& method, double tolerance,
                                             const Repetition& repetition);
[[nodiscard]] std::vector<SolveResult> solve(const StiffMuscleFile& file, const std::string& method, double tolerance,
                                             const Repetition& repetition);

}  // namespace thenar::app
