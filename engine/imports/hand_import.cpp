// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/hand_import.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/formats/text.h"
#include "engine/imports/finger_chains.h"
#include "engine/imports/joint_ties.h"
#include "engine/imports/mjcf_file.h"
#include "engine/imports/muscle_import.h"
#include "engine/imports/pulp_guess.h"
#include "engine/imports/tree_segments.h"
#include "engine/imports/urdf_file.h"
#include "engine/imports/xml_tree.h"
#include "engine/scenes/config.h"

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// Limits of a hand file: beyond them lengths are hardly in m, or masses in kg.
constexpr double kLongest_m = 1.0, kHeaviest_kg = 10.0;

[[noreturn]] void refuse_body(const TreeBody& body, const std::string& what) {
  throw ConfigError({{printable(body.place), fmt::format("body '{}'", printable(body.name)), printable(what)}});
}

/// Adds the masses and centres of mass of all bodies that move with each segment's first one.
void add_masses(const BodyTree& tree, const TreePose& pose, TreeSegments& segments, Hand& hand) {
  for (std::size_t b = 1; b < tree.bodies.size(); ++b) {
    const int s = segments.of_body[b];
    if (s == 0) continue;
    Segment& segment = hand.segments[s];
    const TreeBody& body = tree.bodies[b];
    const Vector3d com_S = segment.X_WS_0.inverse() * (pose.X_HB[b] * body.com_m);
    segment.com_m += body.mass_kg * com_S;
    segment.mass_kg += body.mass_kg;
  }
  for (std::size_t s = 1; s < hand.segments.size(); ++s) {
    Segment& segment = hand.segments[s];
    const TreeBody& body = tree.bodies[segments.body[s]];
    if (segment.mass_kg > 0.0) segment.com_m /= segment.mass_kg;
    if (segment.length_m > kLongest_m || segment.X_WS_0.translation().norm() > kLongest_m) {
      refuse_body(body, fmt::format("is {:g} m long, {:g} m from the hand's origin: lengths are in m", segment.length_m,
                                    segment.X_WS_0.translation().norm()));
    }
    if (segment.mass_kg > kHeaviest_kg)
      refuse_body(body, fmt::format("weighs {:g} kg with all that is fixed to it", segment.mass_kg));
  }
}

void add_joints(const BodyTree& tree, const FingerChains& chains, const TreePose& pose, Hand& hand) {
  for (const std::vector<ChainJoint>& finger : chains.joints) {
    for (const ChainJoint& at : finger) {
      const TreeJoint& joint = tree.bodies[at.body].joints[at.joint];
      const TreeAxis& axis = pose.axes[at.body][at.joint];
      hand.joints.push_back({joint.name, axis.origin_m, axis.direction, (*joint.range)[0], (*joint.range)[1]});
    }
  }
}

bool is_capsule(const TreeRound& round) { return round.shape && round.shape->form == PulpShape::Form::kCapsule; }

/// Returns the centre of a capsule's round end that is farther from a point; of others the centre.
Vector3d far_end_m(const TreeRound& round, const Vector3d& from_B) {
  if (!is_capsule(round)) return round.centre_m;
  const Vector3d way_m = round.shape->half_m[0] * round.shape->axes.col(0);
  const double side = way_m.dot(round.centre_m - from_B) < 0.0 ? -1.0 : 1.0;
  return round.centre_m + side * way_m;
}

/// Tests whether it is a valid pulp of a hand file.
bool may_be_pulp(const TreeRound& round) {
  if (round.radius_m < 1e-3 || round.radius_m > 0.05) return false;
  if (!round.shape) return true;
  const double most_m = is_capsule(round) ? 0.1 : std::min(0.1, 4.0 * round.radius_m);
  return round.shape->half_m.maxCoeff() <= most_m;
}

/// Returns the round part of a body that reaches farthest from its last joint.
const TreeRound* farthest_round(const TreeBody& body, const Vector3d& joint_B) {
  const TreeRound* farthest = nullptr;
  double most = 0.0;
  for (const TreeRound& round : body.rounds) {
    const Vector3d way_m = far_end_m(round, joint_B) - joint_B;
    const bool is_sphere = !round.shape || is_capsule(round);
    const double reach = way_m.norm() + (is_sphere ? round.radius_m : extent_m(*round.shape, way_m.stableNormalized()));
    if (reach <= most || !may_be_pulp(round)) continue;
    most = reach;
    farthest = &round;
  }
  return farthest;
}

/// Makes the pulps; normals that were not requested remain zero.
void add_fingertips(const BodyTree& tree, const HandRequest& request, const FingerChains& chains, const TreePose& pose,
                    const TreeSegments& segments, ImportedHand& made) {
  constexpr double kRadius_m = 8e-3;  // Half of the width of a human fingertip.
  int first = 0;
  for (std::size_t k = 0; k < request.tips.size(); ++k) {
    const TipRequest& asked = request.tips[k];
    const TipPlace& place = chains.tips[k];
    const TreeBody& body = tree.bodies[place.body];
    const ChainJoint last = chains.joints[k].back();
    const Vector3d joint_B = pose.X_HB[place.body].inverse() * pose.axes[last.body][last.joint].origin_m;
    Fingertip tip;
    tip.finger = asked.finger;
    tip.first_joint = first;
    tip.joints = static_cast<int>(chains.joints[k].size());
    tip.segment = segments.of_body[place.body];
    first += tip.joints;
    Vector3d centre_B = place.X_BP * asked.centre_m.value_or(Vector3d::Zero());
    const TreeRound* const round = asked.centre_m || place.is_site ? nullptr : farthest_round(body, joint_B);
    tip.radius_m = asked.radius_m.value_or(round != nullptr ? round->radius_m : kRadius_m);
    if (round != nullptr && round->shape && !asked.radius_m) {
      centre_B = round->centre_m;
      tip.shape = round->shape;
      tip.shape->axes = pose.X_HB[place.body].linear() * tip.shape->axes;
      made.notes.push_back(fmt::format("the {}'s pulp is the {} of '{}'", asked.finger,
                                       is_capsule(*round) ? "capsule" : "ellipsoid", body.name));
    } else if (round != nullptr) {
      centre_B = far_end_m(*round, joint_B);
      made.notes.push_back(fmt::format("the {}'s pulp is where the round end of '{}' is", asked.finger, body.name));
    } else if (!asked.centre_m && !place.is_site && (centre_B - joint_B).norm() < 2e-3) {
      throw ConfigError(
          {{"--tips " + asked.text, "",
            printable(fmt::format("the origin of '{}' lies on its joint, and it has no sphere, ellipsoid or capsule: "
                                  "say where the pulp's centre is, such as {}:@0/-36/14.5mm",
                                  body.name, asked.text))}});
    }
    if (!asked.radius_m && round == nullptr) {
      made.notes.push_back(fmt::format("the {}'s pulp has a radius of 8 mm, a guess", asked.finger));
    }
    const Isometry3d X_SH = made.hand.segments[tip.segment].X_WS_0.inverse();
    tip.centre_m = X_SH * (pose.X_HB[place.body] * centre_B);
    tip.normal = Vector3d::Zero();
    if (asked.normal) {
      tip.normal = X_SH.linear() * (pose.X_HB[place.body].linear() * (place.X_BP.linear() * *asked.normal));
    }
    made.hand.fingertips.push_back(tip);
  }
}

}  // namespace

BodyTree read_bodies(const std::filesystem::path& file) {
  std::size_t left = kMostXmlElements;
  XmlElement root = read_xml(file, left);
  BodyTree tree;
  if (root.name == "robot") {
    tree = read_urdf(root);
  } else if (root.name == "mujoco") {
    tree = read_mjcf(std::move(root), file, left);
  } else {
    refuse(root, "is neither MJCF (<mujoco>) nor URDF (<robot>)");
  }
  tree.file = file.filename().string();
  return tree;
}

ImportedHand import_hand(const BodyTree& bodies, const HandRequest& request) {
  const BodyTree tree = request.uncouple ? bodies : limited_by_ties(bodies);
  const FingerChains chains = find_chains(tree, request);
  const TreePose pose = pose_tree(tree, chains);
  ImportedHand made;
  made.notes = tree.notes;
  made.notes.insert(made.notes.end(), chains.notes.begin(), chains.notes.end());
  add_joints(tree, chains, pose, made.hand);
  TreeSegments segments = make_segments(tree, chains, pose, made.hand);
  add_fingertips(tree, request, chains, pose, segments, made);
  finish_segments(made.hand);
  add_masses(tree, pose, segments, made.hand);
  guess_normals(made.hand, made.notes);
  if (made.hand.fingers() == 1) made.notes.emplace_back("a hand of one finger can press, but hold nothing");
  import_muscles(tree, pose, segments, made);
  made.hand = tied(std::move(made.hand), tree, chains, made.notes);
  if (request.mirror) {
    made.hand = mirrored(std::move(made.hand));
    made.notes.emplace_back("it is the mirror image of what the file describes");
  }
  return made;
}

}  // namespace thenar
