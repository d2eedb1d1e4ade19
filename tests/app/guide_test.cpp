// SPDX-License-Identifier: Apache-2.0
// The guides of own objects and hands: a new user's shell, with every command as it is printed.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "tests/support/program.h"

namespace thenar::guide_test {
namespace {

namespace fs = std::filesystem;

/// The lines of a page's blocks without a language that are commands, and what follows a `<<'END'` up to its end. The
/// other lines show what is printed.
std::string commands_of(const std::string& page) {
  std::istringstream lines(page);
  std::string script, line;
  bool in_block = false, in_shell = false, here_document = false;
  while (std::getline(lines, line)) {
    line.erase(0, line.find_first_not_of(' ') == std::string::npos ? line.size() : line.find_first_not_of(' '));
    if (line.starts_with("```")) {
      in_shell = !in_block && line == "```";
      in_block = !in_block;
      continue;
    }
    if (!in_shell) continue;
    if (here_document || line.starts_with("./dev ") || line.starts_with("cat > ") || line.starts_with("awk ")) {
      script += line + "\n";
    }
    if (line.ends_with("<<'END'")) here_document = true;
    if (line == "END") here_document = false;
  }
  return script;
}

// In the folder of the project, where `./dev` is the program: each command is done, and each run holds its object.
TEST(Guide, CommandsOfOwnObjectsAndHandsWorkAsPrinted) {
  const fs::path folder = scratch(), project = fs::path(THENAR_CONFIGS).parent_path();
  for (const char* name : {"configs", "examples", "tests"}) fs::create_directory_symlink(project / name, folder / name);
  std::ofstream(folder / "dev") << "#!/bin/sh\nexec " << THENAR_PROGRAM << " \"$@\"\n";
  fs::permissions(folder / "dev", fs::perms::owner_all);
  std::string script = "set -e\ncd " + folder.string() + "\n";
  for (const char* page : {"objects", "hands"}) {
    script += commands_of(read(project / "docs" / "guide" / (std::string(page) + ".md")));
  }
  for (const char* command :
       {"./dev new ", "./dev run ", "./dev grasp ", "./dev check ", "./dev hand import ", "awk "}) {
    EXPECT_NE(script.find(command), std::string::npos) << script;
  }
  std::ofstream(folder / "guide.sh") << script;
  std::FILE* pipe = popen(("sh -x " + (folder / "guide.sh").string() + " 2>&1").c_str(), "r");
  std::string text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  EXPECT_EQ(WEXITSTATUS(pclose(pipe)), 0) << text;
}

}  // namespace
}  // namespace thenar::guide_test
