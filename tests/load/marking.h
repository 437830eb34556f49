#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "common/net/frame_client.h"
#include "common/trace/trace.h"

namespace enamel::load {

// Recordings that are sealed all at once while stations stream, as when a class ends, and the time
// until the last has its score. Thread safety: none; Begin starts its own thread.
class Marking {
 public:
  struct Options {
    size_t attempts = 42;
    double minutes = 10;   // of each recording, at 1 kHz
    size_t different = 3;  // recordings cut anew; the attempts take turns with them
    int32_t voxel_nm = 50'000;
  };
  struct Figures {
    size_t scored = 0, failed = 0;
    double seal_s = 0;    // until all were sealed
    double marked_s = 0;  // from the first seal to the last score
    double cutting_share = 0;
    double replay_realtime = 0;  // median of what the scores say
  };

  Marking() = default;
  ~Marking();
  Marking(const Marking&) = delete;
  Marking& operator=(const Marking&) = delete;

  // Before the server starts: records class I cavities on the built-in molar, scores one as the
  // reference, and puts the others into the store, complete except for the seal.
  Status Prepare(const std::filesystem::path& data, const Options& options,
                 const std::function<void(const std::string&)>& say);
  // Seals them over the station link, each on its own connection, a few at a time, and waits for the scores.
  void Begin(const net::Endpoint& server, const Sha256& fingerprint);
  bool done() const { return done_; }
  // Waits at most `seconds` for what Begin started. Errors: kUnavailable when not all were scored.
  Result<Figures> Finish(double seconds);

 private:
  struct Sealed {
    Uuid attempt;
    trace::Seal seal;
  };
  void Run(const std::stop_token& stop);
  Status Seal(const Sealed& attempt) const;

  std::filesystem::path data_;
  net::Endpoint server_;
  Sha256 fingerprint_;
  Uuid station_;
  std::string credential_;
  std::vector<Sealed> attempts_;
  Figures figures_;
  Status outcome_;
  std::atomic<bool> done_{false};
  std::jthread thread_;
};

}  // namespace enamel::load
