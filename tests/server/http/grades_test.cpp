#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "common/base/csv.h"
#include "tests/server/http/running_server.h"

// One result over several attempts, over the wire: who sees it, and when.
namespace enamel::server::http {
namespace {

namespace json = boost::json;

class GradesTest : public testing::Test {
 protected:
  GradesTest() {
    for (const char* login : {"sam", "tom", "ada", "ben", "root"}) {
      visitors_.emplace(login, Visitor(server_.port(), login));
    }
    EXPECT_TRUE(school_.store->references
                    .AddReference(school_.toms_scored, "Dr. Vega", true, {school_.ben, "page"})
                    .ok());
  }
  Visitor& By(const std::string& login) { return visitors_.at(login); }
  RawResponse Send(const std::string& login, const std::string& method, const std::string& target,
                   const json::value& body, const std::string& etag = "") {
    std::string headers =
        "X-Enamel-Csrf: " + By(login).csrf + "\r\nContent-Type: application/json\r\n";
    if (!etag.empty()) headers += "If-Match: " + etag + "\r\n";
    return By(login).Send(method, target, headers, json::serialize(body));
  }
  // An assignment of this exercise to cohort A, under which sam has made attempts with these
  // scores.
  Uuid Worked(const std::string& exercise, const Uuid& version, const char* counting,
              const std::vector<double>& scores) {
    RawResponse made = Send("ada", "POST", "/api/v1/assignments",
                            json::object{{"exercise", exercise},
                                         {"cohort_id", school_.cohort_a.Text()},
                                         {"counting", counting}});
    EXPECT_EQ(made.status, 201) << made.body;
    etag_ = made.headers["etag"];
    const Uuid id = *Uuid::Parse(Parsed(made).at("id").as_string());
    for (double score : scores) {
      ++school_.now_ms;
      attempts_.push_back(school_.ScoredAttempt(school_.sam, [&](AttemptRow& row) {
        row.exercise = version;
        row.assignment = id;
      }));
      EXPECT_TRUE(school_.store->judging
                      .OverrideScore(attempts_.back(), ScoreOverride{score, "set", {}, 0}, kBy)
                      .ok());
    }
    return id;
  }
  json::value Sams(const std::string& login, const Uuid& assignment) {
    if (login == "sam") {
      const json::value list = Parsed(By("sam").Get("/api/v1/assignments"));
      for (const json::value& row : list.at("assignments").as_array()) {
        if (row.at("id").as_string() == assignment.Text().c_str())
          return row.at("mine").at("grade");
      }
      return {};
    }
    const json::value grades = Parsed(By(login).Get(grades_path_));
    size_t place = 0;
    for (const json::value& row : grades.at("assignments").as_array()) {
      if (row.at("id").as_string() == assignment.Text().c_str()) break;
      ++place;
    }
    for (const json::value& row : grades.at("students").as_array()) {
      if (row.at("person").at("id").as_string() == school_.sam.Text().c_str())
        return row.at("grades").at(place);
    }
    return {};
  }

  inline static const Actor kBy{{}, "test"};
  School school_;
  RunningServer server_{school_};
  std::map<std::string, Visitor> visitors_;
  std::string grades_path_ = "/api/v1/cohorts/" + school_.cohort_a.Text() + "/grades";
  std::string etag_;
  std::vector<Uuid> attempts_;
};

TEST_F(GradesTest, AssignmentSaysWhatCountsAndTheCohortsResultsFollow) {
  const Uuid id = Worked("class-1-occlusal", school_.exercise, "mean", {70, 90, 85});
  json::value grade = Sams("ada", id);
  EXPECT_EQ(grade.at("attempts"), 3);
  EXPECT_EQ(grade.at("counted"), 3);
  EXPECT_EQ(grade.at("score").to_number<double>(), (70.0 + 90.0 + 85.0) / 3);
  EXPECT_TRUE(grade.at("attempt_id").is_null());
  EXPECT_EQ(grade.at("released"), false);
  const std::string path = "/api/v1/assignments/" + id.Text();
  json::object terms{{"exercise", "class-1-occlusal"}, {"cohort_id", school_.cohort_a.Text()}};
  RawResponse kept = Send("ada", "PUT", path, terms, etag_);
  EXPECT_EQ(Parsed(kept).at("counting"), "mean") << "left out: as it was";
  terms["counting"] = "worst";
  RawResponse refused = Send("ada", "PUT", path, terms, kept.headers["etag"]);
  EXPECT_EQ(refused.status, 400);
  EXPECT_EQ(Parsed(refused).at("error").at("field"), "counting");
  terms["counting"] = "best";
  ASSERT_EQ(Send("ada", "PUT", path, terms, kept.headers["etag"]).status, 200);
  EXPECT_EQ(Sams("root", id).at("score").to_number<double>(), 90);
  EXPECT_EQ(Sams("ada", id).at("attempt_id").as_string(), attempts_[1].Text().c_str());

  const json::value all = Parsed(By("ada").Get(grades_path_));
  EXPECT_EQ(all.at("students").as_array().size(), 2u) << "sam and sue, nobody who teaches";
  const auto& rows = all.at("assignments").as_array();
  auto row = std::ranges::find_if(rows, [&](const json::value& each) {
    return each.at("id").as_string() == id.Text().c_str();
  });
  ASSERT_NE(row, rows.end());
  EXPECT_EQ(row->at("summary").at("students"), 2);
  EXPECT_EQ(row->at("summary").at("graded"), 1);
  EXPECT_EQ(row->at("summary").at("mean").to_number<double>(), 90);
  EXPECT_EQ(By("ben").Get(grades_path_).status, 404);
  EXPECT_EQ(By("sam").Get(grades_path_).status, 403);
}

TEST_F(GradesTest, StudentsResultIsMadeOfReleasedScoresAndTellsNothingOfOthers) {
  const Uuid id = Worked("class-1-occlusal", school_.exercise, "mean", {70, 90});
  json::value grade = Sams("sam", id);
  EXPECT_EQ(grade.at("attempts"), 2);
  EXPECT_EQ(grade.at("counted"), 0);
  EXPECT_TRUE(grade.at("score").is_null());
  ASSERT_TRUE(school_.store->judging.ReleaseAttempt(attempts_[0], kBy).ok());
  grade = Sams("sam", id);
  EXPECT_EQ(grade.at("counted"), 1);
  EXPECT_EQ(grade.at("score").to_number<double>(), 70) << "of what is released";
  EXPECT_EQ(Sams("ada", id).at("score").to_number<double>(), 80);
  EXPECT_EQ(Sams("ada", id).at("released"), false);
  ASSERT_TRUE(school_.store->judging.ReleaseAssignment(id, kBy).ok());
  EXPECT_EQ(Sams("sam", id).at("score").to_number<double>(), 80);
  EXPECT_EQ(Sams("ada", id).at("released"), true);
  ASSERT_TRUE(school_.store->judging.FlagAttempt(attempts_[1], kExcused, "power cut", kBy).ok());
  EXPECT_EQ(Sams("sam", id).at("attempts"), 1);
  EXPECT_EQ(Sams("sam", id).at("score").to_number<double>(), 70);
}

TEST_F(GradesTest, StudentIsToldThatItIsGradedAgainInPlaceOfAnotherAttemptsScore) {
  const Uuid id = Worked("class-1-occlusal", school_.exercise, "best", {0, 90});
  ASSERT_TRUE(school_.store->judging.ReleaseAssignment(id, kBy).ok());
  EXPECT_EQ(Sams("sam", id).at("score").to_number<double>(), 90);
  EXPECT_EQ(Sams("sam", id).at("regrading"), false);
  // The run that its seal asked for has not been made here.
  auto job = school_.store->jobs.LeaseJob(school_.now_ms, 60'000);
  while (job.ok() && *job && (*job)->attempt != attempts_[1]) {
    job = school_.store->jobs.LeaseJob(school_.now_ms, 60'000);
  }
  ASSERT_TRUE(job.ok() && *job);
  json::value grade = Sams("sam", id);
  EXPECT_EQ(grade.at("regrading"), true);
  EXPECT_TRUE(grade.at("score").is_null()) << grade;
  EXPECT_EQ(Sams("ada", id).at("score").to_number<double>(), 90);
  EXPECT_EQ(Sams("ada", id).at("regrading"), true);
}

TEST_F(GradesTest, PracticeCountsForTheStudentAtOnce) {
  const ExerciseRow practice = school_.OwnExercise({school_.ada, "page"}, "practice", true, false);
  const Uuid id = Worked("practice", practice.id, "last", {70, 60});
  EXPECT_EQ(Sams("sam", id).at("score").to_number<double>(), 60);
  EXPECT_EQ(Sams("sam", id).at("attempt_id").as_string(), attempts_.back().Text().c_str());
  EXPECT_EQ(Sams("ada", id).at("released"), true);
}

std::vector<CsvRow> RowsOf(const RawResponse& answer) {
  EXPECT_EQ(answer.status, 200) << answer.body;
  EXPECT_TRUE(answer.body.starts_with(kCsvByteOrderMark));
  return ReadCsv(answer.body).rows;
}

TEST_F(GradesTest, TableFileHasAColumnOfItsOwnForEachAssignment) {
  const std::string graded_title = school_.store->exercises.ExerciseById(school_.exercise)->title;
  Worked("class-1-occlusal", school_.exercise, "mean", {81.66, 81.7});
  Worked("class-1-occlusal", school_.exercise, "best", {});
  const ExerciseRow practice = school_.OwnExercise({school_.ada, "page"}, "practice", true, false);
  const ExerciseRow twin = school_.OwnExercise({school_.ada, "page"}, "twin", true, false);
  ASSERT_EQ(practice.title, twin.title);
  Worked("practice", practice.id, "last", {70});
  Worked("twin", twin.id, "last", {});
  const auto rows = RowsOf(By("ada").Get(grades_path_ + ".csv"));
  ASSERT_EQ(rows.size(), 3u);
  const auto& header = rows[0].cells;
  EXPECT_EQ(std::set<std::string>(header.begin(), header.end()).size(), header.size())
      << "no two columns of one name";
  const auto column = [&](const std::string& title) {
    return static_cast<size_t>(std::ranges::find(header, title) - header.begin());
  };
  const auto sams =
      std::ranges::find_if(rows, [](const CsvRow& row) { return row.cells[1] == "sam"; });
  ASSERT_NE(sams, rows.end());
  EXPECT_EQ(sams->cells.size(), header.size());
  ASSERT_LT(column(graded_title + " #1"), header.size()) << header[3];
  const std::string first = sams->cells[column(graded_title + " #1")];
  const std::string second = sams->cells[column(graded_title + " #2")];
  EXPECT_EQ(first + second, "81.7") << "one decimal, and nothing where there is no result";
  ASSERT_LT(column(practice.title + " (practice) [practice]"), header.size());
  EXPECT_EQ(sams->cells[column(practice.title + " (practice) [practice]")], "70");
  EXPECT_EQ(sams->cells[column("assignments_done")], "2");
}

TEST_F(GradesTest, AttemptsFileSaysWhoseEachIs) {
  Worked("class-1-occlusal", school_.exercise, "mean", {70});
  const auto rows =
      RowsOf(By("ada").Get("/api/v1/cohorts/" + school_.cohort_a.Text() + "/attempts.csv"));
  ASSERT_GE(rows.size(), 2u);
  EXPECT_EQ(rows[0].cells[0], "login");
  for (const CsvRow& row : rows) EXPECT_EQ(row.cells.size(), rows[0].cells.size());
  const auto made = std::ranges::find_if(
      rows, [&](const CsvRow& row) { return row.cells.back() == attempts_.front().Text(); });
  ASSERT_NE(made, rows.end());
  EXPECT_EQ(made->cells[0], "sam");
  EXPECT_EQ(made->cells[1], "Person sam");
  EXPECT_EQ(made->cells[6], "70");
}

}  // namespace
}  // namespace enamel::server::http
