#include "engine/formats/mcap_file.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include "engine/formats/build_info.h"
#include "engine/formats/files.h"

namespace thenar {

namespace {

static_assert(std::endian::native == std::endian::little, "MCAP is little-endian");

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
enum Kind : std::uint8_t { kHeader = 1, kFooter = 2, kSchema = 3, kChannel = 4, kMessage = 5, kDataEnd = 15 };

/// The bytes of a record.
class Bytes {
 public:
  template <class Number>
  Bytes& number(Number value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Bytes& text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size()));
    return raw(text);
  }
  Bytes& raw(std::string_view raw) {
    bytes_ += raw;
    return *this;
  }
  [[nodiscard]] const std::string& done() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Reads a record's bytes in order; a read past their end is remembered and gives zero.
class Parts {
 public:
  explicit Parts(std::string_view bytes) : rest_(bytes) {}

  template <class Number>
  Number number() {
    Number value{};
    const std::string_view bytes = take(sizeof value);
    if (bytes.size() == sizeof value) std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }
  std::string_view text() { return take(number<std::uint32_t>()); }
  std::string_view take(std::uint64_t size) {
    if (size > rest_.size()) {
      ended_early_ = true;
      size = 0;
    }
    const std::string_view bytes = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return bytes;
  }
  [[nodiscard]] std::string_view rest() const { return rest_; }
  [[nodiscard]] bool ended_early() const { return ended_early_; }

 private:
  std::string_view rest_;
  bool ended_early_ = false;
};

FileLock take_for_recording(const std::filesystem::path& file) {
  std::optional<FileLock> lock = FileLock::take(file);
  if (!lock) throw FileError(file, "another run records into this file");
  return *std::move(lock);
}

std::uint64_t nanoseconds(double time_s) { return static_cast<std::uint64_t>(std::llround(1e9 * time_s)); }

}  // namespace

McapWriter::McapWriter(const std::filesystem::path& file, const std::vector<McapChannel>& channels)
    : path_(file),
      lock_(take_for_recording(file)),
      file_(file, std::ios::binary | std::ios::trunc),
      messages_(channels.size()) {
  if (!file_) throw FileError(file, "cannot be written");
  file_ << kMagic;
  record(kHeader, Bytes().text("").text(fmt::format("thenar {}", build_info::kVersion)).done());
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const McapChannel& channel = channels[i];
    const auto id = static_cast<std::uint16_t>(i + 1);  // A schema's 0 stands for none.
    record(kSchema,
           Bytes().number(id).text(channel.schema_name).text(channel.schema_encoding).text(channel.schema).done());
    record(kChannel, Bytes().number(id).number(id).text(channel.topic).text(channel.encoding).text("").done());
  }
  throw_if_failed();
}

void McapWriter::add(std::size_t channel, double time_s, std::string_view bytes) {
  const std::uint64_t time_ns = nanoseconds(time_s);
  const auto id = static_cast<std::uint16_t>(channel + 1);
  record(kMessage, Bytes().number(id).number(messages_[channel]++).number(time_ns).number(time_ns).raw(bytes).done());
}

void McapWriter::finish() {
  record(kDataEnd, Bytes().number(std::uint32_t{0}).done());
  // No summary, and no checksum.
  record(kFooter, Bytes().number(std::uint64_t{0}).number(std::uint64_t{0}).number(std::uint32_t{0}).done());
  file_ << kMagic << std::flush;
  throw_if_failed();
}

void McapWriter::record(std::uint8_t kind, std::string_view bytes) {
  // A stream that has failed takes nothing more.
  file_ << Bytes().number(kind).number(std::uint64_t{bytes.size()}).done() << bytes << std::flush;
}

void McapWriter::throw_if_failed() const {
  if (!file_) throw FileError(path_, "could not be written in full");
}

McapContents read_mcap(const std::filesystem::path& file) {
  McapContents contents;
  contents.file = read_file(file);
  if (!contents.file.starts_with(kMagic)) throw FileError(file, "is no MCAP recording");
  Parts parts(std::string_view(contents.file).substr(kMagic.size()));
  std::vector<std::string> topics;  // by channel, from 1 on
  while (true) {
    const auto kind = parts.number<std::uint8_t>();
    Parts record(parts.take(parts.number<std::uint64_t>()));
    if (parts.ended_early()) return contents;
    if (kind == kChannel) {
      const auto id = record.number<std::uint16_t>();
      record.number<std::uint16_t>();
      if (id != topics.size() + 1) throw FileError(file, "is no recording of this program: its channels have gaps");
      topics.emplace_back(record.text());
    } else if (kind == kMessage) {
      const auto id = record.number<std::uint16_t>();
      record.number<std::uint32_t>();
      const auto time_ns = record.number<std::uint64_t>();
      record.number<std::uint64_t>();
      if (id < 1 || id > topics.size() || record.ended_early()) throw FileError(file, "has a message of no channel");
      contents.messages.push_back({topics[id - 1], 1e-9 * static_cast<double>(time_ns), record.rest()});
    } else if (kind == kFooter) {
      contents.whole = parts.rest() == kMagic;
      return contents;
    }
  }
}

}  // namespace thenar
