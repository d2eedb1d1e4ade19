// SPDX-License-Identifier: Apache-2.0
#include "tests/imports/made_hands.h"

#include "tests/imports/made_parts.h"

namespace thenar {

namespace made {

/// Writes an MJCF of three fingers of three links.
MadeHand written(Dice& dice, const Style& style) {
  const std::array<Vector, 3> knuckles{Vector{0.01, 0.075, 0}, Vector{0.02, 0, 0.016}, Vector{0.02, 0, -0.016}};
  MadeHand made;
  std::string fingers;
  for (int k = 0; k < 3; ++k) {
    std::string open, close;
    for (int link = 0; link < kLinks; ++link) {
      const Vector pos = link == 0 ? dice.near(knuckles[static_cast<std::size_t>(k)], 0.004)
                                   : dice.near({0.036 - 0.004 * link, 0, 0}, 0.002);
      open += fmt::format("<body {} pos='{}'{}{}>\n{}{}", style.name(link_name(k, link)), text_of(pos), style.turn(),
                          link == 0 ? style.childclass : "", style.joints(k, link), style.parts(k, link));
      close += "</body>";
    }
    fingers += open + close + "\n";
    made.tips.push_back({std::string(1, kFingers[k]), link_name(k, kLinks - 1), dice.near({0.024, 0, 0}, 0.003),
                         dice.near({0.3, thumb_sign(k), 0}, 0.1)});
  }
  made.main = "hand.xml";
  made.files[made.main] = fmt::format(
      "<mujoco>\n<compiler angle='{}'{}/>\n{}<worldbody>\n{}<body {}>\n{}{}</body>\n{}</worldbody>\n{}</mujoco>\n",
      style.degrees ? "degree" : "radian", style.compiler, style.before, style.open_world, style.palm, style.in_palm,
      fingers, style.close_world, style.after);
  return made;
}

std::string plain_joint(Dice& dice, const Style& style, int finger, int link) {
  return fmt::format("<joint name='{}j' axis='{}' limited='true' range='{}'/>\n", link_name(finger, link),
                     text_of(dice.near({0, 0, thumb_sign(finger)}, 0.1)),
                     angles(style, dice.in(-30, 0), dice.in(40, 90)));
}

std::string plain_geom(Dice& dice) {
  return fmt::format("<geom type='capsule' fromto='0 0 0 {}' size='{:.4g}'/>\n",
                     text_of(dice.near({0.03, 0, 0}, 0.002)), dice.in(0.006, 0.009));
}

namespace {

/// Nested classes, in a file of their own: what an element has of its class, and what it says itself.
MadeHand classes(Dice& dice) {
  Style style;
  style.degrees = dice.is();
  style.compiler = " autolimits='true'";
  style.before = "<include file='classes.xml'/>\n";
  style.palm = "name='palm' childclass='hand'";
  const bool by_section = dice.is();
  style.joints = [&](int finger, int link) {
    const std::string own = link == 1 ? fmt::format(" range='{}'", angles(style, dice.in(-9, 0), dice.in(30, 60))) : "";
    return fmt::format("<joint name='{}j'{}{}/>\n", link_name(finger, link), finger == 0 ? " class='thumb'" : "", own);
  };
  style.parts = [&](int finger, int link) {
    const std::string place = fmt::format(" pos='{}'", text_of(dice.near({0.015, 0, 0}, 0.003)));
    std::string text = fmt::format("<geom{}/>\n", place);  // All of the class.
    // One size of two, the other is the class's; an orientation besides that of the class.
    text += fmt::format("<geom{} size='{:.4g}'/>\n", place, dice.in(0.004, 0.006));
    text += fmt::format("<geom class='turned'{} {}/>\n", place,
                        dice.one_of({"quat='0.8 0.6 0 0.1'", "euler='0.2 0.3 0.1'", "mass='0.01'"}));
    text += fmt::format("<geom class='seen' type='box' size='0.01 0.02 0.03'{}/>\n", place);
    if (link == 2) text += fmt::format("<geom class='{}'{} size='0.005'/>\n", finger == 0 ? "soft" : "end", place);
    return text;
  };
  style.childclass = " childclass='finger'";
  MadeHand made = written(dice, style);
  const std::string first =
      fmt::format("<joint range='{}' axis='0 0.1 1'/><geom type='capsule' size='{:.4g} {:.4g}' density='{:.4g}'/>\n",
                  angles(style, -20, dice.in(60, 80)), dice.in(0.006, 0.008), dice.in(0.01, 0.014), dice.in(500, 1500));
  const std::string nested = fmt::format(
      "<default class='hand'><joint damping='0.1'/>\n"
      "<default class='finger'><joint axis='0 -0.05 1'/><geom density='{:.4g}'/>\n"
      "<default class='end'><geom type='ellipsoid' size='0.01 0.007 0.006'/>"
      "<default class='soft'><geom density='300'/></default></default>\n"
      "<default class='turned'><geom type='box' size='0.004 0.006 0.009' euler='0.4 0.1 0.5'/></default></default>\n"
      "<default class='thumb'><joint axis='0.1 0 -1' range='{}'/></default>\n"
      "<default class='seen'><geom mass='0' contype='0' group='2'/></default></default>\n",
      dice.in(800, 1200), angles(style, -15, dice.in(40, 70)));
  made.files["classes.xml"] =
      by_section ? "<mujoco>\n<default>\n" + first + "</default>\n<default>\n" + nested + "</default>\n</mujoco>\n"
                 : "<mujoco>\n<default class='main'>\n" + first + nested + "</default>\n</mujoco>\n";
  return made;
}

/// Every way to turn a body, with angles of any unit and sequence.
std::string some_turn(Dice& dice, const Style& style) {
  const double unit = style.degrees ? 1.0 : kDegree;
  const Vector v = dice.direction();
  switch (dice.below(7)) {
    case 0:
      return fmt::format(" quat='{:.6g} {}'", dice.in(0.5, 3.0), text_of(v));  // of any length
    case 1:
      return fmt::format(" axisangle='{:.6g} {:.6g} {:.6g} {:.6g}'", 2 * v[0], 2 * v[1], 2 * v[2],
                         unit * dice.in(-170, 170));
    case 2:
      return fmt::format(" xyaxes='{} {}'", text_of({2, v[0], v[1]}), text_of({v[1], 1, v[2]}));  // not across
    case 3:
      return fmt::format(" zaxis='{}'", text_of(v));
    case 4:
      return " zaxis='0 0 -2'";
    case 5:
      return fmt::format(" euler='{}'", text_of({unit * 60 * v[0], unit * 60 * v[1], unit * 60 * v[2]}));
    default:
      return "";
  }
}

MadeHand poses(Dice& dice) {
  Style style;
  style.degrees = dice.is();
  style.compiler =
      fmt::format(" autolimits='true' eulerseq='{}'", dice.one_of({"zyx", "XYZ", "ZXY", "xyx", "yXz", "zxz", "YyZ"}));
  style.palm = fmt::format("name='palm' pos='0.3 -1 0.5'{}", some_turn(dice, style));
  style.open_world = fmt::format("<body name='stand' pos='{}'{}><body name='plate'{}>\n", text_of(dice.direction()),
                                 some_turn(dice, style), some_turn(dice, style));
  style.close_world = "</body></body>\n";
  style.turn = [&] { return some_turn(dice, style); };
  style.joints = [&](int finger, int link) { return plain_joint(dice, style, finger, link); };
  style.parts = [&](int, int link) {
    std::string text = plain_geom(dice);
    // A fixed body that is turned too, and its mass.
    if (link > 0) {
      text += fmt::format("<body pos='{}'{}><geom type='box' size='0.004 0.006 0.008' pos='0.01 0 0.002'{}/></body>\n",
                          text_of(dice.near({0.01, 0.01, 0}, 0.005)), some_turn(dice, style), some_turn(dice, style));
    }
    return text;
  };
  return written(dice, style);
}

/// Several joints of a body, with places, references and springs, on an arm with joints of every kind.
MadeHand joints(Dice& dice) {
  Style style;
  style.degrees = dice.is();
  const double unit = style.degrees ? 1.0 : kDegree;
  style.compiler = " autolimits='true'";
  style.open_world = fmt::format(
      "<body name='arm' pos='0 0 1'>{}<body name='slider'><joint name='rail' type='slide' axis='1 0 0' "
      "ref='0.03' range='0 0.5'/><geom size='0.03'/><body name='forearm' pos='0.1 0 0' euler='0 0 {:.6g}'>"
      "<geom size='0.03'/><joint name='wrist' axis='0 1 0' pos='0.01 0 0.02' ref='{:.6g}' range='{}'/>\n",
      dice.one_of({"<freejoint/><geom size='0.03'/>", "<joint type='ball'/><geom size='0.03'/>",
                   "<joint name='free' type='free'/><geom size='0.03'/>"}),
      unit * 20, unit * 12, angles(style, -30, 30));
  style.close_world = "</body></body></body>\n";
  style.joints = [&](int finger, int link) {
    std::string text;
    const int number = link == 0 ? 1 + dice.below(3) : 1;
    for (int j = 0; j < number; ++j) {
      const Vector axis = j == 0 ? Vector{0, 0, 2 * thumb_sign(finger)} : j == 1 ? Vector{0, 1, 0} : Vector{1, 0, 0};
      const double low = dice.in(-30, 0);
      text += fmt::format("<joint name='{}j{}' pos='{}' axis='{}' ref='{:.6g}' range='{}'{}/>\n",
                          link_name(finger, link), j, text_of(dice.near({0, 0, 0}, 0.003)),
                          text_of(dice.near(axis, 0.2)), unit * dice.in(low, 30), angles(style, low, dice.in(40, 80)),
                          dice.is(0.2) ? fmt::format(" stiffness='0.1' springref='{:.6g}'", unit * 10) : "");
    }
    return text;
  };
  style.parts = [&](int, int) { return plain_geom(dice); };
  MadeHand made = written(dice, style);
  made.noted = {"joint 'rail' is locked at its reference value, 30 mm", "joint 'wrist' is locked"};
  if (made.files[made.main].find("springref") != std::string::npos) made.noted.emplace_back("springref, stiffness");
  return made;
}

/// A tetrahedron in the format of Wavefront, of a size.
std::string tetrahedron(double size_m) {
  return fmt::format("v 0 0 0\nv {0:.6g} 0 0\nv 0 {0:.6g} 0\nv 0 0 {0:.6g}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
                     size_m);
}

/// Masses of geoms of every type, by mass or density, inertial elements, and what the compiler makes of both.
MadeHand masses(Dice& dice) {
  Style style;
  style.compiler = fmt::format(" autolimits='true' inertiafromgeom='{}' boundinertia='1e-7' balanceinertia='true'",
                               dice.one_of({"auto", "true"}));
  if (dice.is()) style.compiler += " inertiagrouprange='1 3'";
  if (dice.is()) style.compiler += " boundmass='0.008'";
  const bool total = dice.is(0.3), meshes = dice.is();
  if (total) style.compiler += " settotalmass='0.5'";
  style.joints = [&](int finger, int link) { return plain_joint(dice, style, finger, link); };
  if (meshes) style.before = "<asset><mesh name='bone' file='bone.obj' scale='1 1 1.5'/></asset>\n";
  style.parts = [&](int finger, int link) {
    std::string text = "<geom size='0.004' group='2'/>\n";
    const bool has_bone = meshes && (finger == 1 || link == 2);
    if (!has_bone && dice.is(0.4)) {
      text += fmt::format("<inertial pos='{}' mass='{:.4g}' diaginertia='1e-5 1e-5 1e-5'/>\n",
                          text_of(dice.near({0.015, 0, 0}, 0.01)), dice.in(0.005, 0.05));
    }
    for (int g = 0; g < 3; ++g) {
      const std::string type = dice.one_of<std::string>({"sphere", "capsule", "cylinder", "ellipsoid", "box"});
      const std::string weight = dice.is() ? fmt::format("mass='{:.4g}'", dice.in(0.001, 0.01))
                                           : fmt::format("density='{:.4g}'", dice.in(200, 8000));
      const std::string place = type != "sphere" && dice.is()
                                    ? fmt::format("fromto='{} {}'", text_of(dice.near({0, 0, 0}, 0.01)),
                                                  text_of(dice.near({0.03, 0, 0}, 0.01)))
                                    : fmt::format("pos='{}' euler='10 20 30'", text_of(dice.near({0.01, 0, 0}, 0.01)));
      text += fmt::format("<geom type='{}' size='0.005 0.007 0.009' {} {} group='{}'/>\n", type, place, weight, g + 1);
    }
    if (has_bone) {
      text += fmt::format("<geom type='mesh' mesh='bone' pos='0.01 0 0' {}/>\n", finger == 1 ? "mass='0.004'" : "");
    }
    if (dice.is(0.3)) text += "<geom type='box' size='0.03 0.03 0.03' group='4' mass='0.003'/>\n";
    return text;
  };
  MadeHand made = written(dice, style);
  made.files["bone.obj"] = tetrahedron(0.02);
  if (meshes && style.compiler.find("inertiagrouprange") == std::string::npos) made.noted.emplace_back("mesh");
  return made;
}

/// Names that are missing, or have colons, slashes and blanks; files that include files.
MadeHand names(Dice& dice) {
  Style style;
  style.compiler = " autolimits='true'";
  const std::string prefix = dice.one_of<std::string>({"robot0:", "left/hand/", "the hand ", "1", "#", "- ", "a: b, "});
  style.palm = dice.is() ? "pos='0 0 0.1' euler='50 0 10'" : "name='body3' euler='50 0 10'";
  style.name = [&](const std::string& n) {
    const bool is_tip = n.back() == '3', is_missing = !is_tip && dice.is(0.4);
    if (is_missing) return std::string();
    return fmt::format("name='{}{}'", prefix, n);
  };
  style.joints = [&](int finger, int link) {
    std::string text;
    if (dice.is(0.6)) text = fmt::format(" name='{}{}j'", prefix, link_name(finger, link));
    return fmt::format("<joint{} axis='0 0 {}' range='-20 {:.4g}'/>\n", text, thumb_sign(finger), dice.in(40, 90));
  };
  int part = 0;
  std::map<std::string, std::string> files;
  style.parts = [&](int, int) {
    const std::string file = fmt::format("part{}.xml", ++part);
    files[file] = fmt::format("<mujoco>\n<include file='inner{}.xml'/>\n{}</mujoco>\n", part, plain_geom(dice));
    files[fmt::format("inner{}.xml", part)] = "<mujocoinclude>\n<site/>\n" + plain_geom(dice) + "</mujocoinclude>\n";
    return fmt::format("<include file='{}'/>\n", file);
  };
  MadeHand made = written(dice, style);
  made.files.merge(files);
  for (MadeTip& tip : made.tips) tip.body = prefix + tip.body;
  return made;
}

}  // namespace

}  // namespace made

MadeHand made_hand(const std::string& kind, std::uint64_t seed) {
  using namespace made;
  Dice dice(seed);
  if (kind == "classes") return classes(dice);
  if (kind == "poses") return poses(dice);
  if (kind == "joints") return joints(dice);
  if (kind == "masses") return masses(dice);
  if (kind == "strings") return strings(dice);
  if (kind == "wraps") return wraps(dice);
  if (kind == "ties") return ties(dice);
  if (kind == "names") return names(dice);
  if (kind == "actuators") return actuators(dice);
  return urdf(dice, kind == "urdf_mimics");
}

}  // namespace thenar
