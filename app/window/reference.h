// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "engine/grasp/model.h"
#include "engine/loops/live_contact.h"
#include "engine/recordings/state_message.h"
#include "solvers/contact_problem.h"

namespace thenar::window {

/// Accuracy of a tick's contact forces.
struct ReferenceResult {
  double error = thenar::kNotMeasured;  ///< |f - f_accurate| / |f_accurate|; NaN where no accurate forces were found.
  double residual = thenar::kNotMeasured;  ///< Residual of the tick's forces: natural map, W formed anew.
};

/// Solves contact problems of running loops accurately, contacts with the environment among them, on a thread of its
/// own that gives way to all others.
class Reference {
 public:
  Reference();

  /// Takes the problem if the last one is done, else nothing happens.
  void offer(const thenar::Model& model, const thenar::SolvedTick& tick);
  /// Returns the result of the last problem, once.
  [[nodiscard]] std::optional<ReferenceResult> take_result();

 private:
  struct Offer {
    thenar::ContactData problem;
    Eigen::VectorXd f_first, f;
  };
  [[nodiscard]] static ReferenceResult judge(const Offer& offer);
  void work(const std::stop_token& stop);

  std::mutex mutex_;  // guards all below, but for the thread
  std::condition_variable_any offered_;
  bool busy_ = false;
  std::optional<Offer> offer_;
  std::optional<ReferenceResult> result_;
  std::jthread thread_;  // the last one: it ends before what it uses
};

}  // namespace thenar::window
