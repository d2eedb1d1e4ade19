// SPDX-License-Identifier: Apache-2.0
// Whatever the bytes of a problem file that ends in THENAR_ENDING: a problem, or a FileError.
#include "engine/formats/files.h"
#include "engine/formats/problem_file.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thenar;
  static const MemoryFile kFile("problem" THENAR_ENDING);
  kFile.write(text_of(data, size));
  try {
    (void)read_problem(kFile.path());
  } catch (const FileError&) {
  }
  return 0;
}
