#include "app/export.h"

#include <fmt/format.h>

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
#include "engine/formats/mcap_reader.h"
#include "engine/results/recorded_run.h"
#include "engine/results/run_tables.h"
#include "engine/scenes/scene_file.h"
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

/// What a page shows of a recording, as a recording of that alone. Where the one was cut off, so is the other.
std::string shown_of(const fs::path& recording) {
  const std::vector<std::string> topics = {"/scene", "/geometry", "/state", "/status"};
  std::vector<thenar::McapChannel> channels;
  for (const std::string& topic : topics) channels.push_back({topic, "", "", "", ""});
  thenar::McapEncoder encoder(channels);
  std::string shown;
  shown.reserve(fs::file_size(recording));
  const thenar::McapReading reading = thenar::read_mcap(recording, [&](const thenar::McapMessage& message) {
    const auto topic = std::ranges::find(topics, message.topic);
    if (topic == topics.end()) return;
    encoder.add(static_cast<std::size_t>(topic - topics.begin()), message.time_s, message.bytes);
    shown += encoder.take();
  });
  encoder.end_chunk();
  if (reading.whole) encoder.finish();
  return shown + encoder.take();
}

/// Throws FileError where a page could not draw the states.
void check_shown(const fs::path& recording) {
  const auto none = [](const thenar::Field&) { return false; };
  const thenar::RecordedRun run = thenar::read_recording(recording, {none, false});
  for (const char* needed : {"object", "target", "segments", "contacts"}) {
    if (std::ranges::find(run.recorded, needed) != run.recorded.end()) continue;
    throw FileError(recording,
                    fmt::format("has some fields of its states alone, without {}: there is no picture of it", needed));
  }
}

/// Refuses what has no states, and says what is wrong with the others.
void look_at(const fs::path& recording) {
  double last_s = 0.0;
  bool has_states = false;
  const thenar::McapReading reading = thenar::read_mcap(recording, [&](const thenar::McapMessage& message) {
    has_states = has_states || message.topic == "/state";
    last_s = message.time_s;
  });
  if (!has_states) throw FileError(recording, "holds no states");
  if (reading.damaged_chunks > 0) {
    std::cerr << "warning: " << recording.string() << " is damaged: parts of it are missing\n";
  } else if (!reading.whole) {
    std::cerr << "warning: " << recording.string() << " was cut off; it goes on to " << last_s << " s\n";
  }
}

}  // namespace

int export_recording(const Options& options) {
  std::vector<Result> results;
  if (!options.html.empty()) results.push_back({"--html", options.html});
  if (!options.csv.empty()) results.push_back({"--csv", options.csv});
  if (!options.npz.empty()) results.push_back({"--npz", options.npz});
  if (!options.sto.empty()) results.push_back({"--sto", options.sto});
  check_results(results, {options.recording});
  look_at(options.recording);
  if (!options.html.empty()) {
    check_shown(options.recording);
    thenar::write_file(options.html, page_with(shown_of(options.recording)));
  }
  if (!options.csv.empty()) {
    const thenar::RecordedRun run = thenar::read_recording(options.recording, {thenar::is_signal, false});
    thenar::write_file(options.csv, thenar::run_csv(run));
  }
  if (!options.sto.empty()) {
    const auto of_joints = [](const thenar::Field& field) {
      return field.name == "time_s" || field.name == "q_rad" || field.name == "muscles_N";
    };
    const thenar::RecordedRun run = thenar::read_recording(options.recording, {of_joints, false});
    thenar::write_file(options.sto, thenar::run_sto(run, options.recording));
  }
  if (!options.npz.empty()) {
    thenar::write_file(options.npz, thenar::run_npz(thenar::read_recording(options.recording), options.npz));
  }
  return kDone;
}
