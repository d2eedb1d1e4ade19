// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/point_cloud_file.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "engine/formats/file_kind.h"
#include "engine/formats/files.h"
#include "engine/formats/mesh_file.h"
#include "engine/formats/pcd_file.h"
#include "engine/formats/ply_file.h"
#include "engine/formats/text.h"
#include "engine/formats/text_cloud_file.h"

namespace thenar {

namespace {

using Eigen::Index;
using Eigen::Vector3d;
namespace fs = std::filesystem;

constexpr Index kMinPoints = 10;
constexpr double kSmallest_m = 1e-3, kLargest_m = 2.0;

/// Leaves out all but some points, which `keeps` tells by their numbers. Returns the number of those left out.
template <typename Keeps>
Index keep_points(PointCloud& cloud, const Keeps& keeps) {
  const bool has_normals = cloud.normals.cols() > 0;
  Index remaining = 0;
  for (Index i = 0; i < cloud.points_m.cols(); ++i) {
    if (!keeps(i)) continue;
    cloud.points_m.col(remaining) = cloud.points_m.col(i);
    if (has_normals) cloud.normals.col(remaining) = cloud.normals.col(i);
    ++remaining;
  }
  const Index left_out = cloud.points_m.cols() - remaining;
  cloud.points_m.conservativeResize(3, remaining);
  if (has_normals) cloud.normals.conservativeResize(3, remaining);
  return left_out;
}

/// Leaves out points that are missing, as where an organised cloud saw none, and what has no normal.
void leave_out_missing(PointCloud& cloud, std::vector<std::string>& notes) {
  const Index no_point = keep_points(cloud, [&](Index i) { return cloud.points_m.col(i).allFinite(); });
  if (no_point > 0) notes.push_back("left out " + counted(no_point, "point") + " without finite coordinates");
  if (cloud.normals.cols() == 0) return;
  const auto has_normal = [&](Index i) {
    return cloud.normals.col(i).allFinite() && !cloud.normals.col(i).isZero(0.0);
  };
  Index missing = 0;
  for (Index i = 0; i < cloud.normals.cols(); ++i) missing += has_normal(i) ? 0 : 1;
  if (missing == 0) return;
  if (2 * missing > cloud.normals.cols()) {
    cloud.normals.resize(3, 0);
    notes.push_back("left out the normals, of which " + std::to_string(missing) + " have no length");
    return;
  }
  keep_points(cloud, has_normal);
  notes.push_back("left out " + counted(missing, "point") + " whose normals have no length");
}

/// Refuses points that make no surface. `cloud` is as in the file.
void check_surface(const fs::path& file, const PointCloud& cloud, bool is_mesh) {
  const Index count = cloud.points_m.cols();
  if (count < kMinPoints) {
    throw FileError(file, "needs at least " + std::to_string(kMinPoints) + " points, has " + std::to_string(count));
  }
  // The spread along the principal axes, of the points scaled to 1: a surface has at least two.
  Eigen::Matrix3Xd points = cloud.points_m.colwise() - cloud.points_m.col(0);
  const double scale = points.cwiseAbs().maxCoeff();
  if (!(scale > 0.0)) throw FileError(file, "all points coincide");
  if (!std::isfinite(scale)) throw FileError(file, "the points are too far apart");
  points /= scale;
  points.colwise() -= points.rowwise().mean().eval();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread(points * points.transpose(), Eigen::EigenvaluesOnly);
  // Squared widths: a millionth of the length is a line, also in files of single precision.
  if (spread.eigenvalues()[1] <= 1e-12 * spread.eigenvalues()[2]) throw FileError(file, "all points lie on one line");
  if (is_mesh && spread.eigenvalues()[0] <= 1e-12 * spread.eigenvalues()[2]) {
    throw FileError(file, "is flat: all its faces lie in one plane, and an object has a thickness");
  }
}

/// Formats a length in the most readable unit.
std::string in_words(double length_m) {
  if (length_m >= 1.0) return fmt::format("{:.3g} m", length_m);
  if (length_m >= 1e-3) return fmt::format("{:.3g} mm", 1e3 * length_m);
  return fmt::format("{:.3g} um", 1e6 * length_m);
}

/// Refuses sizes that no hand grasps: almost always the stated units are wrong.
void check_size(const fs::path& file, const PointCloud& cloud, double unit_m) {
  const Vector3d extent_m = cloud.points_m.rowwise().maxCoeff() - cloud.points_m.rowwise().minCoeff();
  const double wide_m = extent_m.maxCoeff();
  if (wide_m >= kSmallest_m && wide_m <= kLargest_m) return;
  struct Unit {
    const char* name;
    double m;
  };
  constexpr std::array<Unit, 4> kUnits = {Unit{"mm", 1e-3}, Unit{"cm", 1e-2}, Unit{"m", 1.0}, Unit{"um", 1e-6}};
  std::string guess;
  for (const Unit& unit : kUnits) {
    const double then_m = wide_m / unit_m * unit.m;
    if (!guess.empty() || then_m < kSmallest_m || then_m > kLargest_m) continue;
    guess = fmt::format(": are its units {0}? write unit: {0}, or --unit {0}", unit.name);
  }
  throw FileError(file, fmt::format("is {} wide, where {} to {} make sense{}", in_words(wide_m), in_words(kSmallest_m),
                                    in_words(kLargest_m), guess));
}

void normalise(Eigen::Matrix3Xd& normals) {
  for (auto normal : normals.colwise()) {
    const double length = normal.stableNorm();
    // Normals of unit length to rounding are kept, so that a saved cloud is read back the same.
    if (std::abs(length - 1.0) <= 4.0 * std::numeric_limits<double>::epsilon()) continue;
    // In two steps: 1/length of the smallest normals is infinite.
    normal /= normal.cwiseAbs().maxCoeff();
    normal.normalize();
  }
}

bool is_text_cloud(const std::string& ending) {
  return ending == ".xyz" || ending == ".asc" || ending == ".csv" || ending == ".pts" || ending == ".txt" ||
         ending == ".xyzn" || ending == ".xyzrgb";
}

/// Refuses a file whose name does not end as one that is read.
[[noreturn]] void refuse_kind(std::string_view bytes, const fs::path& file) {
  const std::string ending = ending_of(file);
  const std::string read = ".ply, .obj, .stl, .off, .glb, .gltf, .xyz or .pcd";
  for (const std::string_view other : {".3mf", ".dae", ".fbx", ".amf", ".wrl", ".x3d", ".iv", ".vtk", ".vtp", ".blend",
                                       ".3ds", ".usd", ".usdz", ".usda", ".usdc", ".step", ".stp", ".iges", ".igs"}) {
    if (ending != other) continue;
    throw FileError(file, fmt::format("files of {} are not read: save the surface as {}, as Blender, MeshLab and CAD "
                                      "programs do",
                                      ending, read));
  }
  if (const std::string what = other_kind(bytes, ""); !what.empty()) throw FileError(file, what);
  throw FileError(file, "what kind of file is it? Names end in " + read);
}

}  // namespace

bool is_mesh_file(const fs::path& file) {
  const std::string ending = ending_of(file);
  if (ending != ".ply") {
    return ending == ".obj" || ending == ".stl" || ending == ".off" || ending == ".glb" || ending == ".gltf";
  }
  try {
    return is_readable(file) && ply_has_faces(read_file(file));
  } catch (const FileError&) {
    return false;
  }
}

bool is_surface_file(const fs::path& file) {
  const std::string ending = ending_of(file);
  return ending == ".ply" || ending == ".pcd" || is_text_cloud(ending) || is_mesh_file(file);
}

PointCloud parse_cloud(std::string_view bytes, const fs::path& file, const CloudOptions& options,
                       std::vector<std::string>& notes) {
  const std::string ending = ending_of(file);
  if (is_surface_file(file)) {
    if (const std::string what = other_kind(bytes, ending); !what.empty()) throw FileError(file, what);
  }
  PointCloud cloud;
  std::optional<TriangleMesh> mesh;
  if (ending == ".ply") {
    PlyFile ply = parse_ply(bytes, file, notes);
    cloud = std::move(ply.cloud);
    mesh = std::move(ply.mesh);
  } else if (is_text_cloud(ending)) {
    cloud = parse_xyz(bytes, file, notes);
  } else if (ending == ".pcd") {
    cloud = parse_pcd(bytes, file, notes);
  } else if (is_mesh_file(file)) {
    mesh = parse_mesh(bytes, file, notes);
  } else {
    refuse_kind(bytes, file);
  }
  if (mesh) {
    mend_mesh(*mesh, file, notes);
    cloud = sample_mended_mesh(*mesh, file, options.samples, notes);
  }
  leave_out_missing(cloud, notes);
  check_surface(file, cloud, mesh.has_value());
  normalise(cloud.normals);
  cloud.points_m *= options.unit_m;
  check_size(file, cloud, options.unit_m);
  return cloud;
}

PointCloud load_cloud(const fs::path& file, const CloudOptions& options, std::vector<std::string>& notes) {
  return parse_cloud(read_file(file), file, options, notes);
}

}  // namespace thenar
