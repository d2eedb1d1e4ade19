#include "engine/scenes/scene_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <system_error>

#include "engine/finder/hand_body.h"
#include "engine/formats/files.h"
#include "engine/formats/point_cloud_file.h"
#include "engine/formats/text.h"
#include "engine/scenes/config.h"
#include "engine/scenes/drive_file.h"
#include "engine/scenes/hand_file.h"
#include "engine/scenes/keys.h"
#include "engine/scenes/object_bounds.h"
#include "engine/scenes/scene_control.h"
#include "engine/scenes/scene_environment.h"
#include "engine/scenes/scene_slides.h"
#include "engine/scenes/scene_task.h"
#include "engine/scenes/shared_data.h"
#include "engine/scenes/units.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// Contact forces are kept for a few control periods, and a frame for each one that lies within the delay.
constexpr double kMaxSteps = 1e7, kMaxStepsAPeriod = 1e4, kMaxPeriodsLate = 100.0;
constexpr double kRounding = 1e-9;  // Of a ratio of two times.

void read_time(const ConfigMap& time, Scene& scene) {
  scene.duration_s = time.quantity("duration");
  scene.step_s = time.quantity("step");
  scene.control_period_s = time.quantity("control_period");
  scene.control_delay_s = time.quantity("control_delay");
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

/// Refuses what a grasp that is found says instead.
bool is_found(const ConfigMap& map, std::string_view key, bool finds) {
  if (finds && map.has(key)) map.refuse(key, "is what grasp finds: leave out one of them");
  return finds;
}

void read_posture(const ConfigMap& map, bool finds, Scene& scene) {
  if (is_found(map, "posture", finds)) {
    scene.posture = scene.hand.at_zero();
    return;
  }
  const std::size_t joints = scene.hand.joints.size();
  const Eigen::VectorXd posture = map.quantities("posture", joints);
  if (joints == 0) return;  // no hand was read, and that is reported
  scene.posture = posture;
  for (int i = 0; i < scene.posture.size(); ++i) {
    const Joint& joint = scene.hand.joints[i];
    if (scene.posture[i] >= joint.lower_rad && scene.posture[i] <= joint.upper_rad) continue;
    map.refuse("posture", "value " + std::to_string(i + 1) + " (" + joint.name + ") must lie within " +
                              std::to_string(joint.lower_rad) + " .. " + std::to_string(joint.upper_rad) + " rad");
  }
}

/// The indices of fingers of these names.
std::vector<int> read_fingers(const ConfigMap& map, const Hand& hand) {
  std::vector<int> fingers;
  std::vector<std::string_view> names;
  for (const Fingertip& tip : hand.fingertips) names.push_back(tip.finger);
  for (const std::string& name : map.texts("fingers")) {
    const auto named = [&](const Fingertip& tip) { return tip.finger == name; };
    const auto tip = std::find_if(hand.fingertips.begin(), hand.fingertips.end(), named);
    const int k = static_cast<int>(tip - hand.fingertips.begin());
    if (hand.fingertips.empty()) continue;  // no hand was read, and that is reported
    if (tip == hand.fingertips.end()) {
      map.refuse("fingers", "the hand has no finger '" + name + "'" + did_you_mean(nearest_word(name, names)));
    } else if (std::find(fingers.begin(), fingers.end(), k) != fingers.end()) {
      map.refuse("fingers", "names '" + name + "' twice");
    } else {
      fingers.push_back(k);
    }
  }
  return fingers;
}

/// The hand's file: beside the scene, or one that comes with the program. Empty if the scene names none.
std::filesystem::path hand_file(const ConfigMap& map) {
  const std::filesystem::path beside = map.path("model");
  std::error_code none;  // A folder may have the name of a hand.
  if (beside.empty() || (is_readable(beside) && !std::filesystem::is_directory(beside, none))) return beside;
  const std::filesystem::path known = known_hand(beside);
  return known.empty() ? beside : known;
}

/// Refuses what drives the joints of a hand, or places them.
void refuse_beside_slides(const ConfigMap& root) {
  if (root.has("control"))
    root.refuse("control", "is of a hand, and hand.slides take its place: leave out one of them");
  if (root.has("grasp")) root.refuse("grasp", "is of a hand, and hand.slides take its place: leave out one of them");
}

/// False if the hand file cannot be read, which is reported.
bool read_hand(const ConfigMap& map, bool controlled, bool finds, Scene& scene) {
  if (map.has("slides")) {
    read_slides(map, scene);
    return true;
  }
  bool readable = true;
  const std::filesystem::path model = hand_file(map);
  try {
    if (!model.empty()) scene.hand = load_hand(model);
  } catch (const ReadError& error) {
    const std::vector<std::string> names = known_hands();
    const std::vector<std::string_view> candidates(names.begin(), names.end());
    map.refuse("model", error.what() + did_you_mean(nearest_word(model.stem().string(), candidates)));
    readable = false;
  }
  if (map.has("fingers")) {
    const std::vector<int> fingers = read_fingers(map, scene.hand);
    if (!fingers.empty()) scene.hand = hand_of(scene.hand, fingers);
  }
  if (map.has("mirror") && map.flag("mirror")) scene.hand = mirrored(std::move(scene.hand));
  read_posture(map, finds, scene);
  if (map.has("settle")) scene.settles = map.flag("settle");
  scene.joint_viscosity = map.quantity("joint_viscosity");
  if (controlled || finds) return readable;
  const Eigen::VectorXd torques = map.quantities("torques", scene.hand.joints.size());
  if (readable) scene.torques = torques;
  return readable;
}

FingertipSettings read_fingertips(const ConfigMap& map) {
  FingertipSettings tips;
  tips.points = map.count("points");
  tips.leaves = map.count("leaves");
  if (tips.leaves > tips.points && !map.is_refused("points")) {
    map.refuse("leaves", "must not exceed fingertips.points");
  }
  tips.material.reduced_modulus_Pa = map.quantity("reduced_modulus");
  tips.material.poisson = map.quantity("poisson");
  tips.material.relaxation_s = map.quantity("relaxation");
  if (map.choice("kernel") == "gaussian") tips.material.kernel = PulpKernel::kGaussian;
  if (map.has("stiffening")) tips.material.stiffening_per_N = map.quantity("stiffening");
  if (map.has("touch")) {
    const ConfigMap touch = map.map("touch");
    tips.touch = {touch.quantity("delay"), touch.quantity("noise"), static_cast<std::uint32_t>(touch.count("seed"))};
  }
  return tips;
}

SuperquadricShape read_superquadric(const ConfigMap& map) {
  const Eigen::VectorXd exponents = map.quantities("exponents");
  return {map.quantities("size"), {exponents[0], exponents[1]}};
}

Mug read_mug(const ConfigMap& map) {
  Mug mug{map.quantity("radius"), map.quantity("height"), map.quantity("wall"), std::nullopt};
  if (mug.wall_m >= std::min(mug.radius_m, mug.height_m)) map.refuse("wall", "must be less than radius and height");
  if (!map.has("handle")) return mug;
  const ConfigMap handle = map.map("handle");
  mug.handle = MugHandle{handle.quantity("radius"), handle.quantity("thickness")};
  if (!mug.handle_fits() && !handle.is_refused("radius") && !handle.is_refused("thickness")) {
    map.refuse("handle",
               "thickness must be less than twice its radius, and both together fit the mug: "
               "radius + thickness/2 less than the mug's radius and half its height");
  }
  return mug;
}

/// What 1 in a file measures: the name of a unit or, as "25.4 mm", a length.
double read_unit(const ConfigMap& map) {
  const std::string name = map.word("unit");
  return name.empty() ? map.quantity("unit") : read_quantity("1 " + name, Dimension::kLength).value;
}

/// `cloud: scan.ply`, or `cloud: {file: scan.ply, unit: mm}`.
CloudShape read_cloud(const ConfigMap& map) {
  if (!map.is_map("cloud")) return {map.path("cloud")};  // in metres
  const ConfigMap cloud = map.map("cloud");
  return {cloud.path("file"), read_unit(cloud)};
}

Shape read_shape(const ConfigMap& map) {
  const std::string kind = map.one_of();
  if (kind == "box") return BoxShape{map.quantities(kind)};
  if (kind == "sphere") return SphereShape{map.quantity(kind)};
  if (kind == "ellipsoid") return EllipsoidShape{map.quantities(kind)};
  if (kind == "cylinder") return CylinderShape{map.map(kind).quantity("radius"), map.map(kind).quantity("length")};
  if (kind == "superquadric") return read_superquadric(map.map(kind));
  if (kind == "mug") return read_mug(map.map(kind));
  return kind.empty() ? CloudShape{} : read_cloud(map);
}

/// Where the weight of a solid acts that is equally dense throughout. Whether a surface from a file is one's is not
/// known: its origin.
Vector3d solid_centroid_m(const Shape& shape) {
  const auto* const mug = std::get_if<Mug>(&shape);
  return mug != nullptr ? centroid_m(*mug) : Vector3d::Zero();
}

PulpMaterial read_compliance(const ConfigMap& map) {
  return {map.quantity("reduced_modulus"), map.quantity("poisson"), map.quantity("relaxation")};
}

Vector3d read_centre_of_mass(const ConfigMap& map, const Shape& shape) {
  if (map.has("centre_of_mass")) {
    Vector3d centre_m = map.quantities("centre_of_mass");
    check_is_in_object(map, "centre_of_mass", centre_m, shape);
    return centre_m;
  }
  Vector3d centre_m = solid_centroid_m(shape);
  const auto text = [&](int axis) { return to_text(centre_m[axis], Dimension::kLength); };
  map.use_default("centre_of_mass", fmt::format("[{}, {}, {}]", text(0), text(1), text(2)));
  return centre_m;
}

ObjectSettings read_object(const ConfigMap& map, bool deformable_fingers, bool finds) {
  ObjectSettings object;
  object.shape = read_shape(map.map("shape"));
  const auto* const scan = std::get_if<CloudShape>(&object.shape);
  if (scan == nullptr || is_mesh_file(scan->file)) {
    object.points = map.count("points");
  } else if (map.has("points") && !scan->file.empty()) {
    map.refuse("points", "a point cloud brings its own points: leave this out");
  }
  object.mass_kg = map.quantity("mass");
  object.centre_of_mass_m = read_centre_of_mass(map, object.shape);
  object.X_WO.setIdentity();
  if (!is_found(map, "position", finds)) object.X_WO.translation() = map.quantities("position");
  if (!is_found(map, "rotation", finds)) object.X_WO.linear() = map.rotation("rotation");
  const ConfigMap damping = map.map("damping");
  object.translation_damping = damping.quantity("translation");
  object.rotation_damping = damping.quantity("rotation");
  if (map.has("compliance")) {
    object.compliance = read_compliance(map.map("compliance"));
    // A point's force would press it in without end.
    if (!deformable_fingers) map.refuse("compliance", "needs fingertips: rigid ones touch at a point each");
  }
  return object;
}

/// leaves: 0; auto: nothing.
std::optional<int> read_level(const ConfigMap& map) {
  const std::string level = map.choice("level");
  if (level == "auto") return std::nullopt;
  return level == "leaves" ? 0 : std::stoi(level);
}

ContactSettings read_contact(const ConfigMap& map, const std::optional<FingertipSettings>& fingertips) {
  ContactSettings contact;
  contact.friction = map.quantity("friction");
  contact.band_m = map.quantity("band");
  contact.distance_error_m = map.quantity("distance_error");
  if (!fingertips && map.has("distance_error")) map.refuse("distance_error", "counts with deformable fingertips alone");
  contact.max_per_finger = fingertips ? map.count("max_per_finger") : 1;
  if (fingertips) contact.level = read_level(map);
  if (const int level = contact.level.value_or(0); level > 0 && (Index{1} << level) > fingertips->leaves) {
    map.refuse("level", "needs fingertips of " + std::to_string(1 << level) + " leaves or more");
  }
  if (!contact.level) {
    contact.force_error = map.quantity("force_error");
  } else if (map.has("force_error")) {
    map.refuse("force_error", "counts with contact.level: auto alone");
  }
  contact.tolerance = map.quantity("tolerance");
  contact.max_sweeps = static_cast<int>(map.count("max_sweeps"));
  return contact;
}

Vector3d read_direction(const ConfigMap& map, std::string_view key) {
  const Vector3d direction = map.quantities(key);
  if (direction.squaredNorm() <= 0.0) map.refuse(key, "a direction must not be zero");
  return direction.stableNormalized();
}

/// `grasp: auto`, or a map.
GraspWish read_grasp(const ConfigMap& root, const Scene& scene) {
  GraspWish wish{.place = root.location("grasp")};
  const bool controlled = root.has("control");
  if (!root.word("grasp").empty()) {
    if (!controlled) root.refuse("grasp", "needs grasp.press without control: write it as a map");
    return wish;
  }
  const ConfigMap map = root.map("grasp");
  if (map.has("fingers")) wish.fingers = read_fingers(map, scene.hand);
  if (map.has("axis")) wish.axis_O = read_direction(map, "axis");
  if (map.has("approach")) wish.approach_O = read_direction(map, "approach");
  if (map.has("at")) {
    wish.at_O = map.quantities("at");
    check_is_in_object(map, "at", *wish.at_O, scene.object.shape);
  }
  if (map.has("press") || !controlled) wish.press_N = map.quantity("press");
  wish.rank = static_cast<int>(map.count("rank"));
  wish.seed = static_cast<std::uint32_t>(map.count("seed"));
  return wish;
}

Tolerance read_tolerance(const ConfigMap& map) {
  return {map.quantity("position"), map.quantity("rotation"), map.quantity("force"), map.quantity("moment"),
          map.quantity("margin")};
}

}  // namespace

std::string in_words(const Tolerance& tolerance) {
  return fmt::format("{{position: {:.3g} mm, rotation: {:.3g} deg, force: {:.3g} %, moment: {:.3g} %, margin: {:.3g}}}",
                     1e3 * tolerance.position_m, tolerance.rotation_rad * 180.0 / std::numbers::pi,
                     100.0 * tolerance.force, 100.0 * tolerance.moment, tolerance.margin);
}

Scene load_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  if (is_hand_file(file)) {
    throw ConfigError({{printable(file.string()), "", "is a hand, which a scene names in hand.model, and no scene"}});
  }
  Config config(file, scene_keys(), overrides);
  const ConfigMap root = config.root();
  Scene scene;
  scene.name = root.text("name");
  read_time(root.map("time"), scene);
  scene.gravity = root.quantities("gravity");
  const ConfigMap hand = root.map("hand");
  const bool slides = hand.has("slides"), finds = root.has("grasp") && !slides,
             controlled = root.has("control") && !slides;
  if (slides) refuse_beside_slides(root);
  const bool hand_readable = read_hand(hand, controlled, finds, scene);
  if (root.has("fingertips")) scene.fingertips = read_fingertips(root.map("fingertips"));
  scene.object = read_object(root.map("object"), scene.fingertips.has_value(), finds);
  scene.contact = read_contact(root.map("contact"), scene.fingertips);
  if (finds) scene.grasp = read_grasp(root, scene);
  const bool pressed = scene.grasp && scene.grasp->press_N;
  const bool feels = scene.fingertips && scene.fingertips->touch;
  if (controlled) scene.control = read_control(root.map("control"), scene.hand, pressed, feels);
  if (scene.control && scene.control->muscles && !scene.hand.joints.empty() && scene.hand.muscles.empty()) {
    root.map("control").refuse("muscles", "this hand has none: write false, and torques drive its joints");
  }
  bool drive_readable = true;
  if (scene.control && root.map("control").has("drive")) {
    drive_readable = read_drive(root.map("control"), scene.hand, *scene.control);
  }
  if (root.has("environment")) scene.environment = read_environment(root);
  if (root.has("task")) scene.task = read_task(root, scene);
  scene.only_needed = root.choice("model") == "auto";
  if (root.has("tolerance")) scene.tolerance = read_tolerance(root.map("tolerance"));
  try {
    config.finish();
  } catch (const ConfigError& error) {
    // A file may be there the next time: where that is all that is wrong, the scene is not.
    if ((hand_readable && drive_readable) || error.diagnostics().size() > 1) throw;
    const std::string& place = error.diagnostics().front().location;
    throw ReadError(place, std::string(error.what()).substr(place.size() + 2));
  }
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
  const Config config(scene, scene_keys(), overrides);
  const ConfigMap root = config.root();
  if (root.is_map("hand") && !root.map("hand").has("slides")) add(hand_file(root.map("hand")));
  if (root.is_map("object") && root.map("object").is_map("shape")) {
    const ConfigMap shape = root.map("object").map("shape");
    if (shape.has("cloud")) add(shape.is_map("cloud") ? shape.map("cloud").path("file") : shape.path("cloud"));
  }
  if (root.is_map("control") && root.map("control").has("drive")) add(root.map("control").path("drive"));
  return files;
}

}  // namespace thenar
