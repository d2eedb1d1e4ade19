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

/// A hand at an object.
struct Stance {
  JointVector q;
  Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
};

/// What a fit wants, beside what every grasp needs.
struct FitTarget {
  int opposer = 0;
  PerFinger<double> depth_m;                           ///< By which each pulp is to be pressed in.
  std::optional<Eigen::Vector3d> opposer_O, others_O;  ///< About where the opposer and the middle of the others touch.
  JointVector q_near;                                  ///< The posture that it starts from.
  Eigen::Vector3d approach_W = Eigen::Vector3d::UnitX();  ///< The way in which the hand comes.
  GraspWish wish = {};
  Eigen::Vector3d centre_of_mass_m = Eigen::Vector3d::Zero();
  bool limits = true;  ///< Without them it shows how far a joint would have to bend.
};

/// How a finger's pulp stands to the object.
struct FoundTouch {
  double gap_m = 0.0;  ///< Of the undeformed pulp, less the wanted depth.
  Eigen::Vector3d point_O = Eigen::Vector3d::Zero(), normal_O = point_O;
  double cosine = 0.0;  ///< Between the pulp's mean normal and the inward normal.
};

/// What keeps a stance from being a grasp, each as how far it is beyond its bound; 0: it keeps to it.
struct FitFaults {
  double gap_m = 0.0;
  double facing_rad = 0.0;
  double body_m = 0.0;   ///< How far a bone is in the object.
  double apart_m = 0.0;  ///< How far pulps are in one another.
  double bones_m = 0.0;  ///< How far bones are in one another.
  double limit_rad = 0.0;
  double axis_rad = 0.0, at_m = 0.0, approach_rad = 0.0;  ///< From what the user wants.
  int facing_finger = 0;
  int body_segment = -1;
  int bones_finger = -1, bones_other = -1;

  [[nodiscard]] bool none() const { return badness() == 0.0; }
  /// All of them in one number.
  [[nodiscard]] double badness() const;
};

/// Fits stances to an object: what the terms are, and what they are weighed by, is in the source.
class StanceFit {
 public:
  StanceFit(const Hand& hand, const std::vector<BodyPoint>& body, const ImplicitSurface& object);

  /// Damped least squares from a stance on.
  [[nodiscard]] Stance fit(const Stance& start, const FitTarget& target, int most_steps);
  [[nodiscard]] NormalEquations equations(const Stance& stance, const FitTarget& target);
  /// The sum of squares as a start is judged by, with the pulps and the bones alone: cheaper than equations(). Stops
  /// where it exceeds `enough`.
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
  /// How a point of the hand moves along d with the joints.
  void add_way(const BodyPoint& point, const Eigen::Vector3d& p_W, const Eigen::Vector3d& d, Unknowns& row) const;
  void add_bones(NormalEquations& sum);
  void add_limits(const Stance& stance, const FitTarget& target, NormalEquations& sum) const;
  void add_wishes(const Stance& stance, const FitTarget& target, NormalEquations& sum) const;

  using Rows = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxUnknowns>;

  /// A finger's pulp, and how it moves with the unknowns.
  struct Finger {
    PulpPose pulp;
    double gap_m = 0.0;
    Eigen::Vector3d c_O = Eigen::Vector3d::Zero(), point_O = c_O, normal_O = c_O, n_W = c_O;
    Rows G;  ///< Where it touches, at the middle of the ball there, against the object.
    Rows N;  ///< The surface's normal at it.
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

/// The stance after a step: joints within their limits.
[[nodiscard]] Stance moved(const Hand& hand, const Stance& stance, const Unknowns& step, bool limits);

}  // namespace thenar
