#pragma once

#include <cstdint>
#include <filesystem>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"

namespace enamel::server {

// The store's disk operations, except the database's own, which use SQLite's VFS
// (StoreOptions::vfs). At these two seams tests cut the power and fill the disk. Each call but Copy
// is durable when it returns Ok. Errors: kStorage, with the remedy if known. Thread safety: any
// thread.
class Disk {
 public:
  virtual ~Disk() = default;
  // As WriteFileDurably (common/base/file.h), mode 0600: old content or new, never a mixture.
  virtual Status Replace(const std::filesystem::path& path, ByteView data) = 0;
  // Creates the folder and missing parents; mode 0700.
  virtual Status MakeFolder(const std::filesystem::path& path) = 0;
  // Entries of the folder survive a power cut from now on.
  virtual Status SyncFolder(const std::filesystem::path& path) = 0;
  // Absent: nothing to do.
  virtual Status Remove(const std::filesystem::path& path) = 0;
  // Overwrites the content in place before removing it. A drive may still keep an older copy of a
  // block: only the drive can rule that out.
  virtual Status Shred(const std::filesystem::path& path) = 0;
  // A file's content, read piece by piece. Errors: kNotFound (absent, or cannot be read).
  struct Content {
    Sha256 hash;
    uint64_t bytes = 0;
  };
  virtual Result<Content> Hash(const std::filesystem::path& path) = 0;
  // Copies a file, or links it where the file system can and `link` allows; tells its content,
  // which is read from `from` either way. Not durable before SyncAll. `to` must not exist. Errors:
  // kNotFound (`from` is absent or cannot be read), kStorage (`to`).
  struct Copied : Content {
    bool linked = false;
  };
  virtual Result<Copied> Copy(const std::filesystem::path& from, const std::filesystem::path& to,
                              bool link) = 0;
  // Makes everything durable that was written to the folder's file system so far.
  virtual Status SyncAll(const std::filesystem::path& folder) = 0;
  // What this user may still write there.
  virtual Result<uint64_t> FreeBytes(const std::filesystem::path& folder) = 0;
};

// The machine's own. Never destroyed.
Disk& SystemDisk();

}  // namespace enamel::server
