# SPDX-License-Identifier: Apache-2.0
# The documents as a site, which `./dev docs` builds: where it lies, and how it is installed. `thenar docs` finds it beside
# the program's data, built or installed.
include(GNUInstallDirs)
set(site_folder ${PROJECT_BINARY_DIR}/share/doc/thenar/html)
find_program(SYSTEM_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)
set(build_site ${CMAKE_COMMAND} -E env PYTHONPATH=${PROJECT_BINARY_DIR}/python
    ${SYSTEM_PYTHON} -B ${PROJECT_SOURCE_DIR}/docs/site/build.py ${PROJECT_BINARY_DIR}/docs ${site_folder})
add_custom_target(site COMMAND ${build_site} USES_TERMINAL VERBATIM)
if(TARGET python_package)
  add_dependencies(site python_package)
endif()

# A site that was built is installed. One that was there when the build was configured makes a package of its own.
install(DIRECTORY ${site_folder}/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/html COMPONENT docs OPTIONAL)
set(CPACK_DEBIAN_DOCS_PACKAGE_NAME thenar-doc)
set(CPACK_DEBIAN_DOCS_PACKAGE_SECTION doc)
set(CPACK_DEBIAN_DOCS_PACKAGE_ARCHITECTURE all)
if(EXISTS ${site_folder}/index.html)
  set(documents docs)
endif()
