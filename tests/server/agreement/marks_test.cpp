#include "server/agreement/marks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>

#include "common/base/file.h"

namespace enamel::server {
namespace {

std::string Golden() {
  auto text = ReadFile(ENAMEL_SOURCE_DIR "/schemas/golden/marks.csv", kMaxMarksBytes);
  EXPECT_TRUE(text.ok());
  return std::string(AsText(*text));
}

TEST(MarksTest, GoldenFileIsComparedByCriterion) {
  auto marks = ReadMarks(Golden());
  ASSERT_TRUE(marks.ok()) << marks.status().message();
  EXPECT_EQ(marks->size(), 13u) << "one was not given";
  auto criteria = CompareMarks(*marks);
  ASSERT_TRUE(criteria.ok());
  ASSERT_EQ(criteria->size(), 2u);
  const CriterionAgreement& floor = criteria->front();
  EXPECT_EQ(floor.criterion, "Floor");
  EXPECT_EQ(floor.markers, (std::vector<std::string>{"AK", "BM"}));
  EXPECT_EQ(floor.works, 4u);
  EXPECT_EQ(floor.left_out, 1u);
  // 8 5 9 6 against 7 5 10 5: mean of the differences 1/4, by hand.
  ASSERT_TRUE(floor.limits.at(0).limits);
  EXPECT_NEAR(floor.limits[0].limits->bias.value, 0.25, 1e-12);
  ASSERT_TRUE(floor.icc21.value);
  EXPECT_NEAR(floor.icc21.value->value, Icc21({{8, 7}, {5, 5}, {9, 10}, {6, 5}})->value, 1e-12);
  ASSERT_TRUE(floor.weighted_kappa.value);
  EXPECT_GT(floor.weighted_kappa.value->value, 0.7);
  const CriterionAgreement& wall = criteria->back();
  EXPECT_EQ(wall.criterion, "Wall, mesial");
  EXPECT_FALSE(wall.icc21.value) << "all have full marks: no figure, and why";
  EXPECT_NE(wall.icc21.why, "");
  EXPECT_EQ(wall.weighted_kappa.why, "all marks are the same");
  EXPECT_NE(wall.limits.at(0).why, "");
}

// Quadratic weights are by the marks: the same table as ICC's, whose value kappa then comes close
// to (Fleiss and Cohen 1973), although 2 to 8 are not used.
TEST(MarksTest, MarkBeyondTheFullMarksIsRefusedWithItsRow) {
  const std::string header = "work,criterion,full_marks,marker,mark\n";
  for (const char* row : {"1,c,10,a,75\n", "1,c,10,a,-1\n"}) {
    auto marks = ReadMarks(header + "1,c,10,b,10\n" + row);
    ASSERT_FALSE(marks.ok()) << row;
    EXPECT_EQ(marks.status().field(), "row 3") << marks.status().message();
  }
  EXPECT_TRUE(ReadMarks(header + "1,c,10,a,0\n1,d,,a,75\n1,e,ten,a,75\n").ok())
      << "how much there was to earn is not known";
}

TEST(MarksTest, KappaWeighsByTheMarksAndNotByTheirPlaceInTheList) {
  std::vector<Mark> marks;
  const double first[] = {1, 1, 9, 10, 1, 10, 9, 1}, second[] = {1, 1, 10, 9, 1, 10, 9, 1};
  for (int i = 0; i < 8; ++i) {
    marks.push_back({std::to_string(i), "c", "a", first[i]});
    marks.push_back({std::to_string(i), "c", "b", second[i]});
  }
  auto criteria = CompareMarks(marks);
  ASSERT_TRUE(criteria.ok() && criteria->front().weighted_kappa.value);
  EXPECT_GT(criteria->front().weighted_kappa.value->value, 0.98);
}

TEST(MarksTest, WhatIsWrongIsRefusedWithItsRow) {
  auto why = [](const char* text) {
    auto marks = ReadMarks(text);
    return marks.ok() ? std::string("accepted") : marks.status().message();
  };
  EXPECT_NE(why("").find("header"), std::string::npos);
  EXPECT_NE(why("work,criterion,marker\n").find("a column mark"), std::string::npos);
  EXPECT_NE(why("work,criterion,marker,mark,maker\n").find("\"maker\""), std::string::npos);
  EXPECT_NE(why("work,work,criterion,marker,mark\n").find("once"), std::string::npos);
  EXPECT_NE(why("work,criterion,marker,mark\n1,c,a,\"7,5\"\n").find("row 2"), std::string::npos);
  EXPECT_NE(why("work,criterion,marker,mark\n1,c,a,4,5\n").find("not a comma"), std::string::npos)
      << "4,5 without quotes is no 4";
  EXPECT_EQ(why("work,criterion,marker,mark\n1,c,a,4,,\n"), "accepted");
  EXPECT_NE(why("work,criterion,marker,mark\n1,c,a,nan\n").find("a number"), std::string::npos);
  EXPECT_NE(why("work,criterion,marker,mark\n1,c,,7\n").find("marker"), std::string::npos);
  EXPECT_NE(why("work,criterion,marker,mark\n1,c,a,1e999\n").find("a number"), std::string::npos);
  EXPECT_NE(why(("work,criterion,marker,mark\n1," + std::string(300, 'c') + ",a,7\n").c_str())
                .find("criterion of 1 to 200"),
            std::string::npos);
  EXPECT_EQ(ReadMarks("work,criterion,marker,mark\n1,c,a,\n")->size(), 0u);
  EXPECT_FALSE(CompareMarks({}).ok());
  auto twice = CompareMarks({{"1", "c", "a", 7}, {"1", "c", "a", 8}});
  ASSERT_FALSE(twice.ok());
  EXPECT_NE(twice.status().message().find("twice"), std::string::npos);
}

TEST(MarksTest, TablesSayEachFigureOrWhyThereIsNone) {
  auto criteria = CompareMarks(*ReadMarks(Golden()));
  const std::string csv = AgreementCsv(*criteria);
  EXPECT_EQ(csv.substr(0, csv.find('\r')),
            "criterion,figure,first,second,value,low,high,works,why");
  EXPECT_NE(csv.find("Floor,bias,AK,BM,0.2500,"), std::string::npos) << csv;
  EXPECT_NE(csv.find("\"Wall, mesial\",weighted kappa,,,,,,2,all marks are the same"),
            std::string::npos)
      << csv;
  boost::json::value json = boost::json::parse(AgreementJson(*criteria));
  EXPECT_EQ(json.at("criteria").at(0).at("works"), 4);
  EXPECT_TRUE(json.at("criteria").at(1).at("icc_2_1").at("value").is_null());
  EXPECT_NEAR(json.at("criteria")
                  .at(0)
                  .at("limits_of_agreement")
                  .at(0)
                  .at("bias")
                  .at("value")
                  .to_number<double>(),
              0.25, 1e-12);
}

TEST(MarksTest, ProgramIsComparedWithPeopleAndIsNoneOfThem) {
  std::vector<Mark> people, all;
  const double first[] = {8, 5, 9, 6, 3}, second[] = {7, 5, 10, 5, 4}, program[] = {1, 9, 2, 8, 7};
  for (int i = 0; i < 5; ++i) {
    people.push_back({std::to_string(i), "c", "AK", first[i]});
    people.push_back({std::to_string(i), "c", "BM", second[i]});
  }
  all = people;
  // Of one the program has no mark: people's figures keep it.
  for (int i = 0; i < 4; ++i) {
    all.push_back({std::to_string(i), "c", std::string(kComputed), program[i]});
  }
  const CriterionAgreement alone = CompareMarks(people)->front(), both = CompareMarks(all)->front();
  EXPECT_FALSE(alone.computed);
  EXPECT_EQ(both.markers, alone.markers);
  EXPECT_EQ(both.works, 5u);
  EXPECT_EQ(both.left_out, 0u);
  EXPECT_EQ(both.icc21.value->value, alone.icc21.value->value);
  EXPECT_EQ(both.icc3k.value->value, alone.icc3k.value->value);
  EXPECT_EQ(both.weighted_kappa.value->value, alone.weighted_kappa.value->value);
  EXPECT_TRUE(both.computed);
  EXPECT_EQ(both.computed_works, 4u);
  EXPECT_EQ(both.computed_icc21.value->value, Icc21({{7.5, 1}, {5, 9}, {9.5, 2}, {5.5, 8}})->value);
  ASSERT_EQ(both.limits.size(), 3u) << "AK with BM, and each with the program";
  EXPECT_EQ(both.limits[1].second, kComputed);
  EXPECT_NE(AgreementCsv({both}).find("c,\"ICC(2,1)\",mean,computed,"), std::string::npos)
      << AgreementCsv({both});
  const auto json = boost::json::parse(AgreementJson({both}));
  EXPECT_EQ(json.at("criteria").at(0).at("computed").at("works"), 4);
}

TEST(MarksTest, OneMarkerAloneGetsOneSentenceInPlaceOfFigures) {
  auto criteria = CompareMarks({{"1", "c", "AK", 7}, {"2", "c", "AK", 8}});
  ASSERT_TRUE(criteria.ok());
  const CriterionAgreement& alone = criteria->front();
  EXPECT_EQ(alone.why.find("agreement needs a second marker, as only AK marked this: let another"),
            0u)
      << alone.why;
  EXPECT_FALSE(alone.icc21.value);
  EXPECT_FALSE(alone.free_kappa.value);
  EXPECT_TRUE(alone.limits.empty());
  const auto json = boost::json::parse(AgreementJson(*criteria)).at("criteria").at(0).as_object();
  EXPECT_EQ(json.at("why"), alone.why.c_str());
  for (const char* figure : {"icc_2_1", "icc_3_k", "phi", "weighted_kappa", "free_kappa"}) {
    EXPECT_FALSE(json.contains(figure)) << figure;
  }
  const std::string csv = AgreementCsv(*criteria);
  EXPECT_EQ(std::ranges::count(csv, '\n'), 2) << csv;
  EXPECT_NE(csv.find("c,agreement,AK,,,,,2,\"agreement needs a second marker, "), std::string::npos)
      << csv;
}

TEST(MarksTest, OneMarkerIsStillComparedWithTheProgram) {
  std::vector<Mark> marks;
  for (int i = 0; i < 4; ++i) {
    marks.push_back({std::to_string(i), "c", "AK", double(i)});
    marks.push_back({std::to_string(i), "c", std::string(kComputed), double(i) + i % 2});
  }
  const CriterionAgreement alone = CompareMarks(marks)->front();
  EXPECT_NE(alone.why, "");
  EXPECT_TRUE(alone.computed_icc21.value);
  ASSERT_EQ(alone.limits.size(), 1u);
  EXPECT_TRUE(alone.limits[0].limits);
  marks.push_back({"0", "c", "BM", 1});
  EXPECT_EQ(CompareMarks(marks)->front().why, "") << "two, of whom one marked little";
  const CriterionAgreement nobody = CompareMarks({{"1", "c", std::string(kComputed), 7}})->front();
  EXPECT_NE(nobody.why.find("as nobody marked this"), std::string::npos) << nobody.why;
}

}  // namespace
}  // namespace enamel::server
