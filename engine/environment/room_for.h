#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>

#include "collision/solids/solid_contacts.h"
#include "engine/environment/environment.h"

namespace thenar {

/// What a scene begins with must not overlap by more than this, nor by more than 20 N press in: files have few digits.
inline constexpr double kMostOverlap_m = 2e-6, kMostOverlap_N = 20.0;

/// The object lies in a body of its environment.
struct Overlap {
  struct Place {
    std::size_t body = 0;
    Eigen::Vector3d p_E = Eigen::Vector3d::Zero();  ///< In that body's frame.
  };
  Place deepest;
  double depth_m = 0.0;
  /// Where there is no room beside it: what presses against the deepest contact, and by how much both do. No motion of
  /// the object opens both.
  std::optional<Place> against;
};

/// Whether the object cannot be at X_WO as a run begins; nothing: it can.
///
/// Without friction the forces of bodies that give way minimise an energy. At its least, forces that are left are
/// y >= 0 with sum y_i J_i = 0 and y . gap < 0: they prove that no motion opens all contacts.
[[nodiscard]] std::optional<Overlap> find_overlap(const Environment& environment, const TouchingSolid& object,
                                                  const Eigen::Isometry3d& X_WO);

}  // namespace thenar
