// SPDX-License-Identifier: Apache-2.0
// Made hands with tendons, actuators and couplings.

#include "tests/imports/made_parts.h"

namespace thenar::made {

namespace {

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

/// A tendon from the forearm along a finger, at times over a pulley behind which its force is shared.
std::string string_along(Dice& dice, int finger, const char* side) {
  std::string text = fmt::format("<spatial name='{}{}'{}>", kFingers[finger], side, dice.is() ? " width='0.002'" : "");
  const bool shared = dice.is(0.4);
  if (shared && dice.is()) text += "<pulley divisor='1'/>";
  for (int link = 0; link <= kLinks; ++link) {
    if (link == 2 && shared) {
      text += fmt::format("<pulley divisor='{}'/><site site='{}1{}'/>", dice.one_of({2, 3}), kFingers[finger], side);
    }
    text += fmt::format("<site site='{}{}{}'/>", kFingers[finger], link, side);
  }
  return text + "</spatial>\n";
}

std::string some_muscle(Dice& dice, const std::string& drives) {
  const double force_N = dice.in(10, 200);
  switch (dice.below(4)) {
    case 0:
      return fmt::format("<muscle {} force='{:.4g}' range='0.6 1.2' lengthrange='0.01 1'/>\n", drives, force_N);
    case 1:
      return fmt::format("<muscle class='strong' {} scale='400' lengthrange='0.01 1'/>\n", drives);
    case 2:
      return fmt::format(
          "<general {0} dyntype='muscle' gaintype='muscle' biastype='muscle' dynprm='0.01 0.04' gainprm='0.75 1.05 "
          "{1:.4g} 200 0.5 1.6 1.5 1.3 1.2' biasprm='0.75 1.05 {1:.4g} 200 0.5 1.6 1.5 1.3 1.2' lengthrange='0.01 "
          "1'/>\n",
          drives, force_N);
    default:
      return fmt::format("<muscle {} force='{:.4g}' gear='{:.3g}' lengthrange='0.01 1'/>\n", drives, force_N,
                         dice.in(0.5, 2));
  }
}

}  // namespace

/// Straight tendons along each finger and between two, over pulleys, that muscles pull; some joints follow others.
MadeHand strings(Dice& dice) {
  Style style;
  style.degrees = dice.is();
  style.compiler = " autolimits='true'";
  const double unit = style.degrees ? 1.0 : kDegree;
  style.joints = [&](int finger, int link) {
    return fmt::format("<joint name='{}j' axis='{}' range='{}' ref='{:.6g}'/>\n", link_name(finger, link),
                       text_of(dice.near({0, 0, thumb_sign(finger)}, 0.1)), angles(style, -30, dice.in(60, 90)),
                       unit * dice.in(0, 20));
  };
  const auto place = [&](int finger, double side, double x) {
    return dice.near({x, 0.008 * side * thumb_sign(finger), 0}, 0.002);
  };
  style.parts = [&](int finger, int link) {
    return plain_geom(dice) + site(dice, link_name(finger, link) + "f", place(finger, 1, 0.018)) +
           site(dice, link_name(finger, link) + "e", place(finger, -1, 0.018));
  };
  std::string tendons, muscles, places;
  for (int k = 0; k < 3; ++k) {
    for (const char* side : {"f", "e"}) {
      const std::string at = site(dice, fmt::format("{}0{}", kFingers[k], side), dice.near({-0.02, 0, 0.01 * k}, 0.02));
      (dice.is() ? style.in_palm : places) += at;
      tendons += string_along(dice, k, side);
      muscles += some_muscle(dice, fmt::format("name='{0}{1}m' tendon='{0}{1}'", kFingers[k], side));
    }
  }
  style.open_world = fmt::format(
      "<body name='arm'><geom size='0.03'/><joint name='wrist' axis='0 1 0' range='{}' "
      "ref='{:.6g}'/>\n{}",
      angles(style, -20, 30), unit * 9, places);
  style.close_world = "</body>\n";
  tendons +=
      "<spatial name='between'><site site='t2f'/><site site='i1f'/></spatial>\n"
      "<spatial name='felt'><site site='t2f'/><site site='m3f'/></spatial>\n";
  muscles += "<muscle name='across' tendon='between' force='33' lengthrange='0.01 1'/>\n";
  style.before =
      fmt::format("<default><default class='strong'><muscle force='{:.4g}'/></default></default>\n", dice.in(100, 300));
  style.after = fmt::format(
      "<tendon>\n{}</tendon>\n<actuator>\n{}</actuator>\n<sensor><tendonpos tendon='felt'/>"
      "</sensor>\n",
      tendons, muscles);
  if (dice.is()) {
    style.after += "<equality><joint joint1='i3j' joint2='i2j' polycoef='0.05 0.8 0 0 0'/></equality>\n";
  }
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

namespace {

/// An actuator of some kind, and what bounds its force; muscles are apart, for MuJoCo wants them last.
void add_actuator(Dice& dice, const std::string& tendon, bool autolimits, std::string& text, std::string& muscles) {
  const std::string drives = fmt::format("name='{0}m' tendon='{0}'", tendon);
  const double force_N = dice.in(5, 60), kp = dice.in(100, 900);
  const auto limits = [&](const char* what, double low, double high) {
    const bool is_said = !autolimits || dice.is();
    return fmt::format(" {0}range='{1:.4g} {2:.4g}'{3}", what, low, high,
                       is_said ? fmt::format(" {}limited='true'", what) : "");
  };
  switch (dice.below(11)) {
    case 0:
      text += fmt::format("<position {} kp='{:.4g}'{}/>\n", drives, kp, limits("force", -force_N, 0));
      break;
    case 1:
      text += fmt::format("<motor {}{}/>\n", drives, limits("ctrl", -force_N, 0));
      break;
    case 2:  // The lesser of both.
      text += fmt::format("<motor {}{}{} gear='2'/>\n", drives, limits("ctrl", -force_N, 0),
                          limits("force", -dice.in(5, 60), 1));
      break;
    case 3:
      text += fmt::format("<position class='weak' {} kp='{:.4g}'/>\n", drives, kp);
      break;
    case 4:  // A limit that is off.
      text +=
          fmt::format("<motor {}{} forcerange='-1 1' forcelimited='false'/>\n", drives, limits("ctrl", -force_N, 0));
      break;
    case 5:
      text += fmt::format("<general {} gainprm='-{:.4g}'{}/>\n", drives, force_N, limits("ctrl", 0, 1));
      break;
    case 6:
      text += fmt::format("<general {0} class='weak' gainprm='{1:.4g}' biastype='affine' biasprm='0 -{1:.4g}'/>\n",
                          drives, kp);
      break;
    case 7:  // Two of one tendon.
      text += fmt::format("<motor name='{0}n' tendon='{0}'{1}/>\n", tendon, limits("ctrl", -7, 0));
      muscles += fmt::format("<muscle {} force='{:.4g}' lengthrange='0.01 1'/>\n", drives, force_N);
      break;
    case 8:  // It is never wholly active.
      muscles +=
          fmt::format("<muscle {} force='{:.4g}'{} lengthrange='0.01 1'/>\n", drives, force_N, limits("ctrl", 0, 0.6));
      break;
    case 9:  // It says neither its force nor its bounds.
      text += fmt::format("<position {} kp='{:.4g}'/>\n", drives, kp);
      break;
    default:
      text += fmt::format("<velocity {} kv='3'{}{} gear='-1'/>\n", drives, limits("ctrl", -1, 1),
                          limits("force", -5, force_N));
  }
}

}  // namespace

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
  std::string tendons, text, muscles;
  for (int k = 0; k < 3; ++k) {
    style.in_palm += site(dice, fmt::format("{}0f", kFingers[k]), dice.near({-0.02, 0, 0.01 * k}, 0.02));
    for (int link = 1; link <= kLinks; ++link) {
      const std::string name = fmt::format("{}{}", kFingers[k], link);
      tendons += fmt::format("<spatial name='{0}'><site site='{1}0f'/>{2}<site site='{0}f'/></spatial>\n", name,
                             kFingers[k], link == 1 ? "" : fmt::format("<site site='{}1f'/>", kFingers[k]));
      add_actuator(dice, name, autolimits, text, muscles);
    }
  }
  // What a class says of one kind of actuators holds for all.
  style.before = fmt::format(
      "<default>{}<default class='weak'><{} forcerange='-{:.4g} 0' forcelimited='true'/></default></default>\n",
      dice.one_of<std::string>({"", "<general gear='1.5'/>", "<motor gear='0.7'/>"}),
      dice.one_of<std::string>({"general", "position", "motor"}), dice.in(3, 30));
  style.after = fmt::format(
      "<tendon>\n{}</tendon>\n<actuator>\n{}<motor joint='t1j'/><motor site='t1f' gear='1 0 0 0 0 "
      "0'/>\n{}</actuator>\n",
      tendons, text, muscles);
  MadeHand made = written(dice, style);
  made.noted = {"2 motor actuators of joints left out"};
  return made;
}

}  // namespace thenar::made
