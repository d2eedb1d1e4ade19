// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/pulp.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "collision/point_tree.h"
#include "collision/shapes.h"
#include "collision/surface_cells.h"
#include "collision/voronoi_cells.h"
#include "engine/hand/hand.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

/// The outward normal at the centroid of a node's samples.
Vector3d direction(const Pulp& pulp, const TreeNode& node) {
  Vector3d sum = Vector3d::Zero();
  for (Index k = node.begin; k < node.end; ++k) sum += pulp.surface.points_m.col(pulp.order[k]) - pulp.centre_m;
  // A node all around the sphere, as the root is, has its centroid near the centre, and perhaps at it.
  if (sum.norm() < 1e-6 * pulp.radius_m) sum = pulp.surface.normals.col(pulp.order[node.begin]);
  return sum.normalized();
}

// Lloyd's iteration makes cells as alike as the tree's nodes are not: with 15 to 60 candidates, it takes a third of the
// ripple out of the force of a pulp that rolls. More steps gain no more.
constexpr int kLloydSteps = 3;

/// Where a node's samples are in the mean, about the centre.
Vector3d middle_m(const Pulp& pulp, const TreeNode& node) {
  Vector3d sum = Vector3d::Zero();
  for (Index k = node.begin; k < node.end; ++k) sum += pulp.surface.points_m.col(pulp.order[k]) - pulp.centre_m;
  sum /= static_cast<double>(node.end - node.begin);
  // As with a sphere: of a node all around there is no such place.
  if (sum.norm() < 1e-6 * pulp.radius_m) sum = pulp.surface.points_m.col(pulp.order[node.begin]) - pulp.centre_m;
  return sum;
}

/// The control points of these nodes on the surface of a shape.
void set_controls(Pulp& pulp, const PulpShape& shape, const std::vector<TreeNode>& nodes) {
  const Index n = std::ssize(nodes);
  Eigen::Matrix3Xd points_m(3, n), normals(3, n);
  const auto put = [&](Index i, const Vector3d& x_m) {
    const PulpPlace place = nearest_place(shape, x_m);
    points_m.col(i) = place.point_m;
    normals.col(i) = place.normal;
  };
  const OntoSurface onto = [&shape](const Vector3d& x_m) { return nearest_place(shape, x_m).point_m; };
  for (Index i = 0; i < n; ++i) put(i, middle_m(pulp, nodes[i]));
  const double whole_m2 = area_m2(shape);
  for (int k = 0; k < kLloydSteps; ++k) {
    const SurfaceCells cells = surface_cells(points_m, normals, {}, whole_m2);
    for (Index i = 0; i < n; ++i) put(i, cells.centroids_m.col(i));
  }
  pulp.area_m2 = surface_cells(points_m, normals, onto, whole_m2).areas_m2;
  pulp.control_normals = normals.transpose();
  pulp.control_points_m = points_m.colwise() + pulp.centre_m;
}

double gaussian_kernel(const Pulp& pulp, double squared_m2) {
  constexpr double kSigma2PerArea = 0.36;        // Force within 7 % of Hertz's from 30 candidates, 1 % from 120.
  constexpr double kDepthPerRadius = 1.0 / 8.0;  // Of the calibration: Hertz's law still holds there.
  // Of another shape the radius of the sphere that has its area.
  const double radius_m = pulp.shape ? std::sqrt(pulp.area_m2.sum() / (4.0 * std::numbers::pi)) : pulp.radius_m;
  const double a = std::sqrt(kDepthPerRadius) * radius_m;
  const double sigma2 = kSigma2PerArea * pulp.area_m2.mean();
  return 3.0 * a / (8.0 * pulp.material.reduced_modulus_Pa * sigma2) * std::exp(-squared_m2 / (2.0 * sigma2));
}

}  // namespace

PulpMaterial material_of(const Fingertip& tip, PulpMaterial scenes) {
  scenes.reduced_modulus_Pa = tip.reduced_modulus_Pa.value_or(scenes.reduced_modulus_Pa);
  scenes.poisson = tip.poisson.value_or(scenes.poisson);
  scenes.relaxation_s = tip.relaxation_s.value_or(scenes.relaxation_s);
  return scenes;
}

Pulp make_spherical_pulp(const Vector3d& centre_m, double radius_m, Index points, Index leaves,
                         const PulpMaterial& material) {
  return make_pulp(centre_m, radius_m, std::nullopt, points, leaves, material);
}

Pulp make_pulp(const Vector3d& centre_m, double radius_m, const std::optional<PulpShape>& shape, Index points,
               Index leaves, const PulpMaterial& material) {
  PointCloud surface = shape ? sample_pulp(*shape, points) : sample_sphere(radius_m, points);
  surface.points_m.colwise() += centre_m;
  std::vector<Index> order = order_by_leaves(surface.points_m, leaves);
  Pulp pulp{std::move(surface), leaves, std::move(order), centre_m, radius_m, material};
  pulp.shape = shape;
  const double nu = material.poisson;
  pulp.tangential = (2.0 - nu) / (2.0 * (1.0 - nu));
  set_level(pulp, 0);
  return pulp;
}

void set_level(Pulp& pulp, int level) {
  const Index part = Index{1} << level;
  const std::vector<TreeNode> nodes = tree_nodes(std::ssize(pulp.order), pulp.leaves, part + part / 2);

  if (pulp.shape) {
    set_controls(pulp, *pulp.shape, nodes);
    fill_compliance(pulp);
    return;
  }
  const Index n = std::ssize(nodes);
  Eigen::Matrix3Xd directions(3, n);
  for (Index i = 0; i < n; ++i) directions.col(i) = direction(pulp, nodes[i]);
  for (int k = 0; k < kLloydSteps; ++k) directions = voronoi_cells(directions).centroids;
  pulp.control_normals = directions.transpose();
  pulp.control_points_m = (pulp.radius_m * directions).colwise() + pulp.centre_m;
  pulp.area_m2 = pulp.radius_m * pulp.radius_m * voronoi_cells(directions).areas;

  fill_compliance(pulp);
}

PulpCompliance pulp_compliance(const Pulp& pulp, const PulpPatch& i, const PulpPatch& j) {
  const double squared_m2 = (i.p_m - j.p_m).squaredNorm(), kappa = 2.0 * (pulp.tangential - 1.0);
  if (pulp.material.kernel == PulpKernel::kGaussian) {
    const double k = gaussian_kernel(pulp, squared_m2);
    return {k, 0.5 * kappa * k, 0.0};
  }
  const double k = half_space_kernel(pulp.material, squared_m2, i.area_m2, j.area_m2);
  const double rho = 1.0 / (std::numbers::pi * pulp.material.reduced_modulus_Pa * k);
  const double s = std::sqrt(0.5 * (i.area_m2 + j.area_m2)) / kHexagonal;
  return {k, kappa * k * s / (rho + s), kappa * k / ((rho + s) * (rho + s))};
}

void fill_compliance(Pulp& pulp) {
  const Index n = pulp.controls();
  for (Eigen::MatrixXd* part : {&pulp.kernel, &pulp.a, &pulp.b}) part->resize(n, n);
  const auto set = [&](Eigen::MatrixXd& part, Index i, Index j, double value) { part(i, j) = part(j, i) = value; };
  const auto patch = [&](Index i) -> PulpPatch { return {pulp.control_points_m.col(i), pulp.area_m2[i]}; };
  for (Index j = 0; j < n; ++j) {
    for (Index i = 0; i <= j; ++i) {
      const PulpCompliance entry = pulp_compliance(pulp, patch(i), patch(j));
      set(pulp.kernel, i, j, entry.k);
      set(pulp.a, i, j, entry.a);
      set(pulp.b, i, j, entry.b);
    }
  }
  pulp.rounded_kernel = pulp.kernel.cast<float>();
}

double retained_share(const PulpMaterial& material, double step_s) {
  return material.relaxation_s > 0.0 ? std::exp(-step_s / material.relaxation_s) : 0.0;
}

double softness(const PulpMaterial& material, double normal_N) {
  return 1.0 / (1.0 + material.stiffening_per_N * normal_N);
}

}  // namespace thenar
