// SPDX-License-Identifier: Apache-2.0
#include "app/window/telemetry.h"

#include <algorithm>
#include <cmath>

#include "engine/loops/percentiles.h"

namespace thenar::window {

namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::size_t kFewest = 10;        // In slow motion a second holds fewer ticks than make a rate.
constexpr std::size_t kLatencies = 16384;  // Percentiles are of so many at most: minutes of dragging.

double us(std::int64_t from_ns, std::int64_t to_ns) { return 1e-3 * static_cast<double>(to_ns - from_ns); }

template <typename Timing>
void keep_last_second(std::deque<Timing>& timings) {
  while (timings.size() > kFewest && timings.back().start_ns - timings.front().start_ns > kSecond_ns) {
    timings.pop_front();
  }
}

template <typename Timing>
ThreePercentiles three(const std::deque<Timing>& timings, double Timing::*value) {
  const thenar::Percentiles p = thenar::percentiles(collect(timings, value));
  return {p.p50, p.p99, p.p999};
}

template <typename Timing>
double median(const std::deque<Timing>& timings, double Timing::*value) {
  std::vector<double> values = collect(timings, value);
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

template <typename Timing>
double spent_s(const std::deque<Timing>& timings) {
  return 1e-9 * static_cast<double>(timings.back().start_ns - timings.front().start_ns);
}

template <typename Timing>
double rate_Hz(const std::deque<Timing>& timings) {
  if (timings.size() < 2) return thenar::kNotMeasured;
  return static_cast<double>(timings.size() - 1) / spent_s(timings);
}

}  // namespace

void Telemetry::begin_run(double step_s) {
  step_s_ = step_s;
  contact_.clear();
  control_.clear();
}

void Telemetry::add(const ContactSample& sample) {
  const thenar::TickReport& tick = sample.step.tick;
  contact_.push_back({sample.start_ns, sample.after.tick, us(sample.start_ns, sample.end_ns),
                      us(sample.deadline_ns, sample.start_ns), tick.assemble_s, tick.solve_s, tick.deform_s});
  keep_last_second(contact_);
  slipped_ += sample.slipped;
  overruns_ += sample.overran;
  contact_lost_ = sample.lost;
  if (sample.stamp_ns != 0) add_latency(1e-9 * static_cast<double>(sample.end_ns - sample.stamp_ns));
}

void Telemetry::add(const ControlSample& sample) {
  const thenar::ControlReport& control = sample.step.control;
  control_.push_back({sample.start_ns, us(sample.start_ns, sample.end_ns), us(sample.deadline_ns, sample.start_ns),
                      control.find_s, control.factors_s, control.grasp_s, control.muscle_s});
  keep_last_second(control_);
  control_slipped_ += sample.slipped;
  control_lost_ = sample.lost;
}

void Telemetry::end_run(const thenar::ThreadsReport& report) {
  lost_ += report.lost_samples + report.lost_control_samples;
  contact_lost_ = control_lost_ = 0;
}

void Telemetry::set_reference(double error, double residual) {
  figures_.reference_error = error;
  figures_.reference_residual = residual;
}

void Telemetry::add_latency(double latency_s) {
  const double bin = 1.0 + std::floor(2.0 * std::log2(std::max(latency_s, 1e-9) / thenar::kFirstLatency_s));
  figures_.latency_counts[static_cast<std::size_t>(std::clamp(bin, 0.0, thenar::kLatencyBins - 1.0))] += 1.0;
  if (latencies_s_.size() < kLatencies) {
    latencies_s_.push_back(latency_s);
  } else {
    latencies_s_[static_cast<std::size_t>(latencies_) % kLatencies] = latency_s;
  }
  ++latencies_;
  latencies_counted_ = false;
}

const LoopFigures& Telemetry::figures(std::int64_t now_ns) {
  if (now_ns - stock_ns_ >= kSecond_ns / 4) {
    stock_ns_ = now_ns;
    take_stock();
  }
  // Sums cost nothing.
  figures_.contact_overruns = static_cast<double>(overruns_);
  figures_.contact_slipped = static_cast<double>(slipped_);
  figures_.control_slipped = static_cast<double>(control_slipped_);
  figures_.lost_records = static_cast<double>(lost());
  return figures_;
}

void Telemetry::write_stages(TickRecord& tick) const {
  tick.find_s = medians_.find_s;
  tick.factors_s = medians_.factors_s;
  tick.grasp_s = medians_.grasp_s;
  tick.muscle_s = medians_.muscle_s;
  tick.contact.assemble_s = medians_.contact.assemble_s;
  tick.contact.solve_s = medians_.contact.solve_s;
  tick.contact.deform_s = medians_.contact.deform_s;
}

void Telemetry::take_stock() {
  figures_.contact_Hz = rate_Hz(contact_);
  figures_.contact_compute_us = three(contact_, &Contact::compute_us);
  figures_.contact_jitter_us = three(contact_, &Contact::jitter_us);
  figures_.control_Hz = rate_Hz(control_);
  figures_.control_compute_us = three(control_, &Control::total_us);
  figures_.control_jitter_us = three(control_, &Control::jitter_us);
  if (contact_.size() > 1) {
    const auto ticks = static_cast<double>(contact_.back().tick - contact_.front().tick);
    figures_.realtime_factor = ticks * step_s_ / spent_s(contact_);
  }
  if (!latencies_counted_) {
    const thenar::Percentiles p = thenar::percentiles(latencies_s_);
    figures_.latency_us = {1e6 * p.p50, 1e6 * p.p99, 1e6 * p.p999};
    latencies_counted_ = true;
  }
  medians_.find_s = median(control_, &Control::find_s);
  medians_.factors_s = median(control_, &Control::factors_s);
  medians_.grasp_s = median(control_, &Control::grasp_s);
  medians_.muscle_s = median(control_, &Control::muscle_s);
  medians_.contact.assemble_s = median(contact_, &Contact::assemble_s);
  medians_.contact.solve_s = median(contact_, &Contact::solve_s);
  medians_.contact.deform_s = median(contact_, &Contact::deform_s);
}

}  // namespace thenar::window
