// SPDX-License-Identifier: Apache-2.0
#include "engine/hand/muscles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

/// A crossing at a pose, for its joints together, or for one of them alone.
struct Run {
  Vector3d M, D;          ///< Where it pulls, and the unit vector in which it does; world.
  double length_m = 0.0;  ///< Distance of M from its via point; infinity: a direction.

  [[nodiscard]] double arm_m(const Vector3d& origin, const Vector3d& axis) const {
    return (M - origin).cross(D).dot(axis);
  }
  /// Returns -dD/dq of joints that move M by m_i, m_k, times m_i.
  [[nodiscard]] double turning(const Vector3d& m_i, const Vector3d& m_k) const {
    return (m_i.dot(m_k) - D.dot(m_i) * D.dot(m_k)) / length_m;
  }
};

Run run_between(const MuscleCrossing& crossing, const Vector3d& M, const Eigen::Isometry3d& X_pull) {
  const Vector3d pull =
      crossing.pull_is_point ? Vector3d(X_pull * crossing.pull - M) : Vector3d(X_pull.linear() * crossing.pull);
  const double length_m = pull.norm();
  return {M, pull / length_m, crossing.pull_is_point ? length_m : std::numeric_limits<double>::infinity()};
}

bool is_together(const Hand& hand, const MuscleCrossing& crossing) {
  const Segment &moved = hand.segments[crossing.insertion_segment], &pull = hand.segments[crossing.pull_segment];
  const bool chained = pull.joints > 0 && pull.finger == moved.finger;
  const int between = moved.joints + moved.followers - (chained ? pull.joints + pull.followers : 0);
  return between == std::ssize(crossing.joints) && std::ranges::all_of(crossing.joints, [&](int i) {
           return hand.moves(i, moved) && (pull.joints == 0 || !hand.moves(i, pull));
         });
}

Run run_together(const HandPose& pose, const MuscleCrossing& crossing) {
  return run_between(crossing, pose.segments[crossing.insertion_segment] * crossing.insertion_m,
                     pose.segments[crossing.pull_segment]);
}

double angle_of(const Hand& hand, int i, const JointVector& q) {
  return i < std::ssize(hand.joints) ? q[i] : hand.followers[i - hand.joints.size()].angle(q);
}

/// A crossing for one joint alone, all others at zero.
struct AloneRun {
  Run run;
  bool turns = false;  ///< The joint moves where it pulls, and not where it pulls to: otherwise its arm is constant.
};

AloneRun run_alone(const Hand& hand, const MuscleCrossing& crossing, int i, double angle_rad) {
  const Segment &moved = hand.segments[crossing.insertion_segment], &pull = hand.segments[crossing.pull_segment];
  const Joint& joint = hand.joint(i);
  Vector3d M = moved.X_WS_0 * crossing.insertion_m;
  const bool turns = hand.moves(i, moved) && (pull.joints == 0 || !hand.moves(i, pull));
  if (turns) M = joint.origin_m + Eigen::AngleAxisd(angle_rad, joint.axis) * (M - joint.origin_m);
  return {run_between(crossing, M, pull.X_WS_0), turns};
}

/// Calls visit(joint, share of the arm) for the contributions of both kinds of crossings to H.
template <typename Add>
void for_each_arm(const Hand& hand, const HandPose& pose, const MuscleCrossing& crossing, const Add& add) {
  if (is_together(hand, crossing)) {
    const Run run = run_together(pose, crossing);
    for (const int i : crossing.joints) add(i, crossing.share * run.arm_m(pose.origin_m[i], pose.axis[i]));
    return;
  }
  for (const int i : crossing.joints) {
    const Joint& joint = hand.joint(i);
    const AloneRun alone = run_alone(hand, crossing, i, angle_of(hand, i, pose.q));
    add(i, crossing.share * alone.run.arm_m(joint.origin_m, joint.axis));
  }
}

/// Computes dh/dq of a crossing, the slopes of joint i's arm by joint k, both among its joints.
template <typename Add>
void for_each_slope(const Hand& hand, const HandPose& pose, const MuscleCrossing& crossing, const Add& add) {
  if (is_together(hand, crossing)) {
    const Run run = run_together(pose, crossing);
    const auto way = [&](int i) -> Vector3d { return pose.axis[i].cross(run.M - pose.origin_m[i]); };
    for (std::size_t a = 0; a < crossing.joints.size(); ++a) {
      for (std::size_t b = a; b < crossing.joints.size(); ++b) {  // The joint a is nearer to the palm.
        const int i = crossing.joints[a], k = crossing.joints[b];
        const double slope = run.D.dot(pose.axis[i].cross(way(k))) - run.turning(way(i), way(k));
        add(i, k, crossing.share * slope);
        if (a != b) add(k, i, crossing.share * slope);
      }
    }
    return;
  }
  for (const int i : crossing.joints) {
    const AloneRun alone = run_alone(hand, crossing, i, angle_of(hand, i, pose.q));
    if (!alone.turns) continue;
    const Joint& joint = hand.joint(i);
    const Vector3d way = joint.axis.cross(alone.run.M - joint.origin_m);
    add(i, i, crossing.share * (alone.run.D.dot(joint.axis.cross(way)) - alone.run.turning(way, way)));
  }
}

int finger_of(const Hand& hand, const MuscleCrossing& crossing) {
  const int leader = hand.leader(crossing.joints.front());
  int k = 0;
  while (!hand.fingertips[k].has_joint(leader)) ++k;
  return k;
}

}  // namespace

Eigen::VectorXd muscle_lengths(const Hand& hand, const HandPose& pose) {
  Eigen::VectorXd lengths_m = Eigen::VectorXd::Zero(std::ssize(hand.muscles));
  const auto length = [](const Run& run) { return std::isfinite(run.length_m) ? run.length_m : -run.M.dot(run.D); };
  for (std::size_t m = 0; m < hand.muscles.size(); ++m) {
    double& l = lengths_m[static_cast<Index>(m)];
    for (const MuscleCrossing& crossing : hand.muscles[m].crossings) {
      if (is_together(hand, crossing)) {
        // A string between two fingers has a crossing for each.
        const Segment &moved = hand.segments[crossing.insertion_segment], &pull = hand.segments[crossing.pull_segment];
        const double part = pull.joints > 0 && pull.finger != moved.finger ? 0.5 : 1.0;
        l += part * crossing.share * length(run_together(pose, crossing));
        continue;
      }
      for (const int i : crossing.joints) {
        const double angle_rad = angle_of(hand, i, pose.q);
        const AloneRun alone = run_alone(hand, crossing, i, angle_rad);
        const Joint& joint = hand.joint(i);
        l += crossing.share *
             (alone.turns ? length(alone.run) : -angle_rad * alone.run.arm_m(joint.origin_m, joint.axis));
      }
    }
  }
  return lengths_m;
}

void moment_arms(const Hand& hand, const HandPose& pose, Eigen::Ref<Eigen::MatrixXd> H) {
  H.setZero();
  for (std::size_t m = 0; m < hand.muscles.size(); ++m) {
    auto column = H.col(static_cast<Index>(m));
    for (const MuscleCrossing& crossing : hand.muscles[m].crossings) {
      for_each_arm(hand, pose, crossing, [&](int i, double arm_m) { column[hand.leader(i)] += hand.ratio(i) * arm_m; });
    }
  }
}

std::vector<Belly> bellies_of(const Hand& hand) {
  std::vector<Belly> bellies;
  for (int k = 0; k < hand.fingers(); ++k) {
    for (std::size_t m = 0; m < hand.muscles.size(); ++m) {
      double share = 0.0;
      bool elsewhere = false;
      for (const MuscleCrossing& crossing : hand.muscles[m].crossings) {
        const bool here = finger_of(hand, crossing) == k;
        elsewhere = elsewhere || !here;
        if (here) share = std::max(share, crossing.share);
      }
      if (share > 0.0) bellies.push_back({static_cast<int>(m), k, elsewhere ? share : 1.0, {}, {}});
    }
  }
  return bellies;
}

void find_bellies(const Hand& hand, const HandPose& pose, std::span<Belly> bellies) {
  for (Belly& belly : bellies) {
    const Fingertip& tip = hand.fingertips[belly.finger];
    belly.arms_m = FingerVector::Zero(std::max(4, tip.joints));
    belly.slopes_m = JointMatrix::Zero(tip.joints, tip.joints);
    const auto own = [&](int i) { return hand.leader(i) - tip.first_joint; };
    for (const MuscleCrossing& crossing : hand.muscles[belly.muscle].crossings) {
      if (finger_of(hand, crossing) != belly.finger) continue;
      for_each_arm(hand, pose, crossing, [&](int i, double arm_m) { belly.arms_m[own(i)] += hand.ratio(i) * arm_m; });
      for_each_slope(hand, pose, crossing, [&](int i, int k, double slope_m) {
        belly.slopes_m(own(i), own(k)) += hand.ratio(i) * hand.ratio(k) * slope_m;
      });
    }
  }
}

JointVector muscle_torques(const Hand& hand, std::span<const Belly> bellies,
                           const Eigen::Ref<const Eigen::VectorXd>& forces_N) {
  JointVector tau = hand.at_zero();
  for (const Belly& belly : bellies) {
    const Fingertip& tip = hand.fingertips[belly.finger];
    tau.segment(tip.first_joint, tip.joints) += forces_N[belly.muscle] * belly.arms_m.head(tip.joints);
  }
  return tau;
}

JointMatrix muscle_stiffness(const Hand& hand, std::span<const Belly> bellies, int finger, double gamma,
                             const Eigen::Ref<const Eigen::VectorXd>& forces_N) {
  const int joints = hand.fingertips[finger].joints;
  JointMatrix K = JointMatrix::Zero(joints, joints);
  for (const Belly& belly : bellies) {
    if (belly.finger != finger) continue;
    const double f = forces_N[belly.muscle];
    const double k = belly_stiffness(hand, belly, gamma, f);
    for (int j = 0; j < joints; ++j) {
      for (int i = 0; i < joints; ++i) {
        K(i, j) += k * belly.arms_m[i] * belly.arms_m[j] - f * belly.slopes_m(i, j);
      }
    }
  }
  return K;
}

JointMatrix force_stiffness(const Hand& hand, const HandPose& pose, const Segment& segment, const Vector3d& point_m,
                            const Vector3d& force_N) {
  const Fingertip& tip = hand.fingertips[segment.finger];
  JointMatrix K = JointMatrix::Zero(tip.joints, tip.joints);
  // Joints and followers from the palm on.
  std::array<int, 2 * kMaxFingerJoints> chain;
  int links = 0, next = tip.first_follower;
  for (int j = 0; j < segment.joints; ++j) {
    chain[links++] = tip.first_joint + j;
    for (; next < tip.first_follower + segment.followers && hand.followers[next].after == j + 1; ++next) {
      chain[links++] = static_cast<int>(hand.joints.size()) + next;
    }
  }
  for (int b = 0; b < links; ++b) {
    const Vector3d way = pose.axis[chain[b]].cross(point_m - pose.origin_m[chain[b]]);
    for (int a = 0; a <= b; ++a) {
      const int i = hand.leader(chain[a]) - tip.first_joint, k = hand.leader(chain[b]) - tip.first_joint;
      const double slope = hand.ratio(chain[a]) * hand.ratio(chain[b]) * force_N.dot(pose.axis[chain[a]].cross(way));
      K(i, k) += slope;
      if (a != b) K(k, i) += slope;
    }
  }
  return K;
}

JointMatrix gravity_stiffness(const Hand& hand, const HandPose& pose, int finger, const Vector3d& gravity) {
  const int joints = hand.fingertips[finger].joints;
  JointMatrix K = JointMatrix::Zero(joints, joints);
  for (std::size_t s = 0; s < hand.segments.size(); ++s) {
    const Segment& segment = hand.segments[s];
    if (segment.finger != finger || segment.joints == 0) continue;
    K -= force_stiffness(hand, pose, segment, pose.segments[s] * segment.com_m, segment.mass_kg * gravity);
  }
  return K;
}

}  // namespace thenar
