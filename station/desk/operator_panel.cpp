#include "station/desk/operator_panel.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "station/session/loop_facts.h"

namespace enamel::station::desk {
namespace {

constexpr float kColumn = 570;  // pixels of a picture 1080 high, with the letters of it

double Us(double ns) { return ns * 1e-3; }

void Head(const char* text) {
  ImGui::Spacing();
  ImGui::TextDisabled("%s", text);
  ImGui::Separator();
}

ImVec2 PlotSize() { return {ImGui::GetContentRegionAvail().x, 2 * ImGui::GetTextLineHeight()}; }

void Lateness(const DurationHistogram& lateness) {
  ImGui::TextWrapped("late by   p50 %.0f   p99 %.0f   max %.0f us", Us(lateness.Quantile_ns(0.5)),
                     Us(lateness.Quantile_ns(0.99)), Us(static_cast<double>(lateness.max_ns())));
  // One bar per doubling from 1 us to 16 ms, by share of ticks; square root, to make rare ones
  // visible.
  std::vector<float> bars;
  // kSplit buckets make a doubling; their sum is a bar.
  for (int octave = 7; octave < 22; ++octave) {
    uint64_t n = 0;
    for (int i = 0; i < DurationHistogram::kSplit; ++i) {
      n += lateness.InBucket(static_cast<size_t>(octave * DurationHistogram::kSplit + i));
    }
    double share =
        static_cast<double>(n) / std::max<double>(1, static_cast<double>(lateness.count()));
    bars.push_back(static_cast<float>(std::sqrt(share)));
  }
  ImGui::PlotHistogram("##late", bars.data(), static_cast<int>(bars.size()), 0, "1 us … 16 ms", 0,
                       1, PlotSize());
}

void Loop(RunningAttempt& run, uint32_t rate_hz) {
  const Snapshot& s = run.snapshot();
  auto n = [](uint64_t v) { return static_cast<unsigned long long>(v); };
  Head("Loop");
  ImGui::TextWrapped("%s", CountsText(s.counters).c_str());
  ImGui::TextWrapped("%u Hz   stale %llu   bounded %llu", rate_hz, n(s.counters.stale_ticks),
                     n(s.counters.bounded_ticks));
  ImGui::TextWrapped("tick      p50 %.1f   p99 %.1f us",
                     Us(run.loop().durations().Quantile_ns(0.5)),
                     Us(run.loop().durations().Quantile_ns(0.99)));
  Lateness(run.loop().lateness());
  if (s.fault != Fault::kNone) ImGui::TextWrapped("%s", FaultText(s.fault));
}

void DeviceFacts(const Device& device) {
  DeviceCounters c = device.counters();
  auto n = [](uint64_t v) { return static_cast<unsigned long long>(v); };
  Head("Device");
  ImGui::TextWrapped("%s", device.Name().c_str());
  ImGui::TextWrapped("samples %llu   lost %llu   refused %llu", n(c.samples), n(c.lost),
                     n(c.refused));
  ImGui::TextWrapped("write errors %llu   unplugged %llu", n(c.write_errors), n(c.detached));
}

void Station(Workflow& flow, StationWatch& station) {
  Head("Station");
  const Credentials& credentials = flow.workplace().credentials();
  ImGui::TextWrapped("%s:%u   %s", credentials.server.host.c_str(),
                     unsigned{credentials.server.port},
                     flow.workplace().person() ? "signed in" : "nobody signed in");
  if (const auto& facts = station.Look(Workflow::Clock::now())) {
    for (const std::string& line : Lines(*facts)) ImGui::TextWrapped("%s", line.c_str());
  }
  ImGui::TextWrapped("%s", flow.workplace().spool().file().c_str());
}

void Recording(Workflow& flow) {
  Head("Recording");
  RunningAttempt::Recording r = flow.attempt()->run()->recording();
  Uploader::State up = flow.upload();
  ImGui::TextWrapped("%u chunks, %llu ticks durable", r.chunks,
                     static_cast<unsigned long long>(r.ticks));
  ImGui::TextWrapped("%u chunks on the server%s", up.committed, up.sealed ? "   sealed" : "");
  if (!r.problem.ok()) ImGui::TextWrapped("%s", r.problem.message().c_str());
  if (up.gave_up) ImGui::TextWrapped("%s", up.problem.message().c_str());
}

void Attempt(Workflow& flow) {
  DeskAttempt& attempt = *flow.attempt();
  if (attempt.run() != nullptr) Loop(*attempt.run(), attempt.prepared().header.params.rate_hz);
  DeviceFacts(attempt.device());
  if (attempt.run() != nullptr) Recording(flow);
}

void Pictures(const render::Screen& screen, const PictureTimes& times,
              const render::Quality& quality, double budget_s) {
  Head("Pictures");
  ImGui::TextWrapped("p50 %.1f   p95 %.1f ms   budget here %.1f ms", times.Quantile_ms(0.5),
                     times.Quantile_ms(0.95), 1e3 * budget_s);
  ImGui::TextWrapped("fit for 60 a second (16.7 ms): %.0f %%", 100 * times.ShareWithin(1.0 / 60));
  ImGui::PlotLines("##pictures", times.ms().data(), static_cast<int>(PictureTimes::kCount),
                   static_cast<int>(times.first()), nullptr, 0, static_cast<float>(2e3 * budget_s),
                   PlotSize());
  ImGui::TextWrapped("quality %s   %d x %d", std::string(quality.name).c_str(), screen.width(),
                     screen.height());
  ImGui::TextWrapped("%s", screen.renderer().c_str());
}

}  // namespace

double PictureTimes::Quantile_ms(double share) const {
  std::vector<float> sorted(ms_.begin(), ms_.begin() + static_cast<long>(std::min(next_, kCount)));
  if (sorted.empty()) return 0;
  // Some 180 values, once a picture: cheaper than keeping them in order.
  std::sort(sorted.begin(), sorted.end());
  auto at = static_cast<size_t>(share * static_cast<double>(sorted.size() - 1));
  return sorted[at];
}

double PictureTimes::ShareWithin(double seconds) const {
  auto end = ms_.begin() + static_cast<long>(std::min(next_, kCount));
  auto within = std::count_if(ms_.begin(), end, [&](float ms) { return ms <= 1e3 * seconds; });
  return static_cast<double>(within) /
         static_cast<double>(std::max<size_t>(1, std::min(next_, kCount)));
}

namespace {

// The panel's place and fonts; `draw` adds its columns.
template <typename Draw>
void Frame(const render::Screen& screen, int columns, Draw&& draw) {
  const float px = screen.fonts().scale;
  ImGui::SetNextWindowPos({static_cast<float>(screen.width()) - 20 * px, 20 * px}, ImGuiCond_Always,
                          {1, 0});
  const float wide = static_cast<float>(columns) * kColumn * screen.fonts().letters +
                     (24 * static_cast<float>(columns) + 48) * px;
  ImGui::SetNextWindowSize({std::min(wide, static_cast<float>(screen.width()) - 40 * px), 0});
  ImGui::PushFont(screen.fonts().near);
  ImGui::SetNextWindowFocus();
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4{0.05f, 0.06f, 0.07f, 0.95f});
  ImGui::Begin("operator", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoSavedSettings |
                   // It takes no input: mouse and keys still control the attempt below it.
                   ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::TextWrapped("Operator panel   F1 closes it");
  if (ImGui::BeginTable("columns", columns, ImGuiTableFlags_SizingStretchSame)) {
    draw();
    ImGui::EndTable();
  }
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopFont();
}

}  // namespace

void DrawOperatorPanel(Workflow& flow, StationWatch& station, const render::Screen& screen,
                       const PictureTimes& times, const render::Quality& quality, double budget_s) {
  const int columns = flow.attempt() != nullptr ? 2 : 1;
  Frame(screen, columns, [&] {
    if (columns == 2) {
      ImGui::TableNextColumn();
      Attempt(flow);
    }
    ImGui::TableNextColumn();
    Station(flow, station);
    Pictures(screen, times, quality, budget_s);
  });
}

void DrawOperatorPanel(const std::vector<std::string>& lines, const render::Screen& screen,
                       const PictureTimes& times, const render::Quality& quality, double budget_s) {
  Frame(screen, 1, [&] {
    ImGui::TableNextColumn();
    Head("Station");
    for (const std::string& line : lines) ImGui::TextWrapped("%s", line.c_str());
    Pictures(screen, times, quality, budget_s);
  });
}

}  // namespace enamel::station::desk
