// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/hdf5_library.h"

#ifdef THENAR_HDF5
#include <dlfcn.h>

#include <string>

namespace thenar {

Hdf5::Symbol Hdf5::symbol(const char* name) {
  void* const address = dlsym(library_, name);
  complete_ = complete_ && address != nullptr;
  return {address};
}

hid_t Hdf5::value(const char* name) const {
  const auto of = [&](void* library) {
    const void* const address = dlsym(library, name);
    return address == nullptr ? hid_t{-1} : *static_cast<const hid_t*>(address);
  };
  // In a program that links the library by itself, its variables may be the program's, and then the library's own copy
  // is never set.
  const hid_t own = of(library_);
  return own >= 0 ? own : of(RTLD_DEFAULT);
}

const Hdf5* Hdf5::load(std::string& obstacle) {
  static void* const kLibrary = dlopen(THENAR_HDF5, RTLD_NOW | RTLD_LOCAL);
  if (kLibrary == nullptr) {
    obstacle = "FCLIB files need the library " THENAR_HDF5 ", which is not installed";
    return nullptr;
  }
  static const Hdf5 kHdf5(kLibrary);
  // Its own error messages would go to stderr.
  const bool ready = kHdf5.open_ && kHdf5.H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr) >= 0;
  if (!ready) obstacle = "FCLIB files need another version of the library " THENAR_HDF5 " than is installed";
  return ready ? &kHdf5 : nullptr;
}

}  // namespace thenar
#endif
