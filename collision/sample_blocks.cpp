// SPDX-License-Identifier: Apache-2.0
#include "collision/sample_blocks.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#ifdef __AVX2__
#include <immintrin.h>
#endif

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr int kLanes = SampleBlocks::kLanes;

// Coordinate of unused lanes [m]: beyond any support, with a finite square.
constexpr double kFarAway = 1e30;

/// Sorts order[begin .. end) into blocks: the left part gets the largest power of two of them that is less than all,
/// so that nodes and blocks are full but for the last.
void sort_into_blocks(const Eigen::Matrix3Xd& points_m, Index* begin, Index* end) {
  const Index blocks = (end - begin + kLanes - 1) / kLanes;
  if (blocks <= 1) {
    std::sort(begin, end);
    return;
  }
  Eigen::AlignedBox3d box;
  for (const Index* i = begin; i != end; ++i) box.extend(Vector3d(points_m.col(*i)));
  Index axis = 0;
  box.sizes().maxCoeff(&axis);

  Index* middle = begin + kLanes * static_cast<Index>(std::bit_ceil(static_cast<std::size_t>(blocks)) / 2);
  std::nth_element(begin, middle, end, [&](Index i, Index j) {
    const double x_i = points_m(axis, i), x_j = points_m(axis, j);
    return x_i < x_j || (x_i == x_j && i < j);
  });
  sort_into_blocks(points_m, begin, middle);
  sort_into_blocks(points_m, middle, end);
}

}  // namespace

std::vector<Index> SampleBlocks::order(const Eigen::Matrix3Xd& points_m) {
  std::vector<Index> order(points_m.cols());
  std::iota(order.begin(), order.end(), Index{0});
  sort_into_blocks(points_m, order.data(), order.data() + order.size());
  return order;
}

SampleBlocks::SampleBlocks(const PointCloud& cloud) {
  const Eigen::Matrix3Xd &p = cloud.points_m, &n = cloud.normals;
  const Vector3d low_m = p.rowwise().minCoeff(), high_m = p.rowwise().maxCoeff();
  middle_m_ = 0.5 * (low_m + high_m);
  // A float's last bit is 6e-8 of a coordinate; a few of them meet in a distance.
  rounding_m_ = 1e-6 * (high_m - low_m).norm();

  const auto lanes = [](const auto& row, Index begin, Index used, double unused) {
    Lanes filled = Lanes::Constant(unused);
    filled.head(used) = row.segment(begin, used).transpose();
    return filled;
  };
  std::vector<Eigen::AlignedBox3f> boxes;
  for (Index i = 0; i < p.cols(); i += kLanes) {
    const Index used = std::min<Index>(kLanes, p.cols() - i);
    blocks_.push_back({lanes(p.row(0), i, used, kFarAway), lanes(p.row(1), i, used, 0.0), lanes(p.row(2), i, used, 0.0),
                       lanes(n.row(0), i, used, 0.0), lanes(n.row(1), i, used, 0.0), lanes(n.row(2), i, used, 0.0)});
    Eigen::AlignedBox3f box;
    for (Index k = i; k < i + used; ++k) box.extend(Eigen::Vector3f((p.col(k) - middle_m_).cast<float>()));
    boxes.push_back(box);
  }
  do {
    std::vector<Eigen::AlignedBox3f> parents((boxes.size() + kLanes - 1) / kLanes);
    // A child that is not there is infinitely far.
    const Floats no_low = Floats::Constant(std::numeric_limits<float>::infinity()), no_high = -no_low;
    std::vector<Node> level(parents.size(), Node{no_low, no_low, no_low, no_high, no_high, no_high});
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      Node& node = level[i / kLanes];
      const auto lane = static_cast<Index>(i % kLanes);
      const Eigen::Vector3f &low = boxes[i].min(), &high = boxes[i].max();
      node.low_x[lane] = low.x(), node.low_y[lane] = low.y(), node.low_z[lane] = low.z();
      node.high_x[lane] = high.x(), node.high_y[lane] = high.y(), node.high_z[lane] = high.z();
      parents[i / kLanes].extend(boxes[i]);
    }
    levels_.push_back(std::move(level));
    boxes = std::move(parents);
  } while (boxes.size() > 1);
}

unsigned SampleBlocks::not_above(const Floats& lanes, float limit) {
#ifdef __AVX2__
  const __m256 below = _mm256_cmp_ps(_mm256_load_ps(lanes.data()), _mm256_set1_ps(limit), _CMP_LE_OQ);
  return static_cast<unsigned>(_mm256_movemask_ps(below));
#else
  unsigned bits = 0;
  for (int k = 0; k < kLanes; ++k) bits |= (lanes[k] <= limit ? 1U : 0U) << k;
  return bits;
#endif
}

/// The state of a search for the nearest sample.
struct SampleBlocks::Search {
  const SampleBlocks& samples;
  Vector3d x_m;
  double beyond_m;
  Query query;
  double squared;  // of the nearest sample
  Index sample;
  double limit_squared;  // farther samples do not matter
  float float_limit;
  // Blocks met; further ones are not stored.
  std::array<Index, 64> met;
  std::size_t count;

  void limit_to(double distance_m) {
    limit_squared = std::min(limit_squared, distance_m * distance_m);
    float_limit = std::min(float_limit, samples.inflated_squared(distance_m));
  }

  void meet(Index number) {
    const Lanes from_x = samples.blocks_[number].squared_distances(x_m);
    const double least = from_x.minCoeff();
    if (!(least <= limit_squared)) return;
    if (count < met.size()) met[count] = number;
    ++count;
    if (!(least <= squared)) return;
    int lane = 0;
    while (from_x[lane] != least) ++lane;
    // Blocks come in any order.
    if (least < squared || kLanes * number + lane < sample) sample = kLanes * number + lane;
    if (!(least < squared)) return;
    squared = least;
    // Rounded up: those as near as this one count, too.
    limit_to((std::sqrt(squared) + beyond_m) * (1.0 + 1e-15));
  }

  /// Returns the least distance to a plane on which another sample is as near: (|x - p_j|^2 - |x - p_i|^2) / 2 |p_j -
  /// p_i|.
  [[nodiscard]] double free_m() const {
    if (count > met.size()) return 0.0;
    const Vector3d p_m = samples.blocks_[sample / kLanes].point_m(static_cast<int>(sample % kLanes));
    Lanes least = Lanes::Constant(0.5 * beyond_m);
    for (std::size_t k = 0; k < count; ++k) {
      const Block& block = samples.blocks_[met[k]];
      const Lanes farther = block.squared_distances(x_m) - squared, apart = block.squared_distances(p_m);
      // The sample itself, and others at its position, are never nearer.
      least = (apart > 0.0).select((0.5 * farther / apart.sqrt()).min(least), least);
    }
    return least.minCoeff();
  }
};

void SampleBlocks::search(int level, Index node, Search& best) const noexcept {
  const Floats squared = levels_[level][node].squared_distances(best.query);
  // The nearest first: its samples exclude the others.
  std::array<int, kLanes> turn;
  int count = 0;
  for (unsigned hits = not_above(squared, best.float_limit); hits != 0; hits &= hits - 1) {
    const int lane = std::countr_zero(hits);
    int k = count++;
    for (; k > 0 && squared[turn[k - 1]] > squared[lane]; --k) turn[k] = turn[k - 1];
    turn[k] = lane;
  }
  for (int k = 0; k < count; ++k) {
    if (squared[turn[k]] > best.float_limit) return;
    const Index child = kLanes * node + turn[k];
    if (level == 0) {
      best.meet(child);
    } else {
      search(level - 1, child, best);
    }
  }
}

SampleBlocks::Nearest SampleBlocks::nearest(const Vector3d& x_m, double reach_m, double beyond_m,
                                            Index hint) const noexcept {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  Search best{.samples = *this,
              .x_m = x_m,
              .beyond_m = beyond_m,
              .query = query_at(x_m),
              .squared = kNone,
              .sample = -1,
              .limit_squared = kNone,
              .float_limit = std::numeric_limits<float>::infinity(),
              .met = {},
              .count = 0};
  double within_m = reach_m;
  if (hint >= 0) {
    // Rounded up: the hint's block gives its distance again, perhaps in another last bit.
    const Vector3d to_hint = blocks_[hint / kLanes].point_m(static_cast<int>(hint % kLanes)) - x_m;
    within_m = std::min(within_m, to_hint.norm() * (1.0 + 1e-12));
  }
  best.limit_to(within_m + beyond_m);
  search(static_cast<int>(levels_.size()) - 1, 0, best);

  if (!(best.squared <= reach_m * reach_m)) {
    return {-1, std::min(std::sqrt(best.squared), std::sqrt(best.limit_squared)), 0.0};
  }
  return {best.sample, std::sqrt(best.squared), beyond_m > 0.0 ? best.free_m() : 0.0};
}

}  // namespace thenar
