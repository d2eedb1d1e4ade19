// What the charts of the fingertips against Hertz are drawn from, as one JSON file: hertz_charts FILE. A pulp of the
// reference case (R 8 mm, E* 0.24 MPa) is pressed on a rigid plane in many directions, with few control points and with
// many; force, contact radius and pressure are held against Hertz's, beside what the contact solve took.

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "bench/report/measure.h"
#include "engine/pressed_pulp.h"
#include "engine/summary.h"
#include "solvers/grouped_delassus.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using nlohmann::ordered_json;

constexpr double kRadius_m = 8e-3;
constexpr double kModulus_Pa = 0.24e6;
constexpr double kBand_m = 0.3e-3;
constexpr double kReferenceDepth_m = 1e-3;
constexpr std::array kDepths_m{0.5e-3, 1e-3, 2e-3};
constexpr int kDirections = 20;

Vector3d random_direction(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random), z = normal(random);
  return Vector3d(x, y, z).normalized();
}

/// Meets the plane with about so many control points when it is pressed by the reference depth.
Pulp pad(Index candidates, PulpKernel kernel) {
  const auto leaves = std::lround(static_cast<double>(candidates) * 2.0 * kRadius_m / (kReferenceDepth_m + kBand_m));
  return make_spherical_pulp(Vector3d::Zero(), kRadius_m, leaves * 15 / 2, leaves, {kModulus_Pa, 0.5, 0.0, kernel});
}

/// Relative errors of one press.
struct PressErrors {
  double force, radius, pressure;
};

PressErrors errors(const Pulp& pulp, const PressedPulp& pressed, const Vector3d& n, double depth_m) {
  const double a_m = std::sqrt(kRadius_m * depth_m);
  const double peak_Pa = 2.0 / std::numbers::pi * kModulus_Pa * std::sqrt(depth_m / kRadius_m);
  const Matrix3Xd points_m = pulp.control_points_m(Eigen::all, pressed.controls);
  const Matrix3Xd across_m = points_m - n * (n.transpose() * points_m);
  const double force_N = pressed.force_N.sum();
  const Vector3d centre_m = across_m * pressed.force_N / force_N;
  const VectorXd squares_m2 = (across_m.colwise() - centre_m).colwise().squaredNorm().transpose();
  double difference = 0.0, near = 0.0, whole = 0.0, inside = 0.0;
  for (Index i = 0; i < pressed.force_N.size(); ++i) {
    const double r = across_m.col(i).norm() / a_m;
    const double hertz_Pa = peak_Pa * std::sqrt(std::max(0.0, 1.0 - r * r));
    if (r < 1.1) {
      difference += std::pow(pressed.force_N[i] / pulp.area_m2[pressed.controls[i]] - hertz_Pa, 2);
      near += 1.0;
    }
    if (r < 1.0) {
      whole += hertz_Pa * hertz_Pa;
      inside += 1.0;
    }
  }
  // Of Hertz's pressure the mean r^2 is 2/5 a^2.
  return {force_N / hertz_force_N(pulp, depth_m) - 1.0,
          std::sqrt(2.5 * squares_m2.dot(pressed.force_N) / force_N) / a_m - 1.0,
          std::sqrt(difference / near / (whole / inside))};
}

/// Time and sweeps of a contact tick's solve of such a press, cold, to 1e-6, with friction, the plane dragged by 50 um.
struct Solve {
  double us;
  int sweeps;
};

Solve solve_time(const Pulp& pulp, const Vector3d& n, double depth_m) {
  const PressedPulp pressed = press(pulp, n, depth_m, kBand_m, pulp.controls());
  const Index m = std::ssize(pressed.controls);
  const double c_t = pulp.tangential * pulp.tangential;
  std::vector<MatrixXd> compliance{MatrixXd::Zero(3 * m, 3 * m)};
  VectorXd delta_free(3 * m), f(3 * m), delta(3 * m);
  for (Index j = 0; j < m; ++j) {
    const double height_m = n.dot(pulp.control_points_m.col(pressed.controls[j]));
    delta_free.segment<3>(3 * j) << kRadius_m - depth_m - height_m, 50e-6, 0.0;
    for (Index i = 0; i < m; ++i) {
      const double k_ij = pulp.kernel(pressed.controls[i], pressed.controls[j]);
      compliance[0].block<3, 3>(3 * i, 3 * j) = (k_ij * Vector3d(1.0, c_t, c_t)).asDiagonal();
    }
  }
  const std::vector<Index> begin{0, m};
  const GroupedDelassus::OwnJacobian J_own = GroupedDelassus::OwnJacobian::Zero(3 * m, GroupedDelassus::kOwn);
  const GroupedDelassus::CommonJacobian J_common =
      GroupedDelassus::CommonJacobian::Zero(3 * m, GroupedDelassus::kPadded);
  const GroupedDelassus W{.begin = begin,
                          .J_own = J_own,
                          .J_common = J_common,
                          .own_mobility = 0.0,
                          .common_mobility = GroupedDelassus::CommonMotion::Zero(),
                          .compliance = compliance};
  const VectorXd mu = VectorXd::Constant(m, 0.8);
  GroupedWorkspace work(m, 1);
  SolveReport report;
  const double us = median_us(
      41, [&] { f.setZero(); },
      [&] { report = solve_contacts(W, delta_free, mu, {.tolerance = 1e-6, .max_sweeps = 3000}, work, f, delta); });
  return {us, report.sweeps};
}

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

ordered_json curve(const char* name, PulpKernel kernel) {
  ordered_json curve{{"kernel", name}};
  for (const Index candidates : {5, 8, 10, 15, 20, 30, 42, 60, 85, 120, 170, 240}) {
    const Pulp pulp = pad(candidates, kernel);
    std::mt19937_64 random(20);
    std::vector<double> force, radius, pressure, at_reference, us, sweeps;
    for (int k = 0; k < kDirections; ++k) {
      const Vector3d n = random_direction(random);
      for (const double depth_m : kDepths_m) {
        const PressErrors e = errors(pulp, press(pulp, n, depth_m, kBand_m, pulp.controls()), n, depth_m);
        force.push_back(e.force);
        if (depth_m != kReferenceDepth_m) continue;
        at_reference.push_back(e.force);
        radius.push_back(e.radius);
        pressure.push_back(e.pressure);
      }
      const Solve solve = solve_time(pulp, n, kReferenceDepth_m);
      us.push_back(solve.us);
      sweeps.push_back(solve.sweeps);
    }
    curve["contacts"].push_back(candidates);
    curve["us"].push_back(percentiles(us).p50);
    curve["sweeps"].push_back(percentiles(sweeps).p50);
    curve["force_error"].push_back(rms(force));
    curve["force_error_1mm"].push_back(rms(at_reference));
    curve["radius_error"].push_back(rms(radius));
    curve["pressure_error"].push_back(rms(pressure));
    std::cerr << name << " " << candidates << " contacts: " << curve["us"].back() << " us, force "
              << curve["force_error"].back() << ", at 1 mm " << curve["force_error_1mm"].back() << ", radius "
              << curve["radius_error"].back() << ", pressure " << curve["pressure_error"].back() << "\n";
  }
  return curve;
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  if (argc != 2) {
    std::cerr << "usage: hertz_charts FILE\n";
    return 2;
  }
  nlohmann::ordered_json data{{"build", build_settings()}};
  data["note"] = "medians and rms of 20 directions; " + data["build"].at("compiler").get<std::string>() + " " +
                 data["build"].at("flags").get<std::string>();
  data["hertz"].push_back(curve("boussinesq", PulpKernel::kBoussinesq));
  data["hertz"].push_back(curve("gaussian", PulpKernel::kGaussian));
  std::ofstream(argv[1]) << data.dump(1) << '\n';
}
