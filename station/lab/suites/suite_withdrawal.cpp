#include <atomic>

#include "station/lab/laws/strokes.h"
#include "station/lab/laws/withdrawal.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

constexpr haptics::LawKind kLaws[] = {haptics::kDefaultLaw, haptics::LawKind::kMaxwell};

// A figure beside its bound; a star marks a miss.
std::string FigureText(const StrokeTrack& track, const char* name, double factor,
                       const char* format) {
  for (const StrokeFigure& f : track.figures) {
    if (f.name != name) continue;
    std::string out = F(f.value * factor, format);
    if (f.bound) out += " (" + F(*f.bound * factor, format) + (f.held() ? ")" : ") *");
    return out;
  }
  return "";
}

}  // namespace

void RunWithdrawalSuite(SuiteContext& c) {
  // Built once: every trial cuts a copy.
  const cutting::Volume block = WithdrawalBlock();
  Table t;
  t.title =
      "Strokes with the product's core: the default law, and in brackets what each figure may be";
  t.note =
      "Error: force sent less the ideal while something is ahead; felt: force in the hand, with "
      "the device's "
      "friction, damping and inertia. B 6.5 N s/mm, cylinder r 0.6 x 4 mm. *: not held. Lag at "
      "half of the plateau; rise to 90 % "
      "against 1.15 of "
      "the oracle's; overshoot where B v is within the continuous force; pull against and push "
      "along the hand, "
      "rise of the pull in a tick, and time to let go to max(0.15 N, Kc delta), all after the "
      "ideal bur has left "
      "the tissue; step: growth in a tick beyond Kc (v T + sqrt(3) delta). Drawn: qualify --help "
      "says how.";
  t.head = {"device",      "case",        "ideal N",    "lag ms", "rise 90 % ms",
            "overshoot N", "error RMS N", "felt RMS N", "pull N", "rise N",
            "push N",      "help ms",     "let go ms",  "step N"};
  for (const DeviceModel& m : c.findings.models) {
    StrokeDevice device{m, {}};
    const size_t laws = std::size(kLaws);
    // Every law is run and kept in the JSON; the table shows the first, which is the default.
    device.tracks.resize(std::size(kStrokeCases) * laws);
    std::atomic<size_t> done{0};
    ParallelFor(device.tracks.size(), c.options.threads, [&](size_t i) {
      device.tracks[i] = RunStroke(m, kStrokeCases[i / laws], kLaws[i % laws], block);
      c.progress("withdrawal", ++done, device.tracks.size());
    });
    for (size_t i = 0; i < device.tracks.size(); i += laws) {
      const StrokeTrack& s = device.tracks[i];
      t.rows.push_back(
          {m.title, StrokeName(s.which), FigureText(s, "ideal_peak_n", 1, "%.2f"),
           FigureText(s, "lag_s", 1e3, "%.0f"), FigureText(s, "rise90_s", 1e3, "%.0f"),
           FigureText(s, "overshoot_n", 1, "%.3f"), FigureText(s, "command_error_rms_n", 1, "%.3f"),
           FigureText(s, "felt_error_rms_n", 1, "%.3f"), FigureText(s, "pull_n", 1, "%.3f"),
           FigureText(s, "rise_n", 1, "%.3f"), FigureText(s, "push_n", 1, "%.2f"),
           FigureText(s, "help_s", 1e3, "%.0f"), FigureText(s, "let_go_s", 1e3, "%.0f"),
           FigureText(s, "step_beyond_n", 1, "%.3f")});
    }
    c.findings.strokes.push_back(std::move(device));
  }
  c.findings.tables.push_back(std::move(t));
}

}  // namespace enamel::station::lab
