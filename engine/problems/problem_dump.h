#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

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

/// Returns the muscle-force problem of the last control tick, and its answer.
[[nodiscard]] MuscleFile muscle_problem_file(const Controller& controller, const ControlReport& report);

/// A watcher that writes the problems of a run into a folder: of every Nth contact tick T, counted from 0,
/// contact-T.fcp (if the frame has contacts), and of the last control tick up to there, if not yet written,
/// grasp-T.json and muscle-T.json. T has six digits or more.
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
  std::optional<GraspFile> grasp_;    // of the last control tick, not yet written
  std::optional<MuscleFile> muscle_;  // likewise
};

}  // namespace thenar
