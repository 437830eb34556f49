#pragma once

#include <functional>
#include <optional>
#include <span>
#include <utility>

#include "common/trace/trace.h"

// A recording that is larger than memory may be: its chunks one at a time, and its trace file
// (schemas/trace_format.md) in pieces that end where records do.
namespace enamel::trace {

// The next chunk of a recording, in order; none after the last one.
using NextChunk = std::function<Result<std::optional<Bytes>>()>;
// Gives chunks that are in memory, which outlive it.
NextChunk EachOf(std::span<const Bytes> chunks);

// Appends to a piece: BeginTraceFile first, WriteSeal last.
void BeginTraceFile(ByteView header, ByteWriter& out);
void WriteChunk(ByteView chunk, ByteWriter& out);
void WriteSeal(const Seal& seal, ByteWriter& out);
// The size of a trace file whose header and chunks have so many bytes.
uint64_t TraceFileBytes(uint64_t bytes, uint32_t chunks, bool sealed);

// Reads a trace file piece by piece. Splits and checks the records as DecodeTraceFile does.
class PieceReader {
 public:
  PieceReader() = default;
  // Begins behind the file's first piece, which has this header.
  explicit PieceReader(Bytes header) : began_(true), header_(std::move(header)) {}

  // The piece that follows those read so far; it outlives its reading.
  void Begin(ByteView piece);
  // The next chunk of this piece; none at its end. Errors: DecodeTraceFile's.
  Result<std::optional<ByteView>> Next();

  // The header and the seal that have been read; empty before their records.
  const Bytes& header() const { return header_; }
  const std::optional<Seal>& seal() const { return seal_; }
  // The piece ended inside a record.
  bool truncated() const { return truncated_; }

 private:
  Status ReadHead();

  ByteReader in_{ByteView()};
  size_t before_ = 0;  // bytes of the pieces before this one
  bool began_ = false, truncated_ = false;
  Bytes header_;
  std::optional<Seal> seal_;
};

}  // namespace enamel::trace
