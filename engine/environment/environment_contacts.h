// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <tuple>
#include <vector>

#include "collision/solids/solid_contacts.h"
#include "engine/environment/environment.h"
#include "solvers/ground_contacts.h"

namespace thenar {

/// Returns X moved by x: its origin by x's first three entries [m], and rotated about it by the rotation vector of the
/// others, world axes.
[[nodiscard]] Eigen::Isometry3d moved(const Eigen::Isometry3d& X, const GroundProblem::Motion& x);

/// The force at one contact with the environment, which the next tick finds again by body and place. It is the only
/// state of friction: the shear there is c f_t.
struct EnvironmentForce {
  int body = 0;
  std::int32_t place = 0;
  Eigen::Vector3d p_E = Eigen::Vector3d::Zero();  ///< Contact point, in the frame of the body.
  Eigen::Vector3d n_E = Eigen::Vector3d::Zero();  ///< Normal into the object, axes of the body.
  Eigen::Vector3d f_E = Eigen::Vector3d::Zero();  ///< Force on the object, axes of the body [N].
};

/// Returns the key by which forces are ordered.
[[nodiscard]] inline auto id_of(const EnvironmentForce& force) { return std::tie(force.body, force.place); }

/// The bodies whose forces a tick's report tells apart: the first ones of the environment. A report has a fixed size.
inline constexpr int kToldBodies = 16;

/// The interaction of object and environment in a tick.
struct EnvironmentReport {
  int contacts = 0;            ///< Number within the band.
  int active = 0;              ///< Number of them that carry force.
  double penetration_m = 0.0;  ///< Largest at the tick's end: the deformation of object and body.
  Eigen::Matrix<double, 6, 1> wrench =
      Eigen::Matrix<double, 6, 1>::Zero();  ///< Wrench on the object about its origin, world axes.
  double normal_N = 0.0;                    ///< Sum of the normal forces.
  /// Force of each told body on the object, a column a body, world axes; 0 for those that are not there.
  Eigen::Matrix<double, 3, kToldBodies> body_N = Eigen::Matrix<double, 3, kToldBodies>::Zero();
  /// True if two contacts stick and the line through them lies in both friction cones: they can hold the object between
  /// them with any force, and keep it when all others release it [Whitney 1982].
  bool wedged = false;
};

/// The object and one body of its environment.
struct EnvironmentPair {
  SolidPair solids;
  Eigen::Isometry3d X_WE = Eigen::Isometry3d::Identity();  ///< Pose of the body at which contacts were found.
  Eigen::Vector3d moved_m = Eigen::Vector3d::Zero();       ///< Displacement of the body in the tick, world axes.

  /// Tests whether the body moves so far in the tick that it may have passed through the object at its end.
  [[nodiscard]] bool is_fast() const { return moved_m.squaredNorm() > kFast_m * kFast_m; }
  static constexpr double kFast_m = 0.1e-3;
};

/// A contact with the data that the solver does not need.
struct EnvironmentContact {
  int body = 0;
  SolidContact at;                                      ///< The contact in the body's frame.
  Eigen::Vector3d sheared_m = Eigen::Vector3d::Zero();  ///< Shear by the last force, in contact rows.
};

/// The object's contacts with the environment, found anew in each tick, as both are rigid surfaces: they do not depend
/// on frames. Memory is allocated once.
struct EnvironmentContacts {
  EnvironmentContacts() = default;  ///< Contacts of a scene without environment.
  EnvironmentContacts(const Environment& environment, const TouchingSolid& object);

  std::vector<EnvironmentPair> pairs;     ///< One per body.
  std::vector<EnvironmentContact> found;  ///< Contacts, body by body.
  std::vector<GroundContact> contacts;    ///< The same ones in the solver's form: rows n, t1, t2.
  GroundProblem::Motion looked_at = GroundProblem::Motion::Zero();  ///< The motion after which gaps are exact.
  bool after_motion = false;  ///< True if fast bodies were at the tick's end; else at its begin.
  double reach_m = 0.0;       ///< Radius of the object about its origin.
  double dropped_J = 0.0;     ///< Elastic energy of the last tick's contacts that have ended.

  // Scratch: a pair's contacts; forces before contacts were found again.
  std::vector<SolidContact> of_pair;
  std::vector<EnvironmentForce> then;

  [[nodiscard]] std::size_t most() const { return most_; }

 private:
  std::size_t most_ = 0;
};

/// Finds the contacts of a tick from `begin` to `end`, the object at X_WO when it begins: gaps are those to the bodies
/// at its end, slips those of their motion. Contacts farther than `band_m` are left out. Contacts of fast bodies are
/// found at the tick's begin, when neither has passed through the other, and extrapolated along their normals. `forces`
/// are the last tick's, in order; at most one contact inherits each.
/// `after`: contacts are found with the object displaced by this motion, the bodies at the end, and are transformed
/// back along their own directions: gaps are exact after the motion, not before.
void find_environment_contacts(const Environment& environment, const Eigen::Isometry3d& X_WO, const Instant& begin,
                               const Instant& end, double band_m, const std::vector<EnvironmentForce>& forces,
                               EnvironmentContacts& contacts,
                               const std::optional<GroundProblem::Motion>& after = std::nullopt);

/// Bounds the error of the linearised gaps after a motion x [m]; of contacts that roam, whose points of least gap shift
/// with the motion. Infinite where nothing is known, and where a fast body has moved since.
[[nodiscard]] double may_miss_m(const EnvironmentContacts& contacts, const GroundProblem::Motion& x);

/// Returns the largest difference between the gaps of these contacts after a motion x and those that belong to the
/// forces `then` [m]; of contacts that roam, of all of fast bodies, and of their forces at contacts that have ended.
[[nodiscard]] double missed_m(const Environment& environment, const EnvironmentContacts& contacts,
                              const GroundProblem::Motion& x, const std::vector<EnvironmentForce>& then);

/// Reports the effect of the contacts' forces f (n, t1, t2) and of the object's motion x.
[[nodiscard]] EnvironmentReport environment_report(const EnvironmentContacts& contacts,
                                                   const std::vector<Eigen::Vector3d>& f,
                                                   const GroundProblem::Motion& x);

/// The energy balance of the contacts in a tick [J], forces constant over it.
struct EnvironmentWork {
  double moving_J = 0.0;       ///< Work of moving bodies on the object.
  double deformation_J = 0.0;  ///< Work of the forces on the compliance.
  double stored_J = 0.0;       ///< Elastic energy after the tick.
  double injected_J = 0.0;     ///< Work of forces along the surfaces' motion.
  double dissipated_J = 0.0;   ///< Loss by the others: friction, and gaps that close at once.
  double dropped_J = 0.0;      ///< Elastic energy lost with contacts that ended.
};

/// Computes the balance; f as left by a solve, x the object's motion.
[[nodiscard]] EnvironmentWork environment_work(const Environment& environment, const EnvironmentContacts& contacts,
                                               const std::vector<Eigen::Vector3d>& f, const GroundProblem::Motion& x);

/// Keeps the forces for the next tick, in order.
void keep_forces(const EnvironmentContacts& contacts, const std::vector<Eigen::Vector3d>& f,
                 std::vector<EnvironmentForce>& forces);

}  // namespace thenar
