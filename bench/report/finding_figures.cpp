// SPDX-License-Identifier: Apache-2.0
// Distances from a surface and the contacts of three fingertips: speed against accuracy, ours beside distance grids and
// other projects', judged against objects whose distances are known exactly.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "bench/methods/finding_methods.h"
#include "bench/report/figure.h"

namespace thenar {
namespace {

using Eigen::Matrix3Xd;
using nlohmann::ordered_json;

// Errors below are drawn as this: on flat faces they are rounding alone.
constexpr double kLeastError_um = 1e-3;

/// An object of each kind with about 36 000 samples.
using Maker = KnownObject (*)();
constexpr Maker kObjects[]{[] { return known_box(77); }, [] { return known_scan(61); }, [] { return known_ball(61); }};

// --- Distances of points --------------------------------------------------------------------------------------------

/// The points of one object: all methods that know distances, in turns.
ordered_json distances_from(const KnownObject& object, int rounds) {
  const Matrix3Xd none(3, 0);
  std::vector<FindingMethod> methods{our_finding(object, none, {}, true), our_finding(object, none, {}, true, 0.0)};
  std::vector<WorkPoint> points{{.method = "thenar", .setting = "within 1 µm", .is_default = true},
                                {.method = "thenar", .setting = "exact"}};
  for (const FindingRecipe& recipe : finding_peers(object.box_m.has_value())) {
    if (!recipe.knows_distances) continue;
    methods.push_back(recipe.make(object, none, {}));
    points.push_back({.method = recipe.name, .setting = "", .peer = true});
  }
  for (const double cell_m : {4e-3, 2e-3, 1e-3, 0.5e-3}) {
    methods.push_back(grid_finding(object, none, {}, cell_m));
    const std::string cells = fmt::format("{:g} mm, {:.1f} MB", 1e3 * cell_m, methods.back().memory_MB);
    points.push_back({.method = "distance grid", .setting = cells, .peer = true});
  }
  const std::vector<DistanceRecord> records = measure_distances(methods, object, rounds);
  for (std::size_t m = 0; m < methods.size(); ++m) {
    points[m].error = std::max(records[m].mean_error_um, kLeastError_um);
    points[m].us = records[m].us;
    points[m].us_p99 = records[m].us_p99;
  }
  return points;
}

void distances(ordered_json& part, bool quick) {
  const int rounds = quick ? 5 : 15;
  ordered_json& figure = add_figure(
      part, "work_precision", "distance", "Distance of a point from a surface of samples",
      fmt::format(
          "A distance grid is faster than ours and less exact, at the box's edges by far; ours without an allowed "
          "error "
          "(exact) costs more and gains nothing that can be seen here. What one signed distance takes, and how far it "
          "is from the exact one: mean over 2000 points "
          "from 2 mm inside to 0.3 mm outside. Down and left is better. On the box and the ball our error is rounding "
          "(drawn at {:g} µm).",
          kLeastError_um),
      fmt::format("medians of {} rounds of 40 batches of 50 points, methods in turns", rounds));
  figure["error"] = "mean error of the distance [µm]";
  figure["time"] = "time of one distance [µs]";
  for (const Maker make : kObjects) {
    const KnownObject object = make();
    figure["cases"].push_back({{"name", object.name}, {"points", distances_from(object, rounds)}});
  }
}

// --- The contacts of a grip -----------------------------------------------------------------------------------------

struct Finding {
  std::string name, setting;
  bool ours, is_default;
  FindingMethod method;
  FindingRecord random = {}, creeping = {};
};

/// Whether it finds the control points that touch, and their gaps, as the engine needs.
bool same_contacts(const FindingRecord& record) {
  return std::abs(record.contacts - record.wanted) < 0.05 * record.wanted;
}

/// Every method on grips at random places, and on one that creeps.
std::vector<Finding> find_contacts_of(const KnownObject& object, bool quick) {
  const GripTask task;
  const Matrix3Xd controls_m = pulp_control_points(320);
  std::vector<Finding> findings{
      {"thenar", "remembers the last grip", true, true, our_finding(object, controls_m, task, false)},
      {"thenar", "remembers nothing", true, false, our_finding(object, controls_m, task, true)},
      {"thenar", "exact", true, false, our_finding(object, controls_m, task, false, 0.0)}};
  for (const FindingRecipe& recipe : other_findings(object.box_m.has_value())) {
    findings.push_back({recipe.name, "", false, false, recipe.make(object, controls_m, task)});
  }
  const std::vector<Grip> grips = random_grips(object, controls_m, task, quick ? 16 : 64, 1);
  const std::vector<Grip> creeping = creeping_grip(grips.front(), quick ? 9 : 33, 1);
  const auto measure = [&](const std::vector<Grip>& on) {
    std::vector<FindingCase> cases;
    for (const Finding& finding : findings) cases.push_back({finding.method, on});
    return measure_findings(cases, object, controls_m, task, quick ? 2 : 5);
  };
  const std::vector<FindingRecord> random = measure(grips), creeps = measure(creeping);
  for (std::size_t k = 0; k < findings.size(); ++k) {
    findings[k].random = random[k];
    findings[k].creeping = creeps[k];
  }
  return findings;
}

ordered_json points_of(const std::vector<Finding>& findings, FindingRecord Finding::*grips) {
  ordered_json points = ordered_json::array();
  for (const Finding& f : findings) {
    const FindingRecord& record = f.*grips;
    if (!same_contacts(record)) continue;
    points.push_back(WorkPoint{.method = f.name,
                               .setting = f.setting,
                               .error = std::max(record.mean_error_um, kLeastError_um),
                               .us = record.us_p50,
                               .us_p99 = record.us_p99,
                               .is_default = f.is_default,
                               .peer = !f.ours});
  }
  return points;
}

void contacts(ordered_json& part, bool quick) {
  const std::string runs =
      fmt::format("medians over {} grips and {} rounds, all methods in turns", quick ? 16 : 64, quick ? "2" : "5");
  ordered_json& chart = add_figure(
      part, "work_precision", "finding_contacts", "Finding the contacts of three fingertips",
      "A distance grid is faster at grips that come out of nowhere, and less exact, by far at edges; it needs an exact "
      "distance to be filled from, and memory with the object's volume. Where the grip creeps by micrometres, as a "
      "held "
      "object's does, ours is as fast: it remembers which sample a control point is nearest to. Of the others ours is "
      "the fastest. "
      "Up to 20 contacts of each fingertip (320 control points); error: of the gaps, mean. Down and left is better. "
      "Random: grips at random places, edges too. Methods that find other contacts, or but half of them, are only in "
      "the next table.",
      runs);
  chart["choice"] = "contact finding";
  chart["error"] = "mean error of the gaps [µm]";
  chart["time"] = "time for three fingers [µs]";
  ordered_json rows = ordered_json::array();
  for (const Maker make : kObjects) {
    const KnownObject object = make();
    const std::vector<Finding> findings = find_contacts_of(object, quick);
    chart["cases"].push_back(
        {{"name", object.name + ", random grips"}, {"points", points_of(findings, &Finding::random)}});
    chart["cases"].push_back(
        {{"name", object.name + ", a creeping grip"}, {"points", points_of(findings, &Finding::creeping)}});
    for (const Finding& f : findings) {
      const FindingRecord& r = f.random;
      rows.push_back({object.name, f.setting.empty() ? f.name : f.name + ", " + f.setting, r.us_p50, r.us_p99,
                      r.contacts, r.wanted, r.mean_error_um, r.max_error_um, f.method.prepare_ms, f.method.memory_MB,
                      f.method.lacks});
    }
  }

  ordered_json& table = add_figure(
      part, "table", "finding_methods", "What each way of finding contacts finds, and costs",
      "The methods for meshes find other things than the control points that touch: FCL's distance has the smallest "
      "error, and finds but half of the contacts, for it has no sign; collisions give a contact for each pair of "
      "triangles. The random grips of the chart above. There: the contacts that exact distances tell, at most 20 a "
      "finger. Ready: from the samples, the mesh or the exact distance, once.",
      runs);
  table["columns"] = {"object",          "method",       "median [µs]", "p99 [µs]",    "found",           "there",
                      "mean error [µm]", "largest [µm]", "ready [ms]",  "memory [MB]", "does not compute"};
  table["rows"] = rows;
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(argc, argv, "finding", "Distances and contact finding",
                  "Where the fingertips touch is asked of a cloud of samples, not of a mesh: what that costs, and how "
                  "exact it is. Box: 50 mm, flat faces and sharp edges. Scan: a bumpy ellipsoid, unevenly sampled. "
                  "Ball: radius 20 mm, evenly sampled. All of 36 000 samples. Not part of Thenar: nanoflann finds the "
                  "16 nearest samples, on which our own plane is fitted; FCL and Bullet have a triangle mesh of the "
                  "same samples; a distance grid is filled from the exact distance, and interpolated.",
                  {distances, contacts});
}
