// SPDX-License-Identifier: Apache-2.0
// What the program says to bad inputs: one clear line, from which they can be mended. The table is in refused_*.h.

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "tests/app/refused_hands.h"
#include "tests/app/refused_objects.h"
#include "tests/app/refused_runs.h"
#include "tests/app/refused_scenes.h"
#include "tests/support/program.h"

namespace thenar::refusals {
namespace {

namespace fs = std::filesystem;

Refusals all_refusals() {
  Refusals all;
  for (const Refusals& some : {refused_scenes(), refused_objects(), refused_hands(), refused_runs()}) {
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; !from.empty() && (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
  return text;
}

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) names.insert(entry.path().string());
  return names;
}

class ProgramRefuses : public testing::TestWithParam<Refusal> {};

TEST_P(ProgramRefuses, WithOneClearLineAndWritesNothing) {
  const Refusal& row = GetParam();
  const fs::path folder = scratch();
  if (!row.name.empty()) std::ofstream(folder / row.name, std::ios::binary) << row.text;
  const std::set<std::string> before = names_in(folder);
  const ProgramResult run =
      thenar_program(replaced(row.command, "FILE", row.name), "cd '" + folder.string() + "'; " + row.shell);
  EXPECT_EQ(run.code, row.code);
  EXPECT_EQ(replaced(run.text, row.name, "FILE"), row.message + "\n");
  EXPECT_EQ(row.message.find('\n'), std::string::npos) << "one line";
  EXPECT_EQ(names_in(folder), before);
  if (!row.name.empty()) {
    EXPECT_EQ(read(folder / row.name), row.text);
  }
}

INSTANTIATE_TEST_SUITE_P(Input, ProgramRefuses, testing::ValuesIn(all_refusals()), [](const auto& test) {
  std::string name = test.param.what;
  std::ranges::replace_if(
      name, [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return name;
});

// What the rows spoil is sound without that.
TEST(Refusals, SpoilWhatIsSound) {
  const fs::path folder = scratch();
  std::ofstream(folder / "scene.yaml") << kScene;
  std::ofstream(folder / "box.obj") << kBox;
  std::ofstream(folder / "ball.xyz") << ball(500);
  std::ofstream(folder / "hand.yaml") << kHand;
  std::ofstream(folder / "hand.xml") << kMjcf;
  std::ofstream(folder / "hand.urdf") << kUrdf;
  const std::string there = "cd '" + folder.string() + "'; ";
  for (const char* arguments : {"check scene.yaml", "new box.yaml --object box.obj --unit mm --mass 80g",
                                "new ball.yaml --object ball.xyz --unit mm", "hand hand.yaml",
                                "hand import hand.xml --out mjcf.yaml --tips thumb=thumb_1,index=index_1",
                                "hand import hand.urdf --out urdf.yaml --tips thumb=thumb_1:@40/0/0mm"}) {
    const ProgramResult run = thenar_program(arguments, there);
    EXPECT_EQ(run.code, 0) << arguments << ": " << run.text;
  }
}

}  // namespace
}  // namespace thenar::refusals
