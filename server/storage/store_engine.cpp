#include "server/storage/store_engine.h"

#include <utility>

#include "server/storage/blobs/named_blobs.h"
#include "server/storage/blobs/s3_blobs.h"
#include "server/storage/keys/folder_keyring.h"
#include "server/storage/keys/s3_keyring.h"

namespace enamel::server {
namespace {

// Here and nowhere else, so that no row is written without a signature.
Transactions::Connections Signing(Transactions::Connections connections, const AuditSigner& signer,
                                  const StoreOptions& options, const Rewriter& rewriter) {
  connections.writer->SetBusyWait(options.busy_wait,
                                  [&rewriter] { return rewriter.OthersErase(); });
  connections.writer->SetCompanion(&signer);
  return connections;
}

std::unique_ptr<Blobs> MakeBlobs(const StoreOptions& options, std::unique_ptr<s3::S3Client> s3,
                                 Transactions& rows) {
  if (s3 != nullptr) {
    return std::make_unique<S3Blobs>(std::move(s3), options.s3_blobs->prefix, rows);
  }
  return std::make_unique<FolderBlobs>(
      options.folder / "blobs", DiskOf(options), options.fail_next,
      [&rows] { return rows.Read([](sql::Db& db) { return NamedBlobs(db); }); });
}

// Where rows and blobs are elsewhere a recording takes no room in the folder.
uint64_t KeptFree(const StoreOptions& options, const Transactions::Connections& connections) {
  return options.s3_blobs && connections.open_writer ? 0 : options.min_free_bytes;
}

std::unique_ptr<Keyring> MakeKeyring(const StoreOptions& options, StoreEngine::Buckets& buckets,
                                     Transactions& rows) {
  if (buckets.keys == nullptr) {
    return std::make_unique<FolderKeyring>(options.folder / "keyring", DiskOf(options));
  }
  return std::make_unique<S3Keyring>(std::move(buckets.keys), options.s3_keys->place.prefix,
                                     *buckets.master, rows);
}

}  // namespace

StoreEngine::StoreEngine(const StoreOptions& options, Transactions::Connections connections,
                         FolderLock folder_lock, const trace::SecretKey& key, const Uuid& id,
                         Buckets buckets)
    : folder(options.folder),
      lock(std::move(folder_lock)),
      ticket_key(key),
      part_bytes(options.trace_part_bytes),
      signer(key, id),
      space(options.folder, DiskOf(options), KeptFree(options, connections),
            options.free_space_check),
      rows(Signing(std::move(connections), signer, options, rewriter), options.readers,
           options.change_twice),
      rewriter(options.folder, space, rows),
      look(rows, rewriter, id),
      gate(rows, space),
      blobs(MakeBlobs(options, std::move(buckets.blobs), rows)),
      keyring(MakeKeyring(options, buckets, rows)),
      keys(rows, *keyring),
      owner(rows, options.hold_lock ? id : Uuid::New(), options.hold_lock) {
  if (options.hold_lock) sealed.emplace(rows);
}

}  // namespace enamel::server
