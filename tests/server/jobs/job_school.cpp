#include "tests/server/jobs/job_school.h"

#include "common/scene/json/json.h"
#include "server/jobs/score_job.h"
#include "server/storage/engine/query.h"
#include "server/storage/store_engine.h"
#include "tests/server/storage/all_chunks.h"

namespace enamel::test {
namespace {

namespace fs = std::filesystem;
using namespace server;

const Actor kBy{{}, "test"};

template <typename T>
T Must(enamel::Result<T> result) {
  ENAMEL_CHECK(result.ok());
  return std::move(result).value();
}
void Must(const Status& status) { ENAMEL_CHECK(status.ok()); }

Sha256 Put(Store& store, const std::string& text) {
  return Must(store.blobs.PutBlob(AsBytes(text)));
}

}  // namespace

// Made by the first test that asks for it, and kept as long as the program runs.
struct JobSchool::Kept {
  TempFolder folder;
  Uuid person, station, exercise, reference;

  Kept() {
    JobSchool school;
    reference = school.RecordReference();
    school.Exec("DELETE FROM jobs");
    person = school.person;
    station = school.station;
    exercise = school.exercise;
    school.store.reset();  // what is in the log is in the database then
    fs::copy(school.folder.path() / "data", folder.path() / "data", fs::copy_options::recursive);
  }
};

JobSchool::JobSchool(const World& world, std::function<bool()> fail_next) : world_(world) {
  Open(std::move(fail_next));
  Person student;
  student.login = student.display_name = "student";
  person = Must(store->people.CreatePerson(student, "none", {}, kBy));
  const Sha256 code = HashSha256(AsBytes("code"));
  Must(store->stations.AddEnrolCode(code, 1000, kBy).status());
  StationRow bench;
  bench.name = "bench 1";
  bench.public_key.assign(world.station_key.public_key.begin(), world.station_key.public_key.end());
  station = Must(store->stations.EnrolStation(code, bench, code, 10)).id;
  const Sha256 scene = Put(*store, scene::ToJson(world.scene));
  Must(store->scenes.PutScene(
      {"block", "Block", scene, Must(store->blobs.PutBlob(world.volume_blob))}, kBy));
  Put(*store, scene::ToJson(world.profile));
  ExerciseRow row;
  row.name = world.exercise.name;
  row.title = world.exercise.title;
  row.content = Put(*store, scene::ToJson(world.exercise));
  row.scene = scene;
  exercise = Must(store->exercises.PublishExercise(row, Uuid{}, kBy)).id;
}

JobSchool::JobSchool(const Kept& from)
    : person(from.person),
      station(from.station),
      exercise(from.exercise),
      reference(from.reference),
      world_(World::Get()) {
  fs::copy(from.folder.path() / "data", folder.path() / "data", fs::copy_options::recursive);
  Open({});
}

std::unique_ptr<JobSchool> JobSchool::WithReference() {
  static const Kept kept;
  return std::unique_ptr<JobSchool>(new JobSchool(kept));
}

void JobSchool::Open(std::function<bool()> fail_next) {
  StoreOptions options;
  options.folder = folder.path() / "data";
  options.fail_next = std::move(fail_next);
  options.disk = &disk;
  store = Must(OpenSqliteStore(options));
}

Uuid JobSchool::Record(const PathOptions& path, bool as_reference) {
  AttemptRow row;
  row.id = Uuid::New();
  row.person = person;
  row.station = station;
  row.exercise = exercise;
  row.profile_content = HashSha256(AsBytes(scene::ToJson(world_.profile)));
  row.as_reference = as_reference;
  row.ticketed_ms = now_ms_;
  Must(store->tickets.CreateAttempt(row, AsBytes("ticket"), kBy));
  const Recording recording = world_.Record(row.id, station, path);
  Must(store->tickets.OpenAttempt(row.id, recording.header));
  // As if it had taken an hour: nothing is faster than time.
  now_ms_ += 3'600'000;
  for (const Bytes& chunk : recording.chunks) {
    const auto decoded = Must(trace::DecodeChunkHead(chunk));
    Must(store->ingest.AppendChunk({row.id, decoded.head, decoded.hash, chunk, now_ms_}));
  }
  Must(store->seals.SealAttempt(recording.seal, now_ms_));
  return row.id;
}

Uuid JobSchool::RecordReference(const PathOptions& path) {
  reference = Record(path, true);
  Must(RunScoreJob(*store, reference));
  Must(store->references.AddReference(reference, "Dr. Example", true, kBy).status());
  // Against itself.
  Must(RunScoreJob(*store, reference));
  return reference;
}

AttemptRow JobSchool::Row(const Uuid& attempt) {
  return Must(store->attempts.AttemptById(attempt));
}

AttemptResult JobSchool::Result(const Uuid& attempt) {
  return Must(store->results.ResultOf(attempt));
}

scoring::ScoreResult JobSchool::Score(const Uuid& attempt) {
  return Must(scoring::ScoreFromJson(AsText(Blob(Result(attempt).score_json))));
}

Bytes JobSchool::Blob(const Sha256& content) { return Must(store->blobs.GetBlob(content)); }

Recording JobSchool::RecordingOf(const Uuid& attempt) {
  return {Must(store->recordings.AttemptHeader(attempt)),
          Must(AllChunks(store->recordings, attempt)),
          Must(store->recordings.AttemptSeal(attempt))};
}

std::optional<NearAttempt> JobSchool::Near(const Uuid& attempt) {
  return Must(store->motions.NearestTo(attempt));
}

void JobSchool::Spoil(const Uuid& attempt, const std::function<void(Recording&)>& change) {
  Recording recording = RecordingOf(attempt);
  change(recording);
  const trace::Seal& seal = recording.seal;
  const Sha256 blob = Must(store->blobs.PutAttemptBlob(
      attempt, trace::EncodeTraceFile({recording.header, recording.chunks, seal, false})));
  Must(store->engine->rows.Write([&](sql::Db& db) {
    Query q(
        db,
        "UPDATE attempts SET header = ?3, trace_blob = ?4, chunks = ?5, ticks = ?6, head_hash = "
        "?7, head_state_hash = ?8 WHERE tenant = ?1 AND id = ?2");
    q.Bind(attempt).Bind(recording.header).Bind(blob).Bind(int64_t{seal.chunks});
    q.Bind(static_cast<int64_t>(seal.ticks)).Bind(seal.last_chunk);
    return q.Bind(static_cast<int64_t>(seal.state_hash)).Run();
  }));
}

void JobSchool::SetScore(const Uuid& attempt, const scoring::ScoreResult& score) {
  Set(attempt, "score_json = " + Sql(Put(*store, scoring::ToJson(score))));
}

void JobSchool::Set(const Uuid& attempt, const std::string& columns) {
  Exec("UPDATE attempts SET " + columns + " WHERE id = " + Sql(attempt));
}

void JobSchool::Exec(const std::string& sql) {
  Must(store->engine->rows.Write([&](sql::Db& db) { return db.Exec(sql.c_str()); }));
}

std::string JobSchool::Sql(const Uuid& id) {
  std::string hex = id.Text();
  std::erase(hex, '-');
  return "X'" + hex + "'";
}

}  // namespace enamel::test
