#pragma once

#include <Eigen/Core>

#include "collision/point_cloud.h"
#include "collision/sphere_tree.h"

namespace thenar {

/// How a fingertip gives way, as the scene says it.
struct PulpMaterial {
  double reduced_modulus_Pa = 0.0;  ///< E* = E / (1 - nu^2).
  double poisson = 0.5;
  double relaxation_s = 0.0;  ///< Retardation time tau_r of the Kelvin-Voigt law; 0 is elastic.
};

/// A quasi-rigid fingertip [26, 31]: a rigid rest shape and a compliance on its control points, the leaves of its tree.
///
/// A force at control point j moves the surface at control point i by
///     u_i = k_ij T_i T_j f_j,   k_ij = 1 / (pi E* sqrt(r_ij^2 + (s_i^2 + s_j^2) / 2)),   s_i = sqrt(A_i / pi) / 2,
/// Boussinesq's half space with each force spread over its leaf's area A_i. T = sqrt(c_t) I + (1 - sqrt(c_t)) n n'
/// makes the tangents softer by Mindlin's c_t = (2 - nu) / (2 (1 - nu)); in a contact's own frame T is S = diag(1,
/// sqrt(c_t), sqrt(c_t)), so C_ij = k_ij S E_i' E_j S. The product form is symmetric positive definite for any normals.
struct Pulp {
  PointCloud surface;  ///< Rest shape, distal frame.
  SphereTree tree;
  PulpMaterial material;
  Eigen::Matrix3Xd control_points_m;  ///< 3 x L, distal frame.
  Eigen::MatrixX3d control_normals;   ///< L x 3, outward, at rest.
  Eigen::VectorXd area_m2;            ///< L.
  Eigen::MatrixXd kernel;             ///< L x L, k_ij [m/N].
  double tangential = 1.0;            ///< sqrt(c_t).

  /// T for a surface with this normal.
  [[nodiscard]] Eigen::Matrix3d tensor(const Eigen::Vector3d& normal) const {
    return tangential * Eigen::Matrix3d::Identity() + (1.0 - tangential) * normal * normal.transpose();
  }
  [[nodiscard]] Eigen::Index controls() const { return control_points_m.cols(); }
};

/// A spherical pulp of `points` samples and `leaves` control points, centred at `centre_m` of the distal frame.
[[nodiscard]] Pulp make_spherical_pulp(const Eigen::Vector3d& centre_m, double radius_m, Eigen::Index points,
                                       Eigen::Index leaves, const PulpMaterial& material);

/// rho = exp(-h / tau_r): the share of a displacement that is still there a step h later; 0 if elastic.
[[nodiscard]] double memory(const PulpMaterial& material, double step_s);

}  // namespace thenar
