// Contact finding: three pulps on an object, over the number of contacts, of the object's samples and of control points;
// cold and warm; beside other ways to find contacts. Every time stands with what was found and how far off its gaps are.
//
//     box    the reference scene's cube of 50 mm, flat faces and sharp edges
//     scan   a bumpy ellipsoid of 40 x 50 x 70 mm, unevenly sampled
//     cold   grips at random places, edges too, and nothing remembered
//     warm   a grip that creeps by micrometres, as between two control periods
//
// The time is that of the three fingers together; p50_us is its median, which other programs on the machine hardly move.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "bench/finding_methods.h"
#include "engine/percentiles.h"

namespace thenar {
namespace {

using Eigen::Index;

enum class Shape { kBox, kScan };
enum class Start { kCold, kWarm };

/// An object with about 36 000 samples times a square number, made once.
const KnownObject& object_of(Shape shape, long times) {
  static std::map<std::pair<Shape, long>, KnownObject> objects;
  const auto [at, is_new] = objects.try_emplace({shape, times});
  if (is_new) {
    const Index finer = times == 16 ? 4 : times == 4 ? 2 : 1;
    at->second = shape == Shape::kBox ? known_box(77 * finer) : known_scan(61 * finer);
  }
  return at->second;
}

const Eigen::Matrix3Xd& controls_of(long count) {
  static std::map<long, Eigen::Matrix3Xd> controls;
  const auto [at, is_new] = controls.try_emplace(count);
  if (is_new) at->second = pulp_control_points(count);
  return at->second;
}

const std::vector<Grip>& grips_of(Shape shape, const GripTask& task, long controls, Start start) {
  static std::map<std::tuple<Shape, Index, long, Start>, std::vector<Grip>> all;
  const auto [at, is_new] = all.try_emplace({shape, task.per_finger, controls, start});
  if (is_new) {
    at->second = random_grips(object_of(shape, 1), controls_of(controls), task, start == Start::kCold ? 128 : 1, 1);
    if (start == Start::kWarm) at->second = creeping_grip(at->second.front(), 512, 1);
  }
  return at->second;
}

/// Whether a grip's contacts are those that the distances of all control points tell.
bool as_by_hand(const FindingMethod& method, const KnownObject& object, const Eigen::Matrix3Xd& controls_m,
                const GripTask& task, const Grip& grip) {
  const Eigen::AlignedBox3d bounds(Eigen::Vector3d(object.cloud.points_m.rowwise().minCoeff()),
                                   Eigen::Vector3d(object.cloud.points_m.rowwise().maxCoeff()));
  std::vector<FoundContact> found, by_hand;
  method.find(grip, found);
  for (const Eigen::Isometry3d& X : grip) {
    const auto distance = [&](const Eigen::Vector3d& p) -> std::optional<SurfaceDistance> {
      const auto to = method.distance(p);
      if (!to) return std::nullopt;
      return SurfaceDistance{*to, p, Eigen::Vector3d::Zero()};
    };
    find_by_distance(controls_m, X, bounds, task, distance, by_hand);
  }
  std::sort(found.begin(), found.end());
  std::sort(by_hand.begin(), by_hand.end());
  return std::equal(found.begin(), found.end(), by_hand.begin(), by_hand.end(),
                    [](const auto& a, const auto& b) { return std::abs(a.gap_m - b.gap_m) < 1e-9; });
}

void time_finding(benchmark::State& bench, const FindingMethod& method, const KnownObject& object,
                  const Eigen::Matrix3Xd& controls_m, const GripTask& task, const std::vector<Grip>& grips) {
  std::vector<FoundContact> found;
  std::vector<double> times_us;
  for (const Grip& grip : grips) {  // Not timed: memory is taken, caches are filled.
    found.clear();
    method.find(grip, found);
  }
  std::size_t i = 0;
  for (auto _ : bench) {
    found.clear();
    Stopwatch watch;
    method.find(grips[i], found);
    const double s = watch.lap();
    benchmark::DoNotOptimize(found.data());
    bench.SetIterationTime(s);
    times_us.push_back(1e6 * s);
    i = (i + 1) % grips.size();
  }
  // Exact distances are dear: some grips are enough.
  const std::vector<Grip> some(grips.begin(), grips.begin() + std::min<std::ptrdiff_t>(32, std::ssize(grips)));
  const FindingRecord record = measure_finding(method, object, controls_m, task, some, 0);
  bench.counters["p50_us"] = percentiles(times_us).p50;
  bench.counters["found"] = record.contacts;
  bench.counters["there"] = record.wanted;
  bench.counters["gap_error_um"] = record.mean_error_um;
  bench.counters["worst_um"] = record.max_error_um;
}

void find_contacts_of(benchmark::State& bench, Shape shape, Start start) {
  const GripTask task{.per_finger = bench.range(0)};
  const KnownObject& object = object_of(shape, bench.range(1));
  const Eigen::Matrix3Xd& controls_m = controls_of(bench.range(2));
  const std::vector<Grip>& grips = grips_of(shape, task, bench.range(2), start);
  // Made once, although Google Benchmark begins several times.
  static std::map<std::tuple<Shape, Start, long, long, long>, FindingMethod> made;
  const auto [at, is_new] =
      made.try_emplace({shape, start, bench.range(0), bench.range(1), bench.range(2)}, FindingMethod{});
  if (is_new) at->second = our_finding(object, controls_m, task, start == Start::kCold);
  const FindingMethod& method = at->second;
  time_finding(bench, method, object, controls_m, task, grips);
  if (!as_by_hand(method, object, controls_m, task, grips.front())) bench.SkipWithError("not all, or wrong contacts");
}

void sizes(benchmark::internal::Benchmark* bench) {
  for (const long per_finger : {5, 10, 20, 40}) bench->Args({per_finger, 1, 320});
  for (const long times : {4, 16}) bench->Args({20, times, 320});
  for (const long controls : {1280, 5120}) bench->Args({20, 1, controls});
  bench->ArgNames({"per_finger", "points_x", "controls"})->UseManualTime()->Unit(benchmark::kMicrosecond);
}
BENCHMARK_CAPTURE(find_contacts_of, box_warm, Shape::kBox, Start::kWarm)->Apply(sizes);
BENCHMARK_CAPTURE(find_contacts_of, box_cold, Shape::kBox, Start::kCold)->Apply(sizes);
BENCHMARK_CAPTURE(find_contacts_of, scan_warm, Shape::kScan, Start::kWarm)->Apply(sizes);
BENCHMARK_CAPTURE(find_contacts_of, scan_cold, Shape::kScan, Start::kCold)->Apply(sizes);

/// One query, at places near the whole surface, from 2 mm inside to 0.3 mm outside.
void distance(benchmark::State& bench, Shape shape) {
  const KnownObject& object = object_of(shape, bench.range(0));
  static std::map<std::pair<Shape, long>, FindingMethod> made;
  const auto [at, is_new] = made.try_emplace({shape, bench.range(0)}, FindingMethod{});
  if (is_new) at->second = our_finding(object, {}, {}, true);
  const FindingMethod& method = at->second;
  DistanceRecord record;
  for (auto _ : bench) {
    record = measure_distance(method, object, 15);
    bench.SetIterationTime(1e-9 * record.ns);
  }
  bench.counters["error_um"] = record.mean_error_um;
  bench.counters["worst_um"] = record.max_error_um;
  if (record.answered < 1.0) bench.SkipWithError("no answer near the surface");
}
void densities(benchmark::internal::Benchmark* bench) {
  // One iteration is already a median of many batches.
  bench->Arg(1)->Arg(4)->Arg(16)->ArgName("points_x")->Iterations(1)->UseManualTime();
}
BENCHMARK_CAPTURE(distance, box, Shape::kBox)->Apply(densities);
BENCHMARK_CAPTURE(distance, scan, Shape::kScan)->Apply(densities);

/// The same grips at 20 contacts a finger by other methods. The label says what each does not compute.
void find_by(benchmark::State& bench, Shape shape, const FindingRecipe& recipe) {
  const GripTask task;
  const KnownObject& object = object_of(shape, 1);
  const Eigen::Matrix3Xd& controls_m = controls_of(320);
  static std::map<std::pair<Shape, std::string>, FindingMethod> made;
  const auto [at, is_new] = made.try_emplace({shape, recipe.name}, FindingMethod{});
  if (is_new) at->second = recipe.make(object, controls_m, task);
  const FindingMethod& method = at->second;
  time_finding(bench, method, object, controls_m, task, grips_of(shape, task, 320, Start::kCold));
  bench.counters["prepare_ms"] = method.prepare_ms;
  bench.counters["memory_MB"] = method.memory_MB;
  bench.SetLabel("does not compute: " + method.lacks);
}

const bool registered = [] {
  for (const auto& [shape, name] : {std::pair{Shape::kBox, "box"}, std::pair{Shape::kScan, "scan"}}) {
    for (const FindingRecipe& recipe : other_findings(shape == Shape::kBox)) {
      benchmark::RegisterBenchmark(("find_by/" + std::string(name) + "_cold/" + recipe.name).c_str(),
                                   [shape = shape, recipe](benchmark::State& bench) { find_by(bench, shape, recipe); })
          ->UseManualTime()
          ->Unit(benchmark::kMicrosecond);
    }
  }
  return true;
}();

}  // namespace
}  // namespace thenar
