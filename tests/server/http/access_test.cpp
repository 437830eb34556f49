#include <gtest/gtest.h>

#include <map>

#include "common/protocol/refusals.h"
#include "common/timeline/deviation.h"
#include "common/timeline/timeline.h"
#include "server/jobs/stored_tooth.h"
#include "server/storage/engine/query.h"
#include "server/storage/store_engine.h"
#include "tests/server/http/running_server.h"

// Access rights: person × route, over the wire.
namespace enamel::server::http {
namespace {

const char* const kLogins[] = {"sam", "sue", "tom", "ada", "ben", "root"};

class AccessTest : public testing::Test {
 protected:
  AccessTest() {
    for (const char* login : kLogins) visitors_.emplace(login, Visitor(server_.port(), login));
  }
  Visitor& By(const std::string& login) { return visitors_.at(login); }
  std::string Scored(const std::string& rest = "") const {
    return "/api/v1/attempts/" + school_.sams_scored.Text() + rest;
  }
  std::vector<std::string> AttemptIds(const std::string& login, const std::string& query = "") {
    RawResponse response = By(login).Get("/api/v1/attempts" + query);
    EXPECT_EQ(response.status, 200) << response.body;
    std::vector<std::string> out;
    boost::json::value body = Parsed(response);
    for (const auto& attempt : body.at("attempts").as_array()) {
      out.emplace_back(attempt.at("id").as_string());
    }
    return out;
  }

  School school_;
  RunningServer server_{school_};
  std::map<std::string, Visitor> visitors_;
};

struct Row {
  const char* what;
  std::string method, target, body;
  std::map<std::string, int> expected;  // by login
};

TEST_F(AccessTest, EveryRoleGetsItsOwnAndNothingElse) {
  const std::string scored = Scored();
  const std::string recording = "/api/v1/attempts/" + school_.sams_recording.Text();
  const std::map<std::string, int> all = {{"sam", 200}, {"sue", 200}, {"tom", 200},
                                          {"ada", 200}, {"ben", 200}, {"root", 200}};
  const std::map<std::string, int> staff = {{"sam", 403}, {"sue", 403}, {"tom", 403},
                                            {"ada", 200}, {"ben", 200}, {"root", 200}};
  const std::map<std::string, int> admin = {{"sam", 403}, {"sue", 403}, {"tom", 403},
                                            {"ada", 403}, {"ben", 403}, {"root", 200}};
  const std::map<std::string, int> hidden = {{"sam", 403}, {"sue", 404}, {"tom", 404},
                                             {"ada", 200}, {"ben", 404}, {"root", 200}};
  const Row rows[] = {
      {"session", "GET", "/api/v1/session", "", all},
      {"exercises", "GET", "/api/v1/exercises", "", all},
      {"profiles", "GET", "/api/v1/profiles", "", all},
      {"attempts", "GET", "/api/v1/attempts", "", all},
      {"exercise of cohort A",
       "GET",
       "/api/v1/exercises/" + school_.exercise.Text(),
       "",
       {{"sam", 200}, {"sue", 200}, {"tom", 200}, {"ada", 200}, {"ben", 200}, {"root", 200}}},
      {"cohorts", "GET", "/api/v1/cohorts", "", staff},
      {"stations", "GET", "/api/v1/stations", "", staff},
      {"audit", "GET", "/api/v1/audit", "", admin},
      {"jobs", "GET", "/api/v1/jobs", "", admin},
      {"attempt",
       "GET",
       scored,
       "",
       {{"sam", 200}, {"sue", 404}, {"tom", 404}, {"ada", 200}, {"ben", 404}, {"root", 200}}},
      {"graded score before release", "GET", scored + "/score", "", hidden},
      {"graded surface before release", "GET", scored + "/surface", "", hidden},
      {"graded series before release", "GET", scored + "/series", "", hidden},
      {"score while recording",
       "GET",
       recording + "/score",
       "",
       {{"sam", 403}, {"sue", 404}, {"tom", 404}, {"ada", 409}, {"ben", 404}, {"root", 409}}},
      {"release while recording",
       "POST",
       recording + "/release",
       "",
       {{"sam", 403}, {"sue", 403}, {"tom", 403}, {"ada", 409}, {"ben", 404}, {"root", 409}}},
      {"mark as reference",
       "POST",
       scored + "/reference",
       R"({"dentist":"Dr. Vega","consent":true,"anyway":"a test"})",
       {{"sam", 403}, {"sue", 403}, {"tom", 403}, {"ada", 201}, {"ben", 404}, {"root", 201}}},
      {"release",
       "POST",
       scored + "/release",
       "",
       {{"sam", 403}, {"sue", 403}, {"tom", 403}, {"ada", 204}, {"ben", 404}, {"root", 204}}},
      {"graded score after release",
       "GET",
       scored + "/score",
       "",
       {{"sam", 200}, {"sue", 404}, {"tom", 404}, {"ada", 200}, {"ben", 404}, {"root", 200}}},
  };
  for (const Row& row : rows) {
    for (const char* login : kLogins) {
      Visitor& visitor = By(login);
      const size_t rest = row.target.find("/release");
      RawResponse response = rest != std::string::npos
                                 ? visitor.Judge(row.method, row.target.substr(0, rest), "/release")
                             : row.method == "GET" ? visitor.Get(row.target)
                                                   : visitor.Post(row.target, row.body);
      EXPECT_EQ(response.status, row.expected.at(login))
          << row.what << " by " << login << ": " << response.body;
    }
  }
}

TEST_F(AccessTest, AnotherStudentsAttemptLooksLikeNone) {
  RawResponse existing = By("sue").Get(Scored());
  RawResponse missing = By("sue").Get("/api/v1/attempts/" + Uuid::New().Text());
  EXPECT_EQ(existing.status, 404);
  EXPECT_EQ(existing.body, missing.body);
}

TEST_F(AccessTest, StudentListsOnlyOwnAttemptsWhateverIsAsked) {
  const std::string toms = school_.toms_scored.Text();
  for (const std::string& query :
       {std::string(), "?person=" + school_.tom.Text(), "?cohort=" + school_.cohort_b.Text(),
        std::string("?limit=200")}) {
    std::vector<std::string> ids = AttemptIds("sam", query);
    EXPECT_EQ(ids.size(), 2u) << query;
    EXPECT_EQ(std::count(ids.begin(), ids.end(), toms), 0) << query;
  }
}

TEST_F(AccessTest, InstructorListsOwnCohortsAndAdminAll) {
  EXPECT_EQ(AttemptIds("ada").size(), 2u);
  EXPECT_EQ(AttemptIds("ada", "?person=" + school_.tom.Text()).size(), 0u);
  EXPECT_EQ(AttemptIds("ben"), std::vector<std::string>{school_.toms_scored.Text()});
  EXPECT_EQ(AttemptIds("root").size(), 3u);
  EXPECT_EQ(AttemptIds("root", "?cohort=" + school_.cohort_b.Text()).size(), 1u);
}

TEST_F(AccessTest, HowTheHandMovedInAnExamIsToldToReviewersAlone) {
  auto& store = *school_.store;
  ASSERT_TRUE(store.engine->rows
                  .Write([&](sql::Db& db) {
                    return Query(db,
                                 "UPDATE attempts SET exam = 1, assignment = ?2 WHERE tenant = ?1")
                        .Bind(Uuid::New())
                        .Run();
                  })
                  .ok());
  auto result = *store.results.ResultOf(school_.sams_scored);
  // The row has the figures: the motion itself is not read, and could not be.
  result.motion = *store.blobs.PutAttemptBlob(school_.sams_scored, AsBytes("no motion"));
  result.hand = {1'500, 250'000, 0, 0};
  ASSERT_TRUE(store.results.FinishAttempt(school_.sams_scored, result, {}).ok());
  const boost::json::value told = Parsed(By("ada").Get(Scored())).at("evidence");
  ASSERT_TRUE(told.is_object());
  EXPECT_EQ(told.at("tremor_um").to_number<double>(), 1.5);
  EXPECT_TRUE(told.at("too_calm").as_bool());
  EXPECT_EQ(told.at("still_percent").to_number<double>(), 25);
  EXPECT_TRUE(told.at("rank").is_null()) << "one attempt is no order";
  EXPECT_EQ(told.at("of").to_number<int>(), 1);
  ASSERT_EQ(By("ada").Judge("POST", Scored(), "/release").status, 204);
  EXPECT_TRUE(Parsed(By("sam").Get(Scored())).at("evidence").is_null());
}

TEST_F(AccessTest, WhyThereIsNoScoreIsToldWithItsField) {
  const Status why(Code::kConflict, "parts at tick 7", protocol::kReplay);
  ASSERT_TRUE(school_.store->results.FailAttempt(school_.sams_scored, why, {}).ok());
  const boost::json::value told = Parsed(By("ada").Get(Scored()));
  EXPECT_EQ(told.at("problem"), "parts at tick 7");
  EXPECT_EQ(told.at("problem_field"), "replay");
}

TEST_F(AccessTest, WhoSignedAtTheChairIsToldToReviewersAlone) {
  const std::string path = "/api/v1/attempts/" + school_.sams_recording.Text();
  EXPECT_TRUE(Parsed(By("ada").Get(path)).at("sign_off").is_null()) << "nobody had to";
  auto& store = *school_.store;
  ASSERT_TRUE(store.engine->rows
                  .Write([&](sql::Db& db) {
                    return Query(db, "UPDATE attempts SET sign_off = 1 WHERE tenant = ?1").Run();
                  })
                  .ok());
  ASSERT_TRUE(
      store.sign_offs.Sign(school_.sams_recording, SignedAt::kEnd, 17, {school_.ada, "test"}).ok());
  const boost::json::value told = Parsed(By("root").Get(path)).at("sign_off");
  EXPECT_TRUE(told.at("start").is_null()) << "not signed";
  EXPECT_EQ(told.at("end").at("by"), "Person ada");
  EXPECT_EQ(told.at("end").at("at_ms").to_number<int>(), 17);
  EXPECT_TRUE(Parsed(By("sam").Get(path)).at("sign_off").is_null());
}

TEST_F(AccessTest, WhoseMotionIsNearIsToldToWhoReviewsBothAlone) {
  auto near = [&](const Uuid& attempt, const Uuid& other) {
    auto result = *school_.store->results.ResultOf(attempt);
    result.motion = *school_.store->blobs.PutAttemptBlob(attempt, AsBytes("motion"));
    result.near = {other, 7, 12, 900, 1400, true};
    ASSERT_TRUE(school_.store->results.FinishAttempt(attempt, result, {}).ok());
  };
  near(school_.sams_scored, school_.toms_scored);
  auto seen = [&](const std::string& login) { return Parsed(By(login).Get(Scored())); };
  const boost::json::value root = seen("root"), ada = seen("ada"), sam = seen("sam");
  EXPECT_EQ(boost::json::serialize(root.at("flags")), R"(["near_another"])");
  EXPECT_EQ(std::string(root.at("nearness").at("attempt_id").as_string()),
            school_.toms_scored.Text());
  EXPECT_EQ(root.at("nearness").at("person").at("display_name"), "Person tom");
  EXPECT_EQ(root.at("nearness").at("nearest_mm").to_number<double>(), 0.012);
  EXPECT_EQ(root.at("nearness").at("others").to_number<int>(), 7);
  // Of tom's cohort she teaches nobody.
  EXPECT_EQ(boost::json::serialize(ada.at("flags")), R"(["near_another"])");
  EXPECT_TRUE(ada.at("nearness").at("attempt_id").is_null());
  EXPECT_TRUE(ada.at("nearness").at("person").is_null());
  EXPECT_EQ(ada.at("nearness").at("median_mm").to_number<double>(), 0.9);
  // The attempt's own student learns nothing, even on request.
  ASSERT_EQ(By("ada").Judge("POST", Scored(), "/release").status, 204);
  EXPECT_TRUE(sam.at("nearness").is_null());
  EXPECT_TRUE(seen("sam").at("nearness").is_null());
  EXPECT_TRUE(seen("sam").at("flags").as_array().empty());
  EXPECT_EQ(By("sam").Get("/api/v1/attempts?flag=near_another").status, 403);
  const boost::json::value listed = Parsed(By("sam").Get("/api/v1/attempts"));
  EXPECT_EQ(boost::json::serialize(listed).find("near_another"), std::string::npos);
  EXPECT_EQ(AttemptIds("ada", "?flag=near_another"),
            std::vector<std::string>{school_.sams_scored.Text()});
  // And of the other, whoever reviews both: sue's and sam's are ada's.
  const Uuid sues = school_.ScoredAttempt(school_.sue);
  near(school_.sams_scored, sues);
  EXPECT_EQ(std::string(seen("ada").at("nearness").at("attempt_id").as_string()), sues.Text());
}

TEST_F(AccessTest, PagesFollowEachOtherWithoutGapOrRepeat) {
  std::vector<std::string> seen;
  std::string query = "?limit=1";
  for (int page = 0; page < 10; ++page) {
    boost::json::value body = Parsed(By("root").Get("/api/v1/attempts" + query));
    for (const auto& attempt : body.at("attempts").as_array()) {
      seen.emplace_back(attempt.at("id").as_string());
    }
    if (body.at("next").is_null()) break;
    query = "?limit=1&before=" + std::string(body.at("next").as_string());
  }
  EXPECT_EQ(seen, AttemptIds("root"));
}

TEST_F(AccessTest, ScoreIsHiddenInListsUntilReleased) {
  auto score = [&](const std::string& login) {
    return Parsed(By(login).Get(Scored())).at("score");
  };
  EXPECT_TRUE(score("sam").is_null());
  EXPECT_EQ(score("ada").to_number<double>(), 87.5);
  EXPECT_EQ(By("ada").Judge("POST", Scored(), "/release").status, 204);
  EXPECT_EQ(score("sam").to_number<double>(), 87.5);
  EXPECT_EQ(Parsed(By("sam").Get(Scored())).at("released"), true);
}

TEST_F(AccessTest, AttemptCarriesTheNamesOfWhatItPointsTo) {
  boost::json::value attempt = Parsed(By("ada").Get(Scored()));
  EXPECT_EQ(attempt.at("person").at("display_name"), "Person sam");
  EXPECT_EQ(attempt.at("exercise").at("title"), "Occlusal cavity");
  EXPECT_EQ(attempt.at("station").at("name"), "bench-1");
  EXPECT_EQ(attempt.at("profile").at("name"), "phantom_desktop");
  EXPECT_EQ(attempt.at("state"), "scored");
  EXPECT_TRUE(attempt.at("reference").is_null());
}

TEST_F(AccessTest, ASpanOfTicksIsGivenOrRefusedWithTheFieldAtFault) {
  boost::json::value some = Parsed(By("ada").Get(Scored("/ticks?from=990&to=1010")));
  EXPECT_EQ(some.at("time_ticks").as_array().size(), 10u) << "the recording has a thousand";
  EXPECT_EQ(Parsed(By("ada").Get(Scored("/ticks"))).at("to"), 4000);
  for (const auto& [query, field] : {std::pair{"?from=-1", "from"},
                                     {"?to=x", "to"},
                                     {"?from=9&to=9", "to"},
                                     {"?to=4001", "to"},
                                     {"?from=18446744073709551615", "to"}}) {
    RawResponse refused = By("ada").Get(Scored(std::string("/ticks") + query));
    EXPECT_EQ(refused.status, 400) << query;
    EXPECT_EQ(Parsed(refused).at("error").at("field"), field) << query;
  }
}

TEST_F(AccessTest, ReferenceShowsAtTheExerciseAndTheAttempt) {
  // Its tooth is not one, so nobody can judge whether it did the task.
  RawResponse refused =
      By("ada").Post(Scored("/reference"), R"({"dentist":"Dr. Vega","consent":true})");
  EXPECT_EQ(refused.status, 409) << refused.body;
  EXPECT_EQ(Parsed(refused).at("error").at("field"), "anyway");
  RawResponse made = By("ada").Post(
      Scored("/reference"), R"({"dentist":"Dr. Vega","consent":true,"anyway":"seen by two"})");
  ASSERT_EQ(made.status, 201) << made.body;
  EXPECT_NE(school_.store->audit.FindAudit({.action = "reference.add"})
                ->front()
                .after_json.find("seen by two"),
            std::string::npos);
  EXPECT_EQ(Parsed(made).at("dentist"), "Dr. Vega");
  EXPECT_EQ(Parsed(By("ada").Get(Scored())).at("is_reference"), true);
  boost::json::value exercise =
      Parsed(By("sam").Get("/api/v1/exercises/" + school_.exercise.Text()));
  EXPECT_EQ(exercise.at("has_reference"), true);
  EXPECT_EQ(exercise.at("my_attempts"), 2);
  EXPECT_EQ(exercise.at("burs").at(0).at("shape"), "cylinder");
  EXPECT_EQ(exercise.at("target").at("depth_um"), 2000);
  const boost::json::value& rubric = exercise.at("rubric");
  EXPECT_EQ(rubric.at("criteria").at(0).at("metric"), "time_s");
  EXPECT_EQ(rubric.at("prices").at(0).at("of"), "wall");
  EXPECT_EQ(rubric.at("prices").at(0).at("unit"), "mm");
  EXPECT_EQ(rubric.at("prices").at(0).at("left").to_number<double>(), 0.6);
  EXPECT_EQ(By("ada").Post(Scored("/reference"), R"({"dentist":"","consent":true})").status, 400);
}

TEST_F(AccessTest, ReferenceIsRefusedUnlessTheDentistIsSaidToAgree) {
  RawResponse unsaid = By("ada").Post(Scored("/reference"), R"({"dentist":"Dr. Vega"})");
  EXPECT_EQ(unsaid.status, 400) << unsaid.body;
  EXPECT_EQ(Parsed(unsaid).at("error").at("field"), "consent");
  RawResponse refused =
      By("ada").Post(Scored("/reference"), R"({"dentist":"Dr. Vega","consent":false})");
  EXPECT_EQ(refused.status, 409) << refused.body;
  EXPECT_EQ(Parsed(refused).at("error").at("field"), "consent");
  EXPECT_EQ(Parsed(By("ada").Get(Scored())).at("is_reference"), false);
}

TEST_F(AccessTest, SurfaceIsMadeOfToothAndDeviation) {
  RawResponse surface = By("ada").Get(Scored("/surface"));
  EXPECT_EQ(surface.headers["content-type"], "application/octet-stream");
  const auto made =
      AttemptSurface(school_.store->blobs, *school_.store->results.ResultOf(school_.sams_scored));
  ASSERT_TRUE(made.ok()) << made.status().message();
  EXPECT_EQ(surface.body, AsText(*made));
  EXPECT_EQ(surface.body.substr(0, 4), "ENTM");
  EXPECT_EQ(
      By("ada")
          .Send("GET", Scored("/surface"), "If-None-Match: " + surface.headers["etag"] + "\r\n")
          .status,
      304);
}

TEST_F(AccessTest, DeviationIsServedAsTheScoreLeftIt) {
  RawResponse found = By("ada").Get(Scored("/deviation"));
  ASSERT_EQ(found.status, 200) << found.body;
  EXPECT_EQ(found.headers["cache-control"], "private, no-cache, no-transform");
  EXPECT_EQ(
      By("ada")
          .Send("GET", Scored("/deviation"), "If-None-Match: " + found.headers["etag"] + "\r\n")
          .status,
      304);
  auto deviation = timeline::DecodeDeviation(AsBytes(found.body));
  ASSERT_TRUE(deviation.ok()) << deviation.status().message();
  ASSERT_EQ(deviation->cells.size(), 1u);
  EXPECT_EQ(deviation->cells[0].cell, kComparedCell);
  EXPECT_EQ(deviation->cells[0].deviation_um, 300);
}

TEST_F(AccessTest, TimelineIsToldToBeInTheMakingAndThenServedInRanges) {
  RawResponse waits = By("ada").Get(Scored("/timeline"));
  EXPECT_EQ(waits.status, 503) << waits.body;
  EXPECT_NE(waits.body.find("is being made"), std::string::npos) << waits.body;
  Store& store = *school_.store;
  const Uuid attempt = school_.sams_scored;
  const Sha256 content = *store.blobs.PutAttemptBlob(attempt, AsBytes("ENTT and more"));
  ASSERT_TRUE(store.timelines.PutTimeline(attempt, content).ok());
  RawResponse all = By("ada").Get(Scored("/timeline"));
  EXPECT_EQ(all.status, 200);
  EXPECT_EQ(all.body, "ENTT and more");
  // Kept by the browser, and asked for each time: whoever has it gets nothing but that it is so.
  EXPECT_EQ(all.headers["cache-control"], "private, no-cache, no-transform");
  const std::string same = "If-None-Match: " + all.headers["etag"] + "\r\n";
  RawResponse again = By("ada").Send("GET", Scored("/timeline"), same);
  EXPECT_EQ(again.status, 304);
  EXPECT_EQ(again.body, "");
  EXPECT_NE(By("sue").Send("GET", Scored("/timeline"), same).status, 304) << "may not see it";
  RawResponse series = By("ada").Get(Scored("/series"));
  EXPECT_EQ(series.headers["cache-control"], "private, no-cache");
  EXPECT_EQ(By("ada")
                .Send("GET", Scored("/series"), "If-None-Match: " + series.headers["etag"] + "\r\n")
                .status,
            304);
  RawResponse part = By("ada").Send("GET", Scored("/timeline"), "Range: bytes=5-7\r\n");
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(part.body, "and");
  EXPECT_EQ(part.headers["content-range"], "bytes 5-7/13");
}

TEST_F(AccessTest, ATimelineThatCouldNotBeMadeSaysWhy) {
  // Only a process that took one may say that it could not make it.
  Store& store = *school_.store;
  auto taken = store.timelines.TakeTimeline();
  while (taken.ok() && *taken && **taken != school_.sams_scored)
    taken = store.timelines.TakeTimeline();
  ASSERT_TRUE(taken.ok() && *taken) << taken.status().message();
  ASSERT_TRUE(
      store.timelines.FailTimeline(school_.sams_scored, "replay and recording part", false).ok());
  RawResponse none = By("ada").Get(Scored("/timeline"));
  EXPECT_EQ(none.status, 404) << none.body;
  EXPECT_NE(none.body.find("replay and recording part"), std::string::npos) << none.body;
}

TEST_F(AccessTest, AStartToothIsKeptForEverAndNoOtherBlobIsOne) {
  Store& store = *school_.store;
  const Sha256 tooth = *store.blobs.PutBlob(AsBytes("ENTS")),
               other = *store.blobs.PutBlob(AsBytes("secret"));
  ASSERT_TRUE(store.timelines.PutStartTooth(*store.blobs.PutBlob(AsBytes("volume")), tooth).ok());
  RawResponse found = By("sam").Get("/api/v1/start-teeth/" + tooth.Hex());
  EXPECT_EQ(found.body, "ENTS");
  EXPECT_EQ(found.headers["cache-control"], "private, max-age=31536000, immutable, no-transform");
  RawResponse again = By("sam").Send("GET", "/api/v1/start-teeth/" + tooth.Hex(),
                                     "If-None-Match: " + found.headers["etag"] + "\r\n");
  EXPECT_EQ(again.status, 304);
  EXPECT_EQ(again.body, "");
  EXPECT_EQ(By("sam").Get("/api/v1/start-teeth/" + other.Hex()).status, 404);
  EXPECT_EQ(By("sam").Get("/api/v1/start-teeth/short").status, 404);
}

TEST_F(AccessTest, ProfilesNameTheSourceOfEveryNumber) {
  boost::json::value body = Parsed(By("sam").Get("/api/v1/profiles"));
  const auto& profile = body.at("profiles").as_array().at(0);
  ASSERT_EQ(profile.at("numbers").as_array().size(), 13u);
  for (const auto& number : profile.at("numbers").as_array()) {
    EXPECT_EQ(number.at("source"), "assumption");
  }
}

TEST_F(AccessTest, MalformedQueriesNameTheField) {
  for (const char* field : {"person", "cohort", "exercise", "before", "limit"}) {
    RawResponse response = By("root").Get(std::string("/api/v1/attempts?") + field + "=x");
    EXPECT_EQ(response.status, 400) << field;
    EXPECT_EQ(Parsed(response).at("error").at("field"), field);
  }
  EXPECT_EQ(By("root").Get("/api/v1/attempts?limit=201").status, 400);
  EXPECT_EQ(By("root").Get("/api/v1/jobs?state=lost").status, 400);
  EXPECT_EQ(By("root").Get("/api/v1/attempts/not-a-uuid").status, 400);
}

TEST_F(AccessTest, ReleaseIsAudited) {
  By("ada").Judge("POST", Scored(), "/release");
  boost::json::value body = Parsed(By("root").Get("/api/v1/audit?limit=1"));
  const auto& entry = body.at("audit").as_array().at(0);
  EXPECT_EQ(entry.at("action"), "attempt.release");
  EXPECT_EQ(entry.at("object"), school_.sams_scored.Text().c_str());
}

}  // namespace
}  // namespace enamel::server::http
