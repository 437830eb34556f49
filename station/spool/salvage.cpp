#include "station/spool/salvage.h"

#include <stdlib.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "station/spool/attempt_row.h"
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

// The first `bytes` of a file become those of a new spool, but for the count of pages. SQLite reads
// from page 1 where every table begins. All spools have their tables at the same pages, as none is
// ever moved (schemas/sql/station_spool/0001_initial.sql), so a new one's page 1 fits.
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

struct FoundChunk {
  Bytes bytes;
  std::optional<int64_t> spooled_unix_ms;
};

std::optional<FoundChunk> ChunkOf(sqlite3* db, const Places& places, const Uuid& id, uint32_t seq) {
  auto found = [](Statement& s) {
    FoundChunk out{s.BlobAt("bytes"), {}};
    if (!s.IsNull("spooled_unix_ms")) out.spooled_unix_ms = s.IntAt("spooled_unix_ms");
    return out;
  };
  Statement by_index(db, "SELECT * FROM chunks WHERE attempt = ? AND seq = ?");
  if (by_index.Blob(id.view()).Int(seq).Step() == SQLITE_ROW) return found(by_index);
  auto at = places.find({id, seq});
  if (at == places.end()) return std::nullopt;
  Statement by_place(db, "SELECT * FROM chunks WHERE rowid = ?");
  if (by_place.Int(at->second).Step() == SQLITE_ROW) return found(by_place);
  return std::nullopt;
}

// What the new spool computes from the chunks that are saved, and what BeginAttempt has stored.
// Every other column of an attempt is taken over as it is, also one that a later version adds.
constexpr std::array<std::string_view, 13> kComputed = {"id",
                                                        "header",
                                                        "header_sha256",
                                                        "seal_chunks",
                                                        "seal_ticks",
                                                        "seal_last_sha256",
                                                        "seal_state_hash",
                                                        "chunks",
                                                        "ticks",
                                                        "gap_ticks",
                                                        "bytes",
                                                        "committed",
                                                        "sealed_at_server"};

struct SharedColumn {
  std::string name;
  int in_row = 0;
};

// Those of the new spool's table that the damaged row has too.
std::vector<SharedColumn> SharedColumns(const Statement& row, sqlite3* to,
                                        const std::string& table) {
  const Statement there(to, ("SELECT * FROM " + table + " LIMIT 0").c_str());
  std::vector<SharedColumn> out;
  for (int i = 0; i < there.columns(); ++i) {
    const int in_row = row.ColumnNamed(there.NameOf(i));
    if (in_row >= 0) out.push_back({there.NameOf(i), in_row});
  }
  return out;
}

// A value that the table does not allow is damage, not a failure to write: nothing is changed then.
Status Written(int rc, SpoolFile& to, const char* doing) {
  return rc == SQLITE_DONE || (rc & 0xff) == SQLITE_CONSTRAINT ? Status::Ok() : to.Fail(doing);
}

Status TakeOverColumns(const Statement& row, const Uuid& id, SpoolFile& to) {
  std::lock_guard lock(to.mutex());
  std::string set;
  std::vector<int> values;
  for (const SharedColumn& column : SharedColumns(row, to.handle(), "attempts")) {
    if (std::ranges::find(kComputed, column.name) != kComputed.end()) continue;
    set += (set.empty() ? "" : ", ") + column.name + " = ?";
    values.push_back(column.in_row);
  }
  Statement s(to.handle(), ("UPDATE attempts SET " + set + " WHERE id = ?").c_str());
  for (int column : values) s.Same(row, column);
  return Written(s.Blob(id.view()).Step(), to, "saving an attempt");
}

// The row with all that both tables have. Returns whether it was inserted.
Result<bool> TakeOverRow(const Statement& row, SpoolFile& to, const std::string& table) {
  std::lock_guard lock(to.mutex());
  std::string names, places;
  const auto shared = SharedColumns(row, to.handle(), table);
  for (const SharedColumn& column : shared) {
    names += (names.empty() ? "" : ", ") + column.name;
    places += places.empty() ? "?" : ", ?";
  }
  Statement s(to.handle(),
              ("INSERT INTO " + table + " (" + names + ") VALUES (" + places + ")").c_str());
  for (const SharedColumn& column : shared) s.Same(row, column.in_row);
  const int rc = s.Step();
  ENAMEL_RETURN_IF_ERROR(Written(rc, to, "saving a row"));
  return rc == SQLITE_DONE;
}

Status KeepTime(const Uuid& id, uint32_t seq, const std::optional<int64_t>& spooled_unix_ms,
                SpoolFile& to) {
  std::lock_guard lock(to.mutex());
  Statement s(to.handle(),
              spooled_unix_ms
                  ? "UPDATE chunks SET spooled_unix_ms = ?3 WHERE attempt = ?1 AND seq = ?2"
                  : "UPDATE chunks SET spooled_unix_ms = NULL WHERE attempt = ?1 AND seq = ?2");
  s.Blob(id.view()).Int(seq);
  if (spooled_unix_ms) s.Int(*spooled_unix_ms);
  return Written(s.Step(), to, "saving a chunk's time");
}

Status SaveChunks(sqlite3* db, const Places& places, const SpooledAttempt& row, ByteView header,
                  Spool& to, SalvagedAttempt& out) {
  trace::ChainVerifier chain(out.id, HashSha256(header));
  for (; out.chunks < out.expected; ++out.chunks) {
    auto found = ChunkOf(db, places, out.id, out.chunks);
    auto chunk = found ? trace::DecodeChunk(found->bytes)
                       : Result<trace::Chunk>(Status(Code::kStorage, "it cannot be read"));
    Status fits = chunk.ok() ? chain.Accept(*chunk) : chunk.status();
    if (!fits.ok()) {
      out.problem = Status(Code::kStorage, "chunk " + std::to_string(out.chunks) + ": " +
                                               fits.message() + "; what came after is lost");
      return Status::Ok();
    }
    ENAMEL_RETURN_IF_ERROR(to.PutChunk(out.id, found->bytes));
    ENAMEL_RETURN_IF_ERROR(KeepTime(out.id, out.chunks, found->spooled_unix_ms, to.spool_file()));
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
  Statement found(db, "SELECT * FROM attempts WHERE id = ?");
  const bool there = found.Blob(id.view()).Step() == SQLITE_ROW;
  auto header = there ? trace::DecodeHeader(found.BlobAt("header"))
                      : Result<trace::Header>(Status(Code::kStorage, "it cannot be read"));
  if (!header.ok() || header->ticket.attempt != id) {
    out.problem = Status(Code::kStorage, "its header is lost, and with it the recording");
    return out;
  }
  const SpooledAttempt row = ReadAttemptRow(found);
  out.expected = row.chunks;
  ENAMEL_RETURN_IF_ERROR(to.BeginAttempt(*header, row.exercise, row.profile, row.facts));
  ENAMEL_RETURN_IF_ERROR(SaveChunks(db, places, row, found.BlobAt("header"), to, out));
  ENAMEL_RETURN_IF_ERROR(to.SetCommittedBelow(id, row.committed));
  if (row.sealed_at_server && out.sealed) ENAMEL_RETURN_IF_ERROR(to.MarkSealedAtServer(id));
  ENAMEL_RETURN_IF_ERROR(TakeOverColumns(found, id, to.spool_file()));
  return out;
}

// Tickets for later are kept when all of their row is.
Result<size_t> SaveTickets(sqlite3* db, Spool& to) {
  size_t saved = 0;
  Status worst;
  std::set<Bytes> seen;
  ScanBothWays(db, "SELECT * FROM tickets ORDER BY attempt", [&](Statement& s) {
    if (!seen.insert(s.BlobAt("attempt")).second) return;
    auto taken = TakeOverRow(s, to.spool_file(), "tickets");
    if (!taken.ok()) worst = taken.status();
    saved += taken.ok() && *taken ? 1 : 0;
  });
  return worst.ok() ? Result<size_t>(saved) : worst;
}

// How the loops went, of attempts that are saved.
void SaveLoopFacts(sqlite3* db, const Uuid& id, Spool& to) {
  Statement s(db, "SELECT * FROM loop_facts WHERE attempt = ?");
  s.Blob(id.view());
  while (s.Step() == SQLITE_ROW) (void)TakeOverRow(s, to.spool_file(), "loop_facts");
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
    auto found = ChunkOf(damaged.db, places, place.first, place.second);
    auto chunk = trace::DecodeChunkHead(found ? found->bytes : Bytes());
    if (chunk.ok() && chunk->head.attempt == place.first) ids.insert(place.first);
  }
  Salvaged out;
  for (const Uuid& id : ids) {
    ENAMEL_ASSIGN_OR_RETURN(auto attempt, SaveAttempt(damaged.db, places, id, *saved));
    SaveLoopFacts(damaged.db, id, *saved);
    out.attempts.push_back(std::move(attempt));
  }
  ENAMEL_ASSIGN_OR_RETURN(out.tickets, SaveTickets(damaged.db, *saved));
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
