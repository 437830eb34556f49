#include <gtest/gtest.h>
#include <sqlite3.h>

#include <atomic>
#include <filesystem>
#include <thread>

#include "station/spool/recorder.h"
#include "tests/support/block_plan.h"
#include "tests/support/temp_folder.h"

// A disk that takes nothing for as long as the test wants: another connection holds the database's
// write lock, so the recorder waits in the middle of its commit.
namespace enamel::station {
namespace {

namespace fs = std::filesystem;

// Goes down into the block, a count a tick, with the pedal down.
class Plunging final : public Device {
 public:
  explicit Plunging(int32_t from) : z_(from) {}
  std::string Name() const override { return "plunging"; }
  Hand hand() const override { return MakeHand(HandKind::kHaptic, Name(), "test"); }
  DeviceSample ReadSample() noexcept override {
    DeviceSample s;
    s.counts[2] = --z_;
    s.buttons = kPedal;
    s.bur_speed_krpm = kTurbineSpeed_krpm;
    ++reads;
    return s;
  }
  void SendForce(const dvec3& force_n) noexcept override { force = force_n; }

  uint64_t reads = 0;
  dvec3 force{0};

 private:
  int32_t z_;
};

class SlowDiskTest : public testing::Test {
 protected:
  SlowDiskTest() {
    test::BlockPlan block = test::MakeBlockPlan();
    header_.ticket.attempt = Uuid::New();
    header_.params = block.params;
    header_.station_software = "test";
    header_.hand.kind = HandKind::kProgram;
    above_ = block.CountsAbove(300'000);
    volume_ = std::move(block.volume);
    spool_ = std::move(*Spool::Open(folder_));
    EXPECT_TRUE(spool_->BeginAttempt(header_, "e", "p").ok());
  }
  ~SlowDiskTest() override { spool_.reset(); }

  // The disk hangs from now until the next Release.
  void Hang() {
    ASSERT_EQ(sqlite3_open((folder_ / "spool.sqlite").c_str(), &other_), SQLITE_OK);
    ASSERT_EQ(sqlite3_exec(other_, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  }
  void Release() {
    sqlite3_exec(other_, "ROLLBACK", nullptr, nullptr, nullptr);
    sqlite3_close(other_);
  }

  test::TempFolder temp_;
  const fs::path folder_ = temp_.path();
  trace::KeyPair keys_ = trace::NewKeyPair();
  trace::Header header_;
  cutting::Volume volume_;
  int32_t above_ = 0;
  std::unique_ptr<Spool> spool_;
  sqlite3* other_ = nullptr;
};

TEST_F(SlowDiskTest, HangingDiskStopsForceAndCutNeverTheLoopAndTheGapIsRecorded) {
  constexpr size_t kRing = 200;
  Plunging device(above_);
  core::Core core(header_.params, volume_);
  SampleRing ring(kRing);
  Recorder recorder(*spool_, ring, header_.ticket.attempt, HashSha256(trace::EncodeHeader(header_)),
                    keys_.secret_key);
  TickLoop loop(device, core, ring, {1000, false, false});

  Hang();
  // Pumps like RunningAttempt: an error is the spool's, and is retried.
  std::atomic<bool> stop{false};
  std::thread pump([&] {
    while (!stop) {
      auto moved = recorder.Pump();
      if (!moved.ok() || !*moved) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  // The recorder and the ring are soon full; each further tick is a gap.
  uint64_t ticked = 0;
  double most_n = 0;
  auto tick = [&] {
    loop.Tick();
    ++ticked;
    most_n = std::max(most_n, device.force.z);
  };
  for (int i = 0; i < 30'000 && core.ticks() < Recorder::kTicksPerChunk + kRing; ++i) {
    tick();
    if (ring.Full()) std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  ASSERT_EQ(core.ticks(), Recorder::kTicksPerChunk + kRing);
  EXPECT_GT(most_n, 0.2);
  const uint64_t stepped = core.ticks(), hash = core.state_hash();
  for (int i = 0; i < 2'000; ++i) {
    tick();
    ASSERT_EQ(device.force, dvec3(0)) << i;
  }
  EXPECT_EQ(core.ticks(), stepped);
  EXPECT_EQ(core.state_hash(), hash);
  EXPECT_EQ(device.reads, ticked);
  EXPECT_EQ(recorder.chunks(), 0u);

  Release();
  for (int i = 0; i < 20'000 && ring.size() > 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  tick();
  stop = true;
  pump.join();
  auto seal = recorder.Finish();
  ASSERT_TRUE(seal.ok()) << seal.status().message();
  EXPECT_EQ(seal->ticks, stepped + 1);
  EXPECT_EQ(spool_->Get(header_.ticket.attempt)->gap_ticks, ticked - stepped - 1);

  // The disk has the whole attempt, including the gap.
  core::Core again(header_.params, volume_);
  auto file = spool_->Export(header_.ticket.attempt);
  ASSERT_TRUE(file.ok());
  for (const Bytes& bytes : file->chunks) {
    auto chunk = trace::DecodeChunk(bytes);
    ASSERT_TRUE(chunk.ok());
    for (const trace::Tick& t : chunk->ticks) {
      ASSERT_EQ(again.Step(t.input).witness, t.witness);
    }
  }
  EXPECT_EQ(again.state_hash(), core.state_hash());
}

}  // namespace
}  // namespace enamel::station
