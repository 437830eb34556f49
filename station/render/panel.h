#pragma once

#include <string>

#include "station/render/frame_state.h"

struct GLFWwindow;

namespace enamel::station::render {

struct PanelContent {
  std::string heading;
  FrameState state;
  double force_full_scale_n = 3;
  double time_limit_s = 0;
  double mm_per_pixel = 0;  // at the focus, for the scale bar; window pixels
  bool has_state = false;
};

// Text and bars over the picture: timer, force, removed volume, warnings, keys. By Dear ImGui; one
// per process. Needs the context current. Not thread-safe.
class Panel {
 public:
  explicit Panel(GLFWwindow* window);
  ~Panel();
  Panel(const Panel&) = delete;
  Panel& operator=(const Panel&) = delete;

  // Draws into the framebuffer that is bound.
  void Draw(const PanelContent& content);
};

// "3:07"; hours only when there are any. Negative counts as 0.
std::string TimerText(double seconds);
// Each warning as a sentence for the operator, one line each; empty for none.
std::string WarningText(uint32_t warnings);

}  // namespace enamel::station::render
