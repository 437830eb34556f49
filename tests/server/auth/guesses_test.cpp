#include "server/auth/guesses.h"

#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <string>

#include "server/auth/common_passwords.h"
#include "server/auth/password.h"

namespace enamel::server::auth {
namespace {

bool Taken(std::string_view password) {
  return CheckPasswordPolicy(password, "ada.lovelace", "Augusta King-Noel").ok();
}

TEST(CommonPasswordsTest, AreRankedAndNoneIsALineOfTheListsHead) {
  const auto& all = CommonPasswords();
  ASSERT_GT(all.size(), 40'000u);
  EXPECT_EQ(all.front(), "123456");
  EXPECT_EQ(CommonRank("123456"), 1);
  EXPECT_EQ(CommonRank("password"), 2);
  EXPECT_EQ(CommonRank("no such thing"), 0);
  for (std::string_view one : all) EXPECT_EQ(one.find(' '), std::string_view::npos) << one;
}

TEST(GuessesTest, OfTheCommonestPasswordsNoneIsTakenHoweverItIsDressed) {
  size_t tried = 0;
  for (std::string_view one : CommonPasswords()) {
    if (one.size() < kMinPasswordLength) continue;
    const std::string plain(one), backwards(one.rbegin(), one.rend());
    EXPECT_FALSE(Taken(plain)) << plain;
    if (++tried > 3000) continue;
    std::string capital = plain;
    capital[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(capital[0])));
    std::string disguised;
    for (char c : plain) disguised += c == 'a' ? '@' : c == 'o' ? '0' : c == 'e' ? '3' : c;
    for (const std::string& guess : {capital, plain + "1", capital + "!", plain + "123",
                                     capital + "2026", backwards, disguised, plain + plain}) {
      EXPECT_FALSE(Taken(guess)) << guess;
    }
  }
  EXPECT_GT(tried, 10'000u);
}

TEST(GuessesTest, RowsSequencesDatesRepeatsAndWhatIsKnownOfTheOwnerAreRefused) {
  for (const char* guess : {"1qaz2wsx3edc",
                            "yxcvbnm,",
                            "azertyuiop",
                            "zaq1xsw2",
                            "poiuytrewq",
                            "ijklmnopqr",
                            "2468101214",
                            "zyxwvuts",
                            "03.11.1984",
                            "1984-11-03",
                            "031119841",
                            "19841103",
                            "k7k7k7k7k7k7",
                            "ada.lovelace",
                            "lovelace2026",
                            "AugustaKing",
                            "ecalevol1",
                            "L0velace!",
                            "kingnoel12",
                            "Zahnarzt2026",
                            "M0lar!!!!",
                            "monkeydragon",
                            "Zürich2026",
                            "correct horse battery staple",
                            "Correct-Horse-Battery-Staple1!"}) {
    EXPECT_FALSE(Taken(guess)) << guess << " " << Log10Guesses(guess, {});
  }
}

TEST(GuessesTest, DemoPasswordOfItsOwnerIsRefused) {
  EXPECT_FALSE(CheckPasswordPolicy("enamel-demo-user4", "user4", "User Four").ok());
  EXPECT_FALSE(CheckPasswordPolicy("enamel-demo-student1", "student1", "Student One").ok());
}

TEST(GuessesTest, OrdinaryPassphrasesAreTaken) {
  for (const char* password :
       {"monkey dragon spoon", "the old brown tooth", "Der Zahn tut gar nicht weh",
        "correct-horse-3x", "three wet socks on a line", "my tooth fell out in 2019",
        "Schraube Lampe Regen Kamel"}) {
    EXPECT_TRUE(Taken(password)) << password << " " << Log10Guesses(password, {});
  }
}

// The count of a piece is a small sum that can be done by hand.
TEST(GuessesTest, CountsAreTheOnesOfTheTable) {
  EXPECT_DOUBLE_EQ(Log10Guesses("", {}), 0);
  EXPECT_DOUBLE_EQ(Log10Guesses("123456", {}), 0);                      // the first of the list
  EXPECT_DOUBLE_EQ(Log10Guesses("Password", {}), std::log10(2 * 2.0));  // the second, a capital
  EXPECT_DOUBLE_EQ(Log10Guesses("8#q~x%2^", {}), 8);                    // nothing explains it
  EXPECT_DOUBLE_EQ(Log10Guesses("xqzzyv", {"xqzzyv"}), 0);
  EXPECT_DOUBLE_EQ(Log10Guesses("xqzzyv7", {"xqzzyv"}), std::log10(10 * 2.0));  // two pieces
}

TEST(GuessesTest, WhatIsLongTakesNoLongerToJudge) {
  for (const std::string& long_one : {std::string(256, 'a'), std::string(256, '1'),
                                      std::string(64, 'x') + std::string(192, 'y')}) {
    EXPECT_FALSE(Taken(long_one));
  }
}

}  // namespace
}  // namespace enamel::server::auth
