#include "server/auth/authenticator.h"

#include <gtest/gtest.h>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <map>
#include <new>
#include <semaphore>

#include "common/base/hex.h"
#include "common/base/pin.h"
#include "server/auth/token.h"
#include "tests/server/storage/store_world.h"

namespace enamel::server::auth {
namespace {

using namespace server::testing;

// Cheapest that libsodium allows: these tests are not about the cost.
constexpr PasswordCost kCheap{1, 8192};
constexpr char kPassword[] = "correct horse battery";

class AuthenticatorTest : public ::testing::Test {
 protected:
  AuthenticatorTest() {
    person_ = AddPerson(*store_, "ada", Role::kStudent, *HashPassword(kPassword, kCheap));
  }

  AuthOptions Options() {
    AuthOptions options;
    options.cost = kCheap;
    options.clock = [this] { return now_; };
    return options;
  }
  static SignInRequest Request(const std::string& login, const std::string& password) {
    return {login, password, "203.0.113.7", "page"};
  }

  TempFolder folder_;
  std::unique_ptr<Store> store_ = OpenStore(folder_.path());
  Uuid person_;
  UnixMs now_ = 1'000'000;
  Authenticator authenticator_{*store_, Options()};
};

TEST_F(AuthenticatorTest, RightPasswordOpensASessionThatIsRecognised) {
  auto signed_in = authenticator_.SignInHere(Request("Ada", kPassword));
  ASSERT_TRUE(signed_in.ok()) << signed_in.status().message();
  auto identity = authenticator_.AuthenticateHex(ToHex(signed_in->token));
  ASSERT_TRUE(identity.ok());
  EXPECT_EQ(identity->person.id, person_);
  EXPECT_EQ(identity->csrf, signed_in->identity.csrf);
}

// Counts argon2id calls by their cost, which determines the time of an answer.
TEST_F(AuthenticatorTest, EverySignInDoesTheSameWorkWhoeverItIs) {
  constexpr PasswordCost kUsual{2, 16384};
  std::map<std::string, std::string> passwords = {{"nobody", "x"}, {"usual", kPassword}};
  AddPerson(*store_, "usual", Role::kStudent, *HashPassword(kPassword, kUsual));
  OneTimePassword once = MakeOneTimePassword();
  AddPerson(*store_, "once", Role::kStudent, once.verifier);
  passwords["once"] = once.text;
  AddPerson(*store_, "off", Role::kStudent, *HashPassword(kPassword, kUsual));
  ASSERT_TRUE(
      store_->people.SetDisabled(store_->people.PersonByLogin("off")->id, true, kSystem).ok());
  passwords["off"] = kPassword;
  int usual = 0;
  AuthOptions options = Options();
  options.cost = kUsual;
  options.verify = [&](std::string_view password, const std::string& verifier) {
    usual += CostsAsMuch(verifier, kUsual) ? 1 : 0;
    return VerifyPassword(password, verifier);
  };
  Authenticator authenticator(*store_, options);
  for (const auto& [login, right] : passwords) {
    for (const std::string& password : {right, std::string("wrong password")}) {
      usual = 0;
      (void)authenticator.SignInHere(Request(login, password));
      EXPECT_EQ(usual, 1) << login << " with " << password;
    }
  }
}

// The rules are for new passwords.
TEST_F(AuthenticatorTest, APasswordThatWouldBeRefusedTodayStillSignsIn) {
  constexpr char kWeak[] = "password1";
  ASSERT_FALSE(authenticator_.NewVerifier(kWeak, "weak").ok());
  AddPerson(*store_, "weak", Role::kStudent, *HashPassword(kWeak, Options().cost));
  EXPECT_TRUE(authenticator_.SignInHere(Request("weak", kWeak)).ok());
}

TEST_F(AuthenticatorTest, OneTimePasswordsWorkAndAreDifferent) {
  OneTimePassword a = MakeOneTimePassword(), b = MakeOneTimePassword();
  EXPECT_NE(a.text, b.text);
  EXPECT_EQ(a.text.size(), 19u);
  EXPECT_TRUE(VerifyPassword(a.text, a.verifier));
  EXPECT_FALSE(VerifyPassword(b.text, a.verifier));
  EXPECT_TRUE(CheckPasswordPolicy(a.text, "ada").ok());
}

TEST_F(AuthenticatorTest, AOneTimePasswordIsUsedUpWhenTheNewOneIsSet) {
  OneTimePassword once = MakeOneTimePassword();
  ASSERT_TRUE(store_->people.SetPassword(person_, once.verifier, true, kSystem).ok());
  auto closed = authenticator_.SignInHere(Request("ada", once.text));
  ASSERT_TRUE(closed.ok()) << closed.status().message();
  auto again = authenticator_.SignInHere(Request("ada", once.text));
  ASSERT_TRUE(again.ok()) << "the page was closed before a password was chosen: "
                          << again.status().message();
  EXPECT_TRUE(again->identity.person.must_change_password);
  ASSERT_TRUE(
      store_->people.SetPassword(person_, *HashPassword(kPassword, kCheap), false, kSystem).ok());
  EXPECT_FALSE(authenticator_.AuthenticateHex(ToHex(closed->token)).ok());
  EXPECT_FALSE(authenticator_.AuthenticateHex(ToHex(again->token)).ok());
  const Status used = authenticator_.SignInHere(Request("ada", once.text)).status();
  EXPECT_EQ(used.message(), authenticator_.SignInHere(Request("nobody", "x")).status().message());
}

TEST_F(AuthenticatorTest, AOneTimePasswordEndsAfterItsDaysAndAChosenOneDoesNot) {
  OneTimePassword once = MakeOneTimePassword();
  ASSERT_TRUE(store_->people.SetPassword(person_, once.verifier, true, kSystem).ok());
  AddPerson(*store_, "own", Role::kStudent, *HashPassword(kPassword, kCheap));
  const Person person = *store_->people.PersonById(person_);
  AuthOptions options = Options();
  options.one_time_ms = 3 * UnixMs{24 * 60 * 60 * 1000};
  Authenticator authenticator(*store_, options);
  now_ = authenticator.OneTimeUntil(person);
  EXPECT_EQ(now_, person.password_ms + options.one_time_ms);
  Status late = authenticator.SignInHere(Request("ada", once.text)).status();
  EXPECT_EQ(late.code(), Code::kUnauthenticated);
  EXPECT_NE(late.message().find("for 3 days"), std::string::npos) << late.message();
  EXPECT_EQ(authenticator.SignInHere(Request("ada", "wrong one")).status().field(), "");
  EXPECT_TRUE(authenticator.SignInHere(Request("own", kPassword)).ok());
  --now_;
  EXPECT_TRUE(authenticator.SignInHere(Request("ada", once.text)).ok());
}

TEST_F(AuthenticatorTest, SigningInEndsTheSessionOfTheCookieThatCameAlong) {
  SignInRequest request = Request("ada", kPassword);
  request.address = "2001:db8:1:2::3";
  request.device = "Firefox on Linux";
  auto earlier = authenticator_.SignInHere(request), elsewhere = authenticator_.SignInHere(request);
  ASSERT_TRUE(earlier.ok() && elsewhere.ok());
  request.earlier = ToHex(earlier->token);
  request.password = "wrong one";
  EXPECT_FALSE(authenticator_.SignInHere(request).ok());
  EXPECT_TRUE(authenticator_.AuthenticateHex(ToHex(earlier->token)).ok()) << "nobody signed in";
  request.password = kPassword;
  auto now = authenticator_.SignInHere(request);
  ASSERT_TRUE(now.ok());
  EXPECT_FALSE(authenticator_.AuthenticateHex(ToHex(earlier->token)).ok());
  EXPECT_TRUE(authenticator_.AuthenticateHex(ToHex(elsewhere->token)).ok());
  for (const std::string& no_cookie :
       {std::string("x"), std::string(64, 'z'), std::string(64, '0')}) {
    request.earlier = no_cookie;
    EXPECT_TRUE(authenticator_.SignInHere(request).ok()) << no_cookie;
  }
  const SessionRow row = *store_->sessions.FindSession(now->identity.token_hash);
  EXPECT_EQ(row.address, "2001:db8:1:2::/64");
  EXPECT_EQ(row.device, "Firefox on Linux");
}

TEST_F(AuthenticatorTest, TheStationLinksSessionsDoNotEndByACookie) {
  SignInRequest request = Request("ada", kPassword);
  request.via = kViaStation;
  auto at_station = authenticator_.SignInHere(request);
  ASSERT_TRUE(at_station.ok());
  SignInRequest page = Request("ada", kPassword);
  page.earlier = ToHex(at_station->token);
  ASSERT_TRUE(authenticator_.SignInHere(page).ok());
  EXPECT_TRUE(authenticator_.Authenticate(at_station->token).ok());
}

TEST_F(AuthenticatorTest, WrongPasswordAndUnknownLoginGetTheSameAnswer) {
  Status wrong = authenticator_.SignInHere(Request("ada", "wrong password")).status();
  Status unknown = authenticator_.SignInHere(Request("nobody", "wrong password")).status();
  EXPECT_EQ(wrong.code(), Code::kUnauthenticated);
  EXPECT_EQ(wrong.message(), unknown.message());
  EXPECT_EQ(wrong.code(), unknown.code());
  EXPECT_EQ(wrong.field(), unknown.field());
}

TEST_F(AuthenticatorTest, DisabledPersonIsRefusedWithTheSameWords) {
  ASSERT_TRUE(store_->people.SetDisabled(person_, true, kSystem).ok());
  Status disabled = authenticator_.SignInHere(Request("ada", kPassword)).status();
  EXPECT_EQ(disabled.message(),
            authenticator_.SignInHere(Request("nobody", "x")).status().message());
}

TEST_F(AuthenticatorTest, TokenItselfIsNotStored) {
  auto signed_in = authenticator_.SignInHere(Request("ada", kPassword));
  EXPECT_FALSE(store_->sessions.FindSession(Sha256::FromBytes(signed_in->token)).ok());
  EXPECT_TRUE(store_->sessions.FindSession(HashSha256(signed_in->token)).ok());
}

TEST_F(AuthenticatorTest, SessionEndsWhenIdleForHalfAnHour) {
  auto signed_in = authenticator_.SignInHere(Request("ada", kPassword));
  now_ += 29 * 60 * 1000;
  EXPECT_TRUE(authenticator_.Authenticate(signed_in->token).ok()) << "and renews";
  now_ += 29 * 60 * 1000;
  EXPECT_TRUE(authenticator_.Authenticate(signed_in->token).ok());
  now_ += 30 * 60 * 1000 + 1;
  EXPECT_EQ(authenticator_.Authenticate(signed_in->token).status().code(), Code::kUnauthenticated);
}

TEST_F(AuthenticatorTest, SessionEndsAfterTwelveHoursHoweverBusy) {
  auto signed_in = authenticator_.SignInHere(Request("ada", kPassword));
  for (int minutes = 0; minutes < 12 * 60; minutes += 20) {
    ASSERT_TRUE(authenticator_.Authenticate(signed_in->token).ok()) << minutes;
    now_ += 20 * 60 * 1000;
  }
  EXPECT_FALSE(authenticator_.Authenticate(signed_in->token).ok());
}

TEST_F(AuthenticatorTest, SessionSurvivesAClockThatIsCorrectedAndStillEndsWhenIdle) {
  now_ = 100'000'000;
  auto signed_in = authenticator_.SignInHere(Request("ada", kPassword));
  now_ -= 20 * 60 * 1000;
  EXPECT_TRUE(authenticator_.Authenticate(signed_in->token).ok());
  now_ += 40 * 60 * 1000;
  EXPECT_FALSE(authenticator_.Authenticate(signed_in->token).ok()) << "idle for 40 minutes";
}

TEST_F(AuthenticatorTest, ClockSetBackByADayDoesNotMakeSessionsLastADayLonger) {
  now_ = 200'000'000;
  auto signed_in = authenticator_.SignInHere(Request("ada", kPassword));
  now_ -= 86'400'000;
  EXPECT_FALSE(authenticator_.Authenticate(signed_in->token).ok());
  auto again = authenticator_.SignInHere(Request("ada", kPassword));
  ASSERT_TRUE(again.ok());
  EXPECT_TRUE(authenticator_.Authenticate(again->token).ok());
}

TEST_F(AuthenticatorTest, ClockThatJumpsNeitherLocksAnybodyOutNorForgetsGuesses) {
  AuthOptions options = Options();
  int64_t elapsed = 0;
  options.elapsed = [&] { return elapsed; };
  Authenticator authenticator(*store_, options);
  for (int i = 0; i < 6; ++i) (void)authenticator.SignInHere(Request("ada", "guess guess"));
  now_ += 86'400'000;
  EXPECT_EQ(authenticator.SignInHere(Request("ada", kPassword)).status().field(), "throttled");
  now_ -= 2 * 86'400'000;
  elapsed += 60'000;
  EXPECT_TRUE(authenticator.SignInHere(Request("ada", kPassword)).ok());
}

// A PIN has 20 bits, and slowing down leaves some 225 tries in a quarter of an hour.
class PinLockTest : public AuthenticatorTest {
 protected:
  static constexpr char kPin[] = "804217", kWrong[] = "804218";

  PinLockTest() { SetPin(kPin); }

  void SetPin(const std::string& pin) {
    ASSERT_TRUE(store_->people.SetPin(person_, *HashPassword(pin, kCheap), kSystem).ok());
  }
  // At a chair each time, and once nothing slows it down any more.
  Status Try(const std::string& pin) {
    now_ += 20 * 60 * 1000;
    SignInRequest request = Request("ada", pin);
    request.via = kViaStation;
    request.device = "chair 3";
    return authenticator_.CheckPinHere(request).status();
  }
  void TryWrong(int times) {
    for (int i = 0; i < times; ++i) {
      EXPECT_EQ(Try(kWrong).code(), Code::kUnauthenticated) << i;
    }
  }
  size_t Locks() {
    AuditFilter filter;
    filter.action = "person.pin_locked";
    filter.object = person_.Text();
    const auto rows = *store_->audit.FindAudit(filter);
    for (const AuditRow& row : rows) EXPECT_EQ(row.via, "station chair 3");
    return rows.size();
  }
};

TEST_F(PinLockTest, TheTenthWrongPinLocksAlsoTheRightOne) {
  TryWrong(9);
  EXPECT_EQ(Locks(), 0u);
  EXPECT_FALSE(store_->people.PersonById(person_)->pin_locked);
  const Status tenth = Try(kWrong);
  EXPECT_EQ(tenth.code(), Code::kForbidden);
  EXPECT_EQ(tenth.field(), kPinLocked);
  EXPECT_NE(tenth.message().find("set a new PIN on the page"), std::string::npos);
  EXPECT_TRUE(store_->people.PersonById(person_)->pin_locked);
  const Status right = Try(kPin), wrong = Try(kWrong);
  for (const Status& status : {right, wrong}) {
    EXPECT_EQ(status.code(), tenth.code());
    EXPECT_EQ(status.field(), tenth.field());
    EXPECT_EQ(status.message(), tenth.message()) << "nothing says which of them was right";
  }
  EXPECT_EQ(Locks(), 1u) << "once";
  EXPECT_TRUE(authenticator_.SignInHere(Request("ada", kPassword)).ok())
      << "only the PIN is locked";
}

TEST_F(PinLockTest, ARightPinForgetsTheWrongOnes) {
  for (int round = 0; round < 3; ++round) {
    TryWrong(9);
    EXPECT_TRUE(Try(kPin).ok()) << round;
  }
  EXPECT_EQ(Locks(), 0u);
}

TEST_F(PinLockTest, ANewPinUnlocksAndTheOldOneStaysWrong) {
  TryWrong(9);
  EXPECT_EQ(Try(kWrong).field(), kPinLocked);
  SetPin("271804");
  EXPECT_FALSE(store_->people.PersonById(person_)->pin_locked);
  EXPECT_EQ(Try(kPin).code(), Code::kUnauthenticated);
  EXPECT_TRUE(Try("271804").ok());
}

TEST_F(PinLockTest, ALockOutlivesTheServer) {
  TryWrong(7);
  authenticator_.refusals().Settle();
  store_.reset();
  store_ = OpenStore(folder_.path());
  Authenticator second{*store_, Options()};
  const auto try_again = [&](const std::string& pin) {
    now_ += 20 * 60 * 1000;
    return second.CheckPinHere(Request("ada", pin)).status();
  };
  EXPECT_EQ(try_again(kWrong).code(), Code::kUnauthenticated);
  EXPECT_EQ(try_again(kWrong).code(), Code::kUnauthenticated);
  EXPECT_EQ(try_again(kWrong).field(), kPinLocked) << "the tenth, of two servers' lives";
  EXPECT_EQ(try_again(kPin).field(), kPinLocked);
  Authenticator third{*store_, Options()};
  EXPECT_EQ(third.CheckPinHere(Request("ada", kPin)).status().field(), kPinLocked);
}

// All begin before the first of them is checked.
TEST_F(PinLockTest, OfTriesAtTheSameTimeNoMoreThanTenAreChecked) {
  int checked = 0;
  for (int i = 0; i < 100; ++i) {
    const auto one = store_->people.TryPin(person_);
    ASSERT_TRUE(one.ok()) << one.status().message();
    checked += one->locked ? 0 : 1;
    EXPECT_EQ(one->last, i == 9) << i;
  }
  EXPECT_EQ(checked, 10);
}

TEST_F(PinLockTest, WhoHasNoPinIsNeverLockedAndALockedPinTakesTheSameWork) {
  AddPerson(*store_, "bo", Role::kInstructor, *HashPassword(kPassword, kCheap));
  AuthOptions options = Options();
  int work = 0;
  options.verify = [&](std::string_view password, const std::string& verifier) {
    ++work;
    return VerifyPassword(password, verifier);
  };
  Authenticator authenticator(*store_, options);
  for (const char* login : {"ada", "bo", "nobody"}) {
    for (int i = 0; i < 12; ++i) {
      now_ += 20 * 60 * 1000;
      work = 0;
      const Status status = authenticator.CheckPinHere(Request(login, kWrong)).status();
      EXPECT_EQ(work, 1) << login << i;
      const bool locked = std::string(login) == "ada" && i >= 9;
      EXPECT_EQ(status.field(), locked ? kPinLocked : "") << login << i;
    }
  }
}

TEST_F(AuthenticatorTest, SignedOutTokenIsRefused) {
  auto signed_in = authenticator_.SignInHere(Request("ada", kPassword));
  ASSERT_TRUE(authenticator_.SignOut(signed_in->identity.token_hash).ok());
  EXPECT_FALSE(authenticator_.Authenticate(signed_in->token).ok());
  EXPECT_FALSE(authenticator_.AuthenticateHex("nonsense").ok());
}

TEST_F(AuthenticatorTest, GuessingIsSlowedButTheOwnerElsewhereIsNotLockedOut) {
  for (int i = 0; i < 6; ++i) (void)authenticator_.SignInHere(Request("ada", "guess guess"));
  EXPECT_EQ(authenticator_.SignInHere(Request("ada", kPassword)).status().field(), "throttled");
  SignInRequest elsewhere = Request("ada", kPassword);
  elsewhere.address = "198.51.100.9";
  EXPECT_TRUE(authenticator_.SignInHere(elsewhere).ok());
}

// Ten at once from each address, of which five may wait.
TEST_F(AuthenticatorTest, AnAddressHasABoundedNumberOfSignInsAtOnce) {
  AuthOptions options = Options();
  options.hash_threads = 1;
  options.max_waiting = 5;
  Authenticator small(*store_, options);
  boost::asio::io_context io;
  std::map<std::string, int> ok, refused;
  auto sign_in = [&](std::string address) -> boost::asio::awaitable<void> {
    SignInRequest request = Request("ada", kPassword);
    request.address = address;
    auto result = co_await small.SignIn(request);
    if (result.ok()) ++ok[address];
    if (result.status().code() == Code::kUnavailable) ++refused[address];
  };
  const std::string crowd = "203.0.113.7", other = "198.51.100.9";
  for (const std::string& address : {crowd, other}) {
    for (int i = 0; i < 10; ++i) {
      boost::asio::co_spawn(io, sign_in(address),
                            [](std::exception_ptr failure) { EXPECT_FALSE(failure); });
    }
  }
  io.run();
  for (const std::string& address : {crowd, other}) {
    EXPECT_EQ(ok[address] + refused[address], 10);
    EXPECT_GE(ok[address], 5);
  }
}

// 200 addresses that have failed before wait for the one thread; the owner comes last, to a new
// place, and waits for few of them.
TEST_F(AuthenticatorTest, TheOwnerAtANewPlaceDoesNotWaitForEveryGuesser) {
  AuthOptions options = Options();
  options.hash_threads = 1;
  std::string order;
  std::binary_semaphore begin{0};
  options.verify = [&](std::string_view password, const std::string&) {
    if (order.empty()) begin.acquire();
    order += password == kPassword ? '!' : '.';
    return password == kPassword;
  };
  Authenticator guessed(*store_, options);
  const auto request = [](int i) {
    SignInRequest out = Request("somebody" + std::to_string(i), "guess guess");
    out.address = "198.51." + std::to_string(i / 200) + "." + std::to_string(i % 200);
    return out;
  };
  begin.release();
  for (int i = 0; i < 200; ++i) {
    for (int n = 0; n < 4; ++n) (void)guessed.SignInHere(request(i));
  }
  order.clear();
  boost::asio::io_context io;
  const auto sign_in = [&](SignInRequest what) -> boost::asio::awaitable<void> {
    (void)co_await guessed.SignIn(std::move(what));
  };
  const auto spawn = [&](SignInRequest what) {
    boost::asio::co_spawn(io, sign_in(std::move(what)),
                          [](std::exception_ptr failure) { EXPECT_FALSE(failure); });
    io.poll();
  };
  for (int i = 0; i < 200; ++i) spawn(request(i));
  spawn(Request("ada", kPassword));
  begin.release();
  io.run();
  ASSERT_EQ(order.size(), 201u);
  EXPECT_LE(order.find('!'), 3u) << order;
}

TEST_F(AuthenticatorTest, ABrowserIsKnownToAServerThatStartsAgain) {
  const auto first = authenticator_.SignInHere(Request("ada", kPassword));
  ASSERT_TRUE(first.ok());
  Authenticator again(*store_, Options());
  for (int i = 0; i < 12; ++i) (void)again.SignInHere(Request("ada", "guess guess"));
  EXPECT_EQ(again.SignInHere(Request("ada", kPassword)).status().field(), "throttled");
  SignInRequest browser = Request("ada", kPassword);
  browser.device_tokens = first->device_tokens;
  EXPECT_TRUE(again.SignInHere(browser).ok());
  now_ += DeviceTokens::kDays * 24 * 60 * 60 * 1000;
  for (int i = 0; i < 12; ++i) (void)again.SignInHere(Request("ada", "guess guess"));
  EXPECT_FALSE(again.SignInHere(browser).ok()) << "a month later";
}

TEST_F(AuthenticatorTest, GuessesElsewhereDoNotDelayWhoIsSignedIn) {
  const auto in = authenticator_.SignInHere(Request("ada", kPassword));
  ASSERT_TRUE(in.ok());
  Authenticator again(*store_, Options());
  for (int i = 0; i < 40; ++i) (void)again.SignInHere(Request("ada", "guess guess"));
  boost::asio::io_context io;
  Status confirmed(Code::kInternal, "not asked");
  const auto confirm = [&]() -> boost::asio::awaitable<void> {
    confirmed = co_await again.Confirm(in->identity, kPassword, "203.0.113.7");
  };
  boost::asio::co_spawn(io, confirm(), [](std::exception_ptr failure) { EXPECT_FALSE(failure); });
  io.run();
  EXPECT_TRUE(confirmed.ok()) << confirmed.message();
}

TEST_F(AuthenticatorTest, AFailedSignInGivesItsPlaceBack) {
  AuthOptions options = Options();
  options.max_waiting = 1;
  bool fails = true;
  options.verify = [&](std::string_view password, const std::string& verifier) {
    if (fails) throw std::bad_alloc();
    return VerifyPassword(password, verifier);
  };
  Authenticator small(*store_, options);
  boost::asio::io_context io;
  int failures = 0, signed_in = 0;
  auto sign_in = [&]() -> boost::asio::awaitable<void> {
    auto result = co_await small.SignIn(Request("ada", kPassword));
    EXPECT_TRUE(result.ok()) << result.status().message();
    signed_in += result.ok() ? 1 : 0;
  };
  for (int i = 0; i < 2; ++i) {
    boost::asio::co_spawn(io, sign_in(),
                          [&](std::exception_ptr failure) { failures += failure ? 1 : 0; });
    io.run();
    io.restart();
  }
  EXPECT_EQ(failures, 2);
  fails = false;
  boost::asio::co_spawn(io, sign_in(), [](std::exception_ptr failure) { EXPECT_FALSE(failure); });
  io.run();
  EXPECT_EQ(signed_in, 1);
}

TEST(SignInPlacesTest, OwnersSignInWhileThreeAddressesGuess) {
  SignInPlaces places(64);
  places.Know("ada", "school");
  for (const char* guesser : {"a", "b", "c"}) {
    for (int i = 0; i < 100; ++i) (void)places.Take("ada", guesser, Line::kUsual);
  }
  for (int i = 0; i < 100; ++i)
    (void)places.Take("other" + std::to_string(i), "school", Line::kUsual);
  for (size_t i = 0; i < SignInPlaces::kMaxOfLogin; ++i) {
    const auto turn = places.Take("ada", "school", Line::kUsual);
    ASSERT_TRUE(turn) << "has signed in from there";
    EXPECT_EQ(turn->line, Line::kFirst);
  }
  EXPECT_FALSE(places.Take("ada", "school", Line::kUsual))
      << "two at once, and the school's places are taken";
  const auto turn = places.Take("ben", "at home", Line::kUsual);
  ASSERT_TRUE(turn) << "from an address where nobody has signed in";
  EXPECT_EQ(turn->line, Line::kUsual);
  EXPECT_EQ(turn->of, "at home") << "takes turns with the guessers' addresses";
  places.Leave(*turn);
}

TEST(SignInPlacesTest, WhoIsKnownToBeTheOwnerGoesFirstAndWhoGuessesLast) {
  SignInPlaces places(64);
  EXPECT_EQ(places.Take("ada", "=device 1", Line::kFirst, true)->line, Line::kFirst);
  EXPECT_EQ(places.Take("ada", "elsewhere", Line::kLast)->line, Line::kLast);
}

// A stolen chair that signs in without end makes the server hash one password at a time, 64 MiB.
TEST(SignInPlacesTest, AChairTakesTurnsAsOneAndHasOneThread) {
  SignInPlaces places(4);
  places.Know("ada", "=chair 1");
  size_t let_in = 0;
  for (const char* login : {"ada", "ben", "ada", "cem", "ada", "ada", "ben"}) {
    const auto turn = places.Take(login, "=chair 1", Line::kUsual, true);
    if (!turn) continue;
    ++let_in;
    EXPECT_EQ(turn->of, "=chair 1");
    EXPECT_EQ(turn->most, 1u);
  }
  EXPECT_EQ(let_in, 4u);
  EXPECT_GT(places.Take("ada", "school", Line::kUsual)->most, 2u) << "a school is many people";
}

TEST(SignInPlacesTest, AClassIsLetInFromOneAddressAndManyAddressesDoNotKeepOutOneMore) {
  SignInPlaces places(64);
  for (int i = 0; i < 60; ++i)
    EXPECT_TRUE(places.Take(std::to_string(i), "school", Line::kUsual)) << i;
  for (int address = 0; address < 300; ++address) {
    while (places.Take("x", std::to_string(address), Line::kUsual)) {
    }
  }
  EXPECT_TRUE(places.Take("new", "new", Line::kUsual));
}

TEST_F(AuthenticatorTest, SessionOfTheStationLinkDoesNotOpenThePage) {
  SignInRequest request = Request("ada", kPassword);
  request.via = kViaStation;
  auto at_station = authenticator_.SignInHere(request);
  ASSERT_TRUE(at_station.ok());
  EXPECT_TRUE(authenticator_.Authenticate(at_station->token).ok());
  EXPECT_EQ(authenticator_.AuthenticateHex(ToHex(at_station->token)).status().code(),
            Code::kUnauthenticated);
}

TEST(PasswordTest, VerifierIsArgon2idWithTheStatedCost) {
  auto verifier = HashPassword(kPassword);
  ASSERT_TRUE(verifier.ok());
  EXPECT_TRUE(verifier->starts_with("$argon2id$v=19$m=65536,t=2,p=1$")) << *verifier;
  EXPECT_TRUE(VerifyPassword(kPassword, *verifier));
  EXPECT_FALSE(VerifyPassword("correct horse", *verifier));
}

TEST(PasswordTest, OnePasswordIsTypedOnTheKeyboardsOfTwoSystems) {
  const auto verifier = HashPassword("Caf\u00e9 am\u00a0Zoo, viermal", kCheap);
  ASSERT_TRUE(verifier.ok());
  EXPECT_TRUE(VerifyPassword("Cafe\u0301 am Zoo, viermal", *verifier)) << "decomposed";
  EXPECT_FALSE(VerifyPassword("Cafe am Zoo, viermal", *verifier));
  EXPECT_FALSE(VerifyPassword("caf\u00e9 am Zoo, viermal", *verifier));
}

TEST(PasswordTest, PolicyRefusesShortCommonAndOwnLogin) {
  EXPECT_FALSE(CheckPasswordPolicy("short", "ada").ok());
  EXPECT_FALSE(CheckPasswordPolicy("Password123", "ada").ok());
  EXPECT_FALSE(CheckPasswordPolicy("Ada.Lovelace", "ada.lovelace").ok());
  std::string long_one;
  for (int i = 0; long_one.size() < 256; ++i) long_one += "a sentence of " + std::to_string(i * i);
  EXPECT_TRUE(CheckPasswordPolicy(long_one.substr(0, 256), "ada").ok());
  EXPECT_FALSE(CheckPasswordPolicy(long_one.substr(0, 255) + "ab", "ada").ok());
}

TEST(PasswordTest, WhatIsGuessedFirstIsRefused) {
  for (const char* guess :
       {"password12",       "welcome123",  "12345678910", "qwertz2026", "enamel2026",
        "P@ssw0rd!",        "Summer2026!", "iloveyou2",   "aaaaaaaaaa", "abcabcabc",
        "1q2w3e4r5t",       "asdfghjkl1",  "19840512",    "trustno1",   "ada.lovelace1",
        "passwordpassword", "Dental#2026", "zaq12wsx",    "0987654321", "letmein99"}) {
    EXPECT_FALSE(CheckPasswordPolicy(guess, "ada.lovelace").ok()) << guess;
  }
}

TEST(PasswordTest, WhatNobodyForetellsIsTaken) {
  for (const char* password :
       {"correct horse battery", "a drill and a spoon", "tq8#mvzk", "Grüße vom Zahn", "k3Jf9xQ2",
        "my tooth fell out in 2019", "8412907536281", "quite another one"}) {
    EXPECT_TRUE(CheckPasswordPolicy(password, "ada.lovelace").ok()) << password;
  }
}

TEST(TokenTest, CsrfDependsOnTheTokenAndDoesNotShowIt) {
  Bytes a = NewToken(), b = NewToken();
  EXPECT_EQ(CsrfFor(a), CsrfFor(a));
  EXPECT_NE(CsrfFor(a), CsrfFor(b));
  EXPECT_NE(CsrfFor(a), ToHex(a));
  EXPECT_TRUE(SameSecret("abc", "abc"));
  EXPECT_FALSE(SameSecret("abc", "abd"));
  EXPECT_FALSE(SameSecret("abc", "ab"));
}

}  // namespace
}  // namespace enamel::server::auth
