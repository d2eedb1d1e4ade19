// SPDX-License-Identifier: Apache-2.0
#include "collision/point_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <stdexcept>

namespace thenar {
namespace {

using Eigen::Index;

/// Returns the begin of the right child of a node with so many leaves.
Index middle(const TreeNode& node, Index leaves) {
  return node.begin + (node.end - node.begin) * (leaves / 2) / leaves;
}

void order_node(const Eigen::Matrix3Xd& points_m, const TreeNode& node, Index leaves, std::vector<Index>& order) {
  const auto at = [&](Index place) { return order.begin() + place; };
  if (leaves == 1) {
    std::sort(at(node.begin), at(node.end));
    return;
  }
  Eigen::AlignedBox3d box;
  for (Index k = node.begin; k < node.end; ++k) box.extend(points_m.col(order[k]));
  Index axis = 0;
  box.sizes().maxCoeff(&axis);

  const Index half = middle(node, leaves);
  std::nth_element(at(node.begin), at(half), at(node.end), [&](Index i, Index j) {
    const double x_i = points_m(axis, i), x_j = points_m(axis, j);
    return x_i < x_j || (x_i == x_j && i < j);
  });
  order_node(points_m, {node.begin, half}, leaves / 2, order);
  order_node(points_m, {half, node.end}, leaves - leaves / 2, order);
}

void collect(const TreeNode& node, Index leaves, Index most, std::vector<TreeNode>& nodes) {
  if (leaves <= most) {
    nodes.push_back(node);
    return;
  }
  const Index half = middle(node, leaves);
  collect({node.begin, half}, leaves / 2, most, nodes);
  collect({half, node.end}, leaves - leaves / 2, most, nodes);
}

}  // namespace

std::vector<Index> order_by_leaves(const Eigen::Matrix3Xd& points_m, Index leaves) {
  if (leaves < 1 || leaves > points_m.cols()) {
    throw std::invalid_argument("order_by_leaves: leaves must be between 1 and the number of points");
  }
  std::vector<Index> order(points_m.cols());
  std::iota(order.begin(), order.end(), Index{0});
  order_node(points_m, {0, points_m.cols()}, leaves, order);
  return order;
}

std::vector<TreeNode> tree_nodes(Index points, Index leaves, Index most) {
  std::vector<TreeNode> nodes;
  collect({0, points}, leaves, most, nodes);
  return nodes;
}

}  // namespace thenar
