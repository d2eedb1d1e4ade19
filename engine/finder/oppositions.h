// SPDX-License-Identifier: Apache-2.0
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

/// A measure of how much of the surface near a point is one smooth piece.
class PatchMeter {
 public:
  /// `radius_m` is that of a contact patch. It keeps a reference to the surface.
  PatchMeter(const ImplicitSurface& object, double radius_m);

  /// Returns the share of a disc about the sample nearest to x that samples with normals within 60 degrees of its own
  /// fill: 1 on planes and spheres, about a half at an edge, less at a hole.
  [[nodiscard]] double share(const Eigen::Vector3d& x_O) const;
  [[nodiscard]] double share_at(Eigen::Index sample) const;
  /// Returns the mean normal over the patch about a sample, which acts on a soft fingertip.
  [[nodiscard]] Eigen::Vector3d mean_normal(Eigen::Index sample) const;

 private:
  const ImplicitSurface& object_;
  double radius_m_, sample_area_m2_;
  PointGrid grid_;
};

/// Two points of the object that face away from one another.
struct Opposition {
  Eigen::Vector3d from_O, to_O;  ///< Possible contacts of the opposer and of the others.
  double width_m = 0.0;
  double angle_rad = 0.0;  ///< Larger angle between a normal and the line.
  double cost = 0.0;
};

/// Result of a search for oppositions.
struct Oppositions {
  std::vector<Opposition> pairs;              ///< Best first, no two alike.
  int places = 0;                             ///< Number of samples on patches that a pulp can reach.
  double least_angle_rad = std::numbers::pi;  ///< Least angle of all pairs of these, at any width.
  double least_width_m = 0.0;                 ///< Least width of pairs within the cones; 0: there are none.
  bool fits = false;                          ///< True if one of them fits between the hand's fingers.
};

struct OppositionSettings {
  double cone_rad = 0.0;               ///< Friction angle.
  double least_m = 0.0, most_m = 0.0;  ///< Range of the hand's opening.
  double reach_m = 0.0;                ///< Radius of a pulp less its depth, which must fit at a contact.
  Eigen::Vector3d centre_of_mass_m = Eigen::Vector3d::Zero();
  GraspWish wish = {};
  int places = 160, pairs = 48;
  std::uint32_t seed = 1;
};

[[nodiscard]] Oppositions find_oppositions(const ImplicitSurface& object, const PatchMeter& patches,
                                           const OppositionSettings& settings);

}  // namespace thenar
