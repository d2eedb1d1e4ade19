#pragma once

#include <Eigen/Geometry>
#include <string>

#include "engine/environment/environment.h"

namespace thenar {

/// What a scene begins with must not overlap by more than this: elasticity has it at 20 N, and no file has more digits.
inline constexpr double kMostOverlap_m = 2e-6;

/// Why the object cannot be at X_WO as a run begins, in words; empty: it can. Either it lies in a body, and there is
/// room beside it; or there is none: the two contacts that press against one another are told, and by how much.
///
/// Without friction the forces of bodies that give way minimise an energy. At its least, forces that are left are
/// y >= 0 with sum y_i J_i = 0 and y . gap < 0: they prove that no motion opens all contacts.
[[nodiscard]] std::string no_room_in_words(const Environment& environment, const Solid& object,
                                           const Eigen::Isometry3d& X_WO);

}  // namespace thenar
