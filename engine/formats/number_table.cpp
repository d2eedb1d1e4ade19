// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/number_table.h"

#include <cmath>
#include <limits>
#include <optional>

#include "engine/formats/byte_source.h"
#include "engine/formats/files.h"
#include "engine/formats/text.h"

namespace thenar {

namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t begin = text.find_first_not_of(kBlank);
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) + 1 - begin);
}

/// Splits a line into cells. Names in quotes contain no comma here.
std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.push_back(trimmed(line.substr(0, comma)));
    if (comma == line.npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

double number_of(const ByteSource& source, std::string_view cell) {
  if (cell.empty() || cell == "nan") return std::numeric_limits<double>::quiet_NaN();
  return source.finite(cell);
}

}  // namespace

NumberTable parse_number_table(const std::filesystem::path& file, std::string_view bytes) {
  ByteSource source(file, bytes);
  NumberTable table;
  std::vector<double> numbers;
  std::size_t line_number = 0;
  while (const std::optional<std::string_view> line = source.take_any_line()) {
    ++line_number;
    if (trimmed(*line).empty()) continue;
    const std::vector<std::string_view> cells = cells_of(*line);
    if (table.names.empty()) {
      for (const std::string_view cell : cells) {
        if (cell.empty()) source.fail_at_line("a column has no name");
        table.names.emplace_back(printable(cell));
      }
      continue;
    }
    if (cells.size() != table.names.size()) {
      source.fail_at_line(counted(std::ssize(cells), "value") + " below " + counted(std::ssize(table.names), "name"));
    }
    for (const std::string_view cell : cells) numbers.push_back(number_of(source, cell));
    table.lines.push_back(line_number);
  }
  if (table.lines.empty()) source.fail("is no table: a line of names, and lines of numbers with commas between");
  table.numbers = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      numbers.data(), std::ssize(table.lines), std::ssize(table.names));
  return table;
}

NumberTable read_number_table(const std::filesystem::path& file) { return parse_number_table(file, read_file(file)); }

}  // namespace thenar
