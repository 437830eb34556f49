#include "server/stations/session.h"

#include <gtest/gtest.h>

#include "common/scene/builtin/builtin.h"
#include "common/timeline/deviation.h"
#include "server/jobs/surface_blob.h"
#include "tests/server/stations/link_world.h"
#include "tests/server/storage/all_chunks.h"

// The protocol without sockets: one request, one answer.
namespace enamel::server::stations {
namespace {

using namespace testing;

class SessionTest : public ::testing::Test {
 protected:
  wire::Reply Carry(const wire::Request& request) {
    const Answer answer = CarryTo(session_, request);
    closed_ = answer.close;
    EXPECT_TRUE(answer.reply.has_value());
    return answer.reply.value_or(wire::Reply());
  }

  void Reconnect() {
    session_.End();
    std::destroy_at(&session_);
    std::construct_at(&session_, world_.services, "127.0.0.1");
  }

  void Welcome() {
    ASSERT_TRUE(station_.Enrol().has_enrolled());
    Reconnect();
    ASSERT_TRUE(station_.Hello().has_welcome());
  }

  // Signed in as the student, with a recording ready to be sent.
  Recording Ticketed(uint32_t chunks = 3) {
    EXPECT_TRUE(station_.SignIn("student").has_signed_in());
    auto reply = station_.RequestTicket(world_.exercise.content, profile_);
    EXPECT_TRUE(reply.has_ticket_issued()) << reply.error().message();
    return Recording(world_, TicketOf(reply), station_.keys, chunks);
  }

  LinkWorld world_;
  Session session_{world_.services, "127.0.0.1"};
  ScriptedStation station_{[this](const wire::Request& request) { return Carry(request); }};
  Sha256 profile_ = world_.Profile("phantom_desktop");
  bool closed_ = false;
};

TEST_F(SessionTest, AnythingBeforeHelloIsRefusedAndEndsTheConnection) {
  EXPECT_EQ(station_.SignIn("student").error().code(), "unauthenticated");
  EXPECT_TRUE(closed_);
}

TEST_F(SessionTest, AStationThatConnectsAgainAndAgainIsNotWrittenEachTime) {
  Welcome();
  const uint64_t commits = world_.store->health.Health().commits;
  Reconnect();
  ASSERT_TRUE(station_.Hello().has_welcome());
  EXPECT_EQ(world_.store->health.Health().commits, commits);
}

TEST_F(SessionTest, EnrolmentCodeIsUsedUpByOneStation) {
  ASSERT_TRUE(station_.Enrol().has_enrolled());
  EXPECT_TRUE(closed_);
  Reconnect();
  EXPECT_EQ(station_.Enrol().error().code(), "unauthenticated");
}

TEST_F(SessionTest, NameThatTurnsTextOrASpreadsheetAroundEnrolsNoStation) {
  for (const char* name : {"=HYPERLINK(1)", "bench\n1", "bench \u202e1", "\xff", ""}) {
    wire::Reply refused = station_.Enrol("code", name);
    EXPECT_EQ(refused.error().code(), "invalid_input") << name;
    EXPECT_EQ(refused.error().field(), "name") << name;
    Reconnect();
  }
  EXPECT_TRUE(station_.Enrol("code", " bench 1 ").has_enrolled()) << "the code is not used up";
  EXPECT_EQ(world_.store->stations.Stations()->front().name, "bench 1");
}

TEST_F(SessionTest, WrongCredentialAndOtherVersionAreRefused) {
  ASSERT_TRUE(station_.Enrol().has_enrolled());
  Reconnect();
  EXPECT_EQ(station_.Hello(2).error().code(), "version");
  EXPECT_TRUE(closed_);
  station_.credential.assign(32, 'x');
  EXPECT_EQ(station_.Hello().error().code(), "unauthenticated");
}

TEST_F(SessionTest, UnknownKindIsAnsweredAndTheConnectionGoesOn) {
  Welcome();
  EXPECT_EQ(station_.Send(wire::Request()).error().code(), "unsupported");
  EXPECT_FALSE(closed_);
}

TEST_F(SessionTest, WrongPasswordIsRefusedAndTheConnectionGoesOn) {
  Welcome();
  EXPECT_EQ(station_.SignIn("student", "wrong password").error().code(), "unauthenticated");
  EXPECT_FALSE(closed_);
  EXPECT_EQ(station_.SignIn("student").signed_in().role(), "student");
}

TEST_F(SessionTest, SignInEndsWithTheConnection) {
  Welcome();
  ASSERT_TRUE(station_.SignIn("student").has_signed_in());
  Reconnect();
  ASSERT_TRUE(station_.Hello().has_welcome());
  EXPECT_EQ(station_.RequestTicket(world_.exercise.content, profile_).error().code(),
            "unauthenticated");
}

TEST_F(SessionTest, ListedContentCanBeFetchedPartByPartAndNothingElse) {
  Welcome();
  ASSERT_TRUE(station_.SignIn("student").has_signed_in());
  wire::Request list;
  list.mutable_list_exercises()->set_session(station_.session);
  auto listed = station_.Send(list).exercises();
  ASSERT_EQ(listed.exercises_size(), 1);
  EXPECT_EQ(static_cast<size_t>(listed.profiles_size()), scene::BuiltinProfiles().size());

  std::string data;
  uint64_t total = 1;
  while (data.size() < total) {
    wire::Request get;
    get.mutable_get_blob()->set_sha256(listed.exercises(0).volume());
    get.mutable_get_blob()->set_offset(data.size());
    auto part = station_.Send(get).blob_part();
    ASSERT_FALSE(part.data().empty());
    total = part.total();
    data += part.data();
  }
  EXPECT_EQ(HashSha256(AsBytes(data)), world_.scene.volume);

  wire::Request secret;
  secret.mutable_get_blob()->set_sha256(
      protocol::ToField(PutText(*world_.store, "a score").view()));
  EXPECT_EQ(station_.Send(secret).error().code(), "not_found");
}

TEST_F(SessionTest, TicketIsRefusedToWhomTheExerciseIsNotAssigned) {
  Welcome();
  ASSERT_TRUE(station_.SignIn("outsider").has_signed_in());
  EXPECT_EQ(station_.RequestTicket(world_.exercise.content, profile_).error().code(), "forbidden");
  ASSERT_TRUE(station_.SignIn("student").has_signed_in());
  EXPECT_EQ(station_.RequestTicket(world_.exercise.content, profile_, true).error().code(),
            "forbidden");
  EXPECT_EQ(station_.RequestTicket(Sha256{}, profile_).error().code(), "not_found");
  EXPECT_EQ(station_.RequestTicket(world_.exercise.content, Sha256{}).error().code(), "not_found");
}

TEST_F(SessionTest, OtherCoreVersionMayUploadButNotBegin) {
  station_.core_version = core::kCoreVersion + 1;
  Welcome();
  ASSERT_TRUE(station_.SignIn("student").has_signed_in());
  EXPECT_EQ(station_.RequestTicket(world_.exercise.content, profile_).error().code(), "version");
}

TEST_F(SessionTest, WholeAttemptIsCommittedAndSealed) {
  Welcome();
  Recording recording = Ticketed();
  auto opened = station_.Open(recording.header);
  ASSERT_TRUE(opened.has_attempt_opened()) << opened.error().message();
  EXPECT_EQ(opened.attempt_opened().next_seq(), 0u);
  for (uint32_t seq = 0; seq < recording.chunks.size(); ++seq) {
    auto ack = station_.Put(recording.chunks[seq]);
    ASSERT_TRUE(ack.has_chunk_ack()) << ack.error().message();
    EXPECT_EQ(ack.chunk_ack().seq(), seq);
    EXPECT_TRUE(ack.chunk_ack().committed());
  }
  ASSERT_TRUE(station_.Seal(recording.seal).has_sealed());
  EXPECT_EQ(*AllChunks(world_.store->recordings, recording.seal.attempt), recording.chunks);
  EXPECT_EQ(station_.Status(recording.seal.attempt).attempt_state().state(), "sealed");
}

TEST_F(SessionTest, BrokenConnectionGoesOnWhereItWas) {
  Welcome();
  Recording recording = Ticketed();
  station_.Open(recording.header);
  station_.Put(recording.chunks[0]);
  Reconnect();
  ASSERT_TRUE(station_.Hello().has_welcome());
  EXPECT_EQ(station_.Open(recording.header).attempt_opened().next_seq(), 1u);
  EXPECT_TRUE(station_.Put(recording.chunks[0]).chunk_ack().committed()) << "again";
  EXPECT_TRUE(station_.Put(recording.chunks[1]).chunk_ack().committed());
  EXPECT_EQ(world_.store->attempts.AttemptById(recording.seal.attempt)->chunks, 2u);
}

TEST_F(SessionTest, ChunkOutOfOrderIsAConflictOfSeq) {
  Welcome();
  Recording recording = Ticketed();
  station_.Open(recording.header);
  auto reply = station_.Put(recording.chunks[2]);
  EXPECT_EQ(reply.error().code(), "conflict");
  EXPECT_EQ(reply.error().field(), "seq");
}

TEST_F(SessionTest, ContradictingChunkQuarantines) {
  Welcome();
  Recording recording = Ticketed();
  station_.Open(recording.header);
  station_.Put(recording.chunks[0]);
  Bytes other = recording.Chunk(0, HashSha256(recording.header), station_.keys, 5);
  EXPECT_EQ(station_.Put(other).error().code(), "conflict");
  auto state = station_.Status(recording.seal.attempt).attempt_state();
  EXPECT_EQ(state.state(), "quarantined");
  EXPECT_EQ(state.problem().code(), "conflict");
  EXPECT_EQ(state.problem().field(), protocol::kContradicted) << state.problem().message();
}

TEST_F(SessionTest, ChunkSignedWithAnotherKeyIsRefused) {
  Welcome();
  Recording recording = Ticketed();
  station_.Open(recording.header);
  Bytes forged = recording.Chunk(0, HashSha256(recording.header), trace::NewKeyPair());
  EXPECT_EQ(station_.Put(forged).error().code(), "forbidden");
  Bytes damaged = recording.chunks[0];
  damaged[damaged.size() / 2] ^= 1;
  EXPECT_TRUE(station_.Put(damaged).has_error());
  EXPECT_EQ(world_.store->attempts.AttemptById(recording.seal.attempt)->chunks, 0u);
}

TEST_F(SessionTest, TicketThatThisServerDidNotSignIsRefused) {
  Welcome();
  Recording recording = Ticketed();
  trace::SignTicket(recording.header_fields.ticket, trace::NewKeyPair().secret_key);
  EXPECT_EQ(station_.Open(trace::EncodeHeader(recording.header_fields)).error().code(),
            "forbidden");
}

TEST_F(SessionTest, HeaderWithOtherParametersThanThePlanIsRefused) {
  Welcome();
  Recording recording = Ticketed();
  recording.header_fields.params.peak_force_mn += 1;
  auto reply = station_.Open(trace::EncodeHeader(recording.header_fields));
  EXPECT_EQ(reply.error().code(), "conflict");
  EXPECT_EQ(reply.error().field(), "params");
}

TEST_F(SessionTest, TicketServesOneRecordingOnly) {
  Welcome();
  Recording recording = Ticketed();
  ASSERT_TRUE(station_.Open(recording.header).has_attempt_opened());
  recording.header_fields.station_software = "another run";
  EXPECT_EQ(station_.Open(trace::EncodeHeader(recording.header_fields)).error().code(), "conflict");
}

TEST_F(SessionTest, LongExpiredTicketOpensNothing) {
  Welcome();
  Recording recording = Ticketed();
  world_.now += kTicketValidMs + kLateUploadMs + 1;
  EXPECT_EQ(station_.Open(recording.header).error().code(), "conflict");
}

TEST_F(SessionTest, RecordingSurvivesAClockThatJumps) {
  Welcome();
  Recording recording = Ticketed();
  const UnixMs now = world_.now;
  world_.now = now - UnixMs{86'400'000} * 365;
  ASSERT_TRUE(station_.Open(recording.header).has_attempt_opened());
  ASSERT_TRUE(station_.Put(recording.chunks[0]).has_chunk_ack());
  world_.now = now + UnixMs{86'400'000} * 365;
  ASSERT_TRUE(station_.Put(recording.chunks[1]).has_chunk_ack());
  Reconnect();
  ASSERT_TRUE(station_.Hello().has_welcome());
  EXPECT_EQ(station_.Open(recording.header).attempt_opened().next_seq(), 2u);
  world_.now = now;
  ASSERT_TRUE(station_.Put(recording.chunks[2]).has_chunk_ack());
  EXPECT_TRUE(station_.Seal(recording.seal).has_sealed());
}

TEST_F(SessionTest, AttemptOfAnotherStationIsNotFound) {
  Welcome();
  Recording recording = Ticketed();
  station_.Open(recording.header);
  ASSERT_TRUE(
      world_.store->stations.AddEnrolCode(HashSha256(AsBytes("second")), UnixMs{1} << 60, kSystem)
          .ok());
  Reconnect();
  ScriptedStation other{[this](const wire::Request& request) { return Carry(request); }};
  ASSERT_TRUE(other.Enrol("second").has_enrolled());
  Reconnect();
  ASSERT_TRUE(other.Hello().has_welcome());
  EXPECT_EQ(other.Put(recording.chunks[0]).error().code(), "not_found");
  EXPECT_EQ(other.Open(recording.header).error().code(), "forbidden");
}

TEST_F(SessionTest, SomebodyElsesAttemptIsNotFoundAndGradedScoreIsHeldBack) {
  Welcome();
  Recording recording = Ticketed(1);
  station_.Open(recording.header);
  station_.Put(recording.chunks[0]);
  station_.Seal(recording.seal);
  AttemptResult result;
  result.score_json = PutText(*world_.store, "{\"score\":80}");
  result.score = 80;
  const auto block = scene::BuildBuiltinScene("block", 200'000);
  const CelledSurface surface = CelledSurfaceOf(block->volume);
  const auto by_cell = timeline::DeviationOf(block->volume.spec(), surface.cell,
                                             std::vector<float>(surface.cell.size(), 1e-4f));
  result.deviation = *world_.store->blobs.PutBlob(timeline::EncodeDeviation(by_cell));
  EXPECT_EQ(station_.Deviation(recording.seal.attempt).error().code(), "conflict") << "no score";
  ASSERT_TRUE(world_.store->results.FinishAttempt(recording.seal.attempt, result, {}).ok());
  auto mine = station_.Status(recording.seal.attempt).attempt_state();
  EXPECT_EQ(mine.state(), "scored");
  EXPECT_EQ(mine.result_json().empty(), world_.exercise.graded);
  ASSERT_TRUE(world_.exercise.graded);
  EXPECT_EQ(mine.scores_size(), 0);
  EXPECT_EQ(station_.Deviation(recording.seal.attempt).error().code(), "forbidden");
  ASSERT_TRUE(world_.store->judging.ReleaseAttempt(recording.seal.attempt, kSystem).ok());
  mine = station_.Status(recording.seal.attempt).attempt_state();
  EXPECT_EQ(mine.result_json(), "{\"score\":80}");
  ASSERT_EQ(mine.scores_size(), 1);
  EXPECT_EQ(mine.scores(0).attempt(), protocol::ToField(recording.seal.attempt.view()));
  EXPECT_EQ(mine.scores(0).score(), 80);
  const wire::Reply off = station_.Deviation(recording.seal.attempt);
  ASSERT_TRUE(off.has_attempt_deviation()) << off.error().message();
  const auto cells = timeline::DecodeDeviation(AsBytes(off.attempt_deviation().deviation()));
  ASSERT_TRUE(cells.ok());
  EXPECT_GT(cells->cells.size(), 1000u);
  EXPECT_EQ(cells->cells[0].deviation_um, 100);
  station_.SignIn("outsider");
  EXPECT_EQ(station_.Status(recording.seal.attempt).error().code(), "not_found");
  EXPECT_EQ(station_.Deviation(recording.seal.attempt).error().code(), "not_found");
}

TEST_F(SessionTest, WhoMarksAnAttemptBlindSeesNoScoreOfIt) {
  Welcome();
  Recording recording = Ticketed(1);
  const Uuid attempt = recording.seal.attempt;
  station_.Open(recording.header);
  station_.Put(recording.chunks[0]);
  station_.Seal(recording.seal);
  AttemptResult result;
  result.score = 90;
  result.score_json = PutText(*world_.store, "{}");
  ASSERT_TRUE(world_.store->results.FinishAttempt(attempt, result, {}).ok());
  station_.SignIn("instructor");
  const auto before = station_.Status(attempt).attempt_state();
  EXPECT_EQ(before.result_json(), "{}");
  EXPECT_EQ(before.scores_size(), 0) << "of somebody else's attempt";
  const auto row = world_.store->attempts.AttemptById(attempt);
  const auto marking = world_.store->markings.BeginMarking(*row->assignment, {attempt},
                                                           {world_.instructor}, kSystem);
  ASSERT_TRUE(marking.ok()) << marking.status().message();
  EXPECT_EQ(station_.Status(attempt).attempt_state().result_json(), "");
  EXPECT_EQ(station_.Deviation(attempt).error().code(), "forbidden");
}

TEST_F(SessionTest, OnlyAnInstructorWithConsentMarksAScoredAttemptAsReference) {
  Welcome();
  Recording recording = Ticketed(1);
  const Uuid attempt = recording.seal.attempt;
  station_.Open(recording.header);
  station_.Put(recording.chunks[0]);
  station_.Seal(recording.seal);
  EXPECT_EQ(station_.MarkReference(attempt, "Dr A", true).error().code(), "forbidden");
  station_.SignIn("outsider");
  EXPECT_EQ(station_.MarkReference(attempt, "Dr A", true).error().code(), "not_found");
  station_.SignIn("instructor");
  EXPECT_EQ(station_.MarkReference(attempt, "Dr A", true).error().code(), "conflict")
      << "not scored yet";
  AttemptResult result;
  result.score = 90;
  result.score_json = PutText(*world_.store, "{}");
  ASSERT_TRUE(world_.store->results.FinishAttempt(attempt, result, {}).ok());
  auto without = station_.MarkReference(attempt, "Dr A", false);
  EXPECT_EQ(without.error().field(), "consent");
  EXPECT_EQ(station_.MarkReference(attempt, "", true).error().field(), "dentist");
  EXPECT_EQ(station_.MarkReference(attempt, std::string(201, 'a'), true).error().field(),
            "dentist");
  EXPECT_FALSE(world_.store->references.ReferenceFor(world_.exercise.id)->has_value());
  // Its tooth is not one, so nobody can judge whether it did the task.
  EXPECT_EQ(station_.MarkReference(attempt, "Dr A", true).error().field(), "anyway");
  EXPECT_EQ(station_.MarkReference(attempt, "Dr A", true, "a\nb").error().code(), "invalid_input");
  auto marked = station_.MarkReference(attempt, "Dr A", true, "seen by two");
  ASSERT_TRUE(marked.has_reference_marked()) << marked.error().message();
  EXPECT_EQ(marked.reference_marked().version(), 1);
  auto reference = *world_.store->references.ReferenceFor(world_.exercise.id);
  ASSERT_TRUE(reference.has_value());
  EXPECT_EQ(reference->attempt, attempt);
  EXPECT_EQ(reference->dentist, "Dr A");
}

TEST_F(SessionTest, LatestLiveStateIsKeptUntilTheAttemptIsSealed) {
  Welcome();
  Recording recording = Ticketed(1);
  station_.Open(recording.header);
  wire::Request live;
  live.mutable_live_state()->set_attempt(protocol::ToField(recording.seal.attempt.view()));
  for (int value : {1, 2, 3}) {
    live.mutable_live_state()->add_anchor_um(value);
    live.mutable_live_state()->add_force_mn(-value);
  }
  for (uint64_t tick : {10, 30, 20}) {
    live.mutable_live_state()->set_tick(tick);
    EXPECT_FALSE(session_.Handle(live).reply.has_value());
  }
  ASSERT_TRUE(world_.live.Latest(recording.seal.attempt).has_value());
  EXPECT_EQ(world_.live.Latest(recording.seal.attempt)->tick, 30u);
  station_.Put(recording.chunks[0]);
  station_.Seal(recording.seal);
  EXPECT_FALSE(world_.live.Latest(recording.seal.attempt).has_value());
}

// A restore goes back to before some tickets; stations still hold the recordings made with them.
TEST_F(SessionTest, OnlyWhatIsNotThereAsAWholeIsWantedOfWhatIsOffered) {
  Welcome();
  Recording whole = Ticketed(2), begun = Ticketed(2);
  for (const Recording* r : {&whole, &begun}) {
    station_.Open(r->header);
    station_.Put(r->chunks[0]);
  }
  station_.Put(whole.chunks[1]);
  ASSERT_TRUE(station_.Seal(whole.seal).has_sealed());
  const Uuid lost = Uuid::New();
  wire::Request request;
  wire::OfferAttempts& offer = *request.mutable_offer_attempts();
  for (const Uuid& id : {whole.seal.attempt, begun.seal.attempt, lost}) {
    offer.add_attempts()->set_attempt(protocol::ToField(id.view()));
  }
  auto wanted = station_.Send(request).attempts_wanted();
  ASSERT_EQ(wanted.attempts_size(), 2);
  EXPECT_EQ(wanted.attempts(0), protocol::ToField(begun.seal.attempt.view()));
  EXPECT_EQ(wanted.attempts(1), protocol::ToField(lost.view()));
  for (int i = 0; i < 1100; ++i) offer.add_attempts()->set_attempt(std::string(16, 'x'));
  EXPECT_EQ(station_.Send(request).error().code(), "too_large");
}

// A ticket that a restored server forgot was issued nevertheless; a used one is no ticket for
// later.
TEST_F(SessionTest, TicketThatWasUsedIsRevokedAndOneThatIsUnknownIsNot) {
  Welcome();
  Recording unused = Ticketed(1), used = Ticketed(1);
  station_.Open(used.header);
  wire::Request request;
  wire::OfferAttempts& offer = *request.mutable_offer_attempts();
  for (const Uuid& id : {unused.seal.attempt, used.seal.attempt, Uuid::New()}) {
    offer.add_tickets(protocol::ToField(id.view()));
  }
  auto wanted = station_.Send(request).attempts_wanted();
  ASSERT_EQ(wanted.revoked_size(), 1);
  EXPECT_EQ(wanted.revoked(0), protocol::ToField(used.seal.attempt.view()));
  ASSERT_TRUE(world_.store->people.SetDisabled(world_.student, true, kSystem).ok());
  EXPECT_EQ(station_.Send(request).attempts_wanted().revoked_size(), 2);
}

TEST_F(SessionTest, StationIsToldWithEachAcknowledgementWhetherSomebodyWatches) {
  Welcome();
  Recording recording = Ticketed(3);
  EXPECT_FALSE(station_.Open(recording.header).attempt_opened().watched());
  EXPECT_FALSE(station_.Put(recording.chunks[0]).chunk_ack().watched());
  {
    auto watch = world_.live.Watch(recording.seal.attempt, Uuid{});
    EXPECT_TRUE(station_.Put(recording.chunks[1]).chunk_ack().watched());
    EXPECT_TRUE(station_.Open(recording.header).attempt_opened().watched());
  }
  EXPECT_FALSE(station_.Put(recording.chunks[2]).chunk_ack().watched());
}

TEST_F(SessionTest, RecordingWhoseTicketARestoreForgotIsTaken) {
  Welcome();
  trace::Ticket ticket = Ticketed(1).header_fields.ticket;
  ticket.attempt = Uuid::New();  // one that the store has never heard of
  trace::SignTicket(ticket, world_.services.ticket_key.secret_key);
  Recording recording(world_, trace::EncodeTicket(ticket), station_.keys, 2);
  wire::Reply opened = station_.Open(recording.header);
  ASSERT_TRUE(opened.has_attempt_opened()) << opened.error().message();
  EXPECT_TRUE(station_.Put(recording.chunks[0]).chunk_ack().committed());
  EXPECT_EQ(world_.store->attempts.AttemptById(ticket.attempt)->person, world_.student);

  ticket.attempt = Uuid::New();
  ticket.person = AddPerson(*world_.store, "erased", Role::kStudent);
  ASSERT_TRUE(world_.store->erasures.ErasePerson(ticket.person, false, kSystem).ok());
  trace::SignTicket(ticket, world_.services.ticket_key.secret_key);
  Recording nobodys(world_, trace::EncodeTicket(ticket), station_.keys, 1);
  EXPECT_EQ(station_.Open(nobodys.header).error().code(), "conflict");

  ticket.attempt = Uuid::New();
  ticket.person = world_.student;
  ticket.expires_unix_ms = world_.now - kLateUploadMs - 1;
  trace::SignTicket(ticket, world_.services.ticket_key.secret_key);
  Recording late(world_, trace::EncodeTicket(ticket), station_.keys, 1);
  EXPECT_EQ(station_.Open(late.header).error().code(), "conflict");
  EXPECT_FALSE(world_.store->attempts.AttemptById(ticket.attempt).ok());

  trace::SignTicket(ticket, trace::NewKeyPair().secret_key);
  Recording forged(world_, trace::EncodeTicket(ticket), station_.keys, 1);
  EXPECT_EQ(station_.Open(forged.header).error().code(), "forbidden");
}

}  // namespace
}  // namespace enamel::server::stations
