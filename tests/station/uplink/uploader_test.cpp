#include "station/uplink/uploader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <thread>

#include "station/spool/recorder.h"
#include "tests/station/uplink/fake_server.h"
#include "tests/support/becomes.h"
#include "tests/support/temp_folder.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;
constexpr std::chrono::seconds kSoon{60};  // never waited for when all is well

class UploaderTest : public testing::Test {
 protected:
  UploaderTest() {
    spool_ = std::move(*Spool::Open(folder_ / "spool"));
    header_.ticket.attempt = Uuid::New();
    header_.params.kc_mn_per_mm = 2500;
    header_.params.resolution_nm = {10'000, 10'000, 10'000};
    header_.params.peak_force_mn = 7900;
    header_.params.bur_radius_nm = 500'000;
    header_.hand.kind = HandKind::kProgram;
    EXPECT_TRUE(spool_->BeginAttempt(header_, "e", "p").ok());
    recorder_.emplace(*spool_, ring_, id(), HashSha256(trace::EncodeHeader(header_)),
                      keys_.secret_key);
  }
  ~UploaderTest() override {
    recorder_.reset();
    spool_.reset();
  }

  Uuid id() const { return header_.ticket.attempt; }
  void Record(int chunks) {
    for (int c = 0; c < chunks; ++c) {
      for (size_t i = 0; i < Recorder::kTicksPerChunk; ++i) ring_.Push(Sample{});
      ASSERT_TRUE(recorder_->Pump().ok());
    }
  }
  Status UploadAttempt(ServerLink& link, Spool& spool, const Uuid& attempt) {
    Bandwidth no_bound(0);
    return AttemptSender(link, spool, no_bound).Send(attempt);
  }
  // Destroys the page of the closed spool that contains these bytes.
  void OverwritePageWith(const Bytes& bytes) {
    constexpr size_t kPageBytes = 4096;
    const fs::path file = folder_ / "spool" / "spool.sqlite";
    const Bytes all = *ReadFile(file);
    const auto at = std::search(all.begin(), all.end(), bytes.begin(), bytes.end());
    ASSERT_NE(at, all.end());
    std::fstream out(file, std::ios::binary | std::ios::in | std::ios::out);
    out.seekp((at - all.begin()) / kPageBytes * kPageBytes);
    out << std::string(kPageBytes, '\x5a');
  }
  void ExpectWholeAt(const FakeServer& server) {
    auto spooled = *spool_->ChunksFrom(id(), 0, 1000);
    auto there = server.chunks();
    ASSERT_EQ(there.size(), spooled.size());
    for (const SpooledChunk& c : spooled) EXPECT_EQ(there[c.seq], c.bytes) << c.seq;
  }

  test::TempFolder temp_;
  const fs::path folder_ = temp_.path();
  trace::KeyPair keys_ = trace::NewKeyPair();
  trace::Header header_;
  std::unique_ptr<Spool> spool_;
  SampleRing ring_{1000};
  std::optional<Recorder> recorder_;
};

TEST_F(UploaderTest, BringsEverythingAndSealsIt) {
  Record(40);
  ASSERT_TRUE(recorder_->Finish().ok());
  FakeServer server(folder_);
  ServerLink link;
  ASSERT_TRUE(link.Connect(server.NewStation()).ok());
  ASSERT_TRUE(UploadAttempt(link, *spool_, id()).ok());
  ExpectWholeAt(server);
  EXPECT_TRUE(server.sealed());
  EXPECT_TRUE(spool_->Get(id())->complete());
  EXPECT_EQ(spool_->Get(id())->committed, 40u);
}

TEST_F(UploaderTest, UnsealedAttemptIsSentAndLeftOpen) {
  Record(3);
  FakeServer server(folder_);
  ServerLink link;
  ASSERT_TRUE(link.Connect(server.NewStation()).ok());
  ASSERT_TRUE(UploadAttempt(link, *spool_, id()).ok());
  ExpectWholeAt(server);
  EXPECT_FALSE(server.sealed());
}

TEST_F(UploaderTest, SealThatIsHeldBackFollowsOnceItIsReleased) {
  Record(3);
  ASSERT_TRUE(recorder_->Finish().ok());
  trace::Header later = HeaderOf(Uuid::New());
  ASSERT_TRUE(spool_->BeginAttempt(later, "class-1", "pointer").ok());
  trace::Seal seal;
  seal.attempt = later.ticket.attempt;
  ASSERT_TRUE(spool_->PutSeal(seal).ok());
  FakeServer server(folder_);
  Uploader uploader(server.NewStation(), *spool_);
  uploader.HoldSeal(id());
  uploader.Prefer(id(), nullptr);
  // The preferred one goes first, so its turn is over once the other is sealed.
  uploader.WaitUntilDone(seal.attempt, std::chrono::seconds(20));
  EXPECT_TRUE(uploader.state(seal.attempt).sealed);
  EXPECT_EQ(uploader.state(id()).committed, 3u);
  EXPECT_FALSE(uploader.state(id()).sealed) << "somebody may still sign its end";
  uploader.ReleaseSeal(Uuid::New());  // another attempt's
  uploader.ReleaseSeal(id());
  uploader.WaitUntilDone(id(), std::chrono::seconds(20));
  EXPECT_TRUE(uploader.state(id()).sealed);
  EXPECT_TRUE(spool_->Get(id())->complete());
}

TEST_F(UploaderTest, ConnectionThatBreaksAgainAndAgainLosesAndDoublesNothing) {
  Record(30);
  ASSERT_TRUE(recorder_->Finish().ok());
  FakeServer server(folder_);
  server.break_every = 7;
  Credentials credentials = server.NewStation();
  for (int i = 0; i < 20 && !spool_->Get(id())->complete(); ++i) {
    ServerLink link;
    ASSERT_TRUE(link.Connect(credentials).ok());
    Status status = UploadAttempt(link, *spool_, id());
    EXPECT_TRUE(status.ok() || IsTransient(status)) << status.message();
  }
  EXPECT_GT(server.connections(), 3);
  EXPECT_TRUE(spool_->Get(id())->complete());
  EXPECT_EQ(server.doubled(), 0);
  ExpectWholeAt(server);
}

TEST_F(UploaderTest, ServerRestoredFromABackupIsFilledUpAgain) {
  Record(12);
  FakeServer server(folder_);
  Credentials credentials = server.NewStation();
  ServerLink link;
  ASSERT_TRUE(link.Connect(credentials).ok());
  ASSERT_TRUE(UploadAttempt(link, *spool_, id()).ok());
  server.Forget(5);
  ASSERT_TRUE(recorder_->Finish().ok());
  ASSERT_TRUE(UploadAttempt(link, *spool_, id()).ok());
  ExpectWholeAt(server);
  EXPECT_TRUE(server.sealed());
}

TEST_F(UploaderTest, RefusalForGoodIsNotedAndTheRecordingKept) {
  Record(2);
  FakeServer server(folder_);
  server.refuse = Status(Code::kForbidden, "the ticket is not of this server");
  ServerLink link;
  ASSERT_TRUE(link.Connect(server.NewStation()).ok());
  EXPECT_EQ(UploadAttempt(link, *spool_, id()).code(), Code::kForbidden);
  EXPECT_EQ(spool_->Get(id())->refused, "the ticket is not of this server");
  EXPECT_EQ(spool_->Get(id())->chunks, 2u);
}

// Its administrator may have taken the station out by mistake, and enrols it again.
TEST_F(UploaderTest, ARefusalOfTheStationGivesUpNoRecording) {
  Record(3);
  ASSERT_TRUE(recorder_->Finish().ok());
  FakeServer server(folder_);
  const Credentials credentials = server.NewStation();
  server.refuse = Status(Code::kUnauthenticated, "this station is no longer admitted");
  {
    ServerLink link;
    ASSERT_TRUE(link.Connect(credentials).ok());
    EXPECT_EQ(UploadAttempt(link, *spool_, id()).code(), Code::kUnauthenticated);
  }
  EXPECT_EQ(spool_->Get(id())->refused, "");
  server.refuse.reset();
  Uploader uploader(credentials, *spool_);
  uploader.WaitUntilDone(id(), kSoon);
  ExpectWholeAt(server);
}

TEST_F(UploaderTest, RecordingThatHasToWaitIsKeptAndOthersGoOn) {
  Record(2);
  ASSERT_TRUE(recorder_->Finish().ok());
  trace::Header other = header_;
  other.ticket.attempt = Uuid::New();
  ASSERT_TRUE(spool_->BeginAttempt(other, "e", "p").ok());
  Recorder recorder(*spool_, ring_, other.ticket.attempt, HashSha256(trace::EncodeHeader(other)),
                    keys_.secret_key);
  for (size_t i = 0; i < Recorder::kTicksPerChunk; ++i) ring_.Push(Sample{});
  ASSERT_TRUE(recorder.Pump().ok());
  ASSERT_TRUE(recorder.Finish().ok());
  FakeServer server(folder_);
  server.awaits = trace::EncodeHeader(header_);  // the one that is brought first
  Credentials credentials = server.NewStation();
  {
    Uploader uploader(credentials, *spool_);
    uploader.WaitUntilDone(other.ticket.attempt, kSoon);
    EXPECT_TRUE(uploader.state(other.ticket.attempt).sealed);
    EXPECT_FALSE(uploader.state(id()).gave_up);
    EXPECT_NE(uploader.state(id()).problem.message().find("person 7"), std::string::npos);
    EXPECT_NE(spool_->Get(id())->waits_because.find("person 7"), std::string::npos);
  }
  EXPECT_EQ(server.connections(), 1) << "not a broken connection each time";
  EXPECT_EQ(spool_->Get(id())->refused, "");
  Retention nothing_kept;
  nothing_kept.age = {};
  nothing_kept.bytes = 1;
  ASSERT_TRUE(
      spool_->Prune(nothing_kept, std::chrono::system_clock::now() + std::chrono::years(1)).ok());
  EXPECT_TRUE(spool_->Get(id()).ok()) << "kept, however long";
  server.awaits.reset();
  Uploader again(credentials, *spool_);
  again.WaitUntilDone(id(), kSoon);
  EXPECT_TRUE(again.state(id()).sealed);
}

// Overwrites a page in the middle of the older of two recordings.
TEST_F(UploaderTest, RecordingThatCannotBeReadWholeWaitsAloneAndOthersGoOn) {
  constexpr uint32_t kChunks = 300, kHit = 200;
  Record(kChunks);
  ASSERT_TRUE(recorder_->Finish().ok());
  std::this_thread::sleep_for(std::chrono::milliseconds(2));  // begun later, by the clock
  trace::Header other = header_;
  other.ticket.attempt = Uuid::New();
  ASSERT_TRUE(spool_->BeginAttempt(other, "e", "p").ok());
  {
    Recorder recorder(*spool_, ring_, other.ticket.attempt, HashSha256(trace::EncodeHeader(other)),
                      keys_.secret_key);
    for (size_t i = 0; i < Recorder::kTicksPerChunk; ++i) ring_.Push(Sample{});
    ASSERT_TRUE(recorder.Finish().ok());
  }
  const Bytes hit = (*spool_->ChunksFrom(id(), kHit, 1)).at(0).bytes;
  recorder_.reset();
  spool_.reset();
  OverwritePageWith(hit);
  spool_ = std::move(*Spool::Open(folder_ / "spool"));
  ASSERT_EQ(spool_->ChunksFrom(id(), kHit, 1).status().field(), kDamagedSpool);

  FakeServer server(folder_);
  Credentials credentials = server.NewStation();
  {
    Uploader uploader(credentials, *spool_);
    uploader.WaitUntilDone(other.ticket.attempt, kSoon);
    EXPECT_TRUE(uploader.state(other.ticket.attempt).sealed);
    uploader.WaitUntilDone(id(), kSoon);
    EXPECT_TRUE(uploader.state(id()).gave_up) << "nobody need wait for it";
    EXPECT_TRUE(IsDamaged(uploader.state(id()).problem)) << uploader.state(id()).problem.message();
    EXPECT_TRUE(uploader.link().reachable) << "the server is there";
  }
  EXPECT_EQ(server.connections(), 1) << "the connection carries the others";
  const SpooledAttempt left = *spool_->Get(id());
  EXPECT_NE(left.waits_because.find("spool salvage"), std::string::npos) << left.waits_because;
  EXPECT_EQ(left.refused, "") << "once it is salvaged it is sent";
  EXPECT_GT(left.committed, 0u) << "what can be read before the damage is there";
  EXPECT_EQ(left.committed, server.chunks().size());
  EXPECT_EQ(spool_->Get(other.ticket.attempt)->waits_because, "");
}

TEST_F(UploaderTest, WhyARecordingWaitsIsInTheSpoolUntilItIsSent) {
  Record(3);
  ASSERT_TRUE(recorder_->Finish().ok());
  uint16_t port = 0;
  Credentials credentials;
  {
    FakeServer server(folder_);
    port = server.endpoint().port;
    credentials = server.NewStation();
  }
  auto waits = [&](Uploader& uploader, const std::string& words) {
    for (int i = 0; i < 10'000; ++i) {
      if (spool_->Get(id())->waits_because.find(words) != std::string::npos) return true;
      uploader.Retry();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  };
  int64_t since = 0;
  {
    Uploader uploader(credentials, *spool_);
    ASSERT_TRUE(waits(uploader, std::to_string(port))) << "nobody listens there";
    since = spool_->Get(id())->waits_since_unix_ms;
    EXPECT_GT(since, 0);
  }
  {
    FakeServer server(folder_, port);
    server.refuse = Status(Code::kStorage, "its disk is full");
    Uploader uploader(credentials, *spool_);
    ASSERT_TRUE(waits(uploader, "its disk is full"));
    EXPECT_EQ(spool_->Get(id())->waits_since_unix_ms, since) << "it has waited since then";
    EXPECT_GE(spool_->Get(id())->tried_unix_ms, since);
  }
  EXPECT_NE(spool_->Get(id())->waits_because.find("its disk is full"), std::string::npos)
      << "that it was stopped here says nothing of the server";
  FakeServer server(folder_, port);
  Uploader uploader(credentials, *spool_);
  uploader.WaitUntilDone(id(), kSoon);
  ASSERT_TRUE(uploader.state(id()).sealed);
  EXPECT_EQ(spool_->Get(id())->waits_because, "");
  EXPECT_EQ(spool_->Get(id())->waits_since_unix_ms, 0);
}

TEST_F(UploaderTest, UploadsWhileRecordingGoesOn) {
  FakeServer server(folder_);
  Uploader uploader(server.NewStation(), *spool_);
  for (int i = 0; i < 20; ++i) {
    Record(1);
    uploader.Wake();
  }
  ASSERT_TRUE(recorder_->Finish().ok());
  uploader.Wake();
  uploader.WaitUntilDone(id(), kSoon);
  EXPECT_TRUE(uploader.state(id()).sealed) << uploader.state(id()).problem.message();
  ExpectWholeAt(server);
}

TEST_F(UploaderTest, ServerThatComesLaterIsFound) {
  uint16_t port = 0;
  Credentials credentials;
  {
    FakeServer once(folder_);
    port = once.endpoint().port;
    credentials = once.NewStation();
  }
  Record(4);
  ASSERT_TRUE(recorder_->Finish().ok());
  Uploader uploader(credentials, *spool_);
  uploader.WaitUntilDone(id(), std::chrono::milliseconds(50));
  EXPECT_FALSE(uploader.state(id()).sealed);
  EXPECT_FALSE(uploader.state(id()).gave_up);
  FakeServer server(folder_, port);
  uploader.WaitUntilDone(id(), kSoon);
  EXPECT_TRUE(uploader.state(id()).sealed) << uploader.state(id()).problem.message();
  ExpectWholeAt(server);
}

TEST_F(UploaderTest, ServerWithAnotherCertificateIsGivenUp) {
  FakeServer server(folder_);
  Credentials credentials = server.NewStation();
  credentials.fingerprint = HashSha256(AsBytes("another"));
  Uploader uploader(credentials, *spool_);
  uploader.WaitUntilDone(id(), kSoon);
  EXPECT_TRUE(uploader.state(id()).gave_up);
  EXPECT_EQ(uploader.state(id()).problem.code(), Code::kUnauthenticated);
  EXPECT_EQ(server.chunks().size(), 0u);
}

// Another server answers at the address for a moment, then the right one returns.
class WrongServerTest : public UploaderTest {
 protected:
  WrongServerTest() {
    Record(3);
    EXPECT_TRUE(recorder_->Finish().ok());
    fs::create_directories(folder_ / "wrong");
    own_.emplace(folder_);
    credentials_ = own_->NewStation();
    own_.reset();
    wrong_.emplace(folder_ / "wrong", credentials_.server.port);
  }
  void ComeBack() {
    wrong_.reset();
    own_.emplace(folder_, credentials_.server.port);
  }
  static bool Await(const std::function<bool()>& so) {
    for (int i = 0; i < 60'000 && !so(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return so();
  }
  std::optional<FakeServer> own_, wrong_;
  Credentials credentials_;
};

TEST_F(WrongServerTest, UploadsGoOnByThemselvesSomeTimeAfter) {
  UploaderOptions options;
  options.refused_first = std::chrono::milliseconds(20);
  Uploader uploader(credentials_, *spool_, options);
  ASSERT_TRUE(Await([&] { return uploader.link().refused; }));
  ComeBack();
  EXPECT_TRUE(Await([&] { return uploader.state(id()).sealed; }));
  EXPECT_FALSE(uploader.link().refused);
}

TEST_F(WrongServerTest, UploadsGoOnAtOnceWhenAnAttemptBeginsOrSomebodySignsIn) {
  for (bool begins : {true, false}) {
    if (!begins) {
      own_.reset();
      wrong_.emplace(folder_ / "wrong", credentials_.server.port);
    }
    Uploader uploader(credentials_, *spool_);  // waits a minute
    ASSERT_TRUE(Await([&] { return uploader.link().refused; }));
    ComeBack();
    if (begins)
      uploader.Prefer(id(), nullptr);
    else
      uploader.Retry();
    EXPECT_TRUE(Await([&] { return uploader.link().reachable; }));
  }
}

TEST_F(UploaderTest, WhatTheServerHasHadForLongIsForgottenWhileTheProgramRuns) {
  Record(2);
  FakeServer server(folder_);
  UploaderOptions options;
  options.retention = Retention{std::chrono::hours(0), 0};
  options.prune_every = std::chrono::milliseconds(5);
  Uploader uploader(server.NewStation(), *spool_, options);
  for (int i = 0; i < 60'000 && spool_->Get(id())->committed < 2; ++i) {
    uploader.Wake();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  uploader.Wake();
  // It has an end that the server lacks.
  ASSERT_TRUE(spool_->Get(id()).ok());
  ASSERT_TRUE(recorder_->Finish().ok());
  for (int i = 0; i < 60'000 && spool_->Get(id()).ok(); ++i) {
    uploader.Wake();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(spool_->Get(id()).status().code(), Code::kNotFound);
  EXPECT_TRUE(server.sealed());
}

TEST_F(UploaderTest, RefusedRecordingIsSentWhenItIsTriedOnceMore) {
  Record(2);
  ASSERT_TRUE(recorder_->Finish().ok());
  FakeServer server(folder_);
  Credentials credentials = server.NewStation();
  server.refuse = Status(Code::kForbidden, "the ticket is not of this server");
  ServerLink link;
  ASSERT_TRUE(link.Connect(credentials).ok());
  EXPECT_FALSE(UploadAttempt(link, *spool_, id()).ok());
  EXPECT_TRUE(WaitingAttempts(*spool_)->empty());
  server.refuse.reset();
  ASSERT_TRUE(spool_->ClearRefusal(id()).ok());
  EXPECT_EQ(WaitingAttempts(*spool_)->size(), 1u);
  ServerLink again;
  link.Close();
  ASSERT_TRUE(again.Connect(credentials).ok());
  ASSERT_TRUE(UploadAttempt(again, *spool_, id()).ok());
  ExpectWholeAt(server);
}

// The server was restored from a backup made before the attempt; nobody informs the station.
TEST_F(UploaderTest, WhatTheServerLostIsSentAgainAsSoonAsItIsAsked) {
  Record(9);
  ASSERT_TRUE(recorder_->Finish().ok());
  FakeServer server(folder_);
  Credentials credentials = server.NewStation();
  {
    Uploader uploader(credentials, *spool_);
    uploader.WaitUntilDone(id(), kSoon);
    ASSERT_TRUE(spool_->Get(id())->complete());
  }
  EXPECT_EQ(server.offered(), 0);
  server.Forget(0);
  ServerLink link;
  ASSERT_TRUE(link.Connect(credentials).ok());
  Bandwidth no_bound(0);
  AttemptSender sender(link, *spool_, no_bound);
  EXPECT_EQ(*sender.Offer(), 1u);
  EXPECT_EQ(server.offered(), 1);
  EXPECT_EQ(WaitingAttempts(*spool_)->size(), 1u);
  ASSERT_TRUE(sender.Send(id()).ok());
  ExpectWholeAt(server);
  EXPECT_TRUE(spool_->Get(id())->complete());
  EXPECT_EQ(*sender.Offer(), 0u);
}

TEST_F(UploaderTest, WhatTheServerLosesWhileTheConnectionLastsIsSentAgain) {
  Record(9);
  ASSERT_TRUE(recorder_->Finish().ok());
  FakeServer server(folder_);
  UploaderOptions options;
  options.offer_every = std::chrono::milliseconds(20);
  Uploader uploader(server.NewStation(), *spool_, options);
  uploader.WaitUntilDone(id(), kSoon);
  server.Forget(0);
  ASSERT_TRUE(test::Becomes([&] { return server.chunks().size() == 9; }));
  ExpectWholeAt(server);
  EXPECT_EQ(server.connections(), 1);
}

TEST_F(UploaderTest, ServerIsToldThatAnAttemptWasResumed) {
  Record(2);
  ASSERT_TRUE(spool_->MarkResumed(id()).ok());
  FakeServer server(folder_);
  ServerLink link;
  ASSERT_TRUE(link.Connect(server.NewStation()).ok());
  ASSERT_TRUE(UploadAttempt(link, *spool_, id()).ok());
  EXPECT_EQ(server.resumed(), 1u);
}

TEST_F(UploaderTest, RevokedTicketIsForgottenAndAnotherKept) {
  LockedTicket ticket;
  ticket.attempt = Uuid::New();
  ticket.locked = Bytes(10);
  ASSERT_TRUE(spool_->tickets().Put(ticket).ok());
  // A ticket whose attempt was begun is no longer asked about.
  ticket.attempt = id();
  ASSERT_TRUE(spool_->tickets().Put(ticket).ok());
  FakeServer server(folder_);
  server.revoke_tickets = true;
  ServerLink link;
  ASSERT_TRUE(link.Connect(server.NewStation()).ok());
  Bandwidth no_bound(0);
  ASSERT_TRUE(AttemptSender(link, *spool_, no_bound).Offer().ok());
  auto left = *spool_->tickets().List();
  ASSERT_EQ(left.size(), 1u);
  EXPECT_EQ(left[0].attempt, id());
}

TEST_F(UploaderTest, HandedBackTicketIsReturnedAndForgottenWhateverTheServerSays) {
  const Status answers[] = {Status::Ok(),
                            {Code::kNotFound, "no such"},
                            {Code::kConflict, "opened"},
                            protocol::ToStatus(protocol::UnsupportedError())};
  for (const Status& answer : answers) {
    LockedTicket ticket;
    ticket.attempt = Uuid::New();
    ticket.locked = Bytes(10);
    ASSERT_TRUE(spool_->tickets().Put(ticket).ok());
    ASSERT_TRUE(spool_->tickets().HandBack(ticket.attempt).ok());
    FakeServer server(folder_);
    if (!answer.ok()) server.refuse_returns = answer;
    ServerLink link;
    ASSERT_TRUE(link.Connect(server.NewStation()).ok());
    Bandwidth no_bound(0);
    AttemptSender sender(link, *spool_, no_bound);
    ASSERT_TRUE(sender.Offer().ok());
    EXPECT_EQ(spool_->tickets().List()->size(), 1u) << "it is no longer asked about";
    ASSERT_TRUE(sender.ReturnTickets().ok());
    EXPECT_EQ(server.returned(), std::vector<Uuid>{ticket.attempt});
    EXPECT_TRUE(spool_->tickets().List()->empty()) << CodeName(answer.code());
    ASSERT_TRUE(sender.ReturnTickets().ok());
    EXPECT_EQ(server.returned().size(), 1u);
  }
}

TEST_F(UploaderTest, HandedBackTicketWaitsForTheServerAndNeverCostsAnAttempt) {
  LockedTicket ticket;
  ticket.attempt = Uuid::New();
  ASSERT_TRUE(spool_->tickets().Put(ticket).ok());
  LockedTicket begun;
  begun.attempt = id();  // its recording is in the spool
  ASSERT_TRUE(spool_->tickets().Put(begun).ok());
  FakeServer server(folder_);
  {
    ServerLink link;
    ASSERT_TRUE(link.Connect(server.NewStation()).ok());
    link.Close();
    Bandwidth no_bound(0);
    EXPECT_EQ(AttemptSender(link, *spool_, no_bound).ReturnTickets().code(), Code::kUnavailable);
    EXPECT_FALSE(spool_->tickets().List()->empty());
  }
  Uploader uploader(server.NewStation(), *spool_);
  while (!spool_->tickets().List()->empty()) std::this_thread::yield();
  EXPECT_EQ(server.returned(), std::vector<Uuid>{ticket.attempt});
  ASSERT_TRUE(spool_->tickets().Put(ticket).ok());
  uploader.Wake();
  while (!spool_->tickets().List()->empty()) std::this_thread::yield();
  EXPECT_EQ(server.returned().size(), 2u) << "on the connection it has";
}

// Two attempts wait; a third is being made: its chunks do not wait for theirs.
TEST_F(UploaderTest, AttemptBeingMadeGoesFirst) {
  Record(200);
  trace::Header other = header_;
  other.ticket.attempt = Uuid::New();
  ASSERT_TRUE(spool_->BeginAttempt(other, "e", "p").ok());
  Recorder recorder(*spool_, ring_, other.ticket.attempt, HashSha256(trace::EncodeHeader(other)),
                    keys_.secret_key);
  FakeServer server(folder_);
  server.ack_delay_ms = 5;
  Uploader uploader(server.NewStation(), *spool_);
  while (uploader.link().reachable && server.chunks().empty()) std::this_thread::yield();
  for (size_t i = 0; i < Recorder::kTicksPerChunk; ++i) ring_.Push(Sample{});
  ASSERT_TRUE(recorder.Finish().ok());
  uploader.Prefer(other.ticket.attempt, nullptr);
  uploader.WaitUntilDone(other.ticket.attempt, kSoon);
  EXPECT_TRUE(uploader.state(other.ticket.attempt).sealed);
  EXPECT_LT(spool_->Get(id())->committed, 150u);
  EXPECT_EQ(server.doubled(), 0);
}

TEST_F(UploaderTest, RemarkComesWithAcknowledgementsAndTheServerHearsThatItWasShown) {
  FakeServer server(folder_);
  Uploader uploader(server.NewStation(), *spool_);
  uploader.Prefer(id(), nullptr);
  server.Say({70, "请停一下", "Ada", 1});
  const auto until = std::chrono::steady_clock::now() + kSoon;
  auto record_until = [&](const std::function<bool()>& done) {
    while (!done() && std::chrono::steady_clock::now() < until) {
      Record(1);
      uploader.Wake();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  };
  record_until([&] { return uploader.remarks().Next(id()).has_value(); });
  ASSERT_TRUE(uploader.remarks().Next(id()));
  EXPECT_EQ(uploader.remarks().Next(id())->text, "请停一下");
  EXPECT_EQ(uploader.remarks().Next(id())->from, "Ada");
  EXPECT_TRUE(server.shows_remarks());
  EXPECT_EQ(server.shown(), 0u) << "received is not shown";
  uploader.remarks().Shown(id(), 70);
  record_until([&] { return server.shown() == 70; });
  EXPECT_EQ(server.shown(), 70u);
  server.Say({70, "请停一下", "Ada", 1});
  record_until([&, n = 0]() mutable { return ++n > 3; });
  EXPECT_FALSE(uploader.remarks().Next(id())) << "shown once";
}

class LiveTest : public UploaderTest {
 protected:
  // Records and shows `ticks` in real time, and returns how many live states came meanwhile.
  int Run(FakeServer& server, Uploader& uploader, int chunks) {
    auto mailbox = std::make_shared<LiveMailbox>();
    uploader.Prefer(id(), mailbox);
    int before = server.live();
    for (int c = 0; c < chunks; ++c) {
      Record(1);
      uploader.Wake();
      for (int i = 0; i < 500; i += 5) {
        ticks_ += 5;
        mailbox->Write({ticks_, {1, 2, 3}, {4, 5, 6}, 0});
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
    }
    return server.live() - before;
  }
  uint64_t ticks_ = 0;
};

TEST_F(LiveTest, NothingIsSentWhileNobodyWatches) {
  FakeServer server(folder_);
  Uploader uploader(server.NewStation(), *spool_);
  EXPECT_EQ(Run(server, uploader, 2), 0);
}

// The number depends on the machine's speed. That some arrive, are the newest and are at most 60 a
// second does not.
TEST_F(LiveTest, WhoWatchesGetsTheNewestMoments) {
  FakeServer server(folder_);
  server.watched = true;
  Uploader uploader(server.NewStation(), *spool_);
  auto begin = std::chrono::steady_clock::now();
  int live = Run(server, uploader, 4);
  double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_GT(live, 10);
  EXPECT_LE(live, 60 * took_s + 3);
  EXPECT_LT(server.last_live_tick(), ticks_);
  EXPECT_GT(server.last_live_tick(), ticks_ / 2);
  EXPECT_EQ(spool_->Get(id())->chunks, 4u);
}

TEST_F(LiveTest, ShortBandwidthDropsTheLiveViewAndNoChunk) {
  FakeServer server(folder_);
  server.watched = true;
  // Less than the chunks need: nothing is left over.
  Record(1);
  uint64_t chunk_bytes = spool_->Get(id())->bytes;
  Uploader uploader(server.NewStation(), *spool_, {chunk_bytes});
  int live = Run(server, uploader, 3);
  ASSERT_TRUE(recorder_->Finish().ok());
  uploader.Wake();
  uploader.WaitUntilDone(id(), kSoon);
  ExpectWholeAt(server);
  EXPECT_GT(uploader.link().live_dropped, static_cast<uint64_t>(live));
}

}  // namespace
}  // namespace enamel::station
