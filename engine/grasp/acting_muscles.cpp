// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/acting_muscles.h"

#include <algorithm>
#include <cmath>

namespace thenar {

using Eigen::Index;

namespace {

// The stiffness of fibres is as small as their force: whether muscles yield that hardly pull makes no difference.
constexpr double kLeastPull_N = 0.1;

/// Lets the muscles of finger k act: see let_muscles_act(). Four joints are usual, and sums of four numbers are quick.
template <int kJoints>
void let_finger_act(const Model& model, const Frame& frame, int k, const State& state, std::span<BellyStretch> bellies,
                    JointVector& torque, PerFinger<JointMatrix>& all_stiffness) {
  constexpr int kMost = kJoints == Eigen::Dynamic ? kMaxFingerJoints : kJoints;
  using Square = Eigen::Matrix<double, kJoints, kJoints, 0, kMost, kMost>;
  using Column = Eigen::Matrix<double, kJoints, 1, 0, kMost, 1>;
  const MuscleSettings& settings = *model.scene.control->muscles;
  const auto& gamma = settings.short_range;
  const Fingertip& tip = model.scene.hand.fingertips[k];
  const Index n = tip.joints;
  const auto own = [&](const JointVector& v) { return v.segment<kJoints>(tip.first_joint, n); };
  const Column turned = own(state.q) - own(frame.q_rest);
  Square stiffness = Square::Zero(n, n), geometric = stiffness;
  Column more = Column::Zero(n);
  for (std::size_t b = 0; b < frame.bellies.size(); ++b) {
    const Belly& belly = frame.bellies[b];
    if (belly.finger != k) continue;
    bellies[b] = {};
    const double f_N = state.muscle_N[belly.muscle], more_N = f_N - frame.muscle_N[belly.muscle];
    if (f_N == 0.0 && more_N == 0.0) continue;
    const auto arms = Eigen::Map<const Column>(belly.arms_m.data(), n);
    more += more_N * arms;
    if (!gamma) continue;
    const double k_N_per_m = belly_stiffness(model.scene.hand, belly, *gamma, f_N);
    const double elastic_N = -k_N_per_m * arms.dot(turned);
    // Muscles do not push: shortened by 1 / gamma their fibres are slack, however far their range goes.
    const double range =
        elastic_N < 0.0 ? std::min(settings.short_range_strain, 1.0 / *gamma) : settings.short_range_strain;
    if (const auto yielded = yielded_N(*gamma, range, f_N, elastic_N)) {
      bellies[b].more_N = *yielded;
      more += *yielded * arms;
    } else {
      bellies[b] = {elastic_N, k_N_per_m};
      stiffness += (k_N_per_m * arms).lazyProduct(arms.transpose());
    }
    geometric -= f_N * Eigen::Map<const Square>(belly.slopes_m.data(), n, n);
  }
  auto all = torque.segment<kJoints>(tip.first_joint, n);
  all += more;
  if (!gamma) return;
  geometric += Eigen::Map<const Square>(frame.turning[k].data(), n, n);
  all -= stiffness.lazyProduct(own(state.q) - own(frame.q_rest)) + geometric.lazyProduct(own(state.q) - own(frame.q));
  all_stiffness[k] = stiffness + geometric;
}

/// Returns the strain of a belly's fibres: of its stretch, what its tendon does not take.
double fibre_strain(const Muscle& muscle, const Belly& belly, double turned_m, double more_N) {
  return (-turned_m / belly.share - more_N / muscle.tendon_N_per_m) / *muscle.fibre_m;
}

}  // namespace

void activate(const Model& model, const Frame& frame, State& state) {
  const auto& activation = model.scene.control->muscles->activation;
  if (!activation || state.muscle_N.size() != frame.muscle_N.size()) {
    state.muscle_N = frame.muscle_N;
    return;
  }
  MuscleVector steps(state.muscle_N.size());  // In time constants.
  const double rise = model.scene.step_s / activation->rise_s, fall = model.scene.step_s / activation->fall_s;
  for (Index m = 0; m < steps.size(); ++m) {
    const double f_N = state.muscle_N[m], slowness = 0.5 + 1.5 * f_N / model.scene.hand.muscles[m].max_force_N;
    steps[m] = frame.muscle_N[m] > f_N ? rise / slowness : fall * slowness;
  }
  state.muscle_N = frame.muscle_N.array() + (state.muscle_N - frame.muscle_N).array() * (-steps.array()).exp();
}

void let_muscles_act(const Model& model, const Frame& frame, const State& state, std::span<BellyStretch> bellies,
                     JointVector& torque, PerFinger<JointMatrix>& stiffness) {
  for (int k = 0; k < model.fingers(); ++k) {
    const bool is_usual = model.scene.hand.fingertips[k].joints == 4;
    (is_usual ? let_finger_act<4> : let_finger_act<Eigen::Dynamic>)(model, frame, k, state, bellies, torque, stiffness);
  }
}

YieldedFibres take_pulls(const Model& model, const Frame& frame, std::span<const BellyStretch> bellies,
                         const JointVector& dq, State& state) {
  YieldedFibres yielded;
  const Hand& hand = model.scene.hand;
  if (!model.scene.muscles_act()) {
    state.pull_N = frame.muscle_N;
    return yielded;
  }
  state.pull_N = state.muscle_N;
  const MuscleSettings& settings = *model.scene.control->muscles;
  if (!settings.short_range) return yielded;
  for (std::size_t b = 0; b < bellies.size(); ++b) {
    const Belly& belly = frame.bellies[b];
    const Fingertip& tip = hand.fingertips[belly.finger];
    const auto arms = belly.arms_m.head(tip.joints);
    const auto own = [&](const JointVector& v) { return v.segment(tip.first_joint, tip.joints); };
    const double more_N = bellies[b].more_N - bellies[b].stiffness_N_per_m * arms.dot(own(dq));
    state.pull_N[belly.muscle] += belly.share * more_N;
    if (state.muscle_N[belly.muscle] < kLeastPull_N) continue;
    const double turned_m = arms.dot(own(state.q) - own(frame.q_rest));
    const double strain = fibre_strain(hand.muscles[belly.muscle], belly, turned_m, more_N);
    if (!(std::abs(strain) > settings.short_range_strain)) continue;
    yielded.muscles |= std::uint64_t{1} << belly.muscle;
    if (std::abs(strain) <= std::abs(yielded.strain)) continue;
    yielded.most = belly.muscle;
    yielded.strain = strain;
  }
  return yielded;
}

}  // namespace thenar
