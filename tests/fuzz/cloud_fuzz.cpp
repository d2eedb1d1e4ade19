// SPDX-License-Identifier: Apache-2.0
// Whatever the bytes of a file that ends in THENAR_ENDING: a cloud that a surface can be made of, or a FileError.
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "engine/formats/files.h"
#include "engine/formats/point_cloud_file.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thenar;
  std::vector<std::string> notes;
  try {
    const PointCloud cloud =
        parse_cloud(text_of(data, size), "cloud" THENAR_ENDING, {.unit_m = 1.0, .samples = 20}, notes);
    const bool has_normals = cloud.normals.cols() > 0;
    if (!cloud.points_m.allFinite() || cloud.points_m.cols() < 10) std::abort();
    if (has_normals && cloud.normals.cols() != cloud.points_m.cols()) std::abort();
    if (has_normals && !((cloud.normals.colwise().norm().array() - 1.0).abs().maxCoeff() < 1e-12)) std::abort();
  } catch (const FileError&) {
  }
  return 0;
}
