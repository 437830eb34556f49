#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

#include "common/scene/json/json.h"
#include "common/scoring/score.h"
#include "tests/server/http/running_server.h"

// Blind marking over the wire: nobody who marks sees a name or a computed score before all are done.
namespace enamel::server::http {
namespace {

namespace json = boost::json;

class MarkingTest : public testing::Test {
 protected:
  MarkingTest() {
    for (const char* login : {"ada", "ben", "root", "sam", "sue"}) {
      visitors_.emplace(login, Visitor(server_.port(), login));
    }
    AssignmentRow row;
    row.exercise = "class-1-occlusal";
    row.cohort = school_.cohort_a;
    assignment_ = school_.store->assignments.AddAssignment(row, kBy)->id;
    for (int i = 0; i < 9; ++i) {
      attempts_.push_back(school_.ScoredAttempt(
          i % 2 == 0 ? school_.sam : school_.sue,
          [&](AttemptRow& attempt) { attempt.assignment = assignment_; },
          [&](scoring::ScoreResult& result) { result.score = kScore0 + 7.5 * i; }));
    }
  }

  Visitor& By(const std::string& login) { return visitors_.at(login); }
  std::string OfAssignment(const std::string& rest) const {
    return "/api/v1/assignments/" + assignment_.Text() + rest;
  }
  std::string Markers(const std::vector<Uuid>& ids) const {
    json::array list;
    for (const Uuid& id : ids) list.emplace_back(id.Text());
    return json::serialize(json::object{{"marker_ids", std::move(list)}});
  }
  std::string Begin() {
    RawResponse answer =
        By("ada").Post(OfAssignment("/markings"), Markers({school_.ada, school_.ben}));
    EXPECT_EQ(answer.status, 201) << answer.body;
    return std::string(Parsed(answer).at("id").as_string());
  }
  json::object Seen(const std::string& login, const std::string& marking) {
    RawResponse answer = By(login).Get("/api/v1/markings/" + marking);
    EXPECT_EQ(answer.status, 200) << answer.body;
    return Parsed(answer).as_object();
  }
  std::vector<std::string> WorksOf(const std::string& login, const std::string& marking) {
    std::vector<std::string> out;
    const json::object seen = Seen(login, marking);
    for (const json::value& work : seen.at("mine").as_array()) {
      out.emplace_back(work.at("id").as_string());
    }
    return out;
  }
  RawResponse Mark(const std::string& login, const std::string& work, const std::string& body) {
    return By(login).Post("/api/v1/marking-works/" + work + "/marks", body);
  }
  static std::string Body(int rating, double points, const std::string& comment = "") {
    return json::serialize(json::object{{"rating", rating},
                                        {"criteria",
                                         {{"outline", {{"points", points}, {"comment", comment}}},
                                          {"internal_form", {{"points", points}}}}}});
  }
  void MarkAllBy(const std::string& login, const std::string& marking) {
    const auto works = WorksOf("ada", marking);
    for (size_t i = 0; i < works.size(); ++i) {
      const int rating = 1 + static_cast<int>(i % 5);
      EXPECT_EQ(Mark(login, works[i], Body(rating, 3.0 * rating, "wall out")).status, 204);
    }
  }
  void MarkAll(const std::string& marking) {
    for (const char* login : {"ada", "ben"}) MarkAllBy(login, marking);
  }

  inline static const Actor kBy{{}, "test"};
  static constexpr double kScore0 = 31.25;
  School school_;
  RunningServer server_{school_};
  std::map<std::string, Visitor> visitors_;
  Uuid assignment_;
  std::vector<Uuid> attempts_;
};

TEST_F(MarkingTest, AMarkerSeesNeitherNamesNorAttemptsNorScores) {
  const std::string marking = Begin();
  for (const char* login : {"ada", "ben"}) {
    const std::string told = json::serialize(Seen(login, marking));
    EXPECT_EQ(told.find("Person s"), std::string::npos) << told;
    EXPECT_EQ(told.find("31.25"), std::string::npos);
    for (const Uuid& attempt : attempts_) {
      EXPECT_EQ(told.find(attempt.Text()), std::string::npos);
    }
    EXPECT_EQ(WorksOf(login, marking).size(), attempts_.size());
  }
  EXPECT_EQ(By("sam").Get("/api/v1/markings/" + marking).status, 403);
  EXPECT_EQ(By("sam").Get(OfAssignment("/markings")).status, 403);
}

TEST_F(MarkingTest, EachMarkerHasAnOrderOfTheirOwn) {
  const std::string marking = Begin();
  const auto first = WorksOf("ada", marking), second = WorksOf("ben", marking);
  EXPECT_NE(first, second);
  EXPECT_EQ(first, WorksOf("ada", marking)) << "and it stays";
  EXPECT_TRUE(std::ranges::is_permutation(first, second));
}

TEST_F(MarkingTest, AMarkersOtherPagesHideTheScoresUntilAllAreDone) {
  const std::string attempt = "/api/v1/attempts/" + attempts_[0].Text();
  EXPECT_FALSE(Parsed(By("ada").Get(attempt)).at("score").is_null());
  const std::string marking = Begin();
  EXPECT_EQ(By("ada").Get(OfAssignment("/insight")).status, 403);
  const RawResponse grades =
      By("ada").Get("/api/v1/cohorts/" + school_.cohort_a.Text() + "/grades");
  EXPECT_EQ(grades.body.find("91.25"), std::string::npos) << grades.body;
  EXPECT_FALSE(Parsed(By("root").Get(attempt)).at("score").is_null()) << "who marks nothing";
  MarkAllBy("ada", marking);
  EXPECT_TRUE(Parsed(By("ada").Get(attempt)).at("score").is_null());
  for (const char* part : {"/score", "/surface", "/series", "/results"}) {
    EXPECT_EQ(By("ada").Get(attempt + part).status, 403) << part;
  }
  MarkAllBy("ben", marking);
  EXPECT_FALSE(Parsed(By("ada").Get(attempt)).at("score").is_null());
  EXPECT_EQ(By("ada").Get(attempt + "/score").status, 200);
}

// A teacher of the class could look up whose tooth it is.
TEST_F(MarkingTest, AMarkerOpensNoAttemptByNameUntilTheOwnMarksAreIn) {
  const std::string attempt = "/api/v1/attempts/" + attempts_[0].Text();
  EXPECT_NE(By("ada").Get(attempt + "/timeline").status, 403);
  const std::string marking = Begin();
  for (const char* part : {"", "/timeline", "/ticks", "/annotations", "/score", "/surface"}) {
    const RawResponse answer = By("ada").Get(attempt + part);
    EXPECT_EQ(answer.status, 403) << part;
    EXPECT_NE(answer.body.find("you mark this attempt blind"), std::string::npos) << answer.body;
  }
  EXPECT_EQ(By("sam").Get(attempt).status, 200) << "whose it is";
  EXPECT_EQ(By("root").Get(attempt).status, 200) << "who marks nothing";
  MarkAllBy("ben", marking);
  EXPECT_EQ(By("ada").Get(attempt).status, 403) << "whose own marks are missing";
  MarkAllBy("ada", marking);
  EXPECT_EQ(By("ada").Get(attempt).status, 200);
}

TEST_F(MarkingTest, AfterTheLastMarkEverybodysMarksAreBesideTheProgramsPoints) {
  const std::string marking = Begin();
  EXPECT_TRUE(Seen("ada", marking).at("results").is_null());
  MarkAll(marking);
  const json::object seen = Seen("ada", marking);
  EXPECT_EQ(seen.at("done"), true);
  EXPECT_EQ(seen.at("exercise").at("title").as_string(), "Occlusal cavity");
  const json::value& results = seen.at("results");
  ASSERT_EQ(results.at("works").as_array().size(), attempts_.size());
  for (const json::value& work : results.at("works").as_array()) {
    EXPECT_EQ(work.at("marks").as_array().size(), 2U);
    EXPECT_FALSE(work.at("computed_score").is_null());
  }
  EXPECT_NEAR(results.at("standard").at("icc_2_1").at("value").as_double(), 1, 1e-9)
      << "both gave the same";
  EXPECT_FALSE(results.at("agreement").as_array().empty());
  EXPECT_EQ(seen.at("comments").at(0).at("comment"), "wall out") << "said once, offered again";
  EXPECT_EQ(seen.at("comments").as_array().size(), 1U);
}

TEST_F(MarkingTest, MarksThatAreNoneOrTwiceOrOfOthersWorkAreRefused) {
  const std::string marking = Begin();
  const std::string work = WorksOf("ada", marking)[0];
  EXPECT_EQ(
      Mark("ada", work, R"({"criteria":{"outline":{"points":5},"internal_form":{"points":5}}})")
          .status,
      400)
      << "the rating comes first";
  EXPECT_EQ(Mark("ada", work, Body(6, 5)).status, 400);
  EXPECT_EQ(Mark("ada", work, Body(3, 51)).status, 400) << "of 50";
  EXPECT_EQ(Mark("ada", work, R"({"rating":3,"criteria":{}})").status, 400);
  EXPECT_EQ(Mark("ada", work,
                 R"({"rating":3,"criteria":{"outline":{"points":5},"internal_form":{"points":5},)"
                 R"("time_s":{"points":1}}})")
                .status,
            400);
  EXPECT_EQ(Mark("root", work, Body(3, 5)).status, 404) << "not a marker";
  EXPECT_EQ(Mark("ada", attempts_[0].Text(), Body(3, 5)).status, 404) << "an attempt's id";
  EXPECT_EQ(Mark("ada", work, Body(3, 5)).status, 204);
  EXPECT_EQ(Mark("ada", work, Body(4, 6)).status, 409) << "twice";
  EXPECT_EQ(Mark("ben", work, Body(4, 6)).status, 204);
}

TEST_F(MarkingTest, AnotherMayMarkInSomebodysPlace) {
  const std::string marking = Begin();
  const std::string path = "/api/v1/markings/" + marking + "/markers";
  const auto set = [&](const std::string& login, const std::vector<Uuid>& ids) {
    return By(login).Send(
        "PUT", path, "X-Enamel-Csrf: " + By(login).csrf + "\r\nContent-Type: application/json\r\n",
        Markers(ids));
  };
  ASSERT_EQ(Mark("ben", WorksOf("ben", marking)[0], Body(1, 1)).status, 204);
  EXPECT_EQ(set("ben", {school_.ada, school_.root}).status, 403) << "a marker of another cohort";
  EXPECT_EQ(set("ada", {school_.ada}).status, 400) << "two at least";
  EXPECT_EQ(set("ada", {school_.ada, school_.sam}).status, 400) << "a student";
  RawResponse changed = set("ada", {school_.ada, school_.root});
  ASSERT_EQ(changed.status, 200) << changed.body;
  EXPECT_EQ(Parsed(changed).at("markers").as_array().size(), 2u);
  EXPECT_EQ(By("ben").Get("/api/v1/markings/" + marking).status, 404);
  EXPECT_EQ(set("ada", {school_.ada, school_.ben}).status, 409)
      << "who was left out may have seen scores since";
  MarkAllBy("ada", marking);
  EXPECT_EQ(Seen("ada", marking).at("done"), false);
  MarkAllBy("root", marking);
  const json::object seen = Seen("ada", marking);
  ASSERT_EQ(seen.at("done"), true);
  for (const json::value& work : seen.at("results").at("works").as_array()) {
    EXPECT_EQ(work.at("marks").as_array().size(), 2u) << "without the one that ben gave";
  }
  EXPECT_EQ(set("ada", {school_.ada, school_.root}).status, 409) << "it is over";
}

// A list says who made an attempt and how long it is, and so is the tooth that a marker looks at.
TEST_F(MarkingTest, AMarkersListsLeaveOutWhatIsToBeMarked) {
  auto listed = [&](const std::string& login, const std::string& query) {
    const RawResponse answer = By(login).Get("/api/v1/attempts?limit=200" + query);
    EXPECT_EQ(answer.status, 200) << answer.body;
    return Parsed(answer).at("attempts").as_array().size();
  };
  const std::string of_assignment = "&assignment=" + assignment_.Text();
  const size_t all = listed("ada", ""), works = attempts_.size();
  ASSERT_GT(all, works);
  const std::string marking = Begin();
  EXPECT_EQ(listed("ada", ""), all - works);
  EXPECT_EQ(listed("ada", of_assignment), 0U);
  EXPECT_EQ(listed("ada", of_assignment + "&person=" + school_.sue.Text()), 0U);
  EXPECT_EQ(listed("root", of_assignment), works) << "who marks nothing";
  EXPECT_EQ(listed("sue", of_assignment), works / 2) << "whose they are";
  MarkAllBy("ben", marking);
  EXPECT_EQ(listed("ada", of_assignment), 0U) << "whose own marks are missing";
  MarkAllBy("ada", marking);
  EXPECT_EQ(listed("ada", of_assignment), works);
}

// A released score is known, and no mark of it would be blind: the marking would never be done.
TEST_F(MarkingTest, WhatIsBeingMarkedIsNotReleased) {
  const std::string marking = Begin();
  const auto refused = school_.store->judging.ReleaseAttempt(attempts_[0], kBy);
  EXPECT_EQ(refused.code(), Code::kConflict);
  EXPECT_NE(refused.message().find("give the marking up"), std::string::npos);
  const RawResponse answer = By("root").Post(OfAssignment("/release"), "");
  EXPECT_EQ(answer.status, 409) << answer.body;
  EXPECT_NE(answer.body.find("give the marking up"), std::string::npos);
  EXPECT_FALSE(school_.store->attempts.AttemptById(attempts_[1])->released);
  MarkAll(marking);
  EXPECT_EQ(By("root").Post(OfAssignment("/release"), "").status, 200);
  EXPECT_TRUE(school_.store->attempts.AttemptById(attempts_[0])->released);
}

TEST_F(MarkingTest, WhatIsGivenUpIsMarkedNoMoreAndMayBeReleased) {
  const std::string marking = Begin();
  const auto works = WorksOf("ada", marking);
  const std::string path = "/api/v1/markings/" + marking;
  const std::string csrf = "X-Enamel-Csrf: " + By("ada").csrf + "\r\n";
  EXPECT_EQ(By("ada").Send("DELETE", path, csrf).status, 204);
  EXPECT_EQ(By("ada").Send("DELETE", path, csrf).status, 409) << "given up before";
  const RawResponse late = Mark("ada", works[0], Body(3, 5));
  EXPECT_EQ(late.status, 409);
  EXPECT_EQ(Parsed(late).at("error").at("field"), "marking_given_up");
  for (const Uuid& attempt : attempts_) {
    ASSERT_TRUE(school_.store->judging.ReleaseAttempt(attempt, kBy).ok());
  }
  EXPECT_FALSE(
      Parsed(By("ada").Get("/api/v1/attempts/" + attempts_[0].Text())).at("score").is_null());
  const RawResponse listed = By("ada").Get("/api/v1/attempts?assignment=" + assignment_.Text());
  EXPECT_EQ(Parsed(listed).at("attempts").as_array().size(), attempts_.size());
  EXPECT_EQ(By("ada").Post(OfAssignment("/markings"), Markers({school_.ada, school_.ben})).status,
            409)
      << "nothing is left to mark blind";
}

TEST_F(MarkingTest, MarkersAndWorkThatCannotBeAreRefused) {
  const std::string path = OfAssignment("/markings");
  EXPECT_EQ(By("ada").Post(path, Markers({school_.ada})).status, 400) << "one alone";
  EXPECT_EQ(By("ada").Post(path, Markers({school_.ada, school_.ada})).status, 400);
  EXPECT_EQ(By("ada").Post(path, Markers({school_.ada, school_.sam})).status, 400) << "a student";
  EXPECT_EQ(By("ben").Post(path, Markers({school_.ada, school_.ben})).status, 404);
  Begin();
  const RawResponse second = By("ada").Post(path, Markers({school_.ada, school_.ben}));
  EXPECT_EQ(second.status, 409) << "under way";
  EXPECT_EQ(Parsed(second).at("error").at("field"), "marking_under_way");
}

// A tooth shows neither how hard nor how long it was cut.
TEST_F(MarkingTest, TheGroupsOfTheRubricAreMarkedAndTheHandIsNot) {
  const ExerciseRow exercise = *school_.store->exercises.ExerciseById(school_.exercise);
  const Bytes text = *school_.store->blobs.GetBlob(exercise.content);
  ASSERT_FALSE(scene::ExerciseFromJson(AsText(text))->rubric.criteria.empty());
  const json::object seen = Seen("ada", Begin());
  const json::array& groups = seen.at("criteria").as_array();
  ASSERT_EQ(groups.size(), 2U);
  EXPECT_EQ(groups[0].at("name"), "outline");
  EXPECT_EQ(groups[0].at("title"), "Outline");
  EXPECT_EQ(groups[0].at("max_points").to_number<double>(), 50);
  EXPECT_EQ(groups[1].at("name"), "internal_form");
}

}  // namespace
}  // namespace enamel::server::http
