// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>

#include "collision/solids/solid_contacts.h"
#include "engine/environment/environment.h"

namespace thenar {

/// Largest initial overlap of a scene, or the overlap by 20 N if that is larger: files have few digits.
inline constexpr double kMostOverlap_m = 2e-6, kMostOverlap_N = 20.0;

/// An overlap of the object with a body of its environment.
struct Overlap {
  struct Place {
    std::size_t body = 0;
    Eigen::Vector3d p_E = Eigen::Vector3d::Zero();  ///< Contact point in that body's frame.
  };
  Place deepest;
  double depth_m = 0.0;
  /// If no motion of the object opens it: the contact that presses against the deepest one, and
  /// depth_m is the sum of both.
  std::optional<Place> against;
};

/// Finds the overlap that prevents a run from beginning with the object at X_WO; nothing: there is none.
///
/// Without friction the forces of compliant contacts minimise an energy. Forces at its minimum are y >= 0 with sum y_i
/// J_i = 0 and y . gap < 0: they prove that no motion opens all contacts.
[[nodiscard]] std::optional<Overlap> find_overlap(const Environment& environment, const TouchingSolid& object,
                                                  const Eigen::Isometry3d& X_WO);

}  // namespace thenar
