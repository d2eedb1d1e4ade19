// SPDX-License-Identifier: Apache-2.0
// Whatever the bytes of a problem file: every method that applies solves it, says that it cannot, or the file is
// refused. The first byte says which kind of file the rest is.
#include <cstdlib>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/exit_code.h"
#include "app/studies/solve.h"
#include "engine/formats/files.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thenar;
  static const MemoryFile kContact("problem.fcp"), kSmall("problem.json");
  if (size == 0) return 0;
  const MemoryFile& file = data[0] == 'f' ? kContact : kSmall;
  file.write(text_of(data, size));
  app::Options options;
  options.problems = {file.path()};
  options.method = "all";
  options.repeat = 1;
  options.format = "json";
  options.forces = true;
  std::ostringstream out, faults;
  std::streambuf* const screen[] = {std::cout.rdbuf(out.rdbuf()), std::cerr.rdbuf(faults.rdbuf())};
  bool refused = false;
  int code = app::kDone;
  try {
    code = app::solve(options);
  } catch (const FileError&) {
    refused = true;
  }
  std::cout.rdbuf(screen[0]);
  std::cerr.rdbuf(screen[1]);
  if (!refused && code != app::kDone && code != app::kFailed) std::abort();
  if (!refused && !nlohmann::json::accept(out.str())) std::abort();
  return 0;
}
