// Distances from a surface and the contacts of three fingertips: speed against accuracy, ours beside distance grids and
// other projects', judged against objects whose distances are known exactly.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/finding_methods.h"
#include "bench/report/figure.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using nlohmann::ordered_json;

// Errors below are drawn as this: on flat faces they are rounding alone.
constexpr double kLeastError_um = 1e-3;
// A triangle mesh's faces are as wide as the samples lie apart; what a peer is told is the same as we are.
constexpr char kPeers[] =
    "nanoflann finds the 16 nearest samples, on which our own plane is fitted; FCL measures to a triangle mesh of the "
    "same samples, without a sign; a distance grid is filled from the exact distance, which a scan does not have, and "
    "interpolated.";

/// An object of each kind with about 36 000 samples times `finer` squared.
using Maker = KnownObject (*)(double finer);
constexpr Maker kObjects[]{[](double finer) { return known_box(std::lround(77 * finer)); },
                           [](double finer) { return known_scan(std::lround(61 * finer)); },
                           [](double finer) { return known_ball(std::lround(61 * finer)); }};

std::string thousands(Index samples) { return fmt::format("{} 000 samples", (samples + 500) / 1000); }

WorkPoint work_point(const std::string& method, const std::string& setting, double error_um, double us, double us_p99) {
  WorkPoint point;
  point.method = method;
  point.setting = setting;
  point.error = std::max(error_um, kLeastError_um);
  point.us = us;
  point.us_p99 = us_p99;
  return point;
}

bool is_grid(const FindingRecipe& recipe) { return recipe.name.starts_with("distance grid"); }

// --- Distances of points --------------------------------------------------------------------------------------------

/// The points of one density: all methods that know distances, in turns.
void add_distances(ordered_json& points, const KnownObject& object, bool reference, int rounds) {
  const Matrix3Xd none(3, 0);
  const std::string samples = thousands(object.cloud.points_m.cols());
  std::vector<FindingMethod> methods{our_finding(object, none, {}, true)};
  std::vector<WorkPoint> made{work_point("thenar", samples, 0, 0, 0)};
  made.back().is_default = reference;
  for (const FindingRecipe& recipe : finding_peers(object.box_m.has_value())) {
    if (!recipe.knows_distances) continue;
    methods.push_back(recipe.make(object, none, {}));
    made.push_back(work_point(recipe.name, samples, 0, 0, 0));
    made.back().peer = true;
  }
  for (const double cell_m : {4e-3, 2e-3, 1e-3, 0.5e-3}) {
    if (!reference) continue;
    methods.push_back(grid_finding(object, none, {}, cell_m));
    made.push_back(work_point("distance grid",
                              fmt::format("{:g} mm, {:.1f} MB", 1e3 * cell_m, methods.back().memory_MB), 0, 0, 0));
    made.back().peer = true;
  }
  const std::vector<DistanceRecord> records = measure_distances(methods, object, rounds);
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const DistanceRecord& r = records[m];
    made[m].error = std::max(r.mean_error_um, kLeastError_um);
    made[m].us = 1e-3 * r.ns;
    made[m].us_p99 = 1e-3 * r.ns_p99;
    points.push_back(made[m]);
  }
}

void distances(ordered_json& part, bool quick) {
  const int rounds = quick ? 5 : 15;
  ordered_json& figure = add_figure(
      part, "work_precision", "distance", "Distance of a point from a surface of samples",
      fmt::format(
          "What one signed distance takes, and how far it is from the exact one: mean over 2000 points from 2 mm "
          "inside to 0.3 mm outside. Down and left is better. Box: 50 mm, flat faces and sharp edges. Scan: a bumpy "
          "ellipsoid, unevenly sampled. Ball: radius 20 mm, finely and evenly sampled. Points of a line differ in the "
          "number of samples; ours at the 36 000 of the scenes is the default. On the box's faces our error is "
          "rounding (drawn at {:g} um). {}",
          kLeastError_um, kPeers),
      fmt::format("medians of {} rounds of 40 batches of 50 points, methods of one density in turns", rounds));
  figure["choice"] = "distance from the object";
  figure["error"] = "mean error of the distance [um]";
  figure["time"] = "time of one distance [us]";
  for (const Maker make : kObjects) {
    ordered_json points = ordered_json::array();
    for (const double finer : {0.5, 1.0, 2.0, 4.0}) {
      if (quick && finer > 2.0) continue;
      add_distances(points, make(finer), finer == 1.0, rounds);
    }
    figure["cases"].push_back({{"name", make(0.1).name}, {"points", points}});
  }
}

// --- The contacts of a grip -----------------------------------------------------------------------------------------

struct Finding {
  std::string object, method, lacks;
  bool ours;
  double prepare_ms = 0.0, memory_MB = 0.0;
  FindingRecord record = {};

  /// Whether it finds the control points that touch, and their gaps, as the engine needs.
  [[nodiscard]] bool same_contacts() const { return std::abs(record.contacts - record.wanted) < 0.05 * record.wanted; }
};

std::vector<Finding> find_contacts_of(const KnownObject& object, bool quick) {
  const GripTask task;
  const Matrix3Xd controls_m = pulp_control_points(320);
  const std::vector<Grip> grips = random_grips(object, controls_m, task, quick ? 32 : 128, 1);
  const std::vector<Grip> creeping = creeping_grip(grips.front(), quick ? 64 : 256, 1);
  std::vector<FindingCase> cases{{our_finding(object, controls_m, task, false), creeping},
                                 {our_finding(object, controls_m, task, true), grips}};
  std::vector<Finding> findings{{object.name, "thenar, a grip that creeps", "", true},
                                {object.name, "thenar, nothing remembered", "", true}};
  for (const FindingRecipe& recipe : other_findings(object.box_m.has_value())) {
    if (quick && is_grid(recipe) && recipe.name.find("0.5") != std::string::npos) continue;
    cases.push_back({recipe.make(object, controls_m, task), grips});
    findings.push_back({object.name, recipe.name, cases.back().method.lacks, false});
  }
  const std::vector<FindingRecord> records = measure_findings(cases, object, controls_m, task, quick ? 2 : 6);
  for (std::size_t c = 0; c < cases.size(); ++c) {
    findings[c].prepare_ms = cases[c].method.prepare_ms;
    findings[c].memory_MB = cases[c].method.memory_MB;
    findings[c].record = records[c];
  }
  return findings;
}

void contacts(ordered_json& part, bool quick) {
  std::vector<Finding> all;
  for (const Maker make : kObjects) {
    for (Finding& finding : find_contacts_of(make(1.0), quick)) all.push_back(std::move(finding));
  }
  const std::string runs =
      fmt::format("medians over {} grips, {} rounds of all methods in turns", quick ? 32 : 128, quick ? 2 : 6);

  ordered_json& chart = add_figure(
      part, "work_precision", "contacts", "Finding the contacts of three fingertips",
      fmt::format(
          "What it takes to find up to 20 contacts of each of three fingertips (320 control points each) on an object "
          "of 36 000 samples, and the mean error of their gaps. Down and left is better. Grips are at random places, "
          "edges too; \"a grip that creeps\" moves by micrometres from one to the next, as a held object does: the "
          "default, which remembers. Others look at every control point in the object's bounds; those that find other "
          "contacts, or but half of them, are in the table below alone. A grid of exact distances is faster; it is off "
          "by tenths of a millimetre at edges, its memory grows with the object's volume, and a scan has no exact "
          "distance. {}",
          kPeers),
      runs);
  chart["choice"] = "contact finding";
  chart["error"] = "mean error of the gaps [um]";
  chart["time"] = "time for three fingers [us]";
  for (const Finding& f : all) {
    if (!f.same_contacts()) continue;
    if (chart["cases"].empty() || chart["cases"].back()["name"] != f.object) {
      chart["cases"].push_back({{"name", f.object}, {"points", ordered_json::array()}});
    }
    WorkPoint point = work_point(f.method, "", f.record.mean_error_um, f.record.us_p50, f.record.us_p99);
    point.is_default = f.ours && chart["cases"].back()["points"].empty();
    point.peer = !f.ours;
    chart["cases"].back()["points"].push_back(point);
  }

  ordered_json& table = add_figure(
      part, "table", "contact_methods", "What each way of finding contacts finds, and costs",
      "The same grips by all methods, with what a method does not compute of what the engine needs in the last column. "
      "\"There\" are the contacts that exact distances tell, at most 20 a finger; a method that finds other things may "
      "find more or fewer. Ready: from the samples, the mesh or the exact distance, once.",
      runs);
  table["columns"] = {"object",          "method",       "median [us]", "p99 [us]",    "found",           "there",
                      "mean error [um]", "largest [um]", "ready [ms]",  "memory [MB]", "does not compute"};
  for (const Finding& f : all) {
    table["rows"].push_back({f.object, f.method, f.record.us_p50, f.record.us_p99, f.record.contacts, f.record.wanted,
                             f.record.mean_error_um, f.record.max_error_um, f.prepare_ms, f.memory_MB, f.lacks});
  }
}

void run(const PartArguments& arguments) {
  ordered_json part = make_part("finding", "Distances and contact finding",
                                "Where the fingertips touch is asked of a cloud of samples, not of a mesh: what that "
                                "costs, and how exact it is.",
                                arguments);
  distances(part, arguments.quick);
  contacts(part, arguments.quick);
  write_part(part, arguments);
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) { thenar::run(thenar::part_arguments(argc, argv)); }
