#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "common/scoring/score.h"
#include "server/jobs/score_job.h"
#include "tests/server/jobs/job_school.h"

// Recordings that nobody edited, of hands, loops and links as they come, raise no alarm: a thousand
// with ENAMEL_FULL=1, two dozen otherwise. That edits do is EditsTest's and ScoreJobTest's.
namespace enamel::server {
namespace {

// The recording station: another loop, another law.
struct Recorder {
  const char* name;
  int32_t rate_hz, damping_mn_s_per_mm;
  haptics::LawKind law;
};
constexpr Recorder kRecorders[] = {
    {"1 kHz", 1000, 10, haptics::kDefaultLaw},
    {"2 kHz", 2000, 10, haptics::kDefaultLaw},
    {"4 kHz, hard", 4000, 1000, haptics::kDefaultLaw},
    {"1 kHz, hard", 1000, 6500, haptics::kDefaultLaw},
};

class UneditedTest : public ::testing::TestWithParam<Recorder> {};
INSTANTIATE_TEST_SUITE_P(Recorders, UneditedTest, ::testing::ValuesIn(kRecorders),
                         [](const auto& info) { return std::to_string(info.index); });

TEST_P(UneditedTest, RaisesNoAlarm) {
  const size_t count = std::getenv("ENAMEL_FULL") != nullptr ? 250 : 6;
  constexpr size_t kInOneStore = 25;
  const Recorder& by = GetParam();
  const test::World world(by.rate_hz, by.damping_mn_s_per_mm, by.law);
  size_t alarms = 0, gaps = 0;
  std::unique_ptr<test::JobSchool> school;
  for (size_t i = 0; i < count; ++i) {
    if (i % kInOneStore == 0) {
      school = std::make_unique<test::JobSchool>(world);
      school->RecordReference();
    }
    const Uuid attempt = school->Record({.wander = 1 + i});
    const Status status = RunScoreJob(*school->store, attempt);
    ASSERT_TRUE(status.ok()) << status.message();
    const AttemptRow row = school->Row(attempt);
    if (row.state != AttemptState::kScored) {
      ++alarms;
      ADD_FAILURE() << by.name << ", seed " << 1 + i << ": " << row.problem;
      continue;
    }
    const auto near = school->Near(attempt);
    if (near && near->worth_a_look) {
      ++alarms;
      ADD_FAILURE() << by.name << ", seed " << 1 + i << ": " << near->nearest_um
                    << " um from another";
    }
    const scoring::ScoreResult score = school->Score(attempt);
    EXPECT_TRUE(score.witness_ok);
    gaps += score.gap_ticks > 0 ? 1 : 0;
  }
  RecordProperty("recordings", static_cast<int>(count));
  RecordProperty("alarms", static_cast<int>(alarms));
  std::printf("%s: %zu recordings, %zu alarms; %zu with gaps\n", by.name, count, alarms, gaps);
}

}  // namespace
}  // namespace enamel::server
