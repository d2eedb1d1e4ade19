// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "solvers/dual_active_set.h"
#include "solvers/muscles/stiff_model.h"

namespace thenar {

/// The limits of stiffness as tangent planes, each made where its limit is violated; and bounds.
template <int kSize>
class StiffPlanes {
 public:
  using Lanes = typename StiffModel<kSize>::Lanes;

  /// a.x >= b, a of length 1.
  struct Plane {
    Lanes a;
    double b;
    int finger;  ///< -1: the object's stiffness.
    double over_length;
    SixWide e;                         ///< The direction, of the object or of the finger's joints.
    std::array<double, kMaxJoints> z;  ///< Motion of the joints.
  };

  explicit StiffPlanes(StiffModel<kSize>& model) : model_(model), basis_(unit_rows()) {}

  double left = 0.0;  ///< Relative violation that is tolerated.

  [[nodiscard]] DenseConstraint<kSize> most_violated(const Lanes& x, double tolerance) {
    DenseConstraint<kSize> worst = violated_bound(x);
    look_up_planes(x, worst);
    if (worst.slack < -tolerance) return worst;
    if (count_ + kMostInALook > kMost) return {};
    const int before = count_;
    look(x);
    for (int i = before; i < count_; ++i) {
      const double slack = (planes_[i].a * x).sum() - planes_[i].b;
      if (slack < worst.slack) worst = {2 * kSize + i, slack, planes_[i].a};
    }
    return worst;
  }

  [[nodiscard]] const Plane* plane(int id) const { return id < 2 * kSize ? nullptr : &planes_[id - 2 * kSize]; }

  /// Returns approximate eigenvectors of the object's stiffness.
  [[nodiscard]] const SmallSymmetric& basis() const { return basis_; }

  /// Adds u_j a_j of the set, times a factor, to x.
  void add_push(const ActiveSet<kSize>& set, double factor, Lanes& x) const {
    for (int j = 0; j < set.active; ++j) {
      const int id = set.id[j];
      if (id >= 2 * kSize) {
        x += (factor * set.multiplier[j]) * plane(id)->a;
      } else {
        x[id % kSize] += (id < kSize ? factor : -factor) * set.multiplier[j];
      }
    }
  }

 private:
  // Accuracy of planes' directions as a fraction of `left`: a plane is valid for any direction.
  static constexpr double kRoughly = 0.3;
  // Most planes that one look() makes: one for each direction of the object, or of all joints.
  static constexpr int kMostInALook = static_cast<int>(kMaxJoints);
  static constexpr int kMost = 160;

  DenseConstraint<kSize> violated_bound(const Lanes& x) const {
    DenseConstraint<kSize> worst;
    worst.row.setZero();
    const Lanes below = x - model_.lower, above = model_.upper - x;
    const double least_below = below.minCoeff(), least_above = above.minCoeff();
    const bool is_below = least_below <= least_above;
    const Lanes& slack = is_below ? below : above;
    worst.slack = is_below ? least_below : least_above;
    int i = 0;
    while (i < kSize - 1 && slack[i] != worst.slack) ++i;
    worst.id = is_below ? i : kSize + i;
    worst.row[i] = is_below ? 1.0 : -1.0;
    return worst;
  }

  void look_up_planes(const Lanes& x, DenseConstraint<kSize>& worst) const {
    int found = -1;
    for (int i = 0; i < count_; ++i) {
      const double slack = (planes_[i].a * x).sum() - planes_[i].b;
      if (slack < worst.slack) worst.slack = slack, found = i;
    }
    if (found >= 0) worst.id = 2 * kSize + found, worst.row = planes_[found].a;
  }

  /// Makes planes of the limits violated at x: of postures, or if none is, of the object's stiffness.
  void look(const Lanes& x) {
    point_.look(model_, x);
    bool are_kept = point_.is_definite;
    for (int k = 0; k < model_.fingers; ++k) {
      SmallSymmetric S = point_.posture(model_, k);
      const int n = model_.finger[k].joints;
      const double allowed = -left * model_.posture_scale;
      if (is_positive(n, S, -allowed)) continue;
      are_kept = false;
      SmallSymmetric E = unit_rows();
      diagonalise(n, -kRoughly * allowed, S, E, kRoughly);
      for (int i = 0; i < n; ++i) {
        if (S[i][i] < allowed) add_posture(k, E[i], x);
      }
    }
    const double allowed = -left * model_.stiffness_scale;
    if (!are_kept || is_positive(6, point_.S, -allowed)) return;
    SmallSymmetric X = turned(6, point_.S, basis_);
    diagonalise(6, -kRoughly * allowed, X, basis_, kRoughly);
    for (int i = 0; i < 6; ++i) {
      if (X[i][i] < allowed) add_stiffness(basis_[i], x);
    }
  }

  void add_posture(int k, const SixWide& e, const Lanes& x) {
    Plane plane;
    plane.finger = k;
    plane.e = e;
    plane.a.setZero();
    add_bend(model_, k, e.data(), e.data(), plane.a);
    double value = -model_.kappa;
    const auto& finger = model_.finger[k];
    for (int i = 0; i < finger.joints; ++i) {
      for (int c = 0; c <= i; ++c) value += (c < i ? 2.0 : 1.0) * e[i] * e[c] * point_.P[finger.first + i][c];
    }
    add(plane, value, x);
  }

  void add_stiffness(const SixWide& e, const Lanes& x) {
    Plane plane;
    plane.finger = -1;
    plane.e = e;
    point_.motion(model_, e, plane.z.data());
    plane.a = stiffness_slope(model_, e, plane.z.data(), e, plane.z.data());
    add(plane, between(6, e, point_.S, e), x);
  }

  void add(Plane& plane, double value, const Lanes& x) {
    const double length = std::sqrt(plane.a.square().sum());
    // A value that no force changes makes a plane of any length.
    plane.over_length = 1.0 / std::max(length, 1e-100);
    plane.b = ((plane.a * x).sum() - value) * plane.over_length;
    plane.a *= plane.over_length;
    planes_[count_++] = plane;
  }

  StiffModel<kSize>& model_;
  StiffPoint<kSize> point_;
  SmallSymmetric basis_;
  int count_ = 0;
  std::array<Plane, kMost> planes_;
};

}  // namespace thenar
