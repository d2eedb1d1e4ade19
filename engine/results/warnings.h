// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/grasp/model.h"
#include "engine/pulps/pressed_pulp.h"
#include "engine/results/recording.h"

namespace thenar {

/// Largest ratio of patch radius to pulp radius for a half space; above it the kernel's forces are uncertain.
inline constexpr double kHalfSpaceShare = 0.5;

/// Gathers, tick by tick, the violations of the model's assumptions in a run.
///
/// Friction     The controller plans with more than there is.
/// Full lists   A control point that `contact.max_per_finger` has no room for is more than 10 um in the object: the
///              list is full of loaded contacts, the pulp passes into the object, and its force is too small.
/// Deep pulps   By Hertz, a finger's load makes a patch wider than kHalfSpaceShare of the pulp's radius.
/// Small things A finger's patch is narrower than its control points are apart, or what it presses is deeper than it is
///              wide, so that the pulp would close around it: there is no bone in it.
/// Energy       Contacts have pushed bodies on, from nowhere, by more than 1 % of the energy that moves and is stored.
/// Balance      Energies do not add up, by more than 0.1 % of the same.
/// Stops        A joint rests on an end of its range, and the stop there bears load.
/// Fibres       A muscle's fibres are strained beyond the range of their short-range stiffness, and yield.
class Warnings {
 public:
  explicit Warnings(const Model& model)
      : model_(model),
        full_(model.fingers()),
        deep_(model.fingers()),
        narrow_(model.fingers()),
        swallowed_(model.fingers()),
        factor_(model.fingers(), 1.0),
        stopped_(model.scene.hand.joints.size()) {
    injected_.fingers_J = PerFinger<double>(model.fingers());
    for (std::size_t k = 0; k < model.pulps.size(); ++k) {
      factor_[k] = share_factor(model.pulps[k], model.scene.hand.fingertips[k].normal);
    }
  }

  void add(const TickRecord& tick);

  /// Returns a sentence each: who, by how much, since when. Empty if there are none.
  [[nodiscard]] std::vector<std::string> sentences() const;

 private:
  [[nodiscard]] std::string injected_in_words() const;
  /// Returns an empty text if energies add up.
  [[nodiscard]] std::string balance_in_words() const;

  /// Ticks of a finger in which something was beyond its bound.
  struct Beyond {
    std::int64_t ticks = 0;
    double since_s = 0.0, worst = 0.0, worst_s = 0.0;

    void add(double time_s, double value);
  };

  /// Energy from nowhere, against what there is.
  struct Injected {
    double driven_J = 0.0;  ///< Sum of |work| of the drive, tick by tick.
    double stored_J = 0.0;  ///< Largest stored energy.
    double all_J = 0.0;     ///< Injected so far.
    double unbalanced_J = 0.0;
    PerFinger<double> fingers_J;
    Beyond beyond;  ///< Value: its share.

    void add(const TickRecord& tick);
  };

  /// Returns the ratio of a finger's patch radius to its pulp's.
  [[nodiscard]] double share(std::size_t finger, double normal_N) const;

  const Model& model_;
  std::int64_t ticks_ = 0;
  PerFinger<Beyond> full_;                ///< Value: depth of a control point without room [m].
  PerFinger<Beyond> deep_;                ///< Value: load [N].
  PerFinger<Beyond> narrow_, swallowed_;  ///< Values: those of SmallPatch.
  PerFinger<double> factor_;              ///< share_factor() of each pulp.
  struct Stops {
    Beyond lower, upper;  ///< Value: torque on the stop [N m].
  };
  std::vector<Stops> stopped_;  ///< Stops of each joint.
  Injected injected_;
  Beyond yielded_;           ///< Value: size of the largest strain of muscle fibres that have yielded.
  YieldedFibres worst_;      ///< The most strained of them, when that was.
  std::uint64_t yield_ = 0;  ///< All muscles that have yielded, a bit each.
};

/// Returns the warnings of a whole run.
[[nodiscard]] std::vector<std::string> warnings(const Model& model, const Recording& recording);

/// Returns the warnings expected before a run, at the load of its fingers (expected_load_N), with remedies.
[[nodiscard]] std::vector<std::string> warnings(const Model& model);

}  // namespace thenar
