#include "server/storage/keys/key_bucket.h"

#include <gtest/gtest.h>

#include "tests/support/s3_stand_in.h"

namespace enamel::server {
namespace {

using Fault = test::S3StandIn::Fault;

class KeyBucketTest : public ::testing::Test {
 protected:
  Status Checked() {
    s3::S3Options options = s3_.options();
    options.time.pause = [](auto) {};
    return MustForgetWhatIsDeleted(**s3::S3Client::Make(options));
  }
  test::S3StandIn s3_;
};

TEST_F(KeyBucketTest, BucketThatForgetsIsTaken) {
  const Status status = Checked();
  EXPECT_TRUE(status.ok()) << status.message();
}

TEST_F(KeyBucketTest, BucketThatKeepsVersionsIsRefused) {
  s3_.SetVersioning("Enabled");
  const Status status = Checked();
  EXPECT_EQ(status.code(), Code::kForbidden);
  EXPECT_NE(status.message().find("without versioning"), std::string::npos) << status.message();
}

TEST_F(KeyBucketTest, BucketThatKeptVersionsOnceIsRefused) {
  s3_.SetVersioning("Suspended");
  EXPECT_EQ(Checked().code(), Code::kForbidden);
}

TEST_F(KeyBucketTest, BucketThatMayBeLockedIsRefused) {
  s3_.SetLocked(true);
  const Status status = Checked();
  EXPECT_EQ(status.code(), Code::kForbidden);
  EXPECT_NE(status.message().find("object lock"), std::string::npos) << status.message();
}

TEST_F(KeyBucketTest, BucketThatDoesNotSayIsRefused) {
  s3_.FailNext(Fault::kForbidden, -1);
  EXPECT_EQ(Checked().code(), Code::kStorage);
  s3_.FailNext(Fault::kInternal, -1);
  EXPECT_EQ(Checked().code(), Code::kUnavailable);
}

}  // namespace
}  // namespace enamel::server
