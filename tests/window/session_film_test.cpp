// SPDX-License-Identifier: Apache-2.0
#include "app/window/session_film.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <string>

#include "engine/recordings/recorded_run.h"
#include "tests/support/messages.h"
#include "tests/support/scratch.h"
#include "tests/window/shown_session.h"

namespace thenar::window::session_film_test {
namespace {

using namespace shown_session;

SessionSettings recording_into(const std::filesystem::path& folder) {
  SessionSettings settings = ShownSession::quiet();
  settings.record_folder = folder;
  return settings;
}

/// Begins a recording; returns its news in the status, with its file.
ordered_json begun(ShownSession& shown) {
  EXPECT_EQ(shown.receive(Record{}), "");
  EXPECT_TRUE(
      shown.comes([&] { return shown.status()["recording"].is_object() && shown.status()["recording"]["running"]; }));
  return shown.status()["recording"];
}

/// Ends it, likewise.
ordered_json ended(ShownSession& shown) {
  EXPECT_EQ(shown.receive(StopRecording{}), "");
  EXPECT_TRUE(shown.comes([&] { return shown.status()["recording"]["running"] == false; }));
  return shown.status()["recording"];
}

TEST(SessionFilm, APageBeginsAndEndsARecordingOfWhatIsBetween) {
  const std::filesystem::path folder = scratch();
  ShownSession shown(held_box(), recording_into(folder));
  ASSERT_TRUE(shown.passes(0.3));
  EXPECT_TRUE(shown.status()["recording"].is_null());
  EXPECT_NE(shown.receive(StopRecording{}), "");
  // So slowly that a busy machine, too, has the time to write every state.
  shown.receive(Speed{0.2});
  ASSERT_TRUE(shown.comes([&] { return shown.status()["speed"] == 0.2; }));

  const double before_s = shown.value("time_s");
  const ordered_json news = begun(shown);
  EXPECT_NE(shown.receive(Record{}), "") << "one is being made";
  const std::filesystem::path file = news["file"].get<std::string>();
  EXPECT_EQ(file.parent_path(), folder);
  ASSERT_TRUE(shown.passes(news["begun_s"].get<double>() + 0.2));
  shown.receive(Set{{{"level", 2.0}}});  // The scene comes again, in it too.
  ASSERT_TRUE(shown.comes([&] { return shown.scenes() == 2; }));
  ASSERT_TRUE(shown.passes(news["begun_s"].get<double>() + 0.6));
  const double last_s = shown.value("time_s");
  EXPECT_TRUE(ended(shown)["note"].is_null()) << shown.status()["recording"];
  ASSERT_TRUE(shown.passes(shown.value("time_s") + 0.1));
  const double after_s = shown.value("time_s");

  const RecordedRun run = read_recording(file);
  EXPECT_TRUE(run.reading.whole);
  const Eigen::VectorXd times_s = run.times_s();
  const double period_s = 1.0 / kRecordingRate_Hz;
  ASSERT_GT(times_s.size(), 20);
  EXPECT_GE(news["begun_s"].get<double>(), before_s);
  EXPECT_GE(times_s[0], news["begun_s"].get<double>());
  EXPECT_LE(times_s[0], news["begun_s"].get<double>() + period_s + 1e-9);
  for (Eigen::Index i = 1; i < times_s.size(); ++i) {
    EXPECT_GE(times_s[i], times_s[i - 1]);
    EXPECT_LE(times_s[i] - times_s[i - 1], period_s + 1e-9);
  }
  EXPECT_GE(times_s[times_s.size() - 1], last_s - period_s - 1e-9);
  EXPECT_LT(times_s[times_s.size() - 1], after_s - 0.05);
  int scenes = 0, statuses = 0;
  for (const KeptMessage& message : messages_in(file).messages) {
    scenes += message.topic == "/scene";
    statuses += message.topic == "/status";
    EXPECT_EQ(message.bytes.find(folder.string()), std::string::npos) << "where it lies is no part of it";
  }
  EXPECT_EQ(scenes, 2);
  EXPECT_GE(statuses, 1);
  shown.end();
  EXPECT_EQ(shown.fault(), "");
}

TEST(SessionFilm, EachRecordingHasAFileOfItsOwn) {
  ShownSession shown(held_box(), recording_into(scratch()));
  ASSERT_TRUE(shown.passes(0.1));
  const std::string first = begun(shown)["file"];
  ended(shown);
  const auto bytes = std::filesystem::file_size(first);
  const std::string second = begun(shown)["file"];
  EXPECT_NE(second, first);
  shown.end();  // Ends it, too.
  EXPECT_EQ(std::filesystem::file_size(first), bytes);
  EXPECT_TRUE(read_recording(second).reading.whole);
}

TEST(SessionFilm, ARecordingBegunInAPauseHasTheStateThatIsSeen) {
  ShownSession shown(held_box(), recording_into(scratch()));
  ASSERT_TRUE(shown.passes(0.2));
  shown.receive(Pause{});
  ASSERT_TRUE(shown.rests());
  const std::string file = begun(shown)["file"];
  ASSERT_TRUE(shown.rests());
  ended(shown);
  const Eigen::VectorXd times_s = read_recording(file).times_s();
  ASSERT_EQ(times_s.size(), 1);
  EXPECT_EQ(times_s[0], shown.value("time_s"));
}

// The recording that the command line asked for is ended by a page like any other.
TEST(SessionFilm, APageEndsTheRecordingOfTheCommandLine) {
  SessionSettings settings = recording_into(scratch());
  settings.record = settings.record_folder / "session.mcap";
  ShownSession shown(held_box(), settings);
  ASSERT_TRUE(shown.passes(0.2));
  EXPECT_EQ(shown.status()["recording"]["file"], settings.record.string());
  EXPECT_NE(shown.receive(Record{}), "");
  ended(shown);
  EXPECT_TRUE(read_recording(settings.record).reading.whole);
}

TEST(SessionFilm, SaysWhyItCannotRecord) {
  const std::filesystem::path nowhere = scratch() / "nowhere";
  ShownSession shown(held_box(), recording_into(nowhere));
  ASSERT_TRUE(shown.passes(0.1));
  EXPECT_EQ(shown.receive(Record{}), "");
  ASSERT_TRUE(shown.comes([&] { return shown.status()["recording"].is_object(); }));
  const ordered_json news = shown.status()["recording"];
  EXPECT_EQ(news["running"], false);
  EXPECT_EQ(news["note"], "cannot be written: No such file or directory");
  EXPECT_TRUE(shown.passes(shown.value("time_s") + 0.1)) << "the grasp goes on";
  // It can be tried again.
  std::filesystem::create_directory(nowhere);
  begun(shown);
  shown.end();
  EXPECT_EQ(shown.fault(), "") << "nothing is lost of what had not begun";
}

/// Files of this process have at most so many bytes, as on a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  void (*handler_)(int);
  rlimit before_{};
};

TEST(SessionFilm, EndsARecordingWhoseDiskIsFullAndSaysSo) {
  ShownSession shown(held_box(), recording_into(scratch()));
  ASSERT_TRUE(shown.passes(0.1));
  const std::string file = begun(shown)["file"];
  {
    const FullDisk full(std::filesystem::file_size(file));
    ASSERT_TRUE(shown.comes([&] { return shown.status()["recording"]["running"] == false; }));
  }
  EXPECT_EQ(shown.status()["recording"]["note"], "could not be written in full");
  EXPECT_TRUE(shown.passes(shown.value("time_s") + 0.1)) << "the grasp goes on";
  const std::string second = begun(shown)["file"];
  ended(shown);
  EXPECT_TRUE(read_recording(second).reading.whole);
  shown.end();
  EXPECT_NE(shown.fault().find(file), std::string::npos) << "the program ends with the first file that is not whole";
}

}  // namespace
}  // namespace thenar::window::session_film_test
