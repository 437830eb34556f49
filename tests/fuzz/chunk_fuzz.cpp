#include "common/base/check.h"
#include "common/trace/trace.h"

// Any bytes as a chunk: refused, or ticks that are unchanged by encoding and decoding.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace enamel;
  ByteView bytes(data, size);
  auto head = trace::DecodeChunkHead(bytes);
  auto chunk = trace::DecodeChunk(bytes);
  trace::VerifyChunk(bytes, trace::PublicKey{});
  if (!chunk.ok()) return 0;
  ENAMEL_CHECK(head.ok() && head->head == chunk->head && head->hash == chunk->hash);
  ENAMEL_CHECK(chunk->ticks.size() == chunk->head.count);
  auto again =
      trace::DecodeChunk(trace::EncodeChunk(chunk->head, chunk->ticks, trace::SecretKey{}));
  ENAMEL_CHECK(again.ok() && again->ticks == chunk->ticks && again->head == chunk->head);
  return 0;
}
