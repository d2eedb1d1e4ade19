// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/child_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>

namespace thenar {

namespace {

void bound(const ChildLimits& limits) {
  // Sanitizers reserve terabytes of addresses, so the bound adds to the present size.
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlim_t most = pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) + limits.memory_bytes;
  const rlimit memory{most, most}, time{limits.cpu_s, limits.cpu_s}, core{0, 0};
  setrlimit(RLIMIT_AS, &memory);
  setrlimit(RLIMIT_CPU, &time);
  setrlimit(RLIMIT_CORE, &core);
}

bool write_all(int to, const std::string& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t written = write(to, bytes.data() + done, bytes.size() - done);
    if (written < 0 && errno != EINTR) return false;
    if (written > 0) done += static_cast<std::size_t>(written);
  }
  return true;
}

std::string read_all(int from) {
  std::string bytes;
  std::array<char, 65536> part;
  for (;;) {
    const ssize_t size = read(from, part.data(), part.size());
    if (size == 0 || (size < 0 && errno != EINTR)) return bytes;
    if (size > 0) bytes.append(part.data(), static_cast<std::size_t>(size));
  }
}

/// Waits for the end of a child. Whether it ended by itself, with 0.
bool ended_well(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return false;
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace

std::optional<std::string> in_child_process(const std::function<std::string()>& work, const ChildLimits& limits) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return std::nullopt;
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    bound(limits);
    bool done = false;
    try {
      done = write_all(ends[1], work());
    } catch (...) {
    }
    _exit(done ? 0 : 1);  // The child must not flush buffers or run exit handlers of this process.
  }
  close(ends[1]);
  std::string bytes = child > 0 ? read_all(ends[0]) : "";
  close(ends[0]);
  if (child < 0) return std::nullopt;
  if (!ended_well(child)) return std::nullopt;
  return bytes;
}

pid_t start_program(const std::vector<std::string>& command, const std::vector<PassedDescriptor>& passed) {
  std::vector<char*> words;
  words.reserve(command.size() + 1);
  for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  posix_spawn_file_actions_t streams;
  posix_spawn_file_actions_init(&streams);
  for (const PassedDescriptor& one : passed) posix_spawn_file_actions_adddup2(&streams, one.ours, one.its);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (std::ranges::count(passed, stream, &PassedDescriptor::its) > 0) continue;
    posix_spawn_file_actions_addopen(&streams, stream, "/dev/null", O_RDWR, 0);
  }
  posix_spawnattr_t apart;
  posix_spawnattr_init(&apart);
  posix_spawnattr_setflags(&apart, POSIX_SPAWN_SETPGROUP);
  pid_t child = -1;
  if (posix_spawnp(&child, words.front(), &streams, &apart, words.data(), environ) != 0) child = -1;
  posix_spawn_file_actions_destroy(&streams);
  posix_spawnattr_destroy(&apart);
  return child;
}

std::optional<std::string> output_of(const std::vector<std::string>& command, const std::string& input) {
  // Not a pipe: one to a program that is missing or stops ends us, too.
  const int memory = memfd_create("input", MFD_CLOEXEC);
  int ends[2] = {-1, -1};
  pid_t child = -1;
  std::string bytes;
  if (memory >= 0 && write_all(memory, input) && lseek(memory, 0, SEEK_SET) == 0 && pipe2(ends, O_CLOEXEC) == 0) {
    child = start_program(command, {{memory, STDIN_FILENO}, {ends[1], STDOUT_FILENO}});
    close(ends[1]);
    if (child > 0) bytes = read_all(ends[0]);
    close(ends[0]);
  }
  if (memory >= 0) close(memory);
  if (child < 0 || !ended_well(child)) return std::nullopt;
  return bytes;
}

}  // namespace thenar
