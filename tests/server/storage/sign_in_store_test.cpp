#include "tests/server/storage/backends.h"
#include "tests/server/storage/store_world.h"

// Counters of failed sign-ins, the same for every backend.
namespace enamel::server {
namespace {

using namespace testing;

class SignInStoreTest : public StoreSuite {
 protected:
  static Sha256 Key(const std::string& text) { return HashSha256(AsBytes(text)); }
  std::vector<SignInCounter> Read(const std::vector<Sha256>& keys) {
    std::vector<SignInCounter> out;
    EXPECT_TRUE(
        store_->sign_ins.Change(keys, [&](std::vector<SignInCounter>& all) { out = all; }).ok());
    return out;
  }
  // Counters that nobody forgets while this test runs.
  static UnixMs Later() { return enamel::UnixMs(std::chrono::system_clock::now()) + 3'600'000; }
};
INSTANTIATE_TEST_SUITE_P(Backends, SignInStoreTest, ::testing::ValuesIn(Backends()), BackendName);

TEST_P(SignInStoreTest, KeepsWhatIsMadeOfEachCounterAndNothingElse) {
  const std::vector<Sha256> keys{Key("b"), Key("a"), Key("c")};
  for (const SignInCounter& counter : Read(keys)) EXPECT_EQ(counter, SignInCounter{});
  const SignInCounter b{3, 1, 500, 750, Later()}, c{1, 0, 501, 0, Later()};
  ASSERT_TRUE(store_->sign_ins
                  .Change(keys,
                          [&](std::vector<SignInCounter>& all) {
                            all[0] = b;
                            all[2] = c;
                          })
                  .ok());
  EXPECT_EQ(Read({Key("c"), Key("a"), Key("b")}), (std::vector<SignInCounter>{c, {}, b}));
  Reopen();
  EXPECT_EQ(Read(keys), (std::vector<SignInCounter>{b, {}, c}));
  ASSERT_TRUE(
      store_->sign_ins.Change(keys, [&](std::vector<SignInCounter>& all) { all[0] = {}; }).ok());
  EXPECT_EQ(Read(keys), (std::vector<SignInCounter>{{}, {}, c}));
}

TEST_P(SignInStoreTest, WhatIsOverIsForgottenInTime) {
  const auto count = [&](const std::string& name, UnixMs until_ms) {
    return store_->sign_ins.Change({Key(name)}, [&](std::vector<SignInCounter>& all) {
      ++all[0].failures;
      all[0].until_ms = until_ms;
    });
  };
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(count("over " + std::to_string(i), 1).ok());
  ASSERT_TRUE(count("stays", Later()).ok());
  for (int i = 0; i < 200; ++i) ASSERT_TRUE(count("later " + std::to_string(i), Later()).ok());
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(Read({Key("over " + std::to_string(i))})[0], SignInCounter{}) << i;
  }
  EXPECT_EQ(Read({Key("stays")})[0].failures, 1u);
}

}  // namespace
}  // namespace enamel::server
