// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/app/refusals.h"

namespace thenar::refusals {

/// Files of objects: meshes and clouds.
inline Refusals refused_objects() {
  const auto object = [](const char* what, const char* name, const std::string& text, const char* message) {
    return Refusal{what, "new my.yaml --object FILE --unit mm --mass 80g", name, text, 3, message, ""};
  };
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 60\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  const std::string pcd =
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 50\nHEIGHT 1\nPOINTS 60\nDATA ascii\n";
  const std::string gltf =
      R"({"asset": {"version": "2.0"}, "buffers": [{"uri": "box.bin", "byteLength": 96}], "meshes": []})";
  Refusals rows{
      object("a face of a vertex that there is not", "box.obj", edited(kBox, "f 4 1 5 8", "f 4 1 5 9"),
             "FILE: line 14: there is no vertex 9"),
      object("a box without its lid", "box.obj", edited(kBox, "f 5 6 7 8\n", ""),
             "FILE: is no closed surface: 24 % of its edges have a face on one side only; close its "
             "holes, and give sheets a thickness"),
      object("a drawing in a plane", "box.obj", "v 0 0 0\nv 30 0 0\nv 30 40 0\nv 0 40 0\nf 1 2 3 4\nf 4 3 2 1\n",
             "FILE: is flat: all its faces lie in one plane, and an object has a thickness"),
      object("a download that was cut off", "box.stl", std::string(80, ' ') + bytes_of({12}) + std::string(320, '\0'),
             "FILE: is no text, which begins with 'solid', and its header says that it has 12 facets, where it has 6: "
             "is it whole? Save or download it again"),
      object("fewer points than the header says", "ball.ply", ply + ball(50),
             "FILE: line 58: the file is truncated: it ends here"),
      object("a word among the numbers", "ball.xyz", ball(17) + "1.0 two 3.0\n" + ball(17),
             "FILE: line 18: 'two' is not a number"),
      object("numbers of points that do not agree", "ball.pcd", pcd + ball(50),
             "FILE: POINTS is 60, and WIDTH times HEIGHT 50: they must be the same"),
      object("one of two files", "box.gltf", gltf, "FILE: names the file 'box.bin', which is not beside it"),
      object("a file of a CAD program", "box.step", "ISO-10303-21;\nHEADER;\n",
             "FILE: files of .step are not read: save the surface as .ply, .obj, .stl, .off, .glb, .gltf, .xyz or "
             ".pcd, as Blender, MeshLab and CAD programs do"),
      object("a pointer of Git LFS", "box.stl",
             "version https://git-lfs.github.com/spec/v1\noid sha256:0123456789abcdef\nsize 684\n",
             "FILE: is a pointer of Git LFS, not the file itself: `git lfs pull` fetches that"),
      object("the page of a download", "box.obj", "<!DOCTYPE html>\n<html><body>box.obj</body></html>\n",
             "FILE: is a web page, not the file that it shows: download that one"),
  };
  rows.push_back({"a forgotten unit", "new my.yaml --object FILE --mass 80g", "box.obj", kBox, 3,
                  "FILE: is 60 m wide, where 1 mm to 2 m make sense: are its units mm? write unit: mm, or --unit mm",
                  ""});
  return rows;
}

}  // namespace thenar::refusals
