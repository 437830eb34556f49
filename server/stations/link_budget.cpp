#include "server/stations/link_budget.h"

#include <algorithm>

namespace enamel::server::stations {
namespace {

constexpr UnixMs kPeriodMs = std::chrono::milliseconds(LinkBudget::kPeriod).count();

// A school's address in memory, so that two that know a station by one id do not share a budget.
std::string OfSchool(const Services* school) {
  return std::to_string(reinterpret_cast<uintptr_t>(school)) + " ";
}

LinkBudget::Clock::duration AheadOf(int percent) {
  return LinkBudget::Clock::duration(LinkBudget::kTimeAtOnce) * 100 / percent;
}

}  // namespace

std::shared_ptr<Connection> LinkBudget::Enter(const StationOfSchool& station,
                                              const std::shared_ptr<Connection>& connection) {
  MutexLock lock(mutex_);
  auto& links = parties_[station].links;
  std::erase_if(links, [](const auto& link) { return link.expired(); });
  links.push_back(connection);
  if (links.size() <= static_cast<size_t>(limits_.station_links)) return nullptr;
  ++too_many_links_;
  std::shared_ptr<Connection> oldest = links.front().lock();
  links.pop_front();
  return oldest;
}

bool LinkBudget::Recorded(const StationOfSchool& station, uint64_t bytes, UnixMs now_ms) {
  MutexLock lock(mutex_);
  Party& party = parties_[station];
  // A clock that was set back begins anew too.
  if (now_ms < party.since_ms || now_ms - party.since_ms >= kPeriodMs) {
    party.since_ms = now_ms;
    party.recorded_bytes = 0;
  }
  if (party.recorded_bytes + bytes > ops::LimitOf(ops::kStationRecordings, limits_)) {
    ++too_much_recorded_;
    return false;
  }
  party.recorded_bytes += bytes;
  return true;
}

LinkBudget::Clock::duration LinkBudget::Took(const StationOfSchool& station, Clock::duration time,
                                             Clock::time_point now) {
  const int percent = limits_.station_time_percent;
  const Clock::duration ahead = AheadOf(percent);
  MutexLock lock(mutex_);
  auto& paid_at = parties_[station].paid_at;
  paid_at = std::max(paid_at, now) + time * 100 / percent;
  // It rests at most so long for what it took, also where its connections took it side by side.
  paid_at = std::min(paid_at, now + ahead + kLongestRest);
  const auto rest = std::max(paid_at - ahead - now, Clock::duration::zero());
  if (rest > Clock::duration::zero()) ++rests_;
  return rest;
}

std::string LinkBudget::PartyOf(const StationOfSchool& station) {
  return OfSchool(station.first) + station.second.Text();
}

std::vector<ops::BudgetUse> LinkBudget::Uses(const Services* school, UnixMs now_ms) const {
  const auto make = [this](const ops::BudgetKind& kind, uint64_t refused) {
    ops::BudgetUse out;
    out.kind = &kind;
    out.limit = ops::LimitOf(kind, limits_);
    out.refused = refused;
    return out;
  };
  const auto count = [](ops::BudgetUse& use, const std::string& of, uint64_t amount) {
    if (amount <= use.most) return;
    use.most = amount;
    use.party = ops::PartyKind::kStation;
    use.of = of;
  };
  const HeldBytes::Use frames = coming_.Most(OfSchool(school));
  ops::BudgetUse coming = make(ops::kStationFrames, coming_.refused());
  count(coming, frames.of.substr(std::min(frames.of.size(), OfSchool(school).size())),
        frames.bytes);
  MutexLock lock(mutex_);
  ops::BudgetUse links = make(ops::kStationLinks, too_many_links_);
  ops::BudgetUse time = make(ops::kStationTime, rests_);
  ops::BudgetUse recorded = make(ops::kStationRecordings, too_much_recorded_);
  const Clock::time_point now = Clock::now();
  for (const auto& [station, party] : parties_) {
    if (station.first != school) continue;
    const std::string id = station.second.Text();
    count(links, id, static_cast<uint64_t>(std::ranges::count_if(party.links, [](const auto& link) {
            return !link.expired();
          })));
    if (now_ms - party.since_ms < kPeriodMs) count(recorded, id, party.recorded_bytes);
    const auto ahead = AheadOf(limits_.station_time_percent);
    const auto owed = std::clamp(party.paid_at - now, Clock::duration::zero(), ahead);
    count(time, id,
          time.limit * static_cast<uint64_t>(owed.count()) / static_cast<uint64_t>(ahead.count()));
  }
  return {links, time, coming, recorded};
}

}  // namespace enamel::server::stations
