// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/pcd_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>

#include "engine/formats/byte_source.h"
#include "engine/formats/files.h"
#include "engine/formats/plain_text.h"
#include "engine/formats/text.h"

namespace thenar {

namespace {

using Eigen::Index;

using Words = std::vector<std::string_view>;
using Notes = std::vector<std::string>;

static_assert(std::endian::native == std::endian::little, "the numbers of a binary PCD file are this machine's");

enum class PcdData { kAscii, kBinary, kCompressed };

/// A value of each point.
struct PcdColumn {
  std::string name;
  std::uint64_t field_count = 1;  ///< Values of its field.
  std::size_t field_offset = 0;   ///< Where its field begins in a binary point [bytes].
  std::uint64_t part = 0;         ///< Its place among the values of its field.
  std::size_t size = 0;           ///< In bytes, if binary.
  char type = 'F';                ///< F, I or U: floating, with a sign, without.
};

template <typename Number>
double unpack_number(const char* bytes) {
  Number number;
  std::memcpy(&number, bytes, sizeof number);
  return static_cast<double>(number);
}

/// Returns what reads a column's bytes; null for a type that there is not.
double (*unpacker_of(const PcdColumn& column))(const char*) {
  switch (column.size) {
    case 1:
      return column.type == 'I'   ? unpack_number<std::int8_t>
             : column.type == 'U' ? unpack_number<std::uint8_t>
                                  : nullptr;
    case 2:
      return column.type == 'I'   ? unpack_number<std::int16_t>
             : column.type == 'U' ? unpack_number<std::uint16_t>
                                  : nullptr;
    case 4:
      if (column.type == 'F') return unpack_number<float>;
      return column.type == 'I'   ? unpack_number<std::int32_t>
             : column.type == 'U' ? unpack_number<std::uint32_t>
                                  : nullptr;
    case 8:
      if (column.type == 'F') return unpack_number<double>;
      return column.type == 'I'   ? unpack_number<std::int64_t>
             : column.type == 'U' ? unpack_number<std::uint64_t>
                                  : nullptr;
    default:
      return nullptr;
  }
}

/// The header of a PCD file.
struct PcdHeader {
  std::vector<PcdColumn> columns;  ///< One for each value of a point; a field of several has as many.
  std::uint64_t points = 0;
  PcdData data = PcdData::kAscii;
};

std::uint64_t whole_number(const ByteSource& source, const Words& words) {
  const auto number = words.size() == 2 ? number_in<std::uint64_t>(words[1]) : std::nullopt;
  if (!number) source.fail_at_line(std::string(words[0]) + " must be one whole number");
  return *number;
}

/// The lines of the header that describe the fields.
struct PcdFields {
  std::vector<std::string> names, types;
  std::vector<std::uint64_t> sizes, counts;
};

/// Returns the columns: each field repeated by its count.
std::vector<PcdColumn> columns_of(const ByteSource& source, const PcdFields& fields, PcdData data) {
  constexpr std::size_t kMostValues = 10'000;  // of a point: a histogram has some hundreds
  const std::size_t size = fields.names.size();
  if (!fields.counts.empty() && fields.counts.size() != size) {
    source.fail("COUNT must have one number for each of FIELDS");
  }
  if (data != PcdData::kAscii && (fields.sizes.size() != size || fields.types.size() != size)) {
    source.fail("SIZE and TYPE must have one entry for each of FIELDS");
  }
  std::vector<PcdColumn> columns;
  std::size_t offset = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const std::uint64_t count = fields.counts.empty() ? 1 : fields.counts[i];
    if (count > kMostValues - columns.size()) source.fail("COUNT makes more than 10000 values of a line");
    PcdColumn column{.name = fields.names[i], .field_count = count};
    if (data != PcdData::kAscii) {
      column.size = static_cast<std::size_t>(fields.sizes[i]);
      column.type = fields.types[i].size() == 1 ? fields.types[i][0] : '?';
      if (unpacker_of(column) == nullptr) {
        source.fail("there is no TYPE " + fields.types[i] + " of SIZE " + std::to_string(fields.sizes[i]));
      }
    }
    column.field_offset = offset;
    for (column.part = 0; column.part < count; ++column.part) columns.push_back(column);
    offset += column.size * count;
  }
  return columns;
}

/// Reads a line of the header that describes fields; false: it is none.
bool read_fields(const ByteSource& source, const Words& words, PcdFields& fields) {
  const std::string_view key = words[0];
  if (key == "FIELDS" || key == "COLUMNS") {
    fields.names.assign(words.begin() + 1, words.end());
  } else if (key == "TYPE") {
    fields.types.assign(words.begin() + 1, words.end());
  } else if (key == "COUNT" || key == "SIZE") {
    auto& numbers = key == "COUNT" ? fields.counts : fields.sizes;
    numbers.clear();
    for (std::size_t i = 1; i < words.size(); ++i) numbers.push_back(whole_number(source, {key, words[i]}));
  } else {
    return false;
  }
  return true;
}

PcdData data_of(const ByteSource& source, const Words& words) {
  const std::string_view kind = words.size() == 2 ? words[1] : "";
  if (kind == "ascii") return PcdData::kAscii;
  if (kind == "binary") return PcdData::kBinary;
  if (kind == "binary_compressed") return PcdData::kCompressed;
  source.fail_at_line("DATA must be ascii, binary or binary_compressed");
}

PcdHeader read_pcd_header(ByteSource& source) {
  PcdFields fields;
  PcdData data = PcdData::kAscii;
  std::optional<std::uint64_t> width, height, points;
  for (;;) {
    const Words words = words_of(source.take_line());
    if (words.empty() || words[0].starts_with('#')) continue;
    const std::string_view key = words[0];
    if (read_fields(source, words, fields)) continue;
    if (key == "WIDTH") {
      width = whole_number(source, words);
    } else if (key == "HEIGHT") {
      height = whole_number(source, words);
    } else if (key == "POINTS") {
      points = whole_number(source, words);
    } else if (key == "DATA") {
      data = data_of(source, words);
      break;
    } else if (key != "VERSION" && key != "VIEWPOINT") {
      source.fail_at_line("'" + printable(key) + "' is not expected in the header of a PCD file");
    }
  }
  if (fields.names.empty()) source.fail("the header has no FIELDS");
  if (!points && !width) source.fail("the header has neither POINTS nor WIDTH");
  // Compared as doubles, whose products do not wrap around.
  const double declared = width ? static_cast<double>(*width) * static_cast<double>(height.value_or(1)) : 0.0;
  if (points && width && declared != static_cast<double>(*points)) {
    source.fail(fmt::format("POINTS is {}, and WIDTH times HEIGHT {:.0f}: they must be the same", *points, declared));
  }
  if (declared > 1e15) source.fail("WIDTH times HEIGHT is more than any file holds");
  const std::uint64_t count = points.value_or(width.value_or(0) * height.value_or(1));
  return {columns_of(source, fields, data), count, data};
}

/// Returns the positions of x y z and, if present, the normals among the columns.
std::vector<std::size_t> columns_of_surface(const ByteSource& source, const std::vector<PcdColumn>& columns) {
  constexpr std::array<std::string_view, 6> kColumns = {"x", "y", "z", "normal_x", "normal_y", "normal_z"};
  std::vector<std::size_t> found;
  for (const std::string_view name : kColumns) {
    const auto first = std::ranges::find(columns, name, &PcdColumn::name);
    if (first == columns.end() && (name == "x" || name == "y" || name == "z")) source.fail("FIELDS needs x y z");
    if (first == columns.end()) continue;
    if (first->field_count > 1 || std::ranges::count(columns, name, &PcdColumn::name) > 1) {
      source.fail("FIELDS has " + std::string(name) + " more than once");
    }
    found.push_back(static_cast<std::size_t>(first - columns.begin()));
  }
  if (found.size() != 3 && found.size() != 6) source.fail("FIELDS needs normal_x normal_y normal_z or none of them");
  return found;
}

/// Decompresses LZF [Lehmann, liblzf]: runs of bytes, and copies of earlier ones. Nothing if it is broken.
std::optional<std::string> unpack_lzf(std::string_view in, std::size_t size) {
  std::string out;
  out.reserve(size);
  std::size_t at = 0;
  const auto next = [&]() -> std::size_t { return at < in.size() ? static_cast<unsigned char>(in[at++]) : 0; };
  while (at < in.size()) {
    const std::size_t control = next();
    if (control < 32) {
      if (in.size() - at < control + 1) return std::nullopt;
      out.append(in, at, control + 1);
      at += control + 1;
    } else {
      std::size_t length = (control >> 5U) + 2;
      if (length == 9) length += next();
      const std::size_t back = ((control & 31U) << 8U) + next() + 1;
      if (back > out.size()) return std::nullopt;
      // Byte by byte: the copy may reach into itself.
      for (; length > 0; --length) out.push_back(out[out.size() - back]);
    }
    if (out.size() > size) return std::nullopt;
  }
  return out.size() == size ? std::optional(std::move(out)) : std::nullopt;
}

/// Takes the decompressed bytes of all points, in which each field is in one piece.
std::string take_compressed(ByteSource& source, std::size_t size) {
  std::array<std::uint32_t, 2> sizes{};
  std::memcpy(sizes.data(), source.take(sizeof sizes, "it ends here").data(), sizeof sizes);
  if (sizes[1] != size) source.fail_at_byte("the compressed data are of another size than the points");
  const std::string_view packed = source.take(sizes[0], "the compressed data end here");
  // Three bytes stand for 264 at most.
  auto data = size <= 88 * packed.size() ? unpack_lzf(packed, size) : std::nullopt;
  if (!data) source.fail("the compressed data are broken");
  return std::move(*data);
}

/// Fails if another point follows; a few bytes more are passed over.
void expect_end(ByteSource& source, std::size_t point_size, Notes& notes) {
  if (source.has_blank_rest()) return;
  if (source.left() >= point_size) source.fail_here("the header declares less than the file holds");
  notes.push_back("passed over " + counted(static_cast<Index>(source.left()), "byte") + " behind the last point");
}

void read_ascii(ByteSource& source, const PcdHeader& header, const std::vector<std::size_t>& columns,
                std::vector<double>& values) {
  for (std::uint64_t i = 0; i < header.points; ++i) {
    Words words = words_of(source.take_line());
    while (words.empty()) words = words_of(source.take_line());
    if (words.size() != header.columns.size()) {
      source.fail_at_line("must have " + std::to_string(header.columns.size()) + " values, has " +
                          std::to_string(words.size()));
    }
    for (const std::size_t column : columns) {
      const auto number = number_in<double>(words[column]);
      if (!number) source.fail_as_number(words[column]);
      values.push_back(*number);
    }
  }
}

void read_binary(ByteSource& source, const PcdHeader& header, const std::vector<std::size_t>& columns,
                 std::vector<double>& values, Notes& notes) {
  const PcdColumn& last = header.columns.back();
  const std::size_t point_size = last.field_offset + last.size * last.field_count;
  if (point_size == 0) source.fail("the points have no values");
  if (header.points > std::uint64_t{1} << 40U) source.fail("POINTS is more than any file holds");
  const std::size_t size = point_size * header.points;
  const bool is_packed = header.data == PcdData::kCompressed;
  const std::string unpacked = is_packed ? take_compressed(source, size) : "";
  const std::string_view data =
      is_packed ? unpacked : source.take(size, "its points need " + std::to_string(size) + " bytes");
  for (std::uint64_t i = 0; i < header.points; ++i) {
    for (const std::size_t k : columns) {
      const PcdColumn& column = header.columns[k];
      // These fields have one value each.
      const std::size_t at =
          is_packed ? column.field_offset * header.points + i * column.size : i * point_size + column.field_offset;
      values.push_back(unpacker_of(column)(data.data() + at));
    }
  }
  expect_end(source, point_size, notes);
}

}  // namespace

PointCloud parse_pcd(std::string_view bytes, const std::filesystem::path& file, Notes& notes) {
  std::string store;
  ByteSource source(file, plain_text(bytes, file, store));
  const PcdHeader header = read_pcd_header(source);
  const std::vector<std::size_t> columns = columns_of_surface(source, header.columns);
  std::vector<double> values;
  if (header.data == PcdData::kAscii) {
    // Also the guard against a header that claims more than the file holds: every value has a digit and a blank, but
    // for the last one.
    if (header.points > (source.left() + 1) / (2 * header.columns.size())) {
      source.fail("the file is truncated: it cannot hold " + std::to_string(header.points) + " points");
    }
    read_ascii(source, header, columns, values);
    if (!source.has_blank_rest()) {
      static_cast<void>(source.take_line());
      source.fail_at_line("the header declares less than the file holds");
    }
  } else {
    read_binary(source, header, columns, values, notes);
  }
  const auto width = static_cast<Index>(columns.size());
  const Eigen::Map<const Eigen::MatrixXd> all(values.data(), width, std::ssize(values) / width);
  if (width == 6) return {all.topRows<3>(), all.bottomRows<3>()};
  return {all.topRows<3>(), {}};
}

}  // namespace thenar
