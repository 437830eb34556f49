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
  out.commits_took = writer.commits_took();
  out.queued = writer.queued();
  out.oldest_wait_s = std::chrono::duration<double>(writer.oldest_wait()).count();
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
  const int64_t median_ms = parts_.look.median_ahead_ms();
  const auto off = [](int64_t ms) {
    return std::to_string(std::abs(ms) / 1000) + " s " + (ms > 0 ? "ahead of " : "behind ");
  };
  const int64_t own_ms = out.clock_ahead_ms - median_ms;
  out.clock_is_off = std::abs(own_ms) > DatabaseLook::kMaxClockOffMs &&
                     parts_.look.clock_votes() >= DatabaseLook::kFewestVotes;
  if (std::abs(own_ms) > DatabaseLook::kMaxClockOffMs) {
    out.clock_problem = "this machine's clock is " + off(own_ms) +
                        (median_ms == 0 ? "the database server's" : "most servers'") +
                        "; see that all machines set theirs from the same time servers";
  } else if (median_ms != 0) {
    out.clock_problem = "the database server's clock is " + off(-median_ms) +
                        "the servers', whose time counts meanwhile; see that all machines set "
                        "theirs from the same time servers";
  }
}

std::string StoreHealthCheck::Problem(bool& database) {
  if (Status able = parts_.gate.Check(); !able.ok()) return able.message();
  if (parts_.look.forked()) {
    return "the database lacks what this server has committed: a second primary answers, or it was "
           "set back. Stop all servers, decide which database counts, and start them again. "
           "Recordings wait at the stations";
  }
  database = true;
  if (parts_.look.replaced()) {
    return "the database server that answers is an earlier primary, which another has replaced; "
           "stop it, and check the addresses in database.json. Recordings wait at the stations";
  }
  if (parts_.look.hangs()) {
    if (const std::string why = parts_.look.to_mend(); !why.empty()) {
      return why + ". Recordings wait at the stations";
    }
    return "the database server does not answer; check that PostgreSQL runs and that this machine "
           "reaches it. Recordings wait at the stations";
  }
  if (parts_.rows.writer().oldest_wait() > kLongestWait && Waiting().empty()) {
    return "a change has waited for the database for seconds; check the disk that it is on. "
           "Recordings wait at the stations";
  }
  database = !parts_.rows.writer().last_failure().ok();
  if (!database) return "";
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
  // The heartbeat's row needs no standby.
  if (parts_.look.standby() == sql::Standby::kSynchronous && !parts_.look.hangs() &&
      parts_.rows.writer().oldest_wait() > kLongestWait) {
    return "the database server answers, and its synchronous standby does not confirm changes; "
           "check the standby. Every change and recording waits until it does";
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
  out.blob_store = parts_.blobs.Figures();
  out.key_store = parts_.keyring.Figures();
  out.problem = Problem(out.database_fails);
  out.takes_recordings = out.problem.empty();
  out.waiting = Waiting();
  out.writes_fail = !parts_.rows.writer().last_failure().ok();
  out.blobs_fail = !parts_.blobs.Problem().ok();
  out.keys_fail = !parts_.keyring.Problem().ok();
  return out;
}

Status StoreHealthCheck::TryWrite() {
  // Only after a failure, to find out whether its cause has ended: otherwise ordinary writes show
  // it.
  const Writer& writer = parts_.rows.writer();
  if (writer.last_failure().ok() || writer.damaged()) return Status::Ok();
  return parts_.rows.Write([](Db& db) -> Status {
    return Insert(db, "write_probe", "server", Uuid{}, "at_ms", 0, "ahead_ms", 0, "beats", 0,
                  "host", "", "port", 0,
                  " ON CONFLICT (tenant, server) DO UPDATE SET beats = write_probe.beats + 1");
  });
}

}  // namespace enamel::server
