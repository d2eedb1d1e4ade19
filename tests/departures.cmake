# SPDX-License-Identifier: Apache-2.0
# docs/DEPARTURES.md names where each equation of the paper is, as `file:function`. Fails on a file that is not there,
# on a name that is not in its file, and on an equation that is missing. Run in the project's root: cmake -P
# tests/departures.cmake
cmake_minimum_required(VERSION 3.25)

file(READ docs/DEPARTURES.md document)
set(faults "")

string(REGEX MATCHALL "`[a-z_]+/[a-z_/]+\\.(h|cpp):[A-Za-z_]+`" places "${document}")
foreach(place ${places})
  string(REGEX MATCH "`([^:]+):([^`]+)`" _ "${place}")
  set(source ${CMAKE_MATCH_1})
  set(name ${CMAKE_MATCH_2})
  if(NOT EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/${source})
    list(APPEND faults "there is no ${source}")
    continue()
  endif()
  file(STRINGS ${source} lines REGEX "(^|[^A-Za-z_0-9])${name}([^A-Za-z_0-9]|$)")
  if(NOT lines)
    list(APPEND faults "${source} has no ${name}")
  endif()
endforeach()

string(REGEX MATCHALL "\n\\| \\[[0-9, ]+\\]" rows "${document}")
string(REGEX MATCHALL "[0-9]+" numbers "${rows}")
foreach(equation RANGE 1 36)
  if(NOT equation IN_LIST numbers)
    list(APPEND faults "equation [${equation}] has no row")
  endif()
endforeach()

if(faults)
  list(JOIN faults "\n  " faults)
  message(FATAL_ERROR "docs/DEPARTURES.md:\n  ${faults}")
endif()
list(LENGTH places count)
message(STATUS "${count} places are where docs/DEPARTURES.md says.")
