#include "common/scoring/mistakes/contact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "common/scene/prepared_target.h"
#include "common/scoring/mistakes/prices.h"
#include "common/scoring/trial.h"
#include "tests/common/scoring/synthetic_cavity.h"
#include "tests/support/analytic_volume.h"

// Two blocks side by side, 0.1 mm apart, and a box that opens their contact: every share has a closed form.
namespace enamel::scoring {
namespace {

using cutting::Tissue;
using cutting::Volume;

constexpr double kMm = 1e-3;
// The tooth ends at x = 2 mm. The box reaches from x = 0.5 mm to there, over 2.4 mm of y, 1.8 mm deep.
constexpr double kEnd = 2, kBox = 0.5, kHalf = 1.2, kDepth = 1.8;

double ToBox(const dvec3& p, const dvec3& lo, const dvec3& hi) {
  const dvec3 q = glm::max(lo - p, p - hi);
  const double outside = glm::length(glm::max(q, dvec3(0)));
  return outside > 0 ? outside : std::max({q.x, q.y, q.z});
}

// `gone`: signed distance of what was taken, mm.
template <typename Gone>
Volume Blocks(int32_t voxel_nm, const Gone& gone) {
  cutting::GridSpec spec;
  spec.voxel_nm = voxel_nm;
  const int side = 8 * voxel_nm;
  spec.bricks = ivec3(6'000'000 / side + 1, 6'000'000 / side + 1, 5'000'000 / side + 1);
  spec.origin_nm = {-2'031'000, -3'017'000, -4'009'000};
  const Volume all = test::VolumeOf(spec, Tissue::kEnamel, [&](const dvec3& p_m) {
    const dvec3 p = p_m / kMm;
    const double tooth = ToBox(p, {-1.5, -2.5, -3.5}, {kEnd, 2.5, 0});
    const double next = ToBox(p, {kEnd + 0.1, -2.5, -3.5}, {3.5, 2.5, 0});
    return std::min(std::max(tooth, -gone(p)), next) * kMm;
  });
  // Labels the second block.
  Volume out(spec);
  for (int b = 0; b < spec.brick_count(); ++b) {
    std::array<uint8_t, cutting::kBrickVoxels> labels;
    const int first = b % spec.bricks.x * cutting::kBrickSide;
    for (int i = 0; i < cutting::kBrickVoxels; ++i) {
      const double x = spec.origin_m().x + (first + (i & 7)) * spec.voxel_m();
      labels[i] =
          static_cast<uint8_t>(x > (kEnd + 0.05) * kMm ? Tissue::kNeighbour : Tissue::kEnamel);
    }
    if (all.IsStored(b))
      out.SetBrick(b, all.Phi(b).phi, labels, Tissue::kEnamel);
    else if (all.UniformTissue(b) != Tissue::kAir)
      out.SetUniform(b, static_cast<Tissue>(labels[0]));
  }
  return out;
}
double Box(const dvec3& p) { return ToBox(p, {kBox, -kHalf, -kDepth}, {kEnd + 0.05, kHalf, 9}); }

// The box less a plate of `thick` mm at the tooth's side, up to the height z and from y on.
struct Plate {
  double thick = 0, to_z = 9, from_y = -9;
  double operator()(const dvec3& p) const {
    return std::max(Box(p), -ToBox(p, {kEnd - thick, from_y, -9}, {9, 9, to_z}));
  }
};

struct Judged {
  std::vector<Contact::Third> thirds;
  std::vector<double> closed;  // percent, by third
  double all = 0;
};
Judged Judge(int32_t voxel_nm, const Plate& plate) {
  const Volume initial = Blocks(voxel_nm, [](const dvec3&) { return 9.0; });
  const Volume r = Blocks(voxel_nm, Box), attempt = Blocks(voxel_nm, plate);
  const AcceptableCut cut(initial, r, {46, scene::Up::kOcclusal});
  Judged out;
  for (const RegionMeasure& m : MeasuresOf(cut, MeasureFaults(cut, attempt))) {
    if (m.kind == whole::kContact) out.closed.push_back(m.left);
  }
  if (cut.contact()) out.thirds = cut.contact()->thirds();
  out.all = Contact(initial, r, 46, scene::Up::kOcclusal).Of(attempt).closed_percent();
  return out;
}

TEST(ContactTest, HasThreeThirdsOfEqualArea) {
  for (const int32_t voxel_nm : {100'000, 50'000}) {
    const Judged exact = Judge(voxel_nm, {});
    ASSERT_EQ(exact.thirds.size(), 3u);
    // x grows distally in the fourth quadrant.
    EXPECT_EQ(exact.thirds[0].name, "contact_distal_buccal");
    EXPECT_EQ(exact.thirds[1].name, "contact_distal_gingival");
    EXPECT_EQ(exact.thirds[2].name, "contact_distal_lingual");
    const double h = voxel_nm * 1e-6, third = 2 * kHalf * kDepth / 3;
    for (const Contact::Third& t : exact.thirds) EXPECT_NEAR(t.rows * h * h / third, 1, 0.05);
    EXPECT_GT(exact.thirds[0].at_m.y, 0.3 * kMm);
    EXPECT_LT(exact.thirds[2].at_m.y, -0.3 * kMm);
    EXPECT_NEAR(exact.thirds[1].at_m.z, -kDepth * 5 / 6 * kMm, 0.05 * kMm);
    for (const double closed : exact.closed) EXPECT_EQ(closed, 0);
    EXPECT_EQ(exact.all, 0);
  }
}

TEST(ContactTest, IsClosedWhereAPlateStands) {
  for (const int32_t voxel_nm : {100'000, 50'000}) {
    const Judged gingival = Judge(voxel_nm, {.thick = 0.3, .to_z = -kDepth * 2 / 3});
    EXPECT_LT(gingival.closed.at(0), 8);  // a voxel's row of it
    EXPECT_GT(gingival.closed.at(1), 95);
    EXPECT_LT(gingival.closed.at(2), 8);
    EXPECT_NEAR(gingival.all, 100. / 3, 4);
    const Judged buccal = Judge(voxel_nm, {.thick = 0.3, .from_y = 0});
    EXPECT_GT(buccal.closed.at(0), 95);
    EXPECT_NEAR(buccal.closed.at(1), 50, 5);
    EXPECT_LT(buccal.closed.at(2), 8);
  }
}

// From 0.02 to 0.1 mm by a cubic, of which the middle is a half.
TEST(ContactTest, AFilmClosesItByItsThickness) {
  EXPECT_EQ(Judge(50'000, {.thick = 0.01}).all, 0);
  EXPECT_NEAR(Judge(50'000, {.thick = 0.06}).all, 50, 15);
  EXPECT_GT(Judge(50'000, {.thick = 0.12}).all, 95);
  double last = -1;
  for (const double thick : {0.0, 0.03, 0.05, 0.07, 0.1, 0.2, 0.5, 1.0}) {
    const double closed = Judge(100'000, {.thick = thick}).all;
    EXPECT_GE(closed, last) << thick;
    last = closed;
  }
}

// A pillar stands farther in than half a millimetre.
TEST(ContactTest, IsOpenBesideAPillar) {
  const auto pillar = [](const dvec3& p) {
    return std::max(Box(p), -ToBox(p, {0.8, -0.5, -9}, {1.3, 0.5, 9}));
  };
  const Volume initial = Blocks(100'000, [](const dvec3&) { return 9.0; });
  const Volume r = Blocks(100'000, Box);
  const Contact contact(initial, r, 46, scene::Up::kOcclusal);
  EXPECT_EQ(contact.Of(Blocks(100'000, pillar)).closed, 0);
}

// A scan of a prepared tooth may be of a crown or of a cavity.
TEST(ContactTest, IsMeasuredAgainstAPreparedToothUnlessThatIsAStump) {
  const Volume initial = Blocks(100'000, [](const dvec3&) { return 9.0; });
  const auto stump = [](const dvec3& p) {
    return -std::min(ToBox(p, {-0.4, -1.4, -9}, {0.9, 1.4, -0.3}),
                     ToBox(p, {-9, -9, -9}, {9, 9, -2.8}));
  };
  auto left = [&](const Volume& r, const Volume& attempt) {
    scene::Exercise exercise = BlockExercise();
    exercise.target = *scene::TargetFromPrepared(BlockScene(), initial, r, Sha256{1}, 200);
    return CalmAttempts(initial, r).Measure(BlockScene(), exercise, attempt).value();
  };
  const MetricSet of_box =
      left(Blocks(100'000, Box), Blocks(100'000, Plate{.thick = 0.3, .to_z = -kDepth * 2 / 3}));
  EXPECT_NEAR(ValueOf(of_box, "contact_left_percent"), 100. / 3, 4);
  const MetricSet of_stump = left(Blocks(100'000, stump), Blocks(100'000, stump));
  EXPECT_GT(ValueOf(of_stump, "reduction_top_percent"), 99);
  EXPECT_NE(std::ranges::find(of_stump.missing, "contact_left_percent", &MissingMetric::name),
            of_stump.missing.end());
}

TEST(ContactTest, ACutThatOpensNoneHasNone) {
  const Volume initial = Blocks(100'000, [](const dvec3&) { return 9.0; });
  const auto inner = [](const dvec3& p) { return ToBox(p, {-1, -1, -1}, {1, 1, 9}); };
  EXPECT_TRUE(Contact(initial, Blocks(100'000, inner), 46, scene::Up::kOcclusal).thirds().empty());
  // Shallower than a millimetre behind the tooth's side: a veneer's edge.
  const auto thin = [](const dvec3& p) { return ToBox(p, {1.4, -1, -1}, {2.05, 1, 9}); };
  EXPECT_TRUE(Contact(initial, Blocks(100'000, thin), 46, scene::Up::kOcclusal).thirds().empty());
}

}  // namespace
}  // namespace enamel::scoring
