#include "engine/environment/environment_contacts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// A contact that has gone so far along a circle is another one.
constexpr double kSameArc_rad = std::numbers::pi / 6.0;

double arc_rad(double a, double b) { return std::abs(std::remainder(a - b, 2.0 * std::numbers::pi)); }

/// Columns n, t1, t2; t1 along the axis that n is farthest from.
Matrix3d axes_along(const Vector3d& n) {
  Eigen::Index least = 0;
  n.cwiseAbs().minCoeff(&least);
  Matrix3d E;
  E.col(0) = n;
  E.col(1) = n.cross(Vector3d::Unit(least)).normalized();
  E.col(2) = n.cross(Vector3d(E.col(1)));
  return E;
}

/// The force of the last tick at a contact; null where there was none.
const EnvironmentForce* last_force(const std::vector<EnvironmentForce>& forces, int body, const SolidContact& contact) {
  const auto before = [](const EnvironmentForce& force, const auto& id) { return id_of(force) < id; };
  const auto id = std::tie(body, contact.place);
  double least_rad = kSameArc_rad;
  const EnvironmentForce* nearest = nullptr;
  for (auto force = std::lower_bound(forces.begin(), forces.end(), id, before);
       force != forces.end() && id_of(*force) == id; ++force) {
    const double rad = arc_rad(force->angle_rad, contact.angle_rad);
    if (rad > least_rad) continue;
    least_rad = rad;
    nearest = &*force;
  }
  return nearest;
}

/// Its tangential part, axes of the body.
Vector3d last_friction(const std::vector<EnvironmentForce>& forces, int body, const SolidContact& contact) {
  const EnvironmentForce* const force = last_force(forces, body, contact);
  return force != nullptr ? Vector3d(force->f_E - force->n_E * force->n_E.dot(force->f_E)) : Vector3d::Zero();
}

/// Whether contacts i and j stick, the line through them in both cones.
bool hold_between(const EnvironmentContacts& contacts, const std::vector<Vector3d>& f, std::size_t i, std::size_t j) {
  const auto sticks = [&](std::size_t k) {
    constexpr double kSticks = 0.999;
    return f[k].tail<2>().norm() < kSticks * contacts.contacts[k].mu * f[k][0];
  };
  const Vector3d across_m = contacts.p_W[j] - contacts.p_W[i];
  const auto in_cone = [&](std::size_t k, double sign) {
    const double along = sign * across_m.dot(contacts.E_W[k].col(0)), mu = contacts.contacts[k].mu;
    return along > 0.0 && across_m.squaredNorm() <= (1.0 + mu * mu) * along * along;
  };
  return sticks(i) && sticks(j) && in_cone(i, 1.0) && in_cone(j, -1.0);
}

}  // namespace

EnvironmentContacts::EnvironmentContacts(const Environment& environment, const Solid& object) {
  std::size_t most = 0;
  for (const EnvironmentBody& body : environment.bodies) {
    pairs.emplace_back(object, body.shape);
    most += most_contacts(pairs.back());
  }
  end.resize(pairs.size());
  found.reserve(most);
  contacts.reserve(most);
  E_W.reserve(most);
  p_W.reserve(most);
  sheared_m.reserve(most);
  moved_m.reserve(most);
  then.reserve(most);
}

void find_environment_contacts(const Environment& environment, const Isometry3d& X_WO, const Instant& begin,
                               const Instant& end, double band_m, const std::vector<EnvironmentForce>& forces,
                               EnvironmentContacts& out, const GroundProblem::Motion& x) {
  Isometry3d X_look = X_WO;
  X_look.translation() += x.head<3>();
  const Vector3d turn = x.tail<3>();
  if (turn.norm() > 0.0) X_look.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * X_look.linear();
  out.found.clear();
  out.contacts.clear();
  out.E_W.clear();
  out.p_W.clear();
  out.sheared_m.clear();
  out.moved_m.clear();
  for (std::size_t k = 0; k < out.pairs.size(); ++k) {
    const EnvironmentBody& body = environment.bodies[k];
    const Isometry3d X_WE = pose(body, end);
    const Vector3d moved_m = X_WE.translation() - pose(body, begin).translation();
    const std::size_t first = out.found.size();
    find_contacts(out.pairs[k], X_WE.inverse() * X_look, band_m, out.found);
    out.end[k] = out.found.size();
    for (std::size_t i = first; i < out.found.size(); ++i) {
      const SolidContact& at = out.found[i];
      // The axes are fixed to the body as far as its surface is: forces are carried in them.
      const Matrix3d E = X_WE.linear() * axes_along(at.n);
      const Vector3d r = X_WE * at.p_m - X_look.translation();
      Matrix3d r_cross;
      r_cross << 0.0, -r[2], r[1], r[2], 0.0, -r[0], -r[1], r[0], 0.0;
      const Vector3d f = E.transpose() * (X_WE.linear() * last_friction(forces, static_cast<int>(k), at));
      const Vector3d back_m = environment.compliance_m_per_N * f, along_m = E.transpose() * moved_m;
      GroundContact contact;
      contact.J << E.transpose(), -E.transpose() * r_cross;
      contact.delta_free = {at.gap_m - contact.J.row(0).dot(x), -along_m[1] - back_m[1], -along_m[2] - back_m[2]};
      contact.mu = body.friction;
      out.contacts.push_back(contact);
      out.E_W.push_back(E);
      out.p_W.push_back(X_look.translation() + r);
      out.sheared_m.emplace_back(0.0, back_m[1], back_m[2]);
      out.moved_m.push_back(along_m);
    }
  }
}

double missed_m(const Environment& environment, const EnvironmentContacts& contacts, const GroundProblem::Motion& x,
                const std::vector<EnvironmentForce>& then) {
  double most_m = 0.0;
  std::size_t i = 0;
  for (std::size_t k = 0; k < contacts.pairs.size(); ++k) {
    for (; i < contacts.end[k]; ++i) {
      if (!contacts.found[i].roams) continue;
      const GroundContact& contact = contacts.contacts[i];
      const double gap_m = contact.delta_free[0] + contact.J.row(0).dot(x);
      const EnvironmentForce* const force = last_force(then, static_cast<int>(k), contacts.found[i]);
      const double expected_m =
          force != nullptr ? -environment.compliance_m_per_N * force->n_E.dot(force->f_E) : std::max(0.0, gap_m);
      most_m = std::max(most_m, std::abs(gap_m - expected_m));
    }
  }
  return most_m;
}

EnvironmentReport environment_report(const EnvironmentContacts& contacts, const std::vector<Vector3d>& f,
                                     const GroundProblem::Motion& x) {
  EnvironmentReport report;
  report.contacts = static_cast<int>(contacts.contacts.size());
  for (std::size_t i = 0; i < contacts.contacts.size(); ++i) {
    if (!(f[i][0] > 0.0)) continue;
    ++report.active;
    const GroundContact& contact = contacts.contacts[i];
    report.penetration_m = std::max(report.penetration_m, -(contact.delta_free[0] + contact.J.row(0).dot(x)));
    report.wrench += contacts.contacts[i].J.transpose() * f[i];
    report.normal_N += f[i][0];
    for (std::size_t j = 0; j < i && !report.wedged; ++j)
      report.wedged = f[j][0] > 0.0 && hold_between(contacts, f, i, j);
  }
  return report;
}

EnvironmentWork environment_work(const Environment& environment, const EnvironmentContacts& contacts,
                                 const std::vector<Vector3d>& f, const GroundProblem::Motion& x) {
  EnvironmentWork work;
  for (std::size_t i = 0; i < contacts.contacts.size(); ++i) {
    if (!(f[i][0] > 0.0)) continue;
    const GroundContact& contact = contacts.contacts[i];
    const Vector3d& moved_m = contacts.moved_m[i];
    const Vector3d way_m = contact.J.lazyProduct(x) - moved_m;
    const double gap_m = contact.delta_free[0] + moved_m[0];  // As the tick begins.
    const Vector3d before_m = contacts.sheared_m[i] + Vector3d(std::max(0.0, -gap_m), 0.0, 0.0);
    const Vector3d after_m = environment.compliance_m_per_N * f[i];
    const double deformation_J = f[i].dot(after_m - before_m), rest_J = f[i].dot(way_m) + deformation_J;
    work.moving_J += f[i].dot(moved_m);
    work.deformation_J += deformation_J;
    work.stored_J += 0.5 * f[i].dot(after_m);
    (rest_J > 0.0 ? work.injected_J : work.dissipated_J) += std::abs(rest_J);
  }
  return work;
}

void keep_forces(const EnvironmentContacts& contacts, const std::vector<Vector3d>& f, const Environment& environment,
                 const Instant& end, std::vector<EnvironmentForce>& forces) {
  forces.clear();
  std::size_t i = 0;
  for (std::size_t k = 0; k < contacts.pairs.size(); ++k) {
    const Matrix3d R_EW = pose(environment.bodies[k], end).linear().transpose();
    for (; i < contacts.end[k]; ++i) {
      if (!(f[i][0] > 0.0)) continue;
      forces.push_back({static_cast<int>(k), contacts.found[i].place, contacts.found[i].angle_rad,
                        R_EW * contacts.E_W[i].col(0), R_EW * (contacts.E_W[i] * f[i])});
    }
  }
}

}  // namespace thenar
