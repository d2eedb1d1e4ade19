// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "engine/grasp/contact_kinematics.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/ledger.h"
#include "engine/grasp/scene.h"
#include "engine/grasp/state.h"
#include "engine/hand/hand.h"

/// Fingertips on slides. One that a force or a spring moves has one joint, along which b qdot = F + k (rest - q) - n.f
/// with the contact force f on the object, and is rigid in all other directions. One on a path has three, along the
/// axes of the world: its motion in a step is given, so that they have no mobility in W, and whatever it takes drives
/// them.
namespace thenar {

inline constexpr double kSlideDamping_N_s_per_m = 10.0;  ///< Default damping: 2 N move it 1 mm in 5 ms.
inline constexpr double kSlideReach_m = 1.0;             ///< Default position of the stops; paths stay within.

/// Returns a hand for fingertips on slides, as yet without any.
[[nodiscard]] Hand hand_of_slides();

/// Adds a fingertip of this radius whose centre begins at a place, and which goes along a unit vector from there; or
/// wherever a path takes it.
void add_slide(const std::string& name, const Eigen::Vector3d& at_m, const Eigen::Vector3d& along, double radius_m,
               bool has_path, Hand& hand);

/// Returns the displacement of a slide's fingertip along its path at this time, from its start; world axes [m].
[[nodiscard]] Eigen::Vector3d path_m(const Slide& slide, double time_s);

/// Adds to the drive of the joints [N] the forces of the scene's slides at this time and position q; none for slides on
/// paths. Springs are taken at q: that they end a step elsewhere is in the mobility.
void drive_slides(const Scene& scene, double time_s, const JointVector& q, JointVector& drive_N);

/// Returns the travel of fingertip k in `time_s` from the snapshot on, against the contact forces there and with this
/// drive beside that of the slides [m].
[[nodiscard]] double slide_travel_m(const Scene& scene, const Snapshot& snapshot, const JointVector& drive_N, int k,
                                    double time_s);

/// Gives the joints of paths, in a step that ends then, the motion that takes them where their paths are.
void follow_paths(const Scene& scene, double end_s, const JointVector& q, JointVector& dq);

/// Books the work that a tick's ledger, which takes all joints for viscous ones, lacks for slides moved by dq under the
/// forces f of the contact rows: springs, taken at the end of the step, and the drive of paths. That is a
/// drive, and overcomes the contact forces alone.
void book_slides(const Scene& scene, const Frame& frame, const ContactKinematics& kinematics, const Eigen::VectorXd& f,
                 const JointVector& dq, Ledger& ledger);

}  // namespace thenar
