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

// How the station is, whoever sits at it: what an operator asks before anybody begins.
struct StationFacts {
  Uploader::Link link;
  size_t waiting = 0, refused = 0;  // recordings: to be sent still, not taken by the server
  size_t kept_tickets = 0;
  std::optional<uint64_t> free_bytes;  // where the recordings are; none: it cannot be asked
  Status problem;                      // why the spool cannot be read, or ok
};

// May wait for the disk.
StationFacts LookAtStation(Workplace& workplace);

// One line for each: "the server is reachable", "2 recordings wait for the server", "41.2 GB free".
std::vector<std::string> Lines(const StationFacts& facts);

// "41.2 GB free" where this is; empty: it cannot be asked.
std::string RoomText(const std::optional<uint64_t>& free_bytes);
std::optional<uint64_t> FreeBytes(const std::filesystem::path& folder);

// The facts, at most two seconds old while somebody asks. Thread safety: the window's thread.
class StationWatch {
 public:
  // `workplace` outlives this.
  explicit StationWatch(Workplace& workplace) : workplace_(workplace) {}

  // Once a frame while they are shown; none before the first look has ended.
  const std::optional<StationFacts>& Look(std::chrono::steady_clock::time_point now);

 private:
  Workplace& workplace_;
  std::optional<StationFacts> facts_;
  std::chrono::steady_clock::time_point next_{};
  BackgroundTask task_;
};

}  // namespace enamel::station::desk
