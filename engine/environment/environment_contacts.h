#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <tuple>
#include <vector>

#include "collision/solids/solid_contacts.h"
#include "engine/environment/environment.h"
#include "solvers/ground_contacts.h"

namespace thenar {

/// The force at one contact with the environment, which the next tick finds again by body and place, and on a circle by
/// its angle. It is all that friction remembers: how far the two are sheared there is c f_t.
struct EnvironmentForce {
  int body = 0;
  std::int32_t place = 0;
  double angle_rad = 0.0;
  Eigen::Vector3d n_E = Eigen::Vector3d::Zero();  ///< Into the object, axes of the body.
  Eigen::Vector3d f_E = Eigen::Vector3d::Zero();  ///< On the object, likewise [N].
};

/// By what these are ordered.
[[nodiscard]] inline auto id_of(const EnvironmentForce& force) { return std::tie(force.body, force.place); }

/// What the object does to the environment in a tick, and the environment to it.
struct EnvironmentReport {
  int contacts = 0;            ///< Within the band.
  int active = 0;              ///< Of them, those that carry force.
  double penetration_m = 0.0;  ///< The deepest, at the tick's end: object and body give way by so much.
  Eigen::Matrix<double, 6, 1> wrench =
      Eigen::Matrix<double, 6, 1>::Zero();  ///< On the object, about its origin, world.
  double normal_N = 0.0;                    ///< Sum of the normal forces.
  /// Two contacts stick, and the line through them lies in both friction cones: they can hold the object between them
  /// by any force, and keep it when all else lets go [Whitney 1982].
  bool wedged = false;
};

/// The object's contacts with the environment, found anew in each tick, for both are exact: no frame is too old for
/// them. Memory is taken once.
struct EnvironmentContacts {
  EnvironmentContacts() = default;  ///< Of a scene that has none.
  EnvironmentContacts(const Environment& environment, const Solid& object);

  std::vector<SolidPair> pairs;     ///< The object and each body.
  std::vector<std::size_t> end;     ///< Contacts of body k are at end[k - 1] .. end[k], from 0 on.
  std::vector<SolidContact> found;  ///< In the bodies' frames.
  std::vector<GroundContact> contacts;
  std::vector<Eigen::Matrix3d> E_W;        ///< Columns n, t1, t2, world axes.
  std::vector<Eigen::Vector3d> p_W;        ///< Where they are.
  std::vector<Eigen::Vector3d> sheared_m;  ///< By what the last force has sheared them, in contact rows.
  std::vector<Eigen::Vector3d> moved_m;    ///< By what the body moves in the tick, likewise.

  std::vector<EnvironmentForce> then;  ///< Scratch: forces before the contacts were looked at again.

  [[nodiscard]] std::size_t most() const { return contacts.capacity(); }
  [[nodiscard]] const Solid& object() const { return pairs.front().a; }
};

/// Finds the contacts of a tick from `begin` to `end`, the object at X_WO when it begins: gaps are those to the
/// bodies where they are at its end, slips those that they make. What is farther than `band_m` then is left out.
/// `forces` are the last tick's, in order. `x`: the object is looked at where this motion takes it, and what is found
/// is taken back along its own directions: gaps are right after the motion, not before.
void find_environment_contacts(const Environment& environment, const Eigen::Isometry3d& X_WO, const Instant& begin,
                               const Instant& end, double band_m, const std::vector<EnvironmentForce>& forces,
                               EnvironmentContacts& contacts,
                               const GroundProblem::Motion& x = GroundProblem::Motion::Zero());

/// How far the gaps of these contacts after a motion x are from those at which the forces `then` are, at most [m]; of
/// contacts that roam: places of least gap go elsewhere with the motion, and straight lines miss that.
[[nodiscard]] double missed_m(const Environment& environment, const EnvironmentContacts& contacts,
                              const GroundProblem::Motion& x, const std::vector<EnvironmentForce>& then);

/// What forces f of these contacts (n, t1, t2) do, and the object's motion x.
[[nodiscard]] EnvironmentReport environment_report(const EnvironmentContacts& contacts,
                                                   const std::vector<Eigen::Vector3d>& f,
                                                   const GroundProblem::Motion& x);

/// Where the energy of the contacts went in a tick [J]: forces held over it, and the motions of the bodies.
struct EnvironmentWork {
  double moving_J = 0.0;       ///< Of bodies that move, on the object.
  double deformation_J = 0.0;  ///< Of the forces on what gives way.
  double stored_J = 0.0;       ///< Elastic energy after the tick.
  double injected_J = 0.0;     ///< Of forces that push the surfaces on.
  double dissipated_J = 0.0;   ///< Of the others: friction, and gaps that close at once.
};

/// f as a solve left it, x the object's motion.
[[nodiscard]] EnvironmentWork environment_work(const Environment& environment, const EnvironmentContacts& contacts,
                                               const std::vector<Eigen::Vector3d>& f, const GroundProblem::Motion& x);

/// Keeps the forces for the next tick, in order.
void keep_forces(const EnvironmentContacts& contacts, const std::vector<Eigen::Vector3d>& f,
                 const Environment& environment, const Instant& end, std::vector<EnvironmentForce>& forces);

}  // namespace thenar
