// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace thenar {

/// What puts n balls, each a body, on a square grid under the box of configs/box_grasp.yaml and along its way, n / 2 a
/// square of whole numbers; they rise by 0.2 mm and press against it while it goes. Of none: nothing.
[[nodiscard]] std::vector<std::string> bed_of_balls(int n);

}  // namespace thenar
