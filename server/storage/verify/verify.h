#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/result.h"
#include "server/storage/audit/audit_row.h"

namespace enamel::server {

// Called now and then on the calling thread: the current step ("blobs"), how much of how much.
// `all` is 0 if unknown.
using UpkeepProgress = std::function<void(const std::string& what, uint64_t done, uint64_t all)>;

// One disagreement.
struct Finding {
  std::string kind;    // "database", "blob", "chain", "signature", "seal", "ticket", "key",
                       // "erasure", "file", "result", "timeline", "audit", "decision"
  std::string object;  // the attempt's id, the blob's hash, the file's path, the audit row's id
  std::string expected, found;
  std::string remedy;
};

inline constexpr char kFromBackup[] = "restore a backup that has it";  // most findings' remedy

struct VerifyOptions {
  std::filesystem::path folder;   // data folder, in use or not, or backup
  std::filesystem::path keyring;  // empty: the folder's own
  UpkeepProgress progress{};
  // An earlier backup, which the audit trail must continue; empty: none.
  std::filesystem::path since{};
  bool must_be_backup = false;  // `folder` is no data folder
};

struct VerifyReport {
  bool is_backup = false;
  int schema = 0;
  uint64_t blobs = 0, blob_bytes = 0, unnamed_blobs = 0, unnamed_bytes = 0;
  uint64_t people = 0, attempts = 0, sealed = 0, chunks = 0, ticks = 0, keys = 0, erased = 0;
  uint64_t results = 0;  // of scoring runs
  uint64_t audit_rows = 0;
  std::vector<AuditHead> trail;  // where the audit trail ends, in each chain
  uint64_t decisions = 0;        // compared with the trail
  std::vector<Finding> findings;
  std::vector<std::string> notes;  // what could not be looked at, and why; what is odd and harmless

  void Find(std::string kind, std::string object, std::string expected, std::string found,
            std::string remedy) {
    findings.push_back({std::move(kind), std::move(object), std::move(expected), std::move(found),
                        std::move(remedy)});
  }
};

// Reads everything and compares:
// * the database with itself (integrity_check, foreign keys) and with the schema's version
// * every blob with its name; every blob that a row names with the stored ones
// * every attempt: header with its ticket, the ticket with the server's key, each chunk with the
//   previous one, its signature with the station's key, the row's counts and head with the chain,
//   the seal
// * each result with its signed document, and that with recording, exercise and reference
//   (schemas/result.md)
// * each row of the audit trail with its signature and its place, the trail with the end in an
//   earlier backup, decisions with the trail, the state of each attempt with its stored parts
//   (schemas/audit.md)
// * the key ring with the people: a key for all data encrypted under one, none for the erased
// * a backup's files with its manifest
// Findings in a data folder are checked again while nothing may be removed from it, so that a
// person who is being erased meanwhile is no damage. Changes nothing. Errors: kNotFound (the folder
// is empty), kInvalidInput (`since`, or what must be one, is no finished backup), kVersion (a newer database). Every disagreement
// is a finding.
Result<VerifyReport> Verify(const VerifyOptions& options);

}  // namespace enamel::server
