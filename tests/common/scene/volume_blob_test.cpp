#include "common/scene/volume_blob.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "common/base/file.h"
#include "common/scene/builder.h"

namespace enamel::scene {
namespace {

using cutting::Tissue;

// The golden blob's content by schemas/volume_blob.md.
cutting::Volume GoldenVolume() {
  cutting::GridSpec spec;
  spec.voxel_nm = 100'000;
  spec.bricks = {2, 1, 1};
  return BuildVolume(
      spec, Field([](const dvec3& p) {
        return FieldSample{p.x - 0.35e-3, p.y < 0.35e-3 ? Tissue::kDentin : Tissue::kEnamel};
      }));
}

TEST(VolumeBlobTest, GoldenBlobDecodesToWhatItsDocumentSays) {
  auto bytes =
      ReadFile(std::filesystem::path(ENAMEL_SOURCE_DIR) / "schemas/golden/scene_blob.envb");
  ASSERT_TRUE(bytes.ok());
  auto volume = DecodeVolume(*bytes);
  ASSERT_TRUE(volume.ok()) << volume.status().message();
  EXPECT_TRUE(*volume == GoldenVolume());
  EXPECT_EQ(volume->PhiAt({3, 0, 0}), -4096);
  EXPECT_EQ(volume->PhiAt({4, 0, 0}), 4096);
  EXPECT_EQ(volume->TissueAt({4, 3, 0}), Tissue::kDentin);
  EXPECT_EQ(volume->TissueAt({4, 4, 0}), Tissue::kEnamel);
  EXPECT_FALSE(volume->IsStored(1));
}

TEST(VolumeBlobTest, EncodingIsDeterministicAndLossless) {
  auto volume = GoldenVolume();
  Bytes blob = EncodeVolume(volume);
  EXPECT_EQ(blob, EncodeVolume(GoldenVolume()));
  auto back = DecodeVolume(blob);
  ASSERT_TRUE(back.ok());
  EXPECT_TRUE(*back == volume);
  EXPECT_EQ(EncodeVolume(*back), blob);
}

TEST(VolumeBlobTest, EveryTruncationAndEveryExtraByteIsRefused) {
  Bytes blob = EncodeVolume(GoldenVolume());
  for (size_t n = 0; n < blob.size(); ++n) EXPECT_FALSE(DecodeVolume({blob.data(), n}).ok()) << n;
  blob.push_back(0);
  EXPECT_FALSE(DecodeVolume(blob).ok());
}

TEST(VolumeBlobTest, NoFlippedBitCrashesIt) {
  const Bytes blob = EncodeVolume(GoldenVolume());
  for (size_t bit = 0; bit < blob.size() * 8; ++bit) {
    Bytes bad = blob;
    bad[bit / 8] = static_cast<uint8_t>(bad[bit / 8] ^ (1u << bit % 8));
    auto volume = DecodeVolume(bad);
    EXPECT_TRUE(volume.ok() || !volume.status().message().empty());
  }
}

// The golden volume after a cut: a brick that was stored, and air that becomes solid and the other way.
struct Change {
  cutting::Volume before = GoldenVolume(), after = GoldenVolume();
  Sha256 from = HashSha256(EncodeVolume(before));
  Bytes blob;
  Change() {
    for (int16_t& phi : after.MutablePhi(0).phi) phi = std::max<int16_t>(phi, 1000);
    after.SetUniform(1, Tissue::kDentin);
    blob = EncodeChange(after, before, from);
  }
};

TEST(VolumeChangeTest, WithTheVolumeThatItIsFromItIsTheOtherOne) {
  const Change change;
  EXPECT_EQ(*ChangedFrom(change.blob), change.from);
  const auto back = DecodeChange(change.blob, change.before);
  ASSERT_TRUE(back.ok()) << back.status().message();
  EXPECT_TRUE(*back == change.after);
  // An unchanged brick takes no room.
  EXPECT_LT(EncodeChange(change.before, change.before, change.from).size(), 160u);
  EXPECT_TRUE(ChangedFrom(EncodeVolume(change.before))->IsZero());
}

TEST(VolumeChangeTest, GoldenChangeDecodesToWhatItsDocumentSays) {
  const Change change;
  const auto bytes =
      ReadFile(std::filesystem::path(ENAMEL_SOURCE_DIR) / "schemas/golden/scene_change.envb");
  ASSERT_TRUE(bytes.ok());
  const auto back = DecodeChange(*bytes, change.before);
  ASSERT_TRUE(back.ok()) << back.status().message();
  EXPECT_TRUE(*back == change.after);
}

TEST(VolumeChangeTest, IsNoWholeVolumeAndNotOfAnotherGrid) {
  const Change change;
  EXPECT_EQ(DecodeVolume(change.blob).status().code(), Code::kConflict);
  EXPECT_EQ(DecodeChange(EncodeVolume(change.after), change.before).status().code(),
            Code::kConflict);
  cutting::GridSpec other = change.before.spec();
  other.bricks.z = 2;
  EXPECT_EQ(DecodeChange(change.blob, cutting::Volume(other)).status().code(), Code::kConflict);
}

// Also onto a volume that is not the one it is from.
TEST(VolumeChangeTest, NoTruncationAndNoFlippedBitCrashesIt) {
  const Change change;
  const cutting::Volume air(change.before.spec());
  for (size_t n = 0; n < change.blob.size(); ++n) {
    EXPECT_FALSE(DecodeChange({change.blob.data(), n}, change.before).ok()) << n;
  }
  for (size_t bit = 0; bit < change.blob.size() * 8; ++bit) {
    Bytes bad = change.blob;
    bad[bit / 8] = static_cast<uint8_t>(bad[bit / 8] ^ (1u << bit % 8));
    for (const cutting::Volume* onto : {&change.before, &air}) {
      const auto volume = DecodeChange(bad, *onto);
      EXPECT_TRUE(volume.ok() || !volume.status().message().empty());
    }
  }
}

TEST(VolumeBlobTest, UnknownVersionIsAVersionError) {
  Bytes blob = EncodeVolume(GoldenVolume());
  blob[4] = 9;
  EXPECT_EQ(DecodeVolume(blob).status().code(), Code::kVersion);
}

TEST(VolumeBlobTest, HugeGridIsRefusedBeforeMemoryIsTaken) {
  Bytes blob = EncodeVolume(GoldenVolume());
  for (size_t axis = 0; axis < 3; ++axis) blob[12 + 4 * axis + 1] = 0x0f;  // 3840 bricks or so each
  EXPECT_EQ(DecodeVolume(blob).status().code(), Code::kTooLarge);
}

}  // namespace
}  // namespace enamel::scene
