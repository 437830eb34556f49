#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/protocol/station.pb.h"

// Settings of stations that their server gives them (schemas/station_settings.md, "Policy"). Pure
// functions, any thread.
namespace enamel::protocol {

using Policy = wire::Policy;

// A setting that a policy may have: one that says neither what a chair is nor where its server is. Its
// value is an integer from `least` to `most`, or one of `texts` where there are any, or a window's size.
struct PolicyRule {
  std::string_view name;
  int64_t least = 0, most = 0;
  std::vector<std::string> texts = {};
};
const std::vector<PolicyRule>& PolicyRules();
// Requires: there is such a rule.
const PolicyRule& PolicyRuleOf(std::string_view name);

// Errors: kInvalidInput, field "name" (the message lists those there are) or "value" (expected, found).
Status CheckPolicySetting(std::string_view name, std::string_view value);

// "1280x720". Errors: kInvalidInput.
struct WindowSize {
  int width_px = 0, height_px = 0;
};
Result<WindowSize> ParseWindowSize(std::string_view text);

// Scope of a setting: empty for every station, a station's name, or the beginning of names and "*".
bool IsInScope(std::string_view scope, std::string_view station);

// What a station keeps of the last policy that it was given. Errors: kInvalidInput.
inline constexpr size_t kMaxPolicyBytes = 1 << 16;
std::string PolicyJson(const Policy& policy);
Result<Policy> PolicyFromJson(std::string_view json);

}  // namespace enamel::protocol
