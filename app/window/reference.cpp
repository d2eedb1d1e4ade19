// SPDX-License-Identifier: Apache-2.0
#include "app/window/reference.h"

#include <sys/resource.h>

#include <stop_token>
#include <utility>

#include "engine/grasp/delassus.h"
#include "solvers/contact_newton.h"
#include "solvers/residual.h"

namespace thenar::window {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

/// Of n contacts with fingers and m with the environment, in this order.
thenar::ContactData problem_of(const thenar::Model& model, const thenar::SolvedTick& tick) {
  const Index n = tick.frame.size(), m = std::ssize(tick.ground);
  thenar::ContactData problem{MatrixXd::Zero(3 * (n + m), 3 * (n + m)), VectorXd(3 * (n + m)), VectorXd(n + m)};
  problem.delta_free.head(3 * n) = tick.delta_free.head(3 * n);
  problem.mu.head(n) = tick.mu.head(n);
  if (m == 0) {
    problem.W = thenar::dense_delassus(model, tick.frame, tick.kinematics, tick.mobility);
    return problem;
  }
  MatrixXd J(3 * (n + m), 6);  // How the object's motion changes all gaps and slips.
  J.topRows(3 * n) = tick.kinematics.J_object.topLeftCorner(3 * n, 6);
  for (Index i = 0; i < m; ++i) {
    const thenar::GroundContact& contact = tick.ground[i];
    J.middleRows<3>(3 * (n + i)) = contact.J;
    problem.delta_free.segment<3>(3 * (n + i)) = contact.delta_free + contact.J * tick.x_free;
    problem.mu[n + i] = contact.mu;
  }
  Vector6d mobility;
  mobility << Vector3d::Constant(tick.mobility.translation), Vector3d::Constant(tick.mobility.rotation);
  const MatrixXd by_forces = J * mobility.asDiagonal();
  problem.W = by_forces.lazyProduct(J.transpose());  // Eigen's other product has functions that the ticks call, too.
  problem.W.diagonal().tail(3 * m).array() += model.scene.environment->compliance_m_per_N;
  if (n > 0) {
    // Which has that of the object, and of all else.
    problem.W.topLeftCorner(3 * n, 3 * n) = thenar::dense_delassus(model, tick.frame, tick.kinematics, tick.mobility);
  }
  return problem;
}

/// The fingers' forces, and behind them those of the environment.
VectorXd with_ground(const Eigen::Ref<const VectorXd>& f, const thenar::SolvedTick& tick) {
  VectorXd all(f.size() + 3 * std::ssize(tick.ground_N));
  all.head(f.size()) = f;
  for (Index i = 0; i < std::ssize(tick.ground_N); ++i) all.segment<3>(f.size() + 3 * i) = tick.ground_N[i];
  return all;
}

}  // namespace

Reference::Reference() : thread_([this](const std::stop_token& stop) { work(stop); }) {}

void Reference::offer(const thenar::Model& model, const thenar::SolvedTick& tick) {
  const Index n = tick.frame.size();
  const std::lock_guard lock(mutex_);
  const bool none = n == 0 && tick.ground.empty();
  if (none) result_ = ReferenceResult{};  // Nothing is to be solved: what was known of it is not true any more.
  if (busy_ || none) return;
  offer_ = Offer{problem_of(model, tick), with_ground(tick.f_first.head(3 * n), tick),
                 with_ground(tick.f.head(3 * n), tick)};
  busy_ = true;
  offered_.notify_one();
}

std::optional<ReferenceResult> Reference::take_result() {
  const std::lock_guard lock(mutex_);
  return std::exchange(result_, std::nullopt);
}

ReferenceResult Reference::judge(const Offer& offer) {
  const thenar::ContactData& problem = offer.problem;
  ReferenceResult result;
  VectorXd delta = problem.W * offer.f + problem.delta_free;
  result.residual = thenar::natural_map(problem, offer.f, delta).norm;
  thenar::AccurateWorkspace work(problem.contacts());
  VectorXd f = offer.f_first;
  const auto report = thenar::solve_contacts_accurately(problem, {}, work, {f, delta});
  if (report.solve.status == thenar::SolveStatus::kConverged && f.norm() > 0.0) {
    result.error = (offer.f - f).norm() / f.norm();
  }
  return result;
}

void Reference::work(const std::stop_token& stop) {
  setpriority(PRIO_PROCESS, 0, 19);  // Of this thread alone, in Linux.
  std::unique_lock lock(mutex_);
  while (offered_.wait(lock, stop, [this] { return offer_.has_value(); })) {
    const Offer offer = std::move(*offer_);
    offer_.reset();
    lock.unlock();
    const ReferenceResult result = judge(offer);
    lock.lock();
    result_ = result;
    busy_ = false;
  }
}

}  // namespace thenar::window
