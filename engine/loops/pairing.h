#pragma once

#include <deque>
#include <functional>

#include "engine/loops/threads.h"

namespace thenar {

/// Brings together each contact tick of a threaded run and the control tick that made its frame. Their records come on
/// two ways: a contact tick waits here until that of its frame, or a later one, has come.
class Pairing {
 public:
  /// Receives each contact tick, in order, with the control tick of its frame; false: no more of them.
  using OnTick = std::function<bool(const ContactSample& tick, const ControlSample& control)>;
  /// Receives each control tick, in order, before the first contact tick on its frame or a later one, which is `tick`.
  using OnControl = std::function<void(const ContactSample& tick, const ControlSample& control)>;

  explicit Pairing(OnTick on_tick, OnControl on_control = {});

  /// Of the frame that the next contact tick uses, or one before: comes first, and where a grasp goes on with another.
  void start(const ControlSample& control) {
    control_.clear();
    in_use_ = control;
  }
  void add(const ContactSample& sample);
  void add(const ControlSample& sample);
  /// Gives the ticks that wait, and whose control ticks did not come.
  void finish() { give(true); }

  /// Of the frame of the last contact tick given.
  [[nodiscard]] const ControlSample& in_use() const { return in_use_; }

 private:
  void give(bool all);
  void give(const ContactSample& sample);

  OnTick on_tick_;
  OnControl on_control_;
  std::deque<ContactSample> contact_;
  std::deque<ControlSample> control_;  // of frames that no tick given has used yet
  ControlSample in_use_;
  bool ended_ = false;
};

}  // namespace thenar
