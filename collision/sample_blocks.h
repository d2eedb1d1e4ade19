// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <bit>
#include <vector>

#include "collision/point_cloud.h"

namespace thenar {

/// The samples of a cloud in blocks of eight neighbours under a tree of boxes, for the samples around a point.
///
/// Every node has eight children, one a lane. The tree is implicit: child k of node i is 8 i + k of the level below,
/// down to the blocks. Boxes and queries are floats; a query's radius is grown by more than their rounding.
class SampleBlocks {
 public:
  static constexpr int kLanes = 8;
  using Lanes = Eigen::Array<double, kLanes, 1>;

  /// Up to eight samples, each coordinate contiguous. Unused lanes have no normal and lie too far away to have weight.
  struct Block {
    Lanes x, y, z;
    Lanes n_x, n_y, n_z;

    [[nodiscard]] Eigen::Vector3d point_m(int lane) const { return {x[lane], y[lane], z[lane]}; }
    [[nodiscard]] Eigen::Vector3d normal(int lane) const { return {n_x[lane], n_y[lane], n_z[lane]}; }
    [[nodiscard]] Lanes squared_distances(const Eigen::Vector3d& p_m) const {
      return (x - p_m.x()).square() + (y - p_m.y()).square() + (z - p_m.z()).square();
    }
    [[nodiscard]] Lanes cosines(const Eigen::Vector3d& n) const { return n_x * n.x() + n_y * n.y() + n_z * n.z(); }
    /// Returns the heights of the samples over the plane through p with normal n.
    [[nodiscard]] Lanes heights(const Eigen::Vector3d& p_m, const Eigen::Vector3d& n) const {
      return (x - p_m.x()) * n.x() + (y - p_m.y()) * n.y() + (z - p_m.z()) * n.z();
    }
  };

  /// The sample nearest to a point.
  struct Nearest {
    Eigen::Index sample = -1;  ///< The first one if several are as near; -1 if none lies within the reach.
    double distance_m = 0.0;   ///< Its distance; without one, none is nearer than this.
    double free_m = 0.0;       ///< While the point moves less, the sample remains the nearest.
  };

  /// Returns the order of a cloud's samples in blocks: neighbours in one block, neighbouring blocks in one node.
  [[nodiscard]] static std::vector<Eigen::Index> order(const Eigen::Matrix3Xd& points_m);

  /// Requires a cloud in that order, of one sample at least.
  explicit SampleBlocks(const PointCloud& cloud);

  /// Calls visit(block, number) for every block that may hold samples within the radius of c, in their order. Block b
  /// holds the samples 8 b .. 8 b + 7.
  template <typename Visit>
  void for_each_near(const Eigen::Vector3d& c_m, double radius_m, Visit visit) const {
    const Query query = query_at(c_m);
    visit_within(static_cast<int>(levels_.size()) - 1, 0, query, inflated_squared(radius_m), visit);
  }

  /// Finds the sample nearest to x within the reach, ties by number. The search extends `beyond_m` past it: free_m is
  /// the distance to where another sample is as near, or half of `beyond_m`. A `hint` is a guess, a sample's number or
  /// -1: a good one shortens the search, none changes the result.
  [[nodiscard]] Nearest nearest(const Eigen::Vector3d& x_m, double reach_m, double beyond_m = 0.0,
                                Eigen::Index hint = -1) const noexcept;

  [[nodiscard]] const std::vector<Block>& blocks() const { return blocks_; }

 private:
  using Floats = Eigen::Array<float, kLanes, 1>;

  /// A point relative to the middle of the cloud.
  struct Query {
    float x, y, z;
  };

  /// A node: the boxes of its eight children.
  struct Node {
    Floats low_x, low_y, low_z, high_x, high_y, high_z;

    [[nodiscard]] Floats squared_distances(const Query& p) const {
      const Floats x = (low_x - p.x).max(p.x - high_x).max(0.0F);
      const Floats y = (low_y - p.y).max(p.y - high_y).max(0.0F);
      const Floats z = (low_z - p.z).max(p.z - high_z).max(0.0F);
      return x * x + y * y + z * z;
    }
  };
  struct Search;

  [[nodiscard]] Query query_at(const Eigen::Vector3d& p_m) const {
    const Eigen::Vector3f p = (p_m - middle_m_).cast<float>();
    return {p.x(), p.y(), p.z()};
  }
  /// Returns the square of a radius, enlarged by the largest rounding of a distance to floats.
  [[nodiscard]] float inflated_squared(double radius_m) const {
    const double grown_m = radius_m * (1.0 + 1e-5) + rounding_m_;
    return static_cast<float>(grown_m * grown_m);
  }
  /// Returns the lanes not above a limit, as bits.
  [[nodiscard]] static unsigned not_above(const Floats& lanes, float limit);

  template <typename Visit>
  void visit_within(int level, Eigen::Index node, const Query& query, float limit, Visit& visit) const {
    for (unsigned hits = not_above(levels_[level][node].squared_distances(query), limit); hits != 0; hits &= hits - 1) {
      const Eigen::Index child = kLanes * node + std::countr_zero(hits);
      if (level == 0) {
        visit(blocks_[child], child);
      } else {
        visit_within(level - 1, child, query, limit, visit);
      }
    }
  }
  void search(int level, Eigen::Index node, Search& best) const noexcept;

  std::vector<Block> blocks_;
  std::vector<std::vector<Node>> levels_;  // [0]: over the blocks; the last has one node
  Eigen::Vector3d middle_m_;
  double rounding_m_;
};

}  // namespace thenar
