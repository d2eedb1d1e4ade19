// SPDX-License-Identifier: Apache-2.0
// Whatever the text of a scene, and of the changes that --set makes to it: a scene, a ConfigError or a FileError. The
// changes stand after the text, each behind a line's end and "--set ".
#include <string>
#include <vector>

#include "engine/formats/files.h"
#include "engine/grasp/scene.h"
#include "engine/scenes/config.h"
#include "engine/scenes/scene_file.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thenar;
  static const MemoryFile kFile("scene.yaml");
  constexpr std::string_view kSet = "\n--set ";
  std::string_view text = text_of(data, size);
  std::vector<std::string> parts;
  for (;;) {
    const std::size_t end = text.find(kSet);
    parts.emplace_back(text.substr(0, end));
    if (end == text.npos) break;
    text.remove_prefix(end + kSet.size());
  }
  kFile.write(parts.front());
  parts.erase(parts.begin());
  try {
    (void)load_scene(kFile.path(), parts);
  } catch (const ConfigError&) {
  } catch (const FileError&) {
  }
  return 0;
}
