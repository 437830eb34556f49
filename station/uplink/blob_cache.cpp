#include "station/uplink/blob_cache.h"

#include "common/base/file.h"

namespace enamel::station {

std::optional<Bytes> BlobCache::Find(const Sha256& name) const {
  auto bytes = ReadFile(folder_ / name.Hex());
  if (!bytes.ok() || HashSha256(*bytes) != name) return std::nullopt;
  return std::move(*bytes);
}

Status BlobCache::Put(const Sha256& name, ByteView data) const {
  ENAMEL_CHECK(HashSha256(data) == name);
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) {
    return Status(Code::kStorage,
                  "cannot create the folder " + folder_.string() + " (" + error.message() + ")");
  }
  return WriteFileDurably(folder_ / name.Hex(), data);
}

}  // namespace enamel::station
