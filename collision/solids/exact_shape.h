#pragma once

#include <Eigen/Core>
#include <optional>
#include <variant>

#include "collision/shapes.h"
#include "collision/solids/solid.h"
#include "collision/solids/surface_form.h"
#include "thenar/eigen_layout.h"

namespace thenar {

// The surfaces of generated objects by their formulas, where samples would have the error of their spacing. Each shape
// is centred on the origin, in its own frame, as its generator in collision/shapes.h makes it.
using ExactShape = std::variant<BoxShape, SphereShape, EllipsoidShape, CylinderShape, SuperquadricShape, Mug>;

/// Whether all of its faces are planes.
[[nodiscard]] inline bool is_flat(const ExactShape& shape) { return std::holds_alternative<BoxShape>(shape); }

/// The smooth face that a sample of the surface belongs to: s is within 0.5 mm of it, and n, its outward normal, within
/// 35 degrees of the face's. -1 if s lies within the margin of the face's edge, beyond it, or on no face.
///
/// Box       x-, x+, y-, y+, z-, z+.
/// Cylinder  side, lower end, upper end.
/// Mug       bottom, outer wall, rim, inner wall, floor, handle. The seam of handle and outer wall is an edge of both.
/// Sphere, ellipsoid, superquadric: one, whatever n is. A superquadric's ridges are no edges, however sharp they are.
///
/// Does not allocate or throw.
[[nodiscard]] int face_at(const ExactShape& shape, const Eigen::Vector3d& s_m, const Eigen::Vector3d& n,
                          double margin_m) noexcept;

/// The place of a face that is nearest to x. Planes, walls and a handle go on beyond their edges: as infinite planes
/// and cylinders, and as a whole torus. Where several places are as near, as from the axis of a cylinder, it is one
/// near `near_m`.
///
/// An ellipsoid or superquadric has the place where Newton's method comes to from `near_m`: the distance is least among
/// its neighbours. A start that is 1 um off takes two steps.
///
/// Requires  a face of the shape; x and near finite. Coordinates beyond 1e9 m are taken as 1e9 m.
/// Accuracy  rounding; of ellipsoids 1e-12 of the size; of superquadrics 1e-9 m, but see smooth_body.h.
/// Does not allocate or throw. Never NaN.
[[nodiscard]] SurfaceForm foot_on_face(const ExactShape& shape, int face, const Eigen::Vector3d& x_m,
                                       const Eigen::Vector3d& near_m) noexcept;

/// The place of the whole surface that is nearest to x, edges and corners included: there the normal is along x - point
/// outside, and that of the nearest face inside. `near_m` saves time with a superquadric: outside it changes nothing;
/// inside the place is the one near it, as of foot_on_face(), and without it the nearest that is found from a few
/// starts.
///
/// Inside a mug near the seam of its handle the distance is that of the deeper of the two, as if the other one were not
/// there.
///
/// Requirements, accuracy: as foot_on_face(). Does not allocate or throw. Never NaN.
[[nodiscard]] SurfaceForm nearest_place(const ExactShape& shape, const Eigen::Vector3d& x_m,
                                        const std::optional<Eigen::Vector3d>& near_m = std::nullopt) noexcept;

}  // namespace thenar
