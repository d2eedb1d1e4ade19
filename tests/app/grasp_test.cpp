// SPDX-License-Identifier: Apache-2.0
// `thenar new` and `thenar grasp`.

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/program.h"
#include "tests/support/scratch.h"

namespace thenar::grasp_test {
namespace {

/// A cube of 30 mm, in millimetres, its origin at a corner.
void write_cube(const std::filesystem::path& file) {
  std::ofstream out(file);
  for (const int x : {0, 30}) {
    for (const int y : {0, 30}) {
      for (const int z : {0, 30}) out << "v " << x << ' ' << y << ' ' << z << '\n';
    }
  }
  for (const char* face : {"1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"})
    out << "f " << face << '\n';
}

/// Held, even if a muscle passes its limit in the first milliseconds, in which the tangential loads build up.
bool is_held(const ProgramResult& run) { return run.code == 0 || run.code == 11; }

// From a file to a held object, in the working folder: what the guide's first page does.
TEST(Program, GraspsAnObjectFromAFile) {
  const std::filesystem::path folder = scratch();
  write_cube(folder / "cube.obj");
  const std::string here = "cd " + folder.string() + " && exec ";
  const ProgramResult made = thenar_program("new my.yaml --object cube.obj --unit mm --mass 80g", here);
  EXPECT_EQ(made.code, 0) << made.text;
  EXPECT_NE(made.text.find("30.0 x 30.0 x 30.0 mm"), std::string::npos) << made.text;
  const ProgramResult run = thenar_program("run my.yaml --time 0.2", here);
  EXPECT_TRUE(is_held(run)) << run.text;
  const ProgramResult again = thenar_program("new my.yaml --object cube.obj --unit mm", here);
  EXPECT_EQ(again.code, 3) << "nothing is replaced: " << again.text;

  const ProgramResult found = thenar_program("grasp cube.obj --unit mm --mass 80g --best 2 --out grasps", here);
  EXPECT_EQ(found.code, 0) << found.text;
  EXPECT_NE(found.text.find("thumb, index, major"), std::string::npos) << found.text;
  ASSERT_TRUE(std::filesystem::exists(folder / "grasps" / "grasp-1.yaml"));
  const ProgramResult held = thenar_program("run grasps/grasp-1.yaml --time 0.2", here);
  EXPECT_TRUE(is_held(held)) << held.text;

  const ProgramResult wide = thenar_program("grasp cube.obj --unit cm --out made/for/nothing", here);
  EXPECT_EQ(wide.code, 6) << wide.text;
  EXPECT_NE(wide.text.find("this hand opens"), std::string::npos) << wide.text;
  EXPECT_FALSE(std::filesystem::exists(folder / "made")) << "a folder without results is not left";
  EXPECT_TRUE(std::filesystem::exists(folder / "grasps"));
}

/// So often it is in the text.
int count(const std::string& text, const std::string& words) {
  int times = 0;
  for (std::size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) ++times;
  return times;
}

// What editors need stands in a written scene, and only what is there: the schema's file, and the hand by its name.
TEST(Program, WritesScenesThatStandWhereverTheyAre) {
  const std::filesystem::path folder = scratch();
  write_cube(folder / "cube.obj");
  std::filesystem::create_directory(folder / "leap");  // a folder of a hand's name is no hand
  const std::string here = "cd " + folder.string() + " && exec ";
  const ProgramResult made = thenar_program("new my.yaml --object cube.obj --unit mm --hand leap", here);
  EXPECT_EQ(made.code, 0) << made.text;
  const std::string text = read(folder / "my.yaml"), begin = "# yaml-language-server: $schema=";
  ASSERT_TRUE(text.starts_with(begin)) << text;
  EXPECT_TRUE(std::filesystem::exists(text.substr(begin.size(), text.find('\n') - begin.size()))) << text;
  EXPECT_NE(text.find("model: \"leap\""), std::string::npos) << text;
  EXPECT_NE(text.find("0 .. 30, 0 .. 30, 0 .. 30 mm"), std::string::npos) << text;

  const ProgramResult found = thenar_program("grasp my.yaml --best 1 --out made", here);
  EXPECT_EQ(found.code, 0) << found.text;
  EXPECT_NE(found.text.find("\n1 scene in made"), std::string::npos) << found.text;
  EXPECT_NE(found.text.find("\nmargin           The least share"), std::string::npos)
      << "the columns are explained: " << found.text;
  EXPECT_NE(read(folder / "made" / "grasp-1.yaml").find("model: \"leap\""), std::string::npos);
  EXPECT_TRUE(is_held(thenar_program("run made/grasp-1.yaml --time 0.1", here)));
}

TEST(Program, NamesTheFileOrHandThatIsNearest) {
  const std::filesystem::path folder = scratch();
  write_cube(folder / "cube.obj");
  std::ofstream(folder / "cubes.txt") << "no surface";
  const std::string here = "cd " + folder.string() + " && exec ";
  const auto expect = [&](const std::string& arguments, int code, const std::string& message) {
    const ProgramResult said = thenar_program(arguments, here);
    EXPECT_EQ(said.code, code) << arguments;
    EXPECT_EQ(said.text, message + "\n") << arguments;
  };
  const std::string leep = "leep: no such file, nor a hand that comes with the program, did you mean 'leap'?";
  expect("grasp cube.obj --unit mm --hand leep", 3, leep);
  expect("grasp minimal --hand leep", 3, leep);
  expect("new my.yaml --object cube.obj --hand leep", 3, leep);
  expect("grasp cubes.obj", 3, "cubes.obj: no such file, did you mean 'cube.obj'?");
  expect("new my.yaml --object ./cub.obj", 3, "./cub.obj: no such file, did you mean './cube.obj'?");
  std::filesystem::create_symlink("nothing.obj", folder / "link.obj");
  expect("grasp link.obj", 3, "link.obj: is a link to no file");
  write_cube(folder / "two\nlines.obj");
  expect("new my.yaml --object \"$(printf 'two\\nlines.obj')\"", 3,
         "two\\x0Alines.obj: a scene cannot name a file with such bytes in its name: rename it");
  expect("grasp nothing/like/it.stl", 3, "nothing/like/it.stl: no such file");
  expect("grasp cube.obj --set object.mass=1kg", 2, "--set: changes a scene, not an object");
  expect("grasp minimal --unit mm", 2, "--unit: is of an object's file: a scene has its own");
  EXPECT_FALSE(std::filesystem::exists(folder / "my.yaml"));
}

// What was mended in an object's surface is said once, by every command that makes one of a file.
TEST(Program, SaysWhatWasMendedInAnObject) {
  const std::filesystem::path folder = scratch();
  std::ofstream cloud(folder / "ball.xyz");
  for (int i = 0; i < 3000; ++i) {  // evenly, on a spiral, without normals
    const double z = 1.0 - (i + 0.5) / 1500.0, r = std::sqrt(1.0 - z * z), turn = 2.399963 * i;
    cloud << 20.0 * r * std::cos(turn) << ' ' << 20.0 * r * std::sin(turn) << ' ' << 20.0 * z << '\n';
  }
  cloud.close();
  const std::string here = "cd " + folder.string() + " && exec ", note = "estimated the normals";
  for (const char* arguments : {"new my.yaml --object ball.xyz --unit mm", "check my.yaml", "run my.yaml --time 0.01",
                                "grasp my.yaml --best 1"}) {
    const ProgramResult said = thenar_program(arguments, here);
    EXPECT_EQ(count(said.text, note), 1) << arguments << ": " << said.text;
  }
  EXPECT_EQ(count(thenar_program("run my.yaml --time 0.01 --quiet", here).text, note), 0);
}

}  // namespace
}  // namespace thenar::grasp_test
