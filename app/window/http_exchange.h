// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "app/window/admission.h"
#include "app/window/hub.h"
#include "app/window/page_text.h"

namespace thenar::window {

/// Served content and its admission.
struct Site {
  Listening listening;
  PageText page;
  std::filesystem::path recording;  ///< Served recording; empty: none, live instead.
};

/// Reads one request, and answers it or makes a PageLink of its connection; on the server's thread. A connection that
/// takes longer than the hub's patience to state its request, or to take a piece of the answer, ends. So may one that
/// has not shown its admission, where others wait.
void serve(Stream stream, const Site& site, Hub& hub);

}  // namespace thenar::window
