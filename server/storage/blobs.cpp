#include "server/storage/blobs.h"

#include <fcntl.h>
#include <unistd.h>

#include "common/base/file.h"

namespace enamel::server::sqlite {
namespace {

// Makes a new entry of `folder` survive a power cut.
void SyncFolder(const std::filesystem::path& folder) {
  int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  ::fsync(fd);
  ::close(fd);
}

}  // namespace

std::filesystem::path Blobs::PathOf(const Sha256& hash) const {
  std::string hex = hash.Hex();
  return folder_ / hex.substr(0, 2) / hex;
}

Result<Sha256> Blobs::Put(ByteView data) {
  Sha256 hash = HashSha256(data);
  std::filesystem::path path = PathOf(hash);
  std::lock_guard lock(mutex_);
  std::error_code error;
  if (std::filesystem::exists(path, error)) return hash;
  if (fail_next_ && fail_next_()) return Status(Code::kStorage, "injected failure");
  if (std::filesystem::create_directories(path.parent_path(), error)) SyncFolder(folder_);
  if (error) {
    return Status(Code::kStorage,
                  "cannot make " + path.parent_path().string() + ": " + error.message());
  }
  ENAMEL_RETURN_IF_ERROR(WriteFileDurably(path, data, 0600));
  return hash;
}

Result<Bytes> Blobs::Get(const Sha256& hash) const {
  auto data = ReadFile(PathOf(hash));
  if (!data.ok()) {
    if (data.status().code() != Code::kNotFound) return data.status();
    return Status(Code::kNotFound, "no blob " + hash.Hex());
  }
  if (HashSha256(*data) != hash) {
    return Status(Code::kStorage, "blob " + hash.Hex() + " is damaged; restore it from a backup");
  }
  return data;
}

bool Blobs::Has(const Sha256& hash) const {
  std::error_code error;
  return std::filesystem::exists(PathOf(hash), error);
}

}  // namespace enamel::server::sqlite
