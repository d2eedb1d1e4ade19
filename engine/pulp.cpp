#include "engine/pulp.h"

#include <cmath>
#include <numbers>

#include "collision/shapes.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

Pulp make_spherical_pulp(const Vector3d& centre_m, double radius_m, Index points, Index leaves,
                         const PulpMaterial& material) {
  PointCloud surface = sample_sphere(radius_m, points);
  surface.points_m.colwise() += centre_m;
  SphereTree tree(surface, leaves);
  Pulp pulp{std::move(surface), std::move(tree), material, {}, {}, {}, {}, 1.0};
  const double nu = material.poisson;
  pulp.tangential = std::sqrt((2.0 - nu) / (2.0 * (1.0 - nu)));

  const double area_per_point_m2 = 4.0 * std::numbers::pi * radius_m * radius_m / static_cast<double>(points);
  pulp.control_points_m.resize(3, leaves);
  pulp.control_normals.resize(leaves, 3);
  pulp.area_m2.resize(leaves);
  for (Index i = 0; i < leaves; ++i) {
    const SphereTree::Node& leaf = pulp.tree.nodes()[pulp.tree.leaves()[i]];
    pulp.control_points_m.col(i) = pulp.surface.points_m.col(leaf.representative);
    pulp.control_normals.row(i) = pulp.surface.normals.col(leaf.representative).transpose();
    pulp.area_m2[i] = area_per_point_m2 * static_cast<double>(leaf.end - leaf.begin);
  }

  pulp.kernel.resize(leaves, leaves);
  for (Index j = 0; j < leaves; ++j) {
    for (Index i = 0; i < leaves; ++i) {
      const double r2 = (pulp.control_points_m.col(i) - pulp.control_points_m.col(j)).squaredNorm();
      const double s2 = (pulp.area_m2[i] + pulp.area_m2[j]) / (8.0 * std::numbers::pi);
      pulp.kernel(i, j) = 1.0 / (std::numbers::pi * material.reduced_modulus_Pa * std::sqrt(r2 + s2));
    }
  }
  return pulp;
}

double memory(const PulpMaterial& material, double step_s) {
  return material.relaxation_s > 0.0 ? std::exp(-step_s / material.relaxation_s) : 0.0;
}

}  // namespace thenar
