#pragma once

#include <cstdint>
#include <string>

namespace thenar {

/// What the system granted a thread.
struct Scheduling {
  std::string policy = "SCHED_OTHER";  ///< Or "SCHED_FIFO".
  int priority = 0;
  int core = -1;  ///< The one it is pinned to; -1: any.
  bool memory_locked = false;
  bool denormals_flushed = false;
  double timer_slack_ns = 0.0;
  double spin_us = 0.0;
  std::string remark;  ///< What was refused, and how to get it; empty if nothing was.
};

}  // namespace thenar
