// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "collision/enclosed_solid.h"
#include "collision/implicit_surface.h"
#include "engine/grasp/scene.h"

namespace thenar {

/// Is told which stage of a start begins, in words: "the object's samples". They live as long as the program.
using StartWatch = std::function<void(const char* stage)>;

/// The surface of a scene's object: a shape is sampled; a scan is read, given normals where it has none, mended
/// (repair(), find_holes()), and what was done is added to `notes`, one sentence each.
/// Throws FileError for a file that cannot be read or is no surface: normals that contradict each other, points off any
/// surface, holes that a fingertip does not see across, a size that makes no sense. Throws ConfigError for a shape
/// whose samples make no surface.
[[nodiscard]] ImplicitSurface make_object_surface(const Scene& scene, std::vector<std::string>& notes,
                                                  const StartWatch& begins = {});

/// Volume and centroid of a scene's object, the centroid being where its weight acts if it is equally dense throughout:
/// of a mesh those of the solids that it encloses; of other surfaces the centroid of their samples, and no volume.
/// `notes` say how far the centroid may be off for holes. Reads a mesh again.
[[nodiscard]] EnclosedSolid object_solid(const Scene& scene, const ImplicitSurface& surface,
                                         std::vector<std::string>& notes);

/// Returns true if the two scenes certainly have the same surface, as long as their object's file stays the same.
[[nodiscard]] bool have_same_surface(const Scene& one, const Scene& other);
/// Returns a hash of the bytes of the object's file; 0 for a shape, and for a file that cannot be read.
[[nodiscard]] std::size_t object_file_hash(const Scene& scene);

}  // namespace thenar
