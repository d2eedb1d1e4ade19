// SPDX-License-Identifier: Apache-2.0
// Imported hands against MuJoCo, which reads the same files: where fingertips are, how tendons wrap, and their moment
// arms.

#ifdef THENAR_MUJOCO

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "engine/hand/muscles.h"
#include "engine/imports/wrapping.h"
#include "tests/imports/imported.h"
#include "tests/imports/mujoco_model.h"

namespace thenar::mujoco_test {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Map;
using Eigen::Matrix;
using Eigen::MatrixXd;
using Eigen::Vector3d;

JointVector random_posture(const Hand& hand, std::mt19937_64& random) {
  JointVector q = hand.at_zero();
  for (std::size_t j = 0; j < hand.joints.size(); ++j) {
    q[static_cast<Index>(j)] =
        std::uniform_real_distribution(hand.joints[j].lower_rad, hand.joints[j].upper_rad)(random);
  }
  return q;
}

/// A place of a fingertip: a body, and a point in its frame.
struct TipPoint {
  std::string body;
  Vector3d p_B;
};

/// The largest distance over 1000 postures.
double tip_error_m(const Hand& hand, Mujoco& mujoco, const std::string& base, const std::vector<TipPoint>& tips) {
  std::mt19937_64 random(5);
  HandPose pose;
  double most_m = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const JointVector q = random_posture(hand, random);
    mujoco.set(hand, q);
    forward_kinematics(hand, q, pose);
    for (std::size_t k = 0; k < tips.size(); ++k) {
      const Vector3d ours = pose.distal(hand, static_cast<int>(k)) * hand.fingertips[k].centre_m;
      const Vector3d theirs = mujoco.X_WB(base).inverse() * mujoco.X_WB(tips[k].body) * tips[k].p_B;
      most_m = std::max(most_m, (ours - theirs).norm());
    }
  }
  return most_m;
}

TEST(Mujoco, FingertipsOfAnMjcfHandAreWhereItHasThem) {
  const Hand hand = imported(hand_data("gripper.xml"), gripper());
  Mujoco mujoco(hand_data("gripper.xml"));
  EXPECT_LT(
      tip_error_m(hand, mujoco, "carpus",
                  {{"thumb_2", {0.024, 0.001, -0.003}}, {"fore_cap", {0, 0, 0}}, {"little_2", {0.028, 0, -0.003}}}),
      1e-9);
}

TEST(Mujoco, FingertipsOfAUrdfHandAreWhereItHasThem) {
  const Hand hand =
      imported(hand_data("gripper.urdf"), fingers({"thumb=thumb_tip", "finger=finger_end:@20/0/0mm:10mm"}));
  Mujoco mujoco(hand_data("gripper.urdf"));
  EXPECT_LT(tip_error_m(hand, mujoco, "palm", {{"thumb_tip", {0.002, 0, 0.001}}, {"finger_end", {0.02, 0, 0}}}), 1e-9);
}

// What `fromto` gives, which geoms have mass, and the least mass of a body.
TEST(Mujoco, PlacesSizesAndMassesAreThose) {
  const std::filesystem::path file = scratch() / "parts.xml";
  std::ofstream(file) << R"(<mujoco><compiler inertiagrouprange="0 1" boundmass="0.05"/>
    <default><geom group="1"/></default><worldbody>
    <body name="a"><joint axis="0 1 0"/>
      <site name="s" type="capsule" fromto="0.02 0.01 0 0.04 0.002 0.03" size="0.004"/>
      <geom type="ellipsoid" fromto="0.02 0 0.01 0.044 0.02 0" size="0.02"/>
      <geom type="sphere" size="0.03" pos="0 0.1 0" group="4"/></body>
    <body name="b"><joint axis="0 1 0"/><geom type="box" fromto="0 0 0 0.01 0.02 0.1" size="0.02 0.5 0.7"/></body>
    <body name="c"><joint axis="0 1 0"/><geom size="0.002"/></body></worldbody></mujoco>)";
  const BodyTree tree = read_bodies(file);
  const Mujoco mujoco(file);
  const mjModel& model = *mujoco.model;
  const Map<Vector3d> site_m(model.site_pos);
  EXPECT_LT((tree.sites[0].X_BS.translation() - site_m).norm(), 1e-12);
  const Eigen::Quaterniond turn(model.site_quat[0], model.site_quat[1], model.site_quat[2], model.site_quat[3]);
  EXPECT_LT((tree.sites[0].X_BS.linear() - turn.toRotationMatrix()).norm(), 1e-9);
  EXPECT_LT((tree.bodies[1].rounds[0].shape->half_m - Map<Vector3d>(model.geom_size)).norm(), 1e-12);
  for (const char* body : {"a", "b", "c"}) {
    const int ours = index_of_name(tree.bodies, body);
    const double kg = model.body_mass[mujoco.id(mjOBJ_BODY, body)];
    EXPECT_NEAR(tree.bodies[static_cast<std::size_t>(ours)].mass_kg, kg, 1e-9 * kg) << body;
  }
}

struct StringCase {
  WrapSurface surface;
  Vector3d a, b;
  std::optional<Vector3d> side;
};

std::vector<StringCase> random_strings(int number) {
  std::mt19937_64 random(6);
  const auto point = [&](double size) {
    std::uniform_real_distribution<double> of(-size, size);
    return Vector3d(of(random), of(random), of(random));
  };
  std::vector<StringCase> cases;
  for (int i = 0; i < number; ++i) {
    StringCase c{{0.01, i % 2 == 0}, point(0.03), point(0.03), std::nullopt};
    // Some sides are inside of the surface: then the string goes through it.
    if (i % 3 != 0) c.side = point(i % 3 == 1 ? 0.03 : 0.005);
    cases.push_back(c);
  }
  return cases;
}

/// All of them in one model.
std::string strings_mjcf(const std::vector<StringCase>& cases) {
  std::string world, tendons;
  const auto site = [&](const std::string& name, const Vector3d& p) {
    world += fmt::format("<site name='{}' pos='{:.17g} {:.17g} {:.17g}'/>\n", name, p.x(), p.y(), p.z());
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const StringCase& c = cases[i];
    const char* const type = c.surface.is_cylinder ? "type='cylinder' size='0.01 0.1'" : "type='sphere' size='0.01'";
    world += fmt::format("<geom name='g{}' {}/>\n", i, type);
    site(fmt::format("a{}", i), c.a);
    site(fmt::format("b{}", i), c.b);
    if (c.side) site(fmt::format("s{}", i), *c.side);
    const std::string side = c.side ? fmt::format(" sidesite='s{}'", i) : "";
    tendons +=
        fmt::format("<spatial><site site='a{0}'/><geom geom='g{0}'{1}/><site site='b{0}'/></spatial>\n", i, side);
  }
  return fmt::format("<mujoco><worldbody>{}</worldbody><tendon>{}</tendon></mujoco>", world, tendons);
}

TEST(Mujoco, StringsTouchSurfacesWhereItHasThem) {
  const std::vector<StringCase> cases = random_strings(900);
  const std::filesystem::path file = scratch() / "strings.xml";
  std::ofstream(file) << strings_mjcf(cases);
  Mujoco mujoco(file);
  mj_forward(mujoco.model.get(), mujoco.data.get());
  int touched = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const StringCase& c = cases[i];
    const auto touch = wrap(c.surface, c.a, c.b, c.side);
    const bool theirs = mujoco.data->ten_wrapnum[i] == 4;
    ASSERT_EQ(touch.has_value(), theirs) << "string " << i << " from " << c.a.transpose() << " to " << c.b.transpose()
                                         << " side " << c.side.value_or(Vector3d::Zero()).transpose();
    if (!touch) continue;
    ++touched;
    for (int end = 0; end < 2; ++end) {
      const Map<Vector3d> p(mujoco.data->wrap_xpos + 3 * (mujoco.data->ten_wrapadr[i] + 1 + end));
      // Through a ring, MuJoCo iterates to 1e-6 of the equation's residual. Where a string hardly bends, the root of a
      // difference that is nearly zero says where it touches: half of the digits are left.
      const bool through = (*touch)[0] == (*touch)[1];
      EXPECT_LT(((*touch)[static_cast<std::size_t>(end)] - p).norm(), through ? 1e-6 : 1e-9) << "string " << i;
    }
  }
  EXPECT_GT(touched, 300);
}

/// The hand's moment arms minus MuJoCo's, over postures that fill the joints' ranges: the largest, and the rms of the
/// joint that is worst.
struct ArmErrors {
  double most_m = 0.0, rms_m = 0.0;
};

ArmErrors arm_errors(const Hand& hand, Mujoco& mujoco, const std::string& muscle) {
  constexpr int kPostures = 1000;
  std::mt19937_64 random(7);
  const int theirs = mujoco.id(mjOBJ_ACTUATOR, muscle);
  Index ours = 0;
  while (hand.muscles[static_cast<std::size_t>(ours)].name != muscle) ++ours;
  const auto joints = static_cast<Index>(hand.joints.size());
  MatrixXd H(joints, std::ssize(hand.muscles));
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(joints);
  HandPose pose;
  ArmErrors errors;
  for (int i = 0; i < kPostures; ++i) {
    const JointVector q = random_posture(hand, random);
    mujoco.set(hand, q);
    forward_kinematics(hand, q, pose);
    moment_arms(hand, pose, H);
    for (Index j = 0; j < joints; ++j) {
      const int dof = mujoco.model->jnt_dofadr[mujoco.joint(hand.joints[static_cast<std::size_t>(j)].name)];
      // MuJoCo's is how the tendon lengthens; a muscle pulls.
      const double off = H(j, ours) + mujoco.data->actuator_moment[theirs * mujoco.model->nv + dof];
      errors.most_m = std::max(errors.most_m, std::abs(off));
      squares[j] += off * off;
    }
  }
  errors.rms_m = std::sqrt(squares.maxCoeff() / kPostures);
  return errors;
}

TEST(Mujoco, StraightTendonsHaveItsMomentArms) {
  const Hand hand = imported(hand_data("gripper.xml"), gripper());
  Mujoco mujoco(hand_data("gripper.xml"));
  for (const char* muscle : {"straight", "between"}) {
    EXPECT_LT(arm_errors(hand, mujoco, muscle).most_m, 1e-9) << muscle;
  }
}

TEST(Mujoco, WrappedTendonsHaveItsMomentArmsWithinHalfAMillimetre) {
  const ImportedHand made = import_hand(read_bodies(hand_data("gripper.xml")), gripper());
  const Hand hand = written_and_read(made);
  Mujoco mujoco(hand_data("gripper.xml"));
  for (const char* muscle : {"knuckle_muscle", "drum", "ring"}) {
    const ArmErrors errors = arm_errors(hand, mujoco, muscle);
    // The knuckle's arms depend on both of its joints, and those of lengths joint by joint do not.
    EXPECT_LT(errors.rms_m, std::string(muscle) == "knuckle_muscle" ? 1.2e-3 : 0.5e-3) << muscle;
    EXPECT_GT(errors.rms_m, 1e-6) << muscle << " wraps nothing";
    RecordProperty(std::string(muscle) + "_um_rms", static_cast<int>(1e6 * errors.rms_m));
  }
}

}  // namespace
}  // namespace thenar::mujoco_test

#endif
