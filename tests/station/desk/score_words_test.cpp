#include "station/words/score_words.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <filesystem>

#include "common/base/file.h"
#include "tests/station/desk/english.h"

namespace enamel::station::desk {
namespace {

using language::Language;

// A criterion that the golden file describes.
scoring::CriterionResult CriterionOf(const boost::json::object& told) {
  scoring::CriterionResult out;
  const auto text = [&](const char* member) { return std::string(told.at(member).as_string()); };
  out.name = text("metric");
  out.title = text("title");
  out.unit = text("unit");
  out.comment = text("comment");
  out.reason = "as the server says";
  for (const auto& reason : told.at("reasons").as_array()) {
    out.reasons.push_back({std::string(reason.at("code").as_string()),
                           boost::json::value_to<std::vector<double>>(reason.at("values")),
                           boost::json::value_to<std::vector<std::string>>(reason.at("units"))});
  }
  return out;
}

// The page's test reads the same file (web/src/api/worded.test.ts).
TEST(ScoreWordsTest, ReasonsAreSaidAsThePageSaysThem) {
  auto bytes =
      ReadFile(std::filesystem::path(ENAMEL_SOURCE_DIR) / "schemas/golden/reasons_said.json");
  ASSERT_TRUE(bytes.ok()) << bytes.status().message();
  const auto golden = boost::json::parse(std::string(bytes->begin(), bytes->end()));
  size_t said = 0;
  for (const auto& each : golden.at("cases").as_array()) {
    const scoring::CriterionResult criterion = CriterionOf(each.as_object());
    for (Language language : language::kLanguages) {
      const Words words(language);
      EXPECT_EQ(ReasonText(words, criterion),
                std::string(each.at("said").at(CodeOf(language)).as_string()));
      ++said;
    }
  }
  EXPECT_GT(said, 50u);
}

TEST(ScoreWordsTest, WhatIsNotKnownHereIsTheServersOwnText) {
  scoring::CriterionResult hand;
  hand.name = "force_sent_p95_n";
  hand.reason = "as the server says";
  EXPECT_EQ(ReasonText(kEnglish, hand), "as the server says");
  hand.reasons = {{"any", {50}, {"N"}}, {"something_new", {1}, {"mm"}}};
  EXPECT_EQ(ReasonText(kEnglish, hand), "as the server says");
  // A known code with too few values, from a faulty server.
  for (const char* code : {"within", "between", "fails_above", "any", "device_limit"}) {
    hand.reasons = {{code, {}, {}}};
    EXPECT_EQ(ReasonText(kEnglish, hand), "as the server says") << code;
  }
}

// Every built-in text (tests/common/scene compares the list with the code's).
TEST(ScoreWordsTest, EveryBuiltInTextHasWordsInEveryLanguage) {
  auto bytes =
      ReadFile(std::filesystem::path(ENAMEL_SOURCE_DIR) / "schemas/golden/builtin_words.txt");
  ASSERT_TRUE(bytes.ok()) << bytes.status().message();
  std::istringstream lines(std::string(bytes->begin(), bytes->end()));
  const Words german(Language::kGerman), chinese(Language::kChinese);
  size_t titles = 0, texts = 0;
  for (std::string line; std::getline(lines, line);) {
    const bool title = line.starts_with("title ");
    const std::string text = line.substr(line.find(' ') + 1);
    ++(title ? titles : texts);
    for (const Words* words : {&german, &chinese}) {
      EXPECT_NE(title ? WordedTitle(*words, text) : WordedText(*words, text), text);
    }
  }
  EXPECT_GT(titles, 0U);
  EXPECT_GT(texts, 0U);
}

TEST(ScoreWordsTest, NumbersOfABuiltInTextStayItsOwn) {
  const Words german(Language::kGerman);
  EXPECT_EQ(WordedTitle(german, "Line, 8 x 1.5 mm and 2.0 mm deep"),
            "Linie, 8 x 1,5 mm und 2,0 mm tief");
}

TEST(ScoreWordsTest, WhatASchoolHasWrittenStaysAsItWasTyped) {
  const Words german(Language::kGerman);
  for (const char* text : {"Prepare like Monday's patient", "", ".", " ", "3",
                           "Do not expose the pulp. Ask Dr Lee first.", "Ä. Ö. ü"}) {
    EXPECT_EQ(WordedTitle(german, text), text);
    EXPECT_EQ(WordedText(german, text), text);
  }
  // Built in except for a number that no double holds.
  const std::string huge = "Line, " + std::string(400, '9') + " x 1.5 mm and 2.0 mm deep";
  EXPECT_EQ(WordedTitle(german, huge), huge);
}

TEST(ScoreWordsTest, NumbersHaveNoZerosAtTheirEnd) {
  const Words german(Language::kGerman);
  EXPECT_EQ(NumberText(german, 10, 1), "10");
  EXPECT_EQ(NumberText(german, 9.5, 1), "9,5");
  EXPECT_EQ(NumberText(german, 0, 1), "0");
  EXPECT_EQ(NumberText(german, 100, 0), "100");
}

}  // namespace
}  // namespace enamel::station::desk
