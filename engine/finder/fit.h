// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "collision/implicit_surface.h"
#include "engine/finder/found_grasp.h"
#include "engine/finder/hand_body.h"
#include "engine/finder/least_squares.h"
#include "engine/hand/hand.h"

namespace thenar {

/// Joint angles of a hand, and the pose of an object in it.
struct Stance {
  JointVector q;
  Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
};

/// The targets of a fit, beyond those of every grasp.
struct FitTarget {
  int opposer = 0;
  PerFinger<double> depth_m;                           ///< Desired indentation of each pulp.
  std::optional<Eigen::Vector3d> opposer_O, others_O;  ///< Approximate contacts of the opposer and the others' middle.
  JointVector q_near;                                  ///< The initial posture.
  Eigen::Vector3d approach_W = Eigen::Vector3d::UnitX();  ///< Approach direction of the hand.
  GraspWish wish = {};
  Eigen::Vector3d centre_of_mass_m = Eigen::Vector3d::Zero();
  bool limits = true;  ///< False: without joint limits, to show how far a joint would have to bend.
};

/// The contact of a finger's pulp with the object.
struct FoundTouch {
  double gap_m = 0.0;  ///< Gap of the undeformed pulp plus the desired indentation.
  Eigen::Vector3d point_O = Eigen::Vector3d::Zero(), normal_O = point_O;
  double cosine = 0.0;  ///< Cosine between the pulp's mean normal and the inward normal.
};

/// The faults of a stance as a grasp, each as the violation of its bound; 0: none.
struct FitFaults {
  double gap_m = 0.0;
  double facing_rad = 0.0;
  double body_m = 0.0;   ///< Depth of a bone in the object.
  double apart_m = 0.0;  ///< Overlap of pulps.
  double bones_m = 0.0;  ///< Overlap of bones.
  double limit_rad = 0.0;
  double axis_rad = 0.0, at_m = 0.0, approach_rad = 0.0;  ///< Deviations from the user's wishes.
  int facing_finger = 0;
  int body_segment = -1;
  int bones_finger = -1, bones_other = -1;

  [[nodiscard]] bool none() const { return badness() == 0.0; }
  /// Returns all of them in one number.
  [[nodiscard]] double badness() const;
};

/// The fit of stances to an object; its terms and weights are in the source.
class StanceFit {
 public:
  StanceFit(const Hand& hand, const std::vector<BodyPoint>& body, const ImplicitSurface& object);

  /// Fits by damped least squares from a stance on.
  [[nodiscard]] Stance fit(const Stance& start, const FitTarget& target, int most_steps);
  [[nodiscard]] NormalEquations equations(const Stance& stance, const FitTarget& target);
  /// Computes the sum of squares that ranks a start, of pulps and bones alone: cheaper than equations(). Stops where it
  /// exceeds `enough`.
  [[nodiscard]] double rough_cost(const Stance& stance, const HandPose& pose, const FitTarget& target,
                                  double enough) const;

  [[nodiscard]] PerFinger<FoundTouch> touches(const Stance& stance, const FitTarget& target);
  [[nodiscard]] FitFaults faults(const Stance& stance, const FitTarget& target);

 private:
  [[nodiscard]] SurfaceDistance distance(const Eigen::Vector3d& x_O) const;
  void look(const Stance& stance, const FitTarget& target, bool with_slopes);
  void add_touches(const FitTarget& target, NormalEquations& sum) const;
  void add_balance(const FitTarget& target, NormalEquations& sum) const;
  void add_body(const Stance& stance, NormalEquations& sum) const;
  void add_apart(NormalEquations& sum) const;
  /// Adds the derivatives by the joints of a hand point's position along d.
  void add_way(const BodyPoint& point, const Eigen::Vector3d& p_W, const Eigen::Vector3d& d, Unknowns& row) const;
  void add_bones(NormalEquations& sum);
  void add_limits(const Stance& stance, const FitTarget& target, NormalEquations& sum) const;
  void add_wishes(const Stance& stance, const FitTarget& target, NormalEquations& sum) const;

  using Rows = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxUnknowns>;

  /// A finger's pulp, and its derivatives by the unknowns.
  struct Finger {
    PulpPose pulp;
    double gap_m = 0.0;
    Eigen::Vector3d c_O = Eigen::Vector3d::Zero(), point_O = c_O, normal_O = c_O, n_W = c_O;
    Rows G;  ///< Contact, at the middle of the ball there, relative to the object.
    Rows N;  ///< The surface's normal there.
    Rows M;  ///< The pulp's mean normal.
    Rows C;  ///< The pulp's centre in the world.
  };

  const Hand& hand_;
  const std::vector<BodyPoint>& body_;
  const ImplicitSurface& object_;
  Bones bones_;
  std::vector<Eigen::Vector3d> bones_W_;
  Eigen::Index unknowns_;
  HandPose pose_;
  PerFinger<Finger> fingers_;
  Eigen::Isometry3d X_WO_;
};

/// Returns the stance after a step, with joints within their limits.
[[nodiscard]] Stance moved(const Hand& hand, const Stance& stance, const Unknowns& step, bool limits);

}  // namespace thenar
