#include "engine/formats/child_process.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

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
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return std::nullopt;
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return std::nullopt;
  return bytes;
}

}  // namespace thenar
