#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <random>
#include <span>

#include "thenar/eigen_layout.h"

namespace thenar {

struct ContactKinematics;
struct FingerLoad;
struct Frame;
struct Model;
struct PatchPoint;
struct PatchReport;

/// What a fingertip feels of its patch in a tick. With Coulomb's law in every point its rim slips first: stick falls as
/// (1 - eta)^(2/3), eta = |T| / (mu N), long before the patch slides as a whole [Cattaneo 1938; Mindlin 1949], and
/// where it slips, friction can be felt.
struct Touch {
  double stick = 1.0;  ///< Share of its loaded area that sticks; 1 without load.
  double friction =
      std::numeric_limits<double>::quiet_NaN();  ///< Sum of |f_t| over that of f_n where it slips; NaN: nowhere.
  double slip_m_per_s = 0.0;                     ///< How fast what slips does, as a mean over its loaded area.
  double moment_Nm = 0.0;  ///< Torsion: about the mean normal, through the pressure centre; signed.
  double normal_N = 0.0;   ///< Load along the mean normal, and across it: as felt, with the noise.
  Eigen::Vector3d tangential_N = Eigen::Vector3d::Zero();  ///< World axes.
};

/// Of what is felt: standard normal numbers that are the same for the same seed.
struct TouchNoise {
  double share = 0.0;
  std::minstd_rand random;
  std::normal_distribution<double> normal;

  /// 1 and some noise.
  double factor() { return 1.0 + share * normal(random); }
};

/// What finger k feels, of its patch's points when they have moved. A point slips where its force is on its friction
/// cone's surface (kOnCone); points with less than a thousandth of the largest normal force are not felt. With noise
/// each contact's normal and tangential force is felt with a factor of its own; which points slip is not noisy.
[[nodiscard]] Touch felt_touch(const Model& model, const Frame& frame, const ContactKinematics& kinematics, int finger,
                               std::span<const PatchPoint> patch, const FingerLoad& load, const PatchReport& report,
                               double mu, TouchNoise& noise);

}  // namespace thenar
