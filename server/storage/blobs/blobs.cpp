#include "server/storage/blobs/blobs.h"

#include <algorithm>

#include "common/base/file.h"

namespace enamel::server {

namespace fs = std::filesystem;

fs::path FolderBlobs::PathOf(const Sha256& hash) const {
  std::string hex = hash.Hex();
  return folder_ / hex.substr(0, 2) / hex;
}

Result<Sha256> FolderBlobs::Put(ByteView data) {
  // Named by its content: the same twice is one file, and a name that fits proves the content.
  Sha256 hash = HashSha256(data);
  fs::path path = PathOf(hash);
  bool there = false;
  {
    // Against RemoveIfOlder, which must not remove between the look and the touch.
    MutexLock lock(mutex_);
    std::error_code error;
    there = fs::exists(path, error);
    // Fresh again, for RemoveIfOlder.
    if (there) fs::last_write_time(path, fs::file_time_type::clock::now(), error);
    if (!there && fail_next_ && fail_next_()) return Status(Code::kStorage, "injected failure");
    if (!there) ENAMEL_RETURN_IF_ERROR(disk_.MakeFolder(path.parent_path()));
  }
  // One that the disk has lost a part of is written again. An intact one may have been left unsynced
  // by a process that was killed, or by another thread.
  there = there && Get(hash).ok();
  ENAMEL_RETURN_IF_ERROR(there ? disk_.SyncFolder(path.parent_path()) : disk_.Replace(path, data));
  return hash;
}

Result<Bytes> FolderBlobs::Get(const Sha256& hash) const {
  auto data = ReadFile(PathOf(hash));
  if (!data.ok()) {
    if (data.status().code() != Code::kNotFound) return data.status();
    return Status(Code::kNotFound, "no blob " + hash.Hex());
  }
  // On every read: a disk that flips a bit must not change a grade unnoticed.
  if (HashSha256(*data) != hash) {
    return Status(Code::kStorage, "blob " + hash.Hex() + " is damaged; restore it from a backup");
  }
  return data;
}

bool FolderBlobs::Has(const Sha256& hash) const {
  std::error_code error;
  return fs::exists(PathOf(hash), error);
}

Result<std::vector<Blobs::Freed>> FolderBlobs::Free(sql::Db&, const std::set<Sha256>& hashes) {
  std::vector<Freed> out;
  for (const Sha256& hash : hashes) out.push_back({hash});
  return out;
}

Result<size_t> FolderBlobs::Remove(const std::vector<Freed>& freed) {
  if (freed.empty()) return size_t{0};
  ENAMEL_ASSIGN_OR_RETURN(const auto named, named_());
  size_t removed = 0;
  for (const auto& [hash, generation] : freed) {
    if (named.contains(hash) || !Has(hash)) continue;
    MutexLock lock(mutex_);
    ENAMEL_RETURN_IF_ERROR(disk_.Remove(PathOf(hash)));
    ++removed;
  }
  return removed;
}

Result<size_t> FolderBlobs::Sweep(std::chrono::seconds age) {
  ENAMEL_ASSIGN_OR_RETURN(const auto listing, List());
  // Read after the list: whatever is on it and was named meanwhile is not swept.
  ENAMEL_ASSIGN_OR_RETURN(const auto named, named_());
  size_t removed = 0;
  for (const Sha256& blob : listing.blobs) {
    if (named.contains(blob)) continue;
    ENAMEL_ASSIGN_OR_RETURN(auto gone, RemoveIfOlder(blob, age));
    removed += gone ? 1 : 0;
  }
  return removed;
}

Result<bool> FolderBlobs::RemoveIfOlder(const Sha256& hash, std::chrono::seconds age) {
  MutexLock lock(mutex_);
  std::error_code error;
  auto put = fs::last_write_time(PathOf(hash), error);
  if (error || fs::file_time_type::clock::now() - put < age) return false;
  ENAMEL_RETURN_IF_ERROR(disk_.Remove(PathOf(hash)));
  return true;
}

Result<FolderBlobs::Listing> FolderBlobs::List() const {
  Listing out;
  std::error_code error;
  fs::recursive_directory_iterator it(folder_, error), end;
  for (; !error && it != end; it.increment(error)) {
    if (it->is_directory(error)) continue;
    auto hash = Sha256::FromHex(it->path().filename().string());
    if (hash.ok() && PathOf(*hash) == it->path()) {
      out.blobs.push_back(*hash);
    } else {
      out.others.push_back(it->path());
    }
  }
  // Made with the first blob.
  if (error && error != std::errc::no_such_file_or_directory) {
    return Status(Code::kStorage, "cannot read the folder " + folder_.string() + ": " +
                                      error.message() + "; make it readable for this user");
  }
  std::ranges::sort(out.blobs);
  std::ranges::sort(out.others);
  return out;
}

}  // namespace enamel::server
