// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/mesh_file.h"

#include <gtest/gtest.h>

#include <array>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "engine/formats/files.h"

namespace thenar::mesh_file_test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

// A box of 40 x 60 x 80 mm as its corners and its faces, counter-clockwise from outside.
constexpr std::array<std::array<int, 4>, 6> kFaces = {
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

Vector3d corner(int i) { return Vector3d(i & 1, i >> 1 & 1, i >> 2 & 1).cwiseProduct(Vector3d(40, 60, 80)); }

std::string text(const Vector3d& v) {
  return std::to_string(v.x()) + " " + std::to_string(v.y()) + " " + std::to_string(v.z());
}

std::string off_box() {
  std::string file = "OFF\n# made by hand\n8 6 12\n";
  for (int i = 0; i < 8; ++i) file += text(corner(i)) + "\n";
  for (const auto& face : kFaces) {
    file += "4";
    for (const int i : face) file += " " + std::to_string(i);
    file += "\n";
  }
  return file;
}

std::string obj_box(std::size_t faces = 6) {
  std::string file = "# made by hand\nmtllib none.mtl\no box\n";
  for (int i = 0; i < 8; ++i) file += "v " + text(corner(i)) + "\n";
  for (std::size_t k = 0; k < faces; ++k) {
    file += "f";
    for (const int i : kFaces.at(k)) file += " " + std::to_string(i + 1);
    file += "\n";
  }
  return file;
}

std::vector<std::array<int, 3>> triangles() {
  std::vector<std::array<int, 3>> all;
  for (const auto& face : kFaces) {
    all.push_back({face[0], face[1], face[2]});
    all.push_back({face[0], face[2], face[3]});
  }
  return all;
}

std::string stl_text_box() {
  std::string file = "solid box\n";
  for (const auto& triangle : triangles()) {
    file += "facet normal 0 0 0\nouter loop\n";
    for (const int i : triangle) file += "vertex " + text(corner(i)) + "\n";
    file += "endloop\nendfacet\n";
  }
  return file + "endsolid box\n";
}

std::string stl_binary_box() {
  std::string file(80, ' ');
  const auto append = [&](const auto& value) {
    std::array<char, sizeof value> raw;
    std::memcpy(raw.data(), &value, sizeof value);
    file.append(raw.data(), raw.size());
  };
  append(std::uint32_t{12});
  for (const auto& triangle : triangles()) {
    for (int k = 0; k < 3; ++k) append(0.0F);
    for (const int i : triangle) {
      for (const double x : corner(i)) append(static_cast<float>(x));
    }
    append(std::uint16_t{0});
  }
  return file;
}

struct Outcome {
  PointCloud cloud;
  std::vector<std::string> notes;
  std::string fault;
};

Outcome read(const std::string& bytes, const std::string& name) {
  Outcome outcome;
  try {
    TriangleMesh mesh = parse_mesh(bytes, name, outcome.notes);
    mend_mesh(mesh, name, outcome.notes);
    outcome.cloud = sample_mended_mesh(mesh, name, 600, outcome.notes);
  } catch (const FileError& error) {
    outcome.fault = error.what();
  }
  return outcome;
}

TEST(MeshFile, SamplesTheSameBoxFromEveryFormat) {
  for (const auto& [bytes, name] : std::vector<std::pair<std::string, std::string>>{{off_box(), "box.off"},
                                                                                    {obj_box(), "box.OBJ"},
                                                                                    {stl_text_box(), "box.stl"},
                                                                                    {stl_binary_box(), "box.stl"}}) {
    SCOPED_TRACE(name);
    const Outcome box = read(bytes, name);
    ASSERT_EQ(box.fault, "");
    EXPECT_TRUE(box.notes.empty()) << box.notes[0];
    ASSERT_EQ(box.cloud.points_m.cols(), 600);
    for (Index i = 0; i < 600; ++i) {
      Index axis = 0;
      ASSERT_EQ(box.cloud.normals.col(i).cwiseAbs().maxCoeff(&axis), 1.0);
      ASSERT_EQ(box.cloud.points_m(axis, i), box.cloud.normals(axis, i) > 0.0 ? corner(7)[axis] : 0.0);
    }
  }
}

TEST(MeshFile, TurnsFacesAndSaysSo) {
  std::string bytes = obj_box(5);
  bytes += "f 7 8 6 5\n";  // the last face the other way round
  const Outcome box = read(bytes, "box.obj");
  ASSERT_EQ(box.fault, "");
  ASSERT_EQ(box.notes.size(), 1U);
  EXPECT_EQ(box.notes[0], "turned 2 faces of 12, wound the other way");
  for (Index i = 0; i < 600; ++i) {
    const Vector3d from_centre = box.cloud.points_m.col(i) - 0.5 * corner(7);
    EXPECT_GT(box.cloud.normals.col(i).dot(from_centre), 0.0);
  }
}

TEST(MeshFile, RefusesWhatIsNoClosedSurface) {
  EXPECT_EQ(read(obj_box(5), "box.obj").fault,
            "box.obj: is no closed surface: 24 % of its edges have a face on one side only; close its holes, and give "
            "sheets a thickness");
  EXPECT_EQ(read(obj_box(0), "box.obj").fault,
            "box.obj: has no faces; points alone are read from .ply, .xyz and .pcd files");
  EXPECT_EQ(read("o box\n", "box.obj").fault,
            "box.obj: has neither vertices nor faces: it is another kind of file than its name says");
  EXPECT_EQ(read("OFF\n3 1 3\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n", "flat.off").fault, "flat.off: its faces have no area");
  EXPECT_EQ(read("OFF\n4 1 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n\n3 0 1 3\n", "two.off").fault,
            "two.off: line 9: is a face beyond those that the head counts: 1");
}

TEST(MeshFile, RefusesSizesBeyondNumbers) {
  for (const char* size : {"1e-300", "1e200", "1e308"}) {
    std::string bytes = "OFF\n4 4 6\n0 0 0\n";
    for (const std::string& vertex :
         {size + std::string(" 0 0"), "0 " + std::string(size) + " 0", "0 0 " + std::string(size)}) {
      bytes += vertex + "\n";
    }
    EXPECT_NE(read(bytes + "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n", "a.off").fault, "") << size;
  }
}

TEST(MeshFile, RefusesBrokenFiles) {
  const auto off = [](const std::string& from, const std::string& to) {
    std::string bytes = off_box();
    return read(bytes.replace(bytes.find(from), from.size(), to), "box.off").fault;
  };
  EXPECT_EQ(read("", "box.off").fault, "box.off: is no OFF file: it does not begin with 'OFF'");
  EXPECT_EQ(read("solid\n", "box.off").fault, "box.off: is no OFF file: it does not begin with 'OFF'");
  EXPECT_EQ(read("OFF\n", "box.off").fault, "box.off: line 1: the file is truncated: it ends here");
  EXPECT_EQ(off("8 6 12", "4000000000 6 12"),
            "box.off: the file is truncated: it cannot hold 4000000000 vertices and 6 faces");
  EXPECT_EQ(off("8 6 12", "8 7 12"), "box.off: line 17: the file is truncated: it ends here");
  EXPECT_EQ(off("8 6 12", "-8 6 12"), "box.off: line 3: '-8' is not a whole number");
  EXPECT_EQ(off("8 6 12", "8"), "box.off: line 4: '0.000000' is not a whole number");
  EXPECT_EQ(off("4 0 4 6 2", "4 0 4 6 8"), "box.off: line 12: there is no vertex 8");
  EXPECT_EQ(off("4 0 4 6 2", "5 0 4 6 2"), "box.off: line 12: has fewer corners than it says");
  EXPECT_EQ(off("0.000000 0.000000", "0.000000 nan"), "box.off: line 4: 'nan' is not finite: leave such points out");
  const auto obj = [](const std::string& line) { return read(obj_box() + line, "box.obj").fault; };
  EXPECT_EQ(obj("v 1 2\n"), "box.obj: line 18: a vertex needs three coordinates");
  EXPECT_EQ(obj("v 1 2 x\n"), "box.obj: line 18: 'x' is not a number");
  EXPECT_EQ(obj("f 1 2 9\n"), "box.obj: line 18: there is no vertex 9");
  EXPECT_EQ(obj("f 1 2 0\n"), "box.obj: line 18: there is no vertex 0");
  EXPECT_EQ(obj("f 1 2 -9\n"), "box.obj: line 18: there is no vertex -9");
  EXPECT_EQ(obj("v 1 2 3 0\n"), "box.obj: line 18: the fourth coordinate, a weight that divides the others, is 0");
  EXPECT_EQ(obj("f 1 2 3 4 1 2 3 4\n"),
            "box.obj: line 18: a face goes round more than once: from its corner 1 to 2 twice");
  EXPECT_EQ(read("garbage", "box.stl").fault,
            "box.stl: is no STL file: a text begins with 'solid', and a binary file is longer");
  EXPECT_EQ(read(stl_binary_box() + std::string(50, 'x'), "box.stl").fault,
            "box.stl: is no text, which begins with 'solid', and its header says that it has 12 facets, where it has "
            "13: is it whole? Save or download it again");
  EXPECT_EQ(read("solid\nvertex 0 0 0\nendfacet\n", "box.stl").fault,
            "box.stl: line 3: a facet must have three vertices, has 1");
  std::string binary = stl_binary_box();
  const float infinite = std::numeric_limits<float>::infinity();
  std::memcpy(binary.data() + 84 + 50 + 12, &infinite, sizeof infinite);
  EXPECT_EQ(read(binary, "box.stl").fault, "box.stl: byte 184: the facet before this has a vertex that is not finite");
}

TEST(MeshFile, ReadsCornersOfEveryKind) {
  // Textures, normals, counting from the end, and a number of vertices in the first line.
  const std::string vertices = "v 0 0 0 1\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0\nv 0 0 1\n";
  std::vector<std::string> notes;
  const TriangleMesh obj =
      parse_mesh(vertices + "f 1/1 3/2 2/3\nf 1//1 2//1 -1//1\nf -4 -1 -2\nf 2 3 4\n", "a.obj", notes);
  EXPECT_EQ(obj.triangles.col(0), Eigen::Vector3i(0, 2, 1));
  EXPECT_EQ(obj.triangles.col(1), Eigen::Vector3i(0, 1, 3));
  EXPECT_EQ(obj.triangles.col(2), Eigen::Vector3i(0, 3, 2));
  const TriangleMesh off =
      parse_mesh("COFF 3 1 0\n0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n3 0 1 2 9 9 9\n", "a.off", notes);
  EXPECT_EQ(off.triangles.col(0), Eigen::Vector3i(0, 1, 2));
  EXPECT_EQ(off.vertices_m.col(2), Vector3d(0, 1, 0));
}

TEST(MeshFile, RefusesEveryTruncation) {
  // With the number of bytes at the end that nobody misses: a line's end, and the name after 'endsolid'.
  struct Case {
    std::string bytes, name;
    std::size_t spare;
  };
  for (const auto& [bytes, name, spare] : {Case{off_box(), "box.off", 1}, Case{obj_box(), "box.obj", 1},
                                           Case{stl_text_box(), "box.stl", 5}, Case{stl_binary_box(), "box.stl", 0}}) {
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      const Outcome outcome = read(bytes.substr(0, length), name);
      EXPECT_EQ(outcome.fault.empty(), length + spare >= bytes.size()) << name << " of " << length << " bytes";
    }
  }
}

/// The bytes of a text in UTF-16, with or without its mark.
std::string utf16(const std::string& text, bool is_big, bool has_mark) {
  std::string bytes = !has_mark ? "" : is_big ? "\xFE\xFF" : "\xFF\xFE";
  for (const char letter : text) {
    if (is_big) bytes += '\0';
    bytes += letter;
    if (!is_big) bytes += '\0';
  }
  return bytes;
}

std::string upper_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(c));
  return text;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
  return text;
}

// The same box, as programs write it in other ways.
TEST(MeshFile, ReadsWhatOtherReadersRead) {
  std::vector<std::pair<std::string, std::string>> files;
  for (const auto& [text, name] : std::vector<std::pair<std::string, std::string>>{
           {off_box(), "box.off"}, {obj_box(), "box.obj"}, {stl_text_box(), "box.stl"}}) {
    files.emplace_back("\xEF\xBB\xBF" + text, name);
    files.emplace_back(utf16(text, false, true), name);
    files.emplace_back(utf16(text, true, true), name);
    files.emplace_back(utf16(text, false, false), name);
    files.emplace_back(utf16(text, true, false), name);
    files.emplace_back(replaced(text, "\n", "\r"), name);
    files.emplace_back(replaced(text, "\n", "\r\n"), name);
    files.emplace_back(replaced(text, "\n", "\r\r\n"), name);
    files.emplace_back(text.substr(0, text.size() - 1), name);
    files.emplace_back(upper_case(text), name);
    files.emplace_back("\n \t" + text, name);
    files.emplace_back(replaced(text, "80.000000", "+8.0E+01"), name);
    files.emplace_back(text + std::string(100, '\0'), name);
  }
  files.emplace_back(stl_binary_box() + "\n", "box.stl");
  files.emplace_back(stl_binary_box() + std::string(49, 'x'), "box.stl");
  files.emplace_back("solid" + stl_binary_box().substr(5) + "x", "box.stl");
  files.emplace_back(replaced(obj_box(), "f 1 5 7 3", "f 1 5 \\\n7 \\\r\n 3"), "box.obj");
  files.emplace_back(replaced(off_box(), "OFF\n# made by hand\n", ""), "box.off");
  files.emplace_back(replaced(off_box(), "OFF\n# made by hand\n", "OFF"), "box.off");
  for (const auto& [bytes, name] : files) {
    SCOPED_TRACE(name + " that begins with " + bytes.substr(0, 20) + " and has " + std::to_string(bytes.size()));
    const Outcome box = read(bytes, name);
    ASSERT_EQ(box.fault, "");
    ASSERT_EQ(box.cloud.points_m.cols(), 600);
    const std::string plain = name == "box.off" ? off_box() : name == "box.obj" ? obj_box() : stl_text_box();
    EXPECT_TRUE(box.cloud.points_m == read(plain, name).cloud.points_m);
  }
  EXPECT_EQ(read(stl_binary_box() + "xy", "box.stl").notes.at(0), "passed over 2 bytes behind the last facet");
}

TEST(MeshFile, DividesByAFourthCoordinate) {
  std::string obj, off = "4OFF\n8 6 12\n";
  for (int i = 0; i < 8; ++i) {
    const double w = i % 2 == 0 ? 2.0 : 0.5;
    obj += "v " + text(w * corner(i)) + " " + std::to_string(w) + "\n";
    off += text(w * corner(i)) + " " + std::to_string(w) + "\n";
  }
  const std::string plain = obj_box();
  const Outcome divided = read(obj + plain.substr(plain.find("f ")), "box.obj");
  EXPECT_TRUE(divided.cloud.points_m == read(plain, "box.obj").cloud.points_m);
  EXPECT_EQ(divided.notes.at(0), "divided x y z by w, the fourth coordinate, of 8 corners");
  const std::string plain_off = off_box();
  EXPECT_TRUE(read(off + plain_off.substr(plain_off.find("4 0 4")), "box.off").cloud.points_m ==
              divided.cloud.points_m);
  EXPECT_EQ(read("nOFF\n4\n", "a.off").fault, "a.off: line 1: nOFF, of any dimension, is not read");
  EXPECT_EQ(read("OFF BINARY\n", "a.off").fault, "a.off: line 1: OFF BINARY is not read: save it as text");
}

// A corner that is named twice in a row is one.
TEST(MeshFile, LeavesOutCornersThatRepeat) {
  const Outcome box = read(obj_box() + "f 1 1 2 2\nf 1 2 2 1\n", "box.obj");
  EXPECT_EQ(box.fault, "");
  EXPECT_EQ(box.notes.at(0), "left out 2 faces without area");
  EXPECT_TRUE(read(replaced(obj_box(), "f 1 5 7 3", "f 1 1 5 7 7 7 3 1"), "box.obj").cloud.points_m ==
              read(obj_box(), "box.obj").cloud.points_m);
}

}  // namespace
}  // namespace thenar::mesh_file_test
