#pragma once

#include <filesystem>
#include <string>

#include "engine/formats/contact_file.h"

namespace thenar {

/// Contact problems in the format of FCLIB, which is HDF5: V. Acary, M. Brémond, T. Koziara, F. Pérignon, "FCLIB: a
/// collection of discrete 3D Frictional Contact problems", INRIA RT-0444. docs/reference/problem_files.md has how its
/// names and laws go with ours.

/// The units of a file of FCLIB that states none.
inline constexpr const char* kUnitsOfFclib = "any that go together";

/// Whether a file is one of FCLIB by the ending of its name: .hdf5 or .h5.
[[nodiscard]] bool is_fclib_file(const std::filesystem::path& file);

/// Why this program cannot read or write them, in a sentence: it was built without HDF5, or the library is not
/// installed. Empty if it can. HDF5 is loaded by the first call, for it takes longer to load than the program to start.
[[nodiscard]] std::string fclib_obstacle();

/// Reads the problem in the bytes of an FCLIB file: a local one, or a global one whose W and q are formed. The first of
/// its guesses becomes f_last, its solution the reference.
///
/// HDF5 runs in a child process of bounded memory and time, for it loops or takes all memory on some damaged files.
///
/// Throws FileError: "path: what is wrong", with the name of the data set; and if fclib_obstacle().
[[nodiscard]] ContactFile read_fclib_problem(const std::filesystem::path& file, const std::string& bytes);

/// Writes the problem's first step as a local problem of FCLIB, with the reference as its solution and f_last as its
/// guess, so that it is read back to the last bit, but for the signs of zeros in W. Throws FileError.
/// Requires  Finite values.
void write_fclib_problem(const std::filesystem::path& file, const ContactFile& problem);

}  // namespace thenar
