#include <algorithm>
#include <bit>
#include <string>

#include "common/base/check.h"
#include "server/storage/sql/sql_names.h"
#include "server/storage/sql/sqlite_impl.h"

// Ingest of traces: header, chunks as rows, and on seal one write-once blob instead of the rows.
namespace enamel::server::sqlite {
namespace {

// Enough to show what happened; a station that is broken or hostile cannot fill the disk with it.
constexpr int kMaxEvidence = 16;
// What a station's clock may be off, and the server's may have been set, before ticks are more than
// time: 2 s and 1 %.
constexpr int64_t kClockSlackMs = 2000, kClockPercent = 101;

constexpr char kInsertChunk[] =
    "INSERT INTO trace_chunks (tenant, attempt, seq, hash, bytes, received_ms) ";

// The part of an attempt's row that ingest works on.
struct Ingest {
  AttemptState state = AttemptState::kTicketed;
  bool has_header = false;
  Sha256 head;
  uint64_t head_state_hash = 0;
  uint32_t chunks = 0;
  uint64_t ticks = 0;
  Sha256 trace_blob;
  bool expired = false;
  uint64_t gap_ticks = 0;
  UnixMs ticketed_ms = 0, due_ms = 0, last_chunk_ms = 0;
  int64_t rate_hz = 0;
  uint32_t flags = 0;
  bool exam = false;
};

// To look at, or to decide on: then nobody else changes it before the transaction's end.
enum class Look { kOnly, kToDecide };

Result<Ingest> FindIngest(Db& db, const Uuid& attempt, Look look) {
  Query q(
      db,
      std::string(
          "SELECT state, header IS NOT NULL, head_hash, head_state_hash, chunks, ticks, "
          "trace_blob, "
          "expired_ms, gap_ticks, ticketed_ms, due_ms, last_chunk_ms, rate_hz, flags, exam FROM "
          "attempts WHERE tenant = ?1 AND id = ?2") +
          (look == Look::kToDecide ? db.RowLock() : ""));
  if (!q.Bind(attempt).Next()) {
    if (!q.status().ok()) return q.status();
    return Status(Code::kNotFound,
                  "no attempt " + attempt.Text() + "; its ticket was not issued here");
  }
  Ingest out;
  out.state = static_cast<AttemptState>(q.Int(0));
  out.has_header = q.Int(1) != 0;
  out.head = q.Hash(2);
  out.head_state_hash = std::bit_cast<uint64_t>(q.Int(3));
  out.chunks = static_cast<uint32_t>(q.Int(4));
  out.ticks = static_cast<uint64_t>(q.Int(5));
  out.trace_blob = q.Hash(6);
  out.expired = q.Int(7) != 0;
  out.gap_ticks = static_cast<uint64_t>(q.Int(8));
  out.ticketed_ms = q.Int(9);
  out.due_ms = q.Int(10);
  out.last_chunk_ms = q.Int(11);
  out.rate_hz = q.Int(12);
  out.flags = static_cast<uint32_t>(q.Int(13));
  out.exam = q.Int(14) != 0;
  return out;
}

Result<std::optional<Sha256>> StoredHash(Db& db, const Uuid& attempt, uint32_t seq) {
  Query q(db, "SELECT hash FROM trace_chunks WHERE tenant = ?1 AND attempt = ?2 AND seq = ?3");
  std::optional<Sha256> out;
  if (q.Bind(attempt).Bind(int64_t{seq}).Next()) out = q.Hash(0);
  if (!q.status().ok()) return q.status();
  return out;
}

// Counted in the statement that inserts: many connections at once cannot pass the bound.
Status KeepEvidence(Db& db, const Store::ChunkPut& chunk, ByteView sealed) {
  Query q(db,
          "INSERT INTO contradicting_chunks (tenant, attempt, seq, hash, bytes, received_ms) "
          "SELECT ?1, ?2, ?3, ?4, ?5, ?6 WHERE (SELECT count(*) FROM contradicting_chunks "
          "WHERE tenant = ?1 AND attempt = ?2) < ?7 ON CONFLICT DO NOTHING");
  q.Bind(chunk.attempt).Bind(int64_t{chunk.head.seq}).Bind(chunk.hash).Bind(sealed);
  return q.Bind(chunk.received_ms).Bind(int64_t{kMaxEvidence}).Run();
}

Status Quarantine(Db& db, const Uuid& attempt, const std::string& problem) {
  Query q(db, "UPDATE attempts SET state = " + Sql(AttemptState::kQuarantined) +
                  ", problem = ?3 WHERE tenant = ?1 AND id = ?2");
  ENAMEL_RETURN_IF_ERROR(q.Bind(attempt).Bind(problem).Run());
  return WriteAudit(db, Actor{{}, "station link"}, "attempt.quarantine", attempt.Text(), "{}",
                    JsonOf({{"problem", problem}}));
}

// A chunk of a number that is committed already, before the seal. After it: RepeatedAfterSeal.
Status Repeated(Db& db, const Ingest& ingest, const Store::ChunkPut& chunk, ByteView sealed,
                bool& keep_anyway) {
  ENAMEL_ASSIGN_OR_RETURN(auto stored, StoredHash(db, chunk.attempt, chunk.head.seq));
  if (!stored || *stored == chunk.hash) return Status::Ok();
  std::string problem = "chunk " + std::to_string(chunk.head.seq) +
                        " came twice with different content: " + stored->Hex() + " is committed, " +
                        chunk.hash.Hex() + " was refused";
  ENAMEL_RETURN_IF_ERROR(KeepEvidence(db, chunk, sealed));
  // Told once, however often it comes. The flag first: the row that is written last tells of it.
  if (ingest.state != AttemptState::kQuarantined) {
    Query q(db, "UPDATE attempts SET flags = flags | ?3 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(chunk.attempt).Bind(int64_t{kContradicted}).Run());
    ENAMEL_RETURN_IF_ERROR(Quarantine(db, chunk.attempt, problem));
  } else {
    ENAMEL_RETURN_IF_ERROR(
        SetFlags(db, chunk.attempt, kContradicted, problem, Actor{{}, "station link"}));
  }
  keep_anyway = true;
  return Status(Code::kConflict, problem + "; the attempt is quarantined, ask the instructor",
                "seq");
}

// What a second recording made with the same ticket leaves: a copy of a station's folder can use its
// tickets once more. Which of the two came first says nothing, so neither is taken for the right one:
// the attempt is flagged, what is committed stays, and the reason names the other.
Status Contradicted(Db& db, const Uuid& attempt, const std::string& problem) {
  return SetFlags(db, attempt, kContradicted,
                  problem +
                      "; one ticket was used for two recordings. The other one is still in "
                      "its station's spool",
                  Actor{{}, "station link"});
}

// What held the tool goes from the header into columns, for lists. A hand that the terms do not admit
// is flagged and not refused: what was recorded is kept, and looked at once it is sealed.
Status KeepHand(Db& db, const Uuid& attempt, ByteView header) {
  auto decoded = trace::DecodeHeader(header);
  // Whoever calls OpenAttempt has read the header; a header of another version tells of no hand.
  if (!decoded.ok()) return Status::Ok();
  const Hand& hand = decoded->hand;
  {
    Query q(db,
            "UPDATE attempts SET hand_kind = ?3, hand_device = ?4, hand_driver = ?5, hand_unit = "
            "?6 WHERE tenant = ?1 AND id = ?2");
    q.Bind(attempt).Bind(static_cast<int64_t>(hand.kind)).Bind(hand.device).Bind(hand.driver);
    ENAMEL_RETURN_IF_ERROR(q.Bind(hand.unit).Run());
  }
  Query terms(db, "SELECT hands FROM attempts WHERE tenant = ?1 AND id = ?2");
  const bool found = terms.Bind(attempt).Next();
  ENAMEL_RETURN_IF_ERROR(terms.status());
  if (!found) return Status::Ok();
  ENAMEL_ASSIGN_OR_RETURN(const bool listed, IsListedIn(db, hand));
  Status may = MayHold(static_cast<HandsAllowed>(terms.Int(0)), hand, listed);
  if (may.ok()) return may;
  return SetFlags(db, attempt, kOtherHand, may.message(), Actor{{}, "station link"});
}

// Asked in the writing transaction: what two connections of one station send is put in order
// here. The station answers a refusal by asking where the server stands.
Status MustContinue(const Ingest& ingest, const trace::ChunkHead& head) {
  if (head.seq != ingest.chunks) {
    return Status(Code::kConflict,
                  "expected chunk " + std::to_string(ingest.chunks) + ", found " +
                      std::to_string(head.seq) + "; send the missing ones first",
                  "seq");
  }
  if (head.first_tick != ingest.ticks) {
    return Status(Code::kConflict,
                  "chunk " + std::to_string(head.seq) + " must begin at tick " +
                      std::to_string(ingest.ticks) + ", it begins at " +
                      std::to_string(head.first_tick),
                  "first_tick");
  }
  if (head.previous != ingest.head) {
    return Status(Code::kConflict,
                  "chunk " + std::to_string(head.seq) + " must follow " + ingest.head.Hex() +
                      ", it names " + head.previous.Hex(),
                  "previous");
  }
  return Status::Ok();
}

// Counts the chunk that an attempt goes on with; changes nothing where it does not. What it has to fit (MustContinue says
// it in words) is asked in the statement; `in_one`: so is the chunk inserted: with a server every statement is a
// message, which costs more than the rows. The counts go with the chunk, so that no look at an attempt reads its chunks.
// `generation`: what the person's key has to be of, 0: of any (Keyring::Remember). `chunk` and `sealed` stay where they
// are until it has run.
sql::Change NextChunk(const Store::ChunkPut& chunk, ByteView sealed, int64_t generation,
                      bool in_one) {
  sql::Change next;
  next.sql =
      "UPDATE attempts SET head_hash = ?3, head_state_hash = ?4, chunks = chunks + 1, "
      "ticks = ticks + ?5, gap_ticks = gap_ticks + ?6, trace_bytes = trace_bytes + ?7, "
      "last_chunk_ms = ?8, flags = flags | "
      "CASE WHEN rate_hz > 0 AND (ticks + gap_ticks + ?5 + ?6) * 100000 > rate_hz * ?9 * (?8 - "
      "ticketed_ms + ?10) THEN " +
      Sql(kFasterThanTime) +
      " ELSE 0 END | "
      "CASE WHEN limit_ticks > 0 AND ticks + gap_ticks + ?5 + ?6 > limit_ticks THEN " +
      Sql(kOverTime) +
      " ELSE 0 END WHERE tenant = ?1 AND id = ?2 AND state = " + Sql(AttemptState::kRecording) +
      " AND header IS NOT NULL AND chunks = ?11 AND ticks = ?12 AND head_hash = ?13";
  if (generation != 0) {
    next.sql +=
        " AND EXISTS (SELECT 1 FROM person_keys k WHERE k.tenant = ?1 AND k.person = "
        "attempts.person AND k.generation = ?14)";
  }
  if (in_one) {
    next.sql = "WITH counted AS (" + next.sql + " RETURNING tenant, id) " + kInsertChunk +
               "SELECT tenant, id, ?11, ?3, " + (generation != 0 ? "?15" : "?14") +
               ", ?8 FROM counted";
  }
  next.bind = [&chunk, sealed, generation, in_one](sql::Query& q) {
    q.BindInt(Query::kTenant).BindBlob(chunk.attempt.view()).BindBlob(chunk.hash.view());
    q.BindInt(std::bit_cast<int64_t>(chunk.head.state_hash)).BindInt(chunk.head.count);
    q.BindInt(chunk.head.gap_ticks).BindInt(static_cast<int64_t>(chunk.bytes.size()));
    q.BindInt(chunk.received_ms).BindInt(kClockPercent).BindInt(kClockSlackMs);
    q.BindInt(chunk.head.seq).BindInt(static_cast<int64_t>(chunk.head.first_tick));
    q.BindBlob(chunk.head.previous.view());
    if (generation != 0) q.BindInt(generation);
    if (in_one) q.BindBlob(sealed);
  };
  return next;
}

// False: the attempt does not go on with it. Encrypted before (AppendWith), outside the writer's thread, which all wait
// for.
Result<bool> TryAppend(Db& db, const Store::ChunkPut& chunk, ByteView sealed, int64_t generation) {
  const bool in_one = db.GoesOnWithChanges();
  sql::Change next = NextChunk(chunk, sealed, generation, in_one);
  ENAMEL_RETURN_IF_ERROR(next.Run(db));
  if (next.rows == 0 || in_one) return next.rows > 0;
  Query row(db, std::string(kInsertChunk) + "VALUES (?1, ?2, ?3, ?4, ?5, ?6)");
  row.Bind(chunk.attempt).Bind(int64_t{chunk.head.seq}).Bind(chunk.hash).Bind(sealed);
  ENAMEL_RETURN_IF_ERROR(row.Bind(chunk.received_ms).Run());
  return true;
}

// Whether the work was late is certain when its ticks cannot have been made between ticket and due
// time; when only the upload was, it may have been made before.
uint32_t LateFlags(const Ingest& ingest) {
  if (ingest.due_ms == 0 || (ingest.flags & kLate) != 0) return 0;
  UnixMs shortest_ms = ingest.rate_hz > 0 ? static_cast<UnixMs>(ingest.ticks + ingest.gap_ticks) *
                                                1000 / ingest.rate_hz
                                          : 0;
  if (ingest.ticketed_ms + shortest_ms > ingest.due_ms) return kLate;
  if (ingest.last_chunk_ms > ingest.due_ms) return kLateUpload;
  return 0;
}

// All four: chunks and ticks say that nothing is missing, the hash that it is this chain, the
// state hash that both have the same tooth.
Status SealMatches(const Ingest& ingest, const trace::Seal& seal) {
  if (seal.chunks == ingest.chunks && seal.ticks == ingest.ticks &&
      seal.last_chunk == ingest.head && seal.state_hash == ingest.head_state_hash) {
    return Status::Ok();
  }
  return Status(Code::kConflict, "the seal names " + std::to_string(seal.chunks) + " chunks, " +
                                     std::to_string(seal.ticks) + " ticks and the last chunk " +
                                     seal.last_chunk.Hex() + "; committed are " +
                                     std::to_string(ingest.chunks) + ", " +
                                     std::to_string(ingest.ticks) + " and " + ingest.head.Hex() +
                                     "; send what is missing, then seal again");
}

Status MarkSealed(Db& db, const Uuid& attempt, const Ingest& ingest, const Sha256& blob,
                  UnixMs now_ms, bool keep_rows) {
  {
    Query q(db, "UPDATE attempts SET state = " + Sql(AttemptState::kSealed) +
                    ", sealed_ms = ?3, trace_blob = ?4, flags = flags | ?5 "
                    "WHERE tenant = ?1 AND id = ?2");
    q.Bind(attempt).Bind(now_ms).Bind(blob);
    ENAMEL_RETURN_IF_ERROR(q.Bind(int64_t{LateFlags(ingest)}).Run());
  }
  // Deleting an hour's chunks here would hold up all who record: SealedRows does it in portions.
  if (keep_rows) return Status::Ok();
  Query q(db, "DELETE FROM trace_chunks WHERE tenant = ?1 AND attempt = ?2");
  return q.Bind(attempt).Run();
}

Result<std::vector<Bytes>> ChunkRows(Db& db, const Uuid& attempt) {
  Query q(db, "SELECT bytes FROM trace_chunks WHERE tenant = ?1 AND attempt = ?2 ORDER BY seq");
  q.Bind(attempt);
  std::vector<Bytes> out;
  while (q.Next()) out.push_back(q.Blob(0));
  if (!q.status().ok()) return q.status();
  return out;
}

Status Expired(const Uuid& attempt) {
  return Status(Code::kNotFound, "the recording of attempt " + attempt.Text() +
                                     " was removed by a retention rule; its score stays");
}

Result<Bytes> HeaderOf(Db& db, const Uuid& attempt) {
  Query q(db, "SELECT header FROM attempts WHERE tenant = ?1 AND id = ?2");
  bool found = q.Bind(attempt).Next();
  if (!q.status().ok()) return q.status();
  if (!found || q.IsNull(0)) {
    return Status(Code::kNotFound, "attempt " + attempt.Text() + " has no recording");
  }
  return q.Blob(0);
}

}  // namespace

Status SqliteStore::OpenAttempt(const Uuid& attempt, ByteView header) {
  ENAMEL_RETURN_IF_ERROR(MayRecord());
  const Status opened = WriteRow(Writer::Work([&](Db& db, bool& keep_anyway) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto ingest, FindIngest(db, attempt, Look::kToDecide));
    if (ingest.has_header) {
      ENAMEL_ASSIGN_OR_RETURN(auto stored, HeaderOf(db, attempt));
      // A station that lost the answer opens again; a ticket used twice brings another header.
      if (std::ranges::equal(stored, header)) return Status::Ok();
      keep_anyway = true;
      ENAMEL_RETURN_IF_ERROR(Contradicted(db, attempt,
                                          "a header came with another hash, " +
                                              HashSha256(header).Hex() + ", than the stored " +
                                              HashSha256(stored).Hex()));
      return Status(Code::kConflict, "the ticket of attempt " + attempt.Text() +
                                         " was used for another recording; ask for a new ticket");
    }
    if ((ingest.flags & kReturned) != 0) {
      return Status(
          Code::kConflict,
          "the ticket of attempt " + attempt.Text() +
              " was handed back, so nothing can be recorded with it; ask for a new ticket",
          "ticket");
    }
    {
      Query q(db, "UPDATE attempts SET header = ?3, head_hash = ?4, state = " +
                      Sql(AttemptState::kRecording) +
                      ", trace_bytes = ?5 "
                      "WHERE tenant = ?1 AND id = ?2");
      q.Bind(attempt).Bind(header).Bind(HashSha256(header));
      ENAMEL_RETURN_IF_ERROR(q.Bind(static_cast<int64_t>(header.size())).Run());
    }
    return KeepHand(db, attempt, header);
  }));
  // So that the first chunk need not wait for a store of keys; it asks again.
  if (opened.ok()) (void)KeyOf(attempt);
  return opened;
}

Status SqliteStore::KeepFacts(const Uuid& attempt, const std::string& facts) {
  return Write([&](Db& db) -> Status {
    Query q(db, "UPDATE attempts SET facts = ?3 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(attempt).Bind(facts).Run());
    if (db.Changes() > 0) return Status::Ok();
    return Status(Code::kNotFound, "no attempt " + attempt.Text());
  });
}

// The chunks are in the blob then, which is read outside the writer.
Status SqliteStore::RepeatedAfterSeal(const ChunkPut& chunk) {
  ENAMEL_ASSIGN_OR_RETURN(auto chunks, AttemptChunks(chunk.attempt));
  ENAMEL_ASSIGN_OR_RETURN(auto stored, trace::DecodeChunkHead(chunks.at(chunk.head.seq)));
  if (stored.hash == chunk.hash) return Status::Ok();
  std::string problem = "chunk " + std::to_string(chunk.head.seq) + " of the sealed attempt " +
                        chunk.attempt.Text() + " is committed with other content";
  ENAMEL_ASSIGN_OR_RETURN(auto key, KeyOf(chunk.attempt));
  Bytes sealed = SealPersonal(key.person, key.key, chunk.attempt, chunk.bytes);
  ENAMEL_RETURN_IF_ERROR(Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(KeepEvidence(db, chunk, sealed));
    return SetFlags(db, chunk.attempt, kContradicted, problem, Actor{{}, "station link"});
  }));
  return Status(Code::kConflict, problem, "hash");
}

Status SqliteStore::AppendChunk(const ChunkPut& chunk) {
  ENAMEL_RETURN_IF_ERROR(MayRecord());
  ENAMEL_ASSIGN_OR_RETURN(const Uuid person, PersonOf(chunk.attempt));
  if (const auto remembered = keyring_.Remember(person)) {
    const KeyForChunk key{person, remembered->key, remembered->generation};
    ENAMEL_ASSIGN_OR_RETURN(const bool done, AppendWith(key, chunk));
    if (done) return Status::Ok();
  }
  ENAMEL_ASSIGN_OR_RETURN(const DataKey asked, keyring_.FindOrMake(person));
  return AppendWith({person, asked}, chunk).status();
}

Result<bool> SqliteStore::AppendWith(const KeyForChunk& key, const ChunkPut& chunk) {
  const Bytes sealed = SealPersonal(key.person, key.key, chunk.attempt, chunk.bytes);
  if (writer_.GoesOnWithChanges()) {
    // It is sent together with others' where it needs no answer before the commit: almost always.
    sql::Change next = NextChunk(chunk, sealed, key.generation, /*in_one*/ true);
    ENAMEL_RETURN_IF_ERROR(writer_.Run(next));
    if (next.rows > 0) CountChunk(chunk);
    if (next.rows > 0 || key.generation != 0) return next.rows > 0;
  }
  bool sealed_before = false, fresh = false;
  Status status = WriteRow(Writer::Work([&](Db& db, bool& keep_anyway) -> Status {
    // A work may run twice (writer.h).
    sealed_before = false;
    ENAMEL_ASSIGN_OR_RETURN(fresh, TryAppend(db, chunk, sealed, key.generation));
    if (fresh || key.generation != 0) return Status::Ok();
    ENAMEL_ASSIGN_OR_RETURN(auto ingest, FindIngest(db, chunk.attempt, Look::kToDecide));
    if (!ingest.has_header) {
      return Status(Code::kNotFound,
                    "attempt " + chunk.attempt.Text() + " is not open; send OpenAttempt");
    }
    // Not an error by itself: the station did not get the acknowledgement and sends again.
    if (chunk.head.seq < ingest.chunks) {
      sealed_before = !ingest.trace_blob.IsZero();
      return sealed_before ? Status::Ok() : Repeated(db, ingest, chunk, sealed, keep_anyway);
    }
    Status fits = ingest.state == AttemptState::kRecording
                      ? MustContinue(ingest, chunk.head)
                      : Status(Code::kConflict, "attempt " + chunk.attempt.Text() + " is " +
                                                    AttemptStateName(ingest.state) +
                                                    " and takes no more chunks");
    // Signed by the station, and of another chain, or beyond the end of the one that was sealed.
    if (fits.field() == "previous" || (!fits.ok() && !ingest.trace_blob.IsZero())) {
      keep_anyway = true;
      ENAMEL_RETURN_IF_ERROR(KeepEvidence(db, chunk, sealed));
      ENAMEL_RETURN_IF_ERROR(Contradicted(db, chunk.attempt,
                                          "chunk " + std::to_string(chunk.head.seq) +
                                              " is of another recording than what is "
                                              "committed"));
    }
    ENAMEL_RETURN_IF_ERROR(fits);
    // Another server has committed the chunk before it in this moment.
    ENAMEL_ASSIGN_OR_RETURN(fresh, TryAppend(db, chunk, sealed, key.generation));
    ENAMEL_CHECK(fresh);
    return Status::Ok();
  }));
  ENAMEL_RETURN_IF_ERROR(status);
  if (fresh) CountChunk(chunk);
  if (sealed_before) ENAMEL_RETURN_IF_ERROR(RepeatedAfterSeal(chunk));
  return fresh || key.generation == 0;
}

void SqliteStore::CountChunk(const ChunkPut& chunk) {
  ++chunks_;
  chunk_bytes_ += chunk.bytes.size();
}

// Outside the transaction that ends the attempt: after a crash in between, the blob is written
// again.
Status SqliteStore::MoveTraceToBlob(const trace::Seal& seal, Sha256& blob) {
  auto file = Read([&](Db& db) -> Result<trace::TraceFile> {
    ENAMEL_ASSIGN_OR_RETURN(auto header, HeaderOf(db, seal.attempt));
    ENAMEL_ASSIGN_OR_RETURN(auto chunks, ChunkRows(db, seal.attempt));
    return trace::TraceFile{std::move(header), std::move(chunks), seal, false};
  });
  if (!file.ok()) return file.status();
  PersonalReader personal(keyring_);
  for (Bytes& chunk : file->chunks) {
    ENAMEL_ASSIGN_OR_RETURN(auto opened, personal.Open(std::move(chunk)));
    chunk = std::move(opened);
  }
  ENAMEL_ASSIGN_OR_RETURN(auto hash, PutAttemptBlob(seal.attempt, trace::EncodeTraceFile(*file)));
  blob = hash;
  return Status::Ok();
}

// A seal that names fewer chunks than are committed, or as many with another last one, or that comes
// after another was taken, is of another recording. One that names more waits for them.
Status SqliteStore::NoteOtherSeal(const trace::Seal& seal) {
  return WriteRow([&](Db& db) -> Status {
    auto ingest = FindIngest(db, seal.attempt, Look::kToDecide);
    if (!ingest.ok() || ingest->chunks == 0 || SealMatches(*ingest, seal).ok()) return Status::Ok();
    const bool waits = ingest->trace_blob.IsZero() && seal.chunks > ingest->chunks;
    if (waits || ingest->expired) return Status::Ok();
    return Contradicted(db, seal.attempt,
                        "a seal came that names " + std::to_string(seal.chunks) +
                            " chunks and the last chunk " + seal.last_chunk.Hex() +
                            ", beside the " + std::to_string(ingest->chunks) +
                            " committed ones that end with " + ingest->head.Hex());
  });
}

Status SqliteStore::SealAttempt(const trace::Seal& seal, UnixMs now_ms) {
  // Asked twice: on a reader, so that no blob is written for a seal that does not fit, and in the
  // transaction that ends the attempt, as another connection may have been faster.
  auto check = [&](Db& db, Look look) -> Result<Ingest> {
    auto ingest = FindIngest(db, seal.attempt, look);
    if (!ingest.ok()) return ingest;
    bool quarantined = ingest->state == AttemptState::kQuarantined && ingest->trace_blob.IsZero();
    if (ingest->state == AttemptState::kTicketed || quarantined) {
      return Status(Code::kConflict, "attempt " + seal.attempt.Text() + " is " +
                                         AttemptStateName(ingest->state) + " and cannot be sealed");
    }
    if (Status status = SealMatches(*ingest, seal); !status.ok()) return status;
    return ingest;
  };
  ENAMEL_RETURN_IF_ERROR(MayRecord());
  auto before_or = Read([&](Db& db) { return check(db, Look::kOnly); });
  if (!before_or.ok()) {
    ENAMEL_RETURN_IF_ERROR(NoteOtherSeal(seal));
    return before_or.status();
  }
  const Ingest& before = *before_or;
  // Sealed by the same seal before: the answer got lost.
  if (before.state != AttemptState::kRecording) return Status::Ok();
  if (before.chunks == 0)
    return Status(Code::kConflict, "an attempt without a chunk cannot be sealed");
  Sha256 blob;
  ENAMEL_RETURN_IF_ERROR(MoveTraceToBlob(seal, blob));
  bool fresh = false;
  Status status = WriteRow([&](Db& db) -> Status {
    fresh = false;
    ENAMEL_ASSIGN_OR_RETURN(auto ingest, check(db, Look::kToDecide));
    if (ingest.state != AttemptState::kRecording) return Status::Ok();
    fresh = true;
    ENAMEL_RETURN_IF_ERROR(blobs_.Hold(db, {blob}));
    ENAMEL_RETURN_IF_ERROR(
        MarkSealed(db, seal.attempt, ingest, blob, now_ms, sealed_rows_.has_value()));
    // Of other work it is a flag that an instructor sees; of an exam nothing is scored before one has
    // looked. Nor is graded work with a hand that was not admitted, which a ticket was refused for or
    // would have been.
    if ((ingest.flags & kOtherHand) != 0) {
      ENAMEL_RETURN_IF_ERROR(
          Quarantine(db, seal.attempt,
                     "what held the tool is not what the assignment admits. An instructor may have "
                     "it scored all the same"));
    } else if (ingest.exam && (ingest.flags & kFasterThanTime) != 0) {
      ENAMEL_RETURN_IF_ERROR(
          Quarantine(db, seal.attempt,
                     "this exam has more ticks than time between its ticket and their arrival: it "
                     "was not made "
                     "in real time. An instructor may have it scored all the same"));
    } else {
      ENAMEL_RETURN_IF_ERROR(QueueScoreJob(db, seal.attempt, "seal"));
    }
    return WriteAudit(db, Actor{{}, "station link"}, "attempt.seal", seal.attempt.Text(), "{}",
                      JsonOf({{"chunks", std::to_string(seal.chunks)}, {"trace", blob.Hex()}}));
  });
  if (status.ok() && fresh) {
    ++sealed_;
    if (sealed_rows_) sealed_rows_->Add(seal.attempt);
  }
  return status;
}

Status SqliteStore::AcceptCommitted(const Uuid& attempt, const Actor& by) {
  // Quarantined while it was recorded: there will be no seal from the station any more.
  auto unsealed = [](const Ingest& ingest) {
    return ingest.state == AttemptState::kQuarantined && ingest.trace_blob.IsZero() &&
           !ingest.expired && ingest.chunks > 0;
  };
  auto before = Read([&](Db& db) { return FindIngest(db, attempt, Look::kOnly); });
  if (!before.ok()) return before.status();
  if (!unsealed(*before)) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(MayRecord());
  Sha256 blob;
  ENAMEL_RETURN_IF_ERROR(MoveTraceToBlob(
      {attempt, before->chunks, before->ticks, before->head, before->head_state_hash}, blob));
  bool fresh = false;
  Status status = Write([&](Db& db) -> Status {
    fresh = false;
    ENAMEL_ASSIGN_OR_RETURN(auto ingest, FindIngest(db, attempt, Look::kToDecide));
    if (!unsealed(ingest)) return Status::Ok();
    fresh = true;
    ENAMEL_RETURN_IF_ERROR(blobs_.Hold(db, {blob}));
    ENAMEL_RETURN_IF_ERROR(
        MarkSealed(db, attempt, ingest, blob, NowMs(), sealed_rows_.has_value()));
    return WriteAudit(db, by, "attempt.accept", attempt.Text(), "{}",
                      JsonOf({{"chunks", std::to_string(ingest.chunks)}, {"trace", blob.Hex()}}));
  });
  if (status.ok() && fresh && sealed_rows_) sealed_rows_->Add(attempt);
  return status;
}

Result<std::vector<ContradictionRow>> SqliteStore::ContradictionsOf(const Uuid& attempt) {
  return Read([&](Db& db) -> Result<std::vector<ContradictionRow>> {
    Query q(db,
            "SELECT seq, hash, received_ms FROM contradicting_chunks WHERE tenant = ?1 AND "
            "attempt = ?2 ORDER BY seq, received_ms, hash");
    q.Bind(attempt);
    std::vector<ContradictionRow> out;
    while (q.Next()) out.push_back({static_cast<uint32_t>(q.Int(0)), q.Hash(1), q.Int(2)});
    if (!q.status().ok()) return q.status();
    return out;
  });
}

Result<Bytes> SqliteStore::AttemptHeader(const Uuid& attempt) {
  return Read([&](Db& db) { return HeaderOf(db, attempt); });
}

Result<std::vector<Bytes>> SqliteStore::AttemptChunks(const Uuid& attempt) {
  Sha256 blob;
  auto rows = Read([&](Db& db) -> Result<std::vector<Bytes>> {
    ENAMEL_ASSIGN_OR_RETURN(auto ingest, FindIngest(db, attempt, Look::kOnly));
    blob = ingest.trace_blob;
    if (ingest.expired) return Expired(attempt);
    if (!blob.IsZero()) return std::vector<Bytes>();
    return ChunkRows(db, attempt);
  });
  if (!rows.ok()) return rows;
  PersonalReader personal(keyring_);
  for (Bytes& row : *rows) {
    ENAMEL_ASSIGN_OR_RETURN(auto opened, personal.Open(std::move(row)));
    row = std::move(opened);
  }
  if (blob.IsZero()) return rows;
  ENAMEL_ASSIGN_OR_RETURN(auto bytes, GetBlob(blob));
  ENAMEL_ASSIGN_OR_RETURN(auto file, trace::DecodeTraceFile(bytes));
  return std::move(file.chunks);
}

Result<std::vector<Bytes>> SqliteStore::NewestChunks(const Uuid& attempt, uint32_t from,
                                                     uint32_t most) {
  auto rows = Read([&](Db& db) -> Result<std::vector<Bytes>> {
    Query q(
        db,
        "SELECT bytes FROM trace_chunks WHERE tenant = ?1 AND attempt = ?2 AND seq >= ?3 ORDER BY "
        "seq DESC LIMIT ?4");
    q.Bind(attempt).Bind(int64_t{from}).Bind(int64_t{most});
    std::vector<Bytes> out;
    while (q.Next()) out.push_back(q.Blob(0));
    if (!q.status().ok()) return q.status();
    return out;
  });
  if (!rows.ok()) return rows;
  std::ranges::reverse(*rows);
  PersonalReader personal(keyring_);
  for (Bytes& row : *rows) {
    ENAMEL_ASSIGN_OR_RETURN(row, personal.Open(std::move(row)));
  }
  return rows;
}

Result<trace::Seal> SqliteStore::AttemptSeal(const Uuid& attempt) {
  return Read([&](Db& db) -> Result<trace::Seal> {
    ENAMEL_ASSIGN_OR_RETURN(auto ingest, FindIngest(db, attempt, Look::kOnly));
    if (ingest.expired) return Expired(attempt);
    if (ingest.trace_blob.IsZero()) {
      return Status(Code::kConflict, "attempt " + attempt.Text() + " is not sealed yet");
    }
    return trace::Seal{attempt, ingest.chunks, ingest.ticks, ingest.head, ingest.head_state_hash};
  });
}

}  // namespace enamel::server::sqlite
