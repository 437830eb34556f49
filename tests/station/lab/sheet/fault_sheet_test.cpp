#include "station/lab/sheet/fault_sheet.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/scoring/mistakes/mistakes.h"
#include "station/lab/sheet/section.h"

// The sheet of `enamel-lab reasons`.
namespace enamel::station::lab {
namespace {

using language::Language;
using language::Words;

size_t CountOf(std::string_view text, std::string_view part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++count;
  return count;
}

// The card of a mistake: from its heading's article to the article's end.
std::string_view CardOf(std::string_view sheet, std::string_view fault) {
  const size_t from = sheet.find("<article id=\"" + std::string(fault) + "\">");
  if (from == sheet.npos) return "";
  return sheet.substr(from, sheet.find("</article>", from) - from);
}

// What no kind explains has no picture.
std::vector<scoring::MistakeKind> Kinds() {
  std::vector<scoring::MistakeKind> out;
  for (size_t i = 0; i < scoring::kMistakeKinds; ++i) {
    const auto kind = static_cast<scoring::MistakeKind>(i);
    if (kind != scoring::MistakeKind::kUneven) out.push_back(kind);
  }
  return out;
}

TEST(FaultSheetTest, EveryMistakeIsThereWithItsPictureReasonAndAdvice) {
  const Words words(Language::kGerman);
  const auto made = FaultSheet({.language = Language::kGerman, .voxel_nm = 100'000});
  ASSERT_TRUE(made.ok()) << made.status().message();
  const std::string& sheet = *made;
  EXPECT_EQ(CountOf(sheet, "<article"), Kinds().size() + 1);
  for (const scoring::MistakeKind kind : Kinds()) {
    const std::string name(NameOf(kind));
    const std::string_view card = CardOf(sheet, name);
    EXPECT_NE(card.find(words.Say("fault_why." + name)), card.npos) << name;
    EXPECT_NE(card.find(words.Say("mistake_do." + name)), card.npos) << name;
    EXPECT_EQ(CountOf(card, "<svg"), 2u) << name;
    EXPECT_TRUE(card.find("\"over\"") != card.npos || card.find("\"left\"") != card.npos)
        << name << " is not marked";
  }
  EXPECT_EQ(CountOf(CardOf(sheet, "heavy_hand"), "<svg"), 2u);
  // What is said is what was measured on the picture's cut, 0.3 mm.
  const std::string_view deep = CardOf(sheet, "deep");
  EXPECT_TRUE(deep.find("0,29") != deep.npos || deep.find("0,3") != deep.npos) << deep;
  for (const char* other_place :
       {"<script", "http", "src=", "@import", "fault_", "reason.", "mistake."}) {
    EXPECT_EQ(sheet.find(other_place), sheet.npos) << other_place;
  }
}

TEST(FaultSheetTest, EveryLanguageHasAReasonForEveryMistake) {
  for (Language language : language::kLanguages) {
    const Words words(language);
    for (const scoring::MistakeKind kind : Kinds()) {
      EXPECT_TRUE(words.Has("fault_why." + std::string(NameOf(kind)))) << NameOf(kind);
    }
  }
}

// 3 x 2.4 mm and 2 mm deep; the cut goes 0.5 mm beyond the wall at +x.
TEST(SectionTest, ASectionShowsWhatDiffersToScaleAndNothingWhereNothingDoes) {
  const cutting::Volume block = FaultBlock({});
  const BoxCavity wanted = FaultBlockCavity();
  BoxCavity taken = wanted;
  taken.faces[0].moved_m = 0.5e-3;
  const auto hollow = [](const BoxCavity& box) -> Hollow {
    return [box](const dvec3& p) { return box.Distance_m(p); };
  };
  const std::string drawn =
      DrawSections({&block, hollow(wanted), hollow(taken)}, Plane::kMesiodistal);
  EXPECT_EQ(CountOf(drawn, "class=\"over\""), 1u);
  EXPECT_EQ(CountOf(drawn, "class=\"left\""), 0u);
  // 3.5 mm of cut and 1.2 mm around it to either side, in units of 0.01 mm.
  const size_t box = drawn.find("viewBox=\"0 0 ") + 13;
  EXPECT_NEAR(std::stod(drawn.substr(box)), 580, 20);
  EXPECT_EQ(DrawSections({&block, hollow(wanted), hollow(wanted)}, Plane::kMesiodistal), "");
}

}  // namespace
}  // namespace enamel::station::lab
