#include "common/scoring/reasons.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <span>

namespace enamel::scoring {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// The values that earn the most points, and those around them that earn none, as far as the map
// says.
struct Asked {
  double from, to;
  std::optional<double> none_below, none_above;
};
// Open where the map ends on its best share: beyond it nothing more is asked.
Asked AskedFor(const std::vector<scene::RubricPoint>& map) {
  double best = 0;
  for (const auto& p : map) best = std::max(best, p.share);
  size_t first = 0, last = 0;
  while (map[first].share != best) ++first;
  for (size_t i = first; i < map.size() && map[i].share == best; ++i) last = i;
  Asked out{first == 0 ? -kInfinite : map[first].value,
            last + 1 == map.size() ? kInfinite : map[last].value,
            {},
            {}};
  if (best <= 0) return out;
  for (size_t i = 0; i < first; ++i) {
    if (map[i].share == 0) out.none_below = map[i].value;
  }
  for (size_t i = map.size() - 1; i > last; --i) {
    if (map[i].share == 0) out.none_above = map[i].value;
  }
  return out;
}

std::string Digits(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

double AsShown(double value, int digits) {
  const std::string text = Digits(value, digits);
  double out = 0;
  std::from_chars(text.data(), text.data() + text.size(), out);
  return out;
}

std::string Number(double value, std::string_view unit, int digits) {
  return WithUnit(Digits(value, digits), unit);
}
std::string Number(double value, std::string_view unit) {
  return Number(value, unit, UsualDigits(unit));
}

constexpr int kMaxDigits = 4;

int DigitsOfLimit(double limit, std::string_view unit) {
  int digits = UsualDigits(unit);
  while (digits < kMaxDigits && std::fabs(AsShown(limit, digits) - limit) > 1e-9) ++digits;
  return digits;
}

// A value that misses must show as missing, one that does not may show as the limit itself.
int DigitsOfFound(double value, std::span<const double> limits, bool missed,
                  std::string_view unit) {
  const auto misleads = [&](double limit, int digits) {
    const double shown = AsShown(value, digits);
    if (std::fabs(shown - limit) < 1e-9) return missed && value != limit;
    return (shown > limit) != (value > limit);
  };
  int digits = UsualDigits(unit);
  for (const double limit : limits) {
    while (digits < kMaxDigits && misleads(limit, digits)) ++digits;
  }
  return digits;
}

std::string Found(const MetricInfo& info, double value, int digits) {
  if (info.above_zero.empty()) return Number(value, info.unit, digits);
  std::string size = Number(std::fabs(value), info.unit, digits);
  if (std::fabs(value) < kNeitherWay) return size + " off";
  return size + " " + std::string(value > 0 ? info.above_zero : info.below_zero);
}

// What follows the finding, by code: where full marks end, where none begin.
struct Wording {
  std::string_view code, full, none;
};
constexpr Wording kOneLimit[] = {{"at_most", "up to ", "from "},
                                 {"at_least", "from ", "up to "},
                                 {"within", "within ", "beyond "}};

std::string Value(const Reason& reason, size_t i, std::string_view unit) {
  return Number(reason.values[i], unit, ReasonDigits(reason, i, unit));
}

bool Misses(std::string_view code, const std::vector<double>& v) {
  if (code == "fails_above") return true;
  if (code == "between") return v[0] < v[1] || v[0] > v[2];
  if (code == "at_most") return v[0] > v[1];
  return code == "at_least" ? v[0] < v[1] : std::fabs(v[0]) > v[1];
}

std::string LimitText(const MetricInfo& info, const Wording& how, const Reason& reason) {
  const std::vector<double>& v = reason.values;
  // One value alone earns them: no pulp exposed.
  const bool exact = how.code != "at_least" && v[1] == 0;
  std::string text = Found(info, v[0], ReasonDigits(reason, 0, info.unit)) + " (full marks " +
                     std::string(exact ? "at " : how.full) + Value(reason, 1, info.unit);
  if (v.size() > 2) text += ", none " + std::string(how.none) + Value(reason, 2, info.unit);
  return text + ")";
}

// The sentence without its full stop; empty for what is not known here.
std::string Clause(const MetricInfo& info, const Reason& reason) {
  const std::vector<double>& v = reason.values;
  for (const Wording& how : kOneLimit) {
    if (reason.code == how.code && v.size() >= 2) return LimitText(info, how, reason);
  }
  if (reason.code == "between" && v.size() == 3) {
    return Found(info, v[0], ReasonDigits(reason, 0, info.unit)) + " (full marks " +
           (v[1] == v[2]
                ? "at " + Value(reason, 1, info.unit)
                : "from " + Value(reason, 1, info.unit) + " to " + Value(reason, 2, info.unit)) +
           ")";
  }
  if (reason.code == "any" && v.size() == 1) return Found(info, v[0], UsualDigits(info.unit));
  if (reason.code == "fails_above" && v.size() == 2) {
    return Found(info, v[0], ReasonDigits(reason, 0, info.unit)) + " (more than " +
           Value(reason, 1, info.unit) + " fails the whole attempt)";
  }
  if (reason.code == "not_in_task") return "not judged, because the reference has none of it";
  if (reason.code == "not_made") return "there is nothing to measure yet";
  if (reason.code == "device_limit" && v.size() == 2) {
    return "not judged, because the device was at its limit for more than " + Number(v[1], "%") +
           " of the time with force (measured: " + Number(v[0], info.unit) + ")";
  }
  if (reason.code == "below_grid" && v.size() == 1) {
    return "Thinner than " + Value(reason, 0, info.unit) +
           ": the grid cannot measure it more exactly";
  }
  return std::string(RemedyText(reason.code));
}

}  // namespace

int UsualDigits(std::string_view unit) {
  if (unit == "count") return 0;
  return unit == "%" || unit == "s" || unit == "deg" ? 1 : 2;
}

int ReasonDigits(const Reason& reason, size_t i, std::string_view unit) {
  const std::vector<double>& v = reason.values;
  if (i > 0 || reason.code == "below_grid") return DigitsOfLimit(v[i], unit);
  if (v.size() < 2 || (reason.code == "between" && v.size() < 3)) return UsualDigits(unit);
  const double found = reason.code == "within" ? std::fabs(v[0]) : v[0];
  // Where no points are left any more is read as about there.
  const size_t limits = reason.code == "between" ? 2 : 1;
  return DigitsOfFound(found, std::span(v).subspan(1, limits), Misses(reason.code, v), unit);
}

std::string WithUnit(std::string number, std::string_view unit) {
  if (unit == "count" || unit == "ratio") return number;
  if (unit == "deg") return number + "°";
  const std::string_view shown = unit == "mm2" ? "mm²" : unit == "mm3" ? "mm³" : unit;
  return number + " " + std::string(shown);
}

Reason FoundReason(const MetricInfo& info, double value,
                   const std::vector<scene::RubricPoint>& map) {
  const Asked asked = AskedFor(map);
  const bool open_below = asked.from == -kInfinite, open_above = asked.to == kInfinite;
  const bool lost = value < asked.from || value > asked.to;
  Reason out{"any", {value}, {}};
  if (open_below && !open_above) {
    out = {"at_most", {value, asked.to}, {}};
    if (lost && asked.none_above) out.values.push_back(*asked.none_above);
  } else if (open_above && !open_below) {
    out = {"at_least", {value, asked.from}, {}};
    if (lost && asked.none_below) out.values.push_back(*asked.none_below);
  } else if (!open_below && asked.from == -asked.to) {
    out = {"within", {value, asked.to}, {}};
    const auto& none = value > 0 ? asked.none_above : asked.none_below;
    if (lost && none) out.values.push_back(std::fabs(*none));
  } else if (!open_below) {
    out = {"between", {value, asked.from, asked.to}, {}};
  }
  out.units.assign(out.values.size(), std::string(info.unit));
  return out;
}

Reason FailsReason(const MetricInfo& info, double value, double limit) {
  const std::string unit(info.unit);
  return {"fails_above", {value, limit}, {unit, unit}};
}

Reason MissingReason(NoValue why) {
  return {why == NoValue::kNotInTask ? "not_in_task" : "not_made", {}, {}};
}

Reason LimitReason(const MetricInfo& info, double value) {
  return {"device_limit", {value, kMaxLimited_percent}, {std::string(info.unit), "%"}};
}

Reason BelowGridReason(const MetricInfo& info, double least) {
  return {"below_grid", {least}, {std::string(info.unit)}};
}

const Remedy* RemedyOf(const MetricInfo& info, double value,
                       const std::vector<scene::RubricPoint>& map) {
  const Asked asked = AskedFor(map);
  if (value >= asked.from && value <= asked.to) return nullptr;
  return FindRemedy(info.name, value > asked.to);
}

std::string Sentence(std::string_view title, const MetricInfo& info,
                     const std::vector<Reason>& reasons, std::string_view comment) {
  std::string out = std::string(title) + ":";
  for (const Reason& reason : reasons) {
    const std::string clause = Clause(info, reason);
    if (!clause.empty()) out += " " + clause + ".";
  }
  if (!comment.empty()) out += " " + std::string(comment);
  return out;
}

}  // namespace enamel::scoring
