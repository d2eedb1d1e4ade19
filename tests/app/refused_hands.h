// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/app/refusals.h"

namespace thenar::refusals {

/// A hand file of one joint.
inline const std::string kHand = R"(joints:
- {name: bend, origin_at_q0: [0, 0, 0], axis_at_q0: [0, 0, 1], limits: [-0.5, 1.5]}
segments:
- name: tip
  moved_by: [bend]
  length: 0.03
  mass: 0.01
  com: [0.015, 0, 0]
  frame_at_q0: {origin: [0, 0, 0], R: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}
fingertips:
- {finger: thumb, segment: tip, pulp_centre: [0.03, 0, 0], radius: 0.008, pulp_normal: [0, 1, 0]}
)";

/// Two fingers of one joint each.
inline const std::string kMjcf = R"(<mujoco>
  <worldbody>
    <body name="palm">
      <body name="thumb_1" pos="0 0.04 0">
        <joint name="thumb_bend" type="hinge" axis="0 0 1" range="-30 90"/>
        <geom type="capsule" fromto="0 0 0 0.04 0 0" size="0.008"/>
      </body>
      <body name="index_1" pos="0 -0.04 0">
        <joint name="index_bend" type="hinge" axis="0 0 1" range="-30 90"/>
        <geom type="capsule" fromto="0 0 0 0.04 0 0" size="0.008"/>
      </body>
    </body>
  </worldbody>
</mujoco>
)";

/// The same in URDF, of one finger.
inline const std::string kUrdf = R"(<robot name="hand">
  <link name="palm"/>
  <link name="thumb_1"/>
  <joint name="thumb_bend" type="revolute">
    <parent link="palm"/> <child link="thumb_1"/> <axis xyz="0 0 1"/>
    <limit lower="-0.5" upper="1.5"/>
  </joint>
</robot>
)";

/// Hands: their own files, those of others, and what names their fingers.
inline Refusals refused_hands() {
  const auto hand = [](const char* what, const char* from, const char* to, const char* message) {
    return Refusal{what, "hand FILE --out hand.png", "hand.yaml", edited(kHand, from, to), 2, message, ""};
  };
  const auto import = [](const char* what, const char* tips, const char* name, const std::string& text,
                         const char* message) {
    return Refusal{what, std::string("hand import FILE --out my.yaml --tips ") + tips, name, text, 2, message, ""};
  };
  const char* const two = "thumb=thumb_1,index=index_1";
  return {
      hand("a joint that there is not", "moved_by: [bend]", "moved_by: [bnd]",
           "FILE:5:13: segments[0].moved_by: no joint is named 'bnd', did you mean 'bend'?"),
      hand("limits the other way round", "limits: [-0.5, 1.5]", "limits: [1.5, -0.5]",
           "FILE:2:72: joints[0].limits: its lower end comes first, and must not be above the other"),
      import("a tag is not closed", two, "hand.xml",
             edited(kMjcf, "      </body>\n      <body name=\"index", "      <body name=\"index"),
             "FILE:12: is no XML: this tag closes another element than the last one that is open, or an element is not "
             "closed"),
      import("a joint that slides", two, "hand.xml", edited(kMjcf, "type=\"hinge\"", "type=\"slide\""),
             "FILE:5: joint 'thumb_bend': slides, and the thumb hangs on it: make it a hinge (URDF: revolute), or lock "
             "it, if other joints move the finger: --lock thumb_bend"),
      import("a joint without limits", "thumb=thumb_1", "hand.urdf",
             edited(kUrdf, "<limit lower=\"-0.5\" upper=\"1.5\"/>", ""),
             "FILE:4: joint 'thumb_bend': has no limits: a hand's joint needs <limit lower=... upper=.../>"),
      import("a macro that was not expanded", "thumb=thumb_1", "hand.urdf",
             edited(kUrdf, "  <link name=\"palm\"/>", "  <xacro:finger name=\"thumb\"/>\n  <link name=\"palm\"/>"),
             "FILE:2: xacro:finger 'thumb': is a macro: expand the file with xacro first"),
      import("a macro within a joint", "thumb=thumb_1", "hand.urdf",
             edited(kUrdf, "<limit lower=\"-0.5\"", "<xacro:place name=\"origin\"/><limit lower=\"-0.5\""),
             "FILE:6: xacro:place 'origin': is a macro: expand the file with xacro first"),
      import("a fingertip that there is not", "thumb=thum_1,index=index_1", "hand.xml", kMjcf,
             "--tips thumb=thum_1: no body or site of FILE is named 'thum_1', did you mean 'thumb_1'?"),
      {"muscles of a hand without any", "check leap_carry --set control.muscles=true", "", "", 2,
       "--set control.muscles: this hand has none: write false, and torques drive its joints", ""},
  };
}

}  // namespace thenar::refusals
