// SPDX-License-Identifier: Apache-2.0
#include "bench/cases/recorded.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>

#include "engine/formats/files.h"
#include "engine/models/build_model.h"
#include "engine/problems/problem_dump.h"
#include "engine/scenes/scene_file.h"

namespace thenar {

using Eigen::Index;
namespace fs = std::filesystem;

namespace {

constexpr int kFrom = 700, kTo = 800;  // Ticks: the box moves at 35 to 45 mm/s.

Scene box_scene(Index contacts) { return load_scene(THENAR_CONFIGS "/box_grasp.yaml", changes_for(contacts)); }

/// A folder that is gone afterwards.
struct TemporaryFolder {
  TemporaryFolder() : path(fs::temp_directory_path() / ("thenar-recorded-" + std::to_string(getpid()))) {
    prepare_folder(path);
  }
  ~TemporaryFolder() {
    std::error_code none;  // What cannot be removed stays.
    fs::remove_all(path, none);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  fs::path path;
};

/// Reads back the problems in a folder.
void read_problems(const fs::path& folder, RecordedProblems& run) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry);
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    ProblemFile problem = read_problem(file);
    if (auto* contact = std::get_if<ContactFile>(&problem)) run.contacts.push_back(std::move(*contact));
    if (auto* grasp = std::get_if<GraspFile>(&problem)) run.grasps.push_back(std::move(*grasp));
    if (auto* muscle = std::get_if<MuscleFile>(&problem)) run.muscles.push_back(std::move(*muscle));
  }
}

}  // namespace

std::vector<std::string> changes_for(Index contacts) {
  // At the grasp's loads a patch covers about a twentieth of a pulp.
  const Index most = contacts / 3, leaves = 12 * most;
  std::vector<std::string> changes{"contact.max_per_finger=" + std::to_string(most),
                                   "fingertips.leaves=" + std::to_string(leaves)};
  if (contacts > 60) changes.push_back("fingertips.points=" + std::to_string(leaves * 15 / 2));
  return changes;
}

RecordedTicks::RecordedTicks(Index asked, ProblemDump* dump) : model(build_model(box_scene(asked))) {
  GraspRun run(model);
  for (int tick = 0; tick < kTo; ++tick) {
    const bool recorded = tick >= kFrom;
    if (recorded) ticks.push_back({run.state, run.controller});
    run.control();
    if (recorded && dump) dump->see_control(ControlTick{run.time_s(), run.report, run.controller.f_muscle, &run});
    const TickReport contact = run.contact();
    if (recorded && run.frame.size() != asked) throw std::runtime_error("the recorded run lost contacts");
    if (recorded && dump)
      dump->see_tick(Tick{run.state, contact, run.report, run.controller.f_muscle, true, 0.0, &run});
  }
}

const RecordedProblems& recorded_run(Index contacts) {
  static std::map<Index, RecordedProblems> runs;
  if (const auto at = runs.find(contacts); at != runs.end()) return at->second;
  const TemporaryFolder folder;
  ProblemDump dump(folder.path, 1);
  RecordedProblems run{RecordedTicks(contacts, &dump), {}, {}, {}};
  read_problems(folder.path, run);
  return runs.emplace(contacts, std::move(run)).first->second;
}

}  // namespace thenar
