// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/cases/known_objects.h"
#include "collision/contact_finding.h"
#include "collision/implicit_surface.h"
#include "engine/grasp/stopwatch.h"

namespace thenar {

/// What a method says of one contact: a point of the finger, object frame, and how far it is from the object.
struct FoundContact {
  Eigen::Vector3d point_m;
  double gap_m;
  bool operator<(const FoundContact& other) const { return gap_m < other.gap_m; }
};

/// Finds the contacts of a grip by one method, on the object and control points that it was made for.
using ContactFinder = std::function<void(const Grip& grip, std::vector<FoundContact>& found)>;
/// The distance of one point; nothing where the method has no answer.
using PointDistance = std::function<std::optional<double>(const Eigen::Vector3d& p_m)>;

/// A way to find contacts, made ready for one object: ours and those of others.
struct FindingMethod {
  std::string lacks;        ///< What it does not compute of what a contact needs; empty: nothing.
  double prepare_ms = 0.0;  ///< To make it ready from the samples, the mesh or the exact distance.
  double memory_MB = 0.0;   ///< What that left on the heap.
  ContactFinder find;
  PointDistance distance;  ///< Not every method has one.
  bool is_signed = true;   ///< Whether `distance` tells inside from outside.
};

/// Ours on the object's cloud, with this error allowed; 0: none. Cold: what is remembered from the last grip is
/// forgotten before every one.
[[nodiscard]] FindingMethod our_finding(const KnownObject& object, const Eigen::Matrix3Xd& controls_m,
                                        const GripTask& task, bool cold, double distance_error_m = 1e-6);

/// A grid of exact distances with trilinear interpolation: what rigid objects are usually given. Its gradient is the
/// interpolant's own.
[[nodiscard]] FindingMethod grid_finding(const KnownObject& object, const Eigen::Matrix3Xd& controls_m,
                                         const GripTask& task, double cell_m);

/// A method by its name, before anything is computed for it.
struct FindingRecipe {
  std::string name;
  std::function<FindingMethod(const KnownObject&, const Eigen::Matrix3Xd&, const GripTask&)> make;
  bool knows_distances = false;  ///< Of single points.
};

/// Distance grids, and those of other projects, from Debian's packages (bench/peers/), if built with -DTHENAR_PEERS=ON.
[[nodiscard]] std::vector<FindingRecipe> other_findings(bool box);

/// nanoflann, FCL and Bullet; for a box all of them.
[[nodiscard]] std::vector<FindingRecipe> finding_peers(bool box);
#ifndef THENAR_PEERS
inline std::vector<FindingRecipe> finding_peers(bool) { return {}; }
#endif

/// The contacts of a finger for a method that knows distances of points: control points in the object's bounds, grown
/// by the band, whose distance is below the band; those of least gap.
/// `distance` returns std::optional<SurfaceDistance>.
template <typename Distance>
void find_by_distance(const Eigen::Matrix3Xd& controls_m, const Eigen::Isometry3d& X_SB,
                      const Eigen::AlignedBox3d& bounds, const GripTask& task, Distance&& distance,
                      std::vector<FoundContact>& found) {
  const auto first = std::ssize(found);
  for (Eigen::Index i = 0; i < controls_m.cols(); ++i) {
    const Eigen::Vector3d p = X_SB * controls_m.col(i);
    if (bounds.squaredExteriorDistance(p) >= task.band_m * task.band_m) continue;
    const std::optional<SurfaceDistance> to = distance(p);
    if (to && to->distance_m < task.band_m) found.push_back({p, to->distance_m});
  }
  if (std::ssize(found) - first <= task.per_finger) return;
  std::nth_element(found.begin() + first, found.begin() + first + task.per_finger, found.end());
  found.resize(static_cast<std::size_t>(first + task.per_finger));
}

/// Heap in use [MB].
[[nodiscard]] double heap_MB();

/// What `make` returns, with its time and memory noted in the method that needs it.
template <typename Make>
auto made_ready(FindingMethod& method, Make&& make) {
  const double before_MB = heap_MB();
  Stopwatch watch;
  auto made = make();
  method.prepare_ms = 1e3 * watch.lap();
  method.memory_MB = heap_MB() - before_MB;
  return made;
}

/// A method, and the grips that it is to find the contacts of, one after the other.
struct FindingCase {
  FindingMethod method;
  std::vector<Grip> grips;
};

/// How it did.
struct FindingRecord {
  double us_p50 = 0.0, us_p99 = 0.0;               ///< For the three fingers together.
  double contacts = 0.0;                           ///< Found, mean over the grips.
  double wanted = 0.0;                             ///< Those of the control points that are there, by exact distances.
  double mean_error_um = 0.0, max_error_um = 0.0;  ///< Of the gaps that it gives, against exact ones.
};
/// Of all cases, in turns, after a round that is not timed.
[[nodiscard]] std::vector<FindingRecord> measure_findings(const std::vector<FindingCase>& cases,
                                                          const KnownObject& object, const Eigen::Matrix3Xd& controls_m,
                                                          const GripTask& task, int rounds);

/// How a method's distances of single points are, near the surface: from 2 mm inside to the band outside.
struct DistanceRecord {
  double us = 0.0, us_p99 = 0.0;  ///< Of a query: over batches of some.
  double mean_error_um = 0.0;     ///< Of the size alone if it has no sign.
};
/// Of all methods, in turns.
[[nodiscard]] std::vector<DistanceRecord> measure_distances(const std::vector<FindingMethod>& methods,
                                                            const KnownObject& object, int rounds);

}  // namespace thenar
