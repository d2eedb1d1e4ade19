// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "engine/formats/problem_file.h"

namespace thenar {

/// The files of a folder of the test data, by name.
std::vector<std::filesystem::path> data_files(const char* folder);

/// All contact problems of the test data.
std::vector<ContactFile> recorded_contact_problems();

}  // namespace thenar
