#include "engine/formats/text_cloud_file.h"

#include <gtest/gtest.h>

#include <string>

#include "engine/formats/files.h"

namespace thenar::text_cloud_file_test {
namespace {

using Eigen::Vector3d;

std::string fault_of(PointCloud (*parse)(std::string_view, const std::filesystem::path&), const std::string& text) {
  try {
    (void)parse(text, "scan");
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

TEST(TextCloudFile, ReadsXyzWithAndWithoutNormals) {
  const PointCloud plain = parse_xyz("# a scan\n1 2 3\n\n\t4\t5e-1 -6 # the second\r\n", "scan");
  ASSERT_EQ(plain.points_m.cols(), 2);
  EXPECT_EQ(plain.points_m.col(0), Vector3d(1, 2, 3));
  EXPECT_EQ(plain.points_m.col(1), Vector3d(4, 0.5, -6));
  EXPECT_EQ(plain.normals.cols(), 0);
  // A last line without an end is common, and nothing says how many there should be.
  const PointCloud full = parse_xyz("1 2 3 0 0 1\n4 5 6 0 1 0", "scan");
  ASSERT_EQ(full.points_m.cols(), 2);
  EXPECT_EQ(full.points_m.col(1), Vector3d(4, 5, 6));
  EXPECT_EQ(full.normals.col(1), Vector3d(0, 1, 0));
  EXPECT_EQ(parse_xyz("", "scan").points_m.cols(), 0);
}

TEST(TextCloudFile, RefusesWrongXyzLines) {
  EXPECT_EQ(fault_of(parse_xyz, "1 2 3\n1 2\n"), "scan: line 2: has 2 values, the lines before it 3");
  EXPECT_EQ(fault_of(parse_xyz, "1 2 3\n1 2 3 0 0 1\n"), "scan: line 2: has 6 values, the lines before it 3");
  EXPECT_EQ(fault_of(parse_xyz, "1 2 3 255\n"), "scan: line 1: must be x y z or x y z nx ny nz, not 4 values");
  EXPECT_EQ(fault_of(parse_xyz, "x y z\n"), "scan: line 1: 'x' is not a number");
  EXPECT_EQ(fault_of(parse_xyz, "1,2,3\n"), "scan: line 1: must be x y z or x y z nx ny nz, not 1 values");
  EXPECT_EQ(fault_of(parse_xyz, "1 2 3\n\n1 nan 3\n"), "scan: line 3: 'nan' is not finite: leave such points out");
  EXPECT_EQ(fault_of(parse_xyz, "1 2 1e999\n"), "scan: line 1: '1e999' is not a number");
}

const std::string kPcd =
    "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y rgb histogram z normal_x normal_y normal_z\n"
    "SIZE 4 4 4 4 4 4 4 4\nTYPE F F F F F F F F\nCOUNT 1 1 1 2 1 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\n"
    "POINTS 2\nDATA ascii\n";
const std::string kRows = "1 2 4.2e+06 7 8 3 0 0 1\n4 5 nan 7 8 6 0 1 0\n";

std::string with(const std::string& from, const std::string& to) {
  const std::size_t at = kPcd.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return std::string(kPcd).replace(at, from.size(), to) + kRows;
}

TEST(TextCloudFile, ReadsPcdAndSkipsOtherFields) {
  const PointCloud cloud = parse_pcd(kPcd + kRows, "scan");
  ASSERT_EQ(cloud.points_m.cols(), 2);
  EXPECT_EQ(cloud.points_m.col(0), Vector3d(1, 2, 3));
  EXPECT_EQ(cloud.points_m.col(1), Vector3d(4, 5, 6));
  EXPECT_EQ(cloud.normals.col(0), Vector3d(0, 0, 1));
  EXPECT_EQ(cloud.normals.col(1), Vector3d(0, 1, 0));
  const PointCloud plain = parse_pcd("FIELDS x y z\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 3\n", "scan");
  EXPECT_EQ(plain.points_m.col(0), Vector3d(1, 2, 3));
  EXPECT_EQ(plain.normals.cols(), 0);
}

TEST(TextCloudFile, RefusesEveryTruncatedPcd) {
  const std::string whole = kPcd + kRows;
  ASSERT_EQ(fault_of(parse_pcd, whole), "");
  for (std::size_t length = 0; length < whole.size(); ++length) {
    EXPECT_NE(fault_of(parse_pcd, whole.substr(0, length)), "") << "of " << length << " bytes";
  }
}

TEST(TextCloudFile, RefusesWrongPcd) {
  EXPECT_EQ(fault_of(parse_pcd, with("DATA ascii", "DATA binary")),
            "scan: line 11: only DATA ascii is read: save it as ascii");
  EXPECT_EQ(fault_of(parse_pcd, with("VERSION", "VERSOIN")),
            "scan: line 2: 'VERSOIN' is not expected in the header of a PCD file");
  EXPECT_EQ(fault_of(parse_pcd, with("WIDTH 2", "WIDTH two")), "scan: line 7: WIDTH must be one whole number");
  EXPECT_EQ(fault_of(parse_pcd, with("WIDTH 2", "WIDTH 3")), "scan: POINTS is not WIDTH times HEIGHT");
  EXPECT_EQ(fault_of(parse_pcd, with("COUNT 1 ", "COUNT ")), "scan: COUNT must have one number for each of FIELDS");
  EXPECT_EQ(fault_of(parse_pcd, with("COUNT 1 ", "COUNT 99999999999 ")),
            "scan: COUNT makes more than 10000 values of a line");
  EXPECT_EQ(fault_of(parse_pcd, "FIELDS x y z\nWIDTH 4294967296\nHEIGHT 4294967297\nDATA ascii\n1 2 3\n"),
            "scan: WIDTH times HEIGHT is more than any file holds");
  EXPECT_EQ(fault_of(parse_pcd, with("FIELDS x", "FIELDS w")), "scan: FIELDS needs x y z");
  EXPECT_EQ(fault_of(parse_pcd, with("rgb", "x")), "scan: FIELDS has x more than once");
  EXPECT_EQ(fault_of(parse_pcd, with(" normal_z", " curvature")),
            "scan: FIELDS needs normal_x normal_y normal_z or none of them");
  EXPECT_EQ(fault_of(parse_pcd, with("WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2", "POINTS 1")),
            "scan: line 10: the header declares less than the file holds");
  EXPECT_EQ(fault_of(parse_pcd, with("WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2", "POINTS 4000000000")),
            "scan: the file is truncated: it cannot hold 4000000000 points");
  EXPECT_EQ(fault_of(parse_pcd, kPcd + "1.0 2.0 0 7 8 3 0 0 1\n1 2 0 7 8 3 0 0\n"),
            "scan: line 13: must have 9 values, has 8");
  EXPECT_EQ(fault_of(parse_pcd, kPcd + "1 2 0 7 8 3 0 0 1\nnan 2 0 7 8 3 0 0 1\n"),
            "scan: line 13: 'nan' is not finite: leave such points out");
}

}  // namespace
}  // namespace thenar::text_cloud_file_test
