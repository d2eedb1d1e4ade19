// SPDX-License-Identifier: Apache-2.0
#include "app/program.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <new>
#include <optional>
#include <system_error>

#include "app/exit_code.h"
#include "app/host.h"
#include "engine/formats/files.h"
#include "engine/loops/realtime.h"
#include "engine/scenes/config.h"
#include "engine/scenes/shared_data.h"

namespace thenar::app {

namespace {

/// Becomes another program of this one's folder, with the same arguments. Returns only if that cannot be run: the exit
/// code.
int become(const std::string& name, char** argv) {
  const std::filesystem::path folder = running_program().parent_path();
  if (folder.empty()) {
    std::cerr << fmt::format("{}: cannot be found: the system does not tell where this program is\n", name);
    return kBadFile;
  }
  const std::string program = (folder / name).string();
  execv(program.c_str(), argv);
  if (errno != ENOENT) {
    std::cerr << fmt::format("{}: cannot be run: {}\n", program, std::generic_category().message(errno));
    return kBadFile;
  }
  std::cerr << fmt::format(
      "{}: is missing: it belongs beside this program. `cmake --build {} --target {}` builds it{}\n", program,
      folder.parent_path().string(), name, name == "thenar-window" ? " where npm was found" : "");
  return kBadFile;
}

}  // namespace

int print(const std::string& text) {
  std::cout << text;
  return kDone;
}

int run_program(int argc, char** argv, const Commands& commands, const std::string& other) try {
  if (!host_can_run()) {
    std::cerr << kHostCannotRun;
    return kInternal;
  }
  if (!has_stack()) {
    std::cerr << kNoStack;
    return kBadUsage;
  }
  tell_of_memory_at_the_end();
  widen_thread_stacks();
  std::signal(SIGXFSZ, SIG_IGN);  // A file at its limit is an error like a full disk.
  int exit_code = kDone;
  const std::optional<Options> options = parse_options(argc, argv, exit_code);
  if (options) {
    const auto command = commands.find(options->command);
    if (command == commands.end()) return become(options->command == "demo" ? "thenar-window" : other, argv);
    exit_code = command->second(*options);
  }
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

}  // namespace thenar::app
