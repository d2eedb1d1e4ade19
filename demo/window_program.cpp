#include "demo/window_program.h"

#include <unistd.h>

#include <filesystem>
#include <iostream>

#include "demo/exit_code.h"

int run_window_program(char** argv) {
  std::error_code none;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", none);
  const std::filesystem::path program = self.parent_path() / "thenar-window";
  execv(program.c_str(), argv);
  std::cerr << program.string() << ": the live window is not built. `./dev demo` builds it, or `cmake --build "
            << self.parent_path().parent_path().string() << " --target thenar-window` where npm was found\n";
  return kBadFile;
}
