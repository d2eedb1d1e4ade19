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
// More corners than the end of any cylinder has; cutting up a face takes their square in time.
constexpr std::size_t kMostCorners = 1000;
constexpr std::size_t kMostVertices = 1'000'000'000;  // numbers of vertices are 32 bits wide

using Words = std::vector<std::string_view>;

/// A builder of vertices and triangles in the order of reading.
class MeshBuilder {
 public:
  explicit MeshBuilder(const ByteSource& source) : source_(source) {}

  [[nodiscard]] std::size_t vertices() const { return vertices_.size() / 3; }

  void add_vertex(double x, double y, double z) {
    if (vertices() == kMostVertices) source_.fail("has too many vertices");
    vertices_.insert(vertices_.end(), {x, y, z});
  }
  /// Adds a vertex of three numbers of the last line, from the word `first` on.
  void add_vertex(const Words& words, std::size_t first) {
    if (words.size() < first + 3) source_.fail_at_line("a vertex needs three coordinates");
    add_vertex(source_.finite(words[first]), source_.finite(words[first + 1]), source_.finite(words[first + 2]));
  }
  /// Adds a face of the last line by its vertices, counted from 0.
  void add_face(const std::vector<int>& corners) {
    if (corners.size() < 3) source_.fail_at_line("a face needs at least three corners");
    if (corners.size() > kMostCorners) source_.fail_at_line("a face must not have more than 1000 corners");
    const Eigen::Map<const Eigen::Matrix3Xd> vertices(vertices_.data(), 3, static_cast<Index>(this->vertices()));
    for (const Eigen::Vector3i& triangle : cut_polygon(vertices(Eigen::all, corners))) {
      for (const int corner : triangle) triangles_.push_back(corners[corner]);
    }
  }
  /// Adds a triangle of the last three vertices.
  void add_triangle() {
    const auto end = static_cast<int>(vertices());
    triangles_.insert(triangles_.end(), {end - 3, end - 2, end - 1});
  }

  [[nodiscard]] TriangleMesh mesh() const {
    if (triangles_.empty()) source_.fail("has no faces");
    return {Eigen::Map<const Eigen::Matrix3Xd>(vertices_.data(), 3, std::ssize(vertices_) / 3),
            Eigen::Map<const Eigen::Matrix3Xi>(triangles_.data(), 3, std::ssize(triangles_) / 3)};
  }

 private:
  const ByteSource& source_;
  std::vector<double> vertices_;
  std::vector<int> triangles_;
};

/// Takes the words of the next line that has any; '#' begins a comment. Nothing at the end of the file.
std::optional<Words> next_words(ByteSource& source) {
  while (const auto line = source.take_any_line()) {
    Words words = words_of(line->substr(0, line->find('#')));
    if (!words.empty()) return words;
  }
  return std::nullopt;
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

TriangleMesh parse_off(ByteSource& source) {
  auto head = next_words(source);
  if (!head || !head->front().ends_with("OFF")) source.fail("not an OFF file");
  // The numbers of vertices, faces and edges may stand in the line of the name.
  head->erase(head->begin());
  if (head->empty()) head = require_words(source);
  if (head->size() < 2) source.fail_at_line("needs the numbers of vertices, faces and edges");
  const std::uint64_t vertices = whole_number(source, (*head)[0]), faces = whole_number(source, (*head)[1]);
  // Three values in every line, each with a digit and a blank or the line's end after it; the last may have none.
  if (vertices > source.left() / 6 + 1 || faces > source.left() / 6 + 1) {
    source.fail(fmt::format("the file is truncated: it cannot hold {} vertices and {} faces", vertices, faces));
  }
  MeshBuilder mesh(source);
  for (std::uint64_t i = 0; i < vertices; ++i) mesh.add_vertex(require_words(source), 0);
  for (std::uint64_t i = 0; i < faces; ++i) {
    const Words words = require_words(source);
    const std::uint64_t count = whole_number(source, words[0]);
    // Colours may follow.
    if (count >= words.size()) source.fail_at_line("has fewer corners than it says");
    std::vector<int> corners;
    for (std::size_t k = 1; k <= count; ++k) {
      const std::uint64_t corner = whole_number(source, words[k]);
      if (corner >= vertices) source.fail_at_line("there is no vertex " + std::string(words[k]));
      corners.push_back(static_cast<int>(corner));
    }
    mesh.add_face(corners);
  }
  return mesh.mesh();
}

// ---- OBJ ----

/// Returns the vertex of a corner such as "3", "3/1", "3//2" or, counted from the end, "-1".
int obj_corner(const ByteSource& source, std::string_view word, std::size_t vertices) {
  const auto number = number_in<std::int64_t>(word.substr(0, word.find('/')));
  const auto count = static_cast<std::int64_t>(vertices);
  if (!number || *number == 0 || *number > count || *number < -count) {
    source.fail_at_line("there is no vertex " + std::string(word));
  }
  return static_cast<int>(*number > 0 ? *number - 1 : count + *number);
}

TriangleMesh parse_obj(ByteSource& source) {
  MeshBuilder mesh(source);
  while (const auto words = next_words(source)) {
    if (words->back().ends_with('\\')) source.fail_at_line("lines that go on in the next one are not read");
    if (words->front() == "v") mesh.add_vertex(*words, 1);
    if (words->front() != "f") continue;
    std::vector<int> corners;
    for (std::size_t k = 1; k < words->size(); ++k) {
      corners.push_back(obj_corner(source, (*words)[k], mesh.vertices()));
    }
    mesh.add_face(corners);
  }
  return mesh.mesh();
}

// ---- STL ----

constexpr std::size_t kStlTitle = 80, kStlFacet = 50;  // bytes

/// Returns the number of facets of a binary file; nothing if its size does not match.
std::optional<std::uint32_t> binary_stl_facets(std::string_view bytes) {
  std::uint32_t facets = 0;
  if (bytes.size() < kStlTitle + sizeof facets) return std::nullopt;
  std::memcpy(&facets, bytes.data() + kStlTitle, sizeof facets);
  if (bytes.size() != kStlTitle + sizeof facets + kStlFacet * facets) return std::nullopt;
  return facets;
}

TriangleMesh parse_binary_stl(ByteSource& source, std::uint32_t facets) {
  MeshBuilder mesh(source);
  source.take(kStlTitle + sizeof facets, "it ends here");
  for (std::uint32_t i = 0; i < facets; ++i) {
    // A normal, three vertices, and two bytes of no meaning.
    float values[12];
    std::memcpy(values, source.take(kStlFacet, "it ends here").data(), sizeof values);
    for (int k = 3; k < 12; k += 3) {
      const Vector3d vertex(values[k], values[k + 1], values[k + 2]);
      if (!vertex.allFinite()) source.fail_at_byte("the facet before this has a vertex that is not finite");
      mesh.add_vertex(vertex.x(), vertex.y(), vertex.z());
    }
    mesh.add_triangle();
  }
  return mesh.mesh();
}

TriangleMesh parse_text_stl(ByteSource& source) {
  MeshBuilder mesh(source);
  std::size_t corners = 0;
  bool is_open = false;
  while (const auto words = next_words(source)) {
    const std::string_view key = words->front();
    if (key == "solid" || key == "endsolid") is_open = key == "solid";
    if (key == "vertex") {
      mesh.add_vertex(*words, 1);
      ++corners;
    }
    if (key != "endfacet") continue;
    if (corners != 3) source.fail_at_line("a facet must have three vertices, has " + std::to_string(corners));
    mesh.add_triangle();
    corners = 0;
  }
  if (is_open) source.fail_at_line("the file is truncated: 'endsolid' is missing");
  if (corners > 0) source.fail_at_line("the file is truncated: 'endfacet' is missing");
  return mesh.mesh();
}

TriangleMesh parse_stl(ByteSource& source) {
  // Binary files, too, may begin with "solid": their size identifies them.
  if (const auto facets = binary_stl_facets(source.rest())) return parse_binary_stl(source, *facets);
  if (source.rest().starts_with("solid")) return parse_text_stl(source);
  source.fail("neither begins with 'solid' nor has the size that a binary STL file of its facets has");
}

}  // namespace

TriangleMesh parse_mesh(std::string_view bytes, const fs::path& file) {
  ByteSource source(file, bytes);
  const std::string ending = ending_of(file);
  if (ending == ".off") return parse_off(source);
  if (ending == ".obj") return parse_obj(source);
  if (ending == ".stl") return parse_stl(source);
  source.fail("is no mesh: names of meshes end in .obj, .stl or .off");
}

PointCloud sample_mesh_file(std::string_view bytes, const fs::path& file, Index samples,
                            std::vector<std::string>& notes) {
  TriangleMesh mesh = parse_mesh(bytes, file);
  const MeshMending mending = mend(mesh);
  if (mesh.triangles.cols() == 0) throw FileError(file, "its faces have no area");
  const auto share = [&](Index edges) { return static_cast<double>(edges) / static_cast<double>(mending.edges); };
  if (share(mending.open_edges) > kMostOpen) {
    throw FileError(file, fmt::format("is no closed surface: {:.0f} % of its edges have a face on one side only",
                                      100.0 * share(mending.open_edges)));
  }
  if (share(mending.at_odds) > kMostAtOdds) {
    throw FileError(file, fmt::format("has no outside: the faces along {:.0f} % of its edges cannot agree on one",
                                      100.0 * share(mending.at_odds)));
  }
  if (mending.dropped > 0) notes.push_back(fmt::format("left out {} without area", counted(mending.dropped, "face")));
  if (mending.turned > 0) {
    notes.push_back(
        fmt::format("turned {} of {}, wound the other way", counted(mending.turned, "face"), mesh.triangles.cols()));
  }
  if (mending.open_edges > 0) notes.push_back(fmt::format("the mesh has {}", counted(mending.open_edges, "open edge")));
  try {
    return sample_mesh(mesh, samples);
  } catch (const std::invalid_argument& error) {  // areas beyond the range of numbers
    throw FileError(file, error.what());
  }
}

}  // namespace thenar
