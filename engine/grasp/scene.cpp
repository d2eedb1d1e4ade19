#include "engine/grasp/scene.h"

#include <algorithm>
#include <type_traits>

namespace thenar {

using Eigen::Index;

Eigen::VectorXd DriveTable::at(double at_s) const {
  const Index last = time_s.size() - 1;
  const Index after = std::upper_bound(time_s.begin(), time_s.end(), at_s) - time_s.begin();
  if (after == 0) return values.col(0);
  if (after > last) return values.col(last);
  const double share = (at_s - time_s[after - 1]) / (time_s[after] - time_s[after - 1]);
  return values.col(after - 1) + share * (values.col(after) - values.col(after - 1));
}

std::optional<Solid> solid_of(const Shape& shape) {
  if (const auto* box = std::get_if<BoxShape>(&shape)) return *box;
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) return *sphere;
  if (const auto* cylinder = std::get_if<CylinderShape>(&shape)) return *cylinder;
  return std::nullopt;
}

std::optional<ExactShape> exact_shape_of(const Shape& shape) {
  return std::visit(
      []<typename Kind>(const Kind& kind) -> std::optional<ExactShape> {
        if constexpr (std::is_same_v<Kind, CloudShape>) {
          return std::nullopt;
        } else {
          return kind;
        }
      },
      shape);
}

const char* to_string(Phase::Kind kind) {
  switch (kind) {
    case Phase::Kind::kApproach:
      return "approach";
    case Phase::Kind::kClose:
      return "close";
    case Phase::Kind::kLoad:
      return "load";
    case Phase::Kind::kLift:
      return "lift";
    case Phase::Kind::kMove:
      return "move";
    case Phase::Kind::kInsert:
      return "insert";
    case Phase::Kind::kPlace:
      return "place";
    case Phase::Kind::kRelease:
      return "release";
  }
  return "";
}

}  // namespace thenar
