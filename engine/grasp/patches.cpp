#include "engine/grasp/patches.h"

#include <algorithm>
#include <cmath>

#include "engine/grasp/object_compliance.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Vector3d;

void note_points(const Frame& frame, const ContactKinematics& kinematics, const State& state, const Eigen::VectorXd& f,
                 PatchPoints& points) {
  points.points.clear();
  points.X_WO = state.X_WO;
  const Isometry3d X_OW = state.X_WO.inverse();
  const std::size_t fingers = points.begin.size() - 1;
  for (std::size_t k = 0; k < fingers; ++k) {
    points.begin[k] = points.points.size();
    for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
      if (f[3 * i] <= 0.0) continue;
      const Vector3d zero = Vector3d::Zero();
      const Vector3d u_O = kinematics.u_O.size() > 0 ? Vector3d(kinematics.u_O.row(i)) : zero;
      const Vector3d finger_W = kinematics.c_W[i] - kinematics.gap_m[i] * kinematics.E_W[i].col(0);
      points.points.push_back({.contact = i,
                               .u_F = displacement(state, frame.contacts[i]),
                               .u_O = u_O,
                               .u_end_F = zero,
                               .u_end_O = zero,
                               .x_O = X_OW * finger_W - u_O,
                               .r_W = zero,
                               .f_W = kinematics.E_W[i] * f.segment<3>(3 * i),
                               .normal_N = f[3 * i],
                               .friction_N = f.segment<2>(3 * i + 1).norm(),
                               .d_W = zero});
    }
  }
  points.begin[fingers] = points.points.size();
}

void find_displacements(const Model& model, const Frame& frame, const ContactKinematics& kinematics,
                        const HandPose& pose, const State& state, PatchPoints& points) {
  object_displacements(model, frame, state, points.u_end_O);
  for (int k = 0; k < model.fingers(); ++k) {
    const Isometry3d X_OF = state.X_WO.inverse() * pose.distal(model.scene.hand, k);
    for (std::size_t j = points.begin[k]; j < points.begin[k + 1]; ++j) {
      PatchPoint& point = points.points[j];
      const FrameContact& contact = frame.contacts[point.contact];
      const Eigen::Matrix3d& E_W = kinematics.E_W[point.contact];
      point.u_end_F = displacement(state, contact);
      if (model.soft_object()) point.u_end_O = points.u_end_O.row(point.contact);
      const Vector3d x_O = X_OF * (contact.p_F - point.u_end_F) - point.u_end_O;
      point.d_W = points.X_WO.linear() * (x_O - point.x_O);
      if (contact.fades()) {
        // The bodies slip along the surface, the pulp is sheared across its own normal.
        const Vector3d by_pulp_F = point.u_end_F - point.u_F;
        const Vector3d by_bodies_W = point.d_W + pose.distal(model.scene.hand, k).linear() * by_pulp_F;
        point.d_W.setZero();
        for (const int t : {1, 2}) {
          const double sheared_m = kinematics.E_F[point.contact].col(t).dot(by_pulp_F);
          point.d_W += (E_W.col(t).dot(by_bodies_W) - sheared_m) * E_W.col(t);
        }
      } else {
        point.d_W -= E_W.col(0).dot(point.d_W) * E_W.col(0);
      }
      point.r_W = kinematics.c_W[point.contact] - state.load[k].centre_m;
    }
  }
}

PatchReport patch_report(std::span<const PatchPoint> patch, const FingerLoad& load, double mu, double step_s) {
  PatchReport report;
  if (patch.empty()) return report;
  Vector3d slip = Vector3d::Zero();
  for (const PatchPoint& point : patch) slip += point.normal_N * point.d_W;
  slip /= load.normal_N;
  report.slip_m = slip.norm();

  double turn = 0.0, inertia = 0.0, moment_Nm = 0.0, lever_Nm = 0.0;  // lever: sum of f_n |r|
  for (const PatchPoint& point : patch) {
    const Vector3d across = load.normal.cross(point.r_W);
    moment_Nm += across.dot(point.f_W);
    lever_Nm += point.normal_N * across.norm();
    turn += point.normal_N * across.dot(point.d_W - slip);
    inertia += point.normal_N * across.squaredNorm();

    const double speed_m_per_s = point.d_W.norm() / step_s;
    if (point.friction_N < (1.0 - kOnCone) * mu * point.normal_N) {
      report.creep_m_per_s = std::max(report.creep_m_per_s, speed_m_per_s);
    } else if (speed_m_per_s > kMoves_m_per_s) {
      report.sliding_share += point.normal_N / load.normal_N;
    }
  }

  constexpr double kPoint_m = 1e-9;  // A smaller patch is a point, which neither turns nor carries torsion.
  if (inertia > kPoint_m * kPoint_m * load.normal_N) report.spin_rad = std::abs(turn) / inertia;
  if (mu > 0.0 && lever_Nm > kPoint_m * load.normal_N) {
    report.moment_Nm = moment_Nm;
    report.moment_limit_Nm = mu * lever_Nm;
  }
  const double normal_N = load.force_N.dot(load.normal);
  if (!(normal_N > 0.0 && mu > 0.0)) return report;
  const double friction = (load.force_N - normal_N * load.normal).norm() / (mu * normal_N);
  const double torsion = report.moment_limit_Nm > 0.0 ? report.moment_Nm / report.moment_limit_Nm : 0.0;
  report.margin = 1.0 - std::hypot(friction, torsion);
  return report;
}

}  // namespace thenar
