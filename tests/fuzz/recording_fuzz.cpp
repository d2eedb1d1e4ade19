// SPDX-License-Identifier: Apache-2.0
// Whatever the bytes of a recording: what replaying it and exporting it take from it, or a FileError.
#include "engine/formats/files.h"
#include "engine/formats/mcap_reader.h"
#include "engine/recordings/run_tables.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thenar;
  static const MemoryFile kFile("recording.mcap");
  kFile.write(text_of(data, size));
  try {
    std::size_t bytes = 0;
    (void)read_mcap(text_of(data, size), kFile.path(), [&](const McapMessage& message) {
      bytes += message.bytes.size();
      (void)read_contact_block(message.bytes);
    });
    const RecordedRun run = read_recording(kFile.path());
    (void)run_csv(run);
    (void)run_npz(run, kFile.path());
    (void)run_sto(run, kFile.path());
  } catch (const FileError&) {
  }
  return 0;
}
