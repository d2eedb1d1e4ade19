#include "app/table.h"

#include <fmt/format.h>

#include <cmath>

#include "app/loops_table.h"

namespace thenar::app {

using nlohmann::ordered_json;

namespace {

/// A number of the summary with its unit, or a dash where nothing was measured.
std::string cell(const ordered_json& summary, const char* pointer, const char* unit = "") {
  const ordered_json& value = summary.at(ordered_json::json_pointer(pointer));
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (!value.is_number() || !std::isfinite(value.get<double>())) return "-";
  return fmt::format("{:.4g}{}{}", value.get<double>(), *unit != '\0' ? " " : "", unit);
}

/// A text, or nothing.
std::string words(const ordered_json& value) { return value.is_string() ? value.get<std::string>() : ""; }

void line(std::string& table, const char* name, const std::string& value, const std::string& remark = "") {
  table += fmt::format("  {:<32} {:>14}{}{}\n", name, value, remark.empty() ? "" : "   ", remark);
}

void stage(std::string& table, const ordered_json& stages, const char* key, const char* name,
           const std::string& remark = "") {
  const ordered_json& times = stages.at(key);
  const std::string median = cell(times, "/p50_us", "us");
  if (median == "-") return;  // the scene has no such stage
  table += fmt::format("  {:<32} {:>12} {:>12}{}{}\n", name, median, cell(times, "/p99_us", "us"),
                       remark.empty() ? "" : "   ", remark);
}

/// What the paper reports for so many contacts, on a 2.2 GHz Pentium IV.
const char* published_contact_time(const ordered_json& contacts) {
  const long n = contacts.at("max").is_number() ? contacts.at("max").get<long>() : 0;
  if (n < 15) return "";
  return n > 30 ? "published: 20 ms at 60 contacts" : n > 15 ? "published: 10 ms at 30" : "published: 6 ms at 15";
}

std::string scheduling_in_words(const ordered_json& scheduling) {
  const int priority = scheduling.at("priority").get<int>();
  std::string words = scheduling.at("policy").get<std::string>() + (priority > 0 ? fmt::format(" {}", priority) : "");
  words += scheduling.at("core").is_null() ? ", any core" : ", core " + scheduling.at("core").dump();
  words += scheduling.at("locked").get<bool>() ? ", memory locked" : ", memory not locked";
  return words + (scheduling.at("kept_awake").get<bool>() ? ", cores kept awake" : "");
}

/// What built the program, and what its threads were granted: "…, SCHED_FIFO 80, core 1, memory locked".
std::string build_line(const ordered_json& summary) {
  const auto build = [&](const char* key) { return summary.at("build").at(key).get<std::string>(); };
  return fmt::format("thenar {}, {} ({}), {}, {}\n", build("version"), build("type"), build("flags"), build("compiler"),
                     summary.contains("scheduling") ? scheduling_in_words(summary.at("scheduling"))
                                                    : "one thread, no real-time scheduling");
}

std::string summary_head(const ordered_json& summary) {
  std::string table = build_line(summary);
  table += words(summary.at("scene")) + ": " + cell(summary, "/simulated_s", "s") + " simulated, " +
           cell(summary, "/real_time_factor") + " times real time\n";
  const double delay_ms = summary.at("settings").at("control_delay_ms");
  table += "contact at " + cell(summary, "/settings/contact_rate_hz", "Hz") + ", control at " +
           cell(summary, "/settings/control_rate_hz", "Hz") +
           (delay_ms > 0.0 ? fmt::format(", {:g} ms late", delay_ms) : "") + "; stops at residual " +
           cell(summary, "/settings/tolerance") + " or " + cell(summary, "/settings/max_sweeps") + " sweeps\n";
  for (const std::string part : summary.at("parts")) table += part + "\n";
  for (const std::string warning : summary.at("warnings")) table += "warning: " + warning + "\n";
  return table;
}

/// All of a list: "0.15, 0.15, 0.15"; nothing of null.
std::string cells(const ordered_json& numbers) {
  std::string all;
  for (const ordered_json& value : numbers) {
    const double number = value.get<double>();
    all += (all.empty() ? "" : ", ") + (std::isfinite(number) ? fmt::format("{:.3g}", number) : "-");
  }
  return all;
}

std::string grasp_lines(const ordered_json& summary) {
  const ordered_json& grasp = summary.at("grasp");
  std::string table = "\ngrasp\n";
  line(table, "outcome", words(grasp.at("outcome")));
  if (grasp.at("reason") != "") table += "    " + words(grasp.at("reason")) + "\n";
  line(table, "largest slip of a finger", cell(summary, "/grasp/max_slip_mm", "mm"),
       "of it at the start: " + cell(summary, "/grasp/max_start_slip_mm", "mm"));
  line(table, "largest spin of a finger", cell(summary, "/grasp/max_spin_deg", "deg"),
       "of it at the start: " + cell(summary, "/grasp/max_start_spin_deg", "deg"));
  line(table, "least margin", cell(summary, "/grasp/min_margin"),
       "at the start: " + cell(summary, "/grasp/min_start_margin"));
  line(table, "largest share of a patch sliding", cell(summary, "/grasp/max_sliding_share"));
  line(table, "fastest point that should stick", cell(summary, "/grasp/max_creep_um_per_s", "um/s"));
  line(table, "contacts, median (max)",
       cell(summary, "/contacts/median") + " (" + cell(summary, "/contacts/max") + ")");
  line(table, "of them carrying force", cell(summary, "/contacts/active_median"));
  line(table, "ticks without a solution",
       cell(summary, "/lcp/grasp_infeasible") + ", " + cell(summary, "/lcp/muscle_infeasible"),
       "grasp forces, muscle forces");
  if (summary.at("muscles").is_object()) {
    line(table, "largest muscle force", cell(summary, "/muscles/max_force_N", "N"));
    line(table, "  over the most a muscle has", cell(summary, "/muscles/max_activation"), "1: its limit");
  }
  if (summary.contains("stiffness")) {
    line(table, "share of the stiffness asked for", cell(summary, "/stiffness/min_share"),
         "at the least; 1: all of it");
    line(table, "  periods without an answer", cell(summary, "/stiffness/unanswered"),
         "neither forces nor a proof that there are none");
    line(table, "  last chosen, along x, y, z", cells(summary.at("stiffness").at("along_N_per_m")) + " N/m",
         "about them: " + cells(summary.at("stiffness").at("about_Nm_per_rad")) + " N m/rad");
  }
  const bool slides = summary.at("joints").contains("least_margin_m");
  line(table, slides ? "least way to the end of a slide" : "least way to a joint's limit",
       slides ? cell(summary, "/joints/least_margin_m", "m") : cell(summary, "/joints/least_margin_rad", "rad"));
  return table;
}

std::string touch_lines(const ordered_json& summary) {
  std::string table;
  if (summary.contains("touch")) {
    const ordered_json& touch = summary.at("touch");
    const auto known = [&](const char* words, const char* key) {
      return touch.contains(key) ? words + cells(touch.at(key)) : "";
    };
    line(table, "least share of a patch sticking", cells(touch.at("stick_min")),
         known("friction felt at the end: ", "friction_felt"));
    line(table, "least margin without torsion", cells(touch.at("margin_true")),
         known("by the friction that was felt: ", "margin_felt"));
  }
  if (summary.contains("reflex")) {
    line(table, "answers to loads, to slips",
         cell(summary, "/reflex/events/load") + ", " + cell(summary, "/reflex/events/slip"),
         "the first after " + cell(summary, "/reflex/onset_ms", "ms") + ", with a slip of " +
             cell(summary, "/reflex/slip_mm", "mm"));
  }
  return table;
}

std::string task_lines(const ordered_json& summary) {
  if (!summary.contains("task")) return "";
  std::string table = "\ntask\n";
  for (const ordered_json& phase : summary.at("task").at("phases")) {
    line(table, phase.at("phase").get_ref<const std::string&>().c_str(), cell(phase, "/until_s", "s"),
         "from " + cell(phase, "/from_s", "s"));
    if (!phase.contains("lift_off")) continue;
    line(table, "  correlation of grip and load", cell(phase, "/grip_load_correlation"));
    line(table, "  borne as the object came off", cell(phase, "/lift_off/borne_N", "N"),
         "at " + cell(phase, "/lift_off/at_s", "s") + "; it weighs " + cell(summary, "/task/weight_N", "N"));
  }
  return table;
}

std::string environment_lines(const ordered_json& summary) {
  if (!summary.contains("environment")) return "";
  std::string table = "\nenvironment\n";
  line(table, "ticks in which it is touched", cell(summary, "/environment/ticks_with_contact"),
       "from " + cell(summary, "/environment/first_touch_s", "s") + " to " +
           cell(summary, "/environment/last_touch_s", "s"));
  line(table, "lifted off it", cell(summary, "/environment/lift_off_s", "s"));
  if (summary.at("environment").at("ticks_wedged") > 0) {
    line(table, "wedged at", cell(summary, "/environment/wedged_depth_mm", "mm"),
         "two contacts within the friction cones, from " + cell(summary, "/environment/first_wedged_s", "s") +
             " on in " + cell(summary, "/environment/ticks_wedged") + " ticks");
  }
  line(table, "largest normal force", cell(summary, "/environment/max_normal_N", "N"));
  line(table, "vertical force on the object", cell(summary, "/environment/max_vertical_N", "N"),
       "at the most; at the least " + cell(summary, "/environment/min_vertical_N", "N"));
  line(table, "deepest penetration", cell(summary, "/environment/max_penetration_um", "um"));
  return table;
}

std::string accuracy_lines(const ordered_json& summary) {
  std::string table = "\naccuracy\n";
  line(table, "final position error", cell(summary, "/object/final_error_mm", "mm"));
  line(table, "rms position error", cell(summary, "/object/rms_error_mm", "mm"));
  line(table, "largest off-axis error", cell(summary, "/object/max_off_axis_error_mm", "mm"));
  line(table, "largest rotation error", cell(summary, "/object/max_rotation_deg", "deg"));
  line(table, "final rotation error", cell(summary, "/object/final_rotation_deg", "deg"));
  line(table, "final force error", cell(summary, "/grasp/force_error_end"), "share of the desired forces");
  line(table, "  of the law without feedforward", cell(summary, "/grasp/predicted_paper_law_error"),
       "predicted: (I + S)^-1 S f^d");
  line(table, "deepest penetration of a pulp", cell(summary, "/contacts/max_penetration_um", "um"));
  line(table, "energy contact gave, and took", cell(summary, "/ledger/injected_J", "J"),
       "and " + cell(summary, "/ledger/dissipated_J", "J"));
  line(table, "energy that the balance misses", cell(summary, "/ledger/unbalanced_J", "J"),
       "of " + cell(summary, "/ledger/drive_J", "J") + " of the drive");
  if (summary.at("frames").at("held_ticks") > 0) {
    line(table, "ticks on the drive of an old frame", cell(summary, "/frames/held_ticks"),
         "in " + cell(summary, "/frames/hold_transitions") + " transitions");
  }
  line(table, "contact residual, p99", cell(summary, "/contacts/residual_p99"), "natural map");
  if (summary.at("muscles").is_object()) {
    line(table, "muscle torque residual", cell(summary, "/lcp/muscle_residual_max", "N m"));
  }
  return table;
}

std::string time_lines(const ordered_json& summary) {
  const ordered_json& stages = summary.at("stages");
  const ordered_json& settings = summary.at("settings");
  std::string table = fmt::format("\n{:<34} {:>12} {:>12}\n", "time", "median", "p99");
  stage(table, stages, "find", "contact finding");
  stage(table, stages, "assemble", "Delassus operator");
  stage(table, stages, "solve", "contact forces");
  stage(table, stages, "deform", "deformation");
  stage(table, stages, "interpolate", "surface interpolation");
  // On two threads contact finding is the control thread's.
  const bool two_loops = summary.contains("loops");
  stage(table, stages, "contact_total", "contact computation, total",
        two_loops ? "on both threads together: must fit into no period; see below"
                  : published_contact_time(summary.at("contacts")));
  stage(table, stages, "grasp_lcp", "grasp forces",
        words(settings.at("grasp_method")) + "; published, by Lemke: 40 us");
  stage(table, stages, "muscle_lcp", "muscle forces", words(settings.at("muscle_method")));
  stage(table, stages, "control_total", "control tick, total");
  return table + "  (published: Rougeron et al. 2006, Pentium IV 2.2 GHz)\n";
}

}  // namespace

std::string results_table(const ordered_json& summary) {
  const std::string table = summary_head(summary) + grasp_lines(summary) + touch_lines(summary) + task_lines(summary) +
                            environment_lines(summary) + accuracy_lines(summary) + time_lines(summary);
  return summary.contains("loops") ? table + loops_table(summary) : table;
}

}  // namespace thenar::app
