#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// Who may ask the server for something: who knows its token, also on loopback, which every user of the machine
/// reaches. A browser sends the requests of any page that it shows: from these the Host and the Origin protect, which
/// browsers state.
namespace thenar::window {

/// What a request for the server says of where it comes from; each is nothing where it was not sent.
struct Asker {
  std::optional<std::string_view> host, origin;
  std::string_view target;  ///< Path and query.
};

/// Where the server listens.
struct Listening {
  std::string address;  ///< Numeric.
  std::uint16_t port = 0;
  std::string token;  ///< Empty: nobody has it.
};

/// Why the request is refused; empty: it is not.
[[nodiscard]] std::string refuse(const Asker& asker, const Listening& listening);

/// Whether the text is a numeric address as a URL may have it, and whether none but this machine reaches it.
enum class Reach { kNoAddress, kThisMachine, kOthers };
[[nodiscard]] Reach reach_of(const std::string& address);

/// 128 bits of the system's randomness, in hexadecimal digits.
[[nodiscard]] std::string random_token();

/// Host and port as a URL has them: brackets around an IPv6 address.
[[nodiscard]] std::string host_and_port(const std::string& address, std::uint16_t port);

}  // namespace thenar::window
