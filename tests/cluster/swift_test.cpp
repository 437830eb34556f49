#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "server/s3/s3_client.h"
#include "server/storage/keys/key_bucket.h"

// The client against a real S3 store: OpenStack Swift with its S3 API, which with_swift.sh starts.
namespace enamel::s3 {
namespace {

std::string Environment(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

class SwiftTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (Environment("ENAMEL_S3_ENDPOINT").empty())
      GTEST_SKIP() << "ENAMEL_S3_ENDPOINT names no store; run with_swift.sh";
    client_ = Make(Environment("ENAMEL_S3_BUCKET"), Environment("AWS_SECRET_ACCESS_KEY"));
  }
  static std::unique_ptr<S3Client> Make(const std::string& bucket, const std::string& secret) {
    S3Options options;
    options.endpoint = Environment("ENAMEL_S3_ENDPOINT");
    options.region = Environment("ENAMEL_S3_REGION");
    options.bucket = bucket;
    options.credentials = {Environment("AWS_ACCESS_KEY_ID"), secret};
    auto client = S3Client::Make(options);
    EXPECT_TRUE(client.ok()) << client.status().message();
    return std::move(client).value();
  }
  std::unique_ptr<S3Client> client_;
};

const Bytes kBody = {1, 2, 3, 4};
const Sha256 kHash = HashSha256(kBody);

TEST_F(SwiftTest, WhatIsPutIsGotUntilItIsDeleted) {
  EXPECT_EQ(client_->Get("a/b", kHash, kBody.size()).status().code(), Code::kNotFound);
  EXPECT_EQ(client_->Head("a/b").code(), Code::kNotFound);
  const Status put = client_->Put("a/b", kBody);
  ASSERT_TRUE(put.ok()) << put.message();
  EXPECT_TRUE(client_->Head("a/b").ok());
  const auto got = client_->Get("a/b", kHash, kBody.size());
  ASSERT_TRUE(got.ok()) << got.status().message();
  EXPECT_EQ(*got, kBody);
  const Status deleted = client_->Delete("a/b");
  EXPECT_TRUE(deleted.ok()) << deleted.message();
  EXPECT_TRUE(client_->Delete("a/b").ok()) << "absent: nothing to do";
  EXPECT_EQ(client_->Get("a/b", kHash, kBody.size()).status().code(), Code::kNotFound);
}

TEST_F(SwiftTest, OtherBytesThanTheNameAreTold) {
  ASSERT_TRUE(client_->Put("other", kBody).ok());
  EXPECT_EQ(client_->Get("other", HashSha256({}), kBody.size()).status().code(), Code::kStorage);
  EXPECT_TRUE(client_->Delete("other").ok());
}

TEST_F(SwiftTest, LargeAndEmptyObjectsGoThroughBothWays) {
  Bytes body(8 << 20);
  for (size_t i = 0; i < body.size(); ++i) body[i] = static_cast<uint8_t>(i * 2654435761u >> 13);
  for (const Bytes& each : {body, Bytes()}) {
    const Status put = client_->Put("sized", each);
    ASSERT_TRUE(put.ok()) << put.message();
    const auto got = client_->Get("sized", HashSha256(each), each.size());
    ASSERT_TRUE(got.ok()) << got.status().message();
    EXPECT_TRUE(*got == each);
  }
  EXPECT_TRUE(client_->Delete("sized").ok());
}

TEST_F(SwiftTest, KeysMayHaveAnySigns) {
  for (const std::string& key :
       {std::string("s/a b+c%20&d=e"), std::string("s/\u00fc\u1234~'()*")}) {
    const Status put = client_->Put(key, kBody);
    ASSERT_TRUE(put.ok()) << put.message();
    EXPECT_EQ(*client_->Get(key, kHash, kBody.size()), kBody);
    const auto page = client_->List(key);
    ASSERT_TRUE(page.ok()) << page.status().message();
    ASSERT_EQ(page->objects.size(), 1u);
    EXPECT_EQ(page->objects[0].key, key);
    EXPECT_EQ(page->objects[0].bytes, kBody.size());
    EXPECT_GT(page->objects[0].modified_ms, 1'600'000'000'000);
    EXPECT_TRUE(client_->Delete(key).ok());
  }
}

// Swift lists a thousand at a time.
TEST_F(SwiftTest, ListGoesOnFromPageToPage) {
  constexpr int kThreads = 4, kEach = 251;
  auto all = [&](auto&& each) {
    std::vector<std::jthread> threads;
    for (int t = 0; t < kThreads; ++t) {
      threads.emplace_back([&, t] {
        for (int n = 0; n < kEach; ++n) each("l/" + std::to_string(t) + "-" + std::to_string(n));
      });
    }
  };
  all([&](const std::string& key) { EXPECT_TRUE(client_->Put(key, kBody).ok()) << key; });
  std::vector<std::string> keys;
  std::string next;
  int pages = 0;
  do {
    const auto page = client_->List("l/", next);
    ASSERT_TRUE(page.ok()) << page.status().message();
    for (const ListedObject& object : page->objects) keys.push_back(object.key);
    next = page->next;
  } while (!next.empty() && ++pages < 9);
  EXPECT_EQ(keys.size(), static_cast<size_t>(kThreads * kEach));
  EXPECT_EQ(pages, 1);
  EXPECT_TRUE(std::ranges::is_sorted(keys));
  EXPECT_EQ(std::ranges::adjacent_find(keys), keys.end());
}

TEST_F(SwiftTest, WrongSecretAndMissingBucketAreTold) {
  const Status secret = Make(Environment("ENAMEL_S3_BUCKET"), "wrong")->Put("a", kBody);
  EXPECT_EQ(secret.code(), Code::kStorage);
  EXPECT_NE(secret.message().find("SignatureDoesNotMatch"), std::string::npos) << secret.message();
  const Status bucket =
      Make("absent", Environment("AWS_SECRET_ACCESS_KEY"))->Get("a", kHash, kBody.size()).status();
  EXPECT_EQ(bucket.code(), Code::kStorage);
  EXPECT_NE(bucket.message().find("NoSuchBucket"), std::string::npos) << bucket.message();
}

TEST_F(SwiftTest, BucketThatKeepsVersionsIsNoneForKeys) {
  const Status plain = server::MustForgetWhatIsDeleted(*client_);
  EXPECT_TRUE(plain.ok()) << plain.message();
  const auto versioned = Make("versioned", Environment("AWS_SECRET_ACCESS_KEY"));
  const Status kept = server::MustForgetWhatIsDeleted(*versioned);
  EXPECT_EQ(kept.code(), Code::kForbidden) << kept.message();
}

}  // namespace
}  // namespace enamel::s3
