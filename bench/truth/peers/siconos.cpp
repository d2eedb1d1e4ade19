// SPDX-License-Identifier: Apache-2.0
// Siconos: rigid bodies of its mechanics part, Moreau-Jean's scheme, contacts from its Bullet manager (which Debian
// builds in single precision), all as its runner of mechanical scenes sets them up: theta 0.50001, Newton's loop to
// 1e-10 within 20 iterations, nonsmooth Gauss-Seidel, corners rounded by 2 % of a shape's smallest size. Settings:
// `tolerance` and `iterations` of the solver, `scale` of lengths in Bullet's world, and the share `margin` by which
// corners are rounded. This file is C++17: ublas of Boost 1.74, which its headers include, does not compile as C++20.

// clang-format off
#include <MechanicsFwd.hpp>  // It names the classes that a visitor sees, also to the others.
// clang-format on
#include <SolverOptions.h>

#include <FixedBC.hpp>
#include <GenericMechanical.hpp>
#include <PrismaticJointR.hpp>
#include <RigidBodyDS.hpp>
#include <SiconosBulletCollisionManager.hpp>
#include <SiconosKernel.hpp>
#include <algorithm>
#include <cmath>

#include "bench/truth/peers/peer.h"

namespace thenar::truth {
namespace {

using VectorPtr = SP::SiconosVector;

VectorPtr vector(const Vector& v) { return std::make_shared<SiconosVector>(std::vector<double>(v.begin(), v.end())); }
Vector vector(const SiconosVector& v) { return {v(0), v(1), v(2)}; }

/// Place and attitude as one vector.
VectorPtr pose(const Vector& at, const Quaternion& q) {
  return std::make_shared<SiconosVector>(std::vector<double>{at[0], at[1], at[2], q[0], q[1], q[2], q[3]});
}

class SiconosWorld : public World {
 public:
  explicit SiconosWorld(const WorldData& data)
      : data_(data), system_(std::make_shared<NonSmoothDynamicalSystem>(0, 1e9)) {
    SiconosBulletOptions options;
    options.worldScale = data.set("scale", options.worldScale);
    contacts_ = std::make_shared<SiconosBulletCollisionManager>(options);
    contacts_->insertNonSmoothLaw(std::make_shared<NewtonImpactFrictionNSL>(0.0, 0.0, data.friction, 3), kOthers,
                                  kObject);
    for (const Wall& wall : data.walls) {
      const Vector& h = wall.half_m;
      contacts_->insertStaticContactorSet(set_of(box(h), kOthers), pose(wall.at_m, {1, 0, 0, 0}));
    }
    for (const Finger& finger : data.fingers) add(finger);
    add_object();

    const auto scheme = std::make_shared<MoreauJeanOSI>(0.50001);
    simulation_ = std::make_shared<TimeStepping>(system_, std::make_shared<TimeDiscretisation>(0.0, data.step_s));
    simulation_->insertIntegrator(scheme);
    simulation_->insertNonSmoothProblem(problem());
    simulation_->insertInteractionManager(contacts_);
    simulation_->setNewtonTolerance(1e-10);
    simulation_->setNewtonMaxIteration(20);
    simulation_->initialize();
  }

  void step(const Vector& force_N, const Vector& moment_Nm) override {
    for (int i = 0; i < 3; ++i) {
      (*force_)(i) = force_N[i];
      (*moment_)(i) = moment_Nm[i];
    }
    for (std::size_t k = 0; k < fingers_.size(); ++k) {
      const Finger& f = data_.fingers[k];
      const double force = f.force_N - data_.finger_damping * dot(vector(*fingers_[k]->twist()), f.along);
      for (int i = 0; i < 3; ++i) (*presses_[k])(i) = force * f.along[i];
    }
    // The scheme means the forces at both ends of a step; what it remembers of its start must be of the same load.
    remember(*object_);
    for (const auto& finger : fingers_) remember(*finger);
    simulation_->computeOneStep();
    simulation_->clearNSDSChangeLog();
    simulation_->nextStep();
  }

  [[nodiscard]] Reading read() const override {
    const SiconosVector &q = *object_->q(), &v = *object_->twist();
    const Vector I = data_.inertia(), speed = vector(v);
    double kinetic = 0.5 * data_.mass_kg * dot(speed, speed);
    for (int i = 0; i < 3; ++i) kinetic += 0.5 * I[i] * v(3 + i) * v(3 + i);
    for (const auto& finger : fingers_) {
      const Vector u = vector(*finger->twist());
      kinetic += 0.5 * data_.finger_mass_kg * dot(u, u);
    }
    const auto active = static_cast<int>(system_->topology()->indexSet(1)->size());
    return {vector(q), {q(3), q(4), q(5), q(6)}, kinetic, 0.0, active - joints_};
  }

  [[nodiscard]] double travel_m(std::size_t k) const override {
    const Vector p = vector(*fingers_[k]->q());
    const Finger& f = data_.fingers[k];
    return dot({p[0] - f.at_m[0], p[1] - f.at_m[1], p[2] - f.at_m[2]}, f.along);
  }

 private:
  static void remember(RigidBodyDS& body) {
    body.computeForces(0.0, body.q(), body.twist());
    body.swapInMemory();
  }

  static constexpr int kOthers = 0, kObject = 1;  ///< Groups of shapes: only pairs of both have a law.

  template <class ShapePtr>
  ShapePtr with_margin(ShapePtr shape, double smallest) {
    shape->setInsideMargin(data_.set("margin", 0.02) * smallest);
    return shape;
  }
  SP::SiconosShape box(const Vector& h) {
    return with_margin(std::make_shared<SiconosBox>(2.0 * h[0], 2.0 * h[1], 2.0 * h[2]),
                       2.0 * std::min({h[0], h[1], h[2]}));
  }
  SP::SiconosShape sphere(double radius) {
    return with_margin(std::make_shared<SiconosSphere>(static_cast<float>(radius)), radius);
  }
  static SP::SiconosContactorSet set_of(const SP::SiconosShape& shape, int group) {
    const auto set = std::make_shared<SiconosContactorSet>();
    set->append(std::make_shared<SiconosContactor>(shape, VectorPtr(), group));
    return set;
  }

  std::shared_ptr<RigidBodyDS> add(const SP::SiconosShape& shape, int group, double mass, const Vector& inertia,
                                   const VectorPtr& at) {
    const auto I = std::make_shared<SimpleMatrix>(3, 3);
    for (int i = 0; i < 3; ++i) I->setValue(i, i, inertia[i]);
    const auto body = std::make_shared<RigidBodyDS>(at, std::make_shared<SiconosVector>(6), mass, I);
    body->setContactors(set_of(shape, group));
    body->setUseContactorInertia(false);
    system_->insertDynamicalSystem(body);
    return body;
  }

  void add(const Finger& f) {
    const double I = 0.4 * data_.finger_mass_kg * f.radius_m * f.radius_m;
    const auto body = add(sphere(f.radius_m), kOthers, data_.finger_mass_kg, {I, I, I}, pose(f.at_m, {1, 0, 0, 0}));
    fingers_.push_back(body);
    presses_.push_back(vector({0, 0, 0}));
    body->setFExtPtr(presses_.back());
    const auto axis = std::find_if(f.along.begin(), f.along.end(), [](double a) { return std::abs(a) > 1.0 - 1e-9; });
    if (axis != f.along.end()) {
      const auto fixed = std::make_shared<std::vector<unsigned int>>();
      for (unsigned int i = 0; i < 6; ++i) {
        if (i != static_cast<unsigned int>(axis - f.along.begin())) fixed->push_back(i);
      }
      body->setBoundaryConditions(std::make_shared<FixedBC>(fixed));
      return;
    }
    const auto slide = std::make_shared<PrismaticJointR>(vector(f.along), true, body);
    system_->link(
        std::make_shared<Interaction>(std::make_shared<EqualityConditionNSL>(slide->numberOfConstraints()), slide),
        body);
    ++joints_;
  }

  void add_object() {
    const Vector& h = data_.shape.half_m;
    SP::SiconosShape shape;
    if (data_.shape.kind == Shape::Kind::kSphere) {
      shape = sphere(h[0]);
    } else if (data_.shape.kind == Shape::Kind::kBox) {
      shape = box(h);
    } else {
      // Its Bullet shape is half as long as it says.
      shape =
          with_margin(std::make_shared<SiconosCapsule>(static_cast<float>(h[0]), static_cast<float>(4.0 * h[1])), h[0]);
    }
    object_ = add(shape, kObject, data_.mass_kg, data_.inertia(), pose(data_.at_m, data_.attitude));
    force_ = vector({0, 0, 0});
    moment_ = vector({0, 0, 0});
    object_->setFExtPtr(force_);
    object_->setMExtPtr(moment_);
    object_->setIsMextExpressedInInertialFrame(true);
  }

  /// The problem of contacts, or of contacts and joints, and its solver: nonsmooth Gauss-Seidel.
  std::shared_ptr<LinearOSNS> problem() {
    std::shared_ptr<LinearOSNS> made;
    if (joints_ > 0) {
      made = std::make_shared<GenericMechanical>();
      contacts_->useEqualityConstraints(true);
    } else {
      made = std::make_shared<FrictionContact>(3);
      made->setMStorageType(NM_SPARSE_BLOCK);
    }
    SolverOptions& solver = *made->numericsSolverOptions();
    solver.dparam[SICONOS_DPARAM_TOL] = data_.set("tolerance", solver.dparam[SICONOS_DPARAM_TOL]);
    solver.iparam[SICONOS_IPARAM_MAX_ITER] =
        static_cast<int>(data_.set("iterations", solver.iparam[SICONOS_IPARAM_MAX_ITER]));
    made->setKeepLambdaAndYState(true);
    return made;
  }

  WorldData data_;
  std::shared_ptr<NonSmoothDynamicalSystem> system_;
  std::shared_ptr<SiconosBulletCollisionManager> contacts_;
  std::shared_ptr<TimeStepping> simulation_;
  std::shared_ptr<RigidBodyDS> object_;
  std::vector<std::shared_ptr<RigidBodyDS>> fingers_;
  std::vector<VectorPtr> presses_;
  VectorPtr force_, moment_;
  int joints_ = 0;
};

}  // namespace

std::unique_ptr<World> make_world(const WorldData& data) { return std::make_unique<SiconosWorld>(data); }
std::string engine() { return "Siconos " SICONOS_VERSION; }

}  // namespace thenar::truth
