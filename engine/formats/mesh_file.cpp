// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/mesh_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>

#include "engine/formats/byte_source.h"
#include "engine/formats/files.h"
#include "engine/formats/gltf_file.h"
#include "engine/formats/mesh_builder.h"
#include "engine/formats/plain_text.h"
#include "engine/formats/ply_file.h"
#include "engine/formats/text.h"

namespace thenar {

namespace {

using Eigen::Index;
using Eigen::Vector3d;
namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "the numbers of a binary STL file are little-endian");

// Open edges: some hundredths in a scanned mesh, as rims of holes; all in loose triangles.
constexpr double kMostOpen = 0.1;
constexpr double kMostAtOdds = 0.01;

using Words = std::vector<std::string_view>;
using Notes = std::vector<std::string>;

/// Takes the words of the next line that has any; '#' begins a comment. Nothing at the end of the file.
std::optional<Words> next_words(ByteSource& source) {
  while (const auto line = source.take_any_line()) {
    Words words = words_of(line->substr(0, line->find('#')));
    if (!words.empty()) return words;
  }
  return std::nullopt;
}

/// Fails at the last line if there is a fault.
void expect_none(const ByteSource& source, const std::string& fault) {
  if (!fault.empty()) source.fail_at_line(fault);
}

/// Returns the point of the numbers of the last line from the word `first` on, of which a fourth one divides the
/// others: a place in homogeneous coordinates.
Vector3d point_of(const ByteSource& source, const Words& words, std::size_t first, bool has_fourth) {
  if (words.size() < first + (has_fourth ? 4 : 3)) {
    source.fail_at_line(has_fourth ? "a vertex needs four coordinates" : "a vertex needs three coordinates");
  }
  const auto number = [&](std::size_t i) { return source.finite(words[first + i]); };
  const Vector3d point(number(0), number(1), number(2));
  if (!has_fourth) return point;
  const double w = number(3);
  const Vector3d divided = point / w;
  if (!divided.allFinite()) source.fail_at_line("the fourth coordinate, a weight that divides the others, is 0");
  return divided;
}

/// Returns the mesh; fails without faces.
TriangleMesh mesh_of(const ByteSource& source, const MeshBuilder& mesh) {
  if (mesh.has_faces()) return mesh.mesh();
  source.fail(mesh.vertices() == 0 ? "has neither vertices nor faces: it is another kind of file than its name says"
                                   : "has no faces; points alone are read from .ply, .xyz and .pcd files");
}

// ---- OFF ----

Words require_words(ByteSource& source) {
  auto words = next_words(source);
  if (!words) source.fail_at_line("the file is truncated: it ends here");
  return std::move(*words);
}

std::uint64_t whole_number(const ByteSource& source, std::string_view word) {
  const auto number = number_in<std::uint64_t>(word);
  if (!number) source.fail_at_line("'" + std::string(word) + "' is not a whole number");
  return *number;
}

/// The beginning of an OFF file.
struct OffHead {
  bool has_fourth = false;  ///< Vertices have a fourth coordinate.
  std::uint64_t vertices = 0, faces = 0;
};

constexpr const char* kNoOff = "is no OFF file: it does not begin with 'OFF'";

OffHead read_off_head(ByteSource& source) {
  auto words = next_words(source);
  if (!words) source.fail(kNoOff);
  OffHead head;
  const std::string_view name = words->front();
  const std::size_t end = lower_case(name).find("off");
  if (end != name.npos) {
    if (name.substr(0, end).find('n') != name.npos) source.fail_at_line("nOFF, of any dimension, is not read");
    head.has_fourth = name.substr(0, end).find('4') != name.npos;
    // The numbers of vertices, faces and edges may stand in the line of the name, also without a blank.
    words->front().remove_prefix(end + 3);
    if (words->front().empty()) words->erase(words->begin());
    if (!words->empty() && words->front() == "BINARY") source.fail_at_line("OFF BINARY is not read: save it as text");
    if (words->empty()) words = require_words(source);
  } else if (!number_in<std::uint64_t>(name)) {  // The name may be left out.
    source.fail(kNoOff);
  }
  for (const bool has_line_each = words->size() == 1; has_line_each && words->size() < 3;) {
    const Words more = require_words(source);
    words->insert(words->end(), more.begin(), more.end());
  }
  head.vertices = whole_number(source, (*words)[0]);
  head.faces = whole_number(source, (*words)[1]);
  // Three values in every line, each with a digit and a blank or the line's end after it; the last may have none.
  if (head.vertices > source.left() / 6 + 1 || head.faces > source.left() / 6 + 1) {
    source.fail(
        fmt::format("the file is truncated: it cannot hold {} vertices and {} faces", head.vertices, head.faces));
  }
  return head;
}

TriangleMesh parse_off(ByteSource& source) {
  const OffHead head = read_off_head(source);
  MeshBuilder mesh;
  for (std::uint64_t i = 0; i < head.vertices; ++i) {
    expect_none(source, mesh.add_vertex(point_of(source, require_words(source), 0, head.has_fourth)));
  }
  for (std::uint64_t i = 0; i < head.faces; ++i) {
    const Words words = require_words(source);
    const std::uint64_t count = whole_number(source, words[0]);
    // Colours may follow.
    if (count >= words.size()) source.fail_at_line("has fewer corners than it says");
    std::vector<int> corners;
    for (std::size_t k = 1; k <= count; ++k) {
      const std::uint64_t corner = whole_number(source, words[k]);
      if (corner >= head.vertices) source.fail_at_line("there is no vertex " + std::string(words[k]));
      corners.push_back(static_cast<int>(corner));
    }
    expect_none(source, mesh.add_face(std::move(corners)));
  }
  // A further face means that the count is wrong; the edges that some programs write have two corners.
  if (const auto words = next_words(source)) {
    const auto count = number_in<std::uint64_t>((*words)[0]);
    if (count && *count > 2 && *count < words->size()) {
      source.fail_at_line(fmt::format("is a face beyond those that the head counts: {}", head.faces));
    }
  }
  return mesh_of(source, mesh);
}

// ---- OBJ ----

/// Takes the words of the next line that has any, and of those that it goes on in after a '\\' at its end.
std::optional<Words> next_obj_words(ByteSource& source) {
  auto words = next_words(source);
  while (words && words->back().ends_with('\\')) {
    words->back().remove_suffix(1);
    if (words->back().empty()) words->pop_back();
    const auto line = source.take_any_line();
    const Words more = line ? words_of(line->substr(0, line->find('#'))) : Words();
    words->insert(words->end(), more.begin(), more.end());
    if (words->empty()) words = next_words(source);
  }
  return words;
}

/// Returns the vertex of a corner such as "3", "3/1", "3//2" or, counted from the end, "-1".
int obj_corner(const ByteSource& source, std::string_view word, std::size_t vertices) {
  const auto number = number_in<std::int64_t>(word.substr(0, word.find('/')));
  const auto count = static_cast<std::int64_t>(vertices);
  if (!number || *number == 0 || *number > count || *number < -count) {
    source.fail_at_line("there is no vertex " + std::string(word));
  }
  return static_cast<int>(*number > 0 ? *number - 1 : count + *number);
}

TriangleMesh parse_obj(ByteSource& source, Notes& notes) {
  MeshBuilder mesh;
  Index divided = 0;
  bool has_free_form = false;
  while (const auto words = next_obj_words(source)) {
    const std::string key = lower_case(words->front());
    has_free_form = has_free_form || key == "surf" || key == "curv";
    if (key == "v") {
      // x y z; x y z w; x y z and a colour of three numbers, or of four, of which the last is its opacity.
      const bool has_fourth = words->size() == 5;
      expect_none(source, mesh.add_vertex(point_of(source, *words, 1, has_fourth)));
      if (has_fourth && source.finite((*words)[4]) != 1.0) ++divided;
    }
    if (key != "f" && key != "fo") continue;  // `fo` is `f` of old
    std::vector<int> corners;
    for (std::size_t k = 1; k < words->size(); ++k) {
      corners.push_back(obj_corner(source, (*words)[k], mesh.vertices()));
    }
    expect_none(source, mesh.add_face(std::move(corners)));
  }
  if (divided > 0) notes.push_back("divided x y z by w, the fourth coordinate, of " + counted(divided, "corner"));
  if (has_free_form && !mesh.has_faces()) {
    source.fail("has no faces, but curves or surfaces of free form, which are not read: save it as a mesh");
  }
  return mesh_of(source, mesh);
}

// ---- STL ----

constexpr std::size_t kStlTitle = 80, kStlHead = kStlTitle + sizeof(std::uint32_t), kStlFacet = 50;  // bytes

/// Tests for a text of STL, of which titles of binary files, too, may have the first word.
bool is_text_stl(std::string_view bytes) {
  if (bytes.substr(0, 512).find('\0') != bytes.npos) return false;
  const Words words = words_of(bytes.substr(0, 512));
  if (words.empty()) return false;
  const std::string first = lower_case(words.front());
  return first == "solid" || first == "facet" || first.starts_with('#');
}

/// Returns the number of facets that the header of a binary file says.
std::uint32_t facets_declared(std::string_view bytes) {
  std::uint32_t facets = 0;
  std::memcpy(&facets, bytes.data() + kStlTitle, sizeof facets);
  return facets;
}

/// Returns the number of facets of a binary file; nothing if its size does not match.
std::optional<std::uint32_t> binary_stl_facets(std::string_view bytes) {
  if (bytes.size() < kStlHead) return std::nullopt;
  const std::uint32_t facets = facets_declared(bytes);
  const std::size_t size = kStlHead + kStlFacet * facets;
  // Some programs write a few bytes more.
  const bool fits = bytes.size() == size || (bytes.size() > size && bytes.size() - size < kStlFacet);
  return fits && (bytes.size() == size || !is_text_stl(bytes)) ? std::optional(facets) : std::nullopt;
}

TriangleMesh parse_binary_stl(ByteSource& source, std::uint32_t facets, Notes& notes) {
  MeshBuilder mesh;
  source.take(kStlHead, "it ends here");
  for (std::uint32_t i = 0; i < facets; ++i) {
    // A normal, three vertices, and two bytes of no meaning.
    float values[12];
    std::memcpy(values, source.take(kStlFacet, "it ends here").data(), sizeof values);
    for (int k = 3; k < 12; k += 3) {
      const Vector3d vertex(values[k], values[k + 1], values[k + 2]);
      if (!vertex.allFinite()) source.fail_at_byte("the facet before this has a vertex that is not finite");
      if (const std::string fault = mesh.add_vertex(vertex); !fault.empty()) source.fail(fault);
    }
    mesh.add_triangle();
  }
  if (!source.has_blank_rest()) {
    notes.push_back("passed over " + counted(static_cast<Index>(source.left()), "byte") + " behind the last facet");
  }
  return mesh_of(source, mesh);
}

/// Returns the place in a line of the first facet from the word `i` on; the line's end if there is none.
std::size_t facet_in(const Words& words, std::size_t i) {
  while (i + 1 < words.size() && (lower_case(words[i]) != "facet" || lower_case(words[i + 1]) != "normal")) ++i;
  return i + 1 < words.size() ? i : words.size();
}

/// Reads facets whose keywords may share lines, and be in two words, such as "end loop".
TriangleMesh parse_text_stl(ByteSource& source) {
  MeshBuilder mesh;
  std::size_t corners = 0;
  bool is_open = false;
  while (const auto words = next_words(source)) {
    for (std::size_t i = 0; i < words->size(); ++i) {
      std::string key = lower_case((*words)[i]);
      if (key == "end" && i + 1 < words->size()) key += lower_case((*words)[++i]);
      if (key == "solid" || key == "endsolid") {
        // The name of a solid fills its line, unless facets do.
        const std::size_t facet = facet_in(*words, i + 1);
        is_open = key == "solid" || facet < words->size();
        i = facet - 1;
      }
      if (key == "vertex") {
        expect_none(source, mesh.add_vertex(point_of(source, *words, i + 1, false)));
        ++corners;
        i += 3;
      }
      if (key != "endfacet") continue;
      if (corners != 3) source.fail_at_line("a facet must have three vertices, has " + std::to_string(corners));
      mesh.add_triangle();
      corners = 0;
    }
  }
  if (is_open) source.fail_at_line("the file is truncated: 'endsolid' is missing");
  if (corners > 0) source.fail_at_line("the file is truncated: 'endfacet' is missing");
  return mesh_of(source, mesh);
}

TriangleMesh parse_stl(std::string_view bytes, const fs::path& file, Notes& notes) {
  // Binary files, too, may begin with "solid": their size identifies them.
  ByteSource binary(file, bytes);
  if (const auto facets = binary_stl_facets(bytes)) return parse_binary_stl(binary, *facets, notes);
  std::string store;
  const std::string_view text = plain_text(bytes, file, store);
  ByteSource source(file, text);
  if (is_text_stl(text)) return parse_text_stl(source);
  if (bytes.size() < kStlHead) source.fail("is no STL file: a text begins with 'solid', and a binary file is longer");
  source.fail(
      fmt::format("is no text, which begins with 'solid', and its header says that it has {} facets, where it "
                  "has {}: is it whole? Save or download it again",
                  facets_declared(bytes), (bytes.size() - kStlHead) / kStlFacet));
}

// ---- PLY ----

TriangleMesh parse_ply_mesh(std::string_view bytes, const fs::path& file, Notes& notes) {
  PlyFile ply = parse_ply(bytes, file, notes);
  if (!ply.mesh) throw FileError(file, "has no faces");
  return std::move(*ply.mesh);
}

}  // namespace

TriangleMesh parse_mesh(std::string_view bytes, const fs::path& file, Notes& notes) {
  const std::string ending = ending_of(file);
  if (ending == ".stl") return parse_stl(bytes, file, notes);
  if (ending == ".ply") return parse_ply_mesh(bytes, file, notes);
  if (ending == ".glb" || ending == ".gltf") return parse_gltf(bytes, file, notes);
  std::string store;
  ByteSource source(file, plain_text(bytes, file, store));
  if (ending == ".off") return parse_off(source);
  if (ending == ".obj") return parse_obj(source, notes);
  source.fail("is no mesh: names of meshes end in .obj, .stl, .off, .ply, .glb or .gltf");
}

void mend_mesh(TriangleMesh& mesh, const fs::path& file, Notes& notes) {
  const MeshMending mending = mend(mesh);
  if (mesh.triangles.cols() == 0) throw FileError(file, "its faces have no area");
  const auto share = [&](Index edges) { return static_cast<double>(edges) / static_cast<double>(mending.edges); };
  if (share(mending.open_edges) > kMostOpen) {
    throw FileError(file,
                    fmt::format("is no closed surface: {:.0f} % of its edges have a face on one side only; close its "
                                "holes, and give sheets a thickness",
                                100.0 * share(mending.open_edges)));
  }
  if (share(mending.at_odds) > kMostAtOdds) {
    throw FileError(file, fmt::format("has no outside: the faces along {:.0f} % of its edges cannot agree on one; make "
                                      "a closed surface of it, as Blender's modifier Remesh does",
                                      100.0 * share(mending.at_odds)));
  }
  if (mending.dropped > 0) notes.push_back(fmt::format("left out {} without area", counted(mending.dropped, "face")));
  if (mending.doubled > 0) {
    notes.push_back(fmt::format("left out {} that lie on others", counted(mending.doubled, "face")));
  }
  if (mending.turned > 0) {
    notes.push_back(
        fmt::format("turned {} of {}, wound the other way", counted(mending.turned, "face"), mesh.triangles.cols()));
  }
  if (mending.split > 0) {
    notes.push_back(fmt::format("split {} at corners that lie on them", counted(mending.split, "edge")));
  }
  if (mending.joined_m > 0.0) notes.emplace_back("joined corners that are up to a millionth of the size apart");
  if (mending.open_edges > 0) notes.push_back(fmt::format("the mesh has {}", counted(mending.open_edges, "open edge")));
}

PointCloud sample_mended_mesh(const TriangleMesh& mesh, const fs::path& file, Index samples, Notes& notes) {
  try {
    double covered = 0.0;
    PointCloud cloud = sample_mesh(mesh, samples, 1, &covered);
    if (covered > 0.0) {
      notes.push_back(
          fmt::format("left out {:.2g} % of the faces, inside of other solids of the mesh", 100.0 * covered));
    }
    return cloud;
  } catch (const std::invalid_argument& error) {  // areas beyond the range of numbers
    throw FileError(file, error.what());
  }
}

}  // namespace thenar
