#include "server/live/station_board.h"

#include <algorithm>
#include <utility>

namespace enamel::server {

StationBoard::Connection::Connection(std::shared_ptr<State> state, const Uuid& station,
                                     bool shows_remarks)
    : state_(std::move(state)), station_(station) {
  MutexLock lock(state_->mutex);
  About& about = state_->stations[station_];
  ++about.connections;
  about.shows_remarks = shows_remarks;
}

StationBoard::Connection::~Connection() {
  MutexLock lock(state_->mutex);
  --state_->stations[station_].connections;
}

void StationBoard::Connection::Heard(UnixMs now_ms) {
  MutexLock lock(state_->mutex);
  UnixMs& heard_ms = state_->stations[station_].heard_ms;
  heard_ms = std::max(heard_ms, now_ms);
}

std::unique_ptr<StationBoard::Connection> StationBoard::Enter(const Uuid& station,
                                                              bool shows_remarks) {
  return std::make_unique<Connection>(state_, station, shows_remarks);
}

bool StationBoard::Connected(const Uuid& station) const {
  MutexLock lock(state_->mutex);
  const auto here = state_->stations.find(station);
  return (here != state_->stations.end() && here->second.connections > 0) ||
         state_->elsewhere.contains(station);
}

bool StationBoard::ShowsRemarks(const Uuid& station) const {
  MutexLock lock(state_->mutex);
  const auto here = state_->stations.find(station);
  if (here != state_->stations.end() && here->second.connections > 0 &&
      here->second.shows_remarks) {
    return true;
  }
  const auto elsewhere = state_->elsewhere.find(station);
  return elsewhere != state_->elsewhere.end() && elsewhere->second;
}

std::vector<StationLink> StationBoard::Here() const {
  std::vector<StationLink> out;
  MutexLock lock(state_->mutex);
  for (const auto& [station, about] : state_->stations) {
    if (about.connections > 0) out.push_back({station, about.shows_remarks});
  }
  return out;
}

void StationBoard::SetElsewhere(const std::vector<StationLink>& elsewhere) {
  std::map<Uuid, bool> all;
  for (const StationLink& link : elsewhere) all.emplace(link.station, link.shows_remarks);
  MutexLock lock(state_->mutex);
  state_->elsewhere.swap(all);
}

UnixMs StationBoard::HeardMs(const Uuid& station) const {
  MutexLock lock(state_->mutex);
  const auto found = state_->stations.find(station);
  return found == state_->stations.end() ? 0 : found->second.heard_ms;
}

}  // namespace enamel::server
