// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/mjcf_left_out.h"

#include <fmt/format.h>

#include <array>
#include <map>
#include <set>
#include <string_view>

#include "engine/formats/text.h"

namespace thenar {

namespace {

/// The attributes of an element by MuJoCo's XML reference: those that are read, or have no effect on a hand file; an
/// attribute of neither list changes something. Words between blanks.
struct KnownElement {
  std::string_view name, read, idle;
};

constexpr std::string_view kPoseWords = " pos quat axisangle xyaxes zaxis euler ";

constexpr std::array kKnownElements{
    KnownElement{
        "compiler", " angle eulerseq autolimits inertiafromgeom inertiagrouprange boundmass settotalmass coordinate ",
        " boundinertia balanceinertia strippath assetdir meshdir texturedir discardvisual usethread fusestatic "
        "convexhull exactmeshinertia alignfree saveinertial fitaabb "},
    KnownElement{"body", " name childclass ", " mocap user sleep "},
    KnownElement{"frame", " name childclass ", " "},
    KnownElement{"inertial", " mass ", " diaginertia fullinertia "},
    KnownElement{"joint", " name class type axis ref range limited ",
                 " damping armature frictionloss group user margin solreflimit solimplimit solreffriction "
                 "solimpfriction actuatorfrclimited "},
    KnownElement{"freejoint", " name ", " group align "},
    KnownElement{"geom", " name class type size fromto mass density group ",
                 " contype conaffinity condim priority friction solmix solref solimp margin gap material rgba hfield "
                 "mesh fitscale user fluidshape fluidcoef "},
    KnownElement{"site", " name class type fromto ", " group material size rgba user "},
    KnownElement{"spatial", " name class ",
                 " group user width material rgba margin solreflimit solimplimit solreffriction solimpfriction damping "
                 "armature frictionloss actuatorfrclimited "},
    KnownElement{"fixed", " name class limited range stiffness ",
                 " springlength group user margin solreflimit solimplimit solreffriction solimpfriction damping "
                 "armature frictionloss actuatorfrclimited actuatorfrcrange "},
};

/// Elements in bodies and tendons, and sections of the file, that a hand file has no place for.
constexpr std::string_view kPassedOver = " camera light ";
constexpr std::string_view kKnownSections =
    " compiler default worldbody tendon actuator equality option size statistic visual asset contact sensor keyframe "
    "custom extension include ";

bool has_word(std::string_view words, const std::string& word) {
  return words.find(" " + word + " ") != std::string_view::npos;
}

bool is_zero_text(const std::string& value) { return value.find_first_not_of("0. \t") == std::string::npos; }

/// What is left out, by the kind of element.
struct LeftOut {
  std::map<std::string, std::set<std::string>> attributes;
  std::map<std::string, int> elements;
};

/// Of a `default`, `tendon` stands for both kinds of tendons.
void look_at(const XmlElement& element, LeftOut& left) {
  const std::string name = element.name == "tendon" ? "spatial" : element.name;
  for (const KnownElement& known : kKnownElements) {
    if (known.name != name) continue;
    for (const auto& [attribute, value] : element.attributes) {
      const bool is_pose = name != "compiler" && has_word(kPoseWords, attribute);
      if (is_pose || has_word(known.read, attribute) || has_word(known.idle, attribute) || is_zero_text(value))
        continue;
      left.attributes[element.name].insert(attribute);
    }
  }
}

void look_at_bodies(const XmlElement& holder, LeftOut& left) {
  for (const XmlElement& child : holder.children) {
    const std::string& name = child.name;
    if (name == "body" || name == "frame") {
      look_at(child, left);
      look_at_bodies(child, left);
    } else if (name == "joint" || name == "freejoint" || name == "geom" || name == "site" || name == "inertial") {
      look_at(child, left);
    } else if (!has_word(kPassedOver, name)) {
      ++left.elements[name];
    }
  }
}

void look_at_defaults(const XmlElement& section, LeftOut& left) {
  for (const XmlElement& child : section.children) {
    if (child.name == "default") look_at_defaults(child, left);
    if (child.name == "joint" || child.name == "geom" || child.name == "site" || child.name == "tendon") {
      look_at(child, left);
    }
  }
}

void look_at_tendons(const XmlElement& section, LeftOut& left) {
  for (const XmlElement& tendon : section.children) {
    if (tendon.name == "spatial" || tendon.name == "fixed") {
      look_at(tendon, left);
    } else {
      ++left.elements[tendon.name];
    }
  }
}

}  // namespace

void note_left_out(const XmlElement& mujoco, std::vector<std::string>& notes) {
  LeftOut left;
  for (const XmlElement& section : mujoco.children) {
    if (section.name == "compiler") look_at(section, left);
    if (section.name == "worldbody") look_at_bodies(section, left);
    if (section.name == "default") look_at_defaults(section, left);
    if (section.name == "tendon") look_at_tendons(section, left);
    if (!has_word(kKnownSections, section.name)) ++left.elements[section.name];
  }
  for (const auto& [element, attributes] : left.attributes) {
    const std::vector<std::string_view> names(attributes.begin(), attributes.end());
    notes.push_back(fmt::format("of {} elements what these attributes say is left out: {}", printable(element),
                                printable(join(names, ", "))));
  }
  for (const auto& [element, number] : left.elements) {
    notes.push_back(fmt::format("{} left out", counted(number, printable(element) + " element")));
  }
}

}  // namespace thenar
