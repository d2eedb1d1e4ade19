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

/// A hand, an object, and how the one is to hold the other.
struct FinderProblem {
  const Hand& hand;
  const ImplicitSurface& object;
  double mass_kg = 0.0;
  Eigen::Vector3d centre_of_mass_m = Eigen::Vector3d::Zero();
  double translation_damping = 0.0;                   ///< Of the object, at the origin of its frame [N s/m].
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  ///< World = hand frame.
  double friction = 0.0;                              ///< Of the contacts,
  double cone_friction = 0.0;                         ///< and of the controller's cones, not above it.
  FrictionCone cone = FrictionCone::kExact;
  double internal_force_N = 0.0;              ///< lambda of the controller, where the wish has no press.
  std::optional<PulpMaterial> material = {};  ///< Nothing: rigid fingertips.
  bool muscles = false;                       ///< Muscles drive the joints.
  GraspWish wish = {};
};

/// How long to search. Work is counted, never timed: the same problem gives the same bits.
struct FinderSettings {
  std::uint32_t seed = 1;
  int best = 1;             ///< Grasps to return, each unlike the others. For more than one it searches wider.
  int spare = 0;            ///< So many more, which may be like others.
  int effort = 1;           ///< So many times the usual starts; 20 is a slow reference.
  bool second_look = true;  ///< Search four times as long before giving up.
};

/// Where a finger of a found grasp touches.
struct FingerPlace {
  Eigen::Vector3d point_O = Eigen::Vector3d::Zero();   ///< On the surface.
  Eigen::Vector3d normal_O = Eigen::Vector3d::Zero();  ///< Outward.
  Eigen::Vector3d force_W = Eigen::Vector3d::Zero();   ///< On the object, against the weight [N].
  double depth_m = 0.0;                                ///< By which the pulp is pressed in.
  double facing_rad = 0.0;                             ///< Between the pulp's mean normal and the surface's.
  double patch = 0.0;  ///< Share of the pressed patch that is surface of one piece: less at edges and holes.
};

/// What the engine makes of a grasp that is tried before it is offered: see rehearse().
struct Rehearsal {
  double lasted = 0.0;        ///< The share of the time for which it held: 1 to the end.
  double muscle_share = 0.0;  ///< The largest force of a muscle as a share of its limit.
  /// The friction below which a patch would slide as a whole at rest, by PatchReport::margin: torsion counts, too.
  double needed_friction = 0.0;
  double least_margin = 1.0;  ///< The least PatchReport::margin,
  double reserve = 0.0;       ///< and what the controller's cones leave of the friction; 0: not known.
  std::string trouble = {};   ///< What ended it, in words; empty: nothing.

  [[nodiscard]] bool held() const { return lasted >= 1.0; }
  [[nodiscard]] bool within_limits() const { return held() && muscle_share <= 1.0; }
  /// How much of what there is it takes: more than 1 if a muscle has less than a fifth to spare, or the friction less
  /// than a third of its reserve. Pushes in other directions than it was tried with then ask for more than there is.
  [[nodiscard]] double strain() const {
    const double friction = reserve > 0.0 ? 2.0 - 3.0 * least_margin / reserve : 0.0;
    return friction > 1.25 * muscle_share ? friction : 1.25 * muscle_share;
  }
  [[nodiscard]] bool with_ease() const { return held() && strain() <= 1.0; }
};

/// A grasp: who holds, how, and how well.
struct FoundGrasp {
  std::vector<int> fingers;  ///< Of the hand, in its order.
  int opposer = 0;           ///< The finger that faces the others: an index into `fingers`.
  JointVector q;             ///< Of these fingers.
  Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
  Eigen::Vector3d approach_O = Eigen::Vector3d::Zero();  ///< The way in which the hand comes.
  PerFinger<FingerPlace> places;
  double width_m = 0.0;  ///< Between the opposer's place and the middle of the others'.
  /// Least share of a friction cone that is left, 1 - |f_t| / (mu f_n), with the forces that the controller asks for:
  /// of all fingers under all disturbances: weight in 14 directions, with and without a push of 0.5 N along it, and
  /// turns of 10 mN m. Less than 0: there are no such forces for one of them.
  double margin = 0.0;
  double needed_friction = 0.0;   ///< Largest |f_t| / f_n under the weight as it is; once tried, the rehearsal's.
  double internal_force_N = 0.0;  ///< lambda by which the fingers press as they do.
  double torque_Nm = 0.0;         ///< The largest of a joint, under the weight as it is.
  /// The largest force of a muscle as a share of its limit, under the same and under each push; 0 without muscles.
  double muscle_share = 0.0;
  double dexterity = 1.0;   ///< The least of a finger: see dexterity().
  double limit_rad = 0.0;   ///< Least distance of a joint from its limits.
  std::string limit_joint;  ///< Which one that is.
  /// The way in which the fingers carry the object best, of 14, and how far, at most 25 mm: until a joint meets its
  /// limit, a finger is stretched, a pulp rolls off its piece of the surface, or no forces bear weight and push.
  Eigen::Vector3d travel_W = Eigen::Vector3d::Zero();
  double travel_m = 0.0;
  /// On its first 20 mm: the largest |f_t| / f_n under the weight, the largest force of a muscle as a share of its
  /// limit, with each push, too, and the least dexterity.
  double travel_friction = 0.0, travel_share = 0.0, travel_dexterity = 1.0;
  double cost = 0.0;    ///< By which grasps are ranked.
  Rehearsal rehearsal;  ///< Only of those that were tried.
};

/// Why there is no grasp.
struct Refusal {
  std::string reason;  ///< One sentence without a full stop: "the object is 81 mm wide where this hand opens 74 mm".
  std::string help;    ///< What would help, likewise; may be empty.
};

struct FinderReport {
  std::vector<FoundGrasp> grasps;  ///< Best first.
  std::optional<Refusal> refusal;  ///< Only without grasps.
  bool cancelled = false;
  int fits = 0;  ///< Stances that were refined: how much work it was.
};

/// Is called now and then with the share of the search that is done and the grasps so far; false ends the search.
using FinderProgress = std::function<bool(double share, int grasps)>;

}  // namespace thenar
