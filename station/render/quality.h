#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

// Levels of drawing effort, and the choice among them by drawing time.
namespace enamel::station::render {

struct Quality {
  std::string_view name;         // as in settings
  float scale = 1;               // solid pixels per picture pixel along each side
  int occlusion_samples = 0;     // per pixel of ambient occlusion; 0: none
  bool lighter_turning = false;  // while the camera moves, use WhileTurning of this
  bool coarse = false;           // the tooth's coarse triangles

  bool operator==(const Quality&) const = default;
};

// Best first.
inline constexpr std::array<Quality, 4> kQualities = {{
    {"best", 2.0f, 20, false},
    {"good", 1.0f, 20, true},
    {"fair", 1.0f, 8, true},
    {"low", 0.5f, 0, true},
}};
// A lighter quality for a moving picture, which nobody examines closely: at most one solid pixel for
// four of the picture.
Quality WhileTurning(const Quality& quality);
// nullptr when the name is unknown.
const Quality* FindQuality(std::string_view name);

// Steps down when pictures take longer than the budget, and up again when much time is left. Uses
// the median over kWindow, so that one slow picture (a window being moved) changes nothing. After a
// level up that was too slow it waits twice as long before the next, up to kLongestWait windows:
// quality returns when there is time again, and does not swing. Pure: time comes in, a level comes
// out. Not thread-safe.
class QualityGovernor {
 public:
  static constexpr size_t kWindow = 30;
  static constexpr size_t kShortestWait = 4, kLongestWait = 128;  // windows
  // Levels are indices into kQualities.
  QualityGovernor(size_t first_level, double budget_s);

  // Call after each picture with its time. True when the level changed.
  bool Note(double picture_s);
  size_t level() const { return level_; }
  double budget_s() const { return budget_s_; }

 private:
  const double budget_s_;
  size_t level_;
  size_t wait_ = kShortestWait, easy_windows_ = 0;
  size_t since_rise_ = 0;  // windows; 0: no rise, or it has proved itself
  size_t count_ = 0;
  std::array<double, kWindow> times_s_{};
};

}  // namespace enamel::station::render
