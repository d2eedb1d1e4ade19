#include <fmt/format.h>

#include <csignal>
#include <filesystem>
#include <iostream>
#include <map>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "app/check.h"
#include "app/doctor.h"
#include "app/exit_code.h"
#include "app/export.h"
#include "app/fields.h"
#include "app/grasp.h"
#include "app/hand.h"
#include "app/host.h"
#include "app/keys.h"
#include "app/options.h"
#include "app/progress.h"
#include "app/results.h"
#include "app/run.h"
#include "app/solve.h"
#include "app/sweep.h"
#include "app/window_program.h"
#include "engine/formats/files.h"
#include "engine/insertion/insertion_figure.h"
#include "engine/insertion/insertion_report.h"
#include "engine/loops/realtime.h"
#include "engine/scenes/config.h"
#include "engine/scenes/hand_file.h"
#include "engine/scenes/scene_file.h"
#include "engine/scenes/shared_data.h"
#include "engine/studies/load_model.h"

namespace thenar::app {

namespace fs = std::filesystem;

namespace {

/// How the scene's peg goes into its hole.
int insertion(const Options& options) {
  Scene scene = scene_of(options);
  const PegScene peg = peg_scene(scene, options.scene.string());
  std::vector<Result> files;
  std::optional<FileLock> lock;
  if (!options.out.empty()) {
    for (const char* name : kInsertionFiles) files.push_back({"--out", options.out / name});
    check_results(files, scene_files(options.scene, options.overrides));
    lock.emplace(claim_folder(options.out, "--out"));
  }
  ReadyingLine line(options.quiet);
  const auto is_whole = [&](const Model&) { line.hide(); };
  const Model model = load_model(std::move(scene), {.begins = line.begins(), .is_whole = is_whole});
  require_part(model, Part::kEnvironment, options.scene);
  RunWatch watch(model.scene, options.quiet);
  const InsertionStudy study = study_insertion(model, peg, {.progress = watch.progress()});
  watch.end();
  if (options.format == "json") std::cout << insertion_json(model.scene, study).dump(2) << '\n';
  if (options.format != "json" && !options.quiet) std::cout << insertion_text(model.scene, study);
  const int code = report_verdict(model.scene, study.verdict);
  const bool was_stopped = stop_is_asked();  // Then the verdict says so.
  if (!options.out.empty() && !write_insertion(model.scene, study, options.out))
    std::cerr << "warning: no figure, for gnuplot is missing or failed\n";
  return code_at_end(code, was_stopped);
}

int print(const std::string& text) {
  std::cout << text;
  return kDone;
}

/// Of a scene, or of a hand. Throws ConfigError for a flag of the other.
int check(const Options& options) {
  const auto refuse = [&](bool asked, const char* flag, const char* why) {
    if (asked) throw ConfigError({{flag, "", options.scene.string() + why}});
  };
  if (!is_hand_file(options.scene)) {
    refuse(!options.hand.out.empty(), "--out", " is a scene, and this draws hands: thenar run --out draws a scene");
    return print(description(scene_of(options), options.parts));
  }
  refuse(!options.overrides.empty(), "--set", " is a hand, and this changes scenes");
  refuse(options.parts, "--parts", " is a hand, and this runs scenes");
  HandOptions hand = options.hand;
  hand.hand = options.scene.string();
  return run_hand(hand);
}

int execute(const Options& options) {
  const std::map<std::string, int (*)(const Options&)> commands{
      {"run", run},
      {"check", check},
      {"hand", [](const Options& o) { return run_hand(o.hand); }},
      {"solve", solve},
      {"grasp", grasp},
      {"new", new_scene},
      {"sweep", sweep},
      {"insertion", insertion},
      {"stiffness", [](const Options& o) { return run_stiffness(o.stiffness); }},
      {"export", export_recording},
      {"keys", [](const Options& o) { return print(o.markdown ? keys_as_markdown() : keys_as_text(o.prefix)); }},
      {"fields",
       [](const Options& o) {
         return print(o.stub ? fields_as_stub() : o.measures ? measures_as_markdown() : fields_as_markdown());
       }},
      {"schema", [](const Options&) { return print(keys_as_schema()); }},
      {"doctor",
       [](const Options& o) {
         doctor(std::cout, o.core);
         return int{kDone};
       }},
      {"scenes", [](const Options&) { return print(list_of_scenes()); }}};
  return commands.at(options.command)(options);
}

/// The program, from its arguments to its exit code.
int run_program(int argc, char** argv) try {
  if (!host_can_run()) {
    std::cerr << kHostCannotRun;
    return kInternal;
  }
  if (!has_stack()) {
    std::cerr << kNoStack;
    return kBadUsage;
  }
  widen_thread_stacks();
  std::signal(SIGXFSZ, SIG_IGN);  // A file at its limit is an error like a full disk.
  // The window is a program of its own, so that this one neither needs nor builds it.
  if (argc > 1 && std::string_view(argv[1]) == "demo") return run_window_program(argv);
  int exit_code = kDone;
  const std::optional<Options> options = parse_options(argc, argv, exit_code);
  if (options) exit_code = execute(*options);
  std::cout.flush();
  if (!std::cout) throw FileError("standard output", "could not be written in full");
  return exit_code;
} catch (const ConfigError& error) {
  std::cerr << error.what() << '\n';
  return kBadUsage;
} catch (const FileError& error) {
  std::cerr << error.what() << '\n';
  return kBadFile;
} catch (const std::bad_alloc&) {
  std::cerr << "not enough memory\n";
  return kInternal;
} catch (const std::system_error& error) {
  // So the system calls it when there is no memory for a thread.
  const bool no_thread = error.code() == std::errc::resource_unavailable_try_again;
  std::cerr << (no_thread ? "not enough memory" : std::string("internal error: ") + error.what()) << '\n';
  return kInternal;
} catch (const std::exception& error) {
  std::cerr << "internal error: " << error.what() << '\n';
  return kInternal;
}

}  // namespace

}  // namespace thenar::app

int main(int argc, char** argv) {
  thenar::app::hold_standard_streams();
  return thenar::app::run_program(argc, argv);
}
