#include "common/timeline/deviation.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <optional>
#include <string>

#include "common/base/check.h"
#include "common/scene/grid_blob.h"
#include "common/timeline/deflate.h"

namespace enamel::timeline {
namespace {

using cutting::kBrickSide;
using cutting::kBrickVoxels;

constexpr std::string_view kLetters = "ENTD";
constexpr uint16_t kVersion = 1;
constexpr std::string_view kBlob = "deviation";
constexpr double kMost_um = 1e6;
constexpr size_t kMaskBytes = kBrickVoxels / 8;
constexpr size_t kBrickBytes = 4 + kMaskBytes;

Status Malformed(const std::string& what) {
  return Status(Code::kInvalidInput, std::string(kBlob) + ": " + what);
}

bool IsInside(const ivec3& cell, const cutting::GridSpec& spec) {
  return glm::all(glm::greaterThanEqual(cell, ivec3(0))) &&
         glm::all(glm::lessThan(cell, spec.voxels()));
}

using BrickValues = std::array<std::optional<int32_t>, kBrickVoxels>;

std::map<int, BrickValues> ByBrick(const Deviation& deviation) {
  std::map<int, BrickValues> out;
  for (const CellDeviation& value : deviation.cells) {
    const ivec3& c = value.cell;
    if (!IsInside(c, deviation.spec)) continue;
    const ivec3 brick = c / kBrickSide, in = c % kBrickSide;
    out[deviation.spec.BrickIndex(brick)]
       [static_cast<size_t>((in.z * kBrickSide + in.y) * kBrickSide + in.x)] = value.deviation_um;
  }
  return out;
}

// The masks' bits, counted before anything is read by them.
size_t ValuesIn(ByteView cells, size_t bricks) {
  size_t out = 0;
  for (size_t b = 0; b < bricks; ++b) {
    for (uint8_t byte : cells.subspan(b * kBrickBytes + 4, kMaskBytes)) {
      out += static_cast<size_t>(std::popcount(byte));
    }
  }
  return out;
}

ivec3 CellOf(const cutting::GridSpec& spec, int brick, int i) {
  const ivec3 at(brick % spec.bricks.x, brick / spec.bricks.x % spec.bricks.y,
                 brick / spec.bricks.x / spec.bricks.y);
  return at * kBrickSide +
         ivec3(i % kBrickSide, i / kBrickSide % kBrickSide, i / kBrickSide / kBrickSide);
}

// Requires: `planes` holds as many values as the masks have bits.
Status ReadCells(ByteView cells, size_t bricks, ByteView planes, Deviation& out) {
  ByteReader in(cells);
  const size_t values = planes.size() / 4;
  int64_t before = -1;
  uint32_t um = 0;
  for (size_t b = 0; b < bricks; ++b) {
    const uint32_t brick = in.U32();
    const ByteView mask = in.Raw(kMaskBytes);
    if (brick <= before || brick >= static_cast<uint32_t>(out.spec.brick_count())) {
      return Malformed("brick " + std::to_string(brick) + " is out of order or outside the grid");
    }
    before = brick;
    for (int i = 0; i < kBrickVoxels; ++i) {
      if (!(mask[static_cast<size_t>(i) / 8] >> (i % 8) & 1)) continue;
      um += scene::Unzigzag(scene::FromPlanes(planes, values, out.cells.size()));
      out.cells.push_back({CellOf(out.spec, static_cast<int>(brick), i), static_cast<int32_t>(um)});
    }
  }
  return {};
}

}  // namespace

DeviationByCell::DeviationByCell(const Deviation& deviation) : spec_(deviation.spec) {
  um_.reserve(deviation.cells.size());
  for (const CellDeviation& value : deviation.cells) {
    if (const auto number = NumberOf(value.cell)) um_.emplace(*number, value.deviation_um);
  }
}

std::optional<uint64_t> DeviationByCell::NumberOf(const ivec3& cell) const {
  if (!IsInside(cell, spec_)) return std::nullopt;
  const glm::u64vec3 at(cell), size(spec_.voxels());
  return (at.z * size.y + at.y) * size.x + at.x;
}

std::optional<int32_t> DeviationByCell::At_um(const ivec3& cell) const {
  const auto number = NumberOf(cell);
  const auto at = number ? um_.find(*number) : um_.end();
  if (at == um_.end()) return std::nullopt;
  return at->second;
}

Deviation DeviationOf(const cutting::GridSpec& spec, std::span<const ivec3> cells,
                      std::span<const float> deviation_m) {
  ENAMEL_CHECK(deviation_m.size() == cells.size());
  Deviation out;
  out.spec = spec;
  for (size_t v = 0; v < cells.size(); ++v) {
    if (!std::isfinite(deviation_m[v])) continue;
    const double um = std::clamp(deviation_m[v] * 1e6, -kMost_um, kMost_um);
    out.cells.push_back({cells[v], static_cast<int32_t>(std::lround(um))});
  }
  return out;
}

Bytes EncodeDeviation(const Deviation& deviation) {
  const std::map<int, BrickValues> bricks = ByBrick(deviation);
  ByteWriter cells;
  std::vector<uint32_t> values;
  uint32_t before = 0;
  for (const auto& [brick, in] : bricks) {
    cells.U32(static_cast<uint32_t>(brick));
    std::array<uint8_t, kMaskBytes> mask{};
    for (size_t i = 0; i < in.size(); ++i) {
      if (!in[i]) continue;
      mask[i / 8] = static_cast<uint8_t>(mask[i / 8] | 1 << (i % 8));
      const auto um = static_cast<uint32_t>(*in[i]);
      values.push_back(scene::Zigzag(um - before));
      before = um;
    }
    cells.Raw(mask);
  }
  Bytes planes;
  scene::AppendPlanes(values, planes);
  ByteWriter out;
  scene::WriteBlobStart(kLetters, kVersion, 0, out);
  scene::WriteGrid(deviation.spec, out);
  out.U32(static_cast<uint32_t>(bricks.size()));
  out.U32(static_cast<uint32_t>(values.size()));
  out.Blob(Deflate(cells.bytes()));
  out.Blob(Deflate(planes));
  return out.Take();
}

Result<Deviation> DecodeDeviation(ByteView blob) {
  ByteReader in(blob);
  ENAMEL_RETURN_IF_ERROR(scene::ReadBlobStart(in, kLetters, kVersion, 0, kBlob).status());
  Deviation out;
  ENAMEL_ASSIGN_OR_RETURN(out.spec, scene::ReadGrid(in, kBlob));
  const uint32_t bricks = in.U32(), values = in.U32();
  const ByteView packed_cells = in.Blob(blob.size()), packed_values = in.Blob(blob.size());
  if (!in.ok()) return Malformed("ends early: the file was cut off");
  if (!in.AtEnd()) return Malformed(std::to_string(in.remaining()) + " bytes too many at its end");
  if (bricks > static_cast<uint32_t>(out.spec.brick_count()) ||
      values > size_t{bricks} * kBrickVoxels) {
    return Malformed("more bricks or values than the grid has");
  }
  ENAMEL_ASSIGN_OR_RETURN(const Bytes cells,
                          Inflate(packed_cells, bricks * kBrickBytes, kBlob, "cells"));
  if (ValuesIn(cells, bricks) != values) {
    return Malformed("expected as many cells as its head has, found " +
                     std::to_string(ValuesIn(cells, bricks)) + " and not " +
                     std::to_string(values));
  }
  ENAMEL_ASSIGN_OR_RETURN(const Bytes planes,
                          Inflate(packed_values, size_t{values} * 4, kBlob, "deviation"));
  out.cells.reserve(values);
  ENAMEL_RETURN_IF_ERROR(ReadCells(cells, bricks, planes, out));
  return out;
}

}  // namespace enamel::timeline
