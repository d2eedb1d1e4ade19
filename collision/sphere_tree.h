#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "collision/point_cloud.h"

namespace thenar {

/// A binary tree of bounding spheres over the samples of a cloud.
///
/// A node of L leaves splits its points along the longest axis of their box in the proportion floor(L/2) : ceil(L/2),
/// so that 2400 points in 320 leaves give 7 or 8 points a leaf. Every sample lies in exactly one leaf. The sample
/// nearest a node's mean represents it. Leaves are a pulp's patches, inner nodes those of its coarser levels of detail.
class SphereTree {
 public:
  struct Node {
    Eigen::Vector3d centre_m;
    double radius_m;
    Eigen::Index begin, end;      ///< Its samples: order()[begin .. end).
    Eigen::Index representative;  ///< Sample index.
    Eigen::Index left, right;     ///< Child nodes; a leaf has left = -1 and right = its leaf number.
    [[nodiscard]] bool is_leaf() const { return left < 0; }
  };

  /// Room for a traversal's stack: both children get half a node's leaves, so paths have at most 1 + log2(leaves)
  /// nodes.
  static constexpr int kMaxDepth = 64;

  /// Throws std::invalid_argument if leaves < 1 or > points.
  SphereTree(const PointCloud& cloud, Eigen::Index leaves);

  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }            ///< Root first.
  [[nodiscard]] const std::vector<Eigen::Index>& order() const { return order_; }    ///< Samples, leaf after leaf.
  [[nodiscard]] const std::vector<Eigen::Index>& leaves() const { return leaves_; }  ///< Node index of each leaf.

 private:
  // Both work on order_[begin .. end); build returns the number of the node it makes, split where the right child
  // begins.
  Eigen::Index build(const Eigen::Matrix3Xd& points_m, Eigen::Index begin, Eigen::Index end, Eigen::Index leaves);
  Eigen::Index split(const Eigen::Matrix3Xd& points_m, Eigen::Index begin, Eigen::Index end, Eigen::Index leaves);

  std::vector<Node> nodes_;
  std::vector<Eigen::Index> order_;
  std::vector<Eigen::Index> leaves_;
};

}  // namespace thenar
