// SPDX-License-Identifier: Apache-2.0
// Hands from MJCF and URDF: what is read, what is refused and with which words.

#include "engine/imports/hand_import.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "engine/hand/muscles.h"
#include "tests/imports/imported.h"

namespace thenar::hand_import_test {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;

bool says(const std::vector<std::string>& notes, const std::string& words) {
  return std::ranges::any_of(notes, [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

/// A finger of two hinges on a palm, with places to put more.
std::string finger_mjcf(const std::string& in_palm = "", const std::string& in_tip = "", const std::string& after = "",
                        const std::string& joint = "axis='0 1 0' range='0 90'") {
  return "<mujoco>\n<worldbody>\n<body name='palm'>\n" + in_palm + "<body name='a' pos='0.1 0 0'>\n<joint name='a1' " +
         joint +
         "/>\n<body name='b' pos='0.04 0 0'>\n<joint name='b1' axis='0 1 0' range='0 90'/>\n"
         "<geom type='sphere' size='0.008' pos='0.03 0 0'/>\n" +
         in_tip + "</body></body></body>\n</worldbody>\n" + after + "</mujoco>\n";
}

const std::string kThumb =
    "<body name='c' pos='0.02 0 -0.05'><joint name='c1' axis='0 -1 0' range='0 90'/>"
    "<geom type='sphere' size='0.009' pos='0.05 0 0.01'/></body>\n";

TEST(HandImport, TakesJointsLimitsMassesAndPulps) {
  const ImportedHand made = imported_text("hand.xml", finger_mjcf(kThumb), fingers({"thumb=c", "index=b"}));
  const Hand hand = written_and_read(made);
  ASSERT_EQ(hand.fingers(), 2);
  ASSERT_EQ(hand.joints.size(), 3U);
  EXPECT_EQ(hand.joints[1].name, "a1");
  EXPECT_NEAR(hand.joints[1].upper_rad, 90 * kDegree, 1e-12) << "MJCF has degrees unless it says radian";
  EXPECT_TRUE(hand.joints[1].origin_m.isApprox(Vector3d(0.1, 0, 0), 1e-12));
  EXPECT_DOUBLE_EQ(hand.fingertips[0].radius_m, 0.009);
  EXPECT_TRUE(hand.muscles.empty());
  const Segment& last = hand.segments[hand.fingertips[1].segment];
  const double mass_kg = 1000.0 * 4.0 / 3.0 * std::numbers::pi * std::pow(0.008, 3);
  EXPECT_NEAR(last.mass_kg, mass_kg, 1e-12);
  EXPECT_TRUE((last.X_WS_0 * last.com_m).isApprox(Vector3d(0.17, 0, 0), 1e-9));
  EXPECT_TRUE((last.X_WS_0 * hand.fingertips[1].centre_m).isApprox(Vector3d(0.17, 0, 0), 1e-9));
  // The thumb lies at -z of the finger, whose pulp looks there, 20 degrees towards its tip, which is at x.
  const Vector3d normal = last.X_WS_0.linear() * hand.fingertips[1].normal;
  EXPECT_TRUE(normal.isApprox(Vector3d(std::sin(20 * kDegree), 0, -std::cos(20 * kDegree)), 1e-9)) << normal;
  EXPECT_TRUE(says(made.notes, "the index's pulp faces the first finger, a guess"));
}

/// Where the pulp's surface faces n, and how it lies, in the hand frame.
Vector3d support_H(const Hand& hand, const Fingertip& tip, const Vector3d& n_H) {
  const Isometry3d& X_HS = hand.segments[tip.segment].X_WS_0;
  return X_HS * (tip.centre_m + support_m(*tip.shape, X_HS.linear().transpose() * n_H));
}

// The surface of a geom in the file is that of the pulp in the hand file, wherever the segment's axes are.
TEST(HandImport, TakesCapsulesAndEllipsoidsWhole) {
  const std::string other = "<geom type='sphere' size='0.008' pos='0.03 0 0'/>\n";
  const auto with = [&](const std::string& geom) {
    std::string text = finger_mjcf(kThumb);
    return text.replace(text.find(other), other.size(), geom);
  };
  const HandRequest request = fingers({"thumb=c", "index=b"});
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const auto direction = [&] { return Vector3d(normal(random), normal(random), normal(random)).normalized(); };

  // Body b is at x = 0.14 m with the palm's axes.
  const ImportedHand capsule =
      imported_text("a.xml", with("<geom type='capsule' fromto='0.01 0 0 0.03 0 0.002' size='0.007'/>"), request);
  const Hand hand = written_and_read(capsule);
  EXPECT_TRUE(says(capsule.notes, "the index's pulp is the capsule of 'b'"));
  const Fingertip& tip = hand.fingertips[1];
  ASSERT_TRUE(tip.shape);
  EXPECT_EQ(tip.shape->form, PulpShape::Form::kCapsule);
  EXPECT_NEAR(tip.radius_m, 0.007, 1e-12);
  const Vector3d from(0.15, 0, 0), to(0.17, 0, 0.002);
  for (int i = 0; i < 50; ++i) {
    const Vector3d n = direction();
    const Vector3d end = n.dot(to - from) > 0.0 ? to : from;
    EXPECT_LE((support_H(hand, tip, n) - end - 0.007 * n).norm(), 1e-11);
  }

  const ImportedHand ellipsoid = imported_text(
      "b.xml", with("<geom type='ellipsoid' size='0.012 0.008 0.006' pos='0.02 0 0' euler='0 0 90'/>"), request);
  const Hand other_hand = written_and_read(ellipsoid);
  EXPECT_TRUE(says(ellipsoid.notes, "the index's pulp is the ellipsoid of 'b'"));
  const Vector3d half(0.008, 0.012, 0.006);  // turned by 90 degrees about z
  for (int i = 0; i < 50; ++i) {
    const Vector3d n = direction();
    const Vector3d on = half.cwiseAbs2().cwiseProduct(n) / half.cwiseProduct(n).norm();
    EXPECT_LE((support_H(other_hand, other_hand.fingertips[1], n) - Vector3d(0.16, 0, 0) - on).norm(), 1e-11);
  }

  // A radius makes it the sphere at the far end, and what no hand file takes is no pulp.
  const Hand round = written_and_read(
      imported_text("c.xml", with("<geom type='capsule' fromto='0.01 0 0 0.03 0 0.002' size='0.007'/>"),
                    fingers({"thumb=c", "index=b:6mm"})));
  EXPECT_FALSE(round.fingertips[1].shape);
  EXPECT_NEAR(round.fingertips[1].radius_m, 0.006, 1e-12);
  EXPECT_TRUE((round.segments[round.fingertips[1].segment].X_WS_0 * round.fingertips[1].centre_m).isApprox(to, 1e-9));
  const Hand thin = written_and_read(
      imported_text("d.xml", with("<geom type='ellipsoid' size='0.03 0.008 0.006' pos='0.02 0 0'/>" + other), request));
  EXPECT_FALSE(thin.fingertips[1].shape);

  const std::string urdf =
      "<robot name='r'><link name='p'/><link name='a'/><link name='b'><collision><origin xyz='0.02 0 0' "
      "rpy='0 1.5707963267948966 0'/><geometry><capsule radius='0.007' length='0.02'/></geometry></collision></link>"
      "<link name='c'><collision><origin xyz='0.03 0 0'/><geometry><sphere "
      "radius='0.01'/></geometry></collision></link>"
      "<joint name='a1' type='revolute'><parent link='p'/><child link='a'/><axis xyz='0 1 0'/><limit lower='0' "
      "upper='1'/></joint><joint name='b1' type='revolute'><parent link='a'/><child link='b'/><origin xyz='0.04 0 0'/>"
      "<axis xyz='0 1 0'/><limit lower='0' upper='1'/></joint><joint name='c1' type='revolute'><parent link='p'/>"
      "<child link='c'/><origin xyz='0 0 -0.05'/><axis xyz='0 -1 0'/><limit lower='0' upper='1'/></joint></robot>";
  const Hand robot = written_and_read(imported_text("r.urdf", urdf, request));
  ASSERT_TRUE(robot.fingertips[1].shape);
  EXPECT_NEAR(robot.fingertips[1].shape->half_m[0], 0.01, 1e-12);
  EXPECT_LE((support_H(robot, robot.fingertips[1], Vector3d::UnitX()) - Vector3d(0.077, 0, 0)).norm(), 1e-9);
}

TEST(HandImport, WritesWhatReadsBack) {
  const ImportedHand made = import_hand(read_bodies(hand_data("gripper.xml")), gripper());
  const Hand hand = written_and_read(made);
  std::mt19937_64 random(3);
  HandPose one, other;
  for (int i = 0; i < 50; ++i) {
    JointVector q = hand.at_zero();
    for (Index j = 0; j < q.size(); ++j) q[j] = std::uniform_real_distribution(-1.0, 1.0)(random);
    forward_kinematics(made.hand, q, one);
    forward_kinematics(hand, q, other);
    for (int k = 0; k < hand.fingers(); ++k) {
      // 12 digits of lengths below 1 m, and of directions on lever arms below 1 m, in a chain of 5.
      const Vector3d a = one.distal(made.hand, k) * made.hand.fingertips[k].centre_m;
      const Vector3d b = other.distal(hand, k) * hand.fingertips[k].centre_m;
      EXPECT_LT((a - b).norm(), 2e-11);
    }
  }
  EXPECT_EQ(hand.muscles.size(), made.hand.muscles.size());
}

TEST(HandImport, ReadsUrdf) {
  const ImportedHand made = import_hand(read_bodies(hand_data("gripper.urdf")),
                                        fingers({"thumb=thumb_tip", "finger=finger_end:@20/0/0mm:10mm"}));
  const Hand hand = written_and_read(made);
  ASSERT_EQ(hand.joints.size(), 5U);
  EXPECT_TRUE(hand.joints[2].axis.isApprox(Vector3d(std::cos(0.1), std::sin(0.1), 0), 1e-12))
      << "URDF's axis is x unless it says so";
  EXPECT_EQ(hand.joints[3].lower_rad, 0.0);
  EXPECT_DOUBLE_EQ(hand.fingertips[0].radius_m, 0.011) << "of the sphere";
  const Segment& thumb_end = hand.segments[hand.fingertips[0].segment];
  EXPECT_NEAR(thumb_end.mass_kg, 0.03, 1e-12) << "with the link that is fixed to it";
  EXPECT_EQ(thumb_end.name, "thumb_end");
}

TEST(HandImport, LocksTheWristAndWhatMovesNoFingertip) {
  const ImportedHand made = import_hand(read_bodies(hand_data("gripper.xml")), gripper());
  EXPECT_TRUE(says(made.notes, "joint 'wrist_turn' is locked at its reference value, 12 deg: it moves all fingers"));
  EXPECT_TRUE(says(made.notes, "tendons that move no finger are left out: wrist_muscle"));
  const ImportedHand two =
      import_hand(read_bodies(hand_data("gripper.xml")), fingers({"thumb=thumb_2:@24/1/-3mm", "little=little_tip"}));
  EXPECT_TRUE(
      says(two.notes, "joint 'fore_bend' is locked at its reference value, 0 deg: it moves no named fingertip"));
  HandRequest locked = gripper();
  locked.locks.push_back(read_lock("fore_flex=20deg"));
  EXPECT_EQ(import_hand(read_bodies(hand_data("gripper.xml")), locked).hand.joints.size(), 8U);
}

TEST(HandImport, AHandFrameOfChoiceMovesNoFingertipAgainstAnother) {
  const BodyTree tree = read_bodies(hand_data("gripper.xml"));
  HandRequest other = gripper();
  other.base = "forearm";
  other.R_BH = read_axes("z,-x");
  const Hand a = import_hand(tree, gripper()).hand, b = import_hand(tree, other).hand;
  const auto tip = [](const Hand& hand, int k) {
    const Fingertip& at = hand.fingertips[k];
    return Vector3d(hand.segments[at.segment].X_WS_0 * at.centre_m);
  };
  EXPECT_GT((tip(a, 0) - tip(b, 0)).norm(), 0.01);
  EXPECT_NEAR((tip(a, 0) - tip(a, 1)).norm(), (tip(b, 0) - tip(b, 1)).norm(), 1e-12);
  EXPECT_NEAR((tip(a, 0) - tip(a, 2)).norm(), (tip(b, 0) - tip(b, 2)).norm(), 1e-12);
}

// A mirror turns both sides of every equation of the hand alike: tips are mirrored, and moment arms stay.
TEST(HandImport, TheMirroredHandMovesAsTheMirrorImage) {
  const Hand hand = import_hand(read_bodies(hand_data("gripper.xml")), gripper()).hand;
  const Hand other = mirrored(hand);
  std::mt19937_64 random(4);
  HandPose pose, image;
  const auto joints = static_cast<Index>(hand.joints.size());
  Eigen::MatrixXd H(joints, std::ssize(hand.muscles)), H_image = H;
  for (int i = 0; i < 50; ++i) {
    JointVector q = hand.at_zero();
    for (Index j = 0; j < q.size(); ++j) q[j] = std::uniform_real_distribution(-1.0, 1.5)(random);
    forward_kinematics(hand, q, pose);
    forward_kinematics(other, q, image);
    for (int k = 0; k < hand.fingers(); ++k) {
      const Vector3d tip = pose.distal(hand, k) * hand.fingertips[k].centre_m;
      EXPECT_LT((image.distal(other, k) * other.fingertips[k].centre_m - Vector3d(tip.x(), tip.y(), -tip.z())).norm(),
                1e-14);
    }
    EXPECT_NEAR(image.segments.back().linear().determinant(), 1.0, 1e-12);
    moment_arms(hand, pose, H);
    moment_arms(other, image, H_image);
    EXPECT_LT((H - H_image).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(HandImport, AFrameInABodyMovesWhatItHolds) {
  const std::string plain = finger_mjcf(kThumb);
  std::string framed = plain;
  const std::string joint = "<joint name='b1' axis='0 1 0' range='0 90'/>";
  framed.replace(framed.find("pos='0.04 0 0'"), 14, "pos='0.01 0 0'");
  framed.replace(framed.find("<body name='b'"), 0, "<frame pos='0.03 0 0'>");
  framed.replace(framed.find("</body></body></body>"), 7, "</body></frame>");
  const HandRequest request = fingers({"thumb=c", "index=b"});
  const Hand a = imported_text("a.xml", plain, request).hand, b = imported_text("b.xml", framed, request).hand;
  EXPECT_TRUE(a.joints[2].origin_m.isApprox(b.joints[2].origin_m, 1e-14));
}

TEST(HandImport, SaysWhichFingertipIsUnknown) {
  const std::string said = refusal("hand.xml", finger_mjcf(kThumb), fingers({"thumb=c", "index=plam"}));
  EXPECT_EQ(said, "--tips index=plam: no body or site of hand.xml is named 'plam', did you mean 'palm'?");
}

TEST(HandImport, RefusesWithTheLine) {
  const HandRequest request = fingers({"thumb=c", "index=b"});
  const auto expect = [&](const std::string& text, int line, const std::string& words) {
    const std::string said = refusal("hand.xml", text, request);
    EXPECT_NE(said.find("hand.xml:" + std::to_string(line) + ": "), std::string::npos) << said;
    EXPECT_NE(said.find(words), std::string::npos) << said;
  };
  expect(finger_mjcf(kThumb, "", "<equality>\n<connect name='pin' body1='b' body2='c' anchor='0 0 0'/></equality>"), 13,
         "equality connect 'pin': closes a loop between 'b' and 'c'");
  expect(finger_mjcf(kThumb, "", "<equality><weld body1='a'/></equality>"), 12, "closes a loop");
  const auto tied = [&](const std::string& words) {
    return finger_mjcf(kThumb, "", "<equality><joint name='e' " + words + "/></equality>");
  };
  expect(tied("joint1='a1' joint2='c1'"), 12, "equality joint 'e': couples a1 of the index to c1 of the thumb");
  expect(tied("joint1='a1'"), 12, "equality joint 'e': couples a1 to nothing but the angle 0 deg, where it stays");
  expect(tied("joint1='a1' joint2='b1' polycoef='0.5 0'"), 12, "to nothing but the angle 28.6479 deg");
  expect(tied("joint1='b1' joint2='a1' polycoef='0 1 0.1'"), 12, "couples b1, a1 by a polynomial");
  expect(tied("joint1='b1' joint2='a1' polycoef='2 1'"), 12, "no range of 'a1' keeps what follows it");
  expect(tied("joint1='b1' joint2='a1' polycoef='0 200'"), 12, "would turn b1 200 times as far as a1");
  expect(tied("joint1='b1' joint2='x'"), 12, "no joint is named 'x'");
  expect(tied("joint1='b1' joint2='a1b'"), 12, "no joint is named 'a1b', did you mean 'a1'?");
  expect(tied("joint1='b1' joint2='a1'/><joint name='f' joint1='a1' joint2='b1'"), 12,
         "equality joint 'f': couples a1 to b1, which are coupled already");
  expect(finger_mjcf(kThumb, "",
                     "<tendon><fixed name='t' range='0 1'><joint joint='a1' coef='1'/><joint joint='b1' coef='1'/>"
                     "</fixed></tendon>"),
         12, "fixed tendon 't': couples a1, b1");
  expect(finger_mjcf(kThumb, "", "", "type='slide' range='0 1'"), 6, "joint 'a1': slides, and the index hangs on it");
  expect(finger_mjcf(kThumb, "", "", "type='ball'"), 6, "is a ball joint");
  expect(finger_mjcf(kThumb, "", "", "axis='0 1 0'"), 6, "has no limits, and the index hangs on it");
  expect(finger_mjcf(kThumb, "", "", "axis='0 1 0' range='-9 9000'"), 6, "are its limits in degrees?");
  expect(finger_mjcf(kThumb, "", "", "axis='0 0 0' range='0 1'"), 6, "a direction must not be zero");
  expect(finger_mjcf(kThumb, "", "", "axis='0 1' range='0 1'"), 6, "axis must be 3 numbers, not '0 1'");
  expect(finger_mjcf(kThumb, "", "", "axis='0 1 x' range='0 1'"), 6, "axis: 'x' is no number");
  expect(finger_mjcf(kThumb, "<body name='a'/>\n"), 10, "body 'a': is there twice");
  expect(finger_mjcf(kThumb, "<replicate count='2'/>\n"), 10, "replicate: cannot be read");
  expect("<mujoco>\n<worldbody>\n<body>\n</worldbody>\n</mujoco>", 4, "is no XML");
  expect("<mujoco>\n</mujoco>", 1, "has no worldbody");
  expect("<mujoco>\n<include file='none.xml'/><worldbody/></mujoco>", 2, "there is no file 'none.xml'");
  expect("<sdf>\n</sdf>", 1, "is neither MJCF (<mujoco>) nor URDF (<robot>)");
}

TEST(HandImport, CoupledJointsMoveByThemselvesWhereThatIsAsked) {
  HandRequest request = fingers({"thumb=c", "index=b"});
  request.uncouple = true;
  const std::string text = finger_mjcf(kThumb, "", "<equality><joint name='e' joint1='a1' joint2='b1'/></equality>");
  const ImportedHand made = imported_text("hand.xml", text, request);
  EXPECT_TRUE(says(made.notes, "a1, b1 moves by itself, as asked"));
  EXPECT_TRUE(made.hand.followers.empty());
}

// The nearest to the palm leads, whichever the file names first: b = 0.1 + 2 (a - a_0) + b_0 is a = b / 2 + ..., read
// from either side.
TEST(HandImport, ReadsCoupledJoints) {
  const HandRequest request = fingers({"thumb=c", "index=b"});
  const auto hand_of = [&](const std::string& words) {
    const std::string joint = "ref='10' axis='0 1 0' range='0 90'";
    const std::string text = finger_mjcf(kThumb, "", "<equality><joint " + words + "/></equality>", joint);
    return written_and_read(imported_text("hand.xml", text, request));
  };
  const Hand hand = hand_of("joint1='b1' joint2='a1' polycoef='0.1 0.5 0 0 0'");
  ASSERT_EQ(hand.joints.size(), 2U);
  ASSERT_EQ(hand.followers.size(), 1U);
  EXPECT_EQ(hand.followers[0].joint.name, "b1");
  EXPECT_EQ(hand.joints[hand.followers[0].leader].name, "a1");
  EXPECT_DOUBLE_EQ(hand.followers[0].ratio, 0.5);
  EXPECT_NEAR(hand.followers[0].offset_rad, 0.1 - 0.5 * 10 * kDegree, 1e-12);
  const Hand other = hand_of("joint1='a1' joint2='b1' polycoef='-0.2 2'");
  EXPECT_EQ(other.followers[0].joint.name, "b1");
  EXPECT_DOUBLE_EQ(other.followers[0].ratio, 0.5);
  EXPECT_NEAR(other.followers[0].offset_rad, 0.1 - 0.5 * 10 * kDegree, 1e-12);
  EXPECT_NEAR(hand.joints[1].upper_rad, other.joints[1].upper_rad, 1e-12);
  const ImportedHand made =
      imported_text("a.xml", finger_mjcf(kThumb, "", "<equality><joint joint1='b1' joint2='a1'/></equality>"), request);
  EXPECT_TRUE(says(made.notes, "joint 'b1' follows 'a1': 1 times its angle"));
}

/// A thumb of one joint and a finger of three, f0 to f2, these with more in them; URDF.
std::string finger_urdf(const std::string& f0, const std::string& f1, const std::string& f2) {
  std::string text = "<robot name='r'>\n<link name='p'/>";
  const auto add = [&](const std::string& name, const std::string& parent, const char* xyz, const std::string& more) {
    text += "<link name='" + name + "_'/>\n<joint name='" + name + "' type='revolute'><parent link='" + parent +
            "'/><child link='" + name + "_'/><origin xyz='" + xyz +
            "'/><axis xyz='0 0 1'/><limit lower='0' upper='1.5'/>" + more + "</joint>\n";
  };
  add("t", "p", "0.02 0.05 0", "");
  add("f0", "p", "0.1 0 0", f0);
  add("f1", "f0_", "0.04 0 0", f1);
  add("f2", "f1_", "0.03 0 0", f2);
  return text + "</robot>\n";
}

// Of a group that a mimic chain ties together the joint nearest to the palm leads all the others.
TEST(HandImport, ReadsMimicsAndTheirChains) {
  const HandRequest request = fingers({"thumb=t_:@30/0/0mm:0/-1/0", "index=f2_:@20/0/0mm:0/1/0"});
  const std::string chain = finger_urdf("", "<mimic joint='f2' multiplier='2' offset='0.2'/>", "<mimic joint='f0'/>");
  const ImportedHand made = imported_text("hand.urdf", chain, request);
  const Hand hand = written_and_read(made);
  ASSERT_EQ(hand.joints.size(), 2U);
  ASSERT_EQ(hand.followers.size(), 2U);
  EXPECT_EQ(hand.followers[0].joint.name, "f1");
  EXPECT_DOUBLE_EQ(hand.followers[0].ratio, 2.0);
  EXPECT_DOUBLE_EQ(hand.followers[0].offset_rad, 0.2);
  EXPECT_EQ(hand.followers[1].leader, 1);
  EXPECT_EQ(hand.joints[1].drag, 6.0);
  EXPECT_NEAR(hand.joints[1].upper_rad, 0.65, 1e-12) << "where f1 is at 1.5";

  // It moves as the chain does whose joints are all free, at their angles.
  HandRequest free = request;
  free.uncouple = true;
  const Hand all = imported_text("hand.urdf", chain, free).hand;
  HandPose pose, full;
  for (const double angle : {0.0, 0.2, 0.6}) {
    forward_kinematics(hand, Eigen::Vector2d(0.3, angle), pose);
    forward_kinematics(all, Eigen::Vector4d(0.3, angle, 2.0 * angle + 0.2, angle), full);
    for (int k = 0; k < 2; ++k) {
      const Vector3d a = pose.distal(hand, k) * hand.fingertips[k].centre_m;
      EXPECT_LT((a - full.distal(all, k) * all.fingertips[k].centre_m).norm(), 1e-11);
    }
  }
  const auto said = [&](const std::string& f1, const std::string& f2) {
    return refusal("hand.urdf", finger_urdf("", f1, f2), request);
  };
  EXPECT_NE(said("<mimic joint='t'/>", "").find("couples f1 of the index to t of the thumb"), std::string::npos);
  EXPECT_NE(said("<mimic joint='f2'/>", "<mimic joint='f1'/>").find("which are coupled already"), std::string::npos);
  EXPECT_NE(said("<mimic joint='tt'/>", "").find("couples f1 to another one, but no joint that moves is named 'tt'"),
            std::string::npos);
  EXPECT_NE(said("", "<mimic joint='f1' multiplier='0' offset='1'/>").find("nothing but the angle 1 rad"),
            std::string::npos);
  HandRequest locked = request;
  locked.locks.push_back(read_lock("f1=20deg"));
  EXPECT_TRUE(says(imported_text("hand.urdf", finger_urdf("", "<mimic joint='f2'/>", ""), locked).notes,
                   "mimic of 'f2' is left out: 'f1' moves no finger"));
}

// Of a crossing that a follower has, its leader has the moment arm, times the ratio.
TEST(HandImport, FoldsTheMusclesOfCoupledJoints) {
  const BodyTree free = read_bodies(hand_data("gripper.xml"));
  BodyTree tree = free;
  tree.couplings.push_back({"equality joint 'e'", "gripper.xml:1", {"fore_end", "fore_bend"}, 1, {{0.5, 0.0}}});
  const Hand all = import_hand(free, gripper()).hand, hand = import_hand(tree, gripper()).hand;
  ASSERT_EQ(hand.followers.size(), 1U);
  const Index leader = hand.followers[0].leader, follower = leader + 1;
  ASSERT_EQ(all.joints[follower].name, "fore_end");
  std::mt19937_64 random(8);
  Eigen::MatrixXd H(std::ssize(hand.joints), std::ssize(hand.muscles)), H_all(std::ssize(all.joints), H.cols());
  HandPose pose, full;
  for (int i = 0; i < 20; ++i) {
    JointVector q = hand.at_zero(), q_all = all.at_zero();
    for (Index j = 0; j < q.size(); ++j) q[j] = std::uniform_real_distribution(0.0, 1.0)(random);
    q_all << q.head(leader + 1), 0.5 * q[leader], q.tail(q.size() - leader - 1);
    forward_kinematics(hand, q, pose);
    forward_kinematics(all, q_all, full);
    moment_arms(hand, pose, H);
    moment_arms(all, full, H_all);
    EXPECT_LT((H.row(leader) - H_all.row(leader) - 0.5 * H_all.row(follower)).norm(), 1e-14);
    EXPECT_LT((H.bottomRows(1) - H_all.bottomRows(1)).norm(), 1e-14);
  }
}

TEST(HandImport, RefusesASharedJointAndTooManyFingers) {
  // c, too, hangs on a: a1 moves both, and the thumb not.
  std::string shared = finger_mjcf("<body name='t'><joint name='t1' range='0 9'/></body>");
  shared.replace(shared.find("<body name='b'"), 0, kThumb);
  const HandRequest three = fingers({"thumb=t:@30/0/0mm", "index=b", "ring=c"});
  EXPECT_NE(refusal("hand.xml", shared, three).find("joint 'a1': moves both the index and the ring"),
            std::string::npos);
  EXPECT_EQ(imported_text("hand.xml", shared, fingers({"index=b", "ring=c"})).hand.joints.size(), 2U)
      << "a joint of all fingers is a wrist, which is locked";

  const HandRequest six = fingers({"a=b", "b=b", "c=b", "d=b", "e=b", "f=b"});
  EXPECT_NE(refusal("hand.xml", finger_mjcf(), six).find("names 6 fingers: a hand has 1 to 5"), std::string::npos);

  std::string chain = "<mujoco><worldbody><body name='p'>";
  for (int i = 0; i < 6; ++i) chain += "<body pos='0.03 0 0'><joint axis='0 1 0' range='0 90'/>";
  chain += "<site name='tip' pos='0.02 0 0'/></body></body></body></body></body></body>" + kThumb;
  chain += "</body></worldbody></mujoco>";
  EXPECT_NE(refusal("hand.xml", chain, fingers({"i=tip", "t=c"})).find("6 joints move it, and a finger has at most 5"),
            std::string::npos);
}

TEST(HandImport, OneFingerIsAHandWithAWarning) {
  const ImportedHand made = imported_text("hand.xml", finger_mjcf(), fingers({"index=b"}));
  EXPECT_EQ(made.hand.joints.size(), 2U);
  EXPECT_TRUE(says(made.notes, "a hand of one finger can press, but hold nothing"));
}

TEST(HandImport, RefusesOfUrdfWhatHasNoLimitsOrSlides) {
  const auto with = [](const std::string& joint) {
    return "<robot name='r'>\n<link name='p'/><link name='f'/><link name='g'/>\n<joint name='j' " + joint +
           "<parent link='p'/><child link='f'/></joint>\n<joint name='k' type='revolute'><parent link='p'/>"
           "<child link='g'/><limit lower='0' upper='1'/></joint></robot>";
  };
  const HandRequest request = fingers({"a=f:@30/0/0mm", "b=g:@30/0/0mm"});
  const auto said = [&](const std::string& joint) { return refusal("hand.urdf", with(joint), request); };
  EXPECT_NE(said("type='revolute'>").find("hand.urdf:3: joint 'j': has no limits"), std::string::npos);
  EXPECT_NE(said("type='revolute'><limit effort='1'/>").find("joint 'j': has no limits"), std::string::npos);
  EXPECT_NE(said("type='continuous'>").find("hand.urdf:3: joint 'j': has no limits"), std::string::npos);
  EXPECT_NE(said("type='planar'>").find("of the type 'planar'"), std::string::npos);
  EXPECT_NE(said("type='revolute'><limit lower='0' upper='1'/><mimic joint='k'/>").find("mimic of 'k'"),
            std::string::npos);
  EXPECT_NE(
      refusal("hand.urdf",
              "<robot>\n<link name='a'/><link name='b'/>\n<joint name='j' type='fixed'><parent link='a'/><child "
              "link='b'/></joint>\n<joint name='k' type='fixed'><parent link='b'/><child link='a'/></joint></robot>",
              request)
          .find("closes a loop"),
      std::string::npos);
  try {
    (void)import_hand(read_bodies(hand_data("slides.urdf")), fingers({"a=one:@1/0/0mm", "b=other:@1/0/0mm"}));
    ADD_FAILURE();
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("slides.urdf:6: joint 'left': slides"), std::string::npos) << error.what();
  }
}

TEST(HandRequest, SaysHowATipIsWritten) {
  const TipRequest tip = read_tip("thumb=th_tip:9mm:@0/-36/14.5mm:-x");
  EXPECT_EQ(tip.place, "th_tip");
  EXPECT_DOUBLE_EQ(*tip.radius_m, 9e-3);
  EXPECT_TRUE(tip.centre_m->isApprox(Vector3d(0, -0.036, 0.0145)));
  EXPECT_EQ(*tip.normal, Vector3d(-1, 0, 0));
  EXPECT_TRUE(read_tip("a=b:0/3/4").normal->isApprox(Vector3d(0, 0.6, 0.8)));
  for (const char* wrong :
       {"thumb", "=b", "a=", "a=b:9", "a=b:@1/2mm", "a=b:@1/2/3", "a=b:9kg", "a=b:0/0/0", "a=b:1m"}) {
    EXPECT_THROW((void)read_tip(wrong), ConfigError) << wrong;
  }
  EXPECT_THROW((void)read_axes("z"), ConfigError);
  EXPECT_THROW((void)read_axes("z,-z"), ConfigError);
  EXPECT_DOUBLE_EQ(*read_lock("wrist=90deg").value, 0.5 * std::numbers::pi);
}

}  // namespace
}  // namespace thenar::hand_import_test
