#include "engine/formats/point_cloud_file.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/formats/files.h"
#include "engine/formats/mesh_file.h"
#include "engine/formats/ply_file.h"
#include "engine/formats/text_cloud_file.h"

namespace thenar {

namespace {

using Eigen::Index;
using Eigen::Vector3d;
namespace fs = std::filesystem;

constexpr Index kMinPoints = 10;
constexpr double kSmallest_m = 1e-3, kLargest_m = 2.0;

/// Refuses points that make no surface. `cloud` is as in the file.
void check_surface(const fs::path& file, const PointCloud& cloud) {
  const bool has_normals = cloud.normals.cols() > 0;
  for (Index i = 0; i < cloud.points_m.cols(); ++i) {
    const std::string vertex = "vertex " + std::to_string(i) + ": ";
    if (!cloud.points_m.col(i).allFinite()) throw FileError(file, vertex + "the point is not finite");
    if (!has_normals) continue;
    if (!cloud.normals.col(i).allFinite()) throw FileError(file, vertex + "the normal is not finite");
    if (cloud.normals.col(i).isZero(0.0)) throw FileError(file, vertex + "the normal has no length");
  }
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
    guess = fmt::format(": are its units {}? write unit: {}", unit.name, unit.name);
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

}  // namespace

bool is_mesh_file(const fs::path& file) {
  const std::string ending = ending_of(file);
  return ending == ".obj" || ending == ".stl" || ending == ".off";
}

bool is_surface_file(const fs::path& file) {
  const std::string ending = ending_of(file);
  return is_mesh_file(file) || ending == ".ply" || ending == ".xyz" || ending == ".pcd";
}

PointCloud parse_cloud(std::string_view bytes, const fs::path& file, const CloudOptions& options,
                       std::vector<std::string>& notes) {
  const std::string ending = ending_of(file);
  PointCloud cloud;
  if (ending == ".ply") {
    cloud = parse_ply(bytes, file);
  } else if (ending == ".xyz") {
    cloud = parse_xyz(bytes, file);
  } else if (ending == ".pcd") {
    cloud = parse_pcd(bytes, file);
  } else if (is_mesh_file(file)) {
    cloud = sample_mesh_file(bytes, file, options.samples, notes);
  } else {
    throw FileError(file, "what kind of file is it? Names end in .ply, .xyz, .pcd, .obj, .stl or .off");
  }
  check_surface(file, cloud);
  normalise(cloud.normals);
  cloud.points_m *= options.unit_m;
  check_size(file, cloud, options.unit_m);
  return cloud;
}

PointCloud load_cloud(const fs::path& file, const CloudOptions& options, std::vector<std::string>& notes) {
  return parse_cloud(read_file(file), file, options, notes);
}

}  // namespace thenar
