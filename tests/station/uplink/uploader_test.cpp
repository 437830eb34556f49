#include "station/uplink/uploader.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include "station/spool/recorder.h"
#include "tests/station/uplink/fake_server.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;
constexpr std::chrono::seconds kSoon{60};  // never waited for when all is well

class UploaderTest : public testing::Test {
 protected:
  UploaderTest() {
    std::string name = (fs::temp_directory_path() / "enamel_uplink_XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    spool_ = std::move(*Spool::Open(folder_ / "spool"));
    header_.ticket.attempt = Uuid::New();
    header_.params.kc_mn_per_mm = 2500;
    header_.params.resolution_nm = {10'000, 10'000, 10'000};
    header_.params.peak_force_mn = 7900;
    header_.params.bur_radius_nm = 500'000;
    EXPECT_TRUE(spool_->BeginAttempt(header_, "e", "p").ok());
    recorder_.emplace(*spool_, ring_, id(), HashSha256(trace::EncodeHeader(header_)),
                      keys_.secret_key);
  }
  ~UploaderTest() override {
    recorder_.reset();
    spool_.reset();
    fs::remove_all(folder_);
  }

  Uuid id() const { return header_.ticket.attempt; }
  void Record(int chunks) {
    for (int c = 0; c < chunks; ++c) {
      for (size_t i = 0; i < Recorder::kTicksPerChunk; ++i) ring_.Push(Sample{});
      ASSERT_TRUE(recorder_->Pump().ok());
    }
  }
  void ExpectWholeAt(const FakeServer& server) {
    auto spooled = *spool_->ChunksFrom(id(), 0, 1000);
    auto there = server.chunks();
    ASSERT_EQ(there.size(), spooled.size());
    for (const SpooledChunk& c : spooled) EXPECT_EQ(there[c.seq], c.bytes) << c.seq;
  }

  fs::path folder_;
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

TEST_F(UploaderTest, UploadsWhileRecordingGoesOn) {
  FakeServer server(folder_);
  Uploader uploader(server.NewStation(), *spool_, id());
  for (int i = 0; i < 20; ++i) {
    Record(1);
    uploader.Wake();
  }
  ASSERT_TRUE(recorder_->Finish().ok());
  uploader.Wake();
  uploader.WaitUntilDone(kSoon);
  EXPECT_TRUE(uploader.state().sealed) << uploader.state().problem.message();
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
  Uploader uploader(credentials, *spool_, id());
  uploader.WaitUntilDone(std::chrono::milliseconds(50));
  EXPECT_FALSE(uploader.state().sealed);
  EXPECT_FALSE(uploader.state().gave_up);
  FakeServer server(folder_, port);
  uploader.WaitUntilDone(kSoon);
  EXPECT_TRUE(uploader.state().sealed) << uploader.state().problem.message();
  ExpectWholeAt(server);
}

TEST_F(UploaderTest, ServerWithAnotherCertificateIsGivenUp) {
  FakeServer server(folder_);
  Credentials credentials = server.NewStation();
  credentials.fingerprint = HashSha256(AsBytes("another"));
  Uploader uploader(credentials, *spool_, id());
  uploader.WaitUntilDone(kSoon);
  EXPECT_TRUE(uploader.state().gave_up);
  EXPECT_EQ(uploader.state().problem.code(), Code::kUnauthenticated);
  EXPECT_EQ(server.chunks().size(), 0u);
}

}  // namespace
}  // namespace enamel::station
