// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

/// Messages that a page may send: docs/reference/window.md.
namespace thenar::window {

struct Next {};
struct Ping {
  double t = 0.0;
};
struct Pull {
  Eigen::Vector3d point_m, handle_m;
  std::optional<double> stamp_s;
};
struct Release {};
struct Target {
  Eigen::Vector3d shift_m, turn_rad;
  std::optional<double> stamp_s;
};
struct Poke {
  Eigen::Vector3d force_N;
  std::optional<double> stamp_s;
};
struct Pause {};
struct Resume {};
struct Step {};
struct Reset {};
struct Speed {
  double value = 1.0;
};
/// Searches grasps for the scene's object and hand.
struct Find {
  int best = 5;  ///< Number of best grasps among the found ones.
};
/// Ends the search, which keeps what it has found.
struct StopFinding {};
/// Begins again with a grasp that a search found.
struct Take {
  int search = 0;  ///< Number of the search.
  int grasp = 0;   ///< Rank of the grasp; 0: the scene's own start.

  [[nodiscard]] bool operator==(const Take&) const = default;
};
/// Begins a recording, in a file that the program names.
struct Record {};
/// Ends the recording that is being made.
struct StopRecording {};
/// Present or new value of a key that can change while the scene runs, in the unit of its LiveKey: a number, three of
/// them, or the word of a choice.
using LiveValue = std::variant<double, Eigen::Vector3d, std::string>;
/// Values by the names of their LiveKeys.
using LiveValues = std::map<std::string, LiveValue, std::less<>>;
/// Changes the scene; what is not named stays as it is.
struct Set {
  LiveValues changes;
};

using Message = std::variant<Next, Ping, Pull, Release, Target, Poke, Pause, Resume, Step, Reset, Speed, Set, Find,
                             StopFinding, Take, Record, StopRecording>;

/// Reads one message. Whatever the text, every number of a message is finite and within its range; else there is none,
/// and a reason.
struct ReadMessage {
  std::optional<Message> message;
  std::string refusal;
};
[[nodiscard]] ReadMessage read_message(std::string_view text);

inline constexpr std::size_t kMaxMessage = 4096;  ///< Bytes.

/// Handler of a page's messages, but for Next and Ping; on the server's thread. Returns why one is refused, or nothing.
using Receive = std::function<std::string(const Message&)>;

}  // namespace thenar::window
