// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <numbers>
#include <optional>
#include <vector>

#include "engine/control/control_tick.h"
#include "engine/grasp/contact_tick.h"
#include "engine/loops/known_stiffness.h"
#include "engine/results/verdict.h"

namespace thenar {

inline constexpr double kDegrees = 180.0 / std::numbers::pi;  ///< Degrees per radian.
inline constexpr double kFinalWindow_s = 0.3;                 ///< Window of the means at a run's end.

/// Normal and tangential part of a finger's force [N].
struct NormalTangential {
  double normal_N = 0.0, tangential_N = 0.0;
};

/// The last answer of the grip to what fingertips felt.
struct LastReflex {
  ReflexEvent event = ReflexEvent::kNone;
  int finger = -1;      ///< The finger that felt it most.
  double time_s = 0.0;  ///< Time at which the grip began to answer.
};

/// Record of one tick, taken after its commit.
struct TickRecord {
  TickRecord() = default;
  explicit TickRecord(const Hand& hand)
      : q_rad(hand.at_zero()),
        torques_Nm(hand.at_zero()),
        load(hand.fingers()),
        force(hand.fingers()),
        force_desired(hand.fingers()),
        desired_N(hand.fingers(), Eigen::Vector3d::Zero()),
        force_error_N(hand.fingers()),
        margin(hand.fingers()),
        sliding_share(hand.fingers()),
        creep_m_per_s(hand.fingers()),
        slip_m(hand.fingers()),
        spin_rad(hand.fingers()),
        start_slip_m(hand.fingers()),
        start_spin_rad(hand.fingers()),
        walk_m(hand.fingers(), Eigen::Vector3d::Zero()),
        turn_rad(hand.fingers()),
        contact(hand) {}

  double time_s = 0.0;                                     ///< Time at the tick's end.
  bool controlled = false;                                 ///< A control tick ran before it.
  int phase = -1;                                          ///< Task phase at the last control tick; -1: none.
  bool holds = true;                                       ///< True if the fingers are to carry the object.
  Eigen::Vector3d arm_m = Eigen::Vector3d::Zero();         ///< Arm position, object axes at the start.
  double borne_N = 0.0;                                    ///< Force of the fingers against gravity; 0 without.
  Eigen::Isometry3d X_WT = Eigen::Isometry3d::Identity();  ///< The target, world.
  Eigen::Vector3d position_m, target_m;                    ///< Displacement from the start, object axes at the start.
  double rotation_error_rad = 0.0;                         ///< Angle between the object and its target.
  Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();  ///< The object, world.
  JointVector q_rad;                                       ///< Joint angles; slides in m.
  JointVector torques_Nm;                                  ///< Commanded joint torques; zero without control.
  PerFinger<FingerLoad> load;
  PerFinger<NormalTangential> force, force_desired;
  PerFinger<Eigen::Vector3d> desired_N;  ///< f^d, world axes; zero without control.
  PerFinger<double> force_error_N;       ///< |f^d - f|.
  PerFinger<double> margin;              ///< This and the next two: see PatchReport; NaN without load.
  PerFinger<double> sliding_share, creep_m_per_s;
  PerFinger<double> slip_m, spin_rad;              ///< A patch's slip and spin since its first contact.
  PerFinger<double> start_slip_m, start_spin_rad;  ///< The part before kMeasuredFrom_s.
  PerFinger<Eigen::Vector3d> walk_m;               ///< Net slip from kMeasuredFrom_s on: the vectors' sum; object axes.
  PerFinger<double> turn_rad;                      ///< Net spin likewise, signed as PatchReport::spin_rad.
  PerFinger<Touch> touch;                          ///< Only of scenes that name it.
  ReflexReport reflex;                             ///< Of the last control tick; such scenes only.
  LastReflex last_reflex;                          ///< Last since the start; such scenes only.
  KnownStiffness stiffness;                        ///< Only of scenes that choose one.
  Ledger ledger;                                   ///< Sums since the start.
  TickReport contact;
  double interpolate_s = 0.0;  ///< This and the times below: 0 where the scene has no such stage.
  double find_s = 0.0, factors_s = 0.0, grasp_s = 0.0, muscle_s = 0.0, control_s = 0.0;
  GraspStatus grasp = GraspStatus::kOptimal;
  MuscleStatus muscle = MuscleStatus::kOptimal;
  double muscle_residual_Nm = 0.0;

  /// Returns true if the tick counts for the measures that leave out how the grip builds up.
  [[nodiscard]] bool is_measured() const { return is_from(kMeasuredFrom_s); }
  /// Returns true if the tick ends at this time or later, but for rounding.
  [[nodiscard]] bool is_from(double from_s) const { return time_s >= from_s - 1e-9; }
  /// Returns the published contact computation time: contact finding, assembly, solve, deformation and, in ticks that
  /// show fingertips, surface interpolation.
  [[nodiscard]] double contact_total_s() const {
    return find_s + factors_s + contact.assemble_s + contact.solve_s + contact.deform_s + interpolate_s;
  }
};

/// A grasp-force problem without a solution, as it stood.
struct UnsolvedGrasp {
  double time_s = 0.0;
  ControlReport control = {};
};

/// A run, tick by tick.
struct Recording {
  std::vector<TickRecord> ticks;
  Eigen::MatrixXd muscle_forces_N;  ///< Forces with which muscles pulled: muscles x ticks; no rows without muscles.
  Eigen::MatrixXd muscles_asked_N;  ///< Forces asked for; no rows unless muscles act on the contact side.
  Verdict verdict;
  std::optional<UnsolvedGrasp> unsolved;            ///< The first one.
  bool stopped = false;                             ///< The run ended before its time.
  std::optional<double> predicted_paper_law_error;  ///< For the last state; empty without control.
  double wall_s = 0.0;                              ///< Wall time of the loop.
};

}  // namespace thenar
