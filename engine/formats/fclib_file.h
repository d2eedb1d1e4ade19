// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "engine/formats/contact_file.h"

namespace thenar {

/// Contact problems in the format of FCLIB, which is HDF5: V. Acary, M. Brémond, T. Koziara, F. Pérignon, "FCLIB: a
/// collection of discrete 3D Frictional Contact problems", INRIA RT-0444. docs/reference/problem_files.md maps its
/// names and laws to ours.

/// The units of an FCLIB file that states none.
inline constexpr const char* kUnitsOfFclib = "any that go together";

/// Tests whether a file is one of FCLIB by its extension: .hdf5 or .h5.
[[nodiscard]] bool is_fclib_file(const std::filesystem::path& file);

/// Explains in a sentence why this program cannot read or write them: it was built without HDF5, or the library is not
/// installed. Empty if it can. The first call loads HDF5, which takes longer than the program's start.
[[nodiscard]] std::string fclib_obstacle();

/// Reads the problem in the bytes of an FCLIB file: a local one, or a global one, for which W and q are formed. Its
/// first guess becomes f_last, its solution the reference.
///
/// HDF5 runs in a child process of bounded memory and time, for it loops or exhausts memory on some damaged files.
///
/// Throws FileError: "path: what is wrong", with the name of the data set; and if fclib_obstacle().
[[nodiscard]] ContactFile read_fclib_problem(const std::filesystem::path& file, const std::string& bytes);

/// Writes the problem's first step as a local problem of FCLIB, with the reference as its solution and f_last as its
/// guess, so that it is read back to the last bit, but for the signs of zeros in W. Throws FileError.
/// Requires  Finite values.
void write_fclib_problem(const std::filesystem::path& file, const ContactFile& problem);

}  // namespace thenar
