#include "station/session/running_attempt.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <boost/json.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>

#include "station/session/workplace.h"
#include "tests/station/session/faulty_disk.h"
#include "tests/station/session/log_lines.h"
#include "tests/support/block_plan.h"
#include "tests/support/temp_folder.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

// Goes down into the block with the pedal down, slowly, and stays there.
class Plunging final : public Device {
 public:
  Plunging(int32_t from, int32_t to) : z_(from), to_(to) {}
  std::string Name() const override { return "plunging"; }
  Hand hand() const override { return MakeHand(HandKind::kHaptic, Name(), "test"); }
  bool has_motors() const noexcept override { return true; }
  DeviceSample ReadSample() noexcept override {
    DeviceSample s;
    if (z_ > to_) --z_;
    s.counts[2] = z_;
    s.buttons = pedal ? kPedal : 0;
    s.bur_speed_krpm = pedal ? kTurbineSpeed_krpm : uint16_t{0};
    s.attached = attached;
    policy = ::sched_getscheduler(0);
    ++reads;
    return s;
  }
  void SendForce(const dvec3& force_n) noexcept override {
    bool zero = force_n == dvec3(0);
    zeros_in_a_row = zero ? zeros_in_a_row + 1 : 0;
    if (!zero) ++pushed;
  }

  std::atomic<uint64_t> reads{0}, zeros_in_a_row{0}, pushed{0};
  std::atomic<bool> attached{true}, pedal{true};
  std::atomic<int> policy{-1};  // of the loop's thread, in the system's own words

 private:
  int32_t z_;
  const int32_t to_;
};

class RunningAttemptTest : public testing::Test {
 protected:
  RunningAttemptTest() {
    test::BlockPlan block = test::MakeBlockPlan();
    prepared_.header.ticket.attempt = Uuid::New();
    prepared_.header.params = block.params;
    prepared_.header.station_software = "test";
    prepared_.header.hand.kind = HandKind::kProgram;
    above_ = block.CountsAbove(300'000);
    prepared_.volume = std::move(block.volume);
    volume_ = prepared_.volume;
    Credentials nowhere;
    nowhere.server = {"127.0.0.1", 1};
    nowhere.station = Uuid::New();
    nowhere.secret_key = trace::NewKeyPair().secret_key;
    key_ = nowhere.secret_key;
    EXPECT_TRUE(SaveCredentials(folder_, nowhere).ok());
    auto opened = Workplace::Open({.data = folder_});
    EXPECT_TRUE(opened.ok()) << opened.status().message();
    workplace_ = std::move(*opened);
  }
  ~RunningAttemptTest() override { workplace_.reset(); }

  Spool& spool() { return workplace_->spool(); }
  Uuid id() const { return prepared_.attempt(); }
  std::unique_ptr<RunningAttempt> Begin(Device& device,
                                        const std::atomic<int>* stops_asked = nullptr) {
    AttemptOptions options;
    options.faults_when_late = false;
    options.stops_asked = stops_asked;
    auto begun = workplace_->Begin(prepared_, device, options);
    EXPECT_TRUE(begun.ok()) << begun.status().message();
    return std::move(*begun);
  }
  // Waits for a condition, with a limit that is not reached when all is well.
  static bool Await(const std::function<bool()>& so) {
    for (int i = 0; i < 60'000 && !so(); ++i) std::this_thread::sleep_for(milliseconds(1));
    return so();
  }
  // The same core reproduces the recording on disk.
  void ExpectReplays(const core::Core& core) {
    core::Core again(prepared_.header.params, volume_);
    auto file = spool().Export(id());
    ASSERT_TRUE(file.ok());
    for (const Bytes& bytes : file->chunks) {
      auto chunk = trace::DecodeChunk(bytes);
      ASSERT_TRUE(chunk.ok());
      for (const trace::Tick& t : chunk->ticks) ASSERT_EQ(again.Step(t.input).witness, t.witness);
    }
    EXPECT_EQ(again.state_hash(), core.state_hash());
  }

  FaultyDisk disk_;
  test::TempFolder temp_;
  const fs::path folder_ = temp_.path();
  PreparedAttempt prepared_;
  cutting::Volume volume_;
  trace::SecretKey key_{};
  int32_t above_ = 0;
  std::unique_ptr<Workplace> workplace_;
};

// However a disk fails: no tick is stepped after the first failed write and a turn of the recorder,
// and all samples from before are kept and stored.
class FailingDiskTest : public RunningAttemptTest, public testing::WithParamInterface<int> {};

TEST_P(FailingDiskTest, ForceEndsAtOnceAndWhatWasFeltIsStoredWhenThereIsRoomAgain) {
  Plunging device(above_, above_ - 60);
  auto attempt = Begin(device);
  ASSERT_TRUE(Await([&] { return attempt->recording().chunks >= 1 && device.pushed > 0; }));
  FaultyDisk::fail = GetParam();
  ASSERT_TRUE(Await([&] { return !attempt->recording().problem.ok(); }));
  // Held from the next tick on, far before the ring is full.
  const uint64_t read = device.reads;
  ASSERT_TRUE(Await([&] { return device.reads > read + 50; }));
  const uint64_t stepped = attempt->snapshot().counters.ticks;
  const uint64_t zeros = device.zeros_in_a_row;
  ASSERT_TRUE(Await([&] { return device.reads > read + 300; }));
  EXPECT_EQ(attempt->snapshot().counters.ticks, stepped);
  EXPECT_GE(device.zeros_in_a_row, zeros + 200);
  RunningAttempt::Recording held = attempt->recording();
  EXPECT_EQ(held.problem.code(), Code::kStorage);
  EXPECT_EQ(held.ticks + held.waiting_ticks, stepped);

  FaultyDisk::fail = SQLITE_OK;
  ASSERT_TRUE(Await([&] { return attempt->recording().problem.ok(); }));
  ASSERT_TRUE(Await([&] { return attempt->snapshot().counters.ticks > stepped; }));
  attempt->End();
  auto seal = attempt->Join();
  ASSERT_TRUE(seal.ok()) << seal.status().message();
  EXPECT_GT(seal->ticks, stepped);
  EXPECT_EQ(spool().Get(id())->ticks, seal->ticks);
  EXPECT_GE(spool().Get(id())->gap_ticks, 250u);
  ExpectReplays(attempt->core());
}

TEST_P(FailingDiskTest, TheSealWaitsForRoomAsLongAsTheProcessLives) {
  Plunging device(above_, above_ - 60);
  auto attempt = Begin(device);
  ASSERT_TRUE(Await([&] { return attempt->recording().chunks >= 1; }));
  FaultyDisk::fail = GetParam();
  attempt->End();
  ASSERT_TRUE(Await([&] { return !attempt->ticking() && !attempt->recording().problem.ok(); }));
  const int refused = FaultyDisk::refused;
  ASSERT_TRUE(Await([&] { return FaultyDisk::refused >= refused + 5; }));
  EXPECT_FALSE(attempt->recorded());
  FaultyDisk::fail = SQLITE_OK;
  auto seal = attempt->Join();
  ASSERT_TRUE(seal.ok()) << seal.status().message();
  EXPECT_EQ(seal->ticks, attempt->snapshot().counters.ticks);
  EXPECT_TRUE(spool().Get(id())->seal.has_value());
  ExpectReplays(attempt->core());
}

TEST_P(FailingDiskTest, GivenUpItSaysWhatIsSafeAndWhatIsLost) {
  Plunging device(above_, above_ - 60);
  auto attempt = Begin(device);
  ASSERT_TRUE(Await([&] { return attempt->recording().chunks >= 2; }));
  FaultyDisk::fail = GetParam();
  ASSERT_TRUE(Await([&] { return !attempt->recording().problem.ok(); }));
  attempt->End();
  attempt->GiveUp();
  auto seal = attempt->Join();
  ASSERT_FALSE(seal.ok());
  const std::string said = seal.status().message();
  const uint32_t chunks = attempt->recording().chunks;
  char safe[32];
  std::snprintf(safe, sizeof safe, "first %.2f s are safe",
                static_cast<double>(chunks * Recorder::kTicksPerChunk) / 1000);
  EXPECT_NE(said.find(safe), std::string::npos) << said;
  EXPECT_NE(said.find("are lost"), std::string::npos) << said;
  EXPECT_NE(said.find("spool close " + id().Text()), std::string::npos) << said;
  FaultyDisk::fail = SQLITE_OK;
  EXPECT_EQ(spool().Get(id())->chunks, chunks);
  EXPECT_FALSE(spool().Get(id())->seal.has_value());
}

TEST_P(FailingDiskTest, LeftItIsResumableAsFarAsTheDiskTookIt) {
  Plunging device(above_, above_ - 60);
  auto attempt = Begin(device);
  ASSERT_TRUE(Await([&] { return attempt->recording().chunks >= 2; }));
  FaultyDisk::fail = GetParam();
  ASSERT_TRUE(Await([&] { return !attempt->recording().problem.ok(); }));
  const Status left = attempt->Leave();
  EXPECT_EQ(left.code(), Code::kStorage);
  EXPECT_NE(left.message().find("are safe"), std::string::npos) << left.message();
  FaultyDisk::fail = SQLITE_OK;
  EXPECT_FALSE(spool().Get(id())->seal.has_value());
  EXPECT_GE(spool().Get(id())->chunks, 2u);
}

INSTANTIATE_TEST_SUITE_P(Each, FailingDiskTest,
                         testing::Values(SQLITE_FULL, SQLITE_READONLY, SQLITE_IOERR_WRITE));

TEST_F(RunningAttemptTest, LeftItHasEachTickAndNoEndAndTheDeviceNoForce) {
  for (const bool destroyed : {false, true}) {
    prepared_.header.ticket.attempt = Uuid::New();
    Plunging device(above_, above_ - 60);
    auto attempt = Begin(device);
    ASSERT_TRUE(Await([&] { return attempt->recording().chunks >= 1 && device.pushed > 0; }));
    if (!destroyed) {
      EXPECT_TRUE(attempt->Leave().ok());
      EXPECT_TRUE(attempt->Leave().ok()) << "again";
      EXPECT_EQ(attempt->snapshot().counters.ticks, spool().Get(id())->ticks);
      ExpectReplays(attempt->core());
    }
    attempt.reset();
    EXPECT_GT(device.zeros_in_a_row, 0u);
    const auto left = spool().Get(id());
    ASSERT_TRUE(left.ok());
    EXPECT_FALSE(left->seal.has_value());
    EXPECT_TRUE(spool().loop_facts().Of(id())->size() == 1u);
    // Another process may go on with it.
    EXPECT_TRUE(spool().LockForRecording().ok());
    auto sealed = spool().CloseAttempt(id());
    ASSERT_TRUE(sealed.ok()) << sealed.status().message();
    EXPECT_EQ(sealed->ticks, left->ticks);
  }
}

// The window hangs in a call when the window system no longer answers.
TEST_F(RunningAttemptTest, ItLeavesByItselfIfItsOwnerDoesNotSeeTheStop) {
  Plunging device(above_, above_ - 60);
  std::atomic<int> stops_asked{0};
  auto attempt = Begin(device, &stops_asked);
  ASSERT_TRUE(Await([&] { return attempt->recording().chunks >= 1 && device.pushed > 0; }));
  EXPECT_TRUE(attempt->ticking());
  stops_asked = 1;
  ASSERT_TRUE(Await([&] { return attempt->recorded(); }));
  EXPECT_GT(device.zeros_in_a_row, 0u);
  EXPECT_TRUE(attempt->left());
  const auto left = spool().Get(id());
  ASSERT_TRUE(left.ok());
  EXPECT_FALSE(left->seal.has_value());
  // Then it does.
  EXPECT_TRUE(attempt->Leave().ok());
  EXPECT_TRUE(attempt->left());
  EXPECT_EQ(attempt->snapshot().counters.ticks, left->ticks);
}

// What its person has ended is handed in, whatever stops the program then.
TEST_F(RunningAttemptTest, EndedItIsSealedAlsoIfTheProgramIsStoppedThen) {
  Plunging device(above_, above_ - 60);
  auto attempt = Begin(device);
  ASSERT_TRUE(Await([&] { return attempt->recording().chunks >= 1; }));
  attempt->End();
  EXPECT_TRUE(attempt->Leave().ok());
  EXPECT_TRUE(attempt->Join().ok());
  EXPECT_TRUE(spool().Get(id())->seal.has_value());
}

// While the disk takes nothing no tick is stepped, and the attempt may end in that state.
TEST_F(RunningAttemptTest, WhetherItLacksRealtimeRightsIsWhatTheSystemSays) {
  Plunging device(above_, above_);
  auto run = Begin(device);
  ASSERT_TRUE(Await([&] { return device.reads > 10; }));
  std::ifstream file("/proc/self/status");
  const std::string status{std::istreambuf_iterator<char>(file), {}};
  const size_t locked = status.find("VmLck:");
  ASSERT_NE(locked, std::string::npos);
  const bool has_both =
      device.policy == SCHED_FIFO && std::strtoull(&status[locked + 6], nullptr, 10) > 0;
  EXPECT_EQ(run->lacks_realtime(), !has_both);
  EXPECT_TRUE(run->Leave().ok());
}

TEST_F(RunningAttemptTest, AFaultWhileTheDiskHoldsTheLoopIsLoggedThen) {
  LogLines log;
  Plunging device(above_, above_);
  auto attempt = Begin(device);
  ASSERT_TRUE(Await([&] { return attempt->recording().chunks >= 1; }));
  FaultyDisk::fail = SQLITE_FULL;
  ASSERT_TRUE(Await([&] { return !attempt->recording().problem.ok(); }));
  EXPECT_EQ(attempt->loop().fault(), Fault::kNone);
  device.attached = false;
  EXPECT_TRUE(Await([&] { return log.Has("the force is off: the device is not connected"); }));
  EXPECT_FALSE(attempt->recording().problem.ok()) << "the disk still takes nothing";
  FaultyDisk::fail = SQLITE_OK;
  attempt->End();
  EXPECT_TRUE(attempt->Join().ok());
}

// Unplugged for a while in the middle, the pedal released and pressed after it.
TEST_F(RunningAttemptTest, HowTheLoopWentIsKeptWithTheAttemptAndItsFaultsAreLogged) {
  LogLines log;
  Plunging device(above_, above_);
  auto attempt = Begin(device);
  ASSERT_TRUE(Await([&] { return device.reads > 50; }));
  device.attached = false;
  ASSERT_TRUE(Await([&] { return log.Has("the force is off: the device is not connected"); }));
  device.attached = true;
  device.pedal = false;
  const uint64_t read = device.reads;
  ASSERT_TRUE(Await([&] { return device.reads > read + 5; }));
  device.pedal = true;
  ASSERT_TRUE(Await([&] { return log.Has("the force comes on again"); }));
  attempt->End();
  ASSERT_TRUE(attempt->Join().ok());
  auto kept = spool().loop_facts().Of(id());
  ASSERT_TRUE(kept.ok());
  ASSERT_EQ(kept->size(), 1u);
  EXPECT_EQ((*kept)[0].run, 0u);
  EXPECT_GT((*kept)[0].ended_unix_ms, 0);
  EXPECT_EQ((*kept)[0].json, boost::json::serialize(attempt->facts()));
  const auto facts = boost::json::parse((*kept)[0].json).as_object();
  const LoopCounters& counters = attempt->loop().counters();
  EXPECT_EQ(facts.at("ticks"), counters.ticks);
  EXPECT_EQ(facts.at("lateness").at("count"), counters.ticks + counters.gap_ticks);
  EXPECT_FALSE(facts.at("lateness").at("ns").as_object().empty());
  ASSERT_EQ(facts.at("faults").as_array().size(), 1u);
  EXPECT_EQ(facts.at("faults").at(0).at("why"), FaultText(Fault::kUnplugged));
  for (const std::string& line :
       {"info: attempt " + id().Text() + " begins: exercise ", "warning: attempt " + id().Text(),
        "info: attempt " + id().Text() + " has ended: " + std::to_string(counters.ticks) +
            " ticks, " + std::to_string(counters.late_ticks) + " late"}) {
    EXPECT_TRUE(log.Has(line)) << line << " in\n" << log.text();
  }
  EXPECT_TRUE(log.Has(" 1 faults")) << log.text();
}

TEST_F(RunningAttemptTest, ADiskThatTakesNothingIsFoundBeforeAnAttemptBegins) {
  FaultyDisk::fail = SQLITE_FULL;
  const Status ready = workplace_->MakeReady(prepared_);
  EXPECT_EQ(ready.code(), Code::kStorage);
  EXPECT_NE(ready.message().find("the disk is full"), std::string::npos) << ready.message();
  FaultyDisk::fail = SQLITE_OK;
  EXPECT_TRUE(workplace_->MakeReady(prepared_).ok());
  EXPECT_TRUE(spool().List()->empty());
}

TEST_F(RunningAttemptTest, TooLittleRoomIsSaidWithHowMuchIsNeeded) {
  auto space = fs::space(folder_);
  const Status little = spool().ProveWritable(space.available + (uint64_t{1} << 40));
  EXPECT_EQ(little.code(), Code::kStorage);
  EXPECT_NE(little.message().find("MB free, and a recording needs "), std::string::npos)
      << little.message();
  EXPECT_TRUE(spool().ProveWritable(1).ok());
}

// Nobody is signed in: the error of the missing recording lock shows that the lock comes before the
// server.
TEST_F(RunningAttemptTest, NoTicketIsAskedForWhileAnotherProcessRecordsHere) {
  auto other = Spool::Open(folder_);
  ASSERT_TRUE(other.ok());
  {
    auto lock = (*other)->LockForRecording();
    ASSERT_TRUE(lock.ok());
    EXPECT_EQ(workplace_->TakeTicket(prepared_, false).code(), Code::kConflict);
  }
  EXPECT_EQ(workplace_->TakeTicket(prepared_, false).code(), Code::kUnauthenticated);
  // Refused by the server: the next one may record.
  EXPECT_TRUE((*other)->LockForRecording().ok());
}

TEST_F(RunningAttemptTest, OnceItIsReadyNobodyElseCanTakeItsPlace) {
  ASSERT_TRUE(workplace_->MakeReady(prepared_).ok());
  auto other = Spool::Open(folder_);
  ASSERT_TRUE(other.ok());
  EXPECT_EQ((*other)->LockForRecording().status().code(), Code::kConflict);
}

}  // namespace
}  // namespace enamel::station
