#pragma once

#include <vector>

#include "engine/contact_tick.h"
#include "engine/control_tick.h"
#include "engine/model.h"
#include "engine/problem_file.h"
#include "engine/state.h"

namespace thenar {

/// What a tick of a recorded run starts from, and what control asked for in it.
struct RecordedTick {
  State state;
  Controller controller;
  ControlReport control;
};

/// Inputs recorded from configs/box_grasp.yaml while the box is on its way: consecutive ticks at the published sizes
/// (36 000 + 3 x 2400 points), all of them with the same number of contacts. The problems have been through files, as
/// `thenar run --dump-problems` writes them: what is timed is what anyone can solve again.
struct RecordedRun {
  explicit RecordedRun(Eigen::Index contacts);

  Model model;
  std::vector<RecordedTick> ticks;
  std::vector<ContactFile> contacts;
  std::vector<GraspFile> grasps;
  std::vector<MuscleFile> muscles;
};

/// The run with 15, 30 or 60 contacts, or with 120 on pulps twice as fine; recorded once.
[[nodiscard]] const RecordedRun& recorded_run(Eigen::Index contacts);

}  // namespace thenar
