// SPDX-License-Identifier: Apache-2.0
// Made hands in URDF.

#include "tests/imports/made_parts.h"

namespace thenar::made {

namespace {

std::string origin(Dice& dice, const Vector& xyz, double turn_rad) {
  const std::string rpy = dice.is(0.2) ? "" : fmt::format(" rpy='{}'", text_of(dice.near({0, 0, 0}, turn_rad)));
  return fmt::format("<origin xyz='{}'{}/>", text_of(xyz), rpy);
}

/// A link with shapes, of which the mesh file does not exist.
std::string link(Dice& dice, const std::string& name, bool has_mass = true) {
  std::string inner;
  if (has_mass) {
    inner = fmt::format(
        "<inertial>{}<mass value='{:.4g}'/><inertia ixx='1e-5' iyy='1e-5' izz='1e-5' ixy='0' ixz='0' iyz='0'/>"
        "</inertial>",
        origin(dice, dice.near({0.015, 0, 0}, 0.01), 1.0), dice.in(0.005, 0.05));
  }
  const std::string at = origin(dice, dice.near({0.02, 0, 0}, 0.004), 1.0);
  const std::string shape = dice.one_of<std::string>(
      {"<sphere radius='0.007'/>", "<cylinder radius='0.007' length='0.02'/>", "<box size='0.01 0.02 0.03'/>"});
  return fmt::format(
      "<link name='{1}'>{0}<visual>{2}<geometry><mesh filename='package://hand/meshes/{1}.stl' "
      "scale='0.001 0.001 0.001'/></geometry></visual><collision>{2}<geometry>{3}</geometry></collision></link>\n",
      inner, name, at, shape);
}

std::string joint(const std::string& name, const std::string& type, const std::string& parent, const std::string& child,
                  const std::string& inner) {
  return fmt::format("<joint name='{}' type='{}'><parent link='{}'/><child link='{}'/>{}</joint>\n", name, type, parent,
                     child, inner);
}

std::string limit(double lower, double upper) {
  return fmt::format("<limit lower='{:.4g}' upper='{:.4g}' effort='1' velocity='1'/>", lower, upper);
}

/// The joint of a link: with `mimics` the outer ones follow others, at times in chains.
std::string finger_joint(Dice& dice, int finger, int at, bool mimics, const std::string& parent, MadeHand& made) {
  const std::array<Vector, 3> knuckles{Vector{0.01, 0.075, 0}, Vector{0.02, 0, 0.016}, Vector{0.02, 0, -0.016}};
  const std::string name = link_name(finger, at) + "j";
  std::string inner =
      origin(dice, at == 0 ? knuckles[static_cast<std::size_t>(finger)] : Vector{0.036, 0, 0}, at == 0 ? 0.2 : 0.6);
  inner += fmt::format("<axis xyz='{}'/>", text_of(dice.near({0, 0, 2 * thumb_sign(finger)}, 0.2)));
  inner +=
      "<dynamics damping='0.1' friction='0.1'/><safety_controller soft_lower_limit='0' soft_upper_limit='0.1' "
      "k_velocity='1'/>";
  if (!mimics || at == 0 || (finger == 0 && at == 1)) {
    inner += limit(dice.in(-0.5, 0), dice.in(0.7, 1.5));
    return joint(name, "revolute", parent, link_name(finger, at), inner);
  }
  const MadeTie tie{name, link_name(finger, dice.is() ? 0 : at - 1) + "j", dice.one_of({1.0, 0.8, -0.6, 1.3}),
                    dice.one_of({0.0, 0.2})};
  made.ties.push_back(tie);
  inner += fmt::format("<mimic joint='{}'{}{}/>", tie.leader,
                       tie.ratio == 1.0 ? "" : fmt::format(" multiplier='{}'", tie.ratio),
                       tie.offset_rad == 0.0 ? "" : fmt::format(" offset='{}'", tie.offset_rad));
  const bool is_limited = dice.is();
  return joint(name, is_limited ? "revolute" : "continuous", parent, link_name(finger, at),
               is_limited ? inner + limit(-2, 3) : inner);
}

}  // namespace

/// Links with origins that are turned, fixed chains to the tips, and what readers of hands pass over.
MadeHand urdf(Dice& dice, bool mimics) {
  MadeHand made;
  std::string text =
      "<?xml version='1.0'?>\n<robot name='hand'>\n<mujoco><compiler fusestatic='false' discardvisual='true' "
      "inertiafromgeom='false' boundmass='1e-13' boundinertia='1e-13'/></mujoco>\n";
  text += link(dice, "base") + link(dice, "wrist") + link(dice, "palm");
  text += joint("wrist_j", dice.one_of({"fixed", "revolute", "prismatic"}), "base", "wrist",
                origin(dice, {0.1, 0, 0}, 1.0) + "<axis xyz='0 0 1'/>" + limit(-0.1, 0.2));
  text += joint("palm_j", "fixed", "wrist", "palm", origin(dice, {0, 0.1, 0}, 1.0));
  for (int k = 0; k < 3; ++k) {
    std::string parent = "palm";
    for (int at = 0; at < kLinks; ++at) {
      text += link(dice, link_name(k, at)) + finger_joint(dice, k, at, mimics, parent, made);
      parent = link_name(k, at);
    }
    const std::string tip = fmt::format("{}_tip", kFingers[k]), pad = fmt::format("{}_pad", kFingers[k]);
    text += link(dice, pad) + fmt::format("<link name='{}'/>\n", tip);
    text += joint(pad + "_j", "fixed", parent, pad, origin(dice, {0.02, 0.001, 0}, 0.4));
    text += joint(tip + "_j", "fixed", pad, tip, origin(dice, {0.006, 0, 0.001}, 0.4));
    made.tips.push_back(
        {std::string(1, kFingers[k]), tip, dice.near({0.002, 0, 0}, 0.002), dice.near({0.3, thumb_sign(k), 0}, 0.1)});
    text += fmt::format(
        "<transmission name='{0}t'><type>transmission_interface/SimpleTransmission</type><joint name='{0}1j'/>"
        "<actuator name='a'/></transmission>\n<gazebo reference='{0}1'><selfCollide>true</selfCollide></gazebo>\n",
        kFingers[k]);
  }
  if (mimics) {  // A rod that a finger moves, of a length in m for each rad.
    text += link(dice, "rod", false) +
            joint("rod_j", "prismatic", "palm", "rod", limit(0, 0.02) + "<mimic joint='i1j' multiplier='0.01'/>");
    made.noted = {"mimic of 'i1j' is left out: 'rod_j' moves no finger", "1 link without inertial"};
  }
  made.main = "hand.urdf";
  made.files[made.main] = text + "</robot>\n";
  return made;
}

}  // namespace thenar::made
