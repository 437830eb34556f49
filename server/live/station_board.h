#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <vector>

#include "common/base/mutex.h"
#include "server/live/remark_board.h"
#include "server/training/types.h"

namespace enamel::server {

// The connected stations, when each was last heard, and the remarks to their chairs. BoardKeeper
// adds the stations that are connected to another server. Bounded by the number of enrolled
// stations. Thread safety: any thread.
class StationBoard {
  struct About {
    size_t connections = 0;
    bool shows_remarks = false;  // as the newest connection said
    UnixMs heard_ms = 0;
  };
  struct State {
    Mutex mutex;
    std::map<Uuid, About> stations ENAMEL_GUARDED_BY(mutex);
    std::map<Uuid, bool> elsewhere ENAMEL_GUARDED_BY(mutex);  // whether it shows remarks
  };

 public:
  // A connection of a station, from its Welcome until this goes. A station has two for a while when
  // it comes back before the server has noticed that the old one is dead. May outlive the board.
  class Connection {
   public:
    Connection(std::shared_ptr<State> state, const Uuid& station, bool shows_remarks);
    ~Connection();
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    // The station has said something. Thread safety: any.
    void Heard(UnixMs now_ms);

   private:
    const std::shared_ptr<State> state_;
    const Uuid station_;
  };
  // `shows_remarks`: it has somebody to show remarks to (Hello).
  std::unique_ptr<Connection> Enter(const Uuid& station, bool shows_remarks = false);

  // Here or elsewhere.
  bool Connected(const Uuid& station) const;
  // Connected, and by its newest connection to a server.
  bool ShowsRemarks(const Uuid& station) const;
  // When it said something last, since this server began; 0: it has not.
  UnixMs HeardMs(const Uuid& station) const;

  // Those that are connected here, by id.
  std::vector<StationLink> Here() const;
  // Replaces the stations connected to other servers.
  void SetElsewhere(const std::vector<StationLink>& elsewhere);

  RemarkBoard& remarks() { return remarks_; }
  const RemarkBoard& remarks() const { return remarks_; }

 private:
  const std::shared_ptr<State> state_ = std::make_shared<State>();
  RemarkBoard remarks_;
};

}  // namespace enamel::server
