// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/contact_file.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "engine/formats/byte_source.h"
#include "engine/formats/files.h"

namespace thenar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
namespace fs = std::filesystem;

namespace {

static_assert(std::endian::native == std::endian::little, "the doubles of an .fcp file are little-endian");

// Limits of an .fcp header: far beyond solvable sizes, and small enough for sizes in bytes to fit 64 bits.
constexpr Index kMostContacts = 1'000'000, kMostSteps = 1'000'000;
constexpr std::size_t kLongestLine = 4096;  // Longest line of a header; a longer one is no header.
// Tolerance on the symmetry of a matrix summed in different orders.
constexpr double kRounding = 1e-12;

struct HeaderLine {
  std::string value;
  int line = 0;
};

/// The header of an .fcp file, and its end.
class FcpHeader {
 public:
  FcpHeader(const fs::path& file, const std::string& bytes) : file_(file) {
    if (!bytes.starts_with("fcp ")) throw FileError(file, "line 1: must be 'fcp 1': this is no contact problem");
    for (int line = 1;; ++line) {
      const std::size_t end = bytes.find('\n', size_);
      if (end == std::string::npos || end - size_ > kLongestLine) fail(line, "'end_header' is missing");
      const std::string text = bytes.substr(size_, end - size_);
      size_ = end + 1;
      if (text.ends_with('\r')) fail(line, "ends with CR LF: a conversion of line ends has broken the numbers, too");
      if (text == "end_header") break;
      const std::size_t space = text.find(' ');
      if (space == 0 || space == std::string::npos) fail(line, "must be 'key value' or 'end_header'");
      const bool is_new = lines_.try_emplace(text.substr(0, space), HeaderLine{text.substr(space + 1), line}).second;
      if (!is_new) fail(line, "has '" + text.substr(0, space) + "' again");
    }
    if (text("fcp") != "1") fail(1, "must be 'fcp 1': this reader knows no other version");
  }

  /// Returns the bytes of the header, its last line end included.
  [[nodiscard]] std::size_t size() const { return size_; }
  /// Returns the text of a key; empty if there is none.
  [[nodiscard]] std::string text(const std::string& key) const {
    const auto found = lines_.find(key);
    return found == lines_.end() ? "" : found->second.value;
  }
  /// Returns a whole number within [low, high]; without the key `otherwise`, or an error if that is less than `low`.
  [[nodiscard]] Index integer(const std::string& key, Index low, Index high, Index otherwise = -1) const {
    const auto found = lines_.find(key);
    if (found == lines_.end()) {
      if (otherwise >= low) return otherwise;
      throw FileError(file_, "the header has no '" + key + "'");
    }
    const auto number = number_in<Index>(found->second.value);
    if (!number || *number < low || *number > high) {
      fail(found->second.line,
           "'" + key + "' must be a whole number within " + std::to_string(low) + " .. " + std::to_string(high));
    }
    return *number;
  }
  /// Returns a number; 0 if there is none.
  [[nodiscard]] double number(const std::string& key) const {
    const auto found = lines_.find(key);
    if (found == lines_.end()) return 0.0;
    const auto number = number_in<double>(found->second.value);
    if (!number || !std::isfinite(*number)) fail(found->second.line, "'" + key + "' must be a number");
    return *number;
  }

 private:
  [[noreturn]] void fail(int line, const std::string& what) const {
    throw FileError(file_, "line " + std::to_string(line) + ": " + what);
  }

  const fs::path& file_;
  std::size_t size_ = 0;
  std::map<std::string, HeaderLine> lines_;
};

/// A reader of the doubles after the header, one vector after another.
class Doubles {
 public:
  Doubles(const fs::path& file, std::string_view bytes) : file_(file), bytes_(bytes) {}

  VectorXd take(const char* name, Index size) {
    VectorXd values(size);
    const std::size_t bytes = static_cast<std::size_t>(size) * sizeof(double);
    std::memcpy(values.data(), bytes_.data(), bytes);
    bytes_.remove_prefix(bytes);
    const Index bad = first_not_finite(values);
    if (bad >= 0)
      throw FileError(file_, std::string(name) + ": value " + std::to_string(bad + 1) + " of " + std::to_string(size) +
                                 " is not finite");
    return values;
  }

 private:
  const fs::path& file_;
  std::string_view bytes_;
};

bool is_symmetric(const MatrixXd& W) {
  return (W - W.transpose()).cwiseAbs().maxCoeff() <= kRounding * W.cwiseAbs().maxCoeff();
}

void append(std::string& bytes, const VectorXd& values) {
  const std::size_t size = static_cast<std::size_t>(values.size()) * sizeof(double);
  bytes.append(reinterpret_cast<const char*>(values.data()), size);
}

void append_line(std::string& header, const char* key, std::string value) {
  if (value.empty()) return;
  // A line end within would begin another key.
  std::replace_if(
      value.begin(), value.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  header += std::string(key) + " " + value + "\n";
}

}  // namespace

void check_status(const fs::path& file, const std::string& where, const std::string& status,
                  std::initializer_list<const char*> known) {
  if (status.empty() || std::find(known.begin(), known.end(), status) != known.end()) return;
  throw FileError(file, where + " must be " + *known.begin() + " or " + *(known.end() - 1));
}

ContactFile read_contact_problem(const fs::path& file, const std::string& bytes) {
  const FcpHeader header(file, bytes);
  const Index contacts = header.integer("contacts", 1, kMostContacts);
  const Index steps = header.integer("steps", 1, kMostSteps, 1);
  const bool has_reference = header.integer("has_ref", 0, 1, 0) == 1;
  const bool has_f_last = header.integer("has_f_last", 0, 1, 0) == 1;
  const Index rows = 3 * contacts;

  // Before any memory is taken for it: a wrong number of contacts must not ask for a terabyte.
  const Index doubles =
      rows * rows + steps * rows + contacts + (has_reference ? 2 * rows : 0) + (has_f_last ? rows : 0);
  const std::size_t expected = header.size() + static_cast<std::size_t>(doubles) * sizeof(double);
  if (bytes.size() != expected) {
    throw FileError(file, "has " + std::to_string(bytes.size()) + " bytes, and its header asks for " +
                              std::to_string(expected) + ": " + std::to_string(contacts) + " contacts, " +
                              std::to_string(steps) + (steps == 1 ? " step" : " steps"));
  }

  ContactFile problem;
  problem.name = header.text("name");
  problem.status = header.text("status");
  check_status(file, "'status'", problem.status, {"solved", "no_solution"});
  problem.units = header.text("units");
  problem.source = header.text("source");
  problem.reference_residual = header.number("ref_error");
  Doubles data(file, std::string_view(bytes).substr(header.size()));
  problem.W = data.take("W", rows * rows).reshaped<Eigen::RowMajor>(rows, rows);
  for (Index step = 0; step < steps; ++step) problem.delta_free.push_back(data.take("q", rows));
  problem.mu = data.take("mu", contacts);
  for (Index i = 0; i < rows; ++i) {
    if (problem.W(i, i) < 0.0)
      throw FileError(file, "W: entry " + std::to_string(i + 1) + " of its diagonal is negative");
  }
  if (!(problem.mu.minCoeff() >= 0.0 && problem.mu.maxCoeff() <= kMostFriction))
    throw FileError(file, "mu: " + kNoFriction);
  if (has_reference) {
    problem.f_reference = data.take("r_ref", rows);
    problem.delta_reference = data.take("u_ref", rows);
  }
  if (has_f_last) problem.f_last = data.take("f_last", rows);
  return problem;
}

std::string contact_bytes(const ContactFile& problem) {
  std::string bytes = "fcp 1\n";
  append_line(bytes, "contacts", std::to_string(problem.contacts()));
  append_line(bytes, "steps", std::to_string(problem.delta_free.size()));
  append_line(bytes, "has_ref", problem.f_reference.size() > 0 ? "1" : "0");
  if (problem.f_last.size() > 0) append_line(bytes, "has_f_last", "1");
  append_line(bytes, "name", problem.name);
  append_line(bytes, "status", problem.status);
  if (problem.f_reference.size() > 0)
    append_line(bytes, "ref_error", nlohmann::json(problem.reference_residual).dump());
  append_line(bytes, "source", problem.source);
  append_line(bytes, "symmetric", is_symmetric(problem.W) ? "1" : "0");
  append_line(bytes, "units", problem.units);
  bytes += "end_header\n";
  append(bytes, problem.W.reshaped<Eigen::RowMajor>());
  for (const VectorXd& delta_free : problem.delta_free) append(bytes, delta_free);
  append(bytes, problem.mu);
  append(bytes, problem.f_reference);
  append(bytes, problem.delta_reference);
  append(bytes, problem.f_last);
  return bytes;
}

void write_problem(const fs::path& file, const ContactFile& problem) { write_file(file, contact_bytes(problem)); }

}  // namespace thenar
