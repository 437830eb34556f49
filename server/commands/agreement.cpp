#include "server/commands/agreement.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "common/base/counted.h"
#include "common/base/csv.h"
#include "common/base/file.h"
#include "common/scoring/score.h"
#include "server/agreement/marks.h"
#include "server/app/data_folder.h"
#include "server/commands/command_line.h"
#include "server/commands/say.h"
#include "server/jobs/regrade.h"

namespace enamel::server::app {
namespace {

// Beside the rubric's criteria: the score, 0 to 100.
constexpr char kTotal[] = "total";

struct Scored {
  Uuid attempt;
  scoring::ScoreResult score;
};

Result<std::vector<Scored>> ScoredUnder(Store& store, const std::string& assignment) {
  AttemptFilter which;
  ENAMEL_ASSIGN_OR_RETURN(which.assignment, Uuid::Parse(assignment));
  ENAMEL_ASSIGN_OR_RETURN(auto rows, ScoredAttempts(store.attempts, which));
  std::vector<Scored> out;
  for (const AttemptRow& row : rows) {
    ENAMEL_ASSIGN_OR_RETURN(auto result, store.results.ResultOf(row.id));
    ENAMEL_ASSIGN_OR_RETURN(auto text, store.blobs.GetBlob(result.score_json));
    ENAMEL_ASSIGN_OR_RETURN(auto score, scoring::ScoreFromJson(AsText(text)));
    out.push_back({row.id, std::move(score)});
  }
  if (out.empty()) {
    return Status(Code::kNotFound, "no scored attempt under assignment " + assignment +
                                       "; enamel-server admin list-assignments shows their ids");
  }
  return out;
}

std::vector<Mark> Computed(const std::vector<Scored>& attempts) {
  std::vector<Mark> out;
  const std::string marker(kComputed);
  for (const Scored& a : attempts) {
    // Examiners mark a criterion without knowing the gates, so the gates are divided out. With a
    // closed gate the points before it are unknown.
    double share = 1;
    for (const auto& gate : a.score.gates) share *= gate.share;
    for (const auto& c : a.score.criteria) {
      if (!c.judged || share <= 0) continue;
      out.push_back({a.attempt.Text(), c.title, marker, c.points / share});
    }
    out.push_back({a.attempt.Text(), kTotal, marker, a.score.score});
  }
  return out;
}

// By id and without names, points or pictures. Examiners look at the attempt's page, which shows an
// instructor the computed points as well: they must look away themselves.
Status WriteBlank(const std::filesystem::path& file, const std::vector<Scored>& attempts) {
  if (std::filesystem::exists(file)) {
    return Status(Code::kConflict, file.string() + " is there already; name a new file");
  }
  std::string text = CsvLine({"work", "criterion", "full_marks", "marker", "mark"});
  for (const Scored& a : attempts) {
    for (const auto& c : a.score.criteria) {
      text += CsvLine({a.attempt.Text(), c.title, fmt::format("{:g}", c.max_points), "", ""});
    }
    text += CsvLine({a.attempt.Text(), kTotal, "100", "", ""});
  }
  ENAMEL_RETURN_IF_ERROR(WriteFileDurably(file, AsBytes(text)));
  Say("{}: {}. Each person fills in `marker` and `mark` in a copy of their own.\n", file.string(),
      Counted(attempts.size(), "attempt"));
  return Status::Ok();
}

std::string Shown(const Agreement& a, const char* unit = "") {
  return fmt::format("{:6.2f}{}  ({:.2f} to {:.2f})", a.value, unit, a.interval.low,
                     a.interval.high);
}

void Show(const char* name, const Figure& figure) {
  Say("  {:<24} {}\n", name, figure.value ? Shown(*figure.value) : "none: " + figure.why);
}

void Show(const CriterionAgreement& c) {
  std::string markers;
  for (const std::string& m : c.markers) markers += (markers.empty() ? "" : ", ") + m;
  Say("\n{}: {} pieces of work by {}{}\n", c.criterion, c.works, markers,
      c.left_out > 0 ? fmt::format("; {} left out, as somebody did not mark them", c.left_out)
                     : "");
  Show("ICC(2,1), one mark", c.icc21);
  Show("ICC(3,k), their mean", c.icc3k);
  if (c.computed) {
    Show("ICC(2,1), their mean and the program", c.computed_icc21);
  }
  if (c.markers.size() == 2) Show("kappa, quadratic", c.weighted_kappa);
  Show("kappa, free-marginal", c.free_kappa);
  for (const PairLimits& pair : c.limits) {
    const std::string who = pair.first + " - " + pair.second;
    if (!pair.limits) {
      Say("  {:<24} none: {}\n", who, pair.why);
      continue;
    }
    Say("  {:<24} {}, 95 of 100 within {:.2f} and {:.2f}\n", who, Shown(pair.limits->bias),
        pair.limits->low.value, pair.limits->high.value);
  }
}

}  // namespace

Status CompareAgreement(const AgreementOptions& options) {
  if (!options.assignment.empty() && options.data.empty()) {
    return Status(Code::kInvalidInput, "expected --data (or ENAMEL_DATA) beside --assignment");
  }
  std::vector<Scored> attempts;
  if (!options.assignment.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(options.data));
    ENAMEL_ASSIGN_OR_RETURN(attempts, ScoredUnder(*store, options.assignment));
  }
  if (!options.blank.empty()) {
    if (attempts.empty()) {
      return Status(Code::kInvalidInput, "expected --assignment: of which attempts?");
    }
    return WriteBlank(options.blank, attempts);
  }
  if (options.marks.empty()) {
    return Status(Code::kInvalidInput,
                  "expected files with marks; --blank FILE writes one to be filled in");
  }
  std::vector<Mark> marks = Computed(attempts);
  for (const auto& file : options.marks) {
    ENAMEL_ASSIGN_OR_RETURN(auto text, ReadFile(file, kMaxMarksBytes));
    auto read = ReadMarks(AsText(text));
    if (!read.ok()) {
      return Status(read.status().code(), file.string() + ": " + read.status().message());
    }
    marks.insert(marks.end(), read->begin(), read->end());
  }
  ENAMEL_ASSIGN_OR_RETURN(auto criteria, CompareMarks(marks));
  Say("Each range in brackets holds the true value in 95 of 100 cases. What the program gave is "
      "compared\nwith people apart, criteria before the gates.\n");
  for (const CriterionAgreement& c : criteria) Show(c);
  if (!options.json.empty()) {
    ENAMEL_RETURN_IF_ERROR(WriteFileDurably(options.json, AsBytes(AgreementJson(criteria))));
  }
  if (options.csv.empty()) return Status::Ok();
  return WriteFileDurably(options.csv, AsBytes(AgreementCsv(criteria)));
}

void DeclareAgreement(CommandGroup program) {
  auto [cmd, o] = Declare<AgreementOptions>(
      program, "agreement", "How well the marks of several people agree on the same attempts",
      CompareAgreement);
  cmd->add_option("marks", o.marks, "CSV files (schemas/marks.md)");
  AddData(cmd, o.data)->required(false);
  cmd->add_option("--assignment", o.assignment,
                  "Also compare with the computed points of its scored attempts");
  cmd->add_option("--blank", o.blank, "Write a file to be filled in, and compare nothing");
  cmd->add_option("--json", o.json, "Write the figures to this file");
  cmd->add_option("--csv", o.csv, "Write the table to this file");
  cmd->footer(
      "  enamel-server agreement --data DIR --assignment ID --blank marks.csv\n"
      "  enamel-server agreement anna.csv ben.csv --data DIR --assignment ID --csv table.csv");
}

}  // namespace enamel::server::app
