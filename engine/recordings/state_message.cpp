// SPDX-License-Identifier: Apache-2.0
#include "engine/recordings/state_message.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <span>

#include "engine/formats/build_info.h"
#include "engine/loops/live_input.h"
#include "engine/loops/shown_environment.h"
#include "engine/results/contact_fields.h"
#include "engine/results/tick_fields.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using nlohmann::ordered_json;

namespace {

static_assert(std::endian::native == std::endian::little, "messages are little-endian");

constexpr std::string_view kMagic = "THNR";
constexpr std::size_t kHeader = 8;
constexpr Index kMostObjectSamples = 40'000;

std::string header(MessageKind kind, std::uint16_t version = kMessageVersion) {
  std::string bytes(kMagic);
  for (const auto number : {version, static_cast<std::uint16_t>(kind)}) {
    bytes += {static_cast<char>(number & 0xFF), static_cast<char>(number >> 8)};
  }
  return bytes;
}

template <class Number>
void append(std::span<const Number> numbers, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes());
}

/// The poses of the hand's segments, one after the other.
std::vector<double> segment_poses(const Hand& hand, const JointVector& q) {
  HandPose pose;
  forward_kinematics(hand, q, pose);
  std::vector<double> numbers;
  for (const Isometry3d& X_WS : pose.segments) {
    const std::array<double, 12> of_one = pose_numbers(X_WS);
    numbers.insert(numbers.end(), of_one.begin(), of_one.end());
  }
  return numbers;
}

/// Calls sink(field, numbers) for each field of the scene, in order: what lies before the contacts of a state message.
template <class Sink>
void for_each_field(const Model& model, const Picture& picture, const TickRecord& tick, const Eigen::VectorXd& asked_N,
                    const LoopFigures& loops, Sink&& sink) {
  const Snapshot& now = picture.snapshot;
  std::optional<ShownStiffness> stiffness;
  if (model.scene.chooses_stiffness()) stiffness = shown_stiffness(model, now, tick.stiffness);
  std::optional<ShownEnvironment> environment;
  if (model.scene.environment) environment = shown_environment(model, picture);
  const TickView view{.model = model,
                      .tick = tick,
                      .number = now.tick,
                      .q = now.q,
                      .X_WO = now.X_WO,
                      .load = now.load,
                      .muscle_N = {now.pull_N.data(), static_cast<std::size_t>(now.pull_N.size())},
                      .asked_N = {asked_N.data(), static_cast<std::size_t>(asked_N.size())},
                      .stiffness = stiffness ? &*stiffness : nullptr,
                      .picture = &picture,
                      .environment = environment ? &*environment : nullptr,
                      .loops = &loops};
  std::vector<double> numbers;
  for (const TickField& field : tick_fields()) {
    if (!field.is_in(model)) continue;
    numbers.clear();
    add_numbers(field, view, numbers);
    sink(field, numbers);
  }
}

/// Points of a muscle's way across one joint, from its attachment towards the body.
struct Crossing {
  int segment[2];
  Vector3d point[2];
};

Crossing crossing_line(const MuscleCrossing& crossing) {
  Crossing line{{crossing.insertion_segment, crossing.pull_segment}, {crossing.insertion_m, crossing.pull}};
  if (crossing.pull_is_point) return line;
  // A direction alone: as far behind the joint, which is the segment's origin, as the attachment lies before it.
  const Vector3d pull = crossing.pull.normalized();
  line.segment[1] = crossing.insertion_segment;
  line.point[1] = crossing.insertion_m + 2.0 * std::abs(crossing.insertion_m.dot(pull)) * pull;
  return line;
}

ordered_json line_json(int from, const Vector3d& a, int to, const Vector3d& b) {
  return {from, a.x(), a.y(), a.z(), to, b.x(), b.y(), b.z()};
}

/// A muscle crosses the joints of a finger from the wrist on: where a crossing ends, the one before it goes on.
ordered_json muscle_lines(const Hand& hand, const Muscle& muscle) {
  ordered_json lines = ordered_json::array();
  std::optional<Crossing> last;
  for (const MuscleCrossing& crossing : muscle.crossings) {
    const Crossing line = crossing_line(crossing);
    lines.push_back(line_json(line.segment[0], line.point[0], line.segment[1], line.point[1]));
    const auto finger = [&](const Crossing& c) { return hand.segments[c.segment[0]].finger; };
    if (last && finger(*last) == finger(line)) {
      lines.push_back(line_json(line.segment[1], line.point[1], last->segment[0], last->point[0]));
    }
    last = line;
  }
  return lines;
}

ordered_json vector_json(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

ordered_json shape_json(const PulpShape& shape) {
  const bool is_capsule = shape.form == PulpShape::Form::kCapsule;
  ordered_json axes = ordered_json::array();
  for (int i = 0; i < 3; ++i) axes.push_back(vector_json(shape.axes.col(i)));
  return {{"form", is_capsule ? "capsule" : "ellipsoid"}, {"half_m", vector_json(shape.half_m)}, {"axes", axes}};
}

ordered_json fingers_json(const Hand& hand) {
  ordered_json json = ordered_json::array();
  for (const Fingertip& tip : hand.fingertips) {
    json.push_back({{"name", tip.finger},
                    {"segment", tip.segment},
                    {"centre_m", vector_json(tip.centre_m)},
                    {"radius_m", tip.radius_m}});
    if (tip.shape) json.back()["shape"] = shape_json(*tip.shape);
  }
  return json;
}

ordered_json bodies_json(const Environment& environment) {
  ordered_json json = ordered_json::array();
  for (const EnvironmentBody& body : environment.bodies) {
    const ShownSolid solid = shown_solid(body.shape);
    json.push_back({{"name", body.name}, {"shape", solid.shape}, {"size_m", solid.size_m}});
  }
  return json;
}

ordered_json segments_json(const Hand& hand) {
  ordered_json json = ordered_json::array();
  for (const Segment& segment : hand.segments) {
    json.push_back({{"name", segment.name},
                    {"finger", segment.finger},
                    {"length_m", segment.length_m},
                    {"joints", segment.joints}});
  }
  return json;
}

ordered_json fields_json(const std::vector<Field>& fields) {
  ordered_json json = ordered_json::array();
  for (const Field& field : fields) {
    json.push_back({{"name", field.name}, {"unit", field.unit}, {"begin", field.begin}, {"count", field.count}});
  }
  return json;
}

Index object_stride(const Model& model) { return 1 + (model.object.cloud().points_m.cols() - 1) / kMostObjectSamples; }

}  // namespace

std::vector<Field> state_fields(const Model& model) {
  std::vector<Field> fields;
  std::size_t begin = 0;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(std::ssize(model.scene.hand.muscles));
  for_each_field(model, Picture(model), TickRecord(model.scene.hand), none, LoopFigures{},
                 [&](const TickField& field, std::span<const double> numbers) {
                   fields.push_back({std::string(field.name), std::string(field.unit), begin, numbers.size()});
                   begin += numbers.size();
                 });
  return fields;
}

std::vector<Field> contact_fields(const Model& model) {
  std::vector<Field> fields;
  std::size_t begin = 0;
  for (const ContactField& field : contact_fields()) {
    if (!field.is_in(model)) continue;
    fields.push_back({std::string(field.name), std::string(field.unit), begin, field.count});
    begin += field.count;
  }
  return fields;
}

ordered_json scene_message(const Model& model, bool live, const TriangleMesh& surface) {
  const Scene& scene = model.scene;
  ordered_json fingers = fingers_json(scene.hand), muscles = ordered_json::array(), joints = ordered_json::array();
  for (const Joint& joint : scene.hand.joints) joints.push_back(joint.name);
  for (std::size_t k = 0; k < fingers.size(); ++k) {
    fingers[k]["samples"] = model.deformable() ? model.pulps[k].surface.points_m.cols() : 0;
    fingers[k]["controls"] = model.deformable() ? model.pulps[k].controls() : 0;
  }
  if (model.scene.has_muscles()) {
    for (const Muscle& muscle : scene.hand.muscles) {
      muscles.push_back(
          {{"name", muscle.name}, {"max_force_N", muscle.max_force_N}, {"lines", muscle_lines(scene.hand, muscle)}});
    }
  }
  const Index stride = object_stride(model);
  const auto samples = (model.object.cloud().points_m.cols() + stride - 1) / stride;
  ordered_json position_gain = nullptr, rotation_gain = nullptr;
  if (scene.control) {
    position_gain = scene.control->position.p;
    rotation_gain = scene.control->rotation.p;
  }
  ordered_json message = {{"type", "scene"},
                          {"version", kMessageVersion},
                          {"program", fmt::format("thenar {}", build_info::kVersion)},
                          {"name", scene.name},
                          {"live", live},
                          {"fields", fields_json(state_fields(model))},
                          {"contact_fields", fields_json(contact_fields(model))},
                          {"fingers", fingers},
                          {"segments", segments_json(scene.hand)},
                          {"joints", joints},
                          {"muscles", muscles},
                          // The support of the object's surface is 2.2 spacings.
                          {"object",
                           {{"samples", samples},
                            {"vertices", surface.vertices_m.cols()},
                            {"triangles", surface.triangles.cols()},
                            {"spacing_m", model.object.support_m() / 2.2 * std::sqrt(static_cast<double>(stride))},
                            {"mass_kg", scene.object.mass_kg},
                            {"centre_of_mass_m", vector_json(scene.object.centre_of_mass_m)}}},
                          {"start", pose_numbers(scene.object.X_WO)},
                          {"gravity_m_per_s2", vector_json(scene.gravity)},
                          {"step_s", scene.step_s},
                          {"control_period_s", scene.control_period_s},
                          {"duration_s", scene.duration_s},
                          {"position_gain_N_per_m", position_gain},
                          {"rotation_gain_Nm_per_rad", rotation_gain},
                          {"pull", {{"stiffness_N_per_m", kPullStiffness_N_per_m}, {"limit_N", kPullLimit_N}}}};
  if (scene.hand.slides) message["slides"] = true;
  if (scene.environment) message["bodies"] = bodies_json(*scene.environment);
  for (const Phase& phase : scene.task.phases) message["phases"].push_back(to_string(phase.kind));
  if (scene.has_muscles() && scene.control->muscles->short_range) message["object_stiffness"] = nullptr;
  if (scene.chooses_stiffness()) {
    const MuscleSettings& own = *scene.control->muscles;
    message["object_stiffness"] = {{"centre_m", vector_json(own.object_stiffness->centre_m)},
                                   {"frozen_from_s", own.frozen_from_s ? ordered_json(*own.frozen_from_s) : nullptr}};
  }
  return message;
}

ordered_json posture_json(const Hand& hand, const JointVector& q) {
  return {{"fingers", fingers_json(hand)}, {"segments", segments_json(hand)}, {"poses", segment_poses(hand, q)}};
}

std::string geometry_message(const Model& model, const TriangleMesh& surface) {
  std::string bytes = header(MessageKind::kGeometry);
  const auto add = [&bytes](const auto& numbers) {
    const Eigen::Matrix3Xf floats = numbers.template cast<float>();
    append(std::span<const float>(floats.data(), static_cast<std::size_t>(floats.size())), bytes);
  };
  const PointCloud& cloud = model.object.cloud();
  const auto shown = Eigen::seq(0, Eigen::last, object_stride(model));
  add(cloud.points_m(Eigen::all, shown));
  add(cloud.normals(Eigen::all, shown));
  for (const Pulp& pulp : model.pulps) {
    add(pulp.surface.points_m);
    add(pulp.surface.normals);
    add(pulp.control_points_m);
    const Eigen::VectorXf areas = pulp.area_m2.cast<float>();
    append(std::span<const float>(areas.data(), static_cast<std::size_t>(areas.size())), bytes);
  }
  add(surface.vertices_m);
  const Eigen::Matrix<std::uint32_t, 3, Eigen::Dynamic> triangles = surface.triangles.cast<std::uint32_t>();
  append(std::span<const std::uint32_t>(triangles.data(), static_cast<std::size_t>(triangles.size())), bytes);
  return bytes;
}

void write_state_message(const Model& model, const Picture& picture, const TickRecord& tick,
                         const Eigen::VectorXd& muscle_forces_N, const LoopFigures& loops, std::string& bytes) {
  bytes = header(MessageKind::kState);
  for_each_field(model, picture, tick, muscle_forces_N, loops,
                 [&bytes](const TickField&, std::span<const double> numbers) { append(numbers, bytes); });
  for (const ShownContact& contact : picture.contacts) {
    for (const ContactField& field : contact_fields()) {
      if (!field.is_in(model)) continue;
      for (std::size_t i = 0; i < field.count; ++i) {
        const double number = number_of(field, contact, i);
        append(std::span(&number, 1), bytes);
      }
    }
  }
}

std::vector<double> read_state_message(std::string_view bytes) {
  const auto is_of = [&](std::uint16_t version) { return bytes.starts_with(header(MessageKind::kState, version)); };
  bool is_known = false;
  for (auto version = kOldestMessageVersion; version <= kMessageVersion; ++version) {
    is_known = is_known || is_of(version);
  }
  if (!is_known) return {};
  if ((bytes.size() - kHeader) % sizeof(double) != 0) return {};
  std::vector<double> numbers((bytes.size() - kHeader) / sizeof(double));
  std::ranges::copy(bytes.substr(kHeader), reinterpret_cast<char*>(numbers.data()));
  return numbers;
}

}  // namespace thenar
