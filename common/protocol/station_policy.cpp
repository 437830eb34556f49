#include "common/protocol/station_policy.h"

#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "common/base/check.h"

namespace enamel::protocol {
namespace {

constexpr std::string_view kWindow = "window";
constexpr int kMinWidth = 320, kMinHeight = 200, kMaxSide = 16'384;

std::optional<int64_t> ReadInteger(std::string_view text) {
  int64_t out = 0;
  const char* end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, out);
  if (error != std::errc() || stopped != end) return std::nullopt;
  return out;
}

std::string Expected(const PolicyRule& rule) {
  if (rule.texts.empty()) {
    return "an integer from " + std::to_string(rule.least) + " to " + std::to_string(rule.most);
  }
  std::string out = "one of";
  for (const std::string& text : rule.texts)
    out += (text == rule.texts.front() ? " " : ", ") + text;
  return out;
}

bool Takes(const PolicyRule& rule, std::string_view value) {
  if (!rule.texts.empty()) return std::ranges::find(rule.texts, value) != rule.texts.end();
  const auto integer = ReadInteger(value);
  return integer && *integer >= rule.least && *integer <= rule.most;
}

}  // namespace

const std::vector<PolicyRule>& PolicyRules() {
  static const std::vector<PolicyRule> kRules = {
      // A day: a chair that is on in the morning is signed out by the next.
      {"idle-minutes", 1, 1440},
      {"hand-turn", 0, 0, {"0", "90", "180", "270"}},
      // At least a week: a server's backup that asks for its recordings again may be that old.
      {"keep-days", 7, 3650},
      {"keep-mib", 0, int64_t{1} << 30},
      {"language", 0, 0, {"en", "de", "zh"}},
      {"log-format", 0, 0, {"text", "json"}},
      {"log-level", 0, 0, {"trace", "debug", "info", "warning", "error"}},
      {"quality", 0, 0, {"best", "good", "fair", "low"}},
      {"uplink-kbit", 0, 10'000'000},
      {kWindow}};
  return kRules;
}

const PolicyRule& PolicyRuleOf(std::string_view name) {
  const auto found = std::ranges::find(PolicyRules(), name, &PolicyRule::name);
  ENAMEL_CHECK(found != PolicyRules().end());
  return *found;
}

Status CheckPolicySetting(std::string_view name, std::string_view value) {
  const auto found = std::ranges::find(PolicyRules(), name, &PolicyRule::name);
  if (found == PolicyRules().end()) {
    std::string names;
    for (const PolicyRule& rule : PolicyRules())
      names += (names.empty() ? "" : ", ") + std::string(rule.name);
    return Status(Code::kInvalidInput,
                  "expected one of " + names + "; found \"" + std::string(name) + "\"", "name");
  }
  if (found->name == kWindow) {
    auto size = ParseWindowSize(value);
    return size.ok() ? Status::Ok() : Status(Code::kInvalidInput, size.status().message(), "value");
  }
  if (Takes(*found, value)) return Status::Ok();
  return Status(Code::kInvalidInput,
                std::string(name) + ": expected " + Expected(*found) + "; found \"" +
                    std::string(value) + "\"",
                "value");
}

Result<WindowSize> ParseWindowSize(std::string_view text) {
  const size_t by = text.find('x');
  const auto side = [&](std::string_view digits, int least) {
    const auto pixels = ReadInteger(digits);
    return pixels && *pixels >= least && *pixels <= kMaxSide ? static_cast<int>(*pixels) : 0;
  };
  WindowSize out;
  if (by != text.npos) {
    out = {side(text.substr(0, by), kMinWidth), side(text.substr(by + 1), kMinHeight)};
  }
  if (out.width_px > 0 && out.height_px > 0) return out;
  return Status(
      Code::kInvalidInput,
      "window: expected WIDTHxHEIGHT in pixels, from 320x200 to 16384x16384, as 1280x720; "
      "found '" +
          std::string(text) + "'",
      std::string(kWindow));
}

bool IsInScope(std::string_view scope, std::string_view station) {
  if (scope.ends_with('*')) return station.starts_with(scope.substr(0, scope.size() - 1));
  return scope.empty() || scope == station;
}

std::string PolicyJson(const Policy& policy) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  std::string json;
  ENAMEL_CHECK(google::protobuf::util::MessageToJsonString(policy, &json, options).ok());
  return json + "\n";
}

Result<Policy> PolicyFromJson(std::string_view json) {
  google::protobuf::util::JsonParseOptions options;
  options.ignore_unknown_fields = true;
  Policy out;
  const auto read = google::protobuf::util::JsonStringToMessage(std::string(json), &out, options);
  if (read.ok()) return out;
  return Status(Code::kInvalidInput, "expected a policy: " + std::string(read.message()));
}

}  // namespace enamel::protocol
