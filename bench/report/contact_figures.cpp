// SPDX-License-Identifier: Apache-2.0
// Contact forces: error against time of every solver at its settings, cold and warm.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
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

/// A problem, where warm solves start, and its accurate forces; of a scene in factors, too.
struct Known {
  ContactData problem;
  VectorXd f_start, f_exact;
  std::optional<FactoredContacts> factors;

  [[nodiscard]] GroupedContactProblem grouped() const { return factors->problem(problem.delta_free, problem.mu); }

  [[nodiscard]] double force_error(const VectorXd& f) const {
    return f.allFinite() ? (f - f_exact).norm() / f_exact.norm() : std::numeric_limits<double>::quiet_NaN();
  }
};

struct Case {
  std::string name;
  std::vector<Known> problems;
  bool warm;
};

// --- Problems ------------------------------------------------------------------------------------------------------

/// Fills in f_exact. Throws where there is no reference.
void solve_exactly(Known& p) {
  p.f_exact.setZero(p.problem.delta_free.size());
  VectorXd delta(p.f_exact.size());
  AccurateWorkspace work(p.problem.contacts());
  (void)solve_contacts_accurately(p.problem, {.tolerance = 1e-13}, work, {p.f_exact, delta});
  if (!(residual_of(p.problem, p.f_exact) <= 1e-10)) throw std::runtime_error("a problem without accurate forces");
}

Case scene_case(const std::string& name, const std::string& scene, const std::vector<std::string>& changes,
                const Moments& moments) {
  Case c{name, {}, false};
  for (const SceneContacts& recorded : scene_problems(scene, changes, moments).contacts) {
    const ContactFile& file = recorded.file;
    c.problems.push_back({{file.W, file.delta_free.front(), file.mu}, file.f_last, {}, recorded.factors});
    solve_exactly(c.problems.back());
  }
  return c;
}

/// Three flattened pulps of twenty contacts each, all of them pressed.
Case pressed_case(int count) {
  Case c{"random, 60 pressed", {}, false};
  for (int seed = 0; seed < count; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    ContactData p = families::grasp({.pulp_radius_m = 0.05, .depth_m = 2e-3}, random);
    p.mu.setConstant(0.7);
    c.problems.push_back({p, VectorXd::Zero(p.delta_free.size()), {}, {}});
    solve_exactly(c.problems.back());
  }
  return c;
}

std::vector<Case> make_cases(bool quick) {
  const int count = quick ? 4 : 10;
  std::vector<Case> cases;
  for (const Index contacts : {15, 30, 60}) {
    cases.push_back(scene_case(fmt::format("box_grasp, {} contacts", contacts), "box_grasp", changes_for(contacts),
                               {0.6, 1.0, count}));
  }
  cases.push_back(scene_case("capsule", "capsule", {}, {0.6, 1.8, count}));
  cases.push_back(scene_case("mug", "mug", {}, {0.6, 1.0, count}));
  cases.push_back(scene_case("stick: all stick", "stick", {}, {0.3, 0.7, count}));
  cases.push_back(scene_case("slide: all slide", "slide", {}, {0.35, 0.45, count}));
  cases.push_back(pressed_case(count));
  return cases;
}

// --- Methods and settings ------------------------------------------------------------------------------------------

struct Setting {
  std::string text;
  double tolerance;
  int budget;
};

struct Method {
  std::string name;
  bool peer, published;
  std::function<ContactSolver(const Known&)> prepare;
  std::vector<Setting> settings;
};

constexpr double kNever = 1e-16;
constexpr GaussSeidelSettings kDefault{.tolerance = 1e-7};  // The scenes'.

std::vector<Setting> tolerances(std::initializer_list<double> values) {
  std::vector<Setting> settings;
  for (const double tolerance : values)
    settings.push_back({fmt::format("{:g}", tolerance), tolerance, std::numeric_limits<int>::max()});
  return settings;
}

std::vector<Setting> budgets(std::initializer_list<int> values) {
  std::vector<Setting> settings;
  for (const int budget : values) settings.push_back({fmt::format("{} sweeps", budget), kNever, budget});
  return settings;
}

/// Of a scene, W is in factors: each method of ours that needs it as one matrix forms it in every call.
std::vector<Method> methods_for(bool factored) {
  const auto of_matrix = [factored](const ContactMethod& method) {
    return [method, factored](const Known& p) {
      return factored ? forming_w(method, p.grouped()) : method.prepare(p.problem);
    };
  };
  const auto factors = [](const Known& p) { return in_factors(p.grouped()); };
  const std::vector<ContactMethod> ours = our_contact_methods();
  const auto all = tolerances({1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-12});
  const auto few = tolerances({1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10});
  const auto sweeps = budgets({1, 2, 3, 5, 7, 10, 15, 20, 30, 50, 100});
  std::vector<Method> methods;
  if (factored) {
    methods.push_back({kInFactors, false, false, factors, all});
    methods.push_back({"Gauss-Seidel in factors, n sweeps", false, false, factors, sweeps});
    methods.push_back({ours[0].name, false, false, of_matrix(ours[0]), few});
  } else {
    methods.push_back({ours[0].name, false, false, of_matrix(ours[0]), all});
    methods.push_back({"Gauss-Seidel on a matrix, n sweeps", false, false, of_matrix(ours[0]), sweeps});
  }
  for (Setting& setting : methods.front().settings) {
    if (setting.tolerance == kDefault.tolerance) setting.budget = kDefault.max_sweeps;
  }
  methods.push_back({ours[1].name, false, true, of_matrix(ours[1]), few});
  methods.push_back({ours[2].name, false, false, of_matrix(ours[2]), tolerances({1e-6, 1e-8, 1e-12})});
  for (const ContactMethod& peer : contact_peers()) {
    const std::string name = peer.name;
    methods.push_back({name, true, false, [peer](const Known& p) { return peer.prepare(p.problem); },
                       name == "ode_dantzig"  ? std::vector<Setting>{{"", kNever, 1}}
                       : name == "bullet_pgs" ? budgets({3, 10, 30, 100, 300})
                                              : tolerances({1e-2, 1e-4, 1e-6, 1e-8})});
  }
  for (Method& method : methods) {
    for (Setting& setting : method.settings) setting.budget = std::min(setting.budget, ample_budget(method.name));
  }
  return methods;
}

// --- Measuring -----------------------------------------------------------------------------------------------------

struct Measured {
  std::vector<WorkPoint> by_residual, by_force;
};

Measured measure(const Case& c, int turns) {
  Measured points;
  std::vector<std::function<void()>> rounds;
  const std::vector<Method> methods = methods_for(c.problems.front().factors.has_value());
  for (const Method& method : methods) {
    auto solvers = std::make_shared<std::vector<ContactSolver>>();
    for (const Known& p : c.problems) solvers->push_back(method.prepare(p));
    for (const Setting& setting : method.settings) {
      auto f = std::make_shared<VectorXd>();
      const auto solve = [=, &c](std::size_t i) {
        const Known& p = c.problems[i];
        if (c.warm) {
          *f = p.f_start;
        } else {
          f->setZero(p.f_start.size());
        }
        (*solvers)[i](setting.tolerance, setting.budget, *f);
      };
      double residual = 0.0, force_error = 0.0;
      for (std::size_t i = 0; i < c.problems.size(); ++i) {
        solve(i);
        residual = worse(residual, residual_of(c.problems[i].problem, *f));
        force_error = worse(force_error, c.problems[i].force_error(*f));
      }
      WorkPoint point{.method = method.name,
                      .setting = setting.text,
                      .error = residual,
                      .is_default = &method == &methods.front() && setting.tolerance == kDefault.tolerance,
                      .peer = method.peer,
                      .published = method.published};
      points.by_residual.push_back(point);
      point.error = force_error;
      points.by_force.push_back(point);
      rounds.emplace_back([=, count = c.problems.size()] {
        for (std::size_t i = 0; i < count; ++i) solve(i);
      });
    }
  }
  const std::vector<double> us = times_in_turns(rounds, turns);
  for (std::size_t k = 0; k < us.size(); ++k) {
    points.by_residual[k].us = points.by_force[k].us = us[k] / static_cast<double>(c.problems.size());
  }
  return points;
}

// --- Figures -------------------------------------------------------------------------------------------------------

void add_figures(ordered_json& part, bool quick) {
  const int turns = quick ? 5 : 21;
  ordered_json cold = ordered_json::array(), warm = cold, forces = cold;
  for (Case& c : make_cases(quick)) {
    for (const bool is_warm : {false, true}) {
      if (is_warm && c.problems.front().f_start.isZero(0.0)) continue;
      c.warm = is_warm;
      const Measured measured = measure(c, turns);
      (is_warm ? warm : cold).push_back({{"name", c.name}, {"points", measured.by_residual}});
      if (is_warm) forces.push_back({{"name", c.name}, {"points", measured.by_force}});
    }
  }
  const std::string runs = fmt::format(
      "Time of a call: a round of all the panel's problems, over their number; medians of {} rounds (of 3 at least, "
      "where a point has taken half a second), in which all points of a panel took turns. Errors: the worst of the "
      "panel's problems.",
      turns);
  const auto add = [&](const char* id, const std::string& title, const std::string& caption, const char* error,
                       const ordered_json& cases) {
    auto& figure = add_figure(part, "work_precision", id, title, caption, runs);
    figure.update({{"error", error}, {"time", "time of a solve [µs]"}});
    figure.update({{"choice", "contact solver"}, {"cases", cases}});
  };
  add("contact_cold", "Contact forces from nothing: residual against time",
      "How far the forces of one contact step are from Signorini's and Coulomb's laws, against the time to find them "
      "from zero; down and to the left is better. The residual is the norm of the natural map over that of free "
      "motion: 1e-6 is a millionth, and below 1e-12 it is rounding. Bullet's and ODE's solvers have a square for "
      "Coulomb's cone, and come close only where no contact slides (15 contacts).",
      "worst residual (natural map)", cold);
  add("contact_warm", "Contact forces from the last step's: residual against time",
      "The same problems begun with the forces of the step before, as the contact loop does. A line that starts low "
      "has little left to do.",
      "worst residual (natural map)", warm);
  add("contact_forces", "Contact forces from the last step's: error of the forces against time",
      "What a hand would feel of it, of the same solves: the distance of all contact forces from those of an accurate "
      "solve (Newton, asked for 1e-13), over their norm. A residual of 1e-7, the default's, leaves some tenths of a "
      "millionth of the forces.",
      "worst error of the forces", forces);
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  return thenar::run_part(
      argc, argv, "contact", "Contact forces",
      "The forces of all contacts in one step of the contact loop, on a Delassus operator W that is frozen for the "
      "step: the solve that runs at 1 to 4 kHz. Methods, each at several settings along its line: accelerated "
      "Gauss-Seidel in single precision at its tolerances, or stopped after n sweeps; plain sweeps in double "
      "precision, the published method; Newton's method after up to 300 sweeps that were not enough: its steps "
      "cost milliseconds, and it is there for problems on which sweeps stall. The default (tolerance 1e-7, 200 "
      "sweeps at most) is Gauss-Seidel on W in factors; of a soft object, and in the panel of random problems, on one "
      "matrix. Ours pay for what they make of W, which in a scene comes in factors; other projects are given W: "
      "Siconos's nonlinear Gauss-Seidel (nsgs) and Alart-Curnier Newton (nsn), at tolerances of their own measure, "
      "Bullet's projected Gauss-Seidel (pgs) and ODE's Dantzig. Panels: problems at instants evenly spread over the "
      "motion of five scenes, and random ones with every contact pressed.",
      {thenar::add_figures});
}
