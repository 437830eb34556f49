#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <thread>

#include "station/devices/trouble.h"
#include "station/hid/foot_pedal.h"
#include "station/hid/haptic_board.h"
#include "station/hid/space_mouse.h"
#include "station/loop/tick_loop.h"
#include "tests/station/hid/hid_double.h"
#include "tests/support/block_plan.h"

// Any stream a device may send: drawn from seeds, with the properties that must hold for all. The
// test computes the expected values from the documents, not with the code under test.
namespace enamel::station::hid {
namespace {

using testing_support::HidBus;
using testing_support::ScriptedHid;

constexpr const char* kPath = "/dev/hidraw4";

// Random numbers that are the same for a seed on every machine (distributions of the library are
// not).
class Dice {
 public:
  explicit Dice(uint32_t seed) : random_(seed) {}
  uint32_t Any() { return random_(); }
  uint32_t Below(uint32_t n) { return random_() % n; }
  bool OneIn(uint32_t n) { return Below(n) == 0; }
  Bytes Some(size_t n) {
    Bytes out(n);
    for (uint8_t& b : out) b = static_cast<uint8_t>(Any());
    return out;
  }

 private:
  std::mt19937 random_;
};

void Await(const std::function<bool()>& reached) {
  for (int i = 0; i < 100'000 && !reached(); ++i) {
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  ASSERT_TRUE(reached());
}

FeatureReport Feature() {
  FeatureReport f;
  f.resolution_nm.fill(10'000);
  f.peak_force_mn = {7'900, 7'900, 7'900};
  f.max_watchdog_ms = 100;
  f.rate_hz = 1000;
  f.profile = "phantom_desktop";
  return f;
}

ScriptedHid Plugged(const FeatureReport& feature, const wchar_t* serial) {
  ScriptedHid d;
  d.path = kPath;
  d.vendor = 0x1209;
  d.product = 0x0001;
  d.usage_page = kBoardUsagePage;
  d.usage = kBoardUsage;
  d.serial = serial;
  auto bytes = EncodeFeature(feature);
  d.feature.assign(bytes.begin(), bytes.end());
  return d;
}

// The rules of schemas/hid_haptic_report.md for a stream: which reports count, and how.
class Expected {
 public:
  void Take(const Bytes& bytes) {
    breaks_now = false;
    if (!Whole(bytes)) {
      ++refused;
      return;
    }
    uint32_t sequence = Little(bytes, 4);
    if (known_) {
      int64_t ahead = static_cast<int32_t>(sequence - last_);  // from -2^31
      if (ahead <= 0 && ahead >= -1000) {
        ++duplicated;
        return;
      }
      if (ahead > 0) lost += static_cast<uint64_t>(ahead) - 1;
      breaks_now = ahead < 0;
    }
    known_ = true;
    last_ = sequence;
    ++samples;
    fit = (bytes[2] & 4) == 0;
    breaks_now = breaks_now || !fit;
    pedal = (bytes[3] & 1) != 0;
    for (size_t i = 0; i < 3; ++i) {
      counts[i] = static_cast<int32_t>(Little(bytes, 12 + 4 * i));
    }
  }
  void Unplugged() {
    known_ = false;
    pedal = false;
  }
  uint64_t taken() const { return samples + duplicated + refused; }

  uint64_t samples = 0, lost = 0, duplicated = 0, refused = 0;
  bool fit = true, pedal = false, breaks_now = false;
  std::array<int32_t, 3> counts{};

 private:
  static uint32_t Little(const Bytes& b, size_t at) {
    return b[at] | b[at + 1] << 8 | b[at + 2] << 16 | static_cast<uint32_t>(b[at + 3]) << 24;
  }
  // CRC-16/CCITT-FALSE, by a table of nibbles: a different way than in the code.
  static uint16_t Crc(const Bytes& b, size_t n) {
    uint16_t crc = 0xFFFF;
    for (size_t i = 0; i < n; ++i) {
      for (int nibble : {b[i] >> 4, b[i] & 15}) {
        auto top = static_cast<uint16_t>((crc >> 12) ^ nibble);
        crc = static_cast<uint16_t>((crc << 4) ^ (top * 0x1021));
      }
    }
    return crc;
  }
  static bool Whole(const Bytes& b) {
    return b.size() >= 58 && b[0] == 0x48 && b[1] == 1 &&
           Crc(b, 56) == static_cast<uint16_t>(b[56] | b[57] << 8);
  }
  bool known_ = false;
  uint32_t last_ = 0;
};

// Keeps the forces sent by the loop.
class Watched final : public Device {
 public:
  explicit Watched(Device& inner) : inner_(inner) {}
  std::string Name() const override { return inner_.Name(); }
  Hand hand() const override { return inner_.hand(); }
  DeviceSample ReadSample() noexcept override { return last = inner_.ReadSample(); }
  void SendForce(const dvec3& force_n) noexcept override { inner_.SendForce(force = force_n); }
  double still_before_force_s() const noexcept override { return 0; }

  DeviceSample last;
  dvec3 force{0};

 private:
  Device& inner_;
};

class AnyStreamTest : public testing::TestWithParam<uint32_t> {
 protected:
  AnyStreamTest() {
    bus_.Reset();
    test::BlockPlan block = test::MakeBlockPlan();
    above_ = block.CountsAbove(200'000);
    peak_n_ = block.params.peak_force_mn * 1e-3;
    core_ = std::make_unique<core::Core>(block.params, std::move(block.volume));
  }
  ~AnyStreamTest() override {
    bus_.HoldWrites(false);
    loop_.reset();
    board_.reset();
    bus_.Reset();
  }

  void Open() {
    bus_.Plug(Plugged(Feature(), L"A1"));
    hand_z_ = above_;
    std::thread first([&] {
      if (bus_.Await([](HidBus& b) { return b.handle_count() == 3; })) Send(Next());
    });
    HapticBoardSettings settings;
    settings.centre_on_first_report = false;
    auto board = HapticBoard::Open(settings);
    first.join();
    ASSERT_TRUE(board.ok()) << board.status().message();
    board_ = std::move(*board);
    watched_ = std::make_unique<Watched>(*board_);
    loop_ =
        std::make_unique<TickLoop>(*watched_, *core_, ring_, TickLoopOptions{1000, false, true});
  }

  // The next report of a hand that goes up and down through the block's face.
  Bytes Next() {
    hand_z_ += dice_.OneIn(3) ? 3 : -2;
    if (hand_z_ < above_ - 120 || dice_.OneIn(100)) hand_z_ = above_;
    time_us_ += 1000;
    InputReport r;
    r.sequence = ++sequence_;
    r.time_us = time_us_;
    r.counts = {static_cast<int32_t>(dice_.Below(5)), 0, hand_z_};
    r.buttons = pedal_ ? 1 : 0;
    r.status = kMotorsOn;
    auto bytes = EncodeInput(r);
    return {bytes.begin(), bytes.end()};
  }
  static Bytes Sealed(Bytes b) {
    const size_t end = kInputBytes - 2;
    const uint16_t crc = EnCrc16(b.data(), end);
    b[end] = static_cast<uint8_t>(crc);
    b[end + 1] = static_cast<uint8_t>(crc >> 8);
    return b;
  }
  static Bytes WithSequence(Bytes b, uint32_t sequence) {
    for (size_t i = 0; i < 4; ++i) b[4 + i] = static_cast<uint8_t>(sequence >> (8 * i));
    return Sealed(std::move(b));
  }

  // One possible report; mostly the next one.
  Bytes Draw() {
    Bytes b = Next();
    switch (dice_.Below(60)) {
      case 0:
        b.resize(1 + dice_.Below(47));
        return b;
      case 1:
        b[0] = static_cast<uint8_t>(dice_.Any());
        return b;
      case 2:
        b[1] = static_cast<uint8_t>(dice_.Any());
        return Sealed(std::move(b));
      case 3:
        b[dice_.Below(kInputBytes)] ^= static_cast<uint8_t>(1u << dice_.Below(8));
        return b;
      case 4:  // late, doubled, or back by more
        return WithSequence(std::move(b), sequence_ - dice_.Below(1300));
      case 5:  // lost
        sequence_ += dice_.Below(dice_.OneIn(2) ? 4 : 0x7fff0000);
        return WithSequence(std::move(b), sequence_);
      case 6: {  // counts at their limits
        for (size_t axis = 0; axis < 3; ++axis) {
          if (!dice_.OneIn(2)) continue;
          uint32_t limit = dice_.OneIn(2) ? 0x80000000u : 0x7fffffffu;
          for (size_t i = 0; i < 4; ++i)
            b[12 + 4 * axis + i] = static_cast<uint8_t>(limit >> (8 * i));
        }
        return Sealed(std::move(b));
      }
      case 7:  // a clock that jumps or wraps
        time_us_ = dice_.OneIn(2) ? UINT32_MAX - dice_.Below(2000) : dice_.Any();
        return b;
      case 8:
        b[2] = static_cast<uint8_t>(dice_.Any());  // any status: not fit, watchdog tripped
        return Sealed(std::move(b));
      case 9:  // any orientation, valid or not, and any speed
        for (size_t i = 36; i < 46; ++i) b[i] = static_cast<uint8_t>(dice_.Any());
        b[2] |= kOrientationValid;
        return Sealed(std::move(b));
      case 10:  // padded by the bus
        b.resize(kInputBytes + static_cast<size_t>(dice_.Below(16)), 0xEE);
        return b;
      case 11: {  // all of it nonsense, its seal right
        Bytes any = dice_.Some(kInputBytes);
        any[0] = 0x48;
        any[1] = 1;
        return Sealed(std::move(any));
      }
      case 12:
        return dice_.Some(1 + dice_.Below(80));
      default:
        return b;
    }
  }

  void Send(const Bytes& bytes) {
    bus_.Send(kPath, bytes);
    expected_.Take(bytes);
  }
  void AwaitTaken() {
    Await([&] {
      DeviceCounters c = board_->counters();
      return c.samples + c.duplicated + c.refused >= expected_.taken();
    });
  }

  void Tick() {
    loop_->Tick();
    const dvec3& f = watched_->force;
    ASSERT_TRUE(std::isfinite(f.x) && std::isfinite(f.y) && std::isfinite(f.z));
    ASSERT_LE(std::sqrt(Dot(f, f)), peak_n_ * (1 + 1e-12));
    if (f.z > 0.05) felt_ = true;
    if (!watched_->last.fresh || !watched_->last.attached) {
      ++silent_;
    } else {
      silent_ = 0;
    }
    // 5 ms of silence is a fault; 0 long before the 20 ms allowed.
    if (silent_ > 5) {
      ASSERT_EQ(f, dvec3(0));
    }
    if (loop_->fault() != Fault::kNone) {
      ASSERT_EQ(f, dvec3(0));
    }
    Sample s;
    while (ring_.Pop(s)) {
      ASSERT_EQ(s.tick.witness.flags & core::kReserveExhausted, 0);
    }
  }

  // Unplugged at any time; returns later, perhaps as another device first.
  void Replug() {
    const uint64_t before = board_->counters().detached;
    bus_.Unplug(kPath);
    expected_.Unplugged();
    Await([&] { return board_->counters().detached == before + 1; });
    ASSERT_TRUE(bus_.Await([](HidBus& b) { return b.handle_count() == 0; }));
    Tick();
    Tick();
    ASSERT_EQ(watched_->force, dvec3(0));
    ASSERT_NE(loop_->fault(), Fault::kNone);
    if (dice_.OneIn(2)) {
      FeatureReport other = Feature();
      if (dice_.OneIn(2)) other.peak_force_mn[1] = 3'300;
      bool same_serial = other != Feature();
      int opened = bus_.Opened();
      bus_.Plug(Plugged(other, same_serial ? L"A1" : L"B2"));
      if (same_serial) {
        ASSERT_TRUE(bus_.Await([&](HidBus& b) { return b.opened() >= opened + 4; }));
      } else {  // its serial number is enough: whatever it sends goes nowhere
        for (int i = 0; i < 5; ++i) bus_.Send(kPath, Next());
      }
      ASSERT_FALSE(board_->ReadSample().attached);
      bus_.Unplug(kPath);
      ASSERT_TRUE(bus_.Await([](HidBus& b) { return b.handle_count() == 0; }));
    }
    bus_.Plug(Plugged(Feature(), L"A1"));
    ASSERT_TRUE(bus_.Await([](HidBus& b) { return b.handle_count() == 2; }));
    if (dice_.OneIn(2)) sequence_ = dice_.Any();
    // Back, and not yet for long enough.
    for (int i = 0; i < 5; ++i) {
      Send(Next());
      AwaitTaken();
      Tick();
      ASSERT_NE(loop_->fault(), Fault::kNone);
    }
  }

  // Above the block, with a board that answers, until the fault has ended. Homed first: after a restart it
  // may have said that it was anywhere.
  void Recover() {
    hand_z_ = above_;
    Bytes homing = Next();
    homing[2] |= kNotFit;
    Send(Sealed(std::move(homing)));
    ASSERT_NO_FATAL_FAILURE(AwaitTaken());
    for (int i = 0; i < 300 && loop_->fault() != Fault::kNone; ++i) {
      Send(Next());
      ASSERT_NO_FATAL_FAILURE(AwaitTaken());
      ASSERT_NO_FATAL_FAILURE(Tick());
    }
    ASSERT_EQ(loop_->fault(), Fault::kNone);
  }

  HidBus& bus_ = HidBus::Get();
  Dice dice_{GetParam()};
  Expected expected_;
  int32_t above_ = 0, hand_z_ = 0;
  double peak_n_ = 0;
  uint32_t sequence_ = dice_.Any(), time_us_ = UINT32_MAX - 20'000;
  bool pedal_ = true, felt_ = false;
  int silent_ = 0;
  std::unique_ptr<core::Core> core_;
  SampleRing ring_{16};
  std::unique_ptr<HapticBoard> board_;
  std::unique_ptr<Watched> watched_;
  std::unique_ptr<TickLoop> loop_;
};

TEST_P(AnyStreamTest, TheBoardsForceIsBoundedAndItsReportsCountAsTheDocumentSays) {
  Open();
  for (int step = 0; step < 400; ++step) {
    bool stalled = dice_.OneIn(60);
    if (dice_.OneIn(40)) pedal_ = !pedal_;
    if (loop_->fault() != Fault::kNone && dice_.OneIn(8)) {
      ASSERT_NO_FATAL_FAILURE(Recover()) << "step " << step;
    }
    if (dice_.OneIn(12)) pedal_ = dice_.OneIn(2);  // bounces
    if (dice_.OneIn(30)) bus_.HoldWrites(true);
    bool broke = false;
    for (uint32_t n = dice_.Below(3) + 1; !stalled && n > 0; --n) {
      Send(Draw());
      broke = broke || expected_.breaks_now;
    }
    ASSERT_NO_FATAL_FAILURE(AwaitTaken());
    for (uint32_t n = stalled ? 8 : dice_.Below(2) + 1; n > 0; --n) {
      ASSERT_NO_FATAL_FAILURE(Tick()) << "step " << step;
      // However brief, the event that ended the trust in the poses is seen.
      if (broke) {
        ASSERT_NE(loop_->fault(), Fault::kNone) << "step " << step;
      }
      broke = false;
    }
    ASSERT_EQ(watched_->last.counts, expected_.counts) << "step " << step;
    bus_.HoldWrites(false);
    if (step % 150 == 149) {
      ASSERT_NO_FATAL_FAILURE(Replug()) << "step " << step;
    }
  }
  EXPECT_TRUE(felt_);
  DeviceCounters c = board_->counters();
  EXPECT_EQ(c.samples, expected_.samples);
  EXPECT_EQ(c.lost, expected_.lost);
  EXPECT_EQ(c.duplicated, expected_.duplicated);
  EXPECT_EQ(c.refused, expected_.refused);
  board_.reset();
  // On the wire: every report whole, one more than the last, within the board's own peak.
  uint32_t sequence = 0;
  for (const Bytes& b : bus_.Written()) {
    OutputReport out;
    ASSERT_EQ(DecodeOutput(b, out), ReportError::kNone);
    EXPECT_GT(out.sequence, sequence);
    sequence = out.sequence;
    for (int32_t f : out.force_100un) EXPECT_LE(std::abs(f), 79'000);
    EXPECT_EQ(out.watchdog_ms, 20);
  }
}

// A board that restarts with its cable in place, between two ticks.
TEST_P(AnyStreamTest, AfterARestartTheForceStaysAwayUntilTheBoardHasAnsweredForAWhile) {
  Open();
  for (int i = 0; i < 20; ++i) {
    Send(Next());
    ASSERT_NO_FATAL_FAILURE(AwaitTaken());
    ASSERT_NO_FATAL_FAILURE(Tick());
  }
  ASSERT_EQ(loop_->fault(), Fault::kNone);
  sequence_ -= 1001 + dice_.Below(100'000);
  for (int i = 0; i < 10; ++i) {
    Send(Next());
    Send(Next());
    ASSERT_NO_FATAL_FAILURE(AwaitTaken());
    ASSERT_NO_FATAL_FAILURE(Tick());
    ASSERT_EQ(loop_->fault(), Fault::kUnplugged);
  }
  ASSERT_NO_FATAL_FAILURE(Recover());
}

// Its encoders began at 0 where it then was.
TEST_P(AnyStreamTest, ABoardThatRestartsElsewhereHasNoForceUntilItIsHomed) {
  Open();
  const bool replugged = dice_.OneIn(2);
  const int32_t moved = 2400 + static_cast<int32_t>(dice_.Below(10'000));
  for (const int32_t by : {moved, 1700}) {
    for (int i = 0; i < 300; ++i) {
      Send(Next());
      ASSERT_NO_FATAL_FAILURE(AwaitTaken());
      ASSERT_NO_FATAL_FAILURE(Tick());
    }
    ASSERT_EQ(loop_->fault(), Fault::kNone);
    ASSERT_TRUE(board_->problem().ok());
    if (replugged) {
      bus_.Unplug(kPath);
      expected_.Unplugged();
      ASSERT_TRUE(bus_.Await([](HidBus& b) { return b.handle_count() == 0; }));
      bus_.Plug(Plugged(Feature(), L"A1"));
      ASSERT_TRUE(bus_.Await([](HidBus& b) { return b.handle_count() == 2; }));
    } else {
      sequence_ -= 100'000;
    }
    above_ += by;
    hand_z_ = above_;
    const bool lost = by == moved;
    for (int i = 0; i < 1000; ++i) {
      // A lost one passes the place where it was.
      if (lost) hand_z_ -= moved / 500;
      Send(Next());
      ASSERT_NO_FATAL_FAILURE(AwaitTaken());
      ASSERT_NO_FATAL_FAILURE(Tick());
      if (lost) ASSERT_EQ(loop_->fault(), Fault::kUnplugged);
    }
    EXPECT_EQ(board_->problem().field(), lost ? trouble::kLost : "");
    above_ -= lost ? by : 0;
    ASSERT_NO_FATAL_FAILURE(Recover());
    EXPECT_TRUE(board_->problem().ok());
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, AnyStreamTest, testing::Range(1u, 9u));

// The reports of both families of 6-DoF mice, as station/hid/space_mouse.h describes them.
SpaceMouseState Described(const Bytes& r, SpaceMouseState s) {
  auto axis = [&](size_t i) { return static_cast<int16_t>(r[1 + 2 * i] | r[2 + 2 * i] << 8); };
  bool axes = !r.empty() && (r[0] == 1 || r[0] == 2) && r.size() >= 7;
  if (axes) {
    size_t first = r[0] == 2 ? 3 : 0, count = r[0] == 1 && r.size() >= 13 ? 6 : 3;
    for (size_t i = 0; i < count; ++i) s.axes[first + i] = axis(i);
  }
  if (r.size() >= 2 && r[0] == 3) {
    s.buttons = 0;
    for (size_t i = 1; i < std::min<size_t>(r.size(), 5); ++i)
      s.buttons |= uint32_t{r[i]} << (8 * (i - 1));
  }
  return s;
}

TEST(AnySpaceMouseReportTest, AnyBytesOfAnyLengthAreTakenAsDescribedOrLeftOut) {
  Dice dice(5);
  SpaceMouseState state, expected;
  SpaceMouseSettings settings;
  for (int i = 0; i < 300'000; ++i) {
    Bytes report = dice.Some(dice.Below(20));
    if (!report.empty() && !dice.OneIn(4)) report[0] = static_cast<uint8_t>(dice.Below(5));
    expected = Described(report, expected);
    TakeReport(report, state);
    ASSERT_EQ(state, expected) << i;
    SpaceMouseMotion m = MotionOf(state, settings);
    for (int k = 0; k < 3; ++k) {
      ASSERT_LE(std::fabs(m.velocity_m_per_s[k]), settings.max_speed_m_per_s);
      ASSERT_LE(std::fabs(m.turn_rad_per_s[k]), settings.max_turn_rad_per_s);
    }
  }
}

TEST(AnySpaceMouseReportTest, WhateverItSendsTheTipStaysInReachAndMovesNoFasterThanItMay) {
  HidBus& bus = HidBus::Get();
  for (bool combined : {false, true}) {
    Dice dice(combined ? 7 : 8);
    bus.Reset();
    ScriptedHid d;
    d.path = "/dev/hidraw2";
    d.vendor = combined ? 0x256f : 0x046d;
    d.usage_page = kMultiAxisPage;
    d.usage = kMultiAxisUsage;
    bus.Plug(d);
    SpaceMouseSettings settings;
    auto mouse = SpaceMouse::Open(settings, 1e-6, 1e-3);
    ASSERT_TRUE(mouse.ok());
    ASSERT_TRUE(bus.Await([](HidBus& b) { return b.handle_count() == 1; }));
    DeviceSample before = (*mouse)->ReadSample();
    for (int i = 0; i < 3000; ++i) {
      Bytes report = dice.Some(dice.OneIn(5) ? dice.Below(20) : (combined ? 13 : 7));
      if (!report.empty() && !dice.OneIn(10)) report[0] = static_cast<uint8_t>(1 + dice.Below(3));
      bus.Send(d.path, report);
      DeviceSample now = (*mouse)->ReadSample();
      double step = 0, at = 0;
      for (size_t k = 0; k < 3; ++k) {
        step += std::pow(now.counts[k] - before.counts[k], 2.0);
        at += std::pow(now.counts[k], 2.0);
      }
      // Each axis at most at its full speed, and a count of rounding.
      ASSERT_LE(std::sqrt(step), std::sqrt(3.0) * (settings.max_speed_m_per_s * 1e-3 / 1e-6 + 1));
      ASSERT_LE(std::sqrt(at), settings.reach_m / 1e-6 + 2);
      Quat q = FromQuantised(now.orientation);
      ASSERT_NEAR(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w, 1, 1e-9);
      before = now;
    }
    bus.Unplug(d.path);
    Await([&] { return !(*mouse)->ReadSample().attached; });
    EXPECT_EQ((*mouse)->ReadSample().buttons, 0);
  }
  bus.Reset();
}

TEST(AnyPedalReportTest, AnyBytesOfAnyLengthWithAnySettingsAreReadInBoundsOrLeftOut) {
  Dice dice(9);
  for (int i = 0; i < 300'000; ++i) {
    PedalSettings settings;
    settings.report_id = dice.OneIn(2) ? 0 : static_cast<uint8_t>(dice.Below(4));
    settings.byte = static_cast<uint8_t>(dice.OneIn(4) ? dice.Any() : dice.Below(8));
    settings.mask = static_cast<uint8_t>(1 + dice.Below(255));
    Bytes report = dice.Some(dice.Below(12));
    if (!report.empty() && dice.OneIn(2)) report[0] = settings.report_id;
    bool long_enough = report.size() > settings.byte;
    bool ours = long_enough && (settings.report_id == 0 || report[0] == settings.report_id);
    PedalReading r = ReadPedal(settings, report);
    ASSERT_EQ(r.relevant, ours);
    ASSERT_EQ(r.down, ours && (report[settings.byte] & settings.mask) != 0);
  }
}

TEST(AnyPedalReportTest, WhateverAPedalSendsItSaysPedalOrNothingAndIsReleasedWhenUnplugged) {
  HidBus& bus = HidBus::Get();
  bus.Reset();
  ScriptedHid d;
  d.path = "/dev/hidraw7";
  d.vendor = 0x05f3;
  d.product = 0x00ff;
  bus.Plug(d);
  auto pedal = FootPedal::Open({});
  ASSERT_TRUE(pedal.ok());
  ASSERT_TRUE(bus.Await([](HidBus& b) { return b.handle_count() == 1; }));
  Dice dice(10);
  uint64_t empty = 0;
  for (int i = 0; i < 2000; ++i) {
    Bytes report = dice.Some(1 + dice.Below(8));
    bus.Send(d.path, report);
    ASSERT_EQ((*pedal)->buttons() & ~kPedal, 0);
  }
  const uint8_t down[] = {1};
  bus.Send(d.path, down);
  Await([&] { return (*pedal)->buttons() == kPedal; });
  EXPECT_EQ((*pedal)->refused(), empty);
  bus.Unplug(d.path);
  Await([&] { return (*pedal)->buttons() == 0; });
  bus.Reset();
}

}  // namespace
}  // namespace enamel::station::hid
