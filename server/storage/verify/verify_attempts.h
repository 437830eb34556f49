#pragma once

#include <optional>
#include <set>

#include "common/sql/db.h"
#include "common/trace/trace.h"
#include "server/storage/blobs/blobs.h"
#include "server/storage/keys/folder_keyring.h"
#include "server/storage/verify/verify.h"

namespace enamel::server {

// A folder's blobs, and the keys that open them.
struct StoredBlobs {
  FolderBlobs blobs;
  FolderKeyring keyring;
  bool has_keys = false;   // false: the keys are kept apart, and personal blobs are not opened
  std::set<Sha256> bad{};  // damaged, or not opened by their person's key: found already
};

// Compares every attempt with its recording: header with its ticket, the ticket with the server's
// key, each chunk with the previous one, its signature with the station's key, the row's counts and
// head with the chain, the seal. `key`: this server's ticket key; none: the tickets' signatures are
// not checked. Adds to the report's findings and counts.
Status CheckAttempts(sql::Db& db, StoredBlobs& stored, const std::optional<trace::PublicKey>& key,
                     VerifyReport& report, const UpkeepProgress& progress);

}  // namespace enamel::server
