// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <functional>

#include "engine/loops/threads.h"

namespace thenar {

/// The pairing of each contact tick of a threaded run with the control tick that made its frame. Their records arrive
/// separately: a contact tick waits here until that of its frame, or a later one, has arrived.
class Pairing {
 public:
  /// A function that receives each contact tick, in order, with the control tick of its frame; false ends this.
  using OnTick = std::function<bool(const ContactSample& tick, const ControlSample& control)>;
  /// A function that receives each control tick, in order, before the first contact tick on its frame or a later one,
  /// which is `tick`.
  using OnControl = std::function<void(const ContactSample& tick, const ControlSample& control)>;

  explicit Pairing(OnTick on_tick, OnControl on_control = {});

  /// Sets the control tick of the frame that the next contact tick uses, or one before: at the begin, and where a grasp
  /// continues with another.
  void start(const ControlSample& control) {
    control_.clear();
    in_use_ = control;
  }
  void add(const ContactSample& sample);
  void add(const ControlSample& sample);
  /// Passes on the waiting ticks, whose control ticks did not arrive.
  void finish() { give(true); }

  /// Returns the control tick of the frame of the last contact tick passed on.
  [[nodiscard]] const ControlSample& in_use() const { return in_use_; }

 private:
  void give(bool all);
  void give(const ContactSample& sample);

  OnTick on_tick_;
  OnControl on_control_;
  std::deque<ContactSample> contact_;
  std::deque<ControlSample> control_;  // of frames not yet used by a tick passed on
  ControlSample in_use_;
  bool ended_ = false;
};

}  // namespace thenar
