#include "server/jobs/score_job.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numeric>

#include "common/scene/json/json.h"
#include "common/scene/volume_blob.h"
#include "common/scoring/score.h"
#include "server/jobs/judgement.h"
#include "server/jobs/regrade.h"
#include "server/jobs/stored_tooth.h"
#include "server/results/result_document.h"
#include "server/storage/engine/query.h"
#include "server/storage/store_engine.h"
#include "tests/server/jobs/job_school.h"

namespace enamel::server {
namespace {

using test::JobSchool;
using test::PathOptions;
using test::World;

class ScoreJobTest : public ::testing::Test {
 protected:
  scoring::ScoreResult ScoreOf(const Uuid& attempt) {
    EXPECT_EQ(school_->Row(attempt).problem, "");
    EXPECT_EQ(school_->Row(attempt).state, AttemptState::kScored);
    return school_->Score(attempt);
  }
  double Metric(const scoring::ScoreResult& score, std::string_view name) {
    for (const auto& m : score.metrics) {
      if (m.name == name) return m.value;
    }
    ADD_FAILURE() << "no metric " << name;
    return 0;
  }
  Status Run(const Uuid& attempt, ReferenceCache* cache = nullptr) {
    return RunScoreJob(*school_->store, attempt, {}, cache);
  }
  Uuid Scored(const PathOptions& path) {
    const Uuid attempt = school_->Record(path);
    const Status status = Run(attempt);
    EXPECT_TRUE(status.ok()) << status.message();
    return attempt;
  }
  AttemptFilter OfExercise() {
    AttemptFilter filter;
    filter.exercise = school_->exercise;
    return filter;
  }
  Result<RubricPreview> Preview(const scene::Rubric& rubric,
                                const std::vector<ReferenceRow>& counting = {}) {
    return PreviewRubric(*school_->store, OfExercise(), rubric, counting);
  }
  // The exercise's own, with walls at half the price.
  scene::Rubric Milder() {
    scene::Rubric out = world_.exercise.rubric;
    const auto wall = std::ranges::find(out.prices, "wall", &scene::RubricPrice::of);
    EXPECT_NE(wall, out.prices.end());
    wall->points /= 2;
    return out;
  }
  // Counts from now on, as the exercise's next version of it.
  void Publish(scene::Rubric rubric) {
    rubric.version = world_.exercise.rubric.version + 1;
    const Sha256 content = *school_->store->blobs.PutBlob(AsBytes(scene::ToJson(rubric)));
    const auto published = school_->store->rubrics.PublishRubric(
        {school_->exercise, rubric.version, content, "why", 0}, Actor{{}, "test"});
    EXPECT_TRUE(published.ok()) << published.status().message();
  }
  void ExpectFailed(const Uuid& attempt, const std::string& part_of_problem) {
    Status status = Run(attempt);
    EXPECT_TRUE(status.ok()) << status.message();
    EXPECT_EQ(school_->Row(attempt).state, AttemptState::kFailed);
    EXPECT_NE(school_->Row(attempt).problem.find(part_of_problem), std::string::npos)
        << school_->Row(attempt).problem;
    EXPECT_FALSE(school_->store->results.ResultOf(attempt).ok()) << "nothing may be scored";
  }

  const World& world_ = World::Get();
  std::unique_ptr<JobSchool> school_ = JobSchool::WithReference();
};

TEST_F(ScoreJobTest, ResultIsSignedAndNamesWhatItWasMadeFrom) {
  const trace::KeyPair key = trace::NewKeyPair();
  // Nearer to the attempt than the exercise's own target is.
  const Uuid reference = school_->RecordReference({.mesial_extra_mm = 0.05});
  const Uuid attempt = school_->Record({.mesial_extra_mm = 0.3});
  const std::string flags = std::to_string(uint32_t{kResumed | kExcused});
  school_->Set(attempt, "flags = " + flags);
  ASSERT_TRUE(RunScoreJob(*school_->store, attempt, {}, nullptr, {}, &key).ok());
  const AttemptResult result = school_->Result(attempt);
  const test::Recording recording = school_->RecordingOf(attempt);
  auto d = DecodeResult(result.document);
  ASSERT_TRUE(d.ok()) << d.status().message();
  EXPECT_TRUE(VerifyResult(*d));
  EXPECT_EQ(d->key, key.public_key);
  const trace::Header header = *trace::DecodeHeader(recording.header);
  EXPECT_EQ(d->attempt, attempt);
  EXPECT_EQ(d->scored_ms, result.scored_ms);
  EXPECT_EQ(d->header, HashSha256(recording.header));
  EXPECT_EQ(d->recording, recording.seal.last_chunk);
  EXPECT_EQ(d->exercise, header.ticket.exercise);
  EXPECT_EQ(d->profile, header.ticket.profile);
  EXPECT_EQ(d->scene, header.scene);
  EXPECT_EQ(d->volume, header.volume);
  EXPECT_EQ(d->rubric, HashSha256(AsBytes(scene::ToJson(world_.exercise.rubric))));
  EXPECT_EQ(d->reference, reference);
  EXPECT_EQ(d->reference_recording, school_->RecordingOf(reference).seal.last_chunk);
  EXPECT_EQ(d->reference_tooth, school_->Result(reference).final_volume);
  EXPECT_EQ(d->score_document, result.score_json);
  EXPECT_EQ(d->tooth, result.final_volume);
  EXPECT_EQ(d->deviation, result.deviation);
  EXPECT_EQ(d->series, result.series);
  EXPECT_EQ(d->points, result.score);
  EXPECT_EQ(d->judgement, JudgementOf(ScoreOf(attempt)));
  EXPECT_EQ(d->metric_set, static_cast<uint32_t>(scoring::kScoringVersion));
  EXPECT_EQ(d->core_version, header.params.core_version);
  EXPECT_EQ(d->flags, uint32_t{kResumed}) << "an excuse is people's";
}

// Long enough to have a motion.
constexpr double kCalm = 0.1;

TEST_F(ScoreJobTest, ACopiedMotionIsFlaggedWithWhatItIsNearAndCostsNothing) {
  const trace::KeyPair key = trace::NewKeyPair();
  school_ = std::make_unique<JobSchool>();
  const Uuid reference = school_->RecordReference({.pace = kCalm});
  EXPECT_FALSE(school_->Near(reference)) << "there is none before it";

  auto score = [&](const PathOptions& path) {
    const Uuid attempt = school_->Record(path);
    EXPECT_TRUE(RunScoreJob(*school_->store, attempt, {}, nullptr, {}, &key).ok());
    return attempt;
  };
  const Uuid like_reference = score({.pace = kCalm});
  const auto near_reference = school_->Near(like_reference);
  ASSERT_TRUE(near_reference);
  EXPECT_EQ(near_reference->attempt, reference);
  EXPECT_EQ(near_reference->nearest_um, 0);
  EXPECT_EQ(near_reference->preset, reference) << "a preset path";
  EXPECT_EQ(near_reference->preset_um, 0);
  EXPECT_TRUE(near_reference->worth_a_look);

  // Another hand goes out farther; the copy is as far out, and faster.
  const Uuid own = score({.mesial_extra_mm = 1.4, .pace = kCalm});
  const Uuid copy = score({.mesial_extra_mm = 1.4, .pace = 1.2 * kCalm});
  const auto near_own = school_->Near(own), near_copy = school_->Near(copy);
  ASSERT_TRUE(near_own && near_copy);
  EXPECT_FALSE(near_own->worth_a_look);
  EXPECT_EQ(near_copy->attempt, own);
  EXPECT_EQ(near_copy->others, 3u);
  EXPECT_TRUE(near_copy->worth_a_look) << near_copy->nearest_um;
  EXPECT_EQ(DecodeResult(school_->Result(own).document)->flags, 0u);
  EXPECT_EQ(DecodeResult(school_->Result(copy).document)->flags, uint32_t{kNearAnother});
  // It costs nothing: the same recording has the same score where nobody went so before.
  const scoring::ScoreResult flagged = ScoreOf(copy);
  school_->Exec("DELETE FROM motions");
  ASSERT_TRUE(Run(copy).ok());
  EXPECT_FALSE(school_->Near(copy)->worth_a_look);
  EXPECT_EQ(ScoreOf(copy), flagged);
}

TEST_F(ScoreJobTest, FiguresOfTheHandAreKeptWithItsMotion) {
  school_ = std::make_unique<JobSchool>();
  school_->RecordReference({.pace = kCalm});
  const Uuid assignment = Uuid::New(), attempt = Scored({.pace = kCalm});
  ASSERT_TRUE(school_->store->engine->rows
                  .Write([&](sql::Db& db) {
                    return Query(db,
                                 "UPDATE attempts SET assignment = ?3 WHERE tenant = ?1 AND id = "
                                 "?2")
                        .Bind(attempt)
                        .Bind(assignment)
                        .Run();
                  })
                  .ok());
  const auto rows = *school_->store->motions.MotionsUnder(assignment, 10);
  ASSERT_EQ(rows.size(), 1u);
  const scoring::HandFigures& hand = rows[0].record.hand;
  EXPECT_NE(hand.tremor_nm, scoring::HandFigures::kNoTremor);
  EXPECT_TRUE(scoring::IsTooCalm(hand)) << hand.tremor_nm << " nm along a plan";
}

TEST_F(ScoreJobTest, AReferenceWhoseMotionIsNotKeptIsComparedWithAllTheSame) {
  school_ = std::make_unique<JobSchool>();
  const Uuid reference = school_->RecordReference({.pace = kCalm});
  school_->Exec("DELETE FROM motions");
  const Uuid attempt = Scored({.pace = kCalm});
  ASSERT_TRUE(school_->Near(attempt));
  EXPECT_EQ(school_->Near(attempt)->attempt, reference);
  EXPECT_EQ(school_->Near(attempt)->others, 1u);
}

TEST_F(ScoreJobTest, AMotionIsReadOnceForAllThatAreComparedWithIt) {
  school_ = std::make_unique<JobSchool>();
  school_->RecordReference({.pace = kCalm});
  const Uuid first = Scored({.mesial_extra_mm = 1.4, .pace = kCalm});
  ReferenceCache cache;
  const Uuid second = school_->Record({.mesial_extra_mm = 0.3, .pace = kCalm});
  ASSERT_TRUE(Run(second, &cache).ok());
  ASSERT_EQ(school_->Near(second)->others, 2u);

  const auto rows = *school_->store->motions.MotionsBefore(second, 10);
  const auto row = std::ranges::find(rows, first, &MotionRow::attempt);
  ASSERT_NE(row, rows.end());
  const std::string name = row->content.Hex();
  ASSERT_TRUE(
      std::filesystem::remove(school_->folder.path() / "data/blobs" / name.substr(0, 2) / name));
  const Uuid third = school_->Record({.mesial_extra_mm = 1.4, .pace = 1.2 * kCalm});
  ASSERT_TRUE(Run(third, &cache).ok());
  EXPECT_EQ(school_->Near(third)->attempt, first) << "from the blob that is lost now";
  ASSERT_TRUE(Run(third).ok());
  EXPECT_NE(school_->Near(third)->attempt, first) << "nobody remembers it";
}

TEST_F(ScoreJobTest, AnotherScoreWithdrawsTheReleaseAndTheSamePointsAndReasonsDoNot) {
  const Uuid attempt = Scored({.mesial_extra_mm = 0.3});
  const scoring::ScoreResult score = ScoreOf(attempt);
  ASSERT_FALSE(score.mistakes.empty());
  ASSERT_FALSE(score.criteria.back().reasons.empty()) << "the hand's";
  const auto stays_released = [&](const scoring::ScoreResult& before) {
    school_->SetScore(attempt, before);
    EXPECT_TRUE(school_->store->judging.ReleaseAttempt(attempt, Actor{{}, "test"}).ok());
    EXPECT_TRUE(Run(attempt).ok());
    return school_->Row(attempt).released;
  };

  // The stored score has fewer metrics, and other words.
  scoring::ScoreResult fewer = score;
  fewer.metrics.pop_back();
  fewer.criteria.back().reason = "The same, in other words.";
  EXPECT_TRUE(stays_released(fewer));

  const std::function<void(scoring::ScoreResult&)> others[] = {
      [](auto& s) { s.score -= 0.001; },
      [](auto& s) { s.critical_fail = true; },
      [](auto& s) { s.criteria[0].lost += 0.001; },
      [](auto& s) { s.criteria[0].state = scoring::State::kRedo; },
      [](auto& s) { s.criteria.back().reasons[0].code = "any"; },
      [](auto& s) { s.criteria.back().reasons[0].values[0] += 0.001; },
      [](auto& s) { s.criteria.back().comment += " Watch it."; },
      [](auto& s) { s.criteria.back().judged = false; },
      [](auto& s) { s.criteria.pop_back(); },
      [](auto& s) { s.mistakes[0].kind = scoring::MistakeKind::kHole; },
      [](auto& s) { s.mistakes[0].place = "floor"; },
      [](auto& s) { s.mistakes[0].size += 0.001; },
      [](auto& s) { s.mistakes[0].points += 0.001; },
      [](auto& s) { s.mistakes.pop_back(); }};
  for (size_t i = 0; i < std::size(others); ++i) {
    scoring::ScoreResult other = score;
    others[i](other);
    EXPECT_FALSE(stays_released(other)) << i;
  }
}

TEST_F(ScoreJobTest, TheReferenceAgainstItselfHasNoDeviationAndFullMarksForShape) {
  const Uuid reference = school_->reference;
  auto score = ScoreOf(reference);
  for (const char* name : {"deviation_rms_mm", "deviation_p95_mm", "wall_mesial_mm",
                           "wall_distal_mm", "wall_buccal_mm", "wall_lingual_mm", "floor_mm"}) {
    EXPECT_EQ(Metric(score, name), 0) << name;
  }
  EXPECT_EQ(score.score, 100);
  EXPECT_TRUE(score.mistakes.empty());
  EXPECT_TRUE(score.deductions.empty()) << "nothing too much";
  EXPECT_EQ(score.reference_attempt, reference.Text());
  EXPECT_EQ(school_->Result(reference).reference, reference);
  EXPECT_TRUE(score.witness_ok);
}

// A rubric is corrected: the preview predicts the score of a new run, and the recording is
// unchanged.
TEST_F(ScoreJobTest, ACorrectedRubricCountsInTheNextRunAsItsPreviewSaid) {
  const Uuid attempt = Scored({.mesial_extra_mm = 0.3});
  const scoring::ScoreResult before = ScoreOf(attempt);
  const scene::Rubric rubric = Milder();

  auto preview = Preview(rubric);
  ASSERT_TRUE(preview.ok()) << preview.status().message();
  ASSERT_EQ(preview->attempts.size(), 2u) << "the reference, too";
  const RegradedAttempt& seen = preview->attempts.front();
  EXPECT_EQ(seen.row.id, attempt) << "the largest change first";
  // The document keeps twelve digits.
  EXPECT_NEAR(seen.before, before.score, 1e-9);
  EXPECT_GT(seen.after, seen.before);
  EXPECT_EQ(preview->raised, 1u);
  EXPECT_EQ(preview->lowered, 0u);
  EXPECT_EQ(std::accumulate(preview->after.begin(), preview->after.end(), 0u), 2u);

  Publish(rubric);
  ASSERT_TRUE(Run(attempt).ok());
  const scoring::ScoreResult after = ScoreOf(attempt);
  EXPECT_NEAR(after.score, seen.after, 1e-9);
  EXPECT_EQ(after.rubric_version, world_.exercise.rubric.version + 1);
  EXPECT_EQ(after.metrics, before.metrics);
}

TEST_F(ScoreJobTest, APreviewSaysWhatElseScoringAgainWouldChange) {
  const Uuid attempt = Scored({.mesial_extra_mm = 0.3});
  ASSERT_TRUE(school_->store->judging.ReleaseAttempt(attempt, Actor{{}, "test"}).ok());
  auto counting = *school_->store->references.Counting(school_->exercise);
  auto same = Preview(world_.exercise.rubric, counting);
  ASSERT_TRUE(same.ok());
  EXPECT_EQ(same->withdrawn, 0u);
  const auto of_attempt = [&](const RubricPreview& preview) {
    return *std::ranges::find(preview.attempts, attempt,
                              [](const RegradedAttempt& a) { return a.row.id; });
  };
  EXPECT_FALSE(of_attempt(*same).other_references);

  counting.push_back({});
  auto other = Preview(Milder(), counting);
  ASSERT_TRUE(other.ok());
  EXPECT_EQ(other->withdrawn, 1u);
  EXPECT_TRUE(of_attempt(*other).other_references);
  EXPECT_GE(other->other_references, 1u);
}

TEST_F(ScoreJobTest, APreviewSaysOfWhichAttemptsItCannotTell) {
  const Uuid attempt = Scored({});
  scoring::ScoreResult other = ScoreOf(attempt);
  other.scoring_version = scoring::kScoringVersion + 1;
  school_->SetScore(attempt, other);
  school_->Set(school_->reference, "score_json = " + JobSchool::Sql(HashSha256(AsBytes("lost"))));
  auto preview = Preview(world_.exercise.rubric);
  ASSERT_TRUE(preview.ok());
  EXPECT_EQ(preview->problems, 2u);
  EXPECT_EQ(preview->mean_after, 0);
  for (const RegradedAttempt& a : preview->attempts) EXPECT_NE(a.problem, "");

  scene::Rubric broken = world_.exercise.rubric;
  broken.prices[0].of = "no such kind";
  EXPECT_EQ(Preview(broken).status().code(), Code::kInvalidInput);
}

TEST_F(ScoreJobTest, WhatARubricHadNoUseForIsMeasuredOnceOneHas) {
  const Uuid attempt = Scored({});
  const auto measured = [&] {
    const scoring::ScoreResult score = ScoreOf(attempt);
    return std::ranges::count(score.metrics, "dtw_pose_mm", &scoring::MetricValue::name);
  };
  EXPECT_EQ(measured(), 0);
  scene::Rubric other = world_.exercise.rubric;
  other.criteria.push_back({"dtw_pose_mm", "Like the dentist", "mm", 5, {{0, 1}, {2, 0}}, "", {}});
  auto preview = Preview(other);
  ASSERT_TRUE(preview.ok());
  for (const RegradedAttempt& a : preview->attempts) {
    EXPECT_TRUE(a.row.id != attempt || a.problem.find("dtw_pose_mm") != std::string::npos);
  }
  // The recording has it: scored again by that rubric it is measured.
  Publish(other);
  ASSERT_TRUE(Run(attempt).ok());
  EXPECT_EQ(measured(), 1);
}

TEST_F(ScoreJobTest, AWallThreeTenthsTooFarOutIsFoundAndExplained) {
  // Nearer to the attempt than the exercise's own target is.
  school_->RecordReference({.mesial_extra_mm = 0.05});
  const Uuid attempt = Scored({.mesial_extra_mm = 0.35});
  auto score = ScoreOf(attempt);
  EXPECT_NEAR(Metric(score, "wall_mesial_mm"), 0.3, 0.025);  // a quarter voxel
  EXPECT_NEAR(Metric(score, "wall_distal_mm"), 0, 0.025);
  EXPECT_NEAR(Metric(score, "floor_mm"), 0, 0.025);
  EXPECT_LT(score.score, 100);
  EXPECT_EQ(score.reference_attempt, school_->reference.Text());
  ASSERT_FALSE(score.mistakes.empty());
  EXPECT_EQ(score.mistakes[0].kind, scoring::MistakeKind::kOverExtended);
  EXPECT_EQ(score.mistakes[0].place, "wall_mesial");
  EXPECT_NEAR(score.mistakes[0].size, 0.3, 0.06);  // the leeway may be explained or not
  // And where, and when.
  auto wall = std::find_if(score.deductions.begin(), score.deductions.end(),
                           [](const auto& d) { return d.mistake == 0 && !d.left; });
  ASSERT_NE(wall, score.deductions.end());
  EXPECT_GT(wall->volume_m3, 0);
  ASSERT_FALSE(wall->strokes.empty());
  EXPECT_GE(wall->strokes[0].number, 1u);
  EXPECT_GT(wall->first_tick, 0u);
  EXPECT_LT(wall->first_tick, score.ticks);
  EXPECT_LT(wall->facing.x, -0.7);
}

// One motion, recorded, replayed to its witness and scored at several loop rates: metrics in
// seconds, millimetres and newtons do not count ticks. The hand's way is the same to a count. The
// poses that cut are not, so lengths agree to a quarter of a voxel (0.1 mm) and not to the bit.
// Tough tissue (2.4 N) with the law without a memory; the default law in soft tissue, where the bur
// keeps up: its memory of the hand differs at another rate.
struct AtRates {
  const char* name;
  haptics::LawKind law;
  int32_t damping_mn_s_per_mm;
  double force_n;  // by which forces may differ, or 3 % where that is more
};
class ScoreAtRates : public ::testing::TestWithParam<AtRates> {};

TEST_P(ScoreAtRates, OneMotionScoresTheSameAtEveryLoopRate) {
  // Five voxels of volume; two of the 50 ms in which a cut counts as continuing.
  constexpr double kLength_mm = 0.025, kVolume_mm3 = 0.005, kTime_s = 0.1, kShare = 0.03;
  constexpr double kAngle_deg = 0.1, kDivergence_deg = 0.5, kOfFew_mm = 0.06, kRateShare = 0.1;
  constexpr double kPercent = 0.1, kPoints = 0.5;
  std::map<std::string, double> slow;
  double slow_score = 0;
  for (int32_t rate : {1000, 2000, 4000, 8000}) {
    const World world(rate, GetParam().damping_mn_s_per_mm, GetParam().law);
    JobSchool school(world);
    school.RecordReference();
    Uuid attempt = school.Record({.mesial_extra_mm = 0.3});
    ASSERT_TRUE(RunScoreJob(*school.store, attempt).ok());
    ASSERT_EQ(school.Row(attempt).problem, "") << rate;
    const scoring::ScoreResult score = school.Score(attempt);
    EXPECT_TRUE(score.witness_ok) << rate;
    if (rate == 1000) slow_score = score.score;
    EXPECT_NEAR(score.score, slow_score, kPoints) << rate;
    for (const auto& m : score.metrics) {
      if (rate == 1000) {
        slow[m.name] = m.value;
        continue;
      }
      // The outline consists of the mesh's edges, and the deepest place of a few of its triangles:
      // both are known to some half of a voxel.
      const bool of_few =
          m.name.starts_with("outline_") || m.name == "most_left_mm" || m.name == "deepest_over_mm";
      const double length = of_few ? kOfFew_mm : kLength_mm;
      const double least = m.unit == "mm"    ? length
                           : m.unit == "mm3" ? kVolume_mm3
                           : m.unit == "s"   ? kTime_s
                           // Each rate's reference has its own angle, known to that.
                           : m.name.starts_with("divergence_") ? kDivergence_deg
                           : m.unit == "deg"                   ? kAngle_deg
                           : m.unit == "%"                     ? kPercent
                           : m.unit == "N"                     ? GetParam().force_n
                           // What that force adds up to over the time, and over the way.
                           : m.unit == "N s" ? GetParam().force_n * slow["time_s"]
                           : m.unit == "mJ"  ? GetParam().force_n * slow["path_length_mm"]
                           // Two of its steps.
                           : m.unit == "N/s" ? 0.2001
                           // A pause of about 0.1 s may end a contact or not.
                           : m.unit == "count" ? 1
                                               : 1e-9;
      // How fast a force changes is known less well than the force.
      const double share = m.unit == "N/s" ? kRateShare : kShare;
      EXPECT_NEAR(m.value, slow[m.name], std::max(least, share * std::fabs(slow[m.name])))
          << m.name << " at " << rate << " Hz";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Laws, ScoreAtRates,
    ::testing::Values(AtRates{"MaxwellTough", haptics::LawKind::kMaxwell, 300, 0.02},
                      AtRates{"DefaultSoft", haptics::kDefaultLaw, 10, 0.02}),
    [](const ::testing::TestParamInfo<AtRates>& i) { return std::string(i.param.name); });

TEST_F(ScoreJobTest, TicksGapsAndLateTicksAreOnTheScore) {
  const Uuid attempt = Scored({.gap_ticks = 40, .late = true});
  auto score = ScoreOf(attempt);
  EXPECT_EQ(score.ticks, school_->Row(attempt).ticks);
  EXPECT_EQ(score.gap_ticks, 40u);
  EXPECT_EQ(score.outages, 1u);
  EXPECT_EQ(score.late_ticks, (score.ticks + 99) / 100);
  EXPECT_GT(school_->Result(attempt).replay_realtime_factor, 0);
  EXPECT_EQ(score.core_version, core::kCoreVersion);
}

// The same recording as an exam with a limit, and as if the student had stopped at the limit and
// the station had sealed it there.
TEST_F(ScoreJobTest, AnExamCountsUpToItsTimeLimitAndPracticeToItsEnd) {
  const Uuid attempt = school_->Record({.mesial_extra_mm = 0.3, .gap_ticks = 40});
  const uint64_t all = school_->Row(attempt).ticks + 40, limit = all / 2;
  core::Core core(world_.params, world_.volume);
  uint64_t time_ticks = 0;
  for (const Bytes& bytes : school_->RecordingOf(attempt).chunks) {
    auto chunk = trace::DecodeChunk(bytes);
    ASSERT_TRUE(chunk.ok());
    for (const trace::Tick& tick : chunk->ticks) {
      if (time_ticks >= limit) continue;
      core.Step(tick.input);
      time_ticks += 1 + tick.input.gap_ticks;
    }
  }
  auto scored_volume = [&](bool exam) {
    school_->Set(attempt,
                 "exam = " + std::to_string(exam) + ", limit_ticks = " + std::to_string(limit));
    EXPECT_TRUE(Run(attempt).ok());
    EXPECT_EQ(ScoreOf(attempt).ticks, all - 40) << "all of it is replayed and checked";
    auto stored = CutTooth(school_->store->blobs, school_->Result(attempt).final_volume);
    EXPECT_TRUE(stored.ok());
    return *stored;
  };
  cutting::Volume exam = scored_volume(true), practice = scored_volume(false);
  EXPECT_TRUE(exam == core.volume());
  EXPECT_FALSE(practice == core.volume());
}

TEST_F(ScoreJobTest, TheFinalVolumeIsTheOneTheStationHad) {
  const Uuid attempt = Scored({.mesial_extra_mm = 0.1});
  core::Core core(world_.params, world_.volume);
  for (const Bytes& bytes : school_->RecordingOf(attempt).chunks) {
    auto chunk = trace::DecodeChunk(bytes);
    ASSERT_TRUE(chunk.ok());
    for (const trace::Tick& tick : chunk->ticks) core.Step(tick.input);
  }
  const Sha256 kept = school_->Result(attempt).final_volume;
  auto stored = CutTooth(school_->store->blobs, kept);
  ASSERT_TRUE(stored.ok());
  EXPECT_TRUE(*stored == core.volume());
  EXPECT_LT(school_->Blob(kept).size(), scene::EncodeVolume(*stored).size());
}

TEST_F(ScoreJobTest, TheSurfaceMadeAgainIsTheOneThatTheResultNames) {
  const trace::KeyPair key = trace::NewKeyPair();
  const Uuid attempt = school_->Record({.mesial_extra_mm = 0.2});
  ASSERT_TRUE(RunScoreJob(*school_->store, attempt, {}, nullptr, {}, &key).ok());
  AttemptResult result = school_->Result(attempt);
  auto made = AttemptSurface(school_->store->blobs, result);
  ASSERT_TRUE(made.ok()) << made.status().message();
  EXPECT_EQ(HashSha256(*made), DecodeResult(result.document)->surface_file);
  // Of another attempt's deviation it is another surface, and nobody gets it.
  result.deviation = school_->Result(school_->reference).deviation;
  made = AttemptSurface(school_->store->blobs, result);
  EXPECT_EQ(made.status().code(), Code::kConflict);
  EXPECT_NE(made.status().message().find("signed result"), std::string::npos);
}

TEST_F(ScoreJobTest, ScoringAgainGivesTheSameBlobs) {
  const Uuid attempt = Scored({.mesial_extra_mm = 0.2});
  const AttemptResult first = school_->Result(attempt);
  ReferenceCache cache;
  ASSERT_TRUE(Run(attempt, &cache).ok());
  const AttemptResult again = school_->Result(attempt);
  EXPECT_EQ(first.final_volume, again.final_volume);
  EXPECT_EQ(first.deviation, again.deviation);
  EXPECT_EQ(first.series, again.series);
  EXPECT_EQ(first.score_json, again.score_json) << "to the bit, whatever the clock said meanwhile";
}

TEST_F(ScoreJobTest, OfSeveralReferencesTheOneUnderWhichAnAttemptEarnsMostJudgesIt) {
  const Uuid attempt = Scored({.mesial_extra_mm = 0.3}), like_first = Scored({});
  const Uuid first = school_->reference;
  const double before = ScoreOf(attempt).score;
  EXPECT_FALSE(ScoreOf(attempt).envelope) << "one reference is no envelope";
  const Uuid second = school_->RecordReference({.mesial_extra_mm = 0.2});
  EXPECT_EQ(ScoreOf(attempt).score, before) << "nothing changes before somebody scores again";
  ReferenceCache cache;
  ASSERT_TRUE(Run(attempt, &cache).ok());
  auto score = ScoreOf(attempt);
  EXPECT_GT(score.score, before);
  EXPECT_EQ(score.reference_attempt, second.Text()) << "the nearer one";
  EXPECT_EQ(school_->Result(attempt).reference, second);
  EXPECT_NEAR(Metric(score, "wall_mesial_mm"), 0.1, 0.03);
  ASSERT_TRUE(score.envelope);
  ASSERT_EQ(score.envelope->members.size(), 2u);
  EXPECT_EQ(score.envelope->members[0].attempt, second.Text()) << "the nearest";
  EXPECT_EQ(score.envelope->members[1].attempt, first.Text());
  auto wall = std::ranges::find(score.envelope->metrics, std::string("wall_mesial_mm"),
                                &scoring::MetricPlace::name);
  ASSERT_NE(wall, score.envelope->metrics.end());
  EXPECT_NEAR(wall->least, -0.2, 0.03) << "against the one that judges";
  EXPECT_EQ(wall->most, 0) << "that one against itself";
  EXPECT_EQ(wall->percentile, 100);
  const Sha256 json = school_->Result(attempt).score_json;
  ASSERT_TRUE(Run(attempt, &cache).ok());
  EXPECT_EQ(school_->Result(attempt).score_json, json) << "from the cache too";
  // Whoever followed the first loses nothing to the second, and each reference has full marks.
  for (const Uuid& each : {like_first, second}) {
    ASSERT_TRUE(Run(each, &cache).ok());
    EXPECT_EQ(ScoreOf(each).score, 100);
    EXPECT_EQ(ScoreOf(each).reference_attempt, (each == second ? second : first).Text());
  }
  ASSERT_TRUE(
      school_->store->references
          .WithdrawReference(school_->store->references.ReferenceFor(school_->exercise)->value().id,
                             Actor{{}, "test"})
          .ok());
  ASSERT_TRUE(Run(attempt, &cache).ok());
  EXPECT_EQ(ScoreOf(attempt).score, before) << "the second does not count any more";
}

TEST_F(ScoreJobTest, TheCacheReadsAReferenceOnce) {
  const Uuid attempt = school_->Record(), other = school_->Record();
  ReferenceCache cache;
  ASSERT_TRUE(Run(attempt, &cache).ok());
  school_->Set(school_->reference, "header = X'00'");
  ASSERT_TRUE(Run(attempt, &cache).ok());
  EXPECT_EQ(ScoreOf(attempt).score, 100);
  ExpectFailed(other, "cannot be read");
}

TEST_F(ScoreJobTest, WithoutAReferenceTheTargetJudgesAndTheFirstReferenceHasItScoredAgain) {
  school_ = std::make_unique<JobSchool>();
  const Uuid attempt = Scored({.mesial_extra_mm = 0.3});
  EXPECT_EQ(ScoreOf(attempt).reference_attempt, "");
  EXPECT_FALSE(school_->Result(attempt).reference.has_value());
  EXPECT_LT(ScoreOf(attempt).score, 100) << "against the exercise's own target";
  school_->Exec("DELETE FROM jobs");
  const Uuid reference = school_->RecordReference({.mesial_extra_mm = 0.3});
  const auto queued = *school_->store->jobs.Jobs("queued");
  EXPECT_NE(std::ranges::find(queued, attempt, &JobRow::attempt), queued.end());
  ASSERT_TRUE(Run(attempt).ok());
  EXPECT_EQ(ScoreOf(attempt).reference_attempt, reference.Text());
  EXPECT_EQ(ScoreOf(attempt).score, 100);
}

TEST_F(ScoreJobTest, AReferenceCutIsProcessedBeforeThereIsAReference) {
  school_ = std::make_unique<JobSchool>();
  const Uuid attempt = school_->Record({}, true);
  ASSERT_TRUE(Run(attempt).ok());
  EXPECT_EQ(ScoreOf(attempt).reference_attempt, "");
  EXPECT_FALSE(school_->Result(attempt).reference.has_value());
}

TEST_F(ScoreJobTest, AChangedWitnessIsPlacedToItsTickAndNothingIsScored) {
  const Uuid attempt = school_->Record();
  trace::ChunkHead head;
  school_->Spoil(attempt, [&](test::Recording& recording) {
    Bytes& last = recording.chunks.back();
    head = trace::DecodeChunkHead(last)->head;
    last = world_.Resign(last, [](trace::Tick& tick) { tick.witness.anchor_100nm[0] += 1; });
    recording.seal.last_chunk = trace::DecodeChunkHead(last)->hash;
  });
  uint64_t tick = head.first_tick + head.count / 2;
  ExpectFailed(attempt, "tick " + std::to_string(tick) + " (chunk " + std::to_string(head.seq) +
                            "): anchor differs");
}

TEST_F(ScoreJobTest, AChangedInputIsFoundByTheReplay) {
  const Uuid attempt = school_->Record();
  school_->Spoil(attempt, [&](test::Recording& recording) {
    Bytes& last = recording.chunks.back();
    last = world_.Resign(last, [](trace::Tick& tick) { tick.input.counts[2] -= 50; });
    recording.seal.last_chunk = trace::DecodeChunkHead(last)->hash;
  });
  ExpectFailed(attempt, "replay and recording part at tick");
}

TEST_F(ScoreJobTest, ABrokenChainASealThatDoesNotFitAndAForeignSignatureAreFound) {
  const Uuid swapped = school_->Record(), cut = school_->Record(), foreign = school_->Record();
  school_->Spoil(swapped, [](test::Recording& r) { std::swap(r.chunks[1], r.chunks[2]); });
  ExpectFailed(swapped, "expected");
  school_->Spoil(cut, [](test::Recording& r) { r.chunks.pop_back(); });
  ExpectFailed(cut, "expected");
  school_->Spoil(foreign, [](test::Recording& r) { r.chunks[0].back() ^= 1; });
  ExpectFailed(foreign, "chunk 0 is not signed by station bench 1");
}

TEST_F(ScoreJobTest, AnotherAttemptsRecordingIsRefused) {
  const Uuid attempt = school_->Record();
  const test::Recording other = school_->RecordingOf(school_->Record());
  school_->Spoil(attempt, [&](test::Recording& recording) { recording = other; });
  ExpectFailed(attempt, "attempt in the header");
}

TEST_F(ScoreJobTest, OtherParametersThanThePlanGivesAreRefused) {
  const Uuid attempt = school_->Record();
  school_->Set(attempt, "profile_content = " + JobSchool::Sql(HashSha256(AsBytes("another"))));
  ExpectFailed(attempt, "device profile");

  const Uuid softer = school_->Record();
  school_->Spoil(softer, [&](test::Recording& recording) {
    auto header = trace::DecodeHeader(recording.header);
    ASSERT_TRUE(header.ok());
    header->params.peak_force_mn += 1;
    recording.header = trace::EncodeHeader(*header);
    recording.chunks.clear();
    recording.seal = {softer, 0, 0, HashSha256(recording.header), 0};
  });
  ExpectFailed(softer, "other core parameters");
}

TEST_F(ScoreJobTest, ADamagedHeaderIsAProblemOfTheAttempt) {
  const Uuid attempt = school_->Record();
  school_->Spoil(attempt, [](test::Recording& recording) { recording.header.resize(20); });
  Status status = Run(attempt);
  EXPECT_TRUE(status.ok());
  EXPECT_EQ(school_->Row(attempt).state, AttemptState::kFailed);
}

TEST_F(ScoreJobTest, AFullDiskIsTriedAgainAndNotTheAttemptsFault) {
  const Uuid attempt = school_->Record({.mesial_extra_mm = 0.05});
  int failures = 0;
  for (;; ++failures) {
    school_->disk.fired = false;
    school_->disk.until_failure = failures;
    Status status = Run(attempt);
    if (!school_->disk.fired) {
      EXPECT_TRUE(status.ok()) << status.message();
      break;
    }
    EXPECT_EQ(status.code(), Code::kStorage);
    EXPECT_EQ(school_->Row(attempt).state, AttemptState::kSealed);
  }
  EXPECT_GE(failures, 1);
  (void)ScoreOf(attempt);
}

TEST_F(ScoreJobTest, ProgressRisesAndStoppingLeavesNoTrace) {
  const Uuid attempt = school_->Record(), stopped = school_->Record();
  std::vector<double> seen;
  ASSERT_TRUE(RunScoreJob(*school_->store, attempt, [&](double p) {
                seen.push_back(p);
                return true;
              }).ok());
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  EXPECT_GE(seen.size(), 5u);
  EXPECT_LE(seen.back(), 1);

  for (size_t stop_at = 0; stop_at < seen.size(); ++stop_at) {
    size_t calls = 0;
    Status status =
        RunScoreJob(*school_->store, stopped, [&](double) { return calls++ < stop_at; });
    EXPECT_EQ(status.code(), Code::kUnavailable) << "stopped at call " << stop_at;
    EXPECT_EQ(school_->Row(stopped).state, AttemptState::kSealed);
    EXPECT_FALSE(school_->store->results.ResultOf(stopped).ok());
  }
}

TEST_F(ScoreJobTest, AnUnknownAttemptIsNotFound) {
  EXPECT_EQ(Run(Uuid::New()).code(), Code::kNotFound);
}

}  // namespace
}  // namespace enamel::server
