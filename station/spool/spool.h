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
#include "station/spool/spooled_loop_facts.h"
#include "station/spool/spooled_tickets.h"

namespace enamel::station {

// Field of the errors of a spool whose file is damaged: what can be read of it can be salvaged.
inline constexpr char kDamagedSpool[] = "damaged";
// Of one whose file is empty or gone: nothing is left in it to salvage, a copy has to be put back.
inline constexpr char kLostSpool[] = "lost";

// What the spool knows of one attempt.
struct SpooledAttempt {
  Uuid id;
  std::string exercise, profile;
  int64_t created_unix_ms = 0;
  uint32_t chunks = 0;
  uint32_t committed = 0;  // the server has the chunks below this one durably
  uint64_t ticks = 0, gap_ticks = 0;
  uint64_t bytes = 0;
  std::optional<trace::Seal> seal;
  bool sealed_at_server = false;
  std::string refused;          // not empty: the server will not have it
  int64_t refused_unix_ms = 0;  // 0: not known
  // Why the last try to send it failed, where another may not; empty: it went well, or there was
  // none. Since the first of the tries in a row that failed.
  std::string waits_because;
  int64_t waits_since_unix_ms = 0, tried_unix_ms = 0;
  protocol::AttemptFacts facts;

  bool complete() const { return seal.has_value() && sealed_at_server; }
  // It is to be sent: not refused, and the server does not have all of what is here.
  bool waits() const {
    return refused.empty() && (committed < chunks || (seal && !sealed_at_server));
  }
};

struct SpooledChunk {
  uint32_t seq = 0;
  Bytes bytes;
};

// How long recordings stay here that the server has.
struct Retention {
  std::chrono::hours age{7 * 24};  // since it has all of an attempt
  // Above this the ones it has had longest go earlier; 0: no bound. What goes before a week is over
  // cannot fill up a server that is restored from an older backup.
  uint64_t bytes = uint64_t{10} << 30;
};
struct Pruned {
  int attempts = 0;  // forgotten
  int early = 0;     // of these, before their time, because of `bytes`
};

// What is to be said of a pruning; empty: nothing.
std::string PrunedText(const Pruned& pruned, const Retention& retention);

// How long nothing has been recorded of an attempt.
struct Silence {
  int64_t ms = 0;
  // The machine's clock was set back by more than a second meanwhile: `ms` is by the time since it
  // was started, where it still runs, else it is too short.
  bool clock_stepped = false;
};

// Held while a recording is made or closed: one process at a time does that in a folder. The
// system lets go of it when the process ends, however it ends.
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
// Every Put returns only when the data would survive a power cut (WAL, synchronous = FULL).
// Thread safety: any thread; calls wait for each other. Real-time: never. One process records at a
// time (LockForRecording); others may read, and mark what the server has.
// Errors: kStorage (disk full, not writable, damaged: message says which and what to do; field
// kDamagedSpool), kVersion (made by a newer program), kConflict (contradicts what is stored),
// kNotFound.
class Spool {
 public:
  // Opens `folder`/spool.sqlite, creating both as needed.
  // Errors also: kStorage with field kLostSpool when the file is there and empty, or gone and its
  // log is there: it was not made so, and what was in it is lost.
  static Result<std::unique_ptr<Spool>> Open(const std::filesystem::path& folder);
  // Changes nothing, neither here nor on disk, and needs no right to write: to list, verify and
  // export, also beside a process that records. Of a damaged one what can be read is read. Errors:
  // kNotFound when there is none.
  static Result<std::unique_ptr<Spool>> OpenToRead(const std::filesystem::path& folder);
  ~Spool();
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;

  // Errors: kConflict while another process holds it.
  Result<RecordingLock> LockForRecording();
  // Before something is begun that will be recorded: a test write that has become durable, and at
  // least `room_bytes` free. Errors: kStorage (says how much there is and how much is needed).
  Status ProveWritable(uint64_t room_bytes);

  // The attempt's id is in the header. Idempotent for the same header: what else was said first
  // stays.
  Status BeginAttempt(const trace::Header& header, const std::string& exercise,
                      const std::string& profile, const protocol::AttemptFacts& facts = {});
  // The next chunk. Idempotent for the same bytes; another chunk under a used seq is kConflict.
  Status PutChunk(const Uuid& attempt, ByteView chunk);
  // The attempt goes on after a crash: it counts as resumed once more. Errors: kConflict when it
  // has a seal.
  Status MarkResumed(const Uuid& attempt);
  // The seal that fits the chunks that are here: the end of an attempt that was cut off. Returns
  // the one it has when it has one. Errors: kInvalidInput without a chunk.
  Result<trace::Seal> CloseAttempt(const Uuid& attempt);
  // End of the attempt. Idempotent for the same seal.
  Status PutSeal(const trace::Seal& seal);

  // The server has chunks below `next_seq` durably; those from it on it does not (a restored
  // backup forgets: they will be sent again).
  Status SetCommittedBelow(const Uuid& attempt, uint32_t next_seq);
  // It has chunk `seq` and all before it.
  Status MarkCommitted(const Uuid& attempt, uint32_t seq);
  Status MarkSealedAtServer(const Uuid& attempt);
  // The server does not have it any more, as a whole: it waits to be sent again.
  Status MarkWanted(const Uuid& attempt);
  // A try to send it failed for this reason, and another may not; empty: it went well.
  Status MarkTried(const Uuid& attempt, const std::string& problem);
  // The same of all that wait: the server could not be reached, or not be used.
  Status MarkAllTried(const std::string& problem);
  // Uploading it again is no use; it stays here for export.
  Status MarkRefused(const Uuid& attempt, const std::string& why);
  // It is tried again: the cause of the refusal has gone away.
  Status ClearRefusal(const Uuid& attempt);

  // In the order they were begun.
  Result<std::vector<SpooledAttempt>> List();
  Result<SpooledAttempt> Get(const Uuid& attempt);
  Result<Bytes> HeaderOf(const Uuid& attempt);
  // At most `limit` chunks from `seq` on, in order.
  Result<std::vector<SpooledChunk>> ChunksFrom(const Uuid& attempt, uint32_t seq, size_t limit);
  // The whole recording as one file's content (trace::EncodeTraceFile).
  Result<trace::TraceFile> Export(const Uuid& attempt);

  // When the last chunk became durable here; nothing when there is none, or it is of version 1.
  Result<std::optional<int64_t>> LastSpooledUnixMs(const Uuid& attempt);
  // Since then, or since it was begun. By the clock, or by the time since the machine was started,
  // whichever says more: a clock that was set back makes it no shorter while the machine runs.
  Result<Silence> SilenceOf(const Uuid& attempt);
  // Forgets attempts that the server has, as `retention` says; never one it does not have.
  Result<Pruned> Prune(const Retention& retention, std::chrono::system_clock::time_point now =
                                                       std::chrono::system_clock::now());

  // The tickets for later, and how the loops of its attempts went: under the same lock.
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
