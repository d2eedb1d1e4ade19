// SPDX-License-Identifier: Apache-2.0
// ODE, double precision. Settings: `iterations` takes dWorldQuickStep with so many in place of dWorldStep.
// Contacts' friction is a pyramid along two axes (dContactApprox1), as its manual advises for Coulomb's law.

#include <ode/ode.h>

#include <array>

#include "bench/truth/peers/peer.h"

namespace thenar::truth {
namespace {

class OdeWorld : public World {
 public:
  explicit OdeWorld(const WorldData& data) : data_(data) {
    static const bool started = dInitODE2(0) != 0;
    (void)started;
    world_ = dWorldCreate();
    space_ = dSimpleSpaceCreate(nullptr);
    joints_ = dJointGroupCreate(0);
    iterations_ = static_cast<int>(data.set("iterations", 0.0));
    if (iterations_ > 0) dWorldSetQuickStepNumIterations(world_, iterations_);
    for (const Wall& wall : data_.walls) {
      const Vector& h = wall.half_m;
      const dGeomID geom = dCreateBox(space_, 2.0 * h[0], 2.0 * h[1], 2.0 * h[2]);
      dGeomSetPosition(geom, wall.at_m[0], wall.at_m[1], wall.at_m[2]);
      others_.push_back(geom);
    }
    for (const Finger& finger : data_.fingers) add(finger);
    add_object();
  }
  OdeWorld(const OdeWorld&) = delete;
  OdeWorld& operator=(const OdeWorld&) = delete;
  ~OdeWorld() override {
    dJointGroupDestroy(joints_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
  }

  void step(const Vector& force_N, const Vector& moment_Nm) override {
    contacts_ = 0;
    for (const dGeomID other : others_) {
      std::array<dContact, 8> contact{};
      const int found = dCollide(geom_, other, contact.size(), &contact[0].geom, sizeof(dContact));
      contacts_ += found;
      for (int i = 0; i < found; ++i) {
        contact[i].surface.mode = dContactApprox1;
        contact[i].surface.mu = data_.friction;
        dJointAttach(dJointCreateContact(world_, joints_, &contact[i]), body_, dGeomGetBody(other));
      }
    }
    dBodyAddForce(body_, force_N[0], force_N[1], force_N[2]);
    dBodyAddTorque(body_, moment_Nm[0], moment_Nm[1], moment_Nm[2]);
    for (std::size_t k = 0; k < fingers_.size(); ++k) {
      const Finger& f = data_.fingers[k];
      const double force = f.force_N - data_.finger_damping * dot(velocity(fingers_[k]), f.along);
      dBodyAddForce(fingers_[k], force * f.along[0], force * f.along[1], force * f.along[2]);
    }
    if (iterations_ > 0) {
      dWorldQuickStep(world_, data_.step_s);
    } else {
      dWorldStep(world_, data_.step_s);
    }
    dJointGroupEmpty(joints_);
  }

  [[nodiscard]] Reading read() const override {
    const dReal* p = dBodyGetPosition(body_);
    const dReal* q = dBodyGetQuaternion(body_);
    const Vector v = velocity(body_), I = data_.inertia();
    const dReal* w = dBodyGetAngularVel(body_);
    dVector3 local;
    dBodyVectorFromWorld(body_, w[0], w[1], w[2], local);
    double kinetic = 0.5 * data_.mass_kg * dot(v, v);
    for (int i = 0; i < 3; ++i) kinetic += 0.5 * I[i] * local[i] * local[i];
    for (const dBodyID finger : fingers_) {
      kinetic += 0.5 * data_.finger_mass_kg * dot(velocity(finger), velocity(finger));
    }
    return {{p[0], p[1], p[2]}, {q[0], q[1], q[2], q[3]}, kinetic, 0.0, contacts_};
  }

  [[nodiscard]] double travel_m(std::size_t k) const override {
    const dReal* p = dBodyGetPosition(fingers_[k]);
    const Finger& f = data_.fingers[k];
    return dot({p[0] - f.at_m[0], p[1] - f.at_m[1], p[2] - f.at_m[2]}, f.along);
  }

 private:
  static Vector velocity(dBodyID body) {
    const dReal* v = dBodyGetLinearVel(body);
    return {v[0], v[1], v[2]};
  }

  void add(const Finger& finger) {
    const dBodyID body = dBodyCreate(world_);
    dMass mass;
    dMassSetSphereTotal(&mass, data_.finger_mass_kg, finger.radius_m);
    dBodySetMass(body, &mass);
    dBodySetPosition(body, finger.at_m[0], finger.at_m[1], finger.at_m[2]);
    const dGeomID geom = dCreateSphere(space_, finger.radius_m);
    dGeomSetBody(geom, body);
    const dJointID slide = dJointCreateSlider(world_, nullptr);
    dJointAttach(slide, body, nullptr);
    dJointSetSliderAxis(slide, finger.along[0], finger.along[1], finger.along[2]);
    others_.push_back(geom);
    fingers_.push_back(body);
  }

  void add_object() {
    const Vector& h = data_.shape.half_m;
    switch (data_.shape.kind) {
      case Shape::Kind::kSphere:
        geom_ = dCreateSphere(space_, h[0]);
        break;
      case Shape::Kind::kBox:
        geom_ = dCreateBox(space_, 2.0 * h[0], 2.0 * h[1], 2.0 * h[2]);
        break;
      default:
        geom_ = dCreateCapsule(space_, h[0], 2.0 * h[1]);
    }
    const Vector I = data_.inertia();
    dMass mass;
    dMassSetParameters(&mass, data_.mass_kg, 0, 0, 0, I[0], I[1], I[2], 0, 0, 0);
    body_ = dBodyCreate(world_);
    dBodySetMass(body_, &mass);
    dBodySetPosition(body_, data_.at_m[0], data_.at_m[1], data_.at_m[2]);
    dBodySetQuaternion(body_, data_.attitude.data());
    dGeomSetBody(geom_, body_);
    if (data_.shape.kind == Shape::Kind::kCapsule) {
      dMatrix3 turn;  // Its axis is z here.
      dRFromAxisAndAngle(turn, 1, 0, 0, M_PI / 2);
      dGeomSetOffsetRotation(geom_, turn);
    }
  }

  WorldData data_;
  dWorldID world_;
  dSpaceID space_;
  dJointGroupID joints_;
  dBodyID body_ = nullptr;
  dGeomID geom_ = nullptr;
  std::vector<dBodyID> fingers_;
  std::vector<dGeomID> others_;
  int iterations_ = 0, contacts_ = 0;
};

}  // namespace

std::unique_ptr<World> make_world(const WorldData& data) { return std::make_unique<OdeWorld>(data); }
std::string engine() { return "ODE " dODE_VERSION; }

}  // namespace thenar::truth
