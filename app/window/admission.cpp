// SPDX-License-Identifier: Apache-2.0
#include "app/window/admission.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/algorithm/string/predicate.hpp>
#include <boost/asio/ip/address.hpp>
#include <cerrno>
#include <system_error>

#include "engine/formats/byte_source.h"

namespace thenar::window {
namespace {

using boost::asio::ip::address;
using boost::asio::ip::make_address;

bool is_letter_or_digit(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'); }

/// The port that the text ends in after a ':'; it is cut off. Without one it is 80, the one of HTTP; 0 is none.
std::uint16_t cut_port(std::string_view& host) {
  const std::size_t colon = host.rfind(':');
  if (colon == host.npos || host.find(']', colon) != host.npos) return 80;  // A ':' of an IPv6 address.
  const std::string_view digits = host.substr(colon + 1);
  const auto port = number_in<std::uint16_t>(digits);
  host = host.substr(0, colon);
  // As browsers write it: without a sign, and without zeros before it.
  return port && digits == std::to_string(*port) ? *port : std::uint16_t{0};
}

/// Whether the Host is a name of the address that is listened on. A name that someone's DNS leads here is not: so the
/// pages of others stay strangers. Numbers cannot be led elsewhere, so that any are good where all addresses are
/// listened on.
bool is_ours(std::string_view host, const Listening& listening) {
  if (cut_port(host) != listening.port) return false;
  const address ours = make_address(listening.address);
  if (ours.is_loopback() && boost::algorithm::iequals(host, "localhost")) return true;
  const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  if (bracketed) host = host.substr(1, host.size() - 2);
  boost::system::error_code fault;
  // Behind a '%' an IPv6 address may have any text, the name of an interface.
  if (host.find('%') != host.npos) return false;
  const address theirs = make_address(std::string(host), fault);
  if (fault || theirs.is_v6() != bracketed) return false;
  return theirs == ours || ours.is_unspecified() || (ours.is_loopback() && theirs.is_loopback());
}

/// Whether the Host is one of the names that the user gave.
bool is_named(std::string_view host, const std::vector<HostName>& names) {
  const std::uint16_t port = cut_port(host);
  return std::any_of(names.begin(), names.end(), [&](const HostName& name) {
    return boost::algorithm::iequals(host, name.name) && port != 0 && port == name.port.value_or(port);
  });
}

/// The value of `token` in a request's query.
std::string_view token_in(std::string_view target) {
  constexpr std::string_view kKey = "token=";
  std::size_t begin = target.find('?');
  while (begin != target.npos) {
    const std::string_view pair = target.substr(begin + 1, target.find('&', begin + 1) - begin - 1);
    if (pair.starts_with(kKey)) return pair.substr(kKey.size());
    begin = target.find('&', begin + 1);
  }
  return {};
}

/// Takes as long wherever the two differ, so that nobody finds a token out digit by digit.
bool same_secret(std::string_view shown, std::string_view token) {
  if (shown.size() != token.size()) return false;
  unsigned char difference = 0;
  for (std::size_t i = 0; i < token.size(); ++i) difference |= static_cast<unsigned char>(shown[i] ^ token[i]);
  return difference == 0;
}

}  // namespace

std::string refuse(const Asker& asker, const Listening& listening) {
  const bool named = asker.host && is_named(*asker.host, listening.also);
  if (!named && (!asker.host || !is_ours(*asker.host, listening))) {
    const std::string ours = make_address(listening.address).is_unspecified()
                                 ? fmt::format("a numeric address of this machine, with port {}", listening.port)
                                 : host_and_port(listening.address, listening.port);
    return fmt::format("The Host must be {}, or a name that --allow-host gives.", ours);
  }
  if (listening.token.empty() || !same_secret(token_in(asker.target), listening.token)) {
    return "The address must end in the token that the program printed.";
  }
  // A name may be that of a server before this one, which encrypts.
  const auto is_page = [&](const char* scheme) {
    return boost::algorithm::iequals(*asker.origin, scheme + std::string(*asker.host));
  };
  if (asker.origin && !is_page("http://") && !(named && is_page("https://"))) {
    return "The Origin must be this server's own page.";
  }
  return "";
}

std::optional<HostName> read_host_name(std::string_view text) {
  HostName host;
  const std::size_t colon = text.rfind(':');
  if (colon != text.npos && text.find(']', colon) == text.npos) {
    host.port = number_in<std::uint16_t>(text.substr(colon + 1));
    if (host.port.value_or(0) == 0) return std::nullopt;
    text = text.substr(0, colon);
  }
  host.name = text;
  if (text.starts_with('[')) {
    if (text.size() < 3 || text.back() != ']') return std::nullopt;
    const std::string inside(text.substr(1, text.size() - 2));
    if (reach_of(inside) == Reach::kNoAddress || inside.find(':') == inside.npos) return std::nullopt;
    return host;
  }
  const bool known = std::all_of(text.begin(), text.end(),
                                 [](char c) { return is_letter_or_digit(c) || c == '-' || c == '.' || c == '_'; });
  if (!known || text.empty() || text.size() > 253 || !is_letter_or_digit(text.front())) return std::nullopt;
  return host;
}

Reach reach_of(const std::string& text) {
  boost::system::error_code fault;
  const address read = make_address(text, fault);
  // Behind a '%' an IPv6 address may have any text, the name of an interface. No URL has one.
  if (fault || text.find('%') != text.npos) return Reach::kNoAddress;
  return read.is_loopback() ? Reach::kThisMachine : Reach::kOthers;
}

std::string random_token() {
  std::array<unsigned char, 16> bytes{};
  if (getentropy(bytes.data(), bytes.size()) != 0) {
    throw std::system_error(errno, std::generic_category(), "the system gives no random numbers");
  }
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

bool can_be_token(std::string_view text) {
  return text.size() >= 16 && text.size() <= 128 && std::all_of(text.begin(), text.end(), [](char c) {
           return is_letter_or_digit(c) || std::string_view("-._~").find(c) != std::string_view::npos;
         });
}

std::string host_and_port(const std::string& address, std::uint16_t port) {
  const bool v6 = address.find(':') != address.npos;
  return fmt::format("{}{}{}:{}", v6 ? "[" : "", address, v6 ? "]" : "", port);
}

}  // namespace thenar::window
