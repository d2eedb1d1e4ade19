// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/patches.h"

#include <algorithm>
#include <cmath>

#include "engine/grasp/object_compliance.h"

namespace thenar {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

/// A contact that is loaded with the force f_C, before it moves.
PatchPoint point_of(const ContactKinematics& kinematics, const Isometry3d& X_OW, Index i, const Vector3d& f_C) {
  const Vector3d zero = Vector3d::Zero();
  const Vector3d finger_W = kinematics.c_W[i] - kinematics.gap_m[i] * kinematics.E_W[i].col(0);
  return {.contact = i,
          .u_end_F = zero,
          .u_end_O = zero,
          .x_O = X_OW * finger_W - kinematics.points[i].u_O,
          .r_W = zero,
          .f_W = kinematics.E_W[i] * f_C,
          .normal_N = f_C[0],
          .friction_N = f_C.tail<2>().norm(),
          .d_W = zero};
}

/// Where a point of a contact has gone with its finger at X_WF, X_OF.
void follow(const FrameContact& contact, const ContactKinematics& kinematics, const Isometry3d& X_OF,
            const Isometry3d& X_WF, PatchPoint& point) {
  const Eigen::Matrix3d& E_W = kinematics.E_W[point.contact];
  const Vector3d x_O = X_OF * (contact.p_F - point.u_end_F) - point.u_end_O;
  point.d_W = kinematics.X_WO.linear() * (x_O - point.x_O);
  if (!contact.fades()) {
    point.d_W -= E_W.col(0).dot(point.d_W) * E_W.col(0);
    return;
  }
  // The bodies slip along the surface, the pulp is sheared across its own normal.
  const Vector3d by_pulp_F = point.u_end_F - kinematics.points[point.contact].u_F;
  const Vector3d by_bodies_W = point.d_W + X_WF.linear() * by_pulp_F;
  point.d_W.setZero();
  for (const int t : {1, 2}) {
    const double sheared_m = kinematics.E_F[point.contact].col(t).dot(by_pulp_F);
    point.d_W += (E_W.col(t).dot(by_bodies_W) - sheared_m) * E_W.col(t);
  }
}

}  // namespace

void find_displacements(const Model& model, const Frame& frame, const ContactKinematics& kinematics,
                        const HandPose& pose, const State& state, const Eigen::VectorXd& f, PatchPoints& points) {
  object_displacements(model, frame, state, points.u_end_O);
  const Isometry3d X_OW = kinematics.X_WO.inverse();
  points.points.clear();
  for (int k = 0; k < model.fingers(); ++k) {
    points.begin[k] = points.points.size();
    const Isometry3d& X_WF = pose.distal(model.scene.hand, k);
    const Isometry3d X_OF = state.X_WO.inverse() * X_WF;
    for (Index i = frame.begin[k]; i < frame.begin[k + 1]; ++i) {
      if (f[3 * i] <= 0.0) continue;
      PatchPoint& point = points.points.emplace_back(point_of(kinematics, X_OW, i, f.segment<3>(3 * i)));
      point.u_end_F = displacement(state, frame.contacts[i]);
      if (model.soft_object()) point.u_end_O = points.u_end_O.row(i);
      follow(frame.contacts[i], kinematics, X_OF, X_WF, point);
      point.r_W = kinematics.c_W[i] - state.load[k].centre_m;
    }
  }
  points.begin[model.fingers()] = points.points.size();
}

PatchReport patch_report(std::span<const PatchPoint> patch, const FingerLoad& load, double mu, double step_s) {
  PatchReport report;
  if (patch.empty()) return report;
  Vector3d& slip = report.slip_W;
  for (const PatchPoint& point : patch) {
    slip += point.normal_N * point.d_W;
    report.dent_O += point.normal_N * point.u_end_O;
  }
  slip /= load.normal_N;
  report.dent_O /= load.normal_N;
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
  if (inertia > kPoint_m * kPoint_m * load.normal_N) report.spin_rad = turn / inertia;
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
