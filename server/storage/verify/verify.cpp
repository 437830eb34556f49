#include "server/storage/verify/verify.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <thread>

#include "common/trace/trace.h"
#include "server/storage/audit/audit_row.h"
#include "server/storage/blobs/blobs.h"
#include "server/storage/blobs/named_blobs.h"
#include "server/storage/engine/database.h"
#include "server/storage/engine/query.h"
#include "server/storage/folder/database_file.h"
#include "server/storage/folder/disk.h"
#include "server/storage/folder/folder_lock.h"
#include "server/storage/folder/ticket_key.h"
#include "server/storage/keys/folder_keyring.h"
#include "server/storage/keys/key_rows.h"
#include "server/storage/keys/keyring.h"
#include "server/storage/verify/manifest.h"
#include "server/storage/verify/verify_audit.h"
#include "server/storage/verify/verify_results.h"
#include "server/storage/verify/verify_stage.h"
#include "server/training/types.h"

namespace enamel::server {
namespace {

namespace fs = std::filesystem;

constexpr char kFromBackup[] = "restore a backup that has it";
constexpr char kAskStation[] =
    "restore a backup, or have the station send it again within seven days";

// What an attempt's row says.
struct AttemptFacts {
  Uuid id, person, station;
  AttemptState state = AttemptState::kTicketed;
  Bytes header;
  bool has_header = false, expired = false;
  Hand hand;
  Sha256 head, trace_blob;
  uint64_t head_state_hash = 0, chunks = 0, ticks = 0, gap_ticks = 0, trace_bytes = 0;
};

AttemptFacts FactsOf(const Query& q) {
  AttemptFacts out;
  out.id = q.Id(0);
  out.person = q.Id(1);
  out.station = q.Id(2);
  out.state = static_cast<AttemptState>(q.Int(3));
  out.has_header = !q.IsNull(4);
  out.header = q.Blob(4);
  out.head = q.Hash(5);
  out.head_state_hash = std::bit_cast<uint64_t>(q.Int(6));
  out.chunks = static_cast<uint64_t>(q.Int(7));
  out.ticks = static_cast<uint64_t>(q.Int(8));
  out.gap_ticks = static_cast<uint64_t>(q.Int(9));
  out.trace_bytes = static_cast<uint64_t>(q.Int(10));
  out.trace_blob = q.Hash(11);
  out.expired = q.Int(12) != 0;
  out.hand = {static_cast<HandKind>(q.Int(13)), q.Text(14), q.Text(15), q.Text(16)};
  return out;
}

class Verifier {
 public:
  explicit Verifier(const VerifyOptions& options)
      : options_(options),
        blobs_(options.folder / "blobs", SystemDisk()),
        keyring_(options.keyring.empty() ? options.folder / "keyring" : options.keyring,
                 SystemDisk()) {}

  Result<VerifyReport> Run() {
    fs::path path = options_.folder / "enamel.db";
    std::error_code error;
    ENAMEL_RETURN_IF_ERROR(MustHaveRowsInFolder(options_.folder, "verify"));
    if (!fs::exists(path, error)) {
      return Status(Code::kNotFound, "there is no enamel.db in " + options_.folder.string() +
                                         "; name a data folder or a backup");
    }
    if (!options_.since.empty()) {
      ENAMEL_ASSIGN_OR_RETURN(auto manifest, ReadManifest(options_.since));
      earlier_ = std::move(manifest.trail);
    }
    report_.is_backup = fs::exists(options_.folder / kManifestName, error);
    if (report_.is_backup) CheckManifest();
    ENAMEL_ASSIGN_OR_RETURN(auto db, OpenDatabase(path, DbMode::kReadOnly));
    // One reading transaction over all: a server may write meanwhile.
    Status begun = db->Exec("BEGIN");
    auto schema = begun.ok() ? SchemaVersion(*db) : Result<int>(begun);
    // Not damage: another program's file, or a newer one, is for another program to judge.
    if (!schema.ok() && schema.status().code() == Code::kVersion) return schema.status();
    if (!schema.ok()) {
      Find("database", path.string(), "a database that can be read", schema.status().message(),
           kFromBackup);
      return report_;
    }
    report_.schema = *schema;
    if (Status status = CheckAll(*db); !status.ok()) {
      Find("database", path.string(), "a database that can be read to its end", status.message(),
           kFromBackup);
    }
    return report_;
  }

 private:
  void Find(std::string kind, std::string object, std::string expected, std::string found,
            std::string remedy) {
    report_.findings.push_back({std::move(kind), std::move(object), std::move(expected),
                                std::move(found), std::move(remedy)});
  }

  void Tell(const char* what, uint64_t done, uint64_t all) const {
    if (options_.progress) options_.progress(what, done, all);
  }

  Status CheckAll(Db& db) {
    // From the bottom up: what the pages say is believed below only when they are whole.
    ENAMEL_RETURN_IF_ERROR(CheckDatabase(db));
    // Verifying changes nothing, so an older database is not migrated; the statements below are for
    // the newest.
    if (report_.schema < LatestSchemaVersion()) {
      report_.notes.push_back("the database has schema " + std::to_string(report_.schema) +
                              " and was not looked at further; start the server once, which "
                              "brings it to schema " +
                              std::to_string(LatestSchemaVersion()));
      return Status::Ok();
    }
    ENAMEL_ASSIGN_OR_RETURN(auto named, NamedBlobs(db));
    has_keys_ = LooksLikeKeyring();
    ENAMEL_RETURN_IF_ERROR(CheckBlobs(named));
    ENAMEL_RETURN_IF_ERROR(CheckPeople(db));
    ENAMEL_RETURN_IF_ERROR(LoadStations(db));
    LoadTicketKey();
    ENAMEL_RETURN_IF_ERROR(CheckAttempts(db));
    ENAMEL_RETURN_IF_ERROR(CheckResults(db, ticket_key_, report_));
    ENAMEL_RETURN_IF_ERROR(CheckTimelines(db));
    ENAMEL_RETURN_IF_ERROR(CheckStages(db, report_));
    return CheckAudit(db, ticket_key_, earlier_, report_, options_.progress);
  }

  // A playback is in no signed result: that it was made of its own attempt is in its envelope.
  Status CheckTimelines(Db& db) {
    Query q(db, "SELECT attempt, content FROM timelines WHERE tenant = ?1 AND content IS NOT NULL");
    while (q.Next()) {
      if (!has_keys_ || bad_blobs_.contains(q.Hash(1))) continue;  // noted, or found already
      const auto sealed = blobs_.Get(q.Hash(1));
      if (!sealed.ok() || !PersonOfSealed(*sealed)) continue;
      const auto own = IsOfAttempt(keyring_, *sealed, q.Id(0));
      if (own.ok() && !*own) {
        Find("timeline", q.Id(0).Text(), "the playback that was made of this attempt",
             "one of another attempt", "have the attempt scored again, which makes it anew");
      }
    }
    return q.status();
  }

  void CheckManifest() {
    auto manifest = ReadManifest(options_.folder);
    if (!manifest.ok()) {
      Find("file", kManifestName, "a manifest (schemas/backup.md)", manifest.status().message(),
           "make a new backup");
      return;
    }
    // The manifest has to agree with the backup's own database as well.
    earlier_.insert(earlier_.end(), manifest->trail.begin(), manifest->trail.end());
    if (!manifest->keyring_inside && options_.keyring.empty()) {
      report_.notes.push_back(
          "the keys of this backup are kept apart: what is kept under them was not opened; name "
          "them with --keyring");
    }
    std::set<std::string> listed;
    uint64_t done = 0;
    for (const Manifest::File& file : manifest->files) {
      listed.insert(file.path);
      Tell("files of the manifest", ++done, manifest->files.size());
      if (file.path.starts_with("blobs/")) {
        in_manifest_.insert(*Sha256::FromHex(fs::path(file.path).filename().string()));
        continue;  // its name is its hash, and blobs are all read below
      }
      auto content = SystemDisk().Hash(options_.folder / file.path);
      if (!content.ok()) {
        Find("file", file.path, "a file of " + std::to_string(file.bytes) + " bytes",
             content.status().message(), "use another backup");
      } else if (content->hash != file.hash) {
        Find("file", file.path, "content " + file.hash.Hex(), content->hash.Hex(),
             "use another backup");
      }
    }
    FindUnlisted(listed);
  }

  // What the manifest does not list is not restored: somebody may count on it.
  void FindUnlisted(const std::set<std::string>& listed) {
    std::error_code error;
    for (fs::recursive_directory_iterator it(options_.folder, error), end; !error && it != end;
         it.increment(error)) {
      std::string path = it->path().lexically_relative(options_.folder).generic_string();
      if (it->is_directory(error) || path == kManifestName || listed.contains(path)) continue;
      Find("file", path, "only files that the manifest lists", "a file more",
           "take it away, or make a new backup");
    }
  }

  Status CheckDatabase(Db& db) {
    Tell("database", 0, 1);
    sql::Query integrity(db, "PRAGMA integrity_check(100)");
    while (integrity.Next()) {
      if (integrity.Text(0) != "ok")
        Find("database", "enamel.db", "a whole database", integrity.Text(0), kFromBackup);
    }
    ENAMEL_RETURN_IF_ERROR(integrity.status());
    sql::Query keys(db, "PRAGMA foreign_key_check");
    while (keys.Next()) {
      Find("database", keys.Text(0), "rows that name existing rows of " + keys.Text(2),
           "row " + keys.Text(1) + " names one that is not there", kFromBackup);
    }
    Tell("database", 1, 1);
    return keys.status();
  }

  bool LooksLikeKeyring() const {
    std::error_code error;
    return fs::exists(keyring_.folder(), error);
  }

  Status CheckBlobs(const std::set<Sha256>& named) {
    ENAMEL_ASSIGN_OR_RETURN(auto listing, blobs_.List());
    for (const fs::path& other : listing.others) {
      report_.notes.push_back(other.string() +
                              " is no blob: what an interrupted write left, or put "
                              "there by hand");
    }
    uint64_t done = 0;
    for (const Sha256& hash : listing.blobs) {
      CheckBlob(hash, named.contains(hash));
      Tell("blobs", ++done, listing.blobs.size());
    }
    for (const Sha256& hash : named) {
      if (std::ranges::binary_search(listing.blobs, hash)) continue;
      Find("blob", hash.Hex(), "a blob that the database names", "no such file", kFromBackup);
    }
    for (const Sha256& hash : in_manifest_) {
      if (named.contains(hash) || std::ranges::binary_search(listing.blobs, hash)) continue;
      Find("blob", hash.Hex(), "a blob that the manifest lists", "no such file",
           "use another backup");
    }
    return Status::Ok();
  }

  void CheckBlob(const Sha256& hash, bool is_named) {
    auto content = blobs_.Get(hash);
    if (!content.ok()) {
      bad_blobs_.insert(hash);
      if (is_named) {
        Find("blob", hash.Hex(), "content with this hash", content.status().message(), kFromBackup);
      } else {
        report_.notes.push_back("blob " + hash.Hex() +
                                " is damaged; nothing names it, so nothing is lost");
      }
      return;
    }
    ++report_.blobs;
    report_.blob_bytes += content->size();
    if (!is_named) {
      ++report_.unnamed_blobs;
      report_.unnamed_bytes += content->size();
      return;
    }
    if (!has_keys_ || !PersonOfSealed(*content)) return;
    auto opened = OpenPersonal(keyring_, std::move(content).value());
    if (opened.ok()) return;
    bad_blobs_.insert(hash);
    Find("key", hash.Hex(), "a blob that its person's key opens", opened.status().message(),
         "restore the key ring");
  }

  Status CheckPeople(Db& db) {
    std::set<Uuid> people;
    std::set<Sha256> gone;
    Query q(db, "SELECT id FROM people WHERE tenant = ?1");
    while (q.Next()) people.insert(q.Id(0));
    ENAMEL_RETURN_IF_ERROR(q.status());
    ENAMEL_ASSIGN_OR_RETURN(auto erased, ErasuresIn(db));
    auto buried = keyring_.Gone();
    auto keys = keyring_.People();
    for (const Status& status : {buried.status(), keys.status()}) {
      if (!status.ok())
        Find("key", keyring_.folder().string(), "a key ring", status.message(), kFromBackup);
    }
    // Half of a list would call people erased who are not, or the other way round.
    if (!buried.ok() || !keys.ok()) return Status::Ok();
    for (const auto& list : {erased, *buried}) {
      for (const Tombstone& tombstone : list) gone.insert(tombstone.person);
    }
    report_.people = people.size();
    report_.keys = keys->size();
    report_.erased = gone.size();
    for (const Uuid& person : people) {
      if (gone.contains(TombstoneOf(person))) FindErased(person, "rows of an erased person");
    }
    for (const Uuid& person : *keys) {
      if (gone.contains(TombstoneOf(person))) FindErased(person, "the key of an erased person");
    }
    return Status::Ok();
  }

  void FindErased(const Uuid& person, const std::string& found) {
    Find("erasure", person.Text(), "nothing of a person who was erased", found,
         "start the server once: it finishes erasures");
  }

  Status LoadStations(Db& db) {
    Query q(db, "SELECT id, public_key FROM stations WHERE tenant = ?1");
    while (q.Next()) {
      Bytes key = q.Blob(1);
      trace::PublicKey& into = stations_[q.Id(0)];
      // A key of another length stays zero, and then no signature fits: that is found at its
      // chunks.
      if (key.size() == into.size()) std::ranges::copy(key, into.begin());
    }
    return q.status();
  }

  void LoadTicketKey() {
    auto key = ReadTicketKey(options_.folder);
    if (key.ok()) {
      ticket_key_ = key->public_key;
    } else {
      report_.notes.push_back(
          "ticket.key is not here: tickets, results and the audit trail were not compared with it");
    }
  }

  Status CheckAttempts(Db& db) {
    Query count(db, "SELECT count(*), coalesce(sum(ticks), 0) FROM attempts WHERE tenant = ?1");
    uint64_t all = count.Next() ? static_cast<uint64_t>(count.Int(0)) : 0;
    ENAMEL_RETURN_IF_ERROR(count.status());
    Query q(db,
            "SELECT id, person, station, state, header, head_hash, head_state_hash, chunks, ticks, "
            "gap_ticks, trace_bytes, trace_blob, expired_ms, hand_kind, hand_device, hand_driver, "
            "hand_unit FROM attempts WHERE tenant = ?1");
    while (q.Next()) {
      AttemptFacts facts = FactsOf(q);
      ++report_.attempts;
      ENAMEL_RETURN_IF_ERROR(CheckAttempt(db, facts));
      Tell("attempts", report_.attempts, all);
    }
    return q.status();
  }

  Status CheckAttempt(Db& db, const AttemptFacts& facts) {
    if (!facts.has_header) return Status::Ok();
    CheckHeader(facts);
    // A retention rule has removed the recording; the header stays with the score.
    if (facts.expired) return Status::Ok();
    if (!facts.trace_blob.IsZero()) {
      ++report_.sealed;
      CheckSealed(facts);
      return Status::Ok();
    }
    // Only those two may still have their chunks as rows.
    if (facts.state != AttemptState::kRecording && facts.state != AttemptState::kQuarantined) {
      Find("seal", facts.id.Text(),
           "a trace, as the attempt is " + std::string(AttemptStateName(facts.state)), "none named",
           kFromBackup);
      return Status::Ok();
    }
    std::vector<Bytes> chunks;
    Query q(db, "SELECT bytes FROM trace_chunks WHERE tenant = ?1 AND attempt = ?2 ORDER BY seq");
    q.Bind(facts.id);
    while (q.Next()) chunks.push_back(q.Blob(0));
    ENAMEL_RETURN_IF_ERROR(q.status());
    if (OpenChunks(facts, chunks)) CheckChain(facts, chunks, std::nullopt);
    return Status::Ok();
  }

  void CheckHeader(const AttemptFacts& facts) {
    auto header = trace::DecodeHeader(facts.header);
    if (!header.ok()) {
      Find("ticket", facts.id.Text(), "a header with the server's ticket",
           header.status().message(), kAskStation);
      return;
    }
    const trace::Ticket& ticket = header->ticket;
    if (ticket.attempt != facts.id || ticket.person != facts.person ||
        ticket.station != facts.station) {
      Find("ticket", facts.id.Text(), "a ticket of this attempt, person and station",
           "one of attempt " + ticket.attempt.Text() + ", person " + ticket.person.Text() +
               ", station " + ticket.station.Text(),
           kFromBackup);
    }
    if (header->hand != facts.hand) {
      Find("hand", facts.id.Text(),
           "in the attempt's row the hand of its header, " + HandText(header->hand),
           HandText(facts.hand), kFromBackup);
    }
    if (ticket_key_ && !trace::VerifyTicket(ticket, *ticket_key_)) {
      Find("ticket", facts.id.Text(), "a ticket signed by this server", "another signature",
           "compare ticket.key with the one of a backup");
    }
  }

  bool OpenChunks(const AttemptFacts& facts, std::vector<Bytes>& chunks) {
    if (!has_keys_ &&
        std::ranges::any_of(chunks, [](const Bytes& c) { return PersonOfSealed(c).has_value(); })) {
      return false;  // noted: the keys are apart
    }
    for (Bytes& chunk : chunks) {
      auto opened = OpenPersonal(keyring_, std::move(chunk));
      if (!opened.ok()) {
        Find("key", facts.id.Text(), "chunks that the person's key opens",
             opened.status().message(), "restore the key ring");
        return false;
      }
      chunk = std::move(opened).value();
    }
    return true;
  }

  void CheckSealed(const AttemptFacts& facts) {
    if (bad_blobs_.contains(facts.trace_blob)) return;  // found already
    auto bytes = blobs_.Get(facts.trace_blob);
    if (!bytes.ok()) return;
    // Kept apart, and noted so: what cannot be opened cannot be checked.
    if (!has_keys_ && PersonOfSealed(*bytes)) return;
    auto opened = OpenPersonal(keyring_, std::move(bytes).value());
    if (!opened.ok()) return;
    auto file = trace::DecodeTraceFile(*opened);
    if (!file.ok() || file->truncated || !file->seal) {
      Find("seal", facts.id.Text(), "a whole trace with its seal",
           file.ok() ? "one that ends early" : file.status().message(), kAskStation);
      return;
    }
    if (file->header != facts.header) {
      Find("chain", facts.id.Text(), "the header of the attempt's row at the head of its trace",
           "another one", kFromBackup);
    }
    CheckChain(facts, file->chunks, file->seal);
  }

  void CheckChain(const AttemptFacts& facts, const std::vector<Bytes>& chunks,
                  const std::optional<trace::Seal>& seal) {
    trace::ChainVerifier chain(facts.id, HashSha256(facts.header));
    const std::string id = facts.id.Text();
    uint64_t bytes = facts.header.size(), gaps = 0, unsigned_chunks = 0, first_unsigned = 0;
    for (const Bytes& encoded : chunks) {
      auto chunk = trace::DecodeChunk(encoded);
      if (!chunk.ok())
        return Find("chain", id, "chunk " + std::to_string(chain.next_seq()) + " to be whole",
                    chunk.status().message(), kAskStation);
      if (Status linked = chain.Accept(*chunk); !linked.ok())
        return Find("chain", id, "each chunk to continue the one before", linked.message(),
                    kAskStation);
      if (!IsSigned(facts, encoded) && unsigned_chunks++ == 0) first_unsigned = chunk->head.seq;
      bytes += encoded.size();
      gaps += chunk->head.gap_ticks;
      ++report_.chunks;
      report_.ticks += chunk->head.count;
    }
    if (unsigned_chunks > 0) FindUnsigned(facts, unsigned_chunks, first_unsigned, chunks.size());
    if (chain.next_seq() != facts.chunks || chain.next_tick() != facts.ticks ||
        chain.head() != facts.head || chain.state_hash() != facts.head_state_hash) {
      Find("chain", id, RowText(facts),
           "the chunks say " + std::to_string(chain.next_seq()) + " chunks, " +
               std::to_string(chain.next_tick()) + " ticks, head " + chain.head().Hex(),
           kAskStation);
    }
    // The counts are beside the chain and prove nothing; a difference still says that a row was
    // changed by hand.
    if (bytes != facts.trace_bytes || gaps != facts.gap_ticks) {
      Find("chain", id,
           std::to_string(facts.trace_bytes) + " bytes and " + std::to_string(facts.gap_ticks) +
               " ticks of gaps, as the row says",
           std::to_string(bytes) + " and " + std::to_string(gaps), kFromBackup);
    }
    if (!seal) return;
    if (Status sealed = chain.AcceptSeal(*seal); !sealed.ok())
      Find("seal", id, "a seal that fits the chunks", sealed.message(), kFromBackup);
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
    Find("signature", facts.id.Text(), which + " signed by station " + facts.station.Text(),
         stations_.contains(facts.station) ? "another signature" : "no such station", kAskStation);
  }

  const VerifyOptions& options_;
  FolderBlobs blobs_;
  FolderKeyring keyring_;
  VerifyReport report_;
  bool has_keys_ = false;
  std::set<Sha256> in_manifest_, bad_blobs_;
  std::vector<AuditHead> earlier_;
  std::map<Uuid, trace::PublicKey> stations_;
  std::optional<trace::PublicKey> ticket_key_;
};

// Removing takes several steps, between which things disagree that will agree again.
Result<FolderLock> WaitUntilNothingIsRemoved(const fs::path& folder) {
  constexpr auto kPatience = std::chrono::seconds(30);
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  for (;;) {
    auto lock = TakeUpkeepLock(folder, FolderLock::Mode::kShared);
    bool later = !lock.ok() && lock.status().code() == Code::kUnavailable;
    if (!later || std::chrono::steady_clock::now() > deadline) return lock;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

}  // namespace

Result<VerifyReport> Verify(const VerifyOptions& options) {
  // At first without waiting for anybody, as nearly always nothing is found.
  auto report = Verifier(options).Run();
  if (!report.ok() || report->is_backup || report->findings.empty()) return report;
  auto quiet = WaitUntilNothingIsRemoved(options.folder);
  if (quiet.ok()) return Verifier(options).Run();
  if (quiet.status().code() == Code::kUnavailable) {
    report->notes.push_back(
        "recordings are being removed from this folder just now; what was found may be part of "
        "that: run this again when it is done");
  }
  return report;
}

}  // namespace enamel::server
