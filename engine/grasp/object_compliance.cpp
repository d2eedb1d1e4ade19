// SPDX-License-Identifier: Apache-2.0
#include "engine/grasp/object_compliance.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// A place on the surface that stands for so much area.
struct Place {
  const Vector3d& x_O;
  double area_m2;
};

Place place_of(const Model& model, const Frame& frame, Index i) {
  return {frame.contacts[i].s_O, area_of(model, frame.contacts[i])};
}

/// The kernel between a place and `count` others, so many at once: roots and divisions are what it costs. take(j, k) is
/// given each.
template <typename PlaceOf, typename Take>
void for_kernels(const PulpMaterial& material, const Place& place, Index count, PlaceOf place_of, Take take) {
  constexpr int kLanes = 16;
  Eigen::Array<double, kLanes, 1> squared_m2 = Eigen::Array<double, kLanes, 1>::Zero(), area_m2 = squared_m2;
  for (Index first = 0; first < count; first += kLanes) {
    const Index used = std::min<Index>(kLanes, count - first);
    for (Index lane = 0; lane < used; ++lane) {
      const Place other = place_of(first + lane);
      squared_m2[lane] = (place.x_O - other.x_O).squaredNorm();
      area_m2[lane] = other.area_m2;
    }
    const Eigen::Array<double, kLanes, 1> k = half_space_kernel(material, squared_m2, place.area_m2, area_m2);
    for (Index lane = 0; lane < used; ++lane) take(first + lane, k[lane]);
  }
}

template <typename A, typename B>
bool is_before(const A& a, const B& b) {
  return std::tie(a.finger, a.control_point) < std::tie(b.finger, b.control_point);
}

/// The load of a contact, new where there is none: in the place of the least if there is no room.
ObjectLoad& load_of(const FrameContact& contact, Index most, std::vector<ObjectLoad>& loads) {
  const auto place = [&] {
    return std::lower_bound(loads.begin(), loads.end(), contact, is_before<ObjectLoad, FrameContact>);
  };
  auto load = place();
  if (load != loads.end() && !is_before(contact, *load)) return *load;
  if (std::ssize(loads) >= most) {
    loads.erase(std::min_element(loads.begin(), loads.end(), [](const ObjectLoad& a, const ObjectLoad& b) {
      return a.w_O.squaredNorm() < b.w_O.squaredNorm();
    }));
    load = place();
  }
  return *loads.insert(load, {contact.finger, contact.control_point, contact.s_O, 0.0, Vector3d::Zero()});
}

}  // namespace

void fill_object_kernel(const Model& model, Frame& frame) {
  if (!model.soft_object()) return;
  for (Index j = 0; j < frame.size(); ++j) {
    for_kernels(
        *model.scene.object.compliance, place_of(model, frame, j), j + 1,
        [&](Index i) { return place_of(model, frame, i); },
        [&](Index i, double k) { frame.object_kernel(i, j) = frame.object_kernel(j, i) = k; });
  }
}

Matrix3d object_tensor(const Model& model, const FrameContact& contact) {
  const double nu = model.scene.object.compliance->poisson, tangential = std::sqrt((2.0 - nu) / (2.0 * (1.0 - nu)));
  return tangential * Matrix3d::Identity() + (1.0 - tangential) * contact.n_O * contact.n_O.transpose();
}

SharedCompliance object_compliance(const Model& model, const Frame& frame, const GroupedDelassus::Axes& tensors) {
  if (!model.soft_object()) return {};
  return {&frame.object_kernel, &tensors, 1.0 - retained_share(*model.scene.object.compliance, model.scene.step_s)};
}

Vector3d object_displacement(const Model& model, const State& state, const FrameContact& contact) {
  Vector3d sum = Vector3d::Zero();
  if (!model.soft_object()) return sum;
  const std::vector<ObjectLoad>& loads = state.object_loads;
  for_kernels(
      *model.scene.object.compliance, {contact.s_O, area_of(model, contact)}, std::ssize(loads),
      [&](Index j) {
        return Place{loads[j].x_O, loads[j].area_m2};
      },
      [&](Index j, double k) { sum += k * loads[j].w_O; });
  return object_tensor(model, contact) * sum;
}

void object_displacements(const Model& model, const Frame& frame, const State& state, Eigen::MatrixX3d& u_O) {
  if (!model.soft_object()) return;
  const Index n = frame.size();
  auto u = u_O.topRows(n);
  u.setZero();
  Index j = 0;
  for (const ObjectLoad& load : state.object_loads) {
    while (j < n && is_before(frame.contacts[j], load)) ++j;
    if (j < n && !is_before(load, frame.contacts[j])) {
      const auto k_j = frame.object_kernel.col(j).head(n);
      for (int axis = 0; axis < 3; ++axis) u.col(axis) += load.w_O[axis] * k_j;
      continue;
    }
    for_kernels(
        *model.scene.object.compliance, {load.x_O, load.area_m2}, n, [&](Index i) { return place_of(model, frame, i); },
        [&](Index i, double k) { u.row(i) += k * load.w_O.transpose(); });
  }
  for (Index i = 0; i < n; ++i) u.row(i) *= object_tensor(model, frame.contacts[i]);
}

void carry_loads(const Model& model, const Frame& frame, State& state) {
  if (!model.soft_object()) return;
  auto load = state.object_loads.begin();
  for (const FrameContact& contact : frame.contacts) {
    while (load != state.object_loads.end() && is_before(*load, contact)) ++load;
    if (load == state.object_loads.end() || is_before(contact, *load)) continue;
    load->x_O = contact.s_O;
    load->area_m2 = area_of(model, contact);
  }
}

void remember_loads(const Model& model, const Frame& frame, const GroupedDelassus::Axes& tensors,
                    const Eigen::VectorXd& f, State& state) {
  const PulpMaterial& material = *model.scene.object.compliance;
  const double rho = retained_share(material, model.scene.step_s);
  std::vector<ObjectLoad>& loads = state.object_loads;
  for (ObjectLoad& load : loads) load.w_O *= rho;
  std::erase_if(loads, [](const ObjectLoad& load) { return load.w_O.norm() < kForgotten_N; });
  for (Index i = 0; i < frame.size(); ++i) {
    if (f[3 * i] <= 0.0) continue;
    const FrameContact& contact = frame.contacts[i];
    ObjectLoad& load = load_of(contact, kLoadsPerContact * model.max_contacts, loads);
    load.x_O = contact.s_O;
    load.area_m2 = area_of(model, contact);
    load.w_O += (1.0 - rho) * (tensors.middleRows<3>(3 * i).transpose() * f.segment<3>(3 * i));
  }
}

}  // namespace thenar
