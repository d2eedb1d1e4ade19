// Whatever the text of a hand: a hand, a ConfigError or a FileError.
#include "engine/config.h"
#include "engine/files.h"
#include "engine/hand.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thenar;
  static const MemoryFile kFile("hand.yaml");
  kFile.write(text_of(data, size));
  try {
    (void)load_hand(kFile.path());
  } catch (const ConfigError&) {
  } catch (const FileError&) {
  }
  return 0;
}
