#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "common/scoring/score.h"
#include "tests/server/http/running_server.h"

// The attempts of an assignment with the points lost by criterion, over the wire.
namespace enamel::server::http {
namespace {

namespace json = boost::json;

class GradingTest : public testing::Test {
 protected:
  struct Lost {
    const char* name;
    double points;
    bool judged = true;
  };

  GradingTest() {
    for (const char* login : {"ada", "ben", "root"}) {
      visitors_.emplace(login, Visitor(server_.port(), login));
    }
    AssignmentRow terms;
    terms.exercise = "class-1-occlusal";
    terms.cohort = school_.cohort_a;
    assignment_ = school_.store->assignments.AddAssignment(terms, kBy)->id;
  }
  Uuid Made(const Uuid& person, const std::vector<Lost>& criteria, double not_done_percent = 0) {
    ++school_.now_ms;
    return school_.ScoredAttempt(
        person, [&](AttemptRow& row) { row.assignment = assignment_; },
        [&](scoring::ScoreResult& result) {
          result.criteria.clear();
          for (const Lost& each : criteria) {
            scoring::CriterionResult& c = result.criteria.emplace_back();
            c.name = each.name;
            c.title = std::string("Title of ") + each.name;
            c.lost = each.points;
            c.judged = each.judged;
          }
          if (not_done_percent == 0) return;
          scoring::Mistake rest;
          rest.kind = scoring::MistakeKind::kNotDone;
          rest.size = not_done_percent;
          result.mistakes = {rest};
        });
  }
  json::object Grading(const std::string& login, const std::string& of = "assignments") {
    const Uuid& id = of == "assignments" ? assignment_ : school_.cohort_a;
    RawResponse answer = visitors_.at(login).Get("/api/v1/" + of + "/" + id.Text() + "/grading");
    EXPECT_EQ(answer.status, 200) << answer.body;
    return Parsed(answer).as_object();
  }
  static const json::value& Row(const json::object& grading, const Uuid& attempt) {
    for (const json::value& row : grading.at("attempts").as_array()) {
      if (row.at("id").as_string() == attempt.Text().c_str()) return row;
    }
    static const json::value kNone;
    return kNone;
  }

  inline static const Actor kBy{{}, "test"};
  School school_;
  RunningServer server_{school_};
  std::map<std::string, Visitor> visitors_;
  Uuid assignment_;
};

TEST_F(GradingTest, SaysWhatEachAttemptLostUnderColumnsThatAreNamedOnce) {
  const Uuid first =
      Made(school_.sam, {{"outline", 15}, {"margins", 0}, {"time_s", 0, false}}, 37.5);
  const Uuid second = Made(school_.sue, {{"internal_form", 3}, {"outline", 5}});
  const json::object grading = Grading("ada");
  const json::array& columns = grading.at("criteria").as_array();
  ASSERT_EQ(columns.size(), 4u) << grading;
  EXPECT_EQ(columns[0].at("name"), "internal_form") << "the newest attempt first";
  EXPECT_EQ(columns[1].at("name"), "outline");
  EXPECT_EQ(columns[1].at("group"), "hand");
  EXPECT_EQ(columns[1].at("title"), "Title of outline");
  EXPECT_EQ(json::serialize(Row(grading, second).at("lost")), "[3E0,5E0]");
  EXPECT_EQ(json::serialize(Row(grading, first).at("lost")), "[null,1.5E1,0E0,null]");
  EXPECT_EQ(Row(grading, first).at("done_percent").to_number<double>(), 62.5);
  EXPECT_TRUE(Row(grading, second).at("done_percent").is_null()) << "all of it was done";
  EXPECT_EQ(grading.at("exercises").as_array().size(), 1u);
  EXPECT_EQ(Row(grading, first).at("exercise"), 0);
  EXPECT_EQ(Row(grading, first).at("person").at("display_name"), "Person sam");
  EXPECT_EQ(grading.at("more"), false);
  EXPECT_TRUE(grading.at("of").at("graded").as_bool()) << "the exercise of the assignment";
  EXPECT_TRUE(Grading("root", "cohorts").at("of").at("graded").is_null());
  EXPECT_EQ(grading.at("unread"), 0);
  EXPECT_GE(Grading("root", "cohorts").at("attempts").as_array().size(), 3u)
      << "also what was not made under this assignment";
}

TEST_F(GradingTest, ShowsNoScoreThatAMarkerMayNotKnow) {
  const Uuid id = Made(school_.sam, {{"outline", 15}});
  ASSERT_TRUE(
      school_.store->markings.BeginMarking(assignment_, {id}, {school_.ada, school_.root}, kBy)
          .ok());
  EXPECT_TRUE(Row(Grading("ada"), id).is_null()) << "a list says whose it is";
  const auto marking = school_.store->markings.MarkingsOf(assignment_);
  const auto works = school_.store->markings.WorksOf(marking->front().id);
  ASSERT_TRUE(school_.store->markings
                  .AddMark({works->front().id, school_.ada, 3, "[]", 0}, {school_.ada, "page"})
                  .ok());
  const json::object grading = Grading("ada");
  EXPECT_TRUE(Row(grading, id).at("score").is_null()) << "until the other is done too";
  EXPECT_TRUE(Row(grading, id).at("lost").is_null());
}

TEST_F(GradingTest, ADocumentThatCannotBeReadCostsItsRowThePoints) {
  const Uuid id = Made(school_.sam, {{"outline", 15}});
  const auto row = school_.store->attempts.AttemptById(id);
  ASSERT_EQ(std::filesystem::exists(school_.folder.path()), true);
  size_t removed = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(school_.folder.path())) {
    if (entry.path().filename().string().find(row->score_document.Hex().substr(4)) ==
        std::string::npos) {
      continue;
    }
    removed += std::filesystem::remove(entry.path()) ? 1 : 0;
  }
  ASSERT_EQ(removed, 1u);
  const json::object grading = Grading("ada");
  EXPECT_TRUE(Row(grading, id).at("lost").is_null());
  EXPECT_FALSE(Row(grading, id).at("score").is_null());
  EXPECT_EQ(grading.at("unread"), 1);
}

}  // namespace
}  // namespace enamel::server::http
