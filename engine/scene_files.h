#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace thenar {

/// The files that a scene is made of: its own, the hand's, and the object's if it is scanned. `overrides` as for
/// load_scene(). Other faults of the scene than broken YAML are not reported here. Throws ConfigError and FileError.
[[nodiscard]] std::vector<std::filesystem::path> scene_files(const std::filesystem::path& scene,
                                                             const std::vector<std::string>& overrides);

}  // namespace thenar
