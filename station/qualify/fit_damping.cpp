#include "station/qualify/fit_damping.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>

#include "common/base/file.h"
#include "common/math/vec.h"
#include "common/program/log.h"
#include "common/scene/json_text.h"
#include "station/qualify/csv.h"
#include "station/qualify/svg.h"

namespace enamel::station::qualify {
namespace {

constexpr size_t kLargestFile = size_t{1} << 28;

constexpr double kBlock_s = 0.05;
constexpr double kContact_n = 0.02;
constexpr size_t kLeastBlocks = 8;

Status Refuse(const std::string& what, const std::string& field = {}) {
  return {Code::kInvalidInput, what, field};
}

std::string F(double v, const char* format = "%.3f") {
  char text[64];
  std::snprintf(text, sizeof text, format, v);
  return text;
}

struct Sample3 {
  double t_s = 0;
  dvec3 x_mm{0}, f_n{0};
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

// A quantity of one or three columns with the unit its names carry.
struct Columns {
  std::vector<size_t> at;
  double to_unit = 0;  // 0: not said
  explicit operator bool() const { return !at.empty(); }
};

class Header {
 public:
  explicit Header(const CsvRow& row) {
    for (size_t i = 0; i < row.size(); ++i) columns_.emplace(Plain(row[i]), i);
  }
  Columns Find(const std::vector<std::vector<std::string>>& stems,
               const std::vector<std::pair<std::string, double>>& suffixes) const {
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
  Columns time, position, force, tissue;
};

Result<Layout> LayoutOf(const CsvRow& head) {
  Header h(head);
  Layout l;
  l.time = h.Find({{"time"}, {"t"}}, {{"_s", 1}, {"_ms", 1e-3}, {"_us", 1e-6}, {"", 1}});
  l.position =
      h.Find({{"x", "y", "z"}, {"px", "py", "pz"}, {"position"}, {"pos"}, {"depth"}, {"x"}},
             {{"_mm", 1}, {"_m", 1e3}, {"_um", 1e-3}, {"", 0}});
  l.force = h.Find({{"fx", "fy", "fz"}, {"force_x", "force_y", "force_z"}, {"force"}, {"f"}},
                   {{"_n", 1}, {"_mn", 1e-3}, {"", 1}});
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
    return i < row.size() ? row[i] : std::string();
  };
  for (size_t i = 1; i < rows.size(); ++i) {
    Sample3 s;
    bool ok = ParseNumber(Cell(rows[i], l.time.at[0]), &s.t_s);
    s.t_s *= l.time.to_unit;
    for (size_t k = 0; k < l.position.at.size(); ++k)
      ok = ok && ParseNumber(Cell(rows[i], l.position.at[k]), &s.x_mm[static_cast<int>(k)]);
    for (size_t k = 0; k < l.force.at.size(); ++k)
      ok = ok && ParseNumber(Cell(rows[i], l.force.at[k]), &s.f_n[static_cast<int>(k)]);
    if (!ok) {
      ++*skipped;
      continue;
    }
    s.f_n *= l.force.to_unit;
    if (l.tissue) s.tissue = Cell(rows[i], l.tissue.at[0]);
    if (!out.empty() && s.t_s <= out.back().t_s) {
      return Refuse("time does not rise in row " + std::to_string(i + 1) + ": " +
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

struct Block {
  double t_s;
  dvec3 x_mm, f_n;
};

// Averages over blocks of whole samples; a gap or another tissue starts a new run.
std::vector<std::vector<Block>> BlocksOf(const std::vector<Sample3>& samples,
                                         const std::string& tissue, double dt) {
  size_t per = std::max<size_t>(2, static_cast<size_t>(std::lround(kBlock_s / dt)));
  std::vector<std::vector<Block>> runs;
  std::vector<const Sample3*> open;
  const Sample3* last = nullptr;
  for (const Sample3& s : samples) {
    bool mine = tissue.empty() || s.tissue == tissue;
    bool joins = mine && last != nullptr && s.t_s - last->t_s < 3 * dt;
    if (!joins) {
      open.clear();
      if (mine) runs.emplace_back();
    }
    last = mine ? &s : nullptr;
    if (!mine) continue;
    open.push_back(&s);
    if (open.size() < per) continue;
    Block b{0, dvec3(0), dvec3(0)};
    for (const Sample3* q : open) {
      b.t_s += q->t_s / static_cast<double>(per);
      b.x_mm += q->x_mm / static_cast<double>(per);
      b.f_n += q->f_n / static_cast<double>(per);
    }
    runs.back().push_back(b);
    open.clear();
  }
  return runs;
}

// Two-sided 97.5 % point of Student's t (Hill 1970's expansion about the normal; below 1 % off from
// 3 degrees of freedom).
double Student975(double n) {
  constexpr double z = 1.959964;
  double z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z;
  return z + (z3 + z) / (4 * n) + (5 * z5 + 16 * z3 + 3 * z) / (96 * n * n) +
         (3 * z7 + 19 * z5 + 17 * z3 - 15 * z) / (384 * n * n * n);
}

void Regress(DampingFit* fit) {
  const auto& p = fit->points;
  double n = static_cast<double>(p.size()), sv = 0, sf = 0, svv = 0, svf = 0, low = 1e300, high = 0;
  for (auto [v, f] : p) {
    sv += v, sf += f, svv += v * v, svf += v * f;
    low = std::min(low, v), high = std::max(high, v);
  }
  bool offset = high > 2 * low;
  double var = offset ? svv - sv * sv / n : svv;
  fit->b_n_s_per_mm = (offset ? svf - sv * sf / n : svf) / var;
  fit->offset_n = offset ? (sf - fit->b_n_s_per_mm * sv) / n : 0;
  double rss = 0, lag = 0, before = 0;
  for (size_t i = 0; i < p.size(); ++i) {
    double r = p[i].second - fit->b_n_s_per_mm * p[i].first - fit->offset_n;
    rss += r * r;
    if (i > 0) lag += r * before;
    before = r;
  }
  double freedom = n - (offset ? 2 : 1);
  fit->residual_rms_n = std::sqrt(rss / freedom);
  double rho = rss > 0 ? std::clamp(lag / rss, 0.0, 0.95) : 0;
  double independent = std::max(2.0, freedom * (1 - rho) / (1 + rho));
  double error = std::sqrt(rss / freedom / var * freedom / independent);
  double half = Student975(independent) * error;
  fit->b_low = fit->b_n_s_per_mm - half;
  fit->b_high = fit->b_n_s_per_mm + half;
}

DampingFit FitTissue(const std::vector<Sample3>& samples, const std::string& tissue, double dt) {
  DampingFit fit;
  fit.tissue = tissue.empty() ? "all" : tissue;
  for (const Sample3& s : samples) fit.samples += tissue.empty() || s.tissue == tissue;
  struct Pair {
    double v, f;
  };
  std::vector<Pair> pairs;
  for (const auto& run : BlocksOf(samples, tissue, dt)) {
    for (size_t i = 1; i < run.size(); ++i) {
      dvec3 v = (run[i].x_mm - run[i - 1].x_mm) / (run[i].t_s - run[i - 1].t_s),
            f = (run[i].f_n + run[i - 1].f_n) * 0.5;
      double speed = glm::length(v);
      // A single force column is a magnitude along the cut; three are projected on the motion.
      double along = f.y == 0 && f.z == 0 ? std::fabs(f.x)
                     : speed > 0          ? std::fabs(Dot(f, v)) / speed
                                          : glm::length(f);
      pairs.push_back({speed, along});
      fit.speed_max_mm_s = std::max(fit.speed_max_mm_s, speed);
      fit.force_max_n = std::max(fit.force_max_n, along);
    }
  }
  if (fit.speed_max_mm_s < 1e-3) {
    fit.refused = "no motion: the fastest block moves at " + F(fit.speed_max_mm_s, "%.2g") +
                  " mm/s; record while cutting";
    return fit;
  }
  if (fit.speed_max_mm_s > 1000) {
    fit.refused = "a speed of " + F(fit.speed_max_mm_s, "%.4g") +
                  " mm/s: expected below 1 m/s; check the units of position and time";
    return fit;
  }
  if (fit.force_max_n < kContact_n) {
    fit.refused = "no contact: the largest force is " + F(fit.force_max_n, "%.3g") +
                  " N; expected above " + F(kContact_n, "%.2f") + " N";
    return fit;
  }
  double touch = std::max(kContact_n, 0.05 * fit.force_max_n), move = 0.05 * fit.speed_max_mm_s;
  for (const Pair& p : pairs) {
    if (p.f >= touch && p.v >= move) fit.points.push_back({p.v, p.f});
  }
  fit.used = fit.points.size();
  if (fit.used < kLeastBlocks) {
    fit.refused =
        "only " + std::to_string(fit.used) + " blocks of " + F(std::max(kBlock_s, 2 * dt), "%.2f") +
        " s are in contact and moving; at least " + std::to_string(kLeastBlocks) + " are needed";
    return fit;
  }
  Regress(&fit);
  if (fit.b_high <= 0)
    fit.refused = "force falls with speed (B = " + F(fit.b_n_s_per_mm) +
                  " N s/mm): position and force do not belong together, or not in this unit";
  return fit;
}

}  // namespace

Result<DampingReport> FitDamping(std::string_view csv) {
  Result<std::vector<CsvRow>> rows = ParseCsv(csv);
  if (!rows.ok()) return rows.status();
  if (rows->empty())
    return Refuse("the file is empty: expected a line of column names and rows of numbers");
  Result<Layout> layout = LayoutOf(rows->front());
  if (!layout.ok()) return layout.status();
  size_t skipped = 0;
  Result<std::vector<Sample3>> samples = SamplesOf(*rows, *layout, &skipped);
  if (!samples.ok()) return samples.status();
  DampingReport report;
  if (skipped > 0)
    report.notes.push_back(std::to_string(skipped) + " rows without numbers were left out");
  ENAMEL_RETURN_IF_ERROR(SettleUnits(&*samples, layout->position.to_unit, &report));
  std::vector<double> steps;
  for (size_t i = 1; i < samples->size(); ++i)
    steps.push_back((*samples)[i].t_s - (*samples)[i - 1].t_s);
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2),
                   steps.end());
  double dt = steps[steps.size() / 2];
  if (dt > 1)
    return Refuse("samples are " + F(dt, "%.3g") +
                      " s apart: expected at least one a second; check the unit of time (time_ms "
                      "for milliseconds)",
                  "time_s");
  report.rate_hz = 1 / dt;
  std::vector<std::string> tissues;
  for (const Sample3& s : *samples) {
    if (layout->tissue && !s.tissue.empty() &&
        std::find(tissues.begin(), tissues.end(), s.tissue) == tissues.end())
      tissues.push_back(s.tissue);
  }
  if (tissues.empty()) tissues.push_back("");
  if (tissues.size() > 64) return Refuse("more than 64 tissues in the tissue column", "tissue");
  for (const std::string& tissue : tissues) report.fits.push_back(FitTissue(*samples, tissue, dt));
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
    s += "B = " + F(f.b_n_s_per_mm) + " N s/mm, 95 % " + F(f.b_low) + " to " + F(f.b_high) +
         ", offset " + F(f.offset_n) + " N, residual " + F(f.residual_rms_n) + " N rms, " +
         std::to_string(f.used) + " blocks of " + std::to_string(f.samples) + " samples\n";
  }
  return s;
}

std::string DampingPlot(const DampingReport& r) {
  constexpr const char* kInk[] = {"#1f6f8b", "#c8493f", "#5b3fa0", "#b07a12", "#2e8b68", "#7d8b93"};
  Plot p;
  p.title = "Cutting force against speed";
  p.x_label = "speed, mm/s";
  p.y_label = "force along the motion, N";
  p.width = 760;
  p.height = 420;
  size_t i = 0;
  for (const DampingFit& f : r.fits) {
    if (!f.refused.empty()) continue;
    const char* ink = kInk[i++ % std::size(kInk)];
    p.series.push_back({"", f.points, ink, true, true});
    Series line{f.tissue + ": B = " + F(f.b_n_s_per_mm, "%.2f") + " N s/mm", {}, ink};
    for (double v : {0.0, f.speed_max_mm_s})
      line.points.push_back({v, f.offset_n + f.b_n_s_per_mm * v});
    p.series.push_back(line);
  }
  return SvgOf(p);
}

std::string MaterialText(const DampingReport& r, const std::string& source) {
  namespace json = boost::json;
  auto Milli = [](double v) { return std::llround(v * 1e3); };
  json::array tissues;
  for (const DampingFit& f : r.fits) {
    if (!f.refused.empty()) continue;
    tissues.push_back(json::object{
        {"tissue", f.tissue},
        {"damping_mn_s_per_mm", Milli(f.b_n_s_per_mm)},
        {"provenance", "fitted from " + source + ": " + std::to_string(f.used) + " blocks, 95 % " +
                           F(f.b_low) + " to " + F(f.b_high) + " N s/mm"},
        {"damping_low_mn_s_per_mm", Milli(f.b_low)},
        {"damping_high_mn_s_per_mm", Milli(f.b_high)},
        {"offset_mn", Milli(f.offset_n)},
        {"residual_rms_mn", Milli(f.residual_rms_n)},
        {"blocks", f.used}});
  }
  return scene::CanonicalText(json::object{{"format", 1},
                                           {"source", source},
                                           {"rate_mhz", Milli(r.rate_hz)},
                                           {"tissues", std::move(tissues)}});
}

int RunFitDamping(const FitDampingOptions& options) {
  auto Fail = [](const std::string& why) {
    program::SayError("fit-damping: " + why);
    return 1;
  };
  Result<Bytes> text = ReadFile(options.csv_path, kLargestFile);
  if (!text.ok()) return Fail(text.status().message());
  Result<DampingReport> report =
      FitDamping({reinterpret_cast<const char*>(text->data()), text->size()});
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
  if (!Write(options.svg_path, DampingPlot(*report))) return 1;
  bool any = std::any_of(report->fits.begin(), report->fits.end(),
                         [](const DampingFit& f) { return f.refused.empty(); });
  if (!any) return Fail("no tissue could be fitted; nothing is stored");
  std::string source = std::filesystem::path(options.csv_path).filename();
  return Write(options.material_path, MaterialText(*report, source)) ? 0 : 1;
}

}  // namespace enamel::station::qualify
