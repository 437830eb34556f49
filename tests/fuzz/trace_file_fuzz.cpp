#include "common/base/check.h"
#include "common/trace/trace.h"

// Any bytes as a trace file, header, ticket and seal: refused, or of one encoding only.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace enamel;
  ByteView bytes(data, size);
  Bytes copy(bytes.begin(), bytes.end());
  if (auto header = trace::DecodeHeader(bytes); header.ok()) {
    ENAMEL_CHECK(trace::EncodeHeader(*header) == copy);
  }
  if (auto ticket = trace::DecodeTicket(bytes); ticket.ok()) {
    ENAMEL_CHECK(trace::EncodeTicket(*ticket) == copy);
  }
  if (auto seal = trace::DecodeSeal(bytes); seal.ok()) {
    ENAMEL_CHECK(trace::EncodeSeal(*seal) == copy);
  }
  auto file = trace::DecodeTraceFile(bytes);
  if (!file.ok()) return 0;
  auto again = trace::DecodeTraceFile(trace::EncodeTraceFile(*file));
  file->truncated = false;
  ENAMEL_CHECK(again.ok() && *again == *file);
  return 0;
}
