// SPDX-License-Identifier: Apache-2.0
#include "engine/capacity/opposition.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "engine/grasp/pulp_touch.h"

namespace thenar {

using Eigen::Vector3d;

namespace {

struct Pad {
  Vector3d centre_m, normal;
};

/// Returns Van der Corput's sequence: fills 0 .. 1 evenly, differently for each base.
double filling(int index, int base) {
  double value = 0.0, digit = 1.0;
  for (; index > 0; index /= base) {
    digit /= base;
    value += digit * (index % base);
  }
  return value;
}

std::vector<std::vector<Pad>> sample_pads(const Hand& hand) {
  constexpr int kPostures = 1500, kBases[kMaxFingerJoints] = {2, 3, 5, 7, 11};
  std::vector<std::vector<Pad>> pads(static_cast<std::size_t>(hand.fingers()));
  HandPose pose;
  JointVector q = hand.at_zero();
  for (int i = 0; i < kPostures; ++i) {
    for (const Fingertip& tip : hand.fingertips) {
      for (int j = 0; j < tip.joints; ++j) {
        const Joint& joint = hand.joints[tip.first_joint + j];
        q[tip.first_joint + j] = joint.lower_rad + filling(i, kBases[j]) * (joint.upper_rad - joint.lower_rad);
      }
    }
    forward_kinematics(hand, q, pose);
    for (int k = 0; k < hand.fingers(); ++k) {
      const Eigen::Isometry3d& X_WF = pose.distal(hand, k);
      pads[k].push_back({X_WF * hand.fingertips[k].centre_m, X_WF.linear() * hand.fingertips[k].normal});
    }
  }
  return pads;
}

std::optional<FacingFingers> find_opposition(const std::vector<Pad>& one, const std::vector<Pad>& other,
                                             double radii_m) {
  const double facing = std::cos(std::numbers::pi / 6.0);
  std::optional<FacingFingers> found;
  for (const Pad& a : one) {
    for (const Pad& b : other) {
      const Vector3d apart = b.centre_m - a.centre_m;
      const double distance = apart.norm(), gap = distance - radii_m;
      if (gap < 0.0 || a.normal.dot(apart) < facing * distance || -b.normal.dot(apart) < facing * distance) continue;
      if (!found) found = FacingFingers{0, 0, gap, gap};
      found->least_m = std::min(found->least_m, gap);
      found->most_m = std::max(found->most_m, gap);
    }
  }
  return found;
}

}  // namespace

std::vector<FacingFingers> find_oppositions(const Hand& hand) {
  const std::vector<std::vector<Pad>> pads = sample_pads(hand);
  std::vector<FacingFingers> all;
  for (int i = 0; i < hand.fingers(); ++i) {
    for (int j = i + 1; j < hand.fingers(); ++j) {
      const auto thick_m = [&](int k) { return extent_m(hand.fingertips[k], hand.fingertips[k].normal); };
      std::optional<FacingFingers> found = find_opposition(pads[i], pads[j], thick_m(i) + thick_m(j));
      if (!found) continue;
      found->one = i;
      found->other = j;
      all.push_back(*found);
    }
  }
  return all;
}

}  // namespace thenar
