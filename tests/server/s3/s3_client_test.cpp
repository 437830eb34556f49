#include "server/s3/s3_client.h"

#include <gtest/gtest.h>

#include <thread>

#include "tests/support/s3_stand_in.h"

// Against a store on loopback that fails on request. Pauses are counted instead of waited.
namespace enamel::s3 {
namespace {

using Fault = test::S3StandIn::Fault;
using std::chrono::milliseconds;

class S3ClientTest : public ::testing::Test {
 protected:
  S3Options Options() {
    S3Options out = store_.options();
    out.time.steady = [this] { return now_; };
    out.time.pause = [this](milliseconds time) {
      pauses_.push_back(time);
      now_ += time;
    };
    return out;
  }
  std::unique_ptr<S3Client> Make(const S3Options& options) {
    auto client = S3Client::Make(options);
    EXPECT_TRUE(client.ok()) << client.status().message();
    return std::move(client).value();
  }
  std::unique_ptr<S3Client> Make() { return Make(Options()); }
  // Neither secret nor signature; what to do.
  void ExpectTold(const Status& status, Code code, const std::string& part) {
    EXPECT_EQ(status.code(), code) << status.message();
    EXPECT_NE(status.message().find(part), std::string::npos) << status.message();
    EXPECT_NE(status.message().find(';'), std::string::npos) << status.message();
    for (const std::string& secret : {store_.credentials().secret_key, std::string("Signature=")}) {
      EXPECT_EQ(status.message().find(secret), std::string::npos) << status.message();
    }
  }
  void TearDown() override { EXPECT_EQ(store_.complaints(), std::vector<std::string>{}); }

  test::S3StandIn store_;
  std::chrono::steady_clock::time_point now_{};
  std::vector<milliseconds> pauses_;
};

const Bytes kBody = {1, 2, 3, 4, 5, 6, 7, 8};
const Sha256 kHash = HashSha256(kBody);

TEST_F(S3ClientTest, WhatIsPutIsGotUntilItIsDeleted) {
  auto client = Make();
  EXPECT_EQ(client->Get("a/b", kHash, kBody.size()).status().code(), Code::kNotFound);
  EXPECT_EQ(client->Head("a/b").code(), Code::kNotFound);
  ASSERT_TRUE(client->Put("a/b", kBody).ok());
  EXPECT_TRUE(client->Head("a/b").ok());
  EXPECT_EQ(*client->Get("a/b", kHash, kBody.size()), kBody);
  EXPECT_TRUE(client->Put("empty", {}).ok());
  EXPECT_EQ(*client->Get("empty", HashSha256({}), 0), Bytes{});
  EXPECT_TRUE(client->Delete("a/b").ok());
  EXPECT_TRUE(client->Delete("a/b").ok()) << "absent: nothing to do";
  EXPECT_EQ(client->Get("a/b", kHash, kBody.size()).status().code(), Code::kNotFound);
  EXPECT_EQ(store_.connections(), 1) << "one after the other";
}

TEST_F(S3ClientTest, CountsRequestsAndCallsThatFailed) {
  auto client = Make();
  ASSERT_TRUE(client->Put("a", kBody).ok());
  EXPECT_EQ(client->Get("b", kHash, kBody.size()).status().code(), Code::kNotFound);
  EXPECT_EQ(client->figures().requests, 2u);
  EXPECT_EQ(client->figures().failed, 0u) << "a missing object is an answer";
  store_.FailNext(Fault::kSlowDown, 2);
  ASSERT_TRUE(client->Put("a", kBody).ok());
  EXPECT_EQ(client->figures().requests, 5u) << "three tries";
  EXPECT_EQ(client->figures().failed, 0u);
  store_.FailNext(Fault::kForbidden, 1);
  EXPECT_FALSE(client->Put("a", kBody).ok());
  const S3Figures figures = client->figures();
  EXPECT_EQ(figures.failed, 1u);
  uint64_t calls = 0;
  for (const uint64_t each : figures.calls.each) calls += each;
  EXPECT_EQ(calls, 4u);
  // Time stands still here but for pauses.
  EXPECT_NEAR(figures.calls.sum_s, std::chrono::duration<double>(pauses_[0] + pauses_[1]).count(),
              1e-9);
}

TEST_F(S3ClientTest, SaysHowLongItsOldestCallWaits) {
  S3Options options = Options();
  S3Client* asked = nullptr;
  double waited_s = 0;
  options.time.pause = [&](milliseconds) {
    now_ += std::chrono::seconds(3);
    waited_s = asked->figures().oldest_wait_s;
  };
  auto client = Make(options);
  asked = client.get();
  store_.FailNext(Fault::kSlowDown, 1);
  ASSERT_TRUE(client->Put("a", kBody).ok());
  EXPECT_EQ(waited_s, 3);
  EXPECT_EQ(client->figures().oldest_wait_s, 0);
}

TEST_F(S3ClientTest, KeysMayHaveAnySigns) {
  auto client = Make();
  for (const std::string& key : {std::string("a b+c%20&d=e"), std::string("x/../y//z/."),
                                 std::string("\u00fc\u1234~'()*")}) {
    ASSERT_TRUE(client->Put(key, kBody).ok()) << key;
    EXPECT_TRUE(store_.objects().contains(key)) << key;
    EXPECT_EQ(*client->Get(key, kHash, kBody.size()), kBody);
    EXPECT_EQ(client->List(key)->objects.at(0).key, key);
  }
}

TEST_F(S3ClientTest, LargeObjectsGoThroughBothWays) {
  Bytes body(9 << 20);
  for (size_t i = 0; i < body.size(); ++i) body[i] = static_cast<uint8_t>(i * 2654435761u >> 13);
  auto client = Make();
  ASSERT_TRUE(client->Put("large", body).ok());
  const auto got = client->Get("large", HashSha256(body), body.size());
  ASSERT_TRUE(got.ok()) << got.status().message();
  EXPECT_TRUE(*got == body);
}

TEST_F(S3ClientTest, ListGoesOnFromPageToPage) {
  store_.SetPageSize(2);
  auto client = Make();
  for (const char* key : {"p/1", "p/2", "p/3", "p/4", "p/5", "q/1"}) {
    ASSERT_TRUE(client->Put(key, kBody).ok());
  }
  std::vector<std::string> keys;
  std::string next;
  int pages = 0;
  do {
    const auto page = client->List("p/", next);
    ASSERT_TRUE(page.ok()) << page.status().message();
    for (const ListedObject& object : page->objects) {
      keys.push_back(object.key);
      EXPECT_EQ(object.bytes, kBody.size());
    }
    next = page->next;
    ++pages;
  } while (!next.empty() && pages < 9);
  EXPECT_EQ(keys, (std::vector<std::string>{"p/1", "p/2", "p/3", "p/4", "p/5"}));
  EXPECT_EQ(pages, 3);
}

TEST_F(S3ClientTest, ListThatRepeatsItselfEndsWithAnError) {
  store_.SetPageSize(2);
  auto client = Make();
  for (const char* key : {"p/1", "p/2", "p/3"}) ASSERT_TRUE(client->Put(key, kBody).ok());
  std::vector<std::string> keys;
  const auto list = [&] {
    keys.clear();
    return client->ListEach("p/", [&](ListedObject& object) { keys.push_back(object.key); });
  };
  ASSERT_TRUE(list().ok());
  EXPECT_EQ(keys, (std::vector<std::string>{"p/1", "p/2", "p/3"}));
  for (const Fault fault : {Fault::kSamePage, Fault::kEmptyPage}) {
    store_.FailNext(fault, -1);
    const int before = store_.requests();
    ExpectTold(list(), Code::kStorage, "repeats itself");
    EXPECT_LE(store_.requests() - before, 102);
    EXPECT_LE(keys.size(), 2u);
  }
}

TEST_F(S3ClientTest, ProxysPageOfNotFoundDoesNotProveThatAnObjectIsGone) {
  auto client = Make();
  ASSERT_TRUE(client->Put("a", kBody).ok());
  store_.FailNext(Fault::kProxyNotFound, -1);
  ExpectTold(client->Delete("a"), Code::kUnavailable, "something other than an S3 store");
  EXPECT_EQ(client->Head("a").code(), Code::kUnavailable);
  EXPECT_EQ(client->Get("a", kHash, kBody.size()).status().code(), Code::kUnavailable);
  store_.FailNext(Fault::kProxyNotFound, 2);
  EXPECT_TRUE(client->Delete("a").ok());
  EXPECT_TRUE(store_.objects().empty());
}

struct Case {
  const char* name;
  Fault fault;
};

class WhatPasses : public S3ClientTest, public ::testing::WithParamInterface<Case> {};

TEST_P(WhatPasses, IsTriedAgainWithLongerPausesAndSurvived) {
  auto client = Make();
  ASSERT_TRUE(client->Put("a", kBody).ok());
  for (const char* method : {"PUT", "GET"}) {
    const int before = store_.requests();
    pauses_.clear();
    store_.FailNext(GetParam().fault, 3, method);
    if (std::string(method) == "PUT") {
      const Status put = client->Put("a", kBody);
      EXPECT_TRUE(put.ok()) << put.message();
    } else {
      const auto got = client->Get("a", kHash, kBody.size());
      EXPECT_TRUE(got.ok() && *got == kBody) << got.status().message();
    }
    EXPECT_EQ(store_.requests() - before, 4);
    // libcurl replaces a lost kept connection at once.
    ASSERT_GE(pauses_.size(), 2u);
    ASSERT_LE(pauses_.size(), 3u);
    for (size_t n = 0; n < pauses_.size(); ++n) {
      EXPECT_GE(pauses_[n], milliseconds(50 << n));
      EXPECT_LE(pauses_[n], milliseconds(100 << n));
    }
  }
}

TEST_P(WhatPasses, IsToldWhenItDoesNotPass) {
  auto client = Make();
  store_.FailNext(GetParam().fault, -1);
  ExpectTold(client->Put("a", kBody), Code::kUnavailable, "PUT a at http://127.0.0.1");
  EXPECT_EQ(store_.requests(), 5);
  ExpectTold(client->Get("a", kHash, kBody.size()).status(), Code::kUnavailable,
             "GET a at http://127.0.0.1");
  ExpectTold(client->List("").status(), Code::kUnavailable, "bucket blobs");
  ExpectTold(client->Delete("a"), Code::kUnavailable, "DELETE a");
  // Which sends nothing that could come too slowly.
  if (GetParam().fault != Fault::kSlowRequest)
    EXPECT_EQ(client->Head("a").code(), Code::kUnavailable);
  store_.FailNext(Fault::kNone, 0);
  EXPECT_TRUE(client->Put("a", kBody).ok());
}

INSTANTIATE_TEST_SUITE_P(
    Faults, WhatPasses,
    ::testing::Values(Case{"Internal", Fault::kInternal}, Case{"SlowDown", Fault::kSlowDown},
                      Case{"SlowRequest", Fault::kSlowRequest}, Case{"Aborted", Fault::kAborted},
                      Case{"Gateway", Fault::kGateway}, Case{"ResetInBody", Fault::kResetInBody},
                      Case{"ResetAfterwards", Fault::kResetAfterwards}),
    [](const auto& of) { return std::string(of.param.name); });

TEST_F(S3ClientTest, RefusalIsToldAtOnce) {
  auto client = Make();
  store_.FailNext(Fault::kForbidden, -1);
  ExpectTold(client->Put("a", kBody), Code::kStorage, "403 AccessDenied");
  ExpectTold(client->Get("a", kHash, kBody.size()).status(), Code::kStorage, "the access key may");
  EXPECT_EQ(store_.requests(), 2);
  EXPECT_TRUE(pauses_.empty());
}

TEST_F(S3ClientTest, FullStoreIsToldAtOnce) {
  auto client = Make();
  store_.FailNext(Fault::kFull, 1);
  ExpectTold(client->Put("a", kBody), Code::kStorage, "make room");
  store_.FailNext(Fault::kQuota, 1);
  ExpectTold(client->Put("a", kBody), Code::kStorage, "make room");
  EXPECT_EQ(store_.requests(), 2);
  EXPECT_TRUE(client->Put("a", kBody).ok()) << "there is room again";
}

TEST_F(S3ClientTest, WrongBytesAreAskedForOnceMore) {
  auto client = Make();
  ASSERT_TRUE(client->Put("a", kBody).ok());
  store_.FailNext(Fault::kWrongBytes, 1, "GET");
  EXPECT_EQ(*client->Get("a", kHash, kBody.size()), kBody);
  EXPECT_EQ(store_.requests("GET"), 2);
  store_.FailNext(Fault::kWrongBytes, -1, "GET");
  ExpectTold(client->Get("a", kHash, kBody.size()).status(), Code::kStorage, kHash.Hex());
  EXPECT_EQ(store_.requests("GET"), 4);
}

TEST_F(S3ClientTest, LargerObjectThanAdmittedIsNotTakenIntoMemory) {
  S3Options options = Options();
  options.limits.object_bytes = 1000;
  auto client = Make(options);
  store_.SetObject("large", Bytes(1 << 20));
  const Sha256 hash = HashSha256(Bytes(1 << 20));
  ExpectTold(client->Get("large", hash, 1000).status(), Code::kStorage, "at most 1000 bytes");
  EXPECT_TRUE(client->Get("large", hash, 1 << 20).ok());
  EXPECT_EQ(client->Put("large", Bytes(1001)).code(), Code::kTooLarge);
  EXPECT_TRUE(client->Put("just", Bytes(1000)).ok());
}

TEST_F(S3ClientTest, OutageIsToldAndItsEndIsFound) {
  auto client = Make();
  ASSERT_TRUE(client->Put("a", kBody).ok());
  store_.Stop();
  ExpectTold(client->Put("b", kBody), Code::kUnavailable, "check that the store runs");
  ExpectTold(client->Get("a", kHash, kBody.size()).status(), Code::kUnavailable,
             "check that the store runs");
  EXPECT_EQ(pauses_.size(), 8u);
  store_.Start();
  EXPECT_EQ(*client->Get("a", kHash, kBody.size()), kBody);
  EXPECT_TRUE(client->Put("b", kBody).ok());
}

TEST_F(S3ClientTest, StoreThatComesBackDuringThePausesIsNotNoticed) {
  S3Options options = Options();
  options.time.pause = [&](milliseconds time) {
    pauses_.push_back(time);
    if (pauses_.size() == 2) store_.Start();
  };
  auto client = Make(options);
  store_.Stop();
  EXPECT_TRUE(client->Put("a", kBody).ok());
  EXPECT_EQ(pauses_.size(), 2u);
}

TEST_F(S3ClientTest, CallEndsWithItsTimeHoweverManyTriesAreLeft) {
  S3Options options = Options();
  options.limits.tries = 1000;
  options.limits.call = milliseconds(5'000);
  auto client = Make(options);
  store_.FailNext(Fault::kSlowDown, -1);
  ExpectTold(client->Put("a", kBody), Code::kUnavailable, "SlowDown");
  EXPECT_LE(now_.time_since_epoch(), milliseconds(5'000));
  EXPECT_GE(now_.time_since_epoch(), milliseconds(3'000));
}

TEST_F(S3ClientTest, SilentStoreIsLeftAfterItsTime) {
  S3Options options = Options();
  options.time = {};
  options.limits.call = milliseconds(300);
  auto client = Make(options);
  store_.FailNext(Fault::kSilence, -1);
  ExpectTold(client->Put("a", kBody), Code::kUnavailable, "check that the store runs");
  EXPECT_EQ(store_.requests(), 1);
}

TEST_F(S3ClientTest, ManyThreadsAskAtOnce) {
  auto client = Make();
  std::vector<std::jthread> threads;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&, i] {
      for (int n = 0; n < 20; ++n) {
        const Bytes body(100 + n, static_cast<uint8_t>(i));
        const std::string key = std::to_string(i) + "-" + std::to_string(n);
        EXPECT_TRUE(client->Put(key, body).ok());
        EXPECT_EQ(*client->Get(key, HashSha256(body), body.size()), body);
      }
    });
  }
  threads.clear();
  EXPECT_EQ(store_.objects().size(), 160u);
  EXPECT_LE(store_.connections(), 8) << "connections are used again";
}

TEST_F(S3ClientTest, BucketSaysWhetherItKeepsVersionsOrLocks) {
  auto client = Make();
  EXPECT_EQ(*client->GetBucketVersioning(), Versioning::kNever);
  EXPECT_FALSE(*client->GetObjectLockConfiguration());
  store_.SetVersioning("Suspended");
  store_.SetLocked(true);
  EXPECT_EQ(*client->GetBucketVersioning(), Versioning::kSuspended);
  EXPECT_TRUE(*client->GetObjectLockConfiguration());
  for (const Fault unknown : {Fault::kNotImplemented, Fault::kNotAllowed}) {
    store_.FailNext(unknown, -1);
    EXPECT_EQ(*client->GetBucketVersioning(), Versioning::kNever);
    EXPECT_FALSE(*client->GetObjectLockConfiguration());
  }
  store_.FailNext(Fault::kForbidden, -1);
  EXPECT_EQ(client->GetBucketVersioning().status().code(), Code::kStorage);
  EXPECT_EQ(client->GetObjectLockConfiguration().status().code(), Code::kStorage);
}

TEST_F(S3ClientTest, MissingBucketIsNoMissingObject) {
  S3Options options = Options();
  options.bucket = "other";
  auto client = Make(options);
  ExpectTold(client->Get("a", kHash, kBody.size()).status(), Code::kStorage, "no bucket");
  ExpectTold(client->List("").status(), Code::kStorage, "no bucket");
}

TEST(S3ClientRefusalTest, WhatIsSignedWronglyIsToldWithWhatToDo) {
  test::S3StandIn store;
  auto refusal = [&](s3::Credentials who, std::chrono::hours off) {
    S3Options options = store.options();
    options.credentials = std::move(who);
    options.time.now = [off] { return std::chrono::system_clock::now() + off; };
    return (*S3Client::Make(options))->Put("a", kBody);
  };
  using std::chrono::hours;
  EXPECT_TRUE(refusal(store.credentials(), hours(0)).ok());
  s3::Credentials lent = store.credentials();
  lent.session_token = "IQoJb3JpZ2luX2VjEXAMPLE==";
  EXPECT_TRUE(refusal(lent, hours(0)).ok()) << "the token is among what is signed";
  const Status wrong = refusal({store.credentials().access_key, "another"}, hours(0));
  EXPECT_EQ(wrong.code(), Code::kStorage);
  EXPECT_NE(wrong.message().find("secret are those of the store"), std::string::npos)
      << wrong.message();
  const Status late = refusal(store.credentials(), hours(1));
  EXPECT_NE(late.message().find("clock"), std::string::npos) << late.message();
}

TEST(S3ClientOptionsTest, WhatCannotBeUsedIsRefusedBeforeAnythingIsAsked) {
  S3Options good;
  good.endpoint = "https://s3.example.org:9000/";
  good.bucket = "enamel-blobs";
  good.credentials = {"test:tester", "testing"};
  ASSERT_TRUE(S3Client::Make(good).ok()) << S3Client::Make(good).status().message();
  EXPECT_EQ((*S3Client::Make(good))->Where(), "https://s3.example.org:9000, bucket enamel-blobs");
  auto field = [&](auto change) {
    S3Options options = good;
    change(options);
    const auto made = S3Client::Make(options);
    EXPECT_EQ(made.status().code(), Code::kInvalidInput) << made.status().message();
    return made.status().field();
  };
  for (const char* endpoint :
       {"", "s3.example.org", "ftp://s3.example.org", "https://", "https://a/b", "https://u:p@host",
        "http://s3.example.org", "http://127.example.org", "http://10.0.0.1:9000",
        "https://a\r\nb"}) {
    EXPECT_EQ(field([&](S3Options& o) { o.endpoint = endpoint; }), "endpoint") << endpoint;
  }
  for (const char* bucket : {"", "a/b", "..", "a b", "a\n"}) {
    EXPECT_EQ(field([&](S3Options& o) { o.bucket = bucket; }), "bucket") << bucket;
  }
  EXPECT_EQ(field([](S3Options& o) { o.region = "a/b"; }), "region");
  EXPECT_EQ(field([](S3Options& o) { o.credentials.secret_key.clear(); }), "credentials");
  EXPECT_EQ(field([](S3Options& o) { o.credentials.access_key = "a\r\nHost: b"; }), "credentials");
  for (const char* here : {"http://localhost:1", "http://127.0.0.1:9000", "http://[::1]:9000"}) {
    good.endpoint = here;
    EXPECT_TRUE(S3Client::Make(good).ok()) << here;
  }
}

}  // namespace
}  // namespace enamel::s3
