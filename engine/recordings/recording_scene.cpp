// SPDX-License-Identifier: Apache-2.0
#include "engine/recordings/recording_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engine/formats/foxglove_solid.h"
#include "engine/loops/shown_environment.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using nlohmann::ordered_json;

namespace {

using foxglove::Color;

const Color kBone(0.87, 0.80, 0.70, 1.0), kPulp(0.93, 0.72, 0.62, 0.45), kSurface(0.55, 0.65, 0.78, 0.3),
    kContactForce(0.85, 0.25, 0.15, 1.0), kFingerForce(0.10, 0.35, 0.75, 1.0), kBody(0.45, 0.45, 0.42, 0.5),
    kBodyForce(0.45, 0.30, 0.60, 1.0);
// Of an object's samples: more would be many MB of JSON.
constexpr Index kMostSquares = 4000;
// An edge has no end of pressure: it is told as the mean over so much of a cell, at least.
constexpr double kLeastShare = 0.05;
// Below this an arrow is shorter than it is thick.
constexpr double kLeastShown_N = 1e-3;

std::string frame_of(const Segment& segment) { return "hand/" + segment.name; }
std::string frame_of(const EnvironmentBody& body) { return "around/" + body.name; }

Isometry3d at(const Vector3d& point_m, const Eigen::Matrix3d& axes = Eigen::Matrix3d::Identity()) {
  Isometry3d X = Isometry3d::Identity();
  X.translation() = point_m;
  X.linear() = axes;
  return X;
}

/// Axes of which the third is a direction.
Eigen::Matrix3d axes_along(const Vector3d& z) {
  return Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), z).toRotationMatrix();
}

ordered_json named(ordered_json entity, const char* key, const std::string& value) {
  entity["metadata"].push_back({{"key", key}, {"value", value}});
  return entity;
}

void add_pulp(const Fingertip& tip, ordered_json& entity) {
  if (!tip.shape) {
    entity["spheres"].push_back(foxglove::sphere(at(tip.centre_m), Vector3d::Constant(tip.radius_m), kPulp));
  } else if (tip.shape->form == PulpShape::Form::kEllipsoid) {
    entity["spheres"].push_back(foxglove::sphere(at(tip.centre_m, tip.shape->axes), tip.shape->half_m, kPulp));
  } else {
    const double radius_m = 0.5 * tip.shape->half_m[1];
    const Vector3d half = tip.shape->half_m[0] * tip.shape->axes.col(0);
    for (const double side : {-1.0, 1.0}) {
      entity["spheres"].push_back(
          foxglove::sphere(at(tip.centre_m + side * half), Vector3d::Constant(radius_m), kPulp));
    }
    entity["cylinders"].push_back(foxglove::rod(tip.centre_m - half, tip.centre_m + half, radius_m, kPulp));
  }
}

/// From the wrist, the world's origin, to where the fingers begin, which no joint moves.
void add_metacarpals(const Hand& hand, const Segment& palm, ordered_json& entity) {
  for (const Fingertip& tip : hand.fingertips) {
    const Isometry3d X_SW = palm.X_WS_0.inverse();
    const Vector3d from = X_SW.translation(), to = X_SW * hand.joints[tip.first_joint].origin_m;
    if ((to - from).norm() > 1e-6) entity["cylinders"].push_back(foxglove::rod(from, to, 0.5 * tip.radius_m, kBone));
  }
}

ordered_json closed_surface(const TriangleMesh& surface) {
  const Eigen::Matrix3Xi corners = surface.triangles.cast<int>();
  return foxglove::triangles(surface.vertices_m, {corners.data(), corners.data() + corners.size()}, kSurface);
}

/// One for each of some thousand samples of the object.
ordered_json squares(const Model& model) {
  const PointCloud& cloud = model.object.cloud();
  const Index stride = 1 + (cloud.points_m.cols() - 1) / kMostSquares;
  // The support of the object's surface is 2.2 spacings. From the middle of a square to a corner it is 1.2 of them, so
  // that neighbours overlap.
  const double corner_m = 1.2 * model.object.support_m() / 2.2 * std::sqrt(static_cast<double>(stride));
  const Index squares = (cloud.points_m.cols() + stride - 1) / stride;
  Eigen::Matrix3Xd corners_m(3, 4 * squares);
  std::vector<int> indices;
  for (Index i = 0; i < squares; ++i) {
    const Eigen::Matrix3d axes = axes_along(cloud.normals.col(stride * i));
    const Vector3d x = corner_m * axes.col(0), y = corner_m * axes.col(1), middle = cloud.points_m.col(stride * i);
    corners_m.middleCols<4>(4 * i) << middle + x, middle + y, middle - x, middle - y;
    for (const int corner : {0, 1, 2, 0, 2, 3}) indices.push_back(static_cast<int>(4 * i) + corner);
  }
  return foxglove::triangles(corners_m, indices, kSurface);
}

}  // namespace

ordered_json hand_entities(const Model& model, double time_s) {
  const Hand& hand = model.scene.hand;
  std::vector<ordered_json> entities;
  for (int i = 0; i < std::ssize(hand.segments); ++i) {
    const Segment& segment = hand.segments[i];
    ordered_json entity = foxglove::entity(segment.name, frame_of(segment), time_s, true);
    if (segment.joints == 0) {
      if (!hand.slides) add_metacarpals(hand, segment, entity);
    } else if (segment.length_m > 1e-6) {
      const double radius_m = 0.5 * hand.fingertips[segment.finger].radius_m;
      entity["cylinders"].push_back(
          foxglove::rod(Vector3d::Zero(), segment.length_m * Vector3d::UnitX(), radius_m, kBone));
    }
    for (const Fingertip& tip : hand.fingertips) {
      if (tip.segment == i) add_pulp(tip, entity);
    }
    entities.push_back(std::move(entity));
  }
  return foxglove::scene_update(std::move(entities), time_s, true);
}

ordered_json object_entities(const Model& model, double time_s, const TriangleMesh& surface) {
  std::vector<ordered_json> entities = {foxglove::entity("object", "object", time_s, true)};
  entities.front()["triangles"].push_back(surface.triangles.cols() > 0 ? closed_surface(surface) : squares(model));
  if (model.scene.environment) {
    for (const EnvironmentBody& body : model.scene.environment->bodies) {
      entities.push_back(foxglove::entity(frame_of(body), frame_of(body), time_s, true));
      entities.back()["triangles"].push_back(foxglove::solid(body.shape, kBody));
    }
  }
  return foxglove::scene_update(std::move(entities), time_s, true);
}

ordered_json frame_transforms(const Model& model, const Picture& picture, const Isometry3d& X_WT, double time_s) {
  const Snapshot& now = picture.snapshot;
  const Hand& hand = model.scene.hand;
  HandPose pose;
  forward_kinematics(hand, now.q, pose);
  ordered_json transforms = ordered_json::array();
  transforms.push_back(foxglove::transform("world", "object", now.X_WO, time_s));
  transforms.push_back(foxglove::transform("world", "target", X_WT, time_s));
  for (std::size_t i = 0; i < hand.segments.size(); ++i) {
    transforms.push_back(foxglove::transform("world", frame_of(hand.segments[i]), pose.segments[i], time_s));
  }
  if (model.scene.environment) {
    const ShownEnvironment around = shown_environment(model, picture);
    for (std::size_t k = 0; k < around.X_WE.size(); ++k) {
      const std::string frame = frame_of(model.scene.environment->bodies[k]);
      transforms.push_back(foxglove::transform("world", frame, around.X_WE[k], time_s));
    }
  }
  return {{"transforms", transforms}};
}

ordered_json force_entities(const Model& model, const Picture& picture, double time_s) {
  ordered_json contacts =
      named(foxglove::entity("contacts", "world", time_s, true), "m per N", fmt::format("{}", kContactArrow_m_per_N));
  for (const ShownContact& contact : picture.contacts) {
    if (contact.force_N.norm() < kLeastShown_N) continue;
    const Vector3d tip = contact.point_m + kContactArrow_m_per_N * contact.force_N;
    contacts["arrows"].push_back(foxglove::arrow(contact.point_m, tip, 3e-4, kContactForce));
  }
  ordered_json fingers =
      named(foxglove::entity("fingers", "world", time_s, true), "m per N", fmt::format("{}", kFingerArrow_m_per_N));
  for (int k = 0; k < model.fingers(); ++k) {
    const FingerLoad& load = picture.snapshot.load[k];
    if (load.force_N.norm() < kLeastShown_N) continue;
    const Vector3d tip = load.centre_m + kFingerArrow_m_per_N * load.force_N;
    fingers["arrows"].push_back(foxglove::arrow(load.centre_m, tip, 1.2e-3, kFingerForce));
  }
  std::vector<ordered_json> all = {std::move(contacts), std::move(fingers)};
  if (model.scene.environment) {
    ordered_json bodies =
        named(foxglove::entity("bodies", "world", time_s, true), "m per N", fmt::format("{}", kFingerArrow_m_per_N));
    const ShownEnvironment around = shown_environment(model, picture);
    for (Index k = 0; k < around.force_N.cols(); ++k) {
      if (around.force_N.col(k).norm() < kLeastShown_N) continue;
      const Vector3d from = around.mean_m.col(k), tip = from + kFingerArrow_m_per_N * around.force_N.col(k);
      bodies["arrows"].push_back(foxglove::arrow(from, tip, 1.2e-3, kBodyForce));
    }
    all.push_back(std::move(bodies));
  }
  return foxglove::scene_update(std::move(all), time_s, false);
}

ordered_json pressure_entities(const Model& model, const Picture& picture, double time_s) {
  const Hand& hand = model.scene.hand;
  HandPose pose;
  forward_kinematics(hand, picture.snapshot.q, pose);
  std::vector<ordered_json> entities;
  for (const Fingertip& tip : hand.fingertips) {
    entities.push_back(named(foxglove::entity(tip.finger, frame_of(hand.segments[tip.segment]), time_s, true),
                             "Pa of the strongest colour", fmt::format("{}", kFullPressure_Pa)));
  }
  for (const ShownContact& contact : picture.contacts) {
    if (!model.deformable() || contact.normal_N <= 0.0) continue;
    const double area_m2 =
        std::max(kLeastShare, contact.share) * model.pulps[contact.finger].area_m2[contact.control_point];
    const double share = std::min(1.0, contact.normal_N / area_m2 / kFullPressure_Pa);
    const Isometry3d X_FW = pose.distal(hand, static_cast<int>(contact.finger)).inverse();
    // From yellow to red.
    const Color color(0.95, 0.85 * (1.0 - share), 0.1, 1.0);
    entities[contact.finger]["cylinders"].push_back(
        foxglove::cylinder(at(X_FW * contact.point_m, axes_along(X_FW.linear() * contact.normal)),
                           std::sqrt(area_m2 / std::numbers::pi), 4e-4, color));
  }
  return foxglove::scene_update(std::move(entities), time_s, false);
}

}  // namespace thenar
