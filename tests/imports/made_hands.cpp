#include "tests/imports/made_hands.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace thenar {

namespace {

using Vector = std::array<double, 3>;

/// Numbers by a seed, the same on every machine.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : bits_(seed) {}

  double in(double least, double most) { return least + (most - least) * static_cast<double>(bits_() >> 11) * 0x1p-53; }
  int below(int number) { return static_cast<int>(in(0.0, number)); }
  bool is(double share = 0.5) { return in(0.0, 1.0) < share; }
  template <typename T>
  T one_of(std::initializer_list<T> all) {
    return *(all.begin() + below(static_cast<int>(all.size())));
  }
  Vector direction() {
    Vector v;
    double square = 0.0;
    do {
      v = {in(-1, 1), in(-1, 1), in(-1, 1)};
      square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    } while (square > 1.0 || square < 0.05);
    for (double& x : v) x /= std::sqrt(square);
    return v;
  }
  Vector near(const Vector& middle, double by) {
    return {middle[0] + in(-by, by), middle[1] + in(-by, by), middle[2] + in(-by, by)};
  }

 private:
  std::mt19937_64 bits_;
};

std::string text_of(const Vector& v) { return fmt::format("{:.9g} {:.9g} {:.9g}", v[0], v[1], v[2]); }

constexpr double kDegree = std::numbers::pi / 180.0;

/// What differs among the kinds; each function adds attributes or elements, in which single quotes enclose values.
struct Style {
  bool degrees = true;
  std::string compiler;              ///< Its other attributes.
  std::string before, after;         ///< Sections before and behind the world.
  std::string palm = "name='palm'";  ///< Attributes of the palm.
  std::function<std::string(const std::string&)> name = [](const std::string& n) { return "name='" + n + "'"; };
  std::function<std::string()> turn = [] { return ""; };  ///< Orientation of a body.
  /// Joints of a link, and what it has besides.
  std::function<std::string(int finger, int link)> joints, parts = [](int, int) { return ""; };
  std::string in_palm;
  std::string open_world, close_world;  ///< Bodies about the palm.
  std::string childclass;               ///< Attribute of the fingers' first bodies.
};

constexpr const char* kFingers = "tim";
constexpr int kLinks = 3;

std::string link_name(int finger, int link) { return fmt::format("{}{}", kFingers[finger], link + 1); }
double thumb_sign(int finger) { return finger == 0 ? -1.0 : 1.0; }

std::string angles(const Style& style, double low_deg, double high_deg) {
  const double unit = style.degrees ? 1.0 : kDegree;
  return fmt::format("{:.9g} {:.9g}", unit * low_deg, unit * high_deg);
}

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
    text +=
        fmt::format("<geom class='turned'{} {}/>\n", place,
                    dice.one_of({"quat='0.8 0.6 0 0.1'", "euler='0.2 0.3 0.1'", "zaxis='0.2 0.1 1'", "mass='0.01'"}));
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
    if (dice.is(0.4)) {
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
    if (meshes && (finger == 1 || link == 2)) {
      text += fmt::format("<geom type='mesh' mesh='bone' pos='0.01 0 0' {}/>\n", finger == 1 ? "mass='0.004'" : "");
    }
    if (dice.is(0.3)) text += "<geom type='box' size='0.03 0.03 0.03' group='4' mass='0.003'/>\n";
    return text;
  };
  MadeHand made = written(dice, style);
  made.files["bone.obj"] = tetrahedron(0.02);
  if (total) made.noted.emplace_back("settotalmass");
  if (meshes && style.compiler.find("inertiagrouprange") == std::string::npos) made.noted.emplace_back("mesh");
  return made;
}

std::string site(Dice& dice, const std::string& name, const Vector& at) {
  if (dice.is(0.3)) {
    const double half = 0.01;
    const Vector d = dice.direction();
    return fmt::format("<site name='{}' type='{}' size='0.002' fromto='{} {}'/>\n", name,
                       dice.one_of({"capsule", "cylinder", "box"}),
                       text_of({at[0] - half * d[0], at[1] - half * d[1], at[2] - half * d[2]}),
                       text_of({at[0] + half * d[0], at[1] + half * d[1], at[2] + half * d[2]}));
  }
  return fmt::format("<site name='{}' pos='{}'{}/>\n", name, text_of(at), dice.is() ? " euler='10 20 30'" : "");
}

/// Straight tendons along each finger and between two, over pulleys, that muscles pull.
MadeHand strings(Dice& dice) {
  Style style;
  style.compiler = " autolimits='true'";
  style.joints = [&](int finger, int link) { return plain_joint(dice, style, finger, link); };
  style.parts = [&](int finger, int link) {
    return plain_geom(dice) +
           site(dice, link_name(finger, link) + "f", dice.near({0.018, 0.008 * thumb_sign(finger), 0}, 0.002)) +
           site(dice, link_name(finger, link) + "e", dice.near({0.018, -0.008 * thumb_sign(finger), 0}, 0.002));
  };
  for (int k = 0; k < 3; ++k) {
    for (const char* side : {"f", "e"}) {
      style.in_palm += site(dice, fmt::format("{}0{}", kFingers[k], side), dice.near({-0.02, 0, 0.01 * k}, 0.02));
    }
  }
  std::string tendons, actuators;
  const std::string by_class =
      fmt::format("<default class='strong'><muscle force='{:.4g}'/></default>", dice.in(100, 300));
  for (int k = 0; k < 3; ++k) {
    for (const char* side : {"f", "e"}) {
      tendons += fmt::format("<spatial name='{}{}'{}>", kFingers[k], side, dice.is() ? " width='0.002'" : "");
      const bool halves = dice.is(0.4);
      if (halves && dice.is()) tendons += "<pulley divisor='1'/>";
      for (int link = 0; link <= kLinks; ++link) {
        if (link == 2 && halves)
          tendons += fmt::format("<pulley divisor='{}'/><site site='{}1{}'/>", dice.one_of({2, 3}), kFingers[k], side);
        tendons += fmt::format("<site site='{}{}{}'/>", kFingers[k], link, side);
      }
      tendons += "</spatial>\n";
      const std::string drives = fmt::format("name='{0}{1}m' tendon='{0}{1}'", kFingers[k], side);
      const double force = dice.in(10, 200);
      switch (dice.below(4)) {
        case 0:
          actuators += fmt::format("<muscle {} force='{:.4g}' range='0.6 1.2' lengthrange='0.01 1'/>\n", drives, force);
          break;
        case 1:
          actuators += fmt::format("<muscle class='strong' {} scale='400' lengthrange='0.01 1'/>\n", drives);
          break;
        case 2:
          actuators += fmt::format(
              "<general {1} dyntype='muscle' gaintype='muscle' biastype='muscle' dynprm='0.01 0.04' "
              "gainprm='0.75 1.05 {0:.4g} 200 0.5 1.6 1.5 1.3 1.2' biasprm='0.75 1.05 {0:.4g} 200 0.5 1.6 1.5 1.3 1.2' "
              "lengthrange='0.01 1'/>\n",
              force, drives);
          break;
        default:
          actuators += fmt::format("<muscle {} force='{:.4g}' gear='{:.3g}' lengthrange='0.01 1'/>\n", drives, force,
                                   dice.in(0.5, 2));
      }
    }
  }
  tendons +=
      "<spatial name='between'><site site='t2f'/><site site='i1f'/></spatial>\n<spatial name='felt'><site site='t2f'/>"
      "<site site='m3f'/></spatial>\n";
  actuators += "<muscle name='across' tendon='between' force='33' lengthrange='0.01 1'/>\n";
  style.before = "<default>" + by_class + "</default>\n";
  style.after =
      fmt::format("<tendon>\n{}</tendon>\n<actuator>\n{}</actuator>\n<sensor><tendonpos tendon='felt'/></sensor>\n",
                  tendons, actuators);
  MadeHand made = written(dice, style);
  made.noted = {"tendons without a muscle are left out: felt"};
  return made;
}

/// Tendons around spheres and cylinders, with sides and without, some through rings and over pulleys.
MadeHand wraps(Dice& dice) {
  Style style;
  style.degrees = dice.is();
  style.compiler = " autolimits='true'";
  style.joints = [&](int finger, int link) { return plain_joint(dice, style, finger, link); };
  style.parts = [&](int finger, int link) {
    const double y = thumb_sign(finger);
    const std::string name = link_name(finger, link);
    std::string text = plain_geom(dice) + site(dice, name + "f", dice.near({0.018, 0.011 * y, 0}, 0.001));
    text += fmt::format("<geom name='{}g' type='{}' size='{:.4g} 0.02' pos='{}'{}/>\n", name,
                        dice.one_of({"cylinder", "sphere"}), dice.in(0.006, 0.008),
                        text_of(dice.near({0, 0, 0}, 0.001)), dice.is() ? " zaxis='0 0 -1'" : "");
    const double side = dice.one_of({0.02, 0.012, 0.001});
    return text + fmt::format("<site name='{}s' pos='{}'/>\n", name, text_of({-0.001, side * y, 0.0005}));
  };
  std::string tendons, actuators;
  for (int k = 0; k < 3; ++k) {
    style.in_palm += site(dice, fmt::format("{}0f", kFingers[k]),
                          dice.near({-0.02, k == 0 ? 0.062 : 0.012, k == 0 ? 0.0 : 0.016 - 0.032 * (k - 1)}, 0.002));
    tendons += fmt::format("<spatial name='{0}f'><site site='{0}0f'/>", kFingers[k]);
    for (int link = 0; link < kLinks; ++link) {
      const std::string name = link_name(k, link);
      if (link == 2 && dice.is(0.3)) tendons += fmt::format("<pulley divisor='2'/><site site='{}f'/>", link_name(k, 1));
      tendons += fmt::format("<geom geom='{0}g'{1}/><site site='{0}f'/>", name,
                             dice.is(0.7) ? fmt::format(" sidesite='{}s'", name) : "");
    }
    tendons += "</spatial>\n";
    actuators += fmt::format("<muscle name='{0}m' tendon='{0}f' force='{1:.4g}' lengthrange='0.01 1'/>\n", kFingers[k],
                             dice.in(20, 100));
  }
  style.after = fmt::format("<tendon>\n{}</tendon>\n<actuator>\n{}</actuator>\n", tendons, actuators);
  return written(dice, style);
}

/// Joints that follow others: lines with references, in chains, without limits of their own; ties that hold nothing.
MadeHand ties(Dice& dice) {
  Style style;
  style.degrees = dice.is();
  const double unit = style.degrees ? 1.0 : kDegree;
  style.compiler = " autolimits='true'";
  const bool unlimited = dice.is(), by_class = dice.is();
  style.palm = "name='palm' axisangle='1 0 0 1'";
  style.joints = [&](int finger, int link) {
    const bool follows = finger > 0 && link == 2;
    const std::string range =
        follows && unlimited ? "limited='false'" : fmt::format("range='{}'", angles(style, -40, dice.in(60, 90)));
    return fmt::format("<joint name='{}j' axis='0 0 {}' ref='{:.6g}' {}/>\n", link_name(finger, link),
                       thumb_sign(finger), unit * dice.in(0, 20), range);
  };
  style.parts = [&](int, int) { return plain_geom(dice); };
  std::string equalities =
      fmt::format("<joint name='coupled' joint1='i3j' joint2='i2j' polycoef='{:.4g} {:.4g} 0 0 0'{}/>\n",
                  dice.in(-0.1, 0.1), dice.in(0.4, 0.9), by_class ? " active='true'" : "");
  equalities += fmt::format("<joint joint1='m2j' joint2='m3j' polycoef='0 {:.4g} 0 0 0'{}/>\n", dice.in(1.0, 1.4),
                            by_class ? " active='true'" : "");
  if (dice.is())
    equalities += fmt::format("<joint joint1='m1j' joint2='m2j' polycoef='0.05 {:.4g} 0 0 0'{}/>\n", dice.in(0.5, 1.2),
                              by_class ? " active='true'" : "");
  // Ties that are off, by themselves or by the class of all.
  equalities += by_class ? "<joint joint1='t1j' joint2='t2j' polycoef='0 0.5 0 0 0'/>\n"
                         : "<joint joint1='t1j' joint2='t2j' polycoef='0 0.5 0 0 0' active='false'/>\n";
  style.before =
      fmt::format("<default><joint damping='0.01'/>{}</default>\n", by_class ? "<equality active='false'/>" : "");
  style.after = fmt::format(
      "<equality>\n{}</equality>\n<tendon><fixed name='sum'><joint joint='i2j' coef='1'/><joint joint='i3j' "
      "coef='2'/></fixed></tendon>\n"
      "<sensor><tendonpos tendon='sum'/></sensor>\n<actuator><position joint='t1j' kp='2'/></actuator>\n",
      equalities);
  return written(dice, style);
}

/// Names that are missing, or have colons, slashes and blanks; files that include files.
MadeHand names(Dice& dice) {
  Style style;
  style.compiler = " autolimits='true'";
  const std::string prefix = dice.one_of<std::string>({"robot0:", "left/hand/", "the hand ", "1", "#", "- ", "a: b, "});
  style.palm = dice.is() ? "pos='0 0 0.1' euler='50 0 10'" : "name='body4' euler='50 0 10'";
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

/// Every actuator that can pull a tendon, and what gives its force.
MadeHand actuators(Dice& dice) {
  Style style;
  const bool autolimits = dice.is(0.7);
  style.compiler = fmt::format(" autolimits='{}'", autolimits);
  style.joints = [&](int finger, int link) { return plain_joint(dice, style, finger, link); };
  style.parts = [&](int finger, int link) {
    return plain_geom(dice) +
           site(dice, link_name(finger, link) + "f", dice.near({0.018, 0.008 * thumb_sign(finger), 0}, 0.002));
  };
  std::string tendons, text, muscles;  // MuJoCo wants muscles last.
  for (int k = 0; k < 3; ++k) {
    style.in_palm += site(dice, fmt::format("{}0f", kFingers[k]), dice.near({-0.02, 0, 0.01 * k}, 0.02));
    for (int link = 1; link <= kLinks; ++link) {
      tendons += fmt::format("<spatial name='{0}{1}'><site site='{0}0f'/>{2}<site site='{0}{1}f'/></spatial>\n",
                             kFingers[k], link, link == 1 ? "" : fmt::format("<site site='{}1f'/>", kFingers[k]));
    }
  }
  const double kp = dice.in(100, 900);
  style.before = fmt::format(
      "<default>{}<default class='weak'><{} forcerange='-{:.4g} 0' forcelimited='true'/></default></default>\n",
      dice.one_of<std::string>({"", "<general gear='1.5'/>", "<motor gear='0.7'/>"}),
      dice.one_of<std::string>({"general", "position", "motor"}), dice.in(3, 30));
  const auto limited = [&](const char* what) {
    return autolimits && dice.is() ? std::string() : fmt::format(" {}limited='true'", what);
  };
  for (int k = 0; k < 3; ++k) {
    for (int link = 1; link <= kLinks; ++link) {
      const std::string drives = fmt::format("name='{0}{1}m' tendon='{0}{1}'", kFingers[k], link);
      const double force = dice.in(5, 60);
      switch (dice.below(9)) {
        case 0:
          text +=
              fmt::format("<position {} kp='{:.4g}' forcerange='-{:.4g} 0'{}/>\n", drives, kp, force, limited("force"));
          break;
        case 1:
          text += fmt::format("<motor {} ctrlrange='-{:.4g} 0'{}/>\n", drives, force, limited("ctrl"));
          break;
        case 2:  // The lesser of both.
          text += fmt::format("<motor {} ctrlrange='-{:.4g} 0'{} forcerange='-{:.4g} 1'{} gear='2'/>\n", drives, force,
                              limited("ctrl"), dice.in(5, 60), limited("force"));
          break;
        case 3:
          text += fmt::format("<position class='weak' {} kp='{:.4g}'/>\n", drives, kp);
          break;
        case 4:  // A limit that is off.
          text += fmt::format("<motor {} ctrlrange='-{:.4g} 0'{} forcerange='-1 1' forcelimited='false'/>\n", drives,
                              force, limited("ctrl"));
          break;
        case 5:
          text += fmt::format("<general {} gainprm='-{:.4g}' ctrlrange='0 1'{}/>\n", drives, force, limited("ctrl"));
          break;
        case 6:
          text += fmt::format("<general {} class='weak' gainprm='{:.4g}' biastype='affine' biasprm='0 -{:.4g}'/>\n",
                              drives, kp, kp);
          break;
        case 7:  // Two of one tendon.
          text += fmt::format("<motor name='{0}{1}n' tendon='{0}{1}' ctrlrange='-7 0'{2}/>\n", kFingers[k], link,
                              limited("ctrl"));
          muscles += fmt::format("<muscle {} force='{:.4g}' lengthrange='0.01 1'/>\n", drives, force);
          break;
        default:
          text += fmt::format("<velocity {} kv='3' ctrlrange='-1 1'{} forcerange='-{:.4g} 5'{} gear='-1'/>\n", drives,
                              limited("ctrl"), force, limited("force"));
      }
    }
  }
  text += "<motor joint='t1j'/><motor site='t1f' gear='1 0 0 0 0 0'/>\n";
  style.after = fmt::format("<tendon>\n{}</tendon>\n<actuator>\n{}</actuator>\n", tendons, text + muscles);
  return written(dice, style);
}

/// Links with origins that are turned, fixed chains to the tips, and what readers of hands pass over.
MadeHand urdf(Dice& dice, bool mimics) {
  const auto origin = [&](const Vector& xyz, double turn) {
    return fmt::format("<origin xyz='{}'{}/>", text_of(xyz),
                       dice.is(0.2) ? "" : fmt::format(" rpy='{}'", text_of(dice.near({0, 0, 0}, turn))));
  };
  const auto link = [&](const std::string& name, bool has_mass) {
    std::string inner =
        has_mass ? fmt::format(
                       "<inertial>{}<mass value='{:.4g}'/><inertia ixx='1e-5' iyy='1e-5' izz='1e-5' ixy='0' ixz='0' "
                       "iyz='0'/></inertial>",
                       origin(dice.near({0.015, 0, 0}, 0.01), 1.0), dice.in(0.005, 0.05))
                 : "";
    const std::string shape = dice.one_of<std::string>(
        {"<sphere radius='0.007'/>", "<cylinder radius='0.007' length='0.02'/>", "<box size='0.01 0.02 0.03'/>"});
    inner += fmt::format(
        "<visual>{0}<geometry><mesh filename='package://hand/meshes/{1}.stl' scale='0.001 0.001 "
        "0.001'/></geometry></visual><collision>{0}<geometry>{2}</geometry></collision>",
        origin(dice.near({0.02, 0, 0}, 0.004), 1.0), name, has_mass ? shape : "");
    if (!has_mass) inner.clear();
    return fmt::format("<link name='{}'>{}</link>\n", name, inner);
  };
  const std::array<Vector, 3> knuckles{Vector{0.01, 0.075, 0}, Vector{0.02, 0, 0.016}, Vector{0.02, 0, -0.016}};
  MadeHand made;
  std::string text =
      "<?xml version='1.0'?>\n<robot name='hand'>\n<mujoco><compiler fusestatic='false' discardvisual='true' "
      "inertiafromgeom='false'/></mujoco>\n" +
      link("base", true);
  const auto joint = [&](const std::string& name, const std::string& type, const std::string& parent,
                         const std::string& child, const std::string& inner) {
    text += fmt::format("<joint name='{}' type='{}'><parent link='{}'/><child link='{}'/>{}</joint>\n", name, type,
                        parent, child, inner);
  };
  text += link("wrist", true) + link("palm", true);
  joint("wrist_j", dice.one_of({"fixed", "revolute", "prismatic"}), "base", "wrist",
        origin({0.1, 0, 0}, 1.0) + "<axis xyz='0 0 1'/><limit lower='-0.1' upper='0.2' effort='1' velocity='1'/>");
  joint("palm_j", "fixed", "wrist", "palm", origin({0, 0.1, 0}, 1.0));
  for (int k = 0; k < 3; ++k) {
    std::string parent = "palm";
    for (int l = 0; l < kLinks; ++l) {
      const std::string name = link_name(k, l);
      const bool follows = mimics && l > 0 && (k > 0 || l == 2);
      std::string type = "revolute";
      std::string inner =
          origin(l == 0 ? knuckles[static_cast<std::size_t>(k)] : Vector{0.036, 0, 0}, l == 0 ? 0.2 : 0.6);
      inner += fmt::format("<axis xyz='{}'/>", text_of(dice.near({0, 0, 2 * thumb_sign(k)}, 0.2)));
      if (follows) {
        MadeTie tie{name + "j", link_name(k, dice.is() ? 0 : l - 1) + "j", dice.one_of({1.0, 0.8, -0.6, 1.3}),
                    dice.one_of({0.0, 0.2})};
        inner += fmt::format("<mimic joint='{}'{}{}/>", tie.leader,
                             tie.ratio == 1.0 ? "" : fmt::format(" multiplier='{}'", tie.ratio),
                             tie.offset_rad == 0.0 ? "" : fmt::format(" offset='{}'", tie.offset_rad));
        if (dice.is()) type = "continuous";
        made.ties.push_back(tie);
      }
      if (type == "revolute")
        inner += fmt::format("<limit lower='{:.4g}' upper='{:.4g}' effort='1' velocity='1'/>",
                             follows ? -2.0 : dice.in(-0.5, 0), follows ? 3.0 : dice.in(0.7, 1.5));
      inner +=
          "<dynamics damping='0.1' friction='0.1'/><safety_controller soft_lower_limit='0' soft_upper_limit='0.1' "
          "k_velocity='1'/>";
      text += link(name, true);
      joint(name + "j", type, parent, name, inner);
      parent = name;
    }
    const std::string tip = fmt::format("{}_tip", kFingers[k]), pad = fmt::format("{}_pad", kFingers[k]);
    text += link(pad, true) + link(tip, false);
    joint(pad + "_j", "fixed", parent, pad, origin({0.02, 0.001, 0}, 0.4));
    joint(tip + "_j", "fixed", pad, tip, origin({0.006, 0, 0.001}, 0.4));
    made.tips.push_back(
        {std::string(1, kFingers[k]), tip, dice.near({0.002, 0, 0}, 0.002), dice.near({0.3, thumb_sign(k), 0}, 0.1)});
    text += fmt::format(
        "<transmission name='{0}t'><type>transmission_interface/SimpleTransmission</type><joint "
        "name='{0}1j'/><actuator name='a'/></transmission>\n<gazebo "
        "reference='{0}1'><selfCollide>true</selfCollide></gazebo>\n",
        kFingers[k]);
  }
  made.main = "hand.urdf";
  made.files[made.main] = text + "</robot>\n";
  return made;
}

}  // namespace

MadeHand made_hand(const std::string& kind, std::uint64_t seed) {
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
