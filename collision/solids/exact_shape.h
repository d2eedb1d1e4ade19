// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <variant>

#include "collision/shapes.h"
#include "collision/solids/solid.h"
#include "collision/solids/surface_form.h"
#include "thenar/eigen_layout.h"

namespace thenar {

// The exact surfaces of generated objects, free of the error of samples. Each shape is centred on the origin, in its
// own frame, as made by its generator in collision/shapes.h.
using ExactShape = std::variant<BoxShape, SphereShape, EllipsoidShape, CylinderShape, SuperquadricShape, Mug>;

/// Tests whether all faces are planes.
[[nodiscard]] inline bool is_flat(const ExactShape& shape) { return std::holds_alternative<BoxShape>(shape); }

/// Returns the smooth face of a sample of the surface: s is within 0.5 mm of it, and n, its outward normal, within 35
/// degrees of the face's. -1 if s lies within the margin of the face's edge, beyond it, or on no face.
///
/// Box       x-, x+, y-, y+, z-, z+.
/// Cylinder  side, lower end, upper end.
/// Mug       bottom, outer wall, rim, inner wall, floor, handle. The seam of handle and outer wall is an edge of both.
/// Sphere, ellipsoid, superquadric: one, for any n. A superquadric's ridges are no edges, however sharp.
///
/// Does not allocate or throw.
[[nodiscard]] int face_at(const ExactShape& shape, const Eigen::Vector3d& s_m, const Eigen::Vector3d& n,
                          double margin_m) noexcept;

/// Finds the point of a face nearest to x. Planes, walls and a handle continue beyond their edges, as infinite planes
/// and cylinders and as a whole torus. If several points are as near, as from a cylinder's axis, it is one near
/// `near_m`.
///
/// On an ellipsoid or superquadric it is the local minimum of distance that Newton's method finds from `near_m`. A
/// start that is 1 um off takes two steps.
///
/// Requires  a face of the shape; x and near finite. Coordinates are clamped to 1e9 m.
/// Accuracy  rounding; of ellipsoids 1e-12 of the size; of superquadrics 1e-9 m, but see smooth_body.h.
/// Does not allocate or throw. Never NaN.
[[nodiscard]] SurfaceForm foot_on_face(const ExactShape& shape, int face, const Eigen::Vector3d& x_m,
                                       const Eigen::Vector3d& near_m) noexcept;

/// Finds the point of the whole surface nearest to x, edges and corners included: there the normal is along x - point
/// outside, and that of the nearest face inside. `near_m` saves time with a superquadric: outside it changes nothing;
/// inside the point is the one near it, as in foot_on_face(), and without it the nearest found from a few starts.
///
/// Inside a mug near the seam of its handle the distance is that of the deeper of the two alone.
///
/// Requirements and accuracy are those of foot_on_face(). Does not allocate or throw. Never NaN.
[[nodiscard]] SurfaceForm nearest_place(const ExactShape& shape, const Eigen::Vector3d& x_m,
                                        const std::optional<Eigen::Vector3d>& near_m = std::nullopt) noexcept;

}  // namespace thenar
