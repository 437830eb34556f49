#include "common/trace/keyframes.h"

#include <algorithm>
#include <bit>
#include <string>

#include "common/base/packed.h"
#include "common/base/state_hash.h"
#include "common/trace/layout.h"

namespace enamel::trace {
namespace {

constexpr char kWhat[] = "keyframes";
constexpr char kPart[] = "keyframes (a cache, which may be deleted)";
constexpr uint8_t kKeyframeRecord = 1;
constexpr size_t kMaxBricks = 1 << 20;
constexpr size_t kBrickBytes = 4 + 2 * cutting::kBrickVoxels;
// A cache: a person waits while it is made, the same machine reads it, and deleting it loses
// nothing.
constexpr int kZstdLevel = 1;

// Everything that the state's layout depends on.
uint64_t Build() {
  StateHash hash;
  for (char c : std::string_view(__VERSION__)) hash.U64(static_cast<uint8_t>(c));
  // No proof that two layouts are the same: what slips through is found by the state hash, and by
  // the witness of the chunk that is always re-run (moment.h).
  hash.U64(sizeof(core::Core));
  hash.U64(sizeof(void*));
  hash.U64(std::endian::native == std::endian::little);
  hash.U64(core::kCoreVersion);
  return hash.value();
}

Sha256 ReadHash(ByteReader& in) {
  Sha256 out;
  ByteView raw = in.Raw(out.bytes.size());
  std::copy(raw.begin(), raw.end(), out.bytes.begin());
  return out;
}

Status Unusable(const std::string& why) {
  return Status(Code::kInvalidInput,
                "keyframes: " + why + "; delete the file, and it is made again");
}

}  // namespace

Result<Keyframes> Keyframes::Decode(ByteView bytes, const Sha256& header_hash) {
  ByteReader in(bytes);
  ENAMEL_RETURN_IF_ERROR(ReadMagic(kWhat, kKeyframesMagic, in));
  uint16_t reserved = in.U16();
  uint64_t build = in.U64();
  Sha256 header = ReadHash(in);
  if (!in.ok()) return EndsEarly(kWhat, bytes.size());
  if (reserved != 0) return Unusable("expected 0 in the reserved field");
  if (build != Build()) {
    return Status(Code::kVersion, "keyframes: made by another core or build of the program");
  }
  if (header != header_hash) {
    return Status(Code::kConflict, "keyframes: made for another recording");
  }
  Keyframes out(header_hash);
  while (!in.AtEnd()) {
    ENAMEL_ASSIGN_OR_RETURN(auto record, ReadRecord(kWhat, kMaxKeyframeBytes, /*before=*/0, in));
    if (!record.has_value()) break;
    if (record->kind != kKeyframeRecord) continue;
    if (out.size() == kMaxKeyframes) return TooLarge(kWhat, kMaxKeyframes, out.size() + 1);
    ENAMEL_ASSIGN_OR_RETURN(auto frame, DecodeFrame(record->content));
    uint32_t before = out.frames_.empty() ? 0 : out.frames_.back().place.chunks;
    if (frame.place.chunks <= before) return Unusable("expected them in the order of the chunks");
    out.frames_.push_back(std::move(frame));
  }
  return out;
}

Result<Keyframes::Frame> Keyframes::DecodeFrame(ByteView content) {
  ByteReader in(content);
  Frame f;
  f.place.ticks = in.U64();
  f.place.chunks = in.U32();
  f.place.gap_ticks = in.U64();
  f.place.chain = ReadHash(in);
  f.place.state_hash = in.U64();
  f.bricks = in.U32();
  ByteView samples = in.Blob(kMaxKeyframeBytes);
  f.state_size = in.U32();
  ByteView state = in.Blob(kMaxKeyframeBytes);
  if (!in.ok() || !in.AtEnd()) return Unusable("a keyframe's size does not fit its content");
  if (f.bricks > kMaxBricks) return TooLarge("a keyframe's bricks", kMaxBricks, f.bricks);
  if (f.state_size > kMaxKeyframeBytes) {
    return TooLarge("a keyframe's state", kMaxKeyframeBytes, f.state_size);
  }
  f.samples.assign(samples.begin(), samples.end());
  f.state.assign(state.begin(), state.end());
  return f;
}

void Keyframes::EncodeFrame(const Frame& f, ByteWriter& out) {
  out.U64(f.place.ticks);
  out.U32(f.place.chunks);
  out.U64(f.place.gap_ticks);
  out.Raw(f.place.chain.view());
  out.U64(f.place.state_hash);
  out.U32(f.bricks);
  out.Blob(f.samples);
  out.U32(f.state_size);
  out.Blob(f.state);
}

Bytes Keyframes::Encode() const {
  ByteWriter out;
  WriteMagic(kKeyframesMagic, out);
  out.U16(0);
  out.U64(Build());
  out.Raw(header_hash_.view());
  for (const Frame& frame : frames_) {
    ByteWriter content;
    EncodeFrame(frame, content);
    WriteRecord(kKeyframeRecord, content.bytes(), out);
  }
  return out.Take();
}

void Keyframes::Add(core::Core& core, const KeyframePlace& place,
                    std::span<const int32_t> changed) {
  ENAMEL_CHECK(frames_.empty() || place.chunks > frames_.back().place.chunks);
  // More than a reader takes: the replay continues without keyframes.
  if (frames_.size() == kMaxKeyframes || changed.size() > kMaxBricks) return;
  Frame frame;
  frame.place = place;
  frame.bricks = static_cast<uint32_t>(changed.size());
  ByteWriter samples;
  for (int32_t brick : changed) {
    samples.I32(brick);
    for (int16_t phi : core.volume().Phi(brick).phi) samples.I16(phi);
  }
  frame.samples = Pack(samples.bytes(), kZstdLevel);
  StateArchive archive;
  ENAMEL_CHECK(core.VisitState(archive));
  Bytes state = archive.Take();
  frame.state_size = static_cast<uint32_t>(state.size());
  frame.state = Pack(state, kZstdLevel);
  // 256 for what EncodeFrame puts around the two: a reader would refuse the record.
  if (frame.samples.size() + frame.state.size() + 256 > kMaxKeyframeBytes) return;
  frames_.push_back(std::move(frame));
}

Status Keyframes::Restore(size_t i, core::Core& core) const {
  ENAMEL_CHECK(i < frames_.size() && core.ticks() == 0);
  // Each holds what changed since the one before, so all of them up to this one. Later ones
  // overwrite.
  for (size_t k = 0; k <= i; ++k) {
    // Before there is memory for them: a tooth has no more bricks than it has, whatever is said.
    if (int64_t{frames_[k].bricks} > core.volume().spec().brick_count())
      return Unusable("they have more bricks than the tooth");
    ENAMEL_ASSIGN_OR_RETURN(auto samples,
                            Unpack(frames_[k].samples, frames_[k].bricks * kBrickBytes, kPart));
    ByteReader in(samples);
    for (uint32_t n = 0; n < frames_[k].bricks; ++n) {
      int32_t brick = in.I32();
      std::array<int16_t, cutting::kBrickVoxels> phi;
      for (int16_t& v : phi) v = in.I16();
      if (!core.RestoreBrick(brick, phi)) return Unusable("a brick is not the tooth's");
    }
  }
  ENAMEL_ASSIGN_OR_RETURN(auto state, Unpack(frames_[i].state, frames_[i].state_size, kPart));
  StateArchive archive(state);
  const KeyframePlace& place = frames_[i].place;
  if (!core.VisitState(archive) || core.ticks() != place.ticks ||
      core.state_hash() != place.state_hash) {
    return Unusable("a state is not this core's");
  }
  return Status::Ok();
}

}  // namespace enamel::trace
