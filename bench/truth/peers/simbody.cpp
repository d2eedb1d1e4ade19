// SPDX-License-Identifier: Apache-2.0
// Simbody: compliant contacts. Materials (1e8 Pa, a dissipation of 100 s/m) are those that Gazebo gives it by
// default; the transition velocity of friction (1 mm/s) and the implicit integrator of CPodes, at an accuracy of
// 1e-3, those of its examples of contact. A step is what lies between two reports: it has no other. Hertz' law
// presses spheres, a penalty bricks. It has no contacts of boxes with spheres or boxes, so that faces are
// half-spaces: those that fingers press on, and that of the one wall; worlds with more walls are refused, and
// capsules, which it does not have. (Its contacts of rigid bodies are experimental, says their header.) Settings:
// `stiffness` [Pa], `dissipation` [s/m], `transition` velocity [m/s], `accuracy`. This file is C++17: the headers
// compare in ways that are ambiguous in C++20.

#include <Simbody.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "bench/truth/peers/peer.h"

namespace thenar::truth {
namespace {

using namespace SimTK;

Vec3 vector(const Vector& v) { return {v[0], v[1], v[2]}; }

/// The wrench of a step on the object, and the fingers' forces along their damped slides.
class Loads : public Force::Custom::Implementation {
 public:
  explicit Loads(const WorldData& data) : data_(data) {}
  void calcForce(const State& state, Vector_<SpatialVec>& wrenches, Vector_<Vec3>& /*particles*/,
                 SimTK::Vector& mobilities) const override {
    object.applyBodyForce(state, {moment, force}, wrenches);
    for (std::size_t k = 0; k < fingers.size(); ++k) {
      const Real press = data_.fingers[k].force_N - data_.finger_damping * fingers[k].getRate(state);
      fingers[k].applyOneMobilityForce(state, MobilizerUIndex(0), press, mobilities);
    }
  }
  Real calcPotentialEnergy(const State& /*state*/) const override { return 0.0; }

  MobilizedBody object;
  std::vector<MobilizedBody::Slider> fingers;
  Vec3 force{0}, moment{0};

 private:
  const WorldData& data_;
};

class SimbodyWorld : public World {
 public:
  explicit SimbodyWorld(const WorldData& data)
      : data_(data), material_(data.set("stiffness", 1e8), data.set("dissipation", 100), data.friction, data.friction) {
    if (data.walls.size() > 1) throw std::runtime_error("no boxes against the edges of boxes");
    if (data.shape.kind == Shape::Kind::kCapsule) throw std::runtime_error("no capsules");
    contacts_.setTransitionVelocity(data.set("transition", 1e-3));
    loads_ = new Loads(data_);
    Force::Custom(forces_, loads_);
    add_object();
    for (const Finger& finger : data.fingers) add(finger);
    for (const Wall& wall : data.walls) add(wall);

    State state = system_.realizeTopology();
    const Quaternion& q = data.attitude;
    loads_->object.setQToFitTransform(
        state, Transform(Rotation(SimTK::Quaternion(q[0], q[1], q[2], q[3])), vector(data.at_m)));
    integrator_ = std::make_unique<CPodesIntegrator>(system_, CPodes::BDF, CPodes::Newton);
    integrator_->setAccuracy(data.set("accuracy", 1e-3));
    integrator_->initialize(state);
  }

  void step(const Vector& force_N, const Vector& moment_Nm) override {
    if (vector(force_N) != loads_->force || vector(moment_Nm) != loads_->moment) {
      loads_->force = vector(force_N);
      loads_->moment = vector(moment_Nm);
      // Its integrator of several steps is told of what is not smooth.
      integrator_->updAdvancedState().invalidateAllCacheAtOrAbove(Stage::Dynamics);
      integrator_->reinitialize(Stage::Dynamics, false);
    }
    const Real end = data_.step_s * static_cast<Real>(++steps_);
    while (integrator_->getTime() < end) integrator_->stepTo(end, end);
  }

  [[nodiscard]] Reading read() const override {
    const State& state = integrator_->getState();
    system_.realize(state, Stage::Dynamics);
    const Transform& X = loads_->object.getBodyTransform(state);
    const SimTK::Quaternion q = X.R().convertRotationToQuaternion();
    return {{X.p()[0], X.p()[1], X.p()[2]},
            {q[0], q[1], q[2], q[3]},
            system_.calcKineticEnergy(state),
            system_.calcPotentialEnergy(state),
            contacts_.getNumContactForces(state)};
  }

  [[nodiscard]] double travel_m(std::size_t k) const override {
    return loads_->fingers[k].getLength(integrator_->getState());
  }

 private:
  /// A half-space fills x > 0 of its frame: this one ends at a point, with this outward normal.
  static Transform half_space(const Vec3& normal, const Vec3& at) { return {Rotation(UnitVec3(-normal), XAxis), at}; }

  /// The face of a box that a direction in its axes leaves by most, as its outward normal.
  static Vec3 face(const Vec3& out) {
    int most = 0;
    for (int i = 1; i < 3; ++i) most = std::abs(out[i]) > std::abs(out[most]) ? i : most;
    Vec3 normal(0);
    normal[most] = out[most] > 0 ? 1 : -1;
    return normal;
  }

  /// The face of the object that a finger presses on.
  [[nodiscard]] Vec3 face_of(const Finger& finger) const {
    const Quaternion& q = data_.attitude;
    return face(~Rotation(SimTK::Quaternion(q[0], q[1], q[2], q[3])) * -vector(finger.along));
  }

  void add_object() {
    const Vec3 half = vector(data_.shape.half_m), inertia = vector(data_.inertia());
    Body::Rigid body(MassProperties(data_.mass_kg, Vec3(0), Inertia(inertia[0], inertia[1], inertia[2])));
    if (data_.shape.kind == Shape::Kind::kSphere) {
      body.addContactSurface(Transform(), ContactSurface(ContactGeometry::Sphere(half[0]), material_));
    } else if (!data_.walls.empty()) {
      body.addContactSurface(Transform(), ContactSurface(ContactGeometry::Brick(half), material_));
    } else {
      for (const Finger& finger : data_.fingers) {
        const Vec3 normal = face_of(finger);
        if (std::any_of(faces_.begin(), faces_.end(), [&](const Face& f) { return f.normal == normal; })) continue;
        faces_.push_back({normal, ContactSurface::createNewContactClique()});
        ContactSurface surface(ContactGeometry::HalfSpace(), material_);
        surface.joinClique(faces_.back().others);
        body.addContactSurface(half_space(normal, normal.elementwiseMultiply(half)), surface);
      }
    }
    loads_->object = MobilizedBody::Free(matter_.Ground(), Transform(), body, Transform());
  }

  void add(const Finger& finger) {
    const Real radius = finger.radius_m;
    Body::Rigid body(MassProperties(data_.finger_mass_kg, Vec3(0), data_.finger_mass_kg * UnitInertia::sphere(radius)));
    ContactSurface surface(ContactGeometry::Sphere(radius), material_);
    surface.joinClique(fingers_);
    for (const Face& f : faces_) {
      if (f.normal != face_of(finger)) surface.joinClique(f.others);
    }
    body.addContactSurface(Transform(), surface);
    const Rotation along(UnitVec3(vector(finger.along)), XAxis);
    loads_->fingers.emplace_back(matter_.Ground(), Transform(along, vector(finger.at_m)), body, Transform(along));
  }

  void add(const Wall& wall) {
    Vec3 out = vector(data_.at_m) - vector(wall.at_m);
    for (int i = 0; i < 3; ++i) out[i] /= wall.half_m[i];
    const Vec3 normal = face(out);
    matter_.Ground().updBody().addContactSurface(
        half_space(normal, vector(wall.at_m) + normal.elementwiseMultiply(vector(wall.half_m))),
        ContactSurface(ContactGeometry::HalfSpace(), material_));
  }

  /// A face that fingers press on, and the clique of those that do not: who has a clique in common has no contact.
  struct Face {
    Vec3 normal;
    ContactCliqueId others;
  };

  WorldData data_;
  ContactMaterial material_;
  MultibodySystem system_;
  SimbodyMatterSubsystem matter_{system_};
  GeneralForceSubsystem forces_{system_};
  ContactTrackerSubsystem tracker_{system_};
  CompliantContactSubsystem contacts_{system_, tracker_};
  std::unique_ptr<Integrator> integrator_;
  std::vector<Face> faces_;
  ContactCliqueId fingers_ = ContactSurface::createNewContactClique();
  Loads* loads_ = nullptr;
  long steps_ = 0;
};

}  // namespace

std::unique_ptr<World> make_world(const WorldData& data) { return std::make_unique<SimbodyWorld>(data); }
std::string engine() {
  int major = 0, minor = 0, patch = 0;
  SimTK_version_simbody(&major, &minor, &patch);
  return "Simbody " + std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch);
}

}  // namespace thenar::truth
