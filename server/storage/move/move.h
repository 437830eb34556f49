#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "server/storage/folder/disk.h"
#include "server/storage/school/school_tables.h"
#include "server/storage/verify/verify.h"

// A school's way from one place to another: from rows, blobs and keys in a data folder to
// PostgreSQL and S3 stores, back, or to another folder.
namespace enamel::server {

// Makes the new folder, with the mark MOVE-UNFINISHED, on which no server starts; again after a try
// that was broken off. What says where its rows, blobs and keys are (database_file.h) comes after
// it, then the files of the identity, then MoveSchool. Errors: kConflict (there is something else,
// or a move from another folder), kStorage.
Status BeginMove(const std::filesystem::path& from, const std::filesystem::path& to, Disk& disk);

struct MoveOptions {
  std::filesystem::path from;  // a data folder; no server runs on it, nor on its database
  std::filesystem::path to;    // BeginMove made it
  bool accept_damage = false;  // go on without blobs that are missing or damaged
  UpkeepProgress progress{};
  Disk* disk = nullptr;  // null: the machine's
};

struct MoveReport {
  std::vector<TableDigest> tables;  // as they are in both places
  uint64_t blobs = 0, bytes = 0;
  uint64_t there_before = 0;      // of the blobs: an earlier try put them there
  uint64_t keys = 0, erased = 0;  // people
  std::vector<Sha256> missing;    // blobs that are missing or damaged in the old place
};

// Moves rows first, in one transaction, then blobs, then keys. It compares the rows of each table
// by hash, reads back each blob by its hash and each key, and checks at the end that the old place
// has not changed. Nothing is deleted there; it gets the mark MOVED, with which no server and no
// command starts there. After an error or a crash, the same call continues and keeps the moved
// data.
//
// Errors: kConflict (a server runs, or the new place has other rows), kUnavailable (a store is
// unreachable: try again), kStorage (`missing`, and not accepted; or data read back differs),
// kInvalidInput (both in PostgreSQL: use its own tools).
Result<MoveReport> MoveSchool(const MoveOptions& options);

}  // namespace enamel::server
