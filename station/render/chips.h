#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <random>
#include <span>

#include "common/cutting/bur.h"
#include "common/cutting/tissue.h"
#include "station/render/revolve.h"

namespace enamel::station::render {

// A grain that leaves the bur. Millimetres and seconds, scene frame.
struct Chip {
  glm::vec3 at_mm{0}, mm_per_s{0};
  float age_s = 0, life_s = 0;
  float widest_mm = 0;  // radius when it leaves
  cutting::Tissue tissue = cutting::Tissue::kAir;

  bool alive() const { return age_s < life_s; }
  // Shrinks to nothing as it ages.
  float radius_mm() const;
};

// What flies off while a bur cuts: as many grains as what is removed asks for, up to kMost, after
// which the oldest make room. For the eye: a true grain is dust that leaves the picture within a
// frame, and these neither hit the tooth nor stay on it. The same calls give the same grains.
// Allocates nothing. Not thread-safe.
class Chips {
 public:
  static constexpr size_t kMost = 200;
  // A 1.2 mm bur at 5 mm/s, 0.2 mm deep, removes 1.2 mm3 a second: kMost are then nearly reached.
  static constexpr double kPerMm3 = 500;
  static constexpr float kLongest_s = 1.0f / 3, kShortest_s = 0.2f;
  // Some six pixels across where a crown fills a screen's height.
  static constexpr float kWidest_mm = 0.05f;

  // Moves and ages all of them.
  void Step(float dt_s);
  // Grains of what `bur` at `pose` removed of each tissue during the last `dt_s`. Air gives none, nor
  // does pulp, which is soft.
  void Add(const std::array<double, cutting::kTissueCount>& removed_mm3, const cutting::Bur& bur,
           const cutting::Pose& pose, float dt_s);
  // Dead ones too.
  std::span<const Chip> all() const { return all_; }

 private:
  // Uniform in [0, 1).
  float Unit() { return static_cast<float>(random_() >> 8) / 16777216.0f; }
  Chip Leave(const cutting::Bur& bur, const cutting::Pose& pose);

  std::array<Chip, kMost> all_{};
  size_t next_ = 0;
  std::array<double, cutting::kTissueCount> owed_{};  // grains, below one
  std::mt19937 random_{7};                            // a fixed seed, for equal pictures
};

// Replaces `shape` by those alive, in their tissue's colour and as dull as what was cut.
void ShapeOf(std::span<const Chip> chips, Shape& shape);

}  // namespace enamel::station::render
