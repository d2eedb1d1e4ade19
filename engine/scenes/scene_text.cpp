#include "engine/scenes/scene_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/finder/effort.h"
#include "engine/formats/text.h"
#include "engine/scenes/scene_environment.h"
#include "engine/scenes/scene_slides.h"
#include "engine/scenes/scene_task.h"
#include "engine/scenes/units.h"

namespace thenar {

using Eigen::Vector3d;

namespace {

std::string list(const std::vector<std::string>& items) { return fmt::format("[{}]", fmt::join(items, ", ")); }
template <typename Values>
std::string text(const Values& values, Dimension dimension) {
  return to_text(values, dimension);
}
std::string length(double value_m) { return text(value_m, Dimension::kLength); }
std::string number(double value) { return text(value, Dimension::kNone); }

/// Words as comment lines of at most 120 columns.
std::string comment(const std::string& words) {
  std::string result, line = "#";
  std::size_t at = 0;
  while (at < words.size()) {
    const std::size_t end = std::min(words.find(' ', at), words.size());
    if (line.size() + 1 + end - at > 118) {
      result += line + "\n";
      line = "#";
    }
    line += " " + words.substr(at, end - at);
    at = end + 1;
  }
  return words.empty() ? "" : result + line + "\n";
}

struct ShapeText {
  const std::filesystem::path& file;
  std::string operator()(const BoxShape& box) const { return solid_text(box); }
  std::string operator()(const SphereShape& sphere) const { return solid_text(sphere); }
  std::string operator()(const CylinderShape& cylinder) const { return solid_text(cylinder); }
  std::string operator()(const EllipsoidShape& shape) const {
    return fmt::format("{{ellipsoid: {}}}", text(shape.size_m, Dimension::kLength));
  }
  std::string operator()(const SuperquadricShape& shape) const {
    return fmt::format("{{superquadric: {{size: {}, exponents: [{}, {}]}}}}", text(shape.size_m, Dimension::kLength),
                       number(shape.exponents.north_south), number(shape.exponents.east_west));
  }
  std::string operator()(const Mug& mug) const {
    std::string handle;
    if (mug.handle) {
      handle = fmt::format(", handle: {{radius: {}, thickness: {}}}", length(mug.handle->radius_m),
                           length(mug.handle->thickness_m));
    }
    return fmt::format("{{mug: {{radius: {}, height: {}, wall: {}{}}}}}", length(mug.radius_m), length(mug.height_m),
                       length(mug.wall_m), handle);
  }
  std::string operator()(const CloudShape& cloud) const {
    return fmt::format("{{cloud: {{file: {}, unit: {}}}}}", quoted(file.string()), length(cloud.unit_m));
  }
};

std::string hand_text(const Scene& scene, const SceneTextNotes& notes) {
  if (scene.hand.slides) return "hand:\n" + slides_text(scene);
  std::string out = fmt::format("hand:\n  model: {}\n", quoted(notes.hand.string()));
  if (scene.hand.mirrored) out += "  mirror: true  # the other hand than the file's\n";
  if (notes.names_fingers) {
    std::vector<std::string> names;
    for (const Fingertip& tip : scene.hand.fingertips) names.push_back(quoted(tip.finger));
    out += fmt::format("  fingers: {}  # the others are left out\n", list(names));
  }
  if (!scene.grasp) {
    out += "  posture:  # of each joint, finger by finger\n";
    for (const Fingertip& tip : scene.hand.fingertips) {
      const std::string angles =
          text(Eigen::VectorXd(scene.posture.segment(tip.first_joint, tip.joints)), Dimension::kAngle);
      const bool first = tip.first_joint == 0, last = &tip == &scene.hand.fingertips.back();
      out += fmt::format("    {}{}{}  # {}\n", first ? "[" : " ", angles.substr(1, angles.size() - 2), last ? "]" : ",",
                         tip.finger);
    }
  }
  if (scene.settles) out += "  settle: true  # the fingers begin pressed, as they are asked to\n";
  out += fmt::format("  joint_viscosity: {}\n", text(scene.joint_viscosity, Dimension::kRotationalDamping));
  if (scene.torques && !scene.grasp) {
    out += fmt::format("  torques: {}\n", text(Eigen::VectorXd(*scene.torques), Dimension::kTorque));
  }
  return out;
}

std::string grasp_text(const Scene& scene) {
  const GraspWish& wish = *scene.grasp;
  std::string map;
  const auto add = [&](const char* key, const std::string& value) { map += fmt::format("  {}: {}\n", key, value); };
  std::vector<std::string> names;
  for (const int k : wish.fingers) names.push_back(quoted(scene.hand.fingertips[k].finger));
  if (!names.empty()) add("fingers", list(names));
  if (wish.axis_O) add("axis", text(*wish.axis_O, Dimension::kNone));
  if (wish.at_O) add("at", text(*wish.at_O, Dimension::kLength));
  if (wish.approach_O) add("approach", text(*wish.approach_O, Dimension::kNone));
  if (wish.press_N) add("press", text(*wish.press_N, Dimension::kForce));
  if (wish.rank != 1) add("rank", std::to_string(wish.rank));
  if (wish.seed != 1) add("seed", std::to_string(wish.seed));
  if (!map.empty()) return "grasp:\n" + map;
  return comment(
             "Hand and object are placed by a search. As a map it can say, in the object's axes, as much of the "
             "grasp as matters: {axis: [1, 0, 0], at: [0 mm, 0 mm, 0 mm], approach: [0, 0, -1]}. fingers: [...] names "
             "those that hold it, three or more. press: 1 N says how hard, in place of control.grasp.internal_force.") +
         "grasp: auto\n";
}

std::string object_text(const Scene& scene, const SceneTextNotes& notes) {
  const ObjectSettings& object = scene.object;
  std::string out = fmt::format("object:\n  shape: {}\n", std::visit(ShapeText{notes.object}, object.shape));
  if (object.points > 0) out += fmt::format("  points: {}  # samples of its surface\n", object.points);
  out += fmt::format("  mass: {}\n  centre_of_mass: {}  # object frame\n", text(object.mass_kg, Dimension::kMass),
                     text(object.centre_of_mass_m, Dimension::kLength));
  if (!scene.grasp) {
    out += fmt::format("  position: {}  # of its frame, in the hand's\n",
                       text(Vector3d(object.X_WO.translation()), Dimension::kLength));
    const Eigen::Matrix3d R = object.X_WO.linear();
    const auto row = [&](int i) { return text(Vector3d(R.row(i)), Dimension::kNone); };
    out += fmt::format("  rotation: [{},\n             {},\n             {}]\n", row(0), row(1), row(2));
  }
  out += fmt::format("  damping: {{translation: {}, rotation: {}}}\n",
                     text(object.translation_damping, Dimension::kDamping),
                     text(object.rotation_damping, Dimension::kRotationalDamping));
  if (object.compliance) {
    out += fmt::format("  compliance: {{reduced_modulus: {}, poisson: {}, relaxation: {}}}\n",
                       text(object.compliance->reduced_modulus_Pa, Dimension::kPressure),
                       number(object.compliance->poisson), text(object.compliance->relaxation_s, Dimension::kTime));
  }
  return out;
}

std::string fingertips_text(const FingertipSettings& tips) {
  const PulpMaterial& material = tips.material;
  std::string out =
      fmt::format("fingertips:\n  points: {}\n  leaves: {}\n  reduced_modulus: {}\n  poisson: {}\n", tips.points,
                  tips.leaves, text(material.reduced_modulus_Pa, Dimension::kPressure), number(material.poisson));
  out += fmt::format("  relaxation: {}\n  kernel: {}\n", text(material.relaxation_s, Dimension::kTime),
                     material.kernel == PulpKernel::kGaussian ? "gaussian" : "boussinesq");
  if (material.stiffening_per_N > 0.0) {
    out += fmt::format("  stiffening: {}\n", text(material.stiffening_per_N, Dimension::kPerForce));
  }
  if (const auto& touch = tips.touch) {
    out += fmt::format("  touch: {{delay: {}, noise: {}, seed: {}}}\n", text(touch->delay_s, Dimension::kTime),
                       text(touch->noise, Dimension::kShare), touch->seed);
  }
  return out;
}

std::string contact_text(const Scene& scene) {
  const ContactSettings& contact = scene.contact;
  std::string out =
      fmt::format("contact:\n  friction: {}\n  band: {}\n", number(contact.friction), length(contact.band_m));
  if (scene.fingertips) {
    out += fmt::format("  distance_error: {}\n  max_per_finger: {}\n", length(contact.distance_error_m),
                       contact.max_per_finger);
    const std::string level = !contact.level ? "auto" : *contact.level == 0 ? "leaves" : std::to_string(*contact.level);
    out += fmt::format("  level: {}\n", level);
    if (!contact.level) out += fmt::format("  force_error: {}\n", text(contact.force_error, Dimension::kShare));
  }
  return out + fmt::format("  tolerance: {}\n  max_sweeps: {}\n", number(contact.tolerance), contact.max_sweeps);
}

/// "0.55", or "felt, margin: 0.3, first_friction: 0.5".
std::string cones_text(const ControlSettings& control) {
  if (!control.felt_margin) return number(control.grasp_friction);
  return fmt::format("felt, margin: {}, first_friction: {}", number(*control.felt_margin),
                     number(control.grasp_friction * (1.0 + *control.felt_margin)));
}

std::string muscles_text(const ControlSettings& control) {
  if (!control.muscles) return "false";
  std::vector<std::string> parts;
  if (const auto& activation = control.muscles->activation) {
    parts.push_back(fmt::format("activation: {}, deactivation: {}", text(activation->rise_s, Dimension::kTime),
                                text(activation->fall_s, Dimension::kTime)));
  }
  if (const auto& gamma = control.muscles->short_range) parts.push_back("stiffness: " + number(*gamma));
  if (const auto& wanted = control.muscles->object_stiffness) {
    std::string squeeze;
    if (wanted->most_squeeze_N > 0.0) squeeze = ", squeeze: " + text(wanted->most_squeeze_N, Dimension::kForce);
    parts.push_back(fmt::format("object_stiffness: {{translation: {}, rotation: {}, centre: {}{}}}",
                                text(wanted->translation_N_per_m, Dimension::kStiffness),
                                text(wanted->rotation_Nm_per_rad, Dimension::kRotationalStiffness),
                                text(wanted->centre_m, Dimension::kLength), squeeze));
  }
  if (const auto& from_s = control.muscles->frozen_from_s) {
    parts.push_back("frozen_from: " + text(*from_s, Dimension::kTime));
  }
  return parts.empty() ? "true" : fmt::format("{{{}}}", fmt::join(parts, ", "));
}

std::string control_text(const Scene& scene) {
  const ControlSettings& control = *scene.control;
  std::string out =
      fmt::format("control:\n  law: {}\n  gain: {}\n", control.law == ControlLaw::kPaper ? "paper" : "feedforward",
                  control.gain ? text(*control.gain, Dimension::kRotationalStiffness) : "auto");
  out +=
      fmt::format("  pulp: {{normal: {}, tangential: {}}}\n", text(control.pulp_normal_N_per_m, Dimension::kStiffness),
                  text(control.pulp_tangential_N_per_m, Dimension::kStiffness));
  const bool pressed = scene.grasp && scene.grasp->press_N;
  out +=
      fmt::format("  grasp: {{friction: {}, {}cone: {}}}\n", cones_text(control),
                  pressed ? "" : fmt::format("internal_force: {}, ", text(control.internal_force_N, Dimension::kForce)),
                  control.cone == FrictionCone::kExact ? "exact" : "pyramid");
  out += fmt::format("  position: {{p: {}, i: {}, d: {}}}\n", text(control.position.p, Dimension::kStiffness),
                     text(control.position.i, Dimension::kIntegralGain), text(control.position.d, Dimension::kDamping));
  out += fmt::format("  rotation: {{p: {}, i: {}, d: {}}}\n", text(control.rotation.p, Dimension::kRotationalStiffness),
                     text(control.rotation.i, Dimension::kRotationalIntegralGain),
                     text(control.rotation.d, Dimension::kRotationalDamping));
  if (control.centre_m) out += fmt::format("  centre: {}\n", text(*control.centre_m, Dimension::kLength));
  if (control.posture_Nm_per_rad) {
    out += fmt::format("  posture: {}\n", text(*control.posture_Nm_per_rad, Dimension::kRotationalStiffness));
  }
  if (control.feedback_delay_s > 0.0) {
    out += fmt::format("  feedback_delay: {}\n", text(control.feedback_delay_s, Dimension::kTime));
  }
  if (control.anticipation) out += "  anticipation: true\n";
  if (const auto& reflex = control.reflex) {
    out += fmt::format("  reflex: {{load_rate: {}, pulse: {}, release: {}, stick: {}, regulation: {}}}\n",
                       text(reflex->load_rate_N_per_s, Dimension::kForceRate), text(reflex->pulse_s, Dimension::kTime),
                       text(reflex->release_s, Dimension::kTime), number(reflex->stick),
                       text(reflex->regulation_per_s, Dimension::kRate));
  }
  out += fmt::format("  muscles: {}  # or joint torques\n", muscles_text(control));
  if (control.drive) out += fmt::format("  drive: '{}'\n", std::filesystem::absolute(control.drive->file).string());
  return out;
}

}  // namespace

std::string scene_text(const Scene& scene, const SceneTextNotes& notes) {
  std::string out = notes.schema.empty() ? "" : "# yaml-language-server: $schema=" + notes.schema.string() + "\n";
  out += comment(notes.about) + comment(notes.grasp);
  out += fmt::format("name: {}\ntime: {{duration: {}, step: {}, control_period: {}, control_delay: {}}}\n",
                     quoted(scene.name), text(scene.duration_s, Dimension::kTime), text(scene.step_s, Dimension::kTime),
                     text(scene.control_period_s, Dimension::kTime), text(scene.control_delay_s, Dimension::kTime));
  out += fmt::format("gravity: {}  # in the hand's frame, which is the world\n",
                     text(scene.gravity, Dimension::kAcceleration));
  if (scene.grasp) out += grasp_text(scene);
  out += hand_text(scene, notes);
  if (scene.fingertips) out += fingertips_text(*scene.fingertips);
  out += object_text(scene, notes) + contact_text(scene);
  if (scene.environment) out += environment_text(*scene.environment);
  if (scene.control) out += control_text(scene);
  out += task_text(scene.task);
  if (!scene.only_needed) return out;
  const Tolerance& t = scene.tolerance;
  return out +
         fmt::format("model: auto\ntolerance: {{position: {}, rotation: {}, force: {}, moment: {}, margin: {}}}\n",
                     length(t.position_m), text(t.rotation_rad, Dimension::kAngle), text(t.force, Dimension::kShare),
                     text(t.moment, Dimension::kShare), number(t.margin));
}

Scene scene_to_begin_with(const Hand& hand, const CloudShape& object, double mass_kg, double friction) {
  Scene scene;
  scene.name = object.file.stem().string();
  scene.duration_s = 2.0;
  scene.step_s = scene.control_period_s = 1e-3;
  scene.gravity = {7.01862, 5.581331, 3.977916};  // the palm looks up and to the side, as in the published experiment
  scene.hand = hand;
  scene.posture = hand.at_zero();
  scene.joint_viscosity = 0.05;
  scene.grasp = GraspWish{};
  scene.fingertips = FingertipSettings{2400, 320, {0.24e6, 0.5, 2e-3}};
  scene.object.shape = object;
  scene.object.points = 20000;
  scene.object.mass_kg = mass_kg;
  scene.object.translation_damping = 10.0;
  scene.object.rotation_damping = 0.005;
  scene.contact = {.friction = friction, .band_m = 0.3e-3, .max_per_finger = 30, .tolerance = 1e-7, .max_sweeps = 200};
  ControlSettings control;
  control.pulp_normal_N_per_m = 2000.0;
  control.pulp_tangential_N_per_m = 1330.0;
  control.grasp_friction = 0.7 * friction;
  // What carries the weight, and the push by which grasps are tried, by friction on both sides, and as much again.
  const double needed_N = (mass_kg * 9.81 + kPush_N) / std::max(friction, 0.1);
  control.internal_force_N = std::max(1.0, std::ceil(10.0 * needed_N) / 10.0);
  control.position = {300.0, 900.0, 0.0};
  control.rotation = {0.48, 1.5, 0.0};
  control.posture_Nm_per_rad = 0.5;
  if (!hand.muscles.empty()) control.muscles.emplace();
  scene.control = control;
  return scene;
}

Vector3d enclosed_centroid_m(const PointCloud& cloud) {
  // By Gauss: V = 1/3 sum x.n A, V c_i = 1/2 sum x_i^2 n_i A, about the middle of the box; all A are alike.
  const Vector3d low = cloud.points_m.rowwise().minCoeff(), high = cloud.points_m.rowwise().maxCoeff();
  const Vector3d middle = 0.5 * (low + high);
  const Eigen::Matrix3Xd x = cloud.points_m.colwise() - middle;
  const double volume = x.cwiseProduct(cloud.normals).sum() / 3.0;
  const Vector3d moment = 0.5 * x.cwiseAbs2().cwiseProduct(cloud.normals).rowwise().sum();
  if (!(volume > 0.0)) return middle;
  const Vector3d off = moment / volume;
  return (off.array().abs() < 0.5 * (high - low).array()).all() ? Vector3d(middle + off) : middle;
}

}  // namespace thenar
