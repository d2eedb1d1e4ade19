#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

/// What a page may send, as docs/reference/window.md has it.
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
  int best = 5;  ///< Of all that are found.
};
/// Ends the search, which keeps what it has found.
struct StopFinding {};
/// Begins again with a grasp that a search found.
struct Take {
  int search = 0;  ///< Its number,
  int grasp = 0;   ///< and the grasp's rank; 0: the start that the scene itself has.

  [[nodiscard]] bool operator==(const Take&) const = default;
};
/// Changes of the scene; nothing: stays as it is.
struct Set {
  std::optional<double> friction, internal_force_N, tolerance, contact_Hz, control_Hz, around_friction, around_m_per_N;
  std::optional<int> max_sweeps, delay_periods, level;
  std::optional<std::string> kernel;
  std::optional<Eigen::Vector3d> asked_N_per_m, asked_Nm_per_rad;
};

using Message = std::variant<Next, Ping, Pull, Release, Target, Poke, Pause, Resume, Step, Reset, Speed, Set, Find,
                             StopFinding, Take>;

/// Reads one message. Whatever the text, every number of a message is finite and within its range; else there is none,
/// and a reason.
struct ReadMessage {
  std::optional<Message> message;
  std::string refusal;
};
[[nodiscard]] ReadMessage read_message(std::string_view text);

inline constexpr std::size_t kMaxMessage = 4096;  ///< Bytes.

/// What to do with a message of a page, but for Next and Ping; on the server's thread. Returns why it is refused, or
/// nothing.
using Receive = std::function<std::string(const Message&)>;

}  // namespace thenar::window
