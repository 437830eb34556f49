#include "station/desk/depth_gauge.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "station/render/panel.h"

namespace enamel::station::desk {
namespace {

constexpr ImU32 kFigure = IM_COL32(255, 255, 255, 255), kBehind = IM_COL32(16, 18, 21, 190),
                kWarning = IM_COL32(0, 0, 0, 255);

}  // namespace

DepthGauge::DepthGauge(const scene::CavityTarget& target, const cutting::Volume& initial)
    : sides_(target.landmark == "crown_top"), initial_(initial) {}

double DepthGauge::Along_m(dvec3 at_m, const dvec3& direction) const {
  const double least_m = 0.25 * initial_.spec().voxel_m();
  double way_m = 0, inside_m = -initial_.DistanceAt_m(at_m);
  while (inside_m > 0) {
    // No surface is nearer than the distance says, and that is known to four voxels.
    const double step_m = std::max(inside_m, least_m);
    at_m += step_m * direction;
    const double next_m = -initial_.DistanceAt_m(at_m);
    // Between the two the distance is taken as linear.
    if (next_m <= 0) return way_m + step_m * inside_m / (inside_m - next_m);
    way_m += step_m;
    inside_m = next_m;
  }
  return way_m;
}

std::optional<double> DepthGauge::Depth_m(const dvec3& point_m) const {
  if (initial_.DistanceAt_m(point_m) >= 0) return std::nullopt;
  if (!sides_) return Along_m(point_m, dvec3(0, 0, 1));
  double least_m = std::numeric_limits<double>::infinity();
  for (int z = 0; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        if (x == 0 && y == 0 && z == 0) continue;
        least_m = std::min(least_m, Along_m(point_m, glm::normalize(dvec3(x, y, z))));
      }
    }
  }
  return least_m;
}

std::string DepthGauge::Text(const language::Words& words, double depth_m) const {
  const double step_mm = initial_.spec().voxel_m() * 1e3;
  return words.Say("depth.text",
                   {{"depth", words.Decimal(step_mm * std::round(depth_m * 1e3 / step_mm),
                                            step_mm < 0.1 ? 2 : 1)}});
}

void WriteBeside(const dvec3& point_m, const std::string& figure, const std::string& warning,
                 const render::Camera& camera, const render::Fonts& fonts, int width, int height) {
  const auto w = static_cast<float>(width), h = static_cast<float>(height);
  const glm::vec4 clip =
      camera.ClipFromView(w / h) * camera.ViewFromScene() * glm::vec4(glm::vec3(point_m * 1e3), 1);
  if (clip.w <= 0 || std::abs(clip.x) > clip.w || std::abs(clip.y) > clip.w) return;
  const ImFont* font = fonts.text;
  const float aside = 36 * fonts.scale, edge = 6 * fonts.scale;
  // Right of the bur and below its tip: the bur itself is above it.
  ImVec2 at{0.5f * w * (1 + clip.x / clip.w) + aside, 0.5f * h * (1 - clip.y / clip.w) + edge};
  // In words on yellow: no two colours need to differ, and nothing flashes.
  const auto [r, g, b] = render::ColourOf(render::Bearing::kCareful);
  const struct {
    const std::string& text;
    ImU32 colour, behind;
  } lines[] = {{figure, kFigure, kBehind},
               {warning, kWarning, ImGui::ColorConvertFloat4ToU32({r, g, b, 1})}};
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  for (const auto& line : lines) {
    if (line.text.empty()) continue;
    const ImVec2 size = font->CalcTextSizeA(font->FontSize, w, 0, line.text.c_str());
    at.x = std::min(at.x, w - size.x - 2 * edge);
    at.y = std::min(at.y, h - size.y - 2 * edge);
    list->AddRectFilled({at.x - edge, at.y - edge}, {at.x + size.x + edge, at.y + size.y + edge},
                        line.behind, edge);
    list->AddText(font, font->FontSize, at, line.colour, line.text.c_str());
    at.y += size.y + 3 * edge;
  }
}

}  // namespace enamel::station::desk
