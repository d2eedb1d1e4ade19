// SPDX-License-Identifier: Apache-2.0
#include "engine/figures/hand_picture.h"

#include <fmt/format.h>

#include <vector>

#include "engine/figures/gnuplot.h"
#include "engine/figures/surfels.h"

namespace thenar {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// From the palm to the fingertips, and out of the palm, both unit and across one another.
struct HandAxes {
  Vector3d distal, palmar;
};

HandAxes axes_of(const Hand& hand, const HandPose& pose) {
  Vector3d distal = Vector3d::Zero(), palmar = Vector3d::Zero();
  for (int k = 0; k < hand.fingers(); ++k) {
    // The first finger of several is the thumb, which lies across.
    if (k == 0 && hand.fingers() > 2) continue;
    const Eigen::Isometry3d& X_WF = pose.distal(hand, k);
    distal += X_WF * hand.fingertips[k].centre_m - pose.origin_m[hand.fingertips[k].first_joint];
    palmar += X_WF.linear() * hand.fingertips[k].normal;
  }
  distal = distal.norm() > 0.0 ? distal.normalized() : Vector3d::UnitX();
  palmar -= palmar.dot(distal) * distal;
  palmar = palmar.norm() > 1e-6 ? palmar.normalized() : distal.unitOrthogonal();
  return {distal, palmar};
}

std::string panel(const Hand& hand, const HandPose& pose, const Matrix3d& view, int column, const char* title) {
  std::vector<Surfel> surfels;
  add_bones(hand, pose, surfels);
  for (int k = 0; k < hand.fingers(); ++k) {
    add_rigid_pulp(hand.fingertips[k], pose.distal(hand, k), surfels);
  }
  return fmt::format(
      "$hand{0} << EOD\n{1}EOD\nset lmargin at screen {2}\nset rmargin at screen {3}\nset bmargin at screen 0.02\n"
      "set tmargin at screen 0.92\nset title '{4}'\nplot $hand{0} {5}\n",
      column, painted(surfels, view), 0.02 + 0.5 * column, 0.48 + 0.5 * column, title, kDiscs);
}

}  // namespace

std::string hand_picture_script(const Hand& hand) {
  HandPose pose;
  forward_kinematics(hand, hand.at_zero(), pose);
  const HandAxes axes = axes_of(hand, pose);
  JointVector q = hand.at_zero();
  for (std::size_t j = 0; j < hand.joints.size(); ++j) {
    q[static_cast<Eigen::Index>(j)] = 0.5 * (hand.joints[j].lower_rad + hand.joints[j].upper_rad);
  }
  forward_kinematics(hand, q, pose);
  const Vector3d across = axes.distal.cross(axes.palmar);
  Matrix3d front, side;
  front << across.transpose(), axes.distal.transpose(), axes.palmar.transpose();
  side << -axes.palmar.transpose(), axes.distal.transpose(), across.transpose();
  return "set terminal pngcairo size 900,520 font 'Helvetica,13' background rgb 'white'\n"
         "unset border\nunset tics\nunset key\nset size ratio -1\nset offsets 1,1,1,1\n"
         "set style fill solid 1.0 noborder\nset multiplot\n" +
         panel(hand, pose, front, 0, "towards the palm") + panel(hand, pose, side, 1, "from the side") +
         "unset multiplot\n";
}

}  // namespace thenar
