# SPDX-License-Identifier: Apache-2.0
# Writes OUTPUT, a source that knows the commit of SOURCE. Git tells it, with `-dirty` where files differ from it. An archive of
# the source has it here: `git archive` writes it into the next line (.gitattributes).
set(archived "$Format:%H$")

set(id "")
if(GIT AND EXISTS ${SOURCE}/.git)
  # Without tags, whose names are those of versions.
  execute_process(COMMAND ${GIT} -C ${SOURCE} describe --always --dirty --abbrev=12 --exclude=*
                  OUTPUT_VARIABLE id OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
elseif(archived MATCHES "^[0-9a-f]+$")
  string(SUBSTRING ${archived} 0 12 id)
endif()
if(NOT id)
  set(id "unknown")
endif()
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT [[
#include "engine/formats/build_info.h"

const std::string_view thenar::build_info::kSource = "@id@";
]])
