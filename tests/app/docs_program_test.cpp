// SPDX-License-Identifier: Apache-2.0
// `thenar docs` finds the site of the documents beside the program, opens it, and says what to do where there is none.

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include "tests/support/program.h"

namespace thenar::docs_program_test {
namespace {

namespace fs = std::filesystem;

/// A program as it is installed below a folder, with a browser that writes down what it is to open.
struct Installed {
  fs::path folder = scratch();
  fs::path page = folder / "share" / "doc" / "thenar" / "html" / "index.html";
  fs::path opened = folder / "opened";

  Installed() {
    fs::create_directories(folder / "bin");
    fs::copy_file(THENAR_PROGRAM, folder / "bin" / "thenar");
    std::ofstream(folder / "bin" / "xdg-open") << "#!/bin/sh\nprintf '%s\\n' \"$@\" >" << opened.string() << "\n";
    fs::permissions(folder / "bin" / "xdg-open", fs::perms::owner_all);
  }
  void build_site() const {
    fs::create_directories(page.parent_path());
    std::ofstream(page) << "<p>The documents</p>\n";
  }
  /// stdout and stderr of `thenar docs`, in a shell with these variables.
  [[nodiscard]] ProgramResult docs(const std::string& flags, const std::string& variables) const {
    const fs::path bin = folder / "bin", said = folder / "said";
    const std::string command = "env -u DISPLAY -u WAYLAND_DISPLAY PATH=" + bin.string() + ":$PATH " + variables + " " +
                                (bin / "thenar").string() + " docs " + flags + " >" + said.string() + " 2>&1";
    const int status = std::system(command.c_str());
    return {WEXITSTATUS(status), read(said)};
  }
};

TEST(DocsProgram, PrintsWhereTheSiteIsAndOpensItOnADesktop) {
  const Installed program;
  program.build_site();
  const ProgramResult result = program.docs("", "DISPLAY=:0");
  EXPECT_EQ(result.code, 0);
  EXPECT_EQ(result.text, program.page.string() + "\n");
  // The browser is not waited for.
  for (int i = 0; i < 6000 && !read(program.opened).ends_with('\n'); ++i) usleep(10'000);
  EXPECT_EQ(read(program.opened), program.page.string() + "\n");
}

TEST(DocsProgram, OpensNothingWithoutADesktopOrWhenAsked) {
  const Installed program;
  program.build_site();
  for (const auto& [flags, variables] : {std::pair("", ""), std::pair("--no-browser", "DISPLAY=:0")}) {
    const ProgramResult result = program.docs(flags, variables);
    EXPECT_EQ(result.code, 0);
    EXPECT_EQ(result.text, program.page.string() + "\n");
    usleep(200'000);  // A browser that was started would have written by then: above it takes a few milliseconds.
    EXPECT_FALSE(fs::exists(program.opened)) << flags;
  }
}

TEST(DocsProgram, SaysHowToBuildAMissingSite) {
  const Installed program;
  const ProgramResult result = program.docs("", "DISPLAY=:0");
  EXPECT_EQ(result.code, 3);
  EXPECT_EQ(result.text,
            program.page.string() + ": no such file: `./dev docs` in the source's folder builds the documents\n");
  EXPECT_FALSE(fs::exists(program.opened));
  EXPECT_EQ(program.docs("here", "").code, 2);
}

}  // namespace
}  // namespace thenar::docs_program_test
