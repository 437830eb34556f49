#include "station/uplink/remark_box.h"

#include <gtest/gtest.h>

namespace enamel::station {
namespace {

protocol::Remark Remark(uint64_t id, const std::string& text = "stop") {
  return {id, text, "Ada", 0};
}

class RemarkBoxTest : public testing::Test {
 protected:
  RemarkBoxTest() { box_.Begin(attempt_); }
  RemarkBox box_;
  const Uuid attempt_ = Uuid::New();
};

TEST_F(RemarkBoxTest, EachIsGivenOutOnceHoweverOftenItComes) {
  for (int again = 0; again < 3; ++again) {
    box_.Arrived(attempt_, Remark(5, "one"));
    box_.Arrived(attempt_, Remark(6, "two"));
  }
  EXPECT_EQ(box_.Next(attempt_)->text, "one");
  EXPECT_EQ(box_.Next(attempt_)->text, "one") << "until it was shown";
  EXPECT_EQ(box_.shown(attempt_), 0u);
  box_.Shown(attempt_, 5);
  EXPECT_EQ(box_.shown(attempt_), 5u);
  EXPECT_EQ(box_.Next(attempt_)->text, "two");
  box_.Shown(attempt_, 6);
  box_.Arrived(attempt_, Remark(5));
  box_.Arrived(attempt_, Remark(6));
  EXPECT_FALSE(box_.Next(attempt_));
  EXPECT_EQ(box_.shown(attempt_), 6u);
}

TEST_F(RemarkBoxTest, WhatDoesNotFitComesAgainLater) {
  for (uint64_t id = 1; id <= protocol::kMaxRemarks + 1; ++id) box_.Arrived(attempt_, Remark(id));
  for (uint64_t id = 1; id <= protocol::kMaxRemarks; ++id) {
    ASSERT_EQ(box_.Next(attempt_)->id, id);
    box_.Shown(attempt_, id);
  }
  EXPECT_FALSE(box_.Next(attempt_));
  box_.Arrived(attempt_, Remark(protocol::kMaxRemarks + 1));
  EXPECT_TRUE(box_.Next(attempt_));
}

TEST_F(RemarkBoxTest, AnotherAttemptsRemarksAreNobodysHere) {
  const Uuid other = Uuid::New();
  box_.Arrived(other, Remark(1));
  EXPECT_FALSE(box_.Next(other));
  EXPECT_FALSE(box_.Next(attempt_));
  box_.Arrived(attempt_, Remark(2));
  box_.Begin(other);
  EXPECT_FALSE(box_.Next(attempt_));
  box_.Begin(attempt_);
  EXPECT_FALSE(box_.Next(attempt_)) << "it comes again, as it was not shown";
  EXPECT_EQ(box_.shown(attempt_), 0u);
}

TEST_F(RemarkBoxTest, ResumedAttemptKeepsWhatWasShown) {
  box_.Arrived(attempt_, Remark(3));
  box_.Shown(attempt_, 3);
  box_.Begin(attempt_);
  EXPECT_EQ(box_.shown(attempt_), 3u);
  box_.Arrived(attempt_, Remark(3));
  EXPECT_FALSE(box_.Next(attempt_));
}

}  // namespace
}  // namespace enamel::station
