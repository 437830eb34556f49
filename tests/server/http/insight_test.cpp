#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "common/scoring/score.h"
#include "tests/server/http/running_server.h"

// How a class did under an assignment, over the wire.
namespace enamel::server::http {
namespace {

namespace json = boost::json;

class AssignmentInsightTest : public testing::Test {
 protected:
  AssignmentInsightTest() {
    for (const char* login : {"ada", "ben", "root"}) {
      visitors_.emplace(login, Visitor(server_.port(), login));
    }
    AssignmentRow row;
    row.exercise = "class-1-occlusal";
    row.cohort = school_.cohort_a;
    assignment_ = school_.store->assignments.AddAssignment(row, kBy)->id;
  }
  // An attempt of 1000 ticks at 1 kHz that lost these points by a mesial wall.
  Uuid Made(const Uuid& person, double lost, double score, bool under = true) {
    ++school_.now_ms;
    const Uuid id = school_.ScoredAttempt(
        person,
        [&](AttemptRow& row) {
          if (under) row.assignment = assignment_;
          row.rate_hz = 1000;
        },
        [&](scoring::ScoreResult& result) {
          result.score = score;
          scoring::CriterionResult outline;
          outline.name = "outline";
          outline.group = scoring::Group::kOutline;
          outline.title = "Outline";
          outline.lost = lost;
          outline.state = scoring::State::kModify;
          scoring::CriterionResult force;
          force.name = "force_sent_p95_n";
          force.title = "Light hand";
          force.unit = "N";
          force.value = 0.3;
          force.judged = true;
          result.criteria = {outline, force};
          scoring::Mistake wall;
          wall.kind = scoring::MistakeKind::kOverExtended;
          wall.place = "wall_mesial";
          wall.size = 0.4;
          wall.points = lost;
          wall.at_m = {2e-3, 0, -1e-3};
          result.mistakes = {wall};
        });
    return id;
  }
  json::object Insight(const std::string& login, const std::string& query = "") {
    RawResponse answer = Answer(login, query);
    EXPECT_EQ(answer.status, 200) << answer.body;
    return Parsed(answer).as_object();
  }
  RawResponse Answer(const std::string& login, const std::string& query = "") {
    return visitors_.at(login).Get("/api/v1/assignments/" + assignment_.Text() + "/insight" +
                                   query);
  }
  static const json::value& Row(const json::object& insight, const std::string& name) {
    const json::array& rows = insight.at("students").as_array();
    return *std::ranges::find_if(rows, [&](const json::value& row) {
      return row.at("person").at("display_name").as_string() == name.c_str();
    });
  }

  inline static const Actor kBy{{}, "test"};
  School school_;
  RunningServer server_{school_};
  std::map<std::string, Visitor> visitors_;
  Uuid assignment_;
};

TEST_F(AssignmentInsightTest, SaysWhoHasNotBegunAndWhatWasLost) {
  const Uuid worse = Made(school_.sam, 15, 40);
  const Uuid better = Made(school_.sam, 10, 75);
  const json::object insight = Insight("ada");
  EXPECT_EQ(insight.at("summary").at("students"), 2);
  EXPECT_EQ(insight.at("summary").at("not_started"), 1);
  EXPECT_EQ(insight.at("summary").at("scored"), 1);
  EXPECT_EQ(Row(insight, "Person sue").at("state"), "not_started");
  const json::value& sam = Row(insight, "Person sam");
  EXPECT_EQ(sam.at("attempts"), 2);
  EXPECT_EQ(sam.at("time_s").to_number<double>(), 2) << "of both attempts";
  EXPECT_EQ(sam.at("attempt_id").as_string(), better.Text().c_str()) << "the best counts";
  EXPECT_EQ(sam.at("lost").at(0).to_number<double>(), 10);
  const json::value& outline = insight.at("criteria").at(0);
  EXPECT_EQ(outline.at("group"), "outline");
  EXPECT_EQ(outline.at("to_change"), 1);
  EXPECT_EQ(outline.at("mean_lost").to_number<double>(), 10);
  EXPECT_TRUE(outline.at("values").is_null());
  const json::value& force = insight.at("criteria").at(1);
  EXPECT_EQ(force.at("values").at("median").to_number<double>(), 0.3);
  EXPECT_EQ(insight.at("commonest"), 0);
  const json::value& wall = insight.at("mistakes").at(0);
  EXPECT_EQ(wall.at("kind"), "over_extended");
  EXPECT_EQ(wall.at("place"), "wall_mesial");
  EXPECT_EQ(wall.at("students"), 1);
  EXPECT_EQ(wall.at("size").to_number<double>(), 0.4);
  EXPECT_EQ(wall.at("unit"), "mm");
  EXPECT_EQ(wall.at("at_mm").at(0).to_number<double>(), 2);

  ASSERT_TRUE(school_.store->judging.FlagAttempt(better, kExcused, "power cut", kBy).ok());
  EXPECT_EQ(Row(Insight("ada"), "Person sam").at("attempt_id").as_string(), worse.Text().c_str());
}

TEST_F(AssignmentInsightTest, WhoTeachesIsBesideTheClassAndInNoneOfItsFigures) {
  const Uuid own = Made(school_.ada, 20, 99, false);
  const json::object insight = Insight("ada");
  EXPECT_EQ(insight.at("summary").at("students"), 2);
  EXPECT_EQ(insight.at("summary").at("scored"), 0);
  EXPECT_TRUE(insight.at("summary").at("scores").is_null());
  ASSERT_EQ(insight.at("staff").as_array().size(), 1u);
  EXPECT_EQ(insight.at("staff").at(0).at("attempt_id").as_string(), own.Text().c_str());
  EXPECT_EQ(insight.at("staff").at(0).at("time_s").to_number<double>(), 1);
}

TEST_F(AssignmentInsightTest, ScoreThatCannotBeReadIsCountedAndHidesNothingElse) {
  const Uuid id = Made(school_.sam, 5, 40);
  AttemptResult damaged = *school_.store->results.ResultOf(id);
  damaged.score_json = *school_.store->blobs.PutBlob(AsBytes("no score"));
  ASSERT_TRUE(school_.store->results.FinishAttempt(id, damaged, {}).ok());
  const json::object insight = Insight("ada");
  EXPECT_EQ(insight.at("unread"), 1);
  EXPECT_EQ(insight.at("summary").at("scored"), 1);
  EXPECT_TRUE(insight.at("criteria").as_array().empty());
}

TEST_F(AssignmentInsightTest, CohortThatIsNotAssignedToOrNotTheCallersIsRefused) {
  EXPECT_EQ(Answer("ada", "?cohort=" + school_.cohort_a.Text()).status, 200);
  EXPECT_EQ(Answer("root", "?cohort=" + school_.cohort_b.Text()).status, 400);
  EXPECT_EQ(Answer("ben").status, 404);
  AssignmentRow everybody;
  everybody.exercise = "class-1-occlusal";
  assignment_ = school_.store->assignments.AddAssignment(everybody, kBy)->id;
  EXPECT_EQ(Insight("root").at("summary").at("students"), 3);
  EXPECT_EQ(Insight("root", "?cohort=" + school_.cohort_b.Text()).at("summary").at("students"), 1);
  EXPECT_EQ(Insight("ben").at("summary").at("students"), 1) << "an instructor's own cohorts";
  EXPECT_EQ(Answer("ben", "?cohort=" + school_.cohort_a.Text()).status, 400);
}

}  // namespace
}  // namespace enamel::server::http
