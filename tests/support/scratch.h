// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace thenar {

std::string read(const std::filesystem::path& file);

/// A fresh folder for one test.
std::filesystem::path scratch();

}  // namespace thenar
