// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/files.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <ctime>
#include <map>
#include <mutex>
#include <new>
#include <stdexcept>
#include <system_error>

#include "engine/formats/file_kind.h"
#include "engine/formats/open_file.h"
#include "engine/formats/text.h"

namespace thenar {

namespace fs = std::filesystem;

namespace {

std::string message(int error) { return std::generic_category().message(error); }

/// Returns the bytes of an open file up to its end; nothing, with errno, if the system refuses them.
std::optional<std::string> read_all(int descriptor, std::size_t expected) {
  std::string bytes(expected + 1, '\0');  // One more, to see the end.
  std::size_t size = 0;
  while (true) {
    const ssize_t got = read(descriptor, bytes.data() + size, bytes.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return std::nullopt;
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
    if (size == bytes.size()) bytes.resize(2 * size);
  }
  bytes.resize(size);
  return bytes;
}

std::atomic<bool (*)()> stop_question = nullptr;

bool stop_is_asked() {
  bool (*const asked)() = stop_question;
  return asked != nullptr && asked();
}

/// Keeps SIGPIPE from the thread: a pipe whose reader has gone is a fault of the file.
class NoPipeSignal {
 public:
  NoPipeSignal() {
    sigemptyset(&pipe_);
    sigaddset(&pipe_, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &pipe_, &before_);
  }
  ~NoPipeSignal() {
    const int fault = errno;
    const timespec at_once{};
    if (sigismember(&before_, SIGPIPE) == 0) sigtimedwait(&pipe_, nullptr, &at_once);
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
    errno = fault;
  }
  NoPipeSignal(const NoPipeSignal&) = delete;
  NoPipeSignal& operator=(const NoPipeSignal&) = delete;

 private:
  sigset_t pipe_{}, before_{};
};

/// Waits until a pipe takes more; a second at most from when the end of this process was asked for, by the question or
/// by a signal that somebody handles. False, with errno, if it takes nothing until then.
bool wait_to_write(int descriptor) {
  constexpr int kLook_ms = 100, kMostLooks = 10;
  pollfd pipe{descriptor, POLLOUT, 0};
  bool interrupted = false;
  for (int looks = 0; looks < kMostLooks;) {
    const int ready = poll(&pipe, 1, kLook_ms);
    if (ready > 0) return true;
    interrupted = interrupted || (ready < 0 && errno == EINTR) || stop_is_asked();
    if (interrupted) ++looks;
  }
  errno = EINTR;
  return false;
}

bool write_all(int descriptor, std::string_view bytes) {
  const NoPipeSignal no_signal;
  while (!bytes.empty()) {
    const ssize_t put = write(descriptor, bytes.data(), bytes.size());
    if (put < 0 && errno == EINTR) continue;
    if (put < 0 && errno == EAGAIN && wait_to_write(descriptor)) continue;
    if (put <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(put));
  }
  return true;
}

/// Opens what is not a regular file, such as a pipe, for writing without waiting; -1 with errno. `waits`: for somebody
/// who reads the pipe.
int open_special(const fs::path& file, bool waits) {
  constexpr timespec kLook{.tv_sec = 0, .tv_nsec = 50'000'000};
  for (;;) {
    const int descriptor = open(file.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor >= 0 || errno != ENXIO || !waits || stop_is_asked()) return descriptor;
    if (nanosleep(&kLook, nullptr) != 0) return -1;
  }
}

std::string open_fault(const fs::path& file) {
  const int fault = errno;
  if (fault == ENXIO) return "nobody reads this pipe";
  const fs::path folder = file.parent_path();
  std::error_code none;
  const bool has_folder = folder.empty() || fs::exists(folder, none);
  return "cannot be written: " + (has_folder ? message(fault) : "there is no folder " + folder.string());
}

/// Returns the folder, or what should hold it, that is there and is none; empty: there is no such.
fs::path no_folder_of(fs::path folder) {
  std::error_code none;
  for (; !folder.empty() && folder != folder.root_path(); folder = folder.parent_path()) {
    if (fs::exists(folder, none)) return fs::is_directory(folder, none) ? fs::path() : folder;
  }
  return {};
}

/// Returns true if there is such a file, and it cannot be replaced: a device, a pipe.
bool is_special(const fs::path& file) {
  std::error_code none;
  return fs::exists(file, none) && !fs::is_regular_file(file, none);
}

/// Calls `make` with names beside `path` until one is free. An existing name, even of a link, belongs to others.
template <typename Make>
fs::path make_beside(const fs::path& path, const Make& make) {
  for (int i = 0;; ++i) {
    fs::path name = path.string() + "." + std::to_string(getpid()) + "-" + std::to_string(i) + ".part";
    if (make(name) || errno != EEXIST) return name;
  }
}

std::string read_from_disk(const fs::path& file) try {
  // Without waiting: a pipe that nobody writes into would open when somebody does.
  const OpenFile open_file(file, O_RDONLY | O_NONBLOCK);
  if (open_file.descriptor < 0)
    throw ReadError(file, errno == ENOENT ? "no such file" : "cannot be read: " + message(errno));
  struct stat status {};
  if (fstat(open_file.descriptor, &status) != 0) throw ReadError(file, "cannot be read: " + message(errno));
  if (S_ISDIR(status.st_mode)) throw ReadError(file, "is a folder, not a file");
  if (!S_ISREG(status.st_mode)) throw ReadError(file, "is a pipe or a device, not a file");
  std::optional<std::string> bytes = read_all(open_file.descriptor, static_cast<std::size_t>(status.st_size));
  if (!bytes) throw ReadError(file, "cannot be read: " + message(errno));
  if (const std::string what = parcel_in(*bytes, ending_of(file)); !what.empty()) throw FileError(file, what);
  return *std::move(bytes);
} catch (const std::bad_alloc&) {
  throw ReadError(file, "does not fit into memory");
} catch (const std::length_error&) {
  throw ReadError(file, "does not fit into memory");
}

struct {
  std::mutex turn;
  std::map<fs::path, std::string> bytes;
} kept;

}  // namespace

FileError::FileError(const fs::path& file, const std::string& what)
    : std::runtime_error(printable(file.string() + ": " + what)), file_(file.string()) {}

void set_stop_question(bool (*stop_is_asked)()) { stop_question = stop_is_asked; }

std::string ending_of(const fs::path& file) { return lower_case(file.extension().string()); }

std::string read_file(const fs::path& file) {
  {
    const std::lock_guard lock(kept.turn);
    if (const auto known = kept.bytes.find(file); known != kept.bytes.end()) return known->second;
  }
  return read_from_disk(file);
}

bool is_readable(const fs::path& file) {
  {
    const std::lock_guard lock(kept.turn);
    if (kept.bytes.contains(file)) return true;
  }
  std::error_code none;
  return fs::exists(file, none);
}

KeptFiles::~KeptFiles() {
  const std::lock_guard lock(kept.turn);
  kept.bytes.clear();
}

void KeptFiles::keep(const fs::path& file) {
  const std::lock_guard lock(kept.turn);
  if (!kept.bytes.contains(file)) kept.bytes.emplace(file, read_from_disk(file));
}

void write_file(const fs::path& path, std::string_view bytes) {
  write_file(path, [&](const auto& write) { write(bytes); });
}

void write_file(const fs::path& path, const std::function<void(const std::function<void(std::string_view)>&)>& fill) {
  std::error_code unresolved;
  // The target of a link is written, and the link stays; a device or a pipe cannot be replaced.
  const fs::path resolved = fs::weakly_canonical(path, unresolved);
  const fs::path& file = unresolved ? path : resolved;
  const bool replace = !is_special(file);
  int descriptor = -1;
  fs::path draft = file;
  if (replace) {
    draft = make_beside(file, [&](const fs::path& name) {
      descriptor = open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      return descriptor >= 0;
    });
  } else {
    descriptor = open_special(file, true);
  }
  if (descriptor < 0) throw FileError(path, open_fault(path));
  struct stat before {};
  if (replace && stat(file.c_str(), &before) == 0) {
    // The owner first: it takes bits of the mode away.
    (void)!fchown(descriptor, before.st_uid, before.st_gid);
    fchmod(descriptor, before.st_mode & 0777);
  }
  bool done = true;
  int fault = 0;
  try {
    fill([&](std::string_view bytes) {
      if (!done) return;
      done = write_all(descriptor, bytes);
      fault = errno;
    });
  } catch (...) {
    close(descriptor);
    if (replace) unlink(draft.c_str());
    throw;
  }
  // A full disk may show only when the file is closed.
  if (close(descriptor) != 0 && done) {
    done = false;
    fault = errno;
  }
  if (done && replace && rename(draft.c_str(), file.c_str()) != 0) {
    done = false;
    fault = errno;
  }
  if (done) return;
  if (replace) unlink(draft.c_str());
  throw FileError(path, "could not be written in full: " + message(fault));
}

void prepare_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  const fs::path file = no_folder_of(folder);
  if (!file.empty()) throw FileError(folder, "cannot make this folder: " + file.string() + " is a file");
  if (error) throw FileError(folder, "cannot make this folder: " + error.message());
  const fs::path probe =
      make_beside(folder / ".thenar", [](const fs::path& name) { return mkdir(name.c_str(), 0777) == 0; });
  if (rmdir(probe.c_str()) != 0) throw FileError(folder, "cannot write into this folder");
}

std::optional<FileLock> FileLock::take(const fs::path& path) {
  const bool folder = fs::is_directory(path);
  // Who opens a pipe for both ends reads it, too: nobody would notice that it has no other reader.
  if (!folder && is_special(path)) return FileLock(path, -1);
  FileLock lock(path, open(path.c_str(), (folder ? O_RDONLY : O_RDWR | O_CREAT) | O_NONBLOCK | O_CLOEXEC, 0666));
  struct stat status {};
  if (lock.descriptor_ < 0 || fstat(lock.descriptor_, &status) != 0) {
    throw FileError(path, "cannot be written: " + message(errno));
  }
  if (flock(lock.descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return std::nullopt;
  return lock;
}

void FileLock::write(std::string_view bytes) const {
  if (ftruncate(descriptor_, 0) == 0 && lseek(descriptor_, 0, SEEK_SET) == 0 && write_all(descriptor_, bytes) &&
      fsync(descriptor_) == 0) {
    return;
  }
  throw FileError(path_, "could not be written in full: " + message(errno));
}

FileLock::~FileLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

FileWriter::FileWriter(const fs::path& path)
    : descriptor_(is_special(path) ? open_special(path, false)
                                   : open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)) {
  if (descriptor_ < 0) throw FileError(path, open_fault(path));
}

bool FileWriter::write(std::string_view bytes) {
  failed_ = failed_ || !write_all(descriptor_, bytes);
  return !failed_;
}

FileWriter::~FileWriter() { close(descriptor_); }

std::filesystem::path seen_from(const std::filesystem::path& folder, const std::filesystem::path& file) {
  if (file.empty()) return file;
  std::error_code none;
  const std::filesystem::path relative = std::filesystem::proximate(
      std::filesystem::absolute(file), std::filesystem::absolute(folder.empty() ? "." : folder), none);
  return relative.empty() ? std::filesystem::absolute(file) : relative;
}

}  // namespace thenar
