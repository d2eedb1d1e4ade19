// SPDX-License-Identifier: Apache-2.0
#include "app/window/page_text.h"

#include <gtest/gtest.h>

#include <string>

#include "engine/formats/files.h"
#include "tests/window/server_clients.h"

namespace thenar::window::page_text_test {
namespace {

using namespace server_clients;

TEST_F(Server, ServesThePageWithItsOwnScriptsAlone) {
  start();
  const std::string answer = get("/");
  ASSERT_EQ(status(answer), 200) << answer;
  const std::string header = answer.substr(0, answer.find("\r\n\r\n"));
  EXPECT_NE(header.find("Cache-Control: no-store"), std::string::npos);
  EXPECT_NE(header.find("Referrer-Policy: no-referrer"), std::string::npos);
  const std::size_t begin = header.find("'nonce-") + 7;
  const std::string nonce = header.substr(begin, header.find('\'', begin) - begin);
  EXPECT_EQ(nonce.size(), 32U);
  EXPECT_NE(header.find("Content-Security-Policy: default-src 'none'; script-src 'nonce-"), std::string::npos);
  // What looks like a tag inside a script is left alone.
  EXPECT_EQ(body(answer),
            "<!doctype html><html data-source=\"live\"><style>p{}</style><!-- recording --><script nonce=\"" + nonce +
                "\">'<script>'</script><script nonce=\"" + nonce + "\" type=\"module\">1</script></html>");
  EXPECT_EQ(status(get("/?x=1")), 200);
  EXPECT_EQ(status(get("/recording")), 404);
}

TEST_F(Server, WantsItsFiles) {
  settings_.page = folder_ / "none.html";
  EXPECT_THROW(start(), thenar::FileError);
  thenar::write_file(folder_ / "page.html", "<html></html>");
  settings_.page = folder_ / "page.html";
  EXPECT_THROW(start(), thenar::FileError);
  thenar::write_file(folder_ / "page.html", kPage);
  settings_.recording = folder_ / "none.mcap";
  EXPECT_THROW(start(), thenar::FileError);
}

}  // namespace
}  // namespace thenar::window::page_text_test
