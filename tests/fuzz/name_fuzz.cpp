// SPDX-License-Identifier: Apache-2.0
// Whatever the text of a scene's name: it is refused, or all that is made of it is made: the messages of a window, the
// summary, a recording that is read back, and a problem file that is read back with the same name.
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "engine/formats/mcap_reader.h"
#include "engine/formats/problem_file.h"
#include "engine/grasp/model.h"
#include "engine/models/build_model.h"
#include "engine/recordings/recording_file.h"
#include "engine/recordings/state_message.h"
#include "engine/results/summary.h"
#include "engine/scenes/config.h"
#include "engine/scenes/key_table.h"
#include "engine/scenes/scene_file.h"
#include "tests/fuzz/memory_file.h"

namespace {

using namespace thenar;

/// The name that a file of this text gives a scene.
std::string name_in(const std::filesystem::path& file) {
  Config config(file, scene_keys());
  std::string name = config.root().text("name");
  config.finish();
  return name;
}

void use(Model& model, const std::string& name) {
  static const MemoryFile kRecording("named.mcap"), kProblem("named.fcp");
  model.scene.name = name;
  if (nlohmann::json::parse(scene_message(model, true).dump()).at("name") != name) std::abort();
  (void)summarize(model, Recording{}).dump();
  RecordingFile(kRecording.path(), model).finish();
  if (!read_mcap(kRecording.path(), [](const McapMessage&) {}).whole) std::abort();
  ContactFile problem;
  problem.name = name;
  problem.W = Eigen::MatrixXd::Identity(3, 3);
  problem.delta_free = {Eigen::VectorXd::Zero(3)};
  problem.mu = Eigen::VectorXd::Zero(1);
  write_problem(kProblem.path(), problem);
  if (std::get<ContactFile>(read_problem(kProblem.path())).name != name) std::abort();
}

Model& model() {
  static Model made = build_model(load_scene(THENAR_CONFIGS "/minimal.yaml", {"object.points=500"}));
  return made;
}

}  // namespace

/// The model takes seconds, which are no input's.
extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  (void)model();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const MemoryFile kFile("name.yaml");
  kFile.write("name: " + std::string(text_of(data, size)));
  std::string name;
  try {
    name = name_in(kFile.path());
  } catch (const ConfigError&) {
    return 0;
  }
  use(model(), name);
  return 0;
}
