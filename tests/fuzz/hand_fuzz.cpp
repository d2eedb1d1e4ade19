// SPDX-License-Identifier: Apache-2.0
// Whatever the text of a hand: a hand whose names can be shown, a ConfigError or a FileError.
#include <cstdlib>

#include "engine/formats/files.h"
#include "engine/formats/text.h"
#include "engine/hand/hand.h"
#include "engine/scenes/config.h"
#include "engine/scenes/hand_file.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thenar;
  static const MemoryFile kFile("hand.yaml");
  kFile.write(text_of(data, size));
  try {
    const Hand hand = load_hand(kFile.path());
    const auto check = [](const std::string& name) {
      if (first_unprintable(name) != name.npos) std::abort();
    };
    for (const Joint& joint : hand.joints) check(joint.name);
    for (const Follower& follower : hand.followers) check(follower.joint.name);
    for (const Segment& segment : hand.segments) check(segment.name);
    for (const Muscle& muscle : hand.muscles) check(muscle.name);
    for (const Fingertip& tip : hand.fingertips) check(tip.finger);
  } catch (const ConfigError&) {
  } catch (const FileError&) {
  }
  return 0;
}
