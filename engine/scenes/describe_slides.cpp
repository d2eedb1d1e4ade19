// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "engine/grasp/slides.h"
#include "engine/scenes/describe.h"

/// The list `hand.slides` of a scene.
namespace thenar {

using Eigen::Vector3d;
using enum Dimension;

namespace {

struct SlideSpring {
  double stiffness_N_per_m = 0.0, rest_m = 0.0;
};

/// A fingertip on a slide as a scene names it. Of force, spring and path one is there.
struct SlideKeys {
  std::string name;
  Vector3d at_m = Vector3d::Zero(), along = Vector3d::UnitX();
  double radius_m = 0.0;
  std::optional<double> force_N = {}, rise_s = {};
  std::optional<SlideSpring> spring = {};
  std::vector<PathLeg> path;
  std::optional<double> damping_N_s_per_m = {};
  std::optional<Eigen::Vector2d> range_m = {};
};

void check_path(Visitor& v, const std::vector<PathLeg>& path) {
  double least_m = 0.0, most_m = 0.0;
  Vector3d place_m = Vector3d::Zero();
  for (const PathLeg& leg : path) {
    place_m += leg.by_m;
    least_m = std::min(least_m, place_m.minCoeff());
    most_m = std::max(most_m, place_m.maxCoeff());
  }
  if (path.empty()) v.refuse("path", "names no leg");
  if (least_m < -kSlideReach_m || most_m > kSlideReach_m)
    v.refuse("path", "leads further than 1 m away from its start");
}

/// A slide has one of force, spring and path, and with it what belongs to that.
void check_drive(Visitor& v, const SlideKeys& slide) {
  std::vector<const char*> drives;
  for (const char* drive : {"force", "spring", "path"}) {
    if (v.has(drive)) drives.push_back(drive);
  }
  if (slide.rise_s && !slide.force_N) v.refuse("rise", "is of a force, and there is none: leave it out");
  if (v.has("path")) check_path(v, slide.path);
  if (drives.empty()) v.refuse("force", "is missing: a slide has a force, a spring or a path");
  if (drives.size() > 1) {
    v.refuse(drives[1], fmt::format("a slide has one of force, spring and path, and {} is there: leave out all but one",
                                    drives[0]));
  }
  for (const char* key : {"damping", "range"}) {
    if (!slide.path.empty() && v.has(key)) v.refuse(key, "has no effect on a path: leave it out");
  }
  if (const auto& range_m = slide.range_m; range_m && slide.path.empty()) {
    if (!((*range_m)[0] <= 0.0 && (*range_m)[1] >= 0.0) || (*range_m)[0] == (*range_m)[1]) {
      v.refuse("range", "must reach from 0 or less to 0 or more: 0 is where the fingertip is at the start");
    }
  }
}

void describe(Visitor& v, SlideKeys& slide) {
  v.key({"name", kNone, "", "(Without it: tip1, tip2, and so on.)", "Its name in results."}, slide.name);
  v.key({"at", kLength, "-2 m .. 2 m", "", "The centre of the fingertip at the start."}, slide.at_m);
  describe_direction(v, {"along", kNone, "", "", "The direction in which it slides and faces, of any length but zero."},
                     slide.along);
  v.key({"radius", kLength, "0.1 mm .. 100 mm", "", "The radius of the fingertip, a sphere."}, slide.radius_m);
  v.key({"force", kForce, "", "(A slide has a force, a spring or a path.)",
         "The force along the slide that drives it, constant but for its rise."},
        slide.force_N);
  v.key({"rise", kTime, ">= 0", "(Without it the force is there from the start.)",
         "How long its force grows, linearly from zero at the start."},
        slide.rise_s);
  v.map({"spring", kNone, "", "(A slide has a force, a spring or a path.)", "A spring along the slide that drives it."},
        slide.spring, [&](SlideSpring& spring) {
          v.key({"stiffness", kStiffness, "> 0", "", "Its stiffness."}, spring.stiffness_N_per_m);
          v.key({"rest", kLength, "-1 m .. 1 m", "",
                 "How far along the slide from the start the fingertip is where the spring has no force."},
                spring.rest_m);
        });
  v.list({"path", kNone, "", "(A slide has a force, a spring or a path.)",
          "Where it goes, whatever resists: one leg after the other, each a displacement in any direction. In the end "
          "it stays."},
         slide.path, [&](PathLeg& leg) {
           v.key({"by", kLength, "-1 m .. 1 m", "", "The displacement of this leg, world axes."}, leg.by_m);
           v.key({"over", kTime, "> 0", "", "How long it takes."}, leg.over_s);
           v.choice({"profile", kNone, "linear | minimum_jerk", "linear",
                     "At constant speed, or by minimum jerk from rest to rest."},
                    leg.smooth, {false, true});
         });
  v.key({"damping", kDamping, "> 0", "(Without it 10 N*s/m. Refused with a path.)",
         "The viscous damping of its motion along the slide."},
        slide.damping_N_s_per_m);
  v.key({"range", kLength, "-1 m .. 1 m", "(Without it 1 m each way. Refused with a path.)",
         "How far it can slide from where it is at the start: the places of two stops along the slide."},
        slide.range_m);
  if (v.reads()) check_drive(v, slide);
}

SlideKeys keys_of(const Scene& scene, int k) {
  const Slide& slide = scene.slides[k];
  const Fingertip& tip = scene.hand.fingertips[k];
  const Segment& segment = scene.hand.segments[tip.segment];
  SlideKeys keys{.name = tip.finger,
                 .at_m = segment.X_WS_0.translation(),
                 .along = segment.X_WS_0.linear() * tip.normal,
                 .radius_m = tip.radius_m,
                 .path = slide.path};
  if (scene.has_path(k)) return keys;
  if (slide.stiffness_N_per_m > 0.0) {
    keys.spring = {slide.stiffness_N_per_m, slide.rest_m};
  } else {
    keys.force_N = slide.force_N;
    if (slide.rise_s > 0.0) keys.rise_s = slide.rise_s;
  }
  const Joint& joint = scene.hand.joints[tip.first_joint];
  keys.damping_N_s_per_m = scene.viscosity(k);
  keys.range_m = Eigen::Vector2d(joint.lower_rad, joint.upper_rad);
  return keys;
}

/// Adds the slide and its finger to the scene.
void add(const SlideKeys& keys, const std::string& name, Scene& scene) {
  const bool has_path = !keys.path.empty();
  const SlideSpring spring = keys.spring.value_or(SlideSpring{});
  scene.slides.push_back({.force_N = keys.force_N.value_or(0.0),
                          .rise_s = keys.rise_s.value_or(0.0),
                          .stiffness_N_per_m = spring.stiffness_N_per_m,
                          .rest_m = spring.rest_m,
                          .path = keys.path});
  add_slide(name, keys.at_m, keys.along, keys.radius_m, has_path, scene.hand);
  if (has_path) return;
  scene.hand.fingertips.back().joint_viscosity = keys.damping_N_s_per_m;
  if (!keys.range_m) return;
  scene.hand.joints.back().lower_rad = (*keys.range_m)[0];
  scene.hand.joints.back().upper_rad = (*keys.range_m)[1];
}

/// Makes the scene's hand of one more slide; too many are read for their faults alone.
void read_slide(Visitor& v, const SlideKeys& keys, std::size_t number, Scene& scene) {
  const std::string name = keys.name.empty() ? fmt::format("tip{}", number) : keys.name;
  const auto is_called_so = [&](const Fingertip& other) { return other.finger == name; };
  if (std::ranges::any_of(scene.hand.fingertips, is_called_so)) v.refuse("name", "is there twice: '" + name + "'");
  if (name == scene.hand.segments.front().name)
    v.refuse("name", "'frame' is what slides are fixed to: choose another one");
  if (scene.hand.fingers() < kMaxFingers) add(keys, name, scene);
}

}  // namespace

void describe_slides(Visitor& v, Scene& scene) {
  std::vector<SlideKeys> slides;
  if (v.reads()) {
    scene.hand = hand_of_slides();
    for (const char* key : {"model", "mirror", "posture", "fingers", "settle", "joint_viscosity", "torques"}) {
      if (v.has(key)) v.refuse(key, "is of a hand, and slides take its place: leave out one of them");
    }
  } else {
    for (int k = 0; k < std::ssize(scene.slides); ++k) slides.push_back(keys_of(scene, k));
  }
  std::size_t number = 0;
  v.list({"slides", kNone, "", "(Without them the scene has a hand.)",
          "One to five fingertips on slides in place of a hand. Each is driven by a force, a spring or a path."},
         slides, [&](SlideKeys& slide) {
           describe(v, slide);
           if (v.reads()) read_slide(v, slide, ++number, scene);
         });
  if (!v.reads()) return;
  if (slides.empty() || std::ssize(slides) > kMaxFingers) {
    v.refuse("slides", fmt::format("must list 1 to {} fingertips", kMaxFingers));
  }
  scene.joint_viscosity = kSlideDamping_N_s_per_m;
  scene.posture = scene.hand.at_zero();
}

}  // namespace thenar
