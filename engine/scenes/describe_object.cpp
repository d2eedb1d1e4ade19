// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "engine/formats/files.h"
#include "engine/formats/point_cloud_file.h"
#include "engine/scenes/describe.h"
#include "engine/scenes/object_bounds.h"

/// The map `object` of a scene, and solids, which the environment has, too.
namespace thenar {

using Eigen::Vector3d;
using enum Dimension;

namespace {

void describe_mug(Visitor& v, Mug& mug) {
  v.key({"radius", kLength, "0.1 mm .. 10 m", "", "Its outer radius."}, mug.radius_m);
  v.key({"height", kLength, "0.1 mm .. 10 m", "", "Its height along z."}, mug.height_m);
  v.key({"wall", kLength, "0.1 mm .. 10 m", "", "The thickness of its wall and bottom, less than radius and height."},
        mug.wall_m);
  if (mug.wall_m >= std::min(mug.radius_m, mug.height_m)) v.refuse("wall", "must be less than radius and height");
  bool is_read = true;
  v.map({"handle", kNone, "", "(Without it the mug has no handle.)", "Its handle, on the side of x."}, mug.handle,
        [&](MugHandle& handle) {
          v.key({"radius", kLength, "0.1 mm .. 10 m", "", "The radius of the handle's middle line."}, handle.radius_m);
          v.key({"thickness", kLength, "0.1 mm .. 10 m", "",
                 "The diameter of the handle itself, less than twice its radius."},
                handle.thickness_m);
          is_read = !v.is_refused("radius") && !v.is_refused("thickness");
        });
  if (mug.handle && is_read && !mug.handle_fits()) {
    v.refuse("handle",
             "thickness must be less than twice its radius, and both together fit the mug: "
             "radius + thickness/2 less than the mug's radius and half its height");
  }
}

/// `cloud: scan.ply`, or `cloud: {file: scan.ply, unit: mm}`; a unit by its name or, as "25.4 mm", as a length.
void describe_cloud(Visitor& v, CloudShape& cloud) {
  v.value_or_map({"cloud", kNone, "", "", "A mesh or a point cloud in metres; as a map, a file in any unit."},
                 cloud.file, true, [&] {
                   v.key({"file", kNone, "", "", "The file of the mesh or the point cloud."}, cloud.file);
                   const KeyRow unit{"unit", kLength, "> 0 | m | cm | mm | um", "1 m",
                                     "What 1 in the file measures: a unit or a length."};
                   const std::string name = v.word(unit, "");
                   if (name.empty()) {
                     v.key(unit, cloud.unit_m);
                   } else {
                     cloud.unit_m = read_quantity("1 " + name, kLength).value;
                   }
                 });
}

void describe_shape(Visitor& v, Shape& shape) {
  if (v.reads()) shape = CloudShape{};  // Of one that is refused nothing else is known to be wrong.
  if (auto* box = v.chosen<BoxShape>("box", shape)) describe(v, *box);
  if (auto* sphere = v.chosen<SphereShape>("sphere", shape)) describe(v, *sphere);
  if (auto* ellipsoid = v.chosen<EllipsoidShape>("ellipsoid", shape)) {
    v.key({"ellipsoid", kLength, "0.1 mm .. 10 m", "", "The sizes of an ellipsoid along x, y and z."},
          ellipsoid->size_m);
  }
  if (auto* cylinder = v.chosen<CylinderShape>("cylinder", shape)) describe(v, *cylinder);
  if (auto* superquadric = v.chosen<SuperquadricShape>("superquadric", shape)) {
    v.map({"superquadric", kNone, "", "", "A superquadric."}, [&] {
      v.key({"size", kLength, "0.1 mm .. 10 m", "", "Its sizes along x, y and z."}, superquadric->size_m);
      Eigen::Vector2d exponents(superquadric->exponents.north_south, superquadric->exponents.east_west);
      v.key({"exponents", kNone, "0.1 .. 2", "",
             "Its exponents in sections along z and across it: 0.1 is nearly a box's, 1 an ellipsoid's, 2 an "
             "octahedron's."},
            exponents);
      superquadric->exponents = {exponents[0], exponents[1]};
    });
  }
  if (auto* mug = v.chosen<Mug>("mug", shape)) {
    v.map({"mug", kNone, "", "", "A mug, open at the top of z."}, [&] { describe_mug(v, *mug); });
  }
  if (auto* cloud = v.chosen<CloudShape>("cloud", shape)) describe_cloud(v, *cloud);
}

/// Where the weight of a solid acts that is equally dense throughout. Whether a surface from a file is one's is not
/// known: its origin.
Vector3d solid_centroid_m(const Shape& shape) {
  const auto* const mug = std::get_if<Mug>(&shape);
  return mug != nullptr ? centroid_m(*mug) : Vector3d::Zero();
}

void describe_centre_of_mass(Visitor& v, ObjectSettings& object) {
  std::optional<Vector3d> centre_m = object.centre_of_mass_m;
  v.key(
      {"centre_of_mass", kLength, "", "(Without it: the centroid of a generated solid, the origin of one from a file.)",
       "Where the weight acts, in the object frame, inside the object."},
      centre_m);
  if (centre_m) check_is_in_object(v, "centre_of_mass", *centre_m, object.shape);
  object.centre_of_mass_m = centre_m.value_or(solid_centroid_m(object.shape));
  if (!centre_m) v.use_default("centre_of_mass", to_text(object.centre_of_mass_m, kLength));
}

/// Tests whether a file is of a mesh, which is sampled. Of a .ply its header tells; one that cannot be read is what the
/// scene takes it for. When a scene is written, the file's name is that for its folder.
bool is_sampled_file(Visitor& v, const CloudShape& scan, Eigen::Index points) {
  if (ending_of(scan.file) != ".ply") return is_mesh_file(scan.file);
  if (!v.reads()) return points > 0;
  return is_readable(scan.file) ? is_mesh_file(scan.file) : v.has("points");
}

}  // namespace

void describe(Visitor& v, BoxShape& box) {
  v.key({"box", kLength, "0.1 mm .. 10 m", "", "The sizes of a box along x, y and z."}, box.size_m);
}

void describe(Visitor& v, SphereShape& sphere) {
  v.key({"sphere", kLength, "0.1 mm .. 10 m", "", "The radius of a sphere."}, sphere.radius_m);
}

void describe(Visitor& v, CylinderShape& cylinder) {
  v.map({"cylinder", kNone, "", "", "A cylinder."}, [&] {
    v.key({"radius", kLength, "0.1 mm .. 10 m", "", "Its radius."}, cylinder.radius_m);
    v.key({"length", kLength, "0.1 mm .. 10 m", "", "Its length along z."}, cylinder.length_m);
  });
}

void describe_object(Visitor& v, ObjectSettings& object, bool is_found, bool fingertips_deform) {
  v.one_of({"shape", kNone, "", "", "The object's shape, with full sizes; an axis of revolution is z."},
           [&] { describe_shape(v, object.shape); });
  const auto* const scan = std::get_if<CloudShape>(&object.shape);
  const bool is_sampled = scan == nullptr || is_sampled_file(v, *scan, object.points);
  if (v.when(is_sampled))
    v.key({"points", kNone, "10 .. 1000000", "(Required, but refused with a point cloud, which brings its own.)",
           "The samples of the object's surface."},
          object.points);
  if (!is_sampled && v.has("points") && !scan->file.empty()) {
    v.refuse("points", "a point cloud brings its own points: leave this out");
  }
  v.key({"mass", kMass, "> 0", "", "The object's mass."}, object.mass_kg);
  describe_centre_of_mass(v, object);
  if (v.when(!is_found)) {
    describe_pose(v,
                  {"position", kLength, "", "(Required without grasp, refused with it.)",
                   "The origin of the object frame at the start, in the hand frame."},
                  {"rotation", kNone, "", "(Required without grasp, refused with it.)",
                   "The rotation of the object at the start: its columns are the object's axes in the hand frame."},
                  object.X_WO);
  }
  if (is_found) refuse_found(v, {"position", "rotation"});
  v.map({"damping", kNone, "", "", "The viscous damping of the object's motion."}, [&] {
    v.key({"translation", kDamping, "> 0", "", "The damping of its translation."}, object.translation_damping);
    v.key({"rotation", kRotationalDamping, "> 0", "", "The damping of its rotation."}, object.rotation_damping);
  });
  v.map(
      {"compliance", kNone, "", "(Without it the object is rigid.)",
       "How the object's surface gives way; it needs deformable fingertips."},
      object.compliance, [&](PulpMaterial& material) {
        v.key({"reduced_modulus", kPressure, ">= 1 kPa", "", "Its reduced modulus E*."}, material.reduced_modulus_Pa);
        v.key({"poisson", kNone, "0 .. 0.5", "", "Its Poisson's ratio."}, material.poisson);
        v.key({"relaxation", kTime, ">= 0", "", "Its retardation time, as that of fingertips."}, material.relaxation_s);
      });
  // A point's force would press it in without end.
  if (object.compliance && !fingertips_deform)
    v.refuse("compliance", "needs fingertips: rigid ones touch at a point each");
}

}  // namespace thenar
