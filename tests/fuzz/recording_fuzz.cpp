// Whatever the bytes of a recording: what replaying it and exporting it take from it, or a FileError.
#include <cstdlib>

#include "engine/formats/files.h"
#include "engine/formats/mcap_file.h"
#include "engine/results/recording_file.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thenar;
  static const MemoryFile kFile("recording.mcap");
  kFile.write(text_of(data, size));
  try {
    std::size_t bytes = 0;
    for (const McapMessage& message : read_mcap(kFile.path()).messages) bytes += message.bytes.size();
    if (bytes > size) std::abort();
    (void)recording_csv(kFile.path());
  } catch (const FileError&) {
  }
  return 0;
}
