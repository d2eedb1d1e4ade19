// SPDX-License-Identifier: Apache-2.0
// Hands that are made by seeds, with the parts that files of hands have, against MuJoCo, which reads the same files:
// where their pulps are, limits, weights, couplings, moment arms and forces of muscles.

#ifdef THENAR_MUJOCO

#include "tests/imports/made_hands.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "engine/hand/muscles.h"
#include "tests/imports/imported.h"
#include "tests/imports/mujoco_model.h"

namespace thenar::made_hands_test {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Map;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

Vector3d vector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

/// A made hand: MuJoCo's model and the import of one file.
struct Judged {
  MadeHand made;
  Mujoco mujoco;
  ImportedHand import;
  Hand hand;  ///< As it is read from the file that is written of the import.
};

std::filesystem::path put(const MadeHand& made) {
  const std::filesystem::path folder = scratch();
  for (const auto& [name, text] : made.files) std::ofstream(folder / name) << text;
  return folder / made.main;
}

Judged judged(const MadeHand& made) {
  HandRequest request;
  for (const MadeTip& tip : made.tips) {
    request.tips.push_back({"", tip.finger, tip.body, vector(tip.centre_m), 0.008, vector(tip.normal).normalized()});
  }
  const std::filesystem::path file = put(made);
  Judged all{made, Mujoco(file), import_hand(read_bodies(file), request), {}};
  all.hand = written_and_read(all.import);
  return all;
}

bool says(const Judged& all, const std::string& words) {
  return std::ranges::any_of(all.import.notes,
                             [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

JointVector some_posture(const Hand& hand, std::mt19937_64& random) {
  JointVector q = hand.at_zero();
  for (std::size_t j = 0; j < hand.joints.size(); ++j) {
    const double share = static_cast<double>(random() >> 11) * 0x1p-53;
    q[static_cast<Index>(j)] = hand.joints[j].lower_rad + share * (hand.joints[j].upper_rad - hand.joints[j].lower_rad);
  }
  return q;
}

/// Returns the deepest body that carries all fingertips: the hand's frame is its.
int base_of(const Judged& all) {
  const mjModel& model = *all.mujoco.model;
  std::set<int> shared;
  for (std::size_t k = 0; k < all.made.tips.size(); ++k) {
    std::set<int> path;
    for (int b = all.mujoco.id(mjOBJ_BODY, all.made.tips[k].body); b > 0; b = model.body_parentid[b]) {
      if (k == 0 || shared.contains(b)) path.insert(b);
    }
    shared = path;
  }
  return shared.empty() ? 0 : *shared.rbegin();
}

Isometry3d pose_of(const mjData& data, int body) {
  Isometry3d X = Isometry3d::Identity();
  X.translation() = Map<const Vector3d>(data.xpos + 3 * body);
  X.linear() = Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data.xmat + 9 * body);
  return X;
}

/// Returns what MuJoCo has for each degree of freedom, as torques of the joints that lead.
JointVector led(const Judged& all, const mjtNum* of_dofs) {
  JointVector sum = all.hand.at_zero();
  for (int j = 0; j < static_cast<int>(all.hand.joints.size() + all.hand.followers.size()); ++j) {
    const int dof = all.mujoco.model->jnt_dofadr[all.mujoco.joint(all.hand.joint(j).name)];
    sum[all.hand.leader(j)] += all.hand.ratio(j) * of_dofs[dof];
  }
  return sum;
}

void expect_limits(const Judged& all) {
  const mjModel& model = *all.mujoco.model;
  std::set<int> coupled;  // Their ranges are narrowed by those of what they move.
  for (const Follower& follower : all.hand.followers) coupled.insert(follower.leader);
  for (int j = 0; j < static_cast<int>(all.hand.joints.size() + all.hand.followers.size()); ++j) {
    const Joint& joint = all.hand.joint(j);
    const int theirs = all.mujoco.joint(joint.name);
    if (model.jnt_limited[theirs] == 0) continue;
    EXPECT_GE(joint.lower_rad, model.jnt_range[2 * theirs] - 1e-9) << joint.name;
    EXPECT_LE(joint.upper_rad, model.jnt_range[2 * theirs + 1] + 1e-9) << joint.name;
    if (j >= std::ssize(all.hand.joints) || coupled.contains(j)) continue;
    EXPECT_NEAR(joint.lower_rad, model.jnt_range[2 * theirs], 1e-9) << joint.name;
    EXPECT_NEAR(joint.upper_rad, model.jnt_range[2 * theirs + 1], 1e-9) << joint.name;
  }
}

/// Expects the couplings of the file, and no other.
void expect_ties(Judged& all) {
  const mjModel& model = *all.mujoco.model;
  std::size_t ties = all.made.ties.size();
  const auto angle = [&](int joint) { return all.mujoco.data->qpos[model.jnt_qposadr[joint]]; };
  std::mt19937_64 random(3);
  all.mujoco.set(all.hand, some_posture(all.hand, random));
  for (const MadeTie& tie : all.made.ties) {
    EXPECT_NEAR(angle(all.mujoco.joint(tie.follower)), tie.ratio * angle(all.mujoco.joint(tie.leader)) + tie.offset_rad,
                1e-7);
  }
  for (int e = 0; e < model.neq; ++e) {
    if (model.eq_type[e] != mjEQ_JOINT || model.eq_active[e] == 0) continue;
    ++ties;
    const int one = model.eq_obj1id[e], other = model.eq_obj2id[e];
    const mjtNum* const a = model.eq_data + mjNEQDATA * e;
    const auto from_reference = [&](int joint) { return angle(joint) - model.qpos0[model.jnt_qposadr[joint]]; };
    EXPECT_NEAR(from_reference(one), a[0] + a[1] * from_reference(other), 1e-7) << "equality " << e;
  }
  EXPECT_EQ(all.hand.followers.size(), ties);
}

/// The largest pull of one of MuJoCo's actuators: at full control, gain and bias, and within its limits. Infinite if
/// nothing bounds it.
double pull_N(const mjModel& model, int actuator) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double least = -kInfinity, most = kInfinity;
  const mjtNum* const gain = model.actuator_gainprm + mjNGAIN * actuator;
  const mjtNum* const control = model.actuator_ctrlrange + 2 * actuator;
  const bool is_limited = model.actuator_ctrllimited[actuator] != 0;
  if (model.actuator_gaintype[actuator] == mjGAIN_MUSCLE) {
    least = gain[2] < 0.0 ? -kInfinity : -gain[2] * (is_limited ? std::min(1.0, control[1]) : 1.0);
    most = 0.0;
  } else if (model.actuator_biastype[actuator] == mjBIAS_NONE && is_limited) {
    least = std::min(gain[0] * control[0], gain[0] * control[1]);
    most = std::max(gain[0] * control[0], gain[0] * control[1]);
  }
  if (model.actuator_forcelimited[actuator] != 0) {
    least = std::max(least, model.actuator_forcerange[2 * actuator]);
    most = std::min(most, model.actuator_forcerange[2 * actuator + 1]);
  }
  const double gear = model.actuator_gear[6 * actuator];
  return -std::min(gear * least, gear * most);
}

void expect_forces(const Judged& all) {
  const mjModel& model = *all.mujoco.model;
  std::size_t driven = 0;
  for (int tendon = 0; tendon < model.ntendon; ++tendon) {
    double sum_N = 0.0;
    const Muscle* muscle = nullptr;
    for (int a = 0; a < model.nu; ++a) {
      if (model.actuator_trntype[a] != mjTRN_TENDON || model.actuator_trnid[2 * a] != tendon) continue;
      sum_N += pull_N(model, a);
      const auto named = std::ranges::find(all.hand.muscles, mj_id2name(&model, mjOBJ_ACTUATOR, a), &Muscle::name);
      if (named != all.hand.muscles.end()) muscle = &*named;
    }
    if (muscle == nullptr) continue;
    ++driven;
    if (std::isfinite(sum_N)) {
      EXPECT_NEAR(muscle->max_force_N, sum_N, 1e-9 * sum_N) << muscle->name;
    } else {
      EXPECT_TRUE(says(all, "does not say its force")) << muscle->name;
    }
  }
  EXPECT_EQ(driven, all.hand.muscles.size());
}

/// The largest errors over postures.
struct Errors {
  double pulp_m = 0.0, normal = 0.0, weight_Nm = 0.0, heaviest_Nm = 0.0;
  VectorXd arms_m;  ///< One a muscle.
};

Errors errors_of(Judged& all) {
  constexpr int kPostures = 50;
  Errors errors;
  const Hand& hand = all.hand;
  const int base = base_of(all);
  std::mt19937_64 random(8);
  HandPose pose;
  MatrixXd H(std::ssize(hand.joints), std::ssize(hand.muscles));
  errors.arms_m = VectorXd::Zero(H.cols());
  for (int i = 0; i < kPostures; ++i) {
    const JointVector q = some_posture(hand, random);
    forward_kinematics(hand, q, pose);
    all.mujoco.set(hand, q);
    const mjData& data = *all.mujoco.data;
    const Isometry3d X_WH = pose_of(data, base);
    for (std::size_t k = 0; k < all.made.tips.size(); ++k) {
      const Fingertip& tip = hand.fingertips[k];
      const Isometry3d X_WT = pose_of(data, all.mujoco.id(mjOBJ_BODY, all.made.tips[k].body));
      const Isometry3d X_WD = X_WH * pose.distal(hand, static_cast<int>(k));
      errors.pulp_m = std::max(errors.pulp_m, (X_WD * tip.centre_m - X_WT * vector(all.made.tips[k].centre_m)).norm());
      errors.normal =
          std::max(errors.normal,
                   (X_WD.linear() * tip.normal - X_WT.linear() * vector(all.made.tips[k].normal).normalized()).norm());
    }
    const Vector3d g_H = X_WH.linear().transpose() * Vector3d(0, 0, -9.81);
    const JointVector weight = led(all, data.qfrc_bias);
    errors.weight_Nm = std::max(errors.weight_Nm, (gravity_torques(hand, pose, g_H) - weight).cwiseAbs().maxCoeff());
    errors.heaviest_Nm = std::max(errors.heaviest_Nm, weight.cwiseAbs().maxCoeff());
    moment_arms(hand, pose, H);
    for (Index m = 0; m < H.cols(); ++m) {
      const int actuator = all.mujoco.id(mjOBJ_ACTUATOR, hand.muscles[static_cast<std::size_t>(m)].name);
      // MuJoCo's are how the tendon lengthens, times the gear; a muscle pulls.
      const JointVector arms = -led(all, data.actuator_moment + actuator * all.mujoco.model->nv) /
                               all.mujoco.model->actuator_gear[6 * actuator];
      errors.arms_m[m] = std::max(errors.arms_m[m], (H.col(m) - arms).cwiseAbs().maxCoeff());
    }
  }
  return errors;
}

/// Returns the largest error of a muscle's moment arms that the import tells of; 0 if it is exact.
double told_m(const std::string& note) {
  const std::string before = "at most ";
  double most_mm = 0.0;
  for (std::size_t at = note.find(before); at != std::string::npos; at = note.find(before, at + 1)) {
    most_mm = std::max(most_mm, std::stod(note.substr(at + before.size())));
  }
  return 1e-3 * most_mm;
}

// Files have 12 digits. Arms that wrap surfaces are approximations, with errors that are told, of other postures.
void expect_as_mujoco(const std::string& kind, std::uint64_t seed) {
  SCOPED_TRACE(kind + ", seed " + std::to_string(seed));
  Judged all = judged(made_hand(kind, seed));
  for (const std::string& words : all.made.noted) EXPECT_TRUE(says(all, words)) << words;
  expect_limits(all);
  expect_ties(all);
  expect_forces(all);
  const Errors errors = errors_of(all);
  EXPECT_LT(errors.pulp_m, 1e-10);
  EXPECT_LT(errors.normal, 1e-10);
  EXPECT_GT(errors.heaviest_Nm, 1e-4);
  if (!says(all, "mesh")) {  // What is not read is told.
    EXPECT_LT(errors.weight_Nm, 1e-9 * errors.heaviest_Nm);
  }
  for (Index m = 0; m < errors.arms_m.size(); ++m) {
    const std::string& note = all.import.muscle_notes[static_cast<std::size_t>(m)];
    EXPECT_LT(errors.arms_m[m], note.empty() ? 1e-10 : 1.2 * told_m(note) + 1e-4)
        << all.hand.muscles[static_cast<std::size_t>(m)].name;
    EXPECT_EQ(note.empty(), kind != "wraps");
  }
}

class MadeHands : public testing::TestWithParam<const char*> {};

TEST_P(MadeHands, AreAsMujocoHasThem) {
  for (const std::uint64_t seed : {1, 2, 3}) expect_as_mujoco(GetParam(), seed);
}

INSTANTIATE_TEST_SUITE_P(Kinds, MadeHands, testing::ValuesIn(kMadeKinds),
                         [](const auto& kind) { return std::string(kind.param); });

}  // namespace
}  // namespace thenar::made_hands_test

#endif
