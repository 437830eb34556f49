#include "station/app/recordings/replay.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <filesystem>

#include "common/base/file.h"
#include "common/scene/volume_blob.h"
#include "common/trace/moment.h"
#include "station/lab/cutting/attempt.h"
#include "tests/support/temp_folder.h"

// `enamel-station replay` on real kinds of recordings: whole, cut short, reordered, of another
// scene.
namespace enamel::station {
namespace {

namespace fs = std::filesystem;

const lab::Attempt& Attempt() {
  static const lab::Attempt attempt = [] {
    lab::AttemptOptions options;
    options.voxel_nm = 100'000;
    options.ticks = 12'000;
    auto made = lab::RecordAttempt(options);
    ENAMEL_CHECK(made.ok());
    return std::move(*made);
  }();
  return attempt;
}

trace::TraceFile WholeFile() {
  return {trace::EncodeHeader(Attempt().header), Attempt().chunks, Attempt().seal, false};
}

class ReplayTest : public testing::Test {
 protected:
  ReplayTest() {
    options_.data = folder_ / "data";
    options_.trace = folder_ / "a.entrace";
    options_.volume = folder_ / "a.envb";
    options_.json = folder_ / "a.json";
    Write(options_.volume, scene::EncodeVolume(Attempt().built.volume));
    WriteTrace(WholeFile());
  }

  static void Write(const fs::path& path, ByteView bytes) {
    ASSERT_TRUE(WriteFileDurably(path, bytes).ok());
  }
  void WriteTrace(const trace::TraceFile& file) {
    Write(options_.trace, trace::EncodeTraceFile(file));
  }
  fs::path Sidecar() const { return options_.trace.string() + ".keyframes"; }
  // One after every chunk: the program itself makes them a quarter of a second apart.
  void WriteSidecar() {
    trace::Keyframes keyframes(HashSha256(trace::EncodeHeader(Attempt().header)));
    trace::MomentOptions how;
    how.keyframe_every_s = 0;
    auto moment = trace::ReplayToMoment(
        [] {
          return std::make_unique<core::Core>(Attempt().header.params, Attempt().built.volume);
        },
        Attempt().header, Attempt().chunks, how, keyframes);
    ASSERT_TRUE(moment.ok());
    Write(Sidecar(), keyframes.Encode());
  }
  boost::json::object Json() const {
    auto bytes = ReadFile(options_.json);
    ENAMEL_CHECK(bytes.ok());
    return boost::json::parse(std::string(AsText(*bytes))).as_object();
  }

  test::TempFolder temp_;
  const fs::path folder_ = temp_.path();
  ReplayOptions options_;
};

std::string Hex(uint64_t value) {
  char text[20];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

TEST_F(ReplayTest, TellsTicksHashAndWhatWentPerTissue) {
  Status status = ReplayTrace(options_);
  ASSERT_TRUE(status.ok()) << status.message();
  boost::json::object found = Json();
  EXPECT_EQ(found.at("ticks").to_number<uint64_t>(), Attempt().seal.ticks);
  EXPECT_EQ(found.at("state_hash").as_string(), Hex(Attempt().seal.state_hash).c_str());
  EXPECT_TRUE(found.at("witness_ok").as_bool());
  EXPECT_TRUE(found.at("whole").as_bool() && found.at("sealed").as_bool());
  EXPECT_FALSE(found.at("truncated").as_bool());
  EXPECT_GT(found.at("ticks_per_second").to_number<double>(), 0);
  EXPECT_GT(found.at("removed_mm3").as_object().at("enamel").to_number<double>(), 0);
}

TEST_F(ReplayTest, MomentFromAKeyframeIsTheMomentFromTheStart) {
  options_.to_tick = 9'321;
  options_.keyframes = false;
  ASSERT_TRUE(ReplayTrace(options_).ok());
  boost::json::object slow = Json();
  EXPECT_FALSE(fs::exists(Sidecar()));
  WriteSidecar();
  options_.keyframes = true;
  ASSERT_TRUE(ReplayTrace(options_).ok());
  boost::json::object fast = Json();
  EXPECT_EQ(slow.at("from_tick").to_number<uint64_t>(), 0u);
  EXPECT_GT(fast.at("from_tick").to_number<uint64_t>(), 8'000u);
  for (const char* name : {"ticks", "state_hash", "removed_mm3", "chunks", "gap_ticks"}) {
    EXPECT_EQ(slow.at(name), fast.at(name)) << name;
  }
}

TEST_F(ReplayTest, WithoutToTickEveryTickIsComparedWhateverKeyframesThereAre) {
  WriteSidecar();
  ASSERT_TRUE(ReplayTrace(options_).ok());
  EXPECT_EQ(Json().at("from_tick").to_number<uint64_t>(), 0u);
}

TEST_F(ReplayTest, DamagedKeyframesAreNotMissed) {
  Write(Sidecar(), AsBytes("not keyframes at all"));
  options_.to_tick = 5'000;
  Status status = ReplayTrace(options_);
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(Json().at("ticks").to_number<uint64_t>(), 5'000u);
}

TEST_F(ReplayTest, SurfaceOfAMomentIsAPly) {
  options_.to_tick = 6'000;
  options_.surface = folder_ / "tooth.ply";
  ASSERT_TRUE(ReplayTrace(options_).ok());
  auto ply = ReadFile(options_.surface);
  ASSERT_TRUE(ply.ok());
  EXPECT_EQ(AsText(*ply).substr(0, 4), "ply\n");
}

TEST_F(ReplayTest, FileCutShortIsUsedToItsLastWholeChunkAndSaysSo) {
  Bytes bytes = trace::EncodeTraceFile(WholeFile());
  bytes.resize(bytes.size() * 2 / 3);
  Write(options_.trace, bytes);
  Status status = ReplayTrace(options_);
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_TRUE(Json().at("truncated").as_bool());
  EXPECT_FALSE(Json().at("sealed").as_bool());
  EXPECT_LT(Json().at("ticks").to_number<uint64_t>(), Attempt().seal.ticks);
}

TEST_F(ReplayTest, ReorderedChunksAreRefused) {
  trace::TraceFile file = WholeFile();
  std::swap(file.chunks[4], file.chunks[5]);
  WriteTrace(file);
  EXPECT_EQ(ReplayTrace(options_).code(), Code::kConflict);
  EXPECT_FALSE(fs::exists(options_.json));
}

TEST_F(ReplayTest, ChunkTakenOutIsRefused) {
  trace::TraceFile file = WholeFile();
  file.chunks.erase(file.chunks.begin() + 7);
  WriteTrace(file);
  EXPECT_EQ(ReplayTrace(options_).code(), Code::kConflict);
}

TEST_F(ReplayTest, EndCutOffUnderTheSealIsRefused) {
  trace::TraceFile file = WholeFile();
  file.chunks.pop_back();
  WriteTrace(file);
  EXPECT_EQ(ReplayTrace(options_).code(), Code::kConflict);
}

TEST_F(ReplayTest, VolumeOfAnotherSceneIsRefused) {
  cutting::Volume other = Attempt().built.volume;
  for (int b = 0; b < other.spec().brick_count(); ++b) {
    if (other.IsStored(b)) {
      other.MutablePhi(b).phi[0] ^= 1;
      break;
    }
  }
  Write(options_.volume, scene::EncodeVolume(other));
  Status status = ReplayTrace(options_);
  EXPECT_EQ(status.code(), Code::kConflict);
  EXPECT_NE(status.message().find("another scene"), std::string::npos) << status.message();
}

TEST_F(ReplayTest, RecordingOfAnotherCoreIsRefusedByItsVersion) {
  trace::TraceFile file = WholeFile();
  trace::Header header = Attempt().header;
  header.params.core_version = core::kCoreVersion + 1;
  file.header = trace::EncodeHeader(header);
  WriteTrace(file);
  Status status = ReplayTrace(options_);
  EXPECT_EQ(status.code(), Code::kVersion) << status.message();
  EXPECT_NE(status.message().find(std::to_string(core::kCoreVersion + 1)), std::string::npos)
      << status.message();
}

TEST_F(ReplayTest, ForgedForceIsPlacedToItsTick) {
  trace::TraceFile file = WholeFile();
  auto chunk = trace::DecodeChunk(file.chunks[10]);
  ASSERT_TRUE(chunk.ok());
  chunk->ticks[123].witness.force_sent_mn[2] += 5;
  file.chunks.resize(10);
  file.chunks.push_back(
      trace::EncodeChunk(chunk->head, chunk->ticks, trace::NewKeyPair().secret_key));
  file.seal.reset();
  WriteTrace(file);
  Status status = ReplayTrace(options_);
  EXPECT_EQ(status.code(), Code::kConflict);
  EXPECT_NE(status.message().find("tick 5123 of chunk 10 (force_sent)"), std::string::npos)
      << status.message();
}

}  // namespace
}  // namespace enamel::station
