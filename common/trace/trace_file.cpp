#include <algorithm>
#include <string>

#include "common/trace/layout.h"
#include "common/trace/trace.h"

namespace enamel::trace {
namespace {

enum RecordKind : uint8_t { kHeaderRecord = 1, kChunkRecord = 2, kSealRecord = 3 };

constexpr char kWhat[] = "trace file";
constexpr size_t kMaxRecordBytes = kMaxChunkBytes;

Status Damaged(size_t offset, const std::string& why) { return DamagedAt(kWhat, offset, why); }

Status Add(const Record& record, size_t offset, TraceFile& file) {
  bool known = record.kind >= kHeaderRecord && record.kind <= kSealRecord;
  // Skipped: a newer program may add kinds of records, and only here (schemas/trace_format.md).
  if (!known) return Status::Ok();
  if (file.seal.has_value()) return Damaged(offset, "expected nothing after the seal");
  // Either a header comes now, or there is one already: neither none nor two.
  if (file.header.empty() != (record.kind == kHeaderRecord)) {
    return Damaged(offset,
                   file.header.empty() ? "expected the header first" : "found a second header");
  }
  if (record.kind == kHeaderRecord) {
    if (record.content.empty()) return Damaged(offset, "expected a header, found no bytes");
    file.header.assign(record.content.begin(), record.content.end());
  } else if (record.kind == kChunkRecord) {
    file.chunks.emplace_back(record.content.begin(), record.content.end());
  } else {
    ENAMEL_ASSIGN_OR_RETURN(auto seal, DecodeSeal(record.content));
    file.seal = seal;
  }
  return Status::Ok();
}

}  // namespace

Bytes EncodeTraceFile(const TraceFile& file) {
  ByteWriter out;
  WriteMagic(kFileMagic, out);
  out.U16(0);
  WriteRecord(kHeaderRecord, file.header, out);
  for (const Bytes& chunk : file.chunks) WriteRecord(kChunkRecord, chunk, out);
  if (file.seal.has_value()) WriteRecord(kSealRecord, EncodeSeal(*file.seal), out);
  return out.Take();
}

Result<TraceFile> DecodeTraceFile(ByteView bytes) {
  ByteReader in(bytes);
  ENAMEL_RETURN_IF_ERROR(ReadMagic(kWhat, kFileMagic, in));
  uint16_t reserved = in.U16();
  if (reserved != 0) return Damaged(6, "expected 0 in the reserved field of the file's head");
  TraceFile file;
  while (in.ok() && !in.AtEnd()) {
    size_t offset = in.offset();
    ENAMEL_ASSIGN_OR_RETURN(auto record, ReadRecord(kWhat, kMaxRecordBytes, in));
    if (!record.has_value()) break;
    ENAMEL_RETURN_IF_ERROR(Add(*record, offset, file));
  }
  // Not an error: what is whole before the cut is as good as ever.
  file.truncated = !in.ok();
  if (file.header.empty()) {
    return Status(Code::kInvalidInput,
                  "trace file: its " + std::to_string(bytes.size()) +
                      " bytes end before the header does; nothing of the recording can be used");
  }
  return file;
}

}  // namespace enamel::trace
