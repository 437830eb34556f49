#include "server/storage/recordings/stored_blobs.h"

#include "server/storage/keys/keyring.h"

namespace enamel::server {
Result<Sha256> StoredBlobs::PutBlob(ByteView data) {
  ENAMEL_RETURN_IF_ERROR(gate_.Check());
  return blobs_.Put(data);
}

Result<Sha256> StoredBlobs::PutAttemptBlob(const Uuid& attempt, ByteView data) {
  ENAMEL_RETURN_IF_ERROR(gate_.Check());
  ENAMEL_ASSIGN_OR_RETURN(auto key, keys_.KeyOf(attempt));
  return blobs_.Put(SealPersonal(key.person, key.key, attempt, data));
}

Result<Sha256> StoredBlobs::PutAttemptText(const Uuid& attempt, std::string_view text) {
  ENAMEL_RETURN_IF_ERROR(gate_.Check());
  ENAMEL_ASSIGN_OR_RETURN(auto key, keys_.KeyOf(attempt));
  return blobs_.Put(SealPacked(key.person, key.key, attempt, AsBytes(text)));
}

Result<Bytes> StoredBlobs::GetBlob(const Sha256& hash) {
  auto bytes = blobs_.Get(hash);
  ENAMEL_RETURN_IF_ERROR(bytes.status());
  return OpenPersonal(keyring_, std::move(bytes).value());
}

bool StoredBlobs::HasBlob(const Sha256& hash) { return blobs_.Has(hash); }

}  // namespace enamel::server
