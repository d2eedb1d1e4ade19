// SPDX-License-Identifier: Apache-2.0
// MuJoCo of the C library. Settings are the attributes of <option>, and cone: 1 for an elliptic one.

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <stdexcept>

#include "bench/truth/peers/peer.h"

namespace thenar::truth {
namespace {

std::string row(const Vector& v) { return fmt::format("{} {} {}", v[0], v[1], v[2]); }

std::string options(const WorldData& data) {
  std::string text = fmt::format("timestep='{}'", data.step_s);
  for (const auto& [name, value] : data.setting.items()) {
    text += name == "cone" ? std::string(" cone='elliptic'") : fmt::format(" {}='{}'", name, value.get<double>());
  }
  return text;
}

std::string model_of(const WorldData& data) {
  // Where two geoms meet, the larger friction counts.
  std::string xml = fmt::format(
      "<mujoco><option gravity='0 0 0' {}/><default><geom friction='{} 0.005 0.0001'/></default><worldbody>",
      options(data), data.friction);
  for (const Wall& w : data.walls) {
    xml += fmt::format("<geom type='box' size='{}' pos='{}'/>", row(w.half_m), row(w.at_m));
  }
  for (const Finger& f : data.fingers) {
    xml += fmt::format(
        "<body pos='{}'><joint type='slide' axis='{}' damping='{}'/><geom type='sphere' size='{}' mass='{}'/></body>",
        row(f.at_m), row(f.along), data.finger_damping, f.radius_m, data.finger_mass_kg);
  }
  const Vector& h = data.shape.half_m;
  const std::string geom = data.shape.kind == Shape::Kind::kSphere ? fmt::format("type='sphere' size='{}'", h[0])
                           : data.shape.kind == Shape::Kind::kBox
                               ? fmt::format("type='box' size='{}'", row(h))
                               : fmt::format("type='capsule' size='{} {}' euler='90 0 0'", h[0], h[1]);
  const Quaternion& q = data.attitude;
  return xml + fmt::format(
                   "<body name='object' pos='{}' quat='{} {} {} {}'><freejoint/><inertial pos='0 0 0' mass='{}' "
                   "diaginertia='{}'/><geom {}/></body></worldbody></mujoco>",
                   row(data.at_m), q[0], q[1], q[2], q[3], data.mass_kg, row(data.inertia()), geom);
}

class MujocoWorld : public World {
 public:
  explicit MujocoWorld(const WorldData& data) : data_(data), fingers_(static_cast<int>(data.fingers.size())) {
    const std::string model = model_of(data);
    mjVFS files;
    mj_defaultVFS(&files);
    mj_makeEmptyFileVFS(&files, "world.xml", static_cast<int>(model.size()));
    std::ranges::copy(model, static_cast<char*>(files.filedata[0]));
    std::array<char, 500> error{};
    model_ = mj_loadXML("world.xml", &files, error.data(), error.size());
    mj_deleteVFS(&files);
    if (model_ == nullptr) throw std::runtime_error(error.data());
    state_ = mj_makeData(model_);
    object_ = mj_name2id(model_, mjOBJ_BODY, "object");
  }
  MujocoWorld(const MujocoWorld&) = delete;
  MujocoWorld& operator=(const MujocoWorld&) = delete;
  ~MujocoWorld() override {
    mj_deleteData(state_);
    mj_deleteModel(model_);
  }

  void step(const Vector& force_N, const Vector& moment_Nm) override {
    for (int k = 0; k < fingers_; ++k) state_->qfrc_applied[k] = data_.fingers[k].force_N;
    for (int i = 0; i < 3; ++i) {
      state_->xfrc_applied[6 * object_ + i] = force_N[i];
      state_->xfrc_applied[6 * object_ + 3 + i] = moment_Nm[i];
    }
    mj_step(model_, state_);
  }

  [[nodiscard]] Reading read() const override {
    const double* p = state_->qpos + fingers_;
    const double* v = state_->qvel + fingers_;
    double kinetic = 0.0;
    for (int k = 0; k < fingers_; ++k) kinetic += 0.5 * data_.finger_mass_kg * state_->qvel[k] * state_->qvel[k];
    const Vector I = data_.inertia();
    for (int i = 0; i < 3; ++i) kinetic += 0.5 * (data_.mass_kg * v[i] * v[i] + I[i] * v[3 + i] * v[3 + i]);
    return {{p[0], p[1], p[2]}, {p[3], p[4], p[5], p[6]}, kinetic, 0.0, state_->ncon};
  }

  [[nodiscard]] double travel_m(std::size_t finger) const override { return state_->qpos[finger]; }

 private:
  WorldData data_;
  int fingers_, object_ = 0;
  mjModel* model_ = nullptr;
  mjData* state_ = nullptr;
};

}  // namespace

std::unique_ptr<World> make_world(const WorldData& data) { return std::make_unique<MujocoWorld>(data); }
std::string engine() { return std::string("MuJoCo ") + mj_versionString(); }

}  // namespace thenar::truth
