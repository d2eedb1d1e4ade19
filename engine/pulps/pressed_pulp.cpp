// SPDX-License-Identifier: Apache-2.0
#include "engine/pulps/pressed_pulp.h"

#include <algorithm>
#include <cmath>

#include "engine/pulps/elliptic_hertz.h"
#include "solvers/gauss_seidel.h"

namespace thenar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

/// Returns the heights of control points over the plane.
VectorXd gaps_m(const Pulp& pulp, const Vector3d& direction, double depth_m) {
  if (!pulp.shape) {
    return (pulp.radius_m - depth_m - pulp.radius_m * (pulp.control_normals * direction).array()).matrix();
  }
  const VectorXd height_m = (pulp.control_points_m.colwise() - pulp.centre_m).transpose() * direction;
  return (extent_m(*pulp.shape, direction) - depth_m - height_m.array()).matrix();
}

bool is_capsule(const Pulp& pulp) { return pulp.shape && pulp.shape->form == PulpShape::Form::kCapsule; }

/// The data of a pulp for Hertz's contact.
struct Rounding {
  double radius_m;
  EllipticHertz ellipse;
};
Rounding rounding(const Pulp& pulp, const Vector3d& direction) {
  if (!pulp.shape) return {pulp.radius_m, {}};
  const Eigen::Vector2d radii_m = curvature(*pulp.shape, direction).radii_m;
  return {std::sqrt(radii_m.prod()), elliptic_hertz(radii_m[0], radii_m[1])};
}

double force_at_N(double modulus_Pa, double radius_m, double depth_m) {
  return 4.0 / 3.0 * modulus_Pa * std::sqrt(radius_m) * std::pow(depth_m, 1.5);
}

}  // namespace

PressedPulp press(const Pulp& pulp, const Vector3d& direction, double depth_m, double band_m, Index most) {
  const VectorXd gap_m = gaps_m(pulp, direction, depth_m);
  PressedPulp pressed;
  for (Index c = 0; c < pulp.controls(); ++c) {
    if (gap_m[c] < band_m) pressed.controls.push_back(c);
  }
  std::sort(pressed.controls.begin(), pressed.controls.end(), [&](Index a, Index b) { return gap_m[a] < gap_m[b]; });
  if (std::ssize(pressed.controls) > most) pressed.controls.resize(most);

  // The plane's normal is that of all contacts, so their axes agree; tangents do not matter without friction.
  const Index n = std::ssize(pressed.controls);
  ContactData problem{MatrixXd::Zero(3 * n, 3 * n), VectorXd::Zero(3 * n), VectorXd::Zero(n)};
  for (Index i = 0; i < n; ++i) {
    problem.delta_free[3 * i] = gap_m[pressed.controls[i]];
    for (Index j = 0; j < n; ++j) {
      const double k_ij = pulp.kernel(pressed.controls[i], pressed.controls[j]);
      problem.W.block<3, 3>(3 * i, 3 * j) = k_ij * Eigen::Matrix3d::Identity();
    }
  }
  SweepWorkspace work(n);
  VectorXd f = VectorXd::Zero(3 * n), delta(3 * n);
  (void)solve_contacts(problem, {.tolerance = 1e-6, .max_sweeps = 1000}, work, {f, delta});
  pressed.force_N = f(Eigen::seqN(0, n, 3));
  return pressed;
}

double hertz_force_N(const Pulp& pulp, double depth_m) {
  return 4.0 / 3.0 * pulp.material.reduced_modulus_Pa * std::sqrt(pulp.radius_m) * std::pow(depth_m, 1.5);
}

double hertz_force_N(const Pulp& pulp, const Vector3d& direction, double depth_m) {
  const double modulus_Pa = pulp.material.reduced_modulus_Pa;
  if (is_capsule(pulp)) return modulus_Pa * capsule_load_m2(*pulp.shape, direction, depth_m);
  const auto [radius_m, ellipse] = rounding(pulp, direction);
  return force_at_N(modulus_Pa, radius_m, depth_m / ellipse.depth);
}

double hertz_depth_m(const Pulp& pulp, double force_N) {
  return std::pow(softness(pulp.material, force_N) * force_N / hertz_force_N(pulp, 1.0), 2.0 / 3.0);
}

double hertz_depth_m(const Pulp& pulp, const Vector3d& direction, double force_N) {
  if (is_capsule(pulp)) {
    return capsule_depth_m(*pulp.shape, direction,
                           softness(pulp.material, force_N) * force_N / pulp.material.reduced_modulus_Pa);
  }
  return std::pow(softness(pulp.material, force_N) * force_N / hertz_force_N(pulp, direction, 1.0), 2.0 / 3.0);
}

double hertz_radius_m(const Pulp& pulp, double force_N, const std::optional<PulpMaterial>& object) {
  double compliance_per_Pa = softness(pulp.material, force_N) / pulp.material.reduced_modulus_Pa;
  if (object) compliance_per_Pa += 1.0 / object->reduced_modulus_Pa;
  return std::cbrt(0.75 * force_N * pulp.radius_m * compliance_per_Pa);
}

double share_factor(const Pulp& pulp, const Vector3d& direction) {
  if (!pulp.shape) return 1.0;
  const auto [radius_m, ellipse] = rounding(pulp, direction);
  const double lesser_m = curvature(*pulp.shape, direction).radii_m[1];
  return std::cbrt(radius_m / pulp.radius_m) * ellipse.size * std::sqrt(ellipse.aspect) * (pulp.radius_m / lesser_m);
}

}  // namespace thenar
