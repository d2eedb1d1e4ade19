#include "engine/model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "collision/cloud_repair.h"
#include "collision/shapes.h"
#include "engine/files.h"
#include "engine/fine_parts.h"
#include "engine/point_cloud_file.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
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

ImplicitSurface make_surface(const ObjectSettings& object, std::vector<std::string>& notes) {
  PointCloud cloud = std::visit(MakeCloud{object.points, notes}, object.shape);
  if (cloud.normals.cols() == 0) throw std::invalid_argument("has no normals");
  const CloudRepair repaired = repair(cloud, 2.2 * sample_spacing_m(cloud));
  if (repaired.doubtful_share > kMostDoubtful) {
    throw std::invalid_argument(
        fmt::format("{:.0f} % of the normals contradict their neighbours'; {:.0f} % are too many",
                    100.0 * repaired.doubtful_share, 100.0 * kMostDoubtful));
  }
  // The paper's box has 36 000 points in 4800 leaves: 7 or 8 in each.
  return {cloud, std::max<Index>(1, cloud.points_m.cols() * 4800 / 36000)};
}

ImplicitSurface make_object(const ObjectSettings& object, std::vector<std::string>& notes) try {
  return make_surface(object, notes);
} catch (const std::invalid_argument& error) {  // the cloud stands for no surface
  const auto* scan = std::get_if<CloudShape>(&object.shape);
  throw FileError(scan != nullptr ? scan->file : "object.shape", error.what());
}

/// From 0 to 1 with no velocity and acceleration at both ends.
double minimum_jerk(const Move& move, double time_s) {
  const double s = std::clamp((time_s - move.from_s) / move.over_s, 0.0, 1.0);
  return s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

}  // namespace

Model::Model(Scene s) : scene(std::move(s)), object(make_object(scene.object, object_notes)) {
  max_contacts = kFingers;
  if (!scene.fingertips) return;
  max_contacts = kFingers * std::min(scene.contact.max_per_finger, scene.fingertips->leaves);
  double spacing_m = 0.0;  // of control points
  for (const Fingertip& tip : scene.hand.fingertips) {
    pulps.push_back(make_spherical_pulp(tip.centre_m, tip.radius_m, scene.fingertips->points, scene.fingertips->leaves,
                                        scene.fingertips->material));
    spacing_m = std::max(spacing_m, std::sqrt(pulps.back().area_m2.mean()));
  }
  fine_m = fine_parts(object.cloud(), spacing_m);
}

bool Model::control_is_due(std::int64_t tick) const {
  // A period that ends at a step's start, but for rounding, ends there.
  const auto periods = [&](std::int64_t t) {
    return std::floor(static_cast<double>(t) * scene.step_s / scene.control_period_s + 1e-6);
  };
  return tick == 0 || periods(tick) > periods(tick - 1);
}

Isometry3d Model::target(double time_s) const {
  Isometry3d X_WT = scene.object.X_WO;
  if (const auto& move = scene.task.translate) X_WT.translate(minimum_jerk(*move, time_s) * move->amount * move->axis);
  if (const auto& move = scene.task.rotate) {
    X_WT.rotate(Eigen::AngleAxisd(minimum_jerk(*move, time_s) * move->amount, move->axis));
  }
  return X_WT;
}

Vector3d Model::push(double time_s) const {
  const auto& push = scene.task.push;
  const bool acts = push && time_s >= push->from_s && time_s < push->from_s + push->over_s;
  return acts ? Vector3d(scene.object.X_WO.linear() * push->force_N) : Vector3d::Zero();
}

}  // namespace thenar
