#include "engine/grasp/object_compliance.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace thenar {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// What the laws need of the material.
struct HalfSpace {
  explicit HalfSpace(const PulpMaterial& of)
      : material(of), tangential(std::sqrt((2.0 - of.poisson) / (2.0 * (1.0 - of.poisson)))) {}

  [[nodiscard]] double kernel(const Vector3d& x_i, const Vector3d& x_j, double area_i_m2, double area_j_m2) const {
    return half_space_kernel(material, (x_i - x_j).squaredNorm(), area_i_m2, area_j_m2);
  }
  [[nodiscard]] Matrix3d tensor(const Vector3d& normal) const {
    return tangential * Matrix3d::Identity() + (1.0 - tangential) * normal * normal.transpose();
  }

  const PulpMaterial& material;
  double tangential;  ///< sqrt(c_t).
};

double area_m2(const Model& model, const FrameContact& contact) {
  return model.pulps[contact.finger].area_m2[contact.control_point];
}

/// u at a point of the surface with this normal that stands for so much area.
Vector3d displacement_at(const HalfSpace& half_space, const State& state, const Vector3d& x_O, const Vector3d& n_O,
                         double area) {
  Vector3d sum = Vector3d::Zero();
  for (const ObjectLoad& load : state.object_loads) {
    sum += half_space.kernel(x_O, load.x_O, area, load.area_m2) * load.w_O;
  }
  return half_space.tensor(n_O) * sum;
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
  const HalfSpace half_space(*model.scene.object.compliance);
  for (Index j = 0; j < frame.size(); ++j) {
    const FrameContact& cj = frame.contacts[j];
    for (Index i = 0; i <= j; ++i) {
      const FrameContact& ci = frame.contacts[i];
      frame.object_kernel(i, j) = frame.object_kernel(j, i) =
          half_space.kernel(ci.s_O, cj.s_O, area_m2(model, ci), area_m2(model, cj));
    }
  }
}

Matrix3d object_tensor(const Model& model, const FrameContact& contact) {
  return HalfSpace(*model.scene.object.compliance).tensor(contact.n_O);
}

void add_object_compliance(const Model& model, const Frame& frame, const GroupedDelassus::Axes& tensors,
                           Eigen::Ref<Eigen::MatrixXd> W) {
  if (!model.soft_object()) return;
  const double rho = retained_share(*model.scene.object.compliance, model.scene.step_s);
  for (Index j = 0; j < frame.size(); ++j) {
    const Matrix3d B_j = (1.0 - rho) * tensors.middleRows<3>(3 * j).transpose();
    for (Index i = 0; i < frame.size(); ++i) {
      W.block<3, 3>(3 * i, 3 * j) += frame.object_kernel(i, j) * (tensors.middleRows<3>(3 * i) * B_j);
    }
  }
}

Vector3d object_displacement(const Model& model, const State& state, const FrameContact& contact) {
  if (!model.soft_object()) return Vector3d::Zero();
  const HalfSpace half_space(*model.scene.object.compliance);
  return displacement_at(half_space, state, contact.s_O, contact.n_O, area_m2(model, contact));
}

void carry_loads(const Model& model, const Frame& frame, State& state) {
  if (!model.soft_object()) return;
  auto load = state.object_loads.begin();
  for (const FrameContact& contact : frame.contacts) {
    while (load != state.object_loads.end() && is_before(*load, contact)) ++load;
    if (load == state.object_loads.end() || is_before(contact, *load)) continue;
    load->x_O = contact.s_O;
    load->area_m2 = area_m2(model, contact);
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
    load.area_m2 = area_m2(model, contact);
    load.w_O += (1.0 - rho) * (tensors.middleRows<3>(3 * i).transpose() * f.segment<3>(3 * i));
  }
}

}  // namespace thenar
