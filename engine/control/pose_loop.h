#pragma once

#include <Eigen/Core>
#include <array>
#include <numbers>
#include <optional>

#include "engine/grasp/model.h"

namespace thenar {

/// Returns the rate at which the P gains restore the object's pose: the largest eigenvalue of B^-1 K [1/s], K the gains
/// and B the viscosity of the object and of the fingers, b (J J')^-1 at each contact; at the start of a scene with
/// control. With a delay T there is no overshoot below 1/(e T), and no stability above kMostDelay / T: x' = -k x(t -
/// T).
[[nodiscard]] double pose_rate(const Model& model);
inline constexpr double kMostDelay = std::numbers::pi / 2.0;
/// Returns T: control.feedback_delay, time.control_delay, and half a period, the mean age of a command.
[[nodiscard]] double loop_delay_s(const Scene& scene);

/// A detector of growing oscillations of the object about its target.
class Swings {
 public:
  static constexpr double kLeast_m = 0.1e-3;  ///< Least swing.
  static constexpr double kLeast_rad = 2e-3;
  static constexpr double kWider = 1.05;  ///< Least ratio to the swing before of a wider one.
  static constexpr int kOnEnd = 4;        ///< Number of consecutive wider swings that are reported, if
  static constexpr double kGrown = 2.0;   ///< the last is this many times the first; beats stay below that.

  struct Swing {
    bool turns = false;  ///< True if about its axes, not along them.
    double size = 0.0;   ///< [m] or [rad].
  };
  /// Adds the object's present error, along three axes [m] and as an angle [rad]; returns a growing swing.
  std::optional<Swing> add(const Eigen::Vector3d& off_m, double off_rad);

  /// For an archive (engine/loops/archive.h).
  template <typename Archive>
  void members(Archive& a) {
    a(courses_);
  }

 private:
  struct Course {
    double far = 0.0, turned = 0.0;       ///< Extreme since the last reversal, and that reversal.
    int way = 0;                          ///< Direction: 1 up, -1 down.
    double last = 0.0, one_before = 0.0;  ///< Sizes of swings.
    int wider = 0;
    double first = 0.0;  ///< Last swing that was not wider.
    void add(double now, double least);

    template <typename Archive>
    void members(Archive& a) {
      a(far, turned, way, last, one_before, wider, first);
    }
  };
  std::array<Course, 4> courses_;
};

}  // namespace thenar
