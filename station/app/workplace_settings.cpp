#include "station/app/workplace_settings.h"

#include <CLI/CLI.hpp>

#include "common/protocol/station_policy.h"

namespace enamel::station {
namespace {

// The bounds that a policy has too.
CLI::Range RangeOf(std::string_view name) {
  const protocol::PolicyRule& rule = protocol::PolicyRuleOf(name);
  return {rule.least, rule.most};
}

}  // namespace

WorkplaceOptions WorkplaceSettings::Options() const {
  WorkplaceOptions out;
  out.data = data;
  out.server = server;
  out.retention = {std::chrono::hours(24 * keep_days), static_cast<uint64_t>(keep_mib) << 20};
  out.uploader.bytes_per_s = static_cast<uint64_t>(uplink_kbit) * 1000 / 8;
  return out;
}

void AddDataOption(CLI::App& command, WorkplaceSettings& settings) {
  command
      .add_option("--data", settings.data,
                  "Folder for credentials, spool and cache (also ENAMEL_STATION_DATA)")
      ->capture_default_str();
}

void AddWorkplaceSettings(CLI::App& command, WorkplaceSettings& settings) {
  AddDataOption(command, settings);
  command.add_option("--server", settings.server,
                     "HOST:PORT, if the server has moved since enrolment");
  command
      .add_option("--uplink-kbit", settings.uplink_kbit, "Send no faster than this; 0: no limit")
      ->check(RangeOf("uplink-kbit"))
      ->capture_default_str();
  command
      .add_option("--keep-days", settings.keep_days,
                  "Keep recordings this long after the server has received them")
      ->check(RangeOf("keep-days"))
      ->capture_default_str();
  command
      .add_option("--keep-mib", settings.keep_mib,
                  "Above this size, recordings that the server has had longest are removed "
                  "earlier; 0: no limit")
      ->check(RangeOf("keep-mib"))
      ->capture_default_str();
}

}  // namespace enamel::station
