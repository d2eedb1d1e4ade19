// Fingertips against Hertz's contact: kernels and numbers of control points by the error of the force and the time of the
// solve.

#include <fmt/format.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "bench/random.h"
#include "bench/report/figure.h"
#include "bench/report/measure.h"
#include "engine/pressed_pulp.h"
#include "solvers/grouped_delassus.h"

namespace thenar {
namespace {

using Eigen::Index;
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

/// A pulp pressed on a plane that is dragged by 50 um: the problem of a contact tick's solve.
class PressedSolve {
 public:
  PressedSolve(const Pulp& pulp, const Vector3d& n, double depth_m, const PressedPulp& pressed)
      : contacts_(std::ssize(pressed.controls)),
        begin_{0, contacts_},
        kernel_{MatrixXd(contacts_, contacts_)},
        tensors_(Vector3d(1.0, pulp.tangential, pulp.tangential).asDiagonal().toDenseMatrix().replicate(contacts_, 1)),
        J_own_(GroupedDelassus::OwnJacobian::Zero(3 * contacts_, GroupedDelassus::kOwn)),
        J_common_(GroupedDelassus::CommonJacobian::Zero(3 * contacts_, GroupedDelassus::kPadded)),
        delta_free_(3 * contacts_),
        f_(3 * contacts_),
        delta_(3 * contacts_),
        mu_(VectorXd::Constant(contacts_, 0.8)),
        work_(contacts_, 1) {
    for (Index j = 0; j < contacts_; ++j) {
      const double height_m = n.dot(pulp.control_points_m.col(pressed.controls[j]));
      delta_free_.segment<3>(3 * j) << kRadius_m - depth_m - height_m, 50e-6, 0.0;
      for (Index i = 0; i < contacts_; ++i) {
        kernel_[0](i, j) = pulp.kernel(pressed.controls[i], pressed.controls[j]);
      }
    }
  }

  /// Of a cold solve to 1e-6.
  double us() {
    const GroupedDelassus W{.begin = begin_,
                            .J_own = J_own_,
                            .J_common = J_common_,
                            .own_mobility = 0.0,
                            .common_mobility = GroupedDelassus::CommonMotion::Zero(),
                            .kernel = kernel_,
                            .tensors = tensors_};
    f_.setZero();
    return time_us(
        [&] { (void)solve_contacts(W, delta_free_, mu_, {.tolerance = 1e-6, .max_sweeps = 3000}, work_, f_, delta_); });
  }

 private:
  Index contacts_;
  std::vector<Index> begin_;
  std::vector<MatrixXd> kernel_;
  GroupedDelassus::Tensors tensors_;
  GroupedDelassus::OwnJacobian J_own_;
  GroupedDelassus::CommonJacobian J_common_;
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
          "about "
          "as one over the points, and the time grows faster than they do. gaussian, the "
          "published influence function, is made for one depth, 1 mm (an eighth of the radius), and "
          "stays wrong at others, however many points. A fingertip (radius 8 mm, E* 0.24 MPa) is pressed "
          "on a rigid plane; a panel a depth. Error: of its force without friction against Hertz's closed form, rms "
          "over {0} directions. Time: a contact tick's cold solve of that finger to 1e-6, with friction, the plane "
          "dragged by 50 µm. The points near the plane are the contacts. Down and left is better.",
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

}  // namespace
}  // namespace thenar

int main(int argc, char** argv) {
  using namespace thenar;
  return run_part(argc, argv, "pulp", "Fingertips",
                  "A fingertip is some hundred control points with a compliance among them. How many, and which "
                  "compliance, decides both what a solve costs and how far its force is from an elastic sphere's.",
                  {kernels});
}
