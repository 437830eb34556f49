#include "tests/server/http/school.h"

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <array>
#include <chrono>

#include "common/scene/json/json.h"
#include "common/scene/volume_blob.h"
#include "common/scoring/score.h"
#include "common/timeline/deviation.h"
#include "common/trace/trace.h"
#include "server/storage/open_store.h"
#include "tests/support/analytic_volume.h"

namespace enamel::server::http {
namespace {

const Actor kBy{{}, "test"};

// Made before there are threads, as in the programs: ThreadSanitizer does not see the lock with which the library, which
// is not built with it, makes its logger at the first line.
const auto kLogger = spdlog::default_logger();

template <typename T>
T Must(Result<T> result) {
  EXPECT_TRUE(result.ok()) << result.status().message();
  if (!result.ok()) std::abort();
  return std::move(result).value();
}
void Must(const Status& status) {
  EXPECT_TRUE(status.ok()) << status.message();
  if (!status.ok()) std::abort();
}

scene::DeviceProfile SomeProfile() {
  scene::DeviceProfile out;
  out.name = "phantom_desktop";
  out.title = "Phantom Desktop";
  for (scene::Sourced* number :
       {&out.resolution_nm, &out.max_stiffness_mn_per_mm, &out.coupling_mn_per_mm,
        &out.damping_mn_s_per_m, &out.friction_mn, &out.mass_g, &out.peak_force_mn,
        &out.continuous_force_mn, &out.rate_hz, &out.bus_delay_ticks, &out.workspace_radius_um}) {
    *number = {1000, "assumption"};
  }
  out.bus_delay_ticks.value = 1;
  return out;
}

scene::Exercise SomeExercise(const Sha256& scene) {
  scene::Exercise out;
  out.name = "class-1-occlusal";
  out.title = "Occlusal cavity";
  out.instructions = "Cut the cavity.";
  out.scene = scene;
  out.bur_radius_um = 500;
  out.bur_length_um = 4000;
  out.target.half_size_um = {2000, 1500, 0};
  out.target.depth_um = 2000;
  out.target.leeway_side_um = 200;
  out.target.leeway_bottom_um = 300;
  out.target.container_um = 500;
  out.rubric.name = "class-1";
  out.rubric.prices = {{"wall", 0.45, 0.6, 12, 36, 2, 12, "chosen"},
                       {"floor", 0.4, 0.5, 12, 36, 2, 12, "chosen"},
                       {"line_angle", 0.6, 0.6, 5, 6, 1, 5, "chosen"}};
  out.rubric.criteria = {{"time_s", "Time", "s", 20, {{300, 1}, {600, 0}}, "too slow", {}}};
  return out;
}

}  // namespace

School::School(Role root_role) {
  now_ms = std::chrono::duration_cast<std::chrono::milliseconds>(
               std::chrono::system_clock::now().time_since_epoch())
               .count();
  store = Must(OpenSqliteStore(
      {folder.path() / "data", false, 2, [this] { return before_write && before_write(); }}));
  auth::AuthOptions options;
  options.cost = {1, 8192};
  options.clock = [this] { return now_ms; };
  authenticator = std::make_unique<auth::Authenticator>(*store, options);
  verifier_ = Must(authenticator->NewVerifier(kPassword, "nobody"));
  root = AddPerson("root", root_role);
  ada = AddPerson("ada", Role::kInstructor);
  ben = AddPerson("ben", Role::kInstructor);
  sam = AddPerson("sam", Role::kStudent);
  sue = AddPerson("sue", Role::kStudent);
  tom = AddPerson("tom", Role::kStudent);
  cohort_a = Must(store->cohorts.CreateCohort("A", kBy));
  cohort_b = Must(store->cohorts.CreateCohort("B", kBy));
  for (const Uuid& id : {ada, sam, sue}) Must(store->cohorts.AddToCohort(cohort_a, id, kBy));
  for (const Uuid& id : {ben, tom}) Must(store->cohorts.AddToCohort(cohort_b, id, kBy));
  AddDocuments();
  sams_scored = ScoredAttempt(sam);
  sams_recording = RecordingAttempt(sam);
  toms_scored = ScoredAttempt(tom);
}

Uuid School::AddPerson(const std::string& login, Role role) {
  Person person;
  person.login = login;
  person.display_name = "Person " + login;
  person.role = role;
  return Must(store->people.CreatePerson(person, verifier_, {}, kBy));
}

void School::AddDocuments() {
  Sha256 code = HashSha256(AsBytes("code"));
  Must(store->stations.AddEnrolCode(code, now_ms + 1000, kBy));
  StationRow row;
  row.name = "bench-1";
  row.public_key.assign(32, 1);
  station =
      Must(store->stations.EnrolStation(code, row, HashSha256(AsBytes("credential")), now_ms)).id;

  scene::DeviceProfile profile = SomeProfile();
  profile_ = Must(store->blobs.PutBlob(AsBytes(scene::ToJson(profile))));
  Must(store->profiles.PutProfile({profile.name, profile.title, profile_}, kBy));
  Sha256 scene_json = Must(store->blobs.PutBlob(AsBytes("scene")));
  Sha256 volume = Must(store->blobs.PutBlob(AsBytes("volume")));
  Must(store->scenes.PutScene({"molar", "Molar", scene_json, volume}, kBy));
  scene::Exercise document = SomeExercise(scene_json);
  exercise_row_.name = document.name;
  exercise_row_.title = document.title;
  exercise_row_.content = Must(store->blobs.PutBlob(AsBytes(scene::ToJson(document))));
  exercise_row_.scene = scene_json;
  exercise_row_ = Must(store->exercises.PublishExercise(exercise_row_, cohort_a, kBy));
  exercise = exercise_row_.id;
}

ExerciseRow School::OwnExercise(const Actor& by, const std::string& name, bool publish,
                                bool graded) {
  scene::Exercise document = SomeExercise(exercise_row_.scene);
  document.name = name;
  document.graded = graded;
  ExerciseRow row = exercise_row_;
  row.name = name;
  row.title = document.title;
  row.graded = graded;
  row.content = Must(store->blobs.PutBlob(AsBytes(scene::ToJson(document))));
  row = Must(store->exercises.PutDraft(row, by));
  return publish ? Must(store->exercises.PublishDraft(row.id, row.revision, by)) : row;
}

Uuid School::RecordingAttempt(const Uuid& person, const Change& change, ByteView header) {
  AttemptRow row;
  row.id = Uuid::New();
  row.person = person;
  row.station = station;
  row.exercise = exercise;
  row.profile_content = profile_;
  row.ticketed_ms = now_ms;
  if (change) change(row);
  Must(store->tickets.CreateAttempt(row, AsBytes("ticket"), kBy));
  Must(store->tickets.OpenAttempt(row.id, header));
  return row.id;
}

Uuid School::ScoredAttempt(const Uuid& person, const Change& change, const Judge& judge) {
  Uuid id = RecordingAttempt(person, change);
  ChunkPut chunk;
  chunk.attempt = chunk.head.attempt = id;
  chunk.head.count = 1000;
  chunk.head.previous = HashSha256(AsBytes("header"));
  // A real one, of a bur at rest.
  static const trace::KeyPair kStation = trace::NewKeyPair();
  static const std::vector<trace::Tick> kAtRest(1000);
  chunk.bytes = trace::EncodeChunk(chunk.head, kAtRest, kStation.secret_key);
  chunk.hash = trace::DecodeChunkHead(chunk.bytes)->hash;
  Must(store->ingest.AppendChunk(chunk));
  trace::Seal seal;
  seal.attempt = id;
  seal.chunks = 1;
  seal.ticks = 1000;
  seal.last_chunk = chunk.hash;
  Must(store->seals.SealAttempt(seal, now_ms));
  scoring::ScoreResult score;
  score.score = 87.5;
  if (judge) judge(score);
  AttemptResult result;
  result.score = score.score;
  result.score_json = Must(store->blobs.PutBlob(AsBytes(scoring::ToJson(score))));
  // A block that nobody cut, 0.3 mm off in one cell of its top.
  const cutting::Volume tooth = test::Block(200'000, 1e-3, 1e-3);
  const Sha256 before = Must(store->blobs.PutBlob(scene::EncodeVolume(tooth)));
  result.final_volume = Must(store->blobs.PutBlob(scene::EncodeChange(tooth, tooth, before)));
  const timeline::Deviation deviation{tooth.spec(), {{kComparedCell, 300}}};
  result.deviation = Must(store->blobs.PutBlob(timeline::EncodeDeviation(deviation)));
  result.series = Must(store->blobs.PutBlob(AsBytes("{}")));
  if (!score.reference_attempt.empty()) result.reference = *Uuid::Parse(score.reference_attempt);
  Must(store->results.FinishAttempt(id, result, {}));
  return id;
}

}  // namespace enamel::server::http
