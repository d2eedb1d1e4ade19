# SPDX-License-Identifier: Apache-2.0
# Writes HEADER with the commit of SOURCE; with VERSION, where there is no git or no repository of our own.
set(id "")
if(GIT AND EXISTS ${SOURCE}/.git)
  execute_process(COMMAND ${GIT} -C ${SOURCE} describe --always --dirty --abbrev=12 OUTPUT_VARIABLE id
                  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(NOT id)
  set(id ${VERSION})
endif()
file(CONFIGURE OUTPUT ${HEADER} @ONLY CONTENT [[
#pragma once

#include <string_view>

namespace thenar::build_info {

inline constexpr std::string_view kSource = "@id@";

}  // namespace thenar::build_info
]])
