// SPDX-License-Identifier: Apache-2.0
#include "engine/control/grasp_stiffness.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>
#include <vector>

#include "tests/support/scenes.h"
#include "tests/support/three_fingers.h"

namespace thenar::grasp_stiffness_test {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

Matrix3d turned_by(const Vector3d& turn) {
  const double angle = turn.norm();
  return angle > 0.0 ? Matrix3d(Eigen::AngleAxisd(angle, turn / angle)) : Matrix3d(Matrix3d::Identity());
}

/// Fingers in any posture that hold an object by contacts that stick, with the compliance of a grasp at work. Contacts
/// are material points of the object; what they are displaced by against their finger is the pulp's to give.
struct StuckGrasp {
  StuckGrasp(const Model& m, const Frame& at_work, std::mt19937_64& random);

  /// Forces on the object's contacts, world, with the object moved by X (of its origin, then a rotation vector; world)
  /// and joints q: C f = what is pressed in, in each finger's own axes.
  [[nodiscard]] std::vector<Vector3d> forces(const Vector6d& X, const JointVector& at) const;
  /// Their wrench on the object, in the coordinates X: a moment m works on a turn by m + m x turn / 2, to first order.
  [[nodiscard]] Vector6d wrench(const Vector6d& X, const JointVector& at) const;
  /// -J'f of a finger.
  [[nodiscard]] VectorXd torques(const Vector6d& X, const JointVector& at, int k) const;

  [[nodiscard]] GraspStiffness stiffness() const {
    std::vector<ContactForce> bears;
    for (Index i = 0; i < frame.size(); ++i) {
      bears.push_back({frame.contacts[i].finger, frame.contacts[i].control_point, f_C[i]});
    }
    StiffnessWorkspace work(model);
    return grasp_stiffness(model, frame, pose_at(q), {bears, places, 100.0}, Vector3d::Zero(), work);
  }

  [[nodiscard]] HandPose pose_at(const JointVector& at) const {
    HandPose pose;
    forward_kinematics(model.scene.hand, at, pose);
    return pose;
  }
  [[nodiscard]] Vector3d point(const Vector6d& X, Index i) const {
    return frame.X_WO.translation() + X.head<3>() + turned_by(X.tail<3>()) * (places[i].c_W - frame.X_WO.translation());
  }
  /// Where finger k's contacts are in its axes, and C there: their normals turn with the object.
  [[nodiscard]] VectorXd points_F(const Vector6d& X, const Isometry3d& X_WF, int k) const;
  [[nodiscard]] MatrixXd compliance_F(const Vector6d& X, const Isometry3d& X_WF, int k) const;

  const Model& model;
  Frame frame;
  JointVector q;
  std::vector<ContactPlace> places;
  std::vector<Vector3d> f_C;
};

StuckGrasp::StuckGrasp(const Model& m, const Frame& at_work, std::mt19937_64& random)
    : model(m), frame(at_work), q(m.scene.hand.at_zero()) {
  const Hand& hand = model.scene.hand;
  for (Index j = 0; j < q.size(); ++j) q[j] = uniform(random, hand.joints[j].lower_rad, hand.joints[j].upper_rad);
  const HandPose pose = pose_at(q);
  Vector3d middle = Vector3d::Zero();
  for (const FrameContact& contact : frame.contacts) {
    const Isometry3d& X_WF = pose.distal(hand, contact.finger);
    places.push_back({X_WF * contact.p_F, X_WF.linear() * contact.E_F});
    f_C.emplace_back(uniform(random, 0.05, 0.5), uniform(random, -0.2, 0.2), uniform(random, -0.2, 0.2));
    middle += places.back().c_W / static_cast<double>(frame.size());
  }
  frame.X_WO = Isometry3d(Eigen::Translation3d(middle + 0.01 * random_direction(random)));
}

VectorXd StuckGrasp::points_F(const Vector6d& X, const Isometry3d& X_WF, int k) const {
  const Index first = frame.begin[k], count = frame.begin[k + 1] - first;
  VectorXd points(3 * count);
  for (Index i = 0; i < count; ++i) points.segment<3>(3 * i) = X_WF.inverse() * point(X, first + i);
  return points;
}

MatrixXd StuckGrasp::compliance_F(const Vector6d& X, const Isometry3d& X_WF, int k) const {
  const Index first = frame.begin[k], count = frame.begin[k + 1] - first;
  MatrixXd C(3 * count, 3 * count);
  const auto axes = [&](Index i) -> Matrix3d {
    return X_WF.linear().transpose() * turned_by(X.tail<3>()) * places[first + i].E_W;
  };
  for (Index i = 0; i < count; ++i) {
    for (Index j = 0; j <= i; ++j) {
      const Matrix3d E_i = axes(i), E_j = axes(j);
      C.block<3, 3>(3 * i, 3 * j) = E_i * frame.compliance[k].entry(i, j, E_i, E_j) * E_j.transpose();
      C.block<3, 3>(3 * j, 3 * i) = C.block<3, 3>(3 * i, 3 * j).transpose();
    }
  }
  return C;
}

std::vector<Vector3d> StuckGrasp::forces(const Vector6d& X, const JointVector& at) const {
  std::vector<Vector3d> f_W;
  const HandPose start = pose_at(q), now = pose_at(at);
  for (int k = 0; k < model.fingers(); ++k) {
    const Index first = frame.begin[k], count = frame.begin[k + 1] - first;
    const Isometry3d &X_0 = start.distal(model.scene.hand, k), &X_WF = now.distal(model.scene.hand, k);
    VectorXd f_F(3 * count);
    for (Index i = 0; i < count; ++i) {
      f_F.segment<3>(3 * i) = X_0.linear().transpose() * places[first + i].E_W * f_C[first + i];
    }
    const VectorXd pressed =
        compliance_F(Vector6d::Zero(), X_0, k) * f_F - points_F(X, X_WF, k) + points_F(Vector6d::Zero(), X_0, k);
    f_F = compliance_F(X, X_WF, k).ldlt().solve(pressed);
    for (Index i = 0; i < count; ++i) f_W.emplace_back(X_WF.linear() * f_F.segment<3>(3 * i));
  }
  return f_W;
}

Vector6d StuckGrasp::wrench(const Vector6d& X, const JointVector& at) const {
  const std::vector<Vector3d> f_W = forces(X, at);
  Vector6d sum = Vector6d::Zero();
  for (Index i = 0; i < frame.size(); ++i) {
    const Vector3d r = point(X, i) - (frame.X_WO.translation() + X.head<3>()), m = r.cross(f_W[i]);
    sum.head<3>() += f_W[i];
    sum.tail<3>() += m + 0.5 * m.cross(X.tail<3>());
  }
  return sum;
}

VectorXd StuckGrasp::torques(const Vector6d& X, const JointVector& at, int k) const {
  const std::vector<Vector3d> f_W = forces(X, at);
  const HandPose now = pose_at(at);
  VectorXd tau = VectorXd::Zero(model.scene.hand.fingertips[k].joints);
  for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
    const FingerJacobian J = finger_jacobian(model.scene.hand, now, k, point(X, i));
    tau -= J.leftCols(tau.size()).transpose() * f_W[i];
  }
  return tau;
}

/// Central differences of `value` along each of n coordinates. A step of 1e-6 on arms of 1e-2 m leaves 1e-8 of third
/// derivatives, and C^-1, of condition 1e4, of forces some 1e-12 N: below 1e-7 of stiffnesses of 1e3 N/m and 1e-1
/// N m/rad, both.
template <typename Value>
MatrixXd gradient(Index n, Value value) {
  constexpr double h = 1e-6;
  MatrixXd columns(VectorXd(value(VectorXd(VectorXd::Zero(n)))).size(), n);
  for (Index c = 0; c < n; ++c) {
    const VectorXd step = h * VectorXd::Unit(n, c);
    columns.col(c) = (VectorXd(value(step)) - VectorXd(value(VectorXd(-step)))) / (2.0 * h);
  }
  return columns;
}

/// Blocks of translation and rotation have their own units, and sizes.
void expect_near(const MatrixXd& found, const MatrixXd& expected, const char* what) {
  for (Index row = 0; row < expected.rows(); row += 3) {
    for (Index column = 0; column < expected.cols(); column += 3) {
      const Index rows = std::min<Index>(3, expected.rows() - row),
                  columns = std::min<Index>(3, expected.cols() - column);
      const MatrixXd block = expected.block(row, column, rows, columns);
      EXPECT_LE((found.block(row, column, rows, columns) - block).cwiseAbs().maxCoeff(),
                1e-6 * block.cwiseAbs().maxCoeff())
          << what << ' ' << row << ' ' << column;
    }
  }
}

// K's parts are the derivatives of G f and -J'f of contacts that stick, whatever fingers and forces are like.
TEST(GraspStiffness, IsTheDerivativeOfWhatContactsBear) {
  Loop loop(scene_of("box_grasp", {kCoarseBox}));
  loop.run(20e-3);
  loop.control();
  const Hand& hand = loop.model.scene.hand;
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 5; ++trial) {
    SCOPED_TRACE(trial);
    const StuckGrasp grasp(loop.model, loop.frame, random);
    const GraspStiffness K = grasp.stiffness();
    ASSERT_EQ(K.contacts, grasp.frame.size());
    ASSERT_EQ(K.sliding, 0);
    const Vector6d rest = Vector6d::Zero();
    Matrix6d A = K.A;
    if (const auto& spring = loop.model.scene.task.spring) {
      A.diagonal().head<3>().array() -= spring->translation_N_per_m;
      A.diagonal().tail<3>().array() -= spring->rotation_Nm_per_rad;
    }
    expect_near(-A, gradient(6, [&](const VectorXd& X) { return grasp.wrench(X, grasp.q); }), "A");
    for (int k = 0; k < hand.fingers(); ++k) {
      SCOPED_TRACE(k);
      const Fingertip& tip = hand.fingertips[k];
      const auto with = [&](const VectorXd& own) {
        JointVector q = grasp.q;
        q.segment(tip.first_joint, tip.joints) += own;
        return q;
      };
      expect_near(K.B[k], gradient(tip.joints, [&](const VectorXd& own) { return grasp.wrench(rest, with(own)); }),
                  "B");
      expect_near(K.B_joints[k].transpose(),
                  gradient(6, [&](const VectorXd& X) { return grasp.torques(X, grasp.q, k); }), "B_joints");
      expect_near(-K.D[k], gradient(tip.joints, [&](const VectorXd& own) { return grasp.torques(rest, with(own), k); }),
                  "D");
    }
  }
}

}  // namespace
}  // namespace thenar::grasp_stiffness_test
