// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/finger_chains.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "engine/formats/text.h"
#include "engine/hand/hand.h"
#include "engine/scenes/config.h"

namespace thenar {

using Eigen::Isometry3d;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

[[noreturn]] void refuse_at(const std::string& place, const std::string& key, const std::string& what) {
  throw ConfigError({{printable(place), printable(key), printable(what)}});
}

std::string in_units(const TreeJoint& joint, double value) {
  return joint.kind == TreeJointKind::kSlide ? fmt::format("{:g} mm", 1e3 * value)
                                             : fmt::format("{:g} deg", value / kDegree);
}

template <typename Items>
std::vector<std::string_view> names_of(const Items& items) {
  std::vector<std::string_view> names;
  for (const auto& item : items) names.push_back(item.name);
  return names;
}

/// Finds the site or body of this name.
TipPlace place_of(const BodyTree& tree, const std::string& name, const std::string& flag) {
  if (const int site = index_of_name(tree.sites, name); site >= 0) {
    return {tree.sites[site].body, tree.sites[site].X_BS, true};
  }
  if (const int body = index_of_name(tree.bodies, name); body >= 0) return {body, Isometry3d::Identity(), false};
  std::vector<std::string_view> names = names_of(tree.bodies);
  const std::vector<std::string_view> sites = names_of(tree.sites);
  names.insert(names.end(), sites.begin(), sites.end());
  refuse_at(
      flag, "",
      fmt::format("no body or site of {} is named '{}'{}", tree.file, name, did_you_mean(nearest_word(name, names))));
}

std::vector<int> path_to(const BodyTree& tree, int body) {
  std::vector<int> path{body};
  while (path.back() != 0) path.push_back(tree.bodies[path.back()].parent);
  std::reverse(path.begin(), path.end());
  return path;
}

bool turns(const TreeBody& body) {
  return std::ranges::any_of(body.joints, [](const TreeJoint& joint) { return joint.kind == TreeJointKind::kHinge; });
}

/// Returns the number of first bodies of all paths that are not a finger's: the shared ones; for a single finger those
/// up to the base, or to the body of its first hinge.
std::size_t shared_length(const BodyTree& tree, const std::vector<std::vector<int>>& paths, int base) {
  const std::vector<int>& first = paths.front();
  std::size_t shared = first.size();
  for (const std::vector<int>& path : paths) {
    const auto differ = std::mismatch(first.begin(), first.end(), path.begin(), path.end());
    shared = std::min(shared, static_cast<std::size_t>(differ.first - first.begin()));
  }
  if (paths.size() > 1) return shared;
  if (const auto on_it = std::ranges::find(first, base); base >= 0 && on_it != first.end()) {
    return static_cast<std::size_t>(on_it - first.begin()) + 1;
  }
  const auto hinge = std::ranges::find_if(first, [&](int body) { return turns(tree.bodies[body]); });
  return static_cast<std::size_t>(hinge - first.begin());
}

/// Returns the joints that a request locks, by name, with their offsets.
std::set<std::string> apply_locks(const BodyTree& tree, const HandRequest& request, FingerChains& chains) {
  std::set<std::string> locked;
  for (const LockRequest& lock : request.locks) {
    std::vector<std::string_view> names;
    bool found = false;
    for (std::size_t b = 0; b < tree.bodies.size(); ++b) {
      for (std::size_t j = 0; j < tree.bodies[b].joints.size(); ++j) {
        const TreeJoint& joint = tree.bodies[b].joints[j];
        names.push_back(joint.name);
        if (joint.name != lock.joint) continue;
        found = true;
        const double value = lock.value.value_or(joint.reference);
        chains.offsets[b][j] = value - joint.reference;
        chains.notes.push_back(fmt::format("joint '{}' is locked at {}, as asked", joint.name, in_units(joint, value)));
      }
    }
    if (!found) {
      refuse_at("--lock", "",
                fmt::format("no joint of {} is named '{}'{}", tree.file, lock.joint,
                            did_you_mean(nearest_word(lock.joint, names))));
    }
    locked.insert(lock.joint);
  }
  return locked;
}

void expect_hinge(const TreeJoint& joint, const std::string& finger) {
  const std::string key = fmt::format("joint '{}'", joint.name);
  if (joint.kind != TreeJointKind::kHinge) {
    const char* const kind = joint.kind == TreeJointKind::kSlide  ? "slides"
                             : joint.kind == TreeJointKind::kBall ? "is a ball joint"
                                                                  : "is free";
    refuse_at(joint.place, key,
              fmt::format("{}, and the {} hangs on it: make it a hinge (URDF: revolute), or lock it, if other joints "
                          "move the finger: --lock {}",
                          kind, finger, joint.name));
  }
  if (!joint.range) {
    refuse_at(joint.place, key,
              fmt::format("has no limits, and the {} hangs on it: give it a range, or lock it, if other joints move "
                          "the finger: --lock {}",
                          finger, joint.name));
  }
  constexpr double kTurn_rad = 6.3;
  const double most_rad = std::max(std::abs((*joint.range)[0]), std::abs((*joint.range)[1]));
  if (most_rad > kTurn_rad) {
    refuse_at(joint.place, key,
              fmt::format("turns by up to {:.3g} rad, more than a whole turn: are its limits in degrees?", most_rad));
  }
}

/// Returns the joints of the paths behind their shared part.
void find_joints(const BodyTree& tree, const HandRequest& request, const std::vector<std::vector<int>>& paths,
                 std::size_t shared, const std::set<std::string>& locked, FingerChains& chains) {
  std::vector<int> taken(tree.bodies.size(), -1);
  for (std::size_t k = 0; k < paths.size(); ++k) {
    std::vector<ChainJoint>& joints = chains.joints.emplace_back();
    const std::string& finger = request.tips[k].finger;
    for (std::size_t i = shared; i < paths[k].size(); ++i) {
      const int b = paths[k][i];
      for (std::size_t j = 0; j < tree.bodies[b].joints.size(); ++j) {
        const TreeJoint& joint = tree.bodies[b].joints[j];
        if (locked.contains(joint.name)) continue;
        expect_hinge(joint, finger);
        if (taken[b] >= 0) {
          refuse_at(
              joint.place, fmt::format("joint '{}'", joint.name),
              fmt::format("moves both the {} and the {}: a hand's joints move one finger each (--lock {} locks it)",
                          request.tips[taken[b]].finger, finger, joint.name));
        }
        joints.push_back({b, static_cast<int>(j)});
        chains.offsets[b][j] = -joint.reference;
      }
    }
    for (const ChainJoint& joint : joints) taken[joint.body] = static_cast<int>(k);
    const std::string flag = "--tips " + request.tips[k].text;
    if (joints.empty()) refuse_at(flag, "", "no joint moves it against the other fingers");
    if (std::ssize(joints) > kMaxFingerJoints) {
      refuse_at(flag, "",
                fmt::format("{} joints move it, and a finger has at most {}: --lock locks one, or --base names a "
                            "body nearer to it",
                            joints.size(), kMaxFingerJoints));
    }
  }
}

bool is_chosen(const BodyTree& tree, const FingerChains& chains, const std::string& name) {
  for (const std::vector<ChainJoint>& finger : chains.joints) {
    for (const ChainJoint& joint : finger) {
      if (tree.bodies[joint.body].joints[joint.joint].name == name) return true;
    }
  }
  return false;
}

void find_moved(const BodyTree& tree, FingerChains& chains) {
  chains.moved_with.assign(tree.bodies.size(), -1);
  std::vector<bool> has_joint(tree.bodies.size(), false);
  for (const std::vector<ChainJoint>& finger : chains.joints) {
    for (const ChainJoint& joint : finger) has_joint[joint.body] = true;
  }
  for (std::size_t b = 1; b < tree.bodies.size(); ++b) {
    chains.moved_with[b] = has_joint[b] ? static_cast<int>(b) : chains.moved_with[tree.bodies[b].parent];
  }
}

/// Explains why joints cannot be coupled as in the file.
std::string fault_of(const TreeCoupling& coupling, const BodyTree& tree) {
  const std::vector<std::string_view> names = joint_names(tree);
  for (const std::string& joint : coupling.joints) {
    if (std::ranges::find(names, joint) != names.end()) continue;
    return fmt::format("to another one, but no joint that moves is named '{}'{}", joint,
                       did_you_mean(nearest_word(joint, names)));
  }
  if (!coupling.fault.empty()) return coupling.fault;
  return "to another joint or drive, and a joint follows one of its own finger, by a multiple of its angle";
}

/// Collects couplings between the fingers' joints, and refuses those to anything else.
void find_ties(const BodyTree& tree, const HandRequest& request, FingerChains& chains) {
  for (std::size_t i = 0; i < tree.couplings.size(); ++i) {
    const TreeCoupling& coupling = tree.couplings[i];
    std::vector<std::string_view> own;
    for (const std::string& joint : coupling.joints) {
      if (is_chosen(tree, chains, joint)) own.push_back(joint);
    }
    if (std::ssize(own) < coupling.least) continue;
    const std::string joints = join(own, ", ");
    if (request.uncouple) {
      chains.notes.push_back(fmt::format("{} is left out: {} moves by itself, as asked", coupling.what, joints));
      continue;
    }
    if (coupling.line && own.front() != coupling.joints.front()) {
      chains.notes.push_back(fmt::format("{} is left out: '{}' moves no finger", coupling.what, coupling.joints[0]));
    } else if (coupling.line && own.size() == 2) {
      chains.ties.push_back(static_cast<int>(i));
    } else {
      refuse_at(coupling.place, coupling.what,
                fmt::format("couples {} {}: lock it (--lock {}), or leave the coupling out (--uncouple)", joints,
                            fault_of(coupling, tree), own.back()));
    }
  }
}

void refuse_loops(const BodyTree& tree, FingerChains& chains) {
  for (const TreeLoop& loop : tree.loops) {
    const bool in_finger = chains.moved_with[loop.bodies[0]] >= 0 || chains.moved_with[loop.bodies[1]] >= 0;
    if (in_finger) {
      refuse_at(loop.place, loop.what,
                fmt::format("closes a loop between '{}' and '{}': a finger is a chain of joints",
                            tree.bodies[loop.bodies[0]].name, tree.bodies[loop.bodies[1]].name));
    }
    chains.notes.push_back(loop.what + " is left out: it holds no finger");
  }
}

/// Adds notes for all fixed joints: those of the arm and wrist, and those that move no named fingertip.
void note_locked(const BodyTree& tree, const std::vector<int>& arm, const std::set<std::string>& locked,
                 FingerChains& chains) {
  for (std::size_t b = 1; b < tree.bodies.size(); ++b) {
    const bool carries_all = std::ranges::find(arm, static_cast<int>(b)) != arm.end();
    for (const TreeJoint& joint : tree.bodies[b].joints) {
      if (locked.contains(joint.name) || is_chosen(tree, chains, joint.name)) continue;
      const bool is_loose = joint.kind == TreeJointKind::kFree || joint.kind == TreeJointKind::kBall;
      const std::string at = is_loose ? "" : " at its reference value, " + in_units(joint, joint.reference);
      chains.notes.push_back(fmt::format("joint '{}' is locked{}: it moves {}", joint.name, at,
                                         carries_all ? "all fingers" : "no named fingertip"));
    }
  }
}

}  // namespace

FingerChains find_chains(const BodyTree& tree, const HandRequest& request) {
  FingerChains chains;
  if (request.tips.empty() || std::ssize(request.tips) > kMaxFingers) {
    refuse_at("--tips", "", fmt::format("names {} fingers: a hand has 1 to {}", request.tips.size(), kMaxFingers));
  }
  for (const TreeBody& body : tree.bodies) chains.offsets.emplace_back(body.joints.size(), 0.0);
  const std::set<std::string> locked = apply_locks(tree, request, chains);
  std::vector<std::vector<int>> paths;
  std::set<std::string> fingers;
  for (const TipRequest& tip : request.tips) {
    if (!fingers.insert(tip.finger).second) refuse_at("--tips " + tip.text, "", "this finger is there twice");
    chains.tips.push_back(place_of(tree, tip.place, "--tips " + tip.text));
    if (chains.tips.back().is_site && index_of_name(tree.bodies, tip.place) >= 0) {
      chains.notes.push_back(fmt::format("'{}' is the site of this name: a body has it too", tip.place));
    }
    paths.push_back(path_to(tree, chains.tips.back().body));
  }
  const TipPlace base = request.base.empty() ? TipPlace{-1, Isometry3d::Identity(), false}
                                             : place_of(tree, request.base, "--base " + request.base);
  const std::size_t shared = shared_length(tree, paths, base.body);
  find_joints(tree, request, paths, shared, locked, chains);
  find_moved(tree, chains);
  find_ties(tree, request, chains);
  refuse_loops(tree, chains);
  const std::vector<int> arm(paths.front().begin(), paths.front().begin() + static_cast<std::ptrdiff_t>(shared));
  note_locked(tree, arm, locked, chains);
  chains.base = base.body >= 0 ? base.body : arm.back();
  if (chains.moved_with[chains.base] >= 0) refuse_at("--base " + request.base, "", "a joint of a finger moves it");
  chains.X_BH = base.X_BP;
  chains.X_BH.linear() = base.X_BP.linear() * request.R_BH;
  return chains;
}

}  // namespace thenar
