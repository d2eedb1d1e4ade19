// SPDX-License-Identifier: Apache-2.0
#include <pybind11/pybind11.h>

#include <exception>
#include <string>
#include <system_error>
#include <vector>

#include "engine/formats/build_info.h"
#include "engine/formats/files.h"
#include "engine/scenes/config.h"
#include "python/batch.h"
#include "python/grasps.h"
#include "python/interpreter.h"
#include "python/laws.h"
#include "python/problems.h"
#include "python/realtime.h"
#include "python/recordings.h"
#include "python/scene.h"
#include "python/simulation.h"

namespace py = pybind11;

namespace {

/// Raises an instance of a class of thenar.errors.
void raise(const char* type, const py::args& arguments) {
  const py::object error = py::module_::import("thenar.errors").attr(type);
  PyErr_SetObject(error.ptr(), error(*arguments).ptr());
}

void translate(std::exception_ptr fault) try {
  std::rethrow_exception(fault);
} catch (const thenar::ConfigError& error) {
  py::list all;
  for (const thenar::ConfigDiagnostic& one : error.diagnostics()) {
    all.append(py::make_tuple(one.location, one.key, one.message));
  }
  raise("SceneError", py::make_tuple(all));
} catch (const std::system_error& error) {
  if (error.code() != std::errc::resource_unavailable_try_again) throw;
  PyErr_NoMemory();  // For a thread.
} catch (const thenar::FileError& error) {
  // Names of files may be any bytes.
  const auto text = [](const std::string& bytes) {
    return py::reinterpret_steal<py::object>(PyUnicode_DecodeFSDefault(bytes.c_str()));
  };
  raise("FileError", py::make_tuple(text(error.what()), text(error.file())));
}

}  // namespace

PYBIND11_MODULE(_core, module) {
  py::register_exception_translator(translate);
  thenar::python::bind_interpreter();
  module.attr("__version__") = thenar::build_info::kVersion;
  module.attr("__commit__") = thenar::build_info::kSource;
  thenar::python::bind_scene(module);
  thenar::python::bind_laws(module);
  thenar::python::bind_simulation(module);
  thenar::python::bind_realtime(module);
  thenar::python::bind_batch(module);
  thenar::python::bind_problems(module);
  thenar::python::bind_grasps(module);
  thenar::python::bind_recordings(module);
}
