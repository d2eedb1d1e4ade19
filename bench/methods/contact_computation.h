// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <deque>
#include <vector>

#include "bench/cases/recorded.h"
#include "engine/loops/surface_display.h"
#include "solvers/gauss_seidel.h"

namespace thenar {

/// Seconds of one contact computation of the paper's timing table, stage by stage.
struct ContactComputation {
  double find_s = 0.0;        ///< Contacts of the three pulps.
  double compliance_s = 0.0;  ///< Among the contacts: the frozen factors of W.
  double assemble_s = 0.0;    ///< Gaps and Jacobians at the state, free gaps and slips.
  double solve_s = 0.0;       ///< Gauss-Seidel and the commit.
  double deform_s = 0.0;      ///< Of the control points.
  double display_s = 0.0;     ///< Interpolation at 3 x 2400 samples; at 120 contacts 3 x 4800.
  SolveReport solve;

  [[nodiscard]] double total_s() const { return find_s + compliance_s + assemble_s + solve_s + deform_s + display_s; }
};

/// What the last tick of a run had to deal with: counts.
struct Workload {
  double contacts = 0.0, loaded = 0.0;
  double pairs = 0.0;         ///< Of contacts of one finger, each with itself, too.
  double loaded_pairs = 0.0;  ///< A contact, and a loaded one of the same finger.
  double sweeps = 0.0;
  double controls = 0.0;  ///< Of one fingertip.
  double samples = 0.0;   ///< Of all fingertips.
};

/// Times that Rougeron et al. 2006 publish for it, on a Pentium IV at 2.2 GHz; they have none for more than 60
/// contacts.
[[nodiscard]] double published_us(Eigen::Index contacts);

/// The box grasp while the box is on its way, with so many contacts in every tick, for a hundred ticks again and again.
/// The run is its own: what a tick leaves unsolved the next one starts from.
class ContactRun {
 public:
  /// Solves to the scene's tolerance, or for so many sweeps from the last tick's forces.
  ContactRun(Eigen::Index contacts, int max_sweeps);

  ContactComputation tick();

  [[nodiscard]] Workload workload() const;

  /// How far the last tick's forces are from an accurate solve of its problem, |f - f*| / |f*|; NaN where that failed.
  [[nodiscard]] double force_error() const;

  /// Of a pulp's force against Hertz's, with the contacts that it may have: see estimate_level.
  [[nodiscard]] double hertz_error() const;

 private:
  RecordedTicks recorded_;
  Frame frame_;
  ContactMemory memory_;
  ContactScratch work_;
  std::vector<SurfaceDisplay> displays_;
  RecordedTick now_;
  std::size_t ticks_ = 0;
  SolveReport solved_;
};

inline constexpr int kTicksATurn = 20, kDroppedTicks = 4;

/// Ticks of runs that take turns of so many consecutive ones, the first of them dropped: a run alone has its data in
/// the caches. Throws std::runtime_error where a solve did not converge.
[[nodiscard]] std::vector<std::vector<ContactComputation>> in_turns(std::deque<ContactRun>& runs, int turns);

}  // namespace thenar
