#pragma once

#include <memory>
#include <string>

#include "common/base/result.h"
#include "server/storage/folder/store_options.h"
#include "server/storage/store.h"

// Opens a store: chooses the engine of its rows, and the places of its blobs and keys.
namespace enamel::server {

// The embedded store: DIR/enamel.db (SQLite, WAL, synchronous=FULL), DIR/blobs/xx/<sha256> and
// DIR/keyring (keyring.h), under whose keys everything is kept that shows a person's motion.
// DIR/ticket.key, made when absent, signs every row of the audit trail (schemas/audit.md).
//
// Chunks of an unsealed attempt are rows; SealAttempt moves them into write-once blobs.
//
// Errors: kStorage (folder not writable, disk full, database damaged), kUnavailable (another server
// holds the folder), kVersion (database made by a newer enamel-server), kInvalidInput (ticket.key
// is no key).
Result<std::unique_ptr<Store>> OpenSqliteStore(const StoreOptions& options);

struct PostgresOptions {
  // libpq's: "postgresql://user@host1,host2/name" or "host=… user=… dbname=…". Several hosts: the
  // one that takes writes is found.
  std::string server;
  // The PostgreSQL schema for the tables; created if it is missing. Empty: the user's own.
  std::string schema{};
  // Blobs, key ring and keys; SQLite's options do not count here.
  StoreOptions folder{};
};

// The same store with its rows in PostgreSQL 15 instead of enamel.db. Errors also:
// kUnavailable (the server or its client library is missing).
Result<std::unique_ptr<Store>> OpenPostgresStore(const PostgresOptions& options);
// Whether a server already has its rows there. Creates nothing. Errors: those of OpenPostgresStore.
Result<bool> HasServers(const PostgresOptions& options);

// The store of a data folder. Its rows are in PostgreSQL, its blobs and keys in S3 stores, if the
// folder's database.json names them (folder/database_file.h); otherwise in enamel.db, blobs/ and
// keyring/. Does not connect to the store of blobs yet. With `hold_lock` it asks the store of keys
// whether it forgets deleted objects, and who was erased. Either may be unreachable while a server
// starts.
Result<std::unique_ptr<Store>> OpenStore(const StoreOptions& options);

}  // namespace enamel::server
