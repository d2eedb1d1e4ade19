// SPDX-License-Identifier: Apache-2.0
#include "app/open_page.h"

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <cstdlib>

namespace thenar::app {

void open_page(std::string address) {
  if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return;
  posix_spawn_file_actions_t silence;
  posix_spawn_file_actions_init(&silence);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&silence, stream, "/dev/null", O_RDWR, 0);
  }
  // Ctrl-C at the terminal is not for the browser.
  posix_spawnattr_t apart;
  posix_spawnattr_init(&apart);
  posix_spawnattr_setflags(&apart, POSIX_SPAWN_SETPGROUP);
  // Without a shell, which would read the address as a command.
  char program[] = "xdg-open";
  char* const arguments[] = {program, address.data(), nullptr};
  pid_t started = 0;
  posix_spawnp(&started, program, &silence, &apart, arguments, environ);
  posix_spawn_file_actions_destroy(&silence);
  posix_spawnattr_destroy(&apart);
}

}  // namespace thenar::app
