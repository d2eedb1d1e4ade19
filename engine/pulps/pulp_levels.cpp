// SPDX-License-Identifier: Apache-2.0
#include "engine/pulps/pulp_levels.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "engine/grasp/model.h"
#include "engine/pulps/pressed_pulp.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

constexpr int kDirections = 6;
constexpr std::array kDepths{0.5, 0.75, 1.0};  // Relative to the one at the expected load: a grip closes through them.
constexpr Index kFewestControls = 8;           // With fewer, hardly one of them faces the object.

/// Returns direction k of those spread evenly over the cap of 45 degrees about n: a finger's pulp, without its sides.
Vector3d direction(const Vector3d& n, int k) {
  const double z = 1.0 - (1.0 - std::numbers::sqrt2 / 2.0) * (k + 0.5) / kDirections;
  const double angle = std::numbers::pi * (3.0 - std::sqrt(5.0)) * k;  // the golden one
  const Vector3d e1 = n.unitOrthogonal(), e2 = n.cross(e1);
  return z * n + std::sqrt(1.0 - z * z) * (std::cos(angle) * e1 + std::sin(angle) * e2);
}

/// The reference force: Hertz's, but for a capsule, to whose side Hertz does not apply, that of its leaves.
class ForceReference {
 public:
  ForceReference(const Pulp& pulp, int level) : pulp_(pulp) {
    if (!pulp.shape || pulp.shape->form != PulpShape::Form::kCapsule) return;
    leaves_ = pulp;
    if (level > 0) set_level(*leaves_, 0);
  }
  [[nodiscard]] double force_N(const Vector3d& n, double depth_m) const {
    if (!leaves_) return hertz_force_N(pulp_, n, depth_m);
    return press(*leaves_, n, depth_m, depth_m, leaves_->controls()).force_N.sum();
  }

 private:
  const Pulp& pulp_;
  std::optional<Pulp> leaves_;
};

}  // namespace

LevelEstimate estimate_level(const Scene& scene, const std::vector<Pulp>& pulps, int level) {
  LevelEstimate result{.level = level, .controls = pulps.front().controls()};
  const double share = 1.0 / (kDirections * static_cast<double>(pulps.size()));
  for (std::size_t finger = 0; finger < pulps.size(); ++finger) {
    const Pulp& pulp = pulps[finger];
    const ForceReference reference(pulp, level);
    const Vector3d& middle = scene.hand.fingertips[finger].normal;
    const double deepest_m =
        std::min(hertz_depth_m(pulp, middle, expected_load_N(scene, pulp)), kTrustPerRadius * pulp.radius_m);
    for (int k = 0; k < kDirections; ++k) {
      const Vector3d n = direction(middle, k);
      for (const double depth : kDepths) {
        const double depth_m = depth * deepest_m;
        const PressedPulp pressed = press(pulp, n, depth_m, scene.contact.band_m, scene.contact.max_per_finger);
        const double error = pressed.force_N.sum() / reference.force_N(n, depth_m) - 1.0;
        result.force_error += share / kDepths.size() * error * error;
        if (depth != kDepths.back()) continue;
        result.contacts += share * static_cast<double>(pressed.controls.size());
        Index loaded = (pressed.force_N.array() > 0.0).count();
        if (loaded == scene.contact.max_per_finger) {
          const PressedPulp whole = press(pulp, n, depth_m, scene.contact.band_m, pulp.controls());
          loaded = (whole.force_N.array() > 0.0).count();
          result.missing = std::max(result.missing, 1.0 - pressed.force_N.sum() / whole.force_N.sum());
        }
        result.needed = std::max(result.needed, loaded);
      }
    }
  }
  result.force_error = std::sqrt(result.force_error);
  return result;
}

std::vector<Pulp> make_pulps(const Scene& scene) {
  std::vector<Pulp> pulps;
  for (const Fingertip& tip : scene.hand.fingertips) {
    pulps.push_back(make_pulp(tip.centre_m, tip.radius_m, tip.shape, scene.fingertips->points, scene.fingertips->leaves,
                              material_of(tip, scene.fingertips->material)));
  }
  return pulps;
}

bool have_same_pulps(const Scene& one, const Scene& other) {
  if (!one.fingertips || !other.fingertips) return false;
  const auto is_same = [&](const Fingertip& a, const Fingertip& b) {
    return a.centre_m == b.centre_m && a.radius_m == b.radius_m && a.shape == b.shape &&
           material_of(a, one.fingertips->material) == material_of(b, other.fingertips->material);
  };
  return one.fingertips->points == other.fingertips->points && one.fingertips->leaves == other.fingertips->leaves &&
         std::ranges::equal(one.hand.fingertips, other.hand.fingertips, is_same);
}

double expected_load_N(const Scene& scene, const Pulp& pulp) {
  if (scene.hand.slides) {
    double most_N = 0.0;
    for (const Slide& slide : scene.slides) most_N = std::max(most_N, slide.force_N);
    return most_N > 0.0 ? most_N : hertz_force_N(pulp, pulp.radius_m / 8.0);
  }
  // The thumb faces the other fingers, and carries half of the weight by friction.
  const double mu =
      scene.control ? std::min(scene.control->grasp_friction, scene.contact.friction) : scene.contact.friction;
  const double weight_N = scene.object.mass_kg * scene.gravity.norm();
  const double held_N = mu > 0.0 ? weight_N / (2.0 * mu) : 0.0;
  const double load_N = std::max(held_N, scene.control ? scene.control->internal_force_N : 0.0);
  return load_N > 0.0 ? load_N : hertz_force_N(pulp, pulp.radius_m / 8.0);
}

std::vector<LevelEstimate> estimate_levels(const Scene& scene, std::vector<Pulp>& pulps) {
  std::vector<LevelEstimate> levels;
  for (int level = 0; level == 0 || pulps.front().controls() > kFewestControls; ++level) {
    for (Pulp& pulp : pulps) {
      if (level > 0) set_level(pulp, level);
    }
    levels.push_back(estimate_level(scene, pulps, level));
  }
  return levels;
}

const LevelEstimate& choose_level(const std::vector<LevelEstimate>& levels, double force_error) {
  const auto good = [&](const LevelEstimate& level) { return level.force_error <= force_error; };
  const auto coarsest = std::find_if(levels.rbegin(), levels.rend(), good);
  if (coarsest != levels.rend()) return *coarsest;
  return *std::min_element(levels.begin(), levels.end(), [](const LevelEstimate& a, const LevelEstimate& b) {
    return a.force_error < b.force_error;
  });
}

}  // namespace thenar
