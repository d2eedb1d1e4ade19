#include "app/window/admission.h"

#include <fmt/format.h>
#include <unistd.h>

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

/// The port that the text ends in after a ':'; it is cut off. Without one it is 80, the one of HTTP; 0 is none.
std::uint16_t cut_port(std::string_view& host) {
  const std::size_t colon = host.rfind(':');
  if (colon == host.npos || host.find(']', colon) != host.npos) return 80;  // A ':' of an IPv6 address.
  const auto port = number_in<std::uint16_t>(host.substr(colon + 1));
  host = host.substr(0, colon);
  return port.value_or(0);
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
  const address theirs = make_address(std::string(host), fault);
  if (fault || theirs.is_v6() != bracketed) return false;
  return theirs == ours || ours.is_unspecified() || (ours.is_loopback() && theirs.is_loopback());
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
  if (!asker.host || !is_ours(*asker.host, listening)) {
    return make_address(listening.address).is_unspecified()
               ? fmt::format("The Host must be a numeric address of this machine, with port {}.", listening.port)
               : fmt::format("The Host must be {}.", host_and_port(listening.address, listening.port));
  }
  if (listening.token.empty() || !same_secret(token_in(asker.target), listening.token)) {
    return "The address must end in the token that the program printed.";
  }
  const std::string page = "http://" + std::string(*asker.host);
  if (asker.origin && !boost::algorithm::iequals(*asker.origin, page)) {
    return "The Origin must be this server's own page.";
  }
  return "";
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

std::string host_and_port(const std::string& address, std::uint16_t port) {
  const bool v6 = address.find(':') != address.npos;
  return fmt::format("{}{}{}:{}", v6 ? "[" : "", address, v6 ? "]" : "", port);
}

}  // namespace thenar::window
