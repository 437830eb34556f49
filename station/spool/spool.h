#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "common/trace/trace.h"

namespace enamel::station {

// What the spool knows of one attempt.
struct SpooledAttempt {
  Uuid id;
  std::string exercise, profile;
  int64_t created_unix_ms = 0;
  uint32_t chunks = 0;
  uint32_t committed = 0;  // chunks the server has durably
  uint64_t ticks = 0, gap_ticks = 0;
  uint64_t bytes = 0;
  std::optional<trace::Seal> seal;
  bool sealed_at_server = false;
  std::string refused;  // not empty: the server will not have it

  bool complete() const { return seal.has_value() && sealed_at_server; }
};

struct SpooledChunk {
  uint32_t seq = 0;
  Bytes bytes;
};

// What Verify found in one attempt.
struct SpoolVerdict {
  SpooledAttempt attempt;
  Status status;  // first thing that is wrong, or ok
};

// Recordings on the station's disk: durable before they are sent, kept until the server has had
// them for a week (schemas/sql/station_spool.sql).
//
// Every Put returns only when the data would survive a power cut (WAL, synchronous = FULL).
// Thread safety: any thread; calls wait for each other. Real-time: never. One process writes at a
// time; another may read.
// Errors: kStorage (disk full, not writable, damaged: message says which and what to do), kVersion
// (made by a newer program), kConflict (contradicts what is stored), kNotFound.
class Spool {
 public:
  // Opens `folder`/spool.sqlite, creating both as needed.
  static Result<std::unique_ptr<Spool>> Open(const std::filesystem::path& folder);
  ~Spool();
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;

  // The attempt's id is in the header. Idempotent for the same header.
  Status BeginAttempt(const trace::Header& header, const std::string& exercise,
                      const std::string& profile);
  // The next chunk. Idempotent for the same bytes; another chunk under a used seq is kConflict.
  Status PutChunk(const Uuid& attempt, ByteView chunk);
  // End of the attempt. Idempotent for the same seal.
  Status PutSeal(const trace::Seal& seal);

  // The server has chunks below `next_seq` durably; those from it on it does not (a restored
  // backup forgets: they will be sent again).
  Status SetCommittedBelow(const Uuid& attempt, uint32_t next_seq);
  Status MarkCommitted(const Uuid& attempt, uint32_t seq);
  Status MarkSealedAtServer(const Uuid& attempt);
  // Uploading it again is no use; it stays here for export.
  Status MarkRefused(const Uuid& attempt, const std::string& why);

  Result<std::vector<SpooledAttempt>> List();
  Result<SpooledAttempt> Get(const Uuid& attempt);
  Result<Bytes> HeaderOf(const Uuid& attempt);
  // At most `limit` chunks from `seq` on, in order.
  Result<std::vector<SpooledChunk>> ChunksFrom(const Uuid& attempt, uint32_t seq, size_t limit);
  // The whole recording as one file's content (trace::EncodeTraceFile).
  Result<trace::TraceFile> Export(const Uuid& attempt);

  // Database pages, chain, signatures (when `station_key` is given) and seal of every attempt.
  Result<std::vector<SpoolVerdict>> Verify(const std::optional<trace::PublicKey>& station_key);
  // Forgets attempts the server has had completely for `age`. Returns how many.
  Result<int> Prune(std::chrono::milliseconds age,
                    std::chrono::system_clock::time_point now = std::chrono::system_clock::now());

  const std::filesystem::path& file() const;

 private:
  struct Db;
  explicit Spool(std::unique_ptr<Db> db);
  std::mutex mutex_;
  std::unique_ptr<Db> db_;
};

}  // namespace enamel::station
