#include <algorithm>
#include <string>

#include "common/trace/layout.h"
#include "common/trace/trace.h"

namespace enamel::trace {
namespace {

enum RecordKind : uint8_t { kHeaderRecord = 1, kChunkRecord = 2, kSealRecord = 3 };

constexpr size_t kCheckBytes = 4;
constexpr size_t kMaxRecordBytes = kMaxChunkBytes;

struct Record {
  uint8_t kind = 0;
  ByteView content;
};

Sha256 CheckOf(uint8_t kind, ByteView content) {
  ByteWriter prefix;
  prefix.U8(kind);
  prefix.U32(static_cast<uint32_t>(content.size()));
  Sha256Stream stream;
  stream.Update(prefix.bytes());
  stream.Update(content);
  return stream.Finish();
}

void WriteRecord(uint8_t kind, ByteView content, ByteWriter& out) {
  out.U8(kind);
  out.Blob(content);
  out.Raw(CheckOf(kind, content).view().first(kCheckBytes));
}

Status Damaged(size_t offset, const std::string& what) {
  return Status(Code::kInvalidInput,
                "trace file, record at byte " + std::to_string(offset) + ": " + what,
                std::to_string(offset));
}

// The next record; nothing (and in.ok() false) when the file ends inside it.
Result<std::optional<Record>> ReadRecord(ByteReader& in) {
  size_t offset = in.offset();
  Record record;
  record.kind = in.U8();
  size_t size = in.U32();
  if (in.ok() && size > kMaxRecordBytes) {
    return TooLarge("trace file, record at byte " + std::to_string(offset), kMaxRecordBytes, size);
  }
  record.content = in.Raw(size);
  ByteView check = in.Raw(kCheckBytes);
  if (!in.ok()) return std::optional<Record>();
  Sha256 expected = CheckOf(record.kind, record.content);
  if (!std::equal(check.begin(), check.end(), expected.bytes.begin())) {
    return Damaged(offset,
                   "its check does not fit its content, the file is damaged here; "
                   "fetch it again from the spool or the server");
  }
  return std::optional<Record>(record);
}

Status Add(const Record& record, size_t offset, TraceFile& file) {
  bool known = record.kind >= kHeaderRecord && record.kind <= kSealRecord;
  if (!known) return Status::Ok();
  if (file.seal.has_value()) return Damaged(offset, "expected nothing after the seal");
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
    auto seal = DecodeSeal(record.content);
    if (!seal.ok()) return seal.status();
    file.seal = *seal;
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
  ENAMEL_RETURN_IF_ERROR(ReadMagic("trace file", kFileMagic, in));
  uint16_t reserved = in.U16();
  if (reserved != 0) return Damaged(6, "expected 0 in the reserved field of the file's head");
  TraceFile file;
  while (in.ok() && !in.AtEnd()) {
    size_t offset = in.offset();
    auto record = ReadRecord(in);
    if (!record.ok()) return record.status();
    if (!record->has_value()) break;
    ENAMEL_RETURN_IF_ERROR(Add(**record, offset, file));
  }
  file.truncated = !in.ok();
  if (file.header.empty()) {
    return Status(Code::kInvalidInput,
                  "trace file: its " + std::to_string(bytes.size()) +
                      " bytes end before the header does; nothing of the recording can be used");
  }
  return file;
}

}  // namespace enamel::trace
