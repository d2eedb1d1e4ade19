// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/grasp/scene.h"

namespace thenar {

/// Reads a scene and the files that it names, with `--set key=value` changes applied.
/// A hand that is not beside the scene is looked for among those that come with the program, by its file's name.
/// Throws ConfigError with every mistake at once, or FileError if all that is wrong is a file that cannot be read.
[[nodiscard]] Scene load_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

/// The files that a scene is made of: its own, the hand's, the object's if it is scanned, that of control.drive, and
/// the scene that its grasp is from. `overrides` as for load_scene(). Other faults of the scene than broken YAML are
/// not reported here. Throws ConfigError and FileError.
[[nodiscard]] std::vector<std::filesystem::path> scene_files(const std::filesystem::path& scene,
                                                             const std::vector<std::string>& overrides);

/// As a scene file has it: "{position: 0.1 mm, rotation: 0.1 deg, force: 5 %, moment: 10 %, margin: 0.05}".
[[nodiscard]] std::string in_words(const Tolerance& tolerance);

}  // namespace thenar
