// SPDX-License-Identifier: Apache-2.0
#include "bench/peers/peers.h"

#include <BulletDynamics/MLCPSolvers/btLemkeAlgorithm.h>
#include <BulletDynamics/MLCPSolvers/btSolveProjectedGaussSeidel.h>
#include <dart/external/odelcpsolver/lcp.h>
#include <siconos/numerics/FrictionContactProblem.h>
#include <siconos/numerics/Friction_cst.h>
#include <siconos/numerics/LCP_Solvers.h>
#include <siconos/numerics/LinearComplementarityProblem.h>
#include <siconos/numerics/NonSmoothDrivers.h>
#include <siconos/numerics/NumericsMatrix.h>
#include <siconos/numerics/SolverOptions.h>
#include <siconos/numerics/lcp_cst.h>

#include <cstdlib>
#include <limits>
#include <memory>

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

using OptionsPtr = std::shared_ptr<SolverOptions>;

OptionsPtr make_options(int solver) { return {solver_options_create(solver), solver_options_delete}; }

/// A Siconos matrix that refers to the entries of M.
std::shared_ptr<NumericsMatrix> matrix_of(MatrixXd& M) {
  NumericsMatrix* const matrix =
      NM_create_from_data(NM_DENSE, static_cast<int>(M.rows()), static_cast<int>(M.cols()), M.data());
  return {matrix, [](NumericsMatrix* m) {
            m->matrix0 = nullptr;  // Not its own.
            NM_clear(m);
            std::free(m);
          }};
}

ContactSolver siconos(int solver, const ContactProblem& problem) {
  struct Data {
    ContactData copy;
    VectorXd u;
    std::shared_ptr<NumericsMatrix> matrix;
    FrictionContactProblem problem;
    OptionsPtr options;
  };
  const Index rows = problem.delta_free.size();
  auto data = std::make_shared<Data>(
      Data{{problem.W, problem.delta_free, problem.mu}, VectorXd::Zero(rows), nullptr, {}, nullptr});
  ContactData& copy = data->copy;
  data->matrix = matrix_of(copy.W);
  data->problem = {3, static_cast<int>(copy.contacts()), data->matrix.get(), copy.delta_free.data(), copy.mu.data()};
  data->options = make_options(solver);
  if (solver == SICONOS_FRICTION_3D_NSGS) {
    // Its cheapest measure of the error: what a sweep changed.
    data->options->iparam[SICONOS_FRICTION_3D_IPARAM_ERROR_EVALUATION] =
        SICONOS_FRICTION_3D_NSGS_ERROR_EVALUATION_LIGHT;
  }
  return [data](double tolerance, int budget, VectorXd& f) {
    data->options->iparam[SICONOS_IPARAM_MAX_ITER] = budget;
    data->options->dparam[SICONOS_DPARAM_TOL] = tolerance;
    data->u.setZero();
    fc3d_driver(&data->problem, f.data(), data->u.data(), data->options.get());
  };
}

/// A contact's rows stay in their order (n, t1, t2); a tangential force's limits are mu times that of row 3i.
struct Box {
  VectorXd low, high;
  std::vector<int> normal_row;
};

Box pyramid(const VectorXd& mu) {
  const Index rows = 3 * mu.size();
  Box box{VectorXd::Zero(rows), VectorXd::Constant(rows, std::numeric_limits<double>::infinity()),
          std::vector<int>(static_cast<std::size_t>(rows), -1)};
  for (Index i = 0; i < mu.size(); ++i) {
    for (const Index row : {3 * i + 1, 3 * i + 2}) {
      box.low[row] = -mu[i];
      box.high[row] = mu[i];
      box.normal_row[static_cast<std::size_t>(row)] = static_cast<int>(3 * i);
    }
  }
  return box;
}

btMatrixXu bullet_matrix(const Eigen::Ref<const MatrixXd>& M) {
  btMatrixXu copy(static_cast<int>(M.rows()), static_cast<int>(M.cols()));
  for (int i = 0; i < M.rows(); ++i) {
    for (int j = 0; j < M.cols(); ++j) copy.setElem(i, j, M(i, j));
  }
  return copy;
}

btVectorXu bullet_vector(const VectorXd& v) {
  btVectorXu copy(static_cast<int>(v.size()));
  for (int i = 0; i < v.size(); ++i) copy[i] = v[i];
  return copy;
}

ContactSolver bullet_pgs(const ContactProblem& problem) {
  struct Data {
    btMatrixXu W;
    btVectorXu b, f, low, high;
    btAlignedObjectArray<int> normal_row;
    btSolveProjectedGaussSeidel solver;
  };
  const Box box = pyramid(problem.mu);
  auto data = std::make_shared<Data>(Data{bullet_matrix(problem.W),
                                          bullet_vector(-problem.delta_free),
                                          btVectorXu(static_cast<int>(problem.delta_free.size())),
                                          bullet_vector(box.low),
                                          bullet_vector(box.high),
                                          {},
                                          {}});
  for (const int row : box.normal_row) data->normal_row.push_back(row);
  return [data](double tolerance, int budget, VectorXd& f) {
    data->solver.m_leastSquaresResidualThreshold = tolerance * tolerance;
    for (int i = 0; i < f.size(); ++i) data->f[i] = f[i];
    data->solver.solveMLCP(data->W, data->b, data->f, data->low, data->high, data->normal_row, budget, false);
    for (int i = 0; i < f.size(); ++i) f[i] = data->f[i];
  };
}

/// ODE's Dantzig on w = A x - b. It overwrites all that it is given. Rows of A are padded to four.
struct Dantzig {
  Dantzig(const MatrixXd& A_in, const VectorXd& b_in, Box box_in)
      : size(static_cast<int>(b_in.size())),
        A(MatrixXd::Zero(((size + 3) / 4) * 4, size)),
        b(b_in),
        box(std::move(box_in)) {
    A.topRows(size) = A_in.transpose();
  }

  bool solve(VectorXd& x) {
    A_work = A;
    b_work = b;
    work = box;
    w.resize(size);
    return dart::external::ode::dSolveLCP(size, A_work.data(), x.data(), b_work.data(), w.data(), 0, work.low.data(),
                                          work.high.data(), work.normal_row.data(), true);
  }

  int size;
  MatrixXd A;
  VectorXd b;
  Box box;
  MatrixXd A_work;
  VectorXd b_work, w;
  Box work;
};

ContactSolver ode_dantzig(const ContactProblem& problem) {
  auto data = std::make_shared<Dantzig>(problem.W, -problem.delta_free, pyramid(problem.mu));
  return [data](double, int, VectorXd& f) { data->solve(f); };
}

LcpSolver ode_dantzig_lcp(const LcpProblem& problem) {
  const Index n = problem.q.size();
  Box positive{VectorXd::Zero(n), VectorXd::Constant(n, std::numeric_limits<double>::infinity()),
               std::vector<int>(static_cast<std::size_t>(n), -1)};
  auto data = std::make_shared<Dantzig>(problem.M, -problem.q, std::move(positive));
  return [data](VectorXd& z) { return data->solve(z); };
}

LcpSolver siconos_lexicolemke(const LcpProblem& problem) {
  struct Data {
    LcpData copy;
    VectorXd w;
    std::shared_ptr<NumericsMatrix> matrix;
    LinearComplementarityProblem problem;
    OptionsPtr options;
  };
  const Index n = problem.q.size();
  auto data = std::make_shared<Data>(Data{{problem.M, problem.q}, VectorXd::Zero(n), nullptr, {}, nullptr});
  data->matrix = matrix_of(data->copy.M);
  data->problem = {static_cast<int>(n), data->matrix.get(), data->copy.q.data()};
  data->options = make_options(SICONOS_LCP_LEMKE);
  return [data](VectorXd& z) {
    int info = -1;
    lcp_lexicolemke(&data->problem, z.data(), data->w.data(), &info, data->options.get());
    return info == 0;
  };
}

LcpSolver bullet_lemke(const LcpProblem& problem) {
  auto lemke = std::make_shared<btLemkeAlgorithm>(bullet_matrix(problem.M), bullet_vector(problem.q));
  return [lemke](VectorXd& z) {
    const btVectorXu found = lemke->solve();
    // First w, then z.
    for (int i = 0; i < z.size(); ++i) z[i] = found[static_cast<int>(z.size()) + i];
    return lemke->getInfo() == 0;
  };
}

}  // namespace

std::vector<ContactMethod> contact_peers() {
  using namespace std::placeholders;
  return {{"siconos_nsgs", ContactMethod::kOwnMeasure, std::bind(siconos, SICONOS_FRICTION_3D_NSGS, _1)},
          {"siconos_nsn", ContactMethod::kOwnMeasure, std::bind(siconos, SICONOS_FRICTION_3D_NSN_AC, _1)},
          {"bullet_pgs", ContactMethod::kOtherLaw, bullet_pgs},
          {"ode_dantzig", ContactMethod::kOtherLaw, ode_dantzig}};
}

std::vector<LcpMethod> lcp_peers() {
  return {
      {"siconos_lexicolemke", siconos_lexicolemke}, {"bullet_lemke", bullet_lemke}, {"ode_dantzig", ode_dantzig_lcp}};
}

}  // namespace thenar
