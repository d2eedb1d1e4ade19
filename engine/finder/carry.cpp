// SPDX-License-Identifier: Apache-2.0
#include "engine/finder/carry.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/finder/effort.h"
#include "engine/finder/hand_body.h"
#include "engine/finder/pinch.h"
#include "engine/finder/pressed_shape.h"
#include "engine/grasp/pulp_touch.h"

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kSurePush = 1.4;  // Factor on push and drag, which forces must balance all along the path.
constexpr double kWayStep_m = 2.5e-3, kCheck_m = 5e-3, kMostWay_m = 25e-3;
constexpr double kSpeed_m_per_s = 47e-3;  // Largest speed on 20 mm in 0.8 s.

/// Returns the least distance of a joint from its limits, relative to its range; negative beyond them.
double spare_share(const Hand& hand, const JointVector& q) {
  double least = 0.5;
  for (Index i = 0; i < q.size(); ++i) {
    const Joint& joint = hand.joints[i];
    const double range_rad = std::max(1e-6, joint.upper_rad - joint.lower_rad);
    least = std::min(least, std::min(q[i] - joint.lower_rad, joint.upper_rad - q[i]) / range_rad);
  }
  return least;
}

/// The hand during a carry.
class Carry {
 public:
  Carry(const FinderProblem& problem, const Hand& hand, const FoundGrasp& grasp)
      : problem_(problem),
        hand_(hand),
        q_(grasp.q),
        X_WO_(grasp.X_WO),
        contacts_(hand.fingers()),
        n_(hand.fingers(), Vector3d::Zero()) {
    forward_kinematics(hand_, q_, pose_);
    reach_m_ = depth_m_ = PerFinger<double>(hand_.fingers());
    ball_ = PerFinger<PulpBall>(hand_.fingers());
    for (int k = 0; k < hand_.fingers(); ++k) {
      ball_[k] = {hand_.fingertips[k].centre_m, hand_.fingertips[k].radius_m};
      depth_m_[k] = grasp.places[k].depth_m;
      reach_m_[k] = ball_[k].radius_m - depth_m_[k];
      (void)touch(k);
    }
  }

  /// Moves the hand by a step; false if the fingers do not follow.
  [[nodiscard]] bool go(const Vector3d& way_m) {
    constexpr double kMissed = 0.1;  // Fraction of the step.
    for (int k = 0; k < hand_.fingers(); ++k) move(k, way_m);
    forward_kinematics(hand_, q_, pose_);
    X_WO_.translation() += way_m;
    // A pulp keeps its depth, as its force is constant.
    for (int round = 0; round < 2; ++round) {
      for (int k = 0; k < hand_.fingers(); ++k) {
        const double gap_m = touch(k);
        move(k, gap_m * n_[k]);
      }
      forward_kinematics(hand_, q_, pose_);
    }
    bool followed = spare_share(hand_, q_) > 0.0;
    for (int k = 0; k < hand_.fingers(); ++k) followed = std::abs(touch(k)) < kMissed * way_m.norm() && followed;
    return followed && least_dexterity() > kLeastDexterity;
  }

  /// Tests whether the pulps touch with their valid parts, on smooth pieces of the surface; updates their contacts.
  [[nodiscard]] bool look(const PatchMeter& patches) {
    constexpr double kLeastPatch = 0.6;
    for (int k = 0; k < hand_.fingers(); ++k) {
      contacts_[k] = pressed_contact(problem_.object, X_WO_, hand_.fingertips[k], pose_.distal(hand_, k));
      const Vector3d normal = pose_.distal(hand_, k).linear() * hand_.fingertips[k].normal;
      if (normal.dot(n_[k]) < std::cos(kFacing_rad + 0.2)) return false;
      if (patches.share(X_WO_.inverse() * contacts_[k].point_m) < kLeastPatch) return false;
    }
    return true;
  }

  [[nodiscard]] double least_dexterity() const {
    double least = 1.0;
    for (int k = 0; k < hand_.fingers(); ++k) {
      least = std::min(least, dexterity(hand_, pose_, k, centre_m(k) + reach_m_[k] * n_[k]));
    }
    return least;
  }
  [[nodiscard]] const JointVector& q() const { return q_; }
  [[nodiscard]] const Eigen::Isometry3d& X_WO() const { return X_WO_; }
  [[nodiscard]] const std::vector<GraspContact>& contacts() const { return contacts_; }

 private:
  [[nodiscard]] Vector3d centre_m(int k) const { return pose_.distal(hand_, k) * ball_[k].centre_m; }

  /// Moves the joints of finger k by the least amount that displaces its contact by `way_m`.
  void move(int k, const Vector3d& way_m) {
    const Fingertip& tip = hand_.fingertips[k];
    const FingerJacobian J = finger_jacobian(hand_, pose_, k, centre_m(k) + reach_m_[k] * n_[k]);
    Matrix3d JJ = squared(J);
    JJ.diagonal().array() += 1e-3 * JJ.trace() / 3.0;
    q_.segment(tip.first_joint, tip.joints) += J.leftCols(tip.joints).transpose() * JJ.ldlt().solve(way_m);
  }

  /// Updates the contact of finger k; returns its gap.
  double touch(int k) {
    if (hand_.fingertips[k].shape) {
      ball_[k] = touching_ball(hand_.fingertips[k], problem_.object, X_WO_.inverse() * pose_.distal(hand_, k));
      reach_m_[k] = ball_[k].radius_m - depth_m_[k];
    }
    const SurfaceDistance at =
        *problem_.object.distance(X_WO_.inverse() * centre_m(k), std::numeric_limits<double>::infinity());
    n_[k] = -(X_WO_.linear() * at.normal);
    return at.distance_m - reach_m_[k];
  }

  const FinderProblem& problem_;
  const Hand& hand_;
  JointVector q_;
  Eigen::Isometry3d X_WO_;
  HandPose pose_;
  std::vector<GraspContact> contacts_;
  PerFinger<Vector3d> n_;     ///< Into the object.
  PerFinger<PulpBall> ball_;  ///< That each pulp is like where it touches.
  PerFinger<double> depth_m_, reach_m_;
};

/// The result of carrying in one direction.
struct Travel {
  double way_m = 0.0;
  double spare = 0.5, dexterity = 1.0;               ///< The least,
  double needed_friction = 0.0, muscle_share = 0.0;  ///< and the most, of the first 20 mm.
};

Travel travel_along(const Vector3d& e, const FinderProblem& problem, const Hand& hand, const PatchMeter& patches,
                    const FoundGrasp& grasp) {
  const Vector3d weight_N = problem.mass_kg * problem.gravity_at(grasp.X_WO);
  const Vector3d drag_N = -kSurePush * problem.translation_damping * kSpeed_m_per_s * e;
  Travel travel;
  Carry carry(problem, hand, grasp);
  for (double way_m = kWayStep_m; way_m < kMostWay_m + 1e-9 && carry.go(kWayStep_m * e); way_m += kWayStep_m) {
    if (way_m < kCarry_m + 1e-9) {
      travel.spare = std::min(travel.spare, spare_share(hand, carry.q()));
      travel.dexterity = std::min(travel.dexterity, carry.least_dexterity());
    }
    if (std::abs(std::remainder(way_m, kCheck_m)) > 1e-9) continue;
    if (!carry.look(patches)) break;
    ForceCheck check(problem, carry.contacts(), carry.X_WO(), grasp.internal_force_N);
    const HoldingForces held = check.against(weight_N, Vector3d::Zero());
    if (!held.found || !check.against(weight_N + drag_N, check.moment_at_origin_Nm(drag_N)).found) break;
    Effort effort(problem, hand, carry.contacts(), carry.X_WO());
    double share = effort.muscle_share(effort.torques_Nm(carry.q(), held.f));
    // Pushes act half-way and at the end.
    bool holds = true;
    for (const Vector3d& push : directions()) {
      if (!holds || std::abs(std::remainder(way_m, 0.5 * kCarry_m)) > 1e-9) break;
      holds = check.against(weight_N + kSurePush * kPush_N * push, Vector3d::Zero()).found;
      if (!holds || !problem.muscles) continue;
      const HoldingForces forces = check.against(weight_N + kPush_N * push, Vector3d::Zero());
      share = std::max(share, effort.muscle_share(effort.torques_Nm(carry.q(), forces.f)));
    }
    if (!holds) break;
    travel.way_m = way_m;
    if (way_m > kCarry_m + 1e-9) continue;
    travel.needed_friction = std::max(travel.needed_friction, held.needed_friction);
    travel.muscle_share = std::max(travel.muscle_share, share);
  }
  return travel;
}

}  // namespace

void add_travel(const FinderProblem& problem, const Hand& hand, const PatchMeter& patches, FoundGrasp& grasp) {
  constexpr double kGoodDexterity = 0.15, kEasy = 0.5;
  double best = -std::numeric_limits<double>::infinity();
  for (const Vector3d& e : directions()) {
    const Travel travel = travel_along(e, problem, hand, patches, grasp);
    const double value = 2.0 * travel.way_m / kMostWay_m + travel.spare +
                         std::min(1.0, travel.dexterity / kGoodDexterity) - 0.5 * travel.needed_friction -
                         std::max(0.0, travel.muscle_share - kEasy);
    if (value <= best) continue;
    best = value;
    grasp.travel_W = e;
    grasp.travel_m = travel.way_m;
    grasp.travel_friction = travel.needed_friction;
    grasp.travel_share = travel.muscle_share;
    grasp.travel_dexterity = travel.dexterity;
  }
}

}  // namespace thenar
