#include <gtest/gtest.h>

#include "common/base/state_archive.h"
#include "common/core/core.h"
#include "tests/common/trace/sample.h"

// A saved and restored core continues as if nothing had happened: keyframes rely on this. A member
// of core, cutter, engagement, coupling or law that VisitState forgets shows here.
namespace enamel::core {
namespace {

namespace sample = trace::sample;

// Like a replay: a fresh core, the bricks that are stored now, the rest of the state.
void CopyInto(Core& from, Core& to) {
  const cutting::Volume& volume = from.volume();
  for (int b = 0; b < volume.spec().brick_count(); ++b) {
    if (volume.IsStored(b)) {
      ASSERT_TRUE(to.RestoreBrick(b, volume.Phi(b).phi));
    }
  }
  StateArchive saved;
  ASSERT_TRUE(from.VisitState(saved));
  Bytes bytes = saved.Take();
  StateArchive restored(bytes);
  ASSERT_TRUE(to.VisitState(restored));
}

// Turning, gaps, another bur before the first contact and again in the tooth, a fault and a restart on top of the
// sample's cut.
std::vector<TickInput> BusyInputs() {
  auto inputs = sample::CutInputs(3000);
  for (size_t i = 0; i < inputs.size(); ++i) {
    auto turn = static_cast<int16_t>((i * 7) % 1500);
    inputs[i].orientation = {turn, static_cast<int16_t>(-turn / 2), 0, 32000};
    if (i >= 150 && i < 2500) inputs[i].flags |= BurFlags(1);
  }
  inputs[900].gap_ticks = 3;
  inputs[1500].flags |= kFaulted;
  inputs[2100].flags |= kSoftRestart;
  return inputs;
}

CoreParams ParamsOf(haptics::LawKind law, bool torque = false) {
  CoreParams params = sample::MakeHeader().params;
  params.law = law;
  params.bur_shape = cutting::BurShape::kCylinder;
  params.bur_length_nm = 2'000'000;
  params.contact_cue_mn = 300;
  params.chatter_cue_mn = 200;
  params.cue_energy_nj = 100'000;
  params.cue_power_nw = 500'000;
  params.rotational_kc_un_m_per_rad = torque ? 800'000 : 5000;
  params.peak_torque_un_m = torque ? 100'000 : 0;
  params.rotation_cell_urad = torque ? 300 : 0;
  params.bus_delay_ticks = torque ? 1 : 0;
  params.other_burs[0].rotational_kc_un_m_per_rad = params.rotational_kc_un_m_per_rad;
  return params;
}

class CoreStateTest : public testing::TestWithParam<haptics::LawEntry> {};

void ExpectRestoredGoesOn(const CoreParams& params) {
  auto inputs = BusyInputs();
  for (size_t keyframe : {0u, 50u, 151u, 700u, 901u, 1501u, 2000u, 2099u, 2101u, 2501u}) {
    Core original(params, sample::MakeBlock()), copy(params, sample::MakeBlock());
    for (size_t i = 0; i < keyframe; ++i) original.Step(inputs[i]);
    CopyInto(original, copy);
    ASSERT_EQ(copy.ticks(), original.ticks());
    ASSERT_EQ(copy.removed(), original.removed());
    for (size_t i = keyframe; i < inputs.size(); ++i) {
      ASSERT_EQ(original.Step(inputs[i]).witness, copy.Step(inputs[i]).witness)
          << "tick " << i << " after a keyframe at " << keyframe;
      ASSERT_EQ(original.state_hash(), copy.state_hash()) << i;
    }
    EXPECT_TRUE(original.volume() == copy.volume());
    EXPECT_EQ(copy.bur(), 0u);
    EXPECT_GT(copy.removed()[static_cast<size_t>(cutting::Tissue::kEnamel)], 0);
  }
}

TEST_P(CoreStateTest, RestoredCoreGoesOnTickByTickAsTheOneThatWasSaved) {
  ExpectRestoredGoesOn(ParamsOf(GetParam().kind));
}

INSTANTIATE_TEST_SUITE_P(Laws, CoreStateTest, testing::ValuesIn(haptics::ForceLaws()),
                         [](const auto& law) {
                           std::string name;
                           for (char c : law.param.name) name += c == '-' ? '_' : c;
                           return name;
                         });

TEST(CoreStateTorqueTest, RestoredCoreOfASixAxisDeviceGoesOnAsTheOneThatWasSaved) {
  ExpectRestoredGoesOn(ParamsOf(haptics::kDefaultLaw, true));
}

TEST(CoreStateBytesTest, BytesThatAreCutShortLeftOverOrNoStateAreRefused) {
  CoreParams params = ParamsOf(haptics::LawKind::kLeadMaxwell);
  Core original(params, sample::MakeBlock());
  for (const TickInput& input : sample::CutInputs(700)) original.Step(input);
  StateArchive saved;
  ASSERT_TRUE(original.VisitState(saved));
  Bytes bytes = saved.Take();
  for (size_t size : {size_t{0}, size_t{1}, bytes.size() / 2, bytes.size() - 1}) {
    Core copy(params, sample::MakeBlock());
    StateArchive cut(ByteView(bytes).first(size));
    EXPECT_FALSE(copy.VisitState(cut)) << size;
  }
  bytes.push_back(0);
  Core copy(params, sample::MakeBlock());
  StateArchive longer(bytes);
  EXPECT_FALSE(copy.VisitState(longer));
  EXPECT_FALSE(copy.RestoreBrick(-1, std::array<int16_t, cutting::kBrickVoxels>{}));
}

}  // namespace
}  // namespace enamel::core
