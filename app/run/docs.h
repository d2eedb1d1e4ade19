// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/options.h"

namespace thenar::app {

/// Prints the path of the first page of the documents as a site, and opens it on a desktop. Returns the exit code.
/// Throws FileError if there is no site.
[[nodiscard]] int show_docs(const Options& options);

}  // namespace thenar::app
