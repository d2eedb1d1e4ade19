// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/touch.h"

#include <algorithm>
#include <cmath>

namespace thenar {

using Eigen::Vector3d;

Touch felt_touch(const Model& model, const Frame& frame, const ContactKinematics& kinematics,
                 std::span<const PatchPoint> patch, const FingerLoad& load, const PatchReport& report, double mu,
                 TouchNoise& noise) {
  constexpr double kFelt = 1e-3;
  Touch touch;
  touch.moment_Nm = report.moment_Nm;
  double most_N = 0.0;
  for (const PatchPoint& point : patch) most_N = std::max(most_N, point.normal_N);
  double loaded_m2 = 0.0, slipping_m2 = 0.0, swept_m3 = 0.0, friction_N = 0.0, pressed_N = 0.0;
  Vector3d felt_N = load.force_N;
  for (const PatchPoint& point : patch) {
    double normal_factor = 1.0, tangential_factor = 1.0;
    if (noise.share > 0.0) {
      normal_factor = noise.factor(), tangential_factor = noise.factor();
      const Vector3d normal_W = point.normal_N * kinematics.E_W[point.contact].col(0);
      felt_N += (normal_factor - 1.0) * normal_W + (tangential_factor - 1.0) * (point.f_W - normal_W);
    }
    if (point.normal_N <= kFelt * most_N) continue;
    const double at_m2 = area_of(model, frame.contacts[point.contact]);
    loaded_m2 += at_m2;
    const double limit_N = (1.0 - kOnCone) * mu * point.normal_N;
    if (point.friction_N < limit_N) continue;
    slipping_m2 += at_m2;
    swept_m3 += at_m2 * point.d_W.norm();
    friction_N += tangential_factor * point.friction_N;
    pressed_N += normal_factor * point.normal_N;
  }
  touch.normal_N = felt_N.dot(load.normal);
  touch.tangential_N = felt_N - touch.normal_N * load.normal;
  if (!(loaded_m2 > 0.0)) return touch;
  touch.stick = (loaded_m2 - slipping_m2) / loaded_m2;
  touch.slip_m_per_s = swept_m3 / (loaded_m2 * model.scene.step_s);
  if (pressed_N > 0.0) touch.friction = friction_N / pressed_N;
  return touch;
}

}  // namespace thenar
