// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/app/refusals.h"

namespace thenar::refusals {

/// Scenes: their text as YAML, their keys, values and ranges, and the files that they name.
inline Refusals refused_scenes() {
  const auto scene = [](const char* what, const char* from, const char* to, const char* message, int code = 2) {
    return Refusal{what, "run FILE --out out", "scene.yaml", edited(kScene, from, to), code, message, ""};
  };
  const auto file = [](const char* what, const char* name, const std::string& text, const char* message, int code = 2) {
    return Refusal{what, "run FILE --out out", name, text, code, message, ""};
  };
  return {
      // Text
      scene("a line is not indented as its neighbours", "  points: 2000", "    points: 2000",
            "FILE:11:5: does not line up with the keys above it: those of one map have the same number of blanks "
            "before them"),
      scene("a tab indents", "  points: 2000", "\tpoints: 2000", "FILE:11:1: a tab stands here: indent with blanks"),
      scene("no blank behind a colon", "mass: 100 g", "mass:100 g",
            "FILE:12:3: 'mass:100 g' is no 'key: value': put a ':' and a blank behind the key"),
      scene("a brace is not closed", "band: 0.3 mm}", "band: 0.3 mm",
            "FILE:19:8: ',' or '}' is missing before this: the '{' of line 18 is still open"),
      scene("a quotation mark is not closed", "name: ball", "name: \"ball",
            "FILE:1:7: the quotation mark that stands here is not closed"),
      scene("a name with a colon", "name: ball", "name: ball: second try",
            "FILE:1:11: a second ': ' stands in this line: put a text that holds one in quotation marks"),
      file("a document of another program", "scene.yaml", "%PDF-1.4\n\x80\x81 obj",
           "FILE:2:1: is no text in UTF-8: it has the byte 0x80 here"),
      // Keys
      scene("a key is misspelt", "friction: 0.8", "frction: 0.8",
            "FILE:18:11: contact.frction: unknown key, did you mean 'contact.friction'?"),
      scene("a key is missing", "  mass: 100 g\n", "", "FILE:9:1: object.mass: this key is missing"),
      scene("a key is there twice", "  mass: 100 g\n", "  points: 3000\n  mass: 100 g\n",
            "FILE:12:3: object.points: this key is already in line 11"),
      scene("a key as the command line has it", "  mass: 100 g", "  mass: 100 g\n  damping.rotation: 0.005 N*m*s",
            "FILE:13:3: object.damping.rotation: in a file each name stands below the one before it, without dots"),
      scene("a shape that there is not", "{sphere: 26.09 mm}", "{cube: 50 mm}",
            "FILE:10:11: object.shape.cube: unknown key, did you mean 'object.shape.box'?"),
      scene("a file in the place of a shape", "{sphere: 26.09 mm}", "mug.obj",
            "FILE:10:10: object.shape: must be a map of one of box, sphere, ellipsoid, cylinder, superquadric, mug, "
            "cloud, not a single value"),
      // Values and units
      scene("no unit", "mass: 100 g", "mass: 0.1", "FILE:12:9: object.mass: 0.1 has no unit: use kg or g"),
      scene("a rate for a period", "control_period: 1 ms", "control_period: 1000 Hz",
            "FILE:2:53: time.control_period: 1000 Hz is not a time: use s, ms or us"),
      scene("a decimal comma", "mass: 100 g", "mass: 0,1 kg",
            "FILE:12:9: object.mass: 0,1 kg is not a mass: the mark in a number is '.', not ','"),
      scene("no commas in a list", "[120.187 mm, 45.770 mm, 35.908 mm]", "[120.187 mm 45.770 mm 35.908 mm]",
            "FILE:13:13: object.position: must be a list of 3 values, not 1: write ',' between them"),
      scene("no for false", "muscles: false", "muscles: no",
            "FILE:26:12: control.muscles: 'no' is neither true, false nor a map of keys and values, did you mean "
            "'false'?"),
      // Ranges
      scene("a negative mass", "mass: 100 g", "mass: -100 g",
            "FILE:12:9: object.mass: -100 g must be greater than zero"),
      scene("metres for millimetres", "sphere: 26.09 mm", "sphere: 26.09 m",
            "FILE:10:19: object.shape.sphere: 26.09 m must be at most 10 m"),
      scene("a loop that is slower than it is asked for", "control_period: 1 ms", "control_period: 0.5 ms",
            "FILE:2:53: time.control_period: must not be shorter than time.step"),
      scene("a mirrored frame", "[[0.6853202845266846, 0.1358649520401693, -0.7154556746741104]",
            "[[-0.6853202845266846, -0.1358649520401693, 0.7154556746741104]",
            "FILE:14:13: object.rotation: is a mirror image: turn one of its axes round"),
      scene("a joint beyond its stop", "[0.0863 rad", "[50 deg",
            "FILE:6:12: hand.posture: value 1 (T_CMC_FE) is 0.8727 rad and must lie within -0.78 .. 0.5 rad, -44.7 .. "
            "28.6 deg"),
      // Files
      scene("a hand that there is not", "model: three_finger", "model: three_fingers",
            "FILE:5:10: hand.model: three_fingers: no such file, did you mean 'three_finger'?", 3),
      scene("a scan that there is not", "{sphere: 26.09 mm}\n  points: 2000", "{cloud: scan.ply}",
            "scan.ply: no such file", 3),
      file("an object as a scene", "box.obj", kBox,
           "FILE: is an object, and no scene: thenar new my.yaml --object FILE writes one"),
  };
}

}  // namespace thenar::refusals
