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
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "gnuplot-nox, libhdf5-103-1")
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
