#include "station/lab/report/report.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <map>

#include "station/lab/report/cutting_report.h"
#include "station/lab/report/plot.h"
#include "station/lab/suites/front.h"

namespace enamel::station::lab {
namespace {

namespace json = boost::json;

size_t Width(const std::string& s) {
  return static_cast<size_t>(
      // Characters, not bytes, so that columns line up: 10xxxxxx continues one in UTF-8.
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
  Series others{"holds in every hand", "muted", Style::kDots, {}},
      lost{"cycles or unstable in a hand", "bad", Style::kRings, {}},
      front{"front of this figure", "1", Style::kDots, {}},
      all{"undominated over all figures", "good", Style::kRings, {}};
  Series star{"the default law at 1 kHz", "chosen", Style::kDots, {}};
  std::vector<Series> names;
  for (const LawPoint& q : points) {
    double value = q.figures[metric];
    if (std::isnan(value)) continue;
    // Both ends of a logarithmic axis: 0 and "never" are at its edges.
    std::pair<double, double> at{q.ns_per_tick, std::clamp(value, what.floor, kDrawn)};
    // In the order of importance to a reader: each law is drawn once.
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
      // Each name is a series of one point: the drawer writes a series' label beside it.
      names.push_back({q.name, "1", Style::kRings, {at}, true});
  }
  // The important ones are drawn last: the default on top.
  p.series = {others, lost, all, front};
  for (Series& s : names) p.series.push_back(std::move(s));
  p.series.push_back(star);
  return p;
}

// Every combination: what a tick costs, and how far off its force is in the hand.
Plot JointPlot(const JointFront& f) {
  Plot p;
  p.title = "Joint front on " + f.title + ": voxel, rate, law and estimator";
  p.x_label = "whole tick, us, mean";
  p.y_label = "felt error, share";
  p.log_x = p.log_y = true;
  Series dominated{"dominated, or without a proof", "muted", Style::kDots, {}},
      front{"front", "1", Style::kDots, {}}, tails{"its p99", "1", Style::kRings, {}},
      chosen{"default", "chosen", Style::kDots, {}};
  for (const JointPoint& q : f.points) {
    const std::pair<double, double> at{q.tick.mean_us.value, std::min(q.felt_error, kDrawn)};
    (q.is_default ? chosen : q.on_front ? front : dominated).points.push_back(at);
    if (q.on_front) tails.points.push_back({q.tick.p99_us.value, at.second});
  }
  p.series = {dominated, tails, front, chosen};
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
    s.colour = ColourOf(i++);
    std::sort(s.points.begin(), s.points.end());
    p.series.push_back(s);
  }
  return p;
}

// One for each tissue: felt error over the grip's stiffness, the default law solid with its closed form
// dashed, plain Maxwell dotted, a colour for each rate and delay; the shares that a hand can tell.
std::vector<Plot> FeelPlots(const std::vector<FeelCurve>& curves, const DeviceModel& m) {
  std::vector<Plot> out;
  std::map<std::string, size_t> colours;
  for (const FeelCurve& c : curves) {
    if (c.device != m.name) continue;
    const std::string title = "What a hand can feel on " + m.title + ": " + c.tissue;
    if (out.empty() || out.back().title != title) {
      out.push_back({title, "stiffness of the grip, N/mm", "felt error", true, false, {}});
      const auto& grips = fidelity::kGrips_n_per_m;
      for (double share : fidelity::kShares)
        out.back().series.push_back(
            {F(100 * share, "%.0f") + " %",
             "reference",
             Style::kDashes,
             {{grips[0] * 1e-3, share}, {*std::prev(std::end(grips)) * 1e-3, share}},
             true});
    }
    const std::string name =
        F(c.rate_hz, "%.0f") + " Hz, " + F(c.kc_n_per_mm, "%.1f") + " N/mm" +
        (c.delay_ticks > 0 ? ", " + std::to_string(c.delay_ticks) + " late" : "") +
        (c.calibrated ? "" : ", not calibrated");
    const std::string colour = ColourOf(colours.try_emplace(name, colours.size()).first->second);
    const bool chosen = c.law == haptics::FindLaw(haptics::kDefaultLaw)->name;
    Series law{chosen ? name : "", colour, chosen ? Style::kLine : Style::kDots, {}}, closed = law;
    closed.label = "";
    closed.style = Style::kDashes;
    for (size_t i = 0; i < c.error.size(); ++i) {
      const double grip = fidelity::kGrips_n_per_m[i] * 1e-3;
      law.points.push_back({grip, c.error[i]});
      closed.points.push_back({grip, c.closed_form[i]});
    }
    out.back().series.push_back(std::move(law));
    if (chosen) out.back().series.push_back(std::move(closed));
  }
  return out;
}

Plot RandomPlot(const RandomSummary& r) {
  Plot p;
  p.title = "Share of hands below a difference from plain Maxwell: " + r.title;
  p.x_label = "difference / what is allowed (1 = bound)";
  p.y_label = "share of cases and hands";
  auto Curve = [](std::vector<double> v, double bound, const char* label, size_t n) {
    Series s{label, ColourOf(n), Style::kLine, {}};
    std::sort(v.begin(), v.end());
    for (size_t i = 0; i < v.size(); ++i)
      s.points.push_back(
          // Cut off at two and a half times the bound: farther out only the number matters, which
          // the height shows.
          {std::clamp(v[i] / bound, -2.5, 2.5),
           static_cast<double>(i + 1) / static_cast<double>(v.size())});
    return s;
  };
  p.series = {Curve(r.ripples_n, 0.05, "ripple / 0.05 N", 0),
              Curve(r.errors, 0.01, "felt error / 1 point", 1),
              {"bound", "reference", Style::kDashes, {{1, 0}, {1, 1}}}};
  return p;
}

json::array Cards(const Findings& f) {
  json::array cards;
  auto Add = [&](const std::string& figure, const std::string& text, bool good) {
    cards.push_back(json::object{{"figure", figure}, {"text", text}, {"good", good}});
  };
  double error = 0, force = 0, felt = 0;
  bool any = false;
  for (const Row& r : f.rows) {
    if (r.suite != "figures") continue;
    any = true;
    // A prescribed motion and a held one are different promises, hence two cards.
    (r.hand == "velocity" ? error : force) =
        std::max(r.hand == "velocity" ? error : force, r.m.error_max_n);
    if (r.hand == "velocity") felt = std::max(felt, r.m.felt_error_rms_n);
  }
  if (any) {
    Add(F(felt) + " N",
        "RMS off B v of the force in the hand, the device's friction, damping and inertia in, "
        "velocity "
        "hand, 2.8 N in enamel (bound: what a hand can tell, 7 %)",
        felt < fidelity::kForceShare * 6500 * 0.43e-3);
    Add(F(error) + " N",
        "steady error per axis of the force sent, same cut (bound: encoder's Kc delta/2)",
        error < 0.1);
    Add(F(force) + " N", "worst error with force and impedance hands", force < 0.1);
  }
  int64_t violations = 0, ticks = 0;
  for (const Attack& a : f.attacks) {
    // Laws without a proof are attacked too, and may lose, which breaks no promise.
    if (!a.proved) continue;
    violations += a.violations;
    ticks += a.ticks;
  }
  if (ticks > 0)
    Add(std::to_string(violations),
        "violations of the energy floor in " + F(static_cast<double>(ticks) * 1e-6, "%.1f") +
            " million hostile ticks",
        violations == 0);
  for (const RandomSummary& r : f.random) {
    double share = 100.0 * r.held / std::max(1, r.cases);
    Add(F(share, "%.1f") + " %",
        "of " + std::to_string(r.cases) +
            " random cases are no worse than plain Maxwell in any of four hands; " + r.title,
        share >= 99);
  }
  if (f.integration_error_m > 0)
    Add(F(f.integration_error_m * 1e6, "%.3f") + " um",
        "the simulator's own integration error over a 2 s trial", f.integration_error_m < 1e-6);
  return cards;
}

json::array Sources(const Findings& f) {
  json::array out;
  for (const DeviceModel& m : f.models) {
    json::array numbers;
    for (const auto& [what, source] : m.provenance)
      numbers.push_back(json::object{{"what", what}, {"source", source}});
    out.push_back(json::object{{"title", m.title}, {"numbers", std::move(numbers)}});
  }
  return out;
}

std::vector<Table> Failures(const Findings& f) {
  std::vector<Table> out;
  for (const RandomSummary& r : f.random) {
    Table t;
    t.title = "Cases that miss a bound, " + r.title + ": " + std::to_string(r.cases - r.held) +
              " of " + std::to_string(r.cases) + " (ripple " + std::to_string(r.ripple) +
              ", felt error " + std::to_string(r.error) + ")";
    t.head = {"what, by how much, and what repeats it"};
    for (const std::string& miss : r.misses) t.rows.push_back({miss});
    if (!t.rows.empty()) out.push_back(std::move(t));
  }
  return out;
}

struct Placed {
  std::string section;
  Plot plot;
};

bool OfThePaper(const std::string& title) { return title.rfind("Figure ", 0) == 0; }

std::vector<Placed> AllPlots(const Findings& f) {
  std::vector<Placed> out;
  bool laws =
      std::any_of(f.rows.begin(), f.rows.end(), [](const Row& r) { return r.suite == "laws"; });
  std::map<std::string, Plot> frames;
  std::vector<std::string> order;
  for (const TimeTrace& t : f.traces) {
    Plot& p = frames[t.title];
    if (p.series.empty()) {
      // A map sorts by title; frames are shown in the order of measurement.
      order.push_back(t.title);
      p.title = t.title;
      p.x_label = "time, s";
      p.y_label = "force, N";
    }
    Series s{t.label, ColourOf(p.series.size()), Style::kLine, {}};
    // Laws that oscillate would fill the frame; the paper's figures are drawn whole.
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
      // Once a frame: all its traces belong to one force.
      if (t.title != order[i]) continue;
      p.series.push_back(
          {"B V", "reference", Style::kDashes, {{0, t.target_n}, {end, t.target_n}}});
      break;
    }
    const char* section = OfThePaper(order[i]) ? "paper" : "laws";
    out.push_back({section, std::move(p)});
  }
  for (const DeviceModel& m : f.models) {
    if (!laws) break;
    std::vector<LawPoint> points = LawPointsOf(f.rows, m.name);
    for (size_t k = 0; k < FrontMetrics().size(); ++k) {
      if (!Measured(points, k)) continue;
      out.push_back({"laws", ParetoPlot(points, k, m)});
    }
    // With `quick` there is one rate, which makes no line.
    if (!f.quick) out.push_back({"laws", RatePlot(f, m)});
  }
  for (const JointFront& front : f.fronts) out.push_back({"laws", JointPlot(front)});
  for (const DeviceModel& m : f.models) {
    for (Plot& p : FeelPlots(f.feel, m)) out.push_back({"figures", std::move(p)});
  }
  for (const RandomSummary& r : f.random) out.push_back({"random", RandomPlot(r)});
  for (Plot& p : CuttingPlots(f)) out.push_back({"cutting", std::move(p)});
  return out;
}

// A table's place on the page, by the first words of its title.
const char* SectionOf(const Table& t) {
  auto Starts = [&](const char* with) { return t.title.rfind(with, 0) == 0; };
  // Titles are ours (suites/*.cpp). An unknown one appears under "extreme", where it is noticed.
  if (Starts("Figures of") || Starts("Strokes") || Starts("What a hand can feel") ||
      Starts("Felt") || Starts("Error of the force sent") || Starts("What may not happen") ||
      Starts("What stays safe"))
    return "figures";
  if (Starts("Fronts") || Starts("Joint front")) return "laws";
  if (Starts("The paper") || Starts("Table") || Starts("Device profiles")) return "paper";
  if (Starts("Velocity est")) return "estimators";
  if (Starts("Adversary")) return "adversary";
  if (Starts("Random")) return "random";
  if (Starts("Cutting") || Starts("Scores") || Starts("Order")) return "cutting";
  return "extreme";
}

struct Section {
  const char* id;
  const char* title;
  const char* text;
};
// In the order of the page: conclusions first, their derivation last.
constexpr Section kSections[] = {
    {"figures", "What the default law reaches",
     "Lead Maxwell: a spring joins the tip to the bur, which goes through tissue as force over B. "
     "The spring is stiffer for slow motion than for fast: what that lends to it, it has lost "
     "before."},
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
     "score of one hand at every voxel size. How fast each error falls when its step is halved is "
     "beside it, also of scores, meshes, pictures and simulated devices."},
    {"estimators", "Velocity estimators", ""},
    {"paper", "The paper beside ours",
     "Liu, Zhang, Wang, Townsend, \"Stable haptic interaction using a damping model to implement a "
     "realistic tooth-cutting simulation for dental training\", Virtual Reality 12 (2008) 99-106, "
     "doi:10.1007/s10055-008-0094-x."},
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
    // No blanks at the end of a line: tables are pasted into documents.
    return s.substr(0, s.find_last_not_of(' ') + 1) + "\n";
  };
  std::string s = t.title + "\n" + Print(t.head);
  for (const auto& row : t.rows) s += Print(row);
  if (!t.note.empty()) s += t.note + "\n";
  return s + "\n";
}

json::object ReportOf(const Findings& f) {
  std::string devices;
  for (const DeviceModel& m : f.models) devices += (devices.empty() ? "" : ", ") + m.title;
  const std::vector<Placed> plots = AllPlots(f);
  json::array sections;
  for (const Section& section : kSections) {
    json::array tables, drawn, maps;
    for (const Table& t : f.tables) {
      if (std::string(SectionOf(t)) == section.id) tables.push_back(TableJson(t));
    }
    for (const Placed& p : plots) {
      if (p.section == section.id) drawn.push_back(PlotJson(p.plot));
    }
    if (std::string(section.id) == "random") {
      for (const Table& t : Failures(f)) tables.push_back(TableJson(t));
    }
    if (std::string(section.id) == "extreme") {
      for (const VerdictMap& m : f.maps) maps.push_back(MapJson(m));
    }
    // Suites that were not run leave no empty heading.
    if (tables.empty() && drawn.empty() && maps.empty()) continue;
    sections.push_back(json::object{{"title", section.title},
                                    {"text", section.text},
                                    {"tables", std::move(tables)},
                                    {"plots", std::move(drawn)},
                                    {"maps", std::move(maps)}});
  }
  return {{"format", 1},
          {"title", "Qualification: " + devices + (f.quick ? ", quick" : "") + ", seed " +
                        std::to_string(f.seed)},
          {"cards", Cards(f)},
          {"sections", std::move(sections)},
          {"sources", Sources(f)}};
}

}  // namespace enamel::station::lab
