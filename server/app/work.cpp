#include "server/app/work.h"

#include <spdlog/spdlog.h>

#include <iostream>

#include "server/app/command_line.h"
#include "server/app/data_folder.h"
#include "server/app/stop_signals.h"
#include "server/storage/engine/ticket_key.h"
#include "server/storage/sqlite_store.h"

namespace enamel::server::app {

WorkerOptions LoggedJobs(const trace::KeyPair& key, int threads) {
  WorkerOptions out;
  out.key = key;
  out.threads = threads;
  out.on_done = [](const JobRow& job, const Status& status) {
    if (status.ok()) {
      spdlog::info("job {} of attempt {} done", job.kind, job.attempt.Text());
    } else {
      spdlog::warn("job {} of attempt {}: {}", job.kind, job.attempt.Text(), status.message());
    }
  };
  return out;
}

Status Work(const WorkOptions& options) {
  boost::asio::io_context io;
  StopSignals signals(io);
  if (!options.identity.empty()) {
    ENAMEL_RETURN_IF_ERROR(TakeIdentity(options.data, options.identity));
  }
  SqliteOptions store_options;
  store_options.folder = options.data;
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenStore(store_options));
  ENAMEL_ASSIGN_OR_RETURN(const auto key, ReadTicketKey(options.data));
  WorkerOptions jobs = LoggedJobs(key, options.threads);
  jobs.timelines.emplace(*store);
  Worker worker(*store, jobs);
  worker.Start();
  signals.OnFirst([&] { store->StopWaiting(); });
  std::cout << "ready: " << options.threads << (options.threads == 1 ? " worker" : " workers")
            << std::endl;
  io.run();  // until the signal
  worker.Stop();
  spdlog::info("stopped");
  return Status::Ok();
}

void DeclareWork(CommandGroup root) {
  auto [cmd, o] = Declare<WorkOptions>(
      root, "work", "Score attempts beside a server, on this machine or another, until Ctrl-C",
      Work);
  AddData(cmd, o.data);
  AddIdentity(cmd, o.identity);
  cmd->add_option("--threads", o.threads, "Attempts scored at once")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  cmd->footer(
      "A class that hands in at the same time is scored sooner the more of these run. Each job is\n"
      "done by one of them. Start as many as there are processors to spare; stop them whenever "
      "you\n"
      "like: what one was at goes back to the queue, and is taken by another within half a minute\n"
      "when it was killed.\n\n"
      "  enamel-server work --data /srv/enamel --threads 4");
}

}  // namespace enamel::server::app
