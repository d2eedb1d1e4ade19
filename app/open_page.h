// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace thenar::app {

/// Opens an address in the desktop's browser, where there is a desktop. Says nothing, and does not wait: a browser that
/// cannot be started is no error, because the caller has printed the address.
void open_page(std::string address);

}  // namespace thenar::app
