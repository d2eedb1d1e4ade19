// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/mcap_reader.h"

#include <fmt/format.h>
#include <zstd.h>

#include <cstdint>
#include <map>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>

#include "engine/formats/checksum.h"
#include "engine/formats/files.h"
#include "engine/formats/mcap_records.h"

namespace thenar {

namespace {

// Largest unpacked chunk: those of other writers have some MiB. One that claims more is damaged.
constexpr std::uint64_t kLargestChunk = 1 << 26;

struct Unsupported : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Returns a chunk's records; nothing if it is damaged, or its compression is unknown. Throws Unsupported.
std::optional<std::string_view> records_of(mcap::Parts chunk, std::string& unpacked) {
  chunk.take(2 * sizeof(std::uint64_t));
  const auto size = chunk.number<std::uint64_t>();
  const auto crc = chunk.number<std::uint32_t>();
  const std::string_view compression = chunk.text();
  std::string_view records = chunk.take(chunk.number<std::uint64_t>());
  if (chunk.ended_early() || size > kLargestChunk) return std::nullopt;
  if (compression == "lz4") throw Unsupported("has chunks compressed by lz4: only zstd is read here");
  if (compression == "zstd") {
    // The frame's own size is checked before memory is allocated.
    const auto framed = ZSTD_getFrameContentSize(records.data(), records.size());
    if (framed != size && framed != ZSTD_CONTENTSIZE_UNKNOWN) return std::nullopt;
    unpacked.resize(size);
    if (ZSTD_decompress(unpacked.data(), size, records.data(), records.size()) != size) return std::nullopt;
    records = unpacked;
  } else if (!compression.empty()) {
    return std::nullopt;
  }
  if (records.size() != size || (crc != 0 && crc32(records) != crc)) return std::nullopt;
  return records;
}

/// A sequential reader of records.
class Reading {
 public:
  Reading(const std::filesystem::path& file, const ReceiveMessage& receive) : file_(file), receive_(receive) {}

  McapReading read(std::string_view bytes) try {
    left_ = kLargestChunk + kMostUnpacked * bytes.size();
    if (!bytes.starts_with(mcap::kMagic)) throw FileError(file_, "is no MCAP recording");
    mcap::Parts parts(bytes.substr(mcap::kMagic.size()));
    while (true) {
      const auto kind = parts.number<std::uint8_t>();
      mcap::Parts record(parts.take(parts.number<std::uint64_t>()));
      if (parts.ended_early()) return reading_;
      if (kind == mcap::kFooter) {
        reading_.whole = parts.rest() == mcap::kMagic && reading_.damaged_chunks == 0;
        return reading_;
      }
      if (kind == mcap::kChunk) {
        read_chunk(record);
      } else {
        see(kind, record);
      }
    }
  } catch (const Unsupported& error) {
    throw FileError(file_, error.what());
  } catch (const std::bad_alloc&) {
    throw FileError(file_, "does not fit into memory");
  }

 private:
  void read_chunk(const mcap::Parts& chunk) {
    const std::optional<std::string_view> records = records_of(chunk, unpacked_);
    if (!records) {
      ++reading_.damaged_chunks;
      return;
    }
    if (records->size() > left_) {
      throw FileError(file_, fmt::format("unpacks to more than {} times its size", kMostUnpacked));
    }
    left_ -= records->size();
    mcap::Parts parts(*records);
    while (!parts.rest().empty()) {
      const auto kind = parts.number<std::uint8_t>();
      const mcap::Parts record(parts.take(parts.number<std::uint64_t>()));
      if (parts.ended_early()) {
        ++reading_.damaged_chunks;
        return;
      }
      see(kind, record);
    }
  }

  void see(std::uint8_t kind, mcap::Parts record) {
    if (kind == mcap::kChannel) {
      const auto id = record.number<std::uint16_t>();
      record.number<std::uint16_t>();
      topics_[id] = record.text();
    } else if (kind == mcap::kMessage) {
      const auto id = record.number<std::uint16_t>();
      record.number<std::uint32_t>();
      const auto time_ns = record.number<std::uint64_t>();
      record.number<std::uint64_t>();
      const auto topic = topics_.find(id);
      if (topic == topics_.end() || record.ended_early()) throw FileError(file_, "has a message of no channel");
      receive_({topic->second, 1e-9 * static_cast<double>(time_ns), record.rest()});
    }
  }

  const std::filesystem::path& file_;
  const ReceiveMessage& receive_;
  McapReading reading_;
  std::map<std::uint16_t, std::string> topics_;
  std::string unpacked_;
  std::size_t left_ = 0;  ///< Bytes that chunks may still unpack to.
};

}  // namespace

McapReading read_mcap(const std::filesystem::path& file, const ReceiveMessage& receive) {
  return read_mcap(read_file(file), file, receive);
}

McapReading read_mcap(std::string_view bytes, const std::filesystem::path& file, const ReceiveMessage& receive) {
  return Reading(file, receive).read(bytes);
}

}  // namespace thenar
