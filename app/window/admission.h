// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Admission to the server: only with its token, also on loopback, which every user of the machine reaches. A browser
/// sends the requests of any page that it shows: the Host and the Origin, which browsers state, protect from these.
namespace thenar::window {

/// Origin of a request as it states it; each part is nothing where it was not sent.
struct Asker {
  std::optional<std::string_view> host, origin;
  std::string_view target;  ///< Path and query.
};

/// A name by which others lead pages here, such as the near end of a tunnel.
struct HostName {
  std::string name;                   ///< Name as in a URL: an IPv6 address in brackets.
  std::optional<std::uint16_t> port;  ///< Nothing: any.

  [[nodiscard]] bool operator==(const HostName&) const = default;
};

/// Reads NAME or NAME:PORT: a DNS name or a numeric address. Returns nothing if the text is neither.
[[nodiscard]] std::optional<HostName> read_host_name(std::string_view text);

/// Address, port and token of the server.
struct Listening {
  std::string address;  ///< Numeric address.
  std::uint16_t port = 0;
  std::string token;                ///< Empty: nobody has it.
  std::vector<HostName> also = {};  ///< Further names, which the server cannot find out.
};

/// Returns why the request is refused; empty: it is not.
[[nodiscard]] std::string refuse(const Asker& asker, const Listening& listening);

/// Reach of a numeric address as a URL may have it: none for other text, this machine alone, or others.
enum class Reach { kNoAddress, kThisMachine, kOthers };
[[nodiscard]] Reach reach_of(const std::string& address);

/// Returns 128 bits of the system's randomness, in hexadecimal digits.
[[nodiscard]] std::string random_token();

/// Returns true for a possible token: 16 to 128 letters, digits and any of "-._~", which a URL has as they are.
[[nodiscard]] bool can_be_token(std::string_view text);

/// Returns host and port as in a URL: brackets around an IPv6 address.
[[nodiscard]] std::string host_and_port(const std::string& address, std::uint16_t port);

}  // namespace thenar::window
