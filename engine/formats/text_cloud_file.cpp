// SPDX-License-Identifier: Apache-2.0
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

/// The word without quotation marks about it.
std::string_view unquoted(std::string_view word) {
  const std::size_t begin = std::min(word.find_first_not_of("\"'"), word.size());
  return word.substr(begin, word.find_last_not_of("\"'") + 1 - begin);
}

/// What stands between the cells of a line: a comma or a semicolon, else a blank.
char separator_of(std::string_view line) {
  if (line.find(';') != line.npos) return ';';
  return line.find(',') != line.npos ? ',' : ' ';
}

/// Calls back with each part of a line between separators.
template <typename See>
void for_each_part(std::string_view line, char separator, const See& see) {
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(separator, begin), line.size());
    see(line.substr(begin, end - begin));
    begin = end + 1;
  }
}

/// Splits a line of numbers into cells at blanks, commas and semicolons. Nothing between two commas is an empty cell,
/// and so is nothing after the last one where the lines before have `width` cells.
Words row_cells(const ByteSource& source, std::string_view line, std::size_t width) {
  line = line.substr(0, comment_in(line));
  const char separator = separator_of(line);
  if (separator == ' ') return words_of(line);
  const Words blank = words_of(line);
  const bool has_both = separator == ';' && line.find(',') != line.npos;
  if (has_both || (blank.size() > 2 && std::ranges::all_of(blank, has_decimal_comma))) {
    source.fail_at_line("has commas within its numbers: write points in their place");
  }
  Words cells;
  for_each_part(line, separator, [&](std::string_view part) {
    const Words words = words_of(part);
    cells.insert(cells.end(), words.begin(), words.end());
    if (words.empty()) cells.emplace_back();
  });
  if (std::ranges::all_of(cells, &std::string_view::empty)) return {};
  while (cells.size() > width && cells.back().empty()) cells.pop_back();
  return cells;
}

/// A number of a line: nan for an empty cell, and for what Microsoft's libraries wrote for it, "-1.#IND".
std::optional<double> number_of(std::string_view word) {
  word = unquoted(word);
  return word.empty() || word.find(".#") != word.npos ? std::nan("") : number_in<double>(word);
}

double require_number(const ByteSource& source, std::string_view word) {
  const auto number = number_of(word);
  if (!number) source.fail_as_number(word);
  return *number;
}

/// Tests for a line of no numbers: a title, or a comment.
bool is_title(std::string_view line) {
  constexpr std::string_view kBetween = " \t\r\n\v\f,;\"'";
  const std::size_t begin = std::min(line.find_first_not_of(kBetween), line.size());
  const std::string_view first = line.substr(begin, line.find_first_of(kBetween, begin) - begin);
  return !first.empty() && !number_of(first);
}

bool is_comment(std::string_view line) {
  const std::size_t begin = std::min(line.find_first_not_of(" \t"), line.size());
  return line.substr(begin).starts_with('#') || line.substr(begin).starts_with('%') ||
         line.substr(begin).starts_with("//");
}

/// What the lines hold.
struct Table {
  std::vector<double> values;
  std::size_t width = 0;                 ///< Values in a line.
  char separator = ' ';                  ///< What stands between them.
  std::vector<std::string_view> titles;  ///< Comments and titles before them.
  int plain_titles = 0;                  ///< Those that are no comments.
  std::optional<std::uint64_t> count;    ///< The number of points, where a line of its own says it.
};

/// Keeps a line before the first row that has no numbers. A file may have a title, and the names of its columns.
void take_title(const ByteSource& source, std::string_view line, Table& table) {
  if (line.starts_with("sep=")) {  // So a spreadsheet is told what separates cells.
    ++table.plain_titles;
    return;
  }
  if (!is_comment(line) && ++table.plain_titles > 2) (void)require_number(source, words_of(line).front());
  table.titles.push_back(line);
}

Table read_table(ByteSource& source) {
  Table table;
  while (const auto line = source.take_any_line()) {
    const bool is_first = table.width == 0;
    if (is_comment(*line) || (is_first && is_title(*line))) {
      if (is_first) take_title(source, *line, table);
      continue;
    }
    const Words words = row_cells(source, *line, table.width);
    if (words.empty()) continue;
    // Files of scanners may have several scans, each counted.
    if (words.size() == 1 && (is_first ? !table.count : table.count.has_value())) {
      if (const auto more = number_in<std::uint64_t>(words[0])) {
        table.count = table.count.value_or(0) + *more;
        continue;
      }
    }
    if (is_first) {
      table.width = words.size();
      table.separator = separator_of(line->substr(0, comment_in(*line)));
    }
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

/// A column's name in small letters, without quotation marks and its unit: "X [mm]", "x_mm" and "x" are one.
std::string plain_name(std::string_view name) {
  std::string plain;
  for (const std::string_view word : words_of(name.substr(0, name.find_first_of("[(")))) {
    plain += (plain.empty() ? "" : "_") + std::string(word);
  }
  plain = lower_case(unquoted(plain));
  std::ranges::replace(plain, '.', '_');
  for (const std::string_view unit : {"_mm", "_cm", "_m"}) {
    if (plain.ends_with(unit)) plain.resize(plain.size() - unit.size());
  }
  return plain;
}

/// The names that a title has between its separators, after a word with a colon: "Columns: x y z".
std::vector<std::string> names_in(std::string_view title, char separator) {
  title = title.substr(std::min(title.find_first_not_of("#/% \t"), title.size()));
  if (const std::size_t colon = title.rfind(": "); colon != title.npos) title = title.substr(colon + 2);
  std::vector<std::string> names;
  if (separator == ' ') {
    for (const std::string_view word : words_of(title)) names.push_back(plain_name(word));
  } else {
    for_each_part(title, separator, [&](std::string_view part) { names.push_back(plain_name(part)); });
  }
  return names;
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

using Columns = std::array<Index, 3>;

/// Returns the columns named so, with `prefix` and one of three endings; nothing if not all three are, each once.
std::optional<Columns> named(const std::vector<std::string>& names, const std::string& prefix,
                             const std::array<std::string, 3>& endings) {
  Columns columns{};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::string name = prefix + endings[k];
    if (std::ranges::count(names, name) != 1) return std::nullopt;
    columns[k] = std::ranges::find(names, name) - names.begin();
  }
  return columns;
}

/// Returns the columns that have one of these names, with x, y and z, or numbers as ParaView writes.
std::optional<Columns> named(const std::vector<std::string>& names, const std::vector<std::string>& prefixes) {
  for (const std::string& prefix : prefixes) {
    if (const auto columns = named(names, prefix, {"x", "y", "z"})) return columns;
    if (const auto columns = named(names, prefix, {":0", ":1", ":2"})) return columns;
    if (const auto columns = named(names, prefix, {"_0", "_1", "_2"})) return columns;
  }
  return std::nullopt;
}

std::optional<Columns> named_places(const std::vector<std::string>& names) {
  return named(names, {"", "points", "point_", "pos_", "pos", "position_", "position", "p_", "p", "coord_"});
}

/// Tests whether a table's first column numbers its rows. Such a column often has no name.
bool numbers_rows(const Rows& rows) {
  for (Index i = 0; i < rows.cols(); ++i) {
    if (rows(0, i) != std::floor(rows(0, i)) || (i > 0 && !(rows(0, i) > rows(0, i - 1)))) return false;
  }
  return true;
}

/// Returns the names of a table's columns by the last of its titles that names x, y and z; nothing without one. Fails
/// for a title that names each column, and none of them so.
std::vector<std::string> names_of(const ByteSource& source, const Table& table, const Rows& rows) {
  const bool is_first_unnamed = numbers_rows(rows);
  std::vector<std::string> others;
  for (auto title = table.titles.rbegin(); title != table.titles.rend(); ++title) {
    for (const char separator : {table.separator, '\t', ' ', ',', ';'}) {
      std::vector<std::string> names = names_in(*title, separator);
      if (names.size() < 3) continue;
      while (names.size() > table.width && names.back().empty()) names.pop_back();
      const bool is_whole = names.size() == table.width;
      if (names.size() + 1 == table.width && is_first_unnamed) names.insert(names.begin(), "");
      const auto places = named_places(names);
      // A title that is shorter may be a sentence.
      if (places && names.size() <= table.width && (names.size() == table.width || std::ranges::max(*places) < 3)) {
        return names;
      }
      const bool is_of_rows = separator == table.separator && separator != ' ' && !is_comment(*title);
      if (is_whole && is_of_rows && table.width > 3) others = names;
    }
  }
  if (!others.empty()) {
    source.fail(fmt::format("names its columns {}: call three of them x, y and z", fmt::join(others, ", ")));
  }
  return {};
}

std::string in_words(const Columns& columns) {
  if (columns[1] == columns[0] + 1 && columns[2] == columns[1] + 1) {
    return fmt::format("columns {} to {}", columns[0] + 1, columns[2] + 1);
  }
  return fmt::format("columns {}, {} and {}", columns[0] + 1, columns[1] + 1, columns[2] + 1);
}

/// The points and normals of a table.
PointCloud cloud_of(const ByteSource& source, const Table& table, Notes& notes) {
  const auto width = static_cast<Index>(table.width);
  const Rows rows(table.values.data(), width, std::ssize(table.values) / width);
  const std::vector<std::string> names = names_of(source, table, rows);
  const Columns places = named_places(names).value_or(Columns{0, 1, 2});
  auto normals = named(names, {"n", "n_", "normal_", "normal", "normals", "normals_"});
  if (const auto ijk = named(names, "", {"i", "j", "k"}); !normals && ijk && (*ijk)[2] == (*ijk)[0] + 2) {
    if (are_normals(rows, (*ijk)[0])) normals = ijk;  // They may be places in an image, too.
  }
  const bool is_named = normals.has_value();
  // Where every column has a name, normals are only those that are called so.
  const bool may_be_unnamed = names.size() < table.width;
  for (Index first = 3; !is_named && may_be_unnamed && places[2] == 2 && first + 3 <= width && !normals; ++first) {
    if (are_normals(rows, first)) normals = {first, first + 1, first + 2};
  }
  PointCloud cloud{rows(places, Eigen::all), {}};
  if (normals) cloud.normals = rows(*normals, Eigen::all);
  const bool is_plain = places[0] == 0 && places[2] == 2 && (width == 3 || (width == 6 && normals));
  if (is_plain) return cloud;
  std::string note = "took " + in_words(places) + " for x y z";
  if (normals) {
    note += " and " + in_words(*normals) + " for normals" + (is_named ? "" : ", for they are of unit length");
  } else if (width == 6 && may_be_unnamed && places[2] == 2) {
    note += " and columns 4 to 6 for colours: they are not normals, which have unit length and point to all sides";
  }
  if (width > 6 || (width > 3 && !normals && !(width == 6 && may_be_unnamed && places[2] == 2)))
    note += "; the other columns are not read";
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
  if (table.plain_titles > 0 || std::ranges::any_of(table.titles, [](auto t) { return t.starts_with("//"); }))
    notes.emplace_back("passed over the line before the points");
  return cloud_of(source, table, notes);
}

}  // namespace thenar
