#include "engine/formats/file_kind.h"

#include <algorithm>
#include <array>
#include <string>

#include "engine/formats/files.h"
#include "engine/formats/plain_text.h"

namespace thenar {

namespace {

/// The first bytes of a kind of files, in lower case, and what to say of such a file.
struct Kind {
  std::string_view begin, what;
};
constexpr std::array<Kind, 11> kOthers = {{
    {"\x1f\x8b", "is compressed by gzip: unpack it first"},
    {"pk\x03\x04", "is a zip archive, as 3MF files are, too: unpack it, or save the surface as .stl or .obj"},
    {"7z\xbc\xaf\x27", "is a 7z archive: unpack it first"},
    {"<!doctype html", "is a web page, not the file that it shows: download that one"},
    {"<html", "is a web page, not the file that it shows: download that one"},
    {"version https://git-lfs", "is a pointer of Git LFS, not the file: fetch that one by git lfs pull"},
    {"<?xml", "is a file of XML, as of COLLADA or X3D: save the surface as .stl or .obj"},
    {"iso-10303-21", "is a STEP file: save its surface as .stl or .obj"},
    {"#vrml", "is a VRML file: save its surface as .stl or .obj"},
    {"# vtk", "is a VTK file: save its surface as .stl or .ply"},
    {"kaydara fbx", "is an FBX file: save its surface as .stl or .obj"},
}};

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

void expect_kind_of_name(std::string_view bytes, const std::filesystem::path& file) {
  if (bytes.find_first_not_of(std::string_view(" \t\r\n\0", 5)) == bytes.npos)
    throw FileError(file, "the file is empty");
  std::string text = lower_case(bytes.substr(0, 512));
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  text.erase(0, std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  for (const Kind& other : kOthers) {
    if (text.starts_with(other.begin)) throw FileError(file, std::string(other.what));
  }
  std::string ending = ending_of(file);
  if (ending == ".gltf") ending = ".glb";  // Readers take either of the two.
  const std::string by_content(ending_by_content(bytes, text));
  if (!by_content.empty() && by_content != ending) {
    throw FileError(file, "begins as a file of " + by_content + ": name it so");
  }
}

}  // namespace thenar
