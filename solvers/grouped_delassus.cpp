// SPDX-License-Identifier: Apache-2.0
#include "solvers/grouped_delassus.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace thenar {
namespace {

using Eigen::Index;
using VectorRef = Eigen::Ref<const Eigen::VectorXd>;
using VectorOut = Eigen::Ref<Eigen::VectorXd>;

constexpr Index kLanes = SweepWorkspace::kPadding;
constexpr int kFifth = GroupedDelassus::kOwn + 6;  // The sweeps' column of it: of the padding.
// Relative change of the ground's response at which it is linearised again; and the largest number of these.
constexpr float kOtherwise = 0.3F;
constexpr int kMostLinearisations = 12, kWholeLinearisations = 4;
constexpr float kHardly = 1e-3F;  // Change of Jacobians, relative to their largest entry, up to which blocks are kept.
using Lanes = Eigen::Array<float, kLanes, 1>;

/// Three columns of a block, kLanes rows of them: sums that stay in registers.
struct Columns {
  Lanes n = Lanes::Zero(), t1 = n, t2 = n;

  /// Adds rows c .. c + 2 of a matrix times its rows from r on, of kCount of its columns from kFirst on.
  template <int kFirst, int kCount, typename Matrix>
  void add_products(const Matrix& A, Index c, Index r) {
#pragma GCC unroll 10
    for (int j = kFirst; j < kFirst + kCount; ++j) {
      const auto A_r = A.col(j).template segment<kLanes>(r).array();
      n += A(c, j) * A_r;
      t1 += A(c + 1, j) * A_r;
      t2 += A(c + 2, j) * A_r;
    }
  }
  template <typename Block>
  void store(Block& block, Index r, Index c) const {
    block.col(c).template segment<kLanes>(r) = n;
    block.col(c + 1).template segment<kLanes>(r) = t1;
    block.col(c + 2).template segment<kLanes>(r) = t2;
  }
};

/// Fills the three columns of contact j, c = 3 j, of J J' and, with a compliance, of s C.
template <bool kCompliant, typename Jacobian, typename Block>
void fill_columns(const Jacobian& J, const GroupedDelassus& W, Index k, const GroupedWorkspace& work, Index c,
                  Block& block) {
  const auto& E = work.axes;
  const float s = static_cast<float>(W.scale(k));
  const bool fifth = W.J_fifth.size() > 0;
  Eigen::Matrix3f E_j;  // s E_j', and s E_j' p_j
  Eigen::Vector3f p_j, s_j;
  if constexpr (kCompliant) {
    E_j = s * E.middleRows<3>(c);
    p_j = work.points.row(c);
    s_j = s * work.heights.segment<3>(c);
  }
  for (Index r = 0; r < block.rows(); r += kLanes) {
    Columns sums;
    if constexpr (kCompliant) {
      Lanes along = work.heights.segment<kLanes>(r).array();  // E_i' r_ij
      Lanes along_1 = Lanes::Constant(-s_j[1]), along_2 = Lanes::Constant(-s_j[2]);
#pragma GCC unroll 3
      for (int j = 0; j < 3; ++j) {
        const auto E_r = E.col(j).template segment<kLanes>(r).array();
        const auto p_r = work.points.col(j).template segment<kLanes>(r).array();
        sums.n += E_j(0, j) * E_r;
        sums.t1 += E_j(1, j) * E_r;
        sums.t2 += E_j(2, j) * E_r;
        along -= p_j[j] * E_r;
        along_1 += E_j(1, j) * p_r;
        along_2 += E_j(2, j) * p_r;
      }
      const SurfaceCompliance& C = W.compliance[k];
      const auto cross = C.cross_rows.col(c / 3).segment<kLanes>(r).array();
      along *= C.bent_rows.col(c / 3).segment<kLanes>(r).array();
      sums.n *= C.normal_rows.col(c / 3).segment<kLanes>(r).array();
      sums.t1 = cross * sums.t1 + along * along_1;
      sums.t2 = cross * sums.t2 + along * along_2;
    }
    sums.add_products<0, GroupedDelassus::kOwn + 6>(J, c, r);
    if (fifth) sums.add_products<kFifth, 1>(J, c, r);
    sums.store(block, r, c);
  }
}

/// Fills the three columns of contact j of group k, c = 3 j, at the rows of `group`: C_common, added to k's own rows,
/// and in other rows J_common J_common'.
template <typename Block>
void fill_shared(const SweepWorkspace::Group& own, const SweepWorkspace::Group& group, const GroupedWorkspace& work,
                 Index c, Block& block) {
  for (Index r = group.row; r < group.row + group.rows; r += kLanes) {
    Columns sums;
    sums.add_products<0, 3>(work.tensors, own.row + c, r);
    for (Lanes* column : {&sums.n, &sums.t1, &sums.t2}) *column *= work.shared_rows.segment<kLanes>(r).array();
    if (group.row == own.row) {
      sums.n += block.col(c).template segment<kLanes>(r).array();
      sums.t1 += block.col(c + 1).template segment<kLanes>(r).array();
      sums.t2 += block.col(c + 2).template segment<kLanes>(r).array();
    } else {
      sums.add_products<GroupedDelassus::kOwn, 6>(work.sweeps.J, own.row + c, r);
    }
    sums.store(block, r, c);
  }
}

/// Completes the block of group k, whole columns, by the effect of all contacts through the common body.
void fill_shared(const GroupedDelassus& W, Index k, GroupedWorkspace& work) {
  const std::vector<SweepWorkspace::Group>& groups = work.sweeps.groups;
  auto block = work.sweeps.block(groups[k]);
  for (Index j = groups[k].begin; j < groups[k].end; ++j) {
    for (const SweepWorkspace::Group& group : groups) {
      for (Index i = group.begin; i < group.end; ++i)
        work.shared_rows.segment<3>(group.row + 3 * (i - group.begin))
            .setConstant(static_cast<float>((*W.common_compliance.k)(i, j)));
    }
    for (const SweepWorkspace::Group& group : groups)
      fill_shared(groups[k], group, work, 3 * (j - groups[k].begin), block);
  }
}

/// Makes a group's block, J J' + s C.
template <typename Jacobian, typename Block>
void fill_block(const GroupedDelassus& W, Index k, const Jacobian& J, GroupedWorkspace& work, Block block) {
  const Index columns = block.cols(), padding = block.rows() - columns;
  if (W.compliance.empty()) {
    for (Index c = 0; c < columns; c += 3) fill_columns<false>(J, W, k, work, c, block);
    return;
  }
  if (columns == 0) return;
  const SurfaceCompliance& C = W.compliance[k];
  work.axes.topRows(columns) = W.axes.middleRows(3 * W.begin[k], columns).cast<float>();
  work.axes.middleRows(columns, padding).setZero();
  work.points.middleRows(columns, padding).setZero();
  work.heights.segment(columns, padding).setZero();
  for (Index i = 0; 3 * i < columns; ++i) {
    // From one of them: single precision has few digits for the frame's origin.
    const Eigen::RowVector3f p = (C.p_m.row(i) - C.p_m.row(0)).cast<float>();
    work.points.middleRows<3>(3 * i).rowwise() = p;
    work.heights.segment<3>(3 * i) = work.axes.middleRows<3>(3 * i) * p.transpose();
  }
  for (Index c = 0; c < columns; c += 3) fill_columns<true>(J, W, k, work, c, block);
}

/// Rows of J without those of the common body itself.
Index rows_of_groups(const GroupedDelassus& W, const GroupedWorkspace& grouped) {
  const bool body = std::ssize(grouped.sweeps.groups) > W.groups();
  return body ? grouped.sweeps.groups.back().row : grouped.J_then.rows();
}

/// Tests whether the blocks are still nearly W's. They only precondition: gaps are computed from W itself.
bool blocks_hold(const GroupedDelassus& W, const GroupedWorkspace& grouped) {
  if (W.edition < 0 || W.edition != grouped.edition || W.compliance_scale != grouped.compliance_scale) return false;
  const Index rows = rows_of_groups(W, grouped);
  if (rows == 0) return true;  // Without contacts there is no largest change.
  const auto change = (grouped.sweeps.J.topRows(rows) - grouped.J_then.topRows(rows)).cwiseAbs();
  return change.maxCoeff<Eigen::PropagateNaN>() <= kHardly * grouped.J_then_most;
}

/// Fills the Jacobians of the sweeps, which include the roots of the mobilities.
void fill_jacobians(const GroupedContactProblem& problem, GroupedWorkspace& grouped) {
  const GroupedDelassus& W = problem.W;
  SweepWorkspace& work = grouped.sweeps;
  constexpr int kOwn = GroupedDelassus::kOwn, kCommon = GroupedDelassus::kPadded;
  const float own_root = static_cast<float>(std::sqrt(W.own_mobility));
  const Eigen::Matrix<float, kCommon, 1> common_root = W.common_mobility.cwiseSqrt().cast<float>();
  const Eigen::Matrix<float, 6, 6> L = grouped.L.cast<float>();  // Meant where there is a ground.
  for (Index k = 0; k < W.groups(); ++k) {
    const SweepWorkspace::Group& group = work.groups[k];
    const Index first = 3 * group.begin, columns = 3 * (group.end - group.begin);
    auto J = work.J.middleRows(group.row, group.rows);
    J.topLeftCorner(columns, kOwn) = own_root * W.J_own.middleRows(first, columns).cast<float>();
    const auto J_common = W.J_common.middleRows(first, columns);
    if (problem.ground == nullptr) {
      J.topRightCorner(columns, kCommon) = J_common.cast<float>() * common_root.asDiagonal();
    } else {
      // Times L, which is upper triangular: columns from behind, in place.
      J.topRightCorner(columns, kCommon) = J_common.cast<float>();
      for (int j = 5; j >= 0; --j) {
        auto J_j = J.col(kOwn + j).head(columns);
        J_j *= L(j, j);
        for (int i = 0; i < j; ++i) J_j += L(i, j) * J.col(kOwn + i).head(columns);
      }
    }
    if (W.J_fifth.size() > 0) J.col(kFifth).head(columns) = own_root * W.J_fifth.segment(first, columns).cast<float>();
    J.bottomRows(group.rows - columns).setZero();
  }
  if (problem.ground != nullptr) {
    auto J = work.J.middleRows(work.groups.back().row, work.groups.back().rows);
    J.setZero();
    J.block<6, 6>(0, kOwn).setIdentity();
  }
}

/// Makes the sweeps' problem: a group's block is J J' + s C.
void fill(const GroupedContactProblem& problem, GroupedWorkspace& grouped) {
  const GroupedDelassus& W = problem.W;
  SweepWorkspace& work = grouped.sweeps;
  const SharedCompliance& shared = W.common_compliance;
  work.lay_out(W.begin, static_cast<bool>(shared), problem.ground != nullptr);
  work.coupled = !shared;
  work.goes_on = W.list >= 0 && W.list == grouped.list;
  grouped.list = W.list;
  fill_jacobians(problem, grouped);
  if (blocks_hold(W, grouped)) return;
  grouped.edition = W.edition;
  grouped.compliance_scale = W.compliance_scale;
  grouped.J_then = work.J;
  const Index rows = rows_of_groups(W, grouped);
  grouped.J_then_most = rows == 0 ? 0.0F : work.J.topRows(rows).cwiseAbs().maxCoeff();
  for (const SweepWorkspace::Group& group : work.groups) {
    if (!shared) break;
    const Index columns = 3 * (group.end - group.begin);
    auto T = grouped.tensors.middleRows(group.row, group.rows);
    T.topRows(columns) = (std::sqrt(shared.scale) * shared.T->middleRows(3 * group.begin, columns)).cast<float>();
    T.bottomRows(group.rows - columns).setZero();
  }
  for (Index k = 0; k < W.groups(); ++k) {
    const SweepWorkspace::Group& group = work.groups[k];
    auto block = work.block(group).middleRows(group.row - group.first, group.rows);
    fill_block(W, k, work.J.middleRows(group.row, group.rows), grouped, block);
    if (shared) fill_shared(W, k, grouped);
    for (Index i = group.begin; i < group.end; ++i) {
      const Index n = 3 * (i - group.begin);
      work.local[i] =
          local_step(block(n, n), block(n + 1, n), block(n + 2, n), block(n + 1, n + 1), block(n + 2, n + 2));
    }
  }
}

/// Computes s C f of kRows contacts from `i` on of a group whose first is `first`: all sums in registers.
template <int kRows>
void give_way_rows(const SurfaceCompliance& C, const GroupedDelassus::Axes& axes, Index first, double scale, Index i,
                   const std::vector<SurfaceLoad>& loads, VectorOut motion) {
  using Sums = Eigen::Array<double, kRows, 1>;
  const auto at = [&](const auto& values, Index j) { return values.col(j).template segment<kRows>(i).array(); };
  const Sums px = at(C.p_m, 0), py = at(C.p_m, 1), pz = at(C.p_m, 2);
  Sums x = Sums::Zero(), y = x, z = x;    // sum k f
  Sums tx = x, ty = x, tz = x, bent = x;  // sum a g - b (r.g) p_j, sum b (r.g)
  for (const SurfaceLoad& load : loads) {
    const Sums k = at(C.k, load.contact), a = at(C.a, load.contact);
    const Sums h = at(C.b, load.contact) * (load.g[0] * px + load.g[1] * py + load.g[2] * pz - load.p_g);
    x += load.f[0] * k;
    y += load.f[1] * k;
    z += load.f[2] * k;
    tx += load.g[0] * a - load.p[0] * h;
    ty += load.g[1] * a - load.p[1] * h;
    tz += load.g[2] * a - load.p[2] * h;
    bent += h;
  }
  tx += x + px * bent;
  ty += y + py * bent;
  tz += z + pz * bent;
  for (Index row = 0; row < kRows; ++row) {
    const auto E = axes.middleRows<3>(3 * (first + i + row));
    auto motion_i = motion.segment<3>(3 * (first + i + row));
    motion_i[0] = scale * (E(0, 0) * x[row] + E(0, 1) * y[row] + E(0, 2) * z[row]);
    motion_i[1] = scale * (E(1, 0) * tx[row] + E(1, 1) * ty[row] + E(1, 2) * tz[row]);
    motion_i[2] = scale * (E(2, 0) * tx[row] + E(2, 1) * ty[row] + E(2, 2) * tz[row]);
  }
}

/// Computes the surface motion of group k.
void give_way(const GroupedDelassus& W, Index k, const VectorRef& f, GroupedWorkspace& work) {
  const SurfaceCompliance& C = W.compliance[k];
  const Index first = W.begin[k], contacts = W.begin[k + 1] - first;
  work.loads.clear();
  for (Index j = 0; j < contacts; ++j) {
    const Index row = 3 * (first + j);
    if (f[row] <= 0.0) continue;
    const auto E = W.axes.middleRows<3>(row);
    SurfaceLoad load;
    load.contact = j;
    load.g = f[row + 1] * E.row(1).transpose() + f[row + 2] * E.row(2).transpose();
    load.f = load.g + f[row] * E.row(0).transpose();
    load.p = C.p_m.row(j);
    load.p_g = load.p.dot(load.g);
    work.loads.push_back(load);
  }
  constexpr int kRows = 4;
  const double s = W.scale(k);
  Index i = 0;
  for (; i + kRows <= contacts; i += kRows) {
    give_way_rows<kRows>(C, W.axes, first, s, i, work.loads, work.surface_motion);
  }
  for (; i < contacts; ++i) give_way_rows<1>(C, W.axes, first, s, i, work.loads, work.surface_motion);
}

/// Computes the common body's surface motion.
void give_way(const SharedCompliance& C, const VectorRef& f, GroupedWorkspace& work) {
  const Index contacts = f.size() / 3;
  auto sums = work.shared_sums.topRows(contacts);
  sums.setZero();
  for (Index j = 0; j < contacts; ++j) {
    if (f[3 * j] <= 0.0) continue;
    const Eigen::Vector3d w = C.T->middleRows<3>(3 * j).transpose() * f.segment<3>(3 * j);
    const auto k_j = C.k->col(j).head(contacts);
    for (int axis = 0; axis < 3; ++axis) sums.col(axis) += w[axis] * k_j;
  }
  for (Index i = 0; i < contacts; ++i)
    work.shared_motion.segment<3>(3 * i) = C.scale * (C.T->middleRows<3>(3 * i) * sums.row(i).transpose());
}

/// Computes the common body's motion by forces f: M_common J_common' f.
GroupedDelassus::CommonMotion common_motion(const GroupedDelassus& W, const VectorRef& f) {
  Eigen::Array4d common_1 = Eigen::Array4d::Zero(), common_2 = common_1;
  for (Index i = 0; i < W.contacts(); ++i) {
    if (f[3 * i] <= 0.0) continue;
    for (Index r = 3 * i; r < 3 * i + 3; ++r) {
      common_1 += f[r] * W.J_common.row(r).head<4>().transpose().array();
      common_2 += f[r] * W.J_common.row(r).tail<4>().transpose().array();
    }
  }
  GroupedDelassus::CommonMotion motion;
  motion << common_1, common_2;
  return motion.cwiseProduct(W.common_mobility);
}

/// Moves the body, which its groups move by `by_groups`, to where the ground's laws hold.
void stand_on(const CommonGround& ground, const GroupedDelassus::CommonMotion& by_groups, GroupedWorkspace& work,
              double tolerance = kGroundTolerance) {
  const GroundReport report =
      solve_set_ground(ground.problem, ground.x_free + by_groups.head<6>(), work.ground, tolerance);
  work.ground_missing = report.missing;
  work.ground_status = report.status;
}

/// Computes the body's mobility on the ground at its present motion. Where that keeps changing, a larger mobility is
/// used: sweeps then converge in any case.
void linearise(const CommonGround& ground, GroupedWorkspace& work) {
  ++work.linearisations;
  const double share = std::pow(0.5, std::max(0, work.linearisations - kWholeLinearisations));
  Eigen::Matrix<double, 6, 6> inverse = share * ground_stiffness(ground.problem, work.ground);
  inverse.diagonal() += ground.problem.mobility.cwiseInverse();
  work.R = inverse.llt().matrixL();
  work.L.setIdentity();
  work.R.transpose().triangularView<Eigen::Upper>().solveInPlace(work.L);
}

/// Moves the body after a sweep to where the ground's laws hold, as well as the sweep's change asks for. True if the
/// ground's response has changed so much that the sweeps restart with it.
bool react(const GroupedContactProblem& problem, const VectorRef& f, double change_N, GroupedWorkspace& work) {
  // Where it cannot be solved, the next gaps try again: in each sweep that would take too long.
  if (work.ground_status != SolveStatus::kConverged) return false;
  constexpr double kShareOfChange = 1e-2, kFinest = kGroundTolerance, kCoarsest = 1e-6;
  const double share = change_N > 0.0 ? change_N / f.norm() : 0.0;
  const double tolerance = std::clamp(kShareOfChange * share, kFinest, kCoarsest);
  stand_on(*problem.ground, common_motion(problem.W, f), work, tolerance);
  if (work.ground_status != SolveStatus::kConverged) return false;
  const Eigen::Matrix<float, 6, 1> moved = (work.R.transpose() * (work.ground.x - work.x_exact)).cast<float>();
  SweepWorkspace::Common ahead = SweepWorkspace::Common::Zero();
  ahead.head<6>() = moved - work.sweeps.moved.segment<6>(work.sweeps.groups.back().row);
  move_body(ahead, work.sweeps);
  if (work.linearisations >= kMostLinearisations || ahead.norm() <= kOtherwise * moved.norm()) return false;
  linearise(*problem.ground, work);
  work.list = -1;  // What was learned is of the ground as it was, and in its coordinates.
  fill(problem, work);
  return true;
}

/// Computes the motion by forces f, and from it the gaps.
void gaps(const GroupedContactProblem& problem, const VectorRef& f, GroupedWorkspace& work, VectorOut delta) {
  const GroupedDelassus& W = problem.W;
  find_motion(W, f, work);
  if (problem.ground != nullptr) {
    stand_on(*problem.ground, work.common_motion, work);
    work.x_exact = work.ground.x;
    work.common_motion.head<6>() = work.ground.x - problem.ground->x_free;
  }
  const Eigen::Array4d common_1 = work.common_motion.head<4>(), common_2 = work.common_motion.tail<4>();
  for (Index k = 0; k < W.groups(); ++k) {
    const Eigen::Array4d own = work.own_motion.col(k).head<4>();
    for (Index r = 3 * W.begin[k]; r < 3 * W.begin[k + 1]; ++r) {
      // The 12 products in three registers, which are added up once.
      const Eigen::Array4d parts = W.J_own.row(r).transpose().array() * own +
                                   W.J_common.row(r).head<4>().transpose().array() * common_1 +
                                   W.J_common.row(r).tail<4>().transpose().array() * common_2;
      delta[r] = problem.delta_free[r] + parts.sum();
    }
    if (W.J_fifth.size() == 0) continue;
    const Index first = 3 * W.begin[k], rows = 3 * W.begin[k + 1] - first;
    delta.segment(first, rows) += work.own_motion(4, k) * W.J_fifth.segment(first, rows);
  }
  if (!W.compliance.empty()) delta += work.surface_motion.head(delta.size());
  if (W.common_compliance) delta += work.shared_motion.head(delta.size());
}

}  // namespace

SolveReport solve_contacts(const GroupedContactProblem& problem, const GaussSeidelSettings& settings,
                           GroupedWorkspace& work, ContactSolution solution) noexcept {
  const auto exact = [&](const VectorRef& f, VectorOut delta) { gaps(problem, f, work, delta); };
  if (problem.ground != nullptr) {
    work.linearisations = 0;
    set_ground(problem.ground->problem.contacts, work.ground);
    stand_on(*problem.ground, common_motion(problem.W, solution.f), work);
    linearise(*problem.ground, work);
  }
  fill(problem, work);
  SolveReport report;
  if (problem.ground == nullptr) {
    report = iterate_sweeps(problem, settings, work.sweeps, exact, solution);
  } else {
    const auto mend = [&](const VectorRef& f, double change_N) { return react(problem, f, change_N, work); };
    const double acting_N = solution.f.norm();  // Where fingertips on paths hold the body on the ground.
    report = iterate_sweeps(problem, settings, work.sweeps, exact, mend, solution, acting_N);
    const auto failed = [](SolveStatus s) { return s == SolveStatus::kBudgetSpent || s == SolveStatus::kNotFinite; };
    if (failed(report.status) || failed(work.ground_status)) {
      work.ground.x.setZero();  // Once more, from rest, and with a body that is taken for more mobile.
      work.linearisations = kWholeLinearisations + 2;
      solution.f.setZero();
      stand_on(*problem.ground, GroupedDelassus::CommonMotion::Zero(), work);
      linearise(*problem.ground, work);
      work.list = -1;
      fill(problem, work);
      report = iterate_sweeps(problem, settings, work.sweeps, exact, mend, solution, acting_N);
    }
    report.residual = std::hypot(report.residual, work.ground_missing);
    if (report.status == SolveStatus::kConverged) report.status = work.ground_status;
    write_forces(problem.ground->problem, work.ground);
  }
  if (report.status == SolveStatus::kNotFinite) {
    report = not_finite(report.sweeps, solution);
    work.list = -1;
    work.own_motion.setZero();
    work.common_motion.setZero();
    work.surface_motion.setZero();
  }
  return report;
}

void find_motion(const GroupedDelassus& W, const VectorRef& f, GroupedWorkspace& work) {
  // A register each: sums in the workspace would wait for memory at every contact.
  Eigen::Array4d common_1 = Eigen::Array4d::Zero(), common_2 = common_1;
  for (Index k = 0; k < W.groups(); ++k) {
    Eigen::Array4d own = Eigen::Array4d::Zero();
    for (Index i = W.begin[k]; i < W.begin[k + 1]; ++i) {
      if (f[3 * i] <= 0.0) continue;
      for (Index r = 3 * i; r < 3 * i + 3; ++r) {
        own += f[r] * W.J_own.row(r).transpose().array();
        common_1 += f[r] * W.J_common.row(r).head<4>().transpose().array();
        common_2 += f[r] * W.J_common.row(r).tail<4>().transpose().array();
      }
    }
    work.own_motion.col(k).head<4>() = W.own_mobility * own.matrix();
    if (W.J_fifth.size() > 0) {
      const Index first = 3 * W.begin[k], rows = 3 * W.begin[k + 1] - first;
      work.own_motion(4, k) = W.own_mobility * W.J_fifth.segment(first, rows).dot(f.segment(first, rows));
    }
    if (!W.compliance.empty()) give_way(W, k, f, work);
  }
  work.common_motion << common_1, common_2;
  work.common_motion.array() *= W.common_mobility.array();
  if (W.common_compliance) give_way(W.common_compliance, f, work);
}

void GroupedDelassus::to_dense(Eigen::Ref<Eigen::MatrixXd> W) const {
  const auto J_c = J_common.topRows(3 * contacts());
  // Products with few columns at a time: they need no memory.
  for (Index c = 0; c < W.cols(); c += 3) {
    const Eigen::Matrix<double, kPadded, 3> moved = common_mobility.asDiagonal() * J_c.middleRows<3>(c).transpose();
    W.middleCols<3>(c) = J_c.lazyProduct(moved);
  }
  for (Index k = 0; k < groups(); ++k) {
    const Index first = 3 * begin[k], rows = 3 * begin[k + 1] - first;
    auto W_k = W.block(first, first, rows, rows);
    const auto J_k = J_own.middleRows(first, rows);
    for (Index c = 0; c < rows; c += 3) {
      const Eigen::Matrix<double, kOwn, 3> moved = own_mobility * J_k.middleRows<3>(c).transpose();
      W_k.middleCols<3>(c) += J_k.lazyProduct(moved);
      if (J_fifth.size() == 0) continue;
      const auto fifth = J_fifth.segment(first, rows);
      W_k.middleCols<3>(c) += fifth.lazyProduct(own_mobility * fifth.segment<3>(c).transpose());
    }
    if (!compliance.empty()) add_compliance(compliance[k], axes, begin[k], scale(k), W_k);
  }
  if (common_compliance) add_compliance(common_compliance, W);
}

}  // namespace thenar
