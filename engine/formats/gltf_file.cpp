// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/gltf_file.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>

#include "engine/formats/files.h"
#include "engine/formats/mesh_builder.h"
#include "engine/formats/plain_text.h"
#include "engine/formats/text.h"

namespace thenar {

namespace {

using Eigen::Affine3d;
using Eigen::Vector3d;
using nlohmann::json;
namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "the numbers of glTF are little-endian");

// Nodes may place a mesh as often as they like: a bound for what a small file asks for.
constexpr std::size_t kMostPlaced = 60'000'000;

/// The decoded file.
struct Gltf {
  const fs::path& file;
  json root;
  std::vector<std::string> buffers;

  [[noreturn]] void fail(const std::string& what) const { throw FileError(file, what); }
  /// Returns an item of one of the lists of the root.
  [[nodiscard]] const json& item(const char* list, std::size_t index) const {
    const auto found = root.find(list);
    if (found == root.end() || !found->is_array() || index >= found->size()) {
      fail(std::string(list) + " has no item " + std::to_string(index));
    }
    return (*found)[index];
  }
  /// Returns a count or an index, which some write as 3.0.
  [[nodiscard]] std::size_t whole(const json& number, const char* key) const {
    if (number.is_number_unsigned()) return number.get<std::size_t>();
    constexpr double kMost = 9007199254740992.0;  // 2^53
    const double value = number.is_number_float() ? number.get<double>() : -1.0;
    if (!(value >= 0.0 && value <= kMost && value == std::floor(value))) fail(std::string(key) + " is no whole number");
    return static_cast<std::size_t>(value);
  }
  [[nodiscard]] std::size_t whole_of(const json& of, const char* key,
                                     std::optional<std::size_t> otherwise = std::nullopt) const {
    const auto found = of.find(key);
    if (found != of.end()) return whole(*found, key);
    if (!otherwise) fail(std::string("lacks ") + key);
    return *otherwise;
  }
  [[nodiscard]] std::vector<std::size_t> wholes_of(const json& of, const char* key) const {
    std::vector<std::size_t> numbers;
    const auto found = of.find(key);
    if (found == of.end()) return numbers;
    for (const json& number : *found) numbers.push_back(whole(number, key));
    return numbers;
  }
};

std::optional<std::string> from_base64(std::string_view text) {
  std::string bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char letter : text) {
    if (letter == '=') break;
    constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const std::size_t value = kLetters.find(letter);
    if (value == kLetters.npos) return std::nullopt;
    bits = bits << 6U | static_cast<std::uint32_t>(value);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> static_cast<unsigned>(count) & 0xFFU);
  }
  return bytes;
}

/// Returns the text with its "%20" decoded [RFC 3986].
std::string from_uri(std::string_view uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const auto digit = [&](std::size_t k) {
      constexpr std::string_view kDigits = "0123456789abcdef";
      return k < uri.size() ? kDigits.find(lower_case(uri.substr(k, 1))) : kDigits.npos;
    };
    if (uri[i] != '%' || digit(i + 1) > 15 || digit(i + 2) > 15) {
      text += uri[i];
      continue;
    }
    text += static_cast<char>(16 * digit(i + 1) + digit(i + 2));
    i += 2;
  }
  return text;
}

/// Reads a buffer; one without an address has the bytes of `chunk`.
std::string read_buffer(const Gltf& gltf, const json& buffer, std::string_view chunk) {
  if (!buffer.contains("uri")) return std::string(chunk);
  const auto uri = buffer.at("uri").get<std::string>();
  if (uri.starts_with("data:")) {
    const std::size_t comma = uri.find(";base64,");
    const auto bytes = comma == uri.npos ? std::nullopt : from_base64(std::string_view(uri).substr(comma + 8));
    if (!bytes) gltf.fail("has a buffer that is not base64");
    return *bytes;
  }
  if (uri.find("://") != uri.npos) gltf.fail("has a buffer elsewhere: " + printable(uri));
  const fs::path file = gltf.file.parent_path() / from_uri(uri);
  if (!is_readable(file)) gltf.fail("names the file '" + printable(uri) + "', which is not beside it");
  return read_file(file);
}

std::uint32_t whole_number_at(std::string_view bytes, std::size_t at) {
  std::uint32_t number = 0;
  std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}

/// Splits a .glb into its text, and the bytes behind it.
std::pair<std::string_view, std::string_view> chunks_of(const Gltf& gltf, std::string_view bytes) {
  constexpr std::uint32_t kText = 0x4E4F534A, kBytes = 0x004E4942;
  if (bytes.size() < 20) gltf.fail("the file is truncated: it ends in its header");
  if (whole_number_at(bytes, 4) != 2) gltf.fail("is glTF of another version than 2.0");
  std::pair<std::string_view, std::string_view> chunks;
  for (std::size_t at = 12; at + 8 <= bytes.size();) {
    const std::size_t size = whole_number_at(bytes, at);
    const std::uint32_t kind = whole_number_at(bytes, at + 4);
    at += 8;
    if (size > bytes.size() - at)
      gltf.fail("the file is truncated: a part of " + std::to_string(size) + " bytes begins at byte " +
                std::to_string(at));
    if (kind == kText && chunks.first.empty()) chunks.first = bytes.substr(at, size);
    if (kind == kBytes && chunks.second.empty()) chunks.second = bytes.substr(at, size);
    at += size;
  }
  return chunks;
}

/// The numbers of an accessor.
struct Numbers {
  std::string_view bytes;
  std::size_t count, stride;
  std::size_t type;    ///< Of a component, as in OpenGL.
  bool is_normalized;  ///< Whole numbers stand for 0 .. 1, or -1 .. 1.

  [[nodiscard]] double at(std::size_t i, std::size_t k) const;
};

std::size_t component_size(std::size_t type) {
  return type == 5120 || type == 5121 ? 1 : type == 5122 || type == 5123 ? 2 : 4;
}

template <typename Number>
double component(const char* bytes, bool is_normalized) {
  Number number;
  std::memcpy(&number, bytes, sizeof number);
  const auto value = static_cast<double>(number);
  if (!is_normalized || !std::numeric_limits<Number>::is_integer) return value;
  return std::max(-1.0, value / static_cast<double>(std::numeric_limits<Number>::max()));
}

double Numbers::at(std::size_t i, std::size_t k) const {
  const char* const from = bytes.data() + i * stride + k * component_size(type);
  switch (type) {
    case 5120:
      return component<std::int8_t>(from, is_normalized);
    case 5121:
      return component<std::uint8_t>(from, is_normalized);
    case 5122:
      return component<std::int16_t>(from, is_normalized);
    case 5123:
      return component<std::uint16_t>(from, is_normalized);
    case 5125:
      return component<std::uint32_t>(from, is_normalized);
    default:
      return component<float>(from, false);
  }
}

Numbers numbers_of(const Gltf& gltf, std::size_t index, std::size_t width) {
  const json& accessor = gltf.item("accessors", index);
  const std::string name = "accessor " + std::to_string(index) + ": ";
  if (accessor.contains("sparse")) gltf.fail(name + "sparse numbers are not read: save it without");
  if (!accessor.contains("bufferView")) gltf.fail(name + "has no numbers");
  Numbers numbers{.bytes = {},
                  .count = gltf.whole_of(accessor, "count"),
                  .stride = 0,
                  .type = gltf.whole_of(accessor, "componentType"),
                  .is_normalized = accessor.value("normalized", false)};
  if (numbers.type < 5120 || numbers.type > 5126 || numbers.type == 5124) gltf.fail(name + "unknown componentType");
  if (accessor.at("type") != (width == 3 ? "VEC3" : "SCALAR")) gltf.fail(name + "has another type than is needed");
  const json& view = gltf.item("bufferViews", gltf.whole_of(accessor, "bufferView"));
  const std::size_t buffer = gltf.whole_of(view, "buffer");
  if (buffer >= gltf.buffers.size()) gltf.fail("buffers has no item " + std::to_string(buffer));
  const std::string_view all = gltf.buffers[buffer];
  const std::size_t begin = gltf.whole_of(view, "byteOffset", 0), size = gltf.whole_of(view, "byteLength");
  const std::size_t offset = gltf.whole_of(accessor, "byteOffset", 0);
  const std::size_t each = width * component_size(numbers.type);
  numbers.stride = gltf.whole_of(view, "byteStride", each);
  const bool is_there = begin <= all.size() && size <= all.size() - begin && offset <= size;
  if (!is_there) gltf.fail(name + "the file is truncated: its buffer ends before it");
  numbers.bytes = all.substr(begin + offset, size - offset);
  if (numbers.stride < each || numbers.count > 1 + (numbers.bytes.size() / numbers.stride) ||
      (numbers.count > 0 && (numbers.count - 1) * numbers.stride + each > numbers.bytes.size())) {
    gltf.fail(name + "the file is truncated: its buffer ends before it");
  }
  return numbers;
}

Affine3d transform_of(const Gltf& gltf, const json& node) {
  Affine3d X = Affine3d::Identity();
  const auto numbers = [&](const char* key, std::size_t count, double otherwise) {
    std::vector<double> values(count, otherwise);
    if (node.contains(key)) values = node.at(key).get<std::vector<double>>();
    if (values.size() != count) gltf.fail(std::string("a node's ") + key + " has a wrong number of values");
    return values;
  };
  if (node.contains("matrix")) {
    const std::vector<double> values = numbers("matrix", 16, 0.0);
    X.matrix() = Eigen::Map<const Eigen::Matrix4d>(values.data());
    return X;
  }
  const std::vector<double> t = numbers("translation", 3, 0.0), s = numbers("scale", 3, 1.0);
  X.translation() = Vector3d(t[0], t[1], t[2]);
  if (node.contains("rotation")) {
    const std::vector<double> q = numbers("rotation", 4, 0.0);
    X.linear() = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix();
  }
  X.linear() *= Eigen::DiagonalMatrix<double, 3>(s[0], s[1], s[2]);
  return X;
}

/// The corners of a primitive's triangles, three each, as places among its vertices.
std::vector<std::size_t> triangles_of(const Gltf& gltf, const json& primitive, std::size_t vertices) {
  constexpr std::size_t kTriangles = 4, kFan = 6;  // and strips between
  const std::size_t mode = gltf.whole_of(primitive, "mode", kTriangles);
  if (mode < kTriangles || mode > kFan) return {};
  std::vector<std::size_t> order(vertices);
  for (std::size_t i = 0; i < vertices; ++i) order[i] = i;
  if (primitive.contains("indices")) {
    const std::size_t accessor = gltf.whole_of(primitive, "indices");
    const Numbers numbers = numbers_of(gltf, accessor, 1);
    order.resize(numbers.count);
    for (std::size_t i = 0; i < numbers.count; ++i) {
      const double index = numbers.at(i, 0);
      if (!(index >= 0.0 && index < static_cast<double>(vertices))) {
        gltf.fail("accessor " + std::to_string(accessor) + ": there is no vertex " + std::to_string(index));
      }
      order[i] = static_cast<std::size_t>(index);
    }
  }
  if (mode == kTriangles && order.size() % 3 != 0) gltf.fail("a mesh has a part of a triangle");
  if (mode == kTriangles) return order;
  std::vector<std::size_t> corners;
  for (std::size_t i = 2; i < order.size(); ++i) {
    const bool is_odd = i % 2 == 1;
    const std::size_t a = mode == kFan ? order[0] : order[is_odd ? i - 1 : i - 2];
    const std::size_t b = mode == kFan ? order[i - 1] : order[is_odd ? i - 2 : i - 1];
    corners.insert(corners.end(), {a, b, order[i]});
  }
  return corners;
}

/// Refuses a file that needs an extension by which its triangles are other ones than without.
void check_extensions(const Gltf& gltf) {
  const auto has = [&](const char* list, const char* name) {
    const auto found = gltf.root.find(list);
    return found != gltf.root.end() && std::ranges::find(*found, name) != found->end();
  };
  for (const char* packed : {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    if (has("extensionsRequired", packed)) gltf.fail(std::string("is compressed (") + packed + "): save it without");
  }
  constexpr const char* kCopies = "EXT_mesh_gpu_instancing";
  if (has("extensionsUsed", kCopies)) {
    gltf.fail(std::string("has copies of meshes (") + kCopies + "), which are not read: save them as nodes");
  }
}

void add_primitive(const Gltf& gltf, const json& primitive, const Affine3d& X, MeshBuilder& mesh) {
  const char* const packed = "KHR_draco_mesh_compression";
  if (primitive.contains("extensions") && primitive.at("extensions").contains(packed)) {
    gltf.fail(std::string("is compressed (") + packed + "): save it without");
  }
  if (!primitive.at("attributes").contains("POSITION")) return;
  const std::size_t accessor = gltf.whole_of(primitive.at("attributes"), "POSITION");
  const Numbers places = numbers_of(gltf, accessor, 3);
  const std::vector<std::size_t> corners = triangles_of(gltf, primitive, places.count);
  const std::size_t first = mesh.vertices();
  if (first + places.count + corners.size() > kMostPlaced) gltf.fail("has more than 60 million corners");
  for (std::size_t i = 0; i < places.count; ++i) {
    const Vector3d place = X * Vector3d(places.at(i, 0), places.at(i, 1), places.at(i, 2));
    if (!place.allFinite()) gltf.fail("accessor " + std::to_string(accessor) + ": a vertex is not finite");
    if (const std::string fault = mesh.add_vertex(place); !fault.empty()) gltf.fail(fault);
  }
  // A mirrored mesh has its triangles the other way round.
  const bool is_mirrored = X.linear().determinant() < 0.0;
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
    const auto corner = [&](std::size_t k) { return static_cast<int>(first + corners[i + k]); };
    const std::string fault = mesh.add_face({corner(0), corner(is_mirrored ? 2 : 1), corner(is_mirrored ? 1 : 2)});
    if (!fault.empty()) gltf.fail(fault);
  }
}

/// The nodes that nothing is above, in the scene that is shown; all where there is none.
std::vector<std::size_t> top_nodes(const Gltf& gltf) {
  if (gltf.root.contains("scenes") && !gltf.root.at("scenes").empty()) {
    const json& scene = gltf.item("scenes", gltf.whole_of(gltf.root, "scene", 0));
    return gltf.wholes_of(scene, "nodes");
  }
  const std::size_t count = gltf.root.contains("nodes") ? gltf.root.at("nodes").size() : 0;
  std::vector<char> is_below(count, 0);
  for (std::size_t i = 0; i < count; ++i) {
    for (const std::size_t child : gltf.wholes_of(gltf.item("nodes", i), "children")) {
      if (child < count) is_below[child] = 1;
    }
  }
  std::vector<std::size_t> top;
  for (std::size_t i = 0; i < count; ++i) {
    if (is_below[i] == 0) top.push_back(i);
  }
  return top;
}

TriangleMesh mesh_of(const Gltf& gltf, std::vector<std::string>& notes) {
  struct Placed {
    std::size_t node;
    Affine3d X_above;
  };
  std::vector<Placed> open;
  for (const std::size_t node : top_nodes(gltf)) open.push_back({node, Affine3d::Identity()});
  std::vector<char> seen(gltf.root.contains("nodes") ? gltf.root.at("nodes").size() : 0, 0);
  MeshBuilder mesh;
  bool has_skin = false, has_targets = false;
  while (!open.empty()) {
    const Placed at = open.back();
    open.pop_back();
    const json& node = gltf.item("nodes", at.node);
    if (seen[at.node]++ != 0) gltf.fail("node " + std::to_string(at.node) + " is below two others");
    const Affine3d X = at.X_above * transform_of(gltf, node);
    for (const std::size_t child : gltf.wholes_of(node, "children")) open.push_back({child, X});
    has_skin = has_skin || (node.contains("skin") && node.contains("mesh"));
    if (!node.contains("mesh")) continue;
    const json& shape = gltf.item("meshes", gltf.whole_of(node, "mesh"));
    const auto weights = (node.contains("weights") ? node : shape).value("weights", std::vector<double>{});
    has_targets = has_targets || std::ranges::any_of(weights, [](double weight) { return weight != 0.0; });
    for (const json& primitive : shape.at("primitives")) add_primitive(gltf, primitive, X, mesh);
  }
  if (has_skin) notes.emplace_back("took the mesh at rest: its skin is not moved");
  if (has_targets) notes.emplace_back("took the mesh at rest: its morph targets are not added");
  if (!mesh.has_faces()) gltf.fail("has no triangles");
  return mesh.mesh();
}

}  // namespace

TriangleMesh parse_gltf(std::string_view bytes, const fs::path& file, std::vector<std::string>& notes) try {
  Gltf gltf{file, {}, {}};
  std::string store;
  std::pair<std::string_view, std::string_view> chunks;
  if (bytes.starts_with("glTF")) {
    chunks = chunks_of(gltf, bytes);
  } else {
    chunks.first = plain_text(bytes, file, store);
  }
  try {
    gltf.root = json::parse(chunks.first);
  } catch (const json::parse_error& error) {
    gltf.fail("is no glTF file: its JSON is broken at byte " + std::to_string(error.byte));
  }
  if (!gltf.root.is_object() || !gltf.root.contains("asset")) gltf.fail("is no glTF file");
  if (!gltf.root.at("asset").value("version", "").starts_with("2")) gltf.fail("is glTF of another version than 2.0");
  check_extensions(gltf);
  if (gltf.root.contains("buffers")) {
    for (const json& buffer : gltf.root.at("buffers")) {
      // Only the first one is that of a .glb.
      gltf.buffers.push_back(read_buffer(gltf, buffer, gltf.buffers.empty() ? chunks.second : std::string_view()));
    }
  }
  return mesh_of(gltf, notes);
} catch (const json::exception& error) {
  throw FileError(file, "is broken: " + printable(error.what()));
}

}  // namespace thenar
