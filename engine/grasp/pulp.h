// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "collision/point_cloud.h"
#include "collision/pulp_shape.h"

namespace thenar {

/// The share of its radius by which a fingertip may be pressed in, or have moved against the object since a frame's
/// snapshot: beyond it no law used here holds, and other points touch than those of the frame.
inline constexpr double kTrustPerRadius = 0.5;

/// sqrt(A) / s of a control point's own part: of a hexagonal lattice.
inline constexpr double kHexagonal = 3.9210;

/// Influence of a force at one control point on another's displacement.
enum class PulpKernel {
  kBoussinesq,  ///< An elastic half space.
  kGaussian,    ///< The published model's influence function, eqs. (32, 33): calibrated to Hertz at one depth.
};

/// Compliance of a fingertip's material, as in the scene.
struct PulpMaterial {
  double reduced_modulus_Pa = 0.0;  ///< E* = E / (1 - nu^2).
  double poisson = 0.5;
  double relaxation_s = 0.0;  ///< Retardation time tau_r of the Kelvin-Voigt law; 0 is elastic.
  PulpKernel kernel = PulpKernel::kBoussinesq;
  double stiffening_per_N = 0.0;  ///< beta: a fingertip under the normal load F has the modulus E* (1 + beta F).

  bool operator==(const PulpMaterial&) const = default;
};

struct Fingertip;

/// Returns the scene's material with the fingertip's own values from its hand file.
[[nodiscard]] PulpMaterial material_of(const Fingertip& tip, PulpMaterial scenes);

/// A quasi-rigid fingertip [26, 31]: a rigid rest shape and a compliance on its control points, one for each leaf of
/// its tree or, at coarser levels of detail, for each of some nodes above. They begin at the centroids of these, and
/// move on to those of their Voronoi cells [Lloyd 1982]; A_i is the area of such a cell.
///
/// A force f at control point j moves the surface at control point i by
///     u_i = [k_ij I + P_i (a_ij I + b_ij r_ij r_ij') P_j] f,   r_ij = p_i - p_j,   P = I - n n',
/// n the normal that the surface has there. The kernels:
///     boussinesq   k_ij = 1 / (pi E* rho),   rho^2 = r_ij^2 + s^2,   s^2 = (s_i^2 + s_j^2) / 2,
///                  s_i = sqrt(A_i) / 3.9210
/// Boussinesq's half space, and for a point's own part what an even pressure on a whole plane asks for, if it is to
/// move control points on a hexagonal lattice as far as it does when it is not gathered in points: the potential of
/// such a lattice of unit density, less that of its even background, is -3.9210 [Bonsall, Maradudin 1977].
///     gaussian     k_ij = C exp(-r_ij^2 / (2 sigma^2)),   sigma^2 = 0.36 mean(A),   C = 3 a / (8 E* sigma^2)
/// In an even pressure it is a bed of springs of 1 / (2 pi sigma^2 C) = 4 E* / (3 pi a) per area, which takes Hertz's
/// force at the depth R/8, where a = sqrt(R d) = 0.354 R; off that depth its force goes with d^2, Hertz's with d^1.5. A
/// sigma that does not follow the spacing is ill-posed: the condition then grows with the exponential of the number of
/// points.
///
/// a and b are what forces across the normal add. With kappa = nu / (1 - nu):
///     boussinesq   a_ij = kappa k_ij s / (rho + s),   b_ij = kappa k_ij / (rho + s)^2
///     gaussian     a_ij = kappa k_ij / 2,             b_ij = 0
/// The first is Cerruti's half space, k (I + kappa r r' / r^2), for a force spread as the kernel spreads it: the wave q
/// of a traction moves the surface by exp(-q s) / (E* q / 2) along q, as normal to the plane, and by (1 + kappa) times
/// that across q. So it is positive definite among points of a plane, whatever s. In the mean over all directions of r,
/// and at a point itself, it is k times Mindlin's c_t = 1 + kappa / 2 = (2 - nu) / (2 (1 - nu)), which is what the
/// published kernel has.
struct Pulp {
  PointCloud surface;               ///< Rest shape, distal frame.
  Eigen::Index leaves = 0;          ///< Leaves of the tree over its samples, see collision/point_tree.h.
  std::vector<Eigen::Index> order;  ///< Samples, leaf after leaf.
  Eigen::Vector3d centre_m;         ///< Distal frame.
  double radius_m = 0.0;            ///< Radius of the sphere, or of the largest one about the centre inside the pulp.
  PulpMaterial material;
  Eigen::Matrix3Xd control_points_m = {};  ///< 3 x L, distal frame.
  Eigen::MatrixX3d control_normals = {};   ///< L x 3, outward, at rest.
  Eigen::VectorXd area_m2 = {};            ///< L; together the surface's.
  Eigen::MatrixXd kernel = {};             ///< L x L, k_ij [m/N], of the pulp without load.
  Eigen::MatrixXf rounded_kernel = {};     ///< The kernel in single precision, for points that bear no force.
  Eigen::MatrixXd a = {};                  ///< L x L, a_ij [m/N], likewise.
  Eigen::MatrixXd b = {};                  ///< L x L, b_ij [1/(N m)], likewise.
  double tangential = 1.0;                 ///< c_t.
  std::optional<PulpShape> shape = {};     ///< Nothing: a sphere.

  [[nodiscard]] Eigen::Index controls() const { return control_points_m.cols(); }
};

/// Makes a spherical pulp of `points` samples, centred at `centre_m` of the distal frame. Its tree has `leaves` leaves,
/// and a control point on each.
[[nodiscard]] Pulp make_spherical_pulp(const Eigen::Vector3d& centre_m, double radius_m, Eigen::Index points,
                                       Eigen::Index leaves, const PulpMaterial& material);

/// Makes a pulp of another shape, likewise. Without a shape it is the sphere.
[[nodiscard]] Pulp make_pulp(const Eigen::Vector3d& centre_m, double radius_m, const std::optional<PulpShape>& shape,
                             Eigen::Index points, Eigen::Index leaves, const PulpMaterial& material);

/// Takes the control points of a level of detail: one for about 2^level leaves, or for all of them. Cost O(controls^2).
void set_level(Pulp& pulp, int level);

/// Computes k, a and b of the pulp's control points and their areas. Cost O(controls^2).
void fill_compliance(Pulp& pulp);

/// A part of the surface that a force acts on.
struct PulpPatch {
  Eigen::Vector3d p_m;  ///< Distal frame.
  double area_m2 = 0.0;
};
struct PulpCompliance {
  double k, a, b;
};
/// Returns k_ij, a_ij and b_ij between two parts of a pulp's surface, as for its control points.
[[nodiscard]] PulpCompliance pulp_compliance(const Pulp& pulp, const PulpPatch& i, const PulpPatch& j);

/// Returns k_ij of the Boussinesq kernel between points whose distance squared is `squared_m2`, standing for these
/// areas [m/N]. Distances and areas of points j may be arrays.
template <typename Values>
[[nodiscard]] Values half_space_kernel(const PulpMaterial& material, const Values& squared_m2, double area_i_m2,
                                       const Values& area_j_m2) {
  using std::sqrt;
  const Values s2 = (area_i_m2 + area_j_m2) / (2.0 * kHexagonal * kHexagonal);
  return 1.0 / (std::numbers::pi * material.reduced_modulus_Pa * sqrt(squared_m2 + s2));
}

/// Returns rho = exp(-h / tau_r): the share of a displacement left a step h later; 0 if elastic.
[[nodiscard]] double retained_share(const PulpMaterial& material, double step_s);

/// Returns 1 / (1 + beta F): the share of the compliance left under a normal load F. Human fingertips have a secant
/// modulus about linear in the load [Dzidek et al. 2017].
[[nodiscard]] double softness(const PulpMaterial& material, double normal_N);

}  // namespace thenar
