// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/point_cloud_file.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "engine/formats/files.h"
#include "engine/formats/ply_file.h"

namespace thenar::point_cloud_file_test {
namespace {

using Eigen::Vector3d;

/// A cube of eight corners and six middles of faces, `wide` across.
std::string cube(double wide, const std::string& comment = "") {
  std::string text = comment;
  for (int i = 0; i < 14; ++i) {
    Vector3d p(i & 1, i >> 1 & 1, i >> 2 & 1);
    if (i >= 8) p = Vector3d::Constant(0.5) + (i % 2 == 0 ? 0.5 : -0.5) * Vector3d::Unit((i - 8) / 2);
    const Vector3d n = (p - Vector3d::Constant(0.5)).normalized();
    for (const double value : {wide * p.x(), wide * p.y(), wide * p.z(), n.x(), n.y(), n.z()}) {
      text += std::to_string(value) + " ";
    }
    text += "\n";
  }
  return text;
}

std::string fault_of(const std::string& bytes, const std::string& name, double unit_m = 1.0) {
  std::vector<std::string> notes;
  try {
    (void)parse_cloud(bytes, name, {.unit_m = unit_m, .samples = 100}, notes);
  } catch (const FileError& error) {
    const std::string what = error.what();
    EXPECT_TRUE(what.starts_with(name + ": ")) << what;
    return what.substr(name.size() + 2);
  }
  return "";
}

TEST(PointCloudFile, RefusesSizesThatMakeNoSense) {
  EXPECT_EQ(fault_of(cube(0.04), "mug.xyz"), "");
  EXPECT_EQ(fault_of(cube(40), "mug.xyz"),
            "is 40 m wide, where 1 mm to 2 m make sense: are its units mm? write unit: mm, or --unit mm");
  EXPECT_EQ(fault_of(cube(40), "mug.xyz", 1e-3), "");
  EXPECT_EQ(fault_of(cube(2e5), "mug.xyz"),
            "is 2e+05 m wide, where 1 mm to 2 m make sense: are its units um? write unit: um, or --unit um");
  EXPECT_EQ(fault_of(cube(0.04), "mug.xyz", 1e-3),
            "is 40 um wide, where 1 mm to 2 m make sense: are its units m? write unit: m, or --unit m");
  EXPECT_EQ(fault_of(cube(1e12), "mug.xyz"), "is 1e+12 m wide, where 1 mm to 2 m make sense");
}

TEST(PointCloudFile, GoesByTheEndingOfTheName) {
  const std::string text = cube(0.04, "# a cube\n");
  EXPECT_EQ(fault_of(text, "cube.xyz"), "");
  EXPECT_EQ(fault_of(text, "cube.XYZ"), "");
  EXPECT_EQ(fault_of(text, "cube.ply"), "is no PLY file: its first line is not 'ply'");
  EXPECT_EQ(fault_of(text, "cube.pcd").substr(0, 7), "line 2:");
  EXPECT_EQ(fault_of(text, "cube.txt"), "");
  EXPECT_EQ(fault_of(text, "cube.las"),
            "what kind of file is it? Names end in .ply, .obj, .stl, .off, .glb, .gltf, .xyz or .pcd");
  EXPECT_EQ(fault_of("\x1f\x8b bytes", "cube.obj.gz"), "is packed by gzip: unpack it first");
  EXPECT_EQ(fault_of(text, "cube.3mf"),
            "files of .3mf are not read: save the surface as .ply, .obj, .stl, .off, .glb, .gltf, .xyz or .pcd, as "
            "Blender, MeshLab and CAD programs do");
  EXPECT_TRUE(is_mesh_file("a/b.STL"));
  EXPECT_TRUE(is_mesh_file("b.obj"));
  EXPECT_TRUE(is_mesh_file("b.off"));
  EXPECT_FALSE(is_mesh_file("off.ply"));
}

TEST(PointCloudFile, ScalesPointsAndNormalisesNormals) {
  std::vector<std::string> notes;
  const PointCloud cloud = parse_cloud(cube(40), "cube.xyz", {.unit_m = 1e-3}, notes);
  EXPECT_EQ(cloud.points_m.col(7), Vector3d::Constant(40.0 * 1e-3));
  EXPECT_LT((cloud.normals.colwise().norm().array() - 1.0).abs().maxCoeff(), 1e-15);
  EXPECT_TRUE(notes.empty());
}

TEST(PointCloudFile, RefusesTooFewPoints) {
  EXPECT_EQ(fault_of("# nothing\n", "empty.xyz"), "needs at least 10 points, has 0");
  EXPECT_EQ(fault_of("0 0 0\n1 0 0\n0 1 0\n", "few.xyz"), "needs at least 10 points, has 3");
}

// What a file is that is not what its name says.
TEST(PointCloudFile, SaysWhatAFileIs) {
  const std::string page = "<!DOCTYPE html>\n<html><body>Sign in</body></html>\n";
  const std::string pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:12\nsize 34\n";
  for (const char* ending : {"stl", "obj", "ply", "off", "xyz", "pcd", "glb", "gltf"}) {
    const std::string name = std::string("mug.") + ending;
    EXPECT_EQ(fault_of("", name), "the file is empty");
    EXPECT_EQ(fault_of(std::string(200, '\0'), name), "the file is empty");
    EXPECT_EQ(fault_of(page, name), "is a web page, not the file that it shows: download that one");
    EXPECT_EQ(fault_of("\xEF\xBB\xBF\n" + page, name), "is a web page, not the file that it shows: download that one");
    EXPECT_EQ(fault_of(pointer, name), "is a pointer of Git LFS, not the file itself: `git lfs pull` fetches that");
    EXPECT_EQ(fault_of("\x1F\x8B\x08 and what it packs", name), "is packed by gzip: unpack it first");
    EXPECT_TRUE(fault_of("PK\x03\x04 and what it packs", name).starts_with("is a zip archive"));
    EXPECT_TRUE(fault_of("ISO-10303-21;\nHEADER;\n", name).starts_with("is a STEP file"));
  }
  EXPECT_EQ(fault_of("ply\nformat ascii 1.0\n", "mug.stl"), "begins as a file of .ply: name it so");
  EXPECT_EQ(fault_of("OFF\n8 6 12\n", "mug.obj"), "begins as a file of .off: name it so");
  EXPECT_EQ(fault_of("solid mug\nfacet normal 0 0 1\n", "mug.obj"), "begins as a file of .stl: name it so");
  EXPECT_EQ(fault_of("# Blender\no mug\nv 0 0 0\n", "mug.stl"), "begins as a file of .obj: name it so");
  EXPECT_EQ(fault_of("# .PCD v0.7\n", "mug.xyz"), "begins as a file of .pcd: name it so");
}

TEST(PointCloudFile, NamesAMissingFile) {
  std::vector<std::string> notes;
  try {
    (void)load_cloud("/nowhere/box.ply", {}, notes);
    FAIL();
  } catch (const FileError& error) {
    EXPECT_STREQ(error.what(), "/nowhere/box.ply: no such file");
  }
  EXPECT_THROW((void)load_cloud(testing::TempDir(), {}, notes), FileError);
  EXPECT_THROW(save_ply("/nowhere/box.ply", {}, PlyFormat::kAscii), FileError);
}

}  // namespace
}  // namespace thenar::point_cloud_file_test
