// Contact forces: error against time of every solver at its settings, cold and warm.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>

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

struct Problem {
  MatrixXd W;
  VectorXd delta_free, mu, f_start, f_exact;
  std::optional<FactoredContacts> factors;

  [[nodiscard]] double residual(const VectorXd& f) const {
    return f.allFinite() ? natural_map_residual(W, delta_free, mu, f, W * f + delta_free) : 1.0;
  }
  [[nodiscard]] double force_error(const VectorXd& f) const {
    return f.allFinite() ? (f - f_exact).norm() / f_exact.norm() : 1.0;
  }
};

struct Case {
  std::string name;
  std::vector<Problem> problems;
  bool warm;
};

// --- Problems ------------------------------------------------------------------------------------------------------

VectorXd accurate_forces(const MatrixXd& W, const VectorXd& delta_free, const VectorXd& mu) {
  VectorXd f = VectorXd::Zero(delta_free.size()), delta(delta_free.size());
  AccurateWorkspace work(mu.size());
  (void)solve_contacts_accurately(W, delta_free, mu, {.tolerance = 1e-13}, work, f, delta);
  return f;
}

Case scene_case(const std::string& name, const std::string& scene, const std::vector<std::string>& changes,
                const Moments& moments) {
  Case c{name, {}, false};
  for (const SceneContacts& recorded : scene_problems(scene, changes, moments).contacts) {
    const ContactFile& file = recorded.file;
    c.problems.push_back({file.W, file.delta_free.front(), file.mu, file.f_last,
                          accurate_forces(file.W, file.delta_free.front(), file.mu), recorded.factors});
  }
  return c;
}

/// Three flattened pulps of twenty contacts each, all of them pressed.
Case pressed_case(int count) {
  Case c{"random, 60 pressed", {}, false};
  for (int seed = 0; seed < count; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    RandomContacts p = families::grasp({.pulp_radius_m = 0.05, .depth_m = 2e-3}, random);
    p.mu.setConstant(0.7);
    const VectorXd f = accurate_forces(p.W, p.delta_free, p.mu);
    c.problems.push_back({p.W, p.delta_free, p.mu, VectorXd::Zero(f.size()), f, {}});
  }
  return c;
}

std::vector<Case> make_cases(bool quick) {
  const int count = quick ? 4 : 10;
  std::vector<Case> cases;
  for (const Index contacts : {15, 30, 60}) {
    cases.push_back(scene_case(fmt::format("box_grasp, {} contacts", contacts), "box_grasp",
                               {fmt::format("contact.max_per_finger={}", contacts / 3)}, {0.6, 1.0, count}));
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
  std::function<ContactSolver(const Problem&)> prepare;
  std::vector<Setting> settings;
};

constexpr int kAmple = 3000;
constexpr double kNever = 1e-16;
constexpr GaussSeidelSettings kDefault;

std::vector<Setting> tolerances(std::initializer_list<double> values) {
  std::vector<Setting> settings;
  for (const double tolerance : values) settings.push_back({fmt::format("{:g}", tolerance), tolerance, kAmple});
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
    return [method, factored](const Problem& p) {
      return factored ? forming_w(method, *p.factors, p.delta_free, p.mu) : method.prepare(p.W, p.delta_free, p.mu);
    };
  };
  const auto factors = [](const Problem& p) { return in_factors(*p.factors, p.delta_free, p.mu); };
  const std::vector<ContactMethod> ours = our_contact_methods();
  const auto all = tolerances({1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10, 1e-12});
  const auto few = tolerances({1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10});
  const auto sweeps = budgets({1, 2, 3, 5, 7, 10, 15, 20, 30, 50, 100});
  std::vector<Method> methods;
  if (factored) {
    methods.push_back({"Gauss-Seidel, W in factors", false, false, factors, all});
    methods.push_back({"the same, so many sweeps", false, false, factors, sweeps});
    methods.push_back({"Gauss-Seidel, W as a matrix", false, false, of_matrix(ours[0]), few});
  } else {
    methods.push_back({"Gauss-Seidel, W as a matrix", false, false, of_matrix(ours[0]), all});
    methods.push_back({"the same, so many sweeps", false, false, of_matrix(ours[0]), sweeps});
  }
  for (Setting& setting : methods.front().settings) {
    if (setting.tolerance == kDefault.tolerance) setting.budget = kDefault.max_sweeps;
  }
  methods.push_back({"plain sweeps", false, true, of_matrix(ours[1]), few});
  methods.push_back({"Newton after 300 sweeps", false, false, of_matrix(ours[2]), tolerances({1e-6, 1e-8, 1e-12})});
  methods.push_back(
      {"Newton after 20 sweeps", false, false, of_matrix(newton_after_sweeps("", 20)), tolerances({1e-6, 1e-12})});
  for (const ContactMethod& peer : contact_peers()) {
    const std::string name = peer.name;
    methods.push_back({name, true, false, [peer](const Problem& p) { return peer.prepare(p.W, p.delta_free, p.mu); },
                       name == "ode_dantzig"  ? std::vector<Setting>{{"", kNever, 1}}
                       : name == "bullet_pgs" ? budgets({3, 10, 30, 100, 300})
                                              : tolerances({1e-2, 1e-4, 1e-6, 1e-8})});
    // Its steps are Newton's, each a hundred sweeps and more.
    if (name == "siconos_nsn") {
      for (Setting& setting : methods.back().settings) setting.budget = 200;
    }
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
    for (const Problem& p : c.problems) solvers->push_back(method.prepare(p));
    for (const Setting& setting : method.settings) {
      auto f = std::make_shared<VectorXd>();
      const auto solve = [=, &c](std::size_t i) {
        const Problem& p = c.problems[i];
        if (c.warm) {
          *f = p.f_start;
        } else {
          f->setZero(p.delta_free.size());
        }
        (*solvers)[i](setting.tolerance, setting.budget, *f);
      };
      double residual = 0.0, force_error = 0.0;
      for (std::size_t i = 0; i < c.problems.size(); ++i) {
        solve(i);
        residual = std::max(residual, std::min(1.0, c.problems[i].residual(*f)));
        force_error = std::max(force_error, std::min(1.0, c.problems[i].force_error(*f)));
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

ordered_json default_row(const Case& c, const Measured& m) {
  const WorkPoint& chosen =
      *std::find_if(m.by_residual.begin(), m.by_residual.end(), [](const auto& p) { return p.is_default; });
  const WorkPoint& by_force =
      *std::find_if(m.by_force.begin(), m.by_force.end(), [](const auto& p) { return p.is_default; });
  return {c.name,
          c.warm ? "warm" : "cold",
          c.problems.front().mu.size(),
          chosen.us,
          chosen.error,
          over_front(m.by_residual),
          by_force.error,
          over_front(m.by_force)};
}

void add_figures(ordered_json& part, bool quick) {
  const int turns = quick ? 5 : 21;
  ordered_json cold = ordered_json::array(), warm = cold, forces = cold, rows = cold;
  for (Case& c : make_cases(quick)) {
    for (const bool is_warm : {false, true}) {
      if (is_warm && c.problems.front().f_start.isZero(0.0)) continue;
      c.warm = is_warm;
      const Measured measured = measure(c, turns);
      (is_warm ? warm : cold).push_back({{"name", c.name}, {"points", measured.by_residual}});
      if (is_warm) forces.push_back({{"name", c.name}, {"points", measured.by_force}});
      rows.push_back(default_row(c, measured));
    }
  }
  const std::string runs = fmt::format(
      "Time of a call: a round of all the panel's problems, over their number; medians of {} rounds (of 3 at least, "
      "where a "
      "point has taken half a second), in which all points of a panel took turns. Errors: the worst of the panel's "
      "problems.",
      turns);
  const std::string methods =
      " Methods, each at several settings along its line: accelerated Gauss-Seidel in single precision at its "
      "tolerances; the "
      "same, stopped after so many sweeps; plain sweeps in double precision, the published method; Newton's method "
      "where up to "
      "300, or 20, sweeps have not been enough: its own steps cost milliseconds, and it is there for problems on which "
      "sweeps "
      "stall. Ours pay for what they make of W, which in a scene comes in factors; other projects are given W: "
      "Siconos's "
      "nonlinear Gauss-Seidel and Alart-Curnier Newton, at tolerances of their own measure; Bullet's projected "
      "Gauss-Seidel "
      "and ODE's Dantzig, which solve for a square instead of Coulomb's cone and so cannot come close.";
  const std::string problems =
      " Panels: the contact loop's problems at instants evenly spread over the motion of five scenes, and random ones "
      "with "
      "every contact pressed.";
  const std::string choice =
      " The default (tolerance 1e-6, 200 sweeps at most) is Gauss-Seidel on factors; of a soft object, and in the "
      "panel of "
      "random problems, on one matrix.";
  const auto add = [&](const char* id, const std::string& title, const std::string& caption, const char* error,
                       const ordered_json& cases) {
    auto& figure = add_figure(part, "work_precision", id, title, caption, runs);
    figure.update({{"error", error}, {"time", "time of a solve [us]"}, {"choice", "contact solver"}, {"cases", cases}});
  };
  add("contact_cold", "Contact forces from nothing: residual against time",
      "How far the forces of one contact step are from Signorini's and Coulomb's laws, against the time to find them "
      "from "
      "zero; down and to the left is better. The residual is the norm of the natural map over that of free motion; "
      "1e-6 "
      "is a millionth." +
          choice + methods + problems,
      "worst residual (natural map)", cold);
  add("contact_warm", "Contact forces from the last step's: residual against time",
      "The same problems begun with the forces of the step before, as the contact loop does. A line that starts low "
      "has "
      "little left to do." +
          choice + methods + problems,
      "worst residual (natural map)", warm);
  add("contact_forces", "Contact forces from the last step's: error of the forces against time",
      "What a hand would feel of it: the distance of all contact forces from those of an accurate solve (Newton to "
      "1e-13), "
      "over their norm, with the same solves as in the figure before. The default's 1e-6 leaves some millionths of the "
      "forces." +
          choice + methods + problems,
      "worst error of the forces", forces);
  auto& table = add_figure(part, "table", "contact_default", "Contact forces: the default",
                           "The default's time over the least of any of ours, whatever its setting, that errs no more: "
                           "1 on the front, up to 1.1 "
                           "passes for it. Once by the residual, once by the error of the forces.",
                           runs);
  table["columns"] = {"problems", "start",           "contacts",        "default [us]",
                      "residual", "time over front", "error of forces", "time over front"};
  table["rows"] = rows;
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  const PartArguments arguments = part_arguments(argc, argv);
  auto part =
      make_part("contact", "Contact forces",
                "The forces of all contacts in one step of the contact loop, on a Delassus operator W that is frozen "
                "for the step: the solve that runs at 1 to 4 kHz.",
                arguments);
  add_figures(part, arguments.quick);
  write_part(part, arguments);
}
