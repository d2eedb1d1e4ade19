#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>

#include "engine/control/afference.h"
#include "engine/control/control.h"
#include "engine/grasp/model.h"
#include "solvers/grasp_problem.h"

namespace thenar {

/// What made the grip rise.
enum class ReflexEvent {
  kNone,
  kLoad,  ///< A tangential load changed faster than was expected.
  kSlip,  ///< Hardly any of a patch stuck.
};

/// What the reflex does in a control period.
struct ReflexReport {
  ReflexEvent event = ReflexEvent::kNone;  ///< That began now.
  int finger = -1;                         ///< Which felt it most.
  double rate_N_per_s = 0.0;               ///< Of a load: how fast it changed.
  PerFinger<ContactGrip> grips;            ///< What grasp forces are found with; of no finger without touch.
  PerFinger<double> friction;              ///< As felt last, or expected.
};

/// The answer of the grip to what fingertips feel, fingertips.touch.delay after they do.
///
/// Friction. The last that a finger has felt where its rim slipped; with friction: felt its cone has mu / (1 + m).
/// Pulse. A tangential load T that changes faster than the load rate against what the controller asked for (both less
/// their mean of the last kMemory_s), or a patch of which hardly anything sticks, raises the finger's squeeze by what
/// will be needed when the answer acts, over the pulse's duration as a half sine of rates; then it goes back
/// [Cole & Abbs 1988; Johansson & Westling 1984].
/// Regulation. Slowly the squeeze follows s* - stick, so that partial slip has one upper bound [Schiltz et al. 2022].
///
/// In a hold, and until its end has faded, nothing is answered: what is felt then is the hold's doing.
class Reflex {
 public:
  static constexpr double kBuiltUp_s = 0.3;  ///< Before, loads are those of the grip that closes.

  explicit Reflex(const Model& model);

  /// One control period at `now`, `period_s` after the last, of what is felt; `asked_N` are the grasp forces so far.
  ReflexReport update(const Model& model, const Sensed& felt, const Snapshot& now, const Eigen::VectorXd& asked_N,
                      double period_s);

  /// For an archive (engine/loops/archive.h).
  template <typename Archive>
  void members(Archive& a) {
    a(margin_, delay_s_, fingers_, severity_, answers_slip_, pulse_from_s_, quiet_until_s_);
  }

 private:
  /// Of one finger.
  struct Finger {
    double friction = 0.0;
    Eigen::Vector3d mean_N = Eigen::Vector3d::Zero();  ///< Of the load that was not expected.
    bool is_loaded = false;
    double pulse_N = 0.0;  ///< How far the running pulse raises the squeeze.
    double caught_N = 0.0, regulated_N = 0.0;

    template <typename Archive>
    void members(Archive& a) {
      a(friction, mean_N, is_loaded, pulse_N, caught_N, regulated_N);
    }
  };
  static void feel_friction(const Touch& touch, double period_s, Finger& finger);
  /// What a finger feels that was not expected, and the squeeze that answers it.
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
  double severity_ = 0.0;      ///< Of what the running pulse answers,
  bool answers_slip_ = false;  ///< and whether that is a slip.
  double pulse_from_s_ = -std::numeric_limits<double>::infinity();
  double quiet_until_s_ = kBuiltUp_s;
};

}  // namespace thenar
