#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "thenar/eigen_layout.h"

namespace thenar {

/// A fingertip, as its user names it.
struct TipRequest {
  std::string text;                         ///< As it was written.
  std::string finger;                       ///< What the finger will be called.
  std::string place;                        ///< A site, or a body or link.
  std::optional<Eigen::Vector3d> centre_m;  ///< Of the pulp, in the frame of the place; nothing: to be found.
  std::optional<double> radius_m;
  std::optional<Eigen::Vector3d> normal;  ///< Mean outward direction of the pulp, unit, in the frame of the place.
};

/// A joint that is not to move.
struct LockRequest {
  std::string joint;
  std::optional<double> value;  ///< [rad] or [m]; nothing: its reference value.
};

/// What is to become of a mechanism.
struct HandRequest {
  std::vector<TipRequest> tips;  ///< In the order of the fingers.
  std::string base;              ///< The site or body whose frame is the hand's; empty: where the fingers part.
  Eigen::Matrix3d R_BH = Eigen::Matrix3d::Identity();  ///< The hand's axes in that frame.
  std::vector<LockRequest> locks;
  bool uncouple = false;  ///< Take joints that are coupled as if each had its own drive.
  bool mirror = false;    ///< Make the hand of the other side: z turns round.
};

/// Reads "FINGER=PLACE", and behind it in any order ":9mm", the radius, ":@0/-36/14.5mm", the pulp's centre, and ":-x"
/// or ":0/1/0.3", its outward direction. Throws ConfigError.
[[nodiscard]] TipRequest read_tip(const std::string& text);

/// Reads "JOINT" or "JOINT=20deg". Throws ConfigError.
[[nodiscard]] LockRequest read_lock(const std::string& text);

/// Reads the two axes of a frame that the hand's X and Y are, such as "z,-x". Throws ConfigError.
[[nodiscard]] Eigen::Matrix3d read_axes(const std::string& text);

}  // namespace thenar
