#include "engine/scenes/scene_slides.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "engine/formats/text.h"
#include "engine/grasp/slides.h"
#include "engine/scenes/units.h"

namespace thenar {

using Eigen::Vector3d;

namespace {

Vector3d read_direction(const ConfigMap& map) {
  const Vector3d along = map.quantities("along");
  if (along.squaredNorm() > 0.0) return along.stableNormalized();
  map.refuse("along", "a direction must not be zero");
  return Vector3d::UnitX();
}

void read_path(const ConfigMap& map, Slide& slide) {
  double least_m = 0.0, most_m = 0.0;
  Vector3d place_m = Vector3d::Zero();
  for (const ConfigMap& leg : map.list_of_maps("path")) {
    slide.path.push_back({leg.quantities("by"), leg.quantity("over"), leg.choice("profile") == "minimum_jerk"});
    place_m += slide.path.back().by_m;
    least_m = std::min(least_m, place_m.minCoeff());
    most_m = std::max(most_m, place_m.maxCoeff());
  }
  if (slide.path.empty()) map.refuse("path", "names no leg");
  if (least_m < -kSlideReach_m || most_m > kSlideReach_m)
    map.refuse("path", "leads further than 1 m away from its start");
}

/// What drives a slide.
Slide read_drive(const ConfigMap& map) {
  Slide slide;
  std::vector<std::string> drives;
  if (map.has("force")) {
    slide.force_N = map.quantity("force");
    drives.push_back("force");
  }
  if (map.has("rise")) {
    slide.rise_s = map.quantity("rise");
    if (!map.has("force")) map.refuse("rise", "is of a force, and there is none: leave it out");
  }
  if (map.has("spring")) {
    const ConfigMap spring = map.map("spring");
    slide.stiffness_N_per_m = spring.quantity("stiffness");
    slide.rest_m = spring.quantity("rest");
    drives.push_back("spring");
  }
  if (map.has("path")) {
    read_path(map, slide);
    drives.push_back("path");
  }
  if (drives.empty()) map.refuse("force", "is missing: a slide has a force, a spring or a path");
  if (drives.size() > 1) {
    map.refuse(
        drives[1],
        fmt::format("a slide has one of force, spring and path, and {} is there: leave out all but one", drives[0]));
  }
  return slide;
}

/// Adds the finger of a slide to the hand.
void read_finger(const ConfigMap& map, const Slide& slide, const std::string& name, Hand& hand) {
  const bool has_path = !slide.path.empty();
  add_slide(name, map.quantities("at"), read_direction(map), map.quantity("radius"), has_path, hand);
  for (const char* key : {"damping", "range"}) {
    if (has_path && map.has(key)) map.refuse(key, "has no effect on a path: leave it out");
  }
  if (has_path) return;
  if (map.has("damping")) hand.fingertips.back().joint_viscosity = map.quantity("damping");
  if (!map.has("range")) return;
  const Eigen::Vector2d range_m = map.quantities("range");
  if (!(range_m[0] <= 0.0 && range_m[1] >= 0.0) || range_m[0] == range_m[1]) {
    map.refuse("range", "must reach from 0 or less to 0 or more: 0 is where the fingertip is at the start");
  }
  hand.joints.back().lower_rad = range_m[0];
  hand.joints.back().upper_rad = range_m[1];
}

}  // namespace

void read_slides(const ConfigMap& map, Scene& scene) {
  for (const char* key : {"model", "mirror", "posture", "fingers", "settle", "joint_viscosity", "torques"}) {
    if (map.has(key)) map.refuse(key, "is of a hand, and slides take its place: leave out one of them");
  }
  const std::vector<ConfigMap> slides = map.list_of_maps("slides");
  if (slides.empty() || std::ssize(slides) > kMaxFingers) {
    map.refuse("slides", fmt::format("must list 1 to {} fingertips", kMaxFingers));
  }
  Hand& hand = scene.hand;
  hand = hand_of_slides();
  for (const ConfigMap& one : slides) {
    const std::string name = one.has("name") ? one.text("name") : fmt::format("tip{}", scene.slides.size() + 1);
    const auto is_called_so = [&](const Fingertip& other) { return other.finger == name; };
    if (std::ranges::any_of(hand.fingertips, is_called_so)) one.refuse("name", "is there twice: '" + name + "'");
    if (name == hand.segments.front().name)
      one.refuse("name", "'frame' is what slides are fixed to: choose another one");
    // Too many are read for their faults alone.
    const bool fits = hand.fingers() < kMaxFingers;
    Hand left_out;
    const Slide slide = read_drive(one);
    read_finger(one, slide, name, fits ? hand : left_out);
    if (fits) scene.slides.push_back(slide);
  }
  scene.joint_viscosity = kSlideDamping_N_s_per_m;
  scene.posture = hand.at_zero();
}

std::string slides_text(const Scene& scene) {
  std::string out = "  slides:\n";
  const auto length = [](const auto& value_m) { return to_text(value_m, Dimension::kLength); };
  for (int k = 0; k < scene.hand.fingers(); ++k) {
    const Slide& slide = scene.slides[k];
    const Fingertip& tip = scene.hand.fingertips[k];
    const Segment& segment = scene.hand.segments[tip.segment];
    const Joint& joint = scene.hand.joints[tip.first_joint];
    out += fmt::format("    - name: {}\n      at: {}\n      along: {}\n      radius: {}\n", quoted(tip.finger),
                       length(Vector3d(segment.X_WS_0.translation())),
                       to_text(Vector3d(segment.X_WS_0.linear() * tip.normal), Dimension::kNone), length(tip.radius_m));
    if (scene.has_path(k)) {
      out += "      path:\n";
      for (const PathLeg& leg : slide.path) {
        out += fmt::format("        - {{by: {}, over: {}, profile: {}}}\n", length(leg.by_m),
                           to_text(leg.over_s, Dimension::kTime), leg.smooth ? "minimum_jerk" : "linear");
      }
      continue;
    }
    if (slide.stiffness_N_per_m > 0.0) {
      out += fmt::format("      spring: {{stiffness: {}, rest: {}}}\n",
                         to_text(slide.stiffness_N_per_m, Dimension::kStiffness), length(slide.rest_m));
    } else {
      out += fmt::format("      force: {}\n", to_text(slide.force_N, Dimension::kForce));
      if (slide.rise_s > 0.0) out += fmt::format("      rise: {}\n", to_text(slide.rise_s, Dimension::kTime));
    }
    out += fmt::format("      damping: {}\n      range: {}\n", to_text(scene.viscosity(k), Dimension::kDamping),
                       length(Eigen::VectorXd(Eigen::Vector2d(joint.lower_rad, joint.upper_rad))));
  }
  return out;
}

}  // namespace thenar
