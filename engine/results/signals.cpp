#include "engine/results/signals.h"

#include <fmt/format.h>

#include "engine/formats/text.h"

namespace thenar {

namespace {

std::vector<std::string> hand_names(const Model& model, const Recording& recording) {
  std::vector<std::string> names = {"time_s"};
  for (const char* what : {"position", "target"}) {
    for (const char* axis : {"x", "y", "z"}) names.push_back(std::string(what) + "_" + axis + "_mm");
  }
  names.emplace_back("rotation_error_deg");
  for (const Fingertip& tip : model.scene.hand.fingertips) {
    for (const char* what : {"normal_N", "tangential_N", "desired_normal_N", "desired_tangential_N", "force_error_N",
                             "margin", "slip_um", "spin_deg", "sliding_share", "creep_um_per_s"}) {
      names.push_back(tip.finger + "_" + what);
    }
  }
  const char* const unit = model.scene.hand.slides ? "_mm" : "_rad";
  for (const Joint& joint : model.scene.hand.joints) names.push_back(joint.name + unit);
  for (const char* what : {"contacts", "active", "sweeps", "residual", "penetration_um"}) names.emplace_back(what);
  for (Eigen::Index m = 0; m < recording.muscle_forces_N.rows(); ++m) {
    names.push_back(model.scene.hand.muscles[m].name + "_N");
  }
  if (!model.feels()) return names;
  for (const Fingertip& tip : model.scene.hand.fingertips) {
    for (const char* what : {"stick", "rim_friction", "slip_speed_um_per_s"}) names.push_back(tip.finger + "_" + what);
    if (!model.scene.control) continue;
    for (const char* what : {"friction_felt", "squeeze_N"}) names.push_back(tip.finger + "_" + what);
  }
  if (model.scene.control) names.emplace_back("reflex");
  return names;
}

/// Behind the hand's, of a scene that has one.
void name_environment(std::vector<std::string>& names) {
  for (const char* what : {"force_x_N", "force_y_N", "force_z_N", "moment_x_N_mm", "moment_y_N_mm", "moment_z_N_mm",
                           "normal_N", "contacts", "active", "penetration_um"}) {
    names.push_back(std::string("environment_") + what);
  }
}

std::vector<std::string> names_of(const Model& model, const Recording& recording) {
  std::vector<std::string> names = hand_names(model, recording);
  if (model.scene.environment) name_environment(names);
  if (!model.scene.task.phases.empty()) {
    for (const char* what : {"phase", "borne_N", "arm_x_mm", "arm_y_mm", "arm_z_mm"}) names.emplace_back(what);
  }
  return names;
}

template <class Sink>
void for_each_touch(const Model& model, const TickRecord& tick, Sink&& sink) {
  for (int k = 0; k < model.fingers(); ++k) {
    const Touch& touch = tick.touch[k];
    for (const double v : {touch.stick, touch.friction, 1e6 * touch.slip_m_per_s}) sink(v);
    if (!model.scene.control) continue;
    for (const double v : {tick.reflex.friction[k], tick.reflex.grips[k].internal_force_N}) sink(v);
  }
  if (model.scene.control) sink(tick.controlled ? static_cast<double>(tick.reflex.event) : 0.0);
}

template <class Sink>
void for_each_of_environment(const EnvironmentReport& report, Sink&& sink) {
  for (const double force_N : report.wrench.head<3>()) sink(force_N);
  for (const double moment_Nm : report.wrench.tail<3>()) sink(1e3 * moment_Nm);
  sink(report.normal_N);
  for (const int count : {report.contacts, report.active}) sink(static_cast<double>(count));
  sink(1e6 * report.penetration_m);
}

/// Calls sink(number) for each name of a tick, in their order.
template <class Sink>
void for_each_number(const Model& model, const Recording& recording, std::size_t i, Sink&& sink) {
  const TickRecord& tick = recording.ticks[i];
  sink(tick.time_s);
  for (const double x : tick.position_m) sink(1e3 * x);
  for (const double x : tick.target_m) sink(1e3 * x);
  sink(kDegrees * tick.rotation_error_rad);
  for (int k = 0; k < model.fingers(); ++k) {
    for (const double v :
         {tick.force[k].normal_N, tick.force[k].tangential_N, tick.force_desired[k].normal_N,
          tick.force_desired[k].tangential_N, tick.force_error_N[k], tick.margin[k], 1e6 * tick.slip_m[k],
          kDegrees * tick.spin_rad[k], tick.sliding_share[k], 1e6 * tick.creep_m_per_s[k]}) {
      sink(v);
    }
  }
  for (const double q : tick.q_rad) sink(model.scene.hand.slides ? 1e3 * q : q);
  for (const Eigen::Index count : {tick.contact.contacts, tick.contact.active}) sink(static_cast<double>(count));
  sink(static_cast<double>(tick.contact.solve.sweeps));
  sink(tick.contact.solve.residual);
  sink(1e6 * tick.contact.penetration_m);
  for (Eigen::Index m = 0; m < recording.muscle_forces_N.rows(); ++m) {
    sink(recording.muscle_forces_N(m, static_cast<Eigen::Index>(i)));
  }
  if (model.feels()) for_each_touch(model, tick, sink);
  if (model.scene.environment) for_each_of_environment(tick.contact.environment, sink);
  if (model.scene.task.phases.empty()) return;
  sink(static_cast<double>(tick.phase));
  sink(tick.borne_N);
  for (const double x : tick.arm_m) sink(1e3 * x);
}

}  // namespace

SignalTable signal_table(const Model& model, const Recording& recording) {
  SignalTable table;
  table.names = names_of(model, recording);
  table.numbers.resize(std::ssize(recording.ticks), std::ssize(table.names));
  for (std::size_t i = 0; i < recording.ticks.size(); ++i) {
    Eigen::Index column = 0;
    for_each_number(model, recording, i,
                    [&](double number) { table.numbers(static_cast<Eigen::Index>(i), column++) = number; });
  }
  return table;
}

std::string signals_csv(const Model& model, const Recording& recording) {
  std::string csv;
  for (const std::string& name : names_of(model, recording)) csv += (csv.empty() ? "" : ",") + csv_cell(name);
  for (std::size_t i = 0; i < recording.ticks.size(); ++i) {
    const char* before = "\n";
    for_each_number(model, recording, i, [&](double number) {
      csv += fmt::format("{}{:.9g}", before, number);
      before = ",";
    });
  }
  return csv + "\n";
}

}  // namespace thenar
