#include <algorithm>

#include "common/base/check.h"
#include "common/timeline/changing.h"
#include "common/timeline/deviation.h"
#include "common/timeline/player.h"

// A start tooth and a timeline in one input, each after its length (u32): refused, or played from
// end to end without reading past the end. Its start tooth's hash is set to fit, so that the code
// after that check is reached. The same input is also read as a deviation, and the timeline's parts
// as what they are; each must be unchanged by writing and reading.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace enamel;
  if (auto deviation = timeline::DecodeDeviation({data, size}); deviation.ok()) {
    auto again = timeline::DecodeDeviation(timeline::EncodeDeviation(*deviation));
    ENAMEL_CHECK(again.ok() && again->cells == deviation->cells);
  }
  ByteReader in(ByteView(data, size));
  const ByteView start = in.Blob(size);
  const ByteView rest = in.Blob(size);
  if (!in.ok()) return 0;
  Bytes file(rest.begin(), rest.end());
  constexpr size_t kHashAt = 48;
  if (file.size() >= kHashAt + 32) {
    const Sha256 hash = HashSha256(start);
    std::copy(hash.bytes.begin(), hash.bytes.end(), file.begin() + kHashAt);
  }
  auto player = timeline::Player::Open(start, file);
  if (!player.ok()) return 0;
  const timeline::Head& head = player->head();
  // The head is written as it was read.
  ENAMEL_CHECK(std::ranges::equal(timeline::EncodeHead(head), ByteView(file).first(head.bytes())));
  ByteReader parts(ByteView(file).subspan(head.bytes()));
  for (uint32_t bytes : {head.end_bytes, head.still_bytes}) {
    auto mesh = timeline::DecodeMesh(parts.Raw(bytes));
    if (mesh.ok()) ENAMEL_CHECK(*timeline::DecodeMesh(timeline::EncodeMesh(*mesh)) == *mesh);
  }
  if (auto part = timeline::DecodeChanging(parts.Raw(head.changing_bytes), head.spec); part.ok()) {
    auto again = timeline::DecodeChanging(timeline::EncodeChanging(*part), head.spec);
    ENAMEL_CHECK(again.ok() && again->bricks == part->bricks && again->flags == part->flags &&
                 again->samples == part->samples);
  }
  for (size_t s = 0; s < head.segments.size(); ++s) {
    if (auto poses = player->Poses(s); poses.ok()) ENAMEL_CHECK(poses->size() == head.FramesIn(s));
    const uint64_t last = uint64_t{s} * head.segment_frames + head.FramesIn(s);
    if (!player->Seek(static_cast<uint32_t>(last)).ok()) continue;
    ENAMEL_CHECK(player->at() == last);
  }
  return 0;
}
