#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "common/base/uuid.h"
#include "common/trace/trace.h"
#include "server/s3/s3_client.h"
#include "server/storage/attempts/lease_owner.h"
#include "server/storage/audit/audit_row.h"
#include "server/storage/blobs/blobs.h"
#include "server/storage/engine/database_look.h"
#include "server/storage/engine/recording_gate.h"
#include "server/storage/engine/rewrite.h"
#include "server/storage/engine/transactions.h"
#include "server/storage/folder/folder_lock.h"
#include "server/storage/folder/space_guard.h"
#include "server/storage/folder/store_options.h"
#include "server/storage/keys/keyring.h"
#include "server/storage/keys/master_key.h"
#include "server/storage/recordings/attempt_keys.h"
#include "server/storage/recordings/ingest_counters.h"
#include "server/storage/recordings/sealed_rows.h"

namespace enamel::server {

// The objects under a store's rows, in the order of their construction.
struct StoreEngine {
  // S3 clients and the key that wraps keys; none: blobs and keys are in the folder.
  struct Buckets {
    std::unique_ptr<s3::S3Client> blobs, keys;
    std::optional<MasterKey> master;
  };
  // `id` is zero where no other server has its rows in this database.
  StoreEngine(const StoreOptions& options, Transactions::Connections connections, FolderLock lock,
              const trace::SecretKey& ticket_key, const Uuid& id, Buckets buckets);

  const std::filesystem::path folder;
  const FolderLock lock;
  const trace::SecretKey ticket_key;
  const size_t part_bytes;   // StoreOptions::trace_part_bytes
  const AuditSigner signer;  // goes with every connection that writes
  SpaceGuard space;
  Transactions rows;
  Rewriter rewriter;
  DatabaseLook look;
  RecordingGate gate;
  const std::unique_ptr<Blobs> blobs;
  const std::unique_ptr<Keyring> keyring;
  AttemptKeys keys;
  LeaseOwner owner;
  IngestCounters counters;
  std::optional<SealedRows> sealed;  // the server's; others' rows go with the seal
};

}  // namespace enamel::server
