#include "engine/monolithic.h"

#include <cmath>
#include <limits>

#include "engine/grasp_monitor.h"
#include "engine/stopwatch.h"
#include "engine/surface_display.h"

namespace thenar {

using Eigen::Vector3d;

namespace {

NormalTangential split(const Vector3d& force, const Vector3d& n) {
  const double normal_N = force.dot(n);
  return {normal_N, (force - normal_N * n).norm()};
}

void record_control(const ControlReport& control, TickRecord& record) {
  record.controlled = true;
  record.find_s = control.find_s;
  record.factors_s = control.factors_s;
  record.grasp_s = control.grasp_s;
  record.muscle_s = control.muscle_s;
  record.control_s = control.total_s;
  record.grasp = control.grasp;
  record.muscle = control.muscle;
  record.muscle_residual_Nm = control.muscle_residual_Nm;
}

void record_motion(const Model& model, const State& state, TickRecord& record) {
  const Eigen::Isometry3d& start = model.scene.object.X_WO;
  const Eigen::Isometry3d target = model.target(record.time_s);
  record.position_m = start.linear().transpose() * (state.X_WO.translation() - start.translation());
  record.target_m = start.linear().transpose() * (target.translation() - start.translation());
  record.rotation_error_rad = pose_error(target, state.X_WO).tail<3>().norm();
}

void record_forces(const Model& model, const State& state, const ControlReport& control, TickRecord& record) {
  for (int k = 0; k < kFingers; ++k) {
    const FingerLoad& load = state.load[k];
    record.force[k] = split(load.force_N, load.normal);
    record.cone_margin[k] = std::numeric_limits<double>::quiet_NaN();
    const double mu = model.scene.contact.friction;
    if (load.normal_N > 0.0 && mu > 0.0) {
      record.cone_margin[k] =
          1.0 - record.force[k].tangential_N / (model.scene.contact.friction * record.force[k].normal_N);
    }
    if (!model.scene.control) continue;
    record.force_desired[k] = split(control.f_desired.col(k), control.contacts[k].frame.col(0));
    record.force_error_N[k] = (control.f_desired.col(k) - load.force_N).norm();
  }
}

}  // namespace

Recording run_monolithic(const Model& model, State& state, const Progress& progress) {
  const Scene& scene = model.scene;
  const auto ticks = static_cast<std::int64_t>(std::ceil(scene.duration_s / scene.step_s - 1e-9));
  const bool muscles = scene.control && scene.control->muscles;
  Frame frame(model);
  Controller controller(model);
  ContactWorkspace work(model);
  std::vector<SurfaceDisplay> displays(model.pulps.begin(), model.pulps.end());
  GraspMonitor monitor(scene.hand);
  ControlReport control;
  Recording recording;
  recording.ticks.reserve(ticks);
  recording.muscle_forces_N.resize(muscles ? controller.f_muscle.size() : 0, ticks);

  Stopwatch wall;
  for (std::int64_t tick = 0; tick < ticks && !recording.loss; ++tick) {
    TickRecord record;
    if (model.control_is_due(tick)) {
      const State snapshot = state;
      control = control_tick(model, snapshot, controller, frame);
      record_control(control, record);
      if (control.grasp != GraspStatus::kOptimal && !recording.unsolved) {
        recording.unsolved =
            UnsolvedGrasp{static_cast<double>(tick) * scene.step_s, control, snapshot.X_WO.translation()};
        // Without a first solution there are no forces to go on with.
        if (tick == 0) break;
      }
    }
    record.contact = contact_tick(model, frame, work, state);
    Stopwatch stage;
    for (std::size_t k = 0; k < displays.size(); ++k) displays[k].displace(state.u_m[k]);
    if (!displays.empty()) record.interpolate_s = stage.lap();

    record.time_s = static_cast<double>(state.tick) * scene.step_s;
    record_motion(model, state, record);
    record_forces(model, state, control, record);
    if (muscles) recording.muscle_forces_N.col(tick) = controller.f_muscle;
    recording.loss = monitor.update(scene.step_s, record);
    recording.ticks.push_back(record);
    recording.wall_s += wall.lap();
    if (progress) progress(record.time_s, recording.wall_s);
  }
  recording.stopped = std::ssize(recording.ticks) < ticks;
  recording.muscle_forces_N.conservativeResize(Eigen::NoChange, std::ssize(recording.ticks));
  if (scene.control && !recording.ticks.empty()) {
    recording.predicted_paper_law_error =
        predicted_paper_law_error(model, controller.pose, control.contacts, control.f_desired);
  }
  return recording;
}

}  // namespace thenar
