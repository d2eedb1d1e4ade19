# SPDX-License-Identifier: Apache-2.0
# Installs what is built under a prefix, moves it elsewhere, and tries it as one who has it from a package: the program finds its
# scenes, a project outside builds the examples, the core needs Eigen alone, another instruction set is refused in words, and
# nothing holds a path of the build. Run by ctest:
#   cmake -D BUILD=... -D SOURCE=... -D WORK=... -D COMPILER=... -D EIGEN=... -D ARCH=... -P tests/install.cmake
cmake_minimum_required(VERSION 3.25)

# try(<what it shows> <command>...): it must end with 0; what it says goes to `said`.
macro(try what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE said ERROR_VARIABLE said)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${what}: ${code}\n${said}")
  endif()
endmacro()

file(REMOVE_RECURSE ${WORK})
foreach(component program dev)
  try("install ${component}" ${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/first --component ${component})
endforeach()
file(RENAME ${WORK}/first ${WORK}/prefix)
set(prefix ${WORK}/prefix)

# The program, with its scenes by name, in a folder that has none.
file(MAKE_DIRECTORY ${WORK}/empty)
try("scenes by name" ${CMAKE_COMMAND} -E chdir ${WORK}/empty ${prefix}/bin/thenar run minimal --time 0.05 --quiet)
try("the list of scenes" ${prefix}/bin/thenar scenes)
if(NOT said MATCHES "box_grasp +The published experiment" OR said MATCHES "\nhand ")
  message(FATAL_ERROR "thenar scenes lists:\n${said}")
endif()

# The schema that the scenes' first line names, and that of a scene that it writes.
file(WRITE ${WORK}/empty/cube.obj "v 0 0 0\nv 30 0 0\nv 0 30 0\nv 30 30 0\nv 0 0 30\nv 30 0 30\nv 0 30 30\nv 30 30 30\n"
     "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n")
try("a new scene" ${CMAKE_COMMAND} -E chdir ${WORK}/empty ${prefix}/bin/thenar new my.yaml --object cube.obj --unit mm)
foreach(scene ${prefix}/share/thenar/scenes/box_grasp.yaml ${WORK}/empty/my.yaml)
  file(STRINGS ${scene} line REGEX "yaml-language-server" LIMIT_COUNT 1)
  string(REGEX REPLACE ".*schema=" "" schema "${line}")
  cmake_path(GET scene PARENT_PATH folder)
  cmake_path(ABSOLUTE_PATH schema BASE_DIRECTORY ${folder})
  if(line STREQUAL "" OR NOT EXISTS ${schema})
    message(FATAL_ERROR "${scene} names no schema that is there: ${line}")
  endif()
endforeach()

# No path of the build.
file(GLOB_RECURSE installed ${prefix}/*)
foreach(file IN LISTS installed)
  file(STRINGS ${file} found REGEX "${SOURCE}/|${BUILD}/" LIMIT_COUNT 1)
  if(found)
    message(FATAL_ERROR "${file} holds a path of the build: ${found}")
  endif()
endforeach()

# All programs are of one version, and of one commit.
file(GLOB programs ${prefix}/bin/thenar*)
try("the version" ${prefix}/bin/thenar --version)
set(version "${said}")
if(NOT version MATCHES "^thenar [0-9.]+\n  commit  ([0-9a-f]+(-dirty)?|unknown)\n  build   .*-march=${ARCH}\n  parts   ")
  message(FATAL_ERROR "thenar --version says:\n${version}")
endif()
foreach(program IN LISTS programs)
  try("the version" ${program} --version)
  if(NOT said STREQUAL version)
    message(FATAL_ERROR "${program} --version says:\n${said}and thenar:\n${version}")
  endif()
endforeach()
if(NOT programs MATCHES "thenar-studies" OR NOT EXISTS ${prefix}/share/man/man1/thenar.1)
  message(FATAL_ERROR "programs and manual page: ${programs}")
endif()

# Where there is no /proc, the programs find their scenes and one another: where this system lets anybody try.
execute_process(COMMAND unshare --map-root-user --mount true RESULT_VARIABLE code OUTPUT_QUIET ERROR_QUIET)
if(code EQUAL 0)
  foreach(command "run minimal --time 0.05 --quiet" "hand leap")
    try("${command}, without /proc" unshare --map-root-user --mount sh -c
        "mount -t tmpfs none /proc && test ! -e /proc/self && PATH=${prefix}/bin:$PATH && cd ${WORK}/empty && thenar ${command}")
  endforeach()
endif()

# A project outside the tree, without CMake.
find_program(PKG_CONFIG pkg-config)
if(PKG_CONFIG)
  file(GLOB_RECURSE found ${prefix}/*/thenar.pc)
  cmake_path(GET found PARENT_PATH folder)
  set(ENV{PKG_CONFIG_PATH} ${folder})
  try("flags by pkg-config" ${PKG_CONFIG} --cflags --libs thenar)
  separate_arguments(flags UNIX_COMMAND "${said}")
  try("build an example by pkg-config" ${COMPILER} -std=c++20 ${SOURCE}/examples/embed.cpp -o ${WORK}/embed ${flags})
  try("run it" ${WORK}/embed ${prefix}/share/thenar/scenes/minimal.yaml)
endif()

# A project outside the tree.
try("configure the examples" ${CMAKE_COMMAND} -G Ninja -S ${SOURCE}/examples -B ${WORK}/examples -D CMAKE_PREFIX_PATH=${prefix}
    -D CMAKE_CXX_COMPILER=${COMPILER})
try("build the examples" ${CMAKE_COMMAND} --build ${WORK}/examples)
try("run an example" ${WORK}/examples/embed ${prefix}/share/thenar/scenes/minimal.yaml)

# The core, where no other package is found than Eigen.
set(none)
foreach(package yaml-cpp nlohmann_json fmt spdlog Boost Threads TBB)
  list(APPEND none -D CMAKE_DISABLE_FIND_PACKAGE_${package}=ON)
endforeach()
try("configure with the core alone" ${CMAKE_COMMAND} -G Ninja -S ${SOURCE}/examples -B ${WORK}/core
    -D EXAMPLES_OF_THE_CORE=ON -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_CXX_COMPILER=${COMPILER} ${none})
try("build with the core alone" ${CMAKE_COMMAND} --build ${WORK}/core)
try("run with the core alone" ${WORK}/core/contact_forces)
# Its link line: the libraries below thenar::grasp and the compiler's own.
file(STRINGS ${WORK}/core/build.ninja libraries REGEX "LINK_LIBRARIES = ")
string(REGEX REPLACE ".*LINK_LIBRARIES = " "" libraries "${libraries}")
string(REGEX REPLACE "[^ ]*/libthenar_(solvers|muscles|collision|solids|environment|hand|grasp)\\.a" "" others "${libraries}")
if(others MATCHES "[^ ]")
  message(FATAL_ERROR "thenar::grasp links more than itself: ${libraries}")
endif()

# Another instruction set: every header that shows Eigen's types says so.
if(ARCH STREQUAL "x86-64-v3")
  file(GLOB_RECURSE headers RELATIVE ${prefix}/include/thenar ${prefix}/include/thenar/*.h)
  set(asked 0)
  foreach(header IN LISTS headers)
    file(STRINGS ${prefix}/include/thenar/${header} shows REGEX "Eigen::" LIMIT_COUNT 1)
    if(NOT shows)
      continue()
    endif()
    math(EXPR asked "${asked} + 1")
    execute_process(COMMAND ${COMPILER} -std=c++20 -E -x c++ -I ${prefix}/include/thenar -I ${EIGEN}
                            ${prefix}/include/thenar/${header} RESULT_VARIABLE code OUTPUT_QUIET ERROR_VARIABLE said)
    if(code EQUAL 0 OR NOT said MATCHES "Thenar was built with -march=x86-64-v3")
      message(FATAL_ERROR "${header} takes another instruction set:\n${said}")
    endif()
  endforeach()
  if(asked LESS 30)
    message(FATAL_ERROR "only ${asked} headers show Eigen's types")
  endif()
endif()
