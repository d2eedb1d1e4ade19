#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "engine/frame.h"
#include "engine/hand.h"
#include "engine/model.h"
#include "engine/state.h"

namespace thenar {

/// J_c of a frame's contacts at one state: how the bodies' motion changes gaps and slips. Finger and object meet at the
/// deformed finger point, where the force acts; elsewhere J_c would not be the derivative of the gap.
struct ContactJacobian {
  explicit ContactJacobian(const Model& model);

  Eigen::Matrix<double, Eigen::Dynamic, kJointsPerFinger> finger;  ///< Rows -E' J_k; 3 capacity x 4.
  Eigen::Matrix<double, Eigen::Dynamic, 6> object;                 ///< Rows E' [I, -[r]x]; 3 capacity x 6.
  std::vector<Eigen::Matrix3d> E_W;                                ///< Columns n, t1, t2, world axes.
  std::vector<Eigen::Vector3d> c_O;                                ///< Where finger and object meet, object frame.
};

/// Computes J_c for the contacts of a frame, with the bodies as the state and the pose of its hand have them.
void fill_jacobian(const Model& model, const Frame& frame, const HandPose& pose, const State& state,
                   ContactJacobian& jacobian);

/// How far a step h moves the bodies for a unit of force: h B^-1, B = diag(b I, b_t I, b_o I). A spring k that pulls a
/// body adds h k to its viscosity, for it is taken at the end of the step.
struct Mobility {
  double joint;        ///< [rad/(N m)]
  double translation;  ///< [m/N]
  double rotation;     ///< [rad/(N m)]
};

/// The scene's, with the stiffness of the springs on each joint [N m/rad].
[[nodiscard]] Mobility mobility(const Scene& scene, double joint_stiffness = 0.0);

/// W(h) = J_c h B^-1 J_c' + (1 - rho) C of eqs. (31, 36): the Delassus operator of a step h. W is 3n x 3n, n =
/// frame.size() [m/N].
void assemble_delassus(const Model& model, const Frame& frame, const ContactJacobian& jacobian,
                       const Mobility& mobility, Eigen::Ref<Eigen::MatrixXd> W);

}  // namespace thenar
