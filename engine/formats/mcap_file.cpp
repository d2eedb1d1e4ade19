// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/mcap_file.h"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/formats/build_info.h"
#include "engine/formats/checksum.h"
#include "engine/formats/mcap_records.h"

namespace thenar {

namespace {

// docs/decisions/021-recordings-that-others-open.md compares the levels.
constexpr int kZstdLevel = 1;
// Less is not worth a reader's time.
constexpr double kLeastSaved = 0.05;

FileLock take_for_recording(const std::filesystem::path& file) {
  std::optional<FileLock> lock = FileLock::take(file);
  if (!lock) throw FileError(file, "another run records into this file");
  return *std::move(lock);
}

/// Compresses a chunk; empty if it saves too little.
std::string zstd_compressed(std::string_view bytes) {
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size = ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), kZstdLevel);
  if (ZSTD_isError(size) != 0 || static_cast<double>(size) > (1.0 - kLeastSaved) * static_cast<double>(bytes.size())) {
    return {};
  }
  packed.resize(size);
  return packed;
}

}  // namespace

McapEncoder::McapEncoder(const std::vector<McapChannel>& channels) : messages_(channels.size()) {
  append(mcap::kMagic);
  write(mcap::kHeader, mcap::Bytes().text("").text(fmt::format("thenar {}", build_info::kVersion)).done());
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const McapChannel& channel = channels[i];
    const auto id = static_cast<std::uint16_t>(i + 1);  // A schema's 0 stands for none.
    mcap::append_record(
        schemas_, mcap::kSchema,
        mcap::Bytes().number(id).text(channel.schema_name).text(channel.schema_encoding).text(channel.schema).done());
    mcap::append_record(channels_, mcap::kChannel,
                        mcap::Bytes().number(id).number(id).text(channel.topic).text(channel.encoding).text("").done());
  }
  append(schemas_);
  append(channels_);
}

void McapEncoder::add(std::size_t channel, double time_s, std::string_view bytes) {
  const auto time_ns = static_cast<std::uint64_t>(std::llround(1e9 * std::max(0.0, time_s)));
  const auto id = static_cast<std::uint16_t>(channel + 1);
  const auto now = std::chrono::steady_clock::now();
  if (records_.empty()) {
    first_ns_ = last_ns_ = time_ns;
    begin_s_ = time_s;
    begun_ = now;
  }
  first_ns_ = std::min(first_ns_, time_ns);
  last_ns_ = std::max(last_ns_, time_ns);
  index_[id] += mcap::Bytes().number(time_ns).number(std::uint64_t{records_.size()}).done();
  mcap::append_record(
      records_, mcap::kMessage,
      mcap::Bytes().number(id).number(messages_[channel]++).number(time_ns).number(time_ns).raw(bytes).done());
  // Times go back where a simulation is set back.
  if (records_.size() >= kChunkBytes || std::abs(time_s - begin_s_) >= kChunk_s ||
      now - begun_ >= std::chrono::duration<double>(kChunk_s)) {
    end_chunk();
  }
}

void McapEncoder::end_chunk() {
  if (records_.empty()) return;
  Chunk chunk;
  chunk.begin = size_;
  chunk.first_ns = first_ns_;
  chunk.last_ns = last_ns_;
  chunk.whole = records_.size();
  const std::string packed = zstd_compressed(records_);
  chunk.compressed = !packed.empty();
  const std::string& stored = chunk.compressed ? packed : records_;
  chunk.stored = stored.size();
  write(mcap::kChunk, mcap::Bytes()
                          .number(first_ns_)
                          .number(last_ns_)
                          .number(chunk.whole)
                          .number(crc32(records_))
                          .text(chunk.compressed ? "zstd" : "")
                          .number(chunk.stored)
                          .raw(stored)
                          .done());
  chunk.length = size_ - chunk.begin;
  for (const auto& [id, entries] : index_) {
    chunk.index_at[id] = size_;
    write(mcap::kMessageIndex, mcap::Bytes().number(id).text(entries).done());
  }
  chunk.index_length = size_ - chunk.begin - chunk.length;
  chunks_.push_back(std::move(chunk));
  records_.clear();
  index_.clear();
}

void McapEncoder::finish() {
  end_chunk();
  write(mcap::kDataEnd, mcap::Bytes().number(crc_).done());
  append(summary());
}

/// Returns the bytes after the data: the summary, the offsets of its parts, the footer.
std::string McapEncoder::summary() const {
  std::string bytes, offsets;
  const auto group = [&](mcap::Kind kind, const std::string& records) {
    if (records.empty()) return;
    mcap::append_record(offsets, mcap::kSummaryOffset,
                        mcap::Bytes()
                            .number(static_cast<std::uint8_t>(kind))
                            .number(std::uint64_t{size_ + bytes.size()})
                            .number(std::uint64_t{records.size()})
                            .done());
    bytes += records;
  };
  group(mcap::kSchema, schemas_);
  group(mcap::kChannel, channels_);
  std::uint64_t messages = 0, first_ns = 0, last_ns = 0;
  mcap::Bytes counts;
  for (std::size_t i = 0; i < messages_.size(); ++i) {
    messages += messages_[i];
    counts.number(static_cast<std::uint16_t>(i + 1)).number(std::uint64_t{messages_[i]});
  }
  std::string indexes;
  for (const Chunk& chunk : chunks_) {
    const bool first = indexes.empty();
    first_ns = first ? chunk.first_ns : std::min(first_ns, chunk.first_ns);
    last_ns = std::max(last_ns, chunk.last_ns);
    mcap::Bytes at, index;
    for (const auto& [id, place] : chunk.index_at) at.number(id).number(place);
    index.number(chunk.first_ns).number(chunk.last_ns).number(chunk.begin).number(chunk.length);
    index.text(at.done()).number(chunk.index_length).text(chunk.compressed ? "zstd" : "");
    mcap::append_record(indexes, mcap::kChunkIndex, index.number(chunk.stored).number(chunk.whole).done());
  }
  mcap::Bytes statistics;
  statistics.number(messages).number(static_cast<std::uint16_t>(messages_.size()));
  statistics.number(static_cast<std::uint32_t>(messages_.size())).number(std::uint32_t{0}).number(std::uint32_t{0});
  statistics.number(static_cast<std::uint32_t>(chunks_.size())).number(first_ns).number(last_ns).text(counts.done());
  std::string statistics_record;
  mcap::append_record(statistics_record, mcap::kStatistics, statistics.done());
  group(mcap::kStatistics, statistics_record);
  group(mcap::kChunkIndex, indexes);
  const std::uint64_t offsets_begin = size_ + bytes.size();
  bytes += offsets;
  const std::string places = mcap::Bytes().number(size_).number(offsets_begin).done();
  constexpr std::uint64_t kFooterSize = 20;
  bytes += mcap::Bytes().number(static_cast<std::uint8_t>(mcap::kFooter)).number(kFooterSize).raw(places).done();
  bytes += mcap::Bytes().number(crc32(bytes)).raw(mcap::kMagic).done();
  return bytes;
}

void McapEncoder::write(std::uint8_t kind, std::string_view bytes) {
  std::string record;
  mcap::append_record(record, static_cast<mcap::Kind>(kind), bytes);
  append(record);
}

void McapEncoder::append(std::string_view bytes) {
  bytes_ += bytes;
  size_ += bytes.size();
  crc_ = crc32(bytes, crc_);
}

McapWriter::McapWriter(const std::filesystem::path& file, const std::vector<McapChannel>& channels)
    : path_(file), lock_(take_for_recording(file)), file_(file), encoder_(channels) {
  save();
  throw_if_failed();
}

void McapWriter::add(std::size_t channel, double time_s, std::string_view bytes) {
  encoder_.add(channel, time_s, bytes);
  save();
}

void McapWriter::finish() {
  encoder_.finish();
  save();
  throw_if_failed();
}

void McapWriter::save() {
  const std::string bytes = encoder_.take();
  if (!bytes.empty()) (void)file_.write(bytes);
}

void McapWriter::throw_if_failed() const {
  if (file_.has_failed()) throw FileError(path_, "could not be written in full");
}

}  // namespace thenar
