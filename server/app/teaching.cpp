#include "server/app/teaching.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <optional>

#include "common/base/file.h"
#include "common/scene/json.h"
#include "server/app/admin.h"
#include "server/app/admin_stations.h"
#include "server/app/data_folder.h"
#include "server/app/publish.h"
#include "server/app/say.h"
#include "server/training/ticket_rules.h"

namespace enamel::server::app {
namespace {

constexpr size_t kMaxDocumentBytes = 1 << 20;

void Show(const ExerciseRow& row) {
  std::string version = row.version == 0 ? "draft" : "version " + std::to_string(row.version);
  Say("{}  {:<10} {:<9} {:<8} {:<32} {}\n", row.id.Text(), version, ExerciseStateName(row.state),
      row.graded ? "graded" : "practice", row.name, row.title);
}

std::string WhenText(UnixMs time_ms, const char* otherwise) {
  return time_ms == 0 ? otherwise : TimeText(time_ms);
}

void Show(const AssignmentRow& row) {
  std::string limit =
      row.attempt_limit == 0 ? "any number" : std::to_string(row.attempt_limit) + " at most";
  std::string cohort = row.cohort.IsZero() ? "everybody" : row.cohort_name;
  std::string stations =
      row.stations.empty() ? "" : fmt::format(", at {} stations", row.stations.size());
  Say("{}  {:<28} {:<20} opens {}, due {}{}, attempts: {}{}{}\n", row.id.Text(), row.exercise,
      cohort, WhenText(row.opens_ms, "at once"), WhenText(row.due_ms, "never"),
      row.late_allowed ? " (late allowed)" : "", limit, row.exam ? ", exam" : "", stations);
}

UnixMs UnixNowMs() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

Result<Uuid> CohortOrEverybody(Store& store, const std::string& name) {
  if (name.empty()) return Uuid{};
  return CohortByName(store, name);
}

Result<std::vector<ExerciseRow>> Publish(Store& store, const NewExercise& exercise,
                                         const std::optional<Uuid>& cohort) {
  if (exercise.document.empty()) {
    auto scene = PublishScene(store, exercise.scene, exercise.voxel_um * 1000);
    if (!scene.ok()) return scene.status();
    return PublishBuiltins(store, *scene, exercise.name, cohort);
  }
  auto text = ReadFile(exercise.document, kMaxDocumentBytes);
  if (!text.ok()) return text.status();
  auto document = scene::ExerciseFromJson(AsText(*text));
  if (!document.ok()) {
    return Status(
        document.status().code(),
        exercise.document + ": " + document.status().field() + ": " + document.status().message(),
        document.status().field());
  }
  auto row = PublishDocument(store, *document, cohort);
  if (!row.ok()) return row.status();
  return std::vector<ExerciseRow>{*row};
}

Result<UnixMs> TimeOrNone(const std::string& text) {
  if (text.empty()) return UnixMs{0};
  return TimeFromText(text);
}

Result<std::vector<Uuid>> StationsByName(Store& store, const std::vector<std::string>& names) {
  std::vector<Uuid> out;
  for (const std::string& name : names) {
    auto station = StationNamed(store, name);
    if (!station.ok()) return station.status();
    out.push_back(station->id);
  }
  return out;
}

}  // namespace

Status PublishExercise(const std::filesystem::path& data, const NewExercise& exercise) {
  if (exercise.scene.empty() == exercise.document.empty()) {
    return Status(Code::kInvalidInput,
                  "publish-exercise needs a scene (--scene) or a document (--document), not both",
                  "scene");
  }
  auto store = OpenForCommand(data);
  if (!store.ok()) return store.status();
  auto cohort = CohortOrEverybody(**store, exercise.cohort);
  if (!cohort.ok()) return cohort.status();
  ENAMEL_RETURN_IF_ERROR(PublishProfiles(**store));
  std::optional<Uuid> assigned_to;
  if (!exercise.unassigned) assigned_to = *cohort;
  auto rows = Publish(**store, exercise, assigned_to);
  if (!rows.ok()) return rows.status();
  for (const ExerciseRow& row : *rows) {
    Say("exercise \"{}\" version {}, id {}\n", row.name, row.version, row.id.Text());
  }
  return Status::Ok();
}

Status RetireExercise(const std::filesystem::path& data, const std::string& name) {
  auto store = OpenForCommand(data);
  if (!store.ok()) return store.status();
  auto versions = (*store)->ExerciseVersions(name);
  if (!versions.ok()) return versions.status();
  if (versions->empty()) {
    return Status(Code::kNotFound, "no exercise named \"" + name + "\"; list-exercises shows them",
                  "name");
  }
  ENAMEL_RETURN_IF_ERROR((*store)->RetireExercise(versions->front().id, kCommandLine));
  Say("{} is no longer offered; what was done with it stays\n", name);
  return Status::Ok();
}

Status ListExercises(const std::filesystem::path& data, const std::string& state) {
  auto store = OpenForCommand(data);
  if (!store.ok()) return store.status();
  for (ExerciseState each :
       {ExerciseState::kDraft, ExerciseState::kPublished, ExerciseState::kRetired}) {
    if (!state.empty() && state != ExerciseStateName(each)) continue;
    auto rows = (*store)->ExercisesIn(each);
    if (!rows.ok()) return rows.status();
    for (const ExerciseRow& row : *rows) Show(row);
  }
  return Status::Ok();
}

Status AssignExercise(const std::filesystem::path& data, const NewAssignment& assignment) {
  auto store = OpenForCommand(data);
  if (!store.ok()) return store.status();
  auto cohort = CohortOrEverybody(**store, assignment.cohort);
  if (!cohort.ok()) return cohort.status();
  auto opens = TimeOrNone(assignment.opens);
  if (!opens.ok()) return opens.status();
  auto due = TimeOrNone(assignment.due);
  if (!due.ok()) return due.status();
  auto stations = StationsByName(**store, assignment.stations);
  if (!stations.ok()) return stations.status();
  AssignmentRow row;
  row.exercise = assignment.exercise;
  row.cohort = *cohort;
  row.opens_ms = *opens;
  row.due_ms = *due;
  row.attempt_limit = assignment.attempt_limit;
  row.exam = assignment.exam;
  row.late_allowed = assignment.late_allowed;
  row.stations = *stations;
  ENAMEL_RETURN_IF_ERROR(CheckTerms(row));
  auto added = (*store)->AddAssignment(row, kCommandLine);
  if (!added.ok()) return added.status();
  Show(*added);
  return Status::Ok();
}

Status EndAssignment(const std::filesystem::path& data, const std::string& id) {
  auto parsed = Uuid::Parse(id);
  if (!parsed.ok()) return parsed.status();
  auto store = OpenForCommand(data);
  if (!store.ok()) return store.status();
  auto row = (*store)->AssignmentById(*parsed);
  if (!row.ok()) return row.status();
  Status deleted = (*store)->DeleteAssignment(row->id, row->revision, kCommandLine);
  if (deleted.ok()) {
    Say("{} is no longer assigned so\n", row->exercise);
    return deleted;
  }
  if (deleted.field() != "attempts") return deleted;
  row->due_ms = UnixNowMs();
  row->late_allowed = false;
  if (row->opens_ms >= row->due_ms) row->opens_ms = 0;
  auto ended = (*store)->ReplaceAssignment(*row, kCommandLine);
  if (!ended.ok()) return ended.status();
  Say("{} is due now, so that nothing begins under it any more; it stays for the attempts that "
      "were "
      "made, which release --assignment releases\n",
      row->exercise);
  return Status::Ok();
}

Status ListAssignments(const std::filesystem::path& data) {
  auto store = OpenForCommand(data);
  if (!store.ok()) return store.status();
  auto rows = (*store)->Assignments({});
  if (!rows.ok()) return rows.status();
  for (const AssignmentRow& row : *rows) Show(row);
  return Status::Ok();
}

Status ReleaseAssignment(const std::filesystem::path& data, const std::string& id) {
  auto parsed = Uuid::Parse(id);
  if (!parsed.ok()) return parsed.status();
  auto store = OpenForCommand(data);
  if (!store.ok()) return store.status();
  auto released = (*store)->ReleaseAssignment(*parsed, kCommandLine);
  if (!released.ok()) return released.status();
  Say("{} scores are released to their students\n", *released);
  return Status::Ok();
}

}  // namespace enamel::server::app
