#include "bench/recorded.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>

#include "engine/files.h"
#include "engine/problem_dump.h"

namespace thenar {

using Eigen::Index;
namespace fs = std::filesystem;

namespace {

constexpr int kFrom = 700, kTo = 800;  // Ticks: the box moves at 35 to 45 mm/s.

Scene box_scene(Index contacts) {
  std::vector<std::string> changes{"contact.max_per_finger=" + std::to_string(contacts / kFingers)};
  // The scene's pulps have 32 to 44 control points near the box: too few for 40 in every tick.
  if (contacts > 60) changes.insert(changes.end(), {"fingertips.points=4800", "fingertips.leaves=640"});
  return load_scene(THENAR_CONFIGS "/box_grasp.yaml", changes);
}

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

}  // namespace

RecordedRun::RecordedRun(Index asked) : model(box_scene(asked)) {
  State state(model);
  Frame frame(model);
  Controller controller(model);
  ContactWorkspace work(model);
  const TemporaryFolder folder;
  ProblemDump dump(folder.path, 1);
  for (int tick = 0; tick < kTo; ++tick) {
    const bool recorded = tick >= kFrom;
    if (recorded) ticks.push_back({state, controller, {}});
    const Eigen::Vector3d centre_m = state.X_WO.translation();
    const ControlReport control = control_tick(model, state, controller, frame);
    (void)contact_tick(model, frame, work, state);
    if (!recorded) continue;
    if (frame.size() != asked) throw std::runtime_error("the recorded run lost contacts");
    ticks.back().control = control;
    dump.add_control(model, controller, control, centre_m);
    dump.add_contact(tick, model, frame, work);
  }

  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder.path)) files.push_back(entry);
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    ProblemFile problem = read_problem(file);
    if (auto* contact = std::get_if<ContactFile>(&problem)) contacts.push_back(std::move(*contact));
    if (auto* grasp = std::get_if<GraspFile>(&problem)) grasps.push_back(std::move(*grasp));
    if (auto* muscle = std::get_if<MuscleFile>(&problem)) muscles.push_back(std::move(*muscle));
  }
}

const RecordedRun& recorded_run(Index contacts) {
  static std::map<Index, RecordedRun> runs;
  return runs.try_emplace(contacts, contacts).first->second;
}

}  // namespace thenar
