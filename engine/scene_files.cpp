#include "engine/scene_files.h"

#include "engine/config.h"

namespace thenar {

std::vector<std::filesystem::path> scene_files(const std::filesystem::path& scene,
                                               const std::vector<std::string>& overrides) {
  std::vector<std::filesystem::path> files{scene};
  const auto add = [&files](const std::filesystem::path& file) {
    if (!file.empty()) files.push_back(file);
  };
  const Config config(scene, overrides);
  const ConfigMap root = config.root();
  if (root.is_map("hand")) add(root.map("hand").path("model"));
  if (!root.is_map("object") || !root.map("object").is_map("shape")) return files;
  const ConfigMap shape = root.map("object").map("shape");
  if (shape.has("cloud")) add(shape.is_map("cloud") ? shape.map("cloud").path("file") : shape.path("cloud"));
  return files;
}

}  // namespace thenar
