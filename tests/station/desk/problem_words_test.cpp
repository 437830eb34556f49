#include "station/desk/problem_words.h"

#include <gtest/gtest.h>

#include <set>

#include "common/base/pin.h"
#include "common/protocol/refusals.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/delay.h"
#include "common/scene/find_profile.h"
#include "common/scene/plan.h"
#include "station/devices/trouble.h"
#include "tests/station/desk/english.h"

namespace enamel::station::desk {
namespace {

// An exercise and a device that CompilePlan takes.
class ProblemTextTest : public testing::Test {
 protected:
  ProblemTextTest() {
    auto built = scene::BuildBuiltinScene("block", 500'000);
    EXPECT_TRUE(built.ok());
    scene_ = built->scene;
    exercise_ = scene::ClassOneExercise(scene_, {});
    profile_ = *scene::FindProfile("phantom_desktop");
    EXPECT_TRUE(Plan().ok());
  }
  Status Plan() const { return scene::CompilePlan(scene_, exercise_, profile_).status(); }
  // In the person's language, and not the sentence for the log.
  void ExpectSaid(const Status& status) {
    ASSERT_FALSE(status.ok());
    for (language::Language language : language::kLanguages) {
      const language::Words words(language);
      const std::string text = ProblemText(words, status);
      EXPECT_NE(text, status.message()) << status.field();
      EXPECT_TRUE(all_.insert(text).second || said_ == status.field()) << text;
    }
    said_ = status.field();
  }

  scene::Scene scene_;
  scene::Exercise exercise_;
  scene::DeviceProfile profile_;
  std::set<std::string> all_;
  std::string said_;
};

TEST_F(ProblemTextTest, AnExerciseThatTheDeviceIsTooSlowForIsSaid) {
  exercise_.rate_hz = 4000;
  ExpectSaid(Plan());
  EXPECT_EQ(ProblemText(kEnglish, Plan()),
            "This exercise needs a faster device. Choose another device or another exercise.");
}

TEST_F(ProblemTextTest, ADeviceThatAnswersTooLateIsSaid) {
  profile_.bus_delay_ticks.value = 17;
  profile_.coupling_mn_per_mm.value = 5;
  ExpectSaid(Plan());
  const std::string said = ProblemText(kEnglish, Plan());
  EXPECT_EQ(said.find("This device answers too slowly for a stable force"), 0u) << said;
  profile_.damping_mn_s_per_m.value = 100;
  const auto soft = scene::WithDelay(profile_, 1000, 17);
  ASSERT_FALSE(soft.ok());
  EXPECT_EQ(ProblemText(kEnglish, soft.status()), said);
}

TEST_F(ProblemTextTest, ADeviceWhoseSettingsAreNotPassiveIsSaid) {
  profile_.coupling_mn_per_mm.value = 1'000'000;
  ExpectSaid(Plan());
  profile_ = *scene::FindProfile("sigma7");
  ASSERT_TRUE(profile_.torque);
  profile_.torque->coupling_un_m_per_rad.value = 1'000'000'000;
  EXPECT_EQ(ProblemText(kEnglish, Plan()).find("This device’s settings"), 0u) << Plan().field();
}

TEST_F(ProblemTextTest, AnExerciseWhosePartsDoNotFitIsSaid) {
  const scene::Exercise good = exercise_;
  scene_.burs = {{}};
  ExpectSaid(Plan());
  scene_.burs.clear();
  exercise_.target.landmark = "nowhere";
  const std::string said = ProblemText(kEnglish, Plan());
  EXPECT_EQ(said.find("This exercise cannot begin"), 0u) << said;
  exercise_ = good;
  exercise_.scene = HashSha256(AsBytes(std::string("another")));
  EXPECT_EQ(ProblemText(kEnglish, Plan()), said) << Plan().field();
}

TEST_F(ProblemTextTest, EachRuleThatAPinBreaksIsSaid) {
  for (const char* pin : {"1234", "121212", "123456", "240699"}) ExpectSaid(CheckPin(pin));
  EXPECT_EQ(ProblemText(kEnglish, CheckPin("240699")),
            "This PIN is a date, such as a birthday. Choose digits that are no date.");
}

TEST(RefusalTextTest, EveryReasonOfAServerIsSaidInEveryLanguage) {
  for (language::Language each : language::kLanguages) {
    const language::Words words(each);
    for (const protocol::Refusal& r : protocol::kRefusals) {
      EXPECT_TRUE(words.Has("refusal." + std::string(r.field))) << r.field;
      const Status status(r.code, "go to chair 4", std::string(r.field));
      const std::string said = ProblemText(words, status);
      EXPECT_NE(said, "") << r.field;
      EXPECT_EQ(said.find("refusal."), std::string::npos) << r.field;
      // A reference's figures are for instructors.
      if (r.field != protocol::kAnyway) {
        EXPECT_EQ(said.find("chair 4"), std::string::npos) << said;
      }
    }
  }
}

TEST(RefusalTextTest, EveryReasonOfADriverIsSaidInEveryLanguage) {
  for (language::Language each : language::kLanguages) {
    const language::Words words(each);
    std::set<std::string> said;
    for (std::string_view field : trouble::kAll) {
      EXPECT_TRUE(words.Has("device_trouble." + std::string(field))) << field;
      said.insert(
          ProblemText(words, Status(Code::kUnavailable, "ttyACM0 is odd", std::string(field))));
    }
    EXPECT_EQ(said.size(), trouble::kAll.size());
    for (const std::string& text : said) EXPECT_EQ(text.find("ttyACM0"), std::string::npos) << text;
  }
}

TEST(RefusalTextTest, NoReasonIsSaidInTheServersWords) {
  for (language::Language each : language::kLanguages) {
    const language::Words words(each);
    std::set<std::string> said;
    for (int code = 1; code <= static_cast<int>(Code::kInternal); ++code) {
      const std::string text =
          ProblemText(words, Status(static_cast<Code>(code), "out of tune", "x"));
      EXPECT_EQ(text.find("out of tune"), std::string::npos) << text;
      EXPECT_EQ(text.find("problem."), std::string::npos) << text;
      said.insert(text);
    }
    EXPECT_EQ(said.size(), static_cast<size_t>(Code::kInternal)) << "one for each code";
  }
}

TEST(RefusalTextTest, AnAttemptWithoutAScoreSaysWhyOrWhoKnows) {
  EXPECT_EQ(NoScoreText(kEnglish, Status(Code::kConflict, "chunk 7", protocol::kUnreadable)),
            "The server cannot read this recording as it was made, so it has no score.");
  EXPECT_EQ(NoScoreText(kEnglish, Status(Code::kConflict, "scene 7f is gone")),
            "The server has the recording, but could not score it. Your instructor can see why.");
}

TEST(SofterTextTest, SaysWhyAForceIsSofterAndThatOneMayBegin) {
  using From = scene::DelayUsed::From;
  EXPECT_EQ(SofterText(kEnglish, From::kProfile, "Arm"), "");
  EXPECT_EQ(SofterText(kEnglish, From::kCalibration, "Arm"), "");
  EXPECT_EQ(SofterText(kEnglish, From::kAssumed, "Arm"),
            "Arm was not calibrated on this station, so its force is softer than it could be. You "
            "can begin. The person who looks after this station can calibrate it.");
  EXPECT_EQ(SofterText(kEnglish, From::kAnswers, "Arm").find("Arm answers more slowly"), 0u);
  EXPECT_EQ(SofterText(kEnglish, From::kPoses, "Arm").find("Arm reports its position less"), 0u);
}

TEST(FaultSentenceTest, ALateLoopWithoutRealtimeRightsIsNotBlamedOnOtherPrograms) {
  const auto said = [](Fault fault, bool lacks) {
    return FaultSentence(kEnglish, fault, Status::Ok(), lacks);
  };
  for (const Fault late : {Fault::kLateOnce, Fault::kLateOften}) {
    EXPECT_NE(said(late, true).find("has no real-time rights"), std::string::npos);
    EXPECT_NE(said(late, true).find("enamel-station doctor"), std::string::npos) << "what to do";
    EXPECT_EQ(said(late, false).find("real-time"), std::string::npos);
    EXPECT_NE(said(late, false).find("busy"), std::string::npos);
  }
  for (const Fault other : {Fault::kNone, Fault::kStalled, Fault::kTooSlow, Fault::kUnplugged}) {
    EXPECT_EQ(said(other, true), said(other, false));
  }
}

}  // namespace
}  // namespace enamel::station::desk
