#include "engine/results/monolithic.h"

#include <utility>

#include "engine/grasp/stopwatch.h"
#include "engine/grasp/surface_display.h"
#include "engine/results/recorder.h"

namespace thenar {

Recording run_monolithic(const Model& model, State& state, const Progress& progress, ProblemDump* dump,
                         RecordingFile* film) {
  Frame frame(model);
  Controller controller(model);
  ContactWorkspace work(model);
  std::vector<SurfaceDisplay> displays(model.pulps.begin(), model.pulps.end());
  ControlReport control;
  Recorder recorder(model);
  state = start_of_run(std::move(state));

  Stopwatch wall;
  double wall_s = 0.0;
  for (std::int64_t tick = 0, held = true; tick < recorder.planned() && held; ++tick) {
    const bool controlled = model.control_is_due(tick);
    if (controlled) {
      const Snapshot snapshot = state;
      control = control_tick(model, snapshot, controller, frame);
      if (dump != nullptr) dump->add_control(model, controller, control, snapshot.X_WO.translation());
      recorder.add(static_cast<double>(tick) * model.scene.step_s, control, controller.f_muscle);
      // Without a first solution there are no forces to go on with.
      if (tick == 0 && recorder.has_unsolved()) break;
    }
    const TickReport contact = contact_tick(model, frame, work, state);
    if (dump != nullptr) dump->add_contact(tick, model, frame, work);
    TickRecord record = tick_record(model, state, contact, control);
    if (controlled) record_control(control, record);
    Stopwatch stage;
    for (std::size_t k = 0; k < displays.size(); ++k) displays[k].displace(state.u_m[k]);
    if (!displays.empty()) record.interpolate_s = stage.lap();
    held = recorder.add(record, controller.f_muscle);
    if (film != nullptr) film->add(state, work, record, controller.f_muscle);
    wall_s += wall.lap();
    if (progress && !progress(record.time_s, wall_s)) {
      recorder.interrupt(record.time_s);
      break;
    }
  }
  return recorder.finish(state, control, wall_s);
}

}  // namespace thenar
