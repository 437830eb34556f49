#include "common/base/check.h"
#include "common/scoring/movement/provenance.h"

// Any bytes as a provenance blob: refused, or unchanged by encoding and decoding.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace enamel;
  auto read = scoring::DecodeProvenance(ByteView(data, size));
  if (!read.ok()) return 0;
  size_t seen = 0;
  read->ForEach([&](const ivec3& voxel, uint32_t tick) {
    ENAMEL_CHECK(tick < read->ticks && read->TickOf(voxel) == tick);
    ++seen;
  });
  ENAMEL_CHECK(seen == read->tick.size());
  auto again = scoring::DecodeProvenance(scoring::EncodeProvenance(*read));
  ENAMEL_CHECK(again.ok() && *again == *read);
  return 0;
}
