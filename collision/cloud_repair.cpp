// SPDX-License-Identifier: Apache-2.0
#include "collision/cloud_repair.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "collision/point_grid.h"

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

namespace {

// Normals more than 60 degrees apart belong to two faces, as for ImplicitSurface.
constexpr double kLike = 0.5;

// Heights below 0.1 h average out over the support, and occur at a chamfer of a spacing [h].
constexpr double kSlab = 0.1;

// Samples judge each other within 1.5 h: some 35 on a face, 9 in a corner.
constexpr double kSight = 1.5;

// In the air one sample or two may agree with another by chance; more of them make a surface. A corner shows 9.
constexpr int kByChance = 2;
constexpr std::ptrdiff_t kFewest = 5;

// Number of samples for medians over the whole cloud.
constexpr Index kSubset = 1000;

double median(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Returns the median of of(i) over a subset of the samples; negative values are left out.
template <typename Of>
double median_over_subset(Index count, Of of) {
  std::vector<double> values;
  for (Index s = 0; s < std::min(kSubset, count); ++s) {
    const double value = of(s * count / std::min(kSubset, count));
    if (value >= 0.0) values.push_back(value);
  }
  return median(values);
}

/// Returns the vote of the samples near a sample's tangent plane on its normal: 1 right, -1 to be reversed, 0 divided.
double vote(const PointCloud& cloud, const PointGrid& grid, Index candidate, double support_m) {
  // Voters live within 0.1 h = 0.22 spacings of the plane: the other side of a plate does not vote, nor does the other
  // side of an edge, where the cosine is 0.
  const double radius_m = kSight * support_m, height_m = 0.1 * support_m;
  const Vector3d p = cloud.points_m.col(candidate), n = cloud.normals.col(candidate);
  double all = 1.0, ayes = 1.0;  // the candidate's own vote
  grid.for_each_neighbour(candidate, [&](Index j, double distance_m) {
    const double near = 1.0 - distance_m * distance_m / (radius_m * radius_m);
    const double height = (cloud.points_m.col(j) - p).dot(n) / height_m;
    const double level = std::max(0.0, 1.0 - height * height);
    const double cosine = cloud.normals.col(j).dot(n);
    ayes += near * level * cosine;
    all += near * level * std::abs(cosine);
  });
  // Divided: a majority of less than two to one.
  return ayes > all / 3.0 ? 1.0 : ayes < -all / 3.0 ? -1.0 : 0.0;
}

/// Estimates the normal at sample i by a linear fit n_0 + G (p_j - p_i) to those of its face: exact where curvature is
/// constant. Samples beyond an edge are known by their normals, and by their heights over the plane. Zero without
/// neighbours.
Vector3d fitted_normal(const PointCloud& cloud, const PointGrid& grid, Index i, double support_m, double own_weight) {
  const double radius_m = kSight * support_m, height_m = 0.5 * support_m;
  const Vector3d p = cloud.points_m.col(i), n = cloud.normals.col(i);
  const Vector3d t_1 = n.unitOrthogonal(), t_2 = n.cross(t_1);
  Matrix3d A = Matrix3d::Zero(), B = Matrix3d::Zero();
  A(0, 0) = own_weight;
  B.row(0) = own_weight * n.transpose();
  grid.for_each_neighbour(i, [&](Index j, double distance_m) {
    const double like = cloud.normals.col(j).dot(n);
    if (like <= 0.0) return;
    const Vector3d step = (cloud.points_m.col(j) - p);
    const double near = 1.0 - distance_m * distance_m / (radius_m * radius_m);
    const double height = std::min(1.0, std::abs(step.dot(n + cloud.normals.col(j))) / (2.0 * height_m));
    const double weight = near * like * like * (1.0 - height) * (1.0 - height);
    const Vector3d at(1.0, step.dot(t_1) / radius_m, step.dot(t_2) / radius_m);
    A += weight * at * at.transpose();
    B += weight * at * cloud.normals.col(j).transpose();
  });
  if (!(A(0, 0) > 0.5)) return Vector3d::Zero();
  // A face of a single row of samples has no slope across it.
  A.diagonal().tail<2>().array() += 1e-2 * A(0, 0);
  return Vector3d(A.ldlt().solve(B).row(0)).normalized();
}

/// Estimates the typical angle between a normal and its neighbours' estimate of it [rad].
double normal_noise(const PointCloud& cloud, const PointGrid& grid, double support_m) {
  return median_over_subset(cloud.points_m.cols(), [&](Index i) {
    const Vector3d fitted = fitted_normal(cloud, grid, i, support_m, 0.0), n = cloud.normals.col(i);
    return fitted.isZero(0.0) ? -1.0 : std::atan2(fitted.cross(n).norm(), fitted.dot(n));
  });
}

void smooth_normals(PointCloud& cloud, const PointGrid& grid, double support_m) {
  // The first pass tells the faces apart, the others average over them.
  for (int pass = 0; pass < 3; ++pass) {
    Matrix3Xd smooth = cloud.normals;
    for (Index i = 0; i < smooth.cols(); ++i) {
      const Vector3d fitted = fitted_normal(cloud, grid, i, support_m, 1.0);
      if (!fitted.isZero(0.0)) smooth.col(i) = fitted;
    }
    cloud.normals = smooth;
  }
}

/// Returns the height of sample i over the arc that joins it to sample j: over the plane along the bisector of their
/// normals. Zero on planes, spheres and cylinders.
double arc_height_m(const PointCloud& cloud, Index i, Index j) {
  const Vector3d bisector = cloud.normals.col(i) + cloud.normals.col(j);
  return (cloud.points_m.col(i) - cloud.points_m.col(j)).dot(bisector) / bisector.norm();
}

bool alike(const PointCloud& cloud, Index i, Index j) { return cloud.normals.col(i).dot(cloud.normals.col(j)) > kLike; }

/// Estimates the height by which samples scatter about their surface [m], 0 on a clean one.
double position_noise_m(const PointCloud& cloud, const PointGrid& grid) {
  std::vector<double> heights_m;
  return median_over_subset(cloud.points_m.cols(), [&](Index i) {
    heights_m.clear();
    grid.for_each_neighbour(i, [&](Index j, double) {
      if (alike(cloud, i, j)) heights_m.push_back(std::abs(arc_height_m(cloud, i, j)));
    });
    // Of the difference of two normal variables: median 0.67 sqrt(2) sd.
    return heights_m.empty() ? -1.0 : median(heights_m) / (0.6745 * std::numbers::sqrt2);
  });
}

/// Moves every sample along its normal to the mean height of its face. Spheres and cylinders do not shrink by it.
void smooth_points(PointCloud& cloud, const PointGrid& grid, double support_m) {
  Matrix3Xd smooth_m = cloud.points_m;
  for (Index i = 0; i < smooth_m.cols(); ++i) {
    double weight = 1.0, sum_m = 0.0;
    grid.for_each_neighbour(i, [&](Index j, double distance_m) {
      if (distance_m >= support_m || !alike(cloud, i, j)) return;
      const double near = 1.0 - distance_m * distance_m / (support_m * support_m);
      weight += near;
      sum_m += near * arc_height_m(cloud, i, j);
    });
    smooth_m.col(i) -= sum_m / weight * cloud.normals.col(i);
  }
  cloud.points_m = smooth_m;
}

enum class Verdict : char { kKept, kContradicts, kOutlier };

/// Tests for a sample with which others agree only by chance: part of a narrow rim, or wrong.
Verdict judge_lone(const PointCloud& cloud, const PointGrid& grid, Index i, double support_m, double slab_m) {
  const Vector3d p = cloud.points_m.col(i);
  std::vector<Index> neighbours;
  grid.for_each_neighbour(i, [&](Index j, double) { neighbours.push_back(j); });
  // Apart from all surfaces, alone or with a few others.
  if (std::ssize(neighbours) < kFewest) return Verdict::kOutlier;
  // In the air over the planes of its neighbours. A rim lies under them; of a step's riser, only half lie below it.
  const auto above = std::ranges::count_if(
      neighbours, [&](Index j) { return (p - cloud.points_m.col(j)).dot(cloud.normals.col(j)) > slab_m; });
  if (4 * above >= 3 * std::ssize(neighbours)) return Verdict::kOutlier;
  // In, or under, the midst of a face, whose samples lie all around. Those of a rim's face lie to one side, 0.5 h off
  // in the mean.
  for (const Index face : neighbours) {
    Vector3d sum_m = Vector3d::Zero();
    double members = 0.0;
    for (const Index j : neighbours) {
      if (!alike(cloud, face, j)) continue;
      members += 1.0;
      sum_m += cloud.points_m.col(j) - p;
    }
    const Vector3d n = cloud.normals.col(face);
    const bool around = (sum_m - sum_m.dot(n) * n).norm() < 0.3 * support_m * members;
    if (around && 2.0 * members > static_cast<double>(neighbours.size())) return Verdict::kContradicts;
  }
  return Verdict::kKept;
}

Verdict judge(const PointCloud& cloud, const PointGrid& grid, Index i, double support_m, double slab_m) {
  int with = 1, against = 0;
  grid.for_each_neighbour(i, [&](Index j, double) {
    if (!alike(cloud, i, j)) return;
    // Off the arc, and off the plane of j, too, over which a sample of a chamfer does not rise.
    const double height_m = (cloud.points_m.col(i) - cloud.points_m.col(j)).dot(cloud.normals.col(j));
    const bool off = std::abs(height_m) > slab_m && std::abs(arc_height_m(cloud, i, j)) > slab_m;
    ++(off ? against : with);
  });
  // The samples of a rib, a groove or a fillet a spacing wide have a third of the votes.
  if (against > 3 * with) return Verdict::kOutlier;
  return with > 1 + kByChance ? Verdict::kKept : judge_lone(cloud, grid, i, support_m, slab_m);
}

/// Returns the samples in an order in which neighbours in space are neighbours in memory: large clouds are processed
/// several times as fast.
std::vector<Index> order_in_space(const Matrix3Xd& points_m, double cell_m) {
  const Vector3d low_m = points_m.rowwise().minCoeff();
  using Key = std::array<int, 4>;
  std::vector<Key> keys(points_m.cols());
  for (Index i = 0; i < points_m.cols(); ++i) {
    const Eigen::Vector3i cell = ((points_m.col(i) - low_m) / cell_m).cwiseMin(1e9).cast<int>();
    keys[i] = {cell.x(), cell.y(), cell.z(), static_cast<int>(i)};
  }
  std::ranges::sort(keys);
  std::vector<Index> order(keys.size());
  std::ranges::transform(keys, order.begin(), [](const Key& key) { return key[3]; });
  return order;
}

/// Tests whether a sample lies in the middle of one even face, as most do: no sample within h is unlike, or off its
/// arc. Neither its normal nor its position needs further checks.
std::vector<char> find_plain(const PointCloud& cloud, double support_m) {
  if (cloud.points_m.cols() == 0) return {};
  const PointGrid grid(cloud.points_m, support_m);
  std::vector<char> plain(cloud.points_m.cols());
  for (Index i = 0; i < std::ssize(plain); ++i) {
    int with = 0;
    bool all = true;
    grid.for_each_neighbour(i, [&](Index j, double) {
      ++with;
      all = all && alike(cloud, i, j) && std::abs(arc_height_m(cloud, i, j)) < kSlab * support_m;
    });
    plain[i] = all && with >= 7 ? 1 : 0;
  }
  return plain;
}

/// Reverses outvoted normals. All votes precede all changes: the result does not depend on the order.
void turn_outvoted(PointCloud& cloud, const PointGrid& grid, double support_m, const std::vector<char>& plain,
                   std::vector<Verdict>& verdicts, CloudRepair& report) {
  std::vector<Index> outvoted;
  for (Index i = 0; i < cloud.points_m.cols(); ++i) {
    if (plain[i] != 0) continue;
    const double result = vote(cloud, grid, i, support_m);
    if (result < 0.0) outvoted.push_back(i);
    if (result == 0.0) verdicts[i] = Verdict::kContradicts;
  }
  for (const Index i : outvoted) cloud.normals.col(i) *= -1.0;
  report.turned = std::ssize(outvoted);
}

/// Removes and counts the samples that are not kept, here and in the list of their numbers; returns whether there were
/// any.
bool remove(PointCloud& cloud, std::vector<Index>& numbers, const std::vector<Verdict>& verdicts, CloudRepair& report) {
  std::vector<Index> kept;
  kept.reserve(verdicts.size());
  for (Index i = 0; i < std::ssize(verdicts); ++i) {
    if (verdicts[i] == Verdict::kKept) kept.push_back(i);
    if (verdicts[i] == Verdict::kContradicts) ++report.removed;
    if (verdicts[i] == Verdict::kOutlier) ++report.outliers;
  }
  if (kept.size() == verdicts.size()) return false;
  cloud = {cloud.points_m(Eigen::all, kept), cloud.normals(Eigen::all, kept)};
  for (std::size_t k = 0; k < kept.size(); ++k) numbers[k] = numbers[kept[k]];
  numbers.resize(kept.size());
  return true;
}

}  // namespace

CloudRepair repair(PointCloud& original, double support_m) {
  const double sight_m = kSight * support_m;
  const Index count = original.points_m.cols();
  std::vector<Index> numbers = order_in_space(original.points_m, sight_m);
  PointCloud cloud{original.points_m(Eigen::all, numbers), original.normals(Eigen::all, numbers)};

  CloudRepair report;
  std::vector<Verdict> verdicts(count, Verdict::kKept);
  std::vector<char> plain;
  {
    const PointGrid grid(cloud.points_m, sight_m);
    report.normal_noise = normal_noise(cloud, grid, support_m);
    report.smoothed_normals = report.normal_noise > 2.0 * std::numbers::pi / 180.0;
    if (report.smoothed_normals) smooth_normals(cloud, grid, support_m);
    plain = find_plain(cloud, support_m);
    turn_outvoted(cloud, grid, support_m, plain, verdicts, report);
    if (report.smoothed_normals && report.turned > 0) smooth_normals(cloud, grid, support_m);
    report.position_noise_m = position_noise_m(cloud, grid);
  }
  if (remove(cloud, numbers, verdicts, report)) plain = find_plain(cloud, support_m);

  const double slab_m = std::max(kSlab * support_m, 4.0 * report.position_noise_m);
  // An outlier may hide behind another.
  for (int round = 0; round < 3 && !numbers.empty(); ++round) {
    const PointGrid grid(cloud.points_m, sight_m);
    verdicts.assign(numbers.size(), Verdict::kKept);
    for (Index i = 0; i < std::ssize(verdicts); ++i) {
      if (plain[i] == 0) verdicts[i] = judge(cloud, grid, i, support_m, slab_m);
    }
    if (!remove(cloud, numbers, verdicts, report)) break;
    plain = find_plain(cloud, support_m);
  }
  report.doubtful_share = static_cast<double>(report.turned + report.removed) / static_cast<double>(count);

  // Noisy normals alone make arcs of some height.
  report.smoothed_points = report.position_noise_m > std::max(0.02, 0.15 * report.normal_noise) * support_m;
  if (report.smoothed_points && !numbers.empty()) {
    smooth_points(cloud, PointGrid(cloud.points_m, sight_m), support_m);
  }

  // Back in their order.
  std::vector<Index> places(numbers.size());
  std::iota(places.begin(), places.end(), Index{0});
  std::ranges::sort(places, {}, [&](Index k) { return numbers[k]; });
  original = {cloud.points_m(Eigen::all, places), cloud.normals(Eigen::all, places)};
  return report;
}

double covering_support_m(const PointCloud& cloud) {
  // Like sample_spacing_m(), but with 16 neighbours, so that chance does not appear as a sparse region.
  constexpr std::ptrdiff_t kNeighbours = 16;
  const double spacing_m = sample_spacing_m(cloud), radius_m = 5.0 * spacing_m;
  if (!(spacing_m > 0.0))
    throw std::invalid_argument("its points lie in a few places, many in each: leave out the copies");
  const PointGrid grid(cloud.points_m, radius_m);
  std::vector<double> spacings_m, squared;
  const Index count = cloud.points_m.cols(), subset = std::min(kSubset, count);
  for (Index s = 0; s < subset; ++s) {
    const Index i = s * count / subset;
    squared.clear();
    grid.for_each_neighbour(i, [&](Index j, double distance_m) {
      // The other side of a plate; a flipped neighbour lies level.
      const bool opposite = cloud.normals.col(i).dot(cloud.normals.col(j)) < -kLike;
      const double height_m = (cloud.points_m.col(j) - cloud.points_m.col(i)).dot(cloud.normals.col(i));
      if (!opposite || std::abs(height_m) < 0.22 * spacing_m) squared.push_back(distance_m * distance_m);
    });
    const std::ptrdiff_t k = std::min(kNeighbours, std::ssize(squared));
    if (k == kNeighbours) std::nth_element(squared.begin(), squared.begin() + k - 1, squared.end());
    const double disc_m2 = std::numbers::pi * (k == kNeighbours ? squared[k - 1] : radius_m * radius_m);
    spacings_m.push_back(std::sqrt(disc_m2 / (static_cast<double>(k) + 0.5)));
  }
  const auto sparse = spacings_m.begin() + subset * 9 / 10;
  std::nth_element(spacings_m.begin(), sparse, spacings_m.end());
  return 2.2 * (*sparse > 1.25 * spacing_m ? *sparse : spacing_m);
}

}  // namespace thenar
