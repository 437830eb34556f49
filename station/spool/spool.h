#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "common/protocol/attempt_facts.h"
#include "common/trace/trace.h"
#include "station/spool/chair_terms.h"
#include "station/spool/spooled_loop_facts.h"
#include "station/spool/spooled_tickets.h"

namespace enamel::station {

// Error field for a damaged spool file, whose readable contents can be salvaged.
inline constexpr char kDamagedSpool[] = "damaged";
// Error field for an empty or missing spool file: nothing to salvage, a copy must be restored.
inline constexpr char kLostSpool[] = "lost";

// The spool's facts of one attempt.
struct SpooledAttempt {
  Uuid id;
  std::string exercise, profile;
  int64_t created_unix_ms = 0;
  uint32_t chunks = 0;
  uint32_t committed = 0;  // chunks below this one are durable on the server
  uint64_t ticks = 0, gap_ticks = 0;
  uint64_t bytes = 0;
  std::optional<trace::Seal> seal;
  bool sealed_at_server = false;
  std::string refused;          // why the server refuses it; else empty
  int64_t refused_unix_ms = 0;  // 0: unknown
  // Why the last try to send it failed, if another may succeed; empty: it succeeded, or there was
  // none. Since the first of the failed tries in a row.
  std::string waits_because;
  int64_t waits_since_unix_ms = 0, tried_unix_ms = 0;
  protocol::AttemptFacts facts;
  ChairTerms terms;

  bool complete() const { return seal.has_value() && sealed_at_server; }
  // To be sent: not refused, and not complete on the server.
  bool waits() const {
    return refused.empty() && (committed < chunks || (seal && !sealed_at_server));
  }
};

struct SpooledChunk {
  uint32_t seq = 0;
  Bytes bytes;
};

// How long recordings stay here once the server has them.
struct Retention {
  std::chrono::hours age{7 * 24};  // since the server has all of an attempt
  // Above this size, recordings that the server has had longest are deleted earlier; 0: no limit. A
  // recording deleted within a week cannot refill a server restored from an older backup.
  uint64_t bytes = uint64_t{10} << 30;
};
struct Pruned {
  int attempts = 0;  // deleted
  int early = 0;     // of these, early because of `bytes`
};

// A message about a pruning; empty: none needed.
std::string PrunedText(const Pruned& pruned, const Retention& retention);

// Time since anything was recorded of an attempt.
struct Silence {
  int64_t ms = 0;
  // The machine's clock was set back by more than a second meanwhile. `ms` is then measured by
  // uptime, if the machine has not restarted; else it is too short.
  bool clock_stepped = false;
};

// Held while a recording is made or closed: one process at a time may do that in a folder. The
// system releases it when the process ends, in any way.
class RecordingLock {
 public:
  RecordingLock(RecordingLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  RecordingLock& operator=(RecordingLock&& other) noexcept {
    std::swap(file_, other.file_);
    return *this;
  }
  ~RecordingLock();

 private:
  friend class Spool;
  explicit RecordingLock(int file) : file_(file) {}
  int file_;
};

// Recordings on the station's disk: durable before they are sent, kept until the server has had
// them for a week (schemas/sql/station_spool).
//
// Every Put returns only when the data would survive a power cut (WAL, synchronous = FULL). Thread
// safety: any thread; calls wait for each other. Real-time: never. One process records at a time
// (LockForRecording); others may read, and mark chunks as committed. Errors: kStorage (disk full,
// not writable, damaged: the message says which and what to do; field kDamagedSpool), kVersion
// (made by another version), kConflict (contradicts stored data), kNotFound.
class Spool {
 public:
  // Opens `folder`/spool.sqlite, creating both if needed. Errors also: kStorage with field
  // kLostSpool when the file is empty, or missing with its log present: its contents were lost.
  static Result<std::unique_ptr<Spool>> Open(const std::filesystem::path& folder);
  // Changes nothing in memory or on disk, and needs no right to write: to list, verify and export,
  // even during a recording. Reads what it can of a damaged spool. Errors: kNotFound when there is
  // none.
  static Result<std::unique_ptr<Spool>> OpenToRead(const std::filesystem::path& folder);
  ~Spool();
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;

  // Errors: kConflict while another process holds it.
  Result<RecordingLock> LockForRecording();
  // Call before anything that will be recorded: makes a durable test write, and checks for
  // `room_bytes` free. Errors: kStorage (with the room available and needed).
  Status ProveWritable(uint64_t room_bytes);

  // The attempt's id is in the header. Idempotent for the same header: the other arguments of the
  // first call stay.
  Status BeginAttempt(const trace::Header& header, const std::string& exercise,
                      const std::string& profile, const protocol::AttemptFacts& facts = {},
                      const ChairTerms& terms = {});
  // Stores the next chunk. Idempotent for the same bytes; another chunk under a used seq is
  // kConflict.
  Status PutChunk(const Uuid& attempt, ByteView chunk);
  // The attempt continues after a crash: its count of resumptions grows. Errors: kConflict when it
  // has a seal.
  Status MarkResumed(const Uuid& attempt);
  // Seals an interrupted attempt at the chunks that are here. Returns the existing seal, if any.
  // Errors: kInvalidInput without a chunk.
  Result<trace::Seal> CloseAttempt(const Uuid& attempt);
  // End of the attempt. Idempotent for the same seal.
  Status PutSeal(const trace::Seal& seal);

  // The server has exactly the chunks below `next_seq` durably. Later ones are sent again (a server
  // restored from a backup lacks them).
  Status SetCommittedBelow(const Uuid& attempt, uint32_t next_seq);
  // The server has chunk `seq` and all before it.
  Status MarkCommitted(const Uuid& attempt, uint32_t seq);
  Status MarkSealedAtServer(const Uuid& attempt);
  // The server has lost the whole attempt: it waits to be sent again.
  Status MarkWanted(const Uuid& attempt);
  // A try to send it failed for this reason, and another may succeed; empty: it succeeded.
  Status MarkTried(const Uuid& attempt, const std::string& problem);
  // The same for all that wait: the server could not be reached or used.
  Status MarkAllTried(const std::string& problem);
  // Sending it again is useless; it stays here for export.
  Status MarkRefused(const Uuid& attempt, const std::string& why);
  // The cause of the refusal is repaired: it is tried again.
  Status ClearRefusal(const Uuid& attempt);

  // In the order they were begun.
  Result<std::vector<SpooledAttempt>> List();
  Result<SpooledAttempt> Get(const Uuid& attempt);
  Result<Bytes> HeaderOf(const Uuid& attempt);
  // At most `limit` chunks from `seq` on, in order.
  Result<std::vector<SpooledChunk>> ChunksFrom(const Uuid& attempt, uint32_t seq, size_t limit);
  // The whole recording as one file's content (trace::EncodeTraceFile).
  Result<trace::TraceFile> Export(const Uuid& attempt);

  // When the last chunk became durable here; nothing if there is none.
  Result<std::optional<int64_t>> LastSpooledUnixMs(const Uuid& attempt);
  // Time since then, or since it was begun: by the clock or by uptime, whichever is longer. A clock
  // that was set back does not shorten it while the machine runs.
  Result<Silence> SilenceOf(const Uuid& attempt);
  // Deletes attempts that the server has, by `retention`; never one it lacks.
  Result<Pruned> Prune(const Retention& retention, std::chrono::system_clock::time_point now =
                                                       std::chrono::system_clock::now());

  // Tickets for later, and loop facts of the attempts: under the same lock.
  SpooledTickets& tickets() { return tickets_; }
  SpooledLoopFacts& loop_facts() { return loop_facts_; }

  const std::filesystem::path& file() const;
  // For VerifyRecordings and SalvageSpool.
  SpoolFile& spool_file() { return *file_; }

 private:
  explicit Spool(std::unique_ptr<SpoolFile> file);
  Status MarkTriedWhere(const char* where, const Uuid& attempt, const std::string& problem);

  std::unique_ptr<SpoolFile> file_;
  SpooledTickets tickets_;
  SpooledLoopFacts loop_facts_;
};

}  // namespace enamel::station
