#include "engine/results/signals.h"

#include <fmt/format.h>

#include <utility>

#include "engine/formats/text.h"

namespace thenar {

namespace {

/// A line of comma-separated values.
class CsvRow {
 public:
  void add(double value) { add(fmt::format("{:.9g}", value)); }
  void add(const std::string& cell) { line_ += (line_.empty() ? "" : ",") + csv_cell(cell); }
  std::string finish() { return std::exchange(line_, "") + "\n"; }

 private:
  std::string line_;
};

std::string header(const Model& model, const Recording& recording) {
  CsvRow row;
  row.add("time_s");
  for (const char* what : {"position", "target"}) {
    for (const char* axis : {"x", "y", "z"}) row.add(std::string(what) + "_" + axis + "_mm");
  }
  row.add("rotation_error_deg");
  for (const Fingertip& tip : model.scene.hand.fingertips) {
    for (const char* what : {"normal_N", "tangential_N", "desired_normal_N", "desired_tangential_N", "force_error_N",
                             "margin", "slip_um", "spin_deg", "sliding_share", "creep_um_per_s"}) {
      row.add(tip.finger + "_" + what);
    }
  }
  for (const Joint& joint : model.scene.hand.joints) row.add(joint.name + "_rad");
  for (const char* what : {"contacts", "active", "sweeps", "residual", "penetration_um"}) row.add(what);
  for (Eigen::Index m = 0; m < recording.muscle_forces_N.rows(); ++m) row.add(model.scene.hand.muscles[m].name + "_N");
  return row.finish();
}

}  // namespace

std::string signals_csv(const Model& model, const Recording& recording) {
  std::string csv = header(model, recording);
  CsvRow row;
  for (std::size_t i = 0; i < recording.ticks.size(); ++i) {
    const TickRecord& tick = recording.ticks[i];
    row.add(tick.time_s);
    for (const double x : tick.position_m) row.add(1e3 * x);
    for (const double x : tick.target_m) row.add(1e3 * x);
    row.add(kDegrees * tick.rotation_error_rad);
    for (int k = 0; k < model.fingers(); ++k) {
      for (const double v :
           {tick.force[k].normal_N, tick.force[k].tangential_N, tick.force_desired[k].normal_N,
            tick.force_desired[k].tangential_N, tick.force_error_N[k], tick.margin[k], 1e6 * tick.slip_m[k],
            kDegrees * tick.spin_rad[k], tick.sliding_share[k], 1e6 * tick.creep_m_per_s[k]}) {
        row.add(v);
      }
    }
    for (const double q : tick.q_rad) row.add(q);
    for (const Eigen::Index count : {tick.contact.contacts, tick.contact.active}) row.add(std::to_string(count));
    row.add(std::to_string(tick.contact.solve.sweeps));
    row.add(tick.contact.solve.residual);
    row.add(1e6 * tick.contact.penetration_m);
    for (Eigen::Index m = 0; m < recording.muscle_forces_N.rows(); ++m) row.add(recording.muscle_forces_N(m, i));
    csv += row.finish();
  }
  return csv;
}

}  // namespace thenar
