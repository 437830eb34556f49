#include "station/render/quality.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "station/render/pixel_rect.h"

namespace enamel::station::render {
namespace {

// Feeds whole windows of pictures that take `picture_s`; returns the resulting level.
size_t After(QualityGovernor& governor, int windows, double picture_s) {
  for (size_t i = 0; i < windows * QualityGovernor::kWindow; ++i) governor.Note(picture_s);
  return governor.level();
}

TEST(QualityGovernorTest, StepsDownUntilPicturesFitTheBudget) {
  QualityGovernor governor(0, 1.0 / 15);
  EXPECT_EQ(After(governor, 1, 0.2), 1u);
  EXPECT_EQ(After(governor, 1, 0.1), 2u);
  EXPECT_EQ(After(governor, 5, 0.05), 2u);
}

TEST(QualityGovernorTest, NeverLeavesTheLevelsThereAre) {
  QualityGovernor governor(0, 0.01);
  EXPECT_EQ(After(governor, 20, 1), kQualities.size() - 1);
  QualityGovernor easy(0, 0.01);
  EXPECT_EQ(After(easy, 20, 1e-5), 0u);
  EXPECT_EQ(QualityGovernor(99, 0.01).level(), kQualities.size() - 1);
}

TEST(QualityGovernorTest, OneSlowPictureChangesNothing) {
  QualityGovernor governor(1, 0.02);
  for (int i = 0; i < 300; ++i) EXPECT_FALSE(governor.Note(i % 30 == 7 ? 3.0 : 0.01));
  EXPECT_EQ(governor.level(), 1u);
}

TEST(QualityGovernorTest, DoesNotSwingBetweenTwoLevels) {
  QualityGovernor governor(1, 0.02);
  constexpr size_t kWindows = 4000;
  size_t changes = 0, low = 0;
  for (size_t i = 0; i < kWindows * QualityGovernor::kWindow; ++i) {
    changes += governor.Note(governor.level() <= 1 ? 0.05 : 0.001);
    low += governor.level() == 2;
  }
  EXPECT_LE(changes, 2 * (6 + kWindows / QualityGovernor::kLongestWait));
  EXPECT_GE(low, kWindows * QualityGovernor::kWindow * 98 / 100);
}

TEST(QualityGovernorTest, QualityReturnsHoweverOftenItHadToFall) {
  QualityGovernor governor(0, 0.02);
  for (int time = 0; time < 5; ++time) {
    EXPECT_EQ(After(governor, 10, 0.1), 3u) << time;
    EXPECT_EQ(After(governor, 200, 0.001), 0u) << time;
  }
}

TEST(QualityTest, NamesAreFoundAndOthersAreNot) {
  for (const Quality& q : kQualities) EXPECT_EQ(FindQuality(q.name), &q);
  EXPECT_EQ(FindQuality("finest"), nullptr);
}

TEST(QualityTest, TurningIsNeverMoreWorkThanRest) {
  for (const Quality& q : kQualities) {
    Quality turning = WhileTurning(q);
    EXPECT_LE(turning.occlusion_samples, q.occlusion_samples);
    EXPECT_LE(turning.scale, q.scale);
    EXPECT_TRUE(turning.coarse);
    EXPECT_FALSE(turning == q);
  }
}

TEST(PixelRectTest, ABallsRectangleHoldsEveryPointOfIt) {
  constexpr int kWidth = 1280, kHeight = 720;
  std::mt19937 random(7);
  std::uniform_real_distribution<float> place(-6, 6), size(0.05f, 2.5f), unit(-1, 1);
  glm::mat4 view = glm::lookAt(glm::vec3(18, -9, 14), glm::vec3(0), glm::vec3(0, 0, 1));
  glm::mat4 clip = glm::perspective(0.49f, 1280.0f / 720, 1.0f, 90.0f);
  for (int ball = 0; ball < 300; ++ball) {
    glm::vec3 middle(place(random), place(random), place(random));
    float radius = size(random);
    PixelRect rect = AroundBall(view, clip, kWidth, kHeight, middle, radius);
    for (int i = 0; i < 100; ++i) {
      glm::vec3 out(unit(random), unit(random), unit(random));
      glm::vec4 c = clip * view * glm::vec4(middle + glm::normalize(out) * radius, 1);
      float x = (c.x / c.w + 1) / 2 * kWidth, y = (c.y / c.w + 1) / 2 * kHeight;
      if (x < 0 || x >= kWidth || y < 0 || y >= kHeight) continue;
      EXPECT_GE(x, static_cast<float>(rect.x0));
      EXPECT_LE(x, static_cast<float>(rect.x1));
      EXPECT_GE(y, static_cast<float>(rect.y0));
      EXPECT_LE(y, static_cast<float>(rect.y1));
    }
  }
}

TEST(PixelRectTest, ABallRoundTheEyeIsTheWholePicture) {
  glm::mat4 clip = glm::perspective(0.49f, 1.5f, 1.0f, 90.0f);
  EXPECT_EQ(AroundBall(glm::mat4(1), clip, 300, 200, {0, 0, -1}, 2), PixelRect::Whole(300, 200));
}

TEST(PixelRectTest, NothingAddsNothingAndNothingGrowsOutOfThePicture) {
  PixelRect some{10, 20, 30, 40};
  EXPECT_EQ(PixelRect{}.Around(some), some);
  EXPECT_EQ(some.Around({}), some);
  EXPECT_TRUE(PixelRect{}.Grown(5, 100, 100).empty());
  EXPECT_EQ(some.Grown(15, 40, 100), (PixelRect{0, 5, 40, 55}));
  EXPECT_EQ(some.Within({20, 0, 50, 30}), (PixelRect{20, 20, 30, 30}));
  EXPECT_TRUE(some.Within({30, 20, 50, 40}).empty());
  EXPECT_FALSE(some.Meets({30, 20, 50, 40}));
  EXPECT_TRUE(some.Meets({29, 39, 50, 60}));
}

}  // namespace
}  // namespace enamel::station::render
