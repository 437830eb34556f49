#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "common/base/check.h"
#include "common/base/file.h"
#include "common/cutting/cutter.h"
#include "common/timeline/recorder.h"
#include "common/timeline/start_tooth.h"

namespace enamel::timeline::test {

inline Bytes Golden(const char* name) {
  auto bytes = ReadFile(std::filesystem::path(ENAMEL_SOURCE_DIR) / "schemas/golden" / name);
  ENAMEL_CHECK(bytes.ok());
  return *bytes;
}

// A ball that goes through a block, with what is seen at each tick.
class BallCut {
 public:
  explicit BallCut(RecorderOptions options = {})
      : initial_(MakeBall()),
        volume_(initial_),
        cutter_((volume_.Reserve(), volume_), {cutting::BurShape::kSphere, 0.5e-3}) {
    start_ = EncodeStartTooth(StartToothOf(initial_));
    if (options.burs.empty()) options.burs = {{cutting::BurShape::kSphere, 0.5e-3}};
    options_ = options;
  }

  // Calls seen(ticks so far, volume) after each tick.
  template <typename Seen>
  Bytes Record(int ticks, Seen&& seen) {
    options_.ticks = static_cast<uint64_t>(ticks);
    Recorder recorder(initial_, HashSha256(start_), options_);
    for (int t = 0; t < ticks; ++t) {
      cutting::RemovedUnits removed{};
      Recorder::Tick tick;
      tick.bur.tip_m = {-1.6e-3 + 0.04e-3 * t, 0.2e-3 * std::sin(0.2 * t), 0.6e-3};
      tick.turning = t % 20 < 15;
      tick.which = t < 10 ? 0 : options_.burs.size() - 1;
      tick.gap_ticks = t % 10 == 3 ? 2 : 0;
      if (tick.turning) cutter_.Cut(tick.bur, removed);
      recorder.Add(volume_, tick.turning ? cutter_.touched() : std::span<const int32_t>(), tick);
      seen(t + 1, volume_);
    }
    return recorder.Finish(volume_);
  }
  const Bytes& start() const { return start_; }
  const cutting::Volume& initial() const { return initial_; }

 private:
  static cutting::Volume MakeBall() {
    cutting::GridSpec spec{50'000, ivec3(8), {-1'600'000, -1'600'000, -1'600'000}};
    cutting::Volume out(spec);
    for (int b = 0; b < spec.brick_count(); ++b) {
      const ivec3 corner = ivec3(b % 8, b / 8 % 8, b / 64) * 8;
      std::array<int16_t, cutting::kBrickVoxels> phi;
      for (int i = 0; i < cutting::kBrickVoxels; ++i) {
        const dvec3 d = dvec3(corner + ivec3(i % 8, i / 8 % 8, i / 64)) - 32.0;
        const double units = (std::sqrt(Dot(d, d)) - 24) * cutting::kPhiPerVoxel;
        phi[static_cast<size_t>(i)] = static_cast<int16_t>(std::clamp(units, -32767.0, 32767.0));
      }
      const auto [least, most] = std::ranges::minmax(phi);
      if (least == cutting::kPhiLimit) continue;
      if (most == -cutting::kPhiLimit) {
        out.SetUniform(b, cutting::Tissue::kDentin);
      } else {
        out.SetBrick(b, phi, {}, cutting::Tissue::kEnamel);
      }
    }
    return out;
  }

  cutting::Volume initial_, volume_;
  cutting::Cutter cutter_;
  Bytes start_;
  RecorderOptions options_;
};

}  // namespace enamel::timeline::test
