#include "station/mouth/mouth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include "common/scene/builtin/builtin.h"
#include "common/scene/builtin/teeth.h"
#include "station/desk/target_outline.h"
#include "station/mouth/antagonist.h"
#include "station/mouth/crowns.h"
#include "station/mouth/gingiva.h"
#include "station/mouth/rubber_dam.h"
#include "station/render/revolve.h"

namespace enamel::station::mouth {
namespace {

constexpr int32_t kVoxel_nm = 100'000;
constexpr auto kDam = scene::Isolation::kRubberDam;

TissueAt ShapeOf(const scene::ToothShape& shape) {
  return [&shape](const dvec3& p_mm) {
    const scene::FieldSample sample = scene::ToothField(shape, 1e-3 * p_mm);
    return sample.distance_m < 0 ? sample.tissue : cutting::Tissue::kAir;
  };
}

TEST(NeckTest, TheMarginFollowsTheCementLine) {
  for (const scene::ToothShape* shape : scene::BuiltinTeeth()) {
    const auto neck = NeckOf(ShapeOf(*shape), {0, 0}, shape->cervical_z - 1, 1);
    ASSERT_TRUE(neck) << shape->name;
    // By the tables of teeth.h: lowest on the faces, risen mesially and distally. +x is mesial or
    // distal by the side of the jaw.
    const double face = shape->cervical_z + kAboveCementLine_mm;
    const double mesial = neck->margin_mm.At(shape->Along(1) > 0 ? 0 : std::numbers::pi),
                 distal = neck->margin_mm.At(shape->Along(1) > 0 ? std::numbers::pi : 0);
    EXPECT_NEAR(neck->margin_mm.At(std::numbers::pi / 2), face, 0.3) << shape->name;
    EXPECT_NEAR(neck->margin_mm.At(-std::numbers::pi / 2), face, 0.3) << shape->name;
    EXPECT_NEAR(mesial, face + shape->enamel.mesial_rise, 0.6) << shape->name;
    EXPECT_NEAR(distal, face + shape->enamel.distal_rise, 0.6) << shape->name;
  }
}

TEST(NeckTest, WithoutEnamelThereIsNone) {
  const TissueAt post = [](const dvec3& p) {
    return std::hypot(p.x, p.y) < 3 ? cutting::Tissue::kDentin : cutting::Tissue::kAir;
  };
  EXPECT_FALSE(NeckOf(post, {0, 0}, -8, 1));
}

TEST(GingivaTest, HidesTheRootAndFillsTheSpaceBetweenTeeth) {
  const scene::ToothShape& molar = scene::LowerFirstMolar();
  const Neck neck = *NeckOf(ShapeOf(molar), {0, 0}, molar.cervical_z - 1, 1);
  Neck next = neck;
  next.middle_mm.x = 11.5;
  const Gingiva alone({neck}, Around(1e3)), two({neck, next}, Around(1e3));
  for (size_t i = 0; i < Around::kCount; i += 4) {
    const double angle = Around::Angle(i), r = neck.radius_mm.At(angle) + 0.1;
    const double x = r * std::cos(angle), y = r * std::sin(angle);
    EXPECT_NEAR(alone.Height_mm(x, y), neck.margin_mm.At(angle), 0.05) << angle;
  }
  const double between = 0.5 * 11.5;
  EXPECT_GT(two.Height_mm(between, 0), alone.Height_mm(between, 0) + 0.3);
  EXPECT_LT(two.Height_mm(between, 0),
            std::max(neck.margin_mm.At(0), next.margin_mm.At(std::numbers::pi)) + kPapilla_mm);
}

// Below the clear margin where that is lower, and without a step beside it.
TEST(RubberDamTest, HugsTheNeckAndFallsAwayFromIt) {
  const scene::ToothShape& molar = scene::LowerFirstMolar();
  const Neck neck = *NeckOf(ShapeOf(molar), {0, 0}, molar.cervical_z - 1, 1);
  const double lowest = neck.margin_mm.Mean() - 3;
  for (const double limit : {1e3, lowest}) {
    size_t at_neck = 0, far = 0;
    for (const render::GroupMesh& piece : RubberDam({&neck, 1}, Around(limit))) {
      for (const render::GpuVertex& v : piece.vertices) {
        const double x = v.position_mm[0], y = v.position_mm[1], z = v.position_mm[2];
        const double out = FromTooth_mm(neck, x, y), margin = neck.margin_mm.At(std::atan2(y, x));
        EXPECT_LE(z, HighestAt_mm(neck, Around(limit), x, y) + 1e-3);
        if (limit < margin) continue;
        if (out > 0 && out < 0.3) {
          ++at_neck;
          EXPECT_NEAR(z, margin, 0.5);
        } else if (out > 12) {
          ++far;
          EXPECT_LT(z, neck.margin_mm.Mean() - 2);
        }
      }
    }
    EXPECT_EQ(at_neck > 50 && far > 50, limit > lowest);
  }
}

TEST(AntagonistTest, TheMouthIsOpenByTheFigureAtTheIncisorsAndByLessFartherBack) {
  double before = 2 * kOpening_mm;
  for (const int tooth : {11, 14, 46}) {
    constexpr double kTop_mm = 4;
    double lowest = 1e3;
    for (const render::GroupMesh& mesh : AntagonistOf(tooth, kTop_mm)) {
      for (const render::GpuVertex& v : mesh.vertices) {
        if (std::hypot(v.position_mm[0], v.position_mm[1]) > 30) continue;
        lowest = std::min<double>(lowest, v.position_mm[2]);
      }
    }
    if (tooth == 11) {
      EXPECT_NEAR(lowest - kTop_mm, kOpening_mm, 5);
    }
    EXPECT_GT(lowest - kTop_mm, 0.4 * kOpening_mm) << tooth;
    EXPECT_LT(lowest, before) << tooth;
    before = lowest;
  }
  EXPECT_TRUE(AntagonistOf(55, 4).empty());
}

TEST(AntagonistTest, ItGivesWayToAnEyeBehindItAndIsNoneWhereNobodyAsks) {
  auto built = scene::BuildBuiltinScene("molar", 200'000);
  ASSERT_TRUE(built.ok());
  const render::Scenery mouth = MakeMouth(built->scene, built->volume, {});
  ASSERT_FALSE(mouth.opposite.empty());
  ASSERT_FALSE(mouth.work_mm.empty());
  auto covered_from = [&](const glm::vec3& eye_mm) {
    return std::ranges::any_of(render::BoxesOf(mouth.opposite), [&](const render::Box& box) {
      return render::Covers(box, mouth.work_mm[0], eye_mm);
    });
  };
  EXPECT_TRUE(covered_from({0, 0, 60}));
  // As an attempt begins, 55 degrees up from the tongue's side; and from three times as far.
  EXPECT_FALSE(covered_from({8, -17, 26}));
  EXPECT_FALSE(covered_from({24, -51, 78}));
  EXPECT_TRUE(MakeMouth(built->scene, built->volume, {}, {.antagonist = false}).opposite.empty());
}

TEST(CrownsTest, TheNextToothIsAcrossTheMidlineToo) {
  for (const auto& [tooth, mesial, distal] : {std::tuple{46, 45, 47},
                                              {11, 21, 12},
                                              {21, 11, 22},
                                              {31, 41, 32},
                                              {48, 47, 0},
                                              {55, 0, 0}}) {
    EXPECT_EQ(NextTooth(tooth, true), mesial) << tooth;
    EXPECT_EQ(NextTooth(tooth, false), distal) << tooth;
  }
}

TEST(CrownsTest, NeighboursStandBesideTheTooth) {
  for (int tooth : {46, 36, 14, 11, 48}) {
    const auto crowns = NeighboursOf(tooth, {4, 4});
    EXPECT_EQ(crowns.size(), tooth == 48 ? 2u : 4u);
    for (const Crown& crown : crowns) {
      const Neck neck = crown.neck();
      EXPECT_GT(std::abs(crown.middle.x), 4 + neck.radius_mm.At(0) * 0.7) << tooth;
      EXPECT_LE(crown.middle.y, 0) << "the arch turns toward the tongue";
    }
  }
}

struct Work {
  const char *scene, *exercise;
  scene::Isolation isolation = scene::Isolation::kNone;
};
void PrintTo(const Work& work, std::ostream* out) { *out << work.exercise; }
class MouthOfTest : public testing::TestWithParam<Work> {};

// Whatever the exercise: half a millimetre of tooth is seen below what is to be cut.
TEST_P(MouthOfTest, GingivaAndDamKeepClearOfTheTarget) {
  auto built = scene::BuildBuiltinScene(GetParam().scene, kVoxel_nm);
  ASSERT_TRUE(built.ok());
  for (const scene::Exercise& e : scene::BuiltinExercises(built->scene, Sha256{})) {
    if (!e.name.starts_with(GetParam().exercise)) continue;
    const auto outline = desk::OutlineOf(built->scene, e.target, built->volume);
    ASSERT_FALSE(outline.empty());
    const render::Scenery mouth =
        MakeMouth(built->scene, built->volume, outline, {GetParam().isolation});
    ASSERT_FALSE(mouth.fixed.empty());
    const bool dam = GetParam().isolation == scene::Isolation::kRubberDam;
    for (const render::GpuVertex& v : mouth.fixed[0].vertices) {
      ASSERT_EQ(v.tissue >= render::kRubberDam, dam) << "what the sheet hides is not built";
    }
    const bool own = built->scene.name.find("class-2") != std::string::npos;
    EXPECT_EQ(mouth.giving_way.empty(), own) << "neighbours of the scene are not doubled";
    const bool buccal = built->scene.up == scene::Up::kBuccal;
    for (const surface::LineSegment& line : outline) {
      ASSERT_GT(glm::dot(mouth.hides_below, glm::vec4(1e3f * line.from_m, 1)), 1);
    }
    auto upright = [&](const dvec3& p) { return buccal ? scene::FromBuccalUp(p) : p; };
    size_t near = 0;
    for (size_t i = 0; i < outline.size(); i += 3) {
      const dvec3 at = upright(1e3 * dvec3(outline[i].from_m));
      for (const render::GroupMesh& mesh : mouth.fixed) {
        for (const render::GpuVertex& v : mesh.vertices) {
          const dvec3 p = upright(dvec3(v.position_mm[0], v.position_mm[1], v.position_mm[2]));
          if (std::hypot(p.x - at.x, p.y - at.y) > 0.4) continue;
          ++near;
          ASSERT_LT(p.z, at.z - kClearOfTarget_mm + 0.05);
        }
      }
    }
    EXPECT_GT(near, 10u);
    return;
  }
  FAIL() << "no such exercise";
}
INSTANTIATE_TEST_SUITE_P(Exercises, MouthOfTest,
                         testing::Values(Work{"molar", "crown"}, Work{"molar-class-2", "class-2"},
                                         Work{"molar-buccal", "class-5"},
                                         Work{"incisor-labial", "veneer"},
                                         Work{"molar-class-2", "class-2", kDam},
                                         Work{"molar-buccal", "class-5", kDam}));

TEST(MouthTest, WithoutAToothThereIsNone) {
  auto block = scene::BuildBuiltinScene("block", 200'000);
  ASSERT_TRUE(block.ok());
  EXPECT_TRUE(MakeMouth(block->scene, block->volume, {}).empty());
}

TEST(SceneryTest, ABodyCoversWhatIsBehindIt) {
  const render::Box box{{-1, -1, 4}, {1, 1, 5}};
  EXPECT_TRUE(render::Covers(box, {0, 0, 0}, {0, 0, 30}));
  EXPECT_TRUE(render::Covers(box, {0, 0, 0}, {5, 0, 30}));
  EXPECT_FALSE(render::Covers(box, {0, 0, 0}, {30, 0, 30})) << "past it";
  EXPECT_FALSE(render::Covers(box, {0, 0, 0}, {0, 0, 3})) << "before it";
  EXPECT_FALSE(render::Covers(box, {0, 0, 6}, {0, 0, 30})) << "above it";
  EXPECT_FALSE(render::Covers(box, {2, 0, 0}, {2, 0, 30}));
}

}  // namespace
}  // namespace enamel::station::mouth
