#include <algorithm>
#include <atomic>

#include "station/lab/laws/pecks.h"
#include "station/lab/suites/suites.h"

// Short touches: how deep the bur goes on a device, against an ideal tool in the same hand.
namespace enamel::station::lab {
namespace {

// The faster loop in the table: Kc rises with the rate as far as friction carries it.
constexpr double kFaster_hz = 4000;

std::vector<Unit> Units(const SuiteContext& c) {
  std::vector<Unit> out;
  std::vector<Unit> units = UnitsOf(c.findings.models);
  for (Unit& unit : units) {
    out.push_back(unit);
    if (!unit.calibrated) continue;
    unit.model = AtRate(unit.model, kFaster_hz, true);
    out.push_back(std::move(unit));
  }
  return out;
}

struct Range {
  double sum = 0, least = 1e300, most = -1e300;
  int n = 0;
  void Add(double v) {
    sum += v;
    least = std::min(least, v);
    most = std::max(most, v);
    ++n;
  }
  std::string Text(double factor, const char* format) const {
    if (n == 0) return "–";
    return F(factor * sum / n, format) + " (" + F(factor * least, format) + " to " +
           F(factor * most, format) + ")";
  }
};

void AddTable(SuiteContext& c, const std::vector<Unit>& units) {
  std::vector<double> tissues;
  for (const Peck& p : AllPecks())
    if (tissues.empty() || tissues.back() != p.b_n_s_per_m) tissues.push_back(p.b_n_s_per_m);
  Table t;
  t.title = "Short touches: depth removed, of an ideal tool's, and felt error, %";
  t.note =
      "Mean (least to most) of touches of 0.2, 0.4 and 0.6 s at 0.35, 0.7 and 1 N, in tissue of B "
      "N s/mm. The hand "
      "of 1 N/mm makes the same motion on the device and on the tool. At 4 kHz: calibrated, with "
      "the Kc "
      "that damping and "
      "friction carry there.";
  t.head = {"device", "calibrated", "kHz", "Kc N/mm"};
  for (double b : tissues) t.head.push_back("depth, B " + F(b * 1e-3, "%.2f"));
  for (double b : tissues) t.head.push_back("felt error, B " + F(b * 1e-3, "%.2f"));
  for (const Unit& u : units) {
    std::vector<std::string> line = {u.model.title, u.calibrated ? "yes" : "no",
                                     F(u.model.rate_hz * 1e-3, "%.0f"),
                                     F(u.model.kc_n_per_m * 1e-3)};
    std::vector<Range> depth(tissues.size()), felt(tissues.size());
    for (const PeckRow& r : c.findings.pecks) {
      if (r.device != u.model.name || r.calibrated != u.calibrated || r.rate_hz != u.model.rate_hz)
        continue;
      for (size_t i = 0; i < tissues.size(); ++i) {
        if (r.peck.b_n_s_per_m != tissues[i]) continue;
        depth[i].Add(r.depth_share());
        felt[i].Add(r.felt_error());
      }
    }
    for (const Range& r : depth) line.push_back(r.Text(1, "%.2f"));
    for (const Range& r : felt) line.push_back(r.Text(100, "%.0f"));
    t.rows.push_back(std::move(line));
  }
  c.findings.tables.push_back(std::move(t));
}

}  // namespace

void RunPecksSuite(SuiteContext& c) {
  const std::vector<Unit> units = Units(c);
  const std::vector<Peck> pecks = AllPecks();
  std::vector<PeckRow>& rows = c.findings.pecks;
  for (const Unit& u : units)
    for (const Peck& p : pecks)
      rows.push_back({u.model.name, u.calibrated, u.model.rate_hz, p, {}});
  std::atomic<size_t> done{0};
  ParallelFor(rows.size(), c.options.threads, [&](size_t i) {
    const Unit& unit = units[i / pecks.size()];
    rows[i].figures = RunPeck(unit.model, unit.told, rows[i].peck);
    c.progress("pecks", ++done, rows.size());
  });
  AddTable(c, units);
}

}  // namespace enamel::station::lab
