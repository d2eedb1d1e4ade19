#include "app/window_program.h"

#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <iostream>
#include <system_error>

#include "app/exit_code.h"

namespace thenar::app {

int run_window_program(char** argv) {
  std::error_code none;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", none);
  const std::filesystem::path program = self.parent_path() / "thenar-window";
  execv(program.c_str(), argv);
  if (errno != ENOENT) {
    std::cerr << program.string() << ": cannot be run: " << std::generic_category().message(errno) << '\n';
    return kBadFile;
  }
  std::cerr << program.string() << ": the live window is not built. `./dev demo` builds it, or `cmake --build "
            << self.parent_path().parent_path().string() << " --target thenar-window` where npm was found\n";
  return kBadFile;
}

}  // namespace thenar::app
