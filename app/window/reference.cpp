#include "app/window/reference.h"

#include <sys/resource.h>

#include <stop_token>
#include <utility>

#include "engine/grasp/delassus.h"
#include "solvers/contact_newton.h"
#include "solvers/residual.h"

namespace thenar::window {

using Eigen::Index;
using Eigen::VectorXd;

Reference::Reference() : thread_([this](const std::stop_token& stop) { work(stop); }) {}

void Reference::offer(const thenar::Model& model, const thenar::SolvedTick& tick) {
  const Index n = tick.frame.size();
  const std::lock_guard lock(mutex_);
  if (n == 0) result_ = ReferenceResult{};  // Nothing is to be solved: what was known of it is not true any more.
  if (busy_ || n == 0) return;
  offer_ = Offer{{thenar::dense_delassus(model, tick.frame, tick.kinematics, tick.mobility),
                  tick.delta_free.head(3 * n), tick.mu.head(n)},
                 tick.f_first.head(3 * n),
                 tick.f.head(3 * n)};
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
