#include "station/lab/grades/hand_signs.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>

namespace enamel::station::lab {
namespace {

TEST(HandSignsTest, RocOfNumbersThatOneCanCount) {
  // Of 4 x 4 pairs the program's is higher in 3 + 3 + 4 + 4, and equal in one.
  const SignRoc roc = RocOf("x", {1, 2, 3, 6}, {4, 5, 6, 7});
  EXPECT_NEAR(roc.area, (3 + 3 + 3.5 + 4) / 16.0, 1e-12);
  EXPECT_EQ(roc.people, 4u);
  // At 5 % none of the people may be mistaken for a program: one of four is above 6.
  EXPECT_EQ(roc.found_at_5, 0.25);
  EXPECT_GT(roc.standard_error, 0);
}

TEST(HandSignsTest, WhatPartsAllHasAreaOneAndWhatPartsNothingOneHalf) {
  EXPECT_EQ(RocOf("x", {1, 2, 3}, {4, 5, 6}).area, 1);
  EXPECT_EQ(RocOf("x", {1, 2, 3}, {4, 5, 6}).found_at_5, 1);
  EXPECT_EQ(RocOf("x", {4, 5, 6}, {1, 2, 3}).area, 0);
  EXPECT_EQ(RocOf("x", {4, 5, 6}, {1, 2, 3}).found_at_5, 1) << "on the other side";
  EXPECT_EQ(RocOf("x", {1, 1, 1}, {1, 1}).area, 0.5);
}

std::vector<dvec3> Straight(double mm_per_s, double tremor_um) {
  std::vector<dvec3> way(kSecond);
  for (size_t i = 0; i < kSecond; ++i) {
    const double t_s = 1e-3 * static_cast<double>(i);
    way[i] = dvec3(1e-3 * mm_per_s * t_s,
                   1e-6 * tremor_um * std::sin(2 * std::numbers::pi * 10 * t_s), 0);
  }
  return way;
}

TEST(HandSignsTest, SecondOfMotionHasItsTremorAndItsDirections) {
  HandSigns signs;
  ASSERT_TRUE(SignsOf(Straight(3, 50).data(), signs));
  EXPECT_NEAR(signs.tremor_um, 50 / std::sqrt(2.0), 2);
  ASSERT_TRUE(SignsOf(Straight(3, 1e-3).data(), signs));
  EXPECT_NEAR(signs.direction_bits, 0, 1e-9) << "one direction only";
  EXPECT_NEAR(signs.pause_percent, 0, 1e-9);
}

TEST(HandSignsTest, HandThatRestsSaysNothing) {
  HandSigns signs;
  EXPECT_FALSE(SignsOf(Straight(0.4, 0).data(), signs));
}

TEST(HandSignsTest, TheDocumentIsTheSchemas) {
  std::ifstream file(ENAMEL_SOURCE_DIR "/schemas/golden/lab_hand_signs.json");
  const std::string golden(std::istreambuf_iterator<char>(file), {});
  EXPECT_EQ(boost::json::value(HandSignsJson({{"tremor, 8 to 12 Hz (um)", 17, 111, 0.25, 0.125, 0.5,
                                               0.75, 1, 3.0, 0.0625, 0.5}})),
            boost::json::parse(golden));
}

// Recordings kept with the project: one person, one path, three times.
TEST(HandSignsTest, CopiesLieNearerThanWhoDoesTheSameAgain) {
  HandSignsOptions options;
  options.people = ENAMEL_SHARED_DATA "/motion";
  if (!std::filesystem::exists(options.people)) GTEST_SKIP() << "skipped: no shared data";
  options.operators = {"dentist"};
  options.seconds = 10;
  const auto rows = MeasureHandSigns(options);
  ASSERT_TRUE(rows.ok()) << rows.status().message();
  ASSERT_EQ(rows->size(), 7u);
  const SignRoc& copies = (*rows)[5];
  EXPECT_EQ(copies.people, 15u) << "three pairs of five parts";
  EXPECT_EQ(copies.programs, 45u);
  EXPECT_LT(copies.area, 0.2);
  const auto json = HandSignsJson(*rows);
  EXPECT_EQ(json.at("rows").as_array().size(), 7u);
  EXPECT_EQ(json.at("rows").at(5).at("area").to_number<double>(), copies.area);
}

TEST(HandSignsTest, WithoutRecordingsItSaysWhatWasExpected) {
  HandSignsOptions options;
  options.people = "/nowhere";
  const auto none = MeasureHandSigns(options);
  EXPECT_EQ(none.status().code(), Code::kNotFound);
  EXPECT_NE(none.status().message().find("px_m"), std::string::npos) << none.status().message();
}

}  // namespace
}  // namespace enamel::station::lab
