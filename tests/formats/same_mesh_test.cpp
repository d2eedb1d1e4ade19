// SPDX-License-Identifier: Apache-2.0
// One mesh in every format is one surface: to the last bit, for the vertices here are numbers of single precision.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "engine/formats/files.h"
#include "engine/formats/mesh_file.h"
#include "engine/formats/point_cloud_file.h"

namespace thenar::same_mesh_test {
namespace {

using Eigen::Vector3d;

struct Polygons {
  std::vector<Vector3d> vertices;
  std::vector<std::vector<int>> faces;
};

/// A lumpy ball of rings of triangles between two polygons of many corners; its radius is random.
Polygons lumpy_ball(unsigned seed) {
  std::mt19937 random(seed);
  const int sides = 5 + static_cast<int>(random() % 9), rings = 4;
  Polygons ball;
  for (int ring = 0; ring < rings; ++ring) {
    const double z = -0.6 + 0.4 * ring;
    for (int i = 0; i < sides; ++i) {
      // The ends are plane and convex.
      const bool is_end = ring == 0 || ring == rings - 1;
      const double r = is_end ? 0.7 : 0.8 + 0.4 * static_cast<double>(random() % 1000) / 1000.0;
      const double turn = 2.0 * std::numbers::pi * (i + 0.5 * ring) / sides;
      const auto single = [](double x) { return static_cast<double>(static_cast<float>(0.05 * x)); };
      ball.vertices.emplace_back(single(r * std::cos(turn)), single(r * std::sin(turn)), single(z));
    }
  }
  const auto at = [&](int ring, int i) { return ring * sides + i % sides; };
  std::vector<int> low, high;
  for (int i = 0; i < sides; ++i) {
    low.insert(low.begin(), at(0, i));
    high.push_back(at(rings - 1, i));
    for (int ring = 0; ring + 1 < rings; ++ring) {
      ball.faces.push_back({at(ring, i), at(ring, i + 1), at(ring + 1, i)});
      ball.faces.push_back({at(ring, i + 1), at(ring + 1, i + 1), at(ring + 1, i)});
    }
  }
  ball.faces.push_back(low);
  ball.faces.push_back(high);
  return ball;
}

std::string word(double x) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.17g", x);
  return text.data();
}

std::string row(const Vector3d& v) { return word(v.x()) + " " + word(v.y()) + " " + word(v.z()) + "\n"; }

std::string obj_text(const Polygons& mesh) {
  std::string text;
  for (const Vector3d& v : mesh.vertices) text += "v " + row(v);
  for (const auto& face : mesh.faces) {
    text += "f";
    for (const int i : face) text += " " + std::to_string(i + 1) + "//1";
    text += "\n";
  }
  return text;
}

std::string off_text(const Polygons& mesh) {
  std::string text = "OFF\n" + std::to_string(mesh.vertices.size()) + " " + std::to_string(mesh.faces.size()) + " 0\n";
  for (const Vector3d& v : mesh.vertices) text += row(v);
  for (const auto& face : mesh.faces) {
    text += std::to_string(face.size());
    for (const int i : face) text += " " + std::to_string(i);
    text += "\n";
  }
  return text;
}

template <typename Number>
void append(std::string& bytes, Number number, bool is_big = false) {
  std::array<char, sizeof number> raw;
  std::memcpy(raw.data(), &number, sizeof number);
  if (is_big) std::ranges::reverse(raw);
  bytes.append(raw.data(), raw.size());
}

template <typename Length, typename Item>
std::string ply(const Polygons& mesh, const std::string& format, const std::string& types) {
  std::string bytes = "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(mesh.vertices.size()) +
                      "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nelement face " +
                      std::to_string(mesh.faces.size()) + "\nproperty list " + types + " vertex_indices\nend_header\n";
  const bool is_text = format == "ascii", is_big = format == "binary_big_endian";
  for (const Vector3d& v : mesh.vertices) {
    if (is_text) {
      bytes += row(v).substr(0, row(v).size() - 1) + " 255\n";
      continue;
    }
    for (const double x : v) append(bytes, static_cast<float>(x), is_big);
    bytes += '\xFF';
  }
  for (const auto& face : mesh.faces) {
    if (is_text) bytes += std::to_string(face.size());
    if (!is_text) append(bytes, static_cast<Length>(face.size()), is_big);
    for (const int i : face) {
      if (is_text) bytes += " " + std::to_string(i);
      if (!is_text) append(bytes, static_cast<Item>(i), is_big);
    }
    if (is_text) bytes += "\n";
  }
  return bytes;
}

PointCloud sampled(const std::string& bytes, const std::string& name) {
  std::vector<std::string> notes;
  PointCloud cloud = parse_cloud(bytes, name, {.unit_m = 1.0, .samples = 300}, notes);
  EXPECT_TRUE(notes.empty()) << name << ": " << notes.front();
  return cloud;
}

/// The triangles that a mesh is read as, in single precision.
std::string stl_binary(const TriangleMesh& mesh) {
  std::string bytes(80, ' ');
  append(bytes, static_cast<std::uint32_t>(mesh.triangles.cols()));
  for (const auto t : mesh.triangles.colwise()) {
    for (int k = 0; k < 3; ++k) append(bytes, 0.0F);
    for (const int i : t) {
      for (const double x : mesh.vertices_m.col(i)) append(bytes, static_cast<float>(x));
    }
    append(bytes, std::uint16_t{0});
  }
  return bytes;
}

std::string stl_text(const TriangleMesh& mesh) {
  std::string text = "solid\n";
  for (const auto t : mesh.triangles.colwise()) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const int i : t) text += "vertex " + row(mesh.vertices_m.col(i));
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid\n";
}

std::string base64(const std::string& bytes) {
  constexpr const char* kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned bits = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      bits = bits << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : kLetters[bits >> (18 - 6 * k) & 63U];
  }
  return text;
}

/// The buffer and the text of a glTF file, in which nodes turn and move the mesh back to where it is.
struct Gltf {
  std::string buffer, text;
};

Gltf gltf(const TriangleMesh& mesh, const std::string& uri) {
  Gltf file;
  const auto triangles = static_cast<std::size_t>(mesh.triangles.size());
  for (const int i : mesh.triangles.reshaped()) append(file.buffer, static_cast<std::uint16_t>(i));
  while (file.buffer.size() % 4 != 0) file.buffer += '\0';
  const std::size_t vertices_at = file.buffer.size();
  // y = -x', x = y' of the file, so that a quarter turn about z makes x and y of it; twice as large.
  for (const auto v : mesh.vertices_m.colwise()) {
    for (const double x : {2.0 * v.y(), -2.0 * v.x(), 2.0 * v.z() - 1.0}) append(file.buffer, static_cast<float>(x));
  }
  const std::string size = std::to_string(file.buffer.size());
  const std::string where =
      uri.empty() ? ""
                  : ", \"uri\": \"" +
                        (uri == "data" ? "data:application/octet-stream;base64," + base64(file.buffer) : uri) + "\"";
  file.text = R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [1]}], "nodes": [)"
              R"({"mesh": 0, "translation": [0, 0, 1]},)"
              R"({"children": [0], "scale": [0.5, 0.5, 0.5],)"
              R"("rotation": [0, 0, 0.70710678118654757, 0.70710678118654757]}],)"
              R"("meshes": [{"primitives": [{"attributes": {"POSITION": 1}, "indices": 0}]}],)"
              R"("buffers": [{"byteLength": )" +
              size + where + R"(}], "bufferViews": [{"buffer": 0, "byteLength": )" + size +
              R"(}, {"buffer": 0, "byteOffset": )" + std::to_string(vertices_at) + R"(, "byteLength": )" +
              std::to_string(file.buffer.size() - vertices_at) +
              R"(}], "accessors": [)"
              R"({"bufferView": 0, "componentType": 5123, "type": "SCALAR", "count": )" +
              std::to_string(triangles) + R"(}, {"bufferView": 1, "componentType": 5126, "type": "VEC3", "count": )" +
              std::to_string(mesh.vertices_m.cols()) + "}]}";
  return file;
}

std::string glb(Gltf file) {
  while (file.text.size() % 4 != 0) file.text += ' ';
  std::string bytes = "glTF";
  append(bytes, std::uint32_t{2});
  append(bytes, static_cast<std::uint32_t>(28 + file.text.size() + file.buffer.size()));
  append(bytes, static_cast<std::uint32_t>(file.text.size()));
  bytes += "JSON" + file.text;
  append(bytes, static_cast<std::uint32_t>(file.buffer.size()));
  return bytes + std::string("BIN\0", 4) + file.buffer;
}

TEST(SameMesh, IsOneSurfaceInEveryFormat) {
  for (unsigned seed = 1; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    const Polygons ball = lumpy_ball(seed);
    const PointCloud wanted = sampled(obj_text(ball), "ball.obj");
    std::vector<std::string> notes;
    const TriangleMesh mesh = parse_mesh(obj_text(ball), "ball.obj", notes);
    const std::vector<std::pair<std::string, std::string>> files = {
        {off_text(ball), "ball.off"},
        {ply<int, int>(ball, "ascii", "uchar int"), "ball.ply"},
        {ply<std::uint8_t, std::int32_t>(ball, "binary_little_endian", "uchar int"), "ball.ply"},
        {ply<std::uint8_t, std::int32_t>(ball, "binary_big_endian", "uchar int"), "ball.ply"},
        {ply<std::int32_t, std::uint8_t>(ball, "binary_big_endian", "int32 uint8"), "ball.ply"},
        {ply<std::uint16_t, std::uint32_t>(ball, "binary_little_endian", "ushort uint"), "ball.ply"},
        {ply<std::int8_t, std::int16_t>(ball, "binary_little_endian", "char short"), "ball.ply"},
        {stl_binary(mesh), "ball.stl"},
        {stl_text(mesh), "ball.stl"}};
    for (const auto& [bytes, name] : files) {
      const PointCloud cloud = sampled(bytes, name);
      EXPECT_TRUE(cloud.points_m == wanted.points_m && cloud.normals == wanted.normals) << name;
    }
    for (const auto& [bytes, name] : std::vector<std::pair<std::string, std::string>>{
             {glb(gltf(mesh, "")), "ball.glb"}, {gltf(mesh, "data").text, "ball.gltf"}}) {
      const PointCloud cloud = sampled(bytes, name);
      EXPECT_LT((cloud.points_m - wanted.points_m).cwiseAbs().maxCoeff(), 1e-6) << name;  // moved in single precision
      EXPECT_LT((cloud.normals - wanted.normals).cwiseAbs().maxCoeff(), 1e-4) << name;
    }
  }
}

std::string fault_of(const std::string& bytes, const std::string& name) {
  try {
    std::vector<std::string> notes;
    (void)parse_mesh(bytes, name, notes);
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

TEST(SameMesh, RefusesBrokenGltf) {
  std::vector<std::string> notes;
  const TriangleMesh mesh = parse_mesh(obj_text(lumpy_ball(1)), "ball.obj", notes);
  const std::string whole = glb(gltf(mesh, "")), text = gltf(mesh, "data").text;
  EXPECT_EQ(fault_of(whole, "a.glb"), "");
  for (std::size_t length = 0; length < whole.size(); ++length) {
    EXPECT_NE(fault_of(whole.substr(0, length), "a.glb"), "") << length;
  }
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    EXPECT_NE(changed.find(from), std::string::npos) << from;
    return fault_of(changed.replace(changed.find(from), from.size(), to), "a.gltf");
  };
  EXPECT_EQ(with("\"version\": \"2.0\"", "\"version\": \"1.0\""), "a.gltf: is glTF of another version than 2.0");
  EXPECT_EQ(with("\"children\": [0]", "\"children\": [1]"), "a.gltf: node 1 is below two others");
  EXPECT_EQ(with("\"children\": [0]", "\"children\": [7]"), "a.gltf: nodes has no item 7");
  EXPECT_EQ(with("\"indices\": 0", "\"indices\": 0, \"mode\": 1"), "a.gltf: has no triangles");
  EXPECT_EQ(with("5123", "5121"), "");  // The bytes of small numbers are numbers, of another mesh.
  EXPECT_EQ(with("\"SCALAR\", \"count\": ", "\"SCALAR\", \"count\": 9"),
            "a.gltf: accessor 0: the file is truncated: its buffer ends before it");
  EXPECT_EQ(with("data:application/octet-stream;base64,", "https://somewhere/"),
            "a.gltf: has a buffer elsewhere: https://somewhere/" + text.substr(text.find("base64,") + 7, 0) +
                base64(gltf(mesh, "").buffer));
  EXPECT_EQ(with("\"indices\": 0", "\"indices\": 0, \"extensions\": {\"KHR_draco_mesh_compression\": {}}"),
            "a.gltf: is compressed (KHR_draco_mesh_compression): save it without");
  // gltfpack packs the numbers, and leaves a buffer without any.
  const std::string version = "\"version\": \"2.0\"}";
  EXPECT_EQ(with(version, version + ", \"extensionsRequired\": [\"EXT_meshopt_compression\"]"),
            "a.gltf: is compressed (EXT_meshopt_compression): save it without");
  EXPECT_EQ(with(version, version + ", \"extensionsRequired\": [\"KHR_materials_unlit\"]"), "");
  // Only the first buffer is that of the file itself: others would be as many copies of it.
  Gltf second = gltf(mesh, "");
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
           {"\"buffers\": [", "\"buffers\": [{\"byteLength\": 9}, "}, {"{\"buffer\": 0", "{\"buffer\": 1"}}) {
    second.text.replace(second.text.find(from), from.size(), to);
  }
  EXPECT_EQ(fault_of(glb(second), "a.glb"), "a.glb: accessor 0: the file is truncated: its buffer ends before it");
  EXPECT_TRUE(with(version, version + ", \"extensionsUsed\": [\"EXT_mesh_gpu_instancing\"]")
                  .starts_with("a.gltf: has copies of meshes"));
  // Counts and indexes are whole numbers, of any spelling.
  EXPECT_EQ(with("\"POSITION\": 1", "\"POSITION\": 1.0"), "");
  for (const char* const wrong : {"\"one\"", "-1", "0.5", "1e126", "[1]", "null"}) {
    EXPECT_EQ(with("\"POSITION\": 1", std::string("\"POSITION\": ") + wrong), "a.gltf: POSITION is no whole number");
    EXPECT_EQ(with("\"children\": [0]", std::string("\"children\": [") + wrong + "]"),
              "a.gltf: children is no whole number");
    EXPECT_EQ(with("\"indices\": 0", std::string("\"indices\": 0, \"mode\": ") + wrong),
              "a.gltf: mode is no whole number");
  }
  EXPECT_EQ(with("\"indices\": 0", "\"indices\": 1e300"), "a.gltf: indices is no whole number");
  EXPECT_EQ(fault_of("{", "a.gltf"), "a.gltf: is no glTF file: its JSON is broken at byte 2");
}

}  // namespace
}  // namespace thenar::same_mesh_test
