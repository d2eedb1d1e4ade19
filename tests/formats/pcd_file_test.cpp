// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/pcd_file.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "engine/formats/files.h"

namespace thenar::pcd_file_test {
namespace {

using Eigen::Vector3d;

PointCloud read(const std::string& bytes) {
  std::vector<std::string> notes;
  return parse_pcd(bytes, "scan", notes);
}

std::string fault_of(const std::string& bytes) {
  try {
    (void)read(bytes);
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
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

TEST(PcdFile, ReadsPcdAndSkipsOtherFields) {
  const PointCloud cloud = read(kPcd + kRows);
  ASSERT_EQ(cloud.points_m.cols(), 2);
  EXPECT_EQ(cloud.points_m.col(0), Vector3d(1, 2, 3));
  EXPECT_EQ(cloud.points_m.col(1), Vector3d(4, 5, 6));
  EXPECT_EQ(cloud.normals.col(0), Vector3d(0, 0, 1));
  EXPECT_EQ(cloud.normals.col(1), Vector3d(0, 1, 0));
  const PointCloud plain = read("FIELDS x y z\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 3\n");
  EXPECT_EQ(plain.points_m.col(0), Vector3d(1, 2, 3));
  EXPECT_EQ(plain.normals.cols(), 0);
}

TEST(PcdFile, RefusesEveryTruncatedPcd) {
  const std::string whole = kPcd + kRows;
  ASSERT_EQ(fault_of(whole), "");
  // Without its end the last line is whole, and a number of one digit is.
  for (std::size_t length = 0; length + 1 < whole.size(); ++length) {
    EXPECT_NE(fault_of(whole.substr(0, length)), "") << "of " << length << " bytes";
  }
}

TEST(PcdFile, RefusesWrongPcd) {
  EXPECT_EQ(fault_of(with("DATA ascii", "DATA binary")),
            "scan: byte 235: the file is truncated: its points need 72 bytes");
  EXPECT_EQ(fault_of(with("DATA ascii", "DATA text")),
            "scan: line 11: DATA must be ascii, binary or binary_compressed");
  EXPECT_EQ(fault_of(with("VERSION", "VERSOIN")),
            "scan: line 2: 'VERSOIN' is not expected in the header of a PCD file");
  EXPECT_EQ(fault_of(with("WIDTH 2", "WIDTH two")), "scan: line 7: WIDTH must be one whole number");
  EXPECT_EQ(fault_of(with("WIDTH 2", "WIDTH 3")), "scan: POINTS is 2, and WIDTH times HEIGHT 3: they must be the same");
  EXPECT_EQ(fault_of(with("COUNT 1 ", "COUNT ")), "scan: COUNT must have one number for each of FIELDS");
  EXPECT_EQ(fault_of(with("COUNT 1 ", "COUNT 99999999999 ")), "scan: COUNT makes more than 10000 values of a line");
  EXPECT_EQ(fault_of("FIELDS x y z\nWIDTH 4294967296\nHEIGHT 4294967297\nDATA ascii\n1 2 3\n"),
            "scan: WIDTH times HEIGHT is more than any file holds");
  EXPECT_EQ(fault_of(with("FIELDS x", "FIELDS w")), "scan: FIELDS needs x y z");
  EXPECT_EQ(fault_of(with("rgb", "x")), "scan: FIELDS has x more than once");
  EXPECT_EQ(fault_of(with(" normal_z", " curvature")), "scan: FIELDS needs normal_x normal_y normal_z or none of them");
  EXPECT_EQ(fault_of(with("WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2", "POINTS 1")),
            "scan: line 10: the header declares less than the file holds");
  EXPECT_EQ(fault_of(with("WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2", "POINTS 4000000000")),
            "scan: the file is truncated: it cannot hold 4000000000 points");
  EXPECT_EQ(fault_of(kPcd + "1.0 2.0 0 7 8 3 0 0 1\n1 2 0 7 8 3 0 0\n"), "scan: line 13: must have 9 values, has 8");
  EXPECT_EQ(fault_of(kPcd + "1 2 0 7 8 3 0 0 1\none 2 0 7 8 3 0 0 1\n"), "scan: line 13: 'one' is not a number");
}

template <typename Number>
void append(std::string& bytes, Number number) {
  std::array<char, sizeof number> raw;
  std::memcpy(raw.data(), &number, sizeof number);
  bytes.append(raw.data(), raw.size());
}

/// Packs bytes as LZF does: what repeats four bytes before is a copy of it, the rest stands as it is.
std::string pack_lzf(const std::string& in) {
  std::string out, literals;
  const auto flush = [&] {
    for (std::size_t at = 0; at < literals.size(); at += 32) {
      const std::string run = literals.substr(at, 32);
      out += static_cast<char>(run.size() - 1);
      out += run;
    }
    literals.clear();
  };
  for (std::size_t at = 0; at < in.size();) {
    std::size_t length = 0;
    while (at >= 4 && at + length < in.size() && length < 264 && in[at + length] == in[at + length - 4]) ++length;
    if (length < 3) {
      literals += in[at++];
      continue;
    }
    flush();
    const std::size_t more = length - 2;
    out += static_cast<char>(std::min<std::size_t>(more, 7) << 5U);
    if (more >= 7) out += static_cast<char>(more - 7);
    out += static_cast<char>(3);  // one less than the way back
    at += length;
  }
  flush();
  return out;
}

struct Binary {
  std::string head, rows, packed;
};

/// Points of several types, in rows as binary files have them, and in columns, packed.
Binary binary_pcd(int count) {
  const std::string number = std::to_string(count);
  Binary file;
  file.head = "VERSION .7\nCOLUMNS rgb x y z histogram\nSIZE 4 4 8 2 1\nTYPE U F F I U\nCOUNT 1 1 1 1 3\nWIDTH " +
              number + "\nHEIGHT 1\nDATA ";
  std::array<std::string, 5> columns;
  for (int i = 0; i < count; ++i) {
    std::array<std::string, 5> fields;
    append(fields[0], std::uint32_t{4000000000});
    append(fields[1], i == 7 ? std::numeric_limits<float>::quiet_NaN() : 0.25F * static_cast<float>(i / 50));
    append(fields[2], -0.125 * (i / 80));
    append(fields[3], static_cast<std::int16_t>(-i));
    fields[4] = "abc";
    for (int k = 0; k < 5; ++k) {
      file.rows += fields[k];
      columns[k] += fields[k];
    }
  }
  std::string all;
  for (const std::string& column : columns) all += column;
  const std::string packed = pack_lzf(all);
  append(file.packed, static_cast<std::uint32_t>(packed.size()));
  append(file.packed, static_cast<std::uint32_t>(all.size()));
  file.packed += packed;
  return file;
}

TEST(PcdFile, ReadsBinaryAndCompressed) {
  const Binary file = binary_pcd(300);
  EXPECT_LT(file.packed.size(), file.rows.size());  // It does compress.
  for (const std::string& bytes : {file.head + "binary\n" + file.rows, file.head + "binary_compressed\n" + file.packed,
                                   file.head + "binary\r\n" + file.rows + "\n"}) {
    const PointCloud cloud = read(bytes);
    ASSERT_EQ(cloud.points_m.cols(), 300);
    EXPECT_EQ(cloud.points_m.col(299), Vector3d(1.25, -0.375, -299));
    EXPECT_TRUE(std::isnan(cloud.points_m(0, 7)));
    EXPECT_EQ(cloud.normals.cols(), 0);
  }
}

TEST(PcdFile, RefusesBrokenBinary) {
  const Binary file = binary_pcd(20);
  const std::string plain = file.head + "binary\n" + file.rows,
                    packed = file.head + "binary_compressed\n" + file.packed;
  for (const std::string& whole : {plain, packed}) {
    ASSERT_EQ(fault_of(whole), "");
    for (std::size_t length = 0; length < whole.size(); ++length) {
      EXPECT_NE(fault_of(whole.substr(0, length)), "") << length;
    }
    EXPECT_NE(fault_of(whole + std::string(100, 'x')), "");
  }
  // Whatever a wrong byte does to the compressed data, it is read or refused.
  for (std::size_t at = file.head.size() + 18; at < packed.size(); ++at) {
    for (const char value : {'\0', '\x1F', '\x20', '\x7F', '\xE0', '\xFF'}) {
      std::string wrong = packed;
      wrong[at] = value;
      (void)fault_of(wrong);
    }
  }
}

}  // namespace
}  // namespace thenar::pcd_file_test
