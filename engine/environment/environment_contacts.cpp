// SPDX-License-Identifier: Apache-2.0
#include "engine/environment/environment_contacts.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace thenar {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Returns the columns n, t1, t2; t1 along the axis that n is farthest from.
Matrix3d axes_along(const Vector3d& n) {
  Eigen::Index least = 0;
  n.cwiseAbs().minCoeff(&least);
  Matrix3d E;
  E.col(0) = n;
  E.col(1) = n.cross(Vector3d::Unit(least)).normalized();
  E.col(2) = n.cross(Vector3d(E.col(1)));
  return E;
}

double squared_m2(const SolidContact& contact, const EnvironmentForce& force) {
  return (contact.p_m - force.p_E).squaredNorm();
}

/// Returns the force of the last tick at contact i; null if there was none. Where contacts or forces share a place,
/// both must be nearest to each other.
const EnvironmentForce* last_force(const std::vector<EnvironmentForce>& forces,
                                   const std::vector<EnvironmentContact>& found, std::size_t i) {
  const SolidContact& at = found[i].at;
  const auto before = [](const EnvironmentForce& force, const auto& id) { return id_of(force) < id; };
  const auto id = std::tie(found[i].body, at.place);
  const EnvironmentForce* nearest = nullptr;
  double least_m2 = std::numeric_limits<double>::infinity();
  for (auto force = std::lower_bound(forces.begin(), forces.end(), id, before);
       force != forces.end() && id_of(*force) == id; ++force) {
    const double m2 = squared_m2(at, *force);
    if (m2 > at.same_m * at.same_m || !(m2 < least_m2)) continue;
    least_m2 = m2;
    nearest = &*force;
  }
  if (nearest == nullptr) return nullptr;
  const auto shares = [&](std::size_t j) { return found[j].body == found[i].body && found[j].at.place == at.place; };
  for (std::size_t j = i; j > 0 && shares(j - 1); --j) {
    if (squared_m2(found[j - 1].at, *nearest) <= least_m2) return nullptr;
  }
  for (std::size_t j = i + 1; j < found.size() && shares(j); ++j) {
    if (squared_m2(found[j].at, *nearest) < least_m2) return nullptr;
  }
  return nearest;
}

/// Returns its tangential part, axes of the body.
Vector3d friction_of(const EnvironmentForce* force) {
  return force != nullptr ? Vector3d(force->f_E - force->n_E * force->n_E.dot(force->f_E)) : Vector3d::Zero();
}

/// Returns the columns n, t1, t2, world axes.
auto axes_W(const EnvironmentContacts& contacts, std::size_t i) {
  return contacts.contacts[i].J.leftCols<3>().transpose();
}

Vector3d place_W(const EnvironmentContacts& contacts, std::size_t i) {
  return contacts.pairs[contacts.found[i].body].X_WE * contacts.found[i].at.p_m;
}

bool sticks(const EnvironmentContacts& contacts, const std::vector<Vector3d>& f, std::size_t i) {
  constexpr double kSticks = 0.999;
  return f[i].tail<2>().norm() < kSticks * contacts.contacts[i].mu * f[i][0];
}

/// Tests whether contacts i and j stick, with the line through them in both cones.
bool hold_between(const EnvironmentContacts& contacts, const std::vector<Vector3d>& f, std::size_t i, std::size_t j) {
  if (!sticks(contacts, f, i) || !sticks(contacts, f, j)) return false;
  const Vector3d across_m = place_W(contacts, j) - place_W(contacts, i);
  const auto in_cone = [&](std::size_t k, double sign) {
    const double along = sign * across_m.dot(axes_W(contacts, k).col(0)), mu = contacts.contacts[k].mu;
    return along > 0.0 && across_m.squaredNorm() <= (1.0 + mu * mu) * along * along;
  };
  return in_cone(i, 1.0) && in_cone(j, -1.0);
}

/// Returns false where normals of loaded contacts are so similar that no line is in the cones of two of them: within a
/// cone of 90 degrees less the angle of friction.
bool may_be_wedged(const EnvironmentContacts& contacts, const std::vector<Vector3d>& f) {
  Vector3d mean = Vector3d::Zero();
  for (std::size_t i = 0; i < contacts.contacts.size(); ++i) {
    if (f[i][0] > 0.0) mean += axes_W(contacts, i).col(0);
  }
  for (std::size_t i = 0; i < contacts.contacts.size(); ++i) {
    if (!(f[i][0] > 0.0)) continue;
    const double mu = contacts.contacts[i].mu, along = mean.dot(axes_W(contacts, i).col(0));
    if (!(along > 0.0) || along * along * (1.0 + mu * mu) <= mu * mu * mean.squaredNorm()) return true;
  }
  return false;
}

bool is_wedged(const EnvironmentContacts& contacts, const std::vector<Vector3d>& f) {
  if (!may_be_wedged(contacts, f)) return false;
  for (std::size_t i = 0; i < contacts.contacts.size(); ++i) {
    for (std::size_t j = 0; j < i && f[i][0] > 0.0; ++j) {
      if (f[j][0] > 0.0 && hold_between(contacts, f, i, j)) return true;
    }
  }
  return false;
}

}  // namespace

Isometry3d moved(const Isometry3d& X, const GroundProblem::Motion& x) {
  Isometry3d X_moved = X;
  X_moved.translation() += x.head<3>();
  const Vector3d turn = x.tail<3>();
  const double angle = turn.norm();
  if (angle > 0.0) X_moved.linear() = Eigen::AngleAxisd(angle, turn / angle) * X.linear();
  return X_moved;
}

EnvironmentContacts::EnvironmentContacts(const Environment& environment, const TouchingSolid& object)
    : reach_m(thenar::reach_m(object)) {
  std::size_t most_of_pair = 0;
  for (const EnvironmentBody& body : environment.bodies) {
    pairs.push_back({SolidPair(object, body.shape)});
    const std::size_t most = most_contacts(object, body.shape);
    most_of_pair = std::max(most_of_pair, most);
    most_ += most;
  }
  found.reserve(most_);
  contacts.reserve(most_);
  of_pair.reserve(most_of_pair);
  then.reserve(most_);
}

void find_environment_contacts(const Environment& environment, const Isometry3d& X_WO, const Instant& begin,
                               const Instant& end, double band_m, const std::vector<EnvironmentForce>& forces,
                               EnvironmentContacts& out, const std::optional<GroundProblem::Motion>& after) {
  const GroundProblem::Motion x = after.value_or(GroundProblem::Motion::Zero());
  const Isometry3d X_look = moved(X_WO, x);
  out.looked_at = x;
  out.after_motion = after.has_value();
  out.found.clear();
  out.contacts.clear();
  const auto held_J = [&](const EnvironmentForce& force) {
    return 0.5 * environment.compliance_m_per_N * force.f_E.squaredNorm();
  };
  out.dropped_J = 0.0;
  for (const EnvironmentForce& force : forces) out.dropped_J += held_J(force);
  std::size_t kept = 0;
  for (std::size_t k = 0; k < out.pairs.size(); ++k) {
    EnvironmentPair& pair = out.pairs[k];
    const EnvironmentBody& body = environment.bodies[k];
    const Isometry3d X_begin = pose(body, begin), X_end = pose(body, end);
    pair.moved_m = X_end.translation() - X_begin.translation();
    const bool from_begin = !after && pair.is_fast();
    pair.X_WE = from_begin ? X_begin : X_end;
    const Vector3d ahead_m = from_begin ? pair.moved_m : Vector3d(Vector3d::Zero());
    const Vector3d ahead_E = pair.X_WE.linear().transpose() * ahead_m;
    out.of_pair.clear();
    find_contacts(pair.solids, pair.X_WE.inverse() * X_look, band_m + ahead_m.norm(), out.of_pair);
    const std::size_t first = out.found.size();
    for (const SolidContact& at : out.of_pair) {
      if (at.gap_m - at.n.dot(ahead_E) < band_m) out.found.push_back({static_cast<int>(k), at});
    }
    for (std::size_t i = first; i < out.found.size(); ++i) {
      const SolidContact& at = out.found[i].at;
      // The axes are fixed to the body as far as its surface is: forces are carried in them.
      const Matrix3d E = pair.X_WE.linear() * axes_along(at.n);
      const Vector3d r = pair.X_WE * at.p_m - X_look.translation();
      const EnvironmentForce* const last = last_force(forces, out.found, i);
      if (last != nullptr) {
        ++kept;
        out.dropped_J -= held_J(*last);
      } else if (at.gap_m < 0.0) {  // It continues under another identity.
        out.dropped_J -= 0.5 * at.gap_m * at.gap_m / environment.compliance_m_per_N;
      }
      const Vector3d f = E.transpose() * (pair.X_WE.linear() * friction_of(last));
      const Vector3d back_m = environment.compliance_m_per_N * f, along_m = E.transpose() * pair.moved_m;
      GroundContact& contact = out.contacts.emplace_back();
      for (int axis = 0; axis < 3; ++axis) {
        contact.J.row(axis).head<3>() = E.col(axis);
        contact.J.row(axis).tail<3>() = r.cross(Vector3d(E.col(axis)));
      }
      contact.delta_free = {at.gap_m - contact.J.row(0).dot(x) - E.col(0).dot(ahead_m), -along_m[1] - back_m[1],
                            -along_m[2] - back_m[2]};
      contact.mu = body.friction;
      out.found[i].sheared_m = {0.0, back_m[1], back_m[2]};
    }
  }
  if (kept == forces.size()) out.dropped_J = 0.0;
  out.dropped_J = std::max(0.0, out.dropped_J);
}

double may_miss_m(const EnvironmentContacts& contacts, const GroundProblem::Motion& x) {
  const GroundProblem::Motion on = x - contacts.looked_at;
  const double way_m = on.head<3>().norm(), turn = on.tail<3>().norm();
  double most_m = 0.0;
  for (const EnvironmentContact& contact : contacts.found) {
    if (!contacts.after_motion && contacts.pairs[contact.body].is_fast())
      return std::numeric_limits<double>::infinity();
    if (!contact.at.roams) continue;
    // The feature's displacement shifts its point; and as the object rotates, the feature's path bends.
    const double lever_m = contacts.reach_m + std::max(0.0, contact.at.gap_m) + contact.at.round_m;
    const double goes_m = way_m + turn * lever_m;
    const double bends_m = 0.5 * contact.at.bend_per_m * goes_m * goes_m;
    most_m = std::max(most_m, bends_m + turn * (way_m + 0.5 * turn * lever_m));
  }
  return most_m;
}

double missed_m(const Environment& environment, const EnvironmentContacts& contacts, const GroundProblem::Motion& x,
                const std::vector<EnvironmentForce>& then) {
  const auto is_fast = [&](int body) { return contacts.pairs[body].is_fast(); };
  double most_m = 0.0;
  for (std::size_t i = 0; i < contacts.found.size(); ++i) {
    if (!contacts.found[i].at.roams && !is_fast(contacts.found[i].body)) continue;
    const GroundContact& contact = contacts.contacts[i];
    const double gap_m = contact.delta_free[0] + contact.J.row(0).dot(x);
    const EnvironmentForce* const force = last_force(then, contacts.found, i);
    const double expected_m =
        force != nullptr ? -environment.compliance_m_per_N * force->n_E.dot(force->f_E) : std::max(0.0, gap_m);
    most_m = std::max(most_m, std::abs(gap_m - expected_m));
  }
  for (const EnvironmentForce& force : then) {
    if (!is_fast(force.body)) continue;
    bool is_there = false;
    for (std::size_t i = 0; i < contacts.found.size() && !is_there; ++i) {
      is_there = id_of(force) == std::tie(contacts.found[i].body, contacts.found[i].at.place) &&
                 last_force(then, contacts.found, i) == &force;
    }
    if (!is_there) most_m = std::max(most_m, environment.compliance_m_per_N * force.n_E.dot(force.f_E));
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
    report.wrench += contact.J.transpose() * f[i];
    report.normal_N += f[i][0];
    const int body = contacts.found[i].body;
    if (body < kToldBodies) report.body_N.col(body) += axes_W(contacts, i) * f[i];
  }
  report.wedged = is_wedged(contacts, f);
  return report;
}

EnvironmentWork environment_work(const Environment& environment, const EnvironmentContacts& contacts,
                                 const std::vector<Vector3d>& f, const GroundProblem::Motion& x) {
  EnvironmentWork work{.dropped_J = contacts.dropped_J};
  for (std::size_t i = 0; i < contacts.contacts.size(); ++i) {
    if (!(f[i][0] > 0.0)) continue;
    const GroundContact& contact = contacts.contacts[i];
    const Vector3d moved_m = axes_W(contacts, i).transpose() * contacts.pairs[contacts.found[i].body].moved_m;
    const Vector3d way_m = contact.J.lazyProduct(x) - moved_m;
    const double gap_m = contact.delta_free[0] + moved_m[0];  // As the tick begins.
    const Vector3d before_m = contacts.found[i].sheared_m + Vector3d(std::max(0.0, -gap_m), 0.0, 0.0);
    const Vector3d after_m = environment.compliance_m_per_N * f[i];
    const double deformation_J = f[i].dot(after_m - before_m), rest_J = f[i].dot(way_m) + deformation_J;
    work.moving_J += f[i].dot(moved_m);
    work.deformation_J += deformation_J;
    work.stored_J += 0.5 * f[i].dot(after_m);
    (rest_J > 0.0 ? work.injected_J : work.dissipated_J) += std::abs(rest_J);
  }
  return work;
}

void keep_forces(const EnvironmentContacts& contacts, const std::vector<Vector3d>& f,
                 std::vector<EnvironmentForce>& forces) {
  forces.clear();
  for (std::size_t i = 0; i < contacts.found.size(); ++i) {
    if (!(f[i][0] > 0.0)) continue;
    const EnvironmentContact& contact = contacts.found[i];
    const Matrix3d R_EW = contacts.pairs[contact.body].X_WE.linear().transpose();
    const auto E_W = axes_W(contacts, i);
    forces.push_back({contact.body, contact.at.place, contact.at.p_m, R_EW * E_W.col(0), R_EW * (E_W * f[i])});
  }
}

}  // namespace thenar
