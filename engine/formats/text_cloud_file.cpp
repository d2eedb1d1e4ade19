#include "engine/formats/text_cloud_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "engine/formats/byte_source.h"
#include "engine/formats/plain_text.h"
#include "engine/formats/text.h"

namespace thenar {

namespace {

using Eigen::Index;

using Words = std::vector<std::string_view>;
using Notes = std::vector<std::string>;
/// The values of all lines, one after another.
using Rows = Eigen::Map<const Eigen::MatrixXd>;

/// Tests for a number with a comma in the place of the point: "1,5".
bool has_decimal_comma(std::string_view word) {
  const std::size_t comma = word.find(',');
  const auto is_digit = [&](std::size_t i) { return i < word.size() && word[i] >= '0' && word[i] <= '9'; };
  return comma != word.npos && comma > 0 && is_digit(comma - 1) && is_digit(comma + 1) &&
         word.find(',', comma + 1) == word.npos;
}

/// Returns where a comment begins: at a '#' that is not within a word, as in "-1.#IND".
std::size_t comment_in(std::string_view line) {
  for (std::size_t at = line.find('#'); at != line.npos; at = line.find('#', at + 1)) {
    if (at == 0 || line[at - 1] != '.') return at;
  }
  return line.npos;
}

/// Splits a line at blanks, commas and semicolons.
Words words_of_row(const ByteSource& source, std::string_view line) {
  line = line.substr(0, comment_in(line));
  const Words blank = words_of(line);
  if (line.find_first_of(",;") == line.npos) return blank;
  const bool has_both = line.find(';') != line.npos && line.find(',') != line.npos;
  if (has_both || (blank.size() > 2 && std::ranges::all_of(blank, has_decimal_comma))) {
    source.fail_at_line("has commas within its numbers: write points in their place");
  }
  Words words;
  for (std::size_t begin = 0; begin < line.size();) {
    constexpr std::string_view kBetween = " \t\r\n\v\f,;";
    begin = std::min(line.find_first_not_of(kBetween, begin), line.size());
    const std::size_t end = std::min(line.find_first_of(kBetween, begin), line.size());
    if (begin < end) words.push_back(line.substr(begin, end - begin));
    begin = end;
  }
  return words;
}

/// A number of a line; nan and its kin also as Microsoft's libraries wrote them, "-1.#IND".
std::optional<double> number_of(std::string_view word) {
  return word.find(".#") != word.npos ? std::nan("") : number_in<double>(word);
}

double require_number(const ByteSource& source, std::string_view word) {
  const auto number = number_of(word);
  if (!number) source.fail_as_number(word);
  return *number;
}

/// What the lines hold.
struct Table {
  std::vector<double> values;
  std::size_t width = 0;               ///< Values in a line.
  std::vector<std::string> title;      ///< The words of the line before them; fewer name the last columns.
  std::optional<std::uint64_t> count;  ///< The number of points, where a line of its own says it.
};

/// The words of a title, without what they stand in.
std::vector<std::string> title_of(const Words& words) {
  std::vector<std::string> title;
  for (std::string_view word : words) {
    const std::size_t begin = std::min(word.find_first_not_of("/\"'"), word.size());
    word = word.substr(begin, word.find_last_not_of("\"'") + 1 - begin);
    if (!word.empty()) title.push_back(lower_case(word));
  }
  return title;
}

Table read_table(ByteSource& source) {
  Table table;
  const auto is_number = [](std::string_view word) { return number_of(word).has_value(); };
  while (const auto line = source.take_any_line()) {
    const Words words = words_of_row(source, *line);
    if (words.empty()) continue;
    const bool is_first = table.width == 0;
    const bool is_comment = words[0].starts_with("//");
    if (is_comment && !is_first) continue;
    if (is_first && table.title.empty() && (is_comment || !is_number(words[0]))) {
      table.title = title_of(words);
      continue;
    }
    if (is_first && words.size() == 1 && !table.count) {
      table.count = number_in<std::uint64_t>(words[0]);
      if (table.count) continue;
    }
    if (!is_first && words.size() == 1 && table.count) {  // Files of scanners may have several scans, each counted.
      if (const auto more = number_in<std::uint64_t>(words[0])) {
        *table.count += *more;
        continue;
      }
    }
    if (is_first) table.width = words.size();
    if (table.width < 3) {
      source.fail_at_line("must be x y z or x y z nx ny nz, not " + counted(std::ssize(words), "value"));
    }
    if (words.size() != table.width) {
      source.fail_at_line("has " + std::to_string(words.size()) + " values, the lines before it " +
                          std::to_string(table.width));
    }
    for (const std::string_view word : words) table.values.push_back(require_number(source, word));
  }
  return table;
}

/// Tests whether three columns may be outward normals: nearly all are of unit length, and not all have only positive
/// values, as colours do.
bool are_normals(const Rows& rows, Index first) {
  const auto all = rows.middleRows<3>(first);
  const Index few = 10;  // Fewer are no surface.
  Index unit = 0, some = 0;
  bool is_any_negative = false;
  for (const auto row : all.colwise()) {
    if (!row.allFinite() || row.isZero(0.0)) continue;
    ++some;
    // With two digits after the point a normal's length is off by some hundredths.
    if (std::abs(row.stableNorm() - 1.0) < 0.02) ++unit;
    is_any_negative = is_any_negative || row.minCoeff() < 0.0;
  }
  return 10 * unit > 9 * some && (is_any_negative || rows.cols() < few);
}

/// Returns the columns that a title names so, with `prefix` and one of three endings; nothing if it does not name all
/// three, or more than once. The numbers of rows, as tables have them first, have no name.
std::optional<std::array<Index, 3>> named(const Table& table, const std::string& prefix,
                                          const std::array<std::string, 3>& endings) {
  const std::size_t unnamed = table.width - std::min(table.width, table.title.size());
  if (table.title.size() > table.width || unnamed > 1) return std::nullopt;
  std::array<Index, 3> columns{};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::string name = prefix + endings[k];
    if (std::ranges::count(table.title, name) != 1) return std::nullopt;
    columns[k] = std::ranges::find(table.title, name) - table.title.begin() + static_cast<Index>(unnamed);
  }
  return columns;
}

/// Returns the columns that a title gives one of these names, with x, y and z, or numbers as ParaView writes.
std::optional<std::array<Index, 3>> named(const Table& table, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (const auto columns = named(table, name, {"x", "y", "z"})) return columns;
    if (const auto columns = named(table, name, {":0", ":1", ":2"})) return columns;
    if (const auto columns = named(table, name, {"_0", "_1", "_2"})) return columns;
  }
  return std::nullopt;
}

std::string in_words(const std::array<Index, 3>& columns) {
  if (columns[1] == columns[0] + 1 && columns[2] == columns[1] + 1) {
    return fmt::format("columns {} to {}", columns[0] + 1, columns[2] + 1);
  }
  return fmt::format("columns {}, {} and {}", columns[0] + 1, columns[1] + 1, columns[2] + 1);
}

/// The points and normals of a table.
PointCloud cloud_of(const Table& table, Notes& notes) {
  const auto width = static_cast<Index>(table.width);
  const Rows rows(table.values.data(), width, std::ssize(table.values) / width);
  const auto places = named(table, {"", "points"}).value_or(std::array<Index, 3>{0, 1, 2});
  auto normals = named(table, {"n", "normal_", "normal", "normals"});
  const bool is_named = normals.has_value();
  for (Index first = 3; !is_named && places[2] == 2 && first + 3 <= width && !normals; ++first) {
    if (are_normals(rows, first)) normals = {first, first + 1, first + 2};
  }
  PointCloud cloud{rows(places, Eigen::all), {}};
  if (normals) cloud.normals = rows(*normals, Eigen::all);
  const bool is_plain = places[0] == 0 && places[2] == 2 && (width == 3 || (width == 6 && normals));
  if (is_plain) return cloud;
  std::string note = "took " + in_words(places) + " for x y z";
  if (normals) {
    note += " and " + in_words(*normals) + " for normals" + (is_named ? "" : ", for they are of unit length");
  } else if (width == 6) {
    note += " and columns 4 to 6 for colours: they are not normals, which have unit length and point to all sides";
  }
  if (width > (normals ? 6 : 3) && !(width == 6 && !normals)) note += "; the other columns are not read";
  notes.push_back(note);
  return cloud;
}

}  // namespace

PointCloud parse_xyz(std::string_view bytes, const std::filesystem::path& file, Notes& notes) {
  std::string store;
  ByteSource source(file, plain_text(bytes, file, store));
  const Table table = read_table(source);
  if (table.width == 0) return {};
  const std::size_t points = table.values.size() / table.width;
  if (table.count && *table.count != points) {
    source.fail(fmt::format("says that it has {} points, and has {}", *table.count, points));
  }
  if (!table.title.empty()) notes.emplace_back("passed over the line before the points");
  return cloud_of(table, notes);
}

}  // namespace thenar
