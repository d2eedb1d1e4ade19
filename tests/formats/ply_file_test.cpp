// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/ply_file.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "engine/formats/files.h"
#include "engine/formats/point_cloud_file.h"

namespace thenar::ply_file_test {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

// The surfaces here are some units wide: decimetres.
constexpr double kUnit_m = 0.1;

PointCloud read(const std::string& bytes, double unit_m = kUnit_m) {
  std::vector<std::string> notes;
  return parse_cloud(bytes, "cloud.ply", {.unit_m = unit_m, .samples = 100}, notes);
}

/// What is said of these bytes, after the file's name; empty if they are read.
std::string fault_of(const std::string& bytes) {
  try {
    (void)read(bytes);
  } catch (const FileError& error) {
    const std::string what = error.what();
    const std::string prefix = "cloud.ply: ";
    EXPECT_TRUE(what.starts_with(prefix)) << what;
    return what.substr(prefix.size());
  }
  return "";
}

/// A spiral on the unit sphere. The normals are unit to rounding.
PointCloud spiral(Index count) {
  PointCloud cloud{Eigen::Matrix3Xd(3, count), Eigen::Matrix3Xd(3, count)};
  for (Index i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(count);
    const double turn = 2.4 * static_cast<double>(i);
    const double r = std::sqrt(1.0 - z * z);
    cloud.normals.col(i) = Vector3d(r * std::cos(turn), r * std::sin(turn), z).normalized();
    cloud.points_m.col(i) = 0.03 * cloud.normals.col(i);
  }
  return cloud;
}

/// The bytes that save_ply writes.
std::string saved(const PointCloud& cloud, PlyFormat format) {
  const auto folder = std::filesystem::path(THENAR_TEST_OUTPUT) / "ply";
  std::filesystem::create_directories(folder);
  // One for each test: they may run at the same time.
  const auto* const test = testing::UnitTest::GetInstance()->current_test_info();
  const auto file = folder / (std::string(test->name()) + ".ply");
  save_ply(file, cloud, format);
  return read_file(file);
}

const std::string kHeader =
    "ply\nformat ascii 1.0\nelement vertex 10\n"
    "property float x\nproperty float y\nproperty float z\n"
    "property float nx\nproperty float ny\nproperty float nz\nend_header\n";
constexpr int kHeaderLines = 10;

/// Ten vertices in ascii, two rows of five, with normals along z.
std::vector<std::string> ten_rows() {
  std::vector<std::string> rows;
  for (int i = 0; i < 10; ++i) {
    rows.push_back(std::to_string(i % 5) + ".00 " + std::to_string(i / 5) + ".00 0 0 0 2");
  }
  return rows;
}

std::string joined(const std::vector<std::string>& rows) {
  std::string text;
  for (const std::string& row : rows) text += row + "\n";
  return text;
}

/// ten_rows() with row i replaced.
std::string ten_rows_with(std::size_t i, const std::string& row) {
  std::vector<std::string> rows = ten_rows();
  rows[i] = row;
  return joined(rows);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

template <typename Number>
void append(std::string& bytes, Number number) {
  std::array<char, sizeof number> raw;
  std::memcpy(raw.data(), &number, sizeof number);
  bytes.append(raw.data(), raw.size());
}

TEST(PlyFile, ReadsBackWhatItWrote) {
  const PointCloud cloud = spiral(137);
  for (const PlyFormat format : {PlyFormat::kAscii, PlyFormat::kBinaryLittleEndian, PlyFormat::kBinaryBigEndian}) {
    const PointCloud again = read(saved(cloud, format), 1.0);
    EXPECT_EQ(again.points_m, cloud.points_m);
    EXPECT_EQ(again.normals, cloud.normals);
  }
}

TEST(PlyFile, ReadsBothByteOrdersAlike) {
  // The same doubles in the other order are a file of other bytes, and the same cloud.
  const PointCloud cloud = spiral(20);
  const std::string little = saved(cloud, PlyFormat::kBinaryLittleEndian);
  const std::string big = saved(cloud, PlyFormat::kBinaryBigEndian);
  const std::string header = "format binary_little_endian 1.0";
  EXPECT_NE(replaced(little, header, "format binary_big_endian 1.0"), big);
  EXPECT_EQ(read(little, 1.0).points_m, read(big, 1.0).points_m);
  // The first number by hand: its bytes are turned around, one by one.
  const std::size_t at = little.find("end_header\n") + 11;
  std::string first = little.substr(at, 8);
  std::ranges::reverse(first);
  EXPECT_EQ(big.substr(at - 3, 8), first);  // "big" is three letters shorter than "little"
}

TEST(PlyFile, ReadsACloudWithoutNormals) {
  std::string bytes = replaced(kHeader, "property float nx\nproperty float ny\nproperty float nz\n", "");
  for (int i = 0; i < 10; ++i) bytes += std::to_string(i % 5) + " " + std::to_string(i / 5) + " 1\n";
  const PointCloud cloud = read(bytes);
  EXPECT_EQ(cloud.points_m.col(9), kUnit_m * Vector3d(4, 1, 1));
  EXPECT_EQ(cloud.normals.cols(), 0);
}

TEST(PlyFile, NormalisesNormals) {
  std::vector<std::string> rows = ten_rows();
  rows[3] = "3 0 0 0 -5e-324 0";
  rows[4] = "4 0 0 1e308 1e308 0";
  const PointCloud cloud = read(replaced(kHeader, "float nx", "double nx") + joined(rows));
  EXPECT_EQ(cloud.normals.col(0), Vector3d(0, 0, 1));
  EXPECT_EQ(cloud.normals.col(3), Vector3d(0, -1, 0));
  EXPECT_TRUE(cloud.normals.col(4).isApprox(Vector3d(std::sqrt(0.5), std::sqrt(0.5), 0), 1e-15));
  EXPECT_EQ(cloud.points_m.col(7), kUnit_m * Vector3d(2, 1, 0));
}

TEST(PlyFile, SkipsOtherPropertiesAndElements) {
  // A camera before the vertices, colours and a list among their properties, another order, and faces after them.
  const std::string header =
      "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nobj_info none\r\nelement camera 2\r\nproperty float fov\r\n"
      "element vertex 10\r\nproperty uchar red\r\nproperty double nx\r\nproperty double ny\r\nproperty double nz\r\n"
      "property list uchar int neighbours\r\nproperty float x\r\nproperty float y\r\nproperty float z\r\n"
      "element polygon 2\r\nproperty list uchar int vertex_indices\r\nend_header\r\n";
  std::string body = "45\r\n50\r\n";
  for (int i = 0; i < 10; ++i) {
    body += "255 0 1 0 " + std::string(i % 2 == 0 ? "0" : "3 7 8 9") + " " + std::to_string(i % 5) + " 2 " +
            std::to_string(i / 5) + "\r\n";
  }
  body += "3 0 1 2\r\n4 0 1 2 3\r\n";
  const PointCloud cloud = read(header + body);
  EXPECT_EQ(cloud.points_m.cols(), 10);
  EXPECT_EQ(cloud.points_m.col(9), kUnit_m * Vector3d(4, 2, 1));
  EXPECT_EQ(cloud.normals.col(9), Vector3d(0, 1, 0));
}

/// The same in binary, with every numeric type.
std::string binary_with_all_types() {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nelement camera 2\nproperty ushort a\nproperty list short double b\n"
      "element vertex 12\nproperty char c\nproperty float x\nproperty short y\nproperty double z\nproperty uint d\n"
      "property list uint8 float32 e\nproperty int8 nx\nproperty int32 ny\nproperty float64 nz\n"
      "element polygon 1\nproperty list uchar int vertex_indices\nend_header\n";
  for (int i = 0; i < 2; ++i) {
    append(bytes, std::uint16_t{7});
    append(bytes, std::int16_t{2});
    append(bytes, 1.0);
    append(bytes, 2.0);
  }
  for (int i = 0; i < 12; ++i) {
    append(bytes, std::int8_t{-1});
    append(bytes, static_cast<float>(i % 3) + 0.25f);
    append(bytes, static_cast<std::int16_t>(-(i / 3)));
    append(bytes, 0.1 * i);
    append(bytes, std::uint32_t{4000000000});
    append(bytes, static_cast<std::uint8_t>(i % 2));
    if (i % 2 == 1) append(bytes, 3.0f);
    append(bytes, std::int8_t{-2});
    append(bytes, std::int32_t{0});
    append(bytes, 0.0);
  }
  append(bytes, std::uint8_t{3});
  for (const std::int32_t vertex : {0, 1, 2}) append(bytes, vertex);
  return bytes;
}

TEST(PlyFile, ReadsEveryBinaryType) {
  const PointCloud cloud = read(binary_with_all_types());
  ASSERT_EQ(cloud.points_m.cols(), 12);
  for (int i = 0; i < 12; ++i) {
    const int row = i / 3;
    EXPECT_EQ(cloud.points_m.col(i), kUnit_m * Vector3d(i % 3 + 0.25, -row, 0.1 * i));
    EXPECT_EQ(cloud.normals.col(i), Vector3d(-1, 0, 0));
  }
}

TEST(PlyFile, RefusesEveryTruncation) {
  for (const std::string& whole :
       {saved(spiral(12), PlyFormat::kAscii), saved(spiral(12), PlyFormat::kBinaryLittleEndian),
        saved(spiral(12), PlyFormat::kBinaryBigEndian), binary_with_all_types(), kHeader + joined(ten_rows())}) {
    ASSERT_EQ(fault_of(whole), "");
    // Of a text's last number, where it is no number any more.
    const bool is_text = whole.find("ascii") != std::string::npos;
    const std::size_t enough = is_text ? whole.find_last_of(' ') + 2 : whole.size();
    for (std::size_t length = 0; length < enough; ++length) {
      EXPECT_NE(fault_of(whole.substr(0, length)), "") << "of " << length << " bytes";
    }
  }
}

TEST(PlyFile, SurvivesEveryBrokenByte) {
  // Any one byte may make another valid file, but never a crash, nor a surface that is none.
  for (const std::string& whole : {saved(spiral(12), PlyFormat::kAscii), binary_with_all_types()}) {
    for (std::size_t i = 0; i < whole.size(); ++i) {
      for (const int flip : {0x01, 0x10, 0x80}) {
        std::string broken = whole;
        broken[i] = static_cast<char>(broken[i] ^ flip);
        try {
          const PointCloud cloud = read(broken);
          EXPECT_TRUE(cloud.points_m.allFinite());
          EXPECT_TRUE((cloud.normals.colwise().norm().array() - 1.0).abs().maxCoeff() < 1e-12);
        } catch (const FileError&) {
        }
      }
    }
  }
}

TEST(PlyFile, RefusesWrongHeaders) {
  const std::string rows = joined(ten_rows());
  const auto with = [&](const std::string& from, const std::string& to) {
    return fault_of(replaced(kHeader, from, to) + rows);
  };
  EXPECT_EQ(fault_of(""), "the file is empty");
  EXPECT_EQ(fault_of("solid box\n"), "is no PLY file: its first line is not 'ply'");
  EXPECT_EQ(fault_of(std::string(100, '\0') + "\n"), "the file is empty");
  EXPECT_EQ(with("format ascii 1.0", "format ascii 2.0"), "line 2: PLY version 2.0 is not read, only 1.0");
  EXPECT_EQ(with("format ascii 1.0", "format text 1.0"), "line 2: unknown format 'text'");
  EXPECT_EQ(with("format ascii 1.0\n", ""), "line 2: 'format' must follow 'ply'");
  EXPECT_EQ(with("element vertex 10", "element vertex ten"), "line 3: an element needs a name and a count");
  EXPECT_EQ(with("element vertex 10", "element vertex -10"), "line 3: an element needs a name and a count");
  EXPECT_EQ(with("element vertex 10", "element vertex"), "line 3: an element needs a name and a count");
  EXPECT_EQ(with("element vertex 10\n", ""), "line 3: 'property' is not expected in the header here");
  EXPECT_EQ(with("element vertex 10", "element point 10"), "needs one element 'vertex'");
  EXPECT_EQ(with("element vertex 10", "element vertex 0\nelement vertex 10"), "needs one element 'vertex'");
  EXPECT_EQ(with("property float z", "property half z"),
            "line 6: unknown type 'half', PLY has char, uchar, short, ushort, int, uint, float, double");
  EXPECT_EQ(with("property float z", "property list int64 int z").substr(0, 28), "line 6: unknown type 'int64'");
  EXPECT_EQ(with("property float z", "property float"), "line 6: a property needs a type and a name");
  EXPECT_EQ(with("property float z", "property list float int z"),
            "line 6: the length of a list must be a whole number");
  EXPECT_EQ(with("property float z", "property list uchar float z"), "needs coordinates x y z");
  EXPECT_EQ(with("property float z", "property float w"), "needs coordinates x y z");
  EXPECT_EQ(with("property float z", "property float x"), "property x is declared twice");
  EXPECT_EQ(with("property float nz\n", ""), "has a part of the normals: needs nx ny nz or none of them");
  EXPECT_EQ(with("end_header", "end header"), "line 10: 'end' is not expected in the header here");
}

TEST(PlyFile, RefusesAHeaderThatClaimsMoreThanTheFileHolds) {
  const std::string rows = joined(ten_rows());
  for (const char* count : {"1000", "4000000000", "18446744073709551615"}) {
    EXPECT_EQ(fault_of(replaced(kHeader, "vertex 10", "vertex " + std::string(count)) + rows),
              "the file is truncated: it cannot hold " + std::string(count) + " of 'vertex'");
  }
  EXPECT_EQ(fault_of(replaced(kHeader, "vertex 10", "vertex 99999999999999999999") + rows),
            "line 3: an element needs a name and a count");
  EXPECT_EQ(fault_of(replaced(kHeader, "vertex 10", "vertex 11") + rows),
            "line 21: the file is truncated: it ends here");
  EXPECT_EQ(fault_of(replaced(kHeader, "vertex 10", "vertex 9") + rows),
            "line 20: the header declares less than the file holds");
  const std::string binary = saved(spiral(12), PlyFormat::kBinaryLittleEndian);
  EXPECT_EQ(fault_of(replaced(binary, "vertex 12", "vertex 99")),
            "the file is truncated: it cannot hold 99 of 'vertex'");
  const std::size_t end = binary.size() - 48;
  EXPECT_EQ(fault_of(replaced(binary, "vertex 12", "vertex 11")),
            "byte " + std::to_string(end) + ": the header declares less than the file holds: 48 bytes are left");
  // Elements without properties take no bytes, however many there are.
  EXPECT_EQ(fault_of(replaced(binary, "end_header", "element nothing 18446744073709551615\nend_header")), "");
}

TEST(PlyFile, RefusesWrongRows) {
  const auto line = [](int row) { return "line " + std::to_string(kHeaderLines + 1 + row) + ": "; };
  EXPECT_EQ(fault_of(kHeader + ten_rows_with(4, "1 2 3 4 5")), line(4) + "too few values for one vertex");
  EXPECT_EQ(fault_of(kHeader + ten_rows_with(4, "1 2 3 4 5 6 7")), line(4) + "too many values for one vertex");
  EXPECT_EQ(fault_of(kHeader + ten_rows_with(4, "1 2 3 4 5 six")), line(4) + "'six' is not a number");
  EXPECT_EQ(fault_of(kHeader + ten_rows_with(4, "1 2 3 4 5 6mm")), line(4) + "'6mm' is not a number");
  EXPECT_EQ(fault_of(kHeader + ten_rows_with(4, "")), line(10) + "the file is truncated: it ends here");
  const std::string list = replaced(kHeader, "end_header", "property list int int faces\nend_header");
  for (const char* length : {"-1", "1e300", "nan", "7 1"}) {
    std::vector<std::string> rows = ten_rows();
    for (std::string& row : rows) row += " 0";
    rows[4] = ten_rows()[4] + " " + length;
    EXPECT_TRUE(fault_of(list + joined(rows)).starts_with(line(5))) << length;
  }
}

TEST(PlyFile, RefusesValuesThatAreNoSurface) {
  for (const char* row : {"1 nan 3 0 0 1", "inf 2 3 0 0 1", "1 2 3 0 -inf 1", "1 2 3 0 -0 0"}) {
    EXPECT_EQ(fault_of(kHeader + ten_rows_with(4, row)), "needs at least 10 points, has 9") << row;
  }
  EXPECT_EQ(fault_of(replaced(kHeader, "vertex 10", "vertex 9") + joined({9, "1 2 3 0 0 1"})),
            "needs at least 10 points, has 9");
  EXPECT_EQ(fault_of(replaced(kHeader, "vertex 10", "vertex 0")), "needs at least 10 points, has 0");
  EXPECT_EQ(fault_of(kHeader + joined({10, "1 2 3 0 0 1"})), "all points coincide");
  std::vector<std::string> line;
  for (int i = 0; i < 10; ++i) line.push_back(std::to_string(0.1 * i) + " " + std::to_string(0.3 * i) + " 1 0 0 1");
  EXPECT_EQ(fault_of(kHeader + joined(line)), "all points lie on one line");
  EXPECT_EQ(fault_of(kHeader + ten_rows_with(4, "-1e308 0 0 0 0 1")), "all points lie on one line");
  std::vector<std::string> far = ten_rows();
  far[0] = "1.7e308 0 0 0 0 1";
  far[1] = "-1.7e308 0 0 0 0 1";
  EXPECT_EQ(fault_of(kHeader + joined(far)), "the points are too far apart");
}

TEST(PlyFile, RefusesBadBinaryLists) {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nelement face 1\nproperty list int double a\nelement vertex 10\n"
      "property double x\nproperty double y\nproperty double z\nproperty double nx\nproperty double ny\n"
      "property double nz\nend_header\n";
  const std::string start = std::to_string(bytes.size() + 4);
  for (const auto& [length, fault] : std::vector<std::pair<std::int32_t, std::string>>{
           {-1, "a list has a negative length"},
           {std::numeric_limits<std::int32_t>::max(),
            "the file is truncated: a list of 17179869176 bytes starts here"}}) {
    std::string whole = bytes;
    append(whole, length);
    whole += std::string(480, '\0');
    EXPECT_EQ(fault_of(whole), "byte " + start + ": " + fault);
  }
}

/// Points that are missing, as where an organised cloud saw none, are left out, and told.
TEST(PlyFile, LeavesOutWhatIsMissing) {
  std::vector<std::string> rows = ten_rows(), notes;
  rows.insert(rows.begin() + 3, {"nan nan nan 0 0 1", "9 9 9 0 nan 0", "7 7 7 0 0 0"});
  const std::string header = replaced(kHeader, "vertex 10", "vertex 13");
  const PointCloud cloud = parse_cloud(header + joined(rows), "cloud.ply", {.unit_m = kUnit_m}, notes);
  EXPECT_EQ(cloud.points_m, read(kHeader + joined(ten_rows())).points_m);
  EXPECT_EQ(notes, (std::vector<std::string>{"left out 1 point without finite coordinates",
                                             "left out 2 points whose normals have no length"}));
  // Without any length they are none.
  std::vector<std::string> zero;
  for (const std::string& row : ten_rows()) zero.push_back(row.substr(0, row.size() - 1) + "0");
  EXPECT_EQ(read(kHeader + joined(zero)).normals.cols(), 0);
}

TEST(PlyFile, PassesOverWhatOthersPassOver) {
  const PointCloud plain = read(kHeader + joined(ten_rows()));
  const std::string rows = joined(ten_rows());
  for (const std::string& bytes :
       {kHeader + rows.substr(0, rows.size() - 1), "\xEF\xBB\xBF" + kHeader + rows, "\n " + kHeader + rows,
        replaced(kHeader, "ply", "PLY") + rows, replaced(kHeader, "1.0\n", "1.0\nMade by hand, in 2005\n") + rows,
        kHeader + rows + "\n \n", kHeader + rows + "the end\n", kHeader + rows + std::string(300, '\0'),
        kHeader + "\n" + rows}) {
    EXPECT_EQ(read(bytes).points_m, plain.points_m) << bytes.substr(0, 60);
  }
  std::string returns = kHeader + rows;
  std::ranges::replace(returns, '\n', '\r');
  EXPECT_EQ(read(returns).points_m, plain.points_m);
  EXPECT_EQ(fault_of(replaced(kHeader, "element", "elemnt") + rows),
            "line 3: 'elemnt' is not expected in the header here, did you mean 'element'?");
  const std::string binary = saved(spiral(20), PlyFormat::kBinaryBigEndian);
  EXPECT_EQ(read(binary + "\n").points_m, read(binary).points_m);
  EXPECT_EQ(read(binary + std::string(47, 'x')).points_m, read(binary).points_m);
  EXPECT_NE(fault_of(binary + std::string(48, 'x')), "");
}

/// A box of 2 x 3 x 4, its faces as strips, with another element between.
std::string strips(bool before) {
  std::string vertices;
  for (int i = 0; i < 8; ++i) {
    vertices += std::to_string(2 * (i & 1)) + " " + std::to_string(3 * (i >> 1 & 1)) + " " +
                std::to_string(4 * (i >> 2 & 1)) + "\n";
  }
  const std::string list = "element tristrips 1\nproperty list int int vertex_indices\n";
  const std::string points = "element vertex 8\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string faces = "21 0 2 1 3 5 7 4 6 0 2 -1 0 1 4 5 -1 2 6 3 7 -1\n";
  return "ply\nformat ascii 1.0\n" + (before ? list + points : points + list) + "end_header\n" +
         (before ? faces + vertices : vertices + faces);
}

TEST(PlyFile, ReadsFacesBeforeVerticesAndStrips) {
  for (const bool before : {false, true}) {
    std::vector<std::string> notes;
    const PlyFile ply = parse_ply(strips(before), "box.ply", notes);
    ASSERT_TRUE(ply.mesh);
    double volume = 0.0;
    for (const auto& t : ply.mesh->triangles.colwise()) {
      const Vector3d a = ply.mesh->vertices_m.col(t[0]), b = ply.mesh->vertices_m.col(t[1]);
      volume += a.dot(b.cross(Vector3d(ply.mesh->vertices_m.col(t[2])))) / 6.0;
    }
    EXPECT_EQ(ply.mesh->triangles.cols(), 12);
    EXPECT_NEAR(std::abs(volume), 24.0, 1e-12);
    EXPECT_TRUE(ply_has_faces(strips(before)));
  }
  EXPECT_FALSE(ply_has_faces(kHeader));
  EXPECT_FALSE(ply_has_faces(replaced(kHeader, "end_", "element face 0\nproperty list uchar int vertex_index\nend_")));
  const auto wrong = [](const std::string& from, const std::string& to) {
    return fault_of(replaced(strips(false), from, to));
  };
  EXPECT_EQ(wrong("-1 2 6 3 7", "-1 2 6 3 8"), "face 11: there is no vertex 8");
  EXPECT_EQ(wrong("-1 2 6 3 7", "-1 2 6 3 6.5"), "face 11: there is no vertex 6.5");
  EXPECT_EQ(wrong("2 3 4\n", "2 nan 4\n"), "face 3: its vertex 7 is not finite");
  EXPECT_EQ(wrong("list int int vertex_indices", "list int int corners"), "");
  EXPECT_EQ(wrong("list int int vertex_indices", "int corner"), "the element 'tristrips' has no list vertex_indices");
}

}  // namespace
}  // namespace thenar::ply_file_test
