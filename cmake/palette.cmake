# SPDX-License-Identifier: Apache-2.0
# The colours of app/page/src/palette.js: as "thenar/palette.h" for the program's figures, and as palette.json beside what
# comes with the program, for Python.
set(palette_source ${PROJECT_SOURCE_DIR}/app/page/src/palette.js)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${palette_source})
file(READ ${palette_source} palette)
string(REGEX MATCH "{.*}" palette "${palette}")
foreach(color normal tangential x y z)
  string(JSON palette_${color} GET "${palette}" light ${color})
endforeach()
foreach(colors fingers others)
  string(JSON palette_${colors} GET "${palette}" ${colors})
  string(REGEX REPLACE "[][ \n]" "" palette_${colors} "${palette_${colors}}")
endforeach()
configure_file(${CMAKE_CURRENT_LIST_DIR}/palette.h.in ${PROJECT_BINARY_DIR}/generated/thenar/palette.h @ONLY)
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/share/thenar/palette.json CONTENT "${palette}\n" @ONLY)
