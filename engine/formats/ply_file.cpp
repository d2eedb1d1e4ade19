#include "engine/formats/ply_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "engine/formats/byte_source.h"
#include "engine/formats/files.h"

namespace thenar {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

static_assert(std::endian::native == std::endian::little, "binary_little_endian is this machine's order");

constexpr std::array<std::string_view, 6> kNames = {"x", "y", "z", "nx", "ny", "nz"};

/// Returns `bytes` in this machine's order.
template <typename Number>
double unpack(const char* bytes) {
  Number number;
  std::memcpy(&number, bytes, sizeof number);
  return static_cast<double>(number);
}

/// A type of numbers, by its two names.
struct Type {
  std::string_view name, other_name;
  std::size_t size;
  bool is_whole;
  double (*unpack)(const char* bytes);
};
constexpr std::array<Type, 8> kTypes{{{"char", "int8", 1, true, unpack<std::int8_t>},
                                      {"uchar", "uint8", 1, true, unpack<std::uint8_t>},
                                      {"short", "int16", 2, true, unpack<std::int16_t>},
                                      {"ushort", "uint16", 2, true, unpack<std::uint16_t>},
                                      {"int", "int32", 4, true, unpack<std::int32_t>},
                                      {"uint", "uint32", 4, true, unpack<std::uint32_t>},
                                      {"float", "float32", 4, false, unpack<float>},
                                      {"double", "float64", 8, false, unpack<double>}}};

struct Property {
  std::string_view name;
  const Type* type;
  const Type* length_type;  ///< Type of a list's length; else null.
};

struct Element {
  std::string_view name;
  std::uint64_t count;
  std::vector<Property> properties;
};

/// Returns the type of that name; null if there is none.
const Type* type_named(std::string_view name) {
  const auto* const type =
      std::ranges::find_if(kTypes, [&](const Type& t) { return t.name == name || t.other_name == name; });
  return type == kTypes.end() ? nullptr : type;
}

struct Header {
  PlyFormat format = PlyFormat::kAscii;
  std::vector<Element> elements;
};

PlyFormat read_format(const ByteSource& source, const std::vector<std::string_view>& words) {
  if (words.size() != 3 || words[0] != "format") source.fail_at_line("'format' must follow 'ply'");
  if (words[2] != "1.0") source.fail_at_line("PLY version " + std::string(words[2]) + " is not read, only 1.0");
  if (words[1] == "ascii") return PlyFormat::kAscii;
  if (words[1] == "binary_little_endian") return PlyFormat::kBinaryLittleEndian;
  if (words[1] == "binary_big_endian") return PlyFormat::kBinaryBigEndian;
  source.fail_at_line("unknown format '" + std::string(words[1]) + "'");
}

Element read_element(const ByteSource& source, const std::vector<std::string_view>& words) {
  const auto count = words.size() == 3 ? number_in<std::uint64_t>(words[2]) : std::nullopt;
  if (!count) source.fail_at_line("an element needs a name and a count");
  return {words[1], *count, {}};
}

Property read_property(const ByteSource& source, const std::vector<std::string_view>& words) {
  const bool is_list = words.size() == 5 && words[1] == "list";
  if (!is_list && words.size() != 3) source.fail_at_line("a property needs a type and a name");
  const Type* const type = type_named(words[words.size() - 2]);
  const Type* const length_type = is_list ? type_named(words[2]) : nullptr;
  if (type == nullptr || (is_list && length_type == nullptr)) source.fail_at_line("unknown type");
  if (is_list && !length_type->is_whole) source.fail_at_line("the length of a list must be a whole number");
  return {words.back(), type, length_type};
}

Header read_header(ByteSource& source) {
  if (source.left() == 0) source.fail("the file is empty");
  if (words_of(source.take_line()) != std::vector<std::string_view>{"ply"}) source.fail("not a PLY file");
  Header header;
  bool has_format = false;
  for (;;) {
    const auto words = words_of(source.take_line());
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (!has_format) {
      header.format = read_format(source, words);
      has_format = true;
    } else if (words[0] == "element") {
      header.elements.push_back(read_element(source, words));
    } else if (words[0] == "property" && !header.elements.empty()) {
      header.elements.back().properties.push_back(read_property(source, words));
    } else if (words[0] == "end_header" && words.size() == 1) {
      return header;
    } else {
      source.fail_at_line("'" + std::string(words[0]) + "' is not expected in the header here");
    }
  }
}

double take_binary(ByteSource& source, const Type& type, bool is_big_endian) {
  const std::string_view bytes = source.take(type.size, "it ends here");
  std::array<char, 8> native{};
  std::ranges::copy(bytes, native.begin());
  if (is_big_endian) std::ranges::reverse_copy(bytes, native.begin());
  return type.unpack(native.data());
}

/// Reads one instance of `element`, and its scalars into `values`, where a list leaves a zero.
void read_binary(ByteSource& source, const Element& element, bool is_big_endian, std::vector<double>& values) {
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const Property& property = element.properties[i];
    values[i] = 0.0;
    if (property.length_type == nullptr) {
      values[i] = take_binary(source, *property.type, is_big_endian);
      continue;
    }
    const double length = take_binary(source, *property.length_type, is_big_endian);
    if (length < 0.0) source.fail_at_byte("a list has a negative length");
    const std::size_t size = static_cast<std::size_t>(length) * property.type->size;
    source.take(size, "a list of " + std::to_string(size) + " bytes starts here");
  }
}

void read_ascii(ByteSource& source, const Element& element, std::vector<double>& values) {
  const auto words = words_of(source.take_line());
  std::size_t next = 0;
  const auto take = [&] {
    if (next == words.size()) source.fail_at_line("too few values for one " + std::string(element.name));
    const auto value = number_in<double>(words[next]);
    if (!value) source.fail_at_line("'" + std::string(words[next]) + "' is not a number");
    ++next;
    return *value;
  };
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const double value = take();
    const bool is_list = element.properties[i].length_type != nullptr;
    values[i] = is_list ? 0.0 : value;
    if (!is_list) continue;
    if (!(value >= 0.0 && value <= static_cast<double>(words.size()))) source.fail_at_line("wrong length of a list");
    const auto length = static_cast<std::size_t>(value);
    for (std::size_t item = 0; item < length; ++item) static_cast<void>(take());
  }
  if (next < words.size()) source.fail_at_line("too many values for one " + std::string(element.name));
}

/// Returns the least number of bytes of one instance.
std::size_t least_size(const Element& element, PlyFormat format) {
  // In ascii every value has a digit and a blank or the line's end after it.
  if (format == PlyFormat::kAscii) return std::max<std::size_t>(1, 2 * element.properties.size());
  std::size_t size = 0;
  for (const Property& p : element.properties) size += (p.length_type != nullptr ? p.length_type : p.type)->size;
  return size;
}

/// Returns the indices of x y z and, if present, nx ny nz among the properties of the vertex.
std::vector<std::size_t> columns_of(const ByteSource& source, const Element& vertex) {
  std::vector<std::size_t> columns;
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    const auto is_named = [&](const Property& p) { return p.name == kNames[i] && p.length_type == nullptr; };
    const auto count = std::ranges::count_if(vertex.properties, is_named);
    if (count > 1) source.fail("property " + std::string(kNames[i]) + " is declared twice");
    if (count == 0 && i < 3) source.fail("needs coordinates x y z");
    if (count == 0) continue;
    const auto found = std::ranges::find_if(vertex.properties, is_named);
    columns.push_back(static_cast<std::size_t>(found - vertex.properties.begin()));
  }
  if (columns.size() != 3 && columns.size() != 6)
    source.fail("has a part of the normals: needs nx ny nz or none of them");
  return columns;
}

void expect_end(ByteSource& source, PlyFormat format) {
  if (format == PlyFormat::kAscii) return source.expect_blank_rest();
  if (source.left() == 0) return;
  source.fail_at_byte("the header declares less than the file holds: " + std::to_string(source.left()) +
                      " bytes are left");
}

template <typename Append>
void append_vertices(const PointCloud& cloud, const Append& append) {
  for (Index i = 0; i < cloud.points_m.cols(); ++i) {
    for (const double value : cloud.points_m.col(i)) append(value, false);
    append(cloud.normals(0, i), false);
    append(cloud.normals(1, i), false);
    append(cloud.normals(2, i), true);
  }
}

}  // namespace

PointCloud parse_ply(std::string_view bytes, const std::filesystem::path& file) {
  ByteSource source(file, bytes);
  const Header header = read_header(source);
  const bool is_ascii = header.format == PlyFormat::kAscii;
  const bool is_big_endian = header.format == PlyFormat::kBinaryBigEndian;
  const auto is_vertex = [](const Element& element) { return element.name == "vertex"; };
  if (std::ranges::count_if(header.elements, is_vertex) != 1) source.fail("needs one element 'vertex'");
  const auto columns = columns_of(source, *std::ranges::find_if(header.elements, is_vertex));
  const bool has_normals = columns.size() == 6;

  PointCloud cloud;
  for (const Element& element : header.elements) {
    // Also the guard against a header that claims more than the file holds.
    const std::size_t size = least_size(element, header.format);
    if (size > 0 && element.count > source.left() / size) {
      source.fail("the file is truncated: it cannot hold " + std::to_string(element.count) + " of '" +
                  std::string(element.name) + "'");
    }
    if (size == 0) continue;
    const bool is_wanted = is_vertex(element);
    if (is_wanted) cloud.points_m.resize(3, static_cast<Index>(element.count));
    if (is_wanted && has_normals) cloud.normals.resize(3, static_cast<Index>(element.count));
    std::vector<double> values(element.properties.size());
    for (std::uint64_t i = 0; i < element.count; ++i) {
      is_ascii ? read_ascii(source, element, values) : read_binary(source, element, is_big_endian, values);
      if (!is_wanted) continue;
      const auto value = [&](std::size_t column) { return values[columns[column]]; };
      cloud.points_m.col(static_cast<Index>(i)) = Vector3d(value(0), value(1), value(2));
      if (has_normals) cloud.normals.col(static_cast<Index>(i)) = Vector3d(value(3), value(4), value(5));
    }
  }
  expect_end(source, header.format);
  return cloud;
}

void save_ply(const std::filesystem::path& file, const PointCloud& cloud, PlyFormat format) {
  assert(cloud.points_m.cols() == cloud.normals.cols());
  const bool is_ascii = format == PlyFormat::kAscii;
  std::string bytes = "ply\nformat ";
  bytes += is_ascii ? "ascii" : format == PlyFormat::kBinaryBigEndian ? "binary_big_endian" : "binary_little_endian";
  bytes += " 1.0\nelement vertex " + std::to_string(cloud.points_m.cols()) + "\n";
  for (const std::string_view name : kNames) bytes.append("property double ").append(name).append("\n");
  bytes += "end_header\n";
  append_vertices(cloud, [&](double value, bool is_last) {
    std::array<char, 32> buffer{};
    if (!is_ascii) {
      std::memcpy(buffer.data(), &value, sizeof value);
      if (format == PlyFormat::kBinaryBigEndian) std::reverse(buffer.begin(), buffer.begin() + sizeof value);
      bytes.append(buffer.data(), sizeof value);
      return;
    }
    const auto written = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
    bytes.append(buffer.data(), written.ptr).append(is_last ? "\n" : " ");
  });
  write_file(file, bytes);
}

}  // namespace thenar
