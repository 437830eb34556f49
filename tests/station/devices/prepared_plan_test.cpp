#include "station/devices/prepared_plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "common/cutting/cutter.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/preparation.h"
#include "common/scene/prepared_target.h"

namespace enamel::station {
namespace {

using cutting::Volume;

// A hand without any error.
Volume Followed(const std::vector<Move>& plan, const cutting::Bur& bur, Volume volume) {
  volume.Reserve();
  cutting::Cutter cutter(volume, bur);
  cutting::RemovedUnits removed{};
  std::optional<dvec3> at;
  for (const Move& move : plan) {
    const auto& stroke = std::get<Stroke>(move);
    for (const dvec3& to : stroke.points) {
      const dvec3 from = at.value_or(to);
      const int steps =
          static_cast<int>(glm::length(to - from) / (0.5 * volume.spec().voxel_m())) + 1;
      for (int i = 1; i <= steps; ++i) {
        const dvec3 p = from + (to - from) * (static_cast<double>(i) / steps);
        if (stroke.bur_on) cutter.Cut({p, {}}, removed);
      }
      at = to;
    }
  }
  return volume;
}

// Solid of `a` that `b` lacks, mm3.
double More_mm3(const Volume& a, const Volume& b) {
  const ivec3 n = a.spec().voxels();
  double sum = 0;
  for (int z = 0; z < n.z; ++z)
    for (int y = 0; y < n.y; ++y)
      for (int x = 0; x < n.x; ++x)
        sum += std::max(0, cutting::SolidFraction(a.PhiAt({x, y, z})) -
                               cutting::SolidFraction(b.PhiAt({x, y, z})));
  const double h = a.spec().voxel_m() * 1e3;
  return sum / 65536 * h * h * h;
}

struct Case {
  const char* exercise;
  double most_beyond_mm3, most_left_share;
};
class PreparedPlanTest : public testing::TestWithParam<Case> {};

TEST_P(PreparedPlanTest, TakesWhatHasToGoAndNothingElse) {
  const auto molar = scene::BuildBuiltinScene("molar", 100'000);
  ASSERT_TRUE(molar.ok());
  for (const scene::Exercise& e : scene::BuiltinExercises(molar->scene, Sha256{})) {
    if (!e.name.starts_with(GetParam().exercise)) continue;
    const Volume wanted =
        scene::Prepared(molar->volume, *scene::TargetShape(molar->scene, e.target));
    const auto target = scene::TargetFromPrepared(molar->scene, molar->volume, wanted,
                                                  HashSha256(AsBytes(std::string_view("x"))), 250);
    ASSERT_TRUE(target.ok()) << target.status().message();
    const cutting::Bur bur = e.bur().metric();
    const PreparedCut cut{&wanted, target->prepared_tooth->lo_m, target->prepared_tooth->hi_m,
                          [](const glm::dvec2&) { return 0.0; }, 0};
    const Volume made = Followed(PlanPrepared(cut, bur, molar->volume, {}), bur, molar->volume);
    const double all_mm3 = More_mm3(molar->volume, wanted), beyond_mm3 = More_mm3(wanted, made),
                 left_mm3 = More_mm3(made, wanted);
    std::printf("%s: %.2f mm3 asked, %.3f beyond, %.3f left\n", e.name.c_str(), all_mm3, beyond_mm3,
                left_mm3);
    EXPECT_LT(beyond_mm3, GetParam().most_beyond_mm3);
    EXPECT_LT(left_mm3, GetParam().most_left_share * all_mm3);
  }
}

INSTANTIATE_TEST_SUITE_P(Exercises, PreparedPlanTest,
                         testing::Values(Case{"class-1", 0.5, 0.12}, Case{"crown", 6, 0.12}));

TEST(PreparedPlanTest, AWallThatGoesInIsCutSoMuchFarther) {
  const auto molar = scene::BuildBuiltinScene("molar", 100'000);
  ASSERT_TRUE(molar.ok());
  const scene::Exercise e = scene::ClassOneExercise(molar->scene, Sha256{});
  const Volume wanted = scene::Prepared(molar->volume, *scene::TargetShape(molar->scene, e.target));
  const auto target = scene::TargetFromPrepared(molar->scene, molar->volume, wanted, Sha256{}, 250);
  ASSERT_TRUE(target.ok());
  const PreparedCut cut{&wanted, target->prepared_tooth->lo_m, target->prepared_tooth->hi_m,
                        [](const glm::dvec2& outward) { return 0.3e-3 * std::max(0.0, outward.x); },
                        0.2e-3};
  const cutting::Bur bur = e.bur().metric();
  const Volume made = Followed(PlanPrepared(cut, bur, molar->volume, {}), bur, molar->volume);
  const double wide_mm = 2e-3 * e.target.half_size_um[1], long_mm = 2e-3 * e.target.half_size_um[0],
               deep_mm = 1e-3 * e.target.depth_um;
  const double expected = 0.3 * (wide_mm - 0.5) * deep_mm + 0.2 * wide_mm * long_mm;
  EXPECT_NEAR(More_mm3(wanted, made), expected, 0.4 * expected);
}

}  // namespace
}  // namespace enamel::station
