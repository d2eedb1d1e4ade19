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

/// X moved by x: its origin by x's first three [m], and turned about it by the rotation vector of the others, world
/// axes.
[[nodiscard]] Eigen::Isometry3d moved(const Eigen::Isometry3d& X, const GroundProblem::Motion& x);

/// The force at one contact with the environment, which the next tick finds again by body and place. It is all that
/// friction remembers: how far the two are sheared there is c f_t.
struct EnvironmentForce {
  int body = 0;
  std::int32_t place = 0;
  Eigen::Vector3d p_E = Eigen::Vector3d::Zero();  ///< Where it is, in the frame of the body.
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

/// The object and one body of its environment.
struct EnvironmentPair {
  SolidPair solids;
  Eigen::Isometry3d X_WE = Eigen::Isometry3d::Identity();  ///< The body's, where it was looked at.
  Eigen::Vector3d moved_m = Eigen::Vector3d::Zero();       ///< By what it moves in the tick, world axes.

  /// It goes so far in the tick that it may be through the object at its end.
  [[nodiscard]] bool is_fast() const { return moved_m.squaredNorm() > kFast_m * kFast_m; }
  static constexpr double kFast_m = 0.1e-3;
};

/// A contact, and what the solver does not need to know of it.
struct EnvironmentContact {
  int body = 0;
  SolidContact at;                                      ///< In the body's frame.
  Eigen::Vector3d sheared_m = Eigen::Vector3d::Zero();  ///< By what the last force has sheared it, in contact rows.
};

/// The object's contacts with the environment, found again in each tick, for both are rigid surfaces: no frame is too
/// old for them. Memory is taken once.
struct EnvironmentContacts {
  EnvironmentContacts() = default;  ///< Of a scene that has none.
  EnvironmentContacts(const Environment& environment, const TouchingSolid& object);

  std::vector<EnvironmentPair> pairs;     ///< One a body.
  std::vector<EnvironmentContact> found;  ///< Body by body.
  std::vector<GroundContact> contacts;    ///< The same ones as the solver knows them: rows n, t1, t2.
  GroundProblem::Motion looked_at = GroundProblem::Motion::Zero();  ///< The motion after which gaps are exact,
  bool after_motion = false;  ///< and fast bodies were at the tick's end; else at its begin.
  double reach_m = 0.0;       ///< The object's, from its origin.
  double dropped_J = 0.0;     ///< Elastic energy that those of the tick before held which are no more.

  // Scratch: a pair's contacts; forces before the contacts were looked at again.
  std::vector<SolidContact> of_pair;
  std::vector<EnvironmentForce> then;

  [[nodiscard]] std::size_t most() const { return most_; }

 private:
  std::size_t most_ = 0;
};

/// Finds the contacts of a tick from `begin` to `end`, the object at X_WO when it begins: gaps are those to the
/// bodies where they are at its end, slips those that they make. What is farther than `band_m` then is left out. Bodies
/// that are fast are looked at where they are as the tick begins, when neither has gone through the other, and go on
/// along their normals. `forces` are the last tick's, in order; each is taken over by one contact at most.
/// `after`: the object is looked at where this motion takes it, the bodies at the end, and what is found is taken back
/// along its own directions: gaps are right after the motion, not before.
void find_environment_contacts(const Environment& environment, const Eigen::Isometry3d& X_WO, const Instant& begin,
                               const Instant& end, double band_m, const std::vector<EnvironmentForce>& forces,
                               EnvironmentContacts& contacts,
                               const std::optional<GroundProblem::Motion>& after = std::nullopt);

/// By how much gaps after a motion x may differ from what these contacts say, at most [m]; of contacts that roam:
/// places of least gap go elsewhere with the motion, and straight lines miss that. Infinite where nothing is known, and
/// where a fast body has moved since it was looked at.
[[nodiscard]] double may_miss_m(const EnvironmentContacts& contacts, const GroundProblem::Motion& x);

/// How far the gaps of these contacts after a motion x are from those at which the forces `then` are, at most [m]; of
/// contacts that roam; and of fast bodies all, and forces at contacts that are no more.
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
  double dropped_J = 0.0;      ///< Elastic energy that went with contacts that are no more.
};

/// f as a solve left it, x the object's motion.
[[nodiscard]] EnvironmentWork environment_work(const Environment& environment, const EnvironmentContacts& contacts,
                                               const std::vector<Eigen::Vector3d>& f, const GroundProblem::Motion& x);

/// Keeps the forces for the next tick, in order.
void keep_forces(const EnvironmentContacts& contacts, const std::vector<Eigen::Vector3d>& f,
                 std::vector<EnvironmentForce>& forces);

}  // namespace thenar
