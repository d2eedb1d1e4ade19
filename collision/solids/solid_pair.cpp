// SPDX-License-Identifier: Apache-2.0
#include "collision/solids/solid_pair.h"

#include "collision/solids/sampled_solid.h"

namespace thenar {

SolidPair::SolidPair(const TouchingSolid& one, const Solid& other) : a(one), b(other), of_b(features(b)) {
  if (const Solid* exact = std::get_if<Solid>(&a)) of_a = features(*exact);
}

double reach_m(const TouchingSolid& solid) {
  const Solid* const exact = std::get_if<Solid>(&solid);
  return exact != nullptr ? reach_m(*exact) : std::get<std::shared_ptr<const SampledSolid>>(solid)->reach_m();
}

}  // namespace thenar
