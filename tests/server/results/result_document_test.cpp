#include "server/results/result_document.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <filesystem>

#include "common/base/file.h"
#include "common/base/hex.h"

// Results are written as schemas/result.md says, and nothing in one can be changed unseen.
namespace enamel::server {
namespace {

namespace json = boost::json;

Bytes Golden(const std::string& name) {
  auto bytes = ReadFile(std::filesystem::path(ENAMEL_SOURCE_DIR) / "schemas/golden" / name);
  EXPECT_TRUE(bytes.ok()) << bytes.status().message();
  return bytes.ok() ? *bytes : Bytes();
}

TEST(ResultDocumentTest, GoldenFileReadsAsItsDescriptionSays) {
  auto d = DecodeResult(Golden("result.bin"));
  ASSERT_TRUE(d.ok()) << d.status().message();
  json::object says = json::parse(AsText(Golden("result.json"))).as_object();
  const std::pair<const char*, std::string> members[] = {
      {"attempt", d->attempt.Text()},
      {"header", d->header.Hex()},
      {"recording", d->recording.Hex()},
      {"exercise", d->exercise.Hex()},
      {"rubric", d->rubric.Hex()},
      {"scene", d->scene.Hex()},
      {"volume", d->volume.Hex()},
      {"profile", d->profile.Hex()},
      {"reference", d->reference.Text()},
      {"reference_recording", d->reference_recording.Hex()},
      {"reference_tooth", d->reference_tooth.Hex()},
      {"score_document", d->score_document.Hex()},
      {"tooth", d->tooth.Hex()},
      {"deviation", d->deviation.Hex()},
      {"series", d->series.Hex()},
      {"judgement", d->judgement.Hex()},
      {"score_file", d->score_file.Hex()},
      {"tooth_file", d->tooth_file.Hex()},
      {"surface_file", d->surface_file.Hex()},
      {"series_file", d->series_file.Hex()},
      {"key", ToHex(d->key)},
      {"signature", ToHex(d->signature)}};
  for (const auto& [name, found] : members) EXPECT_EQ(found, says.at(name).as_string()) << name;
  EXPECT_EQ(d->scored_ms, says.at("scored_unix_ms").as_int64());
  EXPECT_EQ(d->points, says.at("points").as_double());
  EXPECT_EQ(d->critical_fail, says.at("critical_fail").as_bool());
  EXPECT_EQ(d->metric_set, says.at("metric_set").as_int64());
  EXPECT_EQ(d->core_version, says.at("core_version").as_int64());
  EXPECT_EQ(d->rubric_version, says.at("rubric_version").as_int64());
  EXPECT_EQ(d->flags, says.at("flags").as_int64());
  EXPECT_EQ(d->hand, says.at("hand").as_int64());
  EXPECT_EQ(says.size(), 30u) << "every member is compared";
  EXPECT_EQ(EncodeResult(*d), Golden("result.bin"));
  EXPECT_TRUE(VerifyResult(*d)) << "signed apart from our code";
}

TEST(ResultDocumentTest, AnyChangedBitIsFound) {
  const Bytes golden = Golden("result.bin");
  for (size_t bit = 0; bit < golden.size() * 8; ++bit) {
    Bytes changed = golden;
    changed[bit / 8] ^= static_cast<uint8_t>(1 << bit % 8);
    auto d = DecodeResult(changed);
    EXPECT_FALSE(d.ok() && VerifyResult(*d)) << "bit " << bit;
  }
}

TEST(ResultDocumentTest, OtherSizesAreRefused) {
  const Bytes golden = Golden("result.bin");
  for (size_t size = 0; size < golden.size(); ++size) {
    EXPECT_FALSE(DecodeResult(ByteView(golden).first(size)).ok()) << size;
  }
  Bytes longer = golden;
  longer.push_back(0);
  EXPECT_EQ(DecodeResult(longer).status().code(), Code::kInvalidInput);
}

TEST(ResultDocumentTest, NewerVersionIsRefusedAsSuch) {
  Bytes newer = Golden("result.bin");
  newer[4] = 2;
  newer.push_back(0);
  EXPECT_EQ(DecodeResult(newer).status().code(), Code::kVersion);
}

TEST(ResultDocumentTest, PointsThatAreNoNumberAreRefused) {
  ResultDocument d = *DecodeResult(Golden("result.bin"));
  for (double points : {std::nan(""), HUGE_VAL}) {
    d.points = points;
    EXPECT_EQ(DecodeResult(EncodeResult(d)).status().code(), Code::kInvalidInput);
  }
}

TEST(ResultDocumentTest, ASignatureOverATicketIsNoneOverAResult) {
  ResultDocument d = *DecodeResult(Golden("result.bin"));
  const Bytes encoded = EncodeResult(d);
  const auto key = trace::KeyPairFromSeed([] {
    std::array<uint8_t, 32> seed;
    seed.fill(1);
    return seed;
  }());
  d.signature =
      trace::SignText("enamel.attempt-ticket.v1", ByteView(encoded).first(680), key.secret_key);
  EXPECT_FALSE(VerifyResult(d));
}

}  // namespace
}  // namespace enamel::server
