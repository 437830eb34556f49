#pragma once

#include <filesystem>

#include "common/protocol/station_policy.h"

// The last policy that the server gave this station, in DATA/policy.json (schemas/station_settings.md,
// "Policy"): programs take their settings from it also while the server is away. Thread safety: any thread.
namespace enamel::station {

// Empty where there is none. One that cannot be read counts as none, and is logged as a warning.
protocol::Policy LoadPolicy(const std::filesystem::path& data);
// Writes it if it is another than the one that is there. Logged.
void KeepPolicy(const std::filesystem::path& data, const protocol::Policy& policy);

}  // namespace enamel::station
