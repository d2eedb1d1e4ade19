// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <optional>
#include <vector>

#include "collision/solids/sampled_solid.h"
#include "collision/solids/solid_pair.h"

namespace thenar {

inline constexpr int kCirclePlaces = 32;  ///< Places on a circle that are examined.
inline constexpr double kEverywhere = std::numeric_limits<double>::infinity();

/// Returns X x. Unlike Eigen's own function it has no copies in translation units that are optimised less.
inline Eigen::Vector3d placed(const Eigen::Isometry3d& X, const Eigen::Vector3d& x) {
  return X.linear().lazyProduct(x) + X.translation();
}

/// The solid that features of another one meet: exact or sampled.
struct FeatureBase {
  const Solid* exact = nullptr;
  const SampledSolid* sampled = nullptr;

  [[nodiscard]] std::optional<Foot> foot(int facet, const Eigen::Vector3d& x) const;
};

/// The search for contacts of a feature: `base` in its own frame, relative to which the feature's solid is at X.
struct Look {
  FeatureBase base;
  Eigen::Isometry3d X;      ///< Pose of the feature's solid.
  Eigen::Isometry3d X_out;  ///< Transform from base's frame to that of the contacts.
  bool reversed;            ///< True if the base is A.
  double band_m;
  std::vector<SolidContact>& contacts;

  void add(std::int32_t place, const Foot& foot, double round_m, const Eigen::Vector3d& x, bool roams = false,
           double same_m = kEverywhere) const;
};

/// Adds the contacts of a feature with a facet of the base; for a segment, only those of least gap inside of it, over a
/// convex solid.
void meet_feature(const Look& look, const Feature& feature, int facet, std::int32_t place);

}  // namespace thenar
