// SPDX-License-Identifier: Apache-2.0
#include "engine/control/reflex.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace thenar {

using Eigen::Vector3d;

namespace {

constexpr double kMemory_s = 0.02;       // Time in which an unexpected load becomes the expected one.
constexpr double kUsualMargin = 0.3;     // Margin of people, if the scene has none.
constexpr double kHardlySticks = 0.5;    // Fraction of the least share: the patch is about to slide.
constexpr double kStep = 0.1;            // Decrease of friction that indicates another surface; else
constexpr double kSteady_s = 0.05;       // friction is averaged over this time.
constexpr double kMostlySlips = 0.5;     // Sticking share below which the sensed friction is not that of a few points.
constexpr double kMuchMore = 2.0;        // Severity, relative to a running pulse's cause, of a new one.
constexpr double kRises_s = 0.15;        // Releasing takes longer than gripping.
constexpr double kMostSqueeze_N = 50.0;  // More than fingers can exert.

/// Returns the rise of a pulse, from 0 to 1, `s` after it began.
double risen(double s, double pulse_s) {
  return 0.5 * (1.0 - std::cos(std::numbers::pi * std::clamp(s / pulse_s, 0.0, 1.0)));
}

}  // namespace

Reflex::Reflex(const Model& model) : delay_s_(model.scene.fingertips->touch->delay_s), fingers_(model.fingers()) {
  const ControlSettings& control = *model.scene.control;
  margin_ = control.felt_margin.value_or(kUsualMargin);
  for (Finger& finger : fingers_) finger.friction = control.grasp_friction * (1.0 + margin_);
}

void Reflex::feel_friction(const Touch& touch, double period_s, Finger& finger) {
  const double felt = touch.friction;
  if (!(felt > 0.0)) return;
  const double rises_s = felt > finger.friction ? kRises_s : kSteady_s;
  const bool falls_at_once = felt < (1.0 - kStep) * finger.friction && touch.stick < kMostlySlips;
  finger.friction += (falls_at_once ? 1.0 : 1.0 - std::exp(-period_s / rises_s)) * (felt - finger.friction);
}

Reflex::Surprise Reflex::feel_load(const ControlSettings& control, const Sensed& felt, int k, double period_s) {
  const ReflexSettings& settings = *control.reflex;
  Finger& finger = fingers_[k];
  const Touch& touch = felt.snapshot.touch[k];
  const Vector3d n = felt.snapshot.load[k].normal, desired_N = felt.desired_N.col(k);
  const Vector3d expected_N = desired_N - desired_N.dot(n) * n;
  const Vector3d unexpected_N = touch.tangential_N - expected_N;
  if (!finger.is_loaded) finger.mean_N = unexpected_N;
  finger.is_loaded = touch.normal_N > 0.0;
  // A decreasing load needs no response; one that decreases as its patch slides is a slip.
  const double change_N = touch.tangential_N.norm() - (expected_N + finger.mean_N).norm();
  const double rate_N_per_s = change_N / kMemory_s;
  finger.mean_N += (1.0 - std::exp(-period_s / kMemory_s)) * (unexpected_N - finger.mean_N);
  Surprise surprise;
  const double mu_c = finger.friction / (1.0 + margin_);
  if (!finger.is_loaded || !(mu_c > 0.0)) return surprise;
  if (rate_N_per_s > settings.load_rate_N_per_s) {
    // The load when the response acts.
    surprise = {ReflexEvent::kLoad, rate_N_per_s / settings.load_rate_N_per_s,
                (change_N + rate_N_per_s * delay_s_) / mu_c};
  } else if (touch.stick < kHardlySticks * settings.stick) {
    // Cones of sensed friction already give the needed forces.
    const double lacks_N = control.felt_margin ? 0.0 : expected_N.norm() / mu_c - desired_N.dot(n);
    surprise = {ReflexEvent::kSlip, 1.0, std::max(0.0, lacks_N)};
  }
  return surprise;
}

ReflexReport Reflex::update(const Model& model, const Sensed& felt, const Snapshot& now, const Eigen::VectorXd& asked_N,
                            double period_s) {
  const ControlSettings& control = *model.scene.control;
  const double now_s = static_cast<double>(now.tick) * model.scene.step_s;
  if (now.held || felt.snapshot.held) quiet_until_s_ = std::max(quiet_until_s_, now_s + 2.0 * kResume_s);
  const bool quiet = now_s < quiet_until_s_;
  ReflexReport report;
  report.friction = PerFinger<double>(model.fingers());
  report.grips = PerFinger<ContactGrip>(model.fingers());
  for (int k = 0; k < model.fingers(); ++k) {
    feel_friction(felt.snapshot.touch[k], period_s, fingers_[k]);
    report.friction[k] = fingers_[k].friction;
  }
  PerFinger<double> pressing_N(model.fingers());
  for (int k = 0; k < model.fingers(); ++k) pressing_N[k] = asked_N.segment<3>(3 * k).dot(now.load[k].normal);
  if (control.reflex) answer(control, felt, pressing_N, now_s, period_s, quiet, report);
  for (int k = 0; k < model.fingers(); ++k) {
    const Finger& finger = fingers_[k];
    report.grips[k].friction = control.felt_margin ? finger.friction / (1.0 + margin_) : control.grasp_friction;
    report.grips[k].internal_force_N =
        std::min(kMostSqueeze_N, control.internal_force_N + finger.caught_N + finger.regulated_N);
  }
  return report;
}

void Reflex::answer(const ControlSettings& control, const Sensed& felt, const PerFinger<double>& pressing_N,
                    double now_s, double period_s, bool quiet, ReflexReport& report) {
  const ReflexSettings& settings = *control.reflex;
  // A pulse responds to its cause, or to a much more severe one; the load that returns after a slip is its own effect.
  const double running_s = now_s - pulse_from_s_;
  const bool comes_back = answers_slip_ && running_s < delay_s_ + 2.0 * kMemory_s;
  const double masked = running_s < settings.pulse_s ? kMuchMore * severity_ : 0.0;
  // A grip force acts beyond that of the cones: it rises from there.
  const auto beyond_N = [&](int k) { return pressing_N[k] - control.internal_force_N; };
  double loudest = 0.0;
  PerFinger<double> target_N(static_cast<int>(fingers_.size()));
  for (int k = 0; k < std::ssize(fingers_); ++k) {
    const Surprise surprise = feel_load(control, felt, k, period_s);
    if (quiet) continue;
    target_N[k] = surprise.target_N;
    if (running_s < kMemory_s) severity_ = std::max(severity_, surprise.severity);
    if (running_s >= kMemory_s && !comes_back && surprise.severity > std::max(loudest, masked)) {
      loudest = surprise.severity;
      report.event = surprise.event;
      report.finger = k;
      report.rate_N_per_s = surprise.event == ReflexEvent::kLoad ? loudest * settings.load_rate_N_per_s : 0.0;
    }
    Finger& finger = fingers_[k];
    const Touch& touch = felt.snapshot.touch[k];
    const double lacks = settings.stick - touch.stick;
    if (lacks > 0.0) finger.regulated_N = std::max(finger.regulated_N, beyond_N(k) - finger.caught_N);
    finger.regulated_N += settings.regulation_per_s * period_s * std::max(0.0, touch.normal_N) * lacks;
    finger.regulated_N = std::clamp(finger.regulated_N, -control.internal_force_N, kMostSqueeze_N);
  }
  if (report.event != ReflexEvent::kNone) {
    pulse_from_s_ = now_s;
    severity_ = loudest;
    answers_slip_ = report.event == ReflexEvent::kSlip;
    for (int k = 0; k < std::ssize(fingers_); ++k) {
      fingers_[k].pulse_N = 0.0;
      fingers_[k].caught_N = std::max(fingers_[k].caught_N, beyond_N(k) - fingers_[k].regulated_N);
    }
  }
  const double s = now_s - pulse_from_s_;
  const double rise = risen(s, settings.pulse_s) - risen(s - period_s, settings.pulse_s);
  for (int k = 0; k < std::ssize(fingers_); ++k) {
    Finger& finger = fingers_[k];
    // Later the load answers the grip, and no longer only the grip the load.
    if (s < kMemory_s) finger.pulse_N = std::max(finger.pulse_N, target_N[k]);
    finger.caught_N += rise * finger.pulse_N;
    if (s > settings.pulse_s) finger.caught_N *= std::exp(-period_s / settings.release_s);
  }
}

}  // namespace thenar
