// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "engine/scenes/describe.h"

/// The map `environment` of a scene.
namespace thenar {

using enum Dimension;

namespace {

void describe_solid(Visitor& v, Solid& solid) {
  bool is_plane = true;
  if (v.chosen<HalfSpace>("plane", solid) != nullptr)
    v.key({"plane", kNone, "", "", "true: all that is below z = 0."}, is_plane);
  if (!is_plane) v.refuse("plane", "is true, or is left out");
  if (auto* box = v.chosen<BoxShape>("box", solid)) describe(v, *box);
  if (auto* sphere = v.chosen<SphereShape>("sphere", solid)) describe(v, *sphere);
  if (auto* cylinder = v.chosen<CylinderShape>("cylinder", solid)) describe(v, *cylinder);
  if (auto* hole = v.chosen<HoleShape>("hole", solid)) {
    v.map({"hole", kNone, "", "", "All that is below z = 0, with a blind hole down along z."}, [&] {
      double diameter_m = 2.0 * hole->radius_m;
      v.key({"diameter", kLength, "0.1 mm .. 10 m", "", "Its diameter."}, diameter_m);
      hole->radius_m = 0.5 * diameter_m;
      v.key({"depth", kLength, "0.1 mm .. 10 m", "", "Its depth."}, hole->depth_m);
      v.key({"chamfer", kLength, "0 .. 10 m", "0 mm", "The width of the chamfer at its mouth, of 45 degrees."},
            hole->chamfer_m);
      if (hole->chamfer_m >= hole->depth_m && !v.is_refused("depth"))
        v.refuse("chamfer", "must be less than the depth");
    });
  }
}

/// The friction of all bodies; nothing if they differ.
std::optional<double> same_friction(const Environment& environment) {
  std::optional<double> friction;
  for (const EnvironmentBody& body : environment.bodies) {
    if (friction && *friction != body.friction) return std::nullopt;
    friction = body.friction;
  }
  return friction;
}

/// Where a body is: at its position, or under the object.
void describe_place(Visitor& v, EnvironmentBody& body) {
  const bool is_under = v.is_there("under", body.under_gap_m.has_value());
  if (v.when(is_under)) {
    bool stands = true;
    double gap_m = body.under_gap_m.value_or(0.0);
    v.choice({"under", kNone, "object", "(Without it the body is at its position.)",
              "The object stands on the body, a plane, a box or a cylinder: its top is level and touches the object's "
              "lowest point, and its middle is below the centre of mass."},
             stands, {true});
    v.key({"gap", kLength, "0 .. 1 m", "0 m", "How far below the object it is."}, gap_m);
    body.under_gap_m = gap_m;
    for (const char* key : {"position", "rotation"}) {
      if (v.reads() && v.has(key)) v.refuse(key, "follows from under: leave out one of them");
    }
    if (std::holds_alternative<SphereShape>(body.shape) || std::holds_alternative<HoleShape>(body.shape)) {
      v.refuse("under", "is for a plane, a box or a cylinder, which have a level top");
    }
  } else if (v.has("gap")) {
    v.refuse("gap", "goes with under: object");
  }
  if (!v.when(!is_under)) return;
  describe_pose(v,
                {"position", kLength, "", "(Required without under, refused with it.)",
                 "Of its frame, in that of environment.frame."},
                {"rotation", kNone, "", "(Without it: as environment.frame is.)",
                 "Of its frame: its columns are the body's axes in environment.frame."},
                body.X_WE);
}

/// `all`: the friction of bodies that have none of their own.
void describe_body(Visitor& v, EnvironmentBody& body, const std::optional<double>& all) {
  v.key({"name", kNone, "", "(Without it: its number.)", "What it is called where it is told of."}, body.name);
  v.one_of({"shape", kNone, "", "", "Its shape, with full sizes; an axis of revolution is z."},
           [&] { describe_solid(v, body.shape); });
  describe_place(v, body);
  std::optional<double> own;
  if (!all) own = body.friction;
  v.key({"friction", kNone, "0 .. 10", "(Without it: environment.friction.)",
         "Its own coefficient of friction against the object."},
        own);
  if (!own && !all) v.refuse("friction", "is needed here, or in environment");
  body.friction = own.value_or(all.value_or(0.0));
  v.list({"move", kNone, "", "(Without it the body stays where it is.)",
          "Minimum-jerk moves, which add up. A table that moves down is an arm that lifts."},
         body.moves, [&](EnvironmentMove& move) {
           v.key({"by", kLength, "", "", "How far, along the axes of environment.frame."}, move.by_m);
           v.key({"from", kTime, ">= 0", "", "When it begins."}, move.from_s);
           v.key({"over", kTime, "> 0", "", "How long it takes."}, move.over_s);
         });
}

}  // namespace

namespace {

/// Why no body can be under the object; empty: one can.
std::string why_not_under(const Scene& scene, const Environment& environment) {
  if (scene.gravity.isZero(0.0)) return "needs gravity, which says where down is";
  if (!scene.grasp) return "";
  if (!scene.gravity_in_object_frame) {
    return "needs gravity in the object's frame, gravity: {down: [0, 0, -1], frame: object}, for how a grasp that is "
           "found turns the object in the hand is not known";
  }
  return environment.in_object_frame ? "" : "needs environment.frame: object where the grasp is found";
}

}  // namespace

void describe_environment(Visitor& v, Environment& environment, const Scene& scene) {
  if (v.is_there("frame", environment.in_object_frame)) {
    v.choice({"frame", kNone, "hand | object", "(Without it: hand.)",
              "The frame in which bodies, their moves and task.goal are: the hand's, which is the world, or the "
              "object's at the start."},
             environment.in_object_frame, {false, true});
  }
  const std::string no_under = v.is_refused("frame") ? "" : why_not_under(scene, environment);
  std::optional<double> friction;
  if (!v.reads()) friction = same_friction(environment);
  v.key({"friction",
         kNone,
         "0 .. 10",
         "(Required where a body has none of its own.)",
         "Coulomb's coefficient of friction between object and bodies.",
         {"around_friction", "friction of bodies", "", 0.0, 2.0}},
        friction);
  v.key({"compliance",
         kCompliance,
         "1e-10 m/N .. 1e-3 m/N",
         "100 nm/N",
         "How far object and body give way at each contact, by a newton in any direction.",
         {"around_m_per_N", "compliance", "m/N", 1e-9, 1e-5}},
        environment.compliance_m_per_N);
  int number = 0;
  v.list({"bodies", kNone, "", "", "The bodies."}, environment.bodies, [&](EnvironmentBody& body) {
    ++number;
    describe_body(v, body, friction);
    if (v.reads() && body.name.empty()) body.name = std::to_string(number);
    if (body.under_gap_m && !no_under.empty()) v.refuse("under", no_under);
  });
  if (environment.bodies.empty() && !v.is_refused("bodies")) v.refuse("bodies", "names no body");
}

}  // namespace thenar
