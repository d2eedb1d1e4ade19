// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/ply_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "engine/formats/byte_source.h"
#include "engine/formats/files.h"
#include "engine/formats/mesh_builder.h"
#include "engine/formats/plain_text.h"
#include "engine/formats/text.h"

namespace thenar {

namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Notes = std::vector<std::string>;
using HeaderWords = std::vector<std::string>;

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
  std::string name;
  const Type* type;
  const Type* length_type;  ///< Type of a list's length; else null.
};

struct Element {
  std::string name;
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

PlyFormat read_format(const ByteSource& source, const HeaderWords& words) {
  if (words.size() != 3 || words[0] != "format") source.fail_at_line("'format' must follow 'ply'");
  if (words[2] != "1.0") source.fail_at_line("PLY version " + words[2] + " is not read, only 1.0");
  if (words[1] == "ascii") return PlyFormat::kAscii;
  if (words[1] == "binary_little_endian") return PlyFormat::kBinaryLittleEndian;
  if (words[1] == "binary_big_endian") return PlyFormat::kBinaryBigEndian;
  source.fail_at_line("unknown format '" + words[1] + "'");
}

Element read_element(const ByteSource& source, const HeaderWords& words) {
  const auto count = words.size() == 3 ? number_in<std::uint64_t>(words[2]) : std::nullopt;
  if (!count) source.fail_at_line("an element needs a name and a count");
  return {words[1], *count, {}};
}

/// Returns the type of that name; fails if there is none.
const Type* require_type(const ByteSource& source, std::string_view name) {
  if (const Type* const type = type_named(name)) return type;
  std::vector<std::string_view> names;
  for (const Type& type : kTypes) names.push_back(type.name);
  source.fail_at_line("unknown type '" + std::string(name) + "', PLY has " + join(names, ", "));
}

Property read_property(const ByteSource& source, const HeaderWords& words) {
  const bool is_list = words.size() == 5 && words[1] == "list";
  if (!is_list && words.size() != 3) source.fail_at_line("a property needs a type and a name");
  const Type* const type = require_type(source, words[words.size() - 2]);
  const Type* const length_type = is_list ? require_type(source, words[2]) : nullptr;
  if (is_list && !length_type->is_whole) source.fail_at_line("the length of a list must be a whole number");
  return {words.back(), type, length_type};
}

/// Returns the words of the next line of the header that has any, in small letters.
HeaderWords header_words(ByteSource& source) {
  for (;;) {
    HeaderWords words;
    for (const std::string_view word : words_of(source.take_line())) words.push_back(lower_case(word));
    if (!words.empty()) return words;
  }
}

/// Passes over a line of the header that is none of its keys, as comments of old programs without the word `comment`.
void pass_over(const ByteSource& source, const std::string& word, Notes& notes) {
  constexpr std::array<std::string_view, 5> kKeys = {"format", "element", "property", "end_header", "comment"};
  const bool is_key = std::ranges::find(kKeys, word) != kKeys.end();
  const std::string_view nearest = nearest_word(word, kKeys);
  if (is_key || !nearest.empty()) {
    source.fail_at_line("'" + printable(word) + "' is not expected in the header here" +
                        (is_key ? "" : did_you_mean(nearest)));
  }
  const std::string note = "passed over lines of the header that are no part of it";
  if (std::ranges::find(notes, note) == notes.end()) notes.push_back(note);
}

Header read_header(ByteSource& source, Notes& notes) {
  if (source.left() == 0) source.fail("the file is empty");
  if (source.has_blank_rest() || header_words(source) != HeaderWords{"ply"})
    source.fail("is no PLY file: its first line is not 'ply'");
  Header header;
  bool has_format = false;
  for (;;) {
    const HeaderWords words = header_words(source);
    if (words[0] == "comment" || words[0] == "obj_info") continue;
    if (!has_format && words[0] == "format") {
      header.format = read_format(source, words);
      has_format = true;
    } else if (has_format && words[0] == "element") {
      header.elements.push_back(read_element(source, words));
    } else if (words[0] == "property" && !header.elements.empty()) {
      header.elements.back().properties.push_back(read_property(source, words));
    } else if (has_format && words[0] == "end_header" && words.size() == 1) {
      return header;
    } else if (!has_format && (words[0] == "element" || words[0] == "property" || words[0] == "end_header")) {
      source.fail_at_line("'format' must follow 'ply'");
    } else if (header.elements.empty()) {
      pass_over(source, words[0], notes);
    } else {
      source.fail_at_line("'" + printable(words[0]) + "' is not expected in the header here");
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

/// One instance of an element.
struct Record {
  std::vector<double> values;  ///< Of its properties; of a list its length.
  std::vector<double> items;   ///< Of the wanted list.
};

void read_binary(ByteSource& source, const Element& element, std::size_t list, bool is_big_endian, Record& record) {
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const Property& property = element.properties[i];
    record.values[i] =
        take_binary(source, property.length_type ? *property.length_type : *property.type, is_big_endian);
    if (property.length_type == nullptr) continue;
    if (record.values[i] < 0.0) source.fail_at_byte("a list has a negative length");
    const auto length = static_cast<std::size_t>(record.values[i]);
    const std::size_t size = length * property.type->size;
    if (i != list || source.left() < size) {
      source.take(size, "a list of " + std::to_string(size) + " bytes starts here");
      continue;
    }
    for (std::size_t k = 0; k < length; ++k) {
      record.items.push_back(take_binary(source, *property.type, is_big_endian));
    }
  }
}

void read_ascii(ByteSource& source, const Element& element, std::size_t list, Record& record) {
  std::vector<std::string_view> words = words_of(source.take_line());
  while (words.empty()) words = words_of(source.take_line());
  std::size_t next = 0;
  const auto take = [&] {
    if (next == words.size()) source.fail_at_line("too few values for one " + element.name);
    const auto value = number_in<double>(words[next]);
    if (!value) source.fail_as_number(words[next]);
    ++next;
    return *value;
  };
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const double value = record.values[i] = take();
    if (element.properties[i].length_type == nullptr) continue;
    if (!(value >= 0.0 && value <= static_cast<double>(words.size()))) source.fail_at_line("wrong length of a list");
    for (std::size_t k = static_cast<std::size_t>(value); k > 0; --k) {
      const double item = take();
      if (i == list) record.items.push_back(item);
    }
  }
  if (next < words.size()) source.fail_at_line("too many values for one " + element.name);
}

/// Returns the least number of bytes of one instance.
std::size_t least_size(const Element& element, PlyFormat format) {
  // In ascii every value has a digit and a blank or the line's end after it.
  if (format == PlyFormat::kAscii) return std::max<std::size_t>(1, 2 * element.properties.size());
  std::size_t size = 0;
  for (const Property& p : element.properties) size += (p.length_type != nullptr ? p.length_type : p.type)->size;
  return size;
}

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

bool holds_faces(const Element& element) {
  return element.count > 0 && (element.name == "face" || element.name == "tristrips");
}

/// Returns the place of the list of an element's corners among its properties.
std::size_t corners_of(const ByteSource& source, const Element& element) {
  std::size_t list = kNone;
  int lists = 0;
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const Property& property = element.properties[i];
    if (property.length_type == nullptr) continue;
    if (property.name == "vertex_indices" || property.name == "vertex_index") return i;
    list = i;
    ++lists;
  }
  if (lists != 1) source.fail("the element '" + element.name + "' has no list vertex_indices");
  return list;
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

/// Returns the fewest bytes that another record would have: three items of a list, as a triangle.
std::size_t record_size(const Element& element) {
  std::size_t size = 0;
  for (const Property& p : element.properties)
    size += p.length_type ? p.length_type->size + 3 * p.type->size : p.type->size;
  return size;
}

/// Refuses further records behind the last one, of which the header says nothing; other bytes are passed over.
void expect_end(ByteSource& source, const Header& header, Notes& notes) {
  if (source.has_blank_rest()) return;
  const std::size_t left = source.left();
  if (header.format == PlyFormat::kAscii) {
    const auto words = words_of(source.take_line());
    const auto is_number = [](std::string_view word) { return number_in<double>(word).has_value(); };
    const bool is_record = std::ranges::all_of(words, is_number);
    if (is_record && words.size() > 1) source.fail_at_line("the header declares less than the file holds");
  } else if (header.elements.empty() || left >= record_size(header.elements.back())) {
    source.fail_at_byte("the header declares less than the file holds: " + std::to_string(left) + " bytes are left");
  }
  notes.push_back("passed over " + counted(static_cast<std::int64_t>(left), "byte") + " behind the last record");
}

std::string to_word(double number) {
  std::array<char, 32> buffer{};
  return {buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), number).ptr};
}

/// The corners of all faces, one after another.
struct Faces {
  std::vector<double> corners;
  std::vector<std::size_t> ends;  ///< Of each face, in `corners`.

  void add(const std::vector<double>& items) {
    corners.insert(corners.end(), items.begin(), items.end());
    ends.push_back(corners.size());
  }
  /// Adds the triangles of strips: each corner makes one with the two before it, in turns wound either way.
  void add_strips(const std::vector<double>& items) {
    for (std::size_t i = 0, length = 0; i < items.size(); ++i) {
      length = items[i] == -1.0 ? 0 : length + 1;
      if (length < 3) continue;
      const bool is_odd = length % 2 == 1;
      add({items[is_odd ? i - 2 : i - 1], items[is_odd ? i - 1 : i - 2], items[i]});
    }
  }
};

TriangleMesh mesh_of(const ByteSource& source, const Eigen::Matrix3Xd& vertices, const Faces& faces) {
  MeshBuilder mesh;
  for (const auto vertex : vertices.colwise()) {
    if (const std::string fault = mesh.add_vertex(vertex); !fault.empty()) source.fail(fault);
  }
  std::size_t begin = 0;
  for (std::size_t face = 0; face < faces.ends.size(); ++face) {
    const auto fail = [&](const std::string& what) { source.fail("face " + std::to_string(face) + ": " + what); };
    std::vector<int> corners;
    for (; begin < faces.ends[face]; ++begin) {
      const double corner = faces.corners[begin];
      const bool is_there =
          corner >= 0.0 && corner < static_cast<double>(vertices.cols()) && corner == std::floor(corner);
      if (!is_there) fail("there is no vertex " + to_word(corner));
      corners.push_back(static_cast<int>(corner));
      if (!vertices.col(corners.back()).allFinite()) fail("its vertex " + to_word(corner) + " is not finite");
    }
    if (const std::string fault = mesh.add_face(std::move(corners)); !fault.empty()) fail(fault);
  }
  if (!mesh.has_faces()) source.fail("has no faces");
  return mesh.mesh();
}

/// The values of the vertices that are wanted.
void add_vertex(const Record& record, const std::vector<std::size_t>& columns, Index i, PointCloud& cloud) {
  const auto value = [&](std::size_t column) { return record.values[columns[column]]; };
  cloud.points_m.col(i) = Vector3d(value(0), value(1), value(2));
  if (columns.size() == 6) cloud.normals.col(i) = Vector3d(value(3), value(4), value(5));
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

PlyFile parse_ply(std::string_view all_bytes, const std::filesystem::path& file, Notes& notes) {
  std::string store;
  ByteSource source(file, plain_text(all_bytes, file, store));
  const Header header = read_header(source, notes);
  const auto is_vertex = [](const Element& element) { return element.name == "vertex"; };
  if (std::ranges::count_if(header.elements, is_vertex) != 1) source.fail("needs one element 'vertex'");
  const auto columns = columns_of(source, *std::ranges::find_if(header.elements, is_vertex));

  PlyFile ply;
  Faces faces;
  for (const Element& element : header.elements) {
    // Also the guard against a header that claims more than the file holds.
    const std::size_t size = least_size(element, header.format);
    if (size > 0 && element.count > source.left() / size + (header.format == PlyFormat::kAscii ? 1 : 0)) {
      source.fail("the file is truncated: it cannot hold " + std::to_string(element.count) + " of '" + element.name +
                  "'");
    }
    if (size == 0) continue;
    if (is_vertex(element)) {
      ply.cloud.points_m.resize(3, static_cast<Index>(element.count));
      if (columns.size() == 6) ply.cloud.normals.resize(3, static_cast<Index>(element.count));
    }
    const std::size_t list = holds_faces(element) ? corners_of(source, element) : kNone;
    Record record{std::vector<double>(element.properties.size()), {}};
    for (std::uint64_t i = 0; i < element.count; ++i) {
      record.items.clear();
      if (header.format == PlyFormat::kAscii) {
        read_ascii(source, element, list, record);
      } else {
        read_binary(source, element, list, header.format == PlyFormat::kBinaryBigEndian, record);
      }
      if (is_vertex(element)) add_vertex(record, columns, static_cast<Index>(i), ply.cloud);
      if (list != kNone) element.name == "face" ? faces.add(record.items) : faces.add_strips(record.items);
    }
  }
  expect_end(source, header, notes);
  if (std::ranges::any_of(header.elements, holds_faces)) ply.mesh = mesh_of(source, ply.cloud.points_m, faces);
  return ply;
}

bool ply_has_faces(std::string_view bytes) try {
  std::string store;
  const std::filesystem::path none;
  Notes notes;
  ByteSource source(none, plain_text(bytes, none, store));
  return std::ranges::any_of(read_header(source, notes).elements, holds_faces);
} catch (const FileError&) {
  return false;
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
