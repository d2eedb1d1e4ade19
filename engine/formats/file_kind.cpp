// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/file_kind.h"

#include <algorithm>
#include <array>
#include <span>
#include <string>

#include "engine/formats/text.h"

namespace thenar {

namespace {

/// The first bytes of a kind of files, in lower case, what to say of such a file, and the endings of names that say it.
struct Kind {
  std::string_view begin, what, endings;
};
constexpr std::array<Kind, 6> kParcels = {{
    {"\x1f\x8b", "is packed by gzip: unpack it first", ".gz"},
    {"pk\x03\x04", "is a zip archive: unpack it first, or, of a 3MF file, save the surface as .obj or .stl",
     ".zip .npz"},
    {"7z\xbc\xaf\x27", "is a 7z archive: unpack it first", ".7z"},
    {"<!doctype html", "is a web page, not the file that it shows: download that one", ".html"},
    {"<html", "is a web page, not the file that it shows: download that one", ".html"},
    {"version https://git-lfs", "is a pointer of Git LFS, not the file itself: `git lfs pull` fetches that", ""},
}};
constexpr std::array<Kind, 5> kOtherSurfaces = {{
    {"<?xml", "is a file of XML, as of COLLADA or X3D: save the surface as .stl or .obj", ""},
    {"iso-10303-21", "is a STEP file: save its surface as .stl or .obj", ""},
    {"#vrml", "is a VRML file: save its surface as .stl or .obj", ""},
    {"# vtk", "is a VTK file: save its surface as .stl or .ply", ""},
    {"kaydara fbx", "is an FBX file: save its surface as .stl or .obj", ""},
}};

/// Returns the first 512 bytes in lower case, without a byte order mark and blanks before it.
std::string head_of(std::string_view bytes) {
  std::string head = lower_case(bytes.substr(0, 512));
  if (head.starts_with("\xEF\xBB\xBF")) head.erase(0, 3);
  head.erase(0, std::min(head.find_first_not_of(" \t\r\n"), head.size()));
  return head;
}

std::string kind_among(std::span<const Kind> kinds, std::string_view head, std::string_view ending) {
  const auto kind = std::ranges::find_if(kinds, [&](const Kind& one) { return head.starts_with(one.begin); });
  const bool is_named = kind != kinds.end() && !ending.empty() && kind->endings.find(ending) != std::string_view::npos;
  return kind == kinds.end() || is_named ? "" : std::string(kind->what);
}

/// Returns the ending that names of such files have; empty for a file that begins as no format of surfaces does.
std::string_view ending_by_content(std::string_view bytes, std::string_view text) {
  if (text.starts_with("ply\n") || text.starts_with("ply\r")) return ".ply";
  if (bytes.starts_with("glTF")) return ".glb";
  if (text.starts_with("# .pcd")) return ".pcd";
  if (text.starts_with("off\n") || text.starts_with("off\r")) return ".off";
  if (text.starts_with("solid") && text.find("facet normal") != text.npos) return ".stl";
  if (text.starts_with("v ") || text.find("\nv ") != text.npos || text.find("\nmtllib ") != text.npos) {
    return ".obj";
  }
  return "";
}

}  // namespace

std::string parcel_in(std::string_view bytes, std::string_view ending) {
  return kind_among(kParcels, head_of(bytes), ending);
}

std::string other_kind(std::string_view bytes, std::string_view ending) {
  if (bytes.find_first_not_of(std::string_view(" \t\r\n\0", 5)) == bytes.npos) return "the file is empty";
  const std::string head = head_of(bytes);
  for (const std::span<const Kind> kinds : {std::span<const Kind>(kParcels), std::span<const Kind>(kOtherSurfaces)}) {
    if (std::string what = kind_among(kinds, head, ending); !what.empty()) return what;
  }
  const std::string_view by_name = ending == ".gltf" ? ".glb" : ending;  // Readers take either of the two.
  const std::string_view by_content = ending_by_content(bytes, head);
  if (by_content.empty() || by_content == by_name) return "";
  return "begins as a file of " + std::string(by_content) + ": name it so";
}

}  // namespace thenar
