#include "server/commands/teaching.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <iostream>
#include <optional>

#include "common/base/counted.h"
#include "common/base/file.h"
#include "common/base/in_document.h"
#include "common/base/unix_time.h"
#include "common/scene/json/json.h"
#include "common/scoring/trial.h"
#include "server/app/data_folder.h"
#include "server/app/publish.h"
#include "server/commands/admin.h"
#include "server/commands/admin_stations.h"
#include "server/commands/command_line.h"
#include "server/commands/console_phases.h"
#include "server/commands/prepared.h"
#include "server/commands/say.h"
#include "server/jobs/comparison.h"
#include "server/jobs/exercise_check.h"
#include "server/jobs/exercise_trial.h"
#include "server/training/names.h"
#include "server/training/ticket_rules.h"

namespace enamel::server::app {
namespace {

void Show(const ExerciseRow& row) {
  std::string version = row.version == 0 ? "draft" : "version " + std::to_string(row.version);
  std::string owner = row.owner.IsZero() ? "the school" : row.owner_name;
  Say("{}  {:<10} {:<9} {:<8} {:<32} {} ({}, {})\n", row.id.Text(), version,
      ExerciseStateName(row.state), row.graded ? "graded" : "practice", row.name, row.title, owner,
      row.shared ? "shared" : "private");
}

std::string WhenText(UnixMs time_ms, const char* otherwise) {
  return time_ms == 0 ? otherwise : TimeText(time_ms);
}

void Show(const AssignmentRow& row) {
  std::string limit =
      row.attempt_limit == 0 ? "any number" : std::to_string(row.attempt_limit) + " at most";
  std::string cohort = row.cohort.IsZero() ? "everybody" : row.cohort_name;
  std::string stations =
      row.stations.empty() ? "" : ", at " + Counted(row.stations.size(), "station");
  std::string outline;
  if (row.outline == OutlineShown::kAlways) outline = ", outline always shown";
  if (row.outline == OutlineShown::kNever) outline = ", outline never shown";
  Say("{}  {:<28} version {}  {:<20} opens {}, due {}{}, attempts: {}{}{}, graded work with "
      "{}{}{}\n",
      row.id.Text(), row.exercise, row.version, cohort, WhenText(row.opens_ms, "at once"),
      WhenText(row.due_ms, "never"), row.late_allowed ? " (late allowed)" : "", limit,
      row.sign_off ? ", exam signed at the chair"
      : row.exam   ? ", exam"
                   : "",
      stations, HandsAllowedText(row.hands), outline, row.retired ? ", exercise retired" : "");
}

Result<Uuid> CohortOrEverybody(CohortRows& cohorts, const std::string& name) {
  if (name.empty()) return Uuid{};
  return CohortByName(cohorts, name);
}

Result<scene::Exercise> ReadDocument(const std::filesystem::path& path) {
  ENAMEL_ASSIGN_OR_RETURN(auto text, ReadFile(path, kMaxDocumentBytes));
  auto document = scene::ExerciseFromJson(AsText(text));
  if (!document.ok()) return InDocument(path, document.status());
  return document;
}

void Show(const char* what, const scoring::ScoreResult& score) {
  Say("{}: {:.1f} of 100 points\n", what, score.score);
  for (const scoring::CriticalResult& critical : score.critical)
    Say("  critical error: {}\n", critical.error);
  for (const scoring::LostItem& lost : scoring::LostItems(score))
    Say("  {} costs {:.1f} points\n", lost.name, lost.points);
}

// Whether the document would be published, and what its rubric makes of two attempts without a hand.
Status TryDocument(Store& store, const std::filesystem::path& path) {
  ENAMEL_ASSIGN_OR_RETURN(const auto exercise, ReadDocument(path));
  ENAMEL_RETURN_IF_ERROR(CheckPrepared(store.blobs, store.scenes, exercise));
  if (Status right = CheckExercise(store.blobs, exercise); !right.ok())
    return InDocument(path, right);
  const auto begin = std::chrono::steady_clock::now();
  ENAMEL_ASSIGN_OR_RETURN(const auto trial, TryStored(store.blobs, exercise));
  Show("target cut exactly", trial.exact);
  Show("untouched tooth", trial.untouched);
  for (const std::string& warning : ExerciseWarnings(store.blobs, exercise))
    Say("warning: {}\n", warning);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  Say("tried in {:.1f} s; nothing was published\n", took.count());
  return Status::Ok();
}

Result<std::vector<ExerciseRow>> Publish(Store& store, const NewExercise& exercise,
                                         const std::optional<Uuid>& cohort, ConsolePhases& phases) {
  if (exercise.document.empty()) {
    phases.Begin("loading the tooth of " + exercise.scene);
    ENAMEL_ASSIGN_OR_RETURN(auto scene, PublishScene(store.blobs, store.scenes, exercise.scene,
                                                     exercise.voxel_um * 1000, exercise.material));
    if (!exercise.prepared.empty()) {
      phases.Begin("publishing " + exercise.prepared);
      ENAMEL_ASSIGN_OR_RETURN(auto row, PublishPrepared(store, scene, exercise.prepared, cohort));
      return std::vector<ExerciseRow>{row};
    }
    return PublishBuiltins(store.blobs, store.exercises, scene, exercise.name, cohort,
                           [&](const std::string& name) { phases.Begin("publishing " + name); });
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto document, ReadDocument(exercise.document));
  phases.Begin("publishing " + document.name);
  ENAMEL_RETURN_IF_ERROR(CheckPrepared(store.blobs, store.scenes, document));
  ENAMEL_ASSIGN_OR_RETURN(auto row,
                          PublishDocument(store.blobs, store.exercises, document, cohort));
  return std::vector<ExerciseRow>{row};
}

Status NoSuchExercise(const std::string& name) {
  return Status(Code::kNotFound, "no exercise named \"" + name + "\"; list-exercises shows them",
                "name");
}

// The newest version, or this one.
Result<ExerciseRow> VersionOf(ExerciseRows& exercises_rows, const std::string& name,
                              int32_t version) {
  ENAMEL_ASSIGN_OR_RETURN(const auto rows, exercises_rows.ExerciseVersions(name));
  for (const ExerciseRow& row : rows) {
    if (row.state == ExerciseState::kPublished && (version == 0 || row.version == version)) {
      return row;
    }
  }
  return Status(Code::kNotFound,
                "\"" + name + "\" has no published version" +
                    (version == 0 ? "" : " " + std::to_string(version)) +
                    "; list-exercises shows what there is",
                "exercise");
}

Status MustHaveReference(StoredBlobs& blobs, ReferenceRows& references, const ExerciseRow& version,
                         bool exam) {
  ENAMEL_ASSIGN_OR_RETURN(const bool comparable, HasComparison(blobs, references, version));
  return CheckReference(exam, version, comparable);
}

// What the publisher has to know: others' work does not change, practice may be coarse, and graded
// work needs a reference.
Status SayWhatFollows(Store& store, const ExerciseRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(const auto assignments, store.assignments.Assignments({}));
  for (const AssignmentRow& each : assignments) {
    if (each.exercise != row.name || each.version_id == row.id) continue;
    Say("  assignment {}, {}, stays with version {}; move-assignment moves it\n", each.id.Text(),
        WordsOf(each), each.version);
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto text, store.blobs.GetBlob(row.content));
  ENAMEL_ASSIGN_OR_RETURN(const auto exercise, scene::ExerciseFromJson(AsText(text)));
  for (const std::string& warning : ExerciseWarnings(store.blobs, exercise))
    Say("  warning: {}\n", warning);
  ENAMEL_ASSIGN_OR_RETURN(const bool comparable, HasComparison(store.blobs, store.references, row));
  if (row.graded && !comparable) {
    Say("  it has no reference yet: what is cut is compared with its own target, and scored again "
        "once there is one\n");
  }
  return Status::Ok();
}

Status MustChangeSomething(const Sharing& sharing) {
  if (sharing.shared || sharing.is_private || sharing.school || !sharing.owner.empty()) {
    return Status::Ok();
  }
  return Status(
      Code::kInvalidInput,
      "expected --shared or --private, --owner LOGIN or --school, found none; list-exercises "
      "shows whose each exercise is and whether it is shared");
}

Result<UnixMs> TimeOrNone(const std::string& text) {
  if (text.empty()) return UnixMs{0};
  return TimeFromText(text);
}

Result<std::vector<Uuid>> StationsByName(StationRows& stations,
                                         const std::vector<std::string>& names) {
  std::vector<Uuid> out;
  for (const std::string& name : names) {
    ENAMEL_ASSIGN_OR_RETURN(auto station, StationNamed(stations, name));
    out.push_back(station.id);
  }
  return out;
}

}  // namespace

Status PublishExercise(const std::filesystem::path& data, const NewExercise& exercise) {
  // Both or neither.
  if (exercise.scene.empty() == exercise.document.empty()) {
    return Status(Code::kInvalidInput,
                  "publish-exercise needs a scene (--scene) or a document (--document), not both",
                  "scene");
  }
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ConsolePhases phases;
  if (exercise.dry_run) {
    phases.Begin("scoring two attempts by its rubric");
    return TryDocument(*store, exercise.document);
  }
  ENAMEL_ASSIGN_OR_RETURN(auto cohort, CohortOrEverybody(store->cohorts, exercise.cohort));
  // A ticket needs a device profile. On a server that was never seeded this command is the first
  // chance to store them. One that an admin has put stays.
  ENAMEL_RETURN_IF_ERROR(PublishProfiles(*store));
  std::optional<Uuid> assigned_to;
  if (!exercise.unassigned) assigned_to = cohort;
  ENAMEL_ASSIGN_OR_RETURN(auto rows, Publish(*store, exercise, assigned_to, phases));
  for (const ExerciseRow& row : rows) {
    phases.Begin("checking " + row.name);
    Say("exercise \"{}\" version {}, id {}\n", row.name, row.version, row.id.Text());
    ENAMEL_RETURN_IF_ERROR(SayWhatFollows(*store, row));
  }
  return Status::Ok();
}

Status RetireExercise(const std::filesystem::path& data, const std::string& name,
                      const std::string& reason) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto versions, store->exercises.ExerciseVersions(name));
  if (versions.empty()) return NoSuchExercise(name);
  std::string why;
  if (!reason.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(why, CheckedReason(reason, "reason"));
  }
  ENAMEL_RETURN_IF_ERROR(store->exercises.RetireExercise(versions.front().id, kCommandLine, why));
  ENAMEL_ASSIGN_OR_RETURN(const auto assigned, store->assignments.Assignments({}));
  const auto now_ms = UnixMs();
  const auto running = std::ranges::count_if(assigned, [&](const AssignmentRow& row) {
    return row.exercise == name && (row.due_ms == 0 || row.due_ms > now_ms);
  });
  Say("{} is no longer offered; what was done with it stays. {}offer-exercise takes this back\n",
      name,
      running == 0 ? std::string()
                   : Counted(static_cast<size_t>(running), "assignment") +
                         " of it can be finished until they end. ");
  return Status::Ok();
}

Status OfferExercise(const std::filesystem::path& data, const std::string& name) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto versions, store->exercises.ExerciseVersions(name));
  if (versions.empty()) return NoSuchExercise(name);
  ENAMEL_RETURN_IF_ERROR(store->exercises.OfferExerciseAgain(versions.front().id, kCommandLine));
  Say("{} is offered again, as it was before it was retired\n", name);
  return Status::Ok();
}

Status ListExercises(const std::filesystem::path& data, const std::string& state) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  for (ExerciseState each :
       {ExerciseState::kDraft, ExerciseState::kPublished, ExerciseState::kRetired}) {
    if (!state.empty() && state != ExerciseStateName(each)) continue;
    ENAMEL_ASSIGN_OR_RETURN(auto rows, store->exercises.ExercisesIn(each));
    for (const ExerciseRow& row : rows) Show(row);
  }
  return Status::Ok();
}

Status AssignExercise(const std::filesystem::path& data, const NewAssignment& assignment) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto cohort, CohortOrEverybody(store->cohorts, assignment.cohort));
  ENAMEL_ASSIGN_OR_RETURN(auto opens, TimeOrNone(assignment.opens));
  ENAMEL_ASSIGN_OR_RETURN(auto due, TimeOrNone(assignment.due));
  ENAMEL_ASSIGN_OR_RETURN(auto stations, StationsByName(store->stations, assignment.stations));
  AssignmentRow row;
  row.exercise = assignment.exercise;
  row.cohort = cohort;
  row.opens_ms = opens;
  row.due_ms = due;
  row.attempt_limit = assignment.attempt_limit;
  row.exam = assignment.exam;
  row.late_allowed = assignment.late_allowed;
  row.stations = stations;
  row.sign_off = assignment.sign_off;
  const auto hands = HandsAllowedFromName(assignment.hands);
  if (!hands) {
    return Status(Code::kInvalidInput,
                  "expected listed, haptic, pointer or any, found \"" + assignment.hands + "\"",
                  "hands");
  }
  row.hands = *hands;
  row.counting = CountingFromName(assignment.counting).value_or(Counting::kBest);
  row.outline = OutlineShownFromName(assignment.outline).value_or(OutlineShown::kPractice);
  ENAMEL_RETURN_IF_ERROR(CheckTerms(row));
  ENAMEL_ASSIGN_OR_RETURN(const auto version, VersionOf(store->exercises, row.exercise, 0));
  ENAMEL_RETURN_IF_ERROR(MustHaveReference(store->blobs, store->references, version, row.exam));
  ENAMEL_ASSIGN_OR_RETURN(auto added, store->assignments.AddAssignment(row, kCommandLine));
  Show(added);
  // Not refused: somebody who imports work from elsewhere assigns exercises that are over.
  if (added.due_ms != 0 && added.due_ms <= enamel::UnixMs()) {
    Say("this due time has passed: {}. Assign again with a later --due.\n",
        added.late_allowed ? "every attempt will be late" : "nobody can begin any more");
  }
  return Status::Ok();
}

Status ShareExercise(const std::filesystem::path& data, const Sharing& sharing) {
  ENAMEL_RETURN_IF_ERROR(MustChangeSomething(sharing));
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(const auto versions, store->exercises.ExerciseVersions(sharing.exercise));
  if (versions.empty()) return NoSuchExercise(sharing.exercise);
  SharingEdit edit;
  if (sharing.shared || sharing.is_private) edit.shared = sharing.shared;
  if (sharing.school) edit.owner = Uuid{};
  if (!sharing.owner.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(const auto person, PersonNamed(store->people, sharing.owner));
    edit.owner = person.id;
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto row,
                          store->exercises.ShareExercise(versions.front().id, edit, kCommandLine));
  Show(row);
  return Status::Ok();
}

Status MoveAssignment(const std::filesystem::path& data, const std::string& id, int32_t version,
                      bool dry_run) {
  ENAMEL_ASSIGN_OR_RETURN(const auto parsed, Uuid::Parse(id));
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(const auto row, store->assignments.AssignmentById(parsed));
  ENAMEL_ASSIGN_OR_RETURN(const auto to, VersionOf(store->exercises, row.exercise, version));
  if (to.id == row.version_id) {
    Say("{} stays with version {}; nothing was changed\n", WordsOf(row), row.version);
    return Status::Ok();
  }
  ENAMEL_RETURN_IF_ERROR(MustHaveReference(store->blobs, store->references, to, row.exam));
  ENAMEL_ASSIGN_OR_RETURN(const auto move, store->assignments.MoveAssignment(
                                               row.id, to.id, row.revision, dry_run, kCommandLine));
  Say("{} {} from version {} to {}; {} theirs, {} not used yet\n", row.exercise,
      dry_run ? "would move" : "moves", move.before.version, move.after.version,
      Counted(move.attempts, "attempt keeps", "attempts keep"),
      Counted(move.tickets, "of them a ticket that is", "of them tickets that are"));
  return Status::Ok();
}

Status EndAssignment(const std::filesystem::path& data, const std::string& id) {
  ENAMEL_ASSIGN_OR_RETURN(auto parsed, Uuid::Parse(id));
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto row, store->assignments.AssignmentById(parsed));
  Status deleted = store->assignments.DeleteAssignment(row.id, row.revision, kCommandLine);
  if (deleted.ok()) {
    Say("this assignment of {} was removed\n", row.exercise);
    return deleted;
  }
  // The store says by this field that attempts are the reason; any other refusal is the caller's to
  // hear.
  if (deleted.field() != "attempts") return deleted;
  row.due_ms = enamel::UnixMs();
  // An assignment with attempts stays for their release. Due now, and with nobody let in late, it
  // comes to the same for students.
  row.late_allowed = false;
  // Terms have to open before they are due (CheckTerms), also those that had not opened yet.
  if (row.opens_ms >= row.due_ms) row.opens_ms = 0;
  ENAMEL_ASSIGN_OR_RETURN(auto ended, store->assignments.ReplaceAssignment(row, kCommandLine));
  Say("{} is due now, and no attempt can begin under this assignment any more. It stays for the "
      "attempts made under it; release --assignment lets students see their scores\n",
      row.exercise);
  return Status::Ok();
}

Status ListAssignments(const std::filesystem::path& data) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto rows, store->assignments.Assignments({}));
  for (const AssignmentRow& row : rows) Show(row);
  return Status::Ok();
}

Status ReleaseAssignment(const std::filesystem::path& data, const std::string& id) {
  ENAMEL_ASSIGN_OR_RETURN(auto parsed, Uuid::Parse(id));
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto released, store->judging.ReleaseAssignment(parsed, kCommandLine));
  Say("{}\n", Counted(released, "score is released to its student",
                      "scores are released to their students"));
  return Status::Ok();
}

namespace {

constexpr char kExerciseHelp[] = "Name of the exercise (list-exercises)";
constexpr char kAssignmentHelp[] = "Id of the assignment (list-assignments)";

}  // namespace

void DeclareExercises(CommandGroup admin) {
  struct Publishing {
    std::filesystem::path data;
    NewExercise exercise;
  };
  auto [publish, p] =
      Declare<Publishing>(admin, "publish-exercise", "Offer exercises on a scene",
                          [](const Publishing& o) { return PublishExercise(o.data, o.exercise); });
  AddData(publish, p.data);
  publish->add_option("--scene", p.exercise.scene, "Scene folder, or builtin:molar and the like");
  publish->add_option("--name", p.exercise.name,
                      "Only this one, or this kind: class-1, class-2, crown, cross");
  auto* document =
      publish->add_option("--document", p.exercise.document,
                          "Instead: file with an exercise (schemas/exercise.schema.json)");
  publish
      ->add_flag("--dry-run", p.exercise.dry_run,
                 "Only check the document and score two attempts by its rubric: the target cut "
                 "exactly, and an untouched tooth")
      ->needs(document);
  publish->add_option(
      "--material", p.exercise.material,
      "On the scene: file of 'enamel-lab fit-damping' that says what cutting its tissues "
      "takes (schemas/material.schema.json)");
  publish->add_option("--prepared", p.exercise.prepared,
                      "On the scene: the target that 'enamel-station target' wrote to this folder");
  auto* cohort =
      publish->add_option("--cohort", p.exercise.cohort, "Cohort it is for; without: everybody");
  publish
      ->add_flag("--unassigned", p.exercise.unassigned,
                 "Publish without assigning it; use assign-exercise for cohorts and dates")
      ->excludes(cohort);
  publish->add_option("--voxel-um", p.exercise.voxel_um, "Voxel size of a built-in scene")
      ->check(CLI::Range(20, 500))
      ->capture_default_str();
  publish->footer(
      "A document that differs from the newest version of its name becomes the next version;\n"
      "a published version never changes. It is offered for any device, even a\n"
      "simulated hand. For dates, limits, exams and allowed devices: --unassigned, then\n"
      "assign-exercise. Of a scene each graded exercise also comes as practice, named\n"
      "practice-NAME: students see target, progress and score at once.\n"
      "builtin:molar-by-load and the like have tissue that a hand's load cuts.");
  AddExample(publish, "--scene builtin:molar --name class-1 --cohort \"Year 3\"");

  struct Named {
    std::filesystem::path data;
    std::string name, state, reason;
  };
  auto [retire, r] =
      Declare<Named>(admin, "retire-exercise", "Stop offering it: no version can be assigned",
                     [](const Named& o) { return RetireExercise(o.data, o.name, o.reason); });
  AddData(retire, r.data);
  retire->add_option("--name", r.name, kExerciseHelp)->required();
  retire->add_option("--reason", r.reason, "Why, for the audit trail");
  AddExample(retire, "--name class-1-molar-46 --reason \"replaced by class-2\"");
  auto [offer, f] =
      Declare<Named>(admin, "offer-exercise", "Offer again what was retired, as it was before",
                     [](const Named& o) { return OfferExercise(o.data, o.name); });
  AddData(offer, f.data);
  offer->add_option("--name", f.name, kExerciseHelp)->required();
  AddExample(offer, "--name class-1-molar-46");

  struct Share {
    std::filesystem::path data;
    Sharing sharing;
  };
  auto [share, s] = Declare<Share>(
      admin, "share-exercise", "Set who owns an exercise, and whether other instructors may use it",
      [](const Share& o) { return ShareExercise(o.data, o.sharing); });
  AddData(share, s.data);
  share->add_option("--exercise", s.sharing.exercise, "Its name")->required();
  auto* shared = share->add_flag("--shared", s.sharing.shared, "Others may read and assign it");
  share->add_flag("--private", s.sharing.is_private, "They may not")->excludes(shared);
  auto* owner = share->add_option("--owner", s.sharing.owner, "Login of an instructor");
  share->add_flag("--school", s.sharing.school, "The school's: admins change it")->excludes(owner);
  share->parse_complete_callback([&sharing = s.sharing] {
    if (Status asked = MustChangeSomething(sharing); !asked.ok())
      throw CLI::ValidationError("share-exercise", asked.message());
  });
  AddExample(share, "--exercise class-1-molar-46 --owner anna --shared");

  auto [list, l] =
      Declare<Named>(admin, "list-exercises", "Drafts, published and retired exercises",
                     [](const Named& o) { return ListExercises(o.data, o.state); });
  AddData(list, l.data);
  list->add_option("--state", l.state, "Only these")
      ->check(CLI::IsMember({"draft", "published", "retired"}));
  AddExample(list, "--state published");
}

void DeclareAssignments(CommandGroup admin) {
  struct Assigning {
    std::filesystem::path data;
    NewAssignment assignment;
  };
  auto [assign, a] =
      Declare<Assigning>(admin, "assign-exercise", "Assign an exercise to a cohort",
                         [](const Assigning& o) { return AssignExercise(o.data, o.assignment); });
  AddData(assign, a.data);
  NewAssignment& row = a.assignment;
  assign
      ->add_option("--exercise", row.exercise,
                   "Its name; its newest version is assigned, and stays")
      ->required();
  assign->add_option("--cohort", row.cohort, "Cohort it is for; without: everybody");
  assign->add_option("--opens", row.opens,
                     "Not before: \"2026-11-20 09:00\", in this computer's time zone, or "
                     "\"2026-11-20 09:00+01:00\"");
  assign->add_option("--due", row.due,
                     "Not after; an attempt begun in time may end later, flagged as late");
  assign->add_option("--attempts", row.attempt_limit, "Attempts each; 0: no limit")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  assign->add_flag("--late", row.late_allowed, "Let attempts begin after it is due, flagged");
  assign->add_flag("--exam", row.exam,
                   "No score before it is released; begun online, one at a time");
  assign->add_flag("--sign-off", row.sign_off,
                   "An exam begins once an instructor has signed at the chair with a PIN");
  assign->add_option("--counts", row.counting, "Which of several attempts is the result")
      ->check(CLI::IsMember({"best", "last", "mean", "median"}))
      ->capture_default_str();
  assign->add_option("--station", row.stations, "Where the exam is taken (repeatable)");
  assign
      ->add_option(
          "--hands", row.hands,
          "What may hold the tool in graded work and exams: haptic devices on the school's "
          "list, every haptic device, a mouse too, or any, also a simulated hand")
      ->check(CLI::IsMember({"listed", "haptic", "pointer", "any"}))
      ->capture_default_str();
  assign
      ->add_option(
          "--outline", row.outline,
          "In which work the chair shows the target's outline on the tooth: in practice only, "
          "always (in graded work and exams too), or never")
      ->check(CLI::IsMember({"practice", "always", "never"}))
      ->capture_default_str();
  AddExample(assign,
             "--exercise class-1-molar-46 --cohort \"Year 3\" --due \"2026-12-01 12:00\" --exam");

  struct Named {
    std::filesystem::path data;
    std::string id;
  };
  struct Moving {
    std::filesystem::path data;
    std::string id;
    int32_t version = 0;
    bool dry_run = false;
  };
  auto [move, m] = Declare<Moving>(
      admin, "move-assignment", "Move an assignment to another version of its exercise",
      [](const Moving& o) { return MoveAssignment(o.data, o.id, o.version, o.dry_run); });
  AddData(move, m.data);
  move->add_option("--assignment", m.id, kAssignmentHelp)->required();
  move->add_option("--version", m.version, "Without: the newest")->check(CLI::PositiveNumber);
  move->add_flag("--dry-run", m.dry_run, "Show what would move; change nothing");
  AddExample(move, std::string("--assignment ") + kSomeId + " --dry-run");

  auto [end, e] = Declare<Named>(
      admin, "end-assignment",
      "Remove an assignment; one with attempts is due now instead, and stays for their release",
      [](const Named& o) { return EndAssignment(o.data, o.id); });
  AddData(end, e.data);
  end->add_option("--assignment", e.id, kAssignmentHelp)->required();
  AddExample(end, std::string("--assignment ") + kSomeId);

  auto [list, l] = Declare<Named>(admin, "list-assignments", "Assignments, by due time",
                                  [](const Named& o) { return ListAssignments(o.data); });
  AddData(list, l.data);
  AddExample(list, "");
}

}  // namespace enamel::server::app
