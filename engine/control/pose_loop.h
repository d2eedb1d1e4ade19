#pragma once

#include <Eigen/Core>
#include <array>
#include <numbers>
#include <optional>

#include "engine/grasp/model.h"

namespace thenar {

/// How fast the P gains bring the object back: the largest eigenvalue of B^-1 K [1/s]. K are they, B is what the
/// object's own viscosity and that of the fingers, b (J J')^-1 at each one's contact, hold against its motion; of the
/// scene's start, and a scene with control. With what is known T late there is no overshoot below 1/(e T), and no
/// stability above kMostDelay / T: x' = -k x(t - T).
[[nodiscard]] double pose_rate(const Model& model);
inline constexpr double kMostDelay = std::numbers::pi / 2.0;
/// T: what control.feedback_delay and time.control_delay say, and half a period, which a command is old on average.
[[nodiscard]] double loop_delay_s(const Scene& scene);

/// Tells an object that swings about its target wider and wider.
class Swings {
 public:
  static constexpr double kLeast_m = 0.1e-3;  ///< Less is no swing,
  static constexpr double kLeast_rad = 2e-3;
  static constexpr double kWider = 1.05;  ///< and no more than so many times the one before is not wider.
  static constexpr int kOnEnd = 4;        ///< So many wider ones on end are told, if
  static constexpr double kGrown = 2.0;   ///< the last is so many times the first: two rates that beat do less.

  struct Swing {
    bool turns = false;  ///< About its axes, not along them.
    double size = 0.0;   ///< [m] or [rad].
  };
  /// How far the object is off its target now, along three axes [m] and by which angle [rad].
  std::optional<Swing> add(const Eigen::Vector3d& off_m, double off_rad);

  /// For an archive (engine/loops/archive.h).
  template <typename Archive>
  void members(Archive& a) {
    a(courses_);
  }

 private:
  struct Course {
    double far = 0.0, turned = 0.0;       ///< As far as it has come, and where it turned last.
    int way = 0;                          ///< Up or down.
    double last = 0.0, one_before = 0.0;  ///< Sizes of swings.
    int wider = 0;
    double first = 0.0;  ///< The last that was not wider.
    void add(double now, double least);

    template <typename Archive>
    void members(Archive& a) {
      a(far, turned, way, last, one_before, wider, first);
    }
  };
  std::array<Course, 4> courses_;
};

}  // namespace thenar
