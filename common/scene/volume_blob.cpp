#include "common/scene/volume_blob.h"

#include <algorithm>
#include <memory>
#include <string>

#include "common/scene/grid_blob.h"

namespace enamel::scene {
namespace {

using cutting::GridSpec;
using cutting::kBrickVoxels;
using cutting::kTissueCount;
using cutting::Tissue;
using cutting::Volume;

constexpr std::string_view kLetters = "ENTV";
constexpr uint16_t kVersion = 1;
constexpr std::string_view kBlob = "volume blob";
// Kind byte of a brick (schemas/volume_blob.md).
constexpr uint8_t kTissueMask = 0x0f;
constexpr uint8_t kStored = 0x40;
constexpr uint8_t kLabelled = 0x80;
// In a change: a brick as it was; one with its old tissues and other distances.
constexpr uint8_t kSame = 0x80, kCut = 0xa0;
constexpr uint16_t kChange = 1;  // flag

Status Malformed(const std::string& what) {
  return Status(Code::kInvalidInput, std::string(kBlob) + ": " + what);
}

// Difference to the sample before it along x; the first of a row to the row before; then low bytes
// of a brick together and high bytes together, which is what makes them compress.
void PackPhi(const cutting::BrickPhi& brick, uint8_t* out) {
  int previous = 0;
  for (int i = 0; i < kBrickVoxels; ++i) {
    if (i % 8 == 0 && i > 0) previous = brick.phi[static_cast<size_t>(i - 8)];
    auto delta = static_cast<uint16_t>(brick.phi[static_cast<size_t>(i)] - previous);
    previous = brick.phi[static_cast<size_t>(i)];
    out[i] = static_cast<uint8_t>(delta);
    out[i + kBrickVoxels] = static_cast<uint8_t>(delta >> 8);
  }
}

bool UnpackPhi(const uint8_t* in, std::array<int16_t, kBrickVoxels>& phi) {
  // Modulo 2^16: any bytes are decoded without overflow, and judged by the outcome.
  uint16_t previous = 0;
  for (int i = 0; i < kBrickVoxels; ++i) {
    if (i % 8 == 0 && i > 0) previous = static_cast<uint16_t>(phi[static_cast<size_t>(i - 8)]);
    auto delta = static_cast<uint16_t>(in[i] | in[i + kBrickVoxels] << 8);
    previous = static_cast<uint16_t>(previous + delta);
    phi[static_cast<size_t>(i)] = static_cast<int16_t>(previous);
    if (phi[static_cast<size_t>(i)] == INT16_MIN) return false;
  }
  return true;
}

uint8_t KindOf(const Volume& v, int brick) {
  if (!v.IsStored(brick)) return static_cast<uint8_t>(v.UniformTissue(brick));
  if (v.HasLabels(brick)) return kStored | kLabelled;
  return kStored | static_cast<uint8_t>(v.UniformTissue(brick));
}

bool KindIsValid(uint8_t kind, bool change) {
  if (change && (kind == kSame || kind == kCut)) return true;
  uint8_t tissue = kind & kTissueMask;
  if (kind & kLabelled) return kind == (kStored | kLabelled);
  if ((kind & ~(kTissueMask | kStored)) != 0 || tissue >= kTissueCount) return false;
  // A stored brick of air would be cut and booked to no tissue.
  return !(kind & kStored) || tissue != 0;
}

struct Header {
  GridSpec spec;
  uint32_t stored = 0, labelled = 0;
  bool change = false;
  Sha256 from{};  // of a change
};

Result<Header> ReadHeader(ByteReader& in) {
  Header h;
  ENAMEL_ASSIGN_OR_RETURN(const uint16_t flags,
                          ReadBlobStart(in, kLetters, kVersion, kChange, kBlob));
  h.change = flags == kChange;
  ENAMEL_ASSIGN_OR_RETURN(h.spec, ReadGrid(in, kBlob));
  h.stored = in.U32();
  h.labelled = in.U32();
  if (h.change) {
    const ByteView from = in.Raw(h.from.bytes.size());
    std::ranges::copy(from, h.from.bytes.begin());
  }
  if (!in.ok()) return Malformed("ends within its header");
  if (h.stored > static_cast<uint64_t>(h.spec.brick_count()) || h.labelled > h.stored) {
    return Malformed("more stored bricks than its grid has");
  }
  return h;
}

bool HasDistances(uint8_t kind) { return (kind & kStored) != 0 || kind == kCut; }
bool HasLabels(uint8_t kind) { return kind == (kStored | kLabelled); }

Status CheckKinds(const Bytes& kinds, const Header& h) {
  uint64_t stored = 0, labelled = 0;
  for (uint8_t kind : kinds) {
    if (!KindIsValid(kind, h.change))
      return Malformed("unknown kind of brick " + std::to_string(kind));
    stored += HasDistances(kind);
    labelled += HasLabels(kind);
  }
  if (stored != h.stored || labelled != h.labelled) {
    return Malformed("its header counts " + std::to_string(h.stored) +
                     " stored bricks, its table " + std::to_string(stored));
  }
  return Status::Ok();
}

// A brick that was not stored is deep or air all over.
std::span<const uint8_t> LabelsOf(const Volume& volume, int brick) {
  if (!volume.IsStored(brick) || !volume.HasLabels(brick)) return {};
  return volume.Labels(brick).tissue;
}

// `before`: what kSame and kCut are of; not read where there are none.
Status Fill(const Bytes& kinds, const Bytes& phi, const Bytes& labels, const Volume& before,
            Volume& volume) {
  // CheckKinds has counted what the table asks for: neither pointer runs past its end.
  const uint8_t* next_phi = phi.data();
  const uint8_t* next_labels = labels.data();
  std::array<int16_t, kBrickVoxels> samples;
  for (size_t b = 0; b < kinds.size(); ++b) {
    auto brick = static_cast<int>(b);
    auto tissue = static_cast<Tissue>(kinds[b] & kTissueMask);
    if (kinds[b] == kSame) {
      if (before.IsStored(brick)) {
        volume.SetBrick(brick, before.Phi(brick).phi, LabelsOf(before, brick),
                        before.UniformTissue(brick));
      } else {
        volume.SetUniform(brick, before.UniformTissue(brick));
      }
      continue;
    }
    if (!HasDistances(kinds[b])) {
      volume.SetUniform(brick, tissue);
      continue;
    }
    if (!UnpackPhi(next_phi, samples)) return Malformed("a distance is out of range");
    next_phi += 2 * kBrickVoxels;
    std::span<const uint8_t> own;
    if (kinds[b] == kCut) {
      own = LabelsOf(before, brick);
      tissue = before.UniformTissue(brick);
      if (own.empty() && tissue == Tissue::kAir) return Malformed("it cuts a brick of air");
    } else if (HasLabels(kinds[b])) {
      own = {next_labels, kBrickVoxels};
      next_labels += kBrickVoxels;
      for (uint8_t t : own) {
        if (t == 0 || t >= kTissueCount) return Malformed("unknown tissue " + std::to_string(t));
      }
      tissue = static_cast<Tissue>(own[0]);
    }
    volume.SetBrick(brick, samples, own, tissue);
  }
  return Status::Ok();
}

// A brick of a change.
uint8_t ChangedKind(const Volume& v, const Volume& before, int brick) {
  const std::span<const uint8_t> now = LabelsOf(v, brick), then = LabelsOf(before, brick);
  const bool tissues = std::ranges::equal(now, then) &&
                       (!now.empty() || v.UniformTissue(brick) == before.UniformTissue(brick));
  if (!tissues) return KindOf(v, brick);
  if (v.IsStored(brick) && before.IsStored(brick)) {
    return v.Phi(brick).phi == before.Phi(brick).phi ? kSame : kCut;
  }
  if (v.IsStored(brick)) return kCut;
  return before.IsStored(brick) ? KindOf(v, brick) : kSame;
}

// `before`: null for a whole volume.
Bytes Encode(const Volume& volume, const Volume* before, const Sha256& from) {
  Bytes kinds, phi, labels;
  const auto bricks = static_cast<int>(volume.spec().brick_count());
  for (int b = 0; b < bricks; ++b) {
    kinds.push_back(before == nullptr ? KindOf(volume, b) : ChangedKind(volume, *before, b));
    if (HasDistances(kinds.back())) {
      phi.resize(phi.size() + 2 * kBrickVoxels);
      PackPhi(volume.Phi(b), phi.data() + phi.size() - 2 * kBrickVoxels);
    }
    if (!HasLabels(kinds.back())) continue;
    const auto& own = volume.Labels(b).tissue;
    labels.insert(labels.end(), own.begin(), own.end());
  }
  ByteWriter out;
  WriteBlobStart(kLetters, kVersion, before == nullptr ? 0 : kChange, out);
  WriteGrid(volume.spec(), out);
  out.U32(static_cast<uint32_t>(phi.size() / (2 * kBrickVoxels)));
  out.U32(static_cast<uint32_t>(labels.size() / kBrickVoxels));
  if (before != nullptr) out.Raw(from.bytes);
  for (const Bytes* section : {&kinds, &phi, &labels}) out.Blob(PackSection(*section));
  return out.Take();
}

// `before`: null for a whole volume.
Result<Volume> Decode(ByteView blob, const Volume* before) {
  ByteReader in(blob);
  ENAMEL_ASSIGN_OR_RETURN(Header header, ReadHeader(in));
  if (header.change != (before != nullptr)) {
    return Status(Code::kConflict,
                  std::string(kBlob) +
                      (before != nullptr
                           ? ": expected a change, found a whole volume"
                           : ": expected a whole volume, found a change of " + header.from.Hex()));
  }
  if (before != nullptr && header.spec != before->spec()) {
    return Status(Code::kConflict,
                  std::string(kBlob) + ": the change has another grid than what it is from");
  }
  std::array<ByteView, 3> packed;
  for (ByteView& section : packed) section = in.Blob(blob.size());
  if (!in.ok()) return Malformed("ends early: the file was cut off");
  if (!in.AtEnd()) return Malformed(std::to_string(in.remaining()) + " bytes too many at its end");
  ENAMEL_ASSIGN_OR_RETURN(
      Bytes kinds,
      UnpackSection(packed[0], static_cast<size_t>(header.spec.brick_count()), kBlob, "kinds"));
  ENAMEL_RETURN_IF_ERROR(CheckKinds(kinds, header));
  ENAMEL_ASSIGN_OR_RETURN(
      Bytes phi,
      UnpackSection(packed[1], size_t{header.stored} * 2 * kBrickVoxels, kBlob, "distances"));
  ENAMEL_ASSIGN_OR_RETURN(
      Bytes labels,
      UnpackSection(packed[2], size_t{header.labelled} * kBrickVoxels, kBlob, "labels"));
  Volume volume(header.spec);
  ENAMEL_RETURN_IF_ERROR(Fill(kinds, phi, labels, before != nullptr ? *before : volume, volume));
  return volume;
}

}  // namespace

Bytes EncodeVolume(const Volume& volume) { return Encode(volume, nullptr, {}); }

Result<Volume> DecodeVolume(ByteView blob) { return Decode(blob, nullptr); }

Bytes EncodeChange(const Volume& volume, const Volume& before, const Sha256& from) {
  ENAMEL_CHECK(volume.spec() == before.spec());
  return Encode(volume, &before, from);
}

Result<Sha256> ChangedFrom(ByteView blob) {
  ByteReader in(blob);
  ENAMEL_ASSIGN_OR_RETURN(const Header header, ReadHeader(in));
  return header.from;
}

Result<Volume> DecodeChange(ByteView blob, const Volume& before) { return Decode(blob, &before); }

}  // namespace enamel::scene
