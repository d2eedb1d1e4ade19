// SPDX-License-Identifier: Apache-2.0
#include "app/version.h"

#include <fmt/format.h>

#include "engine/formats/build_info.h"

namespace thenar::app {

std::string version_text() {
  using namespace build_info;
  return fmt::format(
      "thenar {}\n"
      "  commit  {}\n"
      "  build   {}, {}, {}\n"
      "  parts   {}",
      kVersion, kSource, kType, kCompiler, kFlags, kParts.empty() ? "none of the optional ones" : kParts);
}

}  // namespace thenar::app
