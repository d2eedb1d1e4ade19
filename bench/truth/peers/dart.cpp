// SPDX-License-Identifier: Apache-2.0
// DART. Setting: `bullet` takes Bullet's collision detector in place of the default one.

#include <dart/collision/bullet/bullet.hpp>
#include <dart/dart.hpp>
#include <numbers>

#include "bench/truth/peers/peer.h"

namespace thenar::truth {
namespace {

using namespace dart::dynamics;
using Eigen::Isometry3d;
using Eigen::Vector3d;

Vector3d vector(const Vector& v) { return {v[0], v[1], v[2]}; }

class DartWorld : public World {
 public:
  explicit DartWorld(const WorldData& data) : data_(data), world_(dart::simulation::World::create()) {
    world_->setTimeStep(data.step_s);
    world_->setGravity(Vector3d::Zero());
    if (data.set("bullet", 0.0) > 0.0) {
      world_->getConstraintSolver()->setCollisionDetector(dart::collision::BulletCollisionDetector::create());
    }
    for (const Wall& w : data.walls) {
      WeldJoint::Properties fixed;
      fixed.mT_ParentBodyToJoint.translation() = vector(w.at_m);
      const SkeletonPtr wall = Skeleton::create(name("wall"));
      BodyNode* body = wall->createJointAndBodyNodePair<WeldJoint>(nullptr, fixed).second;
      give(body, std::make_shared<BoxShape>(2.0 * vector(w.half_m)));
      world_->addSkeleton(wall);
    }
    for (const Finger& f : data.fingers) {
      PrismaticJoint::Properties slide;
      slide.mAxis = vector(f.along);
      slide.mT_ParentBodyToJoint.translation() = vector(f.at_m);
      slide.mDampingCoefficients[0] = data.finger_damping;
      const SkeletonPtr finger = Skeleton::create(name("finger"));
      BodyNode* body = finger->createJointAndBodyNodePair<PrismaticJoint>(nullptr, slide).second;
      body->setMass(data.finger_mass_kg);
      give(body, std::make_shared<SphereShape>(f.radius_m));
      world_->addSkeleton(finger);
      fingers_.push_back(finger);
    }
    add_object();
  }

  void step(const Vector& force_N, const Vector& moment_Nm) override {
    object_->addExtForce(vector(force_N), Vector3d::Zero(), false, true);
    object_->addExtTorque(vector(moment_Nm), false);
    for (std::size_t k = 0; k < fingers_.size(); ++k) fingers_[k]->setForce(0, data_.fingers[k].force_N);
    world_->step();
  }

  [[nodiscard]] Reading read() const override {
    const Isometry3d X = object_->getTransform();
    const Eigen::Quaterniond q(X.linear());
    double kinetic = object_->computeKineticEnergy();
    for (const SkeletonPtr& finger : fingers_) kinetic += finger->computeKineticEnergy();
    return {{X.translation()[0], X.translation()[1], X.translation()[2]},
            {q.w(), q.x(), q.y(), q.z()},
            kinetic,
            0.0,
            static_cast<int>(world_->getLastCollisionResult().getNumContacts())};
  }

  [[nodiscard]] double travel_m(std::size_t k) const override { return fingers_[k]->getPosition(0); }

 private:
  [[nodiscard]] std::string name(const char* of) const { return of + std::to_string(world_->getNumSkeletons()); }

  void give(BodyNode* body, const ShapePtr& shape, const Isometry3d& at = Isometry3d::Identity()) {
    ShapeNode* node = body->createShapeNodeWith<CollisionAspect, DynamicsAspect>(shape);
    node->getDynamicsAspect()->setFrictionCoeff(data_.friction);
    node->setRelativeTransform(at);
  }

  void add_object() {
    const Vector& h = data_.shape.half_m;
    const SkeletonPtr skeleton = Skeleton::create(name("object"));
    const auto [joint, body] = skeleton->createJointAndBodyNodePair<FreeJoint>();
    object_ = body;
    if (data_.shape.kind == Shape::Kind::kSphere) {
      give(body, std::make_shared<SphereShape>(h[0]));
    } else if (data_.shape.kind == Shape::Kind::kBox) {
      give(body, std::make_shared<BoxShape>(2.0 * vector(h)));
    } else {
      Isometry3d along_y = Isometry3d::Identity();
      along_y.linear() = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitX()).toRotationMatrix();
      give(body, std::make_shared<CapsuleShape>(h[0], 2.0 * h[1]), along_y);
    }
    Inertia inertia;
    inertia.setMass(data_.mass_kg);
    inertia.setMoment(Eigen::Matrix3d(vector(data_.inertia()).asDiagonal()));
    body->setInertia(inertia);
    Isometry3d X = Isometry3d::Identity();
    X.translation() = vector(data_.at_m);
    const Quaternion& q = data_.attitude;
    X.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
    FreeJoint::setTransformOf(joint, X);
    world_->addSkeleton(skeleton);
  }

  WorldData data_;
  dart::simulation::WorldPtr world_;
  std::vector<SkeletonPtr> fingers_;
  BodyNode* object_ = nullptr;
};

}  // namespace

std::unique_ptr<World> make_world(const WorldData& data) { return std::make_unique<DartWorld>(data); }
std::string engine() { return "DART " DART_VERSION; }

}  // namespace thenar::truth
