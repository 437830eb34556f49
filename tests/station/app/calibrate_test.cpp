#include "station/app/calibrate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/scene/builtin/builtin.h"
#include "common/scene/find_profile.h"
#include "common/scene/json/json.h"
#include "common/scene/plan.h"
#include "common/scene/profile_criteria.h"

namespace enamel::station {
namespace {

AxisFigures Axis(double cell_um, double c, double b, double delay) {
  AxisFigures a;
  a.resolution_m = {cell_um * 1e-6, 0, 1000};
  a.count_m = a.resolution_m.value;
  a.noise_m = {2e-6, 1e-6, 2000};
  a.friction_n = {c, 0.1 * c, 21};
  a.damping_n_s_per_m = {b, 0.1 * b, 21};
  a.mass_kg = {0.1, 0.001, 21};
  a.delay_ticks = {delay, 0.1, 8};
  return a;
}

TEST(CalibrateTest, WorstAxisIsTakenForEachQuantity) {
  AxisFigures worst = WorstOf({Axis(10, 0.05, 2, 0), Axis(30, 0.09, 1, 0), Axis(20, 0.03, 3, 2)});
  EXPECT_DOUBLE_EQ(worst.resolution_m.value, 30e-6);
  EXPECT_DOUBLE_EQ(worst.friction_n.value, 0.03);
  EXPECT_DOUBLE_EQ(worst.damping_n_s_per_m.value, 1);
  EXPECT_DOUBLE_EQ(worst.delay_ticks.value, 2);
}

TEST(CalibrateTest, AMeasuredProfileAsksOnlyForWhatCannotBeMeasured) {
  const auto base = scene::FindProfile("polhem_v1");
  ASSERT_TRUE(base.ok());
  const auto p = ProposeProfile(Axis(55, 0.05, 2, 1), 1000, *base, "mine", "measured here");
  ASSERT_TRUE(p.ok()) << p.status().message();
  EXPECT_EQ(scene::AskedFor(*p), std::vector<std::string>{"continuous_force_mn"});
}

TEST(CalibrateTest, ADriverWithoutItsDeviceIsRefusedWithWhatToDo) {
  CalibrateCommand command;
  command.device = "polhem_serial:/dev/ttyNONE";
  Status refused = CalibrateDevice(command);
  EXPECT_EQ(refused.code(), Code::kNotFound);
  EXPECT_NE(refused.message().find("--profile"), std::string::npos) << refused.message();
  command.profile = "polhem_v3";
  refused = CalibrateDevice(command);
  EXPECT_EQ(refused.code(), Code::kUnavailable);
  EXPECT_NE(refused.message().find("/dev/ttyNONE"), std::string::npos) << refused.message();
}

// The lower ends: b = 1.8, c = 0.045; the upper end of d, a tenth more: K = 2 b f/(d + 1)^2, 2 b f
// = 3600.
TEST(CalibrateTest, ProposedProfileIsStableByTheMeasuredNumbersAndCarriesTheExercise) {
  auto built = scene::BuildBuiltinScene("block", 200'000);
  ASSERT_TRUE(built.ok());
  scene::Exercise exercise = scene::ClassOneExercise(built->scene, {});
  for (double delay : {0.0, 1.4, 2.0}) {
    auto p = ProposeProfile(Axis(20, 0.05, 2, delay), 1000, scene::BuiltinProfiles()[0], "mine",
                            "measured here");
    ASSERT_TRUE(p.ok()) << p.status().message();
    EXPECT_NEAR(static_cast<double>(p->max_stiffness_mn_per_mm.value),
                3600 / std::pow(delay + 1.1, 2), 1);
    double friction_limit = 2 * 0.045 / 20e-6;
    double kc = static_cast<double>(p->coupling_mn_per_mm.value);
    // The core uses whole ticks: 0.1, 1.5 and 2.1 count as 0, 2 and 2 (a quarter may be the
    // interval's own).
    const double held = delay == 0 ? 1 : 3;
    EXPECT_NEAR(
        kc, 0.9 * std::min({3600 / std::pow(delay + 1.1, 2), 3600 / (held * held), friction_limit}),
        1);
    EXPECT_EQ(p->bus_delay_ticks.value, delay == 0 ? 0 : 2);
    EXPECT_TRUE(scene::CompilePlan(built->scene, exercise, *p).ok());
    auto back = scene::ProfileFromJson(scene::ToJson(*p));
    ASSERT_TRUE(back.ok()) << back.status().message();
    EXPECT_EQ(back->name, "mine");
    EXPECT_EQ(back->peak_force_mn.value, scene::BuiltinProfiles()[0].peak_force_mn.value);
  }
}

// 2 b f/(d + 1)^2: 3600 at the lower end of b, over 4 and over 25.
TEST(CalibrateTest, AnswersThatTakeLongerThanThePushesShowedAreTheDelay) {
  const auto base = *scene::FindProfile("inverse3");
  for (const int64_t p99_us : {90, 3050}) {
    AxisFigures worst = Axis(20, 0.05, 2, 1.2);
    RaiseToAnswers(worst.delay_ticks, {p99_us, p99_us, 500}, 1000);
    const auto p = ProposeProfile(worst, 1000, base, "mine", "measured");
    ASSERT_TRUE(p.ok()) << p.status().message();
    const int64_t ticks =
        p99_us == 90 ? 2 : 4 + 4 - 1;  // until the answer, and held until the next
    EXPECT_EQ(p->bus_delay_ticks.value, ticks);
    EXPECT_EQ(CalibrationOf(worst, 1000).bus_delay_ticks->value, ticks);
    EXPECT_LE(p->coupling_mn_per_mm.value, 3600 / ((ticks + 1) * (ticks + 1)));
  }
}

TEST(CalibrateTest, AnAnswerTimeIsKeptInTheDocumentWithItsJitter) {
  scene::Calibration document = CalibrationOf(Axis(20, 0.05, 2, 1.2), 1000);
  EXPECT_FALSE(document.answer_us || document.answer_jitter_us);
  NoteAnswers(document, {90, 520, 5000, 3, 40});
  EXPECT_EQ(document.answer_us, (scene::Measured{90, 3, 5000}));
  EXPECT_EQ(document.answer_jitter_us, (scene::Measured{430, 43, 5000}));
}

// 2 b f/(d + 1)^2 at 8 kHz and a tick is 7200; c/S is 4500.
TEST(CalibrateTest, ABoardsSpringIsProposedWhereTheMeasuredFiguresCarryIt) {
  scene::DeviceProfile base = scene::BuiltinProfiles()[0];
  base.cell.reset();
  base.board_spring = scene::BoardSpringSpec{8000, 1, "the device's own"};
  base.coupling_mn_per_mm = {4499, "the device's own"};
  auto p = ProposeProfile(Axis(20, 0.05, 2, 1), 1000, base, "mine", "measured");
  ASSERT_TRUE(p.ok()) << p.status().message();
  ASSERT_TRUE(p->board_spring);
  EXPECT_EQ(p->coupling_mn_per_mm.value, 4499);
  EXPECT_TRUE(scene::IsAcceptable(scene::CheckProfile(*p)));
  base.coupling_mn_per_mm.value = 4501;
  p = ProposeProfile(Axis(20, 0.05, 2, 1), 1000, base, "mine", "measured");
  ASSERT_TRUE(p.ok()) << p.status().message();
  EXPECT_FALSE(p->board_spring) << "the station runs a softer one";
  EXPECT_LT(p->coupling_mn_per_mm.value, 4500);
  EXPECT_TRUE(scene::IsAcceptable(scene::CheckProfile(*p)));
}

TEST(CalibrateTest, DeviceThatNothingCouldBeStableOnIsRefused) {
  auto p = ProposeProfile(Axis(20, 0, 2, 0), 1000, scene::BuiltinProfiles()[0], "mine", "measured");
  ASSERT_FALSE(p.ok());
  EXPECT_NE(p.status().message().find("friction"), std::string::npos);
}

TEST(CalibrateTest, MeasurementIsADocumentOfItsSchema) {
  scene::Calibration c = CalibrationOf(Axis(20, 0.05, 2, 1), 1000);
  c.device = "hid:1209:0001";
  c.profile = "omega3";
  c.software = "test";
  c.measured_ms = 1'700'000'000'000;
  auto back = scene::CalibrationFromJson(scene::ToJson(c));
  ASSERT_TRUE(back.ok()) << back.status().message();
  EXPECT_EQ(*back, c);
  EXPECT_EQ(back->damping_mn_s_per_m->value, 2000);
  EXPECT_EQ(back->damping_mn_s_per_m->uncertainty, 200);
}

}  // namespace
}  // namespace enamel::station
