// SPDX-License-Identifier: Apache-2.0
// Thenar, as its users write such a world: a scene of fingertips on slides.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <numbers>
#include <numeric>

#include "bench/cases/scene_run.h"
#include "bench/truth/peers/peer.h"
#include "engine/results/summary.h"
#include "engine/scenes/scene_file.h"

namespace thenar::truth {
namespace {

std::string row(const Vector& v, const char* unit) {
  return fmt::format("[{}{}, {}{}, {}{}]", v[0], unit, v[1], unit, v[2], unit);
}

std::string shape_text(const Shape& shape) {
  const Vector& h = shape.half_m;
  switch (shape.kind) {
    case Shape::Kind::kSphere:
      return fmt::format("{{sphere: {} m}}", h[0]);
    case Shape::Kind::kBox:
      return fmt::format("{{box: {}}}", row({2.0 * h[0], 2.0 * h[1], 2.0 * h[2]}, " m"));
    case Shape::Kind::kCapsule:
      // A rod of the same radius: nothing touches its ends.
      return fmt::format("{{cylinder: {{radius: {} m, length: {} m}}}}", h[0], 2.0 * (h[0] + h[1]));
    default:
      return fmt::format("{{cloud: {}}}", shape.file);
  }
}

/// The rotation of the object frame; a rod's axis is z there, and y in a world.
std::string rotation_text(const WorldData& data) {
  const auto& [w, x, y, z] = data.attitude;
  Eigen::Matrix3d R = Eigen::Quaterniond(w, x, y, z).normalized().toRotationMatrix();
  if (data.shape.kind == Shape::Kind::kCapsule) {
    const Eigen::Matrix3d along_y =
        Eigen::AngleAxisd(-0.5 * std::numbers::pi, Eigen::Vector3d::UnitX()).toRotationMatrix();
    R = (R * along_y).eval();
  }
  std::string rows;
  for (int i = 0; i < 3; ++i) rows += fmt::format("{}[{}, {}, {}]", i > 0 ? ", " : "", R(i, 0), R(i, 1), R(i, 2));
  return rows;
}

/// A scene without fingers has one that is far away.
std::vector<Finger> fingers_of(const WorldData& data) {
  if (!data.fingers.empty()) return data.fingers;
  return {{{0.0, 0.0, 1.5}, {0.0, 0.0, 1.0}, 8e-3, 0.0}};
}

std::string scene_text(const WorldData& data) {
  const bool pulps = data.set("pulps", 0.0) > 0.0;
  std::string text = "name: world\n";
  text += fmt::format("time: {{duration: 1 s, step: {} s, control_period: {} s}}\n", data.step_s,
                      std::max(data.step_s, data.set("control_period", 0.0)));
  text += "hand:\n  slides:\n";
  for (const Finger& f : fingers_of(data)) {
    text += fmt::format("    - {{at: {}, along: {}, radius: {} m, force: {} N, damping: {} N*s/m}}\n",
                        row(f.at_m, " m"), row(f.along, ""), f.radius_m, f.force_N, data.finger_damping);
  }
  if (pulps) {
    text += "fingertips: {points: 2400, leaves: 320, reduced_modulus: 0.24 MPa, poisson: 0.5, relaxation: 2 ms}\n";
  }
  // A point cloud brings its own points.
  const bool scanned = data.shape.kind == Shape::Kind::kFile && data.shape.file.ends_with(".xyz");
  text += fmt::format(
      "object: {{shape: {},{} mass: {} kg, position: {}, rotation: [{}], damping: "
      "{{translation: {} N*s/m, rotation: {} N*m*s}}}}\n",
      shape_text(data.shape), scanned ? "" : fmt::format(" points: {},", data.set("points", 4000.0)), data.mass_kg,
      row(data.at_m, " m"), rotation_text(data), data.damping, 1e-4 * data.damping);
  text += fmt::format("contact: {{friction: {}, band: 0.3 mm{}", data.friction, pulps ? ", max_per_finger: 40" : "");
  if (data.setting.contains("tolerance")) text += fmt::format(", tolerance: {}", data.set("tolerance", 0.0));
  text += "}\n";
  if (!data.walls.empty()) text += fmt::format("environment:\n  friction: {}\n  bodies:\n", data.friction);
  for (const Wall& w : data.walls) {
    text += fmt::format("    - {{shape: {{box: {}}}, position: {}}}\n",
                        row({2.0 * w.half_m[0], 2.0 * w.half_m[1], 2.0 * w.half_m[2]}, " m"), row(w.at_m, " m"));
  }
  return text;
}

Scene scene_of(const WorldData& data) {
  // Beside the shape's file, which scenes name by a path from where they are.
  const char* const folder = std::getenv("TRUTH_FOLDER");
  const std::string path = fmt::format("{}/world.yaml", folder != nullptr ? folder : ".");
  std::ofstream(path) << scene_text(data);
  return load_scene(path);
}

class ThenarWorld : public World {
 public:
  explicit ThenarWorld(const WorldData& data) : loop_(scene_of(data)) {}

  void step(const Vector& force_N, const Vector& moment_Nm) override {
    TickInput input;
    input.wrench << force_N[0], force_N[1], force_N[2], moment_Nm[0], moment_Nm[1], moment_Nm[2];
    contacts_ = static_cast<int>(loop_.tick(input).contacts);
  }

  [[nodiscard]] Reading read() const override {
    const State& state = loop_.state;
    const Eigen::Vector3d at = state.X_WO.translation();
    const Eigen::Quaterniond q(state.X_WO.linear());
    const double stored = std::accumulate(state.pulp_energy_J.begin(), state.pulp_energy_J.end(), 0.0);
    return {{at[0], at[1], at[2]}, {q.w(), q.x(), q.y(), q.z()}, 0.0, stored, contacts_};
  }

  [[nodiscard]] double travel_m(std::size_t finger) const override { return loop_.state.q[static_cast<int>(finger)]; }
  [[nodiscard]] nlohmann::json build() const override { return build_settings(); }

 private:
  Loop loop_;
  int contacts_ = 0;
};

}  // namespace

std::unique_ptr<World> make_world(const WorldData& data) { return std::make_unique<ThenarWorld>(data); }
std::string engine() { return "Thenar"; }

}  // namespace thenar::truth
