// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/handover.h"

#include <algorithm>
#include <cassert>

#include "engine/grasp/contact_gaps.h"
#include "engine/grasp/contact_kinematics.h"
#include "engine/grasp/object_compliance.h"

namespace thenar {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

/// Shares the force of a contact that is no more among the loaded contacts of its finger, by the pulp's kernel.
void share_force(const Model& model, const Frame& frame, const ContactForce& lost, Eigen::VectorXd& f) {
  const auto kernel = model.pulps[lost.finger].kernel.col(lost.control_point);
  const Index begin = frame.begin[lost.finger], end = frame.begin[lost.finger + 1];
  double sum = 0.0;
  for (Index i = begin; i < end; ++i) {
    if (f[3 * i] > 0.0) sum += kernel[frame.contacts[i].control_point];
  }
  // A gaussian may be nothing so far away.
  if (!(sum > 0.0)) return;
  for (Index i = begin; i < end; ++i) {
    if (f[3 * i] > 0.0) f.segment<3>(3 * i) += kernel[frame.contacts[i].control_point] / sum * lost.f_C;
  }
}

/// Calls back with each force whose contact the frame has not.
template <typename See>
void for_each_dropped(const Frame& frame, const std::vector<ContactForce>& forces, const See& see) {
  auto contact = frame.contacts.begin();
  for (const ContactForce& force : forces) {
    while (contact != frame.contacts.end() && id_of(*contact) < id_of(force)) ++contact;
    if (contact == frame.contacts.end() || id_of(*contact) != id_of(force)) see(force);
  }
}

/// Calls back with each of the frame's contacts, by index, and the index of its force; -1 if it has none.
template <typename See>
void for_each_contact(const Frame& frame, const std::vector<ContactForce>& forces, const See& see) {
  auto old = forces.begin();
  for (Index i = 0; i < frame.size(); ++i) {
    while (old != forces.end() && id_of(*old) < id_of(frame.contacts[i])) ++old;
    const bool known = old != forces.end() && id_of(*old) == id_of(frame.contacts[i]);
    see(i, known ? old - forces.begin() : -1);
  }
}

}  // namespace

void carry_forces(const Model& model, const Frame& frame, const std::vector<ContactForce>& forces, Eigen::VectorXd& f) {
  for_each_contact(frame, forces,
                   [&](Index i, Index old) { f.segment<3>(3 * i) = old >= 0 ? forces[old].f_C : Vector3d::Zero(); });
  if (!model.deformable()) return;
  for_each_dropped(frame, forces, [&](const ContactForce& force) {
    if (force.f_C[0] > 0.0) share_force(model, frame, force, f);
  });
}

double hand_over(const Model& model, const Frame& frame, State& state, ContactMemory& memory, ContactScratch& work) {
  double dropped_J = 0.0;
  for_each_dropped(frame, state.forces, [&](const ContactForce& force) { dropped_J += force.held_J; });
  carry_forces(model, frame, state.forces, memory.f);
  // A state of another model may have more forces than this one has contacts.
  const Index old_rows = std::min<Index>(3 * std::ssize(state.forces), memory.change_N.rows());
  work.old_change_N.topRows(old_rows) = memory.change_N.topRows(old_rows);
  for_each_contact(frame, state.forces, [&](Index i, Index old) {
    auto change = memory.change_N.middleRows<3>(3 * i);
    if (old >= 0 && 3 * old < old_rows) {
      change = work.old_change_N.middleRows<3>(3 * old);
    } else {
      change.setZero();
    }
  });
  if (memory.policy.offset_decay_s > 0.0) {
    // The old gaps, with the old loads on a soft object.
    for_each_gap(model, memory.contacts, work.kinematics.X_FO, state,
                 [&](Index i, double gap_m) { memory.offset_m[i] += gap_m; });
  }
  carry_loads(model, frame, state);
  find_gaps(model, frame, state, work.kinematics);
  if (memory.policy.offset_decay_s > 0.0) {
    const bool first = memory.sequence < 0;
    std::swap(memory.offset_m, work.old_offset_m);
    auto old = memory.contacts.begin();
    for (Index i = 0; i < frame.size(); ++i) {
      const FrameContact& contact = frame.contacts[i];
      while (old != memory.contacts.end() && id_of(*old) < id_of(contact)) ++old;
      const double gap_m = work.kinematics.points[i].gap.gap_m;
      double e = std::max(0.0, -gap_m);
      if (old != memory.contacts.end() && id_of(*old) == id_of(contact)) {
        e = work.old_offset_m[old - memory.contacts.begin()] - gap_m;
      }
      const double limit_m = kTrustPerRadius * model.scene.hand.fingertips[contact.finger].radius_m;
      memory.offset_m[i] = first ? 0.0 : std::clamp(e, -limit_m, limit_m);
    }
    assert(memory.contacts.capacity() >= frame.contacts.size());
    memory.contacts.assign(frame.contacts.begin(), frame.contacts.end());
  }
  memory.sequence = frame.sequence;
  return dropped_J;
}

}  // namespace thenar
