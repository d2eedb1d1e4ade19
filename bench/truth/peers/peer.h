// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

// What the programs of the truth bench have in common: bench/truth/truth.py hands each of them worlds, and reads what
// became of the object. This header knows no engine, and no engine's file knows a task.

namespace thenar::truth {

using Vector = std::array<double, 3>;
using Quaternion = std::array<double, 4>;  ///< w, x, y, z.

[[nodiscard]] inline double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// A sphere on a slide through its centre, without rotation and without weight, which a force presses along the slide.
struct Finger {
  Vector at_m, along;  ///< Its centre at the start; the slide's direction, of length 1.
  double radius_m, force_N;
};

/// A box that does not move, its axes the world's.
struct Wall {
  Vector at_m, half_m;
};

/// Shape of the object: of a sphere the radius, of a box half of each edge, of a capsule the radius and half of the
/// length of its axis, which is y; of anything else a file.
struct Shape {
  enum class Kind { kSphere, kBox, kCapsule, kFile } kind;
  Vector half_m;
  std::string file;
};

/// A world without gravity: all that acts on the object beside its contacts is a wrench at its centre of mass.
struct WorldData {
  Shape shape;
  double mass_kg, friction, step_s;
  Vector at_m;  ///< The object's centre at the start.
  Quaternion attitude;
  std::vector<Finger> fingers;
  std::vector<Wall> walls;
  double finger_mass_kg, finger_damping;  ///< Of those that have mass: damping of the slide [N s/m].
  double damping;          ///< Of the object of an engine without inertia [N s/m], and [N m s] by its radius of 1 cm.
  nlohmann::json setting;  ///< What the user of an engine sets beside its defaults, by the names of its file.

  [[nodiscard]] double set(const char* name, double otherwise) const { return setting.value(name, otherwise); }
  /// The moments of inertia of a solid of this shape about its axes [kg m^2].
  [[nodiscard]] Vector inertia() const;
};

/// What is read of a world after a step.
struct Reading {
  Vector at_m;
  Quaternion attitude;
  double kinetic_J;       ///< Of object and fingers.
  double stored_J = 0.0;  ///< Elastic energy of what is deformed, where an engine has it.
  int contacts;
};

/// A world as an engine has it.
class World {
 public:
  virtual ~World() = default;
  /// Advances by a step under this force and moment on the object, world axes, and the fingers' forces. All that an
  /// engine has to do for it is in here: this is what is timed.
  virtual void step(const Vector& force_N, const Vector& moment_Nm) = 0;
  [[nodiscard]] virtual Reading read() const = 0;
  /// How far a finger has gone along its slide [m].
  [[nodiscard]] virtual double travel_m(std::size_t finger) const = 0;
  /// How the engine was built, for the report, where it knows.
  [[nodiscard]] virtual nlohmann::json build() const { return nullptr; }
};

/// Builds a world. Each engine's file defines it.
[[nodiscard]] std::unique_ptr<World> make_world(const WorldData& data);
/// The engine's name and version.
[[nodiscard]] std::string engine();

}  // namespace thenar::truth
