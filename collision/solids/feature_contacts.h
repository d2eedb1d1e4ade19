#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <optional>
#include <vector>

#include "collision/solids/sampled_solid.h"
#include "collision/solids/solid_pair.h"

namespace thenar {

inline constexpr int kCirclePlaces = 32;  ///< On a circle, that are looked at.
inline constexpr double kEverywhere = std::numeric_limits<double>::infinity();

/// X x, of which programs that are optimised less have no copy, as they may have of Eigen's own function.
inline Eigen::Vector3d placed(const Eigen::Isometry3d& X, const Eigen::Vector3d& x) {
  return X.linear().lazyProduct(x) + X.translation();
}

/// The solid that features of another meet: exact, or sampled.
struct FeatureBase {
  const Solid* exact = nullptr;
  const SampledSolid* sampled = nullptr;

  [[nodiscard]] std::optional<Foot> foot(int facet, const Eigen::Vector3d& x) const;
};

/// What looks for contacts of a feature: `base` in its own frame, to which the feature's solid is at X.
struct Look {
  FeatureBase base;
  Eigen::Isometry3d X;      ///< Of the feature's solid.
  Eigen::Isometry3d X_out;  ///< From base's frame to that of the contacts.
  bool reversed;            ///< The base is A.
  double band_m;
  std::vector<SolidContact>& contacts;

  void add(std::int32_t place, const Foot& foot, double round_m, const Eigen::Vector3d& x, bool roams = false,
           double same_m = kEverywhere) const;
};

/// Adds the contacts of a feature with a facet of the base. A segment's, only those inside of it, of least gap, over a
/// convex solid.
void meet_feature(const Look& look, const Feature& feature, int facet, std::int32_t place);

}  // namespace thenar
