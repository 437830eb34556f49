#include <string>

#include "common/trace/pieces.h"
#include "common/trace/trace.h"

namespace enamel::trace {

Bytes EncodeTraceFile(const TraceFile& file) {
  ByteWriter out;
  BeginTraceFile(file.header, out);
  for (const Bytes& chunk : file.chunks) WriteChunk(chunk, out);
  if (file.seal.has_value()) WriteSeal(*file.seal, out);
  return out.Take();
}

Result<TraceFile> DecodeTraceFile(ByteView bytes) {
  PieceReader reader;
  reader.Begin(bytes);
  TraceFile file;
  for (;;) {
    ENAMEL_ASSIGN_OR_RETURN(const auto chunk, reader.Next());
    if (!chunk.has_value()) break;
    file.chunks.emplace_back(chunk->begin(), chunk->end());
  }
  file.header = reader.header();
  file.seal = reader.seal();
  file.truncated = reader.truncated();
  if (file.header.empty()) {
    return Status(Code::kInvalidInput,
                  "trace file: its " + std::to_string(bytes.size()) +
                      " bytes end before the header does; nothing of the recording can be used");
  }
  return file;
}

}  // namespace enamel::trace
