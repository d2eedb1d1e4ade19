#include "engine/formats/text_cloud_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/formats/byte_source.h"

namespace thenar {

namespace {

using Eigen::Index;

using Words = std::vector<std::string_view>;

/// Returns the cloud of points and, if they have six values, normals, one after another.
PointCloud cloud_of(const std::vector<double>& values, std::size_t width) {
  if (values.empty()) return {};
  const Eigen::Map<const Eigen::MatrixXd> all(values.data(), static_cast<Index>(width),
                                              std::ssize(values) / static_cast<Index>(width));
  if (width == 6) return {all.topRows<3>(), all.bottomRows<3>()};
  return {all.topRows<3>(), {}};
}

/// The header of a PCD file.
struct PcdHeader {
  std::vector<std::string> columns;  ///< A name for each value of a line; a field of several has as many.
  std::uint64_t points = 0;
};

std::uint64_t whole_number(const ByteSource& source, const Words& words) {
  const auto number = words.size() == 2 ? number_in<std::uint64_t>(words[1]) : std::nullopt;
  if (!number) source.fail_at_line(std::string(words[0]) + " must be one whole number");
  return *number;
}

/// Returns the fields, each repeated by its number in `counts`.
std::vector<std::string> columns_of(const ByteSource& source, const std::vector<std::string>& fields,
                                    const std::vector<std::uint64_t>& counts) {
  constexpr std::size_t kMostValues = 10'000;  // of a line: a histogram has some hundreds
  if (!counts.empty() && counts.size() != fields.size()) source.fail("COUNT must have one number for each of FIELDS");
  std::vector<std::string> columns;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::uint64_t count = counts.empty() ? 1 : counts[i];
    if (count > kMostValues - columns.size()) source.fail("COUNT makes more than 10000 values of a line");
    columns.insert(columns.end(), count, fields[i]);
  }
  return columns;
}

PcdHeader read_pcd_header(ByteSource& source) {
  std::vector<std::string> fields;
  std::vector<std::uint64_t> counts;
  std::optional<std::uint64_t> width, height, points;
  for (;;) {
    const Words words = words_of(source.take_line());
    if (words.empty() || words[0].starts_with('#')) continue;
    const std::string_view key = words[0];
    if (key == "FIELDS") {
      fields.assign(words.begin() + 1, words.end());
    } else if (key == "COUNT") {
      for (std::size_t i = 1; i < words.size(); ++i) counts.push_back(whole_number(source, {key, words[i]}));
    } else if (key == "WIDTH") {
      width = whole_number(source, words);
    } else if (key == "HEIGHT") {
      height = whole_number(source, words);
    } else if (key == "POINTS") {
      points = whole_number(source, words);
    } else if (key == "DATA") {
      if (words != Words{"DATA", "ascii"}) source.fail_at_line("only DATA ascii is read: save it as ascii");
      break;
    } else if (key != "VERSION" && key != "SIZE" && key != "TYPE" && key != "VIEWPOINT") {
      source.fail_at_line("'" + std::string(key) + "' is not expected in the header of a PCD file");
    }
  }
  if (fields.empty()) source.fail("the header has no FIELDS");
  if (!points && !width) source.fail("the header has neither POINTS nor WIDTH");
  // Compared as doubles, whose products do not wrap around.
  const double declared = width ? static_cast<double>(*width) * static_cast<double>(height.value_or(1)) : 0.0;
  if (points && width && declared != static_cast<double>(*points)) source.fail("POINTS is not WIDTH times HEIGHT");
  if (declared > 1e15) source.fail("WIDTH times HEIGHT is more than any file holds");
  const std::uint64_t count = points.value_or(width.value_or(0) * height.value_or(1));
  return {columns_of(source, fields, counts), count};
}

/// Returns the positions of x y z and, if present, the normals in a line.
std::vector<std::size_t> columns_of_surface(const ByteSource& source, const std::vector<std::string>& columns) {
  constexpr std::array<std::string_view, 6> kColumns = {"x", "y", "z", "normal_x", "normal_y", "normal_z"};
  std::vector<std::size_t> found;
  for (const std::string_view name : kColumns) {
    const auto first = std::ranges::find(columns, name);
    if (first == columns.end()) continue;
    if (std::ranges::count(columns, name) > 1) source.fail("FIELDS has " + std::string(name) + " more than once");
    found.push_back(static_cast<std::size_t>(first - columns.begin()));
  }
  const bool has_points = std::ranges::all_of(kColumns.begin(), kColumns.begin() + 3, [&](std::string_view name) {
    return std::ranges::find(columns, name) != columns.end();
  });
  if (!has_points) source.fail("FIELDS needs x y z");
  if (found.size() != 3 && found.size() != 6) source.fail("FIELDS needs normal_x normal_y normal_z or none of them");
  return found;
}

}  // namespace

PointCloud parse_xyz(std::string_view bytes, const std::filesystem::path& file) {
  ByteSource source(file, bytes);
  std::vector<double> values;
  std::size_t width = 0;
  while (const auto line = source.take_any_line()) {
    const Words words = words_of(line->substr(0, line->find('#')));
    if (words.empty()) continue;
    if (width == 0) width = words.size();
    if (width != 3 && width != 6) {
      source.fail_at_line("must be x y z or x y z nx ny nz, not " + std::to_string(width) + " values");
    }
    if (words.size() != width) {
      source.fail_at_line("has " + std::to_string(words.size()) + " values, the lines before it " +
                          std::to_string(width));
    }
    for (const std::string_view word : words) values.push_back(source.finite(word));
  }
  return cloud_of(values, width);
}

PointCloud parse_pcd(std::string_view bytes, const std::filesystem::path& file) {
  ByteSource source(file, bytes);
  const PcdHeader header = read_pcd_header(source);
  const std::vector<std::size_t> columns = columns_of_surface(source, header.columns);
  // Also the guard against a header that claims more than the file holds: every value has a digit and a blank.
  if (header.points > source.left() / (2 * header.columns.size())) {
    source.fail("the file is truncated: it cannot hold " + std::to_string(header.points) + " points");
  }
  std::vector<double> values;
  values.reserve(header.points * columns.size());
  for (std::uint64_t i = 0; i < header.points; ++i) {
    const Words words = words_of(source.take_line());
    if (words.size() != header.columns.size()) {
      source.fail_at_line("must have " + std::to_string(header.columns.size()) + " values, has " +
                          std::to_string(words.size()));
    }
    for (const std::size_t column : columns) values.push_back(source.finite(words[column]));
  }
  source.expect_blank_rest();
  return cloud_of(values, columns.size());
}

}  // namespace thenar
