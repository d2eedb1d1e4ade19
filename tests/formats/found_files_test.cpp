// SPDX-License-Identifier: Apache-2.0
// One solid, as the files of many programs hold it: its volume and centroid are those of the formulas.
#include <gtest/gtest.h>

#include <cctype>
#include <functional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "collision/enclosed_solid.h"
#include "engine/formats/files.h"
#include "engine/formats/mesh_file.h"

namespace thenar::found_files_test {
namespace {

using Eigen::Vector3d;

using Face = std::vector<int>;

/// A block that becomes narrower upwards: 44 x 36 at z = 0, from (4, 2) on 22 x 18 at z = 60.
std::vector<Vector3d> corners() {
  return {{0, 0, 0}, {44, 0, 0}, {44, 36, 0}, {0, 36, 0}, {4, 2, 60}, {26, 2, 60}, {26, 20, 60}, {4, 20, 60}};
}
const std::vector<Face> kFaces = {{3, 2, 1, 0}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};

/// Its volume and first moment, by Simpson's rule, which is exact for cubics: of the sections at s = z/60.
std::pair<double, Vector3d> solid() {
  double volume = 0.0;
  Vector3d moment = Vector3d::Zero();
  for (const auto& [s, weight] : {std::pair(0.0, 10.0), std::pair(0.5, 40.0), std::pair(1.0, 10.0)}) {
    const double wide = 44.0 - 22.0 * s, deep = 36.0 - 18.0 * s;
    volume += weight * wide * deep;
    moment += weight * wide * deep * Vector3d(4.0 * s + 0.5 * wide, 2.0 * s + 0.5 * deep, 60.0 * s);
  }
  return {volume, moment / volume};
}

std::string row(const Vector3d& v) {
  std::ostringstream text;
  text << v.x() << ' ' << v.y() << ' ' << v.z();
  return text.str();
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
  return text;
}

std::string obj(const std::function<std::string(int)>& after_vertex, const std::string& after_corner) {
  std::string text;
  for (int i = 0; i < 8; ++i) text += "v " + row(corners()[i]) + after_vertex(i) + "\n";
  for (const Face& face : kFaces) {
    text += "f";
    for (const int i : face) text += " " + std::to_string(i + 1) + after_corner;
    text += "\n";
  }
  return text;
}
std::string obj() {
  return obj([](int) { return ""; }, "");
}

/// The lines of OFF and PLY, each with something behind it.
std::string vertices(const std::string& after = "", const std::string& before = "") {
  std::string text;
  for (const Vector3d& v : corners()) text += before + row(v) + after + "\n";
  return text;
}
std::string faces(const std::string& before = "", const std::string& after = "") {
  std::string text;
  for (const Face& face : kFaces) {
    text += before + "4";
    for (const int i : face) text += " " + std::to_string(i);
    text += after + "\n";
  }
  return text;
}

std::string stl() {
  std::string text = "solid block\n";
  for (const Face& f : kFaces) {
    for (const Face& t : {Face{f[0], f[1], f[2]}, Face{f[0], f[2], f[3]}}) {
      text += "facet normal 0 0 0\nouter loop\n";
      for (const int i : t) text += "vertex " + row(corners()[i]) + "\n";
      text += "endloop\nendfacet\n";
    }
  }
  return text + "endsolid block\n";
}

std::string ply(const std::string& vertex_lists, const std::string& face_properties, const std::string& rows) {
  return "ply\nformat ascii 1.0\ncomment by m\xC3\xBCller\nobj_info num_cols 512\nelement vertex 8\n" + vertex_lists +
         "property double X\nproperty double y\nproperty double z\nelement face 6\n" + face_properties +
         "end_header\n" + rows;
}
const std::string kIndices = "property list uchar int vertex_indices\n";

struct Found {
  std::string what, name, bytes;
};

std::vector<Found> found_files() {
  const std::string off = "8 6 12\n" + vertices() + faces();
  const std::string split = replaced(stl(), "endsolid", "end solid");
  return {
      {"colours of three numbers", "a.obj", obj([](int i) { return " 0." + std::to_string(i) + " 0.5 1"; }, "")},
      {"colours with opacity", "a.obj", obj([](int i) { return " 0." + std::to_string(i) + "5 0.5 1 1"; }, "")},
      {"weights of 1", "a.obj", obj([](int) { return " 1"; }, "")},
      {"groups, materials, normals", "a.obj",
       "mtllib none.mtl\no a\ng a b\ns 1\nvn 0 0 1\nusemtl m\n" + obj([](int) { return ""; }, "//1")},
      {"points, lines and edges", "a.obj", obj() + "p 1 2\nl 1 2 3\nf 1 2\nf 3\n"},
      {"vertices that no face has", "a.obj", obj() + "v 1e5 0 0\nv 0 -1e4 0\n"},
      {"Latin letters", "a.obj",
       "# St\xFC"
       "ck\n" +
           obj()},
      {"facets in one line each", "a.stl",
       replaced(replaced(replaced(stl(), "\nouter", " outer"), "\nvertex", " vertex"), "\nend", " end")},
      {"all in one line", "a.stl", replaced(stl(), "\n", " ")},
      {"end loop, end facet, end solid", "a.stl",
       replaced(replaced(split, "endloop", "end loop"), "endfacet", "END FACET")},
      {"keywords in the name", "a.stl", replaced(stl(), "block", "vertex 3 facet endfacet")},
      {"two solids", "a.stl", replaced(stl(), "endfacet\n", "endfacet\nendsolid\nsolid\n")},
      {"a number in each line", "a.off", "OFF\n" + replaced(off, "8 6 12\n", "8\n6\n12\n")},
      {"the numbers without edges", "a.off", "OFF\n" + replaced(off, "8 6 12\n", "8 6\n")},
      {"the numbers behind the name", "a.off", "OFF" + off},
      {"textures, colours and normals", "a.off", "STCNOFF\n8 6 12\n" + vertices(" 0 0 1 9 9 9 255 0 0") + faces()},
      {"colours of faces", "a.off", "OFF\n8 6 12\n" + vertices() + faces("", " 0.8 0.1 0.1 1")},
      {"edges and points as faces", "a.off", "OFF\n8 8 12\n" + vertices() + faces() + "2 0 1\n1 3\n"},
      {"lists of vertices", "a.ply",
       ply("property list uchar float w\n", kIndices, vertices("", "2 0.5 0.5 ") + faces())},
      {"lists of textures before the corners", "a.ply",
       ply("", "property list uchar float texcoord\n" + kIndices, vertices() + faces("2 0.5 0.5 "))},
      {"textures, colours and flags of faces", "a.ply",
       ply("", kIndices + "property list uchar float texcoord\nproperty int texnumber\nproperty uchar red\n",
           vertices() + faces("", " 2 0 1 3 255"))},
      {"faces without corners", "a.ply",
       replaced(ply("", kIndices, vertices() + faces() + "0\n2 0 1\n"), "face 6", "face 8")},
      {"a camera", "a.ply",
       replaced(ply("", kIndices, "1 2\n" + vertices() + faces()), "element vertex",
                "element camera 1\nproperty float view_px\nproperty float view_py\nelement vertex")},
  };
}

class FoundFiles : public testing::TestWithParam<Found> {};

TEST_P(FoundFiles, HoldTheirSolid) {
  std::vector<std::string> notes;
  TriangleMesh mesh = parse_mesh(GetParam().bytes, GetParam().name, notes);
  mend_mesh(mesh, GetParam().name, notes);
  const EnclosedSolid read = enclosed_solid(mesh);
  const auto [volume, centroid] = solid();
  EXPECT_NEAR(read.volume_m3, volume, 1e-9 * volume);
  EXPECT_LT((read.centroid_m - centroid).norm(), 1e-9 * 60);
}

INSTANTIATE_TEST_SUITE_P(Kinds, FoundFiles, testing::ValuesIn(found_files()), [](const auto& found) {
  std::string name = found.param.name.substr(2) + "_" + found.param.what;
  for (char& letter : name) letter = std::isalnum(static_cast<unsigned char>(letter)) != 0 ? letter : '_';
  return name;
});

// Refusals that say what is wrong, and what would mend it.
TEST(FoundFileRefusals, NameARemedy) {
  const auto fault_of = [](const std::string& bytes, const std::string& name) -> std::string {
    try {
      std::vector<std::string> notes;
      (void)parse_mesh(bytes, name, notes);
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(fault_of(replaced(obj(), "v 44 0 0", "v 44,5 0 0"), "a.obj"),
            "a.obj: line 2: '44,5' is not a number: write a point in place of the comma");
  EXPECT_EQ(fault_of("v 0 0 0\ncstype bspline\ndeg 3 3\nsurf 0 1 0 1 1\nend\n", "a.obj"),
            "a.obj: has no faces, but curves or surfaces of free form, which are not read: save it as a mesh");
}

}  // namespace
}  // namespace thenar::found_files_test
