#include "common/cutting/engagement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "common/cutting/cutter.h"
#include "tests/support/analytic_volume.h"

namespace enamel::cutting {
namespace {

TissueDamping Enamel(double axial = 6500) {
  TissueDamping b;
  b.lateral[1] = 6500;
  b.axial[1] = axial;
  return b;
}

// A bur that has just cut itself a seat: its surface is on the tooth's.
struct Seat {
  Seat(const Bur& bur, double depth_m, int32_t voxel_nm, const TissueDamping& damping = Enamel())
      : Seat(bur, voxel_nm, damping, dvec3(13e-6, -9e-6, -depth_m)) {}
  Seat(const Bur& bur, int32_t voxel_nm, const TissueDamping& damping, const dvec3& tip_m,
       double half_m = 4e-3)
      : volume(test::Block(voxel_nm, half_m, 6e-3)), reader(bur, voxel_nm * 1e-9, damping) {
    volume.Reserve();
    Cutter cutter(volume, bur);
    RemovedUnits removed{};
    Pose pose{tip_m, Quat{}};
    cutter.Cut(pose, removed);
    reader.Sample(volume, pose);
  }
  Engagement Read(const dvec3& travel) { return reader.Read(volume, travel); }
  Volume volume;
  EngagementReader reader;
};

// The definition of beta: a fully sunk cylinder 0.6 x 4 mm moving sideways meets the tissue's B,
// whatever the direction.
TEST(EngagementTest, ReferenceCylinderMovingSidewaysMeetsTheTissuesDamping) {
  Seat seat({BurShape::kCylinder, 0.6e-3, 4e-3}, 4e-3, 50'000);
  for (double turn : {0.0, 0.13, 0.4}) {
    dvec3 d(std::cos(2 * M_PI * turn), std::sin(2 * M_PI * turn), 0);
    Engagement e = seat.Read(d);
    EXPECT_NEAR(glm::dot(d, e.damping_n_s_per_m * d), 6500, 0.03 * 6500);
  }
}

// Axial: the end face alone, integral of (n.d)^2 = pi r^2.
TEST(EngagementTest, PlungeIsResistedByTheEndFaceOnly) {
  Seat seat({BurShape::kCylinder, 0.6e-3, 4e-3}, 2e-3, 50'000);
  dvec3 down(0, 0, -1);
  double expected = 6500 * (M_PI * 0.36e-6) / EngagementReader::kReferenceArea_m2;
  EXPECT_NEAR(glm::dot(down, seat.Read(down).damping_n_s_per_m * down), expected, 0.03 * expected);
}

// A bur that cuts with its end half as well as with its side is resisted twice as much when it
// plunges, and as before when it moves sideways.
TEST(EngagementTest, AxialDampingCountsForTheEndFaceOnly) {
  Bur bur{BurShape::kCylinder, 0.6e-3, 4e-3};
  Seat same(bur, 2e-3, 50'000), twice(bur, 2e-3, 50'000, Enamel(13000));
  dvec3 down(0, 0, -1), side(1, 0, 0);
  auto along = [](Seat& seat, const dvec3& d) {
    return glm::dot(d, seat.Read(d).damping_n_s_per_m * d);
  };
  EXPECT_NEAR(along(twice, down) / along(same, down), 2, 1e-9);
  EXPECT_NEAR(along(twice, side) / along(same, side), 1, 1e-9);
}

// Lowered by a quarter of a millimetre at a time, a wall's share of B grows in even steps.
TEST(EngagementTest, DampingGrowsEvenlyWithDepth) {
  double before = 0;
  for (int i = 1; i <= 12; ++i) {
    Seat seat({BurShape::kCylinder, 0.6e-3, 4e-3}, i * 0.25e-3, 50'000);
    double b = seat.Read(dvec3(1, 0, 0)).damping_n_s_per_m.xx;
    EXPECT_NEAR(b - before, 6500 * 0.25 / 4, 0.25 * 6500 * 0.25 / 4) << i;
    before = b;
  }
}

TEST(EngagementTest, ShankAtAWallHasANormalAndNoDamping) {
  // The cutting part is a small ball beside the block's edge; the shank above it is wider and
  // touches.
  Volume block = test::Block(50'000, 2e-3, 6e-3);
  Bur bur{BurShape::kSphere, 0.3e-3};
  bur.shank_radius_m = 0.8e-3;
  bur.neck_m = 0.5e-3;
  EngagementReader reader(bur, 50e-6, Enamel());
  reader.Sample(block, {dvec3(2e-3 + 0.79e-3, 0, -4e-3), Quat{}});
  EXPECT_TRUE(reader.Touches(block));
  Engagement e = reader.Read(block, dvec3(-1, 0, 0));
  EXPECT_TRUE(e.damping_n_s_per_m.IsZero());
  EXPECT_NEAR(e.shank_normal.x, -1, 0.05);
  EXPECT_EQ(reader.Read(block, dvec3(1, 0, 0)).shank_normal, dvec3(0)) << "withdrawal is free";
}

TEST(EngagementTest, WithdrawalMeetsNoResistance) {
  Seat seat({BurShape::kSphere, 0.5e-3, 0}, 0.5e-3, 50'000);
  dvec3 up(0, 0, 1);
  Engagement e = seat.Read(up);
  EXPECT_LT(glm::dot(up, e.damping_n_s_per_m * up), 0.02 * 6500);
}

// Half a ball sunk to its equator, moving down: 2 pi r^2 / 3.
TEST(EngagementTest, HalfSunkBallMatchesTheSphereIntegral) {
  Seat seat({BurShape::kSphere, 0.5e-3, 0}, 0.5e-3, 50'000);
  dvec3 down(0, 0, -1);
  double expected = 6500 * (2 * M_PI * 0.25e-6 / 3) / EngagementReader::kReferenceArea_m2;
  EXPECT_NEAR(glm::dot(down, seat.Read(down).damping_n_s_per_m * down), expected, 0.04 * expected);
}

// The integral of (n . d)^2 over the part of the surface that is below the block's top and faces d,
// from 20000 points. Independent of the volume and of what counts as contact.
double FrontIntegral_m2(const Bur& bur, double depth_m, const dvec3& d) {
  double sum = 0;
  for (const SurfacePoint& p : SampleSurface(bur, 1e-9, 20'000)) {
    double along = glm::dot(p.normal, d);
    if (p.position_m.z < depth_m && along > 0) sum += along * along * p.area_m2;
  }
  return sum;
}

std::vector<Bur> BuiltinBurs() {
  return {{BurShape::kSphere, 0.8e-3},
          {BurShape::kCylinder, 0.6e-3, 4e-3},
          {BurShape::kCone, 0.8e-3, 4e-3, 0.5e-3},
          {BurShape::kInvertedCone, 0.6e-3, 1.2e-3, 0.4e-3},
          {BurShape::kPear, 0.6e-3, 2.5e-3, 0.35e-3},
          {BurShape::kFlame, 0.6e-3, 5e-3, 0.3e-3},
          {BurShape::kWheel, 1.5e-3, 1e-3}};
}

// Leaving grazing surface out costs the front next to nothing.
TEST(EngagementTest, EveryBurInItsSeatMeetsTheIntegralOverItsFront) {
  double worst = 0;
  for (const Bur& bur : BuiltinBurs()) {
    const double depth = 0.5 * bur.height_m();
    Seat seat(bur, depth, 50'000);
    for (const dvec3& d : {dvec3(1, 0, 0), dvec3(0.8, 0, -0.6), dvec3(0, 0.6, -0.8)}) {
      double expected =
          6500 * FrontIntegral_m2(bur, depth, d) / EngagementReader::kReferenceArea_m2;
      double found = glm::dot(d, seat.Read(d).damping_n_s_per_m * d);
      EXPECT_NEAR(found, expected, 0.05 * expected) << BurShapeName(bur.shape) << " " << d.x;
      worst = std::max(worst, std::fabs(found / expected - 1));
    }
  }
  std::printf("B of a bur in its seat: at most %.1f %% from the integral\n", 100 * worst);
}

// The bur cuts in along its axis to every depth around the one at which its top is level with the
// surface, then is drawn back along it. Nothing is ahead anywhere on the way back: no rim and no
// film (engagement.h).
TEST(EngagementTest, BurDrawnUpItsAxisMeetsNothingAtAnyDepth) {
  const Volume block = test::Block(50'000, 2e-3, 6e-3);
  // Off the axes.
  const Quat tilted = FromQuantised(ToQuantised(Quat{std::sin(0.1), std::sin(0.06), 0, 0.98}));
  double worst = 0;
  for (const Bur& bur : BuiltinBurs()) {
    for (double above : {-0.6e-3, -45e-6, -20e-6, 0.0, 20e-6, 45e-6, 0.5e-3}) {
      for (const Quat& q : {Quat{}, tilted}) {
        Volume volume = block;
        volume.Reserve();
        Cutter cutter(volume, bur);
        RemovedUnits removed{};
        const dvec3 axis = q.Matrix()[2];
        auto at = [&](double up) {
          return Pose{dvec3(13e-6, -9e-6, 0) + axis * (above + up - bur.height_m()), q};
        };
        for (int k = 150; k >= 0; --k) cutter.Cut(at(k * (bur.height_m() + 1e-3) / 150), removed);
        EngagementReader reader(bur, 50e-6, Enamel());
        for (double up = 0; up < bur.height_m(); up += 60e-6) {
          reader.Sample(volume, at(up));
          double b = glm::dot(axis, reader.Read(volume, axis).damping_n_s_per_m * axis);
          // At 50 mm/s 0.15 N.
          ASSERT_LT(b, 3) << BurShapeName(bur.shape) << ", top at " << above << ", drawn up by "
                          << up << (q.x != 0 ? ", tilted" : "");
          worst = std::max(worst, b);
        }
      }
    }
  }
  std::printf("drawn up its axis a bur meets at most %.3f N s/m\n", worst);
}

constexpr double kFeed = 0.43e-3, kR = 0.6e-3, kL = 4e-3;

// 0.2 N + 2.6 N (v/v0)^m at the reference engagement.
TissueDamping ByLoad(FeedExponent exponent) {
  TissueDamping b;
  b.lateral[1] = b.axial[1] = 2.6 / kFeed;
  b.coulomb_n[1] = 0.2;
  b.exponent[1] = exponent;
  b.feed_m_per_s[1] = kFeed;
  b.friction[1] = 0.5;
  return b;
}

// Integral of cos^q from `from` to pi/2: the arc of a cylinder's front, by Simpson's rule in another variable than the
// reader's points.
double Arc(double from, double q) {
  constexpr int kSteps = 2000;
  const double h = (M_PI / 2 - from) / kSteps;
  double sum = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double weight = i == 0 || i == kSteps ? 1 : i % 2 == 1 ? 4 : 2;
    sum += weight * std::pow(std::max(0.0, std::cos(from + i * h)), q);
  }
  return sum * h / 3;
}

// Tissue that is cut by load, against the closed integrals of the pressure over the surface, at a quarter, once and four
// times the feed v0, for each exponent: the reference cylinder's side, its end in a plunge, and a wall that is
// widened and finished.
TEST(EngagementTest, LoadIsTheIntegralOfThePressure) {
  for (FeedExponent exponent : {FeedExponent::kNone, FeedExponent::kHalf, FeedExponent::kOne}) {
    const double m = 0.5 * static_cast<int>(exponent);
    // Pressures at the feed v0 per element that moves along its normal.
    const double p0 = 0.2 / (2 * kR * kL), k = 2.6 / (2 * Arc(0, 1 + m) * kR * kL);
    auto expect = [&](Seat& seat, const dvec3& d, double coulomb, double rate, const char* name,
                      double within = 0.03) {
      ASSERT_TRUE(seat.Read(d).by_load);
      const FeedForce f = seat.reader.Along(d, 1);
      for (double times : {0.25, 1.0, 4.0}) {
        const double expected = coulomb + rate * std::pow(times, m);
        EXPECT_NEAR(f.At(times * kFeed), expected, within * expected) << name << ", m " << m;
      }
    };
    const Bur bur{BurShape::kCylinder, kR, kL};
    Seat side(bur, kL, 50'000, ByLoad(exponent));
    expect(side, dvec3(0, 1, 0), 0.2, 2.6, "side");
    expect(side, glm::normalize(dvec3(-3, 2, 0)), 0.2, 2.6, "side, turned");
    Seat half(bur, kL / 2, 50'000, ByLoad(exponent));
    expect(half, dvec3(0, 1, 0), 0.1, 1.3, "half sunk");
    const double end = M_PI * kR * kR;
    expect(half, dvec3(0, 0, -1), p0 * end, k * end, "plunge");
    for (double deep : {0.3e-3, 0.1e-3}) {
      // Along the block's edge, `deep` into it: the front's arc from asin(1 - deep/r) on.
      Seat wall(bur, 50'000, ByLoad(exponent), dvec3(4e-3 + kR - deep, 13e-6, -kL));
      const double from = std::asin(1 - deep / kR);
      // Two voxels deep the front is three points wide: the next test.
      expect(wall, dvec3(0, 1, 0), p0 * kL * deep, k * kR * kL * Arc(from, 1 + m), "wall",
             deep < 0.2e-3 ? 0.07 : 0.03);
    }
  }
}

// A wall finished by two voxels, wherever it is in its voxel: low by up to 17 %, for each exponent alike, also for B v.
TEST(EngagementTest, AFinishedWallOfTwoVoxelsIsFeltTooWeak) {
  constexpr double kDeep = 0.1e-3;
  for (FeedExponent exponent : {FeedExponent::kNone, FeedExponent::kHalf, FeedExponent::kOne}) {
    const double m = 0.5 * static_cast<int>(exponent);
    const double right =
        0.2 * kDeep / (2 * kR) + 2.6 * Arc(std::asin(1 - kDeep / kR), 1 + m) / (2 * Arc(0, 1 + m));
    double low = 1, high = -1;
    for (double part : {0.0, 0.29, 0.57, 0.83}) {
      const double half_m = 4e-3 + part * 50e-6;
      Seat wall({BurShape::kCylinder, kR, kL}, 50'000, ByLoad(exponent),
                dvec3(half_m + kR - kDeep, 13e-6, -kL), half_m);
      wall.Read(dvec3(0, 1, 0));
      const double off = wall.reader.Along(dvec3(0, 1, 0), 1).At(kFeed) / right - 1;
      low = std::min(low, off), high = std::max(high, off);
    }
    std::printf("m %.1f: a wall finished by 0.1 mm is felt %.1f to %.1f %% off\n", m, 100 * low,
                100 * high);
    EXPECT_GT(low, -0.17) << m;
    EXPECT_LT(high, 0) << m;
  }
}

// A bur that turns clockwise, seen from the handpiece, and goes along +y drags its holder to +x; on a front
// that is alike on both sides by mu times the force along. The torque: mu r times the integral of the pressure, of
// which the reader leaves out the edges of the front (kGrazing).
TEST(EngagementTest, TheTurningSurfaceDragsAcrossTheFeedAndLoadsTheSpindle) {
  Seat side({BurShape::kCylinder, kR, kL}, kL, 50'000, ByLoad(FeedExponent::kHalf));
  side.Read(dvec3(0, 1, 0));
  const BurDrag drag = side.reader.Drag(dvec3(0, kFeed, 0), 1);
  EXPECT_NEAR(drag.force_n.x, 0.5 * 2.8, 0.03 * 1.4);
  EXPECT_NEAR(drag.force_n.y, 0, 0.03);
  EXPECT_NEAR(drag.force_n.z, 0, 0.03);
  const double k = 2.6 / (2 * Arc(0, 1.5)), p0 = 0.2 / 2;
  const double torque = 0.5 * kR * (k * 2 * Arc(0, 0.5) + p0 * M_PI);
  EXPECT_NEAR(drag.torque_n_m, torque, 0.05 * torque);
  EXPECT_LT(drag.torque_n_m, torque);
  // Half the speed: each chip is twice as thick.
  const BurDrag slow = side.reader.Drag(dvec3(0, kFeed / 2, 0), 0.5);
  EXPECT_NEAR(slow.torque_n_m, drag.torque_n_m, 1e-12);
  const FeedForce f = side.reader.Along(dvec3(0, 1, 0), 1),
                  s = side.reader.Along(dvec3(0, 1, 0), 0.5);
  EXPECT_NEAR(s.At(kFeed / 2), f.At(kFeed), 1e-9);
}

// The secant is the force over the feed along it, and symmetric and positive, whatever the feed.
TEST(EngagementTest, TheSecantOfALoadGivesItsForce) {
  Seat seat({BurShape::kCylinder, kR, kL}, kL / 2, 50'000, ByLoad(FeedExponent::kHalf));
  for (const dvec3& way : {dvec3(0, 1, 0), dvec3(1, 2, -0.5), dvec3(0, 0, -1)}) {
    const dvec3 d = glm::normalize(way);
    seat.Read(d);
    for (double feed : {1e-5, 1e-3, 1e-1}) {
      const Sym3 b = seat.reader.Secant(d * feed, 1);
      const double along = seat.reader.Along(d, 1).At(feed);
      EXPECT_NEAR(Dot(d, b * d) * feed, along, 1e-3 * along);
      EXPECT_TRUE(b.IsPositiveSemiDefinite(1e-12));
    }
    EXPECT_TRUE(seat.reader.Secant(dvec3(0), 1).IsFinite());
  }
}

TEST(EngagementTest, InAirThereIsNothing) {
  Seat seat({BurShape::kSphere, 0.5e-3, 0}, 0.5e-3, 50'000);
  seat.reader.Sample(seat.volume, {dvec3(0, 0, 1e-3), Quat{}});
  EXPECT_FALSE(seat.reader.Touches(seat.volume));
  EXPECT_TRUE(seat.Read(dvec3(1, 0, 0)).damping_n_s_per_m.IsZero());
}

// What was read on the way to a pose saves time and changes nothing: a bur is moved and turned into
// a block by small and large steps, and cuts as it goes.
TEST(EngagementTest, WhatIsLeftOutOfASampleChangesNothing) {
  for (const Bur& bur : BuiltinBurs()) {
    Volume volume = test::Block(100'000, 2e-3, 6e-3);
    volume.Reserve();
    Cutter cutter(volume, bur);
    RemovedUnits removed{};
    EngagementReader along(bur, 100e-6, Enamel());
    std::mt19937 random(3);
    std::uniform_real_distribution<double> any(-1, 1);
    dvec3 tip(0, 0, 0.2e-3);
    Quat turn;
    int touched = 0;
    for (int i = 0; i < 300; ++i) {
      const double step = i % 20 == 0 ? 200e-6 : 15e-6;
      tip += dvec3(any(random), any(random), any(random) - 0.3) * step;
      turn = (Quat{0.02 * any(random), 0.02 * any(random), 0, 1} * turn).Normalised();
      const dvec3 travel(any(random), any(random), any(random));
      along.Sample(volume, {tip, turn});
      EngagementReader fresh(bur, 100e-6, Enamel());
      fresh.Sample(volume, {tip, turn});
      for (const dvec3& d : {travel, dvec3(-travel.y, travel.x, travel.z)}) {
        const Engagement a = along.Read(volume, d), b = fresh.Read(volume, d);
        ASSERT_EQ(a.damping_n_s_per_m.Trace(), b.damping_n_s_per_m.Trace()) << i;
        ASSERT_EQ(a.area_m2, b.area_m2) << i;
        ASSERT_EQ(a.mean_normal, b.mean_normal) << i;
        touched += a.area_m2 > 0;
      }
      ASSERT_EQ(along.Touches(volume), fresh.Touches(volume)) << i;
      cutter.Cut({tip, turn}, removed);
    }
    EXPECT_GT(touched, 100) << BurShapeName(bur.shape);
  }
}

}  // namespace
}  // namespace enamel::cutting
