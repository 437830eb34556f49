#include "server/storage/verify/verify_attempts.h"

#include <algorithm>
#include <map>

#include "server/storage/engine/query.h"
#include "server/storage/recordings/trace_parts.h"
#include "server/training/types.h"

namespace enamel::server {
namespace {

// Chunks in memory at once, of at most a mebibyte each.
constexpr int64_t kRowsAtOnce = 16;
constexpr char kAskStation[] =
    "restore a backup, or have the station send it again within seven days";

// What an attempt's row says.
struct AttemptFacts {
  Uuid id, person, station;
  AttemptState state = AttemptState::kTicketed;
  Bytes header;
  Bytes ticket;
  bool has_header = false, expired = false;
  Hand hand;
  int64_t last_chunk_ms = 0;
  Sha256 head, trace_blob;
  uint64_t head_state_hash = 0, chunks = 0, ticks = 0, gap_ticks = 0, trace_bytes = 0;
};

AttemptFacts FactsOf(const Query& q) {
  AttemptFacts out;
  q.Read(0, out.id, out.person, out.station, out.state, out.header, out.head, out.head_state_hash,
         out.chunks, out.ticks, out.gap_ticks, out.trace_bytes, out.trace_blob, out.expired,
         out.hand, out.ticket, out.last_chunk_ms);
  out.has_header = !q.IsNull(4);
  return out;
}

class AttemptCheck {
 public:
  AttemptCheck(Db& db, StoredBlobs& stored, const std::optional<trace::PublicKey>& key,
               VerifyReport& report, const UpkeepProgress& progress)
      : db_(db), stored_(stored), key_(key), report_(report), progress_(progress) {}

  Status Check() {
    ENAMEL_RETURN_IF_ERROR(LoadStations());
    Query count(db_, "SELECT count(*), coalesce(sum(ticks), 0) FROM attempts WHERE tenant = ?1");
    uint64_t all = count.Next() ? static_cast<uint64_t>(count.Int(0)) : 0;
    ENAMEL_RETURN_IF_ERROR(count.status());
    Query q(db_,
            "SELECT id, person, station, state, header, head_hash, head_state_hash, chunks, ticks, "
            "gap_ticks, trace_bytes, trace_blob, expired_ms, hand_kind, hand_device, hand_driver, "
            "hand_unit, ticket, last_chunk_ms FROM attempts WHERE tenant = ?1");
    while (q.Next()) {
      AttemptFacts facts = FactsOf(q);
      ++report_.attempts;
      ENAMEL_RETURN_IF_ERROR(CheckAttempt(facts));
      if (progress_) progress_("attempts", report_.attempts, all);
    }
    return q.status();
  }

 private:
  Status LoadStations() {
    Query q(db_, "SELECT id, public_key FROM stations WHERE tenant = ?1");
    while (q.Next()) {
      Bytes key = q.Blob(1);
      trace::PublicKey& into = stations_[q.Id(0)];
      // A key of another length stays zero, and then no signature fits: that is found at its
      // chunks.
      if (key.size() == into.size()) std::ranges::copy(key, into.begin());
    }
    return q.status();
  }

  Status CheckAttempt(const AttemptFacts& facts) {
    if (!facts.has_header) {
      CheckNothingRecorded(facts);
      return Status::Ok();
    }
    CheckHeader(facts);
    ENAMEL_RETURN_IF_ERROR(CheckEvidence(facts));
    // A retention rule has removed the recording; the header stays with the score.
    if (facts.expired) return Status::Ok();
    if (!facts.trace_blob.IsZero()) {
      ++report_.sealed;
      return CheckSealed(facts);
    }
    // Only those two may still have their chunks as rows.
    if (facts.state != AttemptState::kRecording && facts.state != AttemptState::kQuarantined) {
      report_.Find("seal", facts.id.Text(),
                   "a trace, as the attempt is " + std::string(AttemptStateName(facts.state)),
                   "none named", kFromBackup);
      return Status::Ok();
    }
    return CheckOpen(facts);
  }

  // Checks a recording that is not sealed, with a few rows in memory.
  Status CheckOpen(const AttemptFacts& facts) {
    Query last(db_,
               "SELECT received_ms FROM trace_chunks WHERE tenant = ?1 AND attempt = ?2 ORDER BY "
               "seq DESC LIMIT 1");
    const int64_t last_ms = last.Bind(facts.id).Next() ? last.Int(0) : 0;
    ENAMEL_RETURN_IF_ERROR(last.status());
    if (last_ms != facts.last_chunk_ms) {
      report_.Find("chain", facts.id.Text(),
                   "the time of the last chunk, " + std::to_string(last_ms) + " ms",
                   std::to_string(facts.last_chunk_ms) + " ms in the attempt's row", kFromBackup);
    }
    std::vector<ChunkRow> rows;
    size_t at = 0;
    int64_t next_seq = 0;
    bool opened = true;
    const Status read = CheckChain(facts, [&]() -> Result<std::optional<Bytes>> {
      if (at == rows.size()) {
        at = 0;
        ENAMEL_ASSIGN_OR_RETURN(rows, ChunkRowsOf(facts.id, "trace_chunks", next_seq));
        if (rows.empty()) return std::optional<Bytes>();
        opened = OpenChunks(facts, rows);
        if (!opened) return Status(Code::kNotFound, "noted");
      }
      ChunkRow& row = rows[at++];
      CheckChunkRow(facts, row, "trace_chunks");
      next_seq = row.seq + 1;
      return std::optional<Bytes>(std::move(row.bytes));
    });
    return opened ? read : Status::Ok();
  }

  // A chunk as a row, with what the row says of it.
  struct ChunkRow {
    int64_t seq = 0, received_ms = 0;
    Sha256 hash;
    Bytes bytes;
  };

  // From that number on, kRowsAtOnce at most.
  Result<std::vector<ChunkRow>> ChunkRowsOf(const Uuid& attempt, const std::string& table,
                                            int64_t from) {
    Query q(db_, "SELECT seq, received_ms, hash, bytes FROM " + table +
                     " WHERE tenant = ?1 AND attempt = ?2 AND seq >= ?3 ORDER BY seq LIMIT ?4");
    std::vector<ChunkRow> out;
    for (q.Bind(attempt, from, kRowsAtOnce); q.Next();)
      out.push_back({q.Int(0), q.Int(1), q.Hash(2), q.Blob(3)});
    ENAMEL_RETURN_IF_ERROR(q.status());
    return out;
  }

  void CheckChunkRow(const AttemptFacts& facts, const ChunkRow& row, const char* table) {
    const auto head = trace::DecodeChunkHead(row.bytes);
    if (head.ok() && head->hash == row.hash && head->head.seq == row.seq &&
        head->head.attempt == facts.id) {
      return;
    }
    report_.Find("chain", facts.id.Text(),
                 "in " + std::string(table) + " chunk " + std::to_string(row.seq) + " with hash " +
                     row.hash.Hex(),
                 head.ok()
                     ? "chunk " + std::to_string(head->head.seq) + " with hash " + head->hash.Hex()
                     : head.status().message(),
                 kFromBackup);
  }

  // Which ones there are is in the attempt's state in the audit trail.
  Status CheckEvidence(const AttemptFacts& facts) {
    ENAMEL_ASSIGN_OR_RETURN(auto rows, ChunkRowsOf(facts.id, "contradicting_chunks", 0));
    if (!OpenChunks(facts, rows)) return Status::Ok();
    for (const ChunkRow& row : rows) {
      CheckChunkRow(facts, row, "contradicting_chunks");
      if (!IsSigned(facts, row.bytes)) FindUnsigned(facts, 1, static_cast<uint64_t>(row.seq), 1);
    }
    return Status::Ok();
  }

  void CheckNothingRecorded(const AttemptFacts& facts) {
    if (facts.head.IsZero() && facts.trace_blob.IsZero() && facts.hand == Hand() &&
        facts.head_state_hash + facts.chunks + facts.ticks + facts.gap_ticks + facts.trace_bytes ==
            0 &&
        facts.last_chunk_ms == 0) {
      return;
    }
    report_.Find("chain", facts.id.Text(), "nothing recorded, as there is no header",
                 RowText(facts), kFromBackup);
  }

  void CheckHeader(const AttemptFacts& facts) {
    auto header = trace::DecodeHeader(facts.header);
    if (!header.ok()) {
      report_.Find("ticket", facts.id.Text(), "a header with the server's ticket",
                   header.status().message(), kAskStation);
      return;
    }
    const trace::Ticket& ticket = header->ticket;
    if (ticket.attempt != facts.id || ticket.person != facts.person ||
        ticket.station != facts.station) {
      report_.Find("ticket", facts.id.Text(), "a ticket of this attempt, person and station",
                   "one of attempt " + ticket.attempt.Text() + ", person " + ticket.person.Text() +
                       ", station " + ticket.station.Text(),
                   kFromBackup);
    }
    if (trace::EncodeTicket(ticket) != facts.ticket) {
      report_.Find("ticket", facts.id.Text(), "in the attempt's row the ticket of its header",
                   "another one", kFromBackup);
    }
    if (header->hand != facts.hand) {
      report_.Find("hand", facts.id.Text(),
                   "in the attempt's row the hand of its header, " + HandText(header->hand),
                   HandText(facts.hand), kFromBackup);
    }
    if (key_ && !trace::VerifyTicket(ticket, *key_)) {
      report_.Find("ticket", facts.id.Text(), "a ticket signed by this server", "another signature",
                   "compare ticket.key with the one of a backup");
    }
  }

  bool OpenChunks(const AttemptFacts& facts, std::vector<ChunkRow>& chunks) {
    if (!stored_.has_keys && std::ranges::any_of(chunks, [](const ChunkRow& c) {
          return PersonOfSealed(c.bytes).has_value();
        })) {
      return false;  // noted: the keys are apart
    }
    for (ChunkRow& chunk : chunks) {
      auto opened = OpenPersonal(stored_.keyring, std::move(chunk.bytes));
      if (!opened.ok()) {
        report_.Find("key", facts.id.Text(), "chunks that the person's key opens",
                     opened.status().message(), "restore the key ring");
        return false;
      }
      chunk.bytes = std::move(opened).value();
    }
    return true;
  }

  // A part in memory at a time.
  Status CheckSealed(const AttemptFacts& facts) {
    TraceBlobs blobs;
    ENAMEL_ASSIGN_OR_RETURN(blobs.parts, PartsOf(db_, facts.id));
    blobs.last = facts.trace_blob;
    // A blob that is missing, damaged or kept under another key is in the report already; so is a
    // note about keys that are kept apart.
    bool found = false;
    PartsReader parts(std::move(blobs), [&](const Sha256& hash) -> Result<Bytes> {
      found = true;
      if (stored_.bad.contains(hash)) return Status(Code::kStorage, "found already");
      ENAMEL_ASSIGN_OR_RETURN(Bytes sealed, stored_.blobs.Get(hash));
      if (!stored_.has_keys && PersonOfSealed(sealed)) return Status(Code::kNotFound, "noted");
      ENAMEL_ASSIGN_OR_RETURN(Bytes opened, OpenPersonal(stored_.keyring, std::move(sealed)));
      found = false;
      return opened;
    });
    const Status read = CheckChain(
        facts, [&] { return parts.Next(); }, &parts.seal());
    if (found) return Status::Ok();
    if (!read.ok()) {
      report_.Find("seal", facts.id.Text(), "a whole trace with its seal", read.message(),
                   kAskStation);
      return Status::Ok();
    }
    if (parts.header() != facts.header) {
      report_.Find("chain", facts.id.Text(),
                   "the header of the attempt's row at the head of its trace", "another one",
                   kFromBackup);
    }
    return Status::Ok();
  }

  // `seal`: of a sealed one, known after the last chunk. Errors: what `next` returns.
  Status CheckChain(const AttemptFacts& facts, const trace::NextChunk& next,
                    const std::optional<trace::Seal>* seal = nullptr) {
    trace::ChainVerifier chain(facts.id, HashSha256(facts.header));
    const std::string id = facts.id.Text();
    uint64_t bytes = facts.header.size(), gaps = 0, unsigned_chunks = 0, first_unsigned = 0;
    for (;;) {
      ENAMEL_ASSIGN_OR_RETURN(const auto encoded, next());
      if (!encoded) break;
      auto chunk = trace::DecodeChunk(*encoded);
      if (!chunk.ok()) {
        report_.Find("chain", id, "chunk " + std::to_string(chain.next_seq()) + " to be whole",
                     chunk.status().message(), kAskStation);
        return Status::Ok();
      }
      if (Status linked = chain.Accept(*chunk); !linked.ok()) {
        report_.Find("chain", id, "each chunk to continue the one before", linked.message(),
                     kAskStation);
        return Status::Ok();
      }
      if (!IsSigned(facts, *encoded) && unsigned_chunks++ == 0) first_unsigned = chunk->head.seq;
      bytes += encoded->size();
      gaps += chunk->head.gap_ticks;
      ++report_.chunks;
      report_.ticks += chunk->head.count;
    }
    if (unsigned_chunks > 0) FindUnsigned(facts, unsigned_chunks, first_unsigned, chain.next_seq());
    if (chain.next_seq() != facts.chunks || chain.next_tick() != facts.ticks ||
        chain.head() != facts.head || chain.state_hash() != facts.head_state_hash) {
      report_.Find("chain", id, RowText(facts),
                   "the chunks say " + std::to_string(chain.next_seq()) + " chunks, " +
                       std::to_string(chain.next_tick()) + " ticks, head " + chain.head().Hex(),
                   kAskStation);
    }
    // The counts are beside the chain and prove nothing; a difference still says that a row was
    // changed by hand.
    if (bytes != facts.trace_bytes || gaps != facts.gap_ticks) {
      report_.Find("chain", id,
                   std::to_string(facts.trace_bytes) + " bytes and " +
                       std::to_string(facts.gap_ticks) + " ticks of gaps, as the row says",
                   std::to_string(bytes) + " and " + std::to_string(gaps), kFromBackup);
    }
    if (seal == nullptr) return Status::Ok();
    if (Status sealed = chain.AcceptSeal(**seal); !sealed.ok())
      report_.Find("seal", id, "a seal that fits the chunks", sealed.message(), kFromBackup);
    return Status::Ok();
  }

  static std::string RowText(const AttemptFacts& facts) {
    return "the row's " + std::to_string(facts.chunks) + " chunks, " + std::to_string(facts.ticks) +
           " ticks, head " + facts.head.Hex();
  }

  bool IsSigned(const AttemptFacts& facts, const Bytes& chunk) const {
    auto key = stations_.find(facts.station);
    return key != stations_.end() && trace::VerifyChunk(chunk, key->second);
  }

  // One for the attempt: a station's changed key would be thousands.
  void FindUnsigned(const AttemptFacts& facts, uint64_t count, uint64_t first, size_t of) {
    const std::string which = count == of && count > 1 ? "all " + std::to_string(of) + " chunks"
                              : count == 1
                                  ? "chunk " + std::to_string(first)
                                  : std::to_string(count) + " of " + std::to_string(of) +
                                        " chunks, from chunk " + std::to_string(first) + " on,";
    report_.Find("signature", facts.id.Text(), which + " signed by station " + facts.station.Text(),
                 stations_.contains(facts.station) ? "another signature" : "no such station",
                 kAskStation);
  }

  Db& db_;
  StoredBlobs& stored_;
  const std::optional<trace::PublicKey>& key_;
  VerifyReport& report_;
  const UpkeepProgress& progress_;
  std::map<Uuid, trace::PublicKey> stations_;
};

}  // namespace

Status CheckAttempts(Db& db, StoredBlobs& stored, const std::optional<trace::PublicKey>& key,
                     VerifyReport& report, const UpkeepProgress& progress) {
  return AttemptCheck(db, stored, key, report, progress).Check();
}

}  // namespace enamel::server
