// Cost of a signed row of the audit trail: its hash and signature, the state in it, the whole row,
// and checking it in `verify`.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include "server/storage/audit/actor.h"
#include "server/storage/audit/audit_row.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/audit/decisions.h"
#include "server/storage/engine/database.h"
#include "server/storage/folder/ticket_key.h"
#include "server/storage/open_store.h"
#include "server/storage/store.h"
#include "server/storage/verify/verify_audit.h"

namespace {

using namespace enamel;
using namespace enamel::server;

const Actor kBench{{}, "bench"};
// About the size of an attempt's state.
const std::string kState(600, 's');

AuditSeal Seal(const AuditSalt& salt) {
  return {Uuid::New(),
          1'793'880'000'123,
          Uuid::New(),
          "page",
          "attempt.override",
          Uuid::New().Text(),
          SubjectOf("attempt", Uuid::New().Text()),
          AuditContentHash(salt, "{}", R"({"score":"70","reason":"too deep"})", kState),
          AuditLink{{}, 1000, HashSha256(AsBytes("the row before"))}};
}

void BM_SaltHashAndSign(benchmark::State& state) {
  const trace::KeyPair keys = trace::NewKeyPair();
  for (auto _ : state) {
    benchmark::DoNotOptimize(SignAuditSeal(Seal(NewAuditSalt()), keys.secret_key));
  }
}
BENCHMARK(BM_SaltHashAndSign)->Unit(benchmark::kMicrosecond);

// The end of the chain, which is signed with each row.
void BM_SignEnd(benchmark::State& state) {
  const trace::KeyPair keys = trace::NewKeyPair();
  AuditHead head{{}, 1000, Uuid::New(), HashSha256(AsBytes("the last row"))};
  for (auto _ : state) benchmark::DoNotOptimize(SignAuditHead(head, keys.secret_key));
}
BENCHMARK(BM_SignEnd)->Unit(benchmark::kMicrosecond);

void BM_VerifySignature(benchmark::State& state) {
  const trace::KeyPair keys = trace::NewKeyPair();
  const AuditSeal seal = Seal(NewAuditSalt());
  const trace::Signature signature = SignAuditSeal(seal, keys.secret_key);
  for (auto _ : state) benchmark::DoNotOptimize(VerifyAuditSeal(seal, signature, keys.public_key));
}
BENCHMARK(BM_VerifySignature)->Unit(benchmark::kMicrosecond);

// A separate store with one listed device, the subject of each row.
class Folder {
 public:
  Folder() {
    char name[] = "/tmp/enamel-audit-bench-XXXXXX";
    if (mkdtemp(name) == nullptr) std::abort();
    path_ = name;
    auto opened = OpenSqliteStore({path_});
    if (!opened.ok() || !opened.value()->devices.ListDevice("device", "chair", kBench).ok())
      std::abort();
    store_ = std::move(opened).value();
  }
  ~Folder() {
    store_.reset();
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  // A connection for the bench's own statements.
  std::unique_ptr<SqliteDb> Connect() const {
    auto db = OpenDatabase(path_ / "enamel.db", DbMode::kExisting);
    if (!db.ok()) std::abort();
    return std::move(db).value();
  }
  trace::KeyPair Key() const {
    auto key = ReadTicketKey(path_);
    if (!key.ok()) std::abort();
    return *key;
  }

 private:
  std::filesystem::path path_;
  std::unique_ptr<Store> store_;
};

void BM_State(benchmark::State& state) {
  const Folder folder;
  auto db = folder.Connect();
  for (auto _ : state) benchmark::DoNotOptimize(StateOf(*db, "device device"));
}
BENCHMARK(BM_State)->Unit(benchmark::kMicrosecond);

// Within one transaction, so without the commit: argument 0, a row without a subject; 1, about a
// device, with its state.
void BM_WriteRow(benchmark::State& state) {
  const Folder folder;
  auto db = folder.Connect();
  const AuditSigner signer(folder.Key().secret_key);
  db->SetCompanion(&signer);
  const char* action = state.range(0) == 0 ? "store.backup" : "device.list";
  if (!db->Begin(sql::Isolation::kSerial).ok()) std::abort();
  for (auto _ : state) {
    if (!WriteAudit(*db, kBench, action, "device", "{}", "{}").ok()) std::abort();
  }
  db->Rollback();
}
BENCHMARK(BM_WriteRow)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);

// A trail of that many rows, as `verify` reads it.
void BM_VerifyTrail(benchmark::State& state) {
  const Folder folder;
  auto db = folder.Connect();
  const trace::KeyPair keys = folder.Key();
  const AuditSigner signer(keys.secret_key);
  db->SetCompanion(&signer);
  if (!db->Begin(sql::Isolation::kSerial).ok()) std::abort();
  for (int64_t i = 0; i < state.range(0); ++i) {
    if (!WriteAudit(*db, kBench, "device.list", "device", "{}", "{}").ok()) std::abort();
  }
  for (auto _ : state) {
    VerifyReport report;
    if (!CheckAudit(*db, keys.public_key, {}, report, {}).ok()) std::abort();
    if (!report.findings.empty()) std::abort();
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
  db->Rollback();
}
BENCHMARK(BM_VerifyTrail)->Arg(1000)->Unit(benchmark::kMillisecond);

}  // namespace
