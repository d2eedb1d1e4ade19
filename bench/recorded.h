#pragma once

#include <vector>

#include "engine/contact_tick.h"
#include "engine/control_tick.h"
#include "engine/frame.h"
#include "engine/model.h"
#include "engine/state.h"

namespace thenar {

/// Inputs recorded from configs/box_grasp.yaml while the box is on its way: consecutive states at the published sizes
/// (36 000 + 3 x 2400 points), all of them with the same number of contacts.
struct RecordedRun {
  explicit RecordedRun(Eigen::Index contacts);

  Model model;
  std::vector<State> states;
  std::vector<ControlReport> controls;  ///< What control asked for at each of them.
};

/// The run with 15, 30 or 60 contacts; recorded once.
[[nodiscard]] const RecordedRun& recorded_run(Eigen::Index contacts);

/// One contact problem of a recorded run, as the contact tick meets it.
struct RecordedContacts {
  Eigen::MatrixXd W;
  Eigen::VectorXd delta_free, mu, f_last;  ///< f_last: the forces of the tick before, the warm start.
};
[[nodiscard]] std::vector<RecordedContacts> recorded_contacts(const RecordedRun& run);

}  // namespace thenar
