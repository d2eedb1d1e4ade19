// SPDX-License-Identifier: Apache-2.0
// Fingertips against Hertz's contact: kernels and numbers of control points by the error of the force and the time of
// the solve.

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numeric>
#include <vector>

#include "bench/cases/factored_contacts.h"
#include "bench/cases/random.h"
#include "bench/report/figure.h"
#include "bench/report/measure.h"
#include "engine/pulps/pressed_pulp.h"

namespace thenar {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using nlohmann::ordered_json;

double rms(const std::vector<double>& values) {
  const double sum = std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

// --- Kernels and numbers of control points --------------------------------------------------------------------------

// A fingertip of the scenes.
constexpr double kRadius_m = 8e-3, kModulus_Pa = 0.24e6, kBand_m = 0.3e-3;
constexpr Index kDefaultLeaves = 320;

/// The compliance among these control points against a plane, in the plane's axes; with Cerruti's tensor, or with its
/// mean over all directions.
SurfaceCompliance compliance_of(const Pulp& pulp, const Vector3d& n, const std::vector<Index>& controls,
                                bool with_cerruti) {
  SurfaceCompliance C(std::ssize(controls));
  Matrix3d E;
  E << n, n.unitOrthogonal(), n.cross(n.unitOrthogonal());
  for (Index j = 0; j < std::ssize(controls); ++j) {
    C.p_m.row(j) = E.transpose() * pulp.control_points_m.col(controls[j]);
    C.set_column(j, std::ssize(controls), [&](Index i) -> SurfaceCompliance::Entry {
      const double k = pulp.kernel(controls[i], controls[j]);
      if (with_cerruti) return {k, pulp.a(controls[i], controls[j]), pulp.b(controls[i], controls[j])};
      return {k, (pulp.tangential - 1.0) * k, 0.0};
    });
  }
  return C;
}

/// A pulp pressed on a plane that is dragged by 50 um: the problem of a contact tick's solve.
class PressedSolve {
 public:
  PressedSolve(const Pulp& pulp, const Vector3d& n, double depth_m, const PressedPulp& pressed,
               bool with_cerruti = true)
      : delta_free_(3 * std::ssize(pressed.controls)),
        f_(delta_free_.size()),
        delta_(delta_free_.size()),
        mu_(VectorXd::Constant(std::ssize(pressed.controls), 0.8)),
        work_(mu_.size(), 1) {
    W_.begin.push_back(mu_.size());
    W_.J_own.setZero(f_.size(), GroupedDelassus::kOwn);
    W_.J_common.setZero(f_.size(), GroupedDelassus::kPadded);
    W_.compliance = {compliance_of(pulp, n, pressed.controls, with_cerruti)};
    W_.axes = Matrix3d::Identity().replicate(mu_.size(), 1);
    for (Index j = 0; j < mu_.size(); ++j) {
      const double height_m = n.dot(pulp.control_points_m.col(pressed.controls[j]));
      delta_free_.segment<3>(3 * j) << kRadius_m - depth_m - height_m, 50e-6, 0.0;
    }
  }

  /// Of a cold solve to 1e-6.
  double us() {
    const GroupedContactProblem problem = W_.problem(delta_free_, mu_);
    f_.setZero();
    return time_us([&] {
      (void)solve_contacts(problem, {.tolerance = 1e-6, .max_sweeps = 3000}, work_, {f_, delta_});
    });
  }

 private:
  FactoredContacts W_;
  VectorXd delta_free_, f_, delta_, mu_;
  GroupedWorkspace work_;
};

/// What a pulp makes of one depth.
struct Pressing {
  Index leaves;
  PulpKernel kernel;
  std::vector<double> errors;  ///< Of the force against Hertz's, relative; one a direction.
  double contacts = 0.0;       ///< Mean.
  std::vector<PressedSolve> solves;
  std::vector<double> us = {};
};

Pressing press_in_all_directions(Index leaves, PulpKernel kernel, double depth_m, int directions) {
  const Pulp pulp =
      make_spherical_pulp(Vector3d::Zero(), kRadius_m, leaves * 15 / 2, leaves, {kModulus_Pa, 0.5, 0.0, kernel});
  Pressing pressing{leaves, kernel, {}, 0.0, {}};
  Random random(20);
  for (int k = 0; k < directions; ++k) {
    const Vector3d n = random.direction();
    const PressedPulp pressed = press(pulp, n, depth_m, kBand_m, pulp.controls());
    pressing.errors.push_back(pressed.force_N.sum() / hertz_force_N(pulp, depth_m) - 1.0);
    pressing.contacts += static_cast<double>(pressed.controls.size()) / directions;
    pressing.solves.emplace_back(pulp, n, depth_m, pressed);
  }
  return pressing;
}

void kernels(ordered_json& part, bool quick) {
  const int directions = quick ? 8 : 20, rounds = quick ? 5 : 15;
  ordered_json& figure = add_figure(
      part, "work_precision", "kernels", "Kernels and control points against Hertz",
      fmt::format(
          "With boussinesq, an elastic half space and the default at {1} points on the whole sphere, the error falls "
          "about as one over the points, and the time grows faster than they do. gaussian, the published influence "
          "function, is made for one depth, 1 mm (an eighth of the radius), and stays wrong at others, however many "
          "points. A fingertip (radius 8 mm, E* 0.24 MPa) is pressed on a rigid plane; a panel a depth. Error: of its "
          "force without friction against Hertz's closed form, rms over {0} directions. Time: a contact tick's cold "
          "solve of that finger to 1e-6, with friction, the plane dragged by 50 µm. The points near the plane are the "
          "contacts. Down and left is better.",
          directions, kDefaultLeaves),
      fmt::format("medians of {} rounds over {} directions, all numbers and kernels in turns", rounds, directions));
  figure["choice"] = "fingertip";
  figure["error"] = "error of the force [parts of Hertz's]";
  figure["time"] = "time of a finger's contact solve [µs]";
  const std::vector<Index> numbers =
      quick ? std::vector<Index>{80, 160, 320, 640, 1280} : std::vector<Index>{40, 80, 160, 320, 640, 1280, 2560};
  for (const double depth_m : {0.5e-3, 1e-3, 2e-3}) {
    std::vector<Pressing> all;
    for (const PulpKernel kernel : {PulpKernel::kBoussinesq, PulpKernel::kGaussian}) {
      for (const Index leaves : numbers) all.push_back(press_in_all_directions(leaves, kernel, depth_m, directions));
    }
    for (int round = 0; round < rounds; ++round) {
      for (Pressing& pressing : all) {
        for (PressedSolve& solve : pressing.solves) pressing.us.push_back(solve.us());
      }
    }
    ordered_json points = ordered_json::array();
    for (const Pressing& pressing : all) {
      const bool published = pressing.kernel == PulpKernel::kGaussian;
      const Percentiles us = percentiles(pressing.us);
      points.push_back(
          WorkPoint{.method = published ? "gaussian" : "boussinesq",
                    .setting = fmt::format("{} control points, {:.0f} contacts", pressing.leaves, pressing.contacts),
                    .error = rms(pressing.errors),
                    .us = us.p50,
                    .us_p99 = us.p99,
                    .is_default = !published && pressing.leaves == kDefaultLeaves,
                    .published = published});
    }
    figure["cases"].push_back({{"name", fmt::format("pressed in by {:g} mm", 1e3 * depth_m)}, {"points", points}});
  }
}

// --- Torsion --------------------------------------------------------------------------------------------------------

/// What a patch that sticks resists a turn about its normal with [N m/rad].
double torsional_stiffness(const Pulp& pulp, const Vector3d& n, const PressedPulp& pressed, bool with_cerruti) {
  std::vector<Index> loaded;
  Eigen::Vector3d centre_m = Vector3d::Zero();
  for (Index i = 0; i < std::ssize(pressed.controls); ++i) {
    if (pressed.force_N[i] <= 0.0) continue;
    loaded.push_back(pressed.controls[i]);
    centre_m += pressed.force_N[i] / pressed.force_N.sum() * pulp.control_points_m.col(pressed.controls[i]);
  }
  const SurfaceCompliance compliance = compliance_of(pulp, n, loaded, with_cerruti);
  const Index size = 2 * std::ssize(loaded);
  MatrixXd C(size, size);
  VectorXd turned_m(size);
  Matrix3d E;
  E << n, n.unitOrthogonal(), n.cross(n.unitOrthogonal());
  for (Index j = 0; 2 * j < size; ++j) {
    const Vector3d way_m = n.cross(pulp.control_points_m.col(loaded[j]) - centre_m);
    turned_m.segment<2>(2 * j) << E.col(1).dot(way_m), E.col(2).dot(way_m);
    for (Index i = 0; 2 * i < size; ++i) {
      C.block<2, 2>(2 * i, 2 * j) =
          compliance.entry(i, j, Matrix3d::Identity(), Matrix3d::Identity()).bottomRightCorner<2, 2>();
    }
  }
  return turned_m.dot(C.llt().solve(turned_m));
}

/// A number of control points with one of the two tensors.
struct Turning {
  Index leaves;
  bool with_cerruti;
  std::vector<double> errors;  ///< Of the torsional stiffness, relative; one a direction.
  std::vector<PressedSolve> solves;
  std::vector<double> us = {};
};

void torsion(ordered_json& part, bool quick) {
  const int directions = quick ? 8 : 20, rounds = quick ? 5 : 15;
  ordered_json& figure = add_figure(
      part, "work_precision", "torsion", "Cerruti's tensor against its mean",
      fmt::format("A force along an elastic half space moves what lies ahead of it farther than what lies beside it. "
                  "With the mean of both in all directions a patch that sticks resists a turn about its normal by a "
                  "quarter to a third too much, however many points it has; with Cerruti's tensor, the default, the "
                  "error falls with the points. The fingertip, panels and times are those of the figure before it; "
                  "both tensors take the same code. Error: of the torsional stiffness of the points that carry force, "
                  "all sticking, against Reissner and Sagoci's 16/3 G a^3 for a rigid disk as large as Hertz's patch, "
                  "rms over {} directions. Down and left is better.",
                  directions),
      fmt::format("medians of {} rounds over {} directions, all numbers and tensors in turns", rounds, directions));
  figure["error"] = "error of the torsional stiffness [parts of 16/3 G a^3]";
  figure["time"] = "time of a finger's contact solve [µs]";
  const std::vector<Index> numbers =
      quick ? std::vector<Index>{160, 320, 640} : std::vector<Index>{80, 160, 320, 640, 1280, 2560};
  for (const double depth_m : {0.5e-3, 1e-3, 2e-3}) {
    std::vector<Turning> all;
    for (const bool with_cerruti : {true, false}) {
      for (const Index leaves : numbers) {
        const Pulp pulp =
            make_spherical_pulp(Vector3d::Zero(), kRadius_m, leaves * 15 / 2, leaves, {kModulus_Pa, 0.5, 0.0});
        const double shear_Pa = 0.5 * kModulus_Pa * (1.0 - pulp.material.poisson);
        const double sagoci = 16.0 / 3.0 * shear_Pa * std::pow(kRadius_m * depth_m, 1.5);
        Turning& turning = all.emplace_back(Turning{leaves, with_cerruti, {}, {}});
        Random random(20);
        for (int k = 0; k < directions; ++k) {
          const Vector3d n = random.direction();
          const PressedPulp pressed = press(pulp, n, depth_m, kBand_m, pulp.controls());
          turning.errors.push_back(torsional_stiffness(pulp, n, pressed, with_cerruti) / sagoci - 1.0);
          turning.solves.emplace_back(pulp, n, depth_m, pressed, with_cerruti);
        }
      }
    }
    for (int round = 0; round < rounds; ++round) {
      for (Turning& turning : all) {
        for (PressedSolve& solve : turning.solves) turning.us.push_back(solve.us());
      }
    }
    ordered_json points = ordered_json::array();
    for (const Turning& turning : all) {
      const Percentiles us = percentiles(turning.us);
      points.push_back(WorkPoint{.method = turning.with_cerruti ? "Cerruti's tensor" : "its mean",
                                 .setting = fmt::format("{} control points", turning.leaves),
                                 .error = rms(turning.errors),
                                 .us = us.p50,
                                 .us_p99 = us.p99,
                                 .is_default = turning.with_cerruti && turning.leaves == kDefaultLeaves,
                                 .published = false});
    }
    figure["cases"].push_back({{"name", fmt::format("pressed in by {:g} mm", 1e3 * depth_m)}, {"points", points}});
  }
}

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(argc, argv, "pulp", "Fingertips",
                  "A fingertip is some hundred control points with a compliance among them. How many, and which "
                  "compliance, decides both what a solve costs and how far its force is from an elastic sphere's.",
                  {kernels, torsion});
}
