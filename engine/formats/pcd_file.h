// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "collision/point_cloud.h"

namespace thenar {

/// Reads a PCD file of the Point Cloud Library, in text, binary or compressed [The PCD file format, version 0.7; and
/// before, with COLUMNS in the place of FIELDS]: the fields x, y, z and, where it has them, normal_x, normal_y,
/// normal_z. Other fields are skipped. Values are nan where an organised cloud has no point. Bytes behind the last
/// point, too few for another one, are passed over, which is added to `notes`. Takes memory in proportion to the bytes,
/// at most 88 times as much where they are compressed. Throws FileError with the name `file` and the line.
[[nodiscard]] PointCloud parse_pcd(std::string_view bytes, const std::filesystem::path& file,
                                   std::vector<std::string>& notes);

}  // namespace thenar
