// SPDX-License-Identifier: Apache-2.0
#include "engine/results/loop_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace thenar {

namespace {

/// Returns the steps by which the delay of a scene can change: what is known late is known by whole periods.
int delay_unit(const Scene& scene) {
  const bool whole = scene.control_delay_s == 0.0 && scene.control->feedback_delay_s > 0.0;
  return whole ? std::max(1, static_cast<int>(std::lround(scene.control_period_s / scene.step_s))) : 1;
}

std::string mode_in_words(const PoseMode& mode) {
  const Eigen::Vector3d axis = mode.axis_O.unaryExpr([](double x) { return std::abs(x) < 0.005 ? 0.0 : x; });
  return fmt::format("{} ({:.2f}, {:.2f}, {:.2f})", mode.turns ? "rotation about" : "translation along", axis.x(),
                     axis.y(), axis.z());
}

std::string timing_in_words(const Scene& scene, int delay) {
  return fmt::format("at {:.4g} Hz and a delay of {:.3g} ms", 1.0 / scene.control_period_s, 1e3 * scene.step_s * delay);
}

std::string of_phase(const Model& model, int phase) {
  if (phase < 0) return "";
  const auto index = static_cast<std::size_t>(phase);
  return fmt::format(" in phase {}, {},", phase + 1, to_string(model.scene.task.phases[index].kind));
}

/// Returns "control.rotation.p of at most 0.1 N m/rad", with its integral and derivative gain if there are any. It
/// rounds down.
std::string gain_in_words(const std::string& key, const PidGains& gains, double times, const char* unit) {
  const double digit = std::pow(10.0, std::floor(std::log10(times * gains.p)) - 1.0);
  const std::string others = gains.i != 0.0 && gains.d != 0.0 ? " (i and d in proportion)"
                             : gains.i != 0.0                 ? " (i in proportion)"
                             : gains.d != 0.0                 ? " (d in proportion)"
                                                              : "";
  return fmt::format("{}.p of at most {:.2g} {}{}", key, std::floor(times * gains.p / digit) * digit, unit, others);
}

}  // namespace

LoopMargin loop_margin(const Model& model, const PoseLoop& loop, int phase) {
  const PoseGains gains = pose_gains(model.scene, phase);
  const int unit = delay_unit(model.scene);
  LoopMargin margin;
  margin.phase = phase;
  margin.delay = loop.delay_steps();
  margin.slowest = loop.slowest(gains, margin.delay);
  const double most = loop.most_gain(gains, margin.delay);
  margin.share = 1.0 / most;
  margin.limiting = most > 0.0 ? loop.slowest(gains.times(1.03 * most, 1.03 * most), margin.delay) : margin.slowest;
  if (!margin.is_known()) return margin;
  margin.most_delay = loop.most_delay(gains, unit);
  if (!margin.is_near()) return margin;
  margin.safe_delay = loop.most_delay(gains.times(1.0 / kNearLimit, 1.0 / kNearLimit), unit);
  margin.position = kNearLimit * loop.most_gain(gains, margin.delay, PoseLoop::Of::kPosition);
  margin.rotation = kNearLimit * loop.most_gain(gains, margin.delay, PoseLoop::Of::kRotation);
  return margin;
}

std::vector<LoopMargin> loop_margins(const Model& model) {
  std::vector<LoopMargin> all;
  if (!model.scene.control) return all;
  const PoseLoop loop(model);
  all.push_back(loop_margin(model, loop));
  for (int i = 0; i < std::ssize(model.scene.task.phases); ++i) {
    const Phase& phase = model.scene.task.phases[static_cast<std::size_t>(i)];
    if (phase.position || phase.rotation || phase.centre_m) all.push_back(loop_margin(model, loop, i));
  }
  return all;
}

std::string in_words(const Model& model, const LoopMargin& margin) {
  if (!margin.is_known())
    return "not known: the fingers do not grasp at the start, or what else the controller does is unstable";
  const double step_ms = 1e3 * model.scene.step_s;
  std::string words = fmt::format("pole of {:.4g} a period, {}", margin.slowest.pole, mode_in_words(margin.slowest));
  words += margin.most_delay < 0 ? "; unstable without a delay, too"
                                 : fmt::format("; stable up to a delay of {:.3g} ms", step_ms * margin.most_delay);
  if (margin.share > 0.0) {
    words += fmt::format(", and up to {:.3g} times its gains, {}", 1.0 / margin.share, mode_in_words(margin.limiting));
  }
  return words;
}

std::string trouble_in_words(const Model& model, const LoopMargin& margin) {
  if (!margin.is_near()) return "";
  const Scene& scene = model.scene;
  const double step_ms = 1e3 * scene.step_s;
  const PoseGains gains = pose_gains(model.scene, margin.phase);
  const bool grows = !(margin.share < 1.0);
  const PoseMode& mode = grows ? margin.slowest : margin.limiting;
  const std::string at = timing_in_words(scene, margin.delay);
  std::string words =
      fmt::format("the object's pose loop{} {} its delay: {} of the object ", of_phase(model, margin.phase),
                  grows ? "does not stand" : "hardly stands", mode_in_words(mode));
  words += grows ? fmt::format("has a pole of {:.3g} {}", mode.pole, at)
                 : fmt::format("grows from {:.3g} times its gains on {}", 1.0 / margin.share, at);
  const std::string of = margin.phase < 0 ? "control." : "its ";
  std::string remedies;
  const auto add = [&](const std::string& remedy) { remedies += (remedies.empty() ? "" : ", or ") + remedy; };
  if (margin.safe_delay >= 0 && margin.safe_delay < margin.delay) {
    add(fmt::format("a delay of at most {:.3g} ms", step_ms * margin.safe_delay));
  }
  if (margin.rotation > 0.0 && margin.rotation < 1.0 && gains.rotation.p > 0.0) {
    add(gain_in_words(of + "rotation", gains.rotation, margin.rotation, "N m/rad"));
  }
  if (margin.position > 0.0 && margin.position < 1.0 && gains.position.p > 0.0) {
    add(gain_in_words(of + "position", gains.position, margin.position, "N/m"));
  }
  if (remedies.empty()) remedies = fmt::format("{:.2g} of all its gains", kNearLimit / margin.share);
  return words + "; " + remedies + ", would do";
}

std::string runaway_in_words(const Model& model, const ControlReport& solved, double time_s) {
  const PoseLoop loop(model, solved);
  const int delay = loop.delay_steps();
  if (delay == 0) return "";
  const PoseMode mode = loop.slowest(pose_gains(model.scene), delay);
  if (mode.is_stable()) return "";
  return fmt::format("while the grip built up, its loop ran away: at {:.3f} s {} of the object has a pole of {:.3g} {}",
                     time_s, mode_in_words(mode), mode.pole, timing_in_words(model.scene, delay));
}

}  // namespace thenar
