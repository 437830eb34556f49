#include "common/scene/builtin/layer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/scene/builtin/builtin.h"
#include "common/scene/builtin/teeth.h"
#include "common/scene/preparation.h"

namespace enamel::scene {
namespace {

PreparationPart Box(std::array<int32_t, 2> half_um) {
  PreparationPart part;
  part.half_size_um = half_um;
  part.depth_um = 9'000;
  return part;
}
double Below_mm(const PreparationPart& part, double x_mm, double y_mm) {
  return -ReliefAt(part, x_mm * 1e-3, y_mm * 1e-3).z_m * 1e3;
}

TEST(LayerTest, OffALevelSurfaceABallLeavesALevelFloorAndItsOwnRound) {
  PreparationPart part = Box({3'000, 3'000});
  const Layer layer{[](double, double) { return 0.0; }, 0.5e-3, 0.8e-3, true, {2e-3, 2e-3}};
  part.relief = ReliefOf(layer, part, {}, 250);
  EXPECT_EQ(part.relief.count, (std::array<int32_t, 2>{25, 25}));
  for (double x : {0.0, 1.0, 2.0}) EXPECT_NEAR(Below_mm(part, x, 0.5), 0.5, 0.006) << x;
  // Half a millimetre beyond where its axis may be.
  EXPECT_NEAR(Below_mm(part, 2.5, 0), 0.5 - (0.8 - std::sqrt(0.64 - 0.25)), 0.006);
  EXPECT_EQ(Below_mm(part, 3, 0), 0) << "there the tooth stays";
}

TEST(LayerTest, OffADomeTheFloorIsASmallerDome) {
  PreparationPart part = Box({3'000, 3'000});
  auto dome = [](double x, double y) { return std::sqrt(64e-6 - x * x - y * y) - 8e-3; };
  part.relief = ReliefOf({dome, 1e-3, 0.5e-3, true, {3e-3, 3e-3}}, part, {}, 250);
  for (double x : {0.0, 1.25, 2.5}) {
    EXPECT_NEAR(Below_mm(part, x, 0), 8 - std::sqrt(49 - x * x), 0.02) << x;
  }
}

TEST(LayerTest, AFlatEndCannotGoIntoAFissureThatIsNarrowerThanItself) {
  PreparationPart part = Box({2'000, 2'000});
  auto valley = [](double x, double) { return std::fabs(x); };
  part.relief = ReliefOf({valley, 0.5e-3, 0.5e-3, false, {3e-3, 3e-3}}, part, {0, 0, 2'000}, 250);
  part.top_um = {0, 0, 2'000};
  // The floor begins half a millimetre across the slopes and is round in the middle. The rim of the
  // end, 0.5 mm to each side, is on the slopes.
  const double floor_mm = ReliefAt(part, 0, 0).z_m * 1e3;
  EXPECT_NEAR(floor_mm, 0.5 - 0.5 * std::sqrt(2.0), 0.02);
  EXPECT_NEAR(ReliefAt(part, 0.3e-3, 0).z_m * 1e3, floor_mm, 0.01);
  // On the slope it is the slope, half a millimetre across.
  EXPECT_NEAR(ReliefAt(part, 1.5e-3, 0).z_m * 1e3, 1.5 - 0.5 * std::sqrt(2.0), 0.02);
}

struct Made {
  BuiltScene built;
  Exercise exercise;
  Preparation shape;
};
Made Make(const char* scene, const char* exercise) {
  auto built = BuildBuiltinScene(scene, 200'000);
  ENAMEL_CHECK(built.ok());
  for (const Exercise& e : BuiltinExercises(built->scene, {})) {
    if (!e.name.starts_with(exercise)) continue;
    auto shape = TargetShape(built->scene, e.target);
    ENAMEL_CHECK(shape.ok());
    return {std::move(*built), e, std::move(*shape)};
  }
  ADD_FAILURE() << "no exercise " << exercise;
  return {std::move(*built), {}, {}};
}

TEST(BuiltinVeneerTest, HalfAMillimetreGoesAllOverTheFaceAndNothingBeyondIt) {
  const Made made = Make("incisor-labial", "veneer");
  ASSERT_EQ(made.shape.parts.size(), 1u);
  const PreparationPart& part = made.shape.parts[0];
  const ToothShape& tooth = UpperCentralIncisor();
  for (double x = -2.75e-3; x <= 2.76e-3; x += 0.5e-3) {
    for (double y = -4.3e-3; y <= 4.31e-3; y += 0.5e-3) {
      const double at_y = part.top_um[1] * 1e-6 + y;
      const dvec3 floor(x, at_y, ReliefAt(part, x, at_y).z_m);
      const dvec3 own = FromBuccalUp(floor);
      const FieldSample there = ToothField(tooth, own);
      const double depth = -there.distance_m;
      // Toward the root it ends along the cervical line, and keeps to enamel.
      const double above_line_mm = own.z * 1e3 - CervicalHeight_mm(tooth, own.x * 1e3);
      const bool inside = std::fabs(x) <= 2.05e-3 && std::fabs(y) <= 3.65e-3 && above_line_mm > 1.9;
      EXPECT_LT(depth, 0.54e-3) << x << " " << y;
      if (depth > 0.05e-3) {
        EXPECT_EQ(there.tissue, cutting::Tissue::kEnamel) << x << " " << y;
        EXPECT_GT(above_line_mm, 0.5) << x << " " << y;
      }
      if (inside) {
        EXPECT_GT(depth, 0.47e-3) << x << " " << y;
      }
    }
  }
  // The incisal edge is at 5.3 mm.
  EXPECT_GT(PreparationDistance_m(made.shape, ToBuccalUp({0, 0.5e-3, 5.0e-3})), 0);
}

TEST(BuiltinClassFiveTest, TheBoxLiesBetweenGumAndEquatorAndKeepsThePulpCovered) {
  const Made made = Make("molar-buccal", "class-5");
  const ToothShape& tooth = LowerFirstMolar();
  const dvec3 middle = dvec3(made.shape.parts[0].top_um[0], made.shape.parts[0].top_um[1],
                             made.shape.parts[0].top_um[2]) *
                       1e-6;
  const auto& target = made.exercise.target;
  const double hx = target.half_size_um[0] * 1e-6, hy = target.half_size_um[1] * 1e-6;
  // Gingival is +y here.
  EXPECT_GT(FromBuccalUp(middle + dvec3(0, hy, 0)).z, tooth.cervical_z * 1e-3);
  EXPECT_LT(FromBuccalUp(middle - dvec3(0, hy, 0)).z, 0);
  const double floor = target.depth_um * 1e-6;
  for (double x = -hx; x <= hx; x += 0.25e-3)
    for (double y = -hy; y <= hy; y += 0.25e-3) {
      // Something is to be cut everywhere.
      EXPECT_LT(ToothField(tooth, FromBuccalUp(middle + dvec3(x, y, -floor))).distance_m, -0.3e-3);
      for (double deeper = 0; deeper < 1e-3; deeper += 0.25e-3) {
        const dvec3 p = middle + dvec3(x, y, -floor - deeper);
        EXPECT_NE(ToothField(tooth, FromBuccalUp(p)).tissue, cutting::Tissue::kPulp);
      }
    }
}

TEST(BuiltinCrownTest, ItsTableKeepsTheReliefAndThePulpItsCover) {
  for (const auto& [scene, tooth, off_mm] : {std::tuple("molar", &LowerFirstMolar(), 1.2),
                                             {"premolar", &UpperFirstPremolar(), 1.5},
                                             {"incisor", &UpperCentralIncisor(), 1.5}}) {
    SCOPED_TRACE(scene);
    const Made made = Make(scene, "crown");
    const PreparationPart& part = made.shape.parts.at(0);
    ASSERT_NE(part.relief.step_um, 0);
    double highest = -1, lowest = 1;
    const Stump::Section& table = part.stump.table;
    for (double u = -0.8; u <= 0.81; u += 0.1)
      for (double v = -0.8; v <= 0.81; v += 0.1) {
        const double x = (table.middle_um[0] + u * table.half_um[0]) * 1e-3;
        const double y = (table.middle_um[1] + v * table.half_um[1]) * 1e-3;
        const double z = ReliefAt(part, x * 1e-3, y * 1e-3).z_m * 1e3;
        highest = std::max(highest, z), lowest = std::min(lowest, z);
        // Straight down at least as much as across; more on slopes, and where the bur is too wide.
        EXPECT_LT(z, OcclusalHeight_mm(*tooth, x, y) - off_mm + 0.45) << x << " " << y;
        EXPECT_GT(z, OcclusalHeight_mm(*tooth, x, y) - off_mm - 1.2) << x << " " << y;
        for (double deeper = 0; deeper < 0.9; deeper += 0.1) {
          EXPECT_NE(ToothField(*tooth, dvec3(x, y, z - deeper) * 1e-3).tissue,
                    cutting::Tissue::kPulp)
              << x << " " << y;
        }
      }
    const bool cusps = !tooth->cusps.empty();
    EXPECT_GT(highest - lowest, cusps ? 0.8 : 0.0) << "a flat top is what it was before";
  }
}

}  // namespace
}  // namespace enamel::scene
