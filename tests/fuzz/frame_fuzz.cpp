#include <algorithm>
#include <optional>

#include "common/base/check.h"
#include "common/protocol/frame.h"
#include "common/protocol/messages.h"

namespace {

using namespace enamel;

struct Outcome {
  std::vector<Bytes> messages;
  bool refused = false;

  bool operator==(const Outcome&) const = default;
};

Outcome ReadIn(ByteView stream, size_t piece) {
  protocol::FrameReader reader;
  Outcome out;
  while (!stream.empty()) {
    auto space = reader.Prepare();
    ENAMEL_CHECK(!space.empty());
    size_t n = std::min({space.size(), stream.size(), piece});
    std::copy_n(stream.begin(), n, space.begin());
    stream = stream.subspan(n);
    out.refused = !reader.Resume(n).ok();
    if (out.refused) return out;
    if (reader.done()) out.messages.push_back(reader.Take());
  }
  return out;
}

}  // namespace

// Any bytes as a stream: the same messages however it is split, each of them one frame, and the
// parsers of messages survive them.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  ByteView stream(data, size);
  Outcome whole = ReadIn(stream, size);
  size_t piece = size > 0 ? data[size - 1] % 7 + 1u : 1u;
  ENAMEL_CHECK(ReadIn(stream, piece) == whole);
  ByteWriter joined;
  for (const Bytes& message : whole.messages) {
    joined.Raw(*protocol::EncodeFrame(message));
    (void)protocol::ParseRequest(message).ok();
    (void)protocol::ParseReply(message).ok();
  }
  ENAMEL_CHECK(std::equal(joined.bytes().begin(), joined.bytes().end(), stream.begin()));
  return 0;
}
