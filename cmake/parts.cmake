# SPDX-License-Identifier: Apache-2.0
# Parts that are built only where their packages are: looked for here, told by `thenar --version`, and at the end of
# configuring, with the packages of those that are left out.
set(thenar_parts "")
set(thenar_left_out "")

# thenar_part(<name> <whether it is built> <what it is> <how to get it>)
function(thenar_part name built what how)
  if(built)
    list(APPEND thenar_parts ${name})
  else()
    list(APPEND thenar_left_out "${name}: ${what}. To build it, ${how}.")
  endif()
  set(thenar_parts "${thenar_parts}" PARENT_SCOPE)
  set(thenar_left_out "${thenar_left_out}" PARENT_SCOPE)
endfunction()

function(thenar_tell_left_out)
  foreach(part IN LISTS thenar_left_out)
    message(STATUS "Left out: ${part}")
  endforeach()
endfunction()

if(PROJECT_IS_TOP_LEVEL)
  option(THENAR_WINDOW "Build the live window, where npm and node are found: it fetches packages" ON)
  find_program(NPM npm)
  find_program(NODE node)
  set(has_window FALSE)
  if(THENAR_WINDOW AND NPM AND NODE)
    set(has_window TRUE)
  endif()
  thenar_part(window ${has_window} "`thenar demo`, and the page of `thenar export --html`"
              "install npm and nodejs, and set THENAR_WINDOW=ON")

  # Debian's own Python, unless another is named.
  option(THENAR_PYTHON "Build the Python package, where pybind11 is found" ON)
  set(has_python FALSE)
  if(THENAR_PYTHON)
    if(NOT Python_EXECUTABLE AND EXISTS /usr/bin/python3)
      set(Python_EXECUTABLE /usr/bin/python3)
    endif()
    find_package(Python 3.10 COMPONENTS Interpreter Development.Module)
    find_package(pybind11 2.10 CONFIG QUIET)
    if(Python_Development.Module_FOUND AND pybind11_FOUND)
      set(has_python TRUE)
    endif()
  endif()
  thenar_part(Python ${has_python} "`import thenar`"
              "install pybind11-dev, python3-dev and python3-numpy, and set THENAR_PYTHON=ON")

  set(MPI_CXX_SKIP_MPICXX ON)
  find_package(MPI COMPONENTS CXX)
  thenar_part(MPI "${MPI_CXX_FOUND}" "sweeps over many machines, `mpirun thenar sweep`"
              "install libopenmpi-dev and openmpi-bin")
endif()

# No program links HDF5: it is loaded when a file of FCLIB comes, by the name that its programs know it by.
find_path(HDF5_HEADERS hdf5.h PATH_SUFFIXES hdf5/serial)
find_library(HDF5_LIBRARY NAMES hdf5_serial hdf5)
set(has_hdf5 FALSE)
if(HDF5_HEADERS AND HDF5_LIBRARY)
  set(has_hdf5 TRUE)
  file(REAL_PATH ${HDF5_LIBRARY} hdf5_file)
  string(REGEX MATCH "[^/]*\\.so\\.[0-9]+" hdf5_name ${hdf5_file})
endif()
thenar_part(HDF5 ${has_hdf5} "contact problems of FCLIB, `thenar solve FILE.hdf5`" "install libhdf5-dev")

if(PROJECT_IS_TOP_LEVEL)
  cmake_language(DEFER CALL thenar_tell_left_out)
endif()
