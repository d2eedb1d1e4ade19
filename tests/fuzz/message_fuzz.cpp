// SPDX-License-Identifier: Apache-2.0
// Whatever a page sends: a message, or a refusal with a reason.
#include <cmath>
#include <cstdlib>
#include <variant>

#include "app/window/message.h"
#include "tests/fuzz/memory_file.h"

namespace {

/// Whether all that the loops would be given is finite and small.
struct Harmless {
  bool operator()(const thenar::window::Pull& pull) const {
    return pull.point_m.norm() <= 1.0 && pull.handle_m.norm() <= 1.0;
  }
  bool operator()(const thenar::window::Target& target) const {
    return target.shift_m.cwiseAbs().maxCoeff() <= 0.05 && target.turn_rad.cwiseAbs().maxCoeff() <= 0.5;
  }
  bool operator()(const thenar::window::Poke& poke) const { return poke.force_N.norm() <= 5.0; }
  bool operator()(const thenar::window::Speed& speed) const { return speed.value >= 0.001 && speed.value <= 1.0; }
  bool operator()(const thenar::window::Ping& ping) const { return std::isfinite(ping.t); }
  bool operator()(const thenar::window::Set& set) const {
    const auto within = [&](const char* name, double low, double high) {
      const auto value = set.changes.find(name);
      if (value == set.changes.end()) return true;
      const double number = std::get<double>(value->second);
      return number >= low && number <= high;
    };
    return within("friction", 0.0, 2.0) && within("contact_Hz", 200.0, 10000.0) && within("max_sweeps", 1.0, 1000.0) &&
           within("level", 0.0, 6.0);
  }
  template <class Order>
  bool operator()(const Order&) const {
    return true;
  }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const thenar::window::ReadMessage read = thenar::window::read_message(thenar::text_of(data, size));
  if (read.message.has_value() != read.refusal.empty()) std::abort();
  if (read.message && !std::visit(Harmless{}, *read.message)) std::abort();
  return 0;
}
