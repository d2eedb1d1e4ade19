// SPDX-License-Identifier: Apache-2.0
#include "app/window/page_text.h"

#include <fmt/format.h>

#include <string_view>

#include "app/window/admission.h"
#include "engine/formats/files.h"

namespace thenar::window {
namespace {

constexpr std::string_view kSource = "data-source=\"live\"";

/// The page with a nonce in each tag that begins a script. Between that tag and the next "</script" all is script, and
/// what looks like a tag there is none.
std::string with_nonce(std::string_view html, const std::string& nonce) {
  constexpr std::string_view kBegin = "<script", kEnd = "</script";
  std::string result;
  for (;;) {
    const std::size_t begin = html.find(kBegin);
    if (begin == html.npos) return result.append(html);
    const std::size_t end = html.find(kEnd, begin);
    result.append(html.substr(0, begin + kBegin.size())).append(" nonce=\"" + nonce + "\"");
    const std::size_t body = begin + kBegin.size();
    if (end == html.npos) return result.append(html.substr(body));
    result.append(html.substr(body, end + kEnd.size() - body));
    html.remove_prefix(end + kEnd.size());
  }
}

}  // namespace

PageText read_page(const std::filesystem::path& file, bool recording) {
  std::string html = thenar::read_file(file);
  const std::size_t source = html.find(kSource);
  if (source == html.npos) throw thenar::FileError(file, "is not the page of the window: build it again");
  if (recording) html.replace(source, kSource.size(), "data-source=\"recording\"");
  const std::string nonce = random_token();
  return {with_nonce(html, nonce),
          fmt::format("default-src 'none'; script-src 'nonce-{}'; style-src 'unsafe-inline'; img-src data: blob:; "
                      "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
                      nonce)};
}

}  // namespace thenar::window
