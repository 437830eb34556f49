#include "tests/load/load.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <random>
#include <thread>

#include "server/app/data_folder.h"
#include "tests/load/api_reader.h"
#include "tests/load/engine.h"
#include "tests/load/stations/motion.h"
#include "tests/load/viewers.h"

namespace enamel::load {
namespace {

constexpr size_t kSetupAtOnce = 12;  // the server lets 16 sign-ins wait
constexpr size_t kOpenAtOnce = 64;
constexpr double kSetupWithin_s = 1800;
constexpr double kDrain_s = 60;
constexpr double kSay_s = 5;
constexpr size_t kSpareDescriptors = 512;

template <typename... Args>
std::string Text(const char* format, Args... args) {
  char buffer[256];
  std::snprintf(buffer, sizeof buffer, format, args...);
  return buffer;
}

Status AllowDescriptors(size_t connections) {
  rlimit limit{};
  ::getrlimit(RLIMIT_NOFILE, &limit);
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
  if (limit.rlim_cur >= connections + kSpareDescriptors) return Status::Ok();
  return Status(Code::kUnavailable, "expected to be allowed " +
                                        std::to_string(connections + kSpareDescriptors) +
                                        " open files, found " + std::to_string(limit.rlim_cur) +
                                        "; raise the limit (ulimit -Hn) or ask for fewer stations");
}

double LoadAverage() {
  double average[1] = {0};
  ::getloadavg(average, 1);
  return average[0];
}

double OwnCpuS() { return UseOf({::getpid()}).cpu_s; }

// A folder that is deleted with its owner.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "enamel-load-XXXXXX").string();
    if (::mkdtemp(pattern.data()) != nullptr) path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// Server CPU over restarts of the process.
class ServerCpu {
 public:
  void Add(double cpu_s) { ended_s_ += cpu_s; }
  double Now(const std::vector<pid_t>& pids) const { return ended_s_ + UseOf(pids).cpu_s; }

 private:
  double ended_s_ = 0;
};

class Run {
 public:
  Run(const LoadOptions& options, const std::function<void(const std::string&)>& say)
      : o_(options), say_(say) {}

  Result<LoadReport> All() {
    ENAMEL_RETURN_IF_ERROR(AllowDescriptors(o_.stations + o_.idle + o_.hostile + o_.viewers));
    ENAMEL_RETURN_IF_ERROR(StartServer());
    ENAMEL_RETURN_IF_ERROR(AddStations());
    ENAMEL_RETURN_IF_ERROR(Prepare());
    ENAMEL_RETURN_IF_ERROR(
        Toward({Goal::kOpen, PerEngine(kOpenAtOnce), NowS() + kSetupWithin_s}, "open"));
    if (o_.stations > 0) {
      ENAMEL_RETURN_IF_ERROR(Stream());
    } else {
      StayIdle();
    }
    Account();
    if (o_.stations > 0) ENAMEL_RETURN_IF_ERROR(SealAndReadBack());
    if (server_) server_->Stop();
    return std::move(report_);
  }

 private:
  std::vector<pid_t> Pids() const { return server_ ? std::vector{server_->pid()} : o_.server_pids; }
  size_t PerEngine(size_t n) const { return std::max<size_t>(1, n / engines_.size()); }

  Status StartServer() {
    data_ = o_.data.empty() ? own_folder_.path() : o_.data;
    ENAMEL_ASSIGN_OR_RETURN(auto school, FoundSchool(data_, o_.stations + o_.idle));
    school_ = std::move(school);
    if (o_.marking) ENAMEL_RETURN_IF_ERROR(marking_.Prepare(data_, *o_.marking, say_));
    if (o_.server) {
      ENAMEL_ASSIGN_OR_RETURN(auto identity, server::app::EnsureIdentity(data_));
      stations_ = *o_.server;
      page_ = o_.page.value_or(net::Endpoint{});
      fingerprint_ = identity.fingerprint;
    } else {
      server_.emplace(o_.server_program, data_, data_ / "server.log",
                      std::vector<std::string>{"--job-threads", std::to_string(o_.job_threads)});
      ENAMEL_RETURN_IF_ERROR(server_->Start());
      stations_ = server_->stations();
      page_ = server_->page();
      fingerprint_ = server_->fingerprint();
      say_("server " + stations_.Text() + " with data in " + data_.string());
    }
    ENAMEL_ASSIGN_OR_RETURN(auto target, TargetOf(stations_, fingerprint_));
    target_ = std::move(target);
    return Status::Ok();
  }

  Status AddStations() {
    for (int i = 0; i < o_.threads; ++i) engines_.push_back(std::make_unique<Engine>(target_));
    for (size_t i = 0; i < o_.stations + o_.idle; ++i) {
      StationPlan plan;
      plan.school = &school_;
      plan.code = school_.codes[i];
      plan.name = "load " + std::to_string(i);
      plan.ticketed = i < o_.stations;
      plan.chunk_ticks = o_.chunk_ticks;
      plan.disturbances = o_.disturbances;
      Station& station = engines_[i % engines_.size()]->Add(std::move(plan));
      if (i < o_.stations) streaming_.push_back(&station);
    }
    return Toward({Goal::kTicket, PerEngine(kSetupAtOnce), NowS() + kSetupWithin_s},
                  "enrolled, signed in and ticketed");
  }

  // Runs all engines, each on its own thread, and reports progress.
  Status Toward(const Engine::Phase& phase, const std::string& what) {
    std::atomic<size_t> running{engines_.size()};
    std::vector<std::jthread> threads;
    for (auto& engine : engines_) {
      threads.emplace_back([&, e = engine.get()] {
        e->Run(phase);
        --running;
      });
    }
    double said_s = NowS();
    while (running > 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      if (NowS() - said_s < kSay_s) continue;
      said_s = NowS();
      say_(Text("  %zu of %zu %s", Reached(), o_.stations + o_.idle, what.c_str()));
    }
    threads.clear();
    for (const auto& engine : engines_) {
      if (std::string problem = engine->Problem(); !problem.empty()) {
        return Status(Code::kUnavailable,
                      "a station gave up before it was " + what + ": " + problem);
      }
    }
    if (Reached() == o_.stations + o_.idle) return Status::Ok();
    return Status(Code::kUnavailable, "not all stations were " + what + " in time");
  }

  size_t Reached() const {
    size_t out = 0;
    for (const auto& engine : engines_) out += engine->progress().reached;
    return out;
  }

  Status Prepare() {
    if (o_.stations == 0) return Status::Ok();
    ENAMEL_ASSIGN_OR_RETURN(auto motion,
                            o_.motion.empty() ? SimulatedMotion(60'000) : ReadMotion(o_.motion));
    double chunk_s = static_cast<double>(o_.chunk_ticks) / school_.params.rate_hz;
    auto chunks = static_cast<uint32_t>(std::max(1.0, std::floor(o_.seconds / chunk_s)));
    auto different = static_cast<size_t>(
        std::clamp(std::ceil(o_.loop_seconds / chunk_s), 1.0, static_cast<double>(chunks)));
    say_(Text("preparing %zu streams of %u chunks, %zu of them with a content of their own",
              o_.stations, chunks, different));
    std::atomic<size_t> next{0};
    double said_s = NowS();
    std::vector<std::jthread> workers;
    for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i) {
      workers.emplace_back([&] {
        for (size_t s; (s = next++) < streaming_.size();) {
          streaming_[s]->Prepare(StreamOf(motion, s, o_.chunk_ticks, different), chunks);
        }
      });
    }
    while (next < streaming_.size()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      if (NowS() - said_s < kSay_s) continue;
      said_s = NowS();
      say_(Text("  %zu of %zu prepared", std::min(next.load(), o_.stations), o_.stations));
    }
    return Status::Ok();
  }

  void StartStreams() {
    double chunk_s = static_cast<double>(o_.chunk_ticks) / school_.params.rate_hz;
    start_s_ = NowS() + 0.5;
    for (size_t s = 0; s < streaming_.size(); ++s) {
      double share = static_cast<double>(s) / static_cast<double>(streaming_.size());
      streaming_[s]->SetStart(start_s_ + share * chunk_s);
    }
    // Counts up to here belong to the set-up.
    for (auto& engine : engines_) engine->figures() = {};
    for (size_t i = 0; i < o_.hostile; ++i) {
      engines_[0]->AddHostile(static_cast<HostileKind>(i % kHostileKinds));
    }
  }

  uint64_t TicksCommitted() const {
    uint64_t out = 0;
    for (const auto& engine : engines_) out += engine->progress().ticks;
    return out;
  }

  Status Stream() {
    StartStreams();
    say_(Text("streaming %zu stations for %.0f s", o_.stations, o_.seconds));
    Engine::Phase phase;
    phase.goal = Goal::kStream;
    phase.until_s = start_s_ + o_.seconds + kDrain_s;
    phase.cuts_per_s = o_.cuts / o_.seconds / static_cast<double>(engines_.size());
    std::atomic<size_t> running{engines_.size()};
    double own_cpu_s = OwnCpuS(), server_cpu_s = server_cpu_.Now(Pids());
    report_.load_average.push_back(LoadAverage());
    std::vector<std::jthread> threads;
    for (auto& engine : engines_) {
      threads.emplace_back([&, e = engine.get()] {
        e->Run(phase);
        --running;
      });
    }
    std::optional<ApiReader> api;
    if (o_.api_reads_per_s > 0) api.emplace(page_, school_, o_.api_reads_per_s);
    if (o_.marking) marking_.Begin(stations_, fingerprint_);
    WatchOver(running);
    threads.clear();
    report_.wall_s = NowS() - start_s_;
    report_.server_cpu_s = server_cpu_.Now(Pids()) - server_cpu_s;
    report_.loadgen_cpu_s = OwnCpuS() - own_cpu_s;
    report_.load_average.push_back(LoadAverage());
    if (o_.marking) ENAMEL_RETURN_IF_ERROR(FinishMarking());
    if (api) {
      api->Stop();
      report_.api_ms = std::move(api->latencies_ms());
      report_.api_failures = api->failures();
      if (api->failures() > 0 || !api->problem().empty()) Note("page: " + api->problem());
    }
    return restart_status_;
  }

  Status FinishMarking() {
    if (!marking_.done())
      Note("the stations had done before all was scored; let them stream longer");
    ENAMEL_ASSIGN_OR_RETURN(auto figures, marking_.Finish(kSetupWithin_s));
    report_.marking = figures;
    if (figures.scored != o_.marking->attempts) {
      Note(std::to_string(figures.scored) + " of " + std::to_string(o_.marking->attempts) +
           " attempts have a score");
    }
    return Status::Ok();
  }

  // The main thread's work while the engines stream: kills, viewers, messages.
  void WatchOver(const std::atomic<size_t>& running) {
    std::mt19937 random(1);
    std::vector<double> kills_s;
    std::uniform_real_distribution<> moment(start_s_ + 0.1 * o_.seconds, start_s_ + o_.seconds);
    for (int i = 0; i < o_.kills; ++i) kills_s.push_back(moment(random));
    std::ranges::sort(kills_s, std::greater<>());
    if (o_.viewers + o_.slow_viewers > 0 && o_.alternate == 0) OpenViewers();
    BeginStretch();
    double said_s = NowS();
    while (running > 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      double now = NowS();
      if (!kills_s.empty() && now >= kills_s.back() && restart_status_.ok()) {
        kills_s.pop_back();
        KillAndRestart();
      }
      if (o_.alternate > 0 && now >= stretch_end_s_) {
        EndStretch();
        BeginStretch();
      }
      if (now - said_s < kSay_s) continue;
      said_s = now;
      say_(Text("  %3.0f s  %.1f M ticks committed, server %.1f CPU s", now - start_s_,
                static_cast<double>(TicksCommitted()) * 1e-6, server_cpu_.Now(Pids())));
    }
    CloseViewers();
  }

  void KillAndRestart() {
    server_cpu_.Add(UseOf({server_->pid()}).cpu_s);
    double from = NowS();
    server_->Kill();
    restart_status_ = server_->Start();
    report_.restart_s.push_back(NowS() - from);
  }

  void OpenViewers() {
    std::vector<Uuid> attempts;
    for (const Station* station : streaming_) attempts.push_back(station->recording()->attempt());
    viewers_.emplace(page_, school_, std::move(attempts), o_.viewers, o_.slow_viewers);
  }

  void CloseViewers() {
    if (!viewers_) return;
    viewers_->Stop();
    report_.viewer_events += viewers_->events();
    report_.viewer_bytes += viewers_->bytes();
    if (!viewers_->problem().empty()) Note(viewers_->problem());
    viewers_.reset();
  }

  // Stretches without and with viewers alternate; the first second of each does not count.
  void BeginStretch() {
    if (o_.alternate == 0) return;
    double length_s = o_.seconds / (2 * o_.alternate);
    stretch_end_s_ = std::max(NowS(), start_s_) + length_s;
    if (stretch_ % 2 == 1) OpenViewers();
    std::this_thread::sleep_for(std::chrono::seconds(1));
    stretch_cpu_s_ = server_cpu_.Now(Pids());
    stretch_ticks_ = TicksCommitted();
  }

  void EndStretch() {
    double mticks = static_cast<double>(TicksCommitted() - stretch_ticks_) * 1e-6;
    double cpu_s = server_cpu_.Now(Pids()) - stretch_cpu_s_;
    auto& figures = stretch_ % 2 ? report_.cpu_with_viewers : report_.cpu_without_viewers;
    if (mticks > 0 && static_cast<int>(figures.size()) < o_.alternate) {
      figures.push_back(cpu_s / mticks);
    }
    CloseViewers();
    ++stretch_;
  }

  void StayIdle() {
    say_(Text("%zu stations stay connected for %.0f s", o_.idle, o_.seconds));
    start_s_ = NowS();
    double server_cpu_s = server_cpu_.Now(Pids());
    Engine::Phase phase{Goal::kOpen, PerEngine(kOpenAtOnce), start_s_ + o_.seconds, true};
    std::vector<std::jthread> threads;
    for (auto& engine : engines_) threads.emplace_back([&, e = engine.get()] { e->Run(phase); });
    threads.clear();
    report_.wall_s = NowS() - start_s_;
    report_.server_cpu_s = server_cpu_.Now(Pids()) - server_cpu_s;
  }

  void Account() {
    for (auto& engine : engines_) {
      report_.stream.Add(std::move(engine->figures()));
      Note(engine->Problem());
      for (const auto& hostile : engine->hostile()) {
        report_.hostile_thrown_out += hostile->thrown_out();
      }
      for (const auto& station : engine->stations()) {
        report_.idle_connected += !station->recording() && station->connected();
      }
    }
    report_.stations = o_.stations;
    ProcessUse use = UseOf(Pids());
    report_.server_rss_mb = use.rss_mb;
    report_.server_peak_rss_mb = use.peak_rss_mb;
  }

  Status SealAndReadBack() {
    double now = NowS();
    for (Station* station : streaming_) station->EndAt(now);
    double from = NowS();
    Status sealed = Toward({Goal::kSeal, PerEngine(kOpenAtOnce), from + kSetupWithin_s}, "sealed");
    if (!sealed.ok()) Note(sealed.message());
    report_.seal_s = NowS() - from;
    say_("reading every trace back");
    std::vector<const Station*> stations(streaming_.begin(), streaming_.end());
    double said_s = NowS();
    auto read = ReadEverythingBack(data_, stations, [&](double done) {
      if (NowS() - said_s < kSay_s) return;
      said_s = NowS();
      say_(Text("  %.0f %% compared", 100 * done));
    });
    if (!read.ok()) return read.status();
    report_.read_back = *read;
    report_.read_back.ticks_lost += report_.stream.ticks_taken_back;
    return Status::Ok();
  }

  void Note(const std::string& problem) {
    if (report_.problem.empty()) report_.problem = problem;
  }

  const LoadOptions& o_;
  const std::function<void(const std::string&)>& say_;
  TemporaryFolder own_folder_;
  std::filesystem::path data_;
  School school_;
  std::optional<ServerProcess> server_;
  net::Endpoint stations_, page_;
  Sha256 fingerprint_;
  LinkTarget target_;
  std::vector<std::unique_ptr<Engine>> engines_;
  std::vector<Station*> streaming_;
  std::optional<Viewers> viewers_;
  Marking marking_;
  ServerCpu server_cpu_;
  Status restart_status_;
  double start_s_ = 0, stretch_end_s_ = 0, stretch_cpu_s_ = 0;
  uint64_t stretch_ticks_ = 0;
  int stretch_ = 0;
  LoadReport report_;
};

}  // namespace

Result<LoadReport> RunLoad(const LoadOptions& options,
                           const std::function<void(const std::string&)>& say) {
  return Run(options, say).All();
}

}  // namespace enamel::load
