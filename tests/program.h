#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace thenar {

struct Outcome {
  int code;
  std::string text;  ///< What it printed, stdout and stderr together.
};

/// Runs the program; `before` may set environment variables.
inline Outcome thenar_program(const std::string& arguments, const std::string& before = "") {
  std::FILE* pipe = popen((before + std::string(THENAR_PROGRAM) + " " + arguments + " 2>&1").c_str(), "r");
  std::string text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  return {WEXITSTATUS(pclose(pipe)), text};
}

inline std::string config(const std::string& name) { return std::string(THENAR_CONFIGS) + "/" + name; }

inline std::string read(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

/// A fresh folder for one test.
inline std::filesystem::path scratch() {
  const std::filesystem::path folder =
      std::filesystem::path(THENAR_TEST_OUTPUT) / testing::UnitTest::GetInstance()->current_test_info()->name();
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

}  // namespace thenar
