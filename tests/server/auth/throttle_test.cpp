#include "server/auth/throttle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <random>
#include <vector>

#include "common/base/unix_time.h"
#include "server/auth/address_block.h"
#include "server/storage/open_store.h"
#include "tests/support/temp_folder.h"

namespace enamel::server::auth {
namespace {

const Origin kHere{"203.0.113.7"};
const Origin kNextSeat{"203.0.113.8"};
const Origin kElsewhere{"198.51.100.9"};

void Fail(Throttle& throttle, const std::string& login, const Origin& origin, int times,
          UnixMs now) {
  for (int i = 0; i < times; ++i) (void)throttle.Failed(login, origin, now);
}

TEST(ThrottleTest, FirstFailuresCostNothing) {
  Throttle throttle;
  Fail(throttle, "ada", kHere, 5, 1000);
  EXPECT_TRUE(throttle.Admit("ada", kHere, 1000).ok());
}

TEST(ThrottleTest, DelayDoublesUpToAMinuteAndThenEndsByItself) {
  Throttle throttle;
  Fail(throttle, "ada", kHere, 6, 1000);
  EXPECT_EQ(throttle.Admit("ada", kHere, 1400).status().field(), "throttled");
  EXPECT_TRUE(throttle.Admit("ada", kHere, 1500).ok());
  Fail(throttle, "ada", kHere, 14, 2000);
  EXPECT_FALSE(throttle.Admit("ada", kHere, 2000 + 59'999).ok());
  EXPECT_TRUE(throttle.Admit("ada", kHere, 2000 + 60'000).ok());
}

TEST(ThrottleTest, RefusalTellsTheSecondsToWait) {
  Throttle throttle;
  Fail(throttle, "ada", kHere, 11, 1000);
  Status refused = throttle.Admit("ada", kHere, 1000 + 4'500).status();
  EXPECT_EQ(refused.message(), "too many failed sign-ins; try again in 12 s");
  EXPECT_EQ(refused.retry_after_s(), 12);
}

TEST(ThrottleTest, StrangerDelaysTheOwnersThirdTryElsewhereByFourSecondsAtMost) {
  Throttle throttle;
  Fail(throttle, "ada", kHere, 1000, 1000);
  for (const char* nth : {"first", "second"}) {
    EXPECT_TRUE(throttle.Admit("ada", kElsewhere, 1000).ok()) << "a place's " << nth << " try";
    (void)throttle.Failed("ada", kElsewhere, 1000);
  }
  EXPECT_FALSE(throttle.Admit("ada", kElsewhere, 1000).ok());
  EXPECT_TRUE(throttle.Admit("ada", kElsewhere, 1000 + 4'000).ok());
  EXPECT_FALSE(throttle.Admit("ada", kHere, 1000 + 4'000).ok());
}

TEST(ThrottleTest, StrangerDoesNotDelayTheOwnerWhereTheOwnerSignedInBefore) {
  Throttle throttle;
  (void)throttle.Succeeded("ada", kHere, 1000);
  Fail(throttle, "ada", kElsewhere, 1000, 2000);
  Fail(throttle, "ada", kHere, 1, 2000);
  EXPECT_TRUE(throttle.Admit("ada", kHere, 2000).ok());
}

Origin Numbered(int i) {
  return {"198." + std::to_string(i / 256) + ".100." + std::to_string(i % 256)};
}

TEST(ThrottleTest, FirstTriesOfManyPlacesHaveATurnEachHalfSecond) {
  Throttle throttle;
  Fail(throttle, "ada", kHere, 1000, 1000);
  std::vector<int64_t> held;
  for (int i = 0; i < 250; ++i) {
    const auto admission = throttle.Admit("ada", Numbered(i), 1000);
    if (admission.ok()) held.push_back(admission->hold_ms);
  }
  EXPECT_EQ(held, (std::vector<int64_t>{0, 500, 1000, 1500, 2000}));
}

TEST(ThrottleTest, ManyTriesAtOnceAreNoFirstTries) {
  Throttle throttle;
  Fail(throttle, "ada", kHere, 1000, 1000);
  int admitted = 0;
  for (int i = 0; i < 50; ++i) admitted += throttle.Admit("ada", kElsewhere, 1000).ok() ? 1 : 0;
  EXPECT_EQ(admitted, 2);
}

// A quarter of an hour: from each of 300 places somebody guesses at the owner's login as fast as
// allowed. Each half minute the owner comes to another new place, mistypes, and tries again.
TEST(ThrottleTest, OwnerGetsInAtANewPlaceWithinSecondsWhileManyPlacesGuess) {
  constexpr int kPlaces = 300;
  Throttle throttle;
  std::vector<UnixMs> free_at(kPlaces);
  int guesses = 0;
  int64_t longest_ms = 0;
  for (UnixMs now = 1000; now < 15 * 60 * 1000; now += 250) {
    for (size_t i = 0; i < kPlaces; ++i) {
      const Origin place = Numbered(static_cast<int>(i));
      if (now < free_at[i]) continue;
      const auto admission = throttle.Admit("owner", place, now);
      // Refused ones come again at once: they take what turns there are.
      if (!admission.ok()) continue;
      ++guesses;
      free_at[i] = now + admission->hold_ms;
      (void)throttle.Failed("owner", place, now);
    }
    // Their own first tries are over after a second.
    if (now % 30'000 != 0) continue;
    const Origin place{"203.0.113." + std::to_string(now / 30'000)};
    const auto mistyped = throttle.Admit("owner", place, now);
    ASSERT_TRUE(mistyped.ok()) << now << ": " << mistyped.status().message();
    (void)throttle.Failed("owner", place, now);
    const auto right = throttle.Admit("owner", place, now);
    ASSERT_TRUE(right.ok()) << now << ": " << right.status().message();
    EXPECT_EQ(right->line, Line::kUsual) << "before those who guess";
    longest_ms = std::max({longest_ms, mistyped->hold_ms, right->hold_ms});
  }
  std::cout << kPlaces << " places guess at one login: " << guesses
            << " guesses in 15 min, owner at a new place held for at most " << longest_ms
            << " ms\n";
  EXPECT_LE(longest_ms, 2000);
  EXPECT_LE(guesses, 300);
  EXPECT_EQ(throttle.Admit("other", Numbered(1), 15 * 60 * 1000)->line, Line::kLast);
}

TEST(ThrottleTest, BrowserThatSignedInIsDelayedByNobodyElsewhere) {
  Throttle throttle;
  const Origin browser{kHere.address, "device 1", true};
  for (int i = 0; i < 5000; ++i) {
    (void)throttle.Failed("owner", Numbered(i % 400), 1000);
    (void)throttle.Failed("login" + std::to_string(i), kHere, 1000);
  }
  const auto admission = throttle.Admit("owner", browser, 1000);
  ASSERT_TRUE(admission.ok());
  EXPECT_EQ(admission->hold_ms, 0);
  EXPECT_EQ(admission->line, Line::kFirst);
  Fail(throttle, "owner", browser, 12, 1000);
  EXPECT_FALSE(throttle.Admit("owner", browser, 1000).ok()) << "a stolen one guesses slowly";
  EXPECT_TRUE(throttle.Admit("owner", browser, 1000 + 4'000).ok());
}

TEST(ThrottleTest, ChairIsNotDelayedByGuessesFromItsAddress) {
  Throttle throttle;
  for (int i = 0; i < 5000; ++i) (void)throttle.Failed("login" + std::to_string(i), kHere, 1000);
  EXPECT_EQ(throttle.Admit("login1", {kHere.address, "chair 1"}, 1000)->hold_ms, 0);
}

// Each guess from another /64 of one /48, at another login.
TEST(ThrottleTest, OneHolderOfManyBlocksHasTheTriesOfAFewOnly) {
  Throttle throttle;
  int guesses = 0;
  for (UnixMs now = 1000; now < 15 * 60 * 1000; now += 20) {
    const std::string n = std::to_string(now % 9973);
    const Origin block{"2001:db8:7:" + n.substr(0, 4) + "::1"};
    const auto admission = throttle.Admit("login" + n, block, now);
    if (!admission.ok()) continue;
    ++guesses;
    (void)throttle.Failed("login" + n, block, now + admission->hold_ms);
  }
  std::cout << "a /48 guessed from: " << guesses << " tries in 15 min\n";
  EXPECT_LE(guesses, 120 + 4 * 900 + 10);
  EXPECT_EQ(throttle.Admit("new", {"2001:db8:8::1"}, 15 * 60 * 1000)->hold_ms, 0) << "the next /48";
}

TEST(ThrottleTest, GuessingManyLoginsFromOnePlaceIsSlowedAndTheNextSeatIsNot) {
  Throttle throttle;
  for (int i = 0; i < 40; ++i) (void)throttle.Failed("login" + std::to_string(i), kHere, 1000);
  EXPECT_FALSE(throttle.Admit("login1", kHere, 1000).ok());
  int64_t held = 0;
  for (int i = 0; i < 9; ++i) {
    auto hold = throttle.Admit("another" + std::to_string(i), kHere, 1000);
    ASSERT_TRUE(hold.ok()) << i;
    EXPECT_EQ(hold->hold_ms, held) << i;
    held += 250;
  }
  EXPECT_FALSE(throttle.Admit("one too many", kHere, 1000).ok());
  EXPECT_EQ(throttle.Admit("login1", kNextSeat, 1000)->hold_ms, 0);
}

TEST(ThrottleTest, SuccessAndSilenceAreForgiven) {
  Throttle throttle;
  Fail(throttle, "ada", kHere, 10, 1000);
  (void)throttle.Succeeded("ada", kHere, 1000);
  EXPECT_TRUE(throttle.Admit("ada", kHere, 1000).ok());
  Fail(throttle, "bob", kHere, 10, 1000);
  Fail(throttle, "bob", kHere, 1, 1000 + 16 * 60 * 1000);
  EXPECT_TRUE(throttle.Admit("bob", kHere, 1000 + 16 * 60 * 1000).ok());
}

TEST(ThrottleTest, OwnersSuccessDoesNotOpenTheLoginToMoreGuesses) {
  Throttle throttle;
  for (int i = 0; i < 40; ++i) Fail(throttle, "ada", Numbered(i), 2, 1000);
  EXPECT_FALSE(throttle.Admit("ada", Numbered(1), 1000).ok());
  (void)throttle.Succeeded("ada", kHere, 1000);
  EXPECT_FALSE(throttle.Admit("ada", Numbered(1), 1000).ok());
  EXPECT_TRUE(throttle.Admit("ada", kHere, 1000).ok());
}

TEST(ThrottleTest, AnAccountOfOnesOwnMakesNoGuessesFree) {
  Throttle throttle;
  int admitted = 0;
  for (int i = 0; i < 400; ++i) {
    (void)throttle.Succeeded("mallory", kHere, 1000);
    const std::string victim = "login" + std::to_string(i % 100);
    if (!throttle.Admit(victim, kHere, 1000).ok()) continue;
    ++admitted;
    (void)throttle.Failed(victim, kHere, 1000);
  }
  EXPECT_LE(admitted, 45);
}

// 144 students, every third mistypes once, two seconds apart.
void SignInAClass(bool behind_one_address) {
  Throttle throttle;
  UnixMs now = 1000;
  int failures = 0, refused = 0, held = 0;
  auto admit = [&](const std::string& login, const Origin& origin) {
    auto admission = throttle.Admit(login, origin, now);
    refused += admission.ok() ? 0 : 1;
    held += admission.ok() && admission->hold_ms > 0 ? 1 : 0;
  };
  for (int i = 0; i < 144; ++i, now += 2000) {
    const std::string login = "student" + std::to_string(i);
    const Origin seat{"203.0.113." + std::to_string(1 + i)};
    const Origin& origin = behind_one_address ? kHere : seat;
    if (i % 3 == 0) {
      admit(login, origin);
      (void)throttle.Failed(login, origin, now);
      ++failures;
    }
    admit(login, origin);
    (void)throttle.Succeeded(login, origin, now);
  }
  std::cout << "class of 144 " << (behind_one_address ? "behind one address" : "in one /24") << ": "
            << failures << " mistyped, " << refused << " tries refused, " << held << " held\n";
  EXPECT_EQ(refused, 0);
}

TEST(ThrottleTest, ClassWhereAThirdMistypesOnceWaitsForNothing) {
  SignInAClass(false);
  SignInAClass(true);
}

// Everybody mistypes before anybody gets in: the worst order there is.
TEST(ThrottleTest, ClassThatMistypesAllAtOnceBehindOneAddressGetsInWithinSeconds) {
  Throttle throttle;
  UnixMs now = 1000;
  int tries = 0;
  for (int i = 0; i < 48; ++i) (void)throttle.Failed("student" + std::to_string(i), kHere, now);
  for (int i = 0; i < 144; ++i) {
    for (const std::string login = "student" + std::to_string(i);; now += 100) {
      ++tries;
      auto hold = throttle.Admit(login, kHere, now);
      if (!hold.ok()) continue;
      now += hold->hold_ms;
      (void)throttle.Succeeded(login, kHere, now);
      break;
    }
  }
  std::cout << "48 mistyped at once, then 144 sign in one after the other: "
            << (now - 1000) / 1000.0 << " s of waiting for all together\n";
  EXPECT_LE(now - 1000, 60'000);
}

struct Siege {
  int guesses = 0, owner_tries = 0, owner_in = 0;
};

// Fifteen minutes: somebody guesses as fast as allowed at `victim_of`, the owner signs in once a
// minute with the right password and, refused, tries again as the refusal says.
Siege Besiege(const Origin& attacker_at, const Origin& owner_at, bool owner_known,
              bool at_the_owners_login) {
  Throttle throttle;
  Siege out;
  if (owner_known) (void)throttle.Succeeded("owner", owner_at, 0);
  UnixMs free_at = 0;
  for (UnixMs now = 1000; now < 15 * 60 * 1000; now += 100) {
    const std::string login =
        at_the_owners_login ? "owner" : "nobody" + std::to_string(out.guesses);
    if (now >= free_at) {
      auto hold = throttle.Admit(login, attacker_at, now);
      if (hold.ok()) {
        ++out.guesses;
        free_at = now + hold->hold_ms;
        (void)throttle.Failed(login, attacker_at, free_at);
      }
    }
    if (now % 60'000 != 0) continue;
    ++out.owner_tries;
    if (throttle.Admit("owner", owner_at, now).ok()) {
      ++out.owner_in;
      (void)throttle.Succeeded("owner", owner_at, now);
    }
  }
  return out;
}

void Show(const char* what, const Siege& siege) {
  std::cout << what << ": " << siege.guesses << " guesses in 15 min, owner in " << siege.owner_in
            << " of " << siege.owner_tries << " times at the first try\n";
}

TEST(ThrottleTest, AttackerDoesNotKeepTheOwnerOut) {
  Siege neighbour = Besiege(kNextSeat, kHere, false, false);
  Show("attacker at the next seat, any login", neighbour);
  EXPECT_EQ(neighbour.owner_in, neighbour.owner_tries);
  Siege targeted = Besiege(kNextSeat, kHere, false, true);
  Show("attacker at the next seat, the owner's login", targeted);
  EXPECT_EQ(targeted.owner_in, targeted.owner_tries);
  Siege same = Besiege(kHere, kHere, false, false);
  Show("attacker behind the same address, any login", same);
  EXPECT_EQ(same.owner_in, same.owner_tries);
  Siege known = Besiege(kElsewhere, kHere, true, true);
  Show("attacker anywhere, the owner's login, owner where known", known);
  EXPECT_EQ(known.owner_in, known.owner_tries);
}

TEST(ThrottleTest, GuesserOfOneLoginGetsFewTries) {
  Throttle throttle;
  int guesses = 0;
  for (UnixMs now = 1000; now < 15 * 60 * 1000; now += 100) {
    if (!throttle.Admit("ada", kHere, now).ok()) continue;
    ++guesses;
    (void)throttle.Failed("ada", kHere, now);
  }
  std::cout << "one login guessed at from one address: " << guesses << " tries in 15 min\n";
  EXPECT_LE(guesses, 30);
}

// What several servers count together.
struct Common {
  MemoryCounters counters;
  bool fails = false;
};
class CommonCounters final : public FailureCounters {
 public:
  explicit CommonCounters(Common& common) : common_(common) {}
  Status Apply(const OfTry<std::string>& names, UnixMs now_ms, const Change& change) override {
    const Status done = common_.counters.Apply(names, now_ms, [&](OfTry<SignInCounter>& counters) {
      // Once more, as when another server's change came between.
      OfTry<SignInCounter> first = counters;
      change(first);
      change(counters);
    });
    return common_.fails ? Status(Code::kUnavailable, "the database is away") : done;
  }

 private:
  Common& common_;
};

// Tries in a quarter of an hour at `logins` logins, from one address, thirty in a second, with each
// server in turn.
int GuessesAt(std::vector<Throttle>& servers, int logins) {
  int guesses = 0, tries = 0;
  for (UnixMs now = 1000; now < 15 * 60 * 1000; now += 100) {
    for (int i = 0; i < 3; ++i, ++tries) {
      const std::string login = "login" + std::to_string(tries % logins);
      Throttle& server = servers[static_cast<size_t>(tries) % servers.size()];
      auto hold = server.Admit(login, kHere, now);
      if (!hold.ok()) continue;
      ++guesses;
      (void)server.Failed(login, kHere, now + hold->hold_ms);
    }
  }
  return guesses;
}

TEST(ThrottleTest, ThreeServersThatCountTogetherLeaveNoMoreGuessesThanOne) {
  for (int logins : {1, 1000}) {
    Common common;
    std::vector<Throttle> alone(1), apart(3), together;
    for (int i = 0; i < 3; ++i) together.emplace_back(std::make_unique<CommonCounters>(common));
    const int one = GuessesAt(alone, logins), each = GuessesAt(apart, logins);
    const int all = GuessesAt(together, logins);
    std::cout << logins << " logins guessed at in 15 min: one server " << one
              << ", three that count together " << all << ", three that count apart " << each
              << "\n";
    EXPECT_EQ(all, one);
    EXPECT_GT(each, 2 * one) << "what this test is about";
  }
}

TEST(ThrottleTest, StoreCountsAsMemoryDoes) {
  const test::TempFolder folder;
  StoreOptions options;
  options.folder = folder.path();
  options.change_twice = true;
  const auto store = std::move(OpenSqliteStore(options)).value();
  Throttle memory, shared(std::make_unique<SharedCounters>(*store));
  std::minstd_rand random(7);
  // The store forgets by the clock.
  UnixMs now = enamel::UnixMs();
  for (int i = 0; i < 1000; ++i, now += random() % 4000) {
    const std::string login = "login" + std::to_string(random() % 12);
    const Origin address{(random() % 2 == 0 ? "203.0.113." : "2001:db8:1:7::") +
                         std::to_string(random() % 4)};
    const auto mine = memory.Admit(login, address, now), theirs = shared.Admit(login, address, now);
    ASSERT_EQ(mine.status().message(), theirs.status().message()) << i;
    if (!mine.ok()) continue;
    ASSERT_EQ(mine->hold_ms, theirs->hold_ms) << i;
    const bool right = random() % 5 == 0;
    for (Throttle* one : {&memory, &shared}) {
      (void)(right ? one->Succeeded(login, address, now) : one->Failed(login, address, now));
    }
  }
}

TEST(ThrottleTest, AClockThatIsSetBackKeepsNobodyOut) {
  Throttle throttle;
  constexpr UnixMs kDay = 24ll * 3600 * 1000;
  (void)throttle.Succeeded("bob", kHere, kDay);
  for (int i = 0; i < 60; ++i) (void)throttle.Failed("login" + std::to_string(i % 7), kHere, kDay);
  for (int i = 0; i < 9; ++i) (void)throttle.Admit("new" + std::to_string(i), kHere, kDay);
  EXPECT_FALSE(throttle.Admit("login1", kHere, kDay).ok());
  EXPECT_FALSE(throttle.Admit("another", kHere, kDay).ok());
  for (const char* login : {"login1", "another", "bob"}) {
    auto hold = throttle.Admit(login, kHere, 1000);
    ASSERT_TRUE(hold.ok()) << login << ": " << hold.status().message();
    EXPECT_EQ(hold->hold_ms, 0) << login;
  }
  // By a little, as a clock that follows another is: nothing is forgotten.
  EXPECT_FALSE(throttle.Admit("login1", kHere, kDay - 50).ok());
}

TEST(ThrottleTest, AFailureThatCannotBeCountedIsSaid) {
  Common common{{}, true};
  Throttle throttle(std::make_unique<CommonCounters>(common));
  EXPECT_EQ(throttle.Failed("ada", kHere, 1000).code(), Code::kUnavailable);
  EXPECT_EQ(throttle.Admit("ada", kHere, 1000).status().message(), "the database is away");
}

TEST(ThrottleTest, AddressesAreTakenByBlock) {
  EXPECT_EQ(AddressBlock("203.0.113.7"), "203.0.113.7");
  EXPECT_EQ(AddressBlock("2001:db8:1:2:3::4"), "2001:db8:1:2::/64");
  EXPECT_EQ(AddressBlock("::ffff:203.0.113.7"), "203.0.113.7");
  EXPECT_EQ(AddressBlock("unknown"), "unknown");
  EXPECT_EQ(AddressSite("2001:db8:1:2:3::4"), "2001:db8:1::/48");
  EXPECT_EQ(AddressSite("203.0.113.7"), "203.0.113.7");
}

}  // namespace
}  // namespace enamel::server::auth
