// SPDX-License-Identifier: Apache-2.0
#include "bench/peers/fcl_peer.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/collision_object.h>
#include <fcl/narrowphase/distance.h>

#include <cmath>

namespace thenar {
namespace {

using Mesh = fcl::BVHModel<fcl::OBBRSSd>;  // What FCL's examples use for distances and for contacts.

std::shared_ptr<Mesh> make_mesh(const std::vector<double>& corners_m, const std::vector<int>& triangles) {
  std::vector<fcl::Vector3d> corners;
  for (std::size_t i = 0; i < corners_m.size(); i += 3) corners.emplace_back(&corners_m[i]);
  std::vector<fcl::Triangle> faces;
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    faces.emplace_back(triangles[i], triangles[i + 1], triangles[i + 2]);
  }
  auto mesh = std::make_shared<Mesh>();
  mesh->beginModel();
  mesh->addSubModel(corners, faces);
  mesh->endModel();
  return mesh;
}

constexpr double kPointRadius_m = 1e-9;  // FCL has no points.

}  // namespace

struct FclScene::Bodies {
  explicit Bodies(std::shared_ptr<Mesh> mesh)
      : object(std::move(mesh)), point(std::make_shared<fcl::Sphered>(kPointRadius_m)), finger(point) {}
  fcl::CollisionObjectd object;
  std::shared_ptr<fcl::CollisionGeometryd> point, finger;
};

FclScene::FclScene(const std::vector<double>& corners_m, const std::vector<int>& triangles)
    : bodies_(std::make_unique<Bodies>(make_mesh(corners_m, triangles))) {}

FclScene::~FclScene() = default;

void FclScene::set_finger(double radius_m) { bodies_->finger = std::make_shared<fcl::Sphered>(radius_m); }

void FclScene::set_finger(const std::vector<double>& corners_m, const std::vector<int>& triangles) {
  bodies_->finger = make_mesh(corners_m, triangles);
}

double FclScene::distance_m(const double* p_m) const {
  fcl::Transform3d X = fcl::Transform3d::Identity();
  X.translation() = Eigen::Map<const fcl::Vector3d>(p_m);
  const fcl::DistanceRequestd request(true);  // With the nearest points: a contact needs them.
  fcl::DistanceResultd result;
  return fcl::distance(bodies_->point.get(), X, bodies_->object.collisionGeometry().get(),
                       bodies_->object.getTransform(), request, result) +
         kPointRadius_m;
}

void FclScene::collide(const double* rotation, const double* translation_m, std::vector<double>& points_m,
                       std::vector<double>& gaps_m) const {
  constexpr std::size_t kMostContacts = 10000;
  fcl::Transform3d X = fcl::Transform3d::Identity();
  X.linear() = Eigen::Map<const fcl::Matrix3d>(rotation);
  X.translation() = Eigen::Map<const fcl::Vector3d>(translation_m);
  const fcl::CollisionRequestd request(kMostContacts, true);
  fcl::CollisionResultd result;
  fcl::collide(bodies_->finger.get(), X, bodies_->object.collisionGeometry().get(), bodies_->object.getTransform(),
               request, result);
  for (std::size_t i = 0; i < result.numContacts(); ++i) {
    // The depth is told with either sign, and the normal towards either body. `pos` lies on the object's triangle.
    const fcl::Contactd& contact = result.getContact(i);
    const fcl::Vector3d to_centre = (X.translation() - contact.pos).normalized();
    const fcl::Vector3d inward = contact.normal.dot(to_centre) > 0.0 ? fcl::Vector3d(-contact.normal) : contact.normal;
    const fcl::Vector3d deepest = contact.pos + std::abs(contact.penetration_depth) * inward;
    points_m.insert(points_m.end(), deepest.data(), deepest.data() + 3);
    gaps_m.push_back(-std::abs(contact.penetration_depth));
  }
}

}  // namespace thenar
