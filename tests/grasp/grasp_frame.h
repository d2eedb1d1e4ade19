// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>

#include "engine/grasp/frame.h"
#include "tests/support/scenes.h"
#include "tests/support/three_fingers.h"

/// A grasp at work, and what its contacts make of the speeds of joints and object.
namespace thenar::grasp_frame {

using Eigen::Index;
using Eigen::MatrixXd;

inline constexpr int kSpeeds = kJoints + 6;  ///< Joints, object's velocity, object's angular velocity.

/// J_c of all the frame's contacts for all speeds.
inline MatrixXd dense(const Frame& frame, const ContactKinematics& now) {
  MatrixXd J = MatrixXd::Zero(3 * frame.size(), kSpeeds);
  for (Index i = 0; i < frame.size(); ++i) {
    const int first = kJointsPerFinger * frame.contacts[i].finger;
    J.block<3, kJointsPerFinger>(3 * i, first) = now.J_finger.middleRows<3>(3 * i);
    J.block<3, 6>(3 * i, kJoints) = now.J_object.middleRows<3>(3 * i).leftCols<6>();
  }
  return J;
}

/// The box grasp at work, 20 ms after its start: three fingers pressed against the box.
class GraspFrame : public testing::Test {
 protected:
  GraspFrame() : loop(scene_of("box_grasp", {kCoarseBox})) {
    loop.run(20e-3);
    loop.control();
    forward_kinematics(model.scene.hand, loop.state.q, pose);
    contact_kinematics(model, frame, pose, loop.state, now);
  }
  Loop loop;
  const Model& model = loop.model;
  const Frame& frame = loop.frame;
  HandPose pose;
  ContactKinematics now{model};
};

}  // namespace thenar::grasp_frame
