#include "common/language/score_text.h"

#include <gtest/gtest.h>

#include <set>

namespace enamel::language {
namespace {

using scoring::Mistake;
using scoring::MistakeKind;

const Words& English() {
  static const Words words(Language::kEnglish);
  return words;
}

Mistake MistakeOf(MistakeKind kind, const char* place, double size) {
  Mistake out;
  out.kind = kind;
  out.place = place;
  out.size = size;
  return out;
}

TEST(ScoreTextTest, EveryMistakeHasASentenceAndARemedyOfItsOwnInEveryLanguage) {
  for (Language language : kLanguages) {
    const Words words(language);
    std::set<std::string> remedies;
    for (size_t i = 0; i < scoring::kMistakeKinds; ++i) {
      const Mistake m = MistakeOf(static_cast<MistakeKind>(i), "", 1);
      const std::string name(NameOf(m.kind));
      EXPECT_TRUE(words.Has("mistake." + name)) << CodeOf(language) << " " << name;
      EXPECT_TRUE(words.Has("mistake_do." + name)) << CodeOf(language) << " " << name;
      remedies.insert(RemedyText(words, m));
    }
    EXPECT_EQ(remedies.size(), scoring::kMistakeKinds) << CodeOf(language);
  }
}

TEST(ScoreTextTest, EveryRegionGroupAndStateHasWordsInEveryLanguage) {
  for (Language language : kLanguages) {
    const Words words(language);
    for (const char* place : {"wall",
                              "wall_mesial",
                              "wall_distal",
                              "wall_buccal",
                              "wall_lingual",
                              "wall_gingival",
                              "wall_occlusal",
                              "floor",
                              "floor_1",
                              "floor_2",
                              "floor_3",
                              "table",
                              "axial",
                              "axial_mesial",
                              "axial_distal",
                              "axial_buccal",
                              "axial_lingual",
                              "cusp_buccal",
                              "cusp_lingual",
                              "cusp_mesiobuccal",
                              "cusp_mesiolingual",
                              "cusp_distobuccal",
                              "cusp_distolingual",
                              "margin",
                              "margin_mesial",
                              "margin_distal",
                              "margin_buccal",
                              "margin_lingual",
                              "face",
                              "face_middle",
                              "face_cervical",
                              "face_incisal",
                              "face_buccal",
                              "face_lingual",
                              "line_angles"}) {
      EXPECT_NE(PlaceText(words, place), place) << CodeOf(language);
    }
    for (size_t i = 0; i < scoring::kGroups; ++i) {
      const auto group = static_cast<scoring::Group>(i);
      EXPECT_TRUE(words.Has("group." + std::string(NameOf(group)))) << NameOf(group);
      EXPECT_EQ(GroupText(words, group), words.Say("group." + std::string(NameOf(group))));
    }
    for (auto state :
         {scoring::State::kAcceptable, scoring::State::kModify, scoring::State::kRedo}) {
      EXPECT_TRUE(words.Has("grade_state." + std::string(NameOf(state)))) << NameOf(state);
    }
  }
}

TEST(ScoreTextTest, AMistakeIsSaidWithItsPlaceAndSize) {
  const std::string said =
      MistakeText(English(), MistakeOf(MistakeKind::kOverExtended, "wall_distal", 0.3249));
  EXPECT_NE(said.find(PlaceText(English(), "wall_distal")), said.npos) << said;
  EXPECT_NE(said.find("0.32 mm"), said.npos) << said;
  const Words german(Language::kGerman);
  EXPECT_NE(MistakeText(german, MistakeOf(MistakeKind::kDeep, "floor", 0.3)).find("0,30 mm"),
            said.npos);
}

TEST(ScoreTextTest, ASizeIsAsFineAsPeopleActOnIt) {
  EXPECT_EQ(SizeText(English(), MistakeOf(MistakeKind::kDeep, "floor", 0.2951)), "0.30 mm");
  EXPECT_EQ(SizeText(English(), MistakeOf(MistakeKind::kTurned, "", 7.6)), "7.6\u00b0");
  EXPECT_EQ(SizeText(English(), MistakeOf(MistakeKind::kHole, "", 1.234)), "1.23 mm\u00b3");
  EXPECT_EQ(SizeText(English(), MistakeOf(MistakeKind::kNotDone, "", 12.4)), "12 %");
  EXPECT_EQ(SizeText(English(), MistakeOf(MistakeKind::kNotDone, "", 0.4)), "0.4 %") << "never 0";
}

TEST(ScoreTextTest, APlaceOfANewerServerKeepsItsName) {
  EXPECT_EQ(PlaceText(English(), "wall_palatal"), "wall_palatal");
  EXPECT_EQ(PlaceText(English(), ""), "");
}

}  // namespace
}  // namespace enamel::language
