#include "server/storage/blobs/s3_blobs.h"

#include <spdlog/spdlog.h>

#include <limits>
#include <map>

#include "server/storage/blobs/blob_rows.h"
#include "server/storage/blobs/named_blobs.h"
#include "server/storage/blobs/object_generation.h"
#include "server/storage/engine/query.h"

namespace enamel::server {
namespace {

constexpr size_t kHexHash = 64;
// Rows of one transaction of Sweep, which keeps others' from being kept.
constexpr size_t kAtOnce = 256;

int64_t Ms(std::chrono::seconds time) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(time).count();
}

Result<std::vector<Blobs::Freed>> FreeUnnamed(sql::Db& db, const std::set<Sha256>& hashes,
                                              int64_t before_ms) {
  ENAMEL_ASSIGN_OR_RETURN(const auto rows, DeleteUnnamedBlobRows(db, hashes, before_ms));
  std::vector<Blobs::Freed> out;
  for (const BlobRow& row : rows) out.push_back({row.hash, row.generation});
  return out;
}

}  // namespace

S3Blobs::S3Blobs(std::unique_ptr<s3::S3Client> client, std::string prefix, Transactions& rows,
                 std::function<int64_t()> now_ms)
    : client_(std::move(client)),
      prefix_(std::move(prefix)),
      rows_(rows),
      now_ms_(now_ms ? std::move(now_ms) : [] { return NowMs(); }),
      trouble_("blobs", now_ms_) {}

std::string S3Blobs::KeyOf(const Sha256& hash, int64_t generation) const {
  return prefix_ + hash.Hex() + "-" + GenerationText(generation);
}

bool S3Blobs::ReadKey(const std::string& key, Freed& out) const {
  if (!key.starts_with(prefix_)) return false;
  const std::string_view name = std::string_view(key).substr(prefix_.size());
  if (name.size() <= kHexHash || name[kHexHash] != '-') return false;
  const auto hash = Sha256::FromHex(name.substr(0, kHexHash));
  const auto generation = ReadGeneration(name.substr(kHexHash + 1));
  if (!hash.ok() || !generation) return false;
  out = {*hash, *generation};
  return KeyOf(out.hash, out.generation) == key;
}

Status S3Blobs::Problem() const { return trouble_.Problem(); }

void S3Blobs::Look() {
  if (trouble_.IsDue())
    (void)trouble_.Told(client_->Look(prefix_ + "look", S3Trouble::kLookWithin));
}

Result<Sha256> S3Blobs::Put(ByteView data) {
  const Sha256 hash = HashSha256(data);
  const int64_t begun_ms = now_ms_();
  std::optional<BlobRow> there;
  ENAMEL_RETURN_IF_ERROR(rows_.Read([&](sql::Db& db) -> Status {
    auto row = FindBlobRow(db, hash);
    if (row.ok()) there = *row;
    return row.status();
  }));
  if (there) {
    ENAMEL_RETURN_IF_ERROR(rows_.Write([&](sql::Db& db) -> Status {
      auto row = TouchBlobRow(db, hash, now_ms_());
      if (row.ok()) there = *row;
      return row.status();
    }));
  }
  if (there) {
    // Read, not only asked for: a store that lost a part of it answers a question as if it had all.
    const Status kept =
        client_->Get(KeyOf(hash, there->generation), hash, static_cast<size_t>(there->bytes))
            .status();
    if (kept.code() != Code::kNotFound && kept.code() != Code::kStorage) {
      ENAMEL_RETURN_IF_ERROR(trouble_.Told(kept));
      return hash;
    }
    spdlog::error("blobs: the object of {} is lost or damaged; it is written again", hash.Hex());
  }
  const int64_t generation = NewGeneration();
  ENAMEL_RETURN_IF_ERROR(trouble_.Told(client_->Put(KeyOf(hash, generation), data)));
  BlobRow row;
  // Even if this fails, the row may have been added: the object stays for Sweep to judge.
  ENAMEL_RETURN_IF_ERROR(rows_.Write([&](sql::Db& db) -> Status {
    const int64_t now_ms = now_ms_();
    if (now_ms - begun_ms >= Ms(kClaimWithin)) {
      return Status(Code::kUnavailable,
                    "writing a blob took more than an hour; check the store, and try again");
    }
    auto claimed = ClaimBlobRow(db, {hash, static_cast<int64_t>(data.size()), generation, now_ms},
                                there ? there->generation : 0);
    if (claimed.ok()) row = *claimed;
    return claimed.status();
  }));
  if (row.generation != generation) (void)client_->Delete(KeyOf(hash, generation));
  return hash;
}

Result<Bytes> S3Blobs::Get(const Sha256& hash) const {
  int64_t tried = 0;
  for (;;) {
    std::optional<BlobRow> row;
    ENAMEL_RETURN_IF_ERROR(rows_.Read([&](sql::Db& db) -> Status {
      auto found = FindBlobRow(db, hash);
      if (found.ok()) row = *found;
      return found.status();
    }));
    if (!row) return Status(Code::kNotFound, "no blob " + hash.Hex());
    if (row->generation == tried) {
      return trouble_.Told(Status(Code::kStorage, "the object " + KeyOf(hash, tried) +
                                                      " is lost at " + client_->Where() +
                                                      "; restore it from a backup"));
    }
    tried = row->generation;
    auto body = client_->Get(KeyOf(hash, tried), hash, static_cast<size_t>(row->bytes));
    if (body.ok()) {
      (void)trouble_.Told(Status::Ok());
      return body;
    }
    // Another server may have written it again under another generation since this read the row.
    if (body.status().code() != Code::kNotFound) return trouble_.Told(body.status());
  }
}

bool S3Blobs::Has(const Sha256& hash) const {
  bool there = false;
  const Status status = rows_.Read([&](sql::Db& db) -> Status {
    auto row = FindBlobRow(db, hash);
    there = row.ok() && row->has_value();
    return row.status();
  });
  return status.ok() && there;
}

Status S3Blobs::Hold(sql::Db& db, const std::set<Sha256>& hashes) {
  // In one order, so that no two transactions wait for each other.
  for (const Sha256& hash : hashes) {
    if (hash.IsZero()) continue;
    ENAMEL_ASSIGN_OR_RETURN(const auto row, TouchBlobRow(db, hash, now_ms_()));
    if (row) continue;
    return Status(Code::kUnavailable,
                  "blob " + hash.Hex() + " was removed before it was named; try again");
  }
  return Status::Ok();
}

Result<std::vector<Blobs::Freed>> S3Blobs::Free(sql::Db& db, const std::set<Sha256>& hashes) {
  return FreeUnnamed(db, hashes, std::numeric_limits<int64_t>::max());
}

Result<size_t> S3Blobs::Remove(const std::vector<Freed>& freed) {
  size_t removed = 0;
  for (const auto& [hash, generation] : freed) {
    // Nothing names it any more, and its person's key is destroyed: a leftover object is no reason
    // to fail the erasure.
    if (!trouble_.Told(client_->Delete(KeyOf(hash, generation))).ok()) break;
    ++removed;
  }
  if (removed < freed.size()) {
    spdlog::warn("blobs: {} of {} objects could not be deleted; they are removed within two days",
                 freed.size() - removed, freed.size());
  }
  return removed;
}

Result<size_t> S3Blobs::Sweep(std::chrono::seconds age) {
  ENAMEL_ASSIGN_OR_RETURN(const size_t rows, SweepRows(age));
  {
    MutexLock lock(mutex_);
    if (listed_ms_ != 0 && now_ms_() - listed_ms_ < Ms(kListEvery)) return rows;
  }
  ENAMEL_ASSIGN_OR_RETURN(const size_t orphans, SweepOrphans());
  MutexLock lock(mutex_);
  listed_ms_ = now_ms_();
  return rows + orphans;
}

Result<size_t> S3Blobs::SweepRows(std::chrono::seconds age) {
  const int64_t before_ms = now_ms_() - Ms(age);
  // Candidates, without keeping anybody from writing.
  std::vector<Sha256> candidates;
  ENAMEL_RETURN_IF_ERROR(rows_.Read([&](sql::Db& db) -> Status {
    candidates.clear();
    ENAMEL_ASSIGN_OR_RETURN(auto rows, AllBlobRows(db));
    ENAMEL_ASSIGN_OR_RETURN(auto named, NamedBlobs(db));
    for (const BlobRow& row : rows) {
      if (row.put_ms < before_ms && !named.contains(row.hash)) candidates.push_back(row.hash);
    }
    return Status::Ok();
  }));
  size_t removed = 0;
  for (size_t at = 0; at < candidates.size(); at += kAtOnce) {
    const std::set<Sha256> some(candidates.begin() + static_cast<std::ptrdiff_t>(at),
                                candidates.begin() + static_cast<std::ptrdiff_t>(std::min(
                                                         at + kAtOnce, candidates.size())));
    std::vector<Freed> freed;
    ENAMEL_RETURN_IF_ERROR(rows_.Write([&](sql::Db& db) -> Status {
      ENAMEL_ASSIGN_OR_RETURN(freed, FreeUnnamed(db, some, before_ms));
      return Status::Ok();
    }));
    ENAMEL_ASSIGN_OR_RETURN(const size_t gone, Remove(freed));
    removed += gone;
  }
  return removed;
}

Result<size_t> S3Blobs::SweepOrphans() {
  const int64_t before_ms = now_ms_() - Ms(kOrphanAge);
  std::vector<Freed> orphans;
  const Status listed = client_->ListEach(prefix_, [&](const s3::ListedObject& object) {
    Freed blob;
    if (object.modified_ms < before_ms && ReadKey(object.key, blob)) orphans.push_back(blob);
  });
  if (!listed.ok()) return trouble_.Told(listed);
  // Read after the list: the row of a day-old object exists by now, or never will.
  std::map<Sha256, int64_t> counts;
  ENAMEL_RETURN_IF_ERROR(rows_.Read([&](sql::Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto rows, AllBlobRows(db));
    for (const BlobRow& row : rows) counts[row.hash] = row.generation;
    return Status::Ok();
  }));
  std::erase_if(orphans, [&](const Freed& blob) {
    const auto row = counts.find(blob.hash);
    return row != counts.end() && row->second == blob.generation;
  });
  return Remove(orphans);
}

}  // namespace enamel::server
