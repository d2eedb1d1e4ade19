// SPDX-License-Identifier: Apache-2.0
// Whatever the text of an MJCF or URDF file: a hand that its hand file holds, a ConfigError or a FileError. The first
// line may be a comment that names the tips: <!--tips a=b,c=d-->.
#include <cmath>
#include <cstdlib>
#include <string>

#include "engine/formats/files.h"
#include "engine/imports/hand_import.h"
#include "engine/imports/hand_text.h"
#include "engine/scenes/config.h"
#include "engine/scenes/hand_file.h"
#include "tests/fuzz/memory_file.h"

namespace {

thenar::HandRequest request_of(std::string_view text) {
  thenar::HandRequest request;
  constexpr std::string_view kBegin = "<!--tips ";
  const std::size_t end = text.find("-->");
  std::string tips = "thumb=thumb,index=index";
  if (text.starts_with(kBegin) && end != text.npos) tips = text.substr(kBegin.size(), end - kBegin.size());
  for (const std::string& tip : thenar::split_tips(tips)) request.tips.push_back(thenar::read_tip(tip));
  request.uncouple = text.size() % 2 == 0;
  request.mirror = text.size() % 3 == 0;
  return request;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thenar;
  static const MemoryFile kFile(std::string("hand") + THENAR_ENDING), kHand("hand.yaml");
  const std::string_view text = text_of(data, size);
  kFile.write(text);
  try {
    const ImportedHand made = import_hand(read_bodies(kFile.path()), request_of(text));
    kHand.write(hand_text(made, "A hand of the fuzzer."));
  } catch (const ConfigError&) {
    return 0;
  } catch (const FileError&) {
    return 0;
  }
  // What was made of it must be a hand file that is read without a word.
  const Hand hand = load_hand(kHand.path());
  for (const Joint& joint : hand.joints) {
    if (!joint.origin_m.allFinite() || std::abs(joint.axis.norm() - 1.0) > 1e-9) std::abort();
  }
  return 0;
}
