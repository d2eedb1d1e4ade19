// SPDX-License-Identifier: Apache-2.0
#include "engine/capacity/hand_capacity.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "engine/control/control.h"
#include "engine/grasp/state.h"

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

/// Forces of muscles and, behind them, unknown sizes of given forces on the object, in balance with the joints.
class Balance {
 public:
  explicit Balance(const HandGrip& grip) : grip_(grip), joints_(std::ssize(grip.hand.joints)) {
    muscles_ = std::ssize(grip.hand.muscles);
    program_.E.setZero(joints_, muscles_);
    moment_arms(grip.hand, grip.pose, program_.E);
    program_.most.resize(muscles_);
    for (Index m = 0; m < muscles_; ++m) program_.most[m] = grip.hand.muscles[m].max_force_N;
  }

  /// Adds an unknown: the size of a force of this finger along a unit vector.
  void add(int finger, const Vector3d& along, double worth) {
    const Fingertip& tip = grip_.hand.fingertips[finger];
    const auto J = finger_jacobian(grip_.hand, grip_.pose, finger, grip_.contacts[finger].point_m);
    MatrixXd& E = program_.E;
    E.conservativeResize(Eigen::NoChange, E.cols() + 1);
    E.rightCols(1).setZero();
    E.col(E.cols() - 1).segment(tip.first_joint, tip.joints) = -(J.leftCols(tip.joints).transpose() * along);
    forces_.push_back({finger, along, worth});
  }

  /// Adds the forces of a finger within its cone; `worth` is the objective of its normal force.
  void add_cone(int finger, double friction, double worth) {
    const Eigen::Matrix3d& axes = grip_.contacts[finger].axes;
    program_.friction = friction;
    program_.cones.push_back(program_.E.cols());
    add(finger, axes.col(0), worth);
    if (!(friction > 0.0)) return;
    add(finger, axes.col(1), 0.0);
    add(finger, axes.col(2), 0.0);
  }

  /// Adds the equilibrium of the object.
  void add_object() {
    MatrixXd& E = program_.E;
    E.conservativeResize(joints_ + 6, Eigen::NoChange);
    E.bottomRows(6).setZero();
    // Torques in units of the largest distance, so that they count as forces do.
    double reach_m = 1e-9;
    for (const GraspContact& contact : grip_.contacts)
      reach_m = std::max(reach_m, (contact.point_m - grip_.centre_m).norm());
    for (std::size_t i = 0; i < forces_.size(); ++i) {
      const Vector3d arm = (grip_.contacts[forces_[i].finger].point_m - grip_.centre_m) / reach_m;
      E.col(muscles_ + static_cast<Index>(i)).tail<6>() << forces_[i].along, arm.cross(forces_[i].along);
    }
  }

  [[nodiscard]] LargestForce solve() {
    program_.c.setZero(program_.E.cols());
    for (std::size_t i = 0; i < forces_.size(); ++i) program_.c[muscles_ + static_cast<Index>(i)] = forces_[i].worth;
    const ForceLimit limit = find_force_limit(program_);
    LargestForce largest;
    largest.status = limit.status;
    largest.residual = limit.residual;
    largest.muscles_N.setZero(muscles_);
    largest.contacts_N.setZero(3, grip_.hand.fingers());
    if (limit.status != LimitStatus::kOptimal) return largest;
    largest.force_N = limit.value;
    largest.muscles_N = limit.x.head(muscles_);
    for (std::size_t i = 0; i < forces_.size(); ++i) {
      largest.contacts_N.col(forces_[i].finger) += limit.x[muscles_ + static_cast<Index>(i)] * forces_[i].along;
    }
    for (Index m = 0; m < muscles_; ++m) {
      if (!(limit.price[m] > kPriced)) continue;
      const double share = limit.value > 0.0 ? limit.price[m] * program_.most[m] / limit.value : 0.0;
      largest.limiting.push_back({static_cast<int>(m), limit.price[m], share});
    }
    std::ranges::stable_sort(largest.limiting, std::greater<>(), &LimitingMuscle::gain);
    return largest;
  }

 private:
  // Prices below are rounding.
  static constexpr double kPriced = 1e-7;

  struct Force {
    int finger;
    Vector3d along;
    double worth;
  };

  const HandGrip& grip_;
  Index joints_, muscles_;
  ForceProgram program_;
  std::vector<Force> forces_;
};

}  // namespace

HandGrip grip_at_start(const Model& model) {
  const State start(model);
  HandGrip grip{model.scene.hand, {}, {}, start.X_WO.translation()};
  forward_kinematics(grip.hand, start.q, grip.pose);
  for (int k = 0; k < model.fingers(); ++k) grip.contacts.push_back(finger_contact(model, grip.pose, start, k));
  return grip;
}

LargestForce largest_pinch(const HandGrip& grip, double friction) {
  Balance balance(grip);
  for (int k = 0; k < grip.hand.fingers(); ++k) balance.add_cone(k, friction, k == 0 ? 1.0 : 0.0);
  balance.add_object();
  return balance.solve();
}

LargestForce largest_along(const HandGrip& grip, int finger, const Vector3d& direction) {
  Balance balance(grip);
  balance.add(finger, direction, 1.0);
  return balance.solve();
}

LargestForce largest_normal(const HandGrip& grip, int finger, double friction) {
  Balance balance(grip);
  balance.add_cone(finger, friction, 1.0);
  return balance.solve();
}

HandCapacity hand_capacity(const HandGrip& grip, double friction) {
  constexpr int kDirections = 12;
  HandCapacity capacity{friction, largest_pinch(grip, friction), {}};
  for (int k = 0; k < grip.hand.fingers(); ++k) {
    const Fingertip& tip = grip.hand.fingertips[k];
    const Eigen::Matrix3d R_WF = grip.pose.distal(grip.hand, k).linear();
    const Vector3d axis = grip.pose.axis[tip.first_joint + tip.joints - 1];
    FingerCapacity finger;
    finger.normal = largest_along(grip, k, grip.contacts[k].axes.col(0));
    finger.normal_with_friction = largest_normal(grip, k, friction);
    finger.along_axis = largest_along(grip, k, axis);
    finger.against_axis = largest_along(grip, k, -axis);
    // 0 is the pulp's direction, 90 degrees that of the tip: x of the last bone.
    Vector3d face = R_WF * tip.normal - axis.dot(R_WF * tip.normal) * axis;
    face = face.norm() > 1e-6 ? face.normalized() : axis.unitOrthogonal();
    Vector3d ahead = axis.cross(face);
    if (ahead.dot(R_WF.col(0)) < 0.0) ahead = -ahead;
    for (int i = 0; i < kDirections; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / kDirections;
      const Vector3d direction = std::cos(angle) * face + std::sin(angle) * ahead;
      finger.ring.push_back({angle, direction, largest_along(grip, k, direction)});
    }
    capacity.fingers.push_back(std::move(finger));
  }
  return capacity;
}

}  // namespace thenar
