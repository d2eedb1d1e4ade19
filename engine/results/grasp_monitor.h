// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/control/pose_loop.h"
#include "engine/results/force_chatter.h"
#include "engine/results/recording.h"
#include "engine/results/task_watch.h"
#include "engine/results/verdict.h"

namespace thenar {

/// Returns the names of the muscles that have a bit in `which`.
[[nodiscard]] std::vector<std::string> muscle_names(const Hand& hand, std::uint64_t which);

/// Returns the reason why the hand cannot reach the desired stiffness: the motion, what it lacks, and the muscles.
[[nodiscard]] std::string lack_in_words(const Hand& hand, const StiffnessReport& found);

/// Watches a grasp tick by tick, and judges it: the only judge of all runs, whoever makes them.
///
/// It takes each control tick and each contact tick once, in the order of their times, and memory only where something
/// goes wrong for the first time. The verdict is on what it has been given so far; it may begin in the middle of a run,
/// and then counts slip from there on. Once a controller has lost its object, or failed in its task, all is said: a run
/// that goes on keeps the verdict of one that ends there.
class GraspMonitor {
 public:
  explicit GraspMonitor(const Model& model);

  /// Adds a control tick on a snapshot at `time_s`. `muscle_forces_N`, what it asks for, are not read in a scene
  /// without muscles.
  void add(double time_s, const ControlReport& control, const Eigen::VectorXd& muscle_forces_N);
  /// Adds a contact tick, with the sums of RunSums. `pull_N`: Snapshot::pull_N after it; read in a scene whose muscles
  /// act on the contact side.
  void add(const TickRecord& tick, const MuscleVector& pull_N = {});
  /// Marks the end of the run, when a task should be done.
  void end() { is_over_ = true; }
  /// Notes that records were lost, as `what` says.
  void miss(const std::string& what) { missed_ = what; }

  [[nodiscard]] bool lost() const { return loss_.has_value(); }
  /// Returns true if the object is lost or a phase of the task has failed.
  [[nodiscard]] bool has_ended() const { return loss_ || task_.has_failed(); }
  /// Returns true if that ended the run, and no further tick counts.
  [[nodiscard]] bool is_closed() const { return is_closed_; }
  /// Returns the first grasp-force problem without a solution.
  [[nodiscard]] const std::optional<UnsolvedGrasp>& unsolved() const { return unsolved_grasp_; }
  /// Returns the chatter of the forces, see Verdict.
  [[nodiscard]] double force_chatter() const { return chatter_.now(); }
  [[nodiscard]] Verdict verdict() const;

  /// For an archive (engine/loops/archive.h).
  template <typename Archive>
  void members(Archive& a) {
    a(unsolved_grasp_, solved_, unsolved_, not_finite_, ticks_with_contacts_, not_converged_, last_s_, unloaded_s_,
      rests_since_s_, holders_, loss_, idle_finger_, slip_before_m_, slip_m_, slips_since_s_, slid_s_, walk_before_,
      walks_, answer_, off_m_, off_rad_, swings_, swinging_, loop_, loop_phase_, joints_, too_soft_, chosen_s_,
      muscles_, pulls_, task_, is_over_, is_closed_, chatter_, trouble_s_, chatter_before_, missed_);
  }

 private:
  struct Event {
    double time_s = 0.0;
    std::string what;

    template <typename Archive>
    void members(Archive& a) {
      a(time_s, what);
    }
  };
  /// The worst value of something that has a bound.
  struct Worst {
    std::optional<double> first_s;  ///< Time at which the bound was first passed.
    double at_s = 0.0, beyond = 0.0, value = 0.0;
    void add(double time_s, double excess, double now);

    template <typename Archive>
    void members(Archive& a) {
      a(first_s, at_s, beyond, value);
    }
  };

  void watch_solver(const TickRecord& tick);
  void watch_grip(const TickRecord& tick);
  void watch_slip(const TickRecord& tick);
  void watch_walk(const TickRecord& tick);
  void watch_target(const TickRecord& tick);
  void watch_swings(const TickRecord& tick);
  void note_trouble();
  [[nodiscard]] std::optional<std::string> contact_failure() const;
  [[nodiscard]] std::string chatter_in_words() const;
  [[nodiscard]] const std::string& loop_in_words() const;
  [[nodiscard]] std::string grip_in_words() const;
  [[nodiscard]] std::string slips_in_words() const;
  [[nodiscard]] std::string rest_in_words() const;
  [[nodiscard]] bool answers_a_slip() const;
  [[nodiscard]] std::string answer_in_words(int k) const;
  [[nodiscard]] std::string way_off_in_words() const;
  [[nodiscard]] std::vector<Excess> beyond() const;

  const Model& model_;
  // Solves.
  std::optional<UnsolvedGrasp> unsolved_grasp_;
  std::optional<UnsolvedGrasp> solved_;  ///< The last one that was solved, of a late loop while the grip builds up.
  std::optional<Event> unsolved_, not_finite_;
  std::int64_t ticks_with_contacts_ = 0, not_converged_ = 0;
  // The grip.
  double last_s_ = 0.0, unloaded_s_ = 0.0;
  std::optional<double> rests_since_s_;  ///< Start of the environment carrying the object while < 2 fingers do.
  int holders_ = 0;                      ///< Fingers that carry load now.
  std::optional<Event> loss_, idle_finger_;
  std::optional<PerFinger<double>> slip_before_m_;  ///< The sums when this watch began.
  PerFinger<double> slip_m_;                        ///< Slip of patches that slid as a whole, from kMeasuredFrom_s on.
  PerFinger<std::optional<double>> slips_since_s_;
  PerFinger<double> slid_s_;  ///< Time at which a patch last slid as a whole.
  /// Net way and turn of a patch.
  struct Walk {
    PerFinger<Eigen::Vector3d> walk_m;
    PerFinger<double> turn_rad;

    template <typename Archive>
    void members(Archive& a) {
      a(walk_m, turn_rad);
    }
  };
  /// The farthest that a patch has walked, once that is too far.
  struct Walked {
    std::optional<double> since_s;
    double way_m = 0.0, turn_rad = 0.0;

    template <typename Archive>
    void members(Archive& a) {
      a(since_s, way_m, turn_rad);
    }
  };
  std::optional<Walk> walk_before_;  ///< The sums when this watch began.
  PerFinger<Walked> walks_;
  /// The answer of the grip to a slip, and the fingers' slip by then.
  struct Answer {
    double time_s = 0.0;
    ReflexReport reflex;
    PerFinger<double> slip_m;

    template <typename Archive>
    void members(Archive& a) {
      a(time_s, reflex, slip_m);
    }
  };
  std::optional<Answer> answer_;
  Worst off_m_, off_rad_;
  Swings swings_;
  std::optional<Event> swinging_;
  mutable std::optional<std::string> loop_;  ///< trouble_in_words() of the pose's loop, once it is asked for,
  mutable int loop_phase_ = -1;              ///< and the phase whose gains it has.
  // The hand.
  std::vector<Worst> joints_;
  /// A desired stiffness that could not be reached: the first since kMeasuredFrom_s, or the last one before.
  std::optional<Event> too_soft_;
  double chosen_s_ = 0.0;       ///< Time at which one was last chosen.
  std::vector<Worst> muscles_;  ///< Forces asked for.
  std::vector<Worst> pulls_;    ///< Forces that acted.
  TaskWatch task_;
  bool is_over_ = false, is_closed_ = false;
  ForceChatter chatter_;
  std::optional<double> trouble_s_;  ///< Time at which a solve, the grip or a finger first failed.
  double chatter_before_ = 0.0;      ///< Chatter up to trouble_s_.
  std::string missed_;
};

}  // namespace thenar
