#include "engine/scenes/scene_file.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "engine/formats/point_cloud_file.h"
#include "engine/scenes/config.h"
#include "engine/scenes/hand_file.h"
#include "engine/scenes/units.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// What a file may ask memory for. A step is within the rates that loops may have, 1 Hz to 100 kHz; contact forces are
// kept for a few control periods, and a frame for each one that lies within the delay.
constexpr double kMaxSteps = 1e7, kShortestStep_s = 1e-5, kLongestStep_s = 1.0;
constexpr double kMaxStepsAPeriod = 1e4, kMaxPeriodsLate = 100.0;
constexpr double kRounding = 1e-9;                       // Of a ratio of two times.
constexpr double kSmallest_m = 1e-4, kLargest_m = 10.0;  // Of a shape: what a hand may meet, with room.
constexpr double kStiffest_per_N = 10.0;                 // Of stiffening: a human fingertip has about 0.5.
constexpr double kSoftest_Pa = 1e3;
constexpr Index kMaxPoints = 1'000'000;  // An object's surface takes 430 bytes for each.
constexpr Index kMaxLeaves = 4000;       // A pulp's kernel takes 24 bytes for each pair: 400 MB.
constexpr Index kMaxContactsPerFinger = 1000;

void read_time(const ConfigMap& time, Scene& scene) {
  scene.duration_s = time.positive("duration", Dimension::kTime);
  scene.step_s = time.positive("step", Dimension::kTime);
  scene.control_period_s = time.positive("control_period", Dimension::kTime);
  scene.control_delay_s = time.non_negative_or("control_delay", Dimension::kTime, 0.0);
  if (scene.step_s < kShortestStep_s || scene.step_s > kLongestStep_s)
    time.refuse("step", "must lie within 10 us .. 1 s");
  if (scene.duration_s / scene.step_s > kMaxSteps) time.refuse("step", "makes more than 10 million steps");
  if (!time.is_refused("step")) {
    const double steps = scene.control_period_s / scene.step_s;
    if (steps < 1.0 - kRounding) time.refuse("control_period", "must not be shorter than time.step");
    if (steps > kMaxStepsAPeriod * (1.0 + kRounding)) {
      time.refuse("control_period", "must not be longer than 10000 times time.step");
    }
  }
  if (!time.is_refused("control_period") &&
      scene.control_delay_s > kMaxPeriodsLate * (1.0 + kRounding) * scene.control_period_s) {
    time.refuse("control_delay", "must not be longer than 100 times time.control_period");
  }
}

void read_posture(const ConfigMap& map, Scene& scene) {
  scene.posture = map.quantities("posture", Dimension::kAngle, kJoints);
  if (scene.hand.segments.empty()) return;  // no hand was read, and that is reported
  for (int i = 0; i < kJoints; ++i) {
    const Joint& joint = scene.hand.joints[i];
    if (scene.posture[i] >= joint.lower_rad && scene.posture[i] <= joint.upper_rad) continue;
    map.refuse("posture", "value " + std::to_string(i + 1) + " (" + joint.name + ") must lie within " +
                              std::to_string(joint.lower_rad) + " .. " + std::to_string(joint.upper_rad) + " rad");
  }
}

void read_hand(const ConfigMap& map, bool controlled, Scene& scene) {
  const std::filesystem::path model = map.path("model");
  if (!model.empty()) scene.hand = load_hand(model);
  read_posture(map, scene);
  scene.joint_viscosity = map.positive("joint_viscosity", Dimension::kRotationalDamping);
  if (!controlled) scene.torques = map.quantities("torques", Dimension::kTorque, kJoints);
}

FingertipSettings read_fingertips(const ConfigMap& map) {
  FingertipSettings tips;
  tips.points = map.count("points", 1, kMaxPoints);
  tips.leaves = map.count("leaves", 1, kMaxLeaves);
  if (tips.leaves > tips.points) map.refuse("leaves", "must not exceed fingertips.points");
  tips.material.reduced_modulus_Pa = map.positive("reduced_modulus", Dimension::kPressure);
  tips.material.poisson = map.number("poisson", 0.0, 0.5);
  tips.material.relaxation_s = map.non_negative("relaxation", Dimension::kTime);
  if (map.choice_or("kernel", {"boussinesq", "gaussian"}, "boussinesq") == "gaussian") {
    tips.material.kernel = PulpKernel::kGaussian;
  }
  if (map.has("stiffening")) {
    tips.material.stiffening_per_N = map.non_negative("stiffening", Dimension::kPerForce);
    if (tips.material.stiffening_per_N > kStiffest_per_N) map.refuse("stiffening", "must not exceed 10 1/N");
  }
  return tips;
}

/// A length of a shape.
double read_length(const ConfigMap& map, std::string_view key) {
  const double length_m = map.positive(key, Dimension::kLength);
  if (length_m < kSmallest_m || length_m > kLargest_m) map.refuse(key, "must measure 0.1 mm to 10 m");
  return length_m;
}

/// The full sizes of a shape along its axes.
Vector3d read_size(const ConfigMap& map, std::string_view key) {
  const Vector3d size_m = map.positive3(key, Dimension::kLength);
  if (size_m.minCoeff() < kSmallest_m || size_m.maxCoeff() > kLargest_m) map.refuse(key, "must measure 0.1 mm to 10 m");
  return size_m;
}

CylinderShape read_cylinder(const ConfigMap& map) { return {read_length(map, "radius"), read_length(map, "length")}; }

SuperquadricShape read_superquadric(const ConfigMap& map) {
  const Vector3d size_m = read_size(map, "size");
  const Eigen::VectorXd exponents = map.numbers("exponents", 2);
  if (exponents.minCoeff() < kLeastExponent || exponents.maxCoeff() > kLargestExponent) {
    map.refuse("exponents", "must lie within 0.1 .. 2");
  }
  return {size_m, {exponents[0], exponents[1]}};
}

Mug read_mug(const ConfigMap& map) {
  Mug mug{read_length(map, "radius"), read_length(map, "height"), read_length(map, "wall"), std::nullopt};
  if (mug.wall_m >= std::min(mug.radius_m, mug.height_m)) map.refuse("wall", "must be less than radius and height");
  if (!map.has("handle")) return mug;
  const ConfigMap handle = map.map("handle");
  mug.handle = MugHandle{read_length(handle, "radius"), read_length(handle, "thickness")};
  if (!mug.handle_fits() && !handle.is_refused("radius") && !handle.is_refused("thickness")) {
    map.refuse("handle",
               "thickness must be less than twice its radius, and both together fit the mug: "
               "radius + thickness/2 less than the mug's radius and half its height");
  }
  return mug;
}

/// What 1 in a file measures: the name of a unit or, as "25.4 mm", a length.
double read_unit(const ConfigMap& map) {
  const std::string name = map.has("unit") ? map.text("unit") : "";
  const Quantity unit = read_quantity("1 " + name, Dimension::kLength);
  return unit.fault.empty() ? unit.value : map.positive_or("unit", Dimension::kLength, 1.0);
}

/// `cloud: scan.ply`, or `cloud: {file: scan.ply, unit: mm}`.
CloudShape read_cloud(const ConfigMap& map) {
  if (!map.is_map("cloud")) return {map.path("cloud")};  // in metres
  const ConfigMap cloud = map.map("cloud");
  return {cloud.path("file"), read_unit(cloud)};
}

Shape read_shape(const ConfigMap& map) {
  const std::string kind = map.one_of({"box", "sphere", "ellipsoid", "cylinder", "superquadric", "mug", "cloud"});
  if (kind == "box") return BoxShape{read_size(map, kind)};
  if (kind == "sphere") return SphereShape{read_length(map, kind)};
  if (kind == "ellipsoid") return EllipsoidShape{read_size(map, kind)};
  if (kind == "cylinder") return read_cylinder(map.map(kind));
  if (kind == "superquadric") return read_superquadric(map.map(kind));
  if (kind == "mug") return read_mug(map.map(kind));
  return kind.empty() ? CloudShape{} : read_cloud(map);
}

/// The box around a shape, in its frame; nothing for one from a file.
struct BoundShape {
  static Eigen::AlignedBox3d around(const Vector3d& size_m) { return {-0.5 * size_m, 0.5 * size_m}; }
  Eigen::AlignedBox3d operator()(const BoxShape& box) const { return around(box.size_m); }
  Eigen::AlignedBox3d operator()(const SphereShape& sphere) const {
    return around(Vector3d::Constant(2.0 * sphere.radius_m));
  }
  Eigen::AlignedBox3d operator()(const EllipsoidShape& ellipsoid) const { return around(ellipsoid.size_m); }
  Eigen::AlignedBox3d operator()(const CylinderShape& cylinder) const {
    return around({2.0 * cylinder.radius_m, 2.0 * cylinder.radius_m, cylinder.length_m});
  }
  Eigen::AlignedBox3d operator()(const SuperquadricShape& shape) const { return around(shape.size_m); }
  Eigen::AlignedBox3d operator()(const Mug& mug) const {
    Eigen::AlignedBox3d box = around({2.0 * mug.radius_m, 2.0 * mug.radius_m, mug.height_m});
    if (mug.handle) box.max().x() += mug.handle->radius_m + 0.5 * mug.handle->thickness_m;
    return box;
  }
  Eigen::AlignedBox3d operator()(const CloudShape& /*scan*/) const { return {}; }
};

/// Refuses a point of the object that does not lie in the box around it. Of a shape from a file the model knows.
void check_is_in_object(const ConfigMap& map, std::string_view key, const Vector3d& point_m, const Shape& shape) {
  constexpr double kRounding_m = 1e-9;
  const Eigen::AlignedBox3d box = std::visit(BoundShape{}, shape);
  if (box.isEmpty() || box.exteriorDistance(point_m) <= kRounding_m) return;
  map.refuse(key, "must lie within the object: " + in_words(box) + " in its frame");
}

/// Where the weight of a solid acts that is equally dense throughout. Whether a surface from a file is one's is not
/// known: its origin.
Vector3d solid_centroid_m(const Shape& shape) {
  const auto* const mug = std::get_if<Mug>(&shape);
  return mug != nullptr ? centroid_m(*mug) : Vector3d::Zero();
}

PulpMaterial read_compliance(const ConfigMap& map) {
  const double modulus_Pa = map.positive("reduced_modulus", Dimension::kPressure);
  if (modulus_Pa < kSoftest_Pa) map.refuse("reduced_modulus", "must be 1 kPa at least");
  return {modulus_Pa, map.number("poisson", 0.0, 0.5), map.non_negative("relaxation", Dimension::kTime)};
}

ObjectSettings read_object(const ConfigMap& map, bool deformable_fingers) {
  ObjectSettings object;
  object.shape = read_shape(map.map("shape"));
  const auto* const scan = std::get_if<CloudShape>(&object.shape);
  if (scan == nullptr || is_mesh_file(scan->file)) {
    object.points = map.count("points", 10, kMaxPoints);
  } else if (map.has("points") && !scan->file.empty()) {
    map.refuse("points", "a point cloud brings its own points: leave this out");
  }
  object.mass_kg = map.positive("mass", Dimension::kMass);
  object.centre_of_mass_m = map.vector3_or("centre_of_mass", Dimension::kLength, solid_centroid_m(object.shape));
  if (map.has("centre_of_mass")) check_is_in_object(map, "centre_of_mass", object.centre_of_mass_m, object.shape);
  object.X_WO.setIdentity();
  object.X_WO.translation() = map.vector3("position", Dimension::kLength);
  object.X_WO.linear() = map.rotation3("rotation");
  const ConfigMap damping = map.map("damping");
  object.translation_damping = damping.positive("translation", Dimension::kDamping);
  object.rotation_damping = damping.positive("rotation", Dimension::kRotationalDamping);
  if (map.has("compliance")) {
    object.compliance = read_compliance(map.map("compliance"));
    // A point's force would press it in without end.
    if (!deformable_fingers) map.refuse("compliance", "needs fingertips: rigid ones touch at a point each");
  }
  return object;
}

/// leaves: 0; auto: nothing.
std::optional<int> read_level(const ConfigMap& map) {
  const std::string level = map.choice("level", {"leaves", "1", "2", "3", "4", "5", "6", "7", "8", "auto"});
  if (level == "auto") return std::nullopt;
  return level.empty() || level == "leaves" ? 0 : std::stoi(level);
}

ContactSettings read_contact(const ConfigMap& map, const std::optional<FingertipSettings>& fingertips) {
  const bool deformable = fingertips.has_value();
  ContactSettings contact;
  contact.friction = map.number("friction", 0.0, 10.0);
  contact.band_m = map.positive("band", Dimension::kLength);
  contact.max_per_finger = deformable ? map.count("max_per_finger", 1, kMaxContactsPerFinger) : 1;
  if (deformable && map.has("level")) contact.level = read_level(map);
  if (const int level = contact.level.value_or(0); level > 0 && (Index{1} << level) > fingertips->leaves) {
    map.refuse("level", "needs fingertips of " + std::to_string(1 << level) + " leaves or more");
  }
  if (!contact.level) {
    contact.force_error = map.non_negative_or("force_error", Dimension::kShare, contact.force_error);
  } else if (map.has("force_error")) {
    map.refuse("force_error", "counts with contact.level: auto alone");
  }
  contact.tolerance = map.number_or("tolerance", 1e-14, 1.0, 1e-7);
  contact.max_sweeps = static_cast<int>(map.count_or("max_sweeps", 1, 1'000'000, 200));
  return contact;
}

PidGains read_gains(const ConfigMap& map, Dimension p, Dimension i, Dimension d) {
  return {map.non_negative("p", p), map.non_negative_or("i", i, 0.0), map.non_negative_or("d", d, 0.0)};
}

ControlSettings read_control(const ConfigMap& map) {
  ControlSettings control;
  control.law = map.choice("law", {"feedforward", "paper"}) == "paper" ? ControlLaw::kPaper : ControlLaw::kFeedforward;
  control.gain = map.positive_or_auto("gain", Dimension::kRotationalStiffness);
  const ConfigMap pulp = map.map("pulp");
  control.pulp_normal_N_per_m = pulp.positive("normal", Dimension::kStiffness);
  control.pulp_tangential_N_per_m = pulp.positive("tangential", Dimension::kStiffness);
  const ConfigMap grasp = map.map("grasp");
  control.grasp_friction = grasp.number("friction", 0.0, 10.0);
  control.internal_force_N = grasp.non_negative("internal_force", Dimension::kForce);
  const bool exact = grasp.choice_or("cone", {"pyramid", "exact"}, "exact") == "exact";
  control.cone = exact ? FrictionCone::kExact : FrictionCone::kPyramid;
  control.position =
      read_gains(map.map("position"), Dimension::kStiffness, Dimension::kIntegralGain, Dimension::kDamping);
  control.rotation = read_gains(map.map("rotation"), Dimension::kRotationalStiffness,
                                Dimension::kRotationalIntegralGain, Dimension::kRotationalDamping);
  if (map.has("posture")) control.posture_Nm_per_rad = map.positive("posture", Dimension::kRotationalStiffness);
  control.muscles = map.flag("muscles");
  return control;
}

void read_interval(const ConfigMap& map, double& from_s, double& over_s) {
  from_s = map.non_negative("from", Dimension::kTime);
  over_s = map.positive("over", Dimension::kTime);
}

Move read_translation(const ConfigMap& map) {
  Move move;
  const Vector3d by = map.vector3("by", Dimension::kLength);
  move.amount = by.norm();
  if (move.amount > 0.0) move.axis = by / move.amount;
  read_interval(map, move.from_s, move.over_s);
  return move;
}

Move read_rotation_move(const ConfigMap& map) {
  Move move;
  move.amount = map.quantity("by", Dimension::kAngle);
  const Vector3d about = map.numbers3("about");
  if (about.squaredNorm() <= 0.0) map.refuse("about", "an axis must not be zero");
  move.axis = about.stableNormalized();
  read_interval(map, move.from_s, move.over_s);
  return move;
}

Push read_push(const ConfigMap& map, const Shape& shape) {
  Push push;
  // One of the two is asked for: the force, unless there is a moment.
  if (map.has("force") || !map.has("moment")) push.force_N = map.vector3("force", Dimension::kForce);
  if (map.has("at")) {
    push.at_m = map.vector3("at", Dimension::kLength);
    check_is_in_object(map, "at", push.at_m, shape);
    if (!map.has("force")) map.refuse("at", "is where a force acts, and there is none: name it, or leave this out");
  }
  if (map.has("moment")) push.moment_Nm = map.vector3("moment", Dimension::kTorque);
  read_interval(map, push.from_s, push.over_s);
  return push;
}

TaskSettings read_task(const ConfigMap& map, const Shape& shape) {
  TaskSettings task;
  if (map.has("translate")) task.translate = read_translation(map.map("translate"));
  if (map.has("rotate")) task.rotate = read_rotation_move(map.map("rotate"));
  if (map.has("spring")) {
    const ConfigMap spring = map.map("spring");
    task.spring = Spring{spring.positive("translation", Dimension::kStiffness),
                         spring.positive("rotation", Dimension::kRotationalStiffness)};
  }
  if (map.has("push")) task.push = read_push(map.map("push"), shape);
  return task;
}

Tolerance read_tolerance(const ConfigMap& map) {
  Tolerance tolerance;
  tolerance.position_m = map.non_negative_or("position", Dimension::kLength, tolerance.position_m);
  tolerance.rotation_rad = map.non_negative_or("rotation", Dimension::kAngle, tolerance.rotation_rad);
  tolerance.force = map.non_negative_or("force", Dimension::kShare, tolerance.force);
  tolerance.moment = map.non_negative_or("moment", Dimension::kShare, tolerance.moment);
  tolerance.margin = map.number_or("margin", 0.0, 1.0, tolerance.margin);
  return tolerance;
}

}  // namespace

std::string in_words(const Tolerance& tolerance) {
  return fmt::format("{{position: {:.3g} mm, rotation: {:.3g} deg, force: {:.3g} %, moment: {:.3g} %, margin: {:.3g}}}",
                     1e3 * tolerance.position_m, tolerance.rotation_rad * 180.0 / std::numbers::pi,
                     100.0 * tolerance.force, 100.0 * tolerance.moment, tolerance.margin);
}

std::string in_words(const Eigen::AlignedBox3d& box) {
  const Vector3d low_mm = 1e3 * box.min(), high_mm = 1e3 * box.max();
  return fmt::format("{:.4g} .. {:.4g}, {:.4g} .. {:.4g}, {:.4g} .. {:.4g} mm", low_mm.x(), high_mm.x(), low_mm.y(),
                     high_mm.y(), low_mm.z(), high_mm.z());
}

Scene load_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  Config config(file, overrides);
  const ConfigMap root = config.root();
  Scene scene;
  scene.name = root.text("name");
  read_time(root.map("time"), scene);
  scene.gravity = root.vector3_or("gravity", Dimension::kAcceleration, Vector3d::Zero());
  read_hand(root.map("hand"), root.has("control"), scene);
  if (root.has("fingertips")) scene.fingertips = read_fingertips(root.map("fingertips"));
  scene.object = read_object(root.map("object"), scene.fingertips.has_value());
  scene.contact = read_contact(root.map("contact"), scene.fingertips);
  if (root.has("control")) scene.control = read_control(root.map("control"));
  if (root.has("task")) scene.task = read_task(root.map("task"), scene.object.shape);
  if (root.has("model")) scene.only_needed = root.choice("model", {"full", "auto"}) == "auto";
  if (root.has("tolerance")) scene.tolerance = read_tolerance(root.map("tolerance"));
  config.finish();
  scene.defaults_used = config.defaults_used();
  if (scene.only_needed && !root.has("tolerance")) {
    scene.defaults_used.push_back("tolerance: " + in_words(scene.tolerance));
  }
  return scene;
}

std::vector<std::filesystem::path> scene_files(const std::filesystem::path& scene,
                                               const std::vector<std::string>& overrides) {
  std::vector<std::filesystem::path> files{scene};
  const auto add = [&files](const std::filesystem::path& file) {
    if (!file.empty()) files.push_back(file);
  };
  const Config config(scene, overrides);
  const ConfigMap root = config.root();
  if (root.is_map("hand")) add(root.map("hand").path("model"));
  if (!root.is_map("object") || !root.map("object").is_map("shape")) return files;
  const ConfigMap shape = root.map("object").map("shape");
  if (shape.has("cloud")) add(shape.is_map("cloud") ? shape.map("cloud").path("file") : shape.path("cloud"));
  return files;
}

}  // namespace thenar
