#include "tests/server/storage/recorded_attempt.h"

#include "common/base/file.h"
#include "server/results/result_document.h"
#include "tests/common/core/params.h"

namespace enamel::server::testing {

RecordedSchool::RecordedSchool(const std::filesystem::path& folder)
    : data(folder), store(OpenStore(folder)), world(*store) {
  // As server/app/data_folder.h keeps them.
  EXPECT_TRUE(WriteFileDurably(data / "station.crt", AsBytes("certificate"), 0600).ok());
  EXPECT_TRUE(WriteFileDurably(data / "station.key", AsBytes("key"), 0600).ok());
}

Uuid RecordedSchool::Record(uint32_t chunks) { return RecordOf(world.student, chunks); }

Uuid RecordedSchool::RecordOf(const Uuid& person, uint32_t chunks) {
  AttemptRow row = world.AttemptOf(person);
  trace::Header header;
  header.ticket.attempt = row.id;
  header.ticket.person = person;
  header.ticket.station = world.station;
  header.ticket.exercise = world.exercise.content;
  header.ticket.profile = world.profile;
  header.ticket.issued_unix_ms = 5;
  header.ticket.expires_unix_ms = 6;
  trace::SignTicket(header.ticket, ticket_key.secret_key);
  EXPECT_TRUE(store->tickets.CreateAttempt(row, trace::EncodeTicket(header.ticket), kSystem).ok());
  header.scene = world.scene;
  header.params = test::ParamsFor({cutting::BurShape::kCylinder, 0.6e-3, 4e-3});
  header.station_software = "test";
  header.hand.kind = HandKind::kProgram;
  Bytes encoded = trace::EncodeHeader(header);
  EXPECT_TRUE(store->tickets.OpenAttempt(row.id, encoded).ok());
  chains_[row.id].head = HashSha256(encoded);
  for (uint32_t i = 0; i < chunks; ++i) EXPECT_TRUE(Append(row.id).ok());
  return row.id;
}

Status RecordedSchool::Append(const Uuid& attempt) {
  Chain& chain = chains_.at(attempt);
  auto put = world.Chunk(attempt, static_cast<uint32_t>(chain.chunks.size()), chain.head);
  ENAMEL_RETURN_IF_ERROR(store->ingest.AppendChunk(put));
  chain.head = put.hash;
  chain.chunks.push_back(std::move(put));
  return Status::Ok();
}

void RecordedSchool::Seal(const Uuid& attempt) {
  Status sealed = store->seals.SealAttempt(World::SealOf(chains_.at(attempt).chunks), 200);
  EXPECT_TRUE(sealed.ok()) << sealed.message();
}

void RecordedSchool::Score(const Uuid& attempt, const std::optional<Uuid>& reference) {
  Seal(attempt);
  Finish(attempt, 80, reference);
}

void RecordedSchool::ScoreAgain(const Uuid& attempt, double points) {
  ASSERT_TRUE(store->judging.Rescore(attempt, "rescore", kSystem).ok());
  Finish(attempt, points, store->results.ResultOf(attempt)->reference);
}

void RecordedSchool::Finish(const Uuid& attempt, double points,
                            const std::optional<Uuid>& reference) {
  auto job = store->jobs.LeaseJob(1, 1000);
  EXPECT_TRUE(job.ok() && job->has_value() && (*job)->attempt == attempt);
  AttemptResult result;
  result.score = points;
  result.scored_ms = 300;
  result.reference = reference;
  ResultDocument document;
  auto put = [&](const std::string& text, Sha256& file) {
    file = HashSha256(AsBytes(text));
    return *store->blobs.PutAttemptBlob(attempt, AsBytes(text));
  };
  result.score_json = put("score of " + std::to_string(points), document.score_file);
  result.final_volume = put("volume", document.tooth_file);
  result.deviation = put("deviation", document.surface_file);
  result.series = put("series", document.series_file);
  if (with_motion) {
    result.motion = *store->blobs.PutAttemptBlob(attempt, AsBytes("motion of " + attempt.Text()));
    result.near = NearAttempt{reference.value_or(Uuid()), 3, 10, 20, 30, false, {}, 0, 0};
  }
  AttemptRow row = *store->attempts.AttemptById(attempt);
  document.attempt = attempt;
  document.scored_ms = result.scored_ms;
  document.header = HashSha256(*store->recordings.AttemptHeader(attempt));
  document.recording = store->recordings.AttemptSeal(attempt)->last_chunk;
  document.exercise = world.exercise.content;
  document.scene = world.scene;
  document.profile = world.profile;
  if (reference) {
    document.reference = *reference;
    document.reference_recording = store->recordings.AttemptSeal(*reference)->last_chunk;
    document.reference_tooth = store->results.ResultOf(*reference)->final_volume;
  }
  document.score_document = result.score_json;
  document.tooth = result.final_volume;
  document.deviation = result.deviation;
  document.series = result.series;
  document.points = points;
  document.flags = row.flags;
  SignResult(document, ticket_key);
  result.document = EncodeResult(document);
  EXPECT_TRUE(store->results.FinishAttempt(attempt, result, {}).ok());
  EXPECT_TRUE(store->jobs.FinishJob((*job)->lease, true, "").ok());
}

Bytes RecordedSchool::TraceOf(const Uuid& attempt) {
  trace::TraceFile file{*store->recordings.AttemptHeader(attempt),
                        *AllChunks(store->recordings, attempt), std::nullopt, false};
  return trace::EncodeTraceFile(file);
}

}  // namespace enamel::server::testing
