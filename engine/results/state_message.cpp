#include "engine/results/state_message.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>
#include <span>

#include "engine/formats/build_info.h"
#include "engine/loops/live_input.h"
#include "engine/loops/shown_environment.h"

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

/// 0 is a stage that did not run.
double us_or_unknown(double time_s) { return time_s > 0.0 ? 1e6 * time_s : kUnknown; }

/// Everything of a state message before its contacts, in order: calls field(name, unit, numbers) for each part. The
/// list of fields and the numbers themselves both come from here.
template <class Sink>
void for_each_field(const Model& model, const Picture& picture, const TickRecord& tick,
                    const Eigen::VectorXd& muscle_forces_N, const LoopFigures& loops, Sink&& field) {
  const Snapshot& now = picture.snapshot;
  const auto one = [&](const char* name, const char* unit, double number) { field(name, unit, std::span(&number, 1)); };
  const auto vector = [&](const char* name, const char* unit, const auto& v) {
    field(name, unit, std::span<const double>(v.data(), static_cast<std::size_t>(v.size())));
  };
  const auto of_fingers = [&](const char* name, const char* unit, auto get) {
    PerFinger<double> numbers(model.fingers());
    for (int k = 0; k < model.fingers(); ++k) numbers[k] = get(k);
    vector(name, unit, numbers);
  };
  const auto columns = [&](const char* name, const char* unit, auto get) {
    FingerForces all(3, model.fingers());
    for (int k = 0; k < model.fingers(); ++k) all.col(k) = get(k);
    vector(name, unit, all);
  };

  one("time_s", "s", tick.time_s);
  one("tick", "", static_cast<double>(now.tick));
  one("frame", "", static_cast<double>(tick.contact.sequence));
  one("held", "", tick.contact.held ? 1.0 : 0.0);
  vector("object", "m", pose_numbers(now.X_WO));
  vector("target", "m", pose_numbers(tick.X_WT));
  vector(model.scene.hand.slides ? "q_m" : "q_rad", model.scene.hand.slides ? "m" : "rad", now.q);
  vector(model.scene.hand.slides ? "stop_N" : "stop_Nm", model.scene.hand.slides ? "N" : "N m", tick.contact.stop_Nm);
  vector("segments", "m", segment_poses(model.scene.hand, now.q));
  columns("force_N", "N", [&](int k) { return now.load[k].force_N; });
  columns("desired_N", "N", [&](int k) { return tick.desired_N[k]; });
  columns("centre_m", "m", [&](int k) { return now.load[k].centre_m; });
  columns("normal", "", [&](int k) { return now.load[k].normal; });
  of_fingers("normal_N", "N", [&](int k) { return tick.force[k].normal_N; });
  of_fingers("tangential_N", "N", [&](int k) { return tick.force[k].tangential_N; });
  of_fingers("desired_normal_N", "N", [&](int k) { return tick.force_desired[k].normal_N; });
  of_fingers("desired_tangential_N", "N", [&](int k) { return tick.force_desired[k].tangential_N; });
  vector("margin", "", tick.margin);
  vector("slip_m", "m", tick.slip_m);
  vector("start_slip_m", "m", tick.start_slip_m);
  vector("spin_rad", "rad", tick.spin_rad);
  vector("start_spin_rad", "rad", tick.start_spin_rad);
  vector("sliding_share", "", tick.sliding_share);
  vector("creep_m_per_s", "m/s", tick.creep_m_per_s);
  if (model.feels()) {
    of_fingers("stick", "", [&](int k) { return tick.touch[k].stick; });
    of_fingers("rim_friction", "", [&](int k) { return tick.touch[k].friction; });
    of_fingers("slip_speed_m_per_s", "m/s", [&](int k) { return tick.touch[k].slip_m_per_s; });
    of_fingers("torsion_Nm", "N m", [&](int k) { return tick.touch[k].moment_Nm; });
  }
  if (model.feels() && model.scene.control) {
    of_fingers("friction_felt", "", [&](int k) { return tick.reflex.friction[k]; });
    of_fingers("squeeze_N", "N", [&](int k) { return tick.reflex.grips[k].internal_force_N; });
    one("reflex", "", static_cast<double>(tick.reflex.event));
    const LastReflex& last = tick.last_reflex;
    const bool none = last.event == ReflexEvent::kNone;
    one("last_reflex", "", static_cast<double>(last.event));
    one("last_reflex_finger", "", none ? kUnknown : last.finger);
    one("last_reflex_s", "s", none ? kUnknown : last.time_s);
  }
  if (model.scene.chooses_stiffness()) {
    const ObjectStiffness& asked = *model.scene.control->muscles->object_stiffness;
    const ShownStiffness shown = shown_stiffness(model, now, tick.stiffness);
    vector("asked_N_per_m", "N/m", asked.translation_N_per_m);
    vector("asked_Nm_per_rad", "N m/rad", asked.rotation_Nm_per_rad);
    one("stiffness_share", "", shown.share);
    one("stiffness_squeeze_N", "N", shown.squeeze_N);
    vector("stiffness_N_per_m", "N/m", shown.along_N_per_m);
    vector("stiffness_Nm_per_rad", "N m/rad", shown.about_Nm_per_rad);
    one("lack_s", "s", shown.lack_s);
    one("lack_N_per_m", "N/m", shown.lack_N_per_m);
    one("lack_Nm_per_rad", "N m/rad", shown.lack_Nm_per_rad);
    vector("lack_axis", "", shown.lack_axis);
    vector("lack_muscles", "", shown.at_limit);
    vector("least_muscles_N", "N", shown.least_N);
  }
  if (model.scene.environment) {
    const ShownEnvironment around = shown_environment(model, picture);
    std::vector<double> poses;
    for (const Isometry3d& X_WE : around.X_WE) std::ranges::copy(pose_numbers(X_WE), std::back_inserter(poses));
    vector("bodies", "m", poses);
    vector("bodies_N", "N", around.force_N);
    vector("bodies_m", "m", around.mean_m);
    vector("touches_m", "m", around.point_m);
    vector("touches_N", "N", around.touch_N);
    vector("touches_margin", "", around.margin);
  }
  if (!model.scene.task.phases.empty()) {
    one("phase", "", tick.phase);
    one("borne_N", "N", tick.borne_N);
    vector("arm_m", "m", tick.arm_m);
  }
  one("friction", "", model.friction(tick.time_s));
  vector("position_m", "m", tick.position_m);
  vector("path_target_m", "m", tick.target_m);
  one("rotation_error_rad", "rad", tick.rotation_error_rad);
  const Eigen::VectorXd asked_N = model.scene.has_muscles() ? muscle_forces_N : Eigen::VectorXd();
  vector("muscles_N", "N", now.muscle_N.size() > 0 ? Eigen::VectorXd(now.muscle_N) : asked_N);
  const Vector3d unknown = Vector3d::Constant(kUnknown);
  const ShownPull pull = picture.pull.value_or(ShownPull{unknown, unknown, unknown});
  vector("pull_anchor_m", "m", pull.anchor_m);
  vector("pull_handle_m", "m", pull.handle_m);
  vector("pull_force_N", "N", pull.force_N);
  one("contacts", "", static_cast<double>(tick.contact.contacts));
  one("active", "", static_cast<double>(tick.contact.active));
  one("sweeps", "", tick.contact.solve.sweeps);
  one("residual", "", tick.contact.solve.residual);
  one("penetration_m", "m", tick.contact.penetration_m);
  if (model.scene.environment) {
    const EnvironmentReport& environment = tick.contact.environment;
    vector("environment_force_N", "N", Vector3d(environment.wrench.head<3>()));
    vector("environment_moment_Nm", "N m", Vector3d(environment.wrench.tail<3>()));
    one("environment_normal_N", "N", environment.normal_N);
    one("environment_contacts", "", environment.contacts);
    one("environment_active", "", environment.active);
    one("environment_penetration_m", "m", environment.penetration_m);
  }
  one("frame_age_s", "s", static_cast<double>(tick.contact.frame_age) * model.scene.step_s);
  one("grasp_failed", "", tick.grasp == GraspStatus::kOptimal ? 0.0 : 1.0);
  one("muscles_failed", "", tick.muscle == MuscleStatus::kOptimal ? 0.0 : 1.0);
  one("find_us", "us", us_or_unknown(tick.find_s));
  one("factors_us", "us", us_or_unknown(tick.factors_s));
  one("grasp_us", "us", us_or_unknown(tick.grasp_s));
  one("muscle_us", "us", us_or_unknown(tick.muscle_s));
  one("assemble_us", "us", us_or_unknown(tick.contact.assemble_s));
  one("solve_us", "us", us_or_unknown(tick.contact.solve_s));
  one("deform_us", "us", us_or_unknown(tick.contact.deform_s));
  one("contact_Hz", "Hz", loops.contact_Hz);
  vector("contact_compute_us", "us", loops.contact_compute_us);
  vector("contact_jitter_us", "us", loops.contact_jitter_us);
  one("contact_overruns", "", loops.contact_overruns);
  one("contact_slipped", "", loops.contact_slipped);
  one("control_Hz", "Hz", loops.control_Hz);
  vector("control_compute_us", "us", loops.control_compute_us);
  vector("control_jitter_us", "us", loops.control_jitter_us);
  one("control_slipped", "", loops.control_slipped);
  one("realtime_factor", "", loops.realtime_factor);
  one("drive_J", "J", tick.ledger.drive_J);
  one("viscous_J", "J", tick.ledger.viscous_J);
  one("deformation_J", "J", tick.ledger.deformation_J);
  one("stored_J", "J", tick.ledger.stored_J);
  one("injected_J", "J", tick.ledger.injected_J);
  one("dissipated_J", "J", tick.ledger.dissipated_J);
  one("dropped_J", "J", tick.ledger.dropped_J);
  one("unaccounted", "", loops.unaccounted);
  one("lost_records", "", loops.lost_records);
  one("reference_error", "", loops.reference_error);
  one("reference_residual", "", loops.reference_residual);
  vector("latency_us", "us", loops.latency_us);
  vector("latency_counts", "", loops.latency_counts);
  std::vector<double> displacement;
  for (const Eigen::MatrixX3d& u_m : picture.u_m) {
    for (Index i = 0; i < u_m.rows(); ++i) {
      for (int axis = 0; axis < 3; ++axis) displacement.push_back(u_m(i, axis));
    }
  }
  vector("displacement_m", "m", displacement);
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
                 [&](const char* name, const char* unit, std::span<const double> numbers) {
                   fields.push_back({name, unit, begin, numbers.size()});
                   begin += numbers.size();
                 });
  return fields;
}

std::vector<Field> contact_fields(const Model& model) {
  std::vector<Field> fields = {{"finger", "", 0, 1},
                               {"control_point", "", 1, 1},
                               {"point_m", "m", 2, 3},
                               {"normal", "", 5, 3},
                               {"force_N", "N", 8, 3}};
  const auto add = [&](const char* name, const char* unit) {
    fields.push_back({name, unit, fields.back().begin + fields.back().count, 1});
  };
  if (model.deformable()) {
    add("normal_N", "N");
    add("friction_N", "N");
    add("share", "");
  }
  if (model.feels()) add("slip_m_per_s", "m/s");
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

std::array<double, 12> pose_numbers(const Isometry3d& X) {
  std::array<double, 12> numbers{};
  Eigen::Map<Vector3d> position(numbers.data());
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rotation(numbers.data() + 3);
  position = X.translation();
  rotation = X.linear();
  return numbers;
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
                 [&bytes](const char*, const char*, std::span<const double> numbers) { append(numbers, bytes); });
  for (const ShownContact& contact : picture.contacts) {
    Eigen::Vector<double, 15> row;
    std::size_t count = 11;
    row.head<11>() << static_cast<double>(contact.finger), static_cast<double>(contact.control_point), contact.point_m,
        contact.normal, contact.force_N;
    if (model.deformable()) {
      for (const double number : {contact.normal_N, contact.friction_N, contact.share}) row[count++] = number;
    }
    if (model.feels()) row[count++] = contact.slip_m / model.scene.step_s;
    append(std::span<const double>(row.data(), count), bytes);
  }
}

std::vector<double> read_state_message(std::string_view bytes) {
  const auto is_of = [&](std::uint16_t version) { return bytes.starts_with(header(MessageKind::kState, version)); };
  if (!is_of(kMessageVersion) && !is_of(kOldestMessageVersion)) return {};
  if ((bytes.size() - kHeader) % sizeof(double) != 0) return {};
  std::vector<double> numbers((bytes.size() - kHeader) / sizeof(double));
  std::memcpy(numbers.data(), bytes.data() + kHeader, numbers.size() * sizeof(double));
  return numbers;
}

}  // namespace thenar
