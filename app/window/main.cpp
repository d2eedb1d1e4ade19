// SPDX-License-Identifier: Apache-2.0
// The program `thenar-window`, which `thenar demo` becomes: a scene while it runs, or a recording, in a browser.

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "app/exit_code.h"
#include "app/host.h"
#include "app/open_page.h"
#include "app/program.h"
#include "app/record_flags.h"
#include "app/results.h"
#include "app/scene_flags.h"
#include "app/window/admission.h"
#include "app/window/server.h"
#include "app/window/session.h"
#include "engine/formats/files.h"
#include "engine/formats/mcap_reader.h"
#include "engine/formats/text.h"
#include "engine/grasp/model.h"
#include "engine/scenes/config.h"
#include "engine/scenes/hand_file.h"
#include "engine/scenes/scene_file.h"
#include "engine/scenes/shared_data.h"
#include "engine/studies/load_model.h"

namespace thenar::window {

namespace fs = std::filesystem;

namespace {

using app::WindowFlags;

bool is_recording(const WindowFlags& flags) { return ending_of(flags.file) == ".mcap"; }

// The signal handler's.
std::atomic<bool> stop = false;
static_assert(std::atomic<bool>::is_always_lock_free);

[[noreturn]] void refuse_flag(const char* flag, const std::string& why) { throw ConfigError({{flag, "", why}}); }

/// The names that were given; throws ConfigError for what is none.
std::vector<HostName> host_names(const std::vector<std::string>& texts) {
  std::vector<HostName> names;
  for (const std::string& text : texts) {
    const std::optional<HostName> name = read_host_name(text);
    if (!name) refuse_flag("--allow-host", text + " is no NAME or NAME:PORT, such as localhost:9000");
    names.push_back(*name);
  }
  return names;
}

/// Throws ConfigError for a flag that a recording has no use for.
void check_recording(const WindowFlags& flags) {
  const auto refuse = [](bool asked, const char* flag) {
    if (asked) refuse_flag(flag, "is for a scene, not for a recording");
  };
  refuse(!flags.overrides.empty(), "--set");
  refuse(!flags.rates.contact.empty(), "--contact-rate");
  refuse(!flags.rates.control.empty(), "--control-rate");
  refuse(flags.record.asked(), "--record");
  refuse(!flags.record_folder.empty(), "--record-folder");
  refuse(!flags.realtime, "--no-realtime");
  refuse(flags.core >= 0, "--core");
}

/// Throws ConfigError for flags that cannot be followed.
ServerSettings server_settings(const WindowFlags& flags) {
  if (is_recording(flags)) check_recording(flags);
  if (reach_of(flags.address) == Reach::kNoAddress)
    refuse_flag("--listen", flags.address + " is no numeric address, such as 127.0.0.1 or 0.0.0.0");
  if (flags.token && !can_be_token(*flags.token))
    refuse_flag("--token", "a token is 16 to 128 letters, digits, '-', '.', '_' or '~'");
  ServerSettings settings;
  settings.address = flags.address;
  settings.port = flags.port;
  settings.token = flags.token.value_or("");
  settings.also = host_names(flags.host_names);
  settings.page = shared_data() / "page.html";
  if (is_recording(flags)) settings.recording = flags.file;
  return settings;
}

/// The changes of the scene: defaults of real time, which give way to the user's changes, and those to the flags.
std::vector<std::string> changes(const WindowFlags& flags) {
  std::vector<std::string> overrides = app::realtime_defaults();
  for (const auto& more : {flags.rates.defaults(), flags.overrides, flags.rates.changes()}) {
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

std::string way_from_elsewhere(const std::string& url, const WindowFlags& flags) {
  if (reach_of(flags.address) == Reach::kOthers) {
    return "the same, with a numeric address by which it reaches this one.";
  }
  const std::string place = url.substr(7, url.find('/', 7) - 7);  // Between "http://" and "/".
  char name[256] = "";
  gethostname(name, sizeof name - 1);
  return fmt::format("ssh -L {}:{} {}, then the same address there.", place.substr(place.rfind(':') + 1), place, name);
}

/// Says where the page is, and opens it where there is a desktop.
void announce(const std::string& url, const WindowFlags& flags) {
  std::cout << url << std::endl;
  if (!flags.quiet) {
    std::cout << "From another machine: " << way_from_elsewhere(url, flags) << "\nCtrl-C ends it." << std::endl;
  }
  // Nobody could find a page whose address is nowhere to be read.
  if (!std::cout) throw FileError("standard output", "could not be written in full");
  if (flags.browser) app::open_page(url);
}

void replay(const WindowFlags& flags, const ServerSettings& settings) {
  // Refused before anybody looks at it.
  double last_s = 0.0;
  if (!app::look_through(flags.file, last_s).whole) {
    std::cerr << "warning: " << printable(flags.file.string()) << " was cut off; it is shown to its last whole state\n";
  }
  const WindowServer server(settings, [](const Message&) { return "a recording takes no orders"; });
  announce(server.url(), flags);
  while (!stop) std::this_thread::sleep_for(std::chrono::milliseconds(50));
}

/// The scene, and the names of its files by which a scene that is kept finds them from any folder.
AskedScene asked_scene(const WindowFlags& flags) {
  AskedScene asked;
  asked.scene = app::scene_at_rates(flags.file, changes(flags), flags.rates);
  if (!asked.scene.hand.slides) {
    const fs::path hand = scene_files(flags.file, changes(flags))[1];  // A hand that was read has a file.
    asked.fingers = load_hand(hand).fingers();
    asked.hand = hand_in_scene(hand, fs::absolute(hand));
  }
  const auto* const cloud = std::get_if<CloudShape>(&asked.scene.object.shape);
  if (cloud != nullptr) asked.object = fs::absolute(cloud->file);
  return asked;
}

void run(const WindowFlags& flags, const ServerSettings& server_settings) {
  AskedScene asked = asked_scene(flags);
  if (flags.record.asked())
    app::check_results({{"--record", flags.record.file}}, scene_files(flags.file, changes(flags)));
  Model model = load_model(asked.scene, {.is_whole = [&](const Model& whole) {
                             if (flags.record.asked()) app::check_record(whole, flags.record);
                           }});
  if (flags.record.file.has_parent_path()) prepare_folder(flags.record.file.parent_path());
  SessionSettings settings;
  settings.realtime = flags.realtime;
  settings.core = flags.core;
  settings.quiet = flags.quiet;
  settings.record = flags.record.file;
  settings.recording = flags.record.settings();
  settings.record_folder = flags.record_folder;
  settings.asked = std::move(asked);
  Session session(std::move(model), settings);
  WindowServer server(server_settings, [&](const Message& message) { return session.receive(message); });
  announce(server.url(), flags);
  session.run(server, stop);
}

int demo(const app::Options& options) try {
  const WindowFlags& flags = options.window;
  const ServerSettings settings = server_settings(flags);
  end_on_signals();
  if (is_recording(flags)) {
    replay(flags, settings);
  } else {
    run(flags, settings);
  }
  return app::kDone;
} catch (const PortError& error) {
  std::cerr << error.what() << '\n';
  return app::kNoPort;
}

}  // namespace

}  // namespace thenar::window

int main(int argc, char** argv) {
  thenar::app::hold_standard_streams();
  return thenar::app::run_program(argc, argv, {{"demo", thenar::window::demo}}, "thenar");
}
