#include "common/timeline/start_tooth.h"

#include <algorithm>
#include <initializer_list>
#include <string>

#include "common/scene/grid_blob.h"
#include "common/timeline/deflate.h"

namespace enamel::timeline {
namespace {

constexpr std::string_view kLetters = "ENTS";
constexpr uint16_t kVersion = 1;
constexpr std::string_view kBlob = "start tooth";

Status Malformed(const std::string& what) {
  return Status(Code::kInvalidInput, std::string(kBlob) + ": " + what);
}

bool IsAll(const Samples& samples, int8_t value) {
  return std::ranges::all_of(samples, [&](int8_t q) { return q == value; });
}

// Bricks with each flag.
struct Counts {
  size_t sampled = 0, labelled = 0;
};
Counts CountOf(const std::vector<uint8_t>& bricks) {
  Counts out;
  for (uint8_t brick : bricks) {
    out.sampled += (brick & StartTooth::kSampled) != 0;
    out.labelled += (brick & StartTooth::kLabelled) != 0;
  }
  return out;
}

Result<std::vector<uint8_t>> ReadBricks(ByteView packed, size_t count) {
  ENAMEL_ASSIGN_OR_RETURN(Bytes bricks, Inflate(packed, count, kBlob, "bricks"));
  for (uint8_t brick : bricks) {
    if (brick > (StartTooth::kTissue | StartTooth::kSampled | StartTooth::kLabelled)) {
      return Malformed("a brick has flags that this version does not know: " +
                       std::to_string(brick));
    }
  }
  return bricks;
}

}  // namespace

StartTooth StartToothOf(const cutting::Volume& volume) {
  StartTooth out;
  out.spec = volume.spec();
  out.bricks.resize(static_cast<size_t>(out.spec.brick_count()));
  for (size_t b = 0; b < out.bricks.size(); ++b) {
    const auto brick = static_cast<int>(b);
    auto flags = static_cast<uint8_t>(volume.UniformTissue(brick));
    if (volume.IsStored(brick)) {
      const Samples samples = QuantiseBrick(volume, brick);
      // Air stays air: nothing grows back.
      if (IsAll(samples, kFarOut)) continue;
      if (volume.HasLabels(brick)) {
        flags = StartTooth::kLabelled;
        out.labels.push_back(volume.Labels(brick));
      }
      // Solid without a tissue cannot be said by flags alone.
      if (!IsAll(samples, kDeep) || flags == 0) {
        flags |= StartTooth::kSampled;
        out.samples.push_back(samples);
      }
    }
    out.bricks[b] = flags;
  }
  return out;
}

Bytes EncodeStartTooth(const StartTooth& tooth, const KeepGoing& keep_going) {
  Bytes residuals, labels;
  for (const Samples& samples : tooth.samples) AppendResiduals(samples, residuals);
  for (const auto& brick : tooth.labels) {
    labels.insert(labels.end(), brick.tissue.begin(), brick.tissue.end());
  }
  ByteWriter out;
  scene::WriteBlobStart(kLetters, kVersion, 0, out);
  scene::WriteGrid(tooth.spec, out);
  // Made once for a scene, fetched by everybody who looks at an attempt at it.
  for (const Bytes* section :
       std::initializer_list<const Bytes*>{&tooth.bricks, &residuals, &labels})
    out.Blob(Deflate(*section, Effort::kMost, keep_going));
  return out.Take();
}

Result<StartTooth> DecodeStartTooth(ByteView blob) {
  ByteReader in(blob);
  ENAMEL_RETURN_IF_ERROR(scene::ReadBlobStart(in, kLetters, kVersion, 0, kBlob).status());
  StartTooth out;
  ENAMEL_ASSIGN_OR_RETURN(out.spec, scene::ReadGrid(in, kBlob));
  std::array<ByteView, 3> packed;
  for (ByteView& section : packed) section = in.Blob(blob.size());
  if (!in.ok()) return Malformed("ends early: the file was cut off");
  if (!in.AtEnd()) return Malformed(std::to_string(in.remaining()) + " bytes too many at its end");
  ENAMEL_ASSIGN_OR_RETURN(out.bricks,
                          ReadBricks(packed[0], static_cast<size_t>(out.spec.brick_count())));
  const Counts counts = CountOf(out.bricks);
  ENAMEL_ASSIGN_OR_RETURN(
      const Bytes residuals,
      Inflate(packed[1], counts.sampled * cutting::kBrickVoxels, kBlob, "samples"));
  ENAMEL_ASSIGN_OR_RETURN(
      const Bytes labels,
      Inflate(packed[2], counts.labelled * cutting::kBrickVoxels, kBlob, "labels"));
  for (size_t at = 0; at < residuals.size(); at += cutting::kBrickVoxels) {
    out.samples.push_back(FromResiduals(ByteView(residuals).subspan(at, cutting::kBrickVoxels)));
  }
  for (size_t at = 0; at < labels.size(); at += cutting::kBrickVoxels) {
    auto& brick = out.labels.emplace_back();
    std::copy_n(labels.begin() + static_cast<ptrdiff_t>(at), cutting::kBrickVoxels,
                brick.tissue.begin());
    if (std::ranges::any_of(brick.tissue, [](uint8_t t) { return t >= cutting::kTissueCount; })) {
      return Malformed("a label is no tissue");
    }
  }
  return out;
}

}  // namespace enamel::timeline
