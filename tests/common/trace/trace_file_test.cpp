#include <gtest/gtest.h>

#include "common/trace/trace.h"
#include "tests/common/trace/sample.h"

namespace enamel::trace {
namespace {

TraceFile MakeFile() {
  auto recording = sample::Record(sample::CutInputs(90), 30);
  return {EncodeHeader(recording.header), recording.chunks, recording.seal, false};
}

size_t ChunksBefore(const TraceFile& file, size_t size) {
  size_t at = 8 + 9 + file.header.size(), whole = 0;
  for (const Bytes& chunk : file.chunks) {
    at += 9 + chunk.size();
    if (at <= size) ++whole;
  }
  return whole;
}

TEST(TraceFileTest, GivesBackWhatWasWritten) {
  TraceFile file = MakeFile();
  auto read = DecodeTraceFile(EncodeTraceFile(file));
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(*read, file);
}

TEST(TraceFileTest, EveryTruncationKeepsEveryWholeChunk) {
  TraceFile file = MakeFile();
  Bytes bytes = EncodeTraceFile(file);
  size_t header_end = 8 + 9 + file.header.size();
  for (size_t n = 0; n < bytes.size(); ++n) {
    auto read = DecodeTraceFile(ByteView(bytes).first(n));
    if (n < header_end) {
      EXPECT_FALSE(read.ok()) << n;
      continue;
    }
    ASSERT_TRUE(read.ok()) << n << ": " << read.status().message();
    size_t whole = ChunksBefore(file, n);
    ASSERT_EQ(read->chunks.size(), whole) << n;
    EXPECT_TRUE(std::equal(read->chunks.begin(), read->chunks.end(), file.chunks.begin()));
    EXPECT_FALSE(read->seal.has_value());
  }
}

TEST(TraceFileTest, TruncatedIsToldFromUnfinished) {
  TraceFile file = MakeFile();
  file.seal.reset();
  Bytes bytes = EncodeTraceFile(file);
  EXPECT_FALSE(DecodeTraceFile(bytes)->truncated);
  bytes.pop_back();
  EXPECT_TRUE(DecodeTraceFile(bytes)->truncated);
}

TEST(TraceFileTest, AnyChangedBitIsNoticedOrCutsTheFile) {
  TraceFile file = MakeFile();
  Bytes bytes = EncodeTraceFile(file);
  for (size_t bit = 0; bit < bytes.size() * 8; bit += 3) {
    bytes[bit / 8] ^= static_cast<uint8_t>(1 << (bit % 8));
    auto read = DecodeTraceFile(bytes);
    // A larger length may look like a cut file; it never yields other content.
    if (read.ok()) {
      EXPECT_TRUE(read->truncated) << bit;
      EXPECT_LT(read->chunks.size() + (read->seal ? 1 : 0), 4u) << bit;
    }
    bytes[bit / 8] ^= static_cast<uint8_t>(1 << (bit % 8));
  }
}

TEST(TraceFileTest, RecordOfUnknownKindIsSkipped) {
  TraceFile file = MakeFile();
  Bytes bytes = EncodeTraceFile(file);
  ByteWriter record;
  record.U8(200);
  record.Text("a note of a later version");
  Sha256 check = HashSha256(record.bytes());
  record.Raw(check.view().first(4));
  bytes.insert(bytes.end(), record.bytes().begin(), record.bytes().end());
  auto read = DecodeTraceFile(bytes);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(*read, file);
}

TEST(TraceFileTest, SomethingElseIsRefusedWithWhatWasExpected) {
  auto read = DecodeTraceFile(AsBytes("solid cube\n facet normal 0 0 1\n"));
  ASSERT_FALSE(read.ok());
  EXPECT_NE(read.status().message().find("ENaf"), std::string::npos) << read.status().message();
}

TEST(TraceFileTest, ChunkBeforeTheHeaderIsRefused) {
  TraceFile file = MakeFile();
  Bytes whole = EncodeTraceFile(file);
  Bytes bytes(whole.begin(), whole.begin() + 8);
  bytes.insert(bytes.end(), whole.begin() + 8 + 9 + static_cast<long>(file.header.size()),
               whole.end());
  EXPECT_EQ(DecodeTraceFile(bytes).status().code(), Code::kInvalidInput);
}

}  // namespace
}  // namespace enamel::trace
