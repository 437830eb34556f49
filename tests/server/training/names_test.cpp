#include "server/training/names.h"

#include <gtest/gtest.h>

namespace enamel::server {
namespace {

TEST(NamesTest, LoginsAreKeptInLowerCaseWithoutSpacesAround) {
  EXPECT_EQ(*CheckedLogin(" Ada.Meyer-2_x@Dental "), "ada.meyer-2_x@dental");
  EXPECT_TRUE(CheckedLogin(std::string(64, 'a')).ok());
}

TEST(NamesTest, LoginsThatAreNoneAreRefusedWithWhatWasFound) {
  for (const std::string text : {"", " ", "a b", "@ada", "-x", "ad\xc3\xa4", "a/b", "a'--"}) {
    Result<std::string> login = CheckedLogin(text);
    ASSERT_FALSE(login.ok()) << text;
    EXPECT_EQ(login.status().field(), "login");
    EXPECT_EQ(login.status().code(), Code::kInvalidInput);
  }
  EXPECT_NE(CheckedLogin(std::string(65, 'a')).status().message().find("65 bytes"),
            std::string::npos);
}

TEST(NamesTest, NamesOfPeopleEverywhereAreNames) {
  for (const char* name :
       {"Zoë Müller", "李 小龍", "O'Brien", "Ng", "Дмитрий", "Łukasz (2)", "5th"}) {
    Result<std::string> checked = CheckedName(name, "display_name");
    ASSERT_TRUE(checked.ok()) << name << ": " << checked.status().message();
    EXPECT_EQ(*checked, name);
  }
}

TEST(NamesTest, WordsThatMixScriptsAreNoNamesOfPeople) {
  for (const char* name :
       {"Zoë Müller", "李 小龍", "李David", "Ольга Müller", "Müller-Παπαδόπουλος", "O'Brien", "Ng",
        "Дмитрий", "Łukasz (2)", "山田 太郎 たろう", "김철수", "Nguyễn Thị Hương", "प्रिया",
        "Γιώργος Νικολάου", "王伟3"}) {
    EXPECT_EQ(CheckedPersonName(name, "name").value(), name);
  }
  for (const char* name : {"\u0430dmin", "Anna M\u043eller", "Paul \u0391da", "Ив\u0061н"}) {
    const Status refused = CheckedPersonName(name, "name").status();
    EXPECT_EQ(refused.field(), "name") << name;
    EXPECT_NE(refused.message().find("mixes several"), std::string::npos) << refused.message();
  }
}

TEST(NamesTest, NamesOfAnotherScriptThatLookLatinAreKnown) {
  const char* const copa = "\u0421\u043e\u0440\u0430";  // Cyrillic
  EXPECT_TRUE(LooksLatin(copa));
  EXPECT_EQ(LookOf(copa), LookOf("copa"));
  EXPECT_NE(LookOf(copa), LookOf("cope"));
  for (const char* name : {"Copa", "Zoë", "Дмитрий", "Ольга", "王伟", "Γιώργος", "김철수"}) {
    EXPECT_FALSE(LooksLatin(name)) << name;
  }
}

TEST(NamesTest, FormulasControlsAndBrokenTextAreNoNames) {
  for (const std::string name : {"=1+1",
                                 "+49 30",
                                 "-2",
                                 "@SUM(A1)",
                                 " =x",
                                 "",
                                 "a\tb",
                                 "a\nb",
                                 "a\x7f",
                                 "\xc2\x85x",
                                 "\xe2\x80\xae"
                                 "abc",
                                 "\xe2\x81\xa6x",
                                 "\xef\xbb\xbfx",
                                 "M\xfcller",
                                 "\xc0\xaf",
                                 "\xed\xa0\x80",
                                 "\xf4\x90\x80\x80",
                                 "\u200b",
                                 " \u00a0\u200b ",
                                 "\u3164",
                                 "\xe2\x82",
                                 "\xf8\x88\x80\x80\x80"}) {
    Result<std::string> checked = CheckedName(name, "display_name");
    EXPECT_FALSE(checked.ok()) << testing::PrintToString(name);
    EXPECT_EQ(checked.status().field(), "display_name");
  }
  EXPECT_FALSE(CheckedName(std::string(201, 'a'), "name").ok());
  EXPECT_TRUE(CheckedName(std::string(200, 'a'), "name").ok());
}

TEST(NamesTest, JoinersInsideANameStay) {
  EXPECT_TRUE(CheckedName("\u0646\u06cc\u200c\u06a9", "display_name").ok());
}

TEST(NamesTest, KeysOfNamesThatPeopleTakeForOneAreEqual) {
  EXPECT_EQ(NameKey("Year 3"), NameKey(" year  3 "));
  EXPECT_NE(NameKey("Year 3"), NameKey("Year 31"));
  EXPECT_NE(NameKey("Year 3"), NameKey("Year3"));
}

TEST(NamesTest, NamesThatLookTheSameAreTheSame) {
  EXPECT_EQ(*CheckedName("U\u0308bung\u00a0A", "name"), "\u00dcbung A");
  EXPECT_EQ(*CheckedName("\u202fZo\u00eb\u2007", "name"), "Zo\u00eb");
  EXPECT_EQ(Composed("no \xff text"), "no \xff text");
}

TEST(NamesTest, SearchedNamesLoseCaseAndAccents) {
  EXPECT_EQ(SearchName("Zoë ÑANDÚ-O'Brien 2"), "zoe nandu-o'brien 2");
  EXPECT_EQ(SearchName("Zoe\u0308 N\u0303andu\u0301"), "zoe nandu") << "decomposed";
  EXPECT_EQ(SearchName("Łukasz Groß, Ærø Ðorđe"), "lukasz gross, aero dorde");
  EXPECT_EQ(SearchName("Nguyễn Thị Hương"), "nguyen thi huong");
  EXPECT_EQ(SearchName("Şükrü İnan ışık"), "sukru inan isik");
  EXPECT_EQ(SearchName("Αλέξανδρος ΆΓΓΕΛΟΣ"), "αλεξανδροσ αγγελοσ");
  EXPECT_EQ(SearchName("Юрий ЁЖИКОВ"), "юрии ежиков");
  EXPECT_EQ(SearchName("Ｙａｍａｄａ ﬁlip"), "yamada filip");
  EXPECT_EQ(SearchName("Ġgant ŽIŽEK"), "ggant zizek");
}

TEST(NamesTest, OtherTextIsSearchedAsItIs) {
  EXPECT_EQ(SearchName("王伟 김철수 प्रिया"), "王伟 김철수 प्रिया");
  EXPECT_EQ(SearchName("a\xff\xc3 b"), "a\xff\xc3 b") << "no UTF-8";
  EXPECT_EQ(SearchName(""), "");
}

// A word is folded when it is typed, and a name when it is stored.
TEST(NamesTest, WhatIsFoldedStaysWhenItIsFoldedAgain) {
  for (uint32_t code = 0x80; code < 0x10000; ++code) {
    if (code >= 0xd800 && code < 0xe000) continue;
    std::string text;
    text += static_cast<char>(code < 0x800 ? 0xc0 | (code >> 6) : 0xe0 | (code >> 12));
    if (code >= 0x800) text += static_cast<char>(0x80 | ((code >> 6) & 0x3f));
    text += static_cast<char>(0x80 | (code & 0x3f));
    const std::string once = SearchName(text);
    ASSERT_EQ(SearchName(once), once) << std::hex << code;
  }
}

}  // namespace
}  // namespace enamel::server
