# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` puts where, in two components: `program` (the programs, scenes, the page) and `dev` (headers, libraries,
# how find_package() finds them). `cpack` makes a Debian package of each.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/thenar)
set(header_folder ${CMAKE_INSTALL_INCLUDEDIR}/thenar)
set(core_rooms solvers muscles collision solids environment hand grasp control)
set(other_rooms finder pulps formats scenes models loops results recordings figures capacity stiffness problems studies sweeps
    insertion)

# thenar-grasp: the real-time core, which needs Eigen alone. thenar-engine: all the rest.
foreach(set IN ITEMS core other)
  list(TRANSFORM ${set}_rooms PREPEND thenar_ OUTPUT_VARIABLE ${set}_targets)
endforeach()
install(TARGETS ${core_targets} EXPORT grasp ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev
        INCLUDES DESTINATION ${header_folder})
install(TARGETS ${other_targets} thenar_engine EXPORT engine ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev
        INCLUDES DESTINATION ${header_folder})
foreach(export grasp engine)
  install(EXPORT ${export} FILE thenar-${export}.cmake NAMESPACE thenar:: DESTINATION ${package_folder} COMPONENT dev)
endforeach()
# Without the room that only a program uses.
install(DIRECTORY solvers collision engine DESTINATION ${header_folder} COMPONENT dev FILES_MATCHING PATTERN "*.h"
        PATTERN imports EXCLUDE)
install(DIRECTORY ${PROJECT_BINARY_DIR}/generated/ DESTINATION ${header_folder} COMPONENT dev FILES_MATCHING PATTERN "*.h")
configure_package_config_file(cmake/thenar-config.cmake.in ${PROJECT_BINARY_DIR}/thenar-config.cmake
                              INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/thenar-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/thenar-config.cmake ${PROJECT_BINARY_DIR}/thenar-config-version.cmake
        DESTINATION ${package_folder} COMPONENT dev)
# For pkg-config: each library before those that it calls. Like the package of CMake it finds the prefix from its own place.
set(pc_folder ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
set(pc_system)
if(has_hdf5 AND CMAKE_DL_LIBS)
  set(pc_system " -l${CMAKE_DL_LIBS}")
endif()
set(pc_libraries ${core_rooms} ${other_rooms})
list(REVERSE pc_libraries)
list(TRANSFORM pc_libraries PREPEND -lthenar_)
list(JOIN pc_libraries " " pc_libraries)
cmake_path(RELATIVE_PATH CMAKE_INSTALL_PREFIX BASE_DIRECTORY ${CMAKE_INSTALL_PREFIX}/${pc_folder} OUTPUT_VARIABLE prefix_from_pc)
configure_file(cmake/thenar.pc.in thenar.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/thenar.pc DESTINATION ${pc_folder} COMPONENT dev)
install(DIRECTORY examples/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples COMPONENT dev)

install(TARGETS thenar thenar-studies RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
if(TARGET thenar-window)
  install(TARGETS thenar-window RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
  install(FILES ${PROJECT_BINARY_DIR}/share/thenar/page.html DESTINATION ${CMAKE_INSTALL_DATADIR}/thenar COMPONENT program)
endif()
# Without the two whose scans are the user's to put beside them.
install(DIRECTORY configs/ DESTINATION ${CMAKE_INSTALL_DATADIR}/thenar/scenes COMPONENT program
        FILES_MATCHING PATTERN "*.yaml" PATTERN bunny.yaml EXCLUDE PATTERN scan_grasp.yaml EXCLUDE)
install(FILES docs/reference/scene.schema.json DESTINATION ${CMAKE_INSTALL_DATADIR}/thenar/docs/reference COMPONENT program)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)

# The manual page, which the program writes, for all of its names.
set(man_folder ${PROJECT_BINARY_DIR}/share/man/man1)
file(MAKE_DIRECTORY ${man_folder})
add_custom_command(OUTPUT ${man_folder}/thenar.1 COMMAND thenar man > ${man_folder}/thenar.1 DEPENDS thenar)
add_custom_target(man_page ALL DEPENDS ${man_folder}/thenar.1)
set(man_pages ${man_folder}/thenar.1)
foreach(program thenar-studies thenar-window)
  if(TARGET ${program})
    file(CREATE_LINK thenar.1 ${man_folder}/${program}.1 SYMBOLIC)
    list(APPEND man_pages ${man_folder}/${program}.1)
  endif()
endforeach()
install(FILES ${man_pages} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)

# Completions, where each shell looks for them.
install(FILES app/completion/thenar.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME thenar
        COMPONENT program)
install(FILES app/completion/_thenar DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions COMPONENT program)
install(FILES app/completion/thenar.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d COMPONENT program)

# The Python package, complete in its folder: what comes with the program lies in it, too.
if(TARGET python_package)
  set(python_folder lib/python3/dist-packages/thenar)
  install(TARGETS thenar_python LIBRARY DESTINATION ${python_folder} COMPONENT python)
  install(DIRECTORY python/thenar/ DESTINATION ${python_folder} COMPONENT python
          FILES_MATCHING PATTERN "*.py" PATTERN "*.pyi" PATTERN "py.typed" PATTERN __pycache__ EXCLUDE)
  install(DIRECTORY configs/ DESTINATION ${python_folder}/share/scenes COMPONENT python
          FILES_MATCHING PATTERN "*.yaml" PATTERN bunny.yaml EXCLUDE PATTERN scan_grasp.yaml EXCLUDE)
  install(FILES docs/reference/scene.schema.json DESTINATION ${python_folder}/share/docs/reference COMPONENT python)
  install(FILES ${PROJECT_BINARY_DIR}/share/thenar/palette.json DESTINATION ${python_folder}/share COMPONENT python)
  if(TARGET thenar-window)
    install(FILES ${PROJECT_BINARY_DIR}/share/thenar/page.html DESTINATION ${python_folder}/share COMPONENT python)
  endif()
endif()

# All that is installed, and no more.
add_custom_target(installed DEPENDS ${core_targets} ${other_targets} thenar thenar-studies man_page)
foreach(target thenar-window python_package)
  if(TARGET ${target})
    add_dependencies(installed ${target})
  endif()
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME thenar)
set(CPACK_PACKAGE_VENDOR "Thenar")
set(CPACK_PACKAGE_CONTACT "The authors of Thenar <thenar@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Real-time simulation of human grasping")
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL program dev ${documents})
if(TARGET python_package)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME thenar)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS gnuplot-nox)
if(has_hdf5)
  execute_process(COMMAND dpkg-query --search ${hdf5_file} OUTPUT_VARIABLE hdf5_package ERROR_QUIET)
  if(hdf5_package MATCHES "^([^:,]+)")
    string(APPEND CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS ", ${CMAKE_MATCH_1}")
  endif()
endif()
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libthenar-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
    "libeigen3-dev, libyaml-cpp-dev, libfmt-dev, libspdlog-dev, libtbb-dev, libboost-dev, nlohmann-json3-dev, libzstd-dev")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-thenar)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
math(EXPR next_python "${Python_VERSION_MINOR} + 1")
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= 3.${Python_VERSION_MINOR}), python3 (<< 3.${next_python}), python3-numpy")
include(CPack)
