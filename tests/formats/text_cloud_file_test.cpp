// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/text_cloud_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "engine/formats/files.h"

namespace thenar::text_cloud_file_test {
namespace {

using Eigen::Vector3d;

struct Read {
  PointCloud cloud;
  std::string note;  ///< The first one.
};

Read read_xyz(const std::string& text) {
  std::vector<std::string> notes;
  const PointCloud cloud = parse_xyz(text, "scan", notes);
  return {cloud, notes.empty() ? "" : notes.back()};
}

std::string fault_of(const std::string& text) {
  try {
    (void)read_xyz(text);
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

TEST(TextCloudFile, ReadsXyzWithAndWithoutNormals) {
  const PointCloud plain = read_xyz("# a scan\n1 2 3\n\n\t4\t5e-1 -6 # the second\r\n").cloud;
  ASSERT_EQ(plain.points_m.cols(), 2);
  EXPECT_EQ(plain.points_m.col(0), Vector3d(1, 2, 3));
  EXPECT_EQ(plain.points_m.col(1), Vector3d(4, 0.5, -6));
  EXPECT_EQ(plain.normals.cols(), 0);
  // A last line without an end is common, and nothing says how many there should be.
  const PointCloud full = read_xyz("1 2 3 0 0 1\n4 5 6 0 1 0").cloud;
  ASSERT_EQ(full.points_m.cols(), 2);
  EXPECT_EQ(full.points_m.col(1), Vector3d(4, 5, 6));
  EXPECT_EQ(full.normals.col(1), Vector3d(0, 1, 0));
  EXPECT_EQ(read_xyz("").cloud.points_m.cols(), 0);
}

TEST(TextCloudFile, RefusesWrongXyzLines) {
  EXPECT_EQ(fault_of("1 2 3\n1 2\n"), "scan: line 2: has 2 values, the lines before it 3");
  EXPECT_EQ(fault_of("1 2 3\n1 2 3 0 0 1\n"), "scan: line 2: has 6 values, the lines before it 3");
  EXPECT_EQ(fault_of("1 2\n"), "scan: line 1: must be x y z or x y z nx ny nz, not 2 values");
  EXPECT_EQ(fault_of("x y z\n1 2 x\n"), "scan: line 2: 'x' is not a number");
  EXPECT_EQ(fault_of("1,5 2,5 3,5\n"), "scan: line 1: has commas within its numbers: write points in their place");
  EXPECT_EQ(fault_of("1,5;2,5;3,5\n"), "scan: line 1: has commas within its numbers: write points in their place");
  EXPECT_EQ(fault_of("3\n1 2 3\n4 5 6\n"), "scan: says that it has 3 points, and has 2");
  EXPECT_EQ(fault_of("1 2 1e999\n"), "scan: line 1: '1e999' is not a number");
}

/// A ball's lines: places, then what `more` appends of the normal.
template <typename More>
std::string ball(const More& more, const char* between = " ") {
  std::string text;
  for (int i = 0; i < 40; ++i) {
    const double z = 1.0 - (i + 0.5) / 20.0, r = std::sqrt(1.0 - z * z), turn = 2.4 * i;
    const Vector3d n(r * std::cos(turn), r * std::sin(turn), z);
    const auto add = [&](double value) {
      text += (text.empty() || text.back() == '\n' ? "" : between) + std::to_string(value);
    };
    for (const double value : n) add(25.0 * value);
    more(i, n, add);
    text += "\n";
  }
  return text;
}

TEST(TextCloudFile, TakesColumnsForWhatTheyAre) {
  const auto nothing = [](int, const Vector3d&, const auto&) {};
  const auto grey = [](int, const Vector3d&, const auto& add) {
    for (int k : {180, 170, 160}) add(k);
  };
  const auto red = [](int, const Vector3d&, const auto& add) {
    for (int k : {1, 0, 0}) add(k);
  };
  const auto normal = [](int, const Vector3d& n, const auto& add) {
    for (double x : n) add(x);
  };
  const auto intensity = [](int i, const Vector3d&, const auto& add) { add(i); };
  const auto both = [](const auto& one, const auto& other) {
    return [&](int i, const Vector3d& n, const auto& add) {
      one(i, n, add);
      other(i, n, add);
    };
  };
  const PointCloud plain = read_xyz(ball(nothing)).cloud;
  EXPECT_EQ(read_xyz(ball(nothing)).note, "");
  const auto expect = [&](const std::string& text, bool has_normals, const std::string& note) {
    const Read read = read_xyz(text);
    EXPECT_EQ(read.cloud.points_m, plain.points_m);
    EXPECT_EQ(read.cloud.normals.cols(), has_normals ? 40 : 0);
    if (has_normals) {
      EXPECT_LT((25.0 * read.cloud.normals - plain.points_m).cwiseAbs().maxCoeff(), 2e-5);
    }
    EXPECT_EQ(read.note, note);
  };
  const std::string colours =
      "took columns 1 to 3 for x y z and columns 4 to 6 for colours: they are not normals, which have unit length and "
      "point to all sides";
  expect(ball(normal), true, "");
  expect(ball(grey), false, colours);
  expect(ball(red), false, colours);
  expect(ball(intensity), false, "took columns 1 to 3 for x y z; the other columns are not read");
  expect(ball(both(grey, intensity)), false, "took columns 1 to 3 for x y z; the other columns are not read");
  expect(ball(both(grey, normal)), true,
         "took columns 1 to 3 for x y z and columns 7 to 9 for normals, for they are of unit length; the other columns "
         "are not read");
  expect(ball(both(intensity, normal)), true,
         "took columns 1 to 3 for x y z and columns 5 to 7 for normals, for they are of unit length; the other columns "
         "are not read");
  const std::string title = "passed over the line before the points";
  expect("X Y Z\n" + ball(nothing), false, title);
  expect("//X,Y,Z\n" + ball(nothing, ", "), false, title);
  expect("40\n" + ball(nothing, ";"), false, "");
  expect("scan of a ball\n" + ball(nothing, "\t"), false, title);
  // By the title: what is of another length is a normal, too.
  const auto twice = [](int, const Vector3d& n, const auto& add) {
    for (double x : n) add(0.04 * 25.0 * x);
  };
  expect("x y z i nx ny nz\n" + ball(both(intensity, twice)), true,
         "took columns 1 to 3 for x y z and columns 5 to 7 for normals; the other columns are not read");
}

// Tables as spreadsheets, ParaView and scanners write them.
TEST(TextCloudFile, FindsColumnsByTheirNames) {
  const auto nothing = [](int, const Vector3d&, const auto&) {};
  const PointCloud plain = read_xyz(ball(nothing)).cloud;
  std::string numbered = ",x,y,z\n", paraview = R"("Normals:0","Normals:1","Normals:2",)";
  paraview += R"("Points:0","Points:1","Points:2")" + std::string("\n");
  std::string scans = "25\n";
  for (int i = 0; i < 40; ++i) {
    const Vector3d p = plain.points_m.col(i);
    const auto row = [&](const std::string& between) {
      return std::to_string(p.x()) + between + std::to_string(p.y()) + between + std::to_string(p.z()) + "\n";
    };
    numbered += std::to_string(i) + "," + row(",");
    paraview += "0.04,0.04,0.04," + row(",");
    scans += (i == 25 ? "15\n" : "") + row(" ");
  }
  EXPECT_EQ(read_xyz(numbered).cloud.points_m, plain.points_m);
  EXPECT_EQ(read_xyz(numbered).note, "took columns 2 to 4 for x y z; the other columns are not read");
  EXPECT_EQ(read_xyz(paraview).cloud.points_m, plain.points_m);
  EXPECT_EQ(read_xyz(paraview).cloud.normals.col(7), Vector3d::Constant(0.04));
  EXPECT_EQ(read_xyz(scans).cloud.points_m, plain.points_m);
  EXPECT_EQ(fault_of(scans + "3\n"), "scan: says that it has 43 points, and has 40");
}

// A name may have blanks and a unit, and a title fewer names than a row has values: those of the last columns, where
// the first one counts rows, else those of the first ones.
TEST(TextCloudFile, SplitsTitlesAsItsRows) {
  struct Case {
    std::string title, row, took;
    Vector3d point{1, 2, 3};
  };
  const std::string second = "took columns 2 to 4 for x y z; the other columns are not read";
  const std::string first = "took columns 1 to 3 for x y z; the other columns are not read";
  const std::vector<Case> cases{
      {"time [s],X,Y,Z", "0.5,1,2,3", second},
      {"Point No;X;Y;Z", "0.5;1;2;3", second},
      {"t,pos_x,pos_y,pos_z", "0.5,1,2,3", second},
      {"No,X(mm),Y(mm),Z(mm)", "7,1,2,3", second},
      {"Point No\tX mm\tY mm\tZ mm", "0.5\t1\t2\t3", second},
      {"X Y Z", "1 2 3 0.5", first},
      {"X Y Z", "7 1 2 3", second},
      {"% x y z", "1 2 3 0.5", first},
      {"# time x y z", "0.5 1 2 3", second},
      {"# exported, 12 points\n# t x y z\n# all in mm", "0.5 1 2 3", second},
      {"z,y,x,point intensity", "3,2,1,9.5", "took columns 3, 2 and 1 for x y z; the other columns are not read"},
      {"id,name,x,y,z", "7,,1,2,3", "took columns 3 to 5 for x y z; the other columns are not read"},
      {"\"x\",\"y\",\"z\"", "\"1\",\"2\",\"3\"", ""},
      {"sep=;\nx;y;z", "1;2;3", ""},
      {"t,x,y,z,", "0.5,1,2,3,", second},
      {"\"\",\"x\",\"y\",\"z\"", "7,1,2,3", second},
      {"\"id\", \"x\", \"y\", \"z\"\r", "0.5, 1, 2, 3\r", second},
      {"x,y,z,label", "1,2,3,", ""},
      {"# Columns: x y z", "1 2 3 9 9 9", "took columns 1 to 3 for x y z and columns 4 to 6 for colours"},
      {"# axes: x y z in mm", "1 2 3 9 9 9", "took columns 1 to 3 for x y z and columns 4 to 6 for colours"},
      {"time,x,y,z\ns,mm,mm,mm", "0.5,1,2,3", second},
      {"ball, 25 mm, v2", "1 2 3 0.5", first},
      {"x,y,z,i,j,k", "1,2,3,40,50,60", first},
      {"Scan of a cup\nx y z", "1 2 3", ""},
      {"x,y,z,u,v,w", "1,2,3,0,0,-1", first},
      {"x y z i j k", "1 2 3 0 0 -1", ""}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.title);
    std::string text = c.title + "\n";
    for (int i = 0; i < 20; ++i)
      text += (c.row.starts_with('7') ? std::to_string(7 + i) + c.row.substr(1) : c.row) + "\n";
    const Read read = read_xyz(text);
    ASSERT_EQ(read.cloud.points_m.cols(), 20);
    EXPECT_EQ(read.cloud.points_m.col(11), c.point);
    EXPECT_EQ(read.cloud.normals.cols(), c.title == "x y z i j k" ? 20 : 0);
    EXPECT_NE(read.note.find(c.took), std::string::npos) << read.note;
  }
  EXPECT_EQ(fault_of("t,east,north,up\n0,1,2,3\n"),
            "scan: names its columns t, east, north, up: call three of them x, y and z");
  const Read missing = read_xyz("1,2,3,5\n1,2,3,\n4,,6,7\n");
  EXPECT_EQ(missing.cloud.points_m.col(1), Vector3d(1, 2, 3));
  EXPECT_TRUE(std::isnan(missing.cloud.points_m(1, 2)));
  EXPECT_EQ(fault_of("40,,\n1,2,3\n"), "scan: says that it has 40 points, and has 1");
  EXPECT_EQ(read_xyz("a\r\r b\r\n\r\n\r1 2 3\r").cloud.points_m.cols(), 1) << "lines that end by \\r alone";
  EXPECT_EQ(fault_of("a ball\nof mine\nsince May\n1 2 3\n"), "scan: line 3: 'since' is not a number");
}

TEST(TextCloudFile, KeepsMissingValues) {
  const PointCloud cloud = read_xyz("1 2 3\nnan 1 2\n-1.#IND 1.#QNAN inf\n+1.5 -2 3\n").cloud;
  ASSERT_EQ(cloud.points_m.cols(), 4);
  EXPECT_TRUE(std::isnan(cloud.points_m(0, 1)) && std::isnan(cloud.points_m(0, 2)));
  EXPECT_EQ(cloud.points_m.col(3), Vector3d(1.5, -2, 3));
}

}  // namespace
}  // namespace thenar::text_cloud_file_test
