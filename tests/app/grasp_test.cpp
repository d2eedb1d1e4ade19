// `thenar new` and `thenar grasp`.

#include <gtest/gtest.h>

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
bool is_held(const Outcome& run) { return run.code == 0 || run.code == 11; }

// From a file to a held object, in the working folder: what the guide's first page does.
TEST(Program, GraspsAnObjectFromAFile) {
  const std::filesystem::path folder = scratch();
  write_cube(folder / "cube.obj");
  const std::string here = "cd " + folder.string() + " && exec ";
  const Outcome made = thenar_program("new my.yaml --object cube.obj --unit mm --mass 80g", here);
  EXPECT_EQ(made.code, 0) << made.text;
  EXPECT_NE(made.text.find("30.0 x 30.0 x 30.0 mm"), std::string::npos) << made.text;
  const Outcome run = thenar_program("run my.yaml --time 0.2", here);
  EXPECT_TRUE(is_held(run)) << run.text;
  const Outcome again = thenar_program("new my.yaml --object cube.obj --unit mm", here);
  EXPECT_EQ(again.code, 3) << "nothing is replaced: " << again.text;

  const Outcome found = thenar_program("grasp cube.obj --unit mm --mass 80g --best 2 --out grasps", here);
  EXPECT_EQ(found.code, 0) << found.text;
  EXPECT_NE(found.text.find("thumb, index, major"), std::string::npos) << found.text;
  ASSERT_TRUE(std::filesystem::exists(folder / "grasps" / "grasp-1.yaml"));
  const Outcome held = thenar_program("run grasps/grasp-1.yaml --time 0.2", here);
  EXPECT_TRUE(is_held(held)) << held.text;

  const Outcome wide = thenar_program("grasp cube.obj --unit cm", here);
  EXPECT_EQ(wide.code, 6) << wide.text;
  EXPECT_NE(wide.text.find("this hand opens"), std::string::npos) << wide.text;
}

}  // namespace
}  // namespace thenar::grasp_test
