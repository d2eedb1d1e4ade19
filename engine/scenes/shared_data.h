// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

// The scenes and hands that come with a program.
namespace thenar {

/// Returns the file of the running program; empty if nothing tells it. Where `link` cannot be read, as without /proc,
/// it is the one by whose name the system started the program.
[[nodiscard]] std::filesystem::path running_program(const std::filesystem::path& link = "/proc/self/exe");

/// Returns the folder of a program's data: scenes and hands in `scenes`, the window's page. It is share/thenar beside
/// the folder of the running program, wherever both were installed.
[[nodiscard]] std::filesystem::path shared_data();
/// Sets this folder instead: for libraries that another program loads. Before any scene is read.
void use_shared_data(std::filesystem::path folder);

/// The hand of this name that comes with the program: "leap", "leap.yaml" or "hands/leap.yaml". Empty if there is none.
[[nodiscard]] std::filesystem::path known_hand(const std::filesystem::path& name);

/// Returns the names of these hands, such as "leap", sorted.
[[nodiscard]] std::vector<std::string> known_hands();

/// A scene that comes with the program.
struct KnownScene {
  std::string name;  ///< Name of its file, without the ending.
  std::filesystem::path file;
  std::string about;  ///< The sentence that its file begins with.
};

/// Returns the scenes by name. Empty if the folder is missing. Throws FileError for a scene that cannot be read.
[[nodiscard]] std::vector<KnownScene> known_scenes();

/// The file that a user means: the text itself where it can be no name or there is such a file, else the known scene of
/// this name. Throws FileError where there is neither, and names the scene that is nearest.
[[nodiscard]] std::filesystem::path find_scene(const std::string& text);

/// The hand's file that a user means: the text itself where there is such a file, else the hand of this name that comes
/// with the program. Throws FileError where there is neither, and names the hand that is nearest.
[[nodiscard]] std::filesystem::path find_hand(const std::string& text);

/// As a scene names a hand's file: by its name where the hand comes with the program, else as `otherwise` has it.
[[nodiscard]] std::filesystem::path hand_in_scene(const std::filesystem::path& hand,
                                                  const std::filesystem::path& otherwise);

/// find_scene(), or find_hand() where there is no such scene.
[[nodiscard]] std::filesystem::path find_scene_or_hand(const std::string& text);

/// Returns a line a scene.
[[nodiscard]] std::string list_of_scenes();

}  // namespace thenar
