#include "common/language/words.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <map>

#include "common/language/catalogues.h"

namespace enamel::language {
namespace {

std::map<std::string, std::string> ByKey(Language language) {
  std::map<std::string, std::string> out;
  for (const Message& m : MessagesOf(language)) out[m.key] = m.pattern;
  return out;
}

TEST(WordsTest, EveryLanguageSaysTheSameThings) {
  const auto english = ByKey(Language::kEnglish);
  ASSERT_GT(english.size(), 200u);
  for (Language each : kLanguages) {
    const auto theirs = ByKey(each);
    for (const auto& [key, pattern] : english) {
      EXPECT_TRUE(theirs.contains(key)) << CodeOf(each) << " does not say " << key;
    }
    for (const auto& [key, pattern] : theirs) {
      EXPECT_TRUE(english.contains(key)) << CodeOf(each) << " says more: " << key;
    }
    EXPECT_EQ(theirs.size(), MessagesOf(each).size()) << "a key is there twice";
  }
}

TEST(WordsTest, EveryMessageHasTheSamePlacesInEveryLanguage) {
  const auto english = ByKey(Language::kEnglish);
  for (Language each : kLanguages) {
    for (const Message& m : MessagesOf(each)) {
      const Places mine = PlacesOf(each, m.pattern);
      EXPECT_EQ(mine.problem, "") << CodeOf(each) << " " << m.key;
      EXPECT_EQ(mine.names, PlacesOf(Language::kEnglish, english.at(m.key)).names)
          << CodeOf(each) << " " << m.key;
    }
  }
}

// German had one word for giving an attempt up and for leaving a dialog.
TEST(WordsTest, WhatLosesSomethingIsCalledOtherwiseThanWhatLosesNothing) {
  const char* loses[] = {"close.close",         "cut_off.hand_in", "finish.hand_in",
                         "hand_in.give_up_end", "paused.give_up",  "pin.give_back",
                         "sign_off.unsigned"};
  const char* loses_nothing[] = {"close.stay",    "cut_off.later", "exercise.back", "finish.go_on",
                                 "hand_in.leave", "paused.go_on",  "pin.leave"};
  for (Language each : kLanguages) {
    const auto say = ByKey(each);
    for (const char* one : loses) {
      for (const char* other : loses_nothing) {
        EXPECT_NE(say.at(one), say.at(other)) << CodeOf(each) << " " << one << ", " << other;
      }
    }
  }
}

// An apostrophe begins what ICU leaves alone, and a translator does not see it; two spaces come
// from joined lines.
TEST(WordsTest, NoMessageHasWhatATranslatorCannotSee) {
  for (Language each : kLanguages) {
    for (const Message& m : MessagesOf(each)) {
      EXPECT_EQ(m.pattern.find('\''), std::string::npos) << CodeOf(each) << " " << m.key;
      EXPECT_EQ(m.pattern.find('\n'), std::string::npos) << CodeOf(each) << " " << m.key;
      EXPECT_FALSE(m.pattern.empty()) << CodeOf(each) << " " << m.key;
      EXPECT_FALSE(m.pattern.ends_with(' ')) << CodeOf(each) << " " << m.key;
    }
  }
}

TEST(WordsTest, ACatalogueIsOfTheVersionThatIsDescribed) {
  ASSERT_FALSE(Catalogues().empty());
  for (const Catalogue& file : Catalogues()) {
    const auto document = boost::json::parse(file.text).as_object();
    EXPECT_EQ(document.at("version"), 1) << file.language << "/" << file.part;
    EXPECT_EQ(document.size(), 2u) << file.language << "/" << file.part;
  }
}

TEST(WordsTest, CountsDecideOnPlurals) {
  const Words english(Language::kEnglish), german(Language::kGerman), chinese(Language::kChinese);
  auto span = [](const Words& words, int64_t minutes) {
    return words.Say("span.minutes", {{"count", minutes}});
  };
  EXPECT_EQ(span(english, 0), "less than a minute");
  EXPECT_EQ(span(english, 1), "1 minute");
  EXPECT_EQ(span(english, 2), "2 minutes");
  EXPECT_EQ(span(german, 1), "1 Minute");
  EXPECT_EQ(span(german, 21), "21 Minuten");
  EXPECT_EQ(span(chinese, 21), " 21 分钟");
}

TEST(WordsTest, WhatIsFilledInIsNoPattern) {
  const Words words(Language::kEnglish);
  for (const char* name : {"{name}", "O'Brien", "'{", "{0, plural, one {", "李", ""}) {
    EXPECT_EQ(words.Say("exercises.hello", {{"name", std::string(name)}}),
              "Hello, " + std::string(name));
  }
}

TEST(WordsTest, AKeyThatNobodyKnowsIsSaidAsItIs) {
  EXPECT_EQ(Words(Language::kGerman).Say("of.tomorrow"), "of.tomorrow");
}

TEST(WordsTest, DecimalsAreWrittenAsTheLanguageHasIt) {
  EXPECT_EQ(Words(Language::kEnglish).Decimal(0.295, 2), "0.29");  // the double lies below 0.295
  EXPECT_EQ(Words(Language::kGerman).Decimal(-1234.5, 1), "-1234,5");
  EXPECT_EQ(Words(Language::kChinese).Decimal(3, 0), "3");
  EXPECT_EQ(Words(Language::kGerman).Decimal(1e300, 1).size(), 303u);
}

TEST(WordsTest, ALocaleNamesItsLanguage) {
  EXPECT_EQ(LanguageOf("de"), Language::kGerman);
  EXPECT_EQ(LanguageOf("de_AT.UTF-8"), Language::kGerman);
  EXPECT_EQ(LanguageOf("zh-Hans-CN"), Language::kChinese);
  EXPECT_EQ(LanguageOf("en"), Language::kEnglish);
  for (const char* none : {"", "C", "POSIX", "den", "fr_FR", "-de"}) {
    EXPECT_FALSE(LanguageOf(none)) << none;
  }
}

}  // namespace
}  // namespace enamel::language
