#include "server/auth/refusal_trail.h"

#include <gtest/gtest.h>

#include "server/auth/authenticator.h"
#include "tests/server/storage/store_world.h"

namespace enamel::server::auth {
namespace {

using namespace server::testing;

class RefusalTrailTest : public ::testing::Test {
 protected:
  TempFolder folder_;
  std::unique_ptr<Store> store_ = OpenStore(folder_.path());
  Uuid ada_ = AddPerson(*store_, "ada", Role::kStudent, "no verifier");
  std::atomic<int64_t> now_{1'000'000};
  RefusalTrail trail_{*store_, [this] { return now_.load(); }};

  void Refuse(const std::string& login, const std::string& address, int times = 1) {
    for (int i = 0; i < times; ++i) {
      trail_.Note({"password", address, "page", login, {}, {}});
      if (i % 100 == 99) trail_.Settle();  // no more than may wait
    }
    trail_.Settle();
  }
  // Oldest first.
  std::vector<AuditRow> Rows() {
    AuditFilter filter;
    filter.action = "session.refused";
    filter.limit = 1000;
    auto rows = store_->audit.FindAudit(filter);
    EXPECT_TRUE(rows.ok());
    return {rows->rbegin(), rows->rend()};
  }
};

TEST_F(RefusalTrailTest, FourHundredRefusalsOfOnePersonMakeThreeRowsWithCountAndAddress) {
  Refuse("ada", "203.0.113.7", 400);
  std::vector<AuditRow> rows = Rows();
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].object, ada_.Text());
  EXPECT_EQ(rows[0].actor, "page");
  EXPECT_EQ(rows[0].after_json, R"({"address":"203.0.113.7","count":"1","reason":"password"})");
  EXPECT_EQ(rows[2].after_json, R"({"address":"203.0.113.7","count":"100","reason":"password"})");
}

TEST_F(RefusalTrailTest, LoginThatNamesNobodyIsNotKept) {
  Refuse("my-own-secret", "203.0.113.7");
  ASSERT_EQ(Rows().size(), 1u);
  EXPECT_EQ(Rows()[0].object, "nobody");
  EXPECT_EQ(Rows()[0].after_json.find("my-own-secret"), std::string::npos);
}

TEST_F(RefusalTrailTest, FloodFromManyAddressesMakesNoMoreRowsThanItMay) {
  for (int i = 0; i < 300; ++i)
    Refuse("ada", "10.0." + std::to_string(i / 250) + "." + std::to_string(i % 250));
  EXPECT_EQ(Rows().size(), RefusalTrail::kMaxRows);
  EXPECT_NE(Rows().back().after_json.find("many"), std::string::npos) << "and the last says so";
  now_ += RefusalTrail::kWindowMs + 1;
  Refuse("ada", "10.0.0.1");
  EXPECT_EQ(Rows().size(), RefusalTrail::kMaxRows + 1) << "until a quarter of an hour is over";
}

TEST_F(RefusalTrailTest, AddressIsNoPlaceForOtherWords) {
  Refuse("ada", "10.0.0.1\",\"x\":\"\n");
  EXPECT_EQ(Rows()[0].after_json, R"({"address":"10.0.0.1x:","count":"1","reason":"password"})");
}

TEST_F(RefusalTrailTest, AuthenticatorCountsAndNotesWhomItTurnsAway) {
  AuthOptions options;
  options.cost = {1, 8192};
  options.clock = [this] { return now_.load(); };
  Authenticator door(*store_, options);
  for (int i = 0; i < 12; ++i) (void)door.SignInHere({"ada", "wrong", "203.0.113.7", "page"});
  door.refusals().Settle();
  EXPECT_GT(door.counts().refused, 0u);
  EXPECT_GT(door.counts().throttled, 0u);
  EXPECT_EQ(door.counts().refused + door.counts().throttled, 12u);
  std::string all;
  for (const AuditRow& row : Rows()) all += row.after_json;
  EXPECT_NE(all.find(R"("reason":"password")"), std::string::npos) << all;
  EXPECT_NE(all.find(R"("reason":"throttled")"), std::string::npos) << all;
}

}  // namespace
}  // namespace enamel::server::auth
