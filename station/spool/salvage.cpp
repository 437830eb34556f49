#include "station/spool/salvage.h"

#include <stdlib.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "station/spool/spool.h"
#include "station/spool/spool_file.h"
#include "station/spool/statement.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;

// https://www.sqlite.org/fileformat2.html, 1.3: the header, and where it counts pages.
constexpr size_t kPageBytes = 4096, kHeaderBytes = 100, kPageCountAt = 28;

// A folder that goes away again.
struct Scratch {
  fs::path path;
  Scratch() {
    std::string name = (fs::temp_directory_path() / "enamel_salvage_XXXXXX").string();
    if (::mkdtemp(name.data()) != nullptr) path = name;
  }
  ~Scratch() {
    std::error_code error;
    if (!path.empty()) fs::remove_all(path, error);
  }
};

struct Handle {
  sqlite3* db = nullptr;
  ~Handle() { sqlite3_close(db); }
  // Also for what is damaged, as far as it can be read.
  bool Open(const fs::path& file) {
    sqlite3_close(std::exchange(db, nullptr));
    return sqlite3_open_v2(file.c_str(), &db, SQLITE_OPEN_READWRITE, nullptr) == SQLITE_OK &&
           sqlite3_exec(db, "PRAGMA writable_schema = ON; SELECT count(*) FROM attempts LIMIT 0",
                        nullptr, nullptr, nullptr) == SQLITE_OK;
  }
};

// The first `bytes` of a file become those of a new spool, but for the count of pages.
bool GiveFreshStart(const fs::path& file, const fs::path& scratch, size_t bytes) {
  { (void)Spool::Open(scratch / "fresh"); }
  std::vector<char> start(kPageBytes);
  std::ifstream fresh(scratch / "fresh" / kSpoolFile, std::ios::binary);
  if (!fresh.read(start.data(), kPageBytes)) return false;
  std::error_code error;
  const auto pages = static_cast<uint32_t>(fs::file_size(file, error) / kPageBytes);
  for (size_t i = 0; i < 4; ++i) {
    start[kPageCountAt + i] = static_cast<char>(pages >> (24 - 8 * i));
  }
  std::fstream out(file, std::ios::binary | std::ios::in | std::ios::out);
  out.write(start.data(), static_cast<std::streamsize>(bytes));
  return static_cast<bool>(out);
}

// As it is, then with a new header, then with a new first page.
Status OpenDamaged(const fs::path& from, const fs::path& scratch, Handle& handle) {
  const fs::path file = scratch / kSpoolFile;
  for (size_t fresh : {size_t{0}, kHeaderBytes, kPageBytes}) {
    std::error_code error;
    for (const char* end : {"", "-wal"}) {
      fs::remove(file.string() + end, error);
      if (fs::exists(from / (std::string(kSpoolFile) + end), error)) {
        fs::copy_file(from / (std::string(kSpoolFile) + end), file.string() + end, error);
      }
      if (error) {
        return Status(Code::kStorage, "cannot copy " + (from / kSpoolFile).string() + " to " +
                                          scratch.string() + " (" + error.message() + ")");
      }
    }
    if (fresh > 0 && !GiveFreshStart(file, scratch, fresh)) break;
    if (handle.Open(file)) return Status::Ok();
  }
  return Status(Code::kStorage, "nothing can be read of " + (from / kSpoolFile).string() + " (" +
                                    sqlite3_errmsg(handle.db) + ")");
}

// What a scan yields from its beginning to the damage, and from its end back to it.
template <typename Take>
void ScanBothWays(sqlite3* db, const std::string& sql, const Take& take) {
  for (const char* order : {" ASC", " DESC"}) {
    Statement s(db, (sql + order).c_str());
    int rc = 0;
    while ((rc = s.Step()) == SQLITE_ROW) take(s);
    if (rc == SQLITE_DONE) return;
  }
}

using Places = std::map<std::pair<Uuid, uint32_t>, int64_t>;  // row of a chunk

// Where chunks lie, by position: an index may be damaged where they are not.
Places ChunkPlaces(sqlite3* db) {
  Places out;
  ScanBothWays(db, "SELECT rowid, attempt, seq FROM chunks NOT INDEXED ORDER BY rowid",
               [&](Statement& s) {
                 Bytes id = s.BlobAt(1);
                 if (id.size() != 16) return;
                 out[{Uuid::FromBytes(id), static_cast<uint32_t>(s.IntAt(2))}] = s.IntAt(0);
               });
  return out;
}

std::optional<Bytes> ChunkOf(sqlite3* db, const Places& places, const Uuid& id, uint32_t seq) {
  Statement by_index(db, "SELECT bytes FROM chunks WHERE attempt = ? AND seq = ?");
  if (by_index.Blob(id.view()).Int(seq).Step() == SQLITE_ROW) return by_index.BlobAt(0);
  auto at = places.find({id, seq});
  if (at == places.end()) return std::nullopt;
  Statement by_place(db, "SELECT bytes FROM chunks WHERE rowid = ?");
  if (by_place.Int(at->second).Step() == SQLITE_ROW) return by_place.BlobAt(0);
  return std::nullopt;
}

// One attempt's row as the damaged spool has it.
struct Row {
  Bytes header;
  std::string exercise, profile, refused;
  std::optional<trace::Seal> seal;
  uint32_t chunks = 0, committed = 0;
  bool sealed_at_server = false;
};

std::optional<Row> RowOf(sqlite3* db, const Uuid& id) {
  Statement s(db,
              "SELECT header, exercise, profile, refused, seal_chunks, seal_ticks,"
              " seal_last_sha256, seal_state_hash, chunks, committed, sealed_at_server"
              " FROM attempts WHERE id = ?");
  if (s.Blob(id.view()).Step() != SQLITE_ROW) return std::nullopt;
  Row out{s.BlobAt(0), s.TextAt(1), s.TextAt(2), s.TextAt(3), {}, 0, 0, false};
  if (Bytes last = s.BlobAt(6); !s.IsNull(4) && last.size() == 32) {
    out.seal = trace::Seal{id, static_cast<uint32_t>(s.IntAt(4)), static_cast<uint64_t>(s.IntAt(5)),
                           Sha256::FromBytes(last), static_cast<uint64_t>(s.IntAt(7))};
  }
  out.chunks = static_cast<uint32_t>(s.IntAt(8));
  out.committed = static_cast<uint32_t>(s.IntAt(9));
  out.sealed_at_server = s.IntAt(10) != 0;
  return out;
}

Status SaveChunks(sqlite3* db, const Places& places, const Row& row, Spool& to,
                  SalvagedAttempt& out) {
  trace::ChainVerifier chain(out.id, HashSha256(row.header));
  for (; out.chunks < row.chunks; ++out.chunks) {
    auto bytes = ChunkOf(db, places, out.id, out.chunks);
    auto chunk = bytes ? trace::DecodeChunk(*bytes)
                       : Result<trace::Chunk>(Status(Code::kStorage, "it cannot be read"));
    Status fits = chunk.ok() ? chain.Accept(*chunk) : chunk.status();
    if (!fits.ok()) {
      out.problem = Status(Code::kStorage, "chunk " + std::to_string(out.chunks) + ": " +
                                               fits.message() + "; what came after is lost");
      return Status::Ok();
    }
    ENAMEL_RETURN_IF_ERROR(to.PutChunk(out.id, *bytes));
  }
  if (!row.seal) return Status::Ok();
  out.problem = chain.AcceptSeal(*row.seal);
  if (!out.problem.ok()) return Status::Ok();
  out.sealed = true;
  return to.PutSeal(*row.seal);
}

Result<SalvagedAttempt> SaveAttempt(sqlite3* db, const Places& places, const Uuid& id, Spool& to) {
  SalvagedAttempt out;
  out.id = id;
  auto row = RowOf(db, id);
  auto header = row ? trace::DecodeHeader(row->header)
                    : Result<trace::Header>(Status(Code::kStorage, "it cannot be read"));
  if (!header.ok() || header->ticket.attempt != id) {
    out.problem = Status(Code::kStorage, "its header is lost, and with it the recording");
    return out;
  }
  out.expected = row->chunks;
  ENAMEL_RETURN_IF_ERROR(to.BeginAttempt(*header, row->exercise, row->profile));
  ENAMEL_RETURN_IF_ERROR(SaveChunks(db, places, *row, to, out));
  ENAMEL_RETURN_IF_ERROR(to.SetCommittedBelow(id, row->committed));
  if (row->sealed_at_server && out.sealed) ENAMEL_RETURN_IF_ERROR(to.MarkSealedAtServer(id));
  if (!row->refused.empty()) ENAMEL_RETURN_IF_ERROR(to.MarkRefused(id, row->refused));
  return out;
}

// Tickets for later are kept when all of their row is.
size_t SaveTickets(sqlite3* db, Spool& to) {
  size_t saved = 0;
  std::set<Uuid> seen;
  ScanBothWays(db,
               "SELECT attempt, person, exercise, title, profile, expires_unix_ms, salt, locked"
               " FROM tickets ORDER BY attempt",
               [&](Statement& s) {
                 LockedTicket t;
                 Bytes id = s.BlobAt(0), salt = s.BlobAt(6);
                 if (id.size() != 16 || salt.size() != t.salt.size()) return;
                 t.attempt = Uuid::FromBytes(id);
                 if (!seen.insert(t.attempt).second) return;
                 t.person = s.TextAt(1);
                 t.exercise = s.TextAt(2);
                 t.title = s.TextAt(3);
                 t.profile = s.TextAt(4);
                 t.expires_unix_ms = s.IntAt(5);
                 std::copy_n(salt.begin(), t.salt.size(), t.salt.begin());
                 t.locked = s.BlobAt(7);
                 saved += to.tickets().Put(t).ok() ? 1 : 0;
               });
  return saved;
}

// How the loops went, of attempts that are saved.
void SaveLoopFacts(sqlite3* db, const Uuid& id, Spool& to) {
  Statement s(db, "SELECT run, ended_unix_ms, facts FROM loop_facts WHERE attempt = ?");
  s.Blob(id.view());
  while (s.Step() == SQLITE_ROW) {
    (void)to.loop_facts().Put(id, {static_cast<uint32_t>(s.IntAt(0)), s.IntAt(1), s.TextAt(2)});
  }
}

}  // namespace

Result<Salvaged> SalvageSpool(const fs::path& from, const fs::path& to) {
  std::error_code error;
  if (!fs::exists(from / kSpoolFile, error)) {
    return Status(Code::kNotFound, "there is no spool in " + from.string());
  }
  if (fs::exists(to / kSpoolFile, error)) {
    return Status(Code::kConflict,
                  to.string() + " has a spool already: name a folder that has none", "out");
  }
  Scratch scratch;
  Handle damaged;
  ENAMEL_RETURN_IF_ERROR(OpenDamaged(from, scratch.path, damaged));
  ENAMEL_ASSIGN_OR_RETURN(auto saved, Spool::Open(to));
  // An id that only chunks still have is an attempt whose row is lost, or noise.
  const Places places = ChunkPlaces(damaged.db);
  std::set<Uuid> ids;
  ScanBothWays(damaged.db, "SELECT id FROM attempts ORDER BY id", [&](Statement& s) {
    if (Bytes id = s.BlobAt(0); id.size() == 16) ids.insert(Uuid::FromBytes(id));
  });
  for (const auto& [place, row] : places) {
    if (ids.contains(place.first)) continue;
    auto bytes = ChunkOf(damaged.db, places, place.first, place.second);
    auto chunk = trace::DecodeChunkHead(bytes.value_or(Bytes()));
    if (chunk.ok() && chunk->head.attempt == place.first) ids.insert(place.first);
  }
  Salvaged out;
  for (const Uuid& id : ids) {
    ENAMEL_ASSIGN_OR_RETURN(auto attempt, SaveAttempt(damaged.db, places, id, *saved));
    SaveLoopFacts(damaged.db, id, *saved);
    out.attempts.push_back(std::move(attempt));
  }
  out.tickets = SaveTickets(damaged.db, *saved);
  if (!out.attempts.empty() || out.tickets > 0) return out;
  // An empty spool must not take the place of one that something was in.
  saved.reset();
  for (const char* end : {"", "-wal", "-shm"}) fs::remove((to / kSpoolFile).string() + end, error);
  return Status(
      Code::kStorage,
      "nothing is left to save in " + (from / kSpoolFile).string() + " (" +
          std::to_string(fs::file_size(from / kSpoolFile, error)) +
          " bytes): put a copy of it back; where nothing was recorded yet, or there is no "
          "copy, move it away (keep it) to begin with an empty spool");
}

}  // namespace enamel::station
