#include "server/jobs/reference_check.h"

#include <gtest/gtest.h>

#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/preparation.h"
#include "common/scene/volume_blob.h"
#include "common/scoring/score.h"
#include "server/jobs/score_job.h"
#include "server/training/revision.h"
#include "tests/server/jobs/recorded_attempt.h"

// What others are compared with did what its exercise's own target asks for.
namespace enamel::server {
namespace {

using test::MemoryStore;
using test::World;

class ReferenceCheckTest : public testing::Test {
 protected:
  ReferenceCheckTest() {
    world_.AddTo(store_);
    cut_ = world_.RecordReference(store_);
    EXPECT_TRUE(RunScoreJob(store_, cut_).ok());
  }
  Status Check() { return CheckReferenceCut(store_, store_.attempts[cut_]); }
  // As if the cut had left this tooth.
  void Leaves(const cutting::Volume& volume) {
    store_.results[cut_].final_volume = *store_.PutBlob(scene::EncodeVolume(volume));
  }
  void ExpectRefused(const std::string& why) {
    const Status refused = Check();
    EXPECT_EQ(refused.code(), Code::kConflict);
    EXPECT_EQ(refused.field(), kAnyway);
    EXPECT_NE(refused.message().find(why), std::string::npos) << refused.message();
  }
  // The target's box, made so much larger on each side and deeper.
  cutting::Volume Grown(int32_t side_um, int32_t depth_um) {
    scene::CavityTarget target = world_.exercise.target;
    for (size_t i = 0; i < 2; ++i) target.half_size_um[i] += side_um;
    target.depth_um += depth_um;
    return scene::Prepared(world_.volume, *scene::TargetShape(world_.scene, target));
  }

  const World& world_ = World::Get();
  MemoryStore store_;
  Uuid cut_;
};

TEST_F(ReferenceCheckTest, CutThatDoesTheTaskIsAReference) {
  EXPECT_TRUE(Check().ok()) << Check().message();
  Leaves(Grown(0, 0));
  EXPECT_TRUE(Check().ok()) << Check().message();
}

TEST_F(ReferenceCheckTest, CutThatStopsEarlyOrGoesBesideTheTaskIsNone) {
  Leaves(Grown(0, -950));
  ExpectRefused("expected at least 80 %");
  Leaves(world_.volume);
  ExpectRefused("found 0.0 %");
  Leaves(Grown(1'500, 0));
  ExpectRefused("to be cut beside it");
}

TEST_F(ReferenceCheckTest, CutOverTimeDisturbedOrSentTwiceIsNone) {
  store_.attempts[cut_].flags |= kOverTime;
  ExpectRefused("time limit");
  store_.attempts[cut_].flags = kContradicted;
  ExpectRefused("second recording");
  store_.attempts[cut_].flags = 0;
  EXPECT_TRUE(Check().ok());
  auto score = *scoring::ScoreFromJson(AsText(store_.blobs[store_.results[cut_].score_json]));
  score.disturbance.late_percent = 7;
  store_.results[cut_].score_json = *store_.PutBlob(AsBytes(scoring::ToJson(score)));
  ExpectRefused("7.0 % of its ticks came late");
}

TEST_F(ReferenceCheckTest, EveryBuiltInTargetIsDoneByItsOwnPreparation) {
  for (const std::string& name : scene::BuiltinSceneNames()) {
    auto built = scene::BuildBuiltinScene(name, 200'000);
    ASSERT_TRUE(built.ok());
    for (const scene::Exercise& exercise : scene::BuiltinExercises(built->scene, Sha256{})) {
      const auto shape = scene::TargetShape(built->scene, exercise.target);
      ASSERT_TRUE(shape.ok()) << exercise.name;
      const auto work = WorkOnTarget(built->scene, exercise, built->volume,
                                     scene::Prepared(built->volume, *shape));
      ASSERT_TRUE(work.ok()) << exercise.name << ": " << work.status().message();
      EXPECT_GT(work->done_percent, 95) << exercise.name;
      EXPECT_LT(work->beside_percent, 5) << exercise.name;
    }
  }
}

}  // namespace
}  // namespace enamel::server
