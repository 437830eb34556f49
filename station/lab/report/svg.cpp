#include "station/lab/report/svg.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace enamel::station::lab {
namespace {

constexpr double kLegend = 232;  // column on the right
constexpr double kLeft = 62, kRight = 18, kTop = 34, kBottom = 46;

std::string Num(double v, const char* format = "%.6g") {
  char text[48];
  std::snprintf(text, sizeof text, format, v);
  return text;
}

// Data to page, linear or logarithmic.
struct Axis {
  double lo = 0, hi = 1, from = 0, to = 1;
  bool log = false;
  double At(double v) const {
    double share = log ? std::log(v / lo) / std::log(hi / lo) : (v - lo) / (hi - lo);
    return from + std::clamp(share, 0.0, 1.0) * (to - from);
  }
  std::vector<double> Ticks() const {
    std::vector<double> out;
    if (log) {
      int first = static_cast<int>(std::ceil(std::log10(lo) - 1e-9)),
          last = static_cast<int>(std::floor(std::log10(hi) + 1e-9));
      int step = std::max(1, (last - first) / 7);
      for (int e = first; e <= last; e += step) out.push_back(std::pow(10, e));
      if (out.size() < 3) {
        out.clear();
        for (int e = first - 1; e <= last + 1; ++e) {
          for (double m : {1.0, 2.0, 3.0, 5.0}) {
            double v = m * std::pow(10, e);
            if (v >= lo && v <= hi) out.push_back(v);
          }
        }
      }
      return out;
    }
    double raw = (hi - lo) / 6, base = std::pow(10, std::floor(std::log10(raw))), step = base;
    for (double m : {1.0, 2.0, 5.0, 10.0}) {
      if (base * m >= raw) {
        step = base * m;
        break;
      }
    }
    for (double v = std::ceil(lo / step) * step; v <= hi + 1e-9 * step; v += step)
      out.push_back(std::fabs(v) < 1e-12 * step ? 0 : v);
    return out;
  }
};

std::string Line(double x1, double y1, double x2, double y2, const char* style) {
  return "<line x1='" + Num(x1) + "' y1='" + Num(y1) + "' x2='" + Num(x2) + "' y2='" + Num(y2) +
         "' " + style + "/>";
}
std::string Label(double x, double y, const std::string& text, const char* style) {
  return "<text x='" + Num(x) + "' y='" + Num(y) + "' " + style + ">" + Escaped(text) + "</text>";
}

std::string Frame(const std::string& title, const std::string& x_label, const std::string& y_label,
                  const Axis& x, const Axis& y, double w, double h) {
  std::string s = "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 " + Num(w) + " " + Num(h) +
                  "' width='" + Num(w) + "' height='" + Num(h) +
                  "' font-family='system-ui,sans-serif' font-size='11' role='img' aria-label='" +
                  Escaped(title) + "'>";
  s += "<rect width='100%' height='100%' fill='#fff'/>" +
       Label(kLeft, 20, title, "font-size='13' font-weight='600' fill='#17242b'");
  for (double v : x.Ticks()) {
    s += Line(x.At(v), y.from, x.At(v), y.to, "stroke='#e4e9ec'");
    s += Label(x.At(v), y.from + 15, Num(v, "%.4g"), "text-anchor='middle' fill='#52626b'");
  }
  for (double v : y.Ticks()) {
    s += Line(x.from, y.At(v), x.to, y.At(v), "stroke='#e4e9ec'");
    s += Label(x.from - 6, y.At(v) + 4, Num(v, "%.4g"), "text-anchor='end' fill='#52626b'");
  }
  s += Line(x.from, y.from, x.to, y.from, "stroke='#7d8b93'") +
       Line(x.from, y.from, x.from, y.to, "stroke='#7d8b93'");
  s += Label((x.from + x.to) / 2, h - 10, x_label, "text-anchor='middle' fill='#17242b'");
  double middle = (y.from + y.to) / 2;
  s += "<text transform='translate(15," + Num(middle) +
       ") rotate(-90)' text-anchor='middle' fill='#17242b'>" + Escaped(y_label) + "</text>";
  return s;
}

std::string Path(const std::vector<std::pair<double, double>>& points, const Axis& x,
                 const Axis& y) {
  std::string d;
  for (auto [px, py] : points)
    d += (d.empty() ? "M" : "L") + Num(x.At(px), "%.1f") + " " + Num(y.At(py), "%.1f");
  return d;
}

const char* Colour(Verdict v) {
  switch (v) {
    case Verdict::kPassive:
      return "#2e8b68";
    case Verdict::kStable:
      return "#a9d4b8";
    case Verdict::kBounded:
      return "#f2c057";
    case Verdict::kUnstable:
      return "#c8493f";
  }
  return "#000";
}

bool HasLegend(const Plot& p) {
  return std::any_of(p.series.begin(), p.series.end(),
                     [](const Series& s) { return !s.label.empty() && !s.labelled; });
}

void Fit(const Plot& p, Axis* x, Axis* y) {
  double x0 = 1e300, x1 = -1e300, y0 = 1e300, y1 = -1e300;
  for (const Series& s : p.series) {
    for (auto [px, py] : s.points) {
      x0 = std::min(x0, px), x1 = std::max(x1, px), y0 = std::min(y0, py), y1 = std::max(y1, py);
    }
  }
  if (x0 > x1) x0 = p.log_x ? 1 : 0, x1 = 10, y0 = p.log_y ? 1 : 0, y1 = 10;  // no points
  if (x0 == x1) x1 = x0 + 1;
  if (y0 == y1) y1 = y0 + 1;
  auto Pad = [](bool log, double* lo, double* hi) {
    if (log) {
      *lo /= 1.3;
      *hi *= 1.6;
    } else {
      double room = 0.05 * (*hi - *lo);
      if (*lo != 0) *lo -= room;
      *hi += room;
    }
  };
  Pad(p.log_x, &x0, &x1);
  Pad(p.log_y, &y0, &y1);
  *x = {x0, x1, kLeft, p.width - (HasLegend(p) ? kLegend : kRight), p.log_x};
  *y = {y0, y1, p.height - kBottom, kTop, p.log_y};
}

std::string Legend(const std::vector<std::pair<std::string, std::string>>& entries, double x,
                   double y) {
  std::string s;
  for (const auto& [label, colour] : entries) {
    s += "<rect x='" + Num(x) + "' y='" + Num(y - 8) + "' width='10' height='10' fill='" + colour +
         "'/>" + Label(x + 15, y + 1, label, "fill='#17242b'");
    y += 16;
  }
  return s;
}

}  // namespace

std::string Escaped(const std::string& text) {
  std::string out;
  for (char c : text) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string SvgOf(const Plot& p) {
  Axis x, y;
  Fit(p, &x, &y);
  std::string s = Frame(p.title, p.x_label, p.y_label, x, y, p.width, p.height);
  std::vector<std::pair<std::string, std::string>> entries;
  int labels = 0;  // beside points: above and below in turn
  for (const Series& line : p.series) {
    if (line.dots) {
      for (auto [px, py] : line.points) {
        s += "<circle cx='" + Num(x.At(px), "%.1f") + "' cy='" + Num(y.At(py), "%.1f") +
             "' r='4' fill='" + (line.hollow ? "none" : line.colour) + "' stroke='" + line.colour +
             "' stroke-width='1.5'/>";
      }
    } else {
      s += "<path d='" + Path(line.points, x, y) + "' fill='none' stroke='" + line.colour +
           "' stroke-width='1.6'" + (line.dashed ? " stroke-dasharray='5 4'" : "") + "/>";
    }
    if (line.labelled && !line.points.empty()) {
      s += Label(x.At(line.points.back().first) + 7,
                 y.At(line.points.back().second) + (labels++ % 2 ? 15 : -7), line.label,
                 "fill='#17242b' font-size='10'");
    } else if (!line.label.empty()) {
      entries.push_back({line.label, line.colour});
    }
  }
  s += Legend(entries, p.width - kLegend + 14, kTop + 12);
  return s + "</svg>";
}

std::string SvgOf(const VerdictMap& map) {
  constexpr double kWidth = 700, kHeight = 380;
  auto Span = [](const std::vector<double>& v, double* half) {
    *half = v.size() > 1 ? std::sqrt(v[1] / v[0]) : 1.5;
    return std::pair{v.front() / *half, v.back() * *half};
  };
  double half_x, half_y;
  auto [x0, x1] = Span(map.x, &half_x);
  // Rows need not be equally spaced (ticks of delay): each reaches half way to its neighbours.
  auto [y0, y1] = Span(map.y, &half_y);
  y1 = map.y.size() > 1 ? map.y.back() * std::sqrt(map.y.back() / map.y[map.y.size() - 2]) : y1;
  Axis x{x0, x1, kLeft, kWidth - kLegend, true}, y{y0, y1, kHeight - kBottom, kTop, true};
  std::string s = Frame(map.title, map.x_label, map.y_label, x, y, kWidth, kHeight);
  for (size_t j = 0; j < map.y.size(); ++j) {
    double top = j + 1 < map.y.size() ? std::sqrt(map.y[j] * map.y[j + 1]) : y1,
           bottom = j > 0 ? std::sqrt(map.y[j] * map.y[j - 1]) : y0;
    for (size_t i = 0; i < map.x.size(); ++i) {
      double left = x.At(map.x[i] / half_x), right = x.At(map.x[i] * half_x);
      s += "<rect x='" + Num(left, "%.1f") + "' y='" + Num(y.At(top), "%.1f") + "' width='" +
           Num(right - left - 0.8, "%.1f") + "' height='" +
           Num(y.At(bottom) - y.At(top) - 0.8, "%.1f") + "' fill='" +
           Colour(map.cells[j * map.x.size() + i]) + "'/>";
    }
  }
  constexpr const char* kInk[] = {"#17242b", "#5b3fa0", "#1f6f8b"};
  std::vector<std::pair<std::string, std::string>> entries;
  for (Verdict v : {Verdict::kPassive, Verdict::kStable, Verdict::kBounded, Verdict::kUnstable})
    entries.push_back({VerdictName(v), Colour(v)});
  size_t ink = 0;
  for (const auto& curve : map.curves) {
    const char* colour = kInk[ink++ % 3];
    s += "<path d='" + Path(curve.points, x, y) + "' fill='none' stroke='" + colour +
         "' stroke-width='2.2' stroke-dasharray='6 3'/>";
    entries.push_back({curve.label, colour});
  }
  return s + Legend(entries, kWidth - kLegend + 12, kTop + 12) + "</svg>";
}

}  // namespace enamel::station::lab
