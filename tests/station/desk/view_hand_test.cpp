#include "station/desk/view_hand.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

namespace enamel::station::desk {
namespace {

render::Camera Fresh() { return render::Camera(glm::vec3(0), 8, 0, 1); }

void ExpectSameView(const render::Camera& a, const render::Camera& b) {
  EXPECT_LT(glm::length(a.TowardViewer() - b.TowardViewer()), 1e-5f);
  EXPECT_LT(glm::length(a.Right() - b.Right()), 1e-5f);
}

TEST(ViewHandTest, TurnsThePictureAsADragOverItDoes) {
  render::Camera by_hand = Fresh(), by_mouse = Fresh();
  ViewHand hand;
  const dvec3 start_m(1e-3, 2e-3, 3e-3), right(by_hand.Right()),
      up = glm::cross(dvec3(by_hand.TowardViewer()), right);
  hand.Look(true, start_m, by_hand);
  ExpectSameView(by_hand, Fresh());
  // The picture is 16 mm high: an eighth of it to the right, a sixteenth down.
  hand.Look(true, start_m + 2e-3 * right - 1e-3 * up, by_hand);
  by_mouse.Orbit(2.0f / 16, 1.0f / 16);
  ExpectSameView(by_hand, by_mouse);
}

TEST(ViewHandTest, WhatTheHandDoesBetweenTwoHoldsTurnsNothing) {
  render::Camera camera = Fresh();
  ViewHand hand;
  hand.Look(true, {0, 0, 0}, camera);
  hand.Look(false, {5e-3, 0, 0}, camera);
  hand.Look(true, {9e-3, 4e-3, 0}, camera);
  ExpectSameView(camera, Fresh());
}

// The mouse drags by shares of the picture's height: 4 radians for all of it.
void TurnBy(float degrees, render::Camera& camera) {
  camera.Orbit(-degrees * std::numbers::pi_v<float> / 180 / 4, 0);
}

TEST(ViewHandTest, TheHandsRightIsThePicturesRightButForAnEighthOfATurn) {
  ViewHand hand;
  render::Camera camera = Fresh();
  for (const auto& [view, quarters] : {std::pair{render::View::kOblique, 0},
                                       {render::View::kOcclusal, 0},
                                       {render::View::kBuccal, 2},
                                       {render::View::kMesial, 1}}) {
    camera.SetView(view);
    EXPECT_EQ(hand.Quarters(false, camera), quarters) << static_cast<int>(view);
    const float right = camera.Turned(), hands = static_cast<float>(quarters) * 90;
    EXPECT_LE(std::abs(std::remainder(right * 180 / std::numbers::pi_v<float> - hands, 360)), 45);
  }
}

TEST(ViewHandTest, AtABorderBetweenTwoQuartersTheHandStaysAsItWas) {
  ViewHand hand;
  render::Camera camera = Fresh();
  camera.SetView(render::View::kOcclusal);
  TurnBy(50, camera);
  EXPECT_EQ(hand.Quarters(false, camera), 0);
  TurnBy(10, camera);
  EXPECT_EQ(hand.Quarters(true, camera), 0) << "while the picture turns";
  EXPECT_EQ(hand.Quarters(false, camera), 1);
  TurnBy(-20, camera);
  EXPECT_EQ(hand.Quarters(false, camera), 1);
  TurnBy(-10, camera);
  EXPECT_EQ(hand.Quarters(false, camera), 0);
}

}  // namespace
}  // namespace enamel::station::desk
