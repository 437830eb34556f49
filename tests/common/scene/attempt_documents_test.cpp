#include "common/scene/attempt_documents.h"

#include <gtest/gtest.h>

#include <map>

#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/plan.h"

namespace enamel::scene {
namespace {

class AttemptDocumentsTest : public testing::Test {
 protected:
  AttemptDocumentsTest() : built_(*BuildBuiltinScene("block", 500'000)) {
    scene_ = Keep(ToJson(built_.scene));
    exercise_ = Keep(ToJson(ClassOneExercise(built_.scene, scene_)));
    profile_ = Keep(ToJson(BuiltinProfiles()[1]));
  }
  Sha256 Keep(const std::string& text) {
    const ByteView bytes = AsBytes(text);
    Sha256 hash = HashSha256(bytes);
    kept_[hash.Hex()] = Bytes(bytes.begin(), bytes.end());
    return hash;
  }
  Result<Bytes> Fetch(const Sha256& hash) const {
    auto it = kept_.find(hash.Hex());
    if (it == kept_.end()) return Status(Code::kNotFound, "no content " + hash.Hex());
    return it->second;
  }
  Result<AttemptDocuments> Read(const Sha256& exercise, const Sha256& profile) const {
    return ReadDocuments(exercise, profile, [this](const Sha256& hash) { return Fetch(hash); });
  }

  BuiltScene built_;
  Sha256 scene_, exercise_, profile_;
  std::map<std::string, Bytes> kept_;
};

TEST_F(AttemptDocumentsTest, AreFoundThroughWhatTheExerciseNames) {
  auto read = Read(exercise_, profile_);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(ToJson(read->scene), ToJson(built_.scene));
  EXPECT_EQ(read->profile.name, BuiltinProfiles()[1].name);
  kept_.erase(scene_.Hex());
  EXPECT_EQ(Read(exercise_, profile_).status().code(), Code::kNotFound);
  EXPECT_FALSE(Read(profile_, exercise_).ok()) << "each is the other's document";
}

TEST_F(AttemptDocumentsTest, ARecordingOfAnotherSceneVolumeOrPlanIsNotMadeOfThem) {
  auto read = Read(exercise_, profile_);
  ASSERT_TRUE(read.ok());
  const core::CoreParams params = *CompilePlan(read->scene, read->exercise, read->profile);
  const Sha256 volume = read->scene.volume;
  EXPECT_TRUE(CheckMadeOf(*read, scene_, volume, params).ok());
  EXPECT_EQ(CheckMadeOf(*read, exercise_, volume, params).field(), "scene");
  EXPECT_EQ(CheckMadeOf(*read, scene_, scene_, params).field(), "volume");
  core::CoreParams softer = params;
  softer.kc_mn_per_mm /= 2;
  Status status = CheckMadeOf(*read, scene_, volume, softer);
  EXPECT_EQ(status.code(), Code::kConflict);
  EXPECT_EQ(status.field(), "params");
}

}  // namespace
}  // namespace enamel::scene
