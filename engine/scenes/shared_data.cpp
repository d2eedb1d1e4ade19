// SPDX-License-Identifier: Apache-2.0
#include "engine/scenes/shared_data.h"

#include <fmt/format.h>
#include <sys/auxv.h>

#include <algorithm>
#include <iterator>
#include <string_view>
#include <system_error>
#include <utility>

#include "engine/formats/files.h"
#include "engine/formats/text.h"

namespace thenar {

namespace fs = std::filesystem;

namespace {

/// Empty: beside the program.
fs::path& chosen_folder() {
  static fs::path folder;
  return folder;
}

fs::path scene_folder() { return shared_data() / "scenes"; }

/// A draft or an editor's copy, which is no scene of the program's.
bool is_hidden(const fs::path& file) { return file.filename().string().starts_with('.'); }

/// The first sentence of the comment that a file begins with.
std::string first_sentence(std::string_view text) {
  std::string sentence;
  while (text.starts_with('#')) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(1, end - 1);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.starts_with(" yaml-language-server")) continue;
    sentence += line.substr(std::min<std::size_t>(sentence.empty() ? 1 : 0, line.size()));
    if (const std::size_t last = sentence.find(". "); last != std::string::npos) return sentence.substr(0, last + 1);
    if (sentence.ends_with('.')) return sentence;
  }
  return sentence;
}

/// The text itself where it can be no name or there is such a file, else the known scene of this name, also as the
/// guides write it, configs/NAME.yaml; empty: there is neither.
fs::path scene_called(const std::string& text) {
  std::error_code none;
  const fs::path file = text;
  const bool is_name = !file.has_parent_path() || file.parent_path() == "configs";
  const bool may_be_known = is_name && (!file.has_extension() || file.extension() == ".yaml");
  if (!may_be_known || fs::exists(file, none)) return file;
  const fs::path known = scene_folder() / (file.stem().string() + ".yaml");
  return fs::exists(known, none) ? known : fs::path();
}

/// The text itself where there is such a file, else, where it can be a name, the known hand of it; empty: neither.
fs::path hand_called(const std::string& text) {
  std::error_code none;
  const fs::path file = text;
  if (fs::exists(file, none) && !fs::is_directory(file, none)) return file;
  return file.has_parent_path() ? fs::path() : known_hand(file);
}

std::vector<std::string> names_of_scenes() {
  std::vector<std::string> names;
  for (const KnownScene& scene : known_scenes()) names.push_back(scene.name);
  return names;
}

/// Throws FileError for a text that is no file and none of the names, with the name that is nearest.
[[noreturn]] void refuse(const std::string& text, const std::string& what, const std::vector<std::string>& names) {
  const std::vector<std::string_view> candidates(names.begin(), names.end());
  throw FileError(text, fmt::format("no such file, nor a {} that comes with the program{}", what,
                                    did_you_mean(nearest_word(fs::path(text).stem().string(), candidates))));
}

}  // namespace

fs::path shared_data() {
  if (!chosen_folder().empty()) return chosen_folder();
  return running_program().parent_path().parent_path() / "share" / "thenar";
}

fs::path running_program(const fs::path& link) {
  std::error_code none;
  fs::path program = fs::read_symlink(link, none);
  // The name by which the system started it, from the folder in which it was: asked for at once, it still holds.
  static const fs::path as_started = [] {
    std::error_code unknown;
    // NOLINTNEXTLINE(performance-no-int-to-ptr): an address, as the system gives it.
    const auto* const name = reinterpret_cast<const char*>(getauxval(AT_EXECFN));
    return name == nullptr ? fs::path() : fs::canonical(name, unknown);
  }();
  return program.empty() ? as_started : program;
}

std::vector<std::string> known_hands() {
  std::vector<std::string> names;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(shared_data() / "scenes" / "hands", none)) {
    if (!is_hidden(entry.path())) names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

fs::path known_hand(const fs::path& name) {
  const fs::path folder = shared_data() / "scenes";
  fs::path file = name.filename();
  if (!file.has_extension()) file += ".yaml";
  for (const fs::path& known : {folder / file, folder / "hands" / file}) {
    if (is_readable(known)) return known;
  }
  return {};
}

void use_shared_data(fs::path folder) { chosen_folder() = std::move(folder); }

std::vector<KnownScene> known_scenes() {
  std::vector<KnownScene> scenes;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(scene_folder(), none)) {
    if (entry.path().extension() != ".yaml" || is_hidden(entry.path())) continue;
    const std::string text = read_file(entry.path());
    // A hand is described by a file like these, and names no object.
    if (text.find("\nobject:") == std::string::npos) continue;
    scenes.push_back({entry.path().stem().string(), entry.path(), first_sentence(text)});
  }
  std::sort(scenes.begin(), scenes.end(),
            [](const KnownScene& one, const KnownScene& other) { return one.name < other.name; });
  return scenes;
}

fs::path find_scene(const std::string& text) {
  const fs::path file = scene_called(text);
  if (file.empty() && !known_hand(text).empty())
    throw FileError(text, "is a hand that comes with the program, and no scene");
  if (file.empty()) refuse(text, "scene", names_of_scenes());
  return file;
}

fs::path find_hand(const std::string& text) {
  const fs::path file = hand_called(text);
  std::error_code none;
  if (file.empty() && fs::exists(scene_called(text), none))
    throw FileError(text, "is a scene that comes with the program, and no hand");
  if (file.empty()) refuse(text, "hand", known_hands());
  return file;
}

fs::path hand_in_scene(const fs::path& hand, const fs::path& otherwise) {
  std::error_code none;
  return fs::equivalent(hand, known_hand(hand), none) ? hand.stem() : otherwise;
}

fs::path find_scene_or_hand(const std::string& text) {
  std::error_code none;
  const fs::path scene = scene_called(text), hand = hand_called(text);
  if (!hand.empty() && !fs::exists(scene, none)) return hand;
  if (!scene.empty()) return scene;
  std::vector<std::string> names = names_of_scenes();
  std::ranges::move(known_hands(), std::back_inserter(names));
  refuse(text, "scene or hand", names);
}

std::string list_of_scenes() {
  const std::vector<KnownScene> scenes = known_scenes();
  if (scenes.empty()) return fmt::format("{} holds no scenes\n", scene_folder().string());
  std::size_t width = 0;
  for (const KnownScene& scene : scenes) width = std::max(width, scene.name.size());
  std::string list;
  for (const KnownScene& scene : scenes) list += fmt::format("{:{}}  {}\n", scene.name, width, scene.about);
  return list;
}

}  // namespace thenar
