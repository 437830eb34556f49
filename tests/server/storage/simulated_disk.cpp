#include "tests/server/storage/simulated_disk.h"

#include <sqlite3.h>

#include <algorithm>
#include <random>
#include <set>

#include "common/base/file.h"

namespace enamel::server::testing {

namespace fs = std::filesystem;

namespace {

constexpr int64_t kSectorBytes = 512;

// What SQLite allocates for each open file: ours, then the real one.
struct File {
  sqlite3_file base;
  SimulatedDisk* disk;
  std::string* path;  // relative; null: a temporary file, which is not remembered
  bool sync_folder;   // with the next sync
  sqlite3_file* real() { return reinterpret_cast<sqlite3_file*>(this + 1); }
};

File& Of(sqlite3_file* file) { return *reinterpret_cast<File*>(file); }

sqlite3_vfs* Real() { return sqlite3_vfs_find(nullptr); }

}  // namespace

// The functions behind the VFS; a struct for the sake of being a friend.
struct SimulatedVfs {
  static SimulatedDisk& DiskOf(sqlite3_vfs* vfs) {
    return *static_cast<SimulatedDisk*>(vfs->pAppData);
  }

  static int Close(sqlite3_file* file) {
    int rc = Of(file).real()->pMethods->xClose(Of(file).real());
    delete Of(file).path;
    return rc;
  }
  static int Read(sqlite3_file* file, void* into, int n, sqlite3_int64 at) {
    return Of(file).real()->pMethods->xRead(Of(file).real(), into, n, at);
  }
  static int Write(sqlite3_file* file, const void* from, int n, sqlite3_int64 at) {
    File& f = Of(file);
    if (f.path != nullptr && f.disk->before_write_) f.disk->before_write_(*f.path);
    sqlite3_int64 size = 0;
    f.real()->pMethods->xFileSize(f.real(), &size);
    if (!f.disk->Take(std::max<int64_t>(at + n - size, 0))) return SQLITE_FULL;
    int rc = f.real()->pMethods->xWrite(f.real(), from, n, at);
    if (rc == SQLITE_OK && f.path != nullptr) {
      f.disk->Record(SimulatedDisk::Kind::kWrite, *f.path, at,
                     {static_cast<const uint8_t*>(from), static_cast<size_t>(n)});
    }
    return rc;
  }
  static int Truncate(sqlite3_file* file, sqlite3_int64 size) {
    File& f = Of(file);
    sqlite3_int64 before = 0;
    f.real()->pMethods->xFileSize(f.real(), &before);
    int rc = f.real()->pMethods->xTruncate(f.real(), size);
    if (rc != SQLITE_OK) return rc;
    f.disk->Take(size - before);
    if (f.path != nullptr) f.disk->Record(SimulatedDisk::Kind::kTruncate, *f.path, size);
    return rc;
  }
  static int Sync(sqlite3_file* file, int) {
    File& f = Of(file);
    if (f.path == nullptr || f.disk->lying_) return SQLITE_OK;
    f.disk->Record(SimulatedDisk::Kind::kSync, *f.path);
    if (f.sync_folder) {
      f.disk->Record(SimulatedDisk::Kind::kSyncFolder, fs::path(*f.path).parent_path().string());
    }
    f.sync_folder = false;
    return SQLITE_OK;
  }
  static int FileSize(sqlite3_file* file, sqlite3_int64* size) {
    return Of(file).real()->pMethods->xFileSize(Of(file).real(), size);
  }
  static int Lock(sqlite3_file* file, int kind) {
    return Of(file).real()->pMethods->xLock(Of(file).real(), kind);
  }
  static int Unlock(sqlite3_file* file, int kind) {
    return Of(file).real()->pMethods->xUnlock(Of(file).real(), kind);
  }
  static int CheckReservedLock(sqlite3_file* file, int* out) {
    return Of(file).real()->pMethods->xCheckReservedLock(Of(file).real(), out);
  }
  static int FileControl(sqlite3_file* file, int what, void* argument) {
    return Of(file).real()->pMethods->xFileControl(Of(file).real(), what, argument);
  }
  static int SectorSize(sqlite3_file* file) {
    return Of(file).real()->pMethods->xSectorSize(Of(file).real());
  }
  static int DeviceCharacteristics(sqlite3_file* file) {
    return Of(file).real()->pMethods->xDeviceCharacteristics(Of(file).real());
  }
  static int ShmMap(sqlite3_file* file, int page, int size, int extend, void volatile** out) {
    return Of(file).real()->pMethods->xShmMap(Of(file).real(), page, size, extend, out);
  }
  static int ShmLock(sqlite3_file* file, int at, int n, int flags) {
    return Of(file).real()->pMethods->xShmLock(Of(file).real(), at, n, flags);
  }
  static void ShmBarrier(sqlite3_file* file) {
    Of(file).real()->pMethods->xShmBarrier(Of(file).real());
  }
  static int ShmUnmap(sqlite3_file* file, int remove) {
    return Of(file).real()->pMethods->xShmUnmap(Of(file).real(), remove);
  }

  static const sqlite3_io_methods& Methods() {
    // Version 2: with shared memory (the log's index), without mapped reads.
    static const sqlite3_io_methods methods = {2,
                                               Close,
                                               Read,
                                               Write,
                                               Truncate,
                                               Sync,
                                               FileSize,
                                               Lock,
                                               Unlock,
                                               CheckReservedLock,
                                               FileControl,
                                               SectorSize,
                                               DeviceCharacteristics,
                                               ShmMap,
                                               ShmLock,
                                               ShmBarrier,
                                               ShmUnmap,
                                               nullptr,
                                               nullptr};
    return methods;
  }

  static int Open(sqlite3_vfs* vfs, const char* name, sqlite3_file* file, int flags, int* out) {
    File& f = Of(file);
    f.base.pMethods = nullptr;
    f.disk = &DiskOf(vfs);
    f.path = nullptr;
    f.sync_folder = false;
    std::error_code error;
    bool fresh = name != nullptr && !fs::exists(name, error);
    int rc = Real()->xOpen(Real(), name, f.real(), flags, out);
    if (rc != SQLITE_OK) return rc;
    f.base.pMethods = &Methods();
    if (name == nullptr) return rc;
    f.path = new std::string(f.disk->Relative(name));
    if (!fresh) return rc;
    f.disk->Record(SimulatedDisk::Kind::kCreate, *f.path);
    f.sync_folder =
        (flags & (SQLITE_OPEN_WAL | SQLITE_OPEN_MAIN_JOURNAL | SQLITE_OPEN_SUPER_JOURNAL)) != 0;
    return rc;
  }
  static int Delete(sqlite3_vfs* vfs, const char* name, int sync_folder) {
    SimulatedDisk& disk = DiskOf(vfs);
    std::error_code error;
    auto size = fs::file_size(name, error);
    int rc = Real()->xDelete(Real(), name, 0);
    if (rc != SQLITE_OK) return rc;
    if (!error) disk.Take(-static_cast<int64_t>(size));
    std::string path = disk.Relative(name);
    disk.Record(SimulatedDisk::Kind::kDelete, path);
    if (sync_folder != 0) {
      disk.Record(SimulatedDisk::Kind::kSyncFolder, fs::path(path).parent_path().string());
    }
    return rc;
  }
  static int Access(sqlite3_vfs*, const char* name, int flags, int* out) {
    return Real()->xAccess(Real(), name, flags, out);
  }
  static int FullPathname(sqlite3_vfs*, const char* name, int n, char* out) {
    return Real()->xFullPathname(Real(), name, n, out);
  }
  static int Randomness(sqlite3_vfs*, int n, char* out) {
    return Real()->xRandomness(Real(), n, out);
  }
  static int Sleep(sqlite3_vfs*, int us) { return Real()->xSleep(Real(), us); }
  static int CurrentTime(sqlite3_vfs*, double* out) { return Real()->xCurrentTime(Real(), out); }
  static int GetLastError(sqlite3_vfs*, int n, char* out) {
    return Real()->xGetLastError(Real(), n, out);
  }
};

// Replays the log, tracking the visible and the durable content.
class SimulatedDisk::Replay {
 public:
  Replay(Unsynced unsynced, uint32_t seed) : torn_(unsynced == Unsynced::kTorn), random_(seed) {}

  void Do(const Operation& op) {
    switch (op.kind) {
      case Kind::kCreate:
      case Kind::kPut:
        names_[op.path] = contents_.size();
        contents_.push_back({op.bytes, {}});
        break;
      case Kind::kWrite:
      case Kind::kTruncate:
        Of(op.path).unsynced.push_back(&op);
        break;
      case Kind::kSync:
        for (const Operation* write : Of(op.path).unsynced) Apply(*write, Of(op.path).durable);
        Of(op.path).unsynced.clear();
        break;
      case Kind::kDelete:
        names_.erase(op.path);
        break;
      case Kind::kMakeFolder:
        folders_.insert(op.path);
        break;
      case Kind::kSyncFolder:
        SyncNames(op.path);
        break;
    }
  }

  void Write(const fs::path& target) {
    std::map<std::string, size_t> names = durable_names_;
    std::set<std::string> folders = durable_folders_;
    if (torn_) KeepSome(names, folders);
    for (const std::string& folder : folders) {
      if (HasFolders(folder, folders)) fs::create_directories(target / folder);
    }
    for (const auto& [name, content] : names) {
      if (!HasFolders(name, folders)) continue;
      Bytes bytes = contents_[content].durable;
      if (torn_) {
        for (const Operation* write : contents_[content].unsynced) ApplySome(*write, bytes);
      }
      if (!WriteFileDurably(target / name, bytes).ok()) std::abort();
    }
  }

 private:
  struct ContentState {
    Bytes durable;
    std::vector<const Operation*> unsynced;
  };

  ContentState& Of(const std::string& path) { return contents_.at(names_.at(path)); }

  static bool Within(const std::string& path, const std::string& folder) {
    return fs::path(path).parent_path().string() == folder;
  }

  void SyncNames(const std::string& folder) {
    std::erase_if(durable_names_, [&](const auto& name) {
      return Within(name.first, folder) && !names_.contains(name.first);
    });
    for (const auto& [name, content] : names_) {
      if (Within(name, folder)) durable_names_[name] = content;
    }
    for (const std::string& name : folders_) {
      if (Within(name, folder)) durable_folders_.insert(name);
    }
  }

  void KeepSome(std::map<std::string, size_t>& names, std::set<std::string>& folders) {
    for (const std::string& folder : folders_) {
      if (Coin()) folders.insert(folder);
    }
    for (const auto& [name, content] : names_) {
      if (Coin()) names[name] = content;
    }
    std::erase_if(names, [&](const auto& name) { return !names_.contains(name.first) && Coin(); });
  }

  static bool HasFolders(const std::string& path, const std::set<std::string>& folders) {
    for (fs::path at = fs::path(path).parent_path(); !at.empty(); at = at.parent_path()) {
      if (!folders.contains(at.string())) return false;
    }
    return true;
  }

  static void Apply(const Operation& op, Bytes& content) {
    auto at = static_cast<size_t>(op.at);
    if (op.kind == Kind::kTruncate) {
      content.resize(at);
      return;
    }
    content.resize(std::max(content.size(), at + op.bytes.size()));
    std::ranges::copy(op.bytes, content.begin() + op.at);
  }

  void ApplySome(const Operation& op, Bytes& content) {
    if (op.kind == Kind::kTruncate) {
      if (Coin()) Apply(op, content);
      return;
    }
    auto size = static_cast<int64_t>(op.bytes.size());
    for (int64_t from = 0; from < size;) {
      int64_t to = std::min(size, ((op.at + from) / kSectorBytes + 1) * kSectorBytes - op.at);
      if (Coin()) {
        Apply({Kind::kWrite, op.path, op.at + from,
               Bytes(op.bytes.begin() + from, op.bytes.begin() + to)},
              content);
      }
      from = to;
    }
  }

  bool Coin() { return (random_() & 1) != 0; }

  const bool torn_;
  std::mt19937 random_;
  std::vector<ContentState> contents_;
  std::map<std::string, size_t> names_, durable_names_;
  std::set<std::string> folders_, durable_folders_;
};

SimulatedDisk::SimulatedDisk(fs::path folder)
    : folder_(std::move(folder)), vfs_(std::make_unique<sqlite3_vfs>()) {
  static std::atomic<int> count{0};
  name_ = "simulated-" + std::to_string(++count);
  *vfs_ = sqlite3_vfs{};
  vfs_->iVersion = 1;
  vfs_->szOsFile = static_cast<int>(sizeof(File)) + Real()->szOsFile;
  vfs_->mxPathname = Real()->mxPathname;
  vfs_->zName = name_.c_str();
  vfs_->pAppData = this;
  vfs_->xOpen = SimulatedVfs::Open;
  vfs_->xDelete = SimulatedVfs::Delete;
  vfs_->xAccess = SimulatedVfs::Access;
  vfs_->xFullPathname = SimulatedVfs::FullPathname;
  vfs_->xRandomness = SimulatedVfs::Randomness;
  vfs_->xSleep = SimulatedVfs::Sleep;
  vfs_->xCurrentTime = SimulatedVfs::CurrentTime;
  vfs_->xGetLastError = SimulatedVfs::GetLastError;
  sqlite3_vfs_register(vfs_.get(), 0);
}

SimulatedDisk::~SimulatedDisk() { sqlite3_vfs_unregister(vfs_.get()); }

size_t SimulatedDisk::operations() const {
  std::lock_guard lock(mutex_);
  return log_.size();
}

void SimulatedDisk::CutAfter(size_t operations, Unsynced unsynced, uint32_t seed,
                             const fs::path& target) const {
  std::lock_guard lock(mutex_);
  Replay replay(unsynced, seed);
  for (size_t i = 0; i < operations; ++i) replay.Do(log_.at(i));
  replay.Write(target);
}

void SimulatedDisk::SetFree(std::optional<uint64_t> bytes) {
  std::lock_guard lock(mutex_);
  free_ = bytes;
}

std::string SimulatedDisk::Relative(const fs::path& path) const {
  std::string out = path.lexically_relative(folder_).generic_string();
  return out == "." ? "" : out;
}

void SimulatedDisk::Record(Kind kind, const std::string& path, int64_t at, ByteView bytes) {
  std::lock_guard lock(mutex_);
  log_.push_back({kind, path, at, Bytes(bytes.begin(), bytes.end())});
}

bool SimulatedDisk::Take(int64_t bytes) {
  std::lock_guard lock(mutex_);
  if (!free_) return true;
  if (bytes > 0 && static_cast<uint64_t>(bytes) > *free_) return false;
  *free_ -= static_cast<uint64_t>(bytes);
  return true;
}

Status SimulatedDisk::Replace(const fs::path& path, ByteView data) {
  if (!Take(static_cast<int64_t>(data.size())))
    return Status(Code::kStorage, "cannot write " + path.string() + ": no space left on device");
  ENAMEL_RETURN_IF_ERROR(SystemDisk().Replace(path, data));
  Record(Kind::kPut, Relative(path), 0, data);
  Record(Kind::kSyncFolder, Relative(path.parent_path()));
  return Status::Ok();
}

Status SimulatedDisk::MakeFolder(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(MakeFolder(path.parent_path()));
  ENAMEL_RETURN_IF_ERROR(SystemDisk().MakeFolder(path));
  Record(Kind::kMakeFolder, Relative(path));
  return SyncFolder(path.parent_path());
}

Status SimulatedDisk::SyncFolder(const fs::path& path) {
  Record(Kind::kSyncFolder, Relative(path));
  return Status::Ok();
}

Status SimulatedDisk::Remove(const fs::path& path) {
  std::error_code error;
  auto size = fs::file_size(path, error);
  if (error) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(SystemDisk().Remove(path));
  Take(-static_cast<int64_t>(size));
  Record(Kind::kDelete, Relative(path));
  return SyncFolder(path.parent_path());
}

Status SimulatedDisk::Shred(const fs::path& path) {
  std::error_code error;
  auto size = fs::file_size(path, error);
  if (error) return Status::Ok();
  Record(Kind::kWrite, Relative(path), 0, Bytes(size, 0));
  Record(Kind::kSync, Relative(path));
  return Remove(path);
}

Result<Disk::Content> SimulatedDisk::Hash(const fs::path& path) { return SystemDisk().Hash(path); }

Result<Disk::Copied> SimulatedDisk::Copy(const fs::path& from, const fs::path& to, bool link) {
  return SystemDisk().Copy(from, to, link);
}

Status SimulatedDisk::SyncAll(const fs::path&) { return Status::Ok(); }

Result<uint64_t> SimulatedDisk::FreeBytes(const fs::path&) {
  std::lock_guard lock(mutex_);
  return free_.value_or(UINT64_MAX);
}

}  // namespace enamel::server::testing
