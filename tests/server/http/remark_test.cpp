#include <gtest/gtest.h>

#include "tests/server/http/running_server.h"

// What an instructor says at the chair of an attempt that is being made.
namespace enamel::server::http {
namespace {

namespace json = boost::json;

class RemarkTest : public testing::Test {
 protected:
  RemarkTest() {
    options_.live = &live_;
    options_.stations = &stations_;
  }

  static std::string Path(const Uuid& attempt) {
    return "/api/v1/live/" + attempt.Text() + "/remarks";
  }
  RawResponse Say(const std::string& login, const Uuid& attempt, const std::string& text) {
    return Visitor(server().port(), login)
        .Post(Path(attempt), json::serialize(json::object{{"text", text}}));
  }
  json::value Heard(const Uuid& attempt) {
    return Parsed(Visitor(server().port(), "ada").Get(Path(attempt)));
  }
  RunningServer& server() {
    if (!server_) server_ = std::make_unique<RunningServer>(school_, options_);
    return *server_;
  }

  School school_;
  LiveBoard live_;
  StationBoard stations_;
  HttpOptions options_;
  std::unique_ptr<RunningServer> server_;
};

TEST_F(RemarkTest, RemarkGoesToTheChairAndStaysOnTheAttempt) {
  const Uuid& attempt = school_.sams_recording;
  auto chair = stations_.Enter(school_.station, true);
  LiveSample now;
  now.attempt = attempt;
  now.tick = 72'000;
  live_.Put(now);
  const RawResponse said = Say("ada", attempt, " 请停一下。\nStop. ");
  ASSERT_EQ(said.status, 201) << said.body;
  EXPECT_EQ(Parsed(said).at("state").as_string(), "waiting");
  EXPECT_EQ(Parsed(said).at("tick").as_int64(), 72'000);

  auto taken = stations_.remarks().Take(attempt);
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_EQ(taken[0].text, "请停一下。 Stop.");
  EXPECT_EQ(taken[0].from, school_.store->people.PersonById(school_.ada)->display_name);
  EXPECT_EQ(Heard(attempt).at("remarks").at(0).at("state").as_string(), "sent");
  stations_.remarks().Shown(attempt, taken[0].id, 99);
  EXPECT_EQ(Heard(attempt).at("remarks").at(0).at("state").as_string(), "shown");
  EXPECT_EQ(Heard(attempt).at("remarks").at(0).at("shown_ms").as_int64(), 99);

  auto kept = *school_.store->remarks.AnnotationsOf(attempt);
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].text, "请停一下。 Stop.");
  EXPECT_EQ(kept[0].tick, 72'000u);
  EXPECT_EQ(kept[0].author, school_.ada);
  EXPECT_TRUE(kept[0].to_chair);
  const json::value listed = Parsed(
      Visitor(server().port(), "ada").Get("/api/v1/attempts/" + attempt.Text() + "/annotations"));
  EXPECT_EQ(listed.at("annotations").at(0).at("to_chair"), true);
  AuditFilter spoken;
  spoken.action = "attempt.speak";
  auto rows = *school_.store->audit.FindAudit(spoken);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].object, attempt.Text());
  EXPECT_NE(rows[0].after_json.find(kept[0].id.Text()), std::string::npos);
  EXPECT_EQ(rows[0].after_json.find("Stop"), std::string::npos)
      << "erasing words happens in the annotation's rows alone";
}

TEST_F(RemarkTest, NothingIsSaidWhereNobodyWouldSeeIt) {
  const Uuid& attempt = school_.sams_recording;
  const RawResponse away = Say("ada", attempt, "stop");
  EXPECT_EQ(away.status, 409) << away.body;
  EXPECT_EQ(Heard(attempt).at("station").at("connected").as_bool(), false);
  auto older = stations_.Enter(school_.station, false);
  const RawResponse old = Say("ada", attempt, "stop");
  EXPECT_EQ(old.status, 409) << old.body;
  EXPECT_NE(old.body.find("older"), std::string::npos) << old.body;
  EXPECT_EQ(Heard(attempt).at("station").at("connected").as_bool(), true);
  EXPECT_EQ(Heard(attempt).at("station").at("shows_remarks").as_bool(), false);
  auto newer = stations_.Enter(school_.station, true);
  const RawResponse over = Say("ada", school_.sams_scored, "stop");
  EXPECT_EQ(over.status, 409) << over.body;
  EXPECT_TRUE(school_.store->remarks.AnnotationsOf(attempt)->empty());
  EXPECT_TRUE(school_.store->remarks.AnnotationsOf(school_.sams_scored)->empty());
}

TEST_F(RemarkTest, InAnExamOnlyWhoTeachesItsPersonSpeaks) {
  auto chair = stations_.Enter(school_.station, true);
  const Uuid exam = school_.RecordingAttempt(school_.sam, [](AttemptRow& row) { row.exam = true; });
  EXPECT_EQ(Say("root", exam, "stop").status, 403);
  EXPECT_EQ(Say("ben", exam, "stop").status, 404);
  EXPECT_EQ(Say("ada", exam, "stop").status, 201);
  const json::value seen = Parsed(Visitor(server().port(), "root").Get(Path(exam)));
  EXPECT_EQ(seen.at("allowed").as_bool(), false);
  EXPECT_EQ(Heard(exam).at("allowed").as_bool(), true);
}

TEST_F(RemarkTest, TextIsBoundedAndChairsAreNotFlooded) {
  auto chair = stations_.Enter(school_.station, true);
  const Uuid& attempt = school_.sams_recording;
  EXPECT_EQ(Say("ada", attempt, "").status, 400);
  EXPECT_EQ(Say("ada", attempt, "  \n").status, 400);
  EXPECT_EQ(Say("ada", attempt, std::string(501, 'x')).status, 400);
  EXPECT_EQ(Say("ada", attempt, "a\xe2\x80\xae").status, 400);
  Visitor ada(server().port(), "ada");
  const std::string stop = R"({"text":"stop"})";
  int status = 201, sent = 0;
  while (status == 201 && sent < 100) {
    status = ada.Post(Path(attempt), stop).status;
    if (status != 201) break;
    ++sent;
    // As a station does that shows them as they come.
    auto taken = stations_.remarks().Take(attempt);
    stations_.remarks().Shown(attempt, taken.back().id, 1);
  }
  EXPECT_EQ(status, 429);
  EXPECT_EQ(sent, static_cast<int>(RemarkBoard::kMaxAMinute));
}

TEST_F(RemarkTest, StationListSaysWhenItWasHeardLast) {
  auto chair = stations_.Enter(school_.station, true);
  const UnixMs stored = school_.store->stations.StationById(school_.station)->last_seen_ms;
  chair->Heard(stored + 12'345);
  const json::value row =
      Parsed(Visitor(server().port(), "ada").Get("/api/v1/stations/" + school_.station.Text()));
  EXPECT_EQ(row.at("last_seen_ms").as_int64(), stored + 12'345);
}

}  // namespace
}  // namespace enamel::server::http
