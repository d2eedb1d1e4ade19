// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "solvers/contact_problem.h"
#include "solvers/lcp.h"

namespace thenar {

/// Solves one contact problem again and again: from the guess in f, for at most `budget` sweeps or steps, to
/// `tolerance` in the solver's own measure. What the solver needs beside f it has prepared before.
using ContactSolver = std::function<void(double tolerance, int budget, Eigen::VectorXd& f)>;

/// A contact solver by its name. What it prepares may refer to the problem's numbers.
struct ContactMethod {
  const char* name;
  enum {
    kNaturalMap,
    kOwnMeasure,
    kOtherLaw
  } stops_by;  ///< The residual of residual.h; another; or never to Coulomb's law.
  std::function<ContactSolver(const ContactProblem& problem)> prepare;
};

/// Solves one LCP again and again; true if the solver calls it solved.
using LcpSolver = std::function<bool(Eigen::VectorXd& z)>;

struct LcpMethod {
  const char* name;
  std::function<LcpSolver(const LcpProblem& problem)> prepare;
};

/// Solvers of other projects, from Debian's packages; none unless built with -DTHENAR_PEERS=ON.
///     siconos_nsgs       nonlinear Gauss-Seidel on the exact cone
///     siconos_nsn        Alart-Curnier Newton on the exact cone
///     bullet_pgs         projected Gauss-Seidel on a square of side 2 mu f_n: another law, it does not converge to
///                        Coulomb's
///     ode_dantzig        Dantzig's method (in the copy of DART) on the same square
[[nodiscard]] std::vector<ContactMethod> contact_peers();

///     siconos_lexicolemke, bullet_lemke    Lemke's method with lexicographic pivoting
///     ode_dantzig                          Dantzig's method (in the copy of DART)
[[nodiscard]] std::vector<LcpMethod> lcp_peers();

#ifndef THENAR_PEERS
inline std::vector<ContactMethod> contact_peers() { return {}; }
inline std::vector<LcpMethod> lcp_peers() { return {}; }
#endif

}  // namespace thenar
