// SPDX-License-Identifier: Apache-2.0
#include "engine/control/task_order.h"

namespace thenar {

using Kind = Phase::Kind;

namespace {

/// State of the object in the fingers.
enum class Grip { kNone, kPress, kHold };

Grip grip_after(Kind kind) {
  if (kind == Kind::kApproach || kind == Kind::kRelease) return Grip::kNone;
  return kind == Kind::kClose || kind == Kind::kPlace ? Grip::kPress : Grip::kHold;
}

}  // namespace

std::string order_fault(const std::vector<Phase>& phases, std::size_t i) {
  const Kind kind = phases[i].kind;
  if (i == 0) return "";
  const Grip grip = grip_after(phases[i - 1].kind);
  switch (kind) {
    case Kind::kApproach:
    case Kind::kClose:
      return grip == Grip::kNone ? "" : "goes with open fingers: release the object first";
    case Kind::kLoad:
      return grip == Grip::kPress ? "" : "takes over what fingers press and do not hold: after close or place";
    case Kind::kRelease:
      return grip != Grip::kNone ? "" : "has nothing to let go of";
    case Kind::kLift:
    case Kind::kMove:
    case Kind::kInsert:
    case Kind::kPlace:
      return grip == Grip::kHold ? "" : "needs fingers that hold the object: load comes before";
  }
  return "";
}

}  // namespace thenar
