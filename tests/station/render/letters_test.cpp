#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "station/render/fonts.h"

namespace enamel::station::render {
namespace {

constexpr double kSeat_mm = 700;

// The angle of a height that is seen from the seat.
double MinutesOfArc(double height_mm) {
  return 2 * std::atan(height_mm / 2 / kSeat_mm) * 180 / std::numbers::pi * 60;
}

struct Monitor {
  int width_px, height_px;
  double inches;
  double pixel_mm() const { return 25.4 * inches / std::hypot(width_px, height_px); }
};

TEST(LettersTest, TheSmallestAreReadFromTheSeatOnEveryMonitor) {
  const Monitor reference{1920, 1080, 24};
  // The letters keep their proportion to the reference picture.
  const double least_mm = 16 * reference.pixel_mm();
  for (const Monitor& m :
       {reference, Monitor{1024, 768, 15}, Monitor{1280, 1024, 17}, Monitor{1280, 1024, 19},
        Monitor{1366, 768, 14}, Monitor{1366, 768, 18.5}, Monitor{1920, 1080, 13.3},
        Monitor{1920, 1080, 15.6}, Monitor{1920, 1080, 65}, Monitor{1080, 1920, 24},
        Monitor{2160, 1440, 15}, Monitor{2560, 1440, 27}, Monitor{3840, 2160, 27},
        Monitor{3840, 2160, 15.6}}) {
    const LetterSizes sizes = LettersFor(m.width_px, m.height_px, m.pixel_mm());
    const std::string name = std::to_string(m.width_px) + " x " + std::to_string(m.height_px) +
                             ", " + std::to_string(m.inches) + " inches";
    EXPECT_GE(sizes.near * m.pixel_mm(), least_mm) << name;
    EXPECT_GE(MinutesOfArc(sizes.near * m.pixel_mm()), 21.9) << name;
    EXPECT_GE(sizes.text, sizes.near) << name;
    EXPECT_GE(sizes.far, sizes.text) << name;
  }
}

TEST(LettersTest, AWindowHasNoLargerLettersThanItHasRoomFor) {
  // On a monitor of a telephone's size; ISO 9241-3 asks for 16 minutes of arc at least.
  const Monitor small{1366, 768, 10.1};
  const LetterSizes sizes = LettersFor(1366, 768, small.pixel_mm());
  EXPECT_NEAR(sizes.near, 768 / 37.0, 1e-9);
  EXPECT_GT(MinutesOfArc(sizes.near * small.pixel_mm()), 16);
  EXPECT_LT(LettersFor(640, 360, 0.1).near, 10);
}

TEST(LettersTest, SizesAreInProportionAndThoseOfAnUprightScreenToItsWidth) {
  const Monitor reference{1920, 1080, 24};
  const LetterSizes sizes = LettersFor(1920, 1080, reference.pixel_mm());
  EXPECT_EQ(sizes.scale, 1);
  EXPECT_NEAR(sizes.text, 23, 1e-9);
  EXPECT_NEAR(sizes.near, 16, 0.25);
  EXPECT_GE(sizes.far * reference.pixel_mm(), kFarCapital_mm);
  // This is the same monitor with four times the pixels.
  const LetterSizes fine = LettersFor(3840, 2160, reference.pixel_mm() / 2);
  EXPECT_NEAR(fine.text, 2 * sizes.text, 1e-9);
  EXPECT_NEAR(fine.near, 2 * sizes.near, 1e-9);
  EXPECT_EQ(LettersFor(1080, 1920, 0.5).scale, LettersFor(1080, 810, 0.5).scale);
}

TEST(LettersTest, AMonitorThatSaysNothingTrueOfItsSizeCountsAsTheReference) {
  EXPECT_NEAR(PixelOf_mm(1920, 1080, 531, 299), kReferencePixel_mm, 2e-4);
  EXPECT_NEAR(PixelOf_mm(1080, 1920, 299, 531), kReferencePixel_mm, 2e-4);
  const int nonsense[][2] = {{0, 0},       {-1, -1}, {16, 9},    {160, 90}, {1600, 900}, {160, 100},
                             {1600, 1000}, {1, 1},   {300, 300}, {531, 0},  {9000, 5000}};
  for (const auto& [width_mm, height_mm] : nonsense) {
    EXPECT_NEAR(PixelOf_mm(1920, 1080, width_mm, height_mm), kReferencePixel_mm, 1e-9)
        << width_mm << " x " << height_mm;
    EXPECT_NEAR(PixelOf_mm(3840, 2160, width_mm, height_mm), kReferencePixel_mm / 2, 1e-9);
    EXPECT_NEAR(PixelOf_mm(1080, 1920, width_mm, height_mm), kReferencePixel_mm, 1e-9);
  }
  EXPECT_GT(PixelOf_mm(0, 0, 0, 0), 0);
}

}  // namespace
}  // namespace enamel::station::render
