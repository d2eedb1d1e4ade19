// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "solvers/grouped_delassus.h"

namespace thenar {

// The object's own compliance, for a scene that names one: a half space under every part of its surface, as under a
// pulp's (pulp.h). A force f_j at the surface point s_j moves the surface at s_i by
//     u_i = k_ij T_i T_j f_j,   k_ij the pulp's Boussinesq kernel (pulp.h),   T = sqrt(c_t) I + (1 - sqrt(c_t)) n n'
// with the object's E*, nu. Across the normal it has the mean c_t = (2 - nu) / (2 (1 - nu)) of Cerruti's tensor, which
// pulps have whole: its loads come from all fingers and outlive their contacts, and the tensor of each pair would have
// to be made in every tick. So a soft object resists torsion more than a half space does. Both bodies share one patch:
// the force is spread over the area of the finger's control point. So two bodies of one material share their
// displacement equally, and a pulp on a soft plane presses like Hertz with 1/E* = 1/E*_f + 1/E*_o within 3 %. Forces
// taken at the nearest of the object's own control points gave up to twice that, and steps where a contact passes from
// one to the next.
//
// Signs: f acts on the object, whose surface moves with it, by +u_o (object frame); the pulp's by -u_f. Seen from the
// finger both open the gap: n.((s + u_o) - (p - u_f)), and in contact rows u = u_f + u_o.
//
// Memory: while the points stay, u+ = (1 - rho) C f + rho u is u = C phi of the filtered forces phi+ = (1 - rho) f +
// rho phi. The state keeps T phi, one load a contact, where it acted last; a contact that slides takes its load along.

/// Computes k_ij among all contacts of the frame, also of different fingers. Requires the frame's contacts.
void fill_object_kernel(const Model& model, Frame& frame);

/// Returns T at a contact, for its normal; it is fixed in the object while a frame is in use.
[[nodiscard]] Eigen::Matrix3d object_tensor(const Model& model, const FrameContact& contact);

/// Returns (1 - rho_o) C_o of a soft object, C_ij = k_ij E_i' T_i T_j E_j in contact rows; nothing for a rigid one.
/// tensors: rows E_O' T of the contacts, as ContactKinematics has them. It refers to both.
[[nodiscard]] SharedCompliance object_compliance(const Model& model, const Frame& frame,
                                                 const GroupedDelassus::Axes& tensors);

/// Returns u_o of the object's surface at a contact, object frame; zero for a rigid object.
[[nodiscard]] Eigen::Vector3d object_displacement(const Model& model, const State& state, const FrameContact& contact);

/// Computes the same at all contacts of the frame, rows of u_O (n x 3, or more); nothing for a rigid object. Where a
/// load is a contact's own, it must be where that touches (carry_loads): the frame knows the kernel then. Does not
/// allocate.
void object_displacements(const Model& model, const Frame& frame, const State& state, Eigen::MatrixX3d& u_O);

/// Moves the loads of the frame's contacts to where those touch now. For the hand-over. Does not allocate.
void carry_loads(const Model& model, const Frame& frame, State& state);

/// phi+ = (1 - rho) f + rho phi of the forces that the frame's contacts carry, rows (n, t1, t2) each. Loads below
/// kForgotten_N are dropped, and the least of them where there are too many. Does not allocate.
void remember_loads(const Model& model, const Frame& frame, const GroupedDelassus::Axes& tensors,
                    const Eigen::VectorXd& f, State& state);

/// Load that moves a surface as soft as a pulp by a hundredth of a nanometre.
inline constexpr double kForgotten_N = 1e-8;

}  // namespace thenar
