// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "collision/triangle_mesh.h"

namespace thenar {

/// Reads the triangles of a glTF 2.0 file [Khronos 2021, ISO/IEC 12113]: .glb, or .gltf with its buffers within it or
/// beside it. The meshes of the default scene's nodes are placed by their transforms; where there is no scene, all
/// nodes. Skins, morph targets, animations and materials are skipped, which is added to `notes` where it may move the
/// surface. Lengths are metres.
/// Throws FileError for a broken file, for compressed meshes, and for primitives that are no triangles.
[[nodiscard]] TriangleMesh parse_gltf(std::string_view bytes, const std::filesystem::path& file,
                                      std::vector<std::string>& notes);

}  // namespace thenar
