#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "common/base/mutex.h"
#include "common/scene/json/json.h"
#include "common/scene/json/preparation.h"
#include "common/scene/volume_blob.h"
#include "common/scoring/score.h"
#include "common/surface/surface.h"
#include "server/http/caller.h"
#include "server/http/error_response.h"
#include "server/http/etag.h"
#include "server/http/handlers/checked_exercise.h"
#include "server/http/handlers/seen_exercise.h"
#include "server/http/json_body.h"
#include "server/http/kept.h"
#include "server/http/operations.h"
#include "server/http/paging.h"
#include "server/http/query.h"
#include "server/http/views/attempt_view.h"
#include "server/http/views/exercise_view.h"
#include "server/jobs/exercise_check.h"
#include "server/jobs/regrade.h"
#include "server/jobs/surface_blob.h"
#include "server/training/access.h"
#include "server/training/names.h"
#include "server/training/revision.h"

namespace enamel::server::http {
namespace json = boost::json;
namespace {

// One page of attempts. A person with more gets a count that is too low. No rule depends on it: the
// store counts for limits.
constexpr uint32_t kCountedAttempts = 200;

Result<std::map<Uuid, int>> OwnAttempts(const Call& call, AttemptRows& attempts_rows) {
  AttemptFilter filter;
  filter.person = call.caller->person.id;
  filter.limit = kCountedAttempts;
  ENAMEL_ASSIGN_OR_RETURN(std::vector<AttemptRow> attempts, attempts_rows.Attempts(filter));
  std::map<Uuid, int> count;
  for (const AttemptRow& attempt : attempts) ++count[attempt.exercise];
  return count;
}

// The exercises of a list: the caller's own, or for editors all in a state.
Result<std::vector<ExerciseRow>> ListedExercises(const Call& call, ExerciseRows& exercises) {
  auto wanted = call.request.query.find("state");
  if (wanted == call.request.query.end()) return VisibleExercises(call, exercises);
  std::optional<ExerciseState> state = ExerciseStateFromName(wanted->second);
  if (!state) {
    return Status{Code::kInvalidInput, "expected draft, published or retired", "state"};
  }
  if (!CanEditExercises(call.caller->person)) {
    return Status{Code::kForbidden, "only instructors and admins see other states; leave out state",
                  "state"};
  }
  Result<std::vector<ExerciseRow>> rows = exercises.ExercisesIn(*state);
  ENAMEL_RETURN_IF_ERROR(rows.status());
  Result<std::vector<ExerciseRow>> assigned = VisibleExercises(call, exercises);
  ENAMEL_RETURN_IF_ERROR(assigned.status());
  // Hides others' private exercises, except those that the caller's cohorts work on.
  std::erase_if(*rows, [&](const ExerciseRow& row) {
    return !CanUseExercise(call.caller->person, row) &&
           (row.state == ExerciseState::kDraft ||
            std::ranges::find(*assigned, row.name, &ExerciseRow::name) == assigned->end());
  });
  return rows;
}

// The exercise with all of its document, as one that may be edited.
Result<json::object> WholeJson(const Call& call, Store& store, const ExerciseRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(auto attempts, OwnAttempts(call, store.attempts));
  Result<ExerciseDocument> exercise = DocumentOf(store.blobs, row);
  if (!exercise.ok()) return Status{Code::kInternal, exercise.status().message()};
  ENAMEL_ASSIGN_OR_RETURN(std::optional<ReferenceRow> reference,
                          store.references.ReferenceFor(row.id));
  json::object out =
      SummaryJson(call.caller->person, row, **exercise, reference.has_value(), attempts[row.id]);
  AddWhole(store.blobs, row, **exercise, out);
  Result<scene::Rubric> rubric =
      CountingRubric(store.blobs, store.rubrics, row.id, (*exercise)->rubric);
  if (!rubric.ok()) return Status{Code::kInternal, rubric.status().message()};
  out.emplace("rubric", RubricJson(*rubric));
  return out;
}

Result<Response> WholeResponse(const Call& call, Store& store, const ExerciseRow& row,
                               int status = 200) {
  ENAMEL_ASSIGN_OR_RETURN(json::object out, WholeJson(call, store, row));
  return WithETag(JsonResponse(out, status), row.revision);
}

Result<ExerciseRow> UploadedExercise(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(scene::Exercise exercise, CheckedExercise(call, store));
  ExerciseRow row;
  row.name = exercise.name;
  row.title = exercise.title;
  row.scene = exercise.scene;
  row.graded = exercise.graded;
  // As our own writer spells it: equal exercises then have equal hashes, which is how publishing
  // finds out that nothing has changed.
  ENAMEL_ASSIGN_OR_RETURN(Sha256 content, store.blobs.PutBlob(AsBytes(scene::ToJson(exercise))));
  row.content = content;
  return row;
}

// Checks that the caller may edit it, and returns the revision the caller has seen.
Result<int32_t> SeenRevision(const Call& call, AttemptRows& attempts, ExerciseRows& exercises) {
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow row, ChangeableExercise(call, attempts, exercises));
  return IfMatch(call.request);
}

// Why a change of an exercise did not happen.
Result<Response> Refused(const Call& call, Store& store, const Status& status) {
  if (status.field() != kStale) return status;
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow now, store.exercises.ExerciseById(call.id));
  ENAMEL_ASSIGN_OR_RETURN(json::object current, WholeJson(call, store, now));
  return Stale(status, current, now.revision);
}

// The volumes whose surface is being computed now, over all threads.
class Making {
 public:
  explicit Making(const Sha256& volume) : volume_(volume) {
    MutexLock lock(made.mutex);
    first_ = made.volumes.insert(volume_).second;
  }
  ~Making() {
    if (!first_) return;
    MutexLock lock(made.mutex);
    made.volumes.erase(volume_);
  }
  Making(const Making&) = delete;
  Making& operator=(const Making&) = delete;
  bool first() const { return first_; }

 private:
  struct Volumes {
    Mutex mutex;
    std::set<Sha256> volumes ENAMEL_GUARDED_BY(mutex);
  };
  // Over all requests of the process. Two servers on one store would both make it, and write the
  // same blob.
  inline static Volumes made;
  Sha256 volume_;
  bool first_ = false;
};

Result<SceneRow> SceneOf(SceneRows& scenes_rows, const ExerciseRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(std::vector<SceneRow> scenes, scenes_rows.Scenes());
  auto scene = std::ranges::find(scenes, row.scene, &SceneRow::content);
  if (scene != scenes.end()) return *scene;
  return Status{Code::kInternal, "the exercise's scene is not stored"};
}

Result<Sha256> MakeSurface(StoredBlobs& blobs, SceneRows& scenes, const Sha256& volume_hash) {
  ENAMEL_ASSIGN_OR_RETURN(Bytes blob, blobs.GetBlob(volume_hash));
  ENAMEL_ASSIGN_OR_RETURN(cutting::Volume volume, scene::DecodeVolume(blob));
  // Seconds of work for a fine tooth, on a thread that requests wait for: hence once, and kept.
  Result<Sha256> surface = blobs.PutBlob(EncodeSurface(surface::ExtractSurface(volume)));
  ENAMEL_RETURN_IF_ERROR(surface.status());
  ENAMEL_RETURN_IF_ERROR(scenes.PutSceneSurface(volume_hash, *surface));
  return surface;
}

// Made once per scene and kept. A request that comes meanwhile is asked to come again, so that it
// does not hold a thread that others' requests wait for.
Result<Sha256> InitialSurface(StoredBlobs& blobs, SceneRows& scenes, const ExerciseRow& row) {
  Result<SceneRow> scene = SceneOf(scenes, row);
  ENAMEL_RETURN_IF_ERROR(scene.status());
  if (!scene->surface.IsZero()) return scene->surface;
  Making making(scene->volume);
  if (!making.first()) {
    return Status{Code::kUnavailable, "the picture of the tooth is being made; try again"};
  }
  scene = SceneOf(scenes, row);  // somebody may have come to the end of it meanwhile
  ENAMEL_RETURN_IF_ERROR(scene.status());
  if (!scene->surface.IsZero()) return scene->surface;
  Result<Sha256> made = MakeSurface(blobs, scenes, scene->volume);
  if (made.ok() || made.status().code() == Code::kStorage) return made;
  return Status{Code::kInternal, made.status().message()};
}

// While somebody types: only whether it is right.
Result<Response> LookAtDraft(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(scene::Exercise exercise, CheckedExercise(call, store));
  ExerciseRow row;
  row.scene = exercise.scene;
  std::vector<std::string> warnings = ExerciseWarnings(store.blobs, exercise);
  std::ranges::move(RubricWarnings(store, row, exercise.rubric, true),
                    std::back_inserter(warnings));
  return JsonResponse({{"warnings", json::value_from(warnings)}});
}

}  // namespace

Result<Response> ListExercises(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(Page page, PageOf(call.request, kMaxPage, kMaxPage));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<ExerciseRow> rows, ListedExercises(call, store.exercises));
  json::value next = CutPage(rows, page, [](const ExerciseRow& row) { return row.name; });
  ENAMEL_ASSIGN_OR_RETURN(auto attempts, OwnAttempts(call, store.attempts));
  ENAMEL_ASSIGN_OR_RETURN(std::set<Uuid> with_reference, store.references.ExercisesWithReference());
  json::array exercises;
  for (const ExerciseRow& row : rows) {
    Result<ExerciseDocument> exercise = DocumentOf(store.blobs, row);
    if (!exercise.ok()) return Status(Code::kInternal, exercise.status().message());
    exercises.push_back(SummaryJson(call.caller->person, row, **exercise,
                                    with_reference.contains(row.id), attempts[row.id]));
  }
  return JsonResponse({{"exercises", std::move(exercises)}, {"next", std::move(next)}});
}

Result<Response> GetExercise(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow row, VisibleExercise(call, store.attempts, store.exercises));
  ENAMEL_ASSIGN_OR_RETURN(Response whole, WholeResponse(call, store, row));
  return Packed(call.request, std::move(whole));
}

Result<Response> GetExerciseDocument(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow row, VisibleExercise(call, store.attempts, store.exercises));
  Result<Bytes> bytes = store.blobs.GetBlob(row.content);
  if (!bytes.ok()) return Status(Code::kInternal, bytes.status().message());
  Response response;
  response.content_type = "application/json";
  response.body = AsText(*bytes);
  return WithETag(std::move(response), row.revision);
}

Result<Response> GetInitialSurface(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow row, VisibleExercise(call, store.attempts, store.exercises));
  ENAMEL_ASSIGN_OR_RETURN(Sha256 surface, InitialSurface(store.blobs, store.scenes, row));
  Result<Bytes> bytes = store.blobs.GetBlob(surface);
  if (!bytes.ok()) return Status(Code::kInternal, bytes.status().message());
  Response response;
  response.content_type = "application/octet-stream";
  response.body = AsText(*bytes);
  return response;
}

Result<Response> ListExerciseVersions(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow row, VisibleExercise(call, store.attempts, store.exercises));
  ENAMEL_ASSIGN_OR_RETURN(Page page, PageOf(call.request, kMaxPage, kMaxPage));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<ExerciseRow> rows,
                          store.exercises.ExerciseVersions(row.name));
  if (!CanUseExercise(call.caller->person, row)) {
    std::erase_if(
        rows, [](const ExerciseRow& version) { return version.state == ExerciseState::kDraft; });
  }
  json::value next = CutPage(rows, page, [](const ExerciseRow& version) {
    // The list's own order as text: the draft, then newest first.
    return (version.state == ExerciseState::kDraft ? "0" : "1") +
           FallingKey(static_cast<uint64_t>(version.version));
  });
  json::array versions;
  for (const ExerciseRow& version : rows) {
    versions.push_back({{"id", version.id.Text()},
                        {"title", version.title},
                        {"version", version.version},
                        {"state", ExerciseStateName(version.state)},
                        {"document_sha256", version.content.Hex()},
                        {"published_ms", version.published_ms}});
  }
  return JsonResponse({{"versions", std::move(versions)}, {"next", std::move(next)}});
}

Result<Response> ListReferences(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow row, VisibleExercise(call, store.attempts, store.exercises));
  ENAMEL_ASSIGN_OR_RETURN(Page page, PageOf(call.request, kMaxPage, kMaxPage));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<ReferenceRow> rows, store.references.References(row.id));
  json::value next = CutPage(rows, page, [](const ReferenceRow& reference) {
    return FallingKey(static_cast<uint64_t>(reference.version));
  });
  json::array references;
  for (const ReferenceRow& reference : rows) {
    references.push_back(ReferenceJson(call.caller->person, reference));
  }
  return JsonResponse({{"references", std::move(references)}, {"next", std::move(next)}});
}

Result<Response> PutDraft(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(std::optional<bool> dry_run, QueryFlag(call.request, "dry_run"));
  if (dry_run.value_or(false)) return LookAtDraft(call, store);
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow draft, UploadedExercise(call, store));
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow row, store.exercises.PutDraft(draft, ActorOf(call)));
  return WholeResponse(call, store, row, 201);
}

Result<Response> ReplaceDraft(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(int32_t revision, SeenRevision(call, store.attempts, store.exercises));
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow draft, UploadedExercise(call, store));
  draft.id = call.id;
  draft.revision = revision;
  Result<ExerciseRow> row = store.exercises.ReplaceDraft(draft, ActorOf(call));
  if (!row.ok()) return Refused(call, store, row.status());
  return WholeResponse(call, store, *row);
}

Result<Response> DeleteDraft(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(int32_t revision, SeenRevision(call, store.attempts, store.exercises));
  Status done = store.exercises.DeleteDraft(call.id, revision, ActorOf(call));
  if (!done.ok()) return Refused(call, store, done);
  return Done();
}

Result<Response> PublishDraft(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(int32_t revision, SeenRevision(call, store.attempts, store.exercises));
  Result<ExerciseRow> row = store.exercises.PublishDraft(call.id, revision, ActorOf(call));
  if (!row.ok()) return Refused(call, store, row.status());
  return WholeResponse(call, store, *row);
}

Result<Response> RetireExercise(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow row,
                          ChangeableExercise(call, store.attempts, store.exercises));
  std::string reason;
  if (!call.request.body.empty()) {
    if (!IsJson(call.request)) return NotJson();
    BodyReader body(call.request);
    if (body.Has("reason")) reason = body.Text("reason", 1, kMaxReasonBytes);
    ENAMEL_RETURN_IF_ERROR(body.Finish());
    ENAMEL_RETURN_IF_ERROR(CheckOneLine(reason, "reason"));
  }
  return DoneOr(store.exercises.RetireExercise(call.id, ActorOf(call), reason));
}

Result<Response> OfferExerciseAgain(const Call& call, Store& store) {
  Result<ExerciseRow> row = ChangeableExercise(call, store.attempts, store.exercises);
  ENAMEL_RETURN_IF_ERROR(row.status());
  ENAMEL_RETURN_IF_ERROR(store.exercises.OfferExerciseAgain(call.id, ActorOf(call)));
  row = store.exercises.ExerciseById(call.id);
  ENAMEL_RETURN_IF_ERROR(row.status());
  return WholeResponse(call, store, *row);
}

Result<Response> ShareExercise(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow row,
                          ChangeableExercise(call, store.attempts, store.exercises));
  BodyReader body(call.request);
  SharingEdit edit;
  if (body.Has("shared")) edit.shared = body.Flag("shared");
  // null gives it to the school, absent leaves it where it is.
  if (body.Has("owner_id")) edit.owner = body.MaybeId("owner_id").value_or(Uuid{});
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  // Without If-Match: it is one switch, and who sets it last means it.
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow shared,
                          store.exercises.ShareExercise(call.id, edit, ActorOf(call)));
  return WholeResponse(call, store, shared);
}

}  // namespace enamel::server::http
