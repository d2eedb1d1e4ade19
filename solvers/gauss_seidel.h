// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "solvers/contact_problem.h"
#include "solvers/contact_sweeps.h"

namespace thenar {

/// Solves a contact problem by nonlinear Gauss-Seidel with the one-step local update [Duriez et al. 2004]; delta is
/// kept up to date by increments, and a contact whose force did not change costs nothing.
///
/// problem   Checked for kNotFinite are the diagonals and first columns of the blocks W_ii. A NaN elsewhere is detected
///           only where its column's contact has a force. Symmetry to a few digits suffices, for only W's columns are
///           read. A closed contact that no force opens is reported as kNoSolution if the others' forces are found.
/// residual  Belongs to the forces and gaps returned. Without contacts or free motion: f = 0, converged.
/// Cost      9n^2 multiply-adds a sweep. Does not allocate, lock or throw.
///
/// It need not converge: it stalls on opposed walls, interference fits and viscosity ratios of 1e3 and more. The
/// residual tells.
[[nodiscard]] SolveReport solve_contacts(const ContactProblem& problem, const GaussSeidelSettings& settings,
                                         ContactSolution solution) noexcept;

/// Solves a contact problem with a workspace, 1.3 (15 contacts) to 2.5 times (60) as fast and with fewer stalls, by
/// accelerated sweeps in single precision on gaps that are recomputed in double precision often enough; see
/// contact_sweeps.h. The result is as accurate.
///
/// problem   Plain sweeps are used where W is outside of 1e-20 .. 1e20 m/N, where the largest |delta_free| [m], the
///           residual's scale [N] (see residual.h) is outside of 1e-15 .. 1e15 or the first guess beyond 1e15 N.
[[nodiscard]] SolveReport solve_contacts(const ContactProblem& problem, const GaussSeidelSettings& settings,
                                         SweepWorkspace& work, ContactSolution solution) noexcept;

}  // namespace thenar
