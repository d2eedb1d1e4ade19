// SPDX-License-Identifier: Apache-2.0
#pragma once

#ifdef THENAR_HDF5
#include <hdf5.h>

#include <string>

namespace thenar {

/// The functions of the HDF5 library that FCLIB files need, under its own names. The library is loaded on first use:
/// with its dependencies, that takes longer than the program's start.
class Hdf5 {
 public:
  /// Returns the library, which stays loaded and prints nothing. Null if there is none, with the reason in `obstacle`.
  [[nodiscard]] static const Hdf5* load(std::string& obstacle);

 private:
  void* library_;
  /// The address of a symbol, convertible to any pointer.
  struct Symbol {
    void* address;
    template <typename T>
    operator T*() const {
      return reinterpret_cast<T*>(address);
    }
  };
  [[nodiscard]] Symbol symbol(const char* name);
  bool complete_ = true;
  explicit Hdf5(void* library) : library_(library) {}

 public:
  decltype(&::H5open) H5open = symbol("H5open");
  decltype(&::H5Eset_auto2) H5Eset_auto2 = symbol("H5Eset_auto2");
  decltype(&::H5Dclose) H5Dclose = symbol("H5Dclose");
  decltype(&::H5Dcreate2) H5Dcreate2 = symbol("H5Dcreate2");
  decltype(&::H5Dget_create_plist) H5Dget_create_plist = symbol("H5Dget_create_plist");
  decltype(&::H5Dget_space) H5Dget_space = symbol("H5Dget_space");
  decltype(&::H5Dget_type) H5Dget_type = symbol("H5Dget_type");
  decltype(&::H5Dopen2) H5Dopen2 = symbol("H5Dopen2");
  decltype(&::H5Dread) H5Dread = symbol("H5Dread");
  decltype(&::H5Dwrite) H5Dwrite = symbol("H5Dwrite");
  decltype(&::H5Fclose) H5Fclose = symbol("H5Fclose");
  decltype(&::H5Fcreate) H5Fcreate = symbol("H5Fcreate");
  decltype(&::H5Fflush) H5Fflush = symbol("H5Fflush");
  decltype(&::H5Fget_file_image) H5Fget_file_image = symbol("H5Fget_file_image");
  decltype(&::H5Fopen) H5Fopen = symbol("H5Fopen");
  decltype(&::H5Gclose) H5Gclose = symbol("H5Gclose");
  decltype(&::H5Gcreate2) H5Gcreate2 = symbol("H5Gcreate2");
  decltype(&::H5Lexists) H5Lexists = symbol("H5Lexists");
  decltype(&::H5Pclose) H5Pclose = symbol("H5Pclose");
  decltype(&::H5Pcreate) H5Pcreate = symbol("H5Pcreate");
  decltype(&::H5Pget_external_count) H5Pget_external_count = symbol("H5Pget_external_count");
  decltype(&::H5Pset_fapl_core) H5Pset_fapl_core = symbol("H5Pset_fapl_core");
  decltype(&::H5Pset_file_image) H5Pset_file_image = symbol("H5Pset_file_image");
  decltype(&::H5Sclose) H5Sclose = symbol("H5Sclose");
  decltype(&::H5Screate) H5Screate = symbol("H5Screate");
  decltype(&::H5Screate_simple) H5Screate_simple = symbol("H5Screate_simple");
  decltype(&::H5Sget_simple_extent_npoints) H5Sget_simple_extent_npoints = symbol("H5Sget_simple_extent_npoints");
  decltype(&::H5Tclose) H5Tclose = symbol("H5Tclose");
  decltype(&::H5Tcopy) H5Tcopy = symbol("H5Tcopy");
  decltype(&::H5Tget_class) H5Tget_class = symbol("H5Tget_class");
  decltype(&::H5Tget_size) H5Tget_size = symbol("H5Tget_size");
  decltype(&::H5Tis_variable_str) H5Tis_variable_str = symbol("H5Tis_variable_str");
  decltype(&::H5Tset_size) H5Tset_size = symbol("H5Tset_size");

 private:
  bool open_ = complete_ && H5open() >= 0;
  /// Returns the value of a variable, once the library is open.
  [[nodiscard]] hid_t value(const char* name) const;

 public:
  // Values that its headers name by macros.
  hid_t file_access = value("H5P_CLS_FILE_ACCESS_ID_g");
  hid_t native_double = value("H5T_NATIVE_DOUBLE_g");
  hid_t native_int = value("H5T_NATIVE_INT_g");
  hid_t native_llong = value("H5T_NATIVE_LLONG_g");
  hid_t c_string = value("H5T_C_S1_g");
};

}  // namespace thenar
#endif
