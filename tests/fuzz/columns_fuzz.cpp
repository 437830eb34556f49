#include "common/base/check.h"
#include "common/trace/columns.h"

// First two bytes: the number of ticks; the rest: an unpacked payload. Reaches the column decoder
// without passing zstd first.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace enamel;
  ByteReader in({data, size});
  size_t count = in.U16() % (trace::kMaxTicksPerChunk + 1);
  auto ticks = trace::DecodeColumns(in.Raw(in.remaining()), count);
  if (!ticks.ok()) return 0;
  ENAMEL_CHECK(ticks->size() == count);
  auto again = trace::DecodeColumns(trace::EncodeColumns(*ticks), count);
  ENAMEL_CHECK(again.ok() && *again == *ticks);
  return 0;
}
