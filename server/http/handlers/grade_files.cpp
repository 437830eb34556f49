#include <spdlog/fmt/chrono.h>

#include <cmath>
#include <map>
#include <set>

#include "common/base/csv.h"
#include "server/http/error_response.h"
#include "server/http/handlers/seen_attempt.h"
#include "server/http/handlers/seen_teaching.h"
#include "server/http/operations.h"
#include "server/http/views/grade_view.h"
#include "server/training/access.h"

// A cohort's results and attempts as comma-separated values.
namespace enamel::server::http {
namespace {

// The page shows scores so: one decimal, and none where it would be 0.
std::string ScoreText(const std::optional<double>& score) {
  if (!score) return "";
  const auto tenths = std::lround(*score * 10);
  return std::to_string(tenths / 10) + (tenths % 10 == 0 ? "" : "." + std::to_string(tenths % 10));
}

std::string YesNo(bool yes) { return yes ? "yes" : "no"; }

// "2026-11-28T09:05:00.250Z"; empty: never.
std::string UtcText(UnixMs at) {
  if (at <= 0) return "";
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z",
                     fmt::gmtime(static_cast<std::time_t>(at / 1000)), at % 1000);
}

std::string TitleOf(const std::string& title, const std::string& name, bool graded) {
  const std::string& shown = title.empty() ? name : title;
  return graded ? shown : shown + " (practice)";
}

// Each assignment has a title of its own, because a spreadsheet looks columns up by title. Equal
// titles get the exercise's name, then a number.
std::vector<std::string> ColumnTitles(const std::vector<AssignmentRow>& rows) {
  std::vector<std::string> out;
  std::map<std::string, std::set<std::string>> names;
  for (const AssignmentRow& row : rows) {
    out.push_back(TitleOf(row.title, row.exercise, row.graded));
    names[out.back()].insert(row.exercise);
  }
  for (size_t i = 0; i < rows.size(); ++i) {
    if (names[out[i]].size() > 1) out[i] += " [" + rows[i].exercise + "]";
  }
  std::map<std::string, size_t> uses, numbers;
  for (const std::string& title : out) ++uses[title];
  for (std::string& title : out) {
    if (uses[title] > 1) title += " #" + std::to_string(++numbers[title]);
  }
  return out;
}

std::string GradesText(const GradeView::Book& book) {
  const std::vector<std::string> titles = ColumnTitles(book.assignments);
  std::vector<std::string> header{"person", "login", "display_name"};
  header.insert(header.end(), titles.begin(), titles.end());
  header.emplace_back("assignments_done");
  for (size_t i = 0; i < titles.size(); ++i) {
    const std::string counting = CountingName(book.assignments[i].counting);
    header.push_back(titles[i] + " (" + counting + " of attempts)");
    header.push_back(titles[i] + " (released)");
  }
  std::string out(kCsvByteOrderMark);
  out += CsvLine(header);
  for (size_t i = 0; i < book.students.size(); ++i) {
    const Person& person = book.students[i];
    std::vector<std::string> cells{person.id.Text(), person.login, person.display_name};
    size_t done = 0;
    for (const auto& results : book.results) {
      cells.push_back(ScoreText(results[i].score));
      done += results[i].score ? 1 : 0;
    }
    cells.push_back(std::to_string(done));
    for (const auto& results : book.results) {
      cells.push_back(std::to_string(results[i].counted));
      cells.push_back(YesNo(results[i].shown));
    }
    out += CsvLine(cells);
  }
  return out;
}

// Lines of attempts, with what the viewer may see of them.
class AttemptLines {
 public:
  AttemptLines(const Call& call, Store& store) : call_(call), store_(store) {}

  Result<std::string> Read(AttemptFilter filter) {
    const Person& viewer = call_.caller->person;
    ENAMEL_ASSIGN_OR_RETURN(const auto hidden, store_.markings.HiddenFrom(viewer.id));
    ENAMEL_ASSIGN_OR_RETURN(const auto stations, store_.stations.Stations());
    for (const StationRow& row : stations) stations_[row.id] = row.name;
    std::string out(kCsvByteOrderMark);
    out += CsvLine({"login", "display_name", "exercise", "begun_utc", "finished_utc", "state",
                    "score", "computed_score", "critical_fail", "released", "exam", "flags",
                    "station", "attempt"});
    filter.limit = AttemptFilter::kMaxAtOnce;
    for (bool more = true; more;) {
      ENAMEL_ASSIGN_OR_RETURN(const auto rows, store_.attempts.Attempts(filter));
      more = rows.size() == filter.limit;
      if (more) filter.before = rows.back().id;
      for (const AttemptRow& row : rows) {
        ENAMEL_ASSIGN_OR_RETURN(const bool graded, IsGraded(row.exercise));
        out +=
            Line(row, graded, !hidden.contains(row.id) && CanSeeScore(viewer, row, graded, true));
      }
      if (more && std::chrono::steady_clock::now() >= call_.request.answer_by) {
        return Status{Code::kUnavailable, "the server was too busy to read these attempts in time"};
      }
    }
    return out;
  }

 private:
  Result<bool> IsGraded(const Uuid& exercise) {
    if (auto found = graded_.find(exercise); found != graded_.end()) return found->second;
    ENAMEL_ASSIGN_OR_RETURN(const auto row, store_.exercises.ExerciseById(exercise));
    return graded_[exercise] = row.graded;
  }

  std::string Line(const AttemptRow& row, bool graded, bool visible) {
    const std::optional<double> computed = visible ? row.score : std::nullopt;
    std::optional<double> score = computed;
    if (score && row.overridden) score = row.overridden->score;
    std::string flags;
    for (const char* name : AttemptFlagNames(row.flags)) {
      flags += (flags.empty() ? "" : " ") + std::string(name);
    }
    return CsvLine({row.person_login, row.person_name, TitleOf(row.exercise_title, "", graded),
                    UtcText(row.ticketed_ms), UtcText(row.sealed_ms), AttemptStateName(row.state),
                    ScoreText(score), ScoreText(computed), computed ? YesNo(row.critical_fail) : "",
                    YesNo(row.released), YesNo(row.exam), flags, stations_[row.station],
                    row.id.Text()});
  }

  const Call& call_;
  Store& store_;
  std::map<Uuid, std::string> stations_;
  std::map<Uuid, bool> graded_;
};

Result<Response> CsvResponse(const Result<std::string>& text) {
  ENAMEL_RETURN_IF_ERROR(text.status());
  Response out;
  out.content_type = "text/csv; charset=utf-8";
  out.body = *text;
  // The page names the file.
  out.headers.emplace_back("Content-Disposition", "attachment");
  return out;
}

}  // namespace

Result<Response> GetGradesFile(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(Cohort cohort, VisibleCohort(call, store.cohorts));
  GradeView view(store, call.caller->person);
  ENAMEL_ASSIGN_OR_RETURN(GradeView::Book book, view.BookOf(cohort.id));
  return CsvResponse(GradesText(book));
}

Result<Response> GetAttemptsFile(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(Cohort cohort, VisibleCohort(call, store.cohorts));
  AttemptFilter filter;
  filter.cohort = cohort.id;
  NarrowToTaught(call, filter);
  filter.not_to_be_marked_by = call.caller->person.id;
  return CsvResponse(AttemptLines(call, store).Read(filter));
}

}  // namespace enamel::server::http
