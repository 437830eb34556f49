#include "server/storage/upkeep/store_health.h"

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "server/storage/engine/query.h"

namespace enamel::server {

void StoreHealthCheck::AddSizes(StoreHealth& out) {
  std::error_code error;
  auto size = [&](const char* name) -> uint64_t {
    uintmax_t bytes = std::filesystem::file_size(parts_.folder / name, error);
    return error ? 0 : bytes;
  };
  out.free_bytes = parts_.space.FreeBytes();
  out.min_free_bytes = parts_.space.min_free_bytes();
  out.database_bytes = size("enamel.db");
  out.log_bytes = size("enamel.db-wal");
}

void StoreHealthCheck::AddCommits(StoreHealth& out) {
  const Writer& writer = parts_.rows.writer();
  const Writer::Counters counters = writer.counters();
  out.commits = counters.commits;
  out.writes = counters.works;
  out.failed_commits = counters.failed_commits;
  out.commit_s = counters.commit_s;
  std::vector<double> took = writer.newest_commits_s();
  out.timed_commits = took.size();
  if (took.empty()) return;
  // The smallest that at least 99 % are not above.
  const auto place = static_cast<std::ptrdiff_t>((took.size() * 99 + 99) / 100 - 1);
  std::ranges::nth_element(took, took.begin() + place);
  out.commit_p99_s = took[static_cast<size_t>(place)];
}

void StoreHealthCheck::AddClock(StoreHealth& out) {
  out.standby = parts_.look.standby();
  out.clock_ahead_ms = parts_.look.clock_ahead_ms();
  if (std::abs(out.clock_ahead_ms) <= kMostClockOffMs) return;
  out.clock_problem = "this machine's clock is " +
                      std::to_string(std::abs(out.clock_ahead_ms) / 1000) + " s " +
                      (out.clock_ahead_ms > 0 ? "ahead of" : "behind") +
                      " the database server's; see that both machines set theirs from the same "
                      "time servers";
}

std::string StoreHealthCheck::Problem() {
  if (Status able = parts_.gate.Check(); !able.ok()) return able.message();
  if (parts_.rows.writer().last_failure().ok()) return "";
  return "the last change could not be written to the database; the server's log says why. "
         "Recordings wait at the stations, the next write that succeeds ends this";
}

std::string StoreHealthCheck::Waiting() {
  if (parts_.rewriter.running() || parts_.rows.writer().waits()) {
    return "a person was erased and the database is being rewritten; changes and recordings wait "
           "until that is done";
  }
  if (parts_.look.standby() == sql::Standby::kMissing) {
    return "the database server waits for a synchronous standby, and none is connected; every "
           "change and recording waits until one is";
  }
  // What arrives is kept in rows meanwhile.
  if (!parts_.blobs.Problem().ok()) {
    return "the store of blobs cannot be written or read; the server's log says why. Until it can, "
           "finished recordings wait at the stations, and scores at the server";
  }
  if (!parts_.keyring.Problem().ok()) {
    return "the store of keys cannot be written or read; the server's log says why. Until it can, "
           "recordings of people whose key is not in memory wait at the stations, and nobody can "
           "be erased";
  }
  return "";
}

StoreHealth StoreHealthCheck::Health() {
  StoreHealth out;
  AddSizes(out);
  AddCommits(out);
  AddClock(out);
  out.chunks = parts_.counters.chunks;
  out.chunk_bytes = parts_.counters.chunk_bytes;
  out.sealed = parts_.counters.sealed;
  out.problem = Problem();
  out.takes_recordings = out.problem.empty();
  out.waiting = Waiting();
  return out;
}

Status StoreHealthCheck::TryWrite() {
  // Only after a failure, to find out whether its cause has ended: otherwise ordinary writes show
  // it.
  const Writer& writer = parts_.rows.writer();
  if (writer.last_failure().ok() || writer.damaged()) return Status::Ok();
  return parts_.rows.Write([](Db& db) -> Status {
    Query q(db,
            "INSERT INTO write_probe (tenant, at_ms) VALUES (?1, ?2) ON CONFLICT (tenant) DO "
            "UPDATE SET at_ms = ?2");
    return q.Bind(NowMs()).Run();
  });
}

}  // namespace enamel::server
