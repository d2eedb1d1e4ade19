// SPDX-License-Identifier: Apache-2.0
#include "bench/methods/contact_computation.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "engine/grasp/stopwatch.h"
#include "engine/pulps/pulp_levels.h"
#include "solvers/contact_newton.h"

namespace thenar {

using Eigen::Index;

namespace {

RecordedTicks with_sweeps(RecordedTicks recorded, int max_sweeps) {
  recorded.model.scene.contact.max_sweeps = max_sweeps;
  return recorded;
}

}  // namespace

double published_us(Index contacts) { return contacts <= 15 ? 6000.0 : contacts <= 30 ? 10000.0 : 20000.0; }

ContactRun::ContactRun(Index contacts, int max_sweeps)
    : recorded_(with_sweeps(RecordedTicks(contacts), max_sweeps)),
      frame_(recorded_.model),
      memory_(recorded_.model),
      work_(recorded_.model),
      displays_(recorded_.model.pulps.begin(), recorded_.model.pulps.end()),
      now_(recorded_.ticks.front()) {}

ContactComputation ContactRun::tick() {
  if (ticks_++ % recorded_.ticks.size() == 0) {
    now_ = recorded_.ticks.front();
    memory_ = ContactMemory(recorded_.model);
  }
  const ControlReport control = control_tick(recorded_.model, now_.state, now_.controller, frame_);
  const TickReport contact = contact_tick(recorded_.model, frame_, memory_, work_, now_.state);
  Stopwatch watch;
  double shown = 0.0;  // Read, so that it is not left out.
  for (std::size_t k = 0; k < displays_.size(); ++k) shown += displays_[k].displace(now_.state.u_m[k])(0, 0);
  const double display_s = watch.lap();
  if (!(std::abs(shown) < 1.0)) throw std::runtime_error("the pulps fell apart");
  solved_ = contact.solve;
  return {control.find_s,   control.factors_s, contact.assemble_s, contact.solve_s,
          contact.deform_s, display_s,         contact.solve};
}

Workload ContactRun::workload() const {
  Workload w;
  w.contacts = static_cast<double>(frame_.size());
  w.sweeps = solved_.sweeps;
  for (std::size_t k = 0; k + 1 < frame_.begin.size(); ++k) {
    const auto own = static_cast<double>(frame_.begin[k + 1] - frame_.begin[k]);
    double loaded = 0.0;
    for (Index i = frame_.begin[k]; i < frame_.begin[k + 1]; ++i) loaded += memory_.f[3 * i] > 0.0 ? 1.0 : 0.0;
    w.loaded += loaded;
    w.pairs += own * own;
    w.loaded_pairs += own * loaded;
    w.samples += static_cast<double>(recorded_.model.pulps[k].surface.points_m.cols());
  }
  w.controls = static_cast<double>(recorded_.model.pulps.front().controls());
  return w;
}

double ContactRun::force_error() const {
  const Index contacts = frame_.size(), rows = 3 * contacts;
  const ContactData problem{dense_delassus(recorded_.model, frame_, work_.kinematics, work_.mobility),
                            work_.delta_free.head(rows), work_.mu.head(contacts)};
  AccurateWorkspace accurate(contacts);
  Eigen::VectorXd f = memory_.f.head(rows), delta(rows);
  const AccurateReport report = solve_contacts_accurately(problem, {.tolerance = 1e-12}, accurate, {f, delta});
  if (report.solve.residual > 1e-10) return std::numeric_limits<double>::quiet_NaN();
  return (memory_.f.head(rows) - f).norm() / f.norm();
}

double ContactRun::hertz_error() const {
  const Model& model = recorded_.model;
  return estimate_level(model.scene, model.pulps, model.level).force_error;
}

std::vector<std::vector<ContactComputation>> in_turns(std::deque<ContactRun>& runs, int turns) {
  std::vector<std::vector<ContactComputation>> ticks(runs.size());
  for (int turn = 0; turn < turns; ++turn) {
    for (std::size_t k = 0; k < runs.size(); ++k) {
      for (int i = 0; i < kTicksATurn; ++i) {
        const ContactComputation tick = runs[k].tick();
        if (tick.solve.status != SolveStatus::kConverged) throw std::runtime_error("a contact solve did not converge");
        if (i >= kDroppedTicks) ticks[k].push_back(tick);
      }
    }
  }
  return ticks;
}

}  // namespace thenar
