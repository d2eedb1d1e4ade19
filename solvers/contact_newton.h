#pragma once

#include <Eigen/Core>

#include "solvers/gauss_seidel.h"

namespace thenar {

/// When the accurate contact solve stops.
struct AccurateSettings {
  double tolerance = 1e-8;  ///< Stop at this natural-map residual [no unit]; see residual.h.
  int max_sweeps = 300;     ///< Of the Gauss-Seidel that goes first.
  int max_steps = 400;      ///< Newton steps of all stages together: bounds the time of one call.
};

/// Memory of accurate contact solves for up to `contacts` contacts; taken once.
class AccurateWorkspace;

/// What one accurate solve returns by value.
struct AccurateReport {
  SolveReport solve;  ///< As of Gauss-Seidel; `sweeps` counts those.
  int steps = 0;      ///< Newton steps; 0 where Gauss-Seidel was enough.
};

}  // namespace thenar
