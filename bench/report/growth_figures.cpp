// How time and memory grow with what a scene is made of: contacts, samples of the object, control points, fingers.

#include <fmt/format.h>

#include <array>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "bench/contact_computation.h"
#include "bench/contact_families.h"
#include "bench/finding_methods.h"
#include "bench/report/figure.h"
#include "bench/report/measure.h"
#include "engine/pressed_pulp.h"
#include "solvers/grouped_delassus.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using nlohmann::ordered_json;

struct Curve {
  std::string name;
  std::vector<double> x = {}, y = {};
};

/// The exponent is that of the upper half of the sizes, where what does not grow no longer counts.
ordered_json to_json(const Curve& curve) {
  const auto half = static_cast<std::ptrdiff_t>((curve.x.size() - 1) / 2);
  return {{"name", curve.name},
          {"x", curve.x},
          {"y", curve.y},
          {"exponent", exponent({curve.x.begin() + half, curve.x.end()}, {curve.y.begin() + half, curve.y.end()})},
          {"peer", false}};
}

ordered_json panel(const std::string& name, const std::vector<Curve>& curves) {
  ordered_json json{{"name", name}, {"curves", ordered_json::array()}};
  for (const Curve& curve : curves) json["curves"].push_back(to_json(curve));
  return json;
}

constexpr char kExponents[] = " The number beside a curve is p of n^p, fitted to the upper half of the sizes.";

ordered_json& add_curves(ordered_json& part, const std::string& id, const std::string& title,
                         const std::string& caption, const std::string& runs, const std::string& x,
                         const std::string& y) {
  ordered_json& figure = add_figure(part, "curves", id, title, caption + kExponents, runs);
  figure["x"] = {{"label", x}, {"log", true}};
  figure["y"] = {{"label", y}, {"log", true}};
  figure["panels"] = ordered_json::array();
  return figure;
}

// --- Contacts -------------------------------------------------------------------------------------------------------

void contacts(ordered_json& part, bool quick) {
  const int rounds = quick ? 60 : 400;
  ordered_json& figure = add_curves(
      part, "contacts", "A contact computation over the number of contacts",
      "The box grasp on its way, every contact solve to a residual of 1e-6 from the last tick's forces. More than 60 "
      "contacts are on fingertips that have so many more control points and samples, so that finding, deformation and "
      "display grow by that, too.",
      fmt::format("medians of {} ticks, all sizes in turns", rounds), "contacts", "time [us]");
  std::vector<Index> sizes{15, 30, 60, 120, 240};
  if (!quick) sizes.push_back(501);
  std::vector<std::unique_ptr<ContactRun>> runs;
  for (const Index size : sizes) runs.push_back(std::make_unique<ContactRun>(size, 1000));
  std::vector<std::vector<ContactComputation>> ticks(sizes.size());
  for (int i = -10; i < rounds; ++i) {
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      const ContactComputation tick = runs[k]->tick();
      if (tick.solve.status != SolveStatus::kConverged) throw std::runtime_error("a contact solve did not converge");
      if (i >= 0) ticks[k].push_back(tick);
    }
  }
  using Tick = ContactComputation;
  const auto curve = [&](const std::string& name, auto seconds) {
    Curve result{name};
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      std::vector<double> us;
      for (const Tick& tick : ticks[k]) us.push_back(1e6 * seconds(tick));
      result.x.push_back(static_cast<double>(sizes[k]));
      result.y.push_back(percentiles(std::move(us)).p50);
    }
    return result;
  };
  figure["panels"].push_back(panel("box grasp", {curve("in all", [](const Tick& t) { return t.total_s(); }),
                                                 curve("find", [](const Tick& t) { return t.find_s; }),
                                                 curve("compliance", [](const Tick& t) { return t.compliance_s; }),
                                                 curve("assemble", [](const Tick& t) { return t.assemble_s; }),
                                                 curve("solve", [](const Tick& t) { return t.solve_s; }),
                                                 curve("deform", [](const Tick& t) { return t.deform_s; }),
                                                 curve("display", [](const Tick& t) { return t.display_s; })}));
}

// --- Samples of the object ------------------------------------------------------------------------------------------

void samples(ordered_json& part, bool quick) {
  const int rounds = quick ? 1 : 4;
  std::vector<double> finer{0.53, 1.0, 1.7, 3.0};  // of 36 000 samples: 10 000, 36 000, 100 000, 330 000
  if (!quick) finer.push_back(5.25);               // 1 000 000
  const Matrix3Xd controls_m = pulp_control_points(320);
  const GripTask task;
  std::vector<ordered_json> times, memories;
  for (const bool box : {true, false}) {
    const auto make = [&](double by) {
      return box ? known_box(std::lround(77 * by)) : known_scan(std::lround(61 * by));
    };
    const KnownObject reference = make(1.0);
    const std::vector<Grip> grips = random_grips(reference, controls_m, task, 32, 1);
    const std::vector<Grip> creeping = creeping_grip(grips.front(), 64, 1);
    std::vector<FindingCase> cases;
    Curve cold{"find, nothing remembered"}, warm{"find, a grip that creeps"}, ready{"make ready"}, memory{"surface"};
    for (const double by : finer) {
      const KnownObject object = make(by);
      const auto n = static_cast<double>(object.cloud.points_m.cols());
      for (Curve* curve : {&cold, &warm, &ready, &memory}) curve->x.push_back(n);
      cases.push_back({our_finding(object, controls_m, task, true), grips});
      ready.y.push_back(1e3 * cases.back().method.prepare_ms);
      memory.y.push_back(cases.back().method.memory_MB);
      cases.push_back({our_finding(object, controls_m, task, false), creeping});
    }
    const std::vector<FindingRecord> records = measure_findings(cases, reference, controls_m, task, rounds);
    for (std::size_t k = 0; k < finer.size(); ++k) {
      cold.y.push_back(records[2 * k].us_p50);
      warm.y.push_back(records[2 * k + 1].us_p50);
    }
    times.push_back(panel(reference.name, {ready, cold, warm}));
    memories.push_back(panel(reference.name, {memory}));
  }
  const std::string runs =
      fmt::format("finding: medians over 32 and 126 grips, {} rounds, all sizes in turns; making ready: once", rounds);
  ordered_json& time = add_curves(part, "samples", "Contact finding over the samples of the object",
                                  "Three fingertips of 320 control points, up to 20 contacts each, on a box of 50 mm "
                                  "and on a bumpy ellipsoid. Finding runs once a control period, making ready once at "
                                  "the start. A held object creeps: what is remembered then spares most searches.",
                                  runs, "samples of the object", "time [us]");
  time["panels"] = times;
  ordered_json& memory = add_curves(
      part, "samples_memory", "Memory over the samples of the object",
      "What the object's surface takes on the heap, ready to be asked for distances: samples, blocks, starts.",
      "one run", "samples of the object", "memory [MB]");
  memory["panels"] = memories;
}

// --- Control points -------------------------------------------------------------------------------------------------

void controls(ordered_json& part, bool quick) {
  const int rounds = quick ? 1 : 4;
  std::vector<Index> sizes{160, 320, 640, 1280};
  if (!quick) sizes.insert(sizes.end(), {2560, 5120});
  const KnownObject object = known_scan(61);
  const GripTask task;
  Curve cold{"find, nothing remembered"}, warm{"find, a grip that creeps"}, make{"make a fingertip"},
      memory{"a fingertip"};
  for (const Index size : sizes) {
    const Matrix3Xd controls_m = pulp_control_points(size);
    const std::vector<Grip> grips = random_grips(object, controls_m, task, 32, 1);
    const std::vector<FindingCase> cases{
        {our_finding(object, controls_m, task, true), grips},
        {our_finding(object, controls_m, task, false), creeping_grip(grips.front(), 64, 1)}};
    const std::vector<FindingRecord> records = measure_findings(cases, object, controls_m, task, rounds);
    for (Curve* curve : {&cold, &warm, &make, &memory}) curve->x.push_back(static_cast<double>(size));
    cold.y.push_back(records[0].us_p50);
    warm.y.push_back(records[1].us_p50);
    FindingMethod taken;
    const Pulp pulp = made_ready(taken, [&] {
      return make_spherical_pulp(Vector3d::Zero(), 8e-3, size * 15 / 2, size, {.reduced_modulus_Pa = 0.24e6});
    });
    make.y.push_back(1e3 * taken.prepare_ms);
    memory.y.push_back(taken.memory_MB);
  }
  ordered_json& time = add_curves(
      part, "controls", "Contact finding and start-up over the control points",
      "Three fingertips on the bumpy ellipsoid of 37 000 samples: finding up to 20 contacts each, whatever the number "
      "of control points; and making one fingertip, once at the start.",
      fmt::format("finding: medians over 32 and 126 grips, {} rounds; making: once", rounds),
      "control points of a fingertip", "time [us]");
  time["panels"].push_back(panel("bumpy ellipsoid", {make, cold, warm}));
  ordered_json& memories = add_curves(part, "controls_memory", "Memory over the control points",
                                      "What a fingertip takes on the heap: its samples, its tree, and the kernel among "
                                      "all control points, which grows with their square.",
                                      "one run", "control points of a fingertip", "memory [MB]");
  memories["panels"].push_back(panel("fingertip", {memory}));
}

// --- Fingers --------------------------------------------------------------------------------------------------------

/// The contact problem of fingers around an object of 50 mm, each pressed in by 1.2 mm and dragged by 50 um; a step of 1 ms.
class FingersAround {
 public:
  FingersAround(const Pulp& pulp, Index fingers, Index per_finger)
      : contacts_(fingers * per_finger),
        begin_(fingers + 1),
        compliance_(fingers, MatrixXd::Zero(3 * per_finger, 3 * per_finger)),
        J_own_(3 * contacts_, GroupedDelassus::kOwn),
        J_common_(GroupedDelassus::CommonJacobian::Zero(3 * contacts_, GroupedDelassus::kPadded)),
        delta_free_(3 * contacts_),
        f_(3 * contacts_),
        delta_(3 * contacts_),
        mu_(VectorXd::Constant(contacts_, 0.8)),
        work_(contacts_, fingers) {
    const PressedPulp pressed = press(pulp, Vector3d::UnitX(), kDepth_m, 1e-3, per_finger);
    if (std::ssize(pressed.controls) != per_finger) throw std::runtime_error("too few control points touch");
    for (Index k = 0; k < fingers; ++k) {
      begin_[k + 1] = (k + 1) * per_finger;
      const double angle = 2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(fingers);
      const Matrix3d R = Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix();
      for (Index i = 0; i < per_finger; ++i) add(pulp, pressed, R, k, i);
    }
  }

  /// Time of a cold solve to 1e-6.
  double us() {
    GroupedDelassus::CommonMotion mobility = GroupedDelassus::CommonMotion::Zero();
    mobility.head<3>().setConstant(kStep_s / 10.0);
    mobility.segment<3>(3).setConstant(kStep_s / 0.005);
    const GroupedDelassus W{.begin = begin_,
                            .J_own = J_own_,
                            .J_common = J_common_,
                            .own_mobility = kStep_s / 0.05,
                            .common_mobility = mobility,
                            .compliance = compliance_};
    f_.setZero();
    SolveReport report;
    const double us = time_us([&] { report = solve_contacts(W, delta_free_, mu_, {}, work_, f_, delta_); });
    if (report.status != SolveStatus::kConverged) throw std::runtime_error("a contact solve did not converge");
    return us;
  }

 private:
  static constexpr double kStep_s = 1e-3, kDepth_m = 1.2e-3, kRadius_m = 8e-3, kHalf_m = 25e-3;

  void add(const Pulp& pulp, const PressedPulp& pressed, const Matrix3d& R, Index k, Index i) {
    // The pulp presses along x on a plane that goes through the origin's distance; then all of it is turned.
    const Vector3d p_m = pulp.control_points_m.col(pressed.controls[i]);
    const Vector3d place_m = R * (p_m - (kHalf_m + kRadius_m - kDepth_m) * Vector3d::UnitX());
    const Matrix3d E = families::axes(R.col(0));
    const Index row = 3 * (begin_[k] + i);
    delta_free_.segment<3>(row) << kRadius_m - kDepth_m - p_m.x(), 50e-6, 0.0;
    J_common_.block<3, 6>(row, 0) = families::body_rows(E, place_m);
    // A joint that spreads, and three that bend at 20, 45 and 90 mm above the contact.
    const std::array<Vector3d, 4> axis{Vector3d::UnitZ(), R.col(1), R.col(1), R.col(1)};
    constexpr std::array kAbove_m{0.09, 0.09, 0.045, 0.02};
    for (int j = 0; j < GroupedDelassus::kOwn; ++j) {
      const Vector3d joint_m = -R.col(0) * (kHalf_m + 0.03) + Vector3d(0.0, 0.0, kAbove_m[j]);
      J_own_.block<3, 1>(row, j) = -E.transpose() * axis[j].cross(place_m - joint_m);
    }
    const double c_t = pulp.tangential * pulp.tangential;
    for (std::size_t j = 0; j < pressed.controls.size(); ++j) {
      const double k_ij = pulp.kernel(pressed.controls[i], pressed.controls[j]);
      compliance_[k].block<3, 3>(3 * i, 3 * static_cast<Index>(j)) = (k_ij * Vector3d(1.0, c_t, c_t)).asDiagonal();
    }
  }

  Index contacts_;
  std::vector<Index> begin_;
  std::vector<MatrixXd> compliance_;
  GroupedDelassus::OwnJacobian J_own_;
  GroupedDelassus::CommonJacobian J_common_;
  VectorXd delta_free_, f_, delta_, mu_;
  GroupedWorkspace work_;
};

void fingers(ordered_json& part, bool quick) {
  constexpr Index kPerFinger = 20;
  const int rounds = quick ? 200 : 2000;
  const Pulp pulp = make_spherical_pulp(Vector3d::Zero(), 8e-3, 2400, 320, {.reduced_modulus_Pa = 0.24e6});
  std::vector<FingersAround> problems;
  Curve solve{"solve, all fingers"};
  for (Index count = 2; count <= 5; ++count) {
    problems.emplace_back(pulp, count, kPerFinger);
    solve.x.push_back(static_cast<double>(count));
  }
  std::vector<std::vector<double>> us(problems.size());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t k = 0; k < problems.size(); ++k) us[k].push_back(problems[k].us());
  }
  for (std::vector<double>& times : us) solve.y.push_back(percentiles(std::move(times)).p50);
  ordered_json& figure = add_curves(
      part, "fingers", "The contact solve over the number of fingers",
      fmt::format(
          "Composed, not simulated: the engine's hand has three fingers, but its solver takes any number. Fingers "
          "stand around an object of 50 mm, {} contacts each, 4 joints each, pressed in by 1.2 mm, and are solved cold "
          "to 1e-6. A finger's contacts act on each other in a block of its own, and on others through the 6 freedoms "
          "of the object alone, so that a sweep's cost goes with the number of fingers; what exceeds it is sweeps. "
          "Contact finding, compliance and deformation are done finger by finger: they go with the number of fingers "
          "by construction, and are not drawn.",
          kPerFinger),
      fmt::format("medians of {} solves, all numbers in turns", rounds), "fingers", "time [us]");
  figure["panels"].push_back(panel("20 contacts a finger", {solve}));
}

void run(const PartArguments& arguments) {
  ordered_json part = make_part(
      "growth", "Growth", "Time and memory against the size of a scene, and with which power they grow.", arguments);
  contacts(part, arguments.quick);
  samples(part, arguments.quick);
  controls(part, arguments.quick);
  fingers(part, arguments.quick);
  write_part(part, arguments);
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) { thenar::run(thenar::part_arguments(argc, argv)); }
