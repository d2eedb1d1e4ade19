#include "bench/contact_computation.h"

#include <cmath>
#include <stdexcept>

#include "engine/stopwatch.h"

namespace thenar {
namespace {

Model with_sweeps(Model model, int max_sweeps) {
  model.scene.contact.max_sweeps = max_sweeps;
  return model;
}

}  // namespace

double published_us(Eigen::Index contacts) { return contacts <= 15 ? 6000.0 : contacts <= 30 ? 10000.0 : 20000.0; }

ContactRun::ContactRun(Eigen::Index contacts, int max_sweeps)
    : recorded_(recorded_run(contacts)),
      model_(with_sweeps(recorded_.model, max_sweeps)),
      frame_(model_),
      work_(model_),
      displays_(model_.pulps.begin(), model_.pulps.end()),
      now_(recorded_.ticks.front()) {}

ContactComputation ContactRun::tick() {
  if (ticks_++ % recorded_.ticks.size() == 0) {
    now_ = recorded_.ticks.front();
    work_ = ContactWorkspace(model_);
  }
  const ControlReport control = control_tick(model_, now_.state, now_.controller, frame_);
  const TickReport contact = contact_tick(model_, frame_, work_, now_.state);
  Stopwatch watch;
  double shown = 0.0;  // Read, so that it is not left out.
  for (std::size_t k = 0; k < displays_.size(); ++k) shown += displays_[k].displace(now_.state.u_m[k])(0, 0);
  const double display_s = watch.lap();
  if (!(std::abs(shown) < 1.0)) throw std::runtime_error("the pulps fell apart");
  return {control.find_s,   control.factors_s, contact.assemble_s, contact.solve_s,
          contact.deform_s, display_s,         contact.solve};
}

}  // namespace thenar
