#include "station/uplink/blob_cache.h"

#include "common/base/file.h"
#include "station/uplink/private_folder.h"

namespace enamel::station {

std::optional<Bytes> BlobCache::Find(const Sha256& name) const {
  auto bytes = ReadFile(folder_ / name.Hex());
  if (!bytes.ok() || HashSha256(*bytes) != name) return std::nullopt;
  return std::move(*bytes);
}

Status BlobCache::Put(const Sha256& name, ByteView data) const {
  ENAMEL_CHECK(HashSha256(data) == name);
  ENAMEL_RETURN_IF_ERROR(MakePrivateFolder(folder_));
  return WriteFileDurably(folder_ / name.Hex(), data);
}

}  // namespace enamel::station
