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
  const auto found = state_->stations.find(station);
  return found != state_->stations.end() && found->second.connections > 0;
}

bool StationBoard::ShowsRemarks(const Uuid& station) const {
  MutexLock lock(state_->mutex);
  const auto found = state_->stations.find(station);
  return found != state_->stations.end() && found->second.connections > 0 &&
         found->second.shows_remarks;
}

UnixMs StationBoard::HeardMs(const Uuid& station) const {
  MutexLock lock(state_->mutex);
  const auto found = state_->stations.find(station);
  return found == state_->stations.end() ? 0 : found->second.heard_ms;
}

}  // namespace enamel::server
