#include "common/timeline/samples.h"

#include <algorithm>

namespace enamel::timeline {

Samples QuantiseBrick(const cutting::Volume& volume, int brick) {
  Samples out;
  if (!volume.IsStored(brick)) {
    out.fill(volume.UniformTissue(brick) == cutting::Tissue::kAir ? kFarOut : kDeep);
    return out;
  }
  const auto& phi = volume.Phi(brick).phi;
  for (size_t i = 0; i < out.size(); ++i) out[i] = Quantise(phi[i]);
  return out;
}

// The Lorenzo predictor (Ibarria et al. 2003): exact where the field is a sum of functions of two
// of the three coordinates, as a plane's distance is.
int Predicted(const Samples& s, size_t i) {
  const bool x = (i & 7) != 0, y = (i >> 3 & 7) != 0, z = (i >> 6) != 0;
  int p = 0;
  if (x) p += s[i - 1];
  if (y) p += s[i - 8];
  if (z) p += s[i - 64];
  if (x && y) p -= s[i - 9];
  if (x && z) p -= s[i - 65];
  if (y && z) p -= s[i - 72];
  if (x && y && z) p += s[i - 73];
  return std::clamp<int>(p, kDeep, kFarOut);
}

Samples Coarsened(const Samples& samples, int coarse) {
  Samples out;
  for (size_t i = 0; i < out.size(); ++i) out[i] = FromLevel(samples[i] >> coarse, coarse);
  return out;
}

void AppendResiduals(const Samples& samples, Bytes& out, int coarse) {
  for (size_t i = 0; i < samples.size(); ++i) {
    out.push_back(Residual(samples[i], Predicted(samples, i), coarse));
  }
}

Samples FromResiduals(ByteView residuals, int coarse) {
  Samples out;
  for (size_t i = 0; i < out.size(); ++i) {
    out[i] = FromResidual(residuals[i], Predicted(out, i), coarse);
  }
  return out;
}

}  // namespace enamel::timeline
