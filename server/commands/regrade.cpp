#include "server/commands/regrade.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <iostream>
#include <map>
#include <set>

#include "common/base/counted.h"
#include "common/base/file.h"
#include "common/base/in_document.h"
#include "common/scene/json/json.h"
#include "server/app/data_folder.h"
#include "server/commands/admin.h"
#include "server/commands/command_line.h"
#include "server/commands/console_phases.h"
#include "server/commands/say.h"
#include "server/jobs/regrade.h"

namespace enamel::server::app {
namespace {

// One mark stands for one attempt until a row would be longer than this.
constexpr uint32_t kWidth = 40;

// The newest that was published, also when it is not offered any more: its attempts are there.
Result<ExerciseRow> NewestPublished(ExerciseRows& exercises_rows, const std::string& name) {
  ENAMEL_ASSIGN_OR_RETURN(auto versions, exercises_rows.ExerciseVersions(name));
  for (const ExerciseRow& row : versions) {
    if (row.state != ExerciseState::kDraft) return row;
  }
  return Status(Code::kNotFound, "no published exercise \"" + name +
                                     "\"; enamel-server admin list-exercises shows their names");
}

Result<scene::Rubric> RubricOf(StoredBlobs& blobs, RubricRows& rubrics, const ExerciseRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(auto text, blobs.GetBlob(row.content));
  ENAMEL_ASSIGN_OR_RETURN(auto document, scene::ExerciseFromJson(AsText(text)));
  return CountingRubric(blobs, rubrics, row.id, document.rubric);
}

Result<scene::Rubric> ReadRubric(const std::filesystem::path& file) {
  ENAMEL_ASSIGN_OR_RETURN(auto text, ReadFile(file, kMaxDocumentBytes));
  auto rubric = scene::RubricFromJson(AsText(text));
  if (rubric.ok()) return rubric;
  return InDocument(file.string(), rubric.status());
}

std::string ScoreText(double score, bool failed) {
  return fmt::format("{:5.1f}{}", score, failed ? " failed" : "       ");
}

void ShowHistogram(const RubricPreview& preview) {
  uint32_t most = 1;
  for (size_t i = 0; i < preview.before.size(); ++i) {
    most = std::max({most, preview.before[i], preview.after[i]});
  }
  const uint32_t each = (most + kWidth - 1) / kWidth;
  auto bar = [&](uint32_t count) { return std::string((count + each - 1) / each, '#'); };
  Say("\n  score    {:<{}}  after\n", "before", kWidth);
  for (size_t i = preview.before.size(); i-- > 0;) {
    Say("{:4}-{:<4} {:<{}}  {}\n", i * 10, i == 9 ? 100 : i * 10 + 10, bar(preview.before[i]),
        kWidth, bar(preview.after[i]));
  }
  if (each > 1) Say("Each # shows {}.\n", Counted(each, "attempt"));
}

void ShowPreview(const RubricPreview& preview) {
  if (preview.attempts.empty()) {
    Say("No attempt at it is scored yet, so there is nothing to compare. Nothing was changed.\n");
    return;
  }
  for (const RegradedAttempt& a : preview.attempts) {
    if (!a.problem.empty()) {
      Say("{}  {}          ?      {:<24} {}\n", a.row.id.Text(),
          ScoreText(a.before, a.failed_before), a.row.person_name, a.problem);
      continue;
    }
    Say("{}  {} {}  {:+6.1f}  {}{}\n", a.row.id.Text(), ScoreText(a.before, a.failed_before),
        ScoreText(a.after, a.failed_after), a.change(), a.row.person_name,
        std::string(a.row.overridden ? " (a person's score counts instead)" : "") +
            (a.other_references ? " (against other references)" : ""));
  }
  const size_t told = preview.attempts.size() - preview.problems;
  if (told > 0) ShowHistogram(preview);
  Say("\n{}: {} would gain, {} would lose, {} stay; mean {:.1f} before, {:.1f} after",
      Counted(told, "attempt"), preview.raised, preview.lowered,
      told - preview.raised - preview.lowered, preview.mean_before, preview.mean_after);
  if (preview.problems > 0) Say("; {} cannot be compared", preview.problems);
  Say(".\n");
  if (preview.other_references > 0) {
    Say("{} measured against other references than those that count now. Scoring again measures "
        "against these, so the change may be larger.\n",
        Counted(preview.other_references, "of them was", "of them were"));
  }
  if (preview.withdrawn > 0) {
    Say("{} released: after scoring again it must be released again.\n",
        Counted(preview.withdrawn, "of those that change is", "of those that change are"));
  }
  Say("Nothing was changed.\n");
}

// Attempts by exercise version, each with its own rubric.
Result<std::map<Uuid, std::vector<Uuid>>> ByExercise(AttemptRows& attempts_rows,
                                                     ExerciseRows& exercises, const Uuid& cohort,
                                                     const std::string& exercise) {
  std::set<Uuid> versions;
  if (!exercise.empty()) {
    ENAMEL_RETURN_IF_ERROR(NewestPublished(exercises, exercise).status());
    ENAMEL_ASSIGN_OR_RETURN(auto rows, exercises.ExerciseVersions(exercise));
    for (const ExerciseRow& row : rows) versions.insert(row.id);
  }
  AttemptFilter which;
  which.cohort = cohort;
  ENAMEL_ASSIGN_OR_RETURN(auto attempts, ScoredAttempts(attempts_rows, which));
  std::map<Uuid, std::vector<Uuid>> out;
  for (const AttemptRow& row : attempts) {
    if (versions.empty() || versions.count(row.exercise) > 0) out[row.exercise].push_back(row.id);
  }
  return out;
}

}  // namespace

Status ShowRubric(const std::filesystem::path& data, const std::string& exercise,
                  const std::filesystem::path& out) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto row, NewestPublished(store->exercises, exercise));
  ENAMEL_ASSIGN_OR_RETURN(auto rubric, RubricOf(store->blobs, store->rubrics, row));
  const std::string text = scene::ToJson(rubric);
  if (out.empty()) {
    std::cout << text;
    return Status::Ok();
  }
  if (std::filesystem::exists(out)) {
    return Status(Code::kConflict, out.string() + " is there already; name a new file");
  }
  return WriteFileDurably(out, AsBytes(text));
}

Status CorrectRubric(const std::filesystem::path& data, const Correction& correction) {
  ENAMEL_ASSIGN_OR_RETURN(auto rubric, ReadRubric(correction.document));
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto row, NewestPublished(store->exercises, correction.exercise));
  // Also before a preview: the points there are given by these bands.
  const auto warnings = RubricWarnings(*store, row, rubric, false);
  for (const std::string& warning : warnings) Say("warning: {}\n", warning);
  if (correction.preview) {
    AttemptFilter which;
    which.exercise = row.id;
    ENAMEL_ASSIGN_OR_RETURN(const auto counting, store->references.Counting(row.id));
    ConsolePhases phases;
    phases.Begin("computing the points of each scored attempt at " + row.name);
    ENAMEL_ASSIGN_OR_RETURN(auto preview, PreviewRubric(*store, which, rubric, counting));
    ShowPreview(preview);
    return Status::Ok();
  }
  if (correction.reason.find_first_not_of(" \t\r\n") == std::string::npos) {
    return Status(Code::kInvalidInput, "expected --reason: it is kept with the correction");
  }
  ENAMEL_ASSIGN_OR_RETURN(auto counting, RubricOf(store->blobs, store->rubrics, row));
  auto made = PublishCorrection(*store, row.id, rubric, counting.version, correction.reason,
                                correction.anyway, kCommandLine);
  if (!made.ok()) return InsistWith(made.status(), "--anyway REASON");
  const RubricRow& published = *made;
  Say("The rubric of {} version {} now has version {}. Existing scores stay; to compute them "
      "again:\n"
      "  enamel-server rescore --data {} --cohort NAME --exercise {}\n",
      row.name, row.version, published.version, data.string(), row.name);
  return Status::Ok();
}

Status RescoreCohort(const std::filesystem::path& data, const Regrading& regrading) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto cohort, CohortByName(store->cohorts, regrading.cohort));
  ENAMEL_ASSIGN_OR_RETURN(
      auto exercises, ByExercise(store->attempts, store->exercises, cohort, regrading.exercise));
  std::vector<Uuid> all;
  ConsolePhases phases;
  for (const auto& [exercise, attempts] : exercises) {
    all.insert(all.end(), attempts.begin(), attempts.end());
    if (!regrading.preview) continue;
    ENAMEL_ASSIGN_OR_RETURN(auto row, store->exercises.ExerciseById(exercise));
    ENAMEL_ASSIGN_OR_RETURN(auto rubric, RubricOf(store->blobs, store->rubrics, row));
    AttemptFilter which;
    which.cohort = cohort;
    which.exercise = exercise;
    ENAMEL_ASSIGN_OR_RETURN(const auto counting, store->references.Counting(exercise));
    phases.Begin("computing the points of " + Counted(attempts.size(), "attempt") + " at " +
                 row.name);
    ENAMEL_ASSIGN_OR_RETURN(auto preview, PreviewRubric(*store, which, rubric, counting));
    Say("{} version {}, rubric version {}:\n\n", row.name, row.version, rubric.version);
    ShowPreview(preview);
  }
  if (all.empty()) {
    return Status(Code::kNotFound, "nobody in " + regrading.cohort + " has a scored attempt" +
                                       (regrading.exercise.empty() ? "" : " of this exercise"));
  }
  if (regrading.preview) return Status::Ok();
  BatchRow batch;
  batch.title = regrading.cohort + (regrading.exercise.empty() ? "" : ", " + regrading.exercise);
  batch.cause = "rubric";
  batch.cohort = cohort;
  uint32_t left_out = 0;
  ENAMEL_ASSIGN_OR_RETURN(auto queued,
                          store->batches.RescoreTogether(batch, all, left_out, kCommandLine));
  Say("{} queued; the server computes them and keeps the earlier scores.\n",
      Counted(queued.queued, "run is", "runs are"));
  if (left_out > 0) {
    Say("{} left out: a run is already waiting, or the recording was removed.\n",
        Counted(left_out, "attempt was", "attempts were"));
  }
  return Status::Ok();
}

void DeclareRubrics(CommandGroup admin) {
  struct Showing {
    std::filesystem::path data, out;
    std::string exercise;
  };
  auto [show, s] =
      Declare<Showing>(admin, "show-rubric", "Print the current rubric as a document to edit",
                       [](const Showing& o) { return ShowRubric(o.data, o.exercise, o.out); });
  AddData(show, s.data);
  show->add_option("--exercise", s.exercise, "Its name; the newest version is used")->required();
  show->add_option("--out", s.out, "A new file; without: standard output");
  AddExample(show, "--exercise class-1-molar-46 --out rubric.json");

  struct Correcting {
    std::filesystem::path data;
    Correction correction;
  };
  auto [correct, c] =
      Declare<Correcting>(admin, "publish-rubric", "Correct the rubric of a published exercise",
                          [](const Correcting& o) { return CorrectRubric(o.data, o.correction); });
  AddData(correct, c.data);
  correct->add_option("--exercise", c.correction.exercise, "Its name; the newest version is used")
      ->required();
  correct
      ->add_option("--document", c.correction.document,
                   "File with a rubric (schemas/rubric.schema.json)")
      ->required();
  correct->add_option("--reason", c.correction.reason, "Why; kept with the correction");
  correct->add_option("--anyway", c.correction.anyway,
                      "Why, although it is another exercise's rubric or takes points from the "
                      "reference itself; kept with the reason");
  correct->add_flag("--preview", c.correction.preview,
                    "Show what it would change for the scored attempts; change nothing");
  correct->footer(
      "A published exercise and its recordings never change; only how they are judged does.\n"
      "show-rubric writes the document to edit; rescore applies it to attempts that have a score.");
  AddExample(correct, "--exercise class-1-molar-46 --document rubric.json --preview");
}

void DeclareRescore(CommandGroup program) {
  struct Rescoring {
    std::filesystem::path data;
    Regrading regrading;
  };
  auto [rescore, r] = Declare<Rescoring>(
      program, "rescore", "Score a cohort's attempts again, with the current rubric and reference",
      [](const Rescoring& o) { return RescoreCohort(o.data, o.regrading); });
  AddData(rescore, r.data);
  rescore->add_option("--cohort", r.regrading.cohort, "Its name")->required();
  rescore->add_option("--exercise", r.regrading.exercise,
                      "Only this one, all its versions; without: all");
  rescore->add_flag("--preview", r.regrading.preview,
                    "Show the points that the current rubric would give; change nothing");
  rescore->footer(
      "Earlier scores are kept. A released score that changes is withdrawn until it is released "
      "again.");
  AddExample(rescore, "--cohort \"Year 3\" --exercise class-1-molar-46 --preview");
}

}  // namespace enamel::server::app
