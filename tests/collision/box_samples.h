// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collision/shapes.h"

namespace thenar::box_samples {

using Eigen::Index;
using Eigen::Vector3d;

inline const Vector3d kBox_m(50e-3, 50e-3, 100e-3);

inline double box_area_m2(const Vector3d& size_m) {
  return 2.0 * (size_m.x() * size_m.y() + size_m.y() * size_m.z() + size_m.z() * size_m.x());
}

/// Faces 0..5 = x-, x+, y-, y+, z-, z+; -1 if the sample is not exactly on the face that its normal names.
inline int face_of(const PointCloud& cloud, Index i, const Vector3d& size_m) {
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    const double side = face % 2 == 0 ? -1.0 : 1.0;
    if (cloud.normals.col(i) != side * Vector3d::Unit(axis)) continue;
    const Vector3d p = cloud.points_m.col(i);
    const bool inside = (p.cwiseAbs().array() <= 0.5 * size_m.array()).all();
    return inside && p[axis] == side * 0.5 * size_m[axis] ? face : -1;
  }
  return -1;
}

}  // namespace thenar::box_samples
