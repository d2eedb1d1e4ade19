// SPDX-License-Identifier: Apache-2.0
#include "engine/imports/mjcf_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "engine/formats/text.h"
#include "engine/imports/mjcf_defaults.h"
#include "engine/imports/mjcf_geom.h"
#include "engine/imports/mjcf_include.h"
#include "engine/imports/mjcf_left_out.h"
#include "engine/imports/mjcf_pose.h"
#include "engine/imports/mjcf_tendons.h"

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

constexpr std::size_t kMostBodies = 10'000;

/// Settings of the file for all bodies.
struct Reader {
  const MjcfDefaults& defaults;
  MjcfAngles angles;
  std::string inertia_from_geoms = "auto";
  std::array<double, 2> inertia_groups{0.0, 5.0};  ///< First and last group of the geoms that have mass, inclusive.
  double least_mass_kg = 0.0;                      ///< Of every body but the world.
  double total_mass_kg = 0.0;                      ///< To which all masses are scaled, if positive.
  BodyTree& tree;
  int weightless_meshes = 0;
  int centred_meshes = 0;  ///< Geoms of a stated mass whose centre is in a mesh file.
};

/// The place of an element: its body, and the frame in it.
struct Within {
  int body = 0;
  Isometry3d X_BF = Isometry3d::Identity();
  std::string childclass;
};

TreeJoint read_joint(const Reader& reader, const XmlElement& element, const Within& within) {
  TreeJoint joint;
  joint.name = element.text("name");
  joint.place = element.place;
  const std::string type = element.name == "freejoint"       ? "free"
                           : element.find("type") != nullptr ? element.text("type")
                                                             : "hinge";
  const std::map<std::string, TreeJointKind> kinds{{"hinge", TreeJointKind::kHinge},
                                                   {"slide", TreeJointKind::kSlide},
                                                   {"ball", TreeJointKind::kBall},
                                                   {"free", TreeJointKind::kFree}};
  const auto kind = kinds.find(type);
  if (kind == kinds.end()) refuse(element, fmt::format("'{}' is none of hinge, slide, ball, free", type));
  joint.kind = kind->second;
  joint.origin_m = within.X_BF * vector3(element, "pos").value_or(Vector3d::Zero());
  joint.axis = (within.X_BF.linear() * direction(element, "axis").value_or(Vector3d::UnitZ())).normalized();
  const double unit = joint.kind == TreeJointKind::kHinge ? reader.angles.unit_rad : 1.0;
  joint.reference = unit * number(element, "ref").value_or(0.0);
  const auto range = numbers(element, "range", 2, 2);
  const bool is_limited = reader.defaults.limits(element, "limited", "range");
  if (is_limited && range && (*range)[0] > (*range)[1]) {
    refuse(element, fmt::format("range: its lower end comes first: '{}'", element.text("range")));
  }
  if (is_limited && range && (*range)[0] < (*range)[1]) joint.range = {unit * (*range)[0], unit * (*range)[1]};
  return joint;
}

void add_site(const Reader& reader, const XmlElement& element, const Within& within) {
  TreeSite site;
  site.name = element.text("name");
  site.place = element.place;
  site.body = within.body;
  const auto ends = ends_of(element, element.find("type") != nullptr ? element.text("type") : "sphere");
  site.X_BS = within.X_BF * (ends ? ends->X_FG : pose_of(element, reader.angles));
  reader.tree.sites.push_back(std::move(site));
}

/// Sums of the masses of a body's geoms.
struct Weights {
  double mass_kg = 0.0;
  Vector3d moment = Vector3d::Zero();
  int unknown = 0;  ///< Geoms whose mass the file does not say.
  int centred = 0;  ///< Geoms whose mass it says, and not the centre.
};

void add_geom(const Reader& reader, const XmlElement& element, const Within& within, Weights& weights) {
  const MjcfGeom geom = read_geom(element, reader.angles, within.X_BF);
  const double group = number(element, "group").value_or(0.0);
  if (group >= reader.inertia_groups[0] && group <= reader.inertia_groups[1]) {
    const double mass_kg = geom.mass_kg.value_or(0.0);
    weights.mass_kg += mass_kg;
    weights.moment += mass_kg * geom.X_BG.translation();
    weights.unknown += geom.mass_kg ? 0 : 1;
    weights.centred += geom.type == "mesh" && mass_kg > 0.0 ? 1 : 0;
  }
  if (geom.round) reader.tree.bodies[within.body].rounds.push_back(*geom.round);
  const bool is_cylinder = geom.type == "cylinder";
  if (!element.text("name").empty() && (is_cylinder || geom.type == "sphere")) {
    reader.tree.wraps.push_back({element.text("name"), within.body, geom.X_BG, geom.radius_m, is_cylinder});
  }
}

/// Reads the elements of a body, or of a frame in it, except bodies: these go to `inner`, with their enclosing frame.
void read_parts(Reader& reader, const XmlElement& holder, const Within& within, Weights& weights,
                const XmlElement** inertial, std::vector<std::pair<const XmlElement*, Within>>& inner) {
  for (const XmlElement& child : holder.children) {
    const std::string& name = child.name;
    expect_one_orientation(child);
    if (name == "joint" || name == "freejoint") {
      if (within.body == 0) refuse(child, "the world has no joints");
      const TreeJoint joint = read_joint(reader, reader.defaults.completed(child, within.childclass), within);
      reader.tree.bodies[within.body].joints.push_back(joint);
    } else if (name == "site") {
      add_site(reader, reader.defaults.completed(child, within.childclass), within);
    } else if (name == "geom") {
      add_geom(reader, reader.defaults.completed(child, within.childclass), within, weights);
    } else if (name == "inertial") {
      *inertial = &child;
    } else if (name == "body") {
      inner.emplace_back(&child, within);
    } else if (name == "frame") {
      Within frame = within;
      frame.X_BF = within.X_BF * pose_of(child, reader.angles);
      if (const std::string* const childclass = child.find("childclass")) frame.childclass = *childclass;
      read_parts(reader, child, frame, weights, inertial, inner);
    } else if (name == "composite" || name == "flexcomp" || name == "replicate" || name == "attach") {
      refuse(child, "cannot be read: bodies must be written out one by one");
    }
  }
}

void read_body(Reader& reader, const XmlElement& element, const Within& parent) {
  if (reader.tree.bodies.size() > kMostBodies) refuse(element, fmt::format("is beyond {} bodies", kMostBodies));
  Within within;
  within.body = static_cast<int>(reader.tree.bodies.size());
  within.childclass = element.find("childclass") != nullptr ? element.text("childclass") : parent.childclass;
  TreeBody& body = reader.tree.bodies.emplace_back();
  body.name = element.text("name");
  body.place = element.place;
  body.parent = parent.body;
  body.X_PB = parent.X_BF * pose_of(element, reader.angles);

  Weights weights;
  const XmlElement* inertial = nullptr;
  std::vector<std::pair<const XmlElement*, Within>> inner;
  read_parts(reader, element, within, weights, &inertial, inner);
  TreeBody& whole = reader.tree.bodies[within.body];  // More bodies may have moved it.
  const bool by_geoms =
      reader.inertia_from_geoms == "true" || (inertial == nullptr && reader.inertia_from_geoms == "auto");
  if (by_geoms) {
    whole.mass_kg = weights.mass_kg;
    if (weights.mass_kg > 0.0) whole.com_m = weights.moment / weights.mass_kg;
    reader.weightless_meshes += weights.unknown;
    reader.centred_meshes += weights.centred;
  } else if (inertial != nullptr) {
    whole.mass_kg = number(*inertial, "mass").value_or(0.0);
    if (whole.mass_kg < 0.0) refuse(*inertial, "mass: must not be negative");
    whole.com_m = vector3(*inertial, "pos").value_or(Vector3d::Zero());
  }
  whole.mass_kg = std::max(whole.mass_kg, reader.least_mass_kg);
  for (const auto& [child, frame] : inner) read_body(reader, *child, frame);
}

/// Reads the settings of the compiler that bear on masses and places.
void read_compiler(const XmlElement& mujoco, const MjcfDefaults& defaults, Reader& reader) {
  XmlElement compiler;
  compiler.name = "compiler";
  compiler.place = mujoco.place;
  for (const char* setting : {"inertiagrouprange", "boundmass", "settotalmass"}) {
    if (const std::string text = defaults.compiler(setting); !text.empty()) {
      compiler.attributes.emplace_back(setting, text);
    }
  }
  if (const std::string inertia = defaults.compiler("inertiafromgeom"); !inertia.empty()) {
    reader.inertia_from_geoms = inertia;
  }
  if (const auto groups = numbers(compiler, "inertiagrouprange", 2, 2)) {
    reader.inertia_groups = {(*groups)[0], (*groups)[1]};
  }
  reader.least_mass_kg = number(compiler, "boundmass").value_or(0.0);
  reader.total_mass_kg = number(compiler, "settotalmass").value_or(0.0);
  if (defaults.compiler("coordinate") == "global") {
    refuse(mujoco, "coordinate: places must be local, as the format has them since MuJoCo 2.3.3");
  }
}

void note_meshes(const Reader& reader) {
  std::vector<std::string>& notes = reader.tree.notes;
  if (reader.weightless_meshes > 0) {
    notes.push_back(
        fmt::format("masses of {} geoms without one, such as meshes, are left out", reader.weightless_meshes));
  }
  if (reader.centred_meshes > 0) {
    notes.push_back(fmt::format("{}: centres of mass are taken at their places, for mesh files are not read",
                                counted(reader.centred_meshes, "mesh with a mass")));
  }
}

void set_total_mass(Reader& reader) {
  if (!(reader.total_mass_kg > 0.0)) return;
  double sum_kg = 0.0;
  for (const TreeBody& body : reader.tree.bodies) sum_kg += body.mass_kg;
  if (reader.weightless_meshes > 0 || !(sum_kg > 0.0)) {
    reader.tree.notes.emplace_back("masses are as written: settotalmass is left out where some are not known");
    return;
  }
  for (TreeBody& body : reader.tree.bodies) body.mass_kg *= reader.total_mass_kg / sum_kg;
}

/// Names bodies and joints without a name by their place, other than those that have one.
void name_the_nameless(BodyTree& tree) {
  std::set<std::string> taken;
  for (const TreeBody& body : tree.bodies) taken.insert(body.name);
  const auto new_name = [&](std::string name) {
    while (!taken.insert(name).second) name += "_2";
    return name;
  };
  for (std::size_t b = 1; b < tree.bodies.size(); ++b) {
    if (tree.bodies[b].name.empty()) tree.bodies[b].name = new_name(fmt::format("body{}", b));
  }
  taken.clear();
  for (const std::string_view name : joint_names(tree)) taken.emplace(name);
  for (TreeBody& body : tree.bodies) {
    for (std::size_t j = 0; j < body.joints.size(); ++j) {
      if (body.joints[j].name.empty()) body.joints[j].name = new_name(fmt::format("{}_joint{}", body.name, j + 1));
    }
  }
}

/// Throws ConfigError if two things of a kind have one name; those without one have none.
template <typename Items>
void expect_own_names(const Items& items, const char* kind) {
  std::map<std::string_view, int> seen;
  for (const auto& item : items) {
    if (item.name.empty() || ++seen[item.name] == 1) continue;
    XmlElement element;
    element.name = kind;
    element.place = item.place;
    element.attributes.emplace_back("name", item.name);
    refuse(element, "is there twice");
  }
}

}  // namespace

BodyTree read_mjcf(XmlElement mujoco, const std::filesystem::path& file, std::size_t left) {
  include_files(mujoco, file, left);
  const MjcfDefaults defaults(mujoco);
  BodyTree tree = empty_tree();
  Reader reader{.defaults = defaults, .angles = angles_of(mujoco, defaults), .tree = tree};
  read_compiler(mujoco, defaults, reader);

  bool has_world = false;
  for (const XmlElement& section : mujoco.children) {
    if (section.name != "worldbody") continue;
    has_world = true;
    Weights weights;
    const XmlElement* inertial = nullptr;
    std::vector<std::pair<const XmlElement*, Within>> inner;
    Within world;
    world.childclass = section.text("childclass");
    read_parts(reader, section, world, weights, &inertial, inner);
    for (const auto& [child, frame] : inner) read_body(reader, *child, frame);
  }
  if (!has_world) refuse(mujoco, "has no worldbody");
  name_the_nameless(tree);
  expect_own_names(tree.bodies, "body");
  std::vector<TreeJoint> joints;
  for (const TreeBody& body : tree.bodies) joints.insert(joints.end(), body.joints.begin(), body.joints.end());
  expect_own_names(joints, "joint");
  expect_own_names(tree.sites, "site");
  note_meshes(reader);
  set_total_mass(reader);
  read_ties(mujoco, defaults, tree);
  note_left_out(mujoco, tree.notes);
  return tree;
}

}  // namespace thenar
