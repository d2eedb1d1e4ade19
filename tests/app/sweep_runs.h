// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/support/program.h"

/// A sweep of few rows, and the shell around it.
namespace thenar::sweep_runs {

namespace fs = std::filesystem;

inline constexpr int kRows = 12;

/// 12 rows, two of them refused, of some hundredths of a second each.
inline std::string sweep_command(const fs::path& out, const std::string& duration = "0.32 s") {
  return "sweep " + config("minimal.yaml") + " --set object.points=2000 --set 'time.duration=" + duration +
         "' --vary contact.friction=-1,0.3,0.4,0.5,0.6,0.7 --vary 'control.grasp.internal_force=1 N:2 N:2' --out " +
         out.string();
}

/// Runs a shell's script; its exit code.
inline int shell(const std::string& script) {
  return WEXITSTATUS(std::system(("{ " + script + "\n} >/dev/null 2>&1").c_str()));
}

/// Waits up to a minute until a journal has a row, and kills the process whose number is in a file.
inline std::string kill_after_a_row(const fs::path& journal, const fs::path& pid) {
  return "for i in $(seq 6000); do grep -q '}$' " + journal.string() + " && break; sleep 0.01; done; kill -9 $(cat " +
         pid.string() + ")";
}

inline auto lines(const fs::path& file) {
  const std::string text = read(file);
  return std::count(text.begin(), text.end(), '\n');
}

}  // namespace thenar::sweep_runs
