// SPDX-License-Identifier: Apache-2.0
// The program `thenar-window`, which `thenar demo` becomes: a scene while it runs, or a recording, in a browser.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <new>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "app/exit_code.h"
#include "app/host.h"
#include "app/open_page.h"
#include "app/record_flags.h"
#include "app/results.h"
#include "app/scene_flags.h"
#include "app/window/admission.h"
#include "app/window/server.h"
#include "app/window/session.h"
#include "app/wrong_command.h"
#include "engine/formats/files.h"
#include "engine/formats/mcap_reader.h"
#include "engine/formats/text.h"
#include "engine/grasp/model.h"
#include "engine/loops/realtime.h"
#include "engine/scenes/config.h"
#include "engine/scenes/hand_file.h"
#include "engine/scenes/scene_file.h"
#include "engine/scenes/shared_data.h"
#include "engine/studies/load_model.h"

namespace thenar::window {

namespace fs = std::filesystem;

namespace {

struct Options {
  fs::path file;  ///< A scene, or a recording.
  std::vector<std::string> overrides;
  app::RateFlags rates;
  app::RecordFlags record;
  ServerSettings server;
  SessionSettings session;
  bool browser = true;

  [[nodiscard]] bool is_recording() const { return ending_of(file) == ".mcap"; }
};

// The signal handler's.
std::atomic<bool> stop = false;
static_assert(std::atomic<bool>::is_always_lock_free);

CLI::Validator numeric_address() {
  return {[](const std::string& text) -> std::string {
            if (reach_of(text) != Reach::kNoAddress) return "";
            return text + " is no numeric address, such as 127.0.0.1 or 0.0.0.0";
          },
          ""};
}

CLI::Validator token() {
  return {[](const std::string& text) -> std::string {
            if (can_be_token(text)) return "";
            return "a token is 16 to 128 letters, digits, '-', '.', '_' or '~'";
          },
          ""};
}

/// The names that were given; throws CLI::ValidationError for what is none.
std::vector<HostName> host_names(const std::vector<std::string>& texts) {
  std::vector<HostName> names;
  for (const std::string& text : texts) {
    const std::optional<HostName> name = read_host_name(text);
    if (!name) throw CLI::ValidationError("--allow-host", text + " is no NAME or NAME:PORT, such as localhost:9000");
    names.push_back(*name);
  }
  return names;
}

/// What a recording has no use for.
void check_recording(const CLI::App& demo) {
  for (const char* flag :
       {"--set", "--contact-rate", "--control-rate", "--record", "--record-folder", "--no-realtime", "--core"}) {
    if (demo.count(flag) > 0) throw CLI::ValidationError(flag, "is for a scene, not for a recording");
  }
}

std::optional<Options> parse_options(int argc, const char* const* argv, int& exit_code) {
  CLI::App program{"The live window", "thenar"};
  program.require_subcommand(1);
  program.failure_message(app::wrong_command_line);
  Options options;
  CLI::App* const demo =
      program.add_subcommand("demo", "Shows a scene while it runs, or a recording, in a browser, and lets hands on it");
  app::add_scene(*demo, options.file, options.overrides,
                 "Scene file (YAML), the name of a scene that comes with the program, or a recording (.mcap)");
  demo->add_option("--port", options.server.port, "Port of the address that is printed; 0: any that is free")
      ->check(app::whole_within(0, 65535))
      ->capture_default_str();
  demo->add_option("--listen", options.server.address,
                   "Numeric address to be reached at. Pages need the token in the address that is printed")
      ->type_name("ADDRESS")
      ->capture_default_str()
      ->check(numeric_address());
  demo->add_option("--token", options.server.token,
                   "Token of the address instead of a random one, for programs that are to know it. Other users of the "
                   "machine see a command's options, but not its environment: THENAR_TOKEN has it, too")
      ->type_name("TEXT")
      ->envname("THENAR_TOKEN")
      ->check(token());
  std::vector<std::string> names;
  demo->add_option("--allow-host", names,
                   "Name by which pages reach the window through a tunnel, or a server before it; more than once for "
                   "more. Without a port: at any")
      ->type_name("NAME[:PORT]")
      ->allow_extra_args(false);
  demo->add_flag_callback(
      "--no-browser", [&] { options.browser = false; }, "Opens no browser, only prints the address");
  app::add_record(*demo, options.record, "File (.mcap) for what the run looks like");
  demo->add_option("--record-folder", options.session.record_folder,
                   "Folder for recordings that pages begin and end; default: the current one")
      ->type_name("FOLDER");
  app::add_rates(*demo, options.rates, false);
  demo->add_flag_callback(
      "--no-realtime", [&] { options.session.realtime = false; },
      "Takes what any thread gets: no SCHED_FIFO, no core of its own");
  app::add_core(*demo, options.session.core);
  demo->add_flag("--quiet", options.session.quiet, "Prints nothing but the address and errors");
  demo->footer("Ctrl-C ends it. Exit code: 0 when ended, 2 for a wrong command or scene, 3 for a file, 4 for a port.");
  try {
    program.parse(argc, argv);
    if (options.is_recording()) check_recording(*demo);
    app::check_rates(options.rates);
    options.server.also = host_names(names);
  } catch (const CLI::ParseError& error) {
    exit_code = program.exit(error) == 0 ? app::kDone : app::kBadUsage;
    return std::nullopt;
  }
  return options;
}

/// The changes of the scene: defaults of real time, which give way to the user's changes, and those to the flags.
std::vector<std::string> changes(const Options& options) {
  std::vector<std::string> overrides = app::realtime_defaults();
  for (const auto& more : {options.rates.defaults(), options.overrides, options.rates.changes()}) {
    overrides.insert(overrides.end(), more.begin(), more.end());
  }
  return overrides;
}

void end_on_signals() {
  set_stop_question([] { return stop.load(); });
  struct sigaction action {};
  action.sa_handler = [](int) { stop = true; };
  action.sa_flags = SA_RESETHAND;  // The second one ends at once what does not end.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
}

std::string way_from_elsewhere(const std::string& url, const Options& options) {
  if (reach_of(options.server.address) == Reach::kOthers) {
    return "the same, with a numeric address by which it reaches this one.";
  }
  const std::string place = url.substr(7, url.find('/', 7) - 7);  // Between "http://" and "/".
  char name[256] = "";
  gethostname(name, sizeof name - 1);
  return fmt::format("ssh -L {}:{} {}, then the same address there.", place.substr(place.rfind(':') + 1), place, name);
}

/// Says where the page is, and opens it where there is a desktop.
void announce(const std::string& url, const Options& options) {
  std::cout << url << std::endl;
  if (!options.session.quiet) {
    std::cout << "From another machine: " << way_from_elsewhere(url, options) << "\nCtrl-C ends it." << std::endl;
  }
  // Nobody could find a page whose address is nowhere to be read.
  if (!std::cout) throw FileError("standard output", "could not be written in full");
  if (options.browser) app::open_page(url);
}

void replay(const Options& options) {
  // Refused before anybody looks at it.
  double last_s = 0.0;
  if (!app::look_through(options.file, last_s).whole) {
    std::cerr << "warning: " << printable(options.file.string())
              << " was cut off; it is shown to its last whole state\n";
  }
  const WindowServer server(options.server, [](const Message&) { return "a recording takes no orders"; });
  announce(server.url(), options);
  while (!stop) std::this_thread::sleep_for(std::chrono::milliseconds(50));
}

/// The scene, and the names of its files by which a scene that is kept finds them from any folder.
AskedScene asked_scene(const Options& options) {
  AskedScene asked;
  asked.scene = app::scene_at_rates(options.file, changes(options), options.rates);
  if (!asked.scene.hand.slides) {
    const fs::path hand = scene_files(options.file, changes(options))[1];  // A hand that was read has a file.
    asked.fingers = load_hand(hand).fingers();
    asked.hand = hand_in_scene(hand, fs::absolute(hand));
  }
  const auto* const cloud = std::get_if<CloudShape>(&asked.scene.object.shape);
  if (cloud != nullptr) asked.object = fs::absolute(cloud->file);
  return asked;
}

void run(const Options& options) {
  AskedScene asked = asked_scene(options);
  if (options.record.asked())
    app::check_results({{"--record", options.record.file}}, scene_files(options.file, changes(options)));
  Model model = load_model(asked.scene, {.is_whole = [&](const Model& whole) {
                             if (options.record.asked()) app::check_record(whole, options.record);
                           }});
  if (options.record.file.has_parent_path()) prepare_folder(options.record.file.parent_path());
  SessionSettings settings = options.session;
  settings.record = options.record.file;
  settings.recording = options.record.settings();
  settings.asked = std::move(asked);
  Session session(std::move(model), settings);
  WindowServer server(options.server, [&](const Message& message) { return session.receive(message); });
  announce(server.url(), options);
  session.run(server, stop);
}

/// The program, from its arguments to its exit code.
int run_program(int argc, char** argv) try {
  if (!app::host_can_run()) {
    std::cerr << app::kHostCannotRun;
    return app::kInternal;
  }
  if (!app::has_stack()) {
    std::cerr << app::kNoStack;
    return app::kBadUsage;
  }
  app::tell_of_memory_at_the_end();
  widen_thread_stacks();
  int exit_code = app::kDone;
  std::optional<Options> options = parse_options(argc, argv, exit_code);
  if (!options) {
    std::cout.flush();
    if (!std::cout) throw FileError("standard output", "could not be written in full");
    return exit_code;
  }
  options->server.page = shared_data() / "page.html";
  end_on_signals();
  if (options->is_recording()) {
    options->server.recording = options->file;
    replay(*options);
  } else {
    run(*options);
  }
  return app::kDone;
} catch (const ConfigError& error) {
  std::cerr << error.what() << '\n';
  return app::kBadUsage;
} catch (const FileError& error) {
  std::cerr << error.what() << '\n';
  return app::kBadFile;
} catch (const PortError& error) {
  std::cerr << error.what() << '\n';
  return app::kNoPort;
} catch (const std::bad_alloc&) {
  std::cerr << "not enough memory\n";
  return app::kInternal;
} catch (const std::system_error& error) {
  // So the system calls it when there is no memory for a thread.
  const bool no_thread = error.code() == std::errc::resource_unavailable_try_again;
  std::cerr << (no_thread ? "not enough memory" : std::string("internal error: ") + error.what()) << '\n';
  return app::kInternal;
} catch (const std::exception& error) {
  std::cerr << "internal error: " << error.what() << '\n';
  return app::kInternal;
}

}  // namespace

}  // namespace thenar::window

int main(int argc, char** argv) {
  thenar::app::hold_standard_streams();
  return thenar::window::run_program(argc, argv);
}
