// SPDX-License-Identifier: Apache-2.0
#include "app/window_flags.h"

#include <CLI/CLI.hpp>

namespace thenar::app {

void add_window(CLI::App& app, WindowFlags& flags) {
  CLI::App* const demo =
      app.add_subcommand("demo", "Shows a scene while it runs, or a recording, in a browser, and lets hands on it");
  add_scene(*demo, flags.file, flags.overrides,
            "Scene file (YAML), the name of a scene that comes with the program, or a recording (.mcap)");
  demo->add_option("--port", flags.port, "Port of the address that is printed; 0: any that is free")
      ->type_name("N")
      ->check(whole_within(0, 65535))
      ->capture_default_str();
  demo->add_option("--listen", flags.address,
                   "Numeric address to be reached at. Pages need the token in the address that is printed")
      ->type_name("ADDRESS")
      ->capture_default_str();
  demo->add_option("--token", flags.token,
                   "Token of the address instead of a random one, for programs that are to know it. Other users of the "
                   "machine see a command's options, but not its environment: THENAR_TOKEN has it, too")
      ->type_name("TEXT")
      ->envname("THENAR_TOKEN");
  demo->add_option("--allow-host", flags.host_names,
                   "Name by which pages reach the window through a tunnel, or a server before it; more than once for "
                   "more. Without a port: at any")
      ->type_name("NAME[:PORT]")
      ->allow_extra_args(false);
  demo->add_flag_callback(
      "--no-browser", [&flags] { flags.browser = false; }, "Opens no browser, only prints the address");
  add_record(*demo, flags.record, "File (.mcap) for what the run looks like");
  demo->add_option("--record-folder", flags.record_folder,
                   "Folder for recordings that pages begin and end; default: the current one")
      ->type_name("FOLDER");
  add_rates(*demo, flags.rates, false);
  demo->add_flag_callback(
      "--no-realtime", [&flags] { flags.realtime = false; },
      "Takes what any thread gets: no SCHED_FIFO, no core of its own");
  add_core(*demo, flags.core);
  demo->add_flag("--quiet", flags.quiet, "Prints nothing but the address and errors");
  demo->footer("Ctrl-C ends it. Exit code: 0 when ended, 2 for a wrong command or scene, 3 for a file, 4 for a port.");
}

}  // namespace thenar::app
