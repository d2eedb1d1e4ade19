// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "engine/grasp/model.h"
#include "engine/results/tick_fields.h"

namespace thenar {

/// What is said of a contact, described once: a row of numbers for each contact behind the fields of a state message,
/// and the arrays of contacts in Python.
struct ContactField {
  std::string_view name = {}, unit = {};  ///< Unit: empty for a plain number.
  bool is_whole = false;                  ///< One std::int64_t, else doubles.
  std::size_t count = 1;
  std::size_t offset = 0;  ///< In a ShownContact.
  std::string_view sentence = {};
  const Scenes* scenes = nullptr;  ///< Null: all.

  [[nodiscard]] bool is_in(const Model& model) const { return scenes == nullptr || scenes->have(model); }
};

/// All of them, in the order of a row.
[[nodiscard]] std::span<const ContactField> contact_fields();

/// Number i of a contact's field.
[[nodiscard]] double number_of(const ContactField& field, const ShownContact& contact, std::size_t i);

}  // namespace thenar
