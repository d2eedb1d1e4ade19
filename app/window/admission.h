#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Who may ask the server for something: who knows its token, also on loopback, which every user of the machine
/// reaches. A browser sends the requests of any page that it shows: from these the Host and the Origin protect, which
/// browsers state.
namespace thenar::window {

/// What a request for the server says of where it comes from; each is nothing where it was not sent.
struct Asker {
  std::optional<std::string_view> host, origin;
  std::string_view target;  ///< Path and query.
};

/// A name by which others lead pages here, such as the near end of a tunnel.
struct HostName {
  std::string name;                   ///< As a URL has it: an IPv6 address in brackets.
  std::optional<std::uint16_t> port;  ///< Nothing: any.

  [[nodiscard]] bool operator==(const HostName&) const = default;
};

/// Reads NAME or NAME:PORT: a name of DNS, or a numeric address. Nothing if the text is neither.
[[nodiscard]] std::optional<HostName> read_host_name(std::string_view text);

/// Where the server listens.
struct Listening {
  std::string address;  ///< Numeric.
  std::uint16_t port = 0;
  std::string token;                ///< Empty: nobody has it.
  std::vector<HostName> also = {};  ///< Names of it that it does not find out by itself.
};

/// Why the request is refused; empty: it is not.
[[nodiscard]] std::string refuse(const Asker& asker, const Listening& listening);

/// Whether the text is a numeric address as a URL may have it, and whether none but this machine reaches it.
enum class Reach { kNoAddress, kThisMachine, kOthers };
[[nodiscard]] Reach reach_of(const std::string& address);

/// 128 bits of the system's randomness, in hexadecimal digits.
[[nodiscard]] std::string random_token();

/// Whether the text can be a token: 16 to 128 letters, digits and any of "-._~", which a URL has as they are.
[[nodiscard]] bool can_be_token(std::string_view text);

/// Host and port as a URL has them: brackets around an IPv6 address.
[[nodiscard]] std::string host_and_port(const std::string& address, std::uint16_t port);

}  // namespace thenar::window
