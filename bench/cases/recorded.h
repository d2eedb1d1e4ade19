// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "engine/control/control_tick.h"
#include "engine/formats/problem_file.h"
#include "engine/grasp/contact_tick.h"
#include "engine/grasp/model.h"
#include "engine/grasp/state.h"
#include "engine/problems/problem_dump.h"

namespace thenar {

/// What makes of configs/box_grasp.yaml the same grasp with so many contacts, a multiple of 3: pulps with as many
/// control points as these can serve, 16 for each. More than 60 are on pulps with as many more samples.
[[nodiscard]] std::vector<std::string> changes_for(Eigen::Index contacts);

/// What a tick of a recorded run starts from.
struct RecordedTick {
  State state;
  Controller controller;
};

/// The box grasp of configs/box_grasp.yaml while the box is on its way, at the published sizes (36 000 + 3 x 2400
/// points): a hundred consecutive ticks, all of them with the same number of contacts.
struct RecordedTicks {
  /// So many contacts, see changes_for. Throws std::runtime_error if a tick has
  /// fewer. `dump`, if there is one, writes the problems of the ticks.
  explicit RecordedTicks(Eigen::Index contacts, ProblemDump* dump = nullptr);

  Model model;
  std::vector<RecordedTick> ticks;
};

/// With its problems, which have been through files, as `thenar run --dump-problems` writes them: what is timed is what
/// anyone can solve again.
struct RecordedProblems : RecordedTicks {
  std::vector<ContactFile> contacts;
  std::vector<GraspFile> grasps;
  std::vector<MuscleFile> muscles;
};

/// The run with so many contacts, recorded once.
[[nodiscard]] const RecordedProblems& recorded_run(Eigen::Index contacts);

}  // namespace thenar
