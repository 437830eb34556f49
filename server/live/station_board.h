#pragma once

#include <cstddef>
#include <map>
#include <memory>

#include "common/base/mutex.h"
#include "server/training/types.h"

namespace enamel::server {

// Which stations are connected now. Thread safety: any thread.
class StationBoard {
  struct State {
    Mutex mutex;
    std::map<Uuid, size_t> connections ENAMEL_GUARDED_BY(mutex);  // of connected stations
  };

 public:
  // A connection of a station, from its Welcome until this goes. A station has two for a while when it
  // comes back before the server has noticed that the old one is dead. May outlive the board.
  class Connection {
   public:
    Connection(std::shared_ptr<State> state, const Uuid& station);
    ~Connection();
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

   private:
    const std::shared_ptr<State> state_;
    const Uuid station_;
  };
  std::unique_ptr<Connection> Enter(const Uuid& station);

  bool Connected(const Uuid& station) const;

 private:
  const std::shared_ptr<State> state_ = std::make_shared<State>();
};

}  // namespace enamel::server
