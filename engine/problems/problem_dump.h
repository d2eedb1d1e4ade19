// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <variant>

#include "engine/control/control_tick.h"
#include "engine/formats/files.h"
#include "engine/formats/problem_file.h"
#include "engine/grasp/contact_tick.h"
#include "engine/grasp/frame.h"
#include "engine/grasp/model.h"
#include "engine/loops/run.h"

namespace thenar {

/// Returns the contact problem of the contact tick that `work` has just done on this frame, W dense, with the first
/// guess of its solve.
[[nodiscard]] ContactFile contact_problem_file(const Model& model, const Frame& frame, const ContactScratch& work);

/// Returns the grasp-force problem of a control tick, about the object's origin, with each finger's own friction and
/// internal force, if any, and its optima for both cones by solve_grasp_forces; without an answer the file states none.
[[nodiscard]] GraspFile grasp_problem_file(const Scene& scene, const ControlReport& report);

/// The problem that the muscle forces of a run solve: the least ones, or those under an object stiffness.
using MusclesFile = std::variant<MuscleFile, StiffMuscleFile>;

/// Returns the muscle-force problem that the last control tick solved, and its answer.
[[nodiscard]] MusclesFile muscle_problem_file(const Controller& controller, const ControlReport& report);

/// Returns the problem of the whole object stiffness that the last control tick was asked for, if it had no forces for
/// it: then it solved one of a share, or that of the least forces.
[[nodiscard]] std::optional<StiffMuscleFile> unmet_stiffness_file(const Controller& controller,
                                                                  const ControlReport& report);

/// A watcher that writes the problems of a run into a folder: of every Nth contact tick T, counted from 0,
/// contact-T.fcp (if the frame has contacts), and of the last control tick up to there, if not yet written,
/// grasp-T.json, muscle-T.json and, where it was asked for more stiffness than there is, stiffness-T.json. T has six
/// digits or more.
class ProblemDump : public Watcher {
 public:
  /// Requires a writable folder and every >= 1.
  ProblemDump(std::filesystem::path folder, std::int64_t every) : folder_(std::move(folder)), every_(every) {}

  // For a run on this thread. After a fault of the disk nothing more is written; the run continues.
  bool see_control(const ControlTick& tick) override;
  bool see_tick(const Tick& tick) override;
  /// Throws FileError if a file could not be written.
  void finish() const {
    if (fault_) throw *fault_;
  }

  [[nodiscard]] int files() const { return files_; }

 private:
  std::filesystem::path folder_;
  std::int64_t every_;
  int files_ = 0;
  std::optional<FileError> fault_;
  // Of the last control tick, not yet written:
  std::optional<GraspFile> grasp_;
  std::optional<MusclesFile> muscle_;
  std::optional<StiffMuscleFile> unmet_;
};

}  // namespace thenar
