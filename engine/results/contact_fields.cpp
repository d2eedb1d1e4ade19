// SPDX-License-Identifier: Apache-2.0
#include "engine/results/contact_fields.h"

#include <array>
#include <cstring>
#include <type_traits>

namespace thenar {

namespace {

static_assert(sizeof(Eigen::Index) == sizeof(std::int64_t) && std::is_standard_layout_v<ShownContact>);

constexpr Scenes kDeform{[](const Model& model) { return model.deformable(); }, "of deformable fingertips"};

constexpr auto kContactFields = std::to_array<ContactField>({
    {.name = "finger",
     .is_whole = true,
     .offset = offsetof(ShownContact, finger),
     .sentence = "Number of the finger, from 0 on."},
    {.name = "control_point",
     .is_whole = true,
     .offset = offsetof(ShownContact, control_point),
     .sentence = "Number of its control point, from 0 on."},
    {.name = "point_m",
     .unit = "m",
     .count = 3,
     .offset = offsetof(ShownContact, point_m),
     .sentence = "Where finger and object meet, world axes."},
    {.name = "normal",
     .count = 3,
     .offset = offsetof(ShownContact, normal),
     .sentence = "Normal into the object, world axes."},
    {.name = "force_N",
     .unit = "N",
     .count = 3,
     .offset = offsetof(ShownContact, force_N),
     .sentence = "Force on the object, world axes."},
    {.name = "normal_N",
     .unit = "N",
     .offset = offsetof(ShownContact, normal_N),
     .sentence = "The normal force that bounds its friction: at an edge, where a contact leans, not the part of "
                 "`force_N` along the normal.",
     .scenes = &kDeform},
    {.name = "friction_N",
     .unit = "N",
     .offset = offsetof(ShownContact, friction_N),
     .sentence = "The friction that is bounded: at an edge, not the part of `force_N` across the normal.",
     .scenes = &kDeform},
    {.name = "share",
     .offset = offsetof(ShownContact, share),
     .sentence = "Part of the control point's cell that it stands for: less than 1 at edges and on small objects.",
     .scenes = &kDeform},
    {.name = "slip_m_per_s",
     .unit = "m/s",
     .offset = offsetof(ShownContact, slip_m_per_s),
     .sentence = "How fast the finger's point goes against the object's, along the surface.",
     .scenes = &kFeelingScenes},
});

}  // namespace

std::span<const ContactField> contact_fields() { return kContactFields; }

double number_of(const ContactField& field, const ShownContact& contact, std::size_t i) {
  const char* const at = reinterpret_cast<const char*>(&contact) + field.offset;
  if (field.is_whole) {
    std::int64_t whole = 0;
    std::memcpy(&whole, at, sizeof whole);
    return static_cast<double>(whole);
  }
  double number = 0.0;
  std::memcpy(&number, at + i * sizeof number, sizeof number);
  return number;
}

}  // namespace thenar
