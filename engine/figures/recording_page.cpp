// SPDX-License-Identifier: Apache-2.0
#include "engine/figures/recording_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/archive/iterators/base64_from_binary.hpp>
#include <boost/archive/iterators/transform_width.hpp>
#include <string_view>
#include <vector>

#include "engine/formats/files.h"
#include "engine/formats/mcap_file.h"
#include "engine/formats/mcap_reader.h"
#include "engine/recordings/recorded_run.h"
#include "engine/scenes/shared_data.h"

namespace thenar {

namespace {

namespace fs = std::filesystem;

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
  const fs::path page = shared_data() / "page.html";
  if (!fs::exists(page)) throw FileError(page, "is missing: ./dev build makes it, where npm is installed");
  std::string html = read_file(page);
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

/// What a page shows of a recording, as a recording of that alone. Where the one was cut off, so is the other. Throws
/// FileError without states.
std::string shown_of(const fs::path& recording) {
  const std::vector<std::string> topics = {"/scene", "/geometry", "/state", "/status"};
  std::vector<McapChannel> channels;
  for (const std::string& topic : topics) channels.push_back({topic, "", "", "", ""});
  McapEncoder encoder(channels);
  std::string shown;
  shown.reserve(fs::file_size(recording));
  bool has_states = false;
  const McapReading reading = read_mcap(recording, [&](const McapMessage& message) {
    const auto topic = std::ranges::find(topics, message.topic);
    if (topic == topics.end()) return;
    has_states = has_states || *topic == "/state";
    encoder.add(static_cast<std::size_t>(topic - topics.begin()), message.time_s, message.bytes);
    shown += encoder.take();
  });
  if (!has_states) throw FileError(recording, "holds no states");
  encoder.end_chunk();
  if (reading.whole) encoder.finish();
  return shown + encoder.take();
}

/// Throws FileError where a page could not draw the states.
void check_shown(const fs::path& recording) {
  const auto none = [](const Field&) { return false; };
  const RecordedRun run = read_recording(recording, {none, false});
  for (const char* needed : {"object", "target", "segments", "contacts"}) {
    if (std::ranges::find(run.recorded, needed) != run.recorded.end()) continue;
    throw FileError(recording,
                    fmt::format("has some fields of its states alone, without {}: there is no picture of it", needed));
  }
}

}  // namespace

std::string recording_page(const fs::path& recording) {
  check_shown(recording);
  return page_with(shown_of(recording));
}

}  // namespace thenar
