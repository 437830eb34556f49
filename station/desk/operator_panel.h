#pragma once

#include <array>
#include <string>
#include <vector>

#include "station/desk/station_facts.h"
#include "station/desk/workflow.h"
#include "station/render/quality.h"
#include "station/render/screen.h"

namespace enamel::station::desk {

// Times of the last pictures, for the panel.
class PictureTimes {
 public:
  static constexpr size_t kCount = 180;
  void Add(double seconds) { ms_[next_++ % kCount] = static_cast<float>(1e3 * seconds); }
  const std::array<float, kCount>& ms() const { return ms_; }
  size_t first() const { return next_ % kCount; }
  double Quantile_ms(double share) const;
  // Share of them that took no longer, 0..1.
  double ShareWithin(double seconds) const;

 private:
  std::array<float, kCount> ms_{};
  size_t next_ = 0;
};

// F1: the facts an operator needs when something is wrong. First column: station and pictures;
// second column, once there is a device: device, loop and recording. Fits a screen of 1280 x 720.
void DrawOperatorPanel(Workflow& flow, StationWatch& station, const render::Screen& screen,
                       const PictureTimes& times, const render::Quality& quality, double budget_s);
// The same without a workplace: `lines` replace its facts.
void DrawOperatorPanel(const std::vector<std::string>& lines, const render::Screen& screen,
                       const PictureTimes& times, const render::Quality& quality, double budget_s);

}  // namespace enamel::station::desk
