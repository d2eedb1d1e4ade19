#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include "collision/implicit_surface.h"
#include "collision/point_grid.h"
#include "engine/finder/found_grasp.h"

namespace thenar {

/// Knows how much of the surface near a place is one smooth piece.
class PatchMeter {
 public:
  /// `radius_m` is that of a pressed patch. It refers to the surface.
  PatchMeter(const ImplicitSurface& object, double radius_m);

  /// The share of a disc about the sample nearest to x that samples with normals within 60 degrees of the one there
  /// fill: 1 on planes and spheres, about a half at an edge, less at a hole.
  [[nodiscard]] double share(const Eigen::Vector3d& x_O) const;
  [[nodiscard]] double share_at(Eigen::Index sample) const;
  /// The mean normal over the patch about a sample: what a soft fingertip feels.
  [[nodiscard]] Eigen::Vector3d mean_normal(Eigen::Index sample) const;

 private:
  const ImplicitSurface& object_;
  double radius_m_, sample_area_m2_;
  PointGrid grid_;
};

/// Two places of the object that face away from one another.
struct Opposition {
  Eigen::Vector3d from_O, to_O;  ///< Where the opposer and the others might touch.
  double width_m = 0.0;
  double angle_rad = 0.0;  ///< The larger one between a normal and the line.
  double cost = 0.0;
};

/// What a search for them saw.
struct Oppositions {
  std::vector<Opposition> pairs;              ///< Best first, no two alike.
  int places = 0;                             ///< Samples on patches that a pulp can reach.
  double least_angle_rad = std::numbers::pi;  ///< Of all pairs of such places, at any width.
  double least_width_m = 0.0;                 ///< Of pairs within the cones; 0: there are none.
  bool fits = false;                          ///< One of them is within what the hand opens to.
};

struct OppositionSettings {
  double cone_rad = 0.0;               ///< Friction angle.
  double least_m = 0.0, most_m = 0.0;  ///< What the hand opens to.
  double reach_m = 0.0;                ///< Radius of a pulp less its depth: it must fit at a place.
  Eigen::Vector3d centre_of_mass_m = Eigen::Vector3d::Zero();
  GraspWish wish = {};
  int places = 160, pairs = 48;
  std::uint32_t seed = 1;
};

[[nodiscard]] Oppositions find_oppositions(const ImplicitSurface& object, const PatchMeter& patches,
                                           const OppositionSettings& settings);

}  // namespace thenar
