#include "station/desk/station_facts.h"

#include <algorithm>
#include <cstdio>

namespace enamel::station::desk {
namespace {

constexpr std::chrono::seconds kLookEvery{2};
// Some four hours of recording (0.35 GB take eight).
constexpr uint64_t kLittleRoom_bytes = 200'000'000;

std::string Counted(size_t n, const std::string& one, const std::string& many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

std::string SizeText(uint64_t bytes) {
  const bool large = bytes >= 1'000'000'000;
  char text[32];
  std::snprintf(text, sizeof text, large ? "%.1f GB" : "%.0f MB",
                static_cast<double>(bytes) / (large ? 1e9 : 1e6));
  return text;
}

}  // namespace

StationFacts LookAtStation(Workplace& workplace) {
  StationFacts out;
  out.link = workplace.uploader().link();
  auto all = workplace.spool().List();
  auto waiting = WaitingAttempts(workplace.spool());
  auto tickets = workplace.Reserved();
  // Report one: a spool's problem is the same for all three.
  for (const Status& status : {all.status(), waiting.status(), tickets.status()}) {
    if (out.problem.ok()) out.problem = status;
  }
  if (waiting.ok()) out.waiting = waiting->size();
  if (all.ok()) {
    out.refused = static_cast<size_t>(
        std::ranges::count_if(*all, [](const SpooledAttempt& a) { return !a.refused.empty(); }));
  }
  if (tickets.ok()) out.kept_tickets = tickets->size();
  out.free_bytes = FreeBytes(workplace.spool().file().parent_path());
  return out;
}

std::optional<uint64_t> FreeBytes(const std::filesystem::path& folder) {
  std::error_code error;
  auto space = std::filesystem::space(folder, error);
  return error ? std::nullopt : std::optional<uint64_t>(space.available);
}

std::string RoomText(const std::optional<uint64_t>& free_bytes) {
  if (!free_bytes) return {};
  return SizeText(*free_bytes) + " free" +
         (*free_bytes < kLittleRoom_bytes ? ": TOO LITTLE, make room" : "");
}

std::vector<std::string> Lines(const StationFacts& facts) {
  std::vector<std::string> out;
  out.push_back(facts.link.reachable ? "the server is reachable" : "the server is AWAY");
  if (facts.link.refused) out.push_back("REFUSED: somebody has to act");
  if (!facts.link.problem.ok()) out.push_back(facts.link.problem.message());
  out.push_back(facts.waiting == 0 ? "no recording waits for the server"
                                   : Counted(facts.waiting, "recording waits", "recordings wait") +
                                         " for the server");
  if (facts.refused > 0) {
    out.push_back(Counted(facts.refused, "recording", "recordings") +
                  " REFUSED by it: 'enamel-station spool list' says why");
  }
  if (facts.kept_tickets > 0) {
    out.push_back(Counted(facts.kept_tickets, "ticket", "tickets") + " kept for later");
  }
  if (std::string room = RoomText(facts.free_bytes); !room.empty()) out.push_back(room);
  if (!facts.problem.ok()) out.push_back(facts.problem.message());
  return out;
}

const std::optional<StationFacts>& StationWatch::Look(std::chrono::steady_clock::time_point now) {
  task_.Poll();
  if (!task_.busy() && now >= next_) {
    // On a separate thread: a damaged or slow disk must not hold up the picture.
    next_ = now + kLookEvery;
    task_.Start("Looking at the station", [this]() -> BackgroundTask::After {
      return [this, facts = LookAtStation(workplace_)] { facts_ = facts; };
    });
  }
  return facts_;
}

}  // namespace enamel::station::desk
