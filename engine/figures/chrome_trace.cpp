// SPDX-License-Identifier: Apache-2.0
#include "engine/figures/chrome_trace.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <deque>
#include <unordered_map>
#include <utility>

namespace thenar {

namespace {

enum Thread { kContact = 1, kControl = 2 };

/// The events, one a line.
class Events {
 public:
  explicit Events(std::int64_t origin_ns) : origin_ns_(origin_ns) {}

  [[nodiscard]] double us(std::int64_t time_ns) const { return 1e-3 * static_cast<double>(time_ns - origin_ns_); }

  void name(Thread thread, const std::string& name) {
    add(R"("ph":"M","name":"thread_name","pid":1,"tid":{},"args":{{"name":"{}"}})", static_cast<int>(thread), name);
    add(R"("ph":"M","name":"thread_sort_index","pid":1,"tid":{},"args":{{"sort_index":{}}})", static_cast<int>(thread),
        static_cast<int>(thread));
  }
  void slice(Thread thread, const char* name, double from_us, double length_us, const std::string& args) {
    add(R"("ph":"X","name":"{}","pid":1,"tid":{},"ts":{:.3f},"dur":{:.3f},"args":{{{}}})", name,
        static_cast<int>(thread), from_us, length_us, args);
  }
  /// An arrow from the slice of one thread that covers `from_us` to that of another that covers `to_us`.
  void arrow(const char* what, std::int64_t id, Thread from, double from_us, Thread to, double to_us) {
    add(R"("ph":"s","name":"{0}","cat":"{0}","id":{1},"pid":1,"tid":{2},"ts":{3:.3f})", what, id,
        static_cast<int>(from), from_us);
    add(R"("ph":"f","bp":"e","name":"{0}","cat":"{0}","id":{1},"pid":1,"tid":{2},"ts":{3:.3f})", what, id,
        static_cast<int>(to), to_us);
  }
  [[nodiscard]] std::string json() const {
    return "{\"displayTimeUnit\":\"ns\",\"traceEvents\":[\n" + events_ + "\n]}\n";
  }

 private:
  template <typename... Args>
  void add(fmt::format_string<Args...> format, Args&&... args) {
    if (!events_.empty()) events_ += ",\n";
    events_ += '{' + fmt::format(format, std::forward<Args>(args)...) + '}';
  }

  std::int64_t origin_ns_;
  std::string events_;
};

/// The traces that start at `from_ns` or later.
template <typename Trace>
auto tail(const std::deque<Trace>& traces, std::int64_t from_ns) {
  const auto first = std::lower_bound(traces.begin(), traces.end(), from_ns,
                                      [](const Trace& trace, std::int64_t ns) { return trace.start_ns < ns; });
  return std::pair(first, traces.end());
}

void add_contact_tick(const ContactTrace& tick, Events& events) {
  events.slice(
      kContact, tick.held ? "contact tick, held" : "contact tick", events.us(tick.start_ns), tick.compute_us(),
      fmt::format(R"("tick":{},"frame":{},"jitter_us":{:.3f},"sweeps":{},"residual":{:.3g},"contacts":{})", tick.tick,
                  tick.sequence, tick.jitter_us(), tick.sweeps, tick.finite ? tick.residual : -1.0F, tick.contacts));
}

void add_control_tick(const ControlTrace& tick, Events& events) {
  const double from_us = events.us(tick.start_ns);
  events.slice(kControl, "control tick", from_us, tick.total_us(),
               fmt::format(R"("frame":{},"snapshot":{},"jitter_us":{:.3f},"published":{})", tick.sequence,
                           tick.snapshot_tick, tick.jitter_us(), tick.published));
  double stage_us = from_us;
  for (const auto& [name, length] : std::array<std::pair<const char*, float>, 4>{{{"grasp forces", tick.grasp_us},
                                                                                  {"muscle forces", tick.muscle_us},
                                                                                  {"find", tick.find_us},
                                                                                  {"factors", tick.factors_us}}}) {
    // A stage must not outlast its tick: two clock readings may say so by their own length.
    const double length_us = std::min<double>(length, from_us + tick.total_us() - stage_us);
    if (length_us > 0.0) events.slice(kControl, name, stage_us, length_us, "");
    stage_us += std::max(length_us, 0.0);
  }
}

}  // namespace

std::string chrome_trace(const Model& model, const LoopProfile& profile, double duration_s) {
  const auto& all = profile.contact();
  if (all.empty()) return Events(0).json();
  const auto from_ns = all.back().start_ns - static_cast<std::int64_t>(1e9 * duration_s);
  const auto [contact, contact_end] = tail(all, from_ns);
  const auto [control, control_end] = tail(profile.control(), from_ns);
  Events events(std::min(contact->start_ns, control == control_end ? contact->start_ns : control->start_ns));
  events.name(kContact, fmt::format("contact, {:g} Hz", 1.0 / model.scene.step_s));
  events.name(kControl, fmt::format("control, {:g} Hz", 1.0 / model.scene.control_period_s));

  // A value is published at the end of its tick; half a microsecond before it lies inside the slice.
  constexpr std::int64_t kInside_ns = 500;
  std::unordered_map<std::int64_t, std::int64_t> frame_ns, snapshot_ns;
  for (auto tick = control; tick != control_end; ++tick) {
    add_control_tick(*tick, events);
    if (tick->published) frame_ns[tick->sequence] = std::max(tick->start_ns, tick->end_ns - kInside_ns);
  }
  for (auto tick = contact; tick != contact_end; ++tick) {
    add_contact_tick(*tick, events);
    snapshot_ns[tick->tick] = std::max(tick->start_ns, tick->end_ns - kInside_ns);
    const auto frame = frame_ns.find(tick->sequence);
    if (!tick->handed_over || frame == frame_ns.end()) continue;
    events.arrow("frame", tick->sequence, kControl, events.us(frame->second), kContact, events.us(tick->start_ns));
  }
  for (auto tick = control; tick != control_end; ++tick) {
    const auto snapshot = snapshot_ns.find(tick->snapshot_tick);
    if (snapshot == snapshot_ns.end()) continue;
    events.arrow("snapshot", tick->sequence, kContact, events.us(snapshot->second), kControl,
                 events.us(tick->start_ns));
  }
  return events.json();
}

}  // namespace thenar
