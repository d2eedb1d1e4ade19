// SPDX-License-Identifier: Apache-2.0
#include "bench/methods/finding_methods.h"

#include <fmt/format.h>
#include <malloc.h>

#include <cmath>
#include <memory>
#include <stdexcept>

#include "bench/cases/random.h"
#include "engine/loops/percentiles.h"

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

namespace {

/// Distances at the corners of cubic cells around an object.
class DistanceGrid {
 public:
  DistanceGrid(const KnownObject& object, double cell_m) : cell_m_(cell_m) {
    constexpr double kMargin_m = 1e-3;
    const Matrix3Xd& p = object.cloud.points_m;
    low_m_ = p.rowwise().minCoeff().array() - kMargin_m;
    const Vector3d high_m = p.rowwise().maxCoeff().array() + kMargin_m;
    cells_ = ((high_m - low_m_) / cell_m).array().ceil().cast<int>();
    const Index row = cells_.z() + 1, slice = row * (cells_.y() + 1);
    values_m_.resize(static_cast<std::size_t>(slice * (cells_.x() + 1)));
    for (Index x = 0; x <= cells_.x(); ++x) {
      for (Index y = 0; y <= cells_.y(); ++y) {
        for (Index z = 0; z <= cells_.z(); ++z) {
          const Vector3d corner_m = low_m_ + cell_m * Eigen::Vector3<Index>(x, y, z).cast<double>();
          values_m_[static_cast<std::size_t>(slice * x + row * y + z)] =
              static_cast<float>(object.distance_m(corner_m));
        }
      }
    }
  }

  [[nodiscard]] std::optional<SurfaceDistance> distance(const Vector3d& p_m) const {
    const Vector3d at = (p_m - low_m_) / cell_m_;
    const Eigen::Vector3i cell = at.cast<int>();
    if ((at.array() < 0.0).any() || (cell.array() >= cells_.array()).any()) return std::nullopt;
    const Vector3d t = at - cell.cast<double>(), s = Vector3d::Ones() - t;
    const Index row = cells_.z() + 1, slice = row * (cells_.y() + 1);
    const float* const v = &values_m_[static_cast<std::size_t>(slice * cell.x() + row * cell.y() + cell.z())];
    // Along z first, then y, then x.
    const double z00 = s.z() * v[0] + t.z() * v[1], z01 = s.z() * v[row] + t.z() * v[row + 1];
    const double z10 = s.z() * v[slice] + t.z() * v[slice + 1];
    const double z11 = s.z() * v[slice + row] + t.z() * v[slice + row + 1];
    const double d00 = v[1] - v[0], d01 = v[row + 1] - v[row], d10 = v[slice + 1] - v[slice];
    const double d11 = v[slice + row + 1] - v[slice + row];
    const double y0 = s.y() * z00 + t.y() * z01, y1 = s.y() * z10 + t.y() * z11;
    const double distance_m = s.x() * y0 + t.x() * y1;
    const Vector3d n = Vector3d(y1 - y0, s.x() * (z01 - z00) + t.x() * (z11 - z10),
                                s.x() * (s.y() * d00 + t.y() * d01) + t.x() * (s.y() * d10 + t.y() * d11))
                           .normalized();
    return SurfaceDistance{distance_m, p_m - distance_m * n, n};
  }

 private:
  double cell_m_;
  Vector3d low_m_;
  Eigen::Vector3i cells_;
  std::vector<float> values_m_;
};

Eigen::AlignedBox3d bounds_of(const KnownObject& object) {
  const Matrix3Xd& p = object.cloud.points_m;
  return {Vector3d(p.rowwise().minCoeff()), Vector3d(p.rowwise().maxCoeff())};
}

/// Half the radius, as the engine has it.
constexpr double kDeepest_m = 4e-3;

}  // namespace

double heap_MB() {
  const struct mallinfo2 info = mallinfo2();
  return 1e-6 * static_cast<double>(info.uordblks + info.hblkhd);
}

FindingMethod our_finding(const KnownObject& object, const Matrix3Xd& controls_m, const GripTask& task, bool cold,
                          double distance_error_m) {
  struct Ready {
    ImplicitSurface surface;
    Matrix3Xd controls_m;
    std::array<FindingMemory, 3> memory;
    std::vector<ContactCandidate> candidates;
  };
  FindingMethod method;
  auto ready = made_ready(method, [&] {
    auto made = std::make_shared<Ready>(Ready{ImplicitSurface(object.cloud), controls_m, {}, {}});
    made->surface.allow_error(distance_error_m, kDeepest_m + task.band_m);
    return made;
  });
  const ContactFindingSettings settings{task.band_m, kDeepest_m + task.band_m, task.per_finger};
  // Copied from, it leaves what the memory has taken: forgetting allocates nothing.
  const FindingMemory blank;
  method.find = [ready, settings, cold, blank](const Grip& grip, std::vector<FoundContact>& found) {
    for (std::size_t k = 0; k < grip.size(); ++k) {
      if (cold) ready->memory[k] = blank;
      find_contacts(ready->controls_m, grip[k], ready->surface, settings, ready->memory[k], ready->candidates);
      for (const ContactCandidate& c : ready->candidates) {
        found.push_back({grip[k] * ready->controls_m.col(c.control_point), c.gap_m});
      }
    }
  };
  method.distance = [ready, reach_m = settings.reach_m](const Vector3d& p_m) -> std::optional<double> {
    const auto to = ready->surface.distance(p_m, reach_m);
    if (!to) return std::nullopt;
    return to->distance_m;
  };
  return method;
}

FindingMethod grid_finding(const KnownObject& object, const Matrix3Xd& controls_m, const GripTask& task,
                           double cell_m) {
  FindingMethod method;
  method.lacks = "a distance from samples: it is filled from the exact one; objects that deform";
  auto grid = made_ready(method, [&] { return std::make_shared<DistanceGrid>(object, cell_m); });
  method.find = [grid, controls_m, task, bounds = bounds_of(object)](const Grip& grip,
                                                                     std::vector<FoundContact>& found) {
    for (const Eigen::Isometry3d& X : grip) {
      find_by_distance(
          controls_m, X, bounds, task, [&](const Vector3d& p) { return grid->distance(p); }, found);
    }
  };
  method.distance = [grid](const Vector3d& p_m) -> std::optional<double> {
    const auto to = grid->distance(p_m);
    if (!to) return std::nullopt;
    return to->distance_m;
  };
  return method;
}

std::vector<FindingRecipe> other_findings(bool box) {
  std::vector<FindingRecipe> recipes;
  for (const double cell_m : {1e-3, 0.5e-3}) {
    recipes.push_back({fmt::format("distance grid, {:.2g} mm", 1e3 * cell_m),
                       [cell_m](const KnownObject& object, const Matrix3Xd& controls_m, const GripTask& task) {
                         return grid_finding(object, controls_m, task, cell_m);
                       },
                       true});
  }
  for (FindingRecipe& peer : finding_peers(box)) recipes.push_back(std::move(peer));
  return recipes;
}

namespace {

/// Mean and largest error of the gaps, and how many there are and should be.
FindingRecord judge(const FindingCase& c, const KnownObject& object, const Matrix3Xd& controls_m,
                    const GripTask& task) {
  FindingRecord record;
  std::vector<FoundContact> found;
  const double share = 1.0 / static_cast<double>(c.grips.size());
  double sum_um = 0.0, count = 0.0;
  for (const Grip& grip : c.grips) {
    found.clear();
    c.method.find(grip, found);
    for (const FoundContact& contact : found) {
      const double exact_m = object.distance_m(contact.point_m);
      const double error_um = 1e6 * std::abs(contact.gap_m - (c.method.is_signed ? exact_m : std::abs(exact_m)));
      sum_um += error_um;
      count += 1.0;
      record.max_error_um = std::max(record.max_error_um, error_um);
    }
    for (const Eigen::Isometry3d& X : grip) {
      Index there = 0;
      for (Index i = 0; i < controls_m.cols(); ++i) there += object.distance_m(X * controls_m.col(i)) < task.band_m;
      record.wanted += share * static_cast<double>(std::min(there, task.per_finger));
    }
  }
  record.contacts = share * count;
  record.mean_error_um = count > 0.0 ? sum_um / count : 0.0;
  return record;
}

}  // namespace

std::vector<FindingRecord> measure_findings(const std::vector<FindingCase>& cases, const KnownObject& object,
                                            const Matrix3Xd& controls_m, const GripTask& task, int rounds) {
  std::vector<std::vector<double>> times_us(cases.size());
  std::vector<FoundContact> found;
  for (int round = -1; round < rounds; ++round) {
    for (std::size_t c = 0; c < cases.size(); ++c) {
      for (const Grip& grip : cases[c].grips) {
        found.clear();
        Stopwatch watch;
        cases[c].method.find(grip, found);
        const double us = 1e6 * watch.lap();
        if (round >= 0) times_us[c].push_back(us);
      }
    }
  }
  std::vector<FindingRecord> records;
  for (std::size_t c = 0; c < cases.size(); ++c) {
    records.push_back(judge(cases[c], object, controls_m, task));
    const Percentiles us = percentiles(std::move(times_us[c]));
    records.back().us_p50 = us.p50;
    records.back().us_p99 = us.p99;
  }
  return records;
}

std::vector<DistanceRecord> measure_distances(const std::vector<FindingMethod>& methods, const KnownObject& object,
                                              int rounds) {
  constexpr int kPoints = 2000;
  Random random(7);
  std::vector<Vector3d> points;
  std::vector<double> exact_m;
  for (int k = 0; k < kPoints; ++k) {
    const Index i = random.whole(Index{0}, object.cloud.points_m.cols() - 1);
    points.push_back(object.cloud.points_m.col(i) + random.uniform(-2e-3, 0.3e-3) * object.cloud.normals.col(i));
    exact_m.push_back(object.distance_m(points.back()));
  }
  // In batches so short that other programs seldom interrupt one, and so long that reading the clock does not count.
  constexpr int kBatch = 50;
  std::vector<std::vector<double>> times_us(methods.size());
  double sum_m = 0.0;  // Keeps the compiler from leaving the work out.
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t m = 0; m < methods.size(); ++m) {
      for (int first = 0; first < kPoints; first += kBatch) {
        Stopwatch watch;
        for (int k = first; k < first + kBatch; ++k) sum_m += methods[m].distance(points[k]).value_or(0.0);
        times_us[m].push_back(1e6 * watch.lap() / kBatch);
      }
    }
  }
  if (!std::isfinite(sum_m)) throw std::runtime_error("a distance is not a number");
  std::vector<DistanceRecord> records;
  for (std::size_t m = 0; m < methods.size(); ++m) {
    double sum_um = 0.0, answered = 0.0;
    for (int k = 0; k < kPoints; ++k) {
      const auto distance_m = methods[m].distance(points[k]);
      if (!distance_m) continue;
      sum_um += 1e6 * std::abs(*distance_m - (methods[m].is_signed ? exact_m[k] : std::abs(exact_m[k])));
      ++answered;
    }
    const Percentiles us = percentiles(std::move(times_us[m]));
    records.push_back({us.p50, us.p99, sum_um / answered});
  }
  return records;
}

}  // namespace thenar
