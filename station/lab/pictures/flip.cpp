#include "station/lab/pictures/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <numbers>

#include "common/base/check.h"
#include "common/math/vec.h"

namespace enamel::station::lab {
namespace {

// Constants of the paper, section 4; equations by its numbers.
struct Sensitivity {
  double a1, b1, a2, b2;  // table 1
};
constexpr std::array<Sensitivity, 3> kSensitivity = {
    {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}}};
constexpr double kWidestB = 0.04;
constexpr double kColourPower = 0.7, kFeaturePower = 0.5;  // eq. 9, 13
constexpr double kKnee = 0.4, kKneeTo = 0.95;              // eq. 9: p_c, p_t
constexpr double kFeatureWidth_deg = 0.082;                // section 4.2, after Geisler

// Linear sRGB to XYZ, and its white (D65).
const glm::dmat3 kXyzFromRgb =
    glm::transpose(glm::dmat3(10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794,
                              2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897,
                              1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382));
const glm::dmat3 kRgbFromXyz = glm::inverse(kXyzFromRgb);
const dvec3 kWhite = kXyzFromRgb * dvec3(1);

dvec3 Linear(const dvec3& srgb) {
  dvec3 out;
  for (int i = 0; i < 3; ++i) {
    out[i] = srgb[i] > 0.04045 ? std::pow((srgb[i] + 0.055) / 1.055, 2.4) : srgb[i] / 12.92;
  }
  return out;
}

// Opponents (lightness, red to green, blue to yellow) of three values: of XYZ over white, YCxCz;
// of their cube roots, L*a*b*.
dvec3 Opponents(const dvec3& v) { return {116 * v.y - 16, 500 * (v.x - v.y), 200 * (v.y - v.z)}; }
dvec3 FromOpponents(const dvec3& o) {
  const double y = (o.x + 16) / 116;
  return {y + o.y / 500, y, y - o.z / 200};
}
dvec3 YcxczOf(const dvec3& linear) { return Opponents(kXyzFromRgb * linear / kWhite); }
dvec3 LinearOf(const dvec3& ycxcz) { return kRgbFromXyz * (FromOpponents(ycxcz) * kWhite); }

// L*a*b*, whose chroma the eye sees less of in the dark (Hunt).
dvec3 HuntLab(const dvec3& linear) {
  dvec3 v = kXyzFromRgb * linear / kWhite;
  constexpr double kDelta = 6.0 / 29;
  for (int i = 0; i < 3; ++i) {
    v[i] =
        v[i] > kDelta * kDelta * kDelta ? std::cbrt(v[i]) : v[i] / (3 * kDelta * kDelta) + 4.0 / 29;
  }
  const dvec3 lab = Opponents(v);
  return {lab.x, 0.01 * lab.x * lab.y, 0.01 * lab.x * lab.z};
}

double HyAb(const dvec3& a, const dvec3& b) {
  return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z);
}

double ColourError(const dvec3& lab_a, const dvec3& lab_b) {
  static const double kMost = std::pow(HyAb(HuntLab({0, 1, 0}), HuntLab({0, 0, 1})), kColourPower);
  const double error = std::pow(HyAb(lab_a, lab_b), kColourPower), knee = kKnee * kMost;
  return error < knee ? kKneeTo / knee * error
                      : kKneeTo + (error - knee) / (kMost - knee) * (1 - kKneeTo);
}

using Plane = std::vector<double>;

struct Kernel {
  int radius = 0;
  Plane weights;  // (2 radius + 1)^2

  Kernel(int r, const std::function<double(double x, double y)>& weight) : radius(r) {
    for (int y = -r; y <= r; ++y) {
      for (int x = -r; x <= r; ++x) weights.push_back(weight(x, y));
    }
  }
};

// Beyond its edges a picture continues as its edge.
Plane Filtered(const Plane& in, int width, const Kernel& kernel) {
  const int height = static_cast<int>(in.size()) / width, r = kernel.radius;
  Plane out(in.size());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double sum = 0;
      const double* weight = kernel.weights.data();
      for (int dy = -r; dy <= r; ++dy) {
        const int row = std::clamp(y + dy, 0, height - 1) * width;
        for (int dx = -r; dx <= r; ++dx) {
          sum += *weight++ * in[static_cast<size_t>(row + std::clamp(x + dx, 0, width - 1))];
        }
      }
      out[static_cast<size_t>(y * width + x)] = sum;
    }
  }
  return out;
}

// Eq. 6: Gaussians whose transform is the contrast sensitivity.
Kernel EyeKernel(const Sensitivity& s, double pixels_per_degree) {
  constexpr double kPi2 = std::numbers::pi * std::numbers::pi;
  const int radius =
      static_cast<int>(std::ceil(3 * std::sqrt(kWidestB / (2 * kPi2)) * pixels_per_degree));
  Kernel out(radius, [&](double x, double y) {
    const double d2 = (x * x + y * y) / (pixels_per_degree * pixels_per_degree);
    return s.a1 * std::sqrt(std::numbers::pi / s.b1) * std::exp(-kPi2 * d2 / s.b1) +
           s.a2 * std::sqrt(std::numbers::pi / s.b2) * std::exp(-kPi2 * d2 / s.b2);
  });
  double sum = 0;
  for (double w : out.weights) sum += w;
  for (double& w : out.weights) w /= sum;
  return out;
}

// Section 4.2: the first (edges) or second (points) derivative of a Gaussian along x or y; its
// positive weights sum to 1, its negative ones to -1.
Kernel FeatureKernel(bool point, bool along_y, double pixels_per_degree) {
  const double sigma = 0.5 * kFeatureWidth_deg * pixels_per_degree;
  Kernel out(static_cast<int>(std::ceil(3 * sigma)), [&](double x, double y) {
    const double along = along_y ? y : x;
    const double g = std::exp(-(x * x + y * y) / (2 * sigma * sigma));
    return point ? (along * along / (sigma * sigma) - 1) * g : -along * g;
  });
  double positive = 0, negative = 0;
  for (double w : out.weights) (w > 0 ? positive : negative) += w;
  for (double& w : out.weights) w /= w > 0 ? positive : -negative;
  return out;
}

// A picture as the metric sees it.
struct Seen {
  std::vector<dvec3> lab;
  Plane edges, points;

  Seen(const render::Image& image, double pixels_per_degree) {
    const size_t count = image.rgb.size() / 3;
    std::array<Plane, 3> planes;
    for (Plane& plane : planes) plane.resize(count);
    Plane lightness(count);
    for (size_t i = 0; i < count; ++i) {
      const uint8_t* p = &image.rgb[3 * i];
      const dvec3 o = YcxczOf(Linear(dvec3(p[0], p[1], p[2]) / 255.0));
      for (int c = 0; c < 3; ++c) planes[static_cast<size_t>(c)][i] = o[c];
      lightness[i] = (o.x + 16) / 116;
    }
    for (size_t c = 0; c < 3; ++c) {
      planes[c] = Filtered(planes[c], image.width, EyeKernel(kSensitivity[c], pixels_per_degree));
    }
    lab.resize(count);
    for (size_t i = 0; i < count; ++i) {
      const dvec3 linear = LinearOf({planes[0][i], planes[1][i], planes[2][i]});
      lab[i] = HuntLab(glm::clamp(linear, 0.0, 1.0));
    }
    edges = Features(lightness, image.width, false, pixels_per_degree);
    points = Features(lightness, image.width, true, pixels_per_degree);
  }

 private:
  static Plane Features(const Plane& lightness, int width, bool point, double pixels_per_degree) {
    Plane out = Filtered(lightness, width, FeatureKernel(point, false, pixels_per_degree));
    const Plane down = Filtered(lightness, width, FeatureKernel(point, true, pixels_per_degree));
    for (size_t i = 0; i < out.size(); ++i) out[i] = std::hypot(out[i], down[i]);
    return out;
  }
};

}  // namespace

std::vector<float> Flip(const render::Image& kept, const render::Image& now,
                        double pixels_per_degree) {
  ENAMEL_CHECK(kept.width == now.width && kept.height == now.height);
  const Seen a(kept, pixels_per_degree), b(now, pixels_per_degree);
  std::vector<float> out(a.lab.size());
  for (size_t i = 0; i < out.size(); ++i) {
    const double feature =
        std::max(std::abs(a.edges[i] - b.edges[i]), std::abs(a.points[i] - b.points[i]));
    const double raised = std::pow(feature / std::numbers::sqrt2, kFeaturePower);
    out[i] = static_cast<float>(std::pow(ColourError(a.lab[i], b.lab[i]), 1 - raised));
  }
  return out;
}

WorstPlace WorstOf(const std::vector<float>& map, int width, int side) {
  const int height = static_cast<int>(map.size()) / width;
  ENAMEL_CHECK(side <= width && side <= height);
  // Sums of all above and left.
  const int across = width + 1;
  std::vector<double> sum(static_cast<size_t>(across) * static_cast<size_t>(height + 1));
  auto at = [&](int x, int y) -> double& { return sum[static_cast<size_t>(y * across + x)]; };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      at(x + 1, y + 1) = static_cast<double>(map[static_cast<size_t>(y * width + x)]) +
                         at(x, y + 1) + at(x + 1, y) - at(x, y);
    }
  }
  WorstPlace worst;
  for (int y = 0; y + side <= height; ++y) {
    for (int x = 0; x + side <= width; ++x) {
      const double mean =
          (at(x + side, y + side) - at(x, y + side) - at(x + side, y) + at(x, y)) / (side * side);
      if (mean > worst.mean) worst = {mean, x + side / 2, y + side / 2};
    }
  }
  return worst;
}

}  // namespace enamel::station::lab
