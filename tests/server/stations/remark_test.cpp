#include <gtest/gtest.h>

#include "tests/server/stations/link_world.h"

// Remarks to the chair, and when a station was heard last, at the server's end of the link.
namespace enamel::server::stations {
namespace {

using namespace testing;

class RemarkTest : public ::testing::Test {
 protected:
  RemarkTest() {
    world_.services.board = &board_;
    EXPECT_TRUE(station_.Enrol().has_enrolled());
  }

  wire::Reply Carry(const wire::Request& request) {
    if (!session_) session_.emplace(world_.services, "127.0.0.1");
    return CarryTo(*session_, request).reply.value_or(wire::Reply());
  }

  void Hello(bool shows_remarks = true) {
    session_.reset();
    wire::Request request;
    wire::Hello& hello = *request.mutable_hello();
    hello.set_protocol_version(1);
    hello.set_station_id(station_.id);
    hello.set_credential(station_.credential);
    hello.set_core_version(core::kCoreVersion);
    hello.set_software("enamel-station test");
    hello.set_shows_remarks(shows_remarks);
    ASSERT_TRUE(station_.Send(request).has_welcome());
  }

  // Of a recording that is open.
  Recording Opened(uint32_t chunks) {
    EXPECT_TRUE(station_.SignIn("student").has_signed_in());
    auto reply = station_.RequestTicket(world_.exercise.content, world_.Profile("phantom_desktop"));
    EXPECT_TRUE(reply.has_ticket_issued()) << reply.error().message();
    Recording recording(world_, TicketOf(reply), station_.keys, chunks);
    EXPECT_TRUE(station_.Open(recording.header).has_attempt_opened());
    return recording;
  }

  wire::Reply Put(const Bytes& chunk, uint64_t shown = 0) {
    wire::Request request;
    request.mutable_put_chunk()->set_chunk(protocol::ToField(chunk));
    request.mutable_put_chunk()->set_shown_remark(shown);
    return station_.Send(request);
  }

  wire::Reply Ping(const Uuid& attempt, uint64_t shown = 0) {
    wire::Request request;
    request.mutable_ping()->set_attempt(protocol::ToField(attempt.view()));
    request.mutable_ping()->set_shown_remark(shown);
    return station_.Send(request);
  }

  // Gives its id.
  uint64_t Send(const Uuid& attempt, const std::string& text) {
    board_.remarks().Put({attempt, ++last_id_, text, "Ada", 1, world_.now, {}, {}});
    return last_id_;
  }

  Uuid StationId() const { return *protocol::ReadUuid(station_.id, "id"); }
  UnixMs StoredMs() { return world_.store->stations.StationById(StationId())->last_seen_ms; }

  LinkWorld world_;
  uint64_t last_id_ = 0;
  StationBoard board_;
  std::optional<Session> session_;
  ScriptedStation station_{[this](const wire::Request& request) { return Carry(request); }};
};

TEST_F(RemarkTest, RemarkComesWithEachAcknowledgementUntilItWasShown) {
  Hello();
  Recording recording = Opened(4);
  const Uuid& attempt = recording.seal.attempt;
  EXPECT_EQ(Put(recording.chunks[0]).chunk_ack().remarks_size(), 0);
  const uint64_t sent = Send(attempt, "请停一下");
  for (uint32_t seq : {1u, 2u}) {
    const wire::Reply reply = Put(recording.chunks[seq]);
    ASSERT_EQ(reply.chunk_ack().remarks_size(), 1) << "chunk " << seq;
    EXPECT_EQ(reply.chunk_ack().remarks(0).id(), sent);
    EXPECT_EQ(reply.chunk_ack().remarks(0).text(), "请停一下");
    EXPECT_EQ(reply.chunk_ack().remarks(0).from(), "Ada");
  }
  EXPECT_EQ(board_.remarks().Of(attempt)[0].state, RemarkState::kSent);
  EXPECT_EQ(Put(recording.chunks[3], sent).chunk_ack().remarks_size(), 0);
  EXPECT_EQ(board_.remarks().Of(attempt)[0].state, RemarkState::kShown);
  ASSERT_TRUE(station_.Seal(recording.seal).has_sealed());
  EXPECT_TRUE(board_.remarks().Of(attempt).empty());
}

TEST_F(RemarkTest, RemarkSurvivesABrokenConnection) {
  Hello();
  Recording recording = Opened(2);
  (void)Send(recording.seal.attempt, "stop");
  EXPECT_EQ(Put(recording.chunks[0]).chunk_ack().remarks_size(), 1);
  Hello();
  EXPECT_TRUE(station_.Open(recording.header).has_attempt_opened());
  EXPECT_EQ(Put(recording.chunks[1]).chunk_ack().remarks_size(), 1);
}

TEST_F(RemarkTest, PongBringsRemarksOfAnAttemptThatIsTheStationsOwn) {
  Hello();
  Recording recording = Opened(1);
  const Uuid& attempt = recording.seal.attempt;
  const uint64_t sent = Send(attempt, "stop");
  const Uuid other = Uuid::New();
  (void)Send(other, "for another chair");
  EXPECT_EQ(Ping(other).pong().remarks_size(), 0);
  EXPECT_EQ(Ping(attempt).pong().remarks_size(), 1);
  EXPECT_EQ(Ping(attempt, sent).pong().remarks_size(), 0);
  EXPECT_EQ(board_.remarks().Of(other)[0].state, RemarkState::kWaiting);
}

TEST_F(RemarkTest, OlderStationIsNeverSentOne) {
  Hello(false);
  EXPECT_FALSE(board_.ShowsRemarks(StationId()));
  Recording recording = Opened(1);
  (void)Send(recording.seal.attempt, "stop");
  EXPECT_EQ(Put(recording.chunks[0]).chunk_ack().remarks_size(), 0);
  EXPECT_EQ(Ping(recording.seal.attempt).pong().remarks_size(), 0);
}

TEST_F(RemarkTest, LastSeenFollowsPingsAndIsWrittenOnceAMinute) {
  Hello();
  const UnixMs begun = world_.now;
  EXPECT_EQ(StoredMs(), begun);
  for (int s = 20; s < 60; s += 20) {
    world_.now = begun + s * 1000;
    (void)Ping(Uuid::New());
    EXPECT_EQ(board_.HeardMs(StationId()), world_.now);
    EXPECT_EQ(StoredMs(), begun) << s << " s after Hello";
  }
  world_.now = begun + 60'000;
  (void)Ping(Uuid::New());
  EXPECT_EQ(StoredMs(), world_.now);
  const StationRow row = *world_.store->stations.StationById(StationId());
  EXPECT_EQ(row.software, "enamel-station test") << "what it said in Hello stays";
  EXPECT_EQ(row.core_version, core::kCoreVersion);
  session_.reset();
  EXPECT_EQ(board_.HeardMs(StationId()), world_.now);
}

TEST_F(RemarkTest, LastSeenFollowsChunks) {
  Hello();
  Recording recording = Opened(1);
  world_.now += 90'000;
  ASSERT_TRUE(Put(recording.chunks[0]).has_chunk_ack());
  EXPECT_EQ(board_.HeardMs(StationId()), world_.now);
  EXPECT_EQ(StoredMs(), world_.now);
}

}  // namespace
}  // namespace enamel::server::stations
