#include "engine/scenes/scene_environment.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>
#include <vector>

#include "engine/environment/room_for.h"
#include "engine/formats/text.h"
#include "engine/scenes/units.h"

namespace thenar {

using Eigen::Vector3d;

namespace {

HoleShape read_hole(const ConfigMap& map) {
  HoleShape hole{0.5 * map.quantity("diameter"), map.quantity("depth"), map.quantity("chamfer")};
  if (hole.chamfer_m >= hole.depth_m && !map.is_refused("depth")) map.refuse("chamfer", "must be less than the depth");
  return hole;
}

Solid read_solid(const ConfigMap& map) {
  const std::string kind = map.one_of();
  if (kind == "box") return BoxShape{map.quantities(kind)};
  if (kind == "sphere") return SphereShape{map.quantity(kind)};
  if (kind == "cylinder") return CylinderShape{map.map(kind).quantity("radius"), map.map(kind).quantity("length")};
  if (kind == "hole") return read_hole(map.map(kind));
  if (kind == "plane" && !map.flag(kind)) map.refuse(kind, "is true, or is left out");
  return HalfSpace{};
}

/// `all`: where bodies have no friction of their own.
EnvironmentBody read_body(const ConfigMap& map, const ConfigMap& all, std::size_t number) {
  EnvironmentBody body;
  body.name = map.has("name") ? map.text("name") : std::to_string(number);
  body.shape = read_solid(map.map("shape"));
  body.X_WE.translation() = map.quantities("position");
  if (map.has("rotation")) body.X_WE.linear() = map.rotation("rotation");
  if (!map.has("friction") && !all.has("friction")) map.refuse("friction", "is needed here, or in environment");
  if (map.has("friction") || all.has("friction"))
    body.friction = (map.has("friction") ? map : all).quantity("friction");
  if (!map.has("move")) return body;
  for (const ConfigMap& move : map.list_of_maps("move")) {
    body.moves.push_back({move.quantities("by"), move.quantity("from"), move.quantity("over")});
  }
  return body;
}

struct SolidText {
  std::string operator()(const HalfSpace&) const { return "plane: true"; }
  std::string operator()(const BoxShape& box) const { return "box: " + to_text(box.size_m, Dimension::kLength); }
  std::string operator()(const SphereShape& sphere) const {
    return "sphere: " + to_text(sphere.radius_m, Dimension::kLength);
  }
  std::string operator()(const CylinderShape& cylinder) const {
    return fmt::format("cylinder: {{radius: {}, length: {}}}", to_text(cylinder.radius_m, Dimension::kLength),
                       to_text(cylinder.length_m, Dimension::kLength));
  }
  std::string operator()(const HoleShape& hole) const {
    const auto length = [](double value_m) { return to_text(value_m, Dimension::kLength); };
    return fmt::format("hole: {{diameter: {}, depth: {}, chamfer: {}}}", length(2.0 * hole.radius_m),
                       length(hole.depth_m), length(hole.chamfer_m));
  }
};

}  // namespace

std::string solid_text(const Solid& solid) { return "{" + std::visit(SolidText{}, solid) + "}"; }

Environment read_environment(const ConfigMap& root) {
  const ConfigMap map = root.map("environment");
  Environment environment;
  environment.place = root.location("environment");
  environment.compliance_m_per_N = map.quantity("compliance");
  if (map.has("friction")) static_cast<void>(map.quantity("friction"));  // Read, though all bodies have their own.
  for (const ConfigMap& body : map.list_of_maps("bodies"))
    environment.bodies.push_back(read_body(body, map, environment.bodies.size() + 1));
  if (environment.bodies.empty() && !map.is_refused("bodies")) map.refuse("bodies", "names no body");
  return environment;
}

void check_room(const Scene& scene, const std::shared_ptr<const SampledSolid>& sampled) {
  if (!scene.environment) return;
  const std::optional<Solid> exact = solid_of(scene.object.shape);
  const TouchingSolid object = exact ? TouchingSolid(*exact) : TouchingSolid(sampled);
  const auto overlap = find_overlap(*scene.environment, object, scene.object.X_WO);
  if (!overlap) return;
  const auto at = [&](const Overlap::Place& place) {
    const Vector3d p_mm = 1e3 * place.p_E;
    return fmt::format("'{}' at ({:.3g}, {:.3g}, {:.3g}) mm of its frame", scene.environment->bodies[place.body].name,
                       p_mm.x(), p_mm.y(), p_mm.z());
  };
  const std::string fault =
      overlap->against
          ? fmt::format(
                "the object does not fit: {} and {} press against one another by {:.3g} mm, and no motion of it "
                "opens both",
                at(overlap->deepest), at(*overlap->against), 1e3 * overlap->depth_m)
          : fmt::format("the object lies {:.3g} mm deep in {}: move one of them", 1e3 * overlap->depth_m,
                        at(overlap->deepest));
  throw ConfigError({{scene.environment->place, "environment", fault}});
}

std::string environment_text(const Environment& environment) {
  std::string out = fmt::format("environment:\n  compliance: {}\n  bodies:\n",
                                to_text(environment.compliance_m_per_N, Dimension::kCompliance));
  for (const EnvironmentBody& body : environment.bodies) {
    out += fmt::format("    - name: {}\n      shape: {}\n      position: {}\n", quoted(body.name),
                       solid_text(body.shape), to_text(Vector3d(body.X_WE.translation()), Dimension::kLength));
    const Eigen::Matrix3d R = body.X_WE.linear();
    const auto row = [&](int i) { return to_text(Vector3d(R.row(i)), Dimension::kNone); };
    out += fmt::format("      rotation: [{},\n                 {},\n                 {}]\n", row(0), row(1), row(2));
    out += fmt::format("      friction: {}\n", to_text(body.friction, Dimension::kNone));
    if (!body.moves.empty()) out += "      move:\n";
    for (const EnvironmentMove& move : body.moves) {
      out += fmt::format("        - {{by: {}, from: {}, over: {}}}\n", to_text(move.by_m, Dimension::kLength),
                         to_text(move.from_s, Dimension::kTime), to_text(move.over_s, Dimension::kTime));
    }
  }
  return out;
}

}  // namespace thenar
