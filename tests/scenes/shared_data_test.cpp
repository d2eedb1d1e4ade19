// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/shared_data.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "engine/formats/files.h"

namespace thenar::shared_data_test {
namespace {

// The link of /proc and the name by which the system started the program lead to one file.
TEST(SharedData, FindsTheProgramWithoutTheLinkOfProc) {
  const std::filesystem::path program = running_program();
  ASSERT_TRUE(std::filesystem::is_regular_file(program));
  EXPECT_EQ(running_program("/nowhere/self/exe"), program);
  EXPECT_EQ(shared_data(), program.parent_path().parent_path() / "share" / "thenar");
}

// The guides' configs/NAME.yaml is the program's scene of that name where there is no such file; in other folders a
// missing file is one.
TEST(SharedData, FindsAKnownSceneAsTheGuidesWriteIt) {
  ASSERT_FALSE(std::filesystem::exists("configs"));  // The test runs beside none.
  EXPECT_EQ(find_scene("configs/box_grasp.yaml"), find_scene("box_grasp"));
  EXPECT_EQ(find_scene("mine/box_grasp.yaml"), "mine/box_grasp.yaml");
  EXPECT_THROW((void)find_scene("configs/box_grsp.yaml"), FileError);
}

}  // namespace
}  // namespace thenar::shared_data_test
