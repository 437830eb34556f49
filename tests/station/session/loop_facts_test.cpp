#include "station/session/loop_facts.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <cfloat>
#include <cstdint>
#include <fstream>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "tests/support/block_plan.h"

namespace enamel::station {
namespace {

class HeldDevice final : public Device {
 public:
  std::string Name() const override { return "held"; }
  Hand hand() const override { return MakeHand(HandKind::kHaptic, Name(), "test"); }
  DeviceSample ReadSample() noexcept override { return sample; }
  void SendForce(const dvec3&) noexcept override {}

  DeviceSample sample;
};

TEST(CountsTextTest, CountsEveryTickThatWasNotStepped) {
  LoopCounters counters;
  counters.ticks = 13844;
  counters.late_ticks = 1;
  counters.gap_ticks = 2;
  counters.skipped_ticks = 3;
  EXPECT_EQ(CountsText(counters), "13844 ticks, 1 late, 5 in gaps, 0 interruptions, 0 faults");
  EXPECT_EQ(counters.passed_ticks(), 13849u);
}

class LoopFactsTest : public testing::Test {
 protected:
  LoopFactsTest() {
    test::BlockPlan block = test::MakeBlockPlan(500'000);
    params_ = block.params;
    volume_ = std::move(block.volume);
    device_.sample.buttons = kPedal;
  }

  core::CoreParams params_;
  cutting::Volume volume_;
  HeldDevice device_;
};

TEST_F(LoopFactsTest, HaveEachFaultWithItsTicksAndTheTimeThatPassed) {
  core::Core core(params_, volume_);
  SampleRing ring(4000);
  TickLoop loop(device_, core, ring, {1000, false, true});
  for (int i = 0; i < 100; ++i) loop.Tick();
  loop.Tick(0.1073);
  LoopCounters counters = loop.snapshot().counters;
  auto facts = LoopFacts(loop, device_);
  EXPECT_EQ(facts.at("ticks"), counters.ticks);
  EXPECT_EQ(facts.at("skipped_ticks"), 107u);
  ASSERT_EQ(facts.at("faults").as_array().size(), 1u);
  const auto& fault = facts.at("faults").as_array()[0].as_object();
  EXPECT_EQ(fault.at("why"), FaultText(Fault::kLateOnce));
  ASSERT_EQ(fault.at("ticks").as_array().size(), FaultRecord::kTicks);
  const auto& last = fault.at("ticks").as_array().back().as_object();
  EXPECT_NEAR(last.at("late_us").as_double(), 107300, 1e-6);
  EXPECT_EQ(last.at("gap_ticks"), 107u);
  Sample s;
  for (int fault_count = 0; fault_count < 20; ++fault_count) {
    for (int i = 0; i < 1100; ++i) {
      loop.Tick();
      while (ring.Pop(s)) {
      }
    }
    ASSERT_EQ(loop.fault(), Fault::kNone);
    loop.Tick(0.1061234567);
  }
  facts = LoopFacts(loop, device_);
  EXPECT_EQ(facts.at("fault_count"), 21u) << "also those of which no ticks are kept";
  EXPECT_EQ(facts.at("faults").as_array().size(), TickLoop::kMaxRecords);
}

// Each number with as many digits as its kind has.
void MakeLongest(boost::json::value& value) {
  if (auto* object = value.if_object()) {
    for (auto& member : *object) MakeLongest(member.value());
  } else if (value.is_double()) {
    value = -DBL_MIN;
  } else if (value.is_number()) {
    value = UINT64_MAX;
  }
}

TEST_F(LoopFactsTest, AreNeverLargerThanIsSaid) {
  FaultTick longest;
  longest.input.counts = {INT32_MIN, INT32_MIN, INT32_MIN};
  longest.input.flags = UINT8_MAX;
  longest.input.gap_ticks = std::numeric_limits<decltype(longest.input.gap_ticks)>::max();
  longest.force_sent_n = {-DBL_MIN, -DBL_MIN, -DBL_MIN};
  longest.late_s = -DBL_MIN;
  longest.fresh = longest.attached = longest.driven = false;
  std::vector<FaultRecord> records(TickLoop::kMaxRecords);
  for (FaultRecord& record : records) {
    for (Fault fault : {Fault::kStalled, Fault::kLateOnce, Fault::kLateOften, Fault::kTooSlow,
                        Fault::kUnplugged, Fault::kSwitchedOff}) {
      if (std::string(FaultText(fault)).size() > std::string(FaultText(record.fault)).size()) {
        record.fault = fault;
      }
    }
    record.tick = UINT64_MAX;
    record.count = FaultRecord::kTicks;
    record.ticks.fill(longest);
  }
  DurationHistogram histogram;
  for (int octave = 0; octave < 63; ++octave) histogram.Add(int64_t{1} << octave);
  core::Core core(params_, volume_);
  SampleRing ring(10);
  TickLoop loop(device_, core, ring, {1000, false, true});
  boost::json::value facts = LoopFacts(loop, device_);
  facts.at("lateness") = facts.at("tick") = DurationFacts(histogram);
  MakeLongest(facts);
  facts.at("faults") = FaultFacts(records);
  // A device's name on the bus: 126 letters, each of which JSON writes as \u0001.
  facts.at("device").at("name") = std::string(126, '\1');
  const size_t bytes = boost::json::serialize(facts).size();
  RecordProperty("bytes", static_cast<int>(bytes));
  EXPECT_LT(bytes, kLoopFactsBytes);
  EXPECT_GT(bytes, 120'000u) << "else this is not the longest";
}

// Each name in a document with its parents: "lateness.ns", "faults.ticks.late_us".
void NamesIn(const boost::json::value& value, const std::string& in, std::set<std::string>& out) {
  if (const auto* object = value.if_object()) {
    for (const auto& member : *object) {
      const std::string name = in + std::string(member.key());
      if (in.ends_with("ns.")) continue;  // which doublings there are differs
      out.insert(name);
      NamesIn(member.value(), name + ".", out);
    }
  } else if (const auto* array = value.if_array()) {
    for (const auto& element : *array) NamesIn(element, in, out);
  }
}

TEST_F(LoopFactsTest, HaveTheMembersOfTheirGoldenFileAndNoOthers) {
  std::ifstream in(std::string(ENAMEL_SOURCE_DIR) + "/schemas/golden/loop_facts.json");
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  const auto golden = boost::json::parse(text);
  core::Core core(params_, volume_);
  SampleRing ring(4000);
  TickLoop loop(device_, core, ring, {1000, false, true});
  loop.Tick(0.1073);
  const auto facts = LoopFacts(loop, device_);
  std::set<std::string> expected, found;
  NamesIn(golden, "", expected);
  NamesIn(facts, "", found);
  EXPECT_EQ(found, expected);
  EXPECT_EQ(facts.at("version"), golden.at("version"));
}

}  // namespace
}  // namespace enamel::station
