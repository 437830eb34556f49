#include <algorithm>
#include <cmath>

#include "common/import/band_sampler.h"
#include "common/import/layers.h"

namespace enamel::import {

LayerProbe::LayerProbe(const LayeredTooth& tooth) : tooth_(&tooth) {
  for (size_t i = 0; i < kLayers; ++i) {
    if (const auto* s = tooth.surface(i)) probes_[i].emplace(s->boundary, s->whole);
  }
}

LayeredTooth::Distances LayerProbe::At(const dvec3& p, double reach) {
  LayeredTooth::Distances d{{reach, reach, reach}, reach};
  for (size_t i = 0; i < kLayers; ++i) {
    if (probes_[i]) d.to[i] = probes_[i]->Distance(p, reach);
  }
  return d;
}

double LayerProbe::Distance(const dvec3& p, double limit) {
  const double outside = tooth_->boundary().Distance(p, limit, &nearest_);
  return tooth_->Inside(p, At(p, tooth_->bridge())) ? -outside : outside;
}
namespace {

class LayerField : public scene::BrickField {
 public:
  explicit LayerField(const LayeredTooth& tooth)
      : tooth_(tooth), probe_(tooth), outer_(tooth.boundary()) {
    for (size_t i = 0; i < kLayers; ++i) {
      if (const auto* s = tooth.surface(i)) bands_[i].emplace(s->boundary);
    }
  }

  scene::FieldSample At(const dvec3& point_m, double reach_m) override {
    const dvec3 p = point_m * 1e3;
    const double reach = std::max(reach_m * 1e3, tooth_.bridge());
    const LayeredTooth::Distances d = probe_.At(p, reach);
    // Within the bridge of any surface a cleft may change the tissue, so that much is taken off.
    double margin = reach;
    for (double s : d.to) margin = std::min(margin, std::abs(s));
    const double outside = tooth_.boundary().Distance(p, reach, &nearest_);
    return Sample(p, d, outside, margin - tooth_.bridge());
  }

  void Brick(const dvec3& corner_m, double voxel_m, double reach_m, Samples& out) override {
    const dvec3 corner = corner_m * 1e3;
    // TissueAt needs the bridge, SidesOf neighbours whose distances together exceed a voxel. More
    // would only cost time: the far distances come from outer_.
    const double h = voxel_m * 1e3, reach = std::max(tooth_.bridge(), 1.5 * h) * 1.01;
    for (size_t layer = 0; layer < kLayers; ++layer) {
      if (!bands_[layer]) continue;
      bands_[layer]->Distances(corner, h, reach, to_[layer]);
      SidesOf(
          corner, h, to_[layer],
          [&](const dvec3& p) { return tooth_.surface(layer)->whole.Inside(p); }, inside_[layer]);
    }
    outer_.Distances(corner, h, reach_m * 1e3, outside_);
    for (size_t i = 0; i < cutting::kBrickVoxels; ++i) {
      LayeredTooth::Distances d{{reach, reach, reach}, reach};
      for (size_t layer = 0; layer < kLayers; ++layer) {
        if (!bands_[layer]) continue;
        const double s = static_cast<double>(to_[layer][i]);
        d.to[layer] = inside_[layer][i] ? -s : s;
      }
      out[i] = Sample(corner + h * dvec3(i % 8, i / 8 % 8, i / 64), d,
                      static_cast<double>(outside_[i]), 0);
    }
  }

 private:
  scene::FieldSample Sample(const dvec3& p, const LayeredTooth::Distances& d, double outside,
                            double margin) const {
    const double distance = tooth_.Inside(p, d) ? -outside : outside;
    return {distance * 1e-3, tooth_.TissueAt(p, d), std::max(margin, 0.0) * 1e-3};
  }

  const LayeredTooth& tooth_;
  LayerProbe probe_;
  uint32_t nearest_ = 0;
  BandSampler outer_;
  std::array<std::optional<BandSampler>, kLayers> bands_;
  std::array<BandSampler::Samples, kLayers> to_;
  std::array<std::array<bool, cutting::kBrickVoxels>, kLayers> inside_;
  BandSampler::Samples outside_;
};

}  // namespace

std::unique_ptr<scene::BrickField> MakeLayerField(const LayeredTooth& tooth) {
  return std::make_unique<LayerField>(tooth);
}

}  // namespace enamel::import
