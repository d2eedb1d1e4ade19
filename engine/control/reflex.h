// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>

#include "engine/control/afference.h"
#include "engine/control/control.h"
#include "engine/grasp/model.h"
#include "solvers/grasp_problem.h"

namespace thenar {

/// The cause of an increase of the grip force.
enum class ReflexEvent {
  kNone,
  kLoad,  ///< A tangential load changed faster than expected.
  kSlip,  ///< Hardly any of a patch stuck.
};

/// The action of the reflex in a control period.
struct ReflexReport {
  ReflexEvent event = ReflexEvent::kNone;  ///< Event that began now.
  int finger = -1;                         ///< Finger with the strongest signal.
  double rate_N_per_s = 0.0;               ///< Rate of change of a load.
  PerFinger<ContactGrip> grips;            ///< Grips for the grasp forces; empty without touch.
  PerFinger<double> friction;              ///< Friction as last sensed, or expected.
};

/// The grip reflex to tactile signals, fingertips.touch.delay after them.
///
/// Friction. The last value that a finger has sensed where its rim slipped; with friction: felt its cone has mu / (1 +
/// m). Pulse. A tangential load T that changes faster than the load rate relative to the commanded one (both less their
/// mean of the last kMemory_s), or a patch that hardly sticks, raises the finger's grip force by the amount needed when
/// the reflex acts, over the pulse's duration as a half sine of rates; then it decays
/// [Cole & Abbs 1988; Johansson & Westling 1984].
/// Regulation. The grip force slowly follows s* - stick, so that partial slip has one bound [Schiltz et al. 2022].
///
/// In a hold, and until its end has faded, the reflex is off: signals are then caused by the hold.
class Reflex {
 public:
  static constexpr double kBuiltUp_s = 0.3;  ///< Before this time loads are those of the closing grip.

  explicit Reflex(const Model& model);

  /// Runs a control period at `now`, `period_s` after the last, on the sensed state; `asked_N` are the last commanded
  /// forces.
  ReflexReport update(const Model& model, const Sensed& felt, const Snapshot& now, const Eigen::VectorXd& asked_N,
                      double period_s);

  /// For an archive (engine/loops/archive.h).
  template <typename Archive>
  void members(Archive& a) {
    a(margin_, delay_s_, fingers_, severity_, answers_slip_, pulse_from_s_, quiet_until_s_);
  }

 private:
  /// State of one finger.
  struct Finger {
    double friction = 0.0;
    Eigen::Vector3d mean_N = Eigen::Vector3d::Zero();  ///< Mean of the unexpected load.
    bool is_loaded = false;
    double pulse_N = 0.0;  ///< Rise of the grip force by the running pulse.
    double caught_N = 0.0, regulated_N = 0.0;

    template <typename Archive>
    void members(Archive& a) {
      a(friction, mean_N, is_loaded, pulse_N, caught_N, regulated_N);
    }
  };
  static void feel_friction(const Touch& touch, double period_s, Finger& finger);
  /// An unexpected signal of a finger, and the grip force in response.
  struct Surprise {
    ReflexEvent event = ReflexEvent::kNone;
    double severity = 0.0;
    double target_N = 0.0;
  };
  Surprise feel_load(const ControlSettings& control, const Sensed& felt, int k, double period_s);
  void answer(const ControlSettings& control, const Sensed& felt, const PerFinger<double>& pressing_N, double now_s,
              double period_s, bool quiet, ReflexReport& report);

  double margin_ = 0.0, delay_s_ = 0.0;
  PerFinger<Finger> fingers_;
  double severity_ = 0.0;      ///< Severity of the cause of the running pulse.
  bool answers_slip_ = false;  ///< True if that is a slip.
  double pulse_from_s_ = -std::numeric_limits<double>::infinity();
  double quiet_until_s_ = kBuiltUp_s;
};

}  // namespace thenar
