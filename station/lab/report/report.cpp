#include "station/lab/report/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>

#include "station/lab/report/cutting_report.h"
#include "station/lab/report/svg.h"
#include "station/lab/suites/front.h"

namespace enamel::station::lab {
namespace {

constexpr const char* kInk[] = {"#1f6f8b", "#c8493f", "#5b3fa0", "#b07a12",
                                "#2e8b68", "#7d8b93", "#d1709c", "#3d5a80"};

std::string F(double v, const char* format = "%.3f") {
  char text[64];
  std::snprintf(text, sizeof text, format, v);
  return text;
}

size_t Width(const std::string& s) {
  return static_cast<size_t>(
      std::count_if(s.begin(), s.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

constexpr double kLabelled = 3;  // points worse than this have no name in the plot
constexpr double kDrawn = 100;   // larger figures, and what is never reached, are drawn here

bool Measured(const std::vector<LawPoint>& points, size_t metric) {
  return std::any_of(points.begin(), points.end(),
                     [&](const LawPoint& p) { return std::isfinite(p.figures[metric]); });
}

// One figure of every law at B = 6.5, the worst hand, against the cost of a tick.
Plot ParetoPlot(const std::vector<LawPoint>& points, size_t metric, const DeviceModel& m) {
  const Metric& what = FrontMetrics()[metric];
  Plot p;
  p.title = std::string("Against run time on ") + m.title + ": " + what.label +
            ", B = 6.5 N s/mm, worst hand";
  p.x_label = "ns per tick: law + estimator + output chain";
  p.y_label = what.label;
  p.log_x = p.log_y = true;
  p.width = 1020;
  p.height = 460;
  Series others{"holds in every hand", {}, "#9fb0b8", true},
      lost{"cycles or unstable in a hand", {}, "#c8493f", true, true},
      front{"front of this figure", {}, "#1f6f8b", true},
      all{"undominated over all figures", {}, "#2e8b68", true, true};
  Series star{"default: gated Maxwell, 1 kHz", {}, "#e08e0b", true};
  std::vector<Series> names;
  for (const LawPoint& q : points) {
    double value = q.figures[metric];
    if (std::isnan(value)) continue;
    std::pair<double, double> at{q.ns_per_tick, std::clamp(value, what.floor, kDrawn)};
    if (q.is_default)
      star.points.push_back(at);
    else if (q.lost)
      lost.points.push_back(at);
    else if (q.on_front[metric])
      front.points.push_back(at);
    else if (q.undominated)
      all.points.push_back(at);
    else
      others.points.push_back(at);
    if (q.on_front[metric] && !q.is_default && value < kLabelled)
      names.push_back({q.name, {at}, "#1f6f8b", true, true, false, true});
  }
  p.series = {others, lost, all, front};
  for (Series& s : names) p.series.push_back(std::move(s));
  p.series.push_back(star);
  return p;
}

Plot RatePlot(const Findings& f, const DeviceModel& m) {
  Plot p;
  p.title = "Default law against loop rate on " + m.title;
  p.x_label = "loop rate, Hz";
  p.y_label = "error N (velocity hand)";
  p.log_x = true;
  std::map<double, Series> by_material;
  for (const Row& r : f.rows) {
    if (r.suite != "laws" || r.profile != m.name || !r.is_default || r.hand != "velocity") continue;
    by_material[r.b_n_s_per_mm].points.push_back({r.rate_hz, r.m.error_max_n});
  }
  size_t i = 0;
  for (auto& [b, s] : by_material) {
    s.label = "B = " + F(b, "%.1f");
    s.colour = kInk[i++ % std::size(kInk)];
    std::sort(s.points.begin(), s.points.end());
    p.series.push_back(s);
  }
  return p;
}

Plot RandomPlot(const RandomSummary& r) {
  Plot p;
  p.title = "Share of cases below a multiple of the bound: " + r.title;
  p.x_label = "figure / its bound (1 = bound)";
  p.y_label = "share of cases";
  auto Curve = [](std::vector<double> v, const char* label, const char* colour) {
    Series s{label, {}, colour};
    std::sort(v.begin(), v.end());
    for (size_t i = 0; i < v.size(); ++i)
      s.points.push_back(
          {std::min(v[i], 2.5), static_cast<double>(i + 1) / static_cast<double>(v.size())});
    return s;
  };
  p.series = {Curve(r.errors_n, "error / max(0.06 N, 1.3 Kc delta/2)", kInk[0]),
              Curve(r.rises, "rise / 1.25 floor", kInk[1]),
              Curve(r.releases, "release / 0.75 B/Kc", kInk[2]),
              {"bound", {{1, 0}, {1, 1}}, "#17242b", false, false, true}};
  return p;
}

std::string TableHtml(const Table& t) {
  std::string s = "<h3>" + Escaped(t.title) + "</h3>";
  s += "<div class=wide><table><thead><tr>";
  for (const std::string& h : t.head) s += "<th scope=col>" + Escaped(h) + "</th>";
  s += "</tr></thead><tbody>";
  for (const auto& row : t.rows) {
    s += "<tr>";
    for (const std::string& cell : row) {
      bool bad = cell.find("UNDER") == 0 || cell.find("NOT BOUNDED") == 0 ||
                 cell.find("VIOLATED") != std::string::npos || cell == "unstable";
      s += std::string("<td") + (bad ? " class=bad" : "") + ">" + Escaped(cell) + "</td>";
    }
    s += "</tr>";
  }
  s += "</tbody></table></div>";
  if (!t.note.empty()) s += "<p class=note>" + Escaped(t.note) + "</p>";
  return s;
}

std::string Cards(const Findings& f) {
  auto Card = [](const std::string& big, const std::string& small, bool good) {
    return "<div class='card " + std::string(good ? "good" : "bad") + "'><b>" + Escaped(big) +
           "</b><span>" + Escaped(small) + "</span></div>";
  };
  std::string s = "<div class=cards>";
  double error = 0, force = 0;
  bool any = false;
  for (const Row& r : f.rows) {
    if (r.suite != "figures") continue;
    any = true;
    (r.hand == "velocity" ? error : force) =
        std::max(r.hand == "velocity" ? error : force, r.m.error_max_n);
  }
  if (any) {
    s += Card(F(error) + " N",
              "steady error per axis, velocity hand, 2.8 N in enamel (bound: encoder's Kc delta/2)",
              error < 0.1);
    s += Card(F(force) + " N", "worst error with force and impedance hands", force < 0.1);
  }
  int64_t violations = 0, ticks = 0;
  for (const Attack& a : f.attacks) {
    if (!a.proved) continue;
    violations += a.violations;
    ticks += a.ticks;
  }
  if (ticks > 0)
    s += Card(std::to_string(violations),
              "violations of the energy floor in " + F(static_cast<double>(ticks) * 1e-6, "%.1f") +
                  " million hostile ticks",
              violations == 0);
  for (const RandomSummary& r : f.random) {
    double share = 100.0 * r.held / std::max(1, r.cases);
    s += Card(F(share, "%.1f") + " %",
              "of " + std::to_string(r.cases) +
                  " random cases hold every bound with one parameter set; " + r.title,
              share >= 99);
  }
  if (f.integration_error_m > 0)
    s += Card(F(f.integration_error_m * 1e6, "%.3f") + " um",
              "the simulator's own integration error over a 2 s trial",
              f.integration_error_m < 1e-6);
  return s + "</div>";
}

std::string ProvenanceHtml(const Findings& f) {
  std::string s;
  for (const DeviceModel& m : f.models) {
    s += "<details><summary>" + Escaped(m.title) +
         ": where every number is from</summary><div class=wide><table><tbody>";
    for (const auto& [what, source] : m.provenance)
      s += "<tr><th scope=row>" + Escaped(what) + "</th><td>" + Escaped(source) + "</td></tr>";
    s += "</tbody></table></div></details>";
  }
  return s;
}

std::string FailuresHtml(const Findings& f) {
  std::string s;
  for (const RandomSummary& r : f.random) {
    Table t;
    t.title = "Cases that miss a bound, " + r.title + ": " + std::to_string(r.failures.size()) +
              " of " + std::to_string(r.cases) + " (error " + std::to_string(r.error) + ", rise " +
              std::to_string(r.rise) + ", release " + std::to_string(r.release) + ", cycle " +
              std::to_string(r.cycle) + ")";
    t.head = {"device",       "hand",         "B N s/mm", "speed mm/s", "error N",
              "rise / floor", "release B/Kc", "cycle",    "repeat with"};
    for (const Row& row : r.failures) {
      t.rows.push_back({row.profile, row.hand, F(row.b_n_s_per_mm, "%.1f"), F(row.speed_mm_s),
                        F(row.m.error_max_n), F(row.m.rise90_s / row.m.rise90_floor_s, "%.2f"),
                        row.hand == "velocity" ? F(row.m.release10_s / row.tau_s, "%.2f") : "-",
                        row.m.cycle ? "yes" : "no", row.title});
    }
    if (!t.rows.empty()) s += TableHtml(t);
  }
  return s;
}

constexpr const char* kCss =
    "body{font:15px/1.5 "
    "system-ui,sans-serif;color:#17242b;background:#f6f8f9;margin:0}main{max-width:1060px;margin:0 "
    "auto;padding:28px 20px 60px}"
    "h1{font-size:26px;margin:0 0 4px}h2{font-size:20px;margin:38px 0 8px;border-bottom:2px solid "
    "#d7e0e4;padding-bottom:4px}h3{font-size:15px;margin:22px 0 6px}"
    ".sub,.note{color:#45565f}.note{font-size:13px;max-width:90ch}.cards{display:flex;flex-wrap:"
    "wrap;gap:12px;margin:18px 0}"
    ".card{background:#fff;border:1px solid #d7e0e4;border-left:5px solid "
    "#2e8b68;border-radius:6px;padding:10px 14px;flex:1 1 "
    "190px}.card.bad{border-left-color:#b07a12}"
    ".card b{display:block;font-size:22px}.card "
    "span{font-size:13px;color:#45565f}.wide{overflow-x:auto;background:#fff;border:1px solid "
    "#d7e0e4;border-radius:6px}"
    "table{border-collapse:collapse;font-size:12.5px;width:100%;font-variant-numeric:tabular-nums}"
    "th,td{padding:4px 9px;text-align:left;border-bottom:1px solid #edf1f3;vertical-align:top}"
    "thead "
    "th{background:#eef3f5;position:sticky;top:0}td.bad{color:#a3271d;font-weight:600}.plots{"
    "display:flex;flex-wrap:wrap;gap:14px;margin:12px 0}"
    ".plots svg{background:#fff;border:1px solid "
    "#d7e0e4;border-radius:6px;max-width:100%;height:auto}details{margin:8px "
    "0}summary{cursor:pointer}code{background:#e9eff2;padding:1px 4px;border-radius:3px}"
    "@media print{body{background:#fff}.wide{overflow:visible}}";

struct Named {
  std::string section, file, svg;
};

bool OfThePaper(const std::string& title) { return title.rfind("Figure ", 0) == 0; }

std::vector<Named> AllPlots(const Findings& f) {
  std::vector<Named> out;
  bool laws =
      std::any_of(f.rows.begin(), f.rows.end(), [](const Row& r) { return r.suite == "laws"; });
  std::map<std::string, Plot> frames;
  std::vector<std::string> order;
  for (const TimeTrace& t : f.traces) {
    Plot& p = frames[t.title];
    if (p.series.empty()) {
      order.push_back(t.title);
      p.title = t.title;
      p.x_label = "time, s";
      p.y_label = "resisting force, N";
      p.width = 1020;
      p.height = 360;
    }
    Series s{t.label, {}, kInk[p.series.size() % std::size(kInk)]};
    // Laws that swing to and fro would fill the frame; the paper's figures are drawn whole.
    double most = OfThePaper(t.title) ? 1e9 : t.target_n;
    for (const Sample& q : t.samples)
      s.points.push_back({q.t_s, std::clamp(q.force_n, -2 * most, 4 * most)});
    p.series.push_back(std::move(s));
  }
  for (size_t i = 0; i < order.size(); ++i) {
    Plot& p = frames[order[i]];
    double end = 0;
    for (const Series& s : p.series)
      if (!s.points.empty()) end = std::max(end, s.points.back().first);
    for (const TimeTrace& t : f.traces) {
      if (t.title != order[i]) continue;
      p.series.push_back(
          {"B V", {{0, t.target_n}, {end, t.target_n}}, "#17242b", false, false, true});
      break;
    }
    const char* section = OfThePaper(order[i]) ? "paper" : "laws";
    out.push_back({section, "trace-" + std::to_string(i + 1), SvgOf(p)});
  }
  for (const DeviceModel& m : f.models) {
    if (!laws) break;
    std::vector<LawPoint> points = LawPointsOf(f.rows, m.name);
    for (size_t k = 0; k < FrontMetrics().size(); ++k) {
      if (!Measured(points, k)) continue;
      out.push_back({"laws", std::string("pareto-") + FrontMetrics()[k].id + "-" + m.name,
                     SvgOf(ParetoPlot(points, k, m))});
    }
    if (!f.quick) out.push_back({"laws", "rate-" + m.name, SvgOf(RatePlot(f, m))});
  }
  for (size_t i = 0; i < f.maps.size(); ++i)
    out.push_back({"extreme", "map-" + std::to_string(i + 1), SvgOf(f.maps[i])});
  for (size_t i = 0; i < f.random.size(); ++i)
    out.push_back({"random", "random-" + std::to_string(i + 1), SvgOf(RandomPlot(f.random[i]))});
  for (auto& [file, svg] : CuttingPlots(f)) out.push_back({"cutting", file, std::move(svg)});
  return out;
}

// A table's place on the page, by the words its title starts with.
const char* SectionOf(const Table& t) {
  auto Starts = [&](const char* with) { return t.title.rfind(with, 0) == 0; };
  if (Starts("Figures of") || Starts("Strokes") || Starts("Loop rates")) return "figures";
  if (Starts("Fronts")) return "laws";
  if (Starts("Table") || Starts("Device profiles")) return "paper";
  if (Starts("Velocity est")) return "estimators";
  if (Starts("Adversary")) return "adversary";
  if (Starts("Random")) return "random";
  if (Starts("Cutting") || Starts("Scores")) return "cutting";
  return "extreme";
}

struct Section {
  const char* id;
  const char* title;
  const char* text;
};
constexpr Section kSections[] = {
    {"figures", "What the default law reaches",
     "The gated Maxwell coupling joins the tip to the cutting front by a spring Kc; the front "
     "moves through tissue, held back while the force is still below B v."},
    {"laws", "Error against run time",
     "Every law with every estimator it can use, in four hands. An error is against the analytic B "
     "v, for force and impedance hands against B V of the cutting front. A law is chosen for more "
     "than "
     "its steady error: each figure has its own front (filled blue: nothing is both cheaper and "
     "better in it); what is undominated over all figures together is ringed green."},
    {"random", "Random cases, one parameter set",
     "Device, B, speed, direction, friction, hand and its mass are drawn. Speeds are drawn "
     "uniformly, then "
     "logarithmically, which favours the slow cuts where counts are rare."},
    {"extreme", "Stiff and extreme",
     "Each cell is simulated past what a profile would accept. Passive: the theorem covers it and "
     "no balance fell under its floor. Stable with these grips: nothing swung, nothing is proved."},
    {"adversary", "Adversary",
     "A search for energy: it chooses the motion, the material and the walls tick by tick."},
    {"cutting", "Cutting: error against run time",
     "What a voxel size costs and what it is worth: burs against the bodies they sweep, and the "
     "score "
     "of one hand at every voxel size."},
    {"estimators", "Velocity estimators", ""},
    {"paper", "The paper's tables beside ours",
     "Liu, Zhang, Wang, Townsend, Virtual Reality 12:99-106 (2008)."},
};

}  // namespace

std::string TextOf(const Table& t) {
  std::vector<size_t> widths(t.head.size(), 0);
  auto Fit = [&](const std::vector<std::string>& row) {
    for (size_t i = 0; i < row.size() && i < widths.size(); ++i)
      widths[i] = std::max(widths[i], Width(row[i]));
  };
  Fit(t.head);
  for (const auto& row : t.rows) Fit(row);
  auto Print = [&](const std::vector<std::string>& row) {
    std::string s;
    for (size_t i = 0; i < row.size(); ++i)
      s += row[i] + std::string(widths[i] - Width(row[i]) + 2, ' ');
    return s.substr(0, s.find_last_not_of(' ') + 1) + "\n";
  };
  std::string s = t.title + "\n" + Print(t.head);
  for (const auto& row : t.rows) s += Print(row);
  if (!t.note.empty()) s += t.note + "\n";
  return s + "\n";
}

std::vector<std::pair<std::string, std::string>> PlotsOf(const Findings& f) {
  std::vector<std::pair<std::string, std::string>> out;
  for (Named& p : AllPlots(f)) out.push_back({std::move(p.file), std::move(p.svg)});
  return out;
}

std::string HtmlOf(const Findings& f) {
  std::string devices;
  for (const DeviceModel& m : f.models) devices += (devices.empty() ? "" : ", ") + m.title;
  std::string s =
      "<!doctype html><html lang=en><head><meta charset=utf-8><meta name=viewport "
      "content='width=device-width,initial-scale=1'><title>Qualification: " +
      Escaped(devices) + "</title><style>" + kCss +
      "</style></head><body><main><h1>Haptic qualification</h1><p class=sub>" + Escaped(devices) +
      (f.quick ? " · quick" : "") + " · seed " + std::to_string(f.seed) +
      " · simulated device: mass, b, Coulomb c, encoder, zero-order hold</p>" + Cards(f);
  std::vector<Named> plots = AllPlots(f);
  for (const Section& section : kSections) {
    std::string body, frames;
    for (const Table& t : f.tables) {
      if (std::string(SectionOf(t)) == section.id) body += TableHtml(t);
    }
    for (const Named& p : plots) {
      if (p.section == section.id) frames += p.svg;
    }
    if (std::string(section.id) == "random") body += FailuresHtml(f);
    if (body.empty() && frames.empty()) continue;
    s += std::string("<h2 id=") + section.id + ">" + section.title + "</h2>";
    if (*section.text) s += std::string("<p class=note>") + section.text + "</p>";
    if (!frames.empty()) s += "<div class=plots>" + frames + "</div>";
    s += body;
  }
  s += "<h2>Provenance</h2>" + ProvenanceHtml(f);
  return s + "</main></body></html>\n";
}

Status WriteReport(const Findings& f, const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  auto Write = [&](const std::string& name, const std::string& text) -> Status {
    std::filesystem::path path = std::filesystem::path(folder) / name;
    std::ofstream out(path, std::ios::binary);
    out << text;
    out.close();
    if (!out)
      return {
          Code::kStorage,
          "cannot write " + path.string() + ": choose a folder that can be written with --report",
          "report"};
    return Status::Ok();
  };
  ENAMEL_RETURN_IF_ERROR(Write("report.html", HtmlOf(f)));
  ENAMEL_RETURN_IF_ERROR(Write("qualification.json", JsonOf(f)));
  for (const auto& [name, svg] : PlotsOf(f)) ENAMEL_RETURN_IF_ERROR(Write(name + ".svg", svg));
  return Status::Ok();
}

}  // namespace enamel::station::lab
