#include "server/commands/agreement.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <boost/json/parse.hpp>

#include "common/base/counted.h"
#include "common/base/csv.h"
#include "common/base/file.h"
#include "common/program/output.h"
#include "common/scoring/score.h"
#include "server/agreement/standard.h"
#include "server/app/data_folder.h"
#include "server/commands/command_line.h"
#include "server/commands/say.h"
#include "server/jobs/marked_work.h"

namespace enamel::server::app {
namespace {

// By id and without names, points or pictures. Examiners look at the attempt's page, which shows an
// instructor the computed points as well: they must look away themselves.
Status WriteBlank(const std::filesystem::path& file, const std::vector<ScoredWork>& attempts) {
  if (std::filesystem::exists(file)) {
    return Status(Code::kConflict, file.string() + " is there already; name a new file");
  }
  std::string text = CsvLine({"work", "criterion", "full_marks", "marker", "mark"});
  for (const ScoredWork& a : attempts) {
    // First: whoever has given points would rate by them.
    text += CsvLine({a.attempt.Text(), std::string(kRatingCriterion), "5", "", ""});
    for (const auto& group : MarkedGroups(a.score)) {
      text += CsvLine({a.attempt.Text(), group.title, fmt::format("{:g}", group.most), "", ""});
    }
    text += CsvLine({a.attempt.Text(), std::string(kTotalCriterion), "100", "", ""});
  }
  ENAMEL_RETURN_IF_ERROR(WriteFileDurably(file, AsBytes(WithPlainLineEnds(text))));
  Say("{}: {}. Each person fills in `marker` and `mark` in a copy of their own.\n", file.string(),
      Counted(attempts.size(), "attempt"));
  return Status::Ok();
}

std::string Shown(const Agreement& a, const char* unit = "") {
  return fmt::format("{:6.2f}{}  ({:.2f} to {:.2f})", a.value, unit, a.interval.low,
                     a.interval.high);
}

void Show(const char* name, const Figure& figure) {
  Say("  {:<24} {}\n", name, figure.value ? Shown(CutOff(*figure.value)) : "none: " + figure.why);
}

// `said`: what stands above all criteria.
void Show(const CriterionAgreement& c, const std::string& said) {
  if (c.why == said && !said.empty() && !c.computed) return;
  std::string markers;
  for (const std::string& m : c.markers) markers += (markers.empty() ? "" : ", ") + m;
  Say("\n{}: {} pieces of work by {}{}\n", c.criterion, c.works, markers,
      c.left_out > 0 ? fmt::format("; {} left out, as somebody did not mark them", c.left_out)
                     : "");
  if (c.why.empty()) {
    Show("ICC(2,1), one mark", c.icc21);
    Show("ICC(3,k), their mean", c.icc3k);
    Show("phi, their mean", c.phi);
  } else if (c.why != said) {
    Say("  {}\n", c.why);
  }
  if (c.computed) {
    Show("ICC(2,1), their mean and the program", c.computed_icc21);
  }
  if (c.markers.size() == 2) Show("kappa, quadratic", c.weighted_kappa);
  if (c.why.empty()) Show("kappa, free-marginal", c.free_kappa);
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

Result<std::vector<Mark>> ReadMarkFiles(const std::vector<std::filesystem::path>& files) {
  std::vector<Mark> out;
  for (const auto& file : files) {
    ENAMEL_ASSIGN_OR_RETURN(auto text, ReadFile(file, kMaxMarksBytes));
    auto read = ReadMarks(AsText(text));
    if (!read.ok()) {
      return Status(read.status().code(), file.string() + ": " + read.status().message());
    }
    out.insert(out.end(), read->begin(), read->end());
  }
  return out;
}

Status CompareAgreement(const AgreementOptions& options) {
  if (!options.assignment.empty() && options.data.empty()) {
    return Status(Code::kInvalidInput, "expected --data (or ENAMEL_DATA) beside --assignment");
  }
  std::vector<ScoredWork> attempts;
  if (!options.assignment.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(options.data));
    ENAMEL_ASSIGN_OR_RETURN(const auto assignment, Uuid::Parse(options.assignment));
    ENAMEL_ASSIGN_OR_RETURN(attempts, ScoredUnder(*store, assignment));
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
  ENAMEL_ASSIGN_OR_RETURN(auto marks, ReadMarkFiles(options.marks));
  for (Mark& mark : ComputedMarks(attempts)) marks.push_back(std::move(mark));
  ENAMEL_ASSIGN_OR_RETURN(auto criteria, CompareMarks(marks));
  // The same one marker for all criteria: one sentence is enough.
  const std::string& first = criteria.front().why;
  const bool alone =
      std::ranges::all_of(criteria, [&](const CriterionAgreement& c) { return c.why == first; });
  const std::string said = alone ? first : "";
  if (!said.empty()) Say("{}\n", said);
  const bool any = std::ranges::any_of(
      criteria, [](const CriterionAgreement& c) { return c.why.empty() || c.computed; });
  if (any) {
    Say("Each range in brackets holds the true value in 95 of 100 cases. What the program gave is "
        "compared\nwith people apart.\n");
  }
  for (const CriterionAgreement& c : criteria) Show(c, said);
  ENAMEL_RETURN_IF_ERROR(program::WriteJsonFile(
      options.json, boost::json::parse(AgreementJson(criteria)).as_object()));
  if (options.csv.empty()) return Status::Ok();
  return WriteFileDurably(options.csv, AsBytes(WithPlainLineEnds(AgreementCsv(criteria))));
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
  AddExample(cmd, std::string("anna.csv ben.csv --csv table.csv --assignment ") + kSomeId);
}

}  // namespace enamel::server::app
