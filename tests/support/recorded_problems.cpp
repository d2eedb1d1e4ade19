// SPDX-License-Identifier: Apache-2.0
#include "tests/support/recorded_problems.h"

#include <algorithm>
#include <filesystem>
#include <variant>
#include <vector>

#include "engine/formats/problem_file.h"

namespace thenar {

std::vector<std::filesystem::path> data_files(const char* folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(THENAR_TEST_DATA) / folder)) {
    files.push_back(entry);
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<ContactFile> recorded_contact_problems() {
  std::vector<ContactFile> problems;
  for (const auto& file : data_files("contact")) problems.push_back(std::get<ContactFile>(read_problem(file)));
  return problems;
}

}  // namespace thenar
