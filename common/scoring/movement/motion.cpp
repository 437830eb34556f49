#include "common/scoring/movement/motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "common/base/check.h"
#include "common/scoring/align.h"

namespace enamel::scoring {
namespace {

constexpr uint16_t kVersion = 1;
constexpr size_t kBytes = 2 + 6 * Motion::kParts;
constexpr size_t kBand = Motion::kParts / 20;

int16_t InUnits(double v_m) {
  constexpr double kMost = std::numeric_limits<int16_t>::max();
  return static_cast<int16_t>(std::lround(std::clamp(v_m / Motion::kUnit_m, -kMost, kMost)));
}

dvec3 PlaceOf(const std::array<int16_t, 3>& at) {
  return dvec3(at[0], at[1], at[2]) * Motion::kUnit_m;
}

std::vector<dvec3> PlacesOf(const Motion& motion) {
  std::vector<dvec3> out;
  for (const auto& at : motion.at) out.push_back(PlaceOf(at));
  return out;
}

double Length(const dvec3& v) { return std::sqrt(Dot(v, v)); }

double Distance_m(const std::vector<dvec3>& a, const std::vector<dvec3>& b) {
  return AlignBanded(a.size(), b.size(), kBand,
                     [&](size_t i, size_t j) { return Length(a[i] - b[j]); })
      .mean_cost;
}

double SizeOf_m(const std::vector<dvec3>& places) {
  dvec3 middle(0);
  for (const dvec3& p : places) middle += p;
  middle /= static_cast<double>(places.size());
  double squares = 0;
  for (const dvec3& p : places) squares += Dot(p - middle, p - middle);
  return std::sqrt(squares / static_cast<double>(places.size()));
}

}  // namespace

std::optional<Motion> MotionOf(const std::vector<PathSample>& samples) {
  auto pressed = [](const PathSample& s) { return Dot(s.force_n, s.force_n) > 0; };
  const bool any = std::any_of(samples.begin(), samples.end(), pressed);
  std::vector<dvec3> way;
  double way_m = 0, time_s = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    if (any && !pressed(samples[i])) continue;
    way.push_back(samples[i].anchor_m);
    if (i == 0) continue;
    way_m += samples[i].way_m - samples[i - 1].way_m;
    // A gap is no time in which the bur was where it is seen.
    time_s += std::min(samples[i].time_s - samples[i - 1].time_s, 0.1);
  }
  if (time_s < kMinPressed_s || way_m < kMinWay_m) return std::nullopt;
  return MotionAlong(way);
}

Motion MotionAlong(std::span<const dvec3> way) {
  ENAMEL_CHECK(!way.empty());
  Motion out;
  for (size_t k = 0; k < Motion::kParts; ++k) {
    const size_t from = k * way.size() / Motion::kParts;
    const size_t to = std::max(from + 1, (k + 1) * way.size() / Motion::kParts);
    dvec3 sum(0);
    for (size_t i = from; i < to; ++i) sum += way[i];
    sum /= static_cast<double>(to - from);
    out.at[k] = {InUnits(sum.x), InUnits(sum.y), InUnits(sum.z)};
  }
  return out;
}

double MotionDistance_m(const Motion& a, const Motion& b) {
  return Distance_m(PlacesOf(a), PlacesOf(b));
}

std::optional<Nearness> NearnessTo(const Motion& motion, std::span<const Motion> others) {
  if (others.empty()) return std::nullopt;
  const std::vector<dvec3> places = PlacesOf(motion);
  std::vector<double> far_m;
  for (const Motion& other : others) far_m.push_back(Distance_m(places, PlacesOf(other)));
  Nearness out;
  out.others = others.size();
  const auto nearest = std::min_element(far_m.begin(), far_m.end());
  out.nearest = static_cast<size_t>(nearest - far_m.begin());
  out.nearest_m = *nearest;
  std::sort(far_m.begin(), far_m.end());
  out.median_m = far_m[(far_m.size() - 1) / 2];
  out.size_m = SizeOf_m(places);
  return out;
}

bool IsWorthALook(const Nearness& nearness) {
  return nearness.nearest_m < kNearOfSize * nearness.size_m ||
         (nearness.others >= kEnoughOthers &&
          nearness.nearest_m < kNearOfOthers * nearness.median_m);
}

Bytes EncodeMotion(const Motion& motion) {
  ByteWriter out;
  out.U16(kVersion);
  for (const auto& at : motion.at) {
    for (int16_t v : at) out.I16(v);
  }
  return out.Take();
}

Result<Motion> DecodeMotion(ByteView bytes) {
  ByteReader in(bytes);
  const uint16_t version = in.U16();
  if (in.ok() && version != kVersion) {
    return Status(Code::kVersion, "motion: version " + std::to_string(version) +
                                      ", this program reads " + std::to_string(kVersion) +
                                      "; run the newer one that wrote it");
  }
  if (bytes.size() != kBytes) {
    return Status(Code::kInvalidInput, "motion: expected " + std::to_string(kBytes) +
                                           " bytes, found " + std::to_string(bytes.size()));
  }
  Motion out;
  for (auto& at : out.at) {
    for (int16_t& v : at) v = in.I16();
  }
  return out;
}

}  // namespace enamel::scoring
