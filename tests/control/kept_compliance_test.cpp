// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "engine/grasp/compliance.h"
#include "engine/loops/run.h"
#include "engine/models/build_model.h"
#include "tests/support/scenes.h"

namespace thenar::kept_compliance_test {
namespace {

using Eigen::Index;

/// The frame's contacts by finger and control point.
std::vector<std::pair<int, Index>> contacts_of(const Frame& frame) {
  std::vector<std::pair<int, Index>> contacts;
  for (const FrameContact& contact : frame.contacts) contacts.emplace_back(contact.finger, contact.control_point);
  return contacts;
}

void expect_same_bits(const Frame& frame, const Frame& anew) {
  for (std::size_t k = 0; k + 1 < frame.begin.size(); ++k) {
    const Index n = frame.begin[k + 1] - frame.begin[k];
    const SurfaceCompliance &kept = frame.compliance[k], &made = anew.compliance[k];
    EXPECT_EQ(kept.p_m.topRows(n), made.p_m.topRows(n));
    for (const auto member : {&SurfaceCompliance::k, &SurfaceCompliance::a, &SurfaceCompliance::b})
      EXPECT_EQ((kept.*member).topLeftCorner(n, n), (made.*member).topLeftCorner(n, n));
    for (const auto member :
         {&SurfaceCompliance::normal_rows, &SurfaceCompliance::cross_rows, &SurfaceCompliance::bent_rows})
      EXPECT_EQ((kept.*member).topLeftCorner(3 * n, n), (made.*member).topLeftCorner(3 * n, n));
  }
}

struct Case {
  const char* description;
  std::string scene;
  std::vector<std::string> changes;
  double time_s;
  bool keeps_some;
};

// Kept or not, a frame's compliance is what it would be if it were made anew, and equal numbers mean equal contacts. It
// is made anew where it changes with the load or with how much of a cell an edge leaves, and on a soft object.
TEST(KeptCompliance, IsWhatItWouldBeAnew) {
  const Case cases[] = {
      {"carried", "box_grasp", {kCoarseBox}, 0.8, true},
      {"the contacts change", "capsule", {"object.points=6000"}, 0.5, true},
      {"stiffer under load", "pinch_max", {"object.points=6000"}, 0.1, false},
      {"edges in cells", "box_edge", {"object.points=6000"}, 0.2, false},
      {"soft object",
       "box_grasp",
       {kCoarseBox, "object.compliance={reduced_modulus: 1 MPa, poisson: 0.5, relaxation: 5 ms}"},
       0.1,
       false},
  };
  for (const Case& one : cases) {
    SCOPED_TRACE(one.description);
    const Model model = build_model(scene_of(one.scene, one.changes));
    GraspRun run(model);
    run.tick();
    std::vector<std::pair<int, Index>> last_contacts = contacts_of(run.frame);
    std::int64_t last_list = run.frame.list, last_edition = run.frame.compliance_edition;
    int kept = 0, frames = 0;
    while (run.time_s() < one.time_s) {
      run.tick();
      Frame anew = run.frame;
      for (SurfaceCompliance& C : anew.compliance) C.k.setConstant(std::numeric_limits<double>::quiet_NaN());
      fill_kernels(model, anew);
      expect_same_bits(run.frame, anew);
      const auto contacts = contacts_of(run.frame);
      EXPECT_EQ(run.frame.list == last_list, contacts == last_contacts);
      if (run.frame.compliance_edition == last_edition) {
        EXPECT_EQ(run.frame.list, last_list);
        ++kept;
      }
      last_contacts = contacts, last_list = run.frame.list, last_edition = run.frame.compliance_edition;
      ++frames;
      ASSERT_FALSE(HasFailure()) << "at " << run.time_s() << " s";
    }
    EXPECT_EQ(kept > frames / 2, one.keeps_some) << kept << " of " << frames;
  }
}

}  // namespace
}  // namespace thenar::kept_compliance_test
