#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "common/base/result.h"
#include "station/spool/spool.h"
#include "station/uplink/server_link.h"

namespace enamel::station {

// Sends one attempt's spooled chunks from where the server says, waits until they are committed
// there, and seals it when the spool has the seal. Returns when everything the spool has now is
// committed. A refusal that trying again cannot change is noted in the spool. Errors: the link's.
Status UploadAttempt(ServerLink& link, Spool& spool, const Uuid& attempt,
                     const std::function<bool()>& keep_going = {});

// Uploads on a thread of its own while recording goes on, over breaks of the connection.
//
// The delay before connecting again doubles from 0.5 s to 30 s, less up to a half by chance so that
// a lab full of stations does not come back at once. A refusal that trying again cannot change
// stops the upload of that attempt, not the recording.
// Thread safety: all methods from any thread.
class Uploader {
 public:
  struct State {
    uint32_t committed = 0;  // chunks of the attempt
    bool sealed = false;     // everything is there
    bool reachable = true;   // as of the last try
    Status problem;          // last failure; refused for good when `gave_up`
    bool gave_up = false;
  };

  Uploader(Credentials credentials, Spool& spool, const Uuid& attempt);
  ~Uploader();  // stops
  Uploader(const Uploader&) = delete;
  Uploader& operator=(const Uploader&) = delete;

  // There is something new in the spool.
  void Wake();
  State state() const;
  // Until sealed, given up, or not reachable for `patience`.
  void WaitUntilDone(std::chrono::milliseconds patience);
  void Stop();

 private:
  void Run();
  Status Once(ServerLink& link);

  const Credentials credentials_;
  Spool& spool_;
  const Uuid attempt_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  State state_;
  bool wake_ = true, stop_ = false;
  int failures_ = 0;
  ServerLink* link_ = nullptr;  // while one is in use, for Cancel
  std::thread thread_;
};

// Whether trying again later may help.
bool IsTransient(const Status& status);

}  // namespace enamel::station
