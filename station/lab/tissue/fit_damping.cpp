#include "station/lab/tissue/fit_damping.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>

#include "common/base/csv.h"
#include "common/base/file.h"
#include "common/math/vec.h"
#include "common/program/log.h"
#include "common/scene/json/kinds.h"
#include "common/scene/json/text.h"
#include "common/scene/json/tissue.h"
#include "station/lab/report/draw.h"
#include "station/lab/report/plot.h"

namespace enamel::station::lab {
namespace {

using Cells = std::vector<std::string>;

constexpr size_t kLargestFile = size_t{1} << 28;

Status Refuse(const std::string& what, const std::string& field = {}) {
  return {Code::kInvalidInput, what, field};
}

struct Sample3 {
  double t_s = 0;
  dvec3 x_mm{0}, f_n{0}, axis{0};
  std::string tissue;
};

std::string Plain(const std::string& s) {
  std::string out;
  for (char c : s) {
    if (c != ' ' && c != '\t')
      out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return out;
}

bool ParseNumber(const std::string& text, double* v) {
  size_t from = text.find_first_not_of(" \t"), to = text.find_last_not_of(" \t");
  if (from == std::string::npos) return false;
  const char* first = text.data() + from + (text[from] == '+' ? 1 : 0);
  auto [end, error] = std::from_chars(first, text.data() + to + 1, *v);
  return error == std::errc() && end == text.data() + to + 1 && std::isfinite(*v);
}

// A quantity of one or three columns with the unit in their names.
struct Columns {
  std::vector<size_t> at;
  double to_unit = 0;  // 0: not said
  explicit operator bool() const { return !at.empty(); }
};

class Header {
 public:
  explicit Header(const Cells& row) {
    for (size_t i = 0; i < row.size(); ++i) columns_.emplace(Plain(row[i]), i);
  }
  Columns Find(const std::vector<std::vector<std::string>>& stems,
               const std::vector<std::pair<std::string, double>>& suffixes) const {
    // In the order of preference: three columns before one, names with a unit before bare ones.
    for (const auto& stem : stems) {
      for (const auto& [suffix, to_unit] : suffixes) {
        Columns c{{}, to_unit};
        for (const std::string& name : stem) {
          auto found = columns_.find(name + suffix);
          if (found == columns_.end()) break;
          c.at.push_back(found->second);
        }
        if (c.at.size() == stem.size()) return c;
      }
    }
    return {};
  }

 private:
  std::map<std::string, size_t> columns_;
};

struct Layout {
  Columns time, position, force, axis, tissue;
};

Result<Layout> LayoutOf(const Cells& head) {
  Header h(head);
  Layout l;
  l.time = h.Find({{"time"}, {"t"}}, {{"_s", 1}, {"_ms", 1e-3}, {"_us", 1e-6}, {"", 1}});
  l.position =
      h.Find({{"x", "y", "z"}, {"px", "py", "pz"}, {"position"}, {"pos"}, {"depth"}, {"x"}},
             {{"_mm", 1}, {"_m", 1e3}, {"_um", 1e-3}, {"", 0}});
  l.force = h.Find({{"fx", "fy", "fz"}, {"force_x", "force_y", "force_z"}, {"force"}, {"f"}},
                   {{"_n", 1}, {"_mn", 1e-3}, {"", 1}});
  l.axis = h.Find({{"axis_x", "axis_y", "axis_z"}, {"bur_x", "bur_y", "bur_z"}}, {{"", 1}});
  l.tissue = h.Find({{"tissue"}, {"material"}}, {{"", 1}});
  std::string found;
  for (const std::string& name : head) found += (found.empty() ? "" : ", ") + name;
  if (!l.time) return Refuse("expected a column time_s; found: " + found, "time_s");
  if (!l.position)
    return Refuse("expected a column position_mm (or x_mm, y_mm, z_mm); found: " + found,
                  "position_mm");
  if (!l.force)
    return Refuse("expected a column force_n (or fx_n, fy_n, fz_n); found: " + found, "force_n");
  return l;
}

Result<std::vector<Sample3>> SamplesOf(const std::vector<CsvRow>& rows, const Layout& l,
                                       size_t* skipped) {
  std::vector<Sample3> out;
  auto Cell = [](const CsvRow& row, size_t i) -> std::string {
    return i < row.cells.size() ? row.cells[i] : std::string();
  };
  for (size_t i = 1; i < rows.size(); ++i) {
    Sample3 s;
    bool ok = ParseNumber(Cell(rows[i], l.time.at[0]), &s.t_s);
    s.t_s *= l.time.to_unit;
    for (size_t k = 0; k < l.position.at.size(); ++k)
      ok = ok && ParseNumber(Cell(rows[i], l.position.at[k]), &s.x_mm[static_cast<int>(k)]);
    for (size_t k = 0; k < l.force.at.size(); ++k)
      ok = ok && ParseNumber(Cell(rows[i], l.force.at[k]), &s.f_n[static_cast<int>(k)]);
    for (size_t k = 0; k < l.axis.at.size(); ++k)
      ok = ok && ParseNumber(Cell(rows[i], l.axis.at[k]), &s.axis[static_cast<int>(k)]);
    if (!ok) {
      ++*skipped;
      continue;
    }
    s.f_n *= l.force.to_unit;
    if (l.tissue) s.tissue = Cell(rows[i], l.tissue.at[0]);
    // Refused instead of sorted: falling times usually mean two recordings in one file.
    if (!out.empty() && s.t_s <= out.back().t_s) {
      return Refuse("time does not rise in row " + std::to_string(rows[i].row) + ": " +
                        F(out.back().t_s, "%.6g") + " s, then " + F(s.t_s, "%.6g") +
                        " s; sort the file or cut it into recordings",
                    "time_s");
    }
    out.push_back(std::move(s));
  }
  if (out.size() < 3)
    return Refuse("expected rows of numbers; found " + std::to_string(out.size()) +
                  " that could be read");
  return out;
}

// Bare position columns: a cut is millimetres long, so an extent below 0.05 is in metres.
Status SettleUnits(std::vector<Sample3>* samples, double to_mm, DampingReport* report) {
  dvec3 low(1e300), high(-1e300);
  double most = 0;
  for (const Sample3& s : *samples) {
    low = glm::min(low, s.x_mm);
    high = glm::max(high, s.x_mm);
    most = std::max(most, glm::length(s.f_n));
  }
  double extent = glm::length(high - low);
  if (to_mm == 0) {
    to_mm = extent < 0.05 ? 1e3 : 1;
    report->notes.push_back(std::string("position has no unit in its name: taken as ") +
                            (to_mm > 1 ? "metres" : "millimetres") + " from its extent of " +
                            F(extent, "%.4g"));
  }
  for (Sample3& s : *samples) s.x_mm *= to_mm;
  extent *= to_mm;
  if (extent > 1000)
    return Refuse("positions span " + F(extent, "%.4g") +
                      " mm: expected a cut, less than 1 m; check the unit of the position column",
                  "position_mm");
  if (most > 200)
    return Refuse("the largest force is " + F(most, "%.4g") +
                      " N: expected less than 200 N; check the unit of the force column",
                  "force_n");
  return Status::Ok();
}

// Samples of one tissue; after another tissue a new run begins.
DampingFit FitTissue(const std::vector<Sample3>& samples, const std::string& tissue, double dt,
                     const Layout& layout) {
  DampingFit fit;
  fit.tissue = tissue.empty() ? "all" : tissue;
  std::vector<CutSample> mine;
  int run = 0;
  bool before = false, both_signs = false;
  double lowest = 0, highest = 0;
  for (const Sample3& s : samples) {
    bool take = tissue.empty() || s.tissue == tissue;
    if (take && !before) ++run;
    before = take;
    if (!take) continue;
    mine.push_back({s.t_s, s.x_mm, s.f_n, s.axis, run});
    lowest = std::min(lowest, s.f_n.x), highest = std::max(highest, s.f_n.x);
  }
  // One force column with one position: with both signs it is a component, with one a magnitude.
  both_signs = lowest < -0.2 * highest && highest > -0.2 * lowest;
  int positions = static_cast<int>(layout.position.at.size());
  bool vector = layout.force.at.size() == 3 ? positions == 3 : positions == 1 && both_signs;
  if (!vector) {
    for (CutSample& s : mine) s.f_n = dvec3(glm::length(s.f_n), 0, 0);
  }
  fit.cut = FitCut(mine, dt, !vector, positions);
  const CutFit& c = fit.cut;
  fit.samples = c.samples;
  fit.used = c.windows.used;
  fit.b_n_s_per_mm = c.b.value, fit.b_low = c.b.low, fit.b_high = c.b.high;
  fit.offset_n = c.offset_n;
  fit.residual_rms_n = c.residual_rms_n;
  fit.speed_max_mm_s = c.speed_max_mm_s, fit.force_max_n = c.force_max_n;
  fit.refused = c.refused;
  if (fit.refused.empty() && c.feeds.size() >= 20) fit.load = FitLoad(c.feeds);
  return fit;
}

std::string Between(const Estimate& e, const char* unit, const char* format = "%.3f") {
  return F(e.value, format) + unit + ", 95 % " + F(e.low, format) + " to " + F(e.high, format);
}

// The law of a tissue that is cut by load, and what its recording does not hold.
std::string LoadText(const LoadFit& f) {
  std::string s = "  exponent   ";
  if (f.exponent_told) {
    const bool root = f.exponent == cutting::FeedExponent::kHalf;
    s += std::string(root ? "1/2" : "1") + "; leaves " + F(f.residual_n) + " N rms, " +
         (root ? "1" : "1/2") + " leaves " + F(f.other_n) + " N\n";
    if (root)
      s += "  by load    " + Between(f.coulomb_n, " N") + ", and at " + F(f.feed_mm_s) + " mm/s " +
           Between(f.at_feed_n, " N") + " more\n";
  } else {
    s += "not told: " + f.why_no_exponent + "\n";
  }
  s += "  friction   ";
  s += f.friction_told ? Between(f.friction, "") + "\n" : "not told: " + f.why_no_friction + "\n";
  return s;
}

}  // namespace

Result<DampingReport> FitDamping(std::string_view csv, const dvec3& bur_axis) {
  const CsvTable table = ReadCsv(
      csv, {.rows = std::numeric_limits<size_t>::max(), .columns = 1000, .cell_bytes = 1 << 20});
  ENAMEL_RETURN_IF_ERROR(table.status());
  const std::vector<CsvRow>& rows = table.rows;
  if (rows.empty())
    return Refuse("the file is empty: expected a line of column names and rows of numbers");
  ENAMEL_ASSIGN_OR_RETURN(Layout layout, LayoutOf(rows.front().cells));
  size_t skipped = 0;
  ENAMEL_ASSIGN_OR_RETURN(std::vector<Sample3> samples, SamplesOf(rows, layout, &skipped));
  DampingReport report;
  if (skipped > 0)
    report.notes.push_back(std::to_string(skipped) + " rows without numbers were left out");
  ENAMEL_RETURN_IF_ERROR(SettleUnits(&samples, layout.position.to_unit, &report));
  if (!layout.axis) {
    for (Sample3& s : samples) s.axis = bur_axis;
  }
  std::vector<double> steps;
  for (size_t i = 1; i < samples.size(); ++i) steps.push_back(samples[i].t_s - samples[i - 1].t_s);
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2),
                   steps.end());
  // The median: missing rows do not lower the rate.
  double dt = steps[steps.size() / 2];
  if (dt > 1)
    return Refuse("samples are " + F(dt, "%.3g") +
                      " s apart: expected at least one a second; check the unit of time (time_ms "
                      "for milliseconds)",
                  "time_s");
  report.rate_hz = 1 / dt;
  std::vector<std::string> tissues;
  for (const Sample3& s : samples) {
    if (layout.tissue && !s.tissue.empty() &&
        std::find(tissues.begin(), tissues.end(), s.tissue) == tissues.end())
      tissues.push_back(s.tissue);
  }
  if (tissues.empty()) tissues.push_back("");
  // Otherwise a column of numbers mistaken for names would be fitted for minutes.
  if (tissues.size() > 64) return Refuse("more than 64 tissues in the tissue column", "tissue");
  for (const std::string& tissue : tissues)
    report.fits.push_back(FitTissue(samples, tissue, dt, layout));
  return report;
}

std::string DampingText(const DampingReport& r) {
  std::string s = "rate " + F(r.rate_hz, "%.1f") + " Hz\n";
  for (const std::string& note : r.notes) s += "note: " + note + "\n";
  for (const DampingFit& f : r.fits) {
    s += f.tissue + ": ";
    if (!f.refused.empty()) {
      s += "not fitted: " + f.refused + "\n";
      continue;
    }
    const CutFit& c = f.cut;
    s += "\n";
    if (c.model == CutModel::kMatrix) {
      constexpr const char* kEntry[] = {"xx", "yy", "zz", "xy", "xz", "yz"};
      for (int j = 0; j < 6; ++j)
        s += std::string("  B ") + kEntry[j] + "       " + Between(c.matrix[j], " N s/mm") + "\n";
      s += "  eigenvalues " + F(c.principal[0]) + ", " + F(c.principal[1]) + ", " +
           F(c.principal[2]) + " N s/mm, mean " + Between(c.b, " N s/mm") + "\n";
    } else if (c.model == CutModel::kAxialLateral) {
      s += "  B across the bur " + Between(c.b, " N s/mm") + "\n";
      s += "  B along the bur  " + Between(c.axial, " N s/mm") + "\n";
    } else {
      s += "  B          " + Between(c.b, " N s/mm") + "\n";
    }
    if (c.with_coulomb) {
      s += "  Coulomb    " + Between(c.coulomb_n, " N") + "\n";
      s += c.threshold_seen ? "  threshold  " + Between(c.threshold_n, " N") + "\n"
                            : "  threshold  not seen; below " + F(c.threshold_n.high) + " N\n";
    }
    if (c.compliance_mm_per_n.value > 0)
      s += "  tip bends  " + Between(c.compliance_mm_per_n, " mm/N", "%.5f") + "\n";
    if (f.load) s += LoadText(*f.load);
    s += "  residual   " + F(c.residual_rms_n) + " N rms; windows of " + F(c.window_s) +
         " s: " + std::to_string(c.windows.used) +
         " used; left out: " + std::to_string(c.windows.gap) + " with rows missing, " +
         std::to_string(c.windows.air) + " in air, " + std::to_string(c.windows.slow) +
         " stuck or slow, " + std::to_string(c.windows.turning) + " turning, " +
         std::to_string(c.windows.outlier) + " outliers; " + std::to_string(c.samples) +
         " samples, " + std::to_string(c.spikes) + " of them spikes and dropped\n";
    s += "  bias       noise of speed " + F(c.speed_noise_mm_s) + " mm/s would take " +
         F(100 * c.attenuation, "%.2f") + " % of B (put back); turning hides at most " +
         F(100 * c.turn_bias, "%.2f") + " % of Coulomb's part; condition number " +
         F(c.condition, "%.0f") + "\n";
    for (const std::string& w : c.warnings) s += "  warning: " + w + "\n";
  }
  return s;
}

std::string DampingPlot(const DampingReport& r, const std::string& source) {
  Plot p{.title = "Cutting force against speed",
         .x_label = "speed, mm/s",
         .y_label = "force along the motion, N"};
  size_t i = 0;
  for (const DampingFit& f : r.fits) {
    if (!f.refused.empty()) continue;
    const std::string colour = ColourOf(i++);
    Series rings{"", colour, Style::kRings, {}};
    for (const CutPoint& at : f.cut.points) rings.points.push_back({at.speed_mm_s, at.force_n});
    p.series.push_back(rings);
    const bool root = f.load && f.load->exponent == cutting::FeedExponent::kHalf;
    Series line{f.tissue + ": " +
                    (root ? "by load, m 1/2" : "B = " + F(f.b_n_s_per_mm, "%.2f") + " N s/mm"),
                colour, Style::kLine};
    constexpr int kSteps = 24;
    for (int at = root ? 0 : kSteps - 1; at <= kSteps; ++at) {
      const double v = root ? f.speed_max_mm_s * at / kSteps : at == kSteps ? f.speed_max_mm_s : 0;
      line.points.push_back({v, root
                                    ? f.load->coulomb_n.value +
                                          f.load->at_feed_n.value * std::sqrt(v / f.load->feed_mm_s)
                                    : f.offset_n + f.b_n_s_per_mm * v});
    }
    p.series.push_back(line);
  }
  namespace json = boost::json;
  json::object section{{"title", p.title},
                       {"text",
                        "Rings: windows of the recording. Lines: the fit, F = Fc + B v, or the "
                        "root of v where the recording tells it."},
                       {"tables", json::array()},
                       {"plots", json::array{PlotJson(p)}},
                       {"maps", json::array()}};
  json::object report{{"format", 1},
                      {"title", "Damping fitted from " + source},
                      {"cards", json::array()},
                      {"sections", json::array{std::move(section)}},
                      {"sources", json::array()}};
  return json::serialize(json::object{{"report", std::move(report)}});
}

std::string MaterialText(const DampingReport& r, const std::string& source) {
  namespace json = boost::json;
  auto Milli = [](double v) { return std::llround(v * 1e3); };
  json::array tissues;
  for (const DampingFit& f : r.fits) {
    if (!f.refused.empty()) continue;
    const CutFit& c = f.cut;
    scene::TissueSpec law;
    law.damping_mn_s_per_mm = static_cast<int32_t>(Milli(f.b_n_s_per_mm));
    json::object fit{{"damping_low_mn_s_per_mm", Milli(f.b_low)},
                     {"damping_high_mn_s_per_mm", Milli(f.b_high)},
                     {"offset_mn", Milli(f.offset_n)},
                     {"residual_rms_mn", Milli(f.residual_rms_n)},
                     {"blocks", f.used}};
    auto Put = [&](const std::string& name, const Estimate& e, const std::string& unit) {
      fit[name + "_low" + unit] = Milli(e.low);
      fit[name + "_high" + unit] = Milli(e.high);
      return static_cast<int32_t>(Milli(e.value));
    };
    if (c.model == CutModel::kAxialLateral)
      law.axial_damping_mn_s_per_mm = Put("axial_damping", c.axial, "_mn_s_per_mm");
    if (c.model == CutModel::kMatrix) {
      json::array value, low, high;
      for (const Estimate& e : c.matrix) {
        value.push_back(Milli(e.value));
        low.push_back(Milli(e.low));
        high.push_back(Milli(e.high));
      }
      fit["damping_matrix_mn_s_per_mm"] = std::move(value);
      fit["damping_matrix_low_mn_s_per_mm"] = std::move(low);
      fit["damping_matrix_high_mn_s_per_mm"] = std::move(high);
    }
    const bool root = f.load && f.load->exponent == cutting::FeedExponent::kHalf;
    if (root) {
      law.feed_exponent = f.load->exponent;
      law.feed_um_per_s = static_cast<int32_t>(Milli(f.load->feed_mm_s));
      law.damping_mn_s_per_mm =
          static_cast<int32_t>(Milli(f.load->at_feed_n.value / f.load->feed_mm_s));
      // Along the bur as much more as B is.
      if (law.axial_damping_mn_s_per_mm > 0 && c.b.value > 0)
        law.axial_damping_mn_s_per_mm =
            static_cast<int32_t>(std::llround(law.damping_mn_s_per_mm * c.axial.value / c.b.value));
      law.coulomb_mn = Put("coulomb", f.load->coulomb_n, "_mn");
    } else if (c.with_coulomb) {
      law.coulomb_mn = Put("coulomb", c.coulomb_n, "_mn");
    }
    if (f.load && f.load->friction_told) {
      fit["bur_friction_low_permille"] = Milli(f.load->friction.low);
      fit["bur_friction_high_permille"] = Milli(f.load->friction.high);
      law.bur_friction_permille = static_cast<int32_t>(Milli(f.load->friction.value));
    }
    json::object tissue{{"tissue", f.tissue}};
    scene::WriteTissueLaw(law, tissue);
    tissue["provenance"] = "fitted from " + source + ": " + std::to_string(f.used) +
                           " blocks, 95 % " + F(f.b_low) + " to " + F(f.b_high) + " N s/mm";
    tissue["fit"] = std::move(fit);
    tissues.push_back(std::move(tissue));
  }
  return scene::CanonicalText(json::object{{scene::kMaterialKind, scene::kFormat},
                                           {"source", source},
                                           {"rate_mhz", Milli(r.rate_hz)},
                                           {"tissues", std::move(tissues)}});
}

int RunFitDamping(const FitDampingOptions& options) {
  auto Fail = [](const std::string& why) {
    program::SayError("fit-damping: " + why);
    return 1;
  };
  dvec3 axis(0);
  if (!options.bur_axis.empty()) {
    std::string rest = options.bur_axis + ",";
    int k = 0;
    for (size_t at = 0, end; (end = rest.find(',', at)) != std::string::npos; at = end + 1, ++k) {
      if (k > 2 || !ParseNumber(rest.substr(at, end - at), &axis[std::min(k, 2)])) k = 9;
    }
    if (k != 3 || !(glm::length(axis) > 0))
      return Fail("--bur-axis: expected three numbers x,y,z, not all 0; found " + options.bur_axis);
  }
  if (!options.plot_path.empty() && !options.plot_path.ends_with(".html"))
    return Fail("--plot: expected a page's name, as cut.html; found " + options.plot_path);
  Result<Bytes> text = ReadFile(options.csv_path, kLargestFile);
  if (!text.ok()) return Fail(text.status().message());
  Result<DampingReport> report =
      FitDamping({reinterpret_cast<const char*>(text->data()), text->size()}, axis);
  if (!report.ok()) return Fail(report.status().message());
  std::fputs(DampingText(*report).c_str(), stdout);
  auto Write = [&](const std::string& path, const std::string& content) {
    if (path.empty()) return true;
    std::ofstream out(path, std::ios::binary);
    out << content;
    out.close();
    if (!out) Fail("cannot write " + path);
    return static_cast<bool>(out);
  };
  std::string source = std::filesystem::path(options.csv_path).filename();
  if (!options.plot_path.empty()) {
    Status drawn = WriteReport(DampingPlot(*report, source), options.plot_path);
    if (!drawn.ok()) return Fail(drawn.message());
  }
  bool any = std::any_of(report->fits.begin(), report->fits.end(),
                         [](const DampingFit& f) { return f.refused.empty(); });
  if (!any) return Fail("no tissue could be fitted; nothing is stored");
  return Write(options.material_path, MaterialText(*report, source)) ? 0 : 1;
}

}  // namespace enamel::station::lab
