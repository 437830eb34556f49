#include "station/app/recordings/verify.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>

#include "common/base/file.h"
#include "common/base/hex.h"
#include "common/scene/volume_blob.h"
#include "station/lab/cutting/attempt.h"
#include "tests/support/temp_folder.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;

// Keys of RecordAttempt: the seeds of schemas/golden/README.md.
trace::KeyPair KeysOfSeed(uint8_t byte) {
  std::array<uint8_t, 32> seed;
  seed.fill(byte);
  return trace::KeyPairFromSeed(seed);
}
std::string HexOf(const trace::PublicKey& key) { return ToHex(ByteView(key)); }

const lab::Attempt& Recorded() {
  static const lab::Attempt* attempt = [] {
    lab::AttemptOptions options;
    options.voxel_nm = 200'000;
    options.ticks = 2'000;
    auto recorded = lab::RecordAttempt(options);
    ENAMEL_CHECK(recorded.ok());
    return new lab::Attempt(std::move(*recorded));
  }();
  return *attempt;
}

class VerifyTest : public testing::Test {
 protected:
  VerifyTest() {
    options_.data = temp_.path() / "data";
    options_.trace = temp_.path() / "a.entrace";
    options_.volume = temp_.path() / "a.envb";
    options_.json = temp_.path() / "a.json";
    options_.server_key = HexOf(KeysOfSeed(1).public_key);
    options_.station_key = HexOf(KeysOfSeed(2).public_key);
    EXPECT_TRUE(
        WriteFileDurably(options_.volume, scene::EncodeVolume(Recorded().built.volume)).ok());
    file_ = {trace::EncodeHeader(Recorded().header), Recorded().chunks, Recorded().seal, false};
  }

  Status Verify() {
    EXPECT_TRUE(WriteFileDurably(options_.trace, trace::EncodeTraceFile(file_)).ok());
    return VerifyRecording(options_);
  }
  // Names of the failed checks, from the JSON.
  std::vector<std::string> Failed() const {
    auto bytes = ReadFile(options_.json);
    ENAMEL_CHECK(bytes.ok());
    auto json = boost::json::parse(std::string(AsText(*bytes)));
    std::vector<std::string> out;
    for (const auto& [name, ok] : json.at("checks").as_object()) {
      if (!ok.as_bool()) out.emplace_back(name);
    }
    return out;
  }

  test::TempFolder temp_;
  VerifyOptions options_;
  trace::TraceFile file_;
};

using Names = std::vector<std::string>;

TEST_F(VerifyTest, AWholeRecordingPassesEveryCheck) {
  Status status = Verify();
  EXPECT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(Failed(), Names{});
}

TEST_F(VerifyTest, OtherKeysAreNotThoseThatSigned) {
  options_.station_key = HexOf(KeysOfSeed(3).public_key);
  EXPECT_EQ(Verify().code(), Code::kConflict);
  EXPECT_EQ(Failed(), Names{"chunks"});
  options_.station_key = HexOf(KeysOfSeed(2).public_key);
  options_.server_key = HexOf(KeysOfSeed(3).public_key);
  EXPECT_EQ(Verify().code(), Code::kConflict);
  EXPECT_EQ(Failed(), Names{"ticket"});
}

TEST_F(VerifyTest, AChunkLeftOutBreaksTheChain) {
  ASSERT_GE(file_.chunks.size(), 3u);
  file_.chunks.erase(file_.chunks.begin() + 1);
  EXPECT_EQ(Verify().code(), Code::kConflict);
  const Names failed = Failed();
  EXPECT_NE(std::find(failed.begin(), failed.end(), "chain"), failed.end());
}

TEST_F(VerifyTest, WithoutASealItIsNotWhole) {
  file_.seal.reset();
  EXPECT_EQ(Verify().code(), Code::kConflict);
  EXPECT_EQ(Failed(), Names{"seal"});
}

TEST_F(VerifyTest, AKeyMayBeInAFileAndWhatIsNoKeyIsRefused) {
  const fs::path key = temp_.path() / "station.pub";
  ASSERT_TRUE(WriteFileDurably(key, AsBytes(options_.station_key + "\n")).ok());
  options_.station_key = key.string();
  EXPECT_TRUE(Verify().ok());
  options_.station_key = "not a key";
  Status status = Verify();
  EXPECT_EQ(status.code(), Code::kInvalidInput);
  EXPECT_EQ(status.field(), "--station-key");
}

TEST_F(VerifyTest, WithoutKeysAtAMachineThatIsNoStationItAsksForThem) {
  options_.station_key.clear();
  options_.server_key.clear();
  Status status = Verify();
  EXPECT_EQ(status.code(), Code::kNotFound);
  EXPECT_NE(status.message().find("--station-key"), std::string::npos);
}

}  // namespace
}  // namespace enamel::station
