#include "station/words/score_words.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <vector>

#include "common/scoring/remedies.h"

namespace enamel::station {
namespace {

using language::Value;

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// End of the number that begins at `at`: "12", "2.50", but not the full stop of "in 12.".
size_t EndOfNumber(std::string_view text, size_t at) {
  while (at < text.size() && IsDigit(text[at])) ++at;
  if (at + 1 >= text.size() || text[at] != '.' || !IsDigit(text[at + 1])) return at;
  ++at;
  while (at < text.size() && IsDigit(text[at])) ++at;
  return at;
}

// A text as the name of its message, and its numbers, which fill the message's places {a}, {b}, …
// in order.
struct Named {
  std::string name;
  std::vector<std::string_view> numbers;
};
Named NameOf(std::string_view text) {
  Named out;
  bool apart = false;
  for (size_t i = 0; i < text.size();) {
    std::string piece;
    if (IsDigit(text[i])) {
      const size_t end = EndOfNumber(text, i);
      out.numbers.push_back(text.substr(i, end - i));
      piece = "n";
      i = end;
    } else {
      const char c = text[i++];
      if (c >= 'A' && c <= 'Z') piece = static_cast<char>(c - 'A' + 'a');
      if (c >= 'a' && c <= 'z') piece = c;
    }
    if (piece.empty()) {
      apart = true;
      continue;
    }
    if (apart && !out.name.empty()) out.name += '_';
    apart = false;
    out.name += piece;
  }
  return out;
}

// None: not built in.
std::optional<std::string> SaidBuiltin(const Words& words, std::string_view kind,
                                       std::string_view text) {
  static constexpr std::string_view kPlaces = "abcdefghijklmnopqrstuvwxyz";
  constexpr size_t kLongestNumber = 20;
  const Named named = NameOf(text);
  const std::string key = std::string(kind) + "." + named.name;
  if (!words.Has(key) || named.numbers.size() > kPlaces.size()) return std::nullopt;
  std::vector<Value> values;
  for (size_t i = 0; i < named.numbers.size(); ++i) {
    const std::string_view number = named.numbers[i];
    const size_t point = number.find('.');
    const size_t decimals = point == std::string_view::npos ? 0 : number.size() - point - 1;
    double value = 0;
    // A school's own text may have a number that no double holds; then it is not built in.
    const auto read = std::from_chars(number.data(), number.data() + number.size(), value);
    if (read.ec != std::errc() || number.size() > kLongestNumber) return std::nullopt;
    values.push_back({kPlaces.substr(i, 1), words.Decimal(value, static_cast<int>(decimals))});
  }
  return words.Say(key, values);
}

// Splits at each space between a full stop and a capital letter.
std::vector<std::string_view> SentencesOf(std::string_view text) {
  std::vector<std::string_view> out;
  size_t from = 0;
  for (size_t i = 1; i + 1 < text.size(); ++i) {
    if (text[i] != ' ' || text[i - 1] != '.' || text[i + 1] < 'A' || text[i + 1] > 'Z') continue;
    out.push_back(text.substr(from, i - from));
    from = i + 1;
  }
  out.push_back(text.substr(from));
  return out;
}

// A Chinese full stop includes its space.
std::string_view Between(const Words& words) {
  return words.language() == language::Language::kChinese ? "" : " ";
}

std::string DurationText(const Words& words, double s) {
  // From 59.95 s on, which would read 60.0 s, minutes are shown.
  if (s < 59.95) return NumberText(words, s, 1) + " s";
  const auto whole = std::llround(s);
  const std::string rest = std::to_string(whole % 60);
  return std::to_string(whole / 60) + " min " + (rest.size() < 2 ? "0" : "") + rest + " s";
}

std::string QuantityText(const Words& words, double value, std::string_view unit, int digits) {
  if (unit == "s") return DurationText(words, value);
  return scoring::WithUnit(words.Decimal(value, digits), unit);
}
std::string QuantityText(const Words& words, double value, std::string_view unit) {
  return QuantityText(words, value, unit, scoring::UsualDigits(unit));
}

// The key form of MetricInfo's English: "too deep", "more open at the top".
std::string DirectionKey(std::string_view direction) {
  std::string key = "direction." + std::string(direction);
  for (char& c : key) {
    if (c == ' ') c = '_';
  }
  return key;
}

// A measured value; if its sign has a meaning, with words: "0.22 mm too deep".
std::string FoundText(const Words& words, std::string_view metric, double value,
                      std::string_view unit, int digits) {
  const scoring::MetricInfo* info = scoring::FindMetric(metric);
  if (info == nullptr || info->above_zero.empty()) return QuantityText(words, value, unit, digits);
  const std::string size = QuantityText(words, std::fabs(value), unit, digits);
  const std::string key = std::fabs(value) < scoring::kNeitherWay
                              ? std::string("direction.none")
                              : DirectionKey(value > 0 ? info->above_zero : info->below_zero);
  return words.Has(key) ? words.Say(key, {{"size", size}}) : size;
}

// None: unknown code.
std::optional<std::string> SentenceOf(const Words& words, std::string_view metric,
                                      const scoring::Reason& reason, std::string_view unit) {
  const std::vector<double>& v = reason.values;
  const std::string& code = reason.code;
  const std::string key = "reason." + code;
  const auto quantity = [&](size_t i) {
    return QuantityText(words, v[i], unit, scoring::ReasonDigits(reason, i, unit));
  };
  const bool one_limit = code == "at_most" || code == "at_least" || code == "within";
  if ((one_limit && v.size() >= 2) || (code == "between" && v.size() == 3) ||
      (code == "fails_above" && v.size() == 2)) {
    const std::string found =
        FoundText(words, metric, v[0], unit, scoring::ReasonDigits(reason, 0, unit));
    const std::string second = quantity(1);
    if (code == "fails_above") return words.Say(key, {{"found", found}, {"limit", second}});
    if (code == "between") {
      if (v[1] == v[2]) return words.Say("reason.exactly", {{"found", found}, {"full", second}});
      return words.Say(key, {{"found", found}, {"from", second}, {"to", quantity(2)}});
    }
    // Only one value earns the points: no pulp exposed.
    const std::string how = code != "at_least" && v[1] == 0 ? "reason.exactly" : key;
    if (v.size() == 2) return words.Say(how, {{"found", found}, {"full", second}});
    return words.Say(how + "_none", {{"found", found}, {"full", second}, {"none", quantity(2)}});
  }
  if (code == "any" && v.size() == 1) {
    return words.Say(key,
                     {{"found", FoundText(words, metric, v[0], unit, scoring::UsualDigits(unit))}});
  }
  if (code == "device_limit" && v.size() == 2) {
    return words.Say(
        key, {{"found", QuantityText(words, v[0], unit)}, {"share", NumberText(words, v[1], 1)}});
  }
  if (code == "below_grid" && v.size() == 1) return words.Say(key, {{"limit", quantity(0)}});
  const bool bare = code == "not_in_task" || code == "not_made";
  if (bare || !scoring::RemedyText(code).empty()) return words.Say(key);
  return std::nullopt;
}

// `titled`: begins with the title. Below a title the measured value has a name instead.
std::string ReasonTextOf(const Words& words, const scoring::CriterionResult& judged, bool titled) {
  if (judged.reasons.empty()) return judged.reason;
  std::string out;
  if (titled) out = words.Say("reason.title", {{"title", WordedTitle(words, judged.title)}});
  for (const scoring::Reason& reason : judged.reasons) {
    auto said = SentenceOf(words, judged.name, reason, judged.unit);
    if (!said) return judged.reason;
    const bool measured = out.empty() && !reason.values.empty();
    if (measured) said = words.Say("reason.measured", {{"found", *said}});
    if (!out.empty()) out.append(Between(words));
    out.append(*said);
  }
  if (!judged.comment.empty()) {
    out.append(Between(words)).append(WordedText(words, judged.comment));
  }
  return out;
}

}  // namespace

std::string WordedTitle(const Words& words, std::string_view title) {
  return SaidBuiltin(words, "builtin_title", title).value_or(std::string(title));
}

std::string WordedText(const Words& words, std::string_view text) {
  std::string out;
  for (std::string_view sentence : SentencesOf(text)) {
    const auto said = SaidBuiltin(words, "builtin_text", sentence);
    if (!said) return std::string(text);
    if (!out.empty()) out.append(Between(words));
    out.append(*said);
  }
  return out;
}

std::string ReasonText(const Words& words, const scoring::CriterionResult& criterion) {
  return ReasonTextOf(words, criterion, true);
}
std::string DetailText(const Words& words, const scoring::CriterionResult& criterion) {
  return ReasonTextOf(words, criterion, false);
}

std::string BorderlineText(const Words& words, const scoring::CriticalResult& limit) {
  const std::string key = "critical_error." + limit.error;
  const auto quantity = [&](double value) {
    const int digits =
        limit.unit.empty() ? 1 : scoring::UsualDigits(limit.unit) + (limit.uncertainty < 0.01);
    return scoring::WithUnit(words.Decimal(value, digits), limit.unit);
  };
  return words.Say(words.Has(key) ? "borderline.critical" : "borderline.points",
                   {{"error", words.Has(key) ? words.Say(key) : ""},
                    {"found", quantity(limit.value)},
                    {"limit", quantity(limit.limit)},
                    {"uncertainty", quantity(limit.uncertainty)}});
}

std::string ReasonText(const Words& words, const scoring::CriticalResult& critical) {
  const std::string key = "critical_error." + critical.error;
  if (!words.Has(key)) return critical.reason;
  const scoring::Reason reason{
      critical.above ? "at_most" : "at_least", {critical.value, critical.limit}, {}};
  auto quantity = [&](size_t i) {
    const int digits = scoring::ReasonDigits(reason, i, critical.unit);
    return scoring::WithUnit(words.Decimal(reason.values[i], digits), critical.unit);
  };
  return words.Say("critical." + reason.code,
                   {{"error", words.Say(key)}, {"found", quantity(0)}, {"limit", quantity(1)}});
}

std::string NumberText(const Words& words, double value, int most_digits) {
  std::string out = words.Decimal(value, most_digits);
  if (most_digits == 0) return out;
  while (out.ends_with('0')) out.pop_back();
  if (!IsDigit(out.back())) out.pop_back();
  return out;
}

}  // namespace enamel::station
