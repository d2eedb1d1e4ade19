// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/fclib_file.h"

#include <Eigen/SparseCore>
#include <Eigen/SparseLU>
#include <algorithm>
#include <new>
#include <optional>
#include <utility>

#include "engine/formats/child_process.h"
#include "engine/formats/files.h"
#include "engine/formats/hdf5_library.h"
#include "solvers/residual.h"

namespace thenar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using SparseMatrix = Eigen::SparseMatrix<double>;
namespace fs = std::filesystem;

bool is_fclib_file(const fs::path& file) {
  const std::string ending = ending_of(file);
  return ending == ".hdf5" || ending == ".h5";
}

#ifdef THENAR_HDF5
namespace {

// W is always dense here: this number of contacts needs 300 MB.
constexpr Index kMostFclibContacts = 2000;
// Limit of a global problem's degrees of freedom, or equations. A dense matrix of these and the contacts needs 700 MB.
constexpr Index kMostUnknowns = 15'000;
// A linear system whose solution has a larger relative residual was singular.
constexpr double kSolved = 1e-6;
// FCLIB does not compress; other writers may have compressed up to this number of matrix entries into a byte. A file
// that states more has fewer numbers than it claims.
constexpr Index kNumbersPerByte = 64;
// Entries of one place add up: as many as there are finite elements around a node.
constexpr Index kMostAtOnePlace = 8;
constexpr std::size_t kWidestNumber = 16;
constexpr std::size_t kLongestText = 65536, kKeptText = 2000;
// Flags of HDF5, whose macros would call the library.
constexpr unsigned kReadOnly = 0, kReplace = 2;

/// An object of HDF5, which is closed at the end.
class Id {
 public:
  Id(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Id() {
    if (id_ >= 0) close_(id_);
  }
  Id(const Id&) = delete;
  Id& operator=(const Id&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

const Hdf5& library(const fs::path& file) {
  std::string obstacle;
  const Hdf5* const h5 = Hdf5::load(obstacle);
  if (h5 == nullptr) throw FileError(file, obstacle);
  return *h5;
}

/// Returns the access to a file in memory. Empty bytes: for a new one.
hid_t in_memory(const Hdf5& h5, const std::string& bytes) {
  constexpr std::size_t kGrowth = 1 << 16;
  const hid_t access = h5.H5Pcreate(h5.file_access);
  h5.H5Pset_fapl_core(access, kGrowth, 0);
  // It copies them, and takes no pointer to const.
  if (!bytes.empty()) h5.H5Pset_file_image(access, const_cast<char*>(bytes.data()), bytes.size());
  return access;
}

// ---- reading ----

class Reader {
 public:
  Reader(const fs::path& file, const std::string& bytes)
      : file_(file),
        h5_(library(file)),
        most_(kNumbersPerByte * static_cast<Index>(bytes.size())),
        access_(in_memory(h5_, bytes), h5_.H5Pclose),
        id_(bytes.empty() ? -1 : h5_.H5Fopen("problem", kReadOnly, access_), h5_.H5Fclose) {
    if (id_ < 0) throw FileError(file, "is no HDF5 file, or a damaged one");
  }

  [[nodiscard]] bool has(const std::string& name) const { return h5_.H5Lexists(id_, name.c_str(), H5P_DEFAULT) > 0; }

  [[nodiscard]] Index integer(const std::string& name, Index low, Index high) const {
    return integers(name, 1, 1, low, high).front();
  }
  [[nodiscard]] std::vector<Index> integers(const std::string& name, Index least, Index most, Index low,
                                            Index high) const {
    static_assert(sizeof(Index) == sizeof(long long));
    const auto values = read<Index>(name, {H5T_INTEGER, H5T_INTEGER}, h5_.native_llong, least, most);
    const auto bad = std::find_if(values.begin(), values.end(), [&](Index v) { return v < low || v > high; });
    if (bad != values.end()) {
      fail(name, std::to_string(*bad) + " lies outside of " + std::to_string(low) + " .. " + std::to_string(high));
    }
    return values;
  }
  [[nodiscard]] VectorXd doubles(const std::string& name, Index least, Index most) const {
    const auto values = read<double>(name, {H5T_FLOAT, H5T_INTEGER}, h5_.native_double, least, most);
    const VectorXd vector = VectorXd::Map(values.data(), std::ssize(values));
    const Index bad = first_not_finite(vector);
    if (bad >= 0) {
      fail(name, "value " + std::to_string(bad + 1) + " of " + std::to_string(vector.size()) + " is not finite");
    }
    return vector;
  }
  /// Reads a text; empty if there is none, or none of a fixed length.
  [[nodiscard]] std::string text(const std::string& name) const {
    if (!has(name)) return "";
    const Id data(h5_.H5Dopen2(id_, name.c_str(), H5P_DEFAULT), h5_.H5Dclose);
    if (data < 0) return "";
    const Id type(h5_.H5Dget_type(data), h5_.H5Tclose);
    const Id space(h5_.H5Dget_space(data), h5_.H5Sclose);
    const std::size_t size = h5_.H5Tget_size(type);
    if (h5_.H5Tget_class(type) != H5T_STRING || h5_.H5Tis_variable_str(type) != 0 || size > kLongestText) return "";
    if (h5_.H5Sget_simple_extent_npoints(space) != 1) return "";
    std::string text(size + 1, '\0');
    const Id in_c(h5_.H5Tcopy(h5_.c_string), h5_.H5Tclose);
    h5_.H5Tset_size(in_c, text.size());
    if (h5_.H5Dread(data, in_c, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()) < 0) return "";
    return text.substr(0, std::min(text.find('\0'), kKeptText));
  }
  /// Reads a matrix in columns, in rows or as triplets; its shape where it is known, else -1.
  [[nodiscard]] SparseMatrix matrix(const std::string& name, Index rows, Index cols) const;

  [[noreturn]] void fail(const std::string& name, const std::string& what) const {
    throw FileError(file_, name + ": " + what);
  }

 private:
  template <typename T>
  std::vector<T> read(const std::string& name, std::pair<H5T_class_t, H5T_class_t> kinds, hid_t type, Index least,
                      Index most) const {
    if (!has(name)) fail(name, "is missing");
    const Id data(h5_.H5Dopen2(id_, name.c_str(), H5P_DEFAULT), h5_.H5Dclose);
    if (data < 0) fail(name, "is no data set, or a damaged one");
    const Id stored(h5_.H5Dget_type(data), h5_.H5Tclose);
    const H5T_class_t kind = h5_.H5Tget_class(stored);
    // HDF5 takes memory for the numbers that it converts: of a damaged file, for some of any size.
    const bool fits = (kind == kinds.first || kind == kinds.second) && h5_.H5Tget_size(stored) <= kWidestNumber;
    if (!fits) fail(name, "holds no numbers of its kind");
    const Id made(h5_.H5Dget_create_plist(data), h5_.H5Pclose);
    if (made < 0 || h5_.H5Pget_external_count(made) != 0) fail(name, "lies in another file");
    const Id space(h5_.H5Dget_space(data), h5_.H5Sclose);
    const Index size = h5_.H5Sget_simple_extent_npoints(space);
    if (size < least || size > most) {
      const std::string range = std::to_string(least) + (most > least ? " .. " + std::to_string(most) : "");
      fail(name, "must hold " + range + " numbers, and holds " + std::to_string(size));
    }
    std::vector<T> values(static_cast<std::size_t>(size));
    if (size > 0 && h5_.H5Dread(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) {
      fail(name, "cannot be read: the file is damaged");
    }
    return values;
  }

  const fs::path& file_;
  const Hdf5& h5_;
  Index most_;
  Id access_, id_;
};

SparseMatrix Reader::matrix(const std::string& name, Index rows, Index cols) const {
  const Index m = integer(name + "/m", std::max<Index>(rows, 0), rows < 0 ? kMostUnknowns : rows);
  const Index n = integer(name + "/n", std::max<Index>(cols, 0), cols < 0 ? kMostUnknowns : cols);
  constexpr Index kColumns = -1, kRows = -2;
  // Before any memory is taken for them.
  const Index most = std::min(most_, kMostAtOnePlace * m * n);
  const Index nz = integer(name + "/nz", kRows, most);
  const Index entries = nz >= 0 ? nz : integer(name + "/nzmax", 0, most);
  // In triplets, i is the row and p the column, as in CSparse and Siconos.
  const Index lines = nz == kColumns ? n : m;
  const Index pointers = nz >= 0 ? nz : lines + 1;
  const auto p = integers(name + "/p", pointers, pointers, 0, nz >= 0 ? n - 1 : entries);
  const auto i = integers(name + "/i", entries, entries, 0, (nz == kRows ? n : m) - 1);
  const VectorXd x = doubles(name + "/x", entries, most);
  std::vector<Eigen::Triplet<double>> triplets;
  const auto add = [&](Index row, Index col, Index k) {
    triplets.emplace_back(static_cast<int>(row), static_cast<int>(col), x[k]);
  };
  if (nz >= 0) {
    for (Index k = 0; k < entries; ++k) add(i[static_cast<std::size_t>(k)], p[static_cast<std::size_t>(k)], k);
  } else {
    if (!std::is_sorted(p.begin(), p.end())) fail(name + "/p", "must not fall from one number to the next");
    for (Index line = 0; line < lines; ++line) {
      for (Index k = p[static_cast<std::size_t>(line)]; k < p[static_cast<std::size_t>(line) + 1]; ++k) {
        const Index other = i[static_cast<std::size_t>(k)];
        nz == kColumns ? add(other, line, k) : add(line, other, k);
      }
    }
  }
  SparseMatrix matrix(m, n);
  matrix.setFromTriplets(triplets.begin(), triplets.end());  // It adds up entries of one place.
  return matrix;
}

/// Returns the number of contacts of a problem with these friction coefficients.
void read_friction(const Reader& reader, const std::string& group, ContactFile& problem) {
  if (reader.integer(group + "/spacedim", 2, 3) != 3) {
    reader.fail(group + "/spacedim", "is 2, and only contacts in space are solved");
  }
  problem.mu = reader.doubles(group + "/vectors/mu", 1, kMostFclibContacts);
}

void read_local(const Reader& reader, ContactFile& problem) {
  const std::string group = "/fclib_local";
  read_friction(reader, group, problem);
  if (reader.has(group + "/V")) reader.fail(group + "/V", "equations besides those of the contacts are not solved");
  const Index rows = 3 * problem.contacts();
  problem.delta_free = {reader.doubles(group + "/vectors/q", rows, rows)};
  problem.W = reader.matrix(group + "/W", rows, rows);
}

/// Reads a global problem, M v = H r + G l + f, G'v + b = 0, u = H'v + w: v as a function of r, and thereby W = du/dr
/// and q = u(0).
void read_global(const Reader& reader, ContactFile& problem) {
  const std::string group = "/fclib_global";
  read_friction(reader, group, problem);
  const Index rows = 3 * problem.contacts();
  const VectorXd w = reader.doubles(group + "/vectors/w", rows, rows);
  const VectorXd f = reader.doubles(group + "/vectors/f", 1, kMostUnknowns);
  const Index n = f.size();
  const SparseMatrix M = reader.matrix(group + "/M", n, n);
  const SparseMatrix H = reader.matrix(group + "/H", n, rows);
  const SparseMatrix G = reader.has(group + "/G") ? reader.matrix(group + "/G", n, -1) : SparseMatrix(n, 0);
  const Index p = G.cols();
  std::vector<Eigen::Triplet<double>> triplets;
  const auto add = [&](const SparseMatrix& block, int row, int col, double factor, bool transposed) {
    for (int line = 0; line < block.outerSize(); ++line) {
      for (SparseMatrix::InnerIterator at(block, line); at; ++at) {
        const int i = static_cast<int>(transposed ? at.col() : at.row());
        const int j = static_cast<int>(transposed ? at.row() : at.col());
        triplets.emplace_back(row + i, col + j, factor * at.value());
      }
    }
  };
  // M is symmetric up to its printed digits, whose errors are amplified in its inverse.
  add(M, 0, 0, 0.5, false);
  add(M, 0, 0, 0.5, true);
  add(G, 0, static_cast<int>(n), -1.0, false);
  add(G, static_cast<int>(n), 0, 1.0, true);
  SparseMatrix K(n + p, n + p);
  K.setFromTriplets(triplets.begin(), triplets.end());
  MatrixXd right = MatrixXd::Zero(n + p, rows + 1);
  right.topRows(n) << MatrixXd(H), f;
  if (p > 0) right.col(rows).tail(p) = -reader.doubles(group + "/vectors/b", p, p);

  const Eigen::SparseLU<SparseMatrix> lu(K);
  const MatrixXd v = lu.info() == Eigen::Success ? MatrixXd(lu.solve(right)) : MatrixXd();
  if (v.size() == 0 || !((K * v - right).norm() <= kSolved * right.norm())) {
    reader.fail(group + "/M", p > 0 ? "is singular, with G" : "is singular");
  }
  const MatrixXd u = H.transpose() * v.topRows(n);
  problem.W = u.leftCols(rows);
  problem.delta_free = {u.col(rows) + w};
}

// Separator of source and units in a description.
const std::string kUnitsMark = "; units: ";

// The head of a refusal, which no .fcp file has.
const std::string kRefused = "refused: ";

/// Reads the problem in the bytes of a file. Throws FileError.
ContactFile problem_in(const fs::path& file, const std::string& bytes) {
  const Reader reader(file, bytes);
  if (reader.has("/fclib_global_rolling")) reader.fail("/fclib_global_rolling", "rolling friction is not solved");
  const bool is_local = reader.has("/fclib_local");
  if (!is_local && !reader.has("/fclib_global")) {
    throw FileError(file, "holds no problem of FCLIB: neither /fclib_local nor /fclib_global");
  }
  ContactFile problem;
  is_local ? read_local(reader, problem) : read_global(reader, problem);

  const std::string info = is_local ? "/fclib_local/info" : "/fclib_global/info";
  problem.name = reader.text(info + "/title");
  problem.source = reader.text(info + "/description");
  problem.units = kUnitsOfFclib;
  const std::size_t units = problem.source.rfind(kUnitsMark);
  if (units != std::string::npos) {
    problem.units = problem.source.substr(units + kUnitsMark.size());
    problem.source.resize(units);
  }
  const std::string known = reader.text(info + "/math_info");
  if (known == "solved" || known == "no_solution") problem.status = known;

  const Index rows = 3 * problem.contacts();
  if (reader.has("/solution")) {
    problem.f_reference = reader.doubles("/solution/r", rows, rows);
    // Not the file's u: some hold a state from before the solution.
    problem.delta_reference = problem.W * problem.f_reference + problem.delta_free.front();
    problem.reference_residual = natural_map(problem.problem(), problem.f_reference, problem.delta_reference).norm;
    // Beyond all numbers: it solves nothing.
    if (!std::isfinite(problem.reference_residual)) problem.f_reference = problem.delta_reference = VectorXd();
  }
  if (reader.has("/guesses") && reader.has("/guesses/1")) {
    problem.f_last = reader.doubles("/guesses/1/r", rows, rows);
  }
  return problem;
}

// ---- writing ----

class Writer {
 public:
  explicit Writer(const fs::path& file)
      : file_(file),
        h5_(library(file)),
        access_(in_memory(h5_, ""), h5_.H5Pclose),
        id_(h5_.H5Fcreate("problem", kReplace, H5P_DEFAULT, access_), h5_.H5Fclose) {
    check(id_ >= 0);
  }

  void group(const std::string& name) {
    check(Id(h5_.H5Gcreate2(id_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), h5_.H5Gclose) >= 0);
  }
  void integers(const std::string& name, const std::vector<int>& values) {
    write(name, h5_.native_int, values.size(), values.data());
  }
  void doubles(const std::string& name, const VectorXd& values) {
    write(name, h5_.native_double, static_cast<std::size_t>(values.size()), values.data());
  }
  void text(const std::string& name, const std::string& text) {
    if (text.empty()) return;
    const Id type(h5_.H5Tcopy(h5_.c_string), h5_.H5Tclose);
    check(h5_.H5Tset_size(type, text.size() + 1) >= 0);
    write(name, type, Id(h5_.H5Screate(H5S_SCALAR), h5_.H5Sclose), text.c_str());
  }
  [[nodiscard]] std::string bytes() {
    check(h5_.H5Fflush(id_, H5F_SCOPE_GLOBAL) >= 0);
    std::string bytes(static_cast<std::size_t>(std::max<ssize_t>(0, h5_.H5Fget_file_image(id_, nullptr, 0))), '\0');
    check(!bytes.empty() && h5_.H5Fget_file_image(id_, bytes.data(), bytes.size()) > 0);
    return bytes;
  }

 private:
  void check(bool done) const {
    if (!done) throw FileError(file_, "HDF5 could not write it");
  }
  void write(const std::string& name, hid_t type, std::size_t size, const void* values) {
    const hsize_t count = size;
    write(name, type, Id(h5_.H5Screate_simple(1, &count, nullptr), h5_.H5Sclose), values);
  }
  void write(const std::string& name, hid_t type, const Id& space, const void* values) {
    const Id data(h5_.H5Dcreate2(id_, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), h5_.H5Dclose);
    check(data >= 0 && h5_.H5Dwrite(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
  }

  const fs::path& file_;
  const Hdf5& h5_;
  Id access_, id_;
};

/// Writes a matrix in columns; zeros are left out.
void write_matrix(Writer& writer, const std::string& name, const MatrixXd& matrix) {
  std::vector<int> p{0}, i;
  std::vector<double> x;
  for (Index col = 0; col < matrix.cols(); ++col) {
    for (Index row = 0; row < matrix.rows(); ++row) {
      if (matrix(row, col) == 0.0) continue;
      i.push_back(static_cast<int>(row));
      x.push_back(matrix(row, col));
    }
    p.push_back(static_cast<int>(i.size()));
  }
  writer.group(name);
  writer.integers(name + "/m", {static_cast<int>(matrix.rows())});
  writer.integers(name + "/n", {static_cast<int>(matrix.cols())});
  writer.integers(name + "/nzmax", {p.back()});
  writer.integers(name + "/nz", {-1});
  writer.integers(name + "/p", p);
  writer.integers(name + "/i", i);
  writer.doubles(name + "/x", VectorXd::Map(x.data(), std::ssize(x)));
}

void write_solution(Writer& writer, const std::string& name, const VectorXd& u, const VectorXd& r) {
  writer.group(name);
  writer.doubles(name + "/u", u);
  writer.doubles(name + "/r", r);
}

}  // namespace

std::string fclib_obstacle() {
  std::string obstacle;
  (void)Hdf5::load(obstacle);
  return obstacle;
}

ContactFile read_fclib_problem(const fs::path& file, const std::string& bytes) {
  (void)library(file);
  const auto work = [&]() -> std::string {
    try {
      return contact_bytes(problem_in(file, bytes));
    } catch (const FileError& error) {
      return kRefused + std::string(error.what()).substr(file.string().size() + 2);
    } catch (const std::bad_alloc&) {
      return kRefused + "is too large: it takes more memory than 4 GB";
    }
  };
  const std::optional<std::string> read = in_child_process(work);
  if (!read) throw FileError(file, "HDF5 cannot read it with 4 GB of memory in 120 s: it is damaged, or too large");
  if (read->starts_with(kRefused)) throw FileError(file, read->substr(kRefused.size()));
  return read_contact_problem(file, *read);
}

void write_fclib_problem(const fs::path& file, const ContactFile& problem) {
  if (problem.contacts() > kMostFclibContacts) {
    throw FileError(file, "at most " + std::to_string(kMostFclibContacts) + " contacts");
  }
  const std::string group = "/fclib_local";
  const VectorXd& q = problem.delta_free.front();
  Writer writer(file);
  writer.group(group);
  writer.integers(group + "/spacedim", {3});
  write_matrix(writer, group + "/W", problem.W);
  writer.group(group + "/vectors");
  writer.doubles(group + "/vectors/q", q);
  writer.doubles(group + "/vectors/mu", problem.mu);
  writer.group(group + "/info");
  writer.text(group + "/info/title", problem.name);
  writer.text(group + "/info/description", problem.source + (problem.units.empty() ? "" : kUnitsMark + problem.units));
  writer.text(group + "/info/math_info", problem.status);
  if (problem.f_reference.size() > 0) {
    write_solution(writer, "/solution", problem.delta_reference, problem.f_reference);
  }
  if (problem.f_last.size() > 0) {
    writer.group("/guesses");
    writer.integers("/guesses/number_of_guesses", {1});
    write_solution(writer, "/guesses/1", problem.W * problem.f_last + q, problem.f_last);
  }
  write_file(file, writer.bytes());
}

#else

std::string fclib_obstacle() { return "this build has no FCLIB: HDF5 was not found when it was made"; }
ContactFile read_fclib_problem(const fs::path& file, const std::string& /*bytes*/) {
  throw FileError(file, fclib_obstacle());
}
void write_fclib_problem(const fs::path& file, const ContactFile& /*problem*/) {
  throw FileError(file, fclib_obstacle());
}

#endif

}  // namespace thenar
