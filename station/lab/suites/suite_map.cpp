#include <atomic>
#include <cmath>
#include <cstdio>

#include "common/fidelity/feel.h"
#include "common/scene/builtin/builtin.h"
#include "station/lab/suites/suites.h"

// Where a hand feels F = B V, per device and tissue, and where no law could achieve it
// (common/fidelity).
namespace enamel::station::lab {
namespace {

using fidelity::Motion;

constexpr double kShownSpeed_m_per_s = 0.43e-3;

// Hard to soft; one of each B: a neighbour cuts like enamel.
std::vector<fidelity::Tissue> BuiltinTissues() {
  using cutting::Tissue;
  std::vector<fidelity::Tissue> out;
  for (const scene::TissueSpec& spec :
       scene::DefaultTissues({Tissue::kEnamel, Tissue::kFilling, Tissue::kDentin, Tissue::kGypsum,
                              Tissue::kCaries, Tissue::kPulp}))
    out.push_back(fidelity::TissueOf(spec));
  return out;
}

struct Job {
  fidelity::Device device;
  bool attached;
  const fidelity::Tissue* tissue;
  double speed;
  Motion motion;
};

FeelRow RowOf(const Job& job) {
  FeelRow row;
  row.device = job.device.name;
  row.tissue = job.tissue->name;
  row.b_n_s_per_mm = job.tissue->b_n_s_per_m / 1000;
  row.kc_n_per_mm = job.device.kc_n_per_m / 1000;
  row.delay_ticks = job.device.delay_ticks;
  row.attached = job.attached;
  row.cell = fidelity::Simulate(job.device, *job.tissue, job.speed, job.motion);
  return row;
}

std::string Text(const fidelity::Cell& cell) {
  char figures[80];
  if (cell.verdict == fidelity::Verdict::kBeyondForce) {
    std::snprintf(figures, sizeof figures, ": %.2f N", cell.rms_n);
  } else if (cell.motion == Motion::kStrokes) {
    std::snprintf(figures, sizeof figures, ": %.0f %%, %.0f ms (%.0f %%)", 100 * cell.law.error,
                  1e3 * cell.law.lag_s, 100 * cell.oracle.error);
  } else if (cell.law.rise_s < 0) {
    std::snprintf(figures, sizeof figures, ": %.0f %%, never", 100 * cell.law.error);
  } else {
    std::snprintf(figures, sizeof figures, ": %.0f %%, %.2f s (%.2f)", 100 * cell.law.error,
                  cell.law.rise_s, cell.oracle.rise_s);
  }
  return std::string(fidelity::VerdictWords(cell.verdict)) + figures;
}

void AddTable(SuiteContext& c, const std::vector<fidelity::Tissue>& tissues, Motion motion,
              bool attached) {
  Table t;
  t.title = std::string("What a hand can feel: ") +
            (motion == Motion::kSteady ? "a steady cut at 0.43 mm/s"
                                       : "strokes to and fro of 1 s, mean 0.43 mm/s") +
            (attached ? ", delay and Kc as an attached unit has them"
                      : ", delay and Kc as the profile says");
  t.note = motion == Motion::kSteady ? "Mean error over B V after the rise; time until within 7 % "
                                       "(the oracle's: from rest no passive law is faster)."
                                     : "RMS error over B V; lag (the oracle's error: of force that "
                                       "rises by at most Kc |v|; a law with an energy "
                                       "tank may beat it).";
  t.note +=
      " As it is: within 7 % and 15 ms. Late: within 7 %. Nearly: within 19 %. Device cannot: "
      "worse, and the oracle is not "
      "within 7 % and 15 ms either. Law falls short: worse, though the oracle is. Too weak: RMS "
      "above the continuous "
      "force, or largest above the peak. All speeds: --json.";
  t.head = {"device", "Kc N/mm", "delay ticks"};
  for (const fidelity::Tissue& tissue : tissues) {
    char head[60];
    std::snprintf(head, sizeof head, "%s %.1f", tissue.name.c_str(), tissue.b_n_s_per_m * 1e-3);
    t.head.emplace_back(head);
  }
  for (const DeviceModel& m : c.findings.models) {
    std::vector<std::string> line;
    for (const FeelRow& r : c.findings.feel) {
      if (r.device != m.name || r.attached != attached || r.cell.motion != motion ||
          r.cell.speed_m_per_s != kShownSpeed_m_per_s)
        continue;
      // From the first cell: an attached unit's Kc and delay are not the model's.
      if (line.empty()) {
        char kc[24];
        std::snprintf(kc, sizeof kc, "%.2f", r.kc_n_per_mm);
        line = {m.title, kc, std::to_string(r.delay_ticks)};
      }
      line.push_back(Text(r.cell));
    }
    if (!line.empty()) t.rows.push_back(std::move(line));
  }
  c.findings.tables.push_back(std::move(t));
}

}  // namespace

void RunMapSuite(SuiteContext& c) {
  const std::vector<fidelity::Tissue> tissues = BuiltinTissues();
  std::vector<Job> jobs;
  for (const DeviceModel& m : c.findings.models) {
    Result<fidelity::Device> plain = fidelity::AsItStands(m.profile);
    Result<fidelity::AttachedDevice> attached = fidelity::Attached(m.profile);
    for (const Status& status : {plain.status(), attached.status()}) {
      // A profile usable only with its own delay still has its half of the map.
      if (!status.ok() && c.options.errors) c.options.errors("map: " + status.message());
    }
    for (bool is_attached : {false, true}) {
      if (is_attached ? !attached.ok() : !plain.ok()) continue;
      for (const fidelity::Tissue& tissue : tissues) {
        for (double speed : fidelity::kSpeeds_m_per_s) {
          for (Motion motion : fidelity::kMotions)
            jobs.push_back(
                {is_attached ? attached->device : *plain, is_attached, &tissue, speed, motion});
        }
      }
    }
  }
  std::vector<FeelRow> rows(jobs.size());
  std::atomic<size_t> done{0};
  ParallelFor(jobs.size(), c.options.threads, [&](size_t i) {
    rows[i] = RowOf(jobs[i]);
    c.progress("map: cells", ++done, jobs.size());
  });
  for (FeelRow& row : rows) c.findings.feel.push_back(std::move(row));
  // Four tables instead of one with eight columns a tissue.
  for (bool attached : {false, true}) {
    for (Motion motion : fidelity::kMotions) AddTable(c, tissues, motion, attached);
  }
}

}  // namespace enamel::station::lab
