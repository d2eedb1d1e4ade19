// SPDX-License-Identifier: Apache-2.0
#include "collision/winding_number.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

namespace {

constexpr Index kLeafTriangles = 8;  // triangles
constexpr double kFarRadii = 2.5;    // radii of a node, from which on its moments stand for it

/// The solid angle of a triangle, seen from the origin [van Oosterom, Strackee 1983].
double solid_angle(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const double u = a.norm(), v = b.norm(), w = c.norm();
  return 2.0 * std::atan2(a.dot(b.cross(c)), u * v * w + a.dot(b) * w + b.dot(c) * u + c.dot(a) * v);
}

}  // namespace

WindingNumber::WindingNumber(const TriangleMesh& mesh) : order_(mesh.triangles.cols()) {
  Matrix3Xd middles_m(3, mesh.triangles.cols());
  for (Index i = 0; i < middles_m.cols(); ++i) {
    middles_m.col(i) = mesh.vertices_m(Eigen::all, mesh.triangles.col(i)).rowwise().mean();
  }
  std::iota(order_.begin(), order_.end(), Index{0});
  split(middles_m);
  corners_m_.resize(3, 3 * middles_m.cols());
  for (Index i = 0; i < middles_m.cols(); ++i) {
    corners_m_.middleCols<3>(3 * i) = mesh.vertices_m(Eigen::all, mesh.triangles.col(order_[i]));
  }
  for (Node& node : nodes_) measure(node);
}

void WindingNumber::split(const Matrix3Xd& middles_m) {
  if (order_.empty()) return;
  nodes_.push_back({.begin = 0, .end = std::ssize(order_)});
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Index begin = nodes_[i].begin, end = nodes_[i].end;
    if (end - begin <= kLeafTriangles) continue;
    Eigen::AlignedBox3d box;
    for (Index k = begin; k < end; ++k) box.extend(middles_m.col(order_[k]));
    Index axis = 0;
    box.sizes().maxCoeff(&axis);
    const Index half = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + half, order_.begin() + end,
                     [&](Index a, Index b) { return middles_m(axis, a) < middles_m(axis, b); });
    nodes_[i].first_child = static_cast<int>(nodes_.size());
    nodes_.push_back({.begin = begin, .end = half});
    nodes_.push_back({.begin = half, .end = end});
  }
}

void WindingNumber::measure(Node& node) const {
  const auto corners_m = corners_m_.middleCols(3 * node.begin, 3 * (node.end - node.begin));
  node.middle_m = 0.5 * (corners_m.rowwise().minCoeff() + corners_m.rowwise().maxCoeff());
  node.radius_m = std::sqrt((corners_m.colwise() - node.middle_m).colwise().squaredNorm().maxCoeff());
  node.area_m2.setZero();
  node.moment_m3.setZero();
  for (Index i = 0; i < corners_m.cols(); i += 3) {
    const Vector3d a = corners_m.col(i), b = corners_m.col(i + 1), c = corners_m.col(i + 2);
    const Vector3d area_m2 = 0.5 * (b - a).cross(c - a);
    node.area_m2 += area_m2;
    node.moment_m3 += ((a + b + c) / 3.0 - node.middle_m) * area_m2.transpose();
  }
}

double WindingNumber::operator()(const Vector3d& point_m) const {
  double angle = 0.0;
  std::vector<int> open;
  if (!nodes_.empty()) open.push_back(0);
  while (!open.empty()) {
    const Node& node = nodes_[open.back()];
    open.pop_back();
    const Vector3d r = node.middle_m - point_m;
    const double distance_m = r.norm();
    if (distance_m > kFarRadii * node.radius_m) {
      // The integral of n . x / |x|^3, expanded about the middle.
      const double cube = distance_m * distance_m * distance_m;
      angle += (node.area_m2.dot(r) + node.moment_m3.trace()) / cube -
               3.0 * r.dot(node.moment_m3 * r) / (cube * distance_m * distance_m);
    } else if (node.first_child > 0) {
      open.push_back(node.first_child);
      open.push_back(node.first_child + 1);
    } else {
      for (Index i = 3 * node.begin; i < 3 * node.end; i += 3) {
        angle +=
            solid_angle(corners_m_.col(i) - point_m, corners_m_.col(i + 1) - point_m, corners_m_.col(i + 2) - point_m);
      }
    }
  }
  return angle / (4.0 * std::numbers::pi);
}

}  // namespace thenar
