// SPDX-License-Identifier: Apache-2.0
#include "app/run/loops_table.h"

#include <fmt/format.h>

#include <cmath>
#include <initializer_list>

namespace thenar::app {

using nlohmann::ordered_json;

namespace {

// Ticks given up at once for longer are no overrun.
constexpr double kStandstill_s = 0.5;

/// A number, or a dash where nothing was measured.
std::string cell(const ordered_json& value) {
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number_integer()) return value.dump();
  if (!value.is_number() || !std::isfinite(value.get<double>())) return "-";
  return fmt::format("{:.4g}", value.get<double>());
}

/// A time in us, with the decimals that it is worth.
std::string us(const ordered_json& value) {
  if (!value.is_number()) return "-";
  const double time_us = value.get<double>();
  const double size_us = std::abs(time_us);
  return fmt::format("{:.{}f}", time_us, size_us < 1.0 ? 3 : size_us < 1000.0 ? 1 : 0);
}

std::string row(const std::string& name, std::initializer_list<std::string> cells, const std::string& remark = "") {
  std::string line = fmt::format("  {:<28}", name);
  for (const std::string& text : cells) line += fmt::format(" {:>10}", text);
  return line + remark + '\n';
}
std::string heading(const std::string& name, std::initializer_list<std::string> cells) {
  std::string line = fmt::format("\n{:<30}", name);
  for (const std::string& text : cells) line += fmt::format(" {:>10}", text);
  return line + '\n';
}

std::string latency_row(const std::string& name, const ordered_json& times, const std::string& remark = "") {
  if (times.at("p50_us").is_null()) return "";  // the scene has no such stage
  return row(name, {us(times.at("p50_us")), us(times.at("p99_us")), us(times.at("p999_us")), us(times.at("max_us"))},
             remark.empty() ? "" : "   " + remark);
}
std::string method(const ordered_json& name) { return name.is_string() ? name.get<std::string>() : ""; }

/// The share of a loop's ticks that were done [%].
std::string kept(const ordered_json& loop) {
  const double done = loop.at("ticks").get<double>(), slipped = loop.at("slipped").get<double>();
  return done + slipped > 0.0 ? fmt::format("{:.1f}", 100.0 * done / (done + slipped)) : "-";
}

/// Which period a time must fit into.
std::string must_fit(const char* what, const ordered_json& rate_Hz) {
  return fmt::format("{} must fit into {:.4g} us, the period", what, 1e6 / rate_Hz.get<double>());
}

std::string beside_accuracy(const ordered_json& summary) {
  const ordered_json& contact = summary.at("loops").at("contact");
  const ordered_json& handover = summary.at("handover");
  std::string table = heading("at this accuracy", {});
  table += row("residual > 1e-2; not finite", {cell(contact.at("residual_above_1e-2")), cell(contact.at("not_finite"))},
               "   ticks");
  table += row("sweeps a tick, p50 and p99", {cell(contact.at("sweeps_p50")), cell(contact.at("sweeps_p99"))});
  table += row("force step [N], p99", {cell(handover.at("tick_N_p99")), "in a tick"});
  table += row("  at a hand-over, p99 and max", {cell(handover.at("kick_N_p99")), cell(handover.at("kick_N_max"))});
  table += row("  hand-over over tick, p99", {cell(handover.at("kick_over_tick_p99"))});
  table += row("energy injected/dissipated", {cell(summary.at("ledger").at("injected_over_dissipated"))});
  table += row("largest position error [mm]", {cell(summary.at("object").at("max_error_mm"))});
  return table;
}

std::string counts_row(const char* name, const ordered_json& counts) {
  return row(name, {cell(counts.at("published")), cell(counts.at("consumed")), cell(counts.at("superseded")),
                    cell(counts.at("in_flight")), cell(counts.at("torn")), cell(counts.at("unaccounted"))});
}

std::string exchange_table(const ordered_json& summary) {
  const ordered_json& exchange = summary.at("exchange");
  const ordered_json& age = summary.at("frame_age");
  std::string table = heading("exchange", {"published", "consumed", "superseded", "in flight", "torn", "unaccount."});
  table += counts_row("frames, to contact", exchange);
  table += counts_row("snapshots, to control", summary.at("snapshots"));
  table += heading("on the contact thread", {"p50", "p99", "max"});
  table += row("take a frame [ns]", {cell(exchange.at("acquire_p50_ns")), cell(exchange.at("acquire_p99_ns"))});
  table += row("publish a snapshot [ns]", {cell(exchange.at("publish_p50_ns")), cell(exchange.at("publish_p99_ns"))});
  table += row("age of the frame [ms]", {cell(age.at("p50_ms")), cell(age.at("p99_ms")), cell(age.at("max_ms"))});
  return table;
}

std::string floor_table(const ordered_json& floor) {
  if (floor.is_null()) return "";
  std::string table = heading("floor: start jitter p99 [us]", {"cyclictest", "ours", "ratio"});
  for (std::size_t i = 0; i < floor.at("ratios").size(); ++i) {
    table += row(
        fmt::format("pair {}, no spin", i + 1),
        {us(floor.at("cyclictest_p99_us").at(i)), us(floor.at("jitter_p99_us").at(i)), cell(floor.at("ratios").at(i))});
  }
  table += row("median of the ratios", {"", "", cell(floor.at("ratio_p99_median"))});
  table += row(fmt::format("this run, {:g} us spin", floor.at("spin").at("spin_us").get<double>()),
               {"", us(floor.at("spin").at("jitter_p99_us"))});
  const std::string remark = floor.at("remark").get<std::string>();
  if (!remark.empty()) table += "  " + remark + '\n';
  return table;
}

/// What the threads were granted beyond the first line, and what was refused.
std::string threads_lines(const ordered_json& summary) {
  const ordered_json& scheduling = summary.at("scheduling");
  std::string lines =
      fmt::format("\ntwo threads: {} s of wall time, timer slack {} ns, spin {} us\n", cell(summary.at("wall_s")),
                  cell(scheduling.at("timer_slack_ns")), cell(scheduling.at("spin_us")));
  for (const ordered_json* granted : {&scheduling, &scheduling.at("control")}) {
    const std::string remark = granted->at("remark").get<std::string>();
    if (!remark.empty()) lines += "  " + remark + '\n';
  }
  return lines;
}

std::string rates_and_times(const ordered_json& summary) {
  const ordered_json& contact = summary.at("loops").at("contact");
  const ordered_json& control = summary.at("loops").at("control");
  const ordered_json& stages = control.at("stages");
  const ordered_json& settings = summary.at("settings");
  std::string table = heading("loops", {"asked [Hz]", "rate [Hz]", "ticks", "overruns", "slipped", "kept [%]"});
  table += row("contact", {cell(settings.at("contact_rate_hz")), cell(contact.at("rate_hz")), cell(contact.at("ticks")),
                           cell(contact.at("overruns")), cell(contact.at("slipped")), kept(contact)});
  table += row("control", {cell(settings.at("control_rate_hz")), cell(control.at("rate_hz")), cell(control.at("ticks")),
                           "", cell(control.at("slipped")), kept(control)});
  const auto longest_s = contact.at("longest_slip_s").get<double>();
  if (longest_s > kStandstill_s) {
    table += fmt::format("  The run stood still for {:.1f} s: the program was stopped, or the machine.\n", longest_s);
  }
  table += heading("time [us]", {"p50", "p99", "p99.9", "max"});
  table += latency_row("contact: start jitter", contact.at("jitter"));
  table += latency_row("contact: compute", contact.at("compute"),
                       must_fit("start jitter + compute", settings.at("contact_rate_hz")));
  table += latency_row("control: start jitter", control.at("jitter"));
  table += latency_row("control: whole tick", control.at("total"),
                       must_fit("start jitter + tick", settings.at("control_rate_hz")));
  table += latency_row("  grasp forces", stages.at("grasp_lcp"), method(settings.at("grasp_method")));
  table += latency_row("  muscle forces", stages.at("muscle_lcp"), method(settings.at("muscle_method")));
  table += latency_row("  contact finding", stages.at("find"));
  table += latency_row("  compliance", stages.at("factors"));
  return table;
}

}  // namespace

std::string loops_table(const ordered_json& summary) {
  return threads_lines(summary) + rates_and_times(summary) + beside_accuracy(summary) + exchange_table(summary) +
         floor_table(summary.at("floor"));
}

}  // namespace thenar::app
