// SPDX-License-Identifier: Apache-2.0
// Bullet, double precision. Settings: `iterations` of its sequential impulses, `two_directions` of friction, and
// `dantzig` for its direct solver.

#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>
#include <btBulletDynamicsCommon.h>

#include "bench/truth/peers/peer.h"

namespace thenar::truth {
namespace {

btVector3 vector(const Vector& v) { return {v[0], v[1], v[2]}; }
Vector vector(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

class BulletWorld : public World {
 public:
  explicit BulletWorld(const WorldData& data) : data_(data) {
    if (data.set("dantzig", 0.0) > 0.0) {
      solver_ = std::make_unique<btMLCPSolver>(&dantzig_);
    } else {
      solver_ = std::make_unique<btSequentialImpulseConstraintSolver>();
    }
    world_ = std::make_unique<btDiscreteDynamicsWorld>(&dispatcher_, &broadphase_, solver_.get(), &configuration_);
    world_->setGravity({0, 0, 0});
    btContactSolverInfo& info = world_->getSolverInfo();
    info.m_numIterations = static_cast<int>(data.set("iterations", info.m_numIterations));
    if (data.set("two_directions", 0.0) > 0.0) {
      info.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
      info.m_leastSquaresResidualThreshold = 0;
    }
    const btQuaternion upright(0, 0, 0, 1);
    // Friction of a pair is the product of the two.
    for (const Wall& w : data.walls) add(std::make_unique<btBoxShape>(vector(w.half_m)), 0, w.at_m, upright, 1);
    for (const Finger& f : data.fingers) add_finger(f);
    const Vector& h = data.shape.half_m;
    std::unique_ptr<btCollisionShape> shape;
    if (data.shape.kind == Shape::Kind::kSphere) {
      shape = std::make_unique<btSphereShape>(h[0]);
    } else if (data.shape.kind == Shape::Kind::kBox) {
      shape = std::make_unique<btBoxShape>(vector(h));
    } else {
      shape = std::make_unique<btCapsuleShape>(h[0], 2.0 * h[1]);
    }
    const Quaternion& q = data.attitude;
    object_ = add(std::move(shape), data.mass_kg, data.at_m, {q[1], q[2], q[3], q[0]}, data.friction);
    object_->setMassProps(data.mass_kg, vector(data.inertia()));
    object_->updateInertiaTensor();
  }
  BulletWorld(const BulletWorld&) = delete;
  BulletWorld& operator=(const BulletWorld&) = delete;
  ~BulletWorld() override {
    for (const auto& slide : slides_) world_->removeConstraint(slide.get());
    for (const auto& body : bodies_) world_->removeRigidBody(body.get());
  }

  void step(const Vector& force_N, const Vector& moment_Nm) override {
    object_->applyCentralForce(vector(force_N));
    object_->applyTorque(vector(moment_Nm));
    for (std::size_t k = 0; k < fingers_.size(); ++k) {
      const btVector3 along = vector(data_.fingers[k].along);
      const double speed = fingers_[k]->getLinearVelocity().dot(along);
      fingers_[k]->applyCentralForce(along * (data_.fingers[k].force_N - data_.finger_damping * speed));
    }
    world_->stepSimulation(data_.step_s, 0);
    world_->clearForces();
  }

  [[nodiscard]] Reading read() const override {
    const btVector3 turning = object_->getWorldTransform().getBasis().transpose() * object_->getAngularVelocity();
    const Vector I = data_.inertia();
    double kinetic = 0.5 * data_.mass_kg * object_->getLinearVelocity().length2();
    for (int i = 0; i < 3; ++i) kinetic += 0.5 * I[i] * turning[i] * turning[i];
    for (const btRigidBody* finger : fingers_) {
      kinetic += 0.5 * data_.finger_mass_kg * finger->getLinearVelocity().length2();
    }
    int contacts = 0;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      contacts += const_cast<btCollisionDispatcher&>(dispatcher_).getManifoldByIndexInternal(i)->getNumContacts();
    }
    const btQuaternion q = object_->getOrientation();
    return {vector(object_->getCenterOfMassPosition()), {q.w(), q.x(), q.y(), q.z()}, kinetic, 0.0, contacts};
  }

  [[nodiscard]] double travel_m(std::size_t k) const override {
    const Finger& f = data_.fingers[k];
    return (fingers_[k]->getCenterOfMassPosition() - vector(f.at_m)).dot(vector(f.along));
  }

 private:
  btRigidBody* add(std::unique_ptr<btCollisionShape> shape, double mass, const Vector& at, const btQuaternion& attitude,
                   double friction) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape->calculateLocalInertia(mass, inertia);
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape.get(), inertia);
    info.m_startWorldTransform = btTransform(attitude, vector(at));
    info.m_friction = friction;
    auto body = std::make_unique<btRigidBody>(info);
    body->setActivationState(DISABLE_DEACTIVATION);
    world_->addRigidBody(body.get());
    shapes_.push_back(std::move(shape));
    bodies_.push_back(std::move(body));
    return bodies_.back().get();
  }

  /// A slide along x is a factor of the body; another one is a constraint with six degrees of freedom.
  void add_finger(const Finger& f) {
    btRigidBody* body =
        add(std::make_unique<btSphereShape>(f.radius_m), data_.finger_mass_kg, f.at_m, btQuaternion(0, 0, 0, 1), 1);
    body->setAngularFactor(0);
    fingers_.push_back(body);
    if (std::abs(f.along[0]) > 1.0 - 1e-9) {
      body->setLinearFactor({1, 0, 0});
      return;
    }
    const btVector3 x = vector(f.along), y = x.cross(btVector3(0, 0, 1)).normalized(), z = x.cross(y);
    btTransform frame;
    frame.setIdentity();
    frame.setBasis({x.x(), y.x(), z.x(), x.y(), y.y(), z.y(), x.z(), y.z(), z.z()});
    auto slide = std::make_unique<btGeneric6DofSpring2Constraint>(*body, frame);
    slide->setLinearLowerLimit({1, 0, 0});  // Below above upper: free.
    slide->setLinearUpperLimit({-1, 0, 0});
    slide->setAngularLowerLimit({1, 1, 1});
    slide->setAngularUpperLimit({-1, -1, -1});
    world_->addConstraint(slide.get());
    slides_.push_back(std::move(slide));
  }

  WorldData data_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btDantzigSolver dantzig_;
  std::unique_ptr<btConstraintSolver> solver_;
  std::unique_ptr<btDiscreteDynamicsWorld> world_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btTypedConstraint>> slides_;
  std::vector<btRigidBody*> fingers_;
  btRigidBody* object_ = nullptr;
};

}  // namespace

std::unique_ptr<World> make_world(const WorldData& data) { return std::make_unique<BulletWorld>(data); }
std::string engine() {
  return "Bullet " + std::to_string(btGetVersion() / 100) + "." + std::to_string(btGetVersion() % 100);
}

}  // namespace thenar::truth
