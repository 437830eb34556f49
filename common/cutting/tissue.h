#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace enamel::cutting {

// The material of a voxel. Stable numbers: they are stored in volume blobs and traces.
enum class Tissue : uint8_t {
  kAir = 0,
  kEnamel = 1,
  kDentin = 2,
  kPulp = 3,
  kCaries = 4,  // soft, leathery
  kFilling = 5,
  kGypsum = 6,     // or plastic: the material of practice teeth and blocks
  kNeighbour = 7,  // adjacent tooth: cuts like enamel, counted apart
};
inline constexpr int kTissueCount = 8;

// How the pressure on a cutting surface grows with its feed v: as v^m. Stable numbers: they are in traces.
enum class FeedExponent : uint8_t { kNone = 0, kHalf = 1, kOne = 2 };
using FeedExponents = std::array<FeedExponent, kTissueCount>;
constexpr FeedExponents AllLinear() {
  FeedExponents all{};
  all.fill(FeedExponent::kOne);
  return all;
}

inline constexpr std::array<std::string_view, kTissueCount> kTissueNames = {
    "air", "enamel", "dentin", "pulp", "caries", "filling", "gypsum", "neighbour"};

constexpr std::string_view TissueName(Tissue t) { return kTissueNames[static_cast<size_t>(t)]; }
constexpr std::optional<Tissue> TissueFromName(std::string_view name) {
  for (int i = 0; i < kTissueCount; ++i) {
    if (kTissueNames[static_cast<size_t>(i)] == name) return static_cast<Tissue>(i);
  }
  return std::nullopt;
}

}  // namespace enamel::cutting
