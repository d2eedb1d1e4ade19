// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "engine/grasp/delassus.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"

namespace thenar {

/// Computes the compliance among the contacts that the frame holds, of the pulps and of a soft object. The axes are
/// those that the contacts have in a tick (ContactKinematics).
void fill_kernels(const Model& model, Frame& frame);

/// Keeps the compliance of frames while it is the same from one to the next, as in most of them: the same contacts in
/// order, each a whole cell, with the same softness. The sweeps then keep their blocks, too; and while the contacts are
/// the same, what they have learned.
class KeptCompliance {
 public:
  explicit KeptCompliance(const Model& model);

  /// Numbers the contacts and the compliance of the next frame, and computes this unless the frame has it already.
  void update(const Model& model, Frame& frame);

  template <typename Archive>
  friend void members(Archive& a, KeptCompliance& x) {
    a(x.list_, x.edition_, x.whole_, x.begin_, x.control_points_, x.softness_);
  }

 private:
  [[nodiscard]] bool has_contacts_of(const Frame& frame) const;

  std::int64_t list_ = 0, edition_ = 0;  // 0 before the first frame.
  bool whole_ = false;                   // True if the last compliance follows from the members below.
  std::vector<Eigen::Index> begin_, control_points_;
  PerFinger<double> softness_;
};

/// Workspace of deform, for one finger at a time.
struct PulpLoads {
  struct Load {
    Eigen::Index control_point;
    Eigen::Vector3f w;  ///< f, its part across the normal times c_t; distal frame.
  };
  explicit PulpLoads(const Model& model);

  std::vector<Load> loads;
  Eigen::Matrix3Xd u_m;  ///< u+ at the contacts, distal frame.
};

/// Computes u = rho u + (1 - rho) C f of finger k, at all its control points. At those of the frame's contacts,
/// (1 - rho) C f is the solver's own `surface_motion` (GroupedWorkspace): in a motion of its own a finger that sticks
/// would walk. At the others, which bear no force, forces across the normal act by c_t in all directions, the mean of
/// Cerruti's tensor: the tensor itself would cost four times as much. Their sums are of single precision, which rounds
/// u by some 1e-10 m under a few newtons. `f` holds the frame's contact forces, rows (n, t1, t2) each, as
/// surface_motion has. Does not allocate.
void deform(const Model& model, const Frame& frame, const ContactKinematics& now, int k, const Eigen::VectorXd& f,
            const Eigen::VectorXd& surface_motion, PulpLoads& work, State& state);

}  // namespace thenar
