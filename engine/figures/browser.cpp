// SPDX-License-Identifier: Apache-2.0
#include "engine/figures/browser.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <boost/archive/iterators/binary_from_base64.hpp>
#include <boost/archive/iterators/transform_width.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "engine/formats/child_process.h"
#include "engine/formats/files.h"
#include "engine/formats/talking_process.h"

namespace thenar {

using nlohmann::json;
namespace fs = std::filesystem;

namespace {

constexpr std::chrono::seconds kPatience(120);  // A page without a graphics card takes its time.

/// The name of a browser that starts. Throws FileError.
std::string installed() {
  std::vector<std::string> names = {"chromium", "google-chrome", "chromium-browser"};
  if (const char* const named = getenv("CHROMIUM")) names.insert(names.begin(), named);
  // Ubuntu's chromium-browser may only say that there is a snap.
  const auto found = std::ranges::find_if(names, [](const std::string& name) {
    return output_of({name, "--version"}, "").has_value();
  });
  if (found == names.end())
    throw FileError("chromium", "is missing: install it, or name a browser by CHROMIUM=/path/to/it");
  return *found;
}

std::vector<std::string> command_of(const std::string& browser, const fs::path& profile) {
  std::vector<std::string> command = {
      browser,
      "--headless=new",
      "--remote-debugging-pipe",
      "--user-data-dir=" + profile.string(),
      "--no-first-run",
      "--no-default-browser-check",
      "--disable-background-networking",
      "--disable-component-update",
      "--disable-sync",
      "--hide-scrollbars",
      "--force-color-profile=srgb",
      "--use-gl=angle",
      "--use-angle=swiftshader",  // The same pixels with any graphics card, and with none.
      "--enable-unsafe-swiftshader"};
  if (geteuid() == 0) command.emplace_back("--no-sandbox");  // Which it refuses to have as root.
  command.emplace_back("--no-startup-window");
  return command;
}

std::string from_base64(std::string text) {
  using namespace boost::archive::iterators;
  using Bytes = transform_width<binary_from_base64<std::string::const_iterator>, 8, 6>;
  const auto padding = static_cast<std::size_t>(std::ranges::count(text, '='));
  std::ranges::replace(text, '=', 'A');
  std::string bytes(Bytes(text.begin()), Bytes(text.end()));
  bytes.resize(bytes.size() - padding);
  return bytes;
}

}  // namespace

struct Browser::Impl {
  /// A folder that is removed with what is in it.
  struct TemporaryFolder {
    fs::path path;

    TemporaryFolder() {
      std::string name = fs::temp_directory_path() / "thenar-XXXXXX";
      if (mkdtemp(name.data()) == nullptr) throw FileError(name, "cannot be made");
      path = name;
    }
    ~TemporaryFolder() {
      std::error_code none;
      fs::remove_all(path, none);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  };

  TemporaryFolder folder;
  std::string name = installed();
  TalkingProcess process{command_of(name, folder.path / "profile")};
  std::string session;
  int number = 0;

  [[noreturn]] void fail(const std::string& what) const { throw FileError(name, what); }

  /// Asks for something and returns its result; the events of the protocol that come meanwhile are passed over.
  json ask(const char* method, json parameters) {
    json question = {{"id", ++number}, {"method", method}, {"params", std::move(parameters)}};
    if (!session.empty()) question["sessionId"] = session;
    if (!process.send(question.dump())) fail("ended");
    for (;;) {
      const std::optional<std::string> message = process.receive(kPatience);
      if (!message) fail(fmt::format("gave no answer to {}", method));
      json answer = json::parse(*message, nullptr, false);
      if (answer.is_discarded() || answer.value("id", 0) != number) continue;
      if (answer.contains("error")) fail(fmt::format("refuses {}: {}", method, answer["error"].value("message", "")));
      return std::move(answer["result"]);
    }
  }
};

Browser::Browser(const std::string& html, int width, int height) : impl_(std::make_unique<Impl>()) {
  const fs::path page = impl_->folder.path / "page.html";
  write_file(page, html);
  const json target = impl_->ask("Target.createTarget", {{"url", "about:blank"}})["targetId"];
  impl_->session = impl_->ask("Target.attachToTarget", {{"targetId", target}, {"flatten", true}})["sessionId"];
  impl_->ask("Emulation.setDeviceMetricsOverride",
             {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", false}});
  impl_->ask("Page.navigate", {{"url", "file://" + page.string()}});
}

Browser::~Browser() = default;

json Browser::evaluate(std::string_view script) {
  json result =
      impl_->ask("Runtime.evaluate", {{"expression", script}, {"awaitPromise", true}, {"returnByValue", true}});
  if (result.contains("exceptionDetails")) {
    impl_->fail("the page: " + result["exceptionDetails"]["exception"].value("description", "an error"));
  }
  return result["result"].value("value", json());
}

std::string Browser::picture() {
  return from_base64(impl_->ask("Page.captureScreenshot", {{"format", "png"}, {"optimizeForSpeed", true}})["data"]);
}

const fs::path& Browser::folder() const { return impl_->folder.path; }

}  // namespace thenar
