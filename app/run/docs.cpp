// SPDX-License-Identifier: Apache-2.0
#include "app/run/docs.h"

#include <filesystem>
#include <iostream>
#include <system_error>

#include "app/exit_code.h"
#include "app/open_page.h"
#include "engine/formats/files.h"
#include "engine/scenes/shared_data.h"

namespace thenar::app {

int show_docs(const Options& options) {
  // Beside the program's data, installed or built: share/thenar and share/doc/thenar.
  const std::filesystem::path page = shared_data().parent_path() / "doc" / "thenar" / "html" / "index.html";
  std::error_code unreadable;
  if (!std::filesystem::exists(page, unreadable)) {
    throw FileError(page.string(), "no such file: `./dev docs` in the source's folder builds the documents");
  }
  std::cout << page.string() << std::endl;
  if (!std::cout) throw FileError("standard output", "could not be written in full");
  if (options.browser) open_page(page.string());
  return kDone;
}

}  // namespace thenar::app
