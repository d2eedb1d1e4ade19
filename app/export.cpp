#include "app/export.h"

#include <algorithm>
#include <boost/archive/iterators/base64_from_binary.hpp>
#include <boost/archive/iterators/transform_width.hpp>
#include <filesystem>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include "app/exit_code.h"
#include "app/results.h"
#include "engine/formats/files.h"
#include "engine/formats/mcap_file.h"
#include "engine/results/recording_file.h"
#include "engine/scenes/shared_data.h"

namespace {

namespace fs = std::filesystem;
using thenar::FileError;

void append_base64(std::string_view bytes, std::string& text) {
  using namespace boost::archive::iterators;
  using Letters = base64_from_binary<transform_width<std::string_view::const_iterator, 6, 8>>;
  for (Letters letter(bytes.begin()), end(bytes.end()); letter != end; ++letter) text += *letter;
  text.append((3 - bytes.size() % 3) % 3, '=');
}

/// Where `what` is in the page's text.
std::size_t place_of(std::string_view what, std::string_view text, const fs::path& page) {
  const std::size_t at = text.find(what);
  if (at == std::string::npos) throw FileError(page, "is no page of this program");
  return at;
}

/// The page with the recording in it.
std::string page_with(std::string_view recording) {
  constexpr std::string_view kSource = "data-source=\"live\"", kPlace = "<!-- recording -->";
  const fs::path page = thenar::shared_data() / "page.html";
  if (!fs::exists(page)) throw FileError(page, "is missing: ./dev build makes it, where npm is installed");
  std::string html = thenar::read_file(page);
  html.replace(place_of(kSource, html, page), kSource.size(), "data-source=\"embedded\"");
  const std::size_t place = place_of(kPlace, html, page);
  // Recordings are large: their letters are made where they stay.
  std::string whole = html.substr(0, place);
  whole.reserve(html.size() + recording.size() / 3 * 4 + 100);
  whole += "<script id=\"recording\" type=\"text/plain\">";
  append_base64(recording, whole);
  whole.append("</script>").append(html, place + kPlace.size());
  return whole;
}

/// Looks at the recording, and makes the page if it is asked for; then its bytes are let go.
void look_at(const Options& options) {
  const thenar::McapContents contents = thenar::read_mcap(options.record);
  const auto last = contents.messages.empty() ? 0.0 : contents.messages.back().time_s;
  const auto is_state = [](const thenar::McapMessage& message) { return message.topic == "/state"; };
  if (std::none_of(contents.messages.begin(), contents.messages.end(), is_state)) {
    throw FileError(options.record, "holds no states");
  }
  if (!contents.whole) {
    std::cerr << "warning: " << options.record.string() << " was cut off; it goes on to " << last << " s\n";
  }
  if (!options.html.empty()) thenar::write_file(options.html, page_with(contents.file));
}

}  // namespace

int export_recording(const Options& options) {
  std::vector<Result> results;
  if (!options.html.empty()) results.push_back({"--html", options.html});
  if (!options.csv.empty()) results.push_back({"--csv", options.csv});
  check_results(results, {options.record});
  look_at(options);
  if (!options.csv.empty()) thenar::write_file(options.csv, thenar::recording_csv(options.record));
  return kDone;
}
