#include "common/trace/pieces.h"

#include <gtest/gtest.h>

#include "tests/common/trace/sample.h"

namespace enamel::trace {
namespace {

TraceFile MakeFile() {
  auto recording = sample::Record(sample::CutInputs(90), 30);
  return {EncodeHeader(recording.header), recording.chunks, recording.seal, false};
}

// Where records end, the file's head first.
std::vector<size_t> EndsOf(const TraceFile& file) {
  std::vector<size_t> out{8, 8 + 9 + file.header.size()};
  for (const Bytes& chunk : file.chunks) out.push_back(out.back() + 9 + chunk.size());
  return out;
}

// All pieces read; the chunks.
Result<std::vector<Bytes>> Read(PieceReader& reader, const std::vector<ByteView>& pieces) {
  std::vector<Bytes> out;
  for (const ByteView piece : pieces) {
    reader.Begin(piece);
    for (;;) {
      ENAMEL_ASSIGN_OR_RETURN(const auto chunk, reader.Next());
      if (!chunk) break;
      out.emplace_back(chunk->begin(), chunk->end());
    }
  }
  return out;
}

TEST(PiecesTest, CutAtAnyRecordTheyAreTheWholeFile) {
  const TraceFile file = MakeFile();
  const Bytes bytes = EncodeTraceFile(file);
  EXPECT_EQ(bytes.size(), TraceFileBytes(file.header.size() + EndsOf(file).back() -
                                             EndsOf(file)[1] - 9 * file.chunks.size(),
                                         3, true));
  for (size_t end : EndsOf(file)) {
    PieceReader reader;
    const ByteView all(bytes);
    const auto chunks = Read(reader, {all.first(end), all.subspan(end)});
    ASSERT_TRUE(chunks.ok()) << end << ": " << chunks.status().message();
    EXPECT_EQ(*chunks, file.chunks) << end;
    EXPECT_EQ(reader.header(), file.header);
    EXPECT_EQ(reader.seal(), file.seal);
    EXPECT_FALSE(reader.truncated());
  }
}

TEST(PiecesTest, APieceCutInsideARecordIsTruncated) {
  const TraceFile file = MakeFile();
  const Bytes bytes = EncodeTraceFile(file);
  PieceReader reader;
  ASSERT_TRUE(Read(reader, {ByteView(bytes).first(EndsOf(file)[2] + 5)}).ok());
  EXPECT_TRUE(reader.truncated());
}

TEST(PiecesTest, ReadsOnBehindPiecesThatAreLeftOut) {
  const TraceFile file = MakeFile();
  const Bytes bytes = EncodeTraceFile(file);
  PieceReader reader(file.header);
  const auto chunks = Read(reader, {ByteView(bytes).subspan(EndsOf(file)[2])});
  ASSERT_TRUE(chunks.ok()) << chunks.status().message();
  EXPECT_EQ(*chunks, std::vector<Bytes>(file.chunks.begin() + 1, file.chunks.end()));
  EXPECT_EQ(reader.seal(), file.seal);
}

TEST(PiecesTest, DamageIsPlacedInTheWholeFile) {
  const TraceFile file = MakeFile();
  Bytes bytes = EncodeTraceFile(file);
  const size_t at = EndsOf(file)[2];
  bytes[at + 20] ^= 1;
  PieceReader reader;
  const ByteView all(bytes);
  const auto chunks = Read(reader, {all.first(at), all.subspan(at)});
  ASSERT_FALSE(chunks.ok());
  EXPECT_EQ(chunks.status().field(), std::to_string(at)) << chunks.status().message();
}

}  // namespace
}  // namespace enamel::trace
