// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/problem_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "engine/formats/fclib_file.h"
#include "engine/formats/files.h"

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using nlohmann::json;
using nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

// Joints, and muscles: solvers make a matrix of each pair, and a row of many is little in a file.
constexpr Index kMostMuscles = 1000;
// Redundant data of a file, geometry and matrices, may differ by its printed digits.
constexpr double kAgree = 1e-9;
// A row of A f >= 0 with less relative slack than this has none.
constexpr double kNoSlack = 1e-9;

[[noreturn]] void fail(const fs::path& file, const std::string& key, const std::string& what) {
  throw FileError(file, "key '" + key + "': " + what);
}

/// Reads the object in a file, in which no key may occur twice.
json parse(const fs::path& file, const std::string& bytes) {
  std::map<std::string, int> keys;
  const auto count = [&](int depth, json::parse_event_t event, json& parsed) {
    if (event == json::parse_event_t::key && depth == 1 && ++keys[parsed.get<std::string>()] > 1) {
      fail(file, parsed.get<std::string>(), "is there twice");
    }
    return true;
  };
  try {
    json problem = json::parse(bytes, count);
    if (!problem.is_object()) throw FileError(file, "must be a JSON object with the keys of one problem");
    return problem;
  } catch (const json::exception& error) {
    // "[json.exception.parse_error.101] parse error at line 3, column 7: what is wrong": the library's own name means
    // nothing to a user.
    const std::string what = error.what();
    const std::size_t at = what.find(" at line "), end = what.find(": ", at), name = what.find("] ");
    if (at != std::string::npos && end != std::string::npos) {
      const std::size_t why = what.find(" - ", end);
      throw FileError(file, what.substr(at + 4, end - at - 4) +
                                ": is no JSON: " + what.substr(why == std::string::npos ? end + 2 : why + 3));
    }
    throw FileError(file, (name == std::string::npos ? what : what.substr(name + 2)));
  }
}

const json& value_of(const fs::path& file, const json& problem, const std::string& key) {
  const auto found = problem.find(key);
  if (found == problem.end()) fail(file, key, "is missing");
  return *found;
}

std::string text_of(const fs::path& file, const json& problem, const std::string& key) {
  if (!problem.contains(key)) return "";
  if (!problem.at(key).is_string()) fail(file, key, "must be a text");
  return problem.at(key).get<std::string>();
}

double number_of(const fs::path& file, const json& problem, const std::string& key) {
  const json& value = value_of(file, problem, key);
  if (!value.is_number()) fail(file, key, "must be a number");
  return value.get<double>();
}

bool is_list_of_numbers(const json& list) {
  return list.is_array() && std::all_of(list.begin(), list.end(), [](const json& v) { return v.is_number(); });
}

/// Reads a list of numbers, of this size if `size` is not -1.
VectorXd vector_of(const fs::path& file, const json& list, const std::string& key, Index size = -1) {
  if (!is_list_of_numbers(list) || (size >= 0 && std::ssize(list) != size)) {
    fail(file, key, "must be a list of " + (size >= 0 ? std::to_string(size) + " " : "") + "numbers");
  }
  VectorXd values(std::ssize(list));
  for (Index i = 0; i < values.size(); ++i) values[i] = list[static_cast<std::size_t>(i)].get<double>();
  return values;
}

/// Reads a list of rows of equal length, of this shape where it is not -1.
MatrixXd matrix_of(const fs::path& file, const json& problem, const std::string& key, Index rows, Index cols) {
  const json& list = value_of(file, problem, key);
  const auto shape = [&] {
    return (rows >= 0 ? std::to_string(rows) + " " : "") + "rows of " + (cols >= 0 ? std::to_string(cols) + " " : "") +
           "numbers";
  };
  if (!list.is_array() || list.empty() || (rows >= 0 && std::ssize(list) != rows)) {
    fail(file, key, "must be a list of " + shape());
  }
  if (!list[0].is_array()) fail(file, key, "must be a list of " + shape());
  if (cols < 0) cols = std::ssize(list[0]);
  if (cols < 1) fail(file, key, "must not be empty");
  // All rows before the matrix: one long row must not size the others.
  std::vector<VectorXd> vectors;
  for (std::size_t i = 0; i < list.size(); ++i) {
    vectors.push_back(vector_of(file, list[i], key + "[" + std::to_string(i) + "]", cols));
  }
  MatrixXd matrix(std::ssize(list), cols);
  for (Index i = 0; i < matrix.rows(); ++i) matrix.row(i) = vectors[static_cast<std::size_t>(i)];
  return matrix;
}

/// Reads an optional vector; empty if it is missing.
VectorXd optional_vector_of(const fs::path& file, const json& problem, const std::string& key, Index size) {
  return problem.contains(key) ? vector_of(file, problem.at(key), key, size) : VectorXd();
}

/// Reads a number for all of n contacts, or a list with one for each.
VectorXd number_of_each(const fs::path& file, const json& problem, const std::string& key, Index n) {
  const json& value = value_of(file, problem, key);
  if (value.is_number()) return VectorXd::Constant(n, value.get<double>());
  if (!is_list_of_numbers(value) || std::ssize(value) != n) {
    fail(file, key, "must be a number, or a list of " + std::to_string(n) + " numbers, one a contact");
  }
  return vector_of(file, value, key);
}

/// The matrices that the reference format states beside the geometry that they come from.
struct GraspMatrices {
  MatrixXd G, A;
  VectorXd c;
};

GraspMatrices matrices(const GraspFile& grasp) {
  const Index n = std::ssize(grasp.contacts);
  const GraspProblem problem = grasp.problem(FrictionCone::kPyramid);
  GraspMatrices m{MatrixXd(6, 3 * n), MatrixXd::Zero(5 * n, 3 * n), VectorXd(3 * n)};
  grasp_map(grasp.contacts, Vector3d::Zero(), m.G);
  for (Index i = 0; i < n; ++i) {
    const Matrix3d rows = grasp.contacts[static_cast<std::size_t>(i)].axes.transpose();
    const double mu = problem.friction_of(i);
    auto A_i = m.A.block<5, 3>(5 * i, 3 * i);
    A_i.row(0) = mu * rows.row(0) - rows.row(1);
    A_i.row(1) = mu * rows.row(0) + rows.row(1);
    A_i.row(2) = mu * rows.row(0) - rows.row(2);
    A_i.row(3) = mu * rows.row(0) + rows.row(2);
    A_i.row(4) = rows.row(0);
    m.c.segment<3>(3 * i) = -problem.internal_force_of(i) * rows.row(0).transpose();
  }
  return m;
}

void check_agreement(const fs::path& file, const json& problem, const std::string& key, const MatrixXd& expected,
                     const MatrixXd& given) {
  if ((given - expected).cwiseAbs().maxCoeff() <= kAgree * expected.cwiseAbs().maxCoeff()) return;
  fail(file, key, "contradicts the contact points and axes, mu and lambda of '" + text_of(file, problem, "name") + "'");
}

/// Reads friction and internal force: a number of each, or grips if contacts differ.
void read_grips(const fs::path& file, const json& problem, GraspFile& grasp) {
  const Index n = std::ssize(grasp.contacts);
  const VectorXd mu = number_of_each(file, problem, "mu", n);
  const VectorXd lambda = number_of_each(file, problem, "lambda", n);
  if (!(mu.minCoeff() >= 0.0 && mu.maxCoeff() <= kMostFriction)) fail(file, "mu", kNoFriction);
  if ((mu.array() == mu[0]).all() && (lambda.array() == lambda[0]).all()) {
    grasp.friction = mu[0];
    grasp.internal_force_N = lambda[0];
    return;
  }
  for (Index i = 0; i < n; ++i) grasp.grips.push_back({.friction = mu[i], .internal_force_N = lambda[i]});
}

GraspFile read_grasp(const fs::path& file, const json& problem) {
  GraspFile grasp;
  grasp.status = text_of(file, problem, "status");
  grasp.status_exact_cone = text_of(file, problem, "exact_cone_status");
  for (const char* key : {"status", "exact_cone_status"}) {
    check_status(file, "key '" + std::string(key) + "'", text_of(file, problem, key), {"optimal", "infeasible"});
  }
  const MatrixXd points = matrix_of(file, problem, "contact_points", -1, 3);
  const Index n = points.rows();
  if (n > kMaxGraspContacts) fail(file, "contact_points", "at most " + std::to_string(kMaxGraspContacts) + " contacts");
  if (problem.contains("n_contacts") && number_of(file, problem, "n_contacts") != static_cast<double>(n)) {
    fail(file, "n_contacts", "differs from the number of contact_points");
  }
  const std::array<MatrixXd, 3> axes = {matrix_of(file, problem, "normals_inward", n, 3),
                                        matrix_of(file, problem, "tangent_u", n, 3),
                                        matrix_of(file, problem, "tangent_v", n, 3)};
  for (Index i = 0; i < n; ++i) {
    GraspContact contact{points.row(i), Matrix3d()};
    for (int k = 0; k < 3; ++k) contact.axes.col(k) = axes[static_cast<std::size_t>(k)].row(i);
    if (!contact.axes.isUnitary(kAgree)) {
      fail(file, "normals_inward",
           "contact " + std::to_string(i) + ": normal, tangent_u and tangent_v must be orthogonal unit vectors");
    }
    grasp.contacts.push_back(contact);
  }
  grasp.wrench = vector_of(file, value_of(file, problem, "W"), "W", 6);
  read_grips(file, problem, grasp);
  grasp.f_optimal = optional_vector_of(file, problem, "f_opt", 3 * n);
  grasp.f_optimal_exact_cone = optional_vector_of(file, problem, "f_opt_exact_cone", 3 * n);

  const GraspMatrices m = matrices(grasp);
  if (problem.contains("G")) check_agreement(file, problem, "G", m.G, matrix_of(file, problem, "G", 6, 3 * n));
  if (problem.contains("A")) check_agreement(file, problem, "A", m.A, matrix_of(file, problem, "A", 5 * n, 3 * n));
  if (problem.contains("c")) check_agreement(file, problem, "c", m.c, vector_of(file, problem.at("c"), "c", 3 * n));
  return grasp;
}

/// Reads numbers of each muscle, of which null is no limit; empty if they are missing.
VectorXd limits_of(const fs::path& file, const json& problem, const std::string& key, Index muscles, bool may_be_zero) {
  if (!problem.contains(key)) return {};
  const json& list = problem.at(key);
  const std::string wrong = "must be a list of " + std::to_string(muscles) + " numbers, " +
                            (may_be_zero ? "0 or more" : "more than 0") + ", or null for no limit";
  if (!list.is_array() || std::ssize(list) != muscles) fail(file, key, wrong);
  VectorXd limits(muscles);
  for (Index j = 0; j < muscles; ++j) {
    const json& value = list[static_cast<std::size_t>(j)];
    if (!value.is_null() && !value.is_number()) fail(file, key, wrong);
    limits[j] = value.is_null() ? std::numeric_limits<double>::infinity() : value.get<double>();
    if (!(limits[j] >= 0.0) || (limits[j] == 0.0 && !may_be_zero)) fail(file, key, wrong);
  }
  return limits;
}

MuscleFile read_muscles(const fs::path& file, const json& problem) {
  MuscleFile muscles;
  muscles.status = text_of(file, problem, "status");
  check_status(file, "key 'status'", muscles.status, {"optimal", "infeasible"});
  muscles.H = matrix_of(file, problem, "H", -1, -1);
  if (std::max(muscles.H.rows(), muscles.H.cols()) > kMostMuscles) {
    fail(file, "H", "at most " + std::to_string(kMostMuscles) + " joints and as many muscles");
  }
  muscles.tau = vector_of(file, value_of(file, problem, "tau"), "tau", muscles.H.rows());
  muscles.limit = limits_of(file, problem, "limit", muscles.H.cols(), true);
  const VectorXd c = optional_vector_of(file, problem, "c", muscles.H.cols());
  if (!c.isZero(0.0)) fail(file, "c", "must be zero: the least muscle forces are asked for");
  muscles.f_optimal = optional_vector_of(file, problem, "f_opt", muscles.H.cols());
  return muscles;
}

Matrix6d matrix6_of(const fs::path& file, const json& problem, const std::string& key) {
  const MatrixXd given = matrix_of(file, problem, key, 6, 6);
  if (!(given - given.transpose()).isZero(kAgree * given.cwiseAbs().maxCoeff())) fail(file, key, "must be symmetric");
  return given.selfadjointView<Eigen::Lower>();
}

/// Reads the terms of the internal force.
std::optional<StiffSqueeze> squeeze_of(const fs::path& file, const json& problem, Index joints) {
  if (!problem.contains("squeeze")) return std::nullopt;
  const json& given = problem.at("squeeze");
  if (!given.is_object()) fail(file, "squeeze", "must be an object with low, high, weight, tau, A, B and D");
  StiffSqueeze squeeze;
  squeeze.low = number_of(file, given, "low");
  squeeze.high = number_of(file, given, "high");
  squeeze.weight = number_of(file, given, "weight");
  if (!(squeeze.low <= squeeze.high)) fail(file, "squeeze", "low must not be above high");
  if (!(squeeze.weight > 0.0)) fail(file, "squeeze", "weight must be more than 0");
  squeeze.tau = vector_of(file, value_of(file, given, "tau"), "squeeze.tau", joints);
  squeeze.A = matrix6_of(file, given, "A");
  squeeze.B = matrix_of(file, given, "B", 6, joints);
  squeeze.D = matrix_of(file, given, "D", joints, joints);
  return squeeze;
}

/// Reads the joints of each finger, which are all of H's rows.
std::vector<int> fingers_of(const fs::path& file, const json& problem, Index joints) {
  const VectorXd given = vector_of(file, value_of(file, problem, "finger_joints"), "finger_joints");
  std::vector<int> fingers;
  for (const double n : given) {
    if (!(n >= 1.0 && n <= kMaxStiffJoints) || n != std::floor(n)) {
      fail(file, "finger_joints", "must be whole numbers of 1 to " + std::to_string(kMaxStiffJoints));
    }
    fingers.push_back(static_cast<int>(n));
  }
  if (std::ssize(fingers) > kMaxStiffFingers || given.sum() != static_cast<double>(joints)) {
    fail(file, "finger_joints", "must be at most " + std::to_string(kMaxStiffFingers) + ", in sum the rows of H");
  }
  return fingers;
}

StiffMuscleFile read_stiff_muscles(const fs::path& file, const json& problem) {
  StiffMuscleFile p;
  p.status = text_of(file, problem, "status");
  check_status(file, "key 'status'", p.status, {"optimal", "infeasible"});
  p.H = matrix_of(file, problem, "H", -1, -1);
  const Index joints = p.H.rows(), muscles = p.H.cols();
  if (joints > kMaxJoints || muscles > kMaxMuscles) {
    fail(file, "H",
         "at most " + std::to_string(kMaxJoints) + " joints and " + std::to_string(kMaxMuscles) + " muscles");
  }
  p.tau = vector_of(file, value_of(file, problem, "tau"), "tau", joints);
  p.limit = limits_of(file, problem, "limit", muscles, true);
  p.joints = fingers_of(file, problem, joints);
  p.arm = problem.contains("arm") ? matrix_of(file, problem, "arm", joints, muscles) : p.H;
  Index pairs = 0;
  for (const int n : p.joints) pairs += n * (n + 1) / 2;
  p.turn = matrix_of(file, problem, "turn", pairs, muscles);
  p.fibre_per_m = vector_of(file, value_of(file, problem, "fibre"), "fibre", muscles);
  if (!(p.fibre_per_m.minCoeff() > 0.0)) fail(file, "fibre", "must be more than 0");
  p.tendon_N_per_m = limits_of(file, problem, "tendon", muscles, false);
  p.A = matrix6_of(file, problem, "A");
  p.B = matrix_of(file, problem, "B", 6, joints);
  p.D = matrix_of(file, problem, "D", joints, joints);
  p.K_des = matrix6_of(file, problem, "K_des");
  p.kappa = number_of(file, problem, "kappa");
  p.length_m = problem.contains("length") ? number_of(file, problem, "length") : p.length_m;
  if (!(p.length_m > 0.0)) fail(file, "length", "must be more than 0");
  p.squeeze = squeeze_of(file, problem, joints);
  p.f_optimal = optional_vector_of(file, problem, "f_opt", muscles);
  return p;
}

LcpFile read_lcp(const fs::path& file, const json& problem) {
  LcpFile lcp;
  lcp.status = text_of(file, problem, "status");
  check_status(file, "key 'status'", lcp.status, {"solved", "no_solution"});
  lcp.M = matrix_of(file, problem, "M", -1, -1);
  if (lcp.M.rows() != lcp.M.cols()) fail(file, "M", "must have as many rows as columns");
  lcp.q = vector_of(file, value_of(file, problem, "q"), "q", lcp.M.rows());
  lcp.z = optional_vector_of(file, problem, "z", lcp.M.rows());
  return lcp;
}

ProblemFile read_small_problem(const fs::path& file, const std::string& bytes) {
  const json problem = parse(file, bytes);
  const std::string kind = text_of(file, problem, "problem");
  const std::string name = text_of(file, problem, "name");
  const auto named = [&](auto read) {
    read.name = name;
    return read;
  };
  if (kind == "P1") return named(read_grasp(file, problem));
  if (kind == "P2") return named(read_muscles(file, problem));
  if (kind == "P3") return named(read_stiff_muscles(file, problem));
  if (kind == "LCP") return named(read_lcp(file, problem));
  fail(file, "problem", kind.empty() ? "is missing: P1, P2, P3 or LCP" : "'" + kind + "' is none of P1, P2, P3, LCP");
}

ordered_json list_of(const VectorXd& values) { return std::vector<double>(values.begin(), values.end()); }

ordered_json rows_of(const MatrixXd& matrix) {
  ordered_json rows = ordered_json::array();
  for (Index i = 0; i < matrix.rows(); ++i) rows.push_back(list_of(matrix.row(i)));
  return rows;
}

/// Returns limits with null for infinite ones.
ordered_json limits_list(const VectorXd& limits) {
  ordered_json list = ordered_json::array();
  for (const double limit : limits) list.push_back(std::isinf(limit) ? ordered_json(nullptr) : ordered_json(limit));
  return list;
}

/// Returns the values `of(i)` of n contacts: a number if it is the same for all, else a list.
template <typename Of>
ordered_json number_or_list(Index n, const Of& of) {
  ordered_json list = ordered_json::array();
  bool is_same = true;
  for (Index i = 0; i < n; ++i) {
    list.push_back(of(i));
    is_same = is_same && of(i) == of(0);
  }
  return is_same ? ordered_json(of(0)) : list;
}

/// Writes a key per line; numbers have the digits that restore the same bits.
void write_json(const fs::path& file, const ordered_json& problem) {
  std::string text;
  for (const auto& [key, value] : problem.items()) {
    // A problem may be named after its file, and files may be named by any bytes.
    text += (text.empty() ? "{\n  " : ",\n  ") + ordered_json(key).dump() + ": " +
            value.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  }
  write_file(file, text + "\n}\n");
}

ordered_json begin_json(const std::string& name, const char* kind, const std::string& status) {
  ordered_json problem{{"name", name}, {"problem", kind}};
  if (!status.empty()) problem["status"] = status;
  return problem;
}

/// Returns the optimum of min 1/2 f'f + c'f with A f >= 0, with its objective and active rows.
void add_optimum(const VectorXd& f, const VectorXd& c, const VectorXd& slack, ordered_json& problem) {
  if (f.size() == 0) return;
  problem["f_opt"] = list_of(f);
  problem["objective"] = 0.5 * f.squaredNorm() + c.dot(f);
  problem["active_rows"] = ordered_json::array();
  for (Index i = 0; i < slack.size(); ++i) {
    if (slack[i] <= kNoSlack * f.norm()) problem["active_rows"].push_back(i);
  }
  problem["min_slack"] = slack.minCoeff();
}

}  // namespace

ProblemFile read_problem(const fs::path& file) {
  const bool is_contact = file.extension() == ".fcp", is_fclib = is_fclib_file(file);
  if (!is_contact && !is_fclib && file.extension() != ".json") {
    throw FileError(file, "must be an .fcp, .hdf5 or .h5 file (contact) or a .json file (grasp, muscles, LCP)");
  }
  const std::string bytes = read_file(file);
  ProblemFile problem = is_contact ? ProblemFile(read_contact_problem(file, bytes))
                        : is_fclib ? ProblemFile(read_fclib_problem(file, bytes))
                                   : read_small_problem(file, bytes);
  std::visit([&](auto& p) { p.name = p.name.empty() ? file.stem().string() : p.name; }, problem);
  return problem;
}

void write_problem(const fs::path& file, const GraspFile& grasp) {
  const Index n = std::ssize(grasp.contacts);
  MatrixXd points(n, 3);
  std::array<MatrixXd, 3> axes;
  for (MatrixXd& axis : axes) axis.resize(n, 3);
  for (Index i = 0; i < n; ++i) {
    const GraspContact& contact = grasp.contacts[static_cast<std::size_t>(i)];
    points.row(i) = contact.point_m;
    for (int k = 0; k < 3; ++k) axes[static_cast<std::size_t>(k)].row(i) = contact.axes.col(k);
  }
  const GraspMatrices m = matrices(grasp);
  const GraspProblem given = grasp.problem(FrictionCone::kPyramid);
  ordered_json problem = begin_json(grasp.name, "P1", grasp.status);
  problem["n_contacts"] = n;
  problem["mu"] = number_or_list(n, [&](Index i) { return given.friction_of(i); });
  problem["lambda"] = number_or_list(n, [&](Index i) { return given.internal_force_of(i); });
  problem["contact_points"] = rows_of(points);
  problem["normals_inward"] = rows_of(axes[0]);
  problem["tangent_u"] = rows_of(axes[1]);
  problem["tangent_v"] = rows_of(axes[2]);
  problem["W"] = list_of(grasp.wrench);
  problem["c"] = list_of(m.c);
  problem["G"] = rows_of(m.G);
  problem["A"] = rows_of(m.A);
  if (grasp.f_optimal.size() > 0) add_optimum(grasp.f_optimal, m.c, m.A * grasp.f_optimal, problem);
  if (!grasp.status_exact_cone.empty()) problem["exact_cone_status"] = grasp.status_exact_cone;
  if (grasp.f_optimal_exact_cone.size() > 0) problem["f_opt_exact_cone"] = list_of(grasp.f_optimal_exact_cone);
  write_json(file, problem);
}

void write_problem(const fs::path& file, const MuscleFile& muscles) {
  ordered_json problem = begin_json(muscles.name, "P2", muscles.status);
  const VectorXd c = VectorXd::Zero(muscles.H.cols());
  problem["tau"] = list_of(muscles.tau);
  problem["c"] = list_of(c);
  problem["H"] = rows_of(muscles.H);
  if (muscles.limit.size() > 0) problem["limit"] = limits_list(muscles.limit);
  add_optimum(muscles.f_optimal, c, muscles.f_optimal, problem);
  write_json(file, problem);
}

void write_problem(const fs::path& file, const StiffMuscleFile& p) {
  ordered_json problem = begin_json(p.name, "P3", p.status);
  problem["tau"] = list_of(p.tau);
  problem["H"] = rows_of(p.H);
  if (p.limit.size() > 0) problem["limit"] = limits_list(p.limit);
  problem["finger_joints"] = p.joints;
  problem["arm"] = rows_of(p.arm);
  problem["turn"] = rows_of(p.turn);
  problem["fibre"] = list_of(p.fibre_per_m);
  if (p.tendon_N_per_m.size() > 0) problem["tendon"] = limits_list(p.tendon_N_per_m);
  problem["A"] = rows_of(p.A);
  problem["B"] = rows_of(p.B);
  problem["D"] = rows_of(p.D);
  problem["K_des"] = rows_of(p.K_des);
  problem["kappa"] = p.kappa;
  problem["length"] = p.length_m;
  if (p.squeeze) {
    problem["squeeze"] = {{"low", p.squeeze->low},          {"high", p.squeeze->high},    {"weight", p.squeeze->weight},
                          {"tau", list_of(p.squeeze->tau)}, {"A", rows_of(p.squeeze->A)}, {"B", rows_of(p.squeeze->B)},
                          {"D", rows_of(p.squeeze->D)}};
  }
  if (p.f_optimal.size() > 0) problem["f_opt"] = list_of(p.f_optimal);
  write_json(file, problem);
}

void write_problem(const fs::path& file, const LcpFile& lcp) {
  ordered_json problem = begin_json(lcp.name, "LCP", lcp.status);
  problem["M"] = rows_of(lcp.M);
  problem["q"] = list_of(lcp.q);
  if (lcp.z.size() > 0) {
    problem["z"] = list_of(lcp.z);
    problem["w"] = list_of(lcp.M * lcp.z + lcp.q);
  }
  write_json(file, problem);
}

}  // namespace thenar
