#include "common/scene/prepared_target.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>

#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/preparation.h"
#include "common/scene/volume_blob.h"

namespace enamel::scene {
namespace {

// A block with a disc gone, as it would be stored.
class PreparedTargetTest : public testing::Test {
 protected:
  void SetUp() override {
    block_ = *BuildBuiltinScene("block", 100'000);
    for (const Preparation& p : block_.scene.preparations) {
      if (p.name == "circle") circle_ = p;
    }
    ASSERT_FALSE(circle_.parts.empty());
    prepared_ = Prepared(block_.volume, circle_);
  }

  Sha256 Put(Bytes bytes) {
    const Sha256 hash = HashSha256(bytes);
    stored_[hash] = std::move(bytes);
    return hash;
  }
  Sha256 PutScene(const cutting::Volume& volume) {
    Scene scene = block_.scene;
    scene.name = "block-prepared";
    scene.volume = Put(EncodeVolume(volume));
    const std::string text = ToJson(scene);
    const ByteView bytes = AsBytes(text);
    return Put(Bytes(bytes.begin(), bytes.end()));
  }
  Status Load(CavityTarget& target) {
    return LoadPreparedTarget(
        block_.volume,
        [&](const Sha256& hash) -> Result<Bytes> {
          const auto found = stored_.find(hash);
          if (found == stored_.end()) return Status(Code::kNotFound, "not stored");
          return found->second;
        },
        target);
  }
  std::string FieldOf(const cutting::Volume& prepared) {
    CavityTarget target;
    target.half_size_um = {50'000, 50'000, 0};
    target.prepared = PutScene(prepared);
    const Status status = Load(target);
    return status.ok() ? "accepted" : status.field();
  }

  BuiltScene block_;
  Preparation circle_;
  cutting::Volume prepared_;
  std::map<Sha256, Bytes> stored_;
};

TEST_F(PreparedTargetTest, ItsBoxHoldsWhatHasToGoAboutTheNearestLandmark) {
  const Sha256 scene = PutScene(prepared_);
  auto made = TargetFromPrepared(block_.scene, block_.volume, prepared_, scene, 250);
  ASSERT_TRUE(made.ok()) << made.status().message();
  // The circle's own landmark is in its middle.
  EXPECT_EQ(made->landmark, "circle");
  const PreparationPart& disc = circle_.parts[0];
  EXPECT_NEAR(made->half_size_um[0], disc.half_size_um[0], 100);
  EXPECT_NEAR(made->half_size_um[1], disc.half_size_um[0], 100);
  EXPECT_NEAR(made->depth_um, disc.depth_um, 100);
  EXPECT_EQ(made->leeway_side_um, 250);
  EXPECT_EQ(made->container_um, 250);

  Exercise exercise = PreparedExercise(block_.scene, Sha256{}, *made);
  auto read = ExerciseFromJson(ToJson(exercise));
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->target.prepared, scene);
  ASSERT_TRUE(Load(read->target).ok());
  EXPECT_TRUE(read->target.prepared_tooth->volume == prepared_);
  EXPECT_EQ(read->target.prepared_tooth->lo_m, made->prepared_tooth->lo_m);
}

TEST_F(PreparedTargetTest, WithoutATargetThatNamesOneNothingIsRead) {
  CavityTarget target;
  EXPECT_TRUE(Load(target).ok());
  EXPECT_EQ(target.prepared_tooth, nullptr);
}

TEST_F(PreparedTargetTest, AToothThatIsNotOneOfTheExercisesIsRefused) {
  constexpr const char* kField = "target.prepared_scene_sha256";
  EXPECT_EQ(FieldOf(prepared_), "accepted");
  EXPECT_EQ(FieldOf(block_.volume), kField) << "nothing has to go";
  EXPECT_EQ(FieldOf(BuildBuiltinScene("block", 120'000)->volume), kField) << "other voxels";
  // The prepared block is the tooth, and what was cut from it would have to grow.
  const cutting::Volume whole = block_.volume;
  block_.volume = prepared_;
  EXPECT_EQ(FieldOf(whole), kField);
}

TEST_F(PreparedTargetTest, WhatIsNotStoredOrTooWideForItsBoxIsRefused) {
  CavityTarget target;
  target.prepared = HashSha256(AsBytes(std::string_view("nothing")));
  EXPECT_EQ(Load(target).code(), Code::kNotFound);
  target.prepared = PutScene(prepared_);
  target.half_size_um = {100, 100, 0};
  EXPECT_EQ(Load(target).code(), Code::kInvalidInput);
}

// Nothing tells which form a prepared tooth has.
TEST_F(PreparedTargetTest, TheExerciseHasAPriceForEveryFormAndForCariesWhereThereIsSome) {
  const auto kinds = [](const Scene& scene) {
    std::multiset<std::string> out;
    for (const RubricPrice& p : PreparedExercise(scene, {}, {}).rubric.prices) out.insert(p.of);
    return out;
  };
  std::multiset<std::string> every = {"floor",     "wall", "table",      "axial_wall",
                                      "margin",    "face", "line_angle", "elsewhere",
                                      "neighbour", "pulp", "contact"};
  EXPECT_EQ(kinds(block_.scene), every);
  const auto molar = BuildBuiltinScene("molar-caries", 200'000);
  ASSERT_TRUE(molar.ok());
  every.insert("caries");
  EXPECT_EQ(kinds(molar->scene), every);
}

}  // namespace
}  // namespace enamel::scene
