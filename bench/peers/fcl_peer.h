// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

namespace thenar {

/// The FCL of Debian, built as Debian builds it: its Eigen types are laid out for SSE2 and ours for AVX. Hence this
/// library of its own, with nothing but numbers in between [m].
class __attribute__((visibility("default"))) FclScene {
 public:
  /// `corners_m` x, y, z of each; `triangles` three corners of each.
  FclScene(const std::vector<double>& corners_m, const std::vector<int>& triangles);
  ~FclScene();
  FclScene(const FclScene&) = delete;
  FclScene& operator=(const FclScene&) = delete;

  /// Makes the finger a sphere about its origin, or a mesh.
  void set_finger(double radius_m);
  void set_finger(const std::vector<double>& corners_m, const std::vector<int>& triangles);

  /// fcl::distance of a point and the mesh: not negative, inside or outside.
  [[nodiscard]] double distance_m(const double* p_m) const;

  /// fcl::collide of the finger, posed by a rotation (column by column) and a translation, and the mesh: for each
  /// contact the deepest point of the finger and the depth, negative.
  void collide(const double* rotation, const double* translation_m, std::vector<double>& points_m,
               std::vector<double>& gaps_m) const;

 private:
  struct Bodies;
  std::unique_ptr<Bodies> bodies_;
};

}  // namespace thenar
