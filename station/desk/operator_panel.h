#pragma once

#include <array>
#include <string>
#include <vector>

#include "station/desk/station_facts.h"
#include "station/desk/workflow.h"
#include "station/render/quality.h"
#include "station/render/screen.h"

namespace enamel::station::desk {

// How long the last pictures took, for the panel and for nobody else.
class PictureTimes {
 public:
  static constexpr size_t kCount = 180;
  void Add(double seconds) { ms_[next_++ % kCount] = static_cast<float>(1e3 * seconds); }
  const std::array<float, kCount>& ms() const { return ms_; }
  size_t first() const { return next_ % kCount; }
  double Quantile_ms(double share) const;
  // How many of them took no longer, 0..1.
  double ShareWithin(double seconds) const;

 private:
  std::array<float, kCount> ms_{};
  size_t next_ = 0;
};

// F1: what an operator asks when something is wrong. Station and pictures; once there is a device
// also that, loop and recording, in a second column, so that all of it is on a screen of 1280 x
// 720.
void DrawOperatorPanel(Workflow& flow, StationWatch& station, const render::Screen& screen,
                       const PictureTimes& times, const render::Quality& quality, double budget_s);
// The same where there is no workplace to ask: these lines in the place of what it would say.
void DrawOperatorPanel(const std::vector<std::string>& lines, const render::Screen& screen,
                       const PictureTimes& times, const render::Quality& quality, double budget_s);

}  // namespace enamel::station::desk
