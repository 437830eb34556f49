#include "server/app/work.h"

#include <spdlog/spdlog.h>

#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <exception>
#include <functional>
#include <iostream>
#include <map>
#include <memory>

#include "server/app/data_folder.h"
#include "server/app/school_folder.h"
#include "server/app/stop_signals.h"
#include "server/app/store_watch.h"
#include "server/storage/attempts/job_rows.h"
#include "server/storage/folder/store_options.h"
#include "server/storage/folder/ticket_key.h"
#include "server/storage/open_store.h"
#include "server/storage/people/school_list.h"
#include "server/storage/store.h"

namespace enamel::server::app {

WorkerOptions LoggedJobs(const trace::KeyPair& key, int threads) {
  WorkerOptions out;
  out.key = key;
  out.threads = threads;
  out.timelines = true;
  out.on_done = [](const JobRow& job, const Status& status) {
    if (job.kind.empty()) {
      spdlog::warn("jobs: {}", status.message());
    } else if (status.ok()) {
      spdlog::info("job {} of attempt {} done", job.kind, job.attempt.Text());
    } else {
      spdlog::warn("job {} of attempt {}: {}", job.kind, job.attempt.Text(), status.message());
    }
  };
  return out;
}

namespace {

constexpr std::chrono::seconds kLookAtSchools{2};

// Scores one school's attempts, from its beginning to its end.
struct AtWork {
  AtWork(std::unique_ptr<Store> its, const trace::KeyPair& key, int threads)
      : store(std::move(its)), worker(*store, LoggedJobs(key, threads)) {
    worker.Start();
  }
  static Result<std::unique_ptr<AtWork>> Open(const std::filesystem::path& folder, int threads) {
    StoreOptions options;
    options.folder = folder;
    ENAMEL_ASSIGN_OR_RETURN(auto store, OpenStore(options));
    ENAMEL_ASSIGN_OR_RETURN(const auto key, ReadTicketKey(folder));
    return std::make_unique<AtWork>(std::move(store), key, threads);
  }

  const std::unique_ptr<Store> store;
  Worker worker;
};

// The installation's other schools. On one thread.
class OthersAtWork {
 public:
  OthersAtWork(const WorkOptions& options, SchoolRows& list) : options_(options), list_(list) {}

  void Look() {
    const auto rows = list_.Schools();
    if (!rows.ok()) return;  // in the log
    std::map<Uuid, std::unique_ptr<AtWork>> now;
    for (const SchoolRow& row : *rows) {
      if (row.state != SchoolState::kServed) continue;
      auto& at_work = now[row.id] = std::move(all_[row.id]);
      if (!at_work) at_work = Begin(row);
    }
    all_ = std::move(now);
  }
  void StopWaiting() {
    for (const auto& [id, one] : all_) {
      if (one) one->store->StopWaiting();
    }
  }

 private:
  std::unique_ptr<AtWork> Begin(const SchoolRow& row) {
    auto begun = TryToBegin(row);
    if (begun.ok()) {
      problems_.erase(row.id);
      return std::move(*begun);
    }
    std::string& told = problems_[row.id];
    if (told != begun.status().message()) {
      spdlog::error("school {} cannot be worked for: {}", row.name, begun.status().message());
    }
    told = begun.status().message();
    return nullptr;
  }
  Result<std::unique_ptr<AtWork>> TryToBegin(const SchoolRow& row) const {
    // Such as no more threads: that is one school's trouble.
    try {
      ENAMEL_ASSIGN_OR_RETURN(auto its, OpenSchool(options_.data, row, StoreOptions{}));
      return std::make_unique<AtWork>(std::move(its.store), its.identity.ticket_key,
                                      options_.threads);
    } catch (const std::exception& error) {
      return Status(Code::kUnavailable, error.what());
    }
  }

  const WorkOptions& options_;
  SchoolRows& list_;
  std::map<Uuid, std::unique_ptr<AtWork>> all_;
  std::map<Uuid, std::string> problems_;  // told
};

}  // namespace

Status Work(const WorkOptions& options) {
  boost::asio::io_context io;
  StopSignals signals(io);
  if (!options.identity.empty()) {
    ENAMEL_RETURN_IF_ERROR(TakeIdentity(options.data, options.identity));
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto own, AtWork::Open(options.data, options.threads));
  Store& store = *own->store;
  StoreWatch watch(store);
  OthersAtWork others(options, store.schools);
  boost::asio::steady_timer next_look(io);
  std::function<void()> look = [&] {
    others.Look();
    next_look.expires_after(kLookAtSchools);
    next_look.async_wait([&](const boost::system::error_code& error) {
      if (!error) look();
    });
  };
  look();
  signals.OnFirst([&] {
    signals.EndSoon();
    store.StopWaiting();
    others.StopWaiting();
    next_look.cancel();
  });
  std::cout << "ready: " << options.threads << (options.threads == 1 ? " worker" : " workers")
            << std::endl;
  io.run();  // until the signal
  signals.OnlyJobsRemain();
  own->worker.Stop();
  spdlog::info("stopped");
  return Status::Ok();
}

}  // namespace enamel::server::app
