#include "common/trace/pieces.h"

#include <string>

#include "common/trace/layout.h"

namespace enamel::trace {
namespace {

enum RecordKind : uint8_t { kHeaderRecord = 1, kChunkRecord = 2, kSealRecord = 3 };

constexpr char kWhat[] = "trace file";
constexpr size_t kMaxRecordBytes = kMaxChunkBytes;
constexpr uint64_t kFileHeadBytes = 8, kRecordFrameBytes = 9;

Status Damaged(size_t offset, const std::string& why) { return DamagedAt(kWhat, offset, why); }

}  // namespace

NextChunk EachOf(std::span<const Bytes> chunks) {
  return [chunks]() mutable -> Result<std::optional<Bytes>> {
    if (chunks.empty()) return std::optional<Bytes>();
    std::optional<Bytes> next(chunks.front());
    chunks = chunks.subspan(1);
    return next;
  };
}

void BeginTraceFile(ByteView header, ByteWriter& out) {
  WriteMagic(kFileMagic, out);
  out.U16(0);
  WriteRecord(kHeaderRecord, header, out);
}

void WriteChunk(ByteView chunk, ByteWriter& out) { WriteRecord(kChunkRecord, chunk, out); }

void WriteSeal(const Seal& seal, ByteWriter& out) {
  WriteRecord(kSealRecord, EncodeSeal(seal), out);
}

uint64_t TraceFileBytes(uint64_t bytes, uint32_t chunks, bool sealed) {
  return kFileHeadBytes + bytes + kRecordFrameBytes * (uint64_t{1} + chunks) +
         (sealed ? kRecordFrameBytes + kSealBytes : 0);
}

void PieceReader::Begin(ByteView piece) {
  before_ += in_.offset();
  in_ = ByteReader(piece);
}

Status PieceReader::ReadHead() {
  began_ = true;
  ENAMEL_RETURN_IF_ERROR(ReadMagic(kWhat, kFileMagic, in_));
  if (in_.U16() != 0) return Damaged(6, "expected 0 in the reserved field of the file's head");
  return Status::Ok();
}

Result<std::optional<ByteView>> PieceReader::Next() {
  if (!began_) ENAMEL_RETURN_IF_ERROR(ReadHead());
  while (in_.ok() && !in_.AtEnd()) {
    const size_t offset = before_ + in_.offset();
    ENAMEL_ASSIGN_OR_RETURN(const auto record, ReadRecord(kWhat, kMaxRecordBytes, before_, in_));
    if (!record.has_value()) break;
    const bool known = record->kind >= kHeaderRecord && record->kind <= kSealRecord;
    // Skipped: a newer program may add kinds of records, and only here (schemas/trace_format.md).
    if (!known) continue;
    if (seal_.has_value()) return Damaged(offset, "expected nothing after the seal");
    // Either a header comes now, or there is one already: neither none nor two.
    if (header_.empty() != (record->kind == kHeaderRecord)) {
      return Damaged(offset,
                     header_.empty() ? "expected the header first" : "found a second header");
    }
    if (record->kind == kChunkRecord) return std::optional<ByteView>(record->content);
    if (record->kind == kHeaderRecord) {
      if (record->content.empty()) return Damaged(offset, "expected a header, found no bytes");
      header_.assign(record->content.begin(), record->content.end());
    } else {
      ENAMEL_ASSIGN_OR_RETURN(seal_, DecodeSeal(record->content));
    }
  }
  // Records before the cut are whole: the caller judges what the cut means.
  truncated_ = !in_.ok();
  return std::optional<ByteView>();
}

}  // namespace enamel::trace
