// How time and memory of the contact solvers grow with contacts and fingers.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "bench/contact_families.h"
#include "bench/contact_methods.h"
#include "bench/report/figure.h"
#include "bench/report/measure.h"
#include "bench/scene_problems.h"
#include "solvers/residual.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using nlohmann::ordered_json;

constexpr double kSolved = 1e-6;                     // Natural-map residual of a solved problem.
constexpr int kMostSweeps = 3000, kMostSteps = 200;  // A step of Newton's method costs a hundred sweeps and more.

struct Problem {
  FactoredContacts factors;
  MatrixXd W;
  VectorXd delta_free, mu;

  [[nodiscard]] double residual(const VectorXd& f) const {
    return f.allFinite() ? natural_map_residual(W, delta_free, mu, f, W * f + delta_free) : 1.0;
  }
};

struct Method {
  std::string name;
  bool peer;
  int budget;
  std::vector<double> tolerances;  ///< The loosest that is enough is taken: those of peers are of their own measures.
  std::function<ContactSolver(const Problem&)> prepare;
};

std::vector<Method> all_methods() {
  std::vector<Method> methods;
  methods.push_back({"Gauss-Seidel, W in factors", false, kMostSweeps, {kSolved}, [](const Problem& p) {
                       return in_factors(p.factors, p.delta_free, p.mu);
                     }});
  const std::array<const char*, 3> names{"Gauss-Seidel, W as a matrix", "plain sweeps", "Newton after 300 sweeps"};
  const std::vector<ContactMethod> ours = our_contact_methods();
  for (std::size_t m = 0; m < names.size(); ++m) {
    methods.push_back(
        {names[m], false, m == 2 ? kMostSteps : kMostSweeps, {kSolved}, [method = ours[m]](const Problem& p) {
           return forming_w(method, p.factors, p.delta_free, p.mu);
         }});
  }
  for (const ContactMethod& peer : contact_peers()) {
    if (peer.stops_by == ContactMethod::kOtherLaw) continue;
    const bool is_newton = std::string_view(peer.name) == "siconos_nsn";
    methods.push_back(
        {peer.name, true, is_newton ? kMostSteps : kMostSweeps, {1e-4, 1e-6, 1e-8}, [peer](const Problem& p) {
           return peer.prepare(p.W, p.delta_free, p.mu);
         }});
  }
  return methods;
}

/// What a method needs for the problems of one size.
struct Cost {
  double us, bytes;
};

/// Of each method, nothing where it does not solve them all, or is not asked any more.
std::vector<std::optional<Cost>> costs(const std::vector<Problem>& problems, const std::vector<Method>& methods,
                                       const std::vector<bool>& asked, int turns) {
  std::vector<std::optional<Cost>> all(methods.size());
  std::vector<std::function<void()>> rounds;
  std::vector<std::size_t> timed;
  for (std::size_t m = 0; m < methods.size(); ++m) {
    if (!asked[m]) continue;
    std::vector<std::function<void()>> solves;
    double bytes = 0.0;
    for (const Problem& p : problems) {
      auto f = std::make_shared<VectorXd>(p.delta_free.size());
      const double before = heap_bytes();
      const ContactSolver solver = methods[m].prepare(p);
      for (const double tolerance : methods[m].tolerances) {
        f->setZero();
        solver(tolerance, methods[m].budget, *f);
        if (p.residual(*f) > 1.001 * kSolved) continue;
        bytes = std::max(bytes, heap_bytes() - before);
        solves.emplace_back([=, budget = methods[m].budget] {
          f->setZero();
          solver(tolerance, budget, *f);
        });
        break;
      }
    }
    if (solves.size() < problems.size()) continue;
    all[m] = Cost{0.0, bytes};
    timed.push_back(m);
    rounds.emplace_back([solves] {
      for (const auto& solve : solves) solve();
    });
  }
  const std::vector<double> us = times_in_turns(rounds, turns);
  for (std::size_t k = 0; k < us.size(); ++k) all[timed[k]]->us = us[k] / static_cast<double>(problems.size());
  return all;
}

// --- Problems ------------------------------------------------------------------------------------------------------

/// Three flattened pulps, all contacts pressed.
Problem pressed(Index contacts, std::uint64_t seed) {
  Random random(seed);
  Problem problem;
  RandomContacts p =
      families::grasp({.per_finger = contacts / 3, .pulp_radius_m = 0.05, .depth_m = 2e-3}, random, &problem.factors);
  problem.W = std::move(p.W);
  problem.delta_free = std::move(p.delta_free);
  problem.mu = VectorXd::Constant(contacts, 0.7);
  return problem;
}

/// The box grasp's on its way, of ticks with as many contacts as asked for; finer pulps for more than 60.
std::vector<Problem> of_box_grasp(Index contacts, int count) {
  std::vector<std::string> changes{fmt::format("contact.max_per_finger={}", contacts / 3)};
  if (const Index finer = (contacts + 59) / 60; finer > 1) {
    changes.push_back(fmt::format("fingertips.points={}", 2400 * finer));
    changes.push_back(fmt::format("fingertips.leaves={}", 320 * finer));
  }
  std::vector<Problem> problems;
  for (const SceneContacts& from : scene_problems("box_grasp", changes, {0.6, 1.0, count}).contacts) {
    if (from.file.contacts() != contacts) continue;
    problems.push_back({from.factors, from.file.W, from.file.delta_free.front(), from.file.mu});
  }
  return problems;
}

/// A contact problem of the box grasp with so many fingers: the thumb, and index and major by turns, of another moment
/// from the fourth finger on.
Problem with_fingers(const std::vector<SceneContacts>& recorded, std::size_t moment, Index fingers) {
  Problem problem;
  FactoredContacts& factors = problem.factors;
  const FactoredContacts& first = recorded[moment].factors;
  factors.own_mobility = first.own_mobility;
  factors.common_mobility = first.common_mobility;
  factors.compliance_scale = first.compliance_scale;
  const Index per_finger = first.begin[1];
  factors.J_own.resize(3 * fingers * per_finger, GroupedDelassus::kOwn);
  factors.J_common.resize(3 * fingers * per_finger, GroupedDelassus::kPadded);
  problem.delta_free.resize(3 * fingers * per_finger);
  problem.mu = VectorXd::Constant(fingers * per_finger, recorded[moment].file.mu[0]);
  for (Index k = 0; k < fingers; ++k) {
    const SceneContacts& from = recorded[(moment + static_cast<std::size_t>(k / 3)) % recorded.size()];
    const Index finger = k < 3 ? k : 1 + (k - 3) % 2, rows = 3 * per_finger, row = 3 * from.factors.begin[finger];
    factors.J_own.middleRows(k * rows, rows) = from.factors.J_own.middleRows(row, rows);
    factors.J_common.middleRows(k * rows, rows) = from.factors.J_common.middleRows(row, rows);
    factors.compliance.push_back(from.factors.compliance[finger]);
    problem.delta_free.segment(k * rows, rows) = from.file.delta_free.front().segment(row, rows);
    factors.begin.push_back((k + 1) * per_finger);
  }
  problem.W = factors.dense();
  return problem;
}

// --- Figures -------------------------------------------------------------------------------------------------------

/// Time and memory of all methods over sizes, as the panels of two figures.
struct Growth {
  ordered_json time, memory;
};

Growth grow(const std::string& panel, const std::vector<Index>& sizes, int turns,
            const std::function<std::vector<Problem>(Index)>& problems_of) {
  constexpr double kPatience_us = 50e3;
  const std::vector<Method> methods = all_methods();
  struct Curve {
    std::vector<double> x, us, bytes;
  };
  std::vector<Curve> curves(methods.size());
  std::vector<bool> asked(methods.size(), true);
  for (const Index size : sizes) {
    const std::vector<Problem> problems = problems_of(size);
    if (problems.empty()) continue;
    const std::vector<std::optional<Cost>> all = costs(problems, methods, asked, turns);
    for (std::size_t m = 0; m < methods.size(); ++m) {
      asked[m] = all[m] && all[m]->us < kPatience_us;
      if (!all[m]) continue;
      curves[m].x.push_back(static_cast<double>(size));
      curves[m].us.push_back(all[m]->us);
      curves[m].bytes.push_back(all[m]->bytes);
    }
  }
  Growth growth{{{"name", panel}}, {{"name", panel}}};
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const Curve& curve = curves[m];
    if (curve.x.size() < 3) continue;
    const auto add = [&](ordered_json& to, const std::vector<double>& y) {
      to["curves"].push_back({{"name", methods[m].name},
                              {"x", curve.x},
                              {"y", y},
                              {"exponent", exponent(curve.x, y)},
                              {"peer", methods[m].peer}});
    };
    add(growth.time, curve.us);
    add(growth.memory, curve.bytes);
  }
  return growth;
}

void add_figures(ordered_json& part, bool quick) {
  const int turns = quick ? 3 : 11;
  const std::size_t count = quick ? 2 : 5;
  const std::string runs = fmt::format(
      "{} problems a size, from nothing to a residual of 1e-6; medians of {} rounds (3 where they take long), methods "
      "in "
      "turns. Exponents by least squares of the logarithms over all sizes shown.",
      count, turns);
  const std::vector<Index> sizes = quick ? std::vector<Index>{15, 30, 60, 120, 249, 498}
                                         : std::vector<Index>{15, 21, 30, 42, 60, 84, 120, 168, 249, 336, 498};
  const Growth recorded = grow("contacts of the box grasp",
                               quick ? std::vector<Index>{15, 30, 60, 120} : std::vector<Index>{15, 30, 60, 120, 240},
                               turns, [&](Index size) { return of_box_grasp(size, static_cast<int>(count)); });
  const Growth contacts = grow("contacts, random and all pressed", sizes, turns, [&](Index size) {
    std::vector<Problem> problems;
    for (std::uint64_t seed = 0; seed < count; ++seed) problems.push_back(pressed(size, seed));
    return problems;
  });
  const SceneProblems scene = scene_problems("box_grasp", {}, {0.6, 1.0, static_cast<int>(count) + 1});
  const Growth fingers = grow("fingers, of 20 contacts each", {2, 3, 4, 5}, turns, [&](Index size) {
    std::vector<Problem> problems;
    for (std::size_t k = 0; k < count; ++k) problems.push_back(with_fingers(scene.contacts, k, size));
    return problems;
  });
  const std::string problems =
      " Panels: the box grasp on its way with 15 contacts and more (from 120 on, on finer pulps); random grasps by "
      "three "
      "fingers with all of 15 to 498 contacts pressed; the box grasp with 20 contacts on each of 2 to 5 fingers, the "
      "fourth and "
      "fifth pressing where index and major do. A method that needs more than 50 ms, or does not solve all problems of "
      "a "
      "size, is not asked for more.";
  auto& time = add_figure(part, "curves", "growth_contact_time", "Contact forces: time over contacts and fingers",
                          "Time to the forces of a contact step; lower is better, and so is a lower exponent. In "
                          "factors, the default, a sweep "
                          "costs contacts times contacts per finger: with fingers it grows more slowly than on the "
                          "matrix, which has all of "
                          "them against all." +
                              problems + " Ours pay for forming what they need of W; other projects are given W.",
                          runs);
  time["x"] = {{"label", "contacts, fingers"}, {"log", true}};
  time["y"] = {{"label", "time of a solve [us]"}, {"log", true}};
  time["panels"] = {recorded.time, contacts.time, fingers.time};
  auto& memory = add_figure(
      part, "curves", "growth_contact_memory", "Contact forces: memory over contacts and fingers",
      "Heap that a prepared solver holds after its first solve, the most over the problems: ours take it once, for the "
      "largest problem, and nothing in a solve. In factors it counts workspace and not the factors; as a matrix the "
      "matrix "
      "and the workspace; of other projects their copy of W and what they keep." +
          problems,
      runs);
  memory["x"] = {{"label", "contacts, fingers"}, {"log", true}};
  memory["y"] = {{"label", "memory [bytes]"}, {"log", true}};
  memory["panels"] = {recorded.memory, contacts.memory, fingers.memory};
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  const PartArguments arguments = part_arguments(argc, argv);
  auto part = make_part("contact_growth", "Growth of the contact solve",
                        "What more contacts and more fingers cost the contact solvers, in time and memory.", arguments);
  add_figures(part, arguments.quick);
  write_part(part, arguments);
}
