// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/wait.h>

#include <cstdio>
#include <string>

#include "tests/support/scratch.h"

namespace thenar {

struct ProgramResult {
  int code;
  std::string text;  ///< What it printed, stdout and stderr together.
};

/// Runs the program; `before` may set environment variables.
inline ProgramResult thenar_program(const std::string& arguments, const std::string& before = "") {
  std::FILE* pipe = popen((before + std::string(THENAR_PROGRAM) + " " + arguments + " 2>&1").c_str(), "r");
  std::string text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  return {WEXITSTATUS(pclose(pipe)), text};
}

inline std::string config(const std::string& name) { return std::string(THENAR_CONFIGS) + "/" + name; }

inline std::string data(const std::string& name) { return std::string(THENAR_TEST_DATA) + "/" + name; }

}  // namespace thenar
