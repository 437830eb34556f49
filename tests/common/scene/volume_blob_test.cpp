#include "common/scene/volume_blob.h"

#include <gtest/gtest.h>

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
