#include <gtest/gtest.h>

#include <filesystem>

#include "common/base/file.h"
#include "common/trace/replay.h"
#include "tests/common/trace/describe.h"
#include "tests/common/trace/sample.h"

namespace enamel::trace {
namespace {

Bytes Golden(const std::string& name) {
  auto path = std::filesystem::path(ENAMEL_SOURCE_DIR) / "schemas/golden/trace" / name;
  auto bytes = ReadFile(path);
  EXPECT_TRUE(bytes.ok()) << bytes.status().message();
  return bytes.ok() ? *bytes : Bytes();
}

boost::json::object Content(const std::string& name) {
  Bytes text = Golden(name + ".json");
  return boost::json::parse(std::string(AsText(text))).as_object();
}

TEST(GoldenTest, TicketReadsAsDescribedAndIsWrittenToTheSameBytes) {
  Bytes bytes = Golden("ticket.bin");
  auto ticket = DecodeTicket(bytes);
  ASSERT_TRUE(ticket.ok()) << ticket.status().message();
  EXPECT_EQ(Describe(*ticket), Content("ticket"));
  EXPECT_TRUE(VerifyTicket(*ticket, sample::ServerKeys().public_key));
  EXPECT_EQ(EncodeTicket(sample::MakeHeader().ticket), bytes);
}

TEST(GoldenTest, HeaderReadsAsDescribedAndIsWrittenToTheSameBytes) {
  Bytes bytes = Golden("header.bin");
  auto header = DecodeHeader(bytes);
  ASSERT_TRUE(header.ok()) << header.status().message();
  EXPECT_EQ(Describe(*header), Content("header"));
  EXPECT_EQ(EncodeHeader(sample::MakeHeader()), bytes);
}

TEST(GoldenTest, ChunkReadsAsDescribedAndHoldsItsSignature) {
  Bytes bytes = Golden("chunk.bin");
  auto chunk = DecodeChunk(bytes);
  ASSERT_TRUE(chunk.ok()) << chunk.status().message();
  EXPECT_EQ(Describe(*chunk), Content("chunk"));
  EXPECT_EQ(chunk->ticks, sample::OddTicks());
  EXPECT_TRUE(VerifyChunk(bytes, sample::StationKeys().public_key));
}

TEST(GoldenTest, SealReadsAsDescribedAndIsWrittenToTheSameBytes) {
  Bytes bytes = Golden("seal.bin");
  auto seal = DecodeSeal(bytes);
  ASSERT_TRUE(seal.ok()) << seal.status().message();
  EXPECT_EQ(Describe(*seal), Content("seal"));
  EXPECT_EQ(EncodeSeal(*seal), bytes);
}

TEST(GoldenTest, RecordingReadsAsDescribedAndEachChunkIsSigned) {
  Bytes bytes = Golden("recording.bin");
  auto file = DecodeTraceFile(bytes);
  ASSERT_TRUE(file.ok()) << file.status().message();
  EXPECT_EQ(Describe(*file), Content("recording"));
  EXPECT_EQ(EncodeTraceFile(*file), bytes);
  for (const Bytes& chunk : file->chunks) {
    EXPECT_TRUE(VerifyChunk(chunk, sample::StationKeys().public_key));
  }
}

TEST(GoldenTest, RecordingReplaysToTheBit) {
  auto file = DecodeTraceFile(Golden("recording.bin"));
  ASSERT_TRUE(file.ok()) << file.status().message();
  auto header = DecodeHeader(file->header);
  ASSERT_TRUE(header.ok()) << header.status().message();
  ASSERT_TRUE(core::ValidateParams(header->params).ok());
  core::Core core(header->params, sample::MakeBlock());
  auto report = Replay(core, *header, file->chunks);
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_TRUE(report->witness_ok) << report->what << " differs at tick " << report->first_bad_tick
                                  << ": the core gives other results than it gave";
  EXPECT_EQ(report->state_hash, file->seal->state_hash);
  EXPECT_EQ(report->ticks, file->seal->ticks);
}

}  // namespace
}  // namespace enamel::trace
