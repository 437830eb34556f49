#include "server/jobs/reference_check.h"

#include <gtest/gtest.h>

#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/preparation.h"
#include "common/scene/volume_blob.h"
#include "common/scoring/score.h"
#include "server/jobs/score_job.h"
#include "server/training/revision.h"
#include "tests/server/jobs/job_school.h"

// A reference must meet its exercise's own target.
namespace enamel::server {
namespace {

using test::JobSchool;
using test::World;

class ReferenceCheckTest : public ::testing::Test {
 protected:
  Status Check() {
    return CheckReferenceCut(school_->store->blobs, school_->store->results, school_->Row(cut_));
  }
  // As if the cut had left this tooth.
  void Leaves(const cutting::Volume& volume) {
    const Sha256 left = *school_->store->blobs.PutBlob(
        scene::EncodeChange(volume, world_.volume, world_.scene.volume));
    school_->Set(cut_, "final_volume = " + JobSchool::Sql(left));
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
  std::unique_ptr<JobSchool> school_ = JobSchool::WithReference();
  const Uuid cut_ = school_->reference;
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
  const auto flag = [&](uint32_t flags) { school_->Set(cut_, "flags = " + std::to_string(flags)); };
  flag(kOverTime);
  ExpectRefused("time limit");
  flag(kContradicted);
  ExpectRefused("second recording");
  flag(0);
  EXPECT_TRUE(Check().ok());
  scoring::ScoreResult score = school_->Score(cut_);
  score.disturbance.late_percent = 7;
  school_->SetScore(cut_, score);
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
