#include "station/app/workplace_settings.h"

#include <CLI/CLI.hpp>

namespace enamel::station {
namespace {

constexpr int64_t kMostKbit = 10'000'000, kMostMib = int64_t{1} << 30;

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
      ->check(CLI::Range(int64_t{0}, kMostKbit))
      ->capture_default_str();
  command
      .add_option("--keep-days", settings.keep_days,
                  "Keep recordings this long after the server has received them")
      // At least a week: a server's backup that asks for its recordings again may be that old.
      ->check(CLI::Range(7, 3650))
      ->capture_default_str();
  command
      .add_option("--keep-mib", settings.keep_mib,
                  "Above this size, recordings that the server has had longest are removed "
                  "earlier; 0: no limit")
      ->check(CLI::Range(int64_t{0}, kMostMib))
      ->capture_default_str();
}

}  // namespace enamel::station
