// SPDX-License-Identifier: Apache-2.0
#include "engine/loops/film_tap.h"

#include <algorithm>
#include <cmath>

#include "engine/grasp/frame.h"

namespace thenar {

namespace {

constexpr double kContactRoom_s = 2.0, kPictureRoom_s = 1.0;
constexpr double kMostPictures = 1000.0;

std::size_t room_for(double room_s, double period_s) {
  return static_cast<std::size_t>(std::ceil(room_s / period_s)) + 16;
}

void copy(const Eigen::Vector3d& v, float (&to)[3]) noexcept {
  for (int i = 0; i < 3; ++i) to[i] = static_cast<float>(v[i]);
}

/// Returns one whose pages have all been touched.
Picture touched_picture(const Model& model) {
  Picture picture(model);
  picture.contacts.resize(static_cast<std::size_t>(model.max_contacts));
  picture.contacts.clear();
  picture.touches.resize(picture.touches.capacity());
  picture.touches.clear();
  return picture;
}

}  // namespace

void take_contacts(const State& state, const ContactMemory& memory, const ContactScratch& work,
                   TickContacts& to) noexcept {
  to.tick = state.tick;
  to.sequence = memory.sequence;
  to.count = std::min(state.forces.size(), to.contacts.size());
  for (std::size_t i = 0; i < to.count; ++i) {
    // The state's forces are those of the tick's contacts, in their order.
    const ContactForce& force = state.forces[i];
    const Eigen::Matrix3d& E_W = work.kinematics.E_W[i];
    TickContact& contact = to.contacts[i];
    contact.finger = static_cast<std::uint16_t>(force.finger);
    contact.control_point = static_cast<std::uint16_t>(force.control_point);
    // A contact at an edge is tilted against its sliding direction: the recorded axes are orthogonal.
    const bool is_oblique = std::abs(E_W.col(0).dot(E_W.col(1))) + std::abs(E_W.col(0).dot(E_W.col(2))) > 1e-9;
    const Eigen::Matrix3d E = is_oblique ? axes_of(E_W.col(0), E_W.col(1)) : E_W;
    copy(is_oblique ? Eigen::Vector3d(E.transpose() * (E_W * force.f_C)) : force.f_C, contact.force_N);
    for (int axis = 0; axis < 2; ++axis) {
      contact.slip_m[axis] = static_cast<float>(work.delta[3 * static_cast<Eigen::Index>(i) + 1 + axis]);
    }
    copy(work.kinematics.c_W[i], contact.point_m);
    copy(E_W.col(0), contact.normal);
    copy(E.col(1), contact.tangent);
  }
}

FilmTap::FilmTap(const Model& model, std::int64_t every, bool with_contacts)
    : pictures(std::min(room_for(kPictureRoom_s, static_cast<double>(every) * model.scene.step_s),
                        static_cast<std::size_t>(kMostPictures)),
               [&] { return touched_picture(model); }),
      contacts(with_contacts ? room_for(kContactRoom_s, model.scene.step_s) : 0, [&] { return TickContacts(model); }),
      picture_ticks_(every),
      with_contacts_(with_contacts) {}

void FilmTap::keep(const State& state, const ContactMemory& memory, const ContactScratch& work,
                   const std::optional<ShownPull>& pull) noexcept {
  if (with_contacts_) {
    if (TickContacts* const to = contacts.draft(); to != nullptr) {
      take_contacts(state, memory, work, *to);
      contacts.publish();
    } else {
      lost_contacts_.fetch_add(1, std::memory_order_relaxed);
    }
  }
  if (state.tick % picture_ticks_ != 0) return;
  if (Picture* const to = pictures.draft(); to != nullptr) {
    take_picture(state, memory, work, *to);
    to->pull = pull;
    pictures.publish();
  } else {
    lost_pictures_.fetch_add(1, std::memory_order_relaxed);
  }
}

const Picture* FilmTap::picture_of(std::int64_t tick) {
  const Picture* oldest = pictures.front();
  for (; oldest != nullptr && oldest->snapshot.tick < tick; oldest = pictures.front()) pictures.pop();
  return oldest != nullptr && oldest->snapshot.tick == tick ? oldest : nullptr;
}

}  // namespace thenar
