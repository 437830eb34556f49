#include "server/live/station_board.h"

#include <utility>

namespace enamel::server {

StationBoard::Connection::Connection(std::shared_ptr<State> state, const Uuid& station)
    : state_(std::move(state)), station_(station) {
  MutexLock lock(state_->mutex);
  ++state_->connections[station_];
}

StationBoard::Connection::~Connection() {
  MutexLock lock(state_->mutex);
  const auto found = state_->connections.find(station_);
  if (--found->second == 0) state_->connections.erase(found);
}

std::unique_ptr<StationBoard::Connection> StationBoard::Enter(const Uuid& station) {
  return std::make_unique<Connection>(state_, station);
}

bool StationBoard::Connected(const Uuid& station) const {
  MutexLock lock(state_->mutex);
  return state_->connections.contains(station);
}

}  // namespace enamel::server
