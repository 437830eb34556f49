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

namespace enamel::station {
namespace {

namespace fs = std::filesystem;

// https://www.sqlite.org/fileformat2.html, 1.3: the header, and its count of pages.
constexpr size_t kPageBytes = 4096, kHeaderBytes = 100, kPageCountAt = 28;

// A temporary folder.
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

// Opens what can be read. Errors also: it has no readable table of attempts.
Result<std::unique_ptr<sql::SqliteDb>> OpenAsItIs(const fs::path& file) {
  sql::SqliteDbOptions options;
  options.mode = sql::SqliteDbOptions::Mode::kExisting;
  options.damaged = true;
  ENAMEL_ASSIGN_OR_RETURN(auto db, sql::SqliteDb::Open(file, std::move(options)));
  ENAMEL_RETURN_IF_ERROR(db->Exec("SELECT count(*) FROM attempts LIMIT 0"));
  return db;
}

// Its spools have a version and no mark. Any other mark is damage.
bool IsOfAnEarlierEnamel(sql::Db& db) {
  sql::Query mark(db, "PRAGMA application_id"), version(db, "PRAGMA user_version");
  return mark.Next() && mark.Int(0) == 0 && version.Next() && version.Int(0) > 0;
}

// Replaces the first `bytes` of a file by those of a new spool, except for the count of pages.
// SQLite reads from page 1 where every table begins. All spools have their tables at the same
// pages, as none is ever moved (schemas/sql/station_spool/0001_initial.sql), so a new one's page 1
// fits.
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

// Tries it unchanged, then with a new header, then with a new first page.
Result<std::unique_ptr<sql::SqliteDb>> OpenDamaged(const fs::path& from, const fs::path& scratch) {
  Status why;
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
    auto opened = OpenAsItIs(file);
    if (opened.ok() && fresh == 0 && IsOfAnEarlierEnamel(**opened)) {
      return NotOurs(from / kSpoolFile);
    }
    if (opened.ok()) return opened;
    why = opened.status();
  }
  return Status(Code::kStorage, "nothing can be read of " + (from / kSpoolFile).string() + " (" +
                                    why.message() + ")");
}

// A scan's rows from its beginning to the damage, and from its end back to it.
template <typename Take>
void ScanBothWays(sql::Db& db, const std::string& sql, const Take& take) {
  for (const char* order : {" ASC", " DESC"}) {
    sql::Query s(db, sql + order);
    while (s.Next()) take(s);
    if (s.status().ok()) return;
  }
}

using Places = std::map<std::pair<Uuid, uint32_t>, int64_t>;  // row of a chunk

// Positions of chunks: an index may be damaged where they are not.
Places ChunkPlaces(sql::Db& db) {
  Places out;
  ScanBothWays(db, "SELECT rowid, attempt, seq FROM chunks NOT INDEXED ORDER BY rowid",
               [&](const sql::Query& s) {
                 Bytes id = s.Blob(1);
                 if (id.size() != 16) return;
                 out[{Uuid::FromBytes(id), static_cast<uint32_t>(s.Int(2))}] = s.Int(0);
               });
  return out;
}

struct FoundChunk {
  Bytes bytes;
  int64_t spooled_unix_ms = 0;
};

// By index first, which is fast; if that is damaged, at the position found by the scan.
std::optional<FoundChunk> ChunkOf(sql::Db& db, const Places& places, const Uuid& id, uint32_t seq) {
  auto found = [](const sql::Query& s) {
    return FoundChunk{s.Blob("bytes"), s.Int("spooled_unix_ms")};
  };
  sql::Query by_index(db, "SELECT * FROM chunks WHERE attempt = ? AND seq = ?");
  if (by_index.BindBlob(id.view()).BindInt(seq).Next()) return found(by_index);
  auto at = places.find({id, seq});
  if (at == places.end()) return std::nullopt;
  sql::Query by_place(db, "SELECT * FROM chunks WHERE rowid = ?");
  if (by_place.BindInt(at->second).Next()) return found(by_place);
  return std::nullopt;
}

// Columns that the new spool computes from the saved chunks, or that BeginAttempt has stored. Every
// other column of an attempt is copied unchanged, also one that a later version adds.
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

// Columns of the new spool's table that the damaged row has too.
std::vector<SharedColumn> SharedColumns(const sql::Query& row, sql::Db& to,
                                        const std::string& table) {
  const sql::Query there(to, "SELECT * FROM " + table + " LIMIT 0");
  std::vector<SharedColumn> out;
  for (int i = 0; i < there.columns(); ++i) {
    const int in_row = row.ColumnNamed(there.NameOf(i));
    if (in_row >= 0) out.push_back({there.NameOf(i), in_row});
  }
  return out;
}

// A value that the table does not allow is damage, not a failure to write: it changes nothing.
Status Written(sql::Query& q, SpoolFile& to, const char* doing) {
  Status done = q.Run();
  return done.ok() || done.code() == Code::kConflict ? Status::Ok() : to.Fail(doing);
}

Status TakeOverColumns(const sql::Query& row, const Uuid& id, SpoolFile& to) {
  MutexLock lock(to.mutex());
  std::string set;
  std::vector<int> values;
  for (const SharedColumn& column : SharedColumns(row, to.db(), "attempts")) {
    if (std::ranges::find(kComputed, column.name) != kComputed.end()) continue;
    set += (set.empty() ? "" : ", ") + column.name + " = ?";
    values.push_back(column.in_row);
  }
  sql::Query s(to.db(), ("UPDATE attempts SET " + set + " WHERE id = ?").c_str());
  for (int column : values) s.BindSame(row, column);
  return Written(s.BindBlob(id.view()), to, "saving an attempt");
}

// Copies the columns that both tables have. Returns whether the row was inserted.
Result<bool> TakeOverRow(const sql::Query& row, SpoolFile& to, const std::string& table) {
  MutexLock lock(to.mutex());
  std::string names, places;
  const auto shared = SharedColumns(row, to.db(), table);
  for (const SharedColumn& column : shared) {
    names += (names.empty() ? "" : ", ") + column.name;
    places += places.empty() ? "?" : ", ?";
  }
  sql::Query s(to.db(),
               ("INSERT INTO " + table + " (" + names + ") VALUES (" + places + ")").c_str());
  for (const SharedColumn& column : shared) s.BindSame(row, column.in_row);
  ENAMEL_RETURN_IF_ERROR(Written(s, to, "saving a row"));
  return s.status().ok();
}

Status KeepTime(const Uuid& id, uint32_t seq, int64_t spooled_unix_ms, SpoolFile& to) {
  MutexLock lock(to.mutex());
  sql::Query s(to.db(), "UPDATE chunks SET spooled_unix_ms = ?3 WHERE attempt = ?1 AND seq = ?2");
  s.BindBlob(id.view()).BindInt(seq).BindInt(spooled_unix_ms);
  return Written(s, to, "saving a chunk's time");
}

// Up to the first chunk that is missing or does not fit: nothing after a hole can be proved.
Status SaveChunks(sql::Db& db, const Places& places, const SpooledAttempt& row, ByteView header,
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

Result<SalvagedAttempt> SaveAttempt(sql::Db& db, const Places& places, const Uuid& id, Spool& to) {
  SalvagedAttempt out;
  out.id = id;
  sql::Query found(db, "SELECT * FROM attempts WHERE id = ?");
  const bool there = found.BindBlob(id.view()).Next();
  auto header = there ? trace::DecodeHeader(found.Blob("header"))
                      : Result<trace::Header>(Status(Code::kStorage, "it cannot be read"));
  if (!header.ok() || header->ticket.attempt != id) {
    out.problem = Status(Code::kStorage, "its header is lost, and with it the recording");
    return out;
  }
  const SpooledAttempt row = ReadAttemptRow(found);
  out.expected = row.chunks;
  ENAMEL_RETURN_IF_ERROR(to.BeginAttempt(*header, row.exercise, row.profile, row.facts));
  ENAMEL_RETURN_IF_ERROR(SaveChunks(db, places, row, found.Blob("header"), to, out));
  ENAMEL_RETURN_IF_ERROR(to.SetCommittedBelow(id, row.committed));
  if (row.sealed_at_server && out.sealed) ENAMEL_RETURN_IF_ERROR(to.MarkSealedAtServer(id));
  ENAMEL_RETURN_IF_ERROR(TakeOverColumns(found, id, to.spool_file()));
  return out;
}

// A ticket for later is kept only if its whole row is readable.
Result<size_t> SaveTickets(sql::Db& db, Spool& to) {
  size_t saved = 0;
  Status worst;
  std::set<Bytes> seen;
  ScanBothWays(db, "SELECT * FROM tickets ORDER BY attempt", [&](const sql::Query& s) {
    if (!seen.insert(s.Blob("attempt")).second) return;
    auto taken = TakeOverRow(s, to.spool_file(), "tickets");
    if (!taken.ok()) worst = taken.status();
    saved += taken.ok() && *taken ? 1 : 0;
  });
  return worst.ok() ? Result<size_t>(saved) : worst;
}

// Loop facts of the saved attempts.
void SaveLoopFacts(sql::Db& db, const Uuid& id, Spool& to) {
  sql::Query s(db, "SELECT * FROM loop_facts WHERE attempt = ?");
  s.BindBlob(id.view());
  while (s.Next()) (void)TakeOverRow(s, to.spool_file(), "loop_facts");
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
  ENAMEL_ASSIGN_OR_RETURN(const auto damaged, OpenDamaged(from, scratch.path));
  ENAMEL_ASSIGN_OR_RETURN(auto saved, Spool::Open(to));
  // An id found only in chunks is an attempt whose row is lost, or noise.
  const Places places = ChunkPlaces(*damaged);
  std::set<Uuid> ids;
  ScanBothWays(*damaged, "SELECT id FROM attempts ORDER BY id", [&](const sql::Query& s) {
    if (Bytes id = s.Blob(0); id.size() == 16) ids.insert(Uuid::FromBytes(id));
  });
  for (const auto& [place, row] : places) {
    if (ids.contains(place.first)) continue;
    auto found = ChunkOf(*damaged, places, place.first, place.second);
    auto chunk = trace::DecodeChunkHead(found ? found->bytes : Bytes());
    if (chunk.ok() && chunk->head.attempt == place.first) ids.insert(place.first);
  }
  Salvaged out;
  for (const Uuid& id : ids) {
    ENAMEL_ASSIGN_OR_RETURN(auto attempt, SaveAttempt(*damaged, places, id, *saved));
    SaveLoopFacts(*damaged, id, *saved);
    out.attempts.push_back(std::move(attempt));
  }
  ENAMEL_ASSIGN_OR_RETURN(out.tickets, SaveTickets(*damaged, *saved));
  if (!out.attempts.empty() || out.tickets > 0) return out;
  // An empty spool must not replace one that had contents.
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
