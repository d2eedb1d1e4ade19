// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "thenar/eigen_layout.h"

namespace thenar {

/// A fingertip as requested by the user.
struct TipRequest {
  std::string text;                         ///< Original text.
  std::string finger;                       ///< Name of the finger.
  std::string place;                        ///< A site, or a body or link.
  std::optional<Eigen::Vector3d> centre_m;  ///< Centre of the pulp, in the frame of the place; nothing: to be found.
  std::optional<double> radius_m;
  std::optional<Eigen::Vector3d> normal;  ///< Mean outward direction of the pulp, unit, in the frame of the place.
};

/// A joint to be locked.
struct LockRequest {
  std::string joint;
  std::optional<double> value;  ///< [rad] or [m]; nothing: its reference value.
};

/// A request to make a hand of a mechanism.
struct HandRequest {
  std::vector<TipRequest> tips;  ///< Fingertips, in the order of the fingers.
  std::string base;              ///< The site or body whose frame is the hand's; empty: the last body shared by all.
  Eigen::Matrix3d R_BH = Eigen::Matrix3d::Identity();  ///< The hand's axes in that frame.
  std::vector<LockRequest> locks;
  bool uncouple = false;  ///< Treat coupled joints as if each had its own drive.
  bool mirror = false;    ///< Make the mirror image of the hand: z is reversed.
};

/// Splits the value of --tips at commas that stand in no quotes.
[[nodiscard]] std::vector<std::string> split_tips(std::string_view text);

/// Reads "FINGER=PLACE", followed in any order by ":9mm", the radius, ":@0/-36/14.5mm", the pulp's centre, and ":-x" or
/// ":0/1/0.3", its outward direction. A colon belongs to the name of the place if what follows begins with a letter and
/// is no axis: "thumb=robot0:tip". In double quotes all does, and two of them are one: "thumb=\"a:x,b\":9mm". Throws
/// ConfigError.
[[nodiscard]] TipRequest read_tip(const std::string& text);

/// Reads "JOINT" or "JOINT=20deg". Throws ConfigError.
[[nodiscard]] LockRequest read_lock(const std::string& text);

/// Reads the axes of a frame that are the hand's X and Y, such as "z,-x". Throws ConfigError.
[[nodiscard]] Eigen::Matrix3d read_axes(const std::string& text);

}  // namespace thenar
