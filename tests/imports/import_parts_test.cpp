// SPDX-License-Identifier: Apache-2.0
// Parts of MJCF and URDF files that change places, masses, forces and ties; their laws are in MuJoCo's XML reference.

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "tests/imports/imported.h"

namespace thenar::import_parts_test {
namespace {

using Eigen::Vector3d;

BodyTree tree_of(const std::string& name, const std::string& text) {
  const std::filesystem::path file = scratch() / name;
  std::ofstream(file) << text;
  return read_bodies(file);
}

BodyTree mjcf(const std::string& in_body, const std::string& compiler = "", const std::string& after = "") {
  return tree_of("parts.xml", "<mujoco><compiler " + compiler + "/><worldbody><body name='b'>" + in_body +
                                  "</body></worldbody>" + after + "</mujoco>");
}

std::string refusal_of(const std::string& in_body, const std::string& compiler = "") {
  try {
    (void)mjcf(in_body, compiler);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

bool says(const std::vector<std::string>& notes, const std::string& words) {
  return std::ranges::any_of(notes, [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

TEST(ImportParts, SitesBetweenTwoPointsLieInTheirMiddle) {
  const BodyTree tree = mjcf(
      "<frame pos='0 0 0.1'><site name='s' type='capsule' fromto='0.02 0 0 0.04 0.002 0' pos='1 2 3' size='0.004'/>"
      "</frame>");
  ASSERT_EQ(tree.sites.size(), 1U);
  EXPECT_TRUE(tree.sites[0].X_BS.translation().isApprox(Vector3d(0.03, 0.001, 0.1), 1e-12));
  const Vector3d z = tree.sites[0].X_BS.linear().col(2);
  EXPECT_TRUE(z.isApprox(Vector3d(-0.02, -0.002, 0).normalized(), 1e-12)) << z;
  EXPECT_NE(refusal_of("<site name='s' fromto='0 0 0 1 0 0'/>").find("fromto: a sphere has none"), std::string::npos);
  EXPECT_NE(refusal_of("<geom type='box' size='1' fromto='1 0 0 1 0 0'/>").find("two points that differ"),
            std::string::npos);
}

TEST(ImportParts, EllipsoidsAndBoxesBetweenTwoPointsHaveOneSizeAcross) {
  const BodyTree tree = mjcf("<geom type='ellipsoid' fromto='0.02 0 0 0.044 0 0' size='0.008'/>");
  ASSERT_EQ(tree.bodies[1].rounds.size(), 1U);
  const TreeRound& round = tree.bodies[1].rounds[0];
  ASSERT_TRUE(round.shape);
  EXPECT_TRUE(round.shape->half_m.isApprox(Vector3d(0.008, 0.008, 0.012), 1e-12));
  EXPECT_TRUE(round.centre_m.isApprox(Vector3d(0.032, 0, 0), 1e-12));
  EXPECT_NEAR(std::abs(round.shape->axes(0, 2)), 1.0, 1e-12);
  EXPECT_NEAR(tree.bodies[1].mass_kg, 4e3 / 3.0 * std::numbers::pi * 0.008 * 0.008 * 0.012, 1e-12);
  // Whatever sizes follow the first.
  const BodyTree box = mjcf("<geom type='box' fromto='0 0 0 0 0 0.06' size='0.01 0.5 0.7' density='500'/>");
  EXPECT_NEAR(box.bodies[1].mass_kg, 500.0 * 0.02 * 0.02 * 0.06, 1e-12);
}

TEST(ImportParts, OnlyGeomsOfTheGroupsHaveMass) {
  const std::string geoms = "<geom size='0.01' mass='2'/><geom size='0.01' pos='0.3 0 0' group='4' mass='1'/>";
  EXPECT_DOUBLE_EQ(mjcf(geoms).bodies[1].mass_kg, 3.0);
  const BodyTree tree = mjcf(geoms, "inertiagrouprange='0 1'");
  EXPECT_DOUBLE_EQ(tree.bodies[1].mass_kg, 2.0);
  EXPECT_TRUE(tree.bodies[1].com_m.isZero(1e-15));
  EXPECT_EQ(tree.bodies[1].rounds.size(), 2U) << "its place is that of the pulp all the same";
  EXPECT_DOUBLE_EQ(mjcf(geoms, "inertiagrouprange='4 4'").bodies[1].mass_kg, 1.0);
  EXPECT_DOUBLE_EQ(mjcf("<site name='s'/>", "boundmass='0.02'").bodies[1].mass_kg, 0.02);
  EXPECT_NE(refusal_of("", "coordinate='global'").find("must be local"), std::string::npos);
}

TEST(ImportParts, NotesWhatChangesAValueAndIsLeftOut) {
  const std::string plain =
      "<joint axis='0 1 0' range='0 1' damping='0.1' armature='1e-3' stiffness='0'/><geom size='0.01' rgba='1 0 0 1' "
      "contype='0'/><camera name='eye'/>";
  EXPECT_TRUE(mjcf(plain, "meshdir='x'", "<option timestep='0.001'/>").notes.empty());
  const BodyTree tree = mjcf(
      "<joint axis='0 1 0' range='0 1' stiffness='0.2' springref='30'/><geom size='0.01' "
      "shellinertia='true'/><plugin/>",
      "", "<deformable/>");
  EXPECT_TRUE(says(tree.notes, "of joint elements what these attributes say is left out: springref, stiffness"));
  EXPECT_TRUE(says(tree.notes, "of geom elements what these attributes say is left out: shellinertia"));
  EXPECT_TRUE(says(tree.notes, "1 plugin element left out"));
  EXPECT_TRUE(says(tree.notes, "1 deformable element left out"));
  EXPECT_EQ(tree.notes.size(), 4U);
}

TEST(ImportParts, TheGearOfAnActuatorMultipliesItsPull) {
  const auto pull_N = [](const std::string& actuator) {
    const BodyTree tree =
        mjcf("<site name='s'/><site name='t'/>", "",
             "<tendon><spatial name='x'><site site='s'/><site site='t'/></spatial></tendon><actuator>" + actuator +
                 "</actuator>");
    return tree.tendons.at(0).max_force_N.value_or(0.0);
  };
  EXPECT_DOUBLE_EQ(pull_N("<muscle tendon='x' force='30'/>"), 30.0);
  EXPECT_DOUBLE_EQ(pull_N("<muscle tendon='x' force='30' gear='2'/>"), 60.0);
  EXPECT_DOUBLE_EQ(pull_N("<general tendon='x' gaintype='muscle' gainprm='1 1 20' gear='0.5'/>"), 10.0);
  EXPECT_DOUBLE_EQ(pull_N("<position tendon='x' forcerange='-40 0' gear='3'/>"), 120.0);
  EXPECT_DOUBLE_EQ(pull_N("<motor tendon='x' ctrlrange='0 5' gear='-2'/>"), 10.0);
}

TEST(ImportParts, AFixedTendonTiesByLimitsSpringsAndWhatRefersToIt) {
  const auto couplings = [](const std::string& attributes, const std::string& after = "",
                            const std::string& compiler = "") {
    return mjcf("<joint name='i' axis='0 1 0' range='0 1'/><joint name='j' axis='0 0 1' range='0 1'/>", compiler,
                after + "<tendon><fixed name='sum' " + attributes +
                    "><joint joint='i' coef='1'/><joint joint='j' coef='1'/></fixed></tendon>")
        .couplings.size();
  };
  EXPECT_EQ(couplings(""), 0U);
  EXPECT_EQ(couplings("", "<sensor><tendonpos tendon='sum'/></sensor>"), 0U);
  EXPECT_EQ(couplings("limited='false' range='0 1'"), 0U);
  EXPECT_EQ(couplings("range='0 1'", "", "autolimits='false'"), 0U);
  EXPECT_EQ(couplings("stiffness='0'", "<actuator><motor joint='i'/></actuator>"), 0U);
  EXPECT_EQ(couplings("range='0 1'"), 1U);
  EXPECT_EQ(couplings("limited='true' range='0 1'", "", "autolimits='false'"), 1U);
  EXPECT_EQ(couplings("stiffness='2'"), 1U);
  EXPECT_EQ(couplings("", "<default><tendon stiffness='2'/></default>"), 1U);
  EXPECT_EQ(couplings("", "<actuator><motor tendon='sum'/></actuator>"), 1U);
  EXPECT_EQ(couplings("", "<equality><tendon tendon1='sum'/></equality>"), 1U);
}

// What cannot pull pulls nothing, and what pulls besides another one is told.
TEST(ImportParts, ActuatorsThatPushOrShareATendonAreTold) {
  const auto tree_with = [](const std::string& actuators) {
    return mjcf("<site name='s'/><site name='t'/>", "",
                "<tendon><spatial name='x'><site site='s'/><site site='t'/></spatial></tendon><actuator>" + actuators +
                    "</actuator>");
  };
  const BodyTree pushed = tree_with("<motor name='m' tendon='x' ctrlrange='0 5'/>");
  EXPECT_FALSE(pushed.tendons.at(0).max_force_N);
  EXPECT_TRUE(says(pushed.notes, "motor 'm' is left out: it can only push its tendon"));
  const BodyTree two = tree_with("<muscle name='a' tendon='x' force='5'/><muscle name='b' tendon='x' force='7'/>");
  EXPECT_DOUBLE_EQ(two.tendons.at(0).max_force_N.value(), 12.0);
  EXPECT_TRUE(says(two.notes, "muscle 'b' pulls the tendon of 'a', which has both forces"));
}

// An angle of a class replaces a quaternion; MuJoCo's versions differ in which of two other kinds they take.
TEST(ImportParts, OrientationsOfAClass) {
  const auto z_of = [](const std::string& geom, const std::string& in_class) {
    const BodyTree tree = mjcf("<geom name='g' type='cylinder' size='1 1' " + geom + "/>", "",
                               "<default><geom " + in_class + "/></default>");
    return Vector3d(tree.wraps.at(0).X_BG.linear().col(2));
  };
  EXPECT_TRUE(z_of("quat='1 0 0 0'", "euler='90 0 0'").isApprox(Vector3d(0, -1, 0), 1e-12));
  EXPECT_TRUE(z_of("euler='0 90 0'", "euler='90 0 0'").isApprox(Vector3d(1, 0, 0), 1e-12));
  try {
    (void)z_of("zaxis='1 0 0'", "euler='90 0 0'");
    ADD_FAILURE();
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("and its class one of another kind"), std::string::npos) << error.what();
  }
  EXPECT_NE(refusal_of("<geom size='1' quat='1 0 0 0' euler='1 0 0'/>").find("names two orientations"),
            std::string::npos);
}

TEST(ImportParts, MeshFilesAreNotRead) {
  EXPECT_NE(refusal_of("<geom type='capsule' mesh='m'/>").find("is a capsule fitted to a mesh, which is not read"),
            std::string::npos);
  const BodyTree tree = mjcf("<geom type='mesh' mesh='m'/><geom size='0.01' mass='1'/>", "settotalmass='3'");
  EXPECT_TRUE(says(tree.notes, "settotalmass is left out where some are not known"));
  EXPECT_DOUBLE_EQ(tree.bodies[1].mass_kg, 1.0);
  const BodyTree centred = mjcf("<geom type='mesh' mesh='m' mass='2'/>", "settotalmass='3'");
  EXPECT_TRUE(says(centred.notes, "1 mesh with a mass: centres of mass are taken at their places"));
  EXPECT_DOUBLE_EQ(centred.bodies[1].mass_kg, 3.0);
}

TEST(ImportParts, NamesThatAreMissingAreNew) {
  const BodyTree tree = mjcf("<body/><body name='body2'><joint/><joint name='body2_joint1'/></body>");
  EXPECT_EQ(tree.bodies[2].name, "body2_2");
  EXPECT_EQ(tree.bodies[3].joints[0].name, "body2_joint1_2");
}

/// Two fingers of two joints each, the outer of the first with more in it.
std::string hand_urdf(const std::string& outer) {
  std::string text = "<robot name='r'><link name='p'/>";
  const auto add = [&](const std::string& name, const std::string& parent, const std::string& at,
                       const std::string& inner) {
    text += "<link name='" + name + "_'/><joint name='" + name + "' " + inner + "<parent link='" + parent +
            "'/><child link='" + name + "_'/><origin xyz='" + at + "'/><axis xyz='0 0 1'/></joint>";
  };
  const std::string limited = "type='revolute'><limit lower='-0.5' upper='1.5'/>";
  add("t", "p", "0.02 0.05 0", limited);
  add("f", "p", "0.1 0 0", limited);
  add("g", "f_", "0.04 0 0", outer);
  return text + "</robot>";
}

// The angle of the other is in [-0.5, 1.5], and this one's is a multiple of it and an offset.
TEST(ImportParts, JointsWithoutLimitsHaveThoseOfWhatTheyFollow) {
  const HandRequest request = fingers({"thumb=t_:@30/0/0mm:0/-1/0", "index=g_:@20/0/0mm:0/1/0"});
  const auto follower = [&](const std::string& mimic) {
    return imported_text("a.urdf", hand_urdf("type='continuous'>" + mimic), request).hand;
  };
  const Hand hand = follower("<mimic joint='f' multiplier='-0.8' offset='0.4'/>");
  ASSERT_EQ(hand.followers.size(), 1U);
  EXPECT_NEAR(hand.followers[0].joint.lower_rad, -0.8, 1e-12);
  EXPECT_NEAR(hand.followers[0].joint.upper_rad, 0.8, 1e-12);
  ASSERT_EQ(hand.joints.size(), 2U);
  EXPECT_NEAR(hand.joints[1].lower_rad, -0.5, 1e-12);
  EXPECT_NEAR(hand.joints[1].upper_rad, 1.5, 1e-12);
  EXPECT_NE(refusal("b.urdf", hand_urdf("type='continuous'>"), request).find("has no limits"), std::string::npos);
  HandRequest free = request;
  free.uncouple = true;
  EXPECT_NE(refusal("c.urdf", hand_urdf("type='continuous'><mimic joint='f'/>"), free).find("has no limits"),
            std::string::npos)
      << "it moves by itself, without any";
}

TEST(ImportParts, TipsNameBodiesWithColonsAndCommas) {
  const TipRequest colon = read_tip("thumb=robot0:thdistal:9mm");
  EXPECT_EQ(colon.place, "robot0:thdistal");
  EXPECT_DOUBLE_EQ(*colon.radius_m, 9e-3);
  const TipRequest quoted = read_tip(R"(thumb="a:x,2 ""b""":-x:@1/2/3mm)");
  EXPECT_EQ(quoted.place, R"(a:x,2 "b")");
  EXPECT_EQ(*quoted.normal, Vector3d(-1, 0, 0));
  EXPECT_EQ(split_tips(R"(a="x,y:z":9mm,b=c)"), (std::vector<std::string>{R"(a="x,y:z":9mm)", "b=c"}));
  EXPECT_EQ(read_tip("a=b:x").place, "b") << "an axis is a direction";
  for (const char* wrong : {R"(a="b)", R"(a="b"c)", R"(a="")", "a=b:9x"}) {
    EXPECT_THROW((void)read_tip(wrong), ConfigError) << wrong;
  }
  try {
    (void)read_tip("a=robot0:2");
    ADD_FAILURE();
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("stands in quotes"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace thenar::import_parts_test
