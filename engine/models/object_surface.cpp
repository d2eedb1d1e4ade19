// SPDX-License-Identifier: Apache-2.0
#include "engine/models/object_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "collision/cloud_holes.h"
#include "collision/cloud_repair.h"
#include "collision/normal_estimation.h"
#include "collision/shapes.h"
#include "engine/formats/files.h"
#include "engine/formats/mesh_file.h"
#include "engine/formats/point_cloud_file.h"
#include "engine/formats/text.h"
#include "engine/scenes/config.h"
#include "engine/scenes/scene_text.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

// Fewer normals that point the wrong way are put right by their neighbours.
constexpr double kMostDoubtful = 0.1;

/// A shape's surface as `points` samples; a scan brings its own.
struct MakeCloud {
  Index points;
  std::vector<std::string>& notes;
  PointCloud operator()(const BoxShape& box) const { return sample_box(box.size_m, points); }
  PointCloud operator()(const SphereShape& sphere) const { return sample_sphere(sphere.radius_m, points); }
  PointCloud operator()(const EllipsoidShape& ellipsoid) const { return sample_ellipsoid(ellipsoid.size_m, points); }
  PointCloud operator()(const CylinderShape& cylinder) const {
    return sample_cylinder(cylinder.radius_m, cylinder.length_m, points);
  }
  PointCloud operator()(const SuperquadricShape& shape) const {
    return sample_superquadric(shape.size_m, shape.exponents, points);
  }
  PointCloud operator()(const Mug& mug) const { return sample_mug(mug, points); }
  PointCloud operator()(const CloudShape& scan) const {
    return load_cloud(scan.file, {.unit_m = scan.unit_m, .samples = points}, notes);
  }
};

/// Within which all fingertips find the object's samples, see contact_search.cpp.
double search_reach_m(const Scene& scene) {
  double radius_m = std::numeric_limits<double>::infinity();
  for (const Fingertip& tip : scene.hand.fingertips) radius_m = std::min(radius_m, tip.radius_m);
  return kTrustPerRadius * radius_m + scene.contact.band_m;
}

/// What fingertips ask the surface for: distances with this error, up to this depth.
struct Asked {
  double error_m = 0.0, depth_m = 0.0;
  bool operator==(const Asked&) const = default;
};
Asked asked_of_surface(const Scene& scene) {
  if (!scene.fingertips || scene.contact.distance_error_m == 0.0) return {};
  double radius_m = 0.0;
  for (const Fingertip& tip : scene.hand.fingertips) radius_m = std::max(radius_m, tip.radius_m);
  return {scene.contact.distance_error_m, kTrustPerRadius * radius_m + scene.contact.band_m};
}

/// What repair() did that a user should know of.
void add_notes(const CloudRepair& repaired, Index points, std::vector<std::string>& notes) {
  const auto share = [&](Index part) { return 100.0 * static_cast<double>(part) / static_cast<double>(points); };
  if (repaired.turned > 0) {
    notes.push_back(fmt::format("turned {} ({:.2g} %) that contradicted those around",
                                counted(repaired.turned, "normal"), share(repaired.turned)));
  }
  if (repaired.removed > 0) {
    notes.push_back(fmt::format("removed {} ({:.2g} %) facing against those around", counted(repaired.removed, "point"),
                                share(repaired.removed)));
  }
  if (repaired.outliers > 0) {
    notes.push_back(fmt::format("removed {} ({:.2g} %) off the surface", counted(repaired.outliers, "point"),
                                share(repaired.outliers)));
  }
  if (repaired.smoothed_normals) {
    notes.push_back(
        fmt::format("averaged the normals: they are {:.1f} deg off", repaired.normal_noise * 180.0 / std::numbers::pi));
  }
  if (repaired.smoothed_points) {
    notes.push_back(fmt::format("averaged the points: they are {:.3f} mm off", 1e3 * repaired.position_noise_m));
  }
}

/// A hole wider than the reach may let a finger in unseen; narrower ones are bridged by the faces around them.
void check_holes(const PointCloud& cloud, double support_m, double reach_m, std::vector<std::string>& notes) {
  const std::vector<CloudHole> holes = find_holes(cloud, support_m, std::max(support_m, 2.0 * reach_m));
  if (holes.empty()) return;
  const CloudHole& widest = holes.front();
  const Vector3d at_mm = 1e3 * widest.centre_m;
  const std::string what =
      fmt::format("{} with a radius up to {:.1f} mm{}, the widest near [{:.1f}, {:.1f}, {:.1f}] mm",
                  holes.size() == 1 ? "a hole" : fmt::format("{} holes", holes.size()), 1e3 * widest.radius_m,
                  widest.radius_m >= 2.0 * reach_m ? " or more" : "", at_mm.x(), at_mm.y(), at_mm.z());
  if (widest.radius_m > reach_m) {
    throw std::invalid_argument(
        fmt::format("has {}; fingertips find the surface within {:.1f} mm only: close the surface there, or sample it",
                    what, 1e3 * reach_m));
  }
  notes.push_back("bridged " + what);
}

/// What is wrong with samples whose normals contradict their neighbours', and what would mend it.
std::string contradiction(const Scene& scene, bool is_estimated, double share) {
  const auto* const scan = std::get_if<CloudShape>(&scene.object.shape);
  const std::string much =
      fmt::format("{:.0f} % of the normals contradict their neighbours'; {:.0f} % are too many: ", 100.0 * share,
                  100.0 * kMostDoubtful);
  if (scan != nullptr && is_mesh_file(scan->file)) {
    return much +
           "the mesh has faces inside its solids, or close to others that face the other way; unite its parts into one "
           "closed surface, as Blender's modifier Remesh does, or MeshLab's boolean union";
  }
  if (is_estimated) {
    return much +
           "they were estimated; the points are too few for the thinnest part, or lie in its inside, too: sample "
           "the surface more densely, or save it as a mesh";
  }
  return much + "orient them anew, or leave them out of the file, and they are estimated";
}

/// Leaves out normals that are not those of the surface: a constant, other axes, or values of another kind.
void leave_out_wrong_normals(PointCloud& cloud, std::vector<std::string>& notes) {
  constexpr double kMost = 0.4;
  const double share = share_off_planes(cloud);
  if (share <= kMost) return;
  cloud.normals.resize(3, 0);
  notes.push_back(fmt::format(
      "left out the file's normals: {:.0f} % are more than 45 degrees off the surface of the points", 100.0 * share));
}

ImplicitSurface make_surface(const Scene& scene, std::vector<std::string>& notes, const StartWatch& begins) {
  const auto tell = [&begins](const char* stage) {
    if (begins) begins(stage);
  };
  tell("the object's samples");
  PointCloud cloud = std::visit(MakeCloud{scene.object.points, notes}, scene.object.shape);
  const auto* const scan = std::get_if<CloudShape>(&scene.object.shape);
  if (scan != nullptr && !is_mesh_file(scan->file) && cloud.normals.cols() > 0) leave_out_wrong_normals(cloud, notes);
  const bool is_estimated = cloud.normals.cols() == 0;
  if (is_estimated) {
    estimate_normals(cloud);
    notes.emplace_back("estimated the normals from the points, and turned them outward");
  }
  tell("faults among the samples");
  const Index points = cloud.points_m.cols();
  const double spacing_m = sample_spacing_m(cloud), support_m = covering_support_m(cloud);
  const CloudRepair repaired = repair(cloud, support_m);
  if (cloud.normals.cwiseProduct(cloud.points_m.colwise() - cloud.points_m.rowwise().mean()).sum() < 0.0) {
    cloud.normals *= -1.0;
    notes.emplace_back("turned all normals outward: they pointed into the object");
  }
  if (repaired.doubtful_share > kMostDoubtful) {
    throw std::invalid_argument(contradiction(scene, is_estimated, repaired.doubtful_share));
  }
  if (repaired.outliers > points / 4) {
    throw std::invalid_argument(
        fmt::format("{:.0f} % of the points stand off the surface that their neighbours make: are "
                    "they a surface, with the unit that it was saved in?",
                    100.0 * static_cast<double>(repaired.outliers) / static_cast<double>(points)));
  }
  if (support_m > 2.2 * spacing_m) {
    notes.push_back(fmt::format("widened the support to {:.2f} mm: the points are unevenly dense", 1e3 * support_m));
  }
  add_notes(repaired, points, notes);
  check_holes(cloud, support_m, search_reach_m(scene), notes);
  tell("the object's surface");
  ImplicitSurface surface(cloud, support_m);
  const Asked asked = asked_of_surface(scene);
  tell("patches of the surface");
  surface.allow_error(asked.error_m, asked.depth_m);
  return surface;
}

}  // namespace

ImplicitSurface make_object_surface(const Scene& scene, std::vector<std::string>& notes, const StartWatch& begins) try {
  return make_surface(scene, notes, begins);
} catch (const std::invalid_argument& error) {  // the cloud stands for no surface
  if (const auto* scan = std::get_if<CloudShape>(&scene.object.shape)) throw FileError(scan->file, error.what());
  throw ConfigError(
      {{scene.name, "object.shape",
        fmt::format("the {} samples of object.points make no surface: they are too few for its thinnest part, or for "
                    "its size, or the shape is no solid",
                    scene.object.points)}});
}

EnclosedSolid object_solid(const Scene& scene, const ImplicitSurface& surface, std::vector<std::string>& notes) {
  const auto* const scan = std::get_if<CloudShape>(&scene.object.shape);
  const auto of_samples = [&] { return EnclosedSolid{0.0, enclosed_centroid_m(surface.cloud()), 0.0}; };
  if (scan == nullptr || !is_mesh_file(scan->file)) return of_samples();
  std::vector<std::string> told;  // when the surface was made
  TriangleMesh mesh = parse_mesh(read_file(scan->file), scan->file, told);
  mend_mesh(mesh, scan->file, told);
  mesh.vertices_m *= scan->unit_m;
  const EnclosedSolid solid = enclosed_solid(mesh);
  if (!(solid.volume_m3 > 0.0)) return of_samples();
  const double size_m = surface.bounds().diagonal().norm();
  if (solid.error_m > 1e-3 * size_m) {
    notes.push_back(
        fmt::format("the centre of mass may be {:.1f} mm off: the mesh is open, and was taken to be flat there",
                    1e3 * std::min(solid.error_m, size_m)));
  }
  return solid;
}

bool have_same_surface(const Scene& one, const Scene& other) {
  return one.object.points == other.object.points && one.object.shape == other.object.shape &&
         search_reach_m(one) == search_reach_m(other) && asked_of_surface(one) == asked_of_surface(other);
}

std::size_t object_file_hash(const Scene& scene) try {
  const auto* const scan = std::get_if<CloudShape>(&scene.object.shape);
  return scan == nullptr ? 0 : std::hash<std::string>()(read_file(scan->file));
} catch (const FileError&) {
  return 0;
}

}  // namespace thenar
