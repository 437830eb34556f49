#include "common/hands/assignment_text.h"

#include <gtest/gtest.h>

#include <set>

namespace enamel {
namespace {

// date -u -d "2026-12-01 12:00" +%s
constexpr int64_t kDue = 1'796'126'400'000;

TEST(AssignmentTextTest, SaysWhatItIs) {
  EXPECT_EQ(AssignmentText({"Class I cavity", true, kDue, HandsAllowed::kHaptic}),
            "Class I cavity (exam, due 2026-12-01 12:00 UTC, with a haptic device)");
  EXPECT_EQ(AssignmentText({"Crown", false, 0, HandsAllowed::kAny}),
            "Crown (no due time, with any hand, also a simulated one)");
}

TEST(AssignmentTextTest, AssignmentsOfOneExerciseThatDifferInAnyTermReadDifferently) {
  std::set<std::string> texts;
  int made = 0;
  for (bool exam : {false, true}) {
    for (int64_t due : {int64_t{0}, kDue, kDue + 60'000}) {
      for (HandsAllowed hands : {HandsAllowed::kListed, HandsAllowed::kHaptic,
                                 HandsAllowed::kPointer, HandsAllowed::kAny}) {
        texts.insert(AssignmentText({"Crown", exam, due, hands}));
        ++made;
      }
    }
  }
  EXPECT_EQ(texts.size(), static_cast<size_t>(made));
}

}  // namespace
}  // namespace enamel
