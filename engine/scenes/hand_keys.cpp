// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/hand_keys.h"

#include <fmt/format.h>

#include <cmath>

#include "engine/scenes/describe.h"

namespace thenar {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using enum Dimension;

namespace {

void describe(Visitor& v, JointKeys& joint) {
  v.key({"name", kNone, "", "", "Its name."}, joint.name);
  v.key({"origin_at_q0", kNone, "-2 .. 2", "", "A point of its axis at q = 0, hand frame, in m."}, joint.origin_m);
  describe_direction(v, {"axis_at_q0", kNone, "", "", "The direction of its axis at q = 0, hand frame."}, joint.axis);
  v.key({"limits", kNone, "-6.3 .. 6.3", "", "The ends of its range, in rad: a turn each way at most."},
        joint.limits_rad);
  v.key({"follows", kNone, "", "(It turns by itself.)",
         "The joint of its finger, nearer to the palm, that it turns with: it has no angle of its own."},
        joint.follows);
  if (v.when(v.is_there("follows", !joint.follows.empty()))) {
    v.key({"ratio", kNone, "-100 .. 100", "1", "Its angle over that of the joint that it follows."}, joint.ratio);
    v.key({"offset", kNone, "-100 .. 100", "0", "What is added to that, in rad."}, joint.offset_rad);
    return;
  }
  for (const char* key : {"ratio", "offset"}) {
    if (v.has(key)) v.refuse(key, "is of a joint that follows another one: follows names that");
  }
}

void describe(Visitor& v, SegmentKeys& segment) {
  v.key({"name", kNone, "", "", "Its name."}, segment.name);
  v.key({"moved_by", kNone, "", "", "The first joints of one finger, in their order."}, segment.moved_by);
  v.key({"length", kNone, "0 .. 1", "", "Its length in m."}, segment.length_m);
  v.key({"mass", kNone, "0 .. 10", "", "Its mass in kg."}, segment.mass_kg);
  v.key({"com", kNone, "", "", "Its centre of mass, in its frame, in m."}, segment.com_m);
  v.map({"frame_at_q0", kNone, "", "", "Its frame at q = 0."}, [&] {
    Matrix3d R = segment.X_WS_0.linear();
    Vector3d origin_m = segment.X_WS_0.translation();
    v.key({"R", kNone, "", "", "Its rotation."}, R);
    v.key({"origin", kNone, "", "", "Its origin in m."}, origin_m);
    segment.X_WS_0.linear() = R;
    segment.X_WS_0.translation() = origin_m;
  });
}

void check_pulp(Visitor& v, const FingertipKeys& keys) {
  constexpr double kMostRatio = 4.0;
  if (keys.semi_axes_m) {
    for (const char* const other : {"radius", "length"}) {
      if (v.has(other)) v.refuse(other, "an ellipsoid has semi_axes alone: name these, or a radius");
    }
    if (keys.semi_axes_m->maxCoeff() > kMostRatio * keys.semi_axes_m->minCoeff()) {
      v.refuse("semi_axes", fmt::format("the largest must be at most {:g} times the least", kMostRatio));
    }
  } else if (!keys.radius_m) {
    v.refuse("radius", "is missing: a pulp has a radius, or semi_axes");
  } else if (keys.axes && !keys.length_m) {
    v.refuse("pulp_axes", "a sphere has no axes: they are of semi_axes, or of a length");
  }
}

void describe(Visitor& v, FingertipKeys& keys) {
  v.key({"finger", kNone, "", "", "Its finger's name."}, keys.finger);
  v.key({"segment", kNone, "", "", "The last segment of its finger: its `moved_by` are the finger's joints."},
        keys.segment);
  v.key({"pulp_centre", kNone, "-2 .. 2", "", "The centre of its pulp, segment frame, in m."}, keys.centre_m);
  v.key({"radius", kNone, "1e-4 .. 0.1", "(Required without semi_axes.)",
         "The radius of its pulp in m: a sphere, or with a length a capsule."},
        keys.radius_m);
  v.key({"length", kNone, "1e-4 .. 0.2", "(Without it the pulp is no capsule.)",
         "Of a capsule: from the centre of one round end to that of the other, in m. Half of it is on either side of "
         "pulp_centre."},
        keys.length_m);
  v.key({"semi_axes", kNone, "1e-4 .. 0.1", "(Without them the pulp is no ellipsoid.)",
         "Of an ellipsoid, in m: along the pulp, across it, and through it; the largest at most 4 times the least."},
        keys.semi_axes_m);
  v.key({"pulp_axes", kNone, "",
         "(Of a capsule: its first axis is the segment's x. Of an ellipsoid: its third axis is pulp_normal, its first "
         "one x less what of it is along that.)",
         "How these axes lie in the segment frame: its columns. A capsule lies along the first."},
        keys.axes);
  describe_direction(v, {"pulp_normal", kNone, "", "", "The mean outward direction of its pulp, segment frame."},
                     keys.normal);
  v.key({"joint_viscosity", kNone, "> 0 .. 1e7", "(The scene's.)", "The viscous damping of its joints in N m s."},
        keys.joint_viscosity);
  v.key({"reduced_modulus", kNone, "> 0 .. 1e13", "(The scene's.)", "The modulus E* of its pulp in Pa."},
        keys.reduced_modulus_Pa);
  v.key({"poisson", kNone, "0 .. 0.5", "(The scene's.)", "Poisson's ratio of its pulp."}, keys.poisson);
  v.key({"relaxation", kNone, ">= 0", "(The scene's.)", "The retardation time of its pulp in s."}, keys.relaxation_s);
  if (v.reads()) check_pulp(v, keys);
}

void describe(Visitor& v, CrossingKeys& crossing) {
  v.key({"joints", kNone, "", "", "The joints that it crosses."}, crossing.joints);
  v.key({"share", kNone, "0 .. 1", "1", "The share of the muscle's force."}, crossing.share);
  v.map({"insertion", kNone, "", "", "Where it pulls, distal to the joints."}, [&] {
    v.key({"segment", kNone, "", "", "The segment."}, crossing.insertion_segment);
    v.key({"pos", kNone, "", "", "The point, segment frame, in m."}, crossing.insertion_m);
  });
  v.one_of({"pull", kNone, "", "", "Where it pulls to."}, [&] {
    const bool is_point = crossing.pull_is_point;
    if (v.chooses("via", is_point)) {
      crossing.pull_is_point = true;
      v.map({"via", kNone, "", "", "A point."}, [&] {
        v.key({"segment", kNone, "", "", "Its segment."}, crossing.pull_segment);
        v.key({"pos", kNone, "", "", "Its place, segment frame, in m."}, crossing.pull);
      });
    }
    if (v.chooses("dir", !is_point)) {
      v.map({"dir", kNone, "", "", "A direction."}, [&] {
        v.key({"segment", kNone, "", "", "The segment that it turns with."}, crossing.pull_segment);
        describe_direction(v, {"vec", kNone, "", "", "Its vector, segment frame."}, crossing.pull);
      });
    }
  });
}

void describe(Visitor& v, MuscleKeys& muscle) {
  v.key({"name", kNone, "", "", "Its name."}, muscle.name);
  v.key({"max_force", kNone, "0 .. 1e4", "", "The most force that it has, in N."}, muscle.max_force_N);
  v.key({"fibre_length", kNone, "1e-3 .. 1", "(None: it has no stiffness.)", "The length of its fibres at rest, in m."},
        muscle.fibre_m);
  v.key({"tendon_stiffness", kNone, "> 0", "(Its tendon is rigid.)", "The stiffness of its tendon, in N/m."},
        muscle.tendon_N_per_m);
  v.list({"crossings", kNone, "", "", "Where its tendon crosses joints."}, muscle.crossings,
         [&](CrossingKeys& crossing) { describe(v, crossing); });
}

double rounded(double value) {
  const double near = std::round(value * 1e12) / 1e12;
  return near == 0.0 ? 0.0 : near;
}

template <typename Matrix>
Matrix rounded(const Matrix& values) {
  return values.unaryExpr([](double value) { return rounded(value); });
}

/// The first joints and followers of a finger from the palm on, as Hand::joint() counts them.
std::vector<int> chain_of(const Hand& hand, const Fingertip& tip, int joints, int followers) {
  std::vector<int> chain;
  int next = tip.first_follower;
  for (int j = 0; j < joints; ++j) {
    chain.push_back(tip.first_joint + j);
    for (; next < tip.first_follower + followers && hand.followers[next].after == j + 1; ++next) {
      chain.push_back(static_cast<int>(hand.joints.size()) + next);
    }
  }
  return chain;
}

std::vector<std::string> joint_names(const Hand& hand, const std::vector<int>& joints) {
  std::vector<std::string> names;
  for (const int joint : joints) names.push_back(hand.joint(joint).name);
  return names;
}

JointKeys keys_of(const Hand& hand, int index) {
  const Joint& joint = hand.joint(index);
  JointKeys keys{.name = joint.name,
                 .origin_m = rounded(joint.origin_m),
                 .axis = rounded(joint.axis),
                 .limits_rad = rounded(Eigen::Vector2d(joint.lower_rad, joint.upper_rad))};
  if (index < std::ssize(hand.joints)) return keys;
  const Follower& follower = hand.followers[index - hand.joints.size()];
  keys.follows = hand.joints[follower.leader].name;
  keys.ratio = rounded(follower.ratio);
  keys.offset_rad = rounded(follower.offset_rad);
  return keys;
}

SegmentKeys keys_of(const Hand& hand, const Segment& segment) {
  SegmentKeys keys{
      .name = segment.name,
      .moved_by = joint_names(hand, chain_of(hand, hand.fingertips[segment.finger], segment.joints, segment.followers)),
      .length_m = rounded(segment.length_m),
      .mass_kg = rounded(segment.mass_kg),
      .com_m = rounded(segment.com_m)};
  keys.X_WS_0.linear() = rounded(Matrix3d(segment.X_WS_0.linear()));
  keys.X_WS_0.translation() = rounded(Vector3d(segment.X_WS_0.translation()));
  return keys;
}

FingertipKeys keys_of(const Hand& hand, const Fingertip& tip) {
  FingertipKeys keys{.finger = tip.finger,
                     .segment = hand.segments[tip.segment].name,
                     .centre_m = rounded(tip.centre_m),
                     .normal = rounded(tip.normal),
                     .joint_viscosity = tip.joint_viscosity,
                     .reduced_modulus_Pa = tip.reduced_modulus_Pa,
                     .poisson = tip.poisson,
                     .relaxation_s = tip.relaxation_s};
  const bool is_ellipsoid = tip.shape && tip.shape->form == PulpShape::Form::kEllipsoid;
  if (is_ellipsoid) keys.semi_axes_m = rounded(tip.shape->half_m);
  if (!is_ellipsoid) keys.radius_m = rounded(tip.radius_m);
  if (tip.shape && !is_ellipsoid) keys.length_m = rounded(2.0 * tip.shape->half_m[0]);
  if (tip.shape) keys.axes = rounded(tip.shape->axes);
  return keys;
}

MuscleKeys keys_of(const Hand& hand, const Muscle& muscle) {
  MuscleKeys keys{.name = muscle.name, .max_force_N = rounded(muscle.max_force_N)};
  if (muscle.fibre_m) keys.fibre_m = rounded(*muscle.fibre_m);
  if (std::isfinite(muscle.tendon_N_per_m)) keys.tendon_N_per_m = rounded(muscle.tendon_N_per_m);
  for (const MuscleCrossing& crossing : muscle.crossings) {
    keys.crossings.push_back({.joints = joint_names(hand, crossing.joints),
                              .share = rounded(crossing.share),
                              .insertion_segment = hand.segments[crossing.insertion_segment].name,
                              .insertion_m = rounded(crossing.insertion_m),
                              .pull_segment = hand.segments[crossing.pull_segment].name,
                              .pull = rounded(crossing.pull),
                              .pull_is_point = crossing.pull_is_point});
  }
  return keys;
}

}  // namespace

void describe(Visitor& v, HandKeys& hand) {
  v.list({"joints", kNone, "", "", "The joints, finger by finger, each from the palm on: up to five a finger."},
         hand.joints, [&](JointKeys& joint) { describe(v, joint); });
  v.list({"segments", kNone, "", "", "The bones but for the palm."}, hand.segments,
         [&](SegmentKeys& segment) { describe(v, segment); });
  v.list({"fingertips", kNone, "", "", "The fingertips, one a finger, in the order of the joints: up to five."},
         hand.fingertips, [&](FingertipKeys& tip) { describe(v, tip); });
  v.list({"muscles", kNone, "", "(Without them torques drive the joints.)", "The muscles."}, hand.muscles,
         [&](MuscleKeys& muscle) { describe(v, muscle); });
}

HandKeys keys_of(const Hand& hand) {
  HandKeys keys;
  for (const Fingertip& tip : hand.fingertips) {
    for (const int joint : chain_of(hand, tip, tip.joints, tip.followers)) keys.joints.push_back(keys_of(hand, joint));
    keys.fingertips.push_back(keys_of(hand, tip));
  }
  for (std::size_t s = 1; s < hand.segments.size(); ++s) keys.segments.push_back(keys_of(hand, hand.segments[s]));
  for (const Muscle& muscle : hand.muscles) keys.muscles.push_back(keys_of(hand, muscle));
  return keys;
}

}  // namespace thenar
