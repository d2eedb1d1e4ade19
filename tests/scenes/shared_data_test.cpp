// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/shared_data.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace thenar::shared_data_test {
namespace {

// The link of /proc and the name by which the system started the program lead to one file.
TEST(SharedData, FindsTheProgramWithoutTheLinkOfProc) {
  const std::filesystem::path program = running_program();
  ASSERT_TRUE(std::filesystem::is_regular_file(program));
  EXPECT_EQ(running_program("/nowhere/self/exe"), program);
  EXPECT_EQ(shared_data(), program.parent_path().parent_path() / "share" / "thenar");
}

}  // namespace
}  // namespace thenar::shared_data_test
