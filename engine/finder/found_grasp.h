// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "collision/implicit_surface.h"
#include "engine/grasp/pulp.h"
#include "engine/grasp/scene.h"
#include "engine/hand/hand.h"
#include "solvers/grasp_problem.h"

namespace thenar {

/// The problem of the finder: a hand, an object, and the conditions of the grasp.
struct FinderProblem {
  const Hand& hand;
  const ImplicitSurface& object;
  double mass_kg = 0.0;
  Eigen::Vector3d centre_of_mass_m = Eigen::Vector3d::Zero();
  double translation_damping = 0.0;                   ///< Damping of the object, at the origin of its frame [N s/m].
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  ///< World = hand frame, or object frame:
  bool gravity_in_object_frame = false;
  const Environment* environment = nullptr;  ///< Placed bodies that the hand must not reach into; null: none.
  double friction = 0.0;                     ///< Friction of the contacts.
  double cone_friction = 0.0;                ///< Friction of the controller's cones, at most `friction`.
  FrictionCone cone = FrictionCone::kExact;
  double internal_force_N = 0.0;              ///< lambda of the controller, if the wish has no press.
  std::optional<PulpMaterial> material = {};  ///< Nothing: rigid fingertips.
  bool muscles = false;                       ///< Muscles drive the joints.
  GraspWish wish = {};

  /// Returns gravity with the object at this pose, world axes.
  [[nodiscard]] Eigen::Vector3d gravity_at(const Eigen::Isometry3d& X_WO) const {
    return gravity_in_object_frame ? Eigen::Vector3d(X_WO.linear() * gravity) : gravity;
  }
};

/// The extent of the search. Work is counted, never timed: the same problem gives the same bits.
struct FinderSettings {
  std::uint32_t seed = 1;
  int best = 1;             ///< Number of distinct grasps to return. For more than one the search is wider.
  int spare = 0;            ///< Number of further grasps, which may resemble others.
  int effort = 1;           ///< Factor on the usual number of starts; 20 is a slow reference.
  bool second_look = true;  ///< Search four times as long before giving up.
};

/// The contact of a finger in a found grasp.
struct FingerPlace {
  Eigen::Vector3d point_O = Eigen::Vector3d::Zero();   ///< Point on the surface.
  Eigen::Vector3d normal_O = Eigen::Vector3d::Zero();  ///< Outward.
  Eigen::Vector3d force_W = Eigen::Vector3d::Zero();   ///< Force on the object, against the weight [N].
  double depth_m = 0.0;                                ///< Indentation of the pulp.
  double facing_rad = 0.0;                             ///< Angle between the pulp's mean normal and the surface's.
  double patch = 0.0;  ///< Share of the contact patch on one piece of surface: less at edges and holes.
};

/// The outcome of a simulation of a grasp before it is offered: see rehearse().
struct Rehearsal {
  double lasted = 0.0;        ///< Share of the time for which it held; 1: to the end.
  double muscle_share = 0.0;  ///< The largest force of a muscle as a share of its limit.
  /// Friction below which a patch would slide as a whole at rest, by PatchReport::margin, torsion included.
  double needed_friction = 0.0;
  double least_margin = 1.0;  ///< Least PatchReport::margin.
  double reserve = 0.0;       ///< Friction reserve of the controller's cones; 0: not known.
  std::string trouble = {};   ///< Reason for its end; empty: none.
  std::string weakness = {};  ///< Muscles that were too weak, and by how much; empty: none.

  [[nodiscard]] bool held() const { return lasted >= 1.0; }
  [[nodiscard]] bool within_limits() const { return held() && muscle_share <= 1.0; }
  /// Returns the utilisation: above 1 if a muscle has less than a fifth to spare, or the friction less than a third of
  /// its reserve. Pushes in directions that were not tried may then demand too much.
  [[nodiscard]] double strain() const {
    const double friction = reserve > 0.0 ? 2.0 - 3.0 * least_margin / reserve : 0.0;
    return friction > 1.25 * muscle_share ? friction : 1.25 * muscle_share;
  }
  [[nodiscard]] bool with_ease() const { return held() && strain() <= 1.0; }
};

/// A grasp: its fingers, posture and measures.
struct FoundGrasp {
  std::vector<int> fingers;  ///< Fingers of the hand, in its order.
  int opposer = 0;           ///< The finger that faces the others: an index into `fingers`.
  JointVector q;             ///< Joint angles of these fingers.
  Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
  Eigen::Vector3d approach_O = Eigen::Vector3d::Zero();  ///< Approach direction of the hand.
  PerFinger<FingerPlace> places;
  double width_m = 0.0;  ///< Distance between the opposer's contact and the middle of the others'.
  /// Least remaining share of a friction cone, 1 - |f_t| / (mu f_n), with the commanded forces, over all fingers and
  /// disturbances: weight in 14 directions, with and without a push of 0.5 N along it, and torques of 10 mN m.
  /// Negative: there are no such forces for one of them.
  double margin = 0.0;
  double needed_friction = 0.0;   ///< Largest |f_t| / f_n under the actual weight; after a rehearsal, its value.
  double internal_force_N = 0.0;  ///< lambda of the fingers' forces.
  double torque_Nm = 0.0;         ///< Largest torque of a joint under the actual weight.
  /// Largest force of a muscle as a share of its limit, under the same and under each push; 0 without muscles.
  double muscle_share = 0.0;
  double dexterity = 1.0;   ///< Least dexterity of a finger: see dexterity().
  double limit_rad = 0.0;   ///< Least distance of a joint from its limits.
  std::string limit_joint;  ///< Name of that joint.
  /// Direction, of 14, in which the fingers carry the object farthest, and that distance, at most 25 mm: until a joint
  /// meets its limit, a finger is stretched, a pulp rolls off its piece of the surface, or no forces bear weight and
  /// push.
  Eigen::Vector3d travel_W = Eigen::Vector3d::Zero();
  double travel_m = 0.0;
  /// Over its first 20 mm: largest |f_t| / f_n under the weight, largest force of a muscle as a share of its limit,
  /// also with each push, and least dexterity.
  double travel_friction = 0.0, travel_share = 0.0, travel_dexterity = 1.0;
  double cost = 0.0;    ///< Cost by which grasps are ranked.
  Rehearsal rehearsal;  ///< Set only for those that were tried.
};

/// The reason why there is no grasp.
struct Refusal {
  std::string reason;  ///< One sentence without a full stop: "the object is 81 mm wide where this hand opens 74 mm".
  std::string help;    ///< A remedy, likewise; may be empty.
  /// True if contact forces hold the object, and muscles do not give the torques that they take.
  bool by_muscles = false;
};

struct FinderReport {
  std::vector<FoundGrasp> grasps;  ///< Best first.
  std::optional<Refusal> refusal;  ///< Only without grasps.
  bool cancelled = false;
  int fits = 0;                ///< Number of stances that were refined, a measure of work.
  std::string shortfall = {};  ///< Reason why there are fewer than were asked for; empty: there are as many.
};

/// A callback with the completed share of the search and the number of grasps so far; false ends the search.
using FinderProgress = std::function<bool(double share, int grasps)>;

}  // namespace thenar
