#include "server/app/school.h"

#include <utility>
#include <vector>

#include "common/base/unix_time.h"
#include "common/protocol/release.h"
#include "server/app/work.h"

namespace enamel::server::app {
namespace {

// Of the stores of blobs and keys, where these are buckets.
void AddS3Figures(const StoreHealth& health, ops::MetricsText& text) {
  std::vector<std::pair<const char*, const s3::S3Figures*>> stores;
  if (health.blob_store) stores.emplace_back("blobs", &*health.blob_store);
  if (health.key_store) stores.emplace_back("keys", &*health.key_store);
  for (const auto& [of, figures] : stores) {
    text.Counter("enamel_s3_requests_total", "Requests sent to a store, every try.",
                 static_cast<double>(figures->requests), {{"of", of}});
  }
  for (const auto& [of, figures] : stores) {
    text.Counter("enamel_s3_failed_calls_total", "Calls that failed after all their tries.",
                 static_cast<double>(figures->failed), {{"of", of}});
  }
  for (const auto& [of, figures] : stores) {
    text.Durations("enamel_s3_call_seconds", "Calls, with all their tries and pauses.",
                   figures->calls, {{"of", of}});
  }
  for (const auto& [of, figures] : stores) {
    text.Gauge("enamel_s3_oldest_wait_seconds", "How long the oldest call has waited.",
               figures->oldest_wait_s, {{"of", of}});
  }
}

// What the store knows, as figures.
void AddStoreFigures(StoreHealthCheck& health_rows, ops::MetricsText& text) {
  // Once for all figures: those of one answer then belong to one moment.
  StoreHealth health = health_rows.Health();
  auto number = [](auto value) { return static_cast<double>(value); };
  text.Gauge("enamel_takes_recordings", "1 while recordings are taken.",
             health.takes_recordings ? 1 : 0);
  text.Gauge("enamel_clock_ahead_seconds",
             "How far this machine's clock is ahead of the database's.",
             number(health.clock_ahead_ms) / 1000);
  if (health.standby != sql::Standby::kNotKept && health.standby != sql::Standby::kUnknown) {
    text.Gauge("enamel_database_synchronous_standby",
               "1 while commits are on a standby of the database server too.",
               health.standby == sql::Standby::kSynchronous ? 1 : 0);
    text.Gauge("enamel_database_standby_missing",
               "1 while every change waits because no standby is connected.",
               health.standby == sql::Standby::kMissing ? 1 : 0);
  }
  text.Gauge("enamel_disk_free_bytes", "Free where the data folder is.", number(health.free_bytes));
  text.Gauge("enamel_disk_kept_free_bytes", "Below this no recordings are taken.",
             number(health.min_free_bytes));
  text.Gauge("enamel_database_bytes", "Size of the database.", number(health.database_bytes));
  text.Gauge("enamel_database_log_bytes", "Size of its log.", number(health.log_bytes));
  text.Counter("enamel_store_commits_total", "Transactions written, each with one sync.",
               number(health.commits));
  text.Counter("enamel_store_failed_commits_total", "Transactions that could not be written.",
               number(health.failed_commits));
  text.Durations("enamel_store_commit_seconds", "Transactions written, from begin to commit.",
                 health.commits_took);
  text.Counter("enamel_store_writes_total", "Changes in those transactions.",
               number(health.writes));
  text.Counter("enamel_chunks_committed_total", "Chunks of recordings committed.",
               number(health.chunks));
  text.Counter("enamel_chunk_bytes_committed_total", "Bytes of those chunks.",
               number(health.chunk_bytes));
  text.Counter("enamel_attempts_sealed_total", "Attempts sealed.", number(health.sealed));
  text.Gauge("enamel_store_queued", "Changes that wait to be written.", number(health.queued));
  text.Gauge("enamel_store_oldest_wait_seconds", "How long the oldest change has waited.",
             health.oldest_wait_s);
  AddS3Figures(health, text);
}

// As counted last: asking for them would wait for the database.
void AddCountedFigures(const Caretaker& caretaker, ops::MetricsText& text) {
  for (size_t i = 0; i < Caretaker::kJobStates.size(); ++i) {
    if (const auto count = caretaker.jobs(i)) {
      text.Gauge("enamel_jobs", "Scoring jobs by state, counted up to 200.",
                 static_cast<double>(*count), {{"state", Caretaker::kJobStates[i]}});
    }
  }
  if (const int64_t at_ms = caretaker.newest_backup_ms(); at_ms != 0) {
    text.Gauge("enamel_backup_made_seconds", "When the newest backup was made, Unix time.",
               static_cast<double>(at_ms) / 1000);
  }
}

}  // namespace

School::School(std::unique_ptr<Store> store, const ServerIdentity& identity,
               const SchoolOptions& options)
    : store_(std::move(store)),
      authenticator_(*store_, options.auth),
      live_(options.budgets),
      content_(*store_),
      services_{*store_,
                authenticator_,
                live_,
                content_,
                identity.ticket_key,
                SoftwareName(),
                std::string(protocol::ThisRelease()),
                [] { return enamel::UnixMs(); }},
      worker_(*store_, LoggedJobs(identity.ticket_key, options.job_threads)) {
  services_.board = &stations_;
  metrics_.Add([](ops::MetricsText& text) { ops::AddBuild(text, SoftwareName()); });
  metrics_.Add(ops::AddProcess);
  metrics_.Add([this](ops::MetricsText& text) { AddStoreFigures(store_->health, text); });
  metrics_.Add([this](ops::MetricsText& text) {
    text.Gauge("enamel_stations_connected", "Stations that are connected to this server.",
               static_cast<double>(stations_.Here().size()));
    services_.arrivals.AddFigures(text, services_.clock());
  });
}

void School::Start() {
  worker_.Start();
  caretaker_.emplace(*store_);
  metrics_.Add([this](ops::MetricsText& text) { AddCountedFigures(*caretaker_, text); });
  keeper_.emplace(stations_, *store_, store_->shared);
  if (store_->shared) follower_.emplace(live_, *store_);
}

void School::End() {
  ended_ = true;
  store_->StopWaiting();
  worker_.Stop();
}

}  // namespace enamel::server::app
