#pragma once

#include <filesystem>
#include <string>
#include <vector>

// What comes with the programs: scenes, the hand, the page of the window.

/// The folder where it is: share/thenar beside the folder of the running program, wherever both were installed.
[[nodiscard]] std::filesystem::path shared_data();

/// A scene that comes with the program.
struct KnownScene {
  std::string name;  ///< Of its file, without the ending.
  std::filesystem::path file;
  std::string about;  ///< The sentence that its file begins with.
};

/// By name. Empty if the folder is missing. Throws FileError for a scene that cannot be read.
[[nodiscard]] std::vector<KnownScene> known_scenes();

/// The file that a user means: the text itself where there is such a file, else the known scene of this name, else the
/// text.
[[nodiscard]] std::filesystem::path find_scene(const std::string& text);

/// A line a scene.
[[nodiscard]] std::string list_of_scenes();
