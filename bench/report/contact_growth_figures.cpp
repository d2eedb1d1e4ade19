// SPDX-License-Identifier: Apache-2.0
// How time and memory of the contact solvers grow with contacts and fingers.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "bench/cases/contact_families.h"
#include "bench/cases/recorded.h"
#include "bench/cases/scene_problems.h"
#include "bench/methods/contact_methods.h"
#include "bench/report/figure.h"
#include "bench/report/measure.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using nlohmann::ordered_json;

/// A problem in factors, too.
struct Factored {
  FactoredContacts factors;
  ContactData problem;

  [[nodiscard]] GroupedContactProblem grouped() const { return factors.problem(problem.delta_free, problem.mu); }
};

struct Method {
  std::string name;
  bool peer;
  std::vector<double> tolerances;
  std::function<ContactSolver(const Factored&)> prepare;
};

std::vector<Method> all_methods() {
  std::vector<Method> methods;
  methods.push_back({kInFactors, false, {kSolvedResidual}, [](const Factored& p) { return in_factors(p.grouped()); }});
  for (const ContactMethod& method : our_contact_methods()) {
    methods.push_back({method.name, false, {kSolvedResidual}, [method](const Factored& p) {
                         return forming_w(method, p.grouped());
                       }});
  }
  for (const ContactMethod& peer : contact_peers()) {
    if (peer.stops_by == ContactMethod::kOtherLaw) continue;
    methods.push_back(
        {peer.name, true, tolerances_to_solve(peer), [peer](const Factored& p) { return peer.prepare(p.problem); }});
  }
  return methods;
}

/// What a method needs for the problems of one size.
struct Cost {
  double us, bytes;
};

/// Of each method, nothing where it does not solve them all, or is not asked any more.
std::vector<std::optional<Cost>> costs(const std::vector<Factored>& problems, const std::vector<Method>& methods,
                                       const std::vector<bool>& asked, int turns) {
  std::vector<std::optional<Cost>> all(methods.size());
  std::vector<std::function<void()>> rounds;
  std::vector<std::size_t> timed;
  for (std::size_t m = 0; m < methods.size(); ++m) {
    if (!asked[m]) continue;
    std::vector<std::function<void()>> solves;
    double bytes = 0.0;
    for (const Factored& p : problems) {
      auto f = std::make_shared<VectorXd>(p.problem.delta_free.size());
      const double before = heap_bytes();
      const ContactSolver solver = methods[m].prepare(p);
      const int budget = ample_budget(methods[m].name);
      const double given = methods[m].peer
                               ? static_cast<double>(sizeof(double)) * static_cast<double>(p.problem.W.size())
                               : p.factors.bytes();
      for (const double tolerance : methods[m].tolerances) {
        f->setZero();
        solver(tolerance, budget, *f);
        if (!(residual_of(p.problem, *f) <= 1.001 * kSolvedResidual)) continue;
        bytes = std::max(bytes, given + heap_bytes() - before);
        solves.emplace_back([=] {
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
Factored pressed(Index contacts, std::uint64_t seed) {
  Random random(seed);
  Factored made;
  made.problem =
      families::grasp({.per_finger = contacts / 3, .pulp_radius_m = 0.05, .depth_m = 2e-3}, random, &made.factors);
  made.problem.mu.setConstant(0.7);
  return made;
}

/// The box grasp's on its way, of ticks with as many contacts as asked for; finer pulps for more than 60.
std::vector<Factored> of_box_grasp(Index contacts, int count) {
  std::vector<Factored> problems;
  for (const SceneContacts& from : scene_problems("box_grasp", changes_for(contacts), {0.6, 1.0, count}).contacts) {
    if (from.file.contacts() != contacts) continue;
    problems.push_back({from.factors, {from.file.W, from.file.delta_free.front(), from.file.mu}});
  }
  return problems;
}

/// A contact problem of the box grasp with so many fingers: the thumb, and index and major by turns, of another moment
/// from the fourth finger on.
Factored with_fingers(const std::vector<SceneContacts>& recorded, std::size_t moment, Index fingers) {
  Factored made;
  FactoredContacts& factors = made.factors;
  ContactData& problem = made.problem;
  const FactoredContacts& first = recorded[moment].factors;
  factors.own_mobility = first.own_mobility;
  factors.common_mobility = first.common_mobility;
  factors.compliance_scale = first.compliance_scale;
  const Index per_finger = first.begin[1];
  factors.J_own.resize(3 * fingers * per_finger, GroupedDelassus::kOwn);
  factors.J_common.resize(3 * fingers * per_finger, GroupedDelassus::kPadded);
  factors.axes.resize(3 * fingers * per_finger, 3);
  problem.delta_free.resize(3 * fingers * per_finger);
  problem.mu = VectorXd::Constant(fingers * per_finger, recorded[moment].file.mu[0]);
  for (Index k = 0; k < fingers; ++k) {
    const SceneContacts& from = recorded[(moment + static_cast<std::size_t>(k / 3)) % recorded.size()];
    const Index finger = k < 3 ? k : 1 + (k - 3) % 2, rows = 3 * per_finger, row = 3 * from.factors.begin[finger];
    factors.J_own.middleRows(k * rows, rows) = from.factors.J_own.middleRows(row, rows);
    factors.J_common.middleRows(k * rows, rows) = from.factors.J_common.middleRows(row, rows);
    factors.compliance.push_back(from.factors.compliance[finger]);
    factors.axes.middleRows(k * rows, rows) = from.factors.axes.middleRows(row, rows);
    problem.delta_free.segment(k * rows, rows) = from.file.delta_free.front().segment(row, rows);
    factors.begin.push_back((k + 1) * per_finger);
  }
  problem.W = factors.dense();
  return made;
}

// --- Figures -------------------------------------------------------------------------------------------------------

/// Time and memory of all methods over sizes, as the panels of two figures.
struct Growth {
  ordered_json time, memory;
};

Growth grow(const std::string& panel, const std::vector<Index>& sizes, int turns,
            const std::function<std::vector<Factored>(Index)>& problems_of) {
  constexpr double kPatience_us = 50e3;
  const std::vector<Method> methods = all_methods();
  struct Curve {
    std::vector<double> x, us, bytes;
  };
  std::vector<Curve> curves(methods.size());
  std::vector<bool> asked(methods.size(), true);
  for (const Index size : sizes) {
    const std::vector<Factored> problems = problems_of(size);
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
    const Curve& c = curves[m];
    if (c.x.size() < 3) continue;
    growth.time["curves"].push_back(curve(methods[m].name, c.x, c.us, methods[m].peer));
    growth.memory["curves"].push_back(curve(methods[m].name, c.x, c.bytes, methods[m].peer));
  }
  return growth;
}

void add_figures(ordered_json& part, bool quick) {
  const int turns = quick ? 3 : 11;
  const std::size_t count = quick ? 2 : 5;
  const std::string runs = fmt::format(
      "{} problems a size, from nothing to a residual of 1e-6; medians of {} rounds (3 where they take long), methods "
      "in turns. Exponents: of the upper half of the sizes, of all of fewer than six.",
      count, turns);
  const std::vector<Index> sizes = quick ? std::vector<Index>{15, 30, 60, 120, 249, 498}
                                         : std::vector<Index>{15, 21, 30, 42, 60, 84, 120, 168, 249, 336, 498};
  const Growth recorded = grow("contacts of the box grasp",
                               quick ? std::vector<Index>{15, 30, 60, 120} : std::vector<Index>{15, 30, 60, 120, 240},
                               turns, [&](Index size) { return of_box_grasp(size, static_cast<int>(count)); });
  const Growth contacts = grow("contacts, random and all pressed", sizes, turns, [&](Index size) {
    std::vector<Factored> problems;
    for (std::uint64_t seed = 0; seed < count; ++seed) problems.push_back(pressed(size, seed));
    return problems;
  });
  const auto moments = [&](Index per_finger) {
    return scene_problems("box_grasp", changes_for(3 * per_finger), {0.6, 1.0, static_cast<int>(count) + 1}).contacts;
  };
  const auto of_fingers = [&](Index per_finger, std::vector<Index> sizes_of) {
    const std::vector<SceneContacts> recorded_moments = moments(per_finger);
    return grow(fmt::format("{} to {} fingers of {} contacts each", sizes_of.front() / per_finger,
                            sizes_of.back() / per_finger, per_finger),
                sizes_of, turns, [&](Index size) {
                  std::vector<Factored> problems;
                  for (std::size_t k = 0; k < count; ++k) {
                    problems.push_back(with_fingers(recorded_moments, k, size / per_finger));
                  }
                  return problems;
                });
  };
  const Growth fingers = of_fingers(20, {40, 60, 80, 100}), large = of_fingers(100, {200, 300, 400, 500});
  const Growth patch = grow("one patch", {25, 50, 100, 200}, turns, [&](Index size) {
    const std::vector<SceneContacts> recorded_moments = moments(size);
    std::vector<Factored> problems;
    for (std::size_t k = 0; k < count; ++k) problems.push_back(with_fingers(recorded_moments, k, 1));
    return problems;
  });
  const auto add = [&](const char* id, const char* title, const std::string& caption, const char* label,
                       const ordered_json& panels) {
    auto& figure = add_figure(part, "curves", id, title, caption, runs);
    figure["x"] = {{"label", "contacts"}, {"log", true}};
    figure["y"] = {{"label", label}, {"log", true}};
    figure["panels"] = panels;
  };
  add("growth_contact_time", "Contact forces: time over contacts and fingers",
      "Lower is better, and so is a lower exponent. In factors, the default, a sweep costs contacts times contacts "
      "per finger: with fingers it grows more slowly than on the matrix, which has all of them against all. Ours pay "
      "for forming what they need of W; other projects are given W.",
      "time of a solve [µs]", {recorded.time, contacts.time, fingers.time, large.time, patch.time});
  add("growth_contact_memory", "Contact forces: memory over contacts and fingers",
      "What a solver is given and what it holds of the heap after its first solve, the most over the problems: ours "
      "take it once, for the largest problem, and nothing in a solve. All of ours are given the factors, and those on "
      "the matrix form it; other projects are given the matrix, and keep a copy.",
      "memory [bytes]", {recorded.memory, contacts.memory, fingers.memory, large.memory, patch.memory});
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  return thenar::run_part(
      argc, argv, "contact_growth", "Growth of the contact solve",
      "What more contacts and more fingers cost the contact solvers, in time and memory. Panels: the box grasp on its "
      "way (from 120 contacts on, on finer pulps); random grasps by three fingers with all contacts pressed; the box "
      "grasp with more or fewer fingers, of 20 and of 100 contacts each, the fourth and fifth pressing where index and "
      "major do; and one finger alone, a plate on so many contacts. A line ends where a "
      "method needs more than 50 ms, or does not solve all problems of the next size.",
      {thenar::add_figures});
}
