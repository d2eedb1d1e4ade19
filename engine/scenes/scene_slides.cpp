#include "engine/scenes/scene_slides.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "engine/formats/text.h"
#include "engine/scenes/units.h"

namespace thenar {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kDamping_N_s_per_m = 10.0;  // A free fingertip moves by 1 mm in 5 ms under 2 N.
constexpr double kReach_m = 1.0;             // Where stops are that a slide does not name, and how far paths may go.
constexpr double kRodsPerRadius = 5.0;       // How long the rod is that a fingertip is drawn with.

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
  if (least_m < -kReach_m || most_m > kReach_m) map.refuse("path", "leads further than 1 m away from its start");
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

/// Axes of the segment that carries a fingertip: x from it along the rod that it is drawn with.
Matrix3d rod_axes(const Vector3d& along) {
  Matrix3d axes;
  axes.col(0) = -along;
  axes.col(1) = along.unitOrthogonal();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

/// Adds the finger of a slide to the hand.
void add_slide(const ConfigMap& map, const Slide& slide, const std::string& name, Hand& hand) {
  const Vector3d at_m = map.quantities("at"), along = read_direction(map);
  const bool has_path = !slide.path.empty();
  Fingertip tip;
  tip.finger = name;
  tip.first_joint = static_cast<int>(hand.joints.size());
  tip.joints = has_path ? 3 : 1;
  tip.segment = static_cast<int>(hand.segments.size());
  tip.centre_m.setZero();
  tip.radius_m = map.quantity("radius");
  tip.normal = -Vector3d::UnitX();
  tip.joint_viscosity = kDamping_N_s_per_m;
  for (const char* key : {"damping", "range"}) {
    if (has_path && map.has(key)) map.refuse(key, "has no effect on a path: leave it out");
  }
  if (!has_path && map.has("damping")) tip.joint_viscosity = map.quantity("damping");
  Eigen::Vector2d range_m(-kReach_m, kReach_m);
  if (!has_path && map.has("range")) {
    range_m = map.quantities("range");
    if (!(range_m[0] <= 0.0 && range_m[1] >= 0.0) || range_m[0] == range_m[1]) {
      map.refuse("range", "must reach from 0 or less to 0 or more: 0 is where the fingertip is at the start");
    }
  }
  if (has_path) {
    // Beyond where paths end: no stop is in their way.
    const char* const axes[] = {"x", "y", "z"};
    for (int i = 0; i < 3; ++i) {
      hand.joints.push_back({name + "_travel_" + axes[i], at_m, Vector3d::Unit(i), -2.0 * kReach_m, 2.0 * kReach_m});
    }
  } else {
    hand.joints.push_back({name + "_travel", at_m, along, range_m[0], range_m[1]});
  }
  Segment segment;
  segment.name = name;
  segment.finger = hand.fingers();
  segment.joints = tip.joints;
  segment.X_WS_0.setIdentity();
  segment.X_WS_0.linear() = rod_axes(along);
  segment.X_WS_0.translation() = at_m;
  segment.length_m = kRodsPerRadius * tip.radius_m;
  hand.segments.push_back(segment);
  hand.fingertips.push_back(tip);
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
  hand.slides = true;
  Segment frame;
  frame.name = "frame";
  frame.X_WS_0.setIdentity();
  hand.segments.push_back(frame);
  for (const ConfigMap& one : slides) {
    const std::string name = one.has("name") ? one.text("name") : fmt::format("tip{}", scene.slides.size() + 1);
    const auto is_called_so = [&](const Fingertip& other) { return other.finger == name; };
    if (std::ranges::any_of(hand.fingertips, is_called_so)) one.refuse("name", "is there twice: '" + name + "'");
    if (name == frame.name) one.refuse("name", "'frame' is what slides are fixed to: choose another one");
    // Too many are read for their faults alone.
    const bool fits = hand.fingers() < kMaxFingers;
    Hand left_out;
    const Slide slide = read_drive(one);
    add_slide(one, slide, name, fits ? hand : left_out);
    if (fits) scene.slides.push_back(slide);
  }
  scene.joint_viscosity = kDamping_N_s_per_m;
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
