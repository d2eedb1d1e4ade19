// What the charts of contact finding and of the whole contact computation are drawn from, as one JSON file:
// collision_charts FILE. The same, as tables, on stdout. Times are medians; every time stands beside its accuracy, which
// is judged here against exact distances.

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "bench/report/measure.h"
#include "bench/contact_computation.h"
#include "bench/finding_methods.h"
#include "engine/summary.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using nlohmann::ordered_json;

constexpr int kRounds = 15;

/// An object of each kind with about 36 000 samples times `finer` squared.
KnownObject box_of(double finer) { return known_box(std::lround(77 * finer)); }
KnownObject scan_of(double finer) { return known_scan(std::lround(61 * finer)); }

// --- Error of a distance over its time ------------------------------------------------------------------------------

ordered_json distance_point(const FindingMethod& method, const KnownObject& object, const std::string& name) {
  const DistanceRecord record = measure_distance(method, object, kRounds);
  const auto samples = object.cloud.points_m.cols();
  fmt::print("  {:8}{:34}{:9}{:9.2f}{:11.1f}{:10.2f}{:10.1f}{:10.1f}{:10.0f}{:9.1f}{}\n", object.name, name, samples,
             1e-3 * record.ns, 100.0 * record.answered, record.mean_error_um, record.p99_error_um, record.max_error_um,
             method.prepare_ms, method.memory_MB, method.is_signed ? "" : "   size alone");
  return {{"object", object.name},
          {"method", name},
          {"samples", samples},
          {"us", 1e-3 * record.ns},
          {"answered", record.answered},
          {"mean_error_um", record.mean_error_um},
          {"p99_error_um", record.p99_error_um},
          {"max_error_um", record.max_error_um},
          {"signed", method.is_signed},
          {"prepare_ms", method.prepare_ms},
          {"memory_MB", method.memory_MB}};
}

void distance_error(ordered_json& points) {
  fmt::print("Distance of one point, from 2 mm inside to 0.3 mm outside, against the exact one\n");
  fmt::print("  {:8}{:34}{:>9}{:>9}{:>11}{:>10}{:>10}{:>10}{:>10}{:>9}\n", "object", "method", "samples", "us",
             "answered %", "mean um", "p99 um", "max um", "ready ms", "MB");
  const Matrix3Xd none(3, 0);
  for (const auto& make : {box_of, scan_of}) {
    for (const double finer : {0.5, 1.0, 2.0, 4.0}) {
      const KnownObject object = make(finer);
      points.push_back(distance_point(our_finding(object, none, {}, true), object, "thenar"));
      for (const FindingRecipe& recipe : finding_peers(object.box_m.has_value())) {
        if (!recipe.knows_distances || finer > 2.0) continue;
        points.push_back(distance_point(recipe.make(object, none, {}), object, recipe.name));
      }
      if (finer != 1.0) continue;
      for (const double cell_m : {2e-3, 1e-3, 0.5e-3}) {
        points.push_back(distance_point(grid_finding(object, none, {}, cell_m), object,
                                        fmt::format("distance grid, {:.2g} mm", 1e3 * cell_m)));
      }
    }
  }
}

// --- The contacts of a grip by all methods --------------------------------------------------------------------------

ordered_json finding_row(const FindingMethod& method, const KnownObject& object, const Matrix3Xd& controls_m,
                         const GripTask& task, const std::vector<Grip>& grips, const std::string& name, int rounds) {
  const FindingRecord record = measure_finding(method, object, controls_m, task, grips, rounds);
  fmt::print("  {:8}{:34}{:9.1f}{:9.1f}{:9.1f}{:9.1f}{:10.2f}{:10.1f}{:10.0f}{:9.1f}  {}\n", object.name, name,
             record.us_p50, record.us_p99, record.contacts, record.wanted, record.mean_error_um, record.max_error_um,
             method.prepare_ms, method.memory_MB, method.lacks.empty() ? "" : "does not compute: " + method.lacks);
  return {{"object", object.name},
          {"method", name},
          {"us", record.us_p50},
          {"us_p99", record.us_p99},
          {"found", record.contacts},
          {"there", record.wanted},
          {"mean_error_um", record.mean_error_um},
          {"max_error_um", record.max_error_um},
          {"prepare_ms", method.prepare_ms},
          {"memory_MB", method.memory_MB},
          {"lacks", method.lacks}};
}

void finding(ordered_json& rows) {
  const GripTask task;
  const Matrix3Xd controls_m = pulp_control_points(320);
  fmt::print("\nContacts of three pulps at random places, {} a finger asked for\n", task.per_finger);
  fmt::print("  {:8}{:34}{:>9}{:>9}{:>9}{:>9}{:>10}{:>10}{:>10}{:>9}\n", "object", "method", "us p50", "p99", "found",
             "there", "mean um", "max um", "ready ms", "MB");
  for (const auto& make : {box_of, scan_of}) {
    const KnownObject object = make(1.0);
    const std::vector<Grip> grips = random_grips(object, controls_m, task, 128, 1);
    const std::vector<Grip> creeping = creeping_grip(grips.front(), 256, 1);
    rows.push_back(finding_row(our_finding(object, controls_m, task, true), object, controls_m, task, grips,
                               "thenar, cold", kRounds));
    rows.push_back(finding_row(our_finding(object, controls_m, task, false), object, controls_m, task, creeping,
                               "thenar, warm", kRounds));
    for (const FindingRecipe& recipe : other_findings(object.box_m.has_value())) {
      rows.push_back(
          finding_row(recipe.make(object, controls_m, task), object, controls_m, task, grips, recipe.name, 2));
    }
  }
}

// --- Growth ---------------------------------------------------------------------------------------------------------

struct Sizes {
  std::vector<double> n, us;
};

/// The curve with the exponent of n that fits its times best, by least squares of logarithms.
ordered_json curve(const std::string& over, const std::string& name, const Sizes& sizes) {
  const double fitted = exponent(sizes.n, sizes.us);
  fmt::print("  {:10}{:30}n^{:5.2f}   ", over, name, fitted);
  for (std::size_t i = 0; i < sizes.n.size(); ++i) fmt::print("{:9.0f}: {:.1f}", sizes.n[i], sizes.us[i]);
  fmt::print("\n");
  return {{"over", over}, {"name", name}, {"n", sizes.n}, {"us", sizes.us}, {"exponent", fitted}};
}

void finding_growth(ordered_json& curves) {
  constexpr std::array<Index, 4> kPerFinger{5, 10, 20, 40};
  constexpr std::array kFiner{1.0, 2.0, 4.0};
  constexpr std::array<Index, 3> kControls{320, 1280, 5120};
  fmt::print("\nGrowth of finding: size and us for three fingers\n");
  const Matrix3Xd controls_m = pulp_control_points(320);
  for (const auto& make : {box_of, scan_of}) {
    const KnownObject object = make(1.0);
    const auto grips_for = [&](const Matrix3Xd& controls, const GripTask& task, bool cold) {
      const std::vector<Grip> grips = random_grips(object, controls, task, cold ? 64 : 1, 1);
      return cold ? grips : creeping_grip(grips.front(), 256, 1);
    };
    for (const bool cold : {true, false}) {
      const std::string name = object.name + (cold ? ", cold" : ", warm");
      const auto us_of = [&](const KnownObject& at, const Matrix3Xd& controls, const GripTask& task) {
        return measure_finding(our_finding(at, controls, task, cold), object, controls, task,
                               grips_for(controls, task, cold), kRounds)
            .us_p50;
      };
      Sizes contacts, points, controls;
      for (const Index per_finger : kPerFinger) {
        contacts.n.push_back(3.0 * static_cast<double>(per_finger));
        contacts.us.push_back(us_of(object, controls_m, {.per_finger = per_finger}));
      }
      curves.push_back(curve("contacts", name, contacts));
      for (const double finer : kFiner) {
        const KnownObject at = make(finer);
        points.n.push_back(static_cast<double>(at.cloud.points_m.cols()));
        points.us.push_back(us_of(at, controls_m, {}));
      }
      curves.push_back(curve("points", name, points));
      for (const Index count : kControls) {
        controls.n.push_back(static_cast<double>(count));
        controls.us.push_back(us_of(object, pulp_control_points(count), {}));
      }
      curves.push_back(curve("controls", name, controls));
    }
  }
}

// --- The contact computation, stage by stage ------------------------------------------------------------------------

void breakdown(ordered_json& rows, ordered_json& curves) {
  constexpr int kWarmSweeps = 10, kTicks = 2000, kUntimed = 100;
  fmt::print("\nContact computation of the box grasp, {} warm sweeps, us\n", kWarmSweeps);
  fmt::print("  {:>8}{:>8}{:>12}{:>10}{:>8}{:>8}{:>9}{:>10}{:>10}{:>12}{:>9}{:>11}{:>7}{:>11}{:>11}\n", "contacts",
             "find", "compliance", "assemble", "solve", "deform", "display", "contact", "slow", "no display", "total",
             "published", "ratio", "residual", "worst");
  Sizes totals;
  for (const Index contacts : {15, 30, 60, 120}) {
    ContactRun run(contacts, kWarmSweeps);
    std::vector<ContactComputation> ticks;
    for (int i = 0; i < kUntimed + kTicks; ++i) {
      ticks.push_back(run.tick());
      if (i < kUntimed) ticks.clear();
    }
    const auto median_of = [&](auto value) {
      std::vector<double> values;
      for (const ContactComputation& tick : ticks) values.push_back(value(tick));
      return percentiles(std::move(values));
    };
    using Tick = ContactComputation;
    const auto us = [&](auto stage) { return 1e6 * median_of(stage).p50; };
    const Percentiles residual = median_of([](const Tick& t) { return t.solve.residual; });
    ordered_json row{{"contacts", contacts},
                     {"find", us([](const Tick& t) { return t.find_s; })},
                     {"compliance", us([](const Tick& t) { return t.compliance_s; })},
                     {"assemble", us([](const Tick& t) { return t.assemble_s; })},
                     {"solve", us([](const Tick& t) { return t.solve_s; })},
                     {"deform", us([](const Tick& t) { return t.deform_s; })},
                     {"display", us([](const Tick& t) { return t.display_s; })},
                     {"contact_thread", us([](const Tick& t) { return t.contact_thread_s(); })},
                     {"slow_thread", us([](const Tick& t) { return t.slow_thread_s(); })},
                     {"no_display", us([](const Tick& t) { return t.total_s() - t.display_s; })},
                     {"total", us([](const Tick& t) { return t.total_s(); })},
                     {"residual", residual.p50},
                     {"worst_residual", residual.max}};
    const double total = row["total"];
    totals.n.push_back(static_cast<double>(contacts));
    totals.us.push_back(total);
    fmt::print("  {:8}{:8.1f}{:12.1f}{:10.1f}{:8.1f}{:8.1f}{:9.1f}{:10.1f}{:10.1f}{:12.1f}{:9.1f}", contacts,
               row["find"].get<double>(), row["compliance"].get<double>(), row["assemble"].get<double>(),
               row["solve"].get<double>(), row["deform"].get<double>(), row["display"].get<double>(),
               row["contact_thread"].get<double>(), row["slow_thread"].get<double>(), row["no_display"].get<double>(),
               total);
    if (contacts <= 60) {
      row["published"] = published_us(contacts);
      fmt::print("{:11.0f}{:7.0f}", published_us(contacts), published_us(contacts) / total);
    } else {
      fmt::print("{:>11}{:>7}", "-", "-");
    }
    fmt::print("{:11.1e}{:11.1e}\n", residual.p50, residual.max);
    rows.push_back(row);
  }
  curves.push_back(curve("contacts", "whole computation", totals));
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  if (argc != 2) {
    std::cerr << "usage: collision_charts FILE\n";
    return 2;
  }
  nlohmann::ordered_json data{{"build", build_settings()}};
  data["note"] = "one core, medians; " + data["build"].at("compiler").get<std::string>() + " " +
                 data["build"].at("flags").get<std::string>();
  distance_error(data["distance_error"]);
  finding(data["finding"]);
  finding_growth(data["growth"]);
  breakdown(data["breakdown"], data["growth"]);
  std::ofstream(argv[1]) << data.dump(1) << '\n';
}
