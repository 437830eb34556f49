#include "common/timeline/changing.h"

#include <algorithm>
#include <string>

#include "common/scene/grid_blob.h"
#include "common/timeline/deflate.h"

namespace enamel::timeline {
namespace {

using cutting::kBrickSide;
using cutting::kBrickVoxels;

constexpr std::string_view kBlob = "changing part";
// Samples that a vertex on a brick's border reads beyond the brick: two for its normal.
constexpr int kReach = 2;
constexpr uint8_t kKnown =
    Changing::kTissue | Changing::kSampled | Changing::kLabelled | Changing::kTriangles;

Status Malformed(const std::string& what) {
  return Status(Code::kInvalidInput, std::string(kBlob) + ": " + what);
}

// Calls each(neighbour, step towards it) for those in the grid, itself among them.
template <typename Each>
void AroundBrick(int brick, const ivec3& n, Each&& each) {
  const ivec3 at(brick % n.x, brick / n.x % n.y, brick / n.x / n.y);
  for (int z = std::max(0, at.z - 1); z <= std::min(n.z - 1, at.z + 1); ++z)
    for (int y = std::max(0, at.y - 1); y <= std::min(n.y - 1, at.y + 1); ++y)
      for (int x = std::max(0, at.x - 1); x <= std::min(n.x - 1, at.x + 1); ++x)
        each((z * n.y + y) * n.x + x, ivec3(x, y, z) - at);
}

// Which samples of a brick lie within kReach of a brick that is set.
std::array<bool, kBrickVoxels> NextTo(const std::vector<uint8_t>& set, int brick, const ivec3& n) {
  std::array<bool, kBrickVoxels> out{};
  AroundBrick(brick, n, [&](int other, const ivec3& step) {
    if (!set[static_cast<size_t>(other)]) return;
    const auto range = [](int s) {
      return s < 0   ? std::pair(0, kReach)
             : s > 0 ? std::pair(kBrickSide - kReach, kBrickSide)
                     : std::pair(0, kBrickSide);
    };
    const auto [x0, x1] = range(step.x);
    const auto [y0, y1] = range(step.y);
    const auto [z0, z1] = range(step.z);
    for (int z = z0; z < z1; ++z)
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x)
          out[static_cast<size_t>((z * kBrickSide + y) * kBrickSide + x)] = true;
  });
  return out;
}

}  // namespace

std::vector<uint8_t> WithNeighbours(const std::vector<uint8_t>& set, const ivec3& bricks) {
  std::vector<uint8_t> out(set.size());
  for (size_t b = 0; b < set.size(); ++b) {
    if (!set[b]) continue;
    AroundBrick(static_cast<int>(b), bricks,
                [&](int other, const ivec3&) { out[static_cast<size_t>(other)] = 1; });
  }
  return out;
}

Changing ChangingOf(const cutting::Volume& initial, const std::vector<uint8_t>& triangles) {
  const ivec3 n = initial.spec().bricks;
  const std::vector<uint8_t> all = WithNeighbours(triangles, n);
  Changing out;
  for (size_t b = 0; b < all.size(); ++b) {
    if (!all[b]) continue;
    const auto brick = static_cast<int>(b);
    const std::array<bool, kBrickVoxels> needed = NextTo(triangles, brick, n);
    auto flags = static_cast<uint8_t>(triangles[b] ? Changing::kTriangles : 0);
    const bool labelled = initial.HasLabels(brick);
    if (labelled) {
      cutting::BrickLabels labels = initial.Labels(brick);
      // A label that nobody needs packs best as a copy of the one before it.
      for (size_t i = 1; i < needed.size(); ++i) {
        if (!needed[i]) labels.tissue[i] = labels.tissue[i - 1];
      }
      out.labels.push_back(labels);
      flags |= Changing::kLabelled;
    } else {
      flags |= static_cast<uint8_t>(initial.UniformTissue(brick));
    }
    Samples samples = QuantiseBrick(initial, brick);
    for (size_t i = 0; i < needed.size(); ++i) {
      if (!needed[i]) samples[i] = static_cast<int8_t>(Predicted(samples, i));
    }
    const int8_t implied = flags & (Changing::kTissue | Changing::kLabelled) ? kDeep : kFarOut;
    if (std::ranges::any_of(samples, [&](int8_t q) { return q != implied; })) {
      out.samples.push_back(samples);
      flags |= Changing::kSampled;
    }
    out.bricks.push_back(brick);
    out.flags.push_back(flags);
  }
  return out;
}

Bytes EncodeChanging(const Changing& changing) {
  std::vector<uint32_t> gaps;
  int32_t before = -1;
  for (int32_t brick : changing.bricks) {
    gaps.push_back(static_cast<uint32_t>(brick - before - 1));
    before = brick;
  }
  Bytes bricks, residuals, labels;
  scene::AppendPlanes(gaps, bricks);
  bricks.insert(bricks.end(), changing.flags.begin(), changing.flags.end());
  for (const Samples& samples : changing.samples) AppendResiduals(samples, residuals);
  for (const auto& brick : changing.labels) {
    labels.insert(labels.end(), brick.tissue.begin(), brick.tissue.end());
  }
  ByteWriter out;
  out.U32(static_cast<uint32_t>(changing.bricks.size()));
  for (const Bytes& section : {bricks, residuals, labels}) {
    out.Blob(Deflate(section, Effort::kMost));
  }
  return out.Take();
}

Result<Changing> DecodeChanging(ByteView blob, const cutting::GridSpec& spec) {
  ByteReader in(blob);
  const size_t count = in.U32();
  std::array<ByteView, 3> packed;
  for (ByteView& section : packed) section = in.Blob(blob.size());
  if (!in.ok()) return Malformed("ends early: the file was cut off");
  if (!in.AtEnd()) return Malformed(std::to_string(in.remaining()) + " bytes too many at its end");
  if (count > static_cast<size_t>(spec.brick_count())) {
    return Malformed("has more bricks than the grid");
  }
  ENAMEL_ASSIGN_OR_RETURN(const Bytes bricks, Inflate(packed[0], 5 * count, kBlob, "bricks"));
  Changing out;
  int64_t brick = -1;
  size_t sampled = 0, labelled = 0;
  for (size_t i = 0; i < count; ++i) {
    brick += 1 + int64_t{scene::FromPlanes(bricks, count, i)};
    if (brick >= spec.brick_count()) return Malformed("a brick is outside the grid");
    const uint8_t flags = bricks[4 * count + i];
    if (flags & ~kKnown) return Malformed("a brick has flags that this version does not know");
    sampled += (flags & Changing::kSampled) != 0;
    labelled += (flags & Changing::kLabelled) != 0;
    out.bricks.push_back(static_cast<int32_t>(brick));
    out.flags.push_back(flags);
  }
  ENAMEL_ASSIGN_OR_RETURN(const Bytes residuals,
                          Inflate(packed[1], sampled * kBrickVoxels, kBlob, "samples"));
  ENAMEL_ASSIGN_OR_RETURN(const Bytes labels,
                          Inflate(packed[2], labelled * kBrickVoxels, kBlob, "labels"));
  for (size_t at = 0; at < residuals.size(); at += kBrickVoxels) {
    out.samples.push_back(FromResiduals(ByteView(residuals).subspan(at, kBrickVoxels)));
  }
  if (std::ranges::any_of(labels, [](uint8_t t) { return t >= cutting::kTissueCount; })) {
    return Malformed("a label is no tissue");
  }
  for (size_t at = 0; at < labels.size(); at += kBrickVoxels) {
    std::copy_n(labels.begin() + static_cast<ptrdiff_t>(at), kBrickVoxels,
                out.labels.emplace_back().tissue.begin());
  }
  return out;
}

}  // namespace enamel::timeline
