#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "station/desk/background_task.h"
#include "station/session/workplace.h"

namespace enamel::station::desk {

// State of the station for the operator, whoever is signed in.
struct StationFacts {
  Uploader::Link link;
  size_t waiting = 0, refused = 0;  // recordings not sent yet; refused by the server
  size_t kept_tickets = 0;
  std::optional<uint64_t> free_bytes;  // where recordings are kept; none: unknown
  Status problem;                      // why the spool cannot be read, or ok
};

// May wait for the disk.
StationFacts LookAtStation(Workplace& workplace);

// One line for each fact: "the server is reachable", "2 recordings wait for the server".
std::vector<std::string> Lines(const StationFacts& facts);

// "41.2 GB free"; empty if unknown.
std::string RoomText(const std::optional<uint64_t>& free_bytes);
std::optional<uint64_t> FreeBytes(const std::filesystem::path& folder);

// Keeps the facts at most two seconds old while they are shown. Thread safety: the window's thread.
class StationWatch {
 public:
  // `workplace` outlives this.
  explicit StationWatch(Workplace& workplace) : workplace_(workplace) {}

  // Call once a frame while they are shown; none before the first look has ended.
  const std::optional<StationFacts>& Look(std::chrono::steady_clock::time_point now);

 private:
  Workplace& workplace_;
  std::optional<StationFacts> facts_;
  std::chrono::steady_clock::time_point next_{};
  BackgroundTask task_;
};

}  // namespace enamel::station::desk
