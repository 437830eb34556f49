#include "server/commands/standard.h"

#include <spdlog/fmt/fmt.h>

#include <boost/json/parse.hpp>

#include "common/base/csv.h"
#include "common/base/file.h"
#include "common/program/output.h"
#include "server/agreement/standard.h"
#include "server/app/data_folder.h"
#include "server/commands/agreement.h"
#include "server/commands/command_line.h"
#include "server/commands/say.h"
#include "server/jobs/marked_work.h"

namespace enamel::server::app {
namespace {

// Each group once: what a student who is just good enough would earn for it.
Status WriteBorderlineForm(const std::filesystem::path& file, const ScoredWork& any) {
  if (std::filesystem::exists(file)) {
    return Status(Code::kConflict, file.string() + " is there already; name a new file");
  }
  std::string text = CsvLine({"work", "criterion", "full_marks", "marker", "mark"});
  for (const auto& group : MarkedGroups(any.score)) {
    text += CsvLine(
        {std::string(kBorderlineWork), group.title, fmt::format("{:g}", group.most), "", ""});
  }
  ENAMEL_RETURN_IF_ERROR(WriteFileDurably(file, AsBytes(WithPlainLineEnds(text))));
  Say("{}: each examiner fills in `marker` and, as `mark`, the points that a student would earn "
      "who "
      "is just good enough.\n",
      file.string());
  return Status::Ok();
}

std::string FigureText(const Agreement& a) {
  return fmt::format("{:.2f} ({:.2f} to {:.2f})", a.value, a.interval.low, a.interval.high);
}
std::string FigureText(const Figure& figure) {
  return figure.value ? FigureText(CutOff(*figure.value)) : "none: " + figure.why;
}

void Show(const StandardSetting& s) {
  Say("Each range in brackets holds the true value in 95 of 100 cases.\n");
  if (s.borderline) {
    const BorderlineCut& b = *s.borderline;
    Say("borderline regression    {} points; {:.2f} points for each step of the rating, R2 {:.2f}, "
        "{} attempts, {} ratings\n",
        FigureText(b.cut), b.points_per_rating, b.explained, b.works, b.ratings);
  } else {
    Say("borderline regression    none: {}\n", s.why_no_borderline);
  }
  if (s.angoff) {
    Say("Angoff                   {} % of the full marks, {} examiners\n",
        FigureText(s.angoff->cut), s.angoff->examiners);
    for (const AngoffCriterion& c : s.angoff->criteria) {
      Say("  {:<34} {:6.2f} of {:g}, spread {:.2f}\n", c.criterion, c.mean, c.full_marks, c.spread);
    }
  } else {
    Say("Angoff                   none: {}\n", s.why_no_angoff);
  }
  if (!s.why_no_agreement.empty()) {
    Say("people's totals          {}\n", s.why_no_agreement);
  } else {
    Say("people's totals\n  ICC(2,1), one mark     {}\n  phi, their mean        {}\n",
        FigureText(s.icc21), FigureText(s.phi));
  }
  if (s.cut && s.why_no_agreement.empty()) {
    Say("  phi(lambda)            {}, their mean as the pass mark cuts it, at {:.2f} points\n",
        FigureText(s.phi_at_cut), *s.cut);
  }
  for (const std::string& warning : s.warnings) Say("WARNING: {}\n", warning);
}

}  // namespace

Status FindStandard(const StandardOptions& options) {
  if (!options.assignment.empty() && options.data.empty()) {
    return Status(Code::kInvalidInput, "expected --data (or ENAMEL_DATA) beside --assignment");
  }
  std::vector<ScoredWork> attempts;
  if (!options.assignment.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(const auto assignment, Uuid::Parse(options.assignment));
    ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(options.data));
    ENAMEL_ASSIGN_OR_RETURN(attempts, ScoredUnder(*store, assignment));
  }
  if (!options.blank.empty()) {
    if (attempts.empty()) {
      return Status(Code::kInvalidInput, "expected --assignment: the criteria of which exercise?");
    }
    return WriteBorderlineForm(options.blank, attempts.front());
  }
  if (options.marks.empty()) {
    return Status(
        Code::kInvalidInput,
        "expected files with marks; enamel-server agreement --blank FILE writes one to be "
        "filled in");
  }
  ENAMEL_ASSIGN_OR_RETURN(auto marks, ReadMarkFiles(options.marks));
  for (Mark& mark : ComputedMarks(attempts)) marks.push_back(std::move(mark));
  ENAMEL_ASSIGN_OR_RETURN(const auto standard, SetStandard(marks, options.cut));
  Show(standard);
  ENAMEL_RETURN_IF_ERROR(
      program::WriteJsonFile(options.json, boost::json::parse(StandardJson(standard)).as_object()));
  if (standard.cut) return Status::Ok();
  return Status(Code::kConflict, "these marks give no cut score: see the reasons above");
}

void DeclareStandard(CommandGroup program) {
  auto [cmd, o] = Declare<StandardOptions>(
      program, "standard", "A pass mark from examiners' ratings and marks", FindStandard);
  cmd->add_option("marks", o.marks, "CSV files (schemas/marks.md)");
  AddData(cmd, o.data)->required(false);
  cmd->add_option("--assignment", o.assignment,
                  "Put its computed points on the ratings, not the examiners' own totals");
  cmd->add_option("--cut", o.cut, "How dependable are decisions at these points, 0 to 100");
  cmd->add_option("--blank", o.blank, "Write a form for Angoff's method, and compute nothing");
  cmd->add_option("--json", o.json, "Write the figures to this file");
  cmd->footer(
      "Borderline regression needs ratings of 8 attempts at least and three different ones; below\n"
      "30 attempts it warns. Angoff's method needs two examiners. agreement --blank makes the "
      "file\n"
      "that examiners fill in.\n"
      "Exit codes: 0 there is a cut score, 1 there is none, and why.");
  AddExample(cmd, std::string("anna.csv ben.csv --assignment ") + kSomeId);
}

}  // namespace enamel::server::app
