// Measures what an attack costs everybody else. Starts a server, lets one chair stream and one
// person read, and beside them in turn nobody and the attack.
//
//   stolen_chair [--attack chair|strangers|views] [--seconds S] [--pairs N] [--postgres] [--check]
//
// chair: a chair's credentials in the hands of somebody who tries everything (thief.h); strangers:
// 1 020 unfinished bodies at the page; views: 512 live views of one session. The attacker's thread
// has nice 19. Prints the medians of the pairs. --check: fails if a refusal does not name its budget,
// /readyz is not 200, or the other chair loses anything; without it only a failure of its own.
#include <spdlog/spdlog.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "tests/load/api_reader.h"
#include "tests/load/engine.h"
#include "tests/load/read_back.h"
#include "tests/load/server_process.h"
#include "tests/load/stations/motion.h"
#include "tests/load/stolen_chair/strangers.h"
#include "tests/load/stolen_chair/thief.h"

namespace {

using namespace enamel;
using namespace enamel::load;

constexpr size_t kChunkTicks = 100;  // ten commits a second
constexpr double kReadsPerS = 50;
constexpr size_t kStrangers = 1020;
constexpr size_t kViews = 512;
constexpr double kSetupWithin_s = 30;
constexpr double kSettle_s = 1;
constexpr std::string_view kWithout = "without", kWith = "with";

struct Asked {
  std::string attack = "chair", misuse;
  double seconds = 60;
  int pairs = 5;
  bool postgres = false, check = false;
  std::filesystem::path server_program;
};

struct Stretch {
  std::vector<float> commit_ms, read_ms;
  double rss_mb = 0;
  uint64_t not_ready = 0, asked_ready = 0, read_failures = 0;
};

// Asks /readyz and looks at the memory for as long as it lives.
class Watch {
 public:
  Watch(const net::Endpoint& page, pid_t server, Stretch& out)
      : thread_([&out, page, server](const std::stop_token& stop) {
          HttpClient client(page);
          while (!stop.stop_requested()) {
            ++out.asked_ready;
            if (const auto ready = client.Get("/readyz"); !ready.ok()) {
              ++out.not_ready;
              std::fprintf(stderr, "  /readyz: %s\n", ready.status().message().c_str());
            }
            out.rss_mb = std::max(out.rss_mb, UseOf({server}).rss_mb);
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
          }
        }) {}

 private:
  std::jthread thread_;
};

class Benchmark {
 public:
  explicit Benchmark(Asked asked) : asked_(std::move(asked)) {}
  ~Benchmark() {
    std::error_code ignored;
    if (!data_.empty()) std::filesystem::remove_all(data_, ignored);
  }

  Status Run() {
    ENAMEL_RETURN_IF_ERROR(Begin());
    std::printf("%-5s %-8s %10s %10s %10s %10s %9s %9s\n", "pair", "", "commit p50", "p99",
                "request p50", "p99", "RSS MB", "not ready");
    for (int pair = 1; pair <= asked_.pairs; ++pair) {
      ENAMEL_ASSIGN_OR_RETURN(Stretch without, Measure(pair, kWithout));
      ENAMEL_RETURN_IF_ERROR(Attack(true));
      auto with = Measure(pair, kWith);
      ENAMEL_RETURN_IF_ERROR(Attack(false));
      if (!with.ok()) return with.status();
      Compare(without, *with);
      Settle();
    }
    Print();
    return End();
  }

 private:
  Status Begin() {
    rlimit files{};
    ::getrlimit(RLIMIT_NOFILE, &files);
    files.rlim_cur = files.rlim_max;
    ::setrlimit(RLIMIT_NOFILE, &files);
    std::string folder = (std::filesystem::temp_directory_path() / "enamel-stolen-XXXXXX").string();
    if (::mkdtemp(folder.data()) == nullptr) return Status(Code::kUnavailable, "no folder");
    data_ = folder;
    if (asked_.postgres) {
      const char* place = std::getenv("ENAMEL_POSTGRES");
      if (place == nullptr)
        return Status(Code::kInvalidInput, "run it under tests/support/with_postgres.sh");
      const std::string made = asked_.server_program.string() + " init --data " + folder +
                               " --database '" + place + "' --schema stolen > /dev/null";
      if (std::system(made.c_str()) != 0) return Status(Code::kUnavailable, "init failed");
    }
    ENAMEL_ASSIGN_OR_RETURN(school_, FoundSchool(data_, 2));
    server_.emplace(asked_.server_program, data_, data_ / "server.log",
                    std::vector<std::string>{"--job-threads", "1"});
    ENAMEL_RETURN_IF_ERROR(server_->Start());
    ENAMEL_ASSIGN_OR_RETURN(target_, TargetOf(server_->stations(), server_->fingerprint()));
    std::vector<Misuse> misuses;
    for (size_t i = 0; i < kMisuses; ++i) {
      const auto misuse = static_cast<Misuse>(i);
      if (asked_.misuse.empty() || asked_.misuse == NameOf(misuse)) misuses.push_back(misuse);
    }
    if (misuses.empty()) return Status(Code::kInvalidInput, "expected a misuse that --help lists");
    const double turn_s = asked_.seconds / static_cast<double>(misuses.size());
    thief_.emplace(target_, school_, school_.codes[1], std::move(misuses), turn_s);
    ENAMEL_RETURN_IF_ERROR(thief_->Enrol());
    strangers_.emplace(server_->page(), kStrangers);
    engine_.emplace(target_);
    StationPlan plan;
    plan.school = &school_;
    plan.code = school_.codes[0];
    plan.name = "another chair";
    plan.chunk_ticks = kChunkTicks;
    chair_ = &engine_->Add(std::move(plan));
    if (!engine_->Run({Goal::kTicket, 1, NowS() + kSetupWithin_s}))
      return Status(Code::kUnavailable, "no ticket: " + engine_->Problem());
    ENAMEL_ASSIGN_OR_RETURN(const Motion motion, SimulatedMotion(5'000));
    const double all_s = (2 * asked_.seconds + 2 * kSettle_s) * asked_.pairs + 60;
    chair_->Prepare(StreamOf(motion, 0, kChunkTicks, 40), static_cast<uint32_t>(all_s * 10));
    if (!engine_->Run({Goal::kOpen, 1, NowS() + kSetupWithin_s}))
      return Status(Code::kUnavailable, "not opened: " + engine_->Problem());
    chair_->SetStart(NowS());
    Settle();
    return Status::Ok();
  }

  void Settle() { Stream(kSettle_s); }
  void Stream(double seconds) {
    engine_->figures().commit_ms.clear();
    (void)engine_->Run({Goal::kStream, 1, NowS() + seconds, true});
  }

  Status Attack(bool begins) {
    if (asked_.attack == "strangers") {
      begins ? strangers_->Begin() : strangers_->Stop();
    } else if (asked_.attack == "views") {
      return begins ? BeginViews() : EndViews();
    } else {
      begins ? thief_->Begin() : thief_->Stop();
    }
    return Status::Ok();
  }

  Status BeginViews() {
    const std::string path = "/api/v1/attempts/" + chair_->recording()->attempt().Text() + "/live";
    HttpClient one(server_->page()), other(server_->page());
    ENAMEL_RETURN_IF_ERROR(one.SignIn(school_.instructor_login, school_.password));
    ENAMEL_RETURN_IF_ERROR(other.SignIn(school_.admin_login, school_.password));
    viewed_ = 0;
    for (size_t i = 0; i < kViews; ++i) {
      const Opened view = OpenStream(server_->page(), path, one.cookie());
      if (view.status == 200) {
        ++viewed_;
        views_.push_back(view.fd);
      } else {
        ++answers_[view.text];
      }
    }
    const Opened view = OpenStream(server_->page(), path, other.cookie());
    other_views_ += view.status == 200 ? 1 : 0;
    if (view.status == 200) views_.push_back(view.fd);
    return Status::Ok();
  }
  Status EndViews() {
    for (const int fd : views_) ::close(fd);
    views_.clear();
    return Status::Ok();
  }

  Result<Stretch> Measure(int pair, std::string_view which) {
    Stretch out;
    const double until_s = NowS() + kSetupWithin_s;
    {
      Watch watch(server_->page(), server_->pid(), out);
      ApiReader reader(server_->page(), school_, kReadsPerS);
      Stream(asked_.seconds);
      // However slow the machine is.
      const bool waits = asked_.check && asked_.attack == "chair" && which == kWith;
      while (waits && thief_->counts().over_budget == 0 && NowS() < until_s) Stream(0.1);
      reader.Stop();
      out.read_ms = reader.latencies_ms();
      out.read_failures = reader.failures();
      if (reader.failures() > 0) std::fprintf(stderr, "  %s\n", reader.problem().c_str());
    }
    out.commit_ms = engine_->figures().commit_ms;
    if (const std::string problem = engine_->Problem(); !problem.empty())
      return Status(Code::kUnavailable, "the other chair gave up: " + problem);
    std::printf("%-5d %-8s %10.2f %10.2f %10.2f %10.2f %9.0f %5llu/%llu\n", pair,
                std::string(which).c_str(), Quantile(out.commit_ms, 0.5),
                Quantile(out.commit_ms, 0.99), Quantile(out.read_ms, 0.5),
                Quantile(out.read_ms, 0.99), out.rss_mb,
                static_cast<unsigned long long>(out.not_ready),
                static_cast<unsigned long long>(out.asked_ready));
    std::fflush(stdout);
    if (idle_rss_mb_ == 0) idle_rss_mb_ = out.rss_mb;
    not_ready_ += out.not_ready;
    read_failures_ += out.read_failures;
    return out;
  }

  void Compare(Stretch& without, Stretch& with) {
    const auto add = [&](size_t at, std::vector<float>& a, std::vector<float>& b, double p) {
      const double before = Quantile(a, p), after = Quantile(b, p);
      without_[at].push_back(before);
      with_[at].push_back(after);
      times_[at].push_back(before > 0 ? after / before : 0);
    };
    add(0, without.commit_ms, with.commit_ms, 0.5);
    add(1, without.commit_ms, with.commit_ms, 0.99);
    add(2, without.read_ms, with.read_ms, 0.5);
    add(3, without.read_ms, with.read_ms, 0.99);
    above_idle_mb_.push_back(with.rss_mb - idle_rss_mb_);
  }

  void Print() {
    constexpr const char* kNames[] = {"commit_p50_ms", "commit_p99_ms", "request_p50_ms",
                                      "request_p99_ms"};
    std::printf("%-34s %s, %.0f s, medians of %d interleaved pairs, %s\n", "attack",
                asked_.attack.c_str(), asked_.seconds, asked_.pairs,
                asked_.postgres ? "PostgreSQL" : "SQLite");
    for (size_t i = 0; i < std::size(kNames); ++i) {
      std::printf("%-34s %.2f -> %.2f, x %.2f\n", kNames[i], Median(without_[i]), Median(with_[i]),
                  Median(times_[i]));
    }
    std::printf("%-34s %llu\n", "readyz_not_200", static_cast<unsigned long long>(not_ready_));
    std::printf("%-34s %llu\n", "requests_refused",
                static_cast<unsigned long long>(read_failures_));
    std::printf("%-34s %.0f, at most %.0f\n", "rss_above_idle_mb", Median(above_idle_mb_),
                std::ranges::max(above_idle_mb_));
    if (asked_.attack == "chair") {
      std::printf("%-34s %llu links, %llu frames, %llu replies\n", "thief",
                  static_cast<unsigned long long>(thief_->counts().links),
                  static_cast<unsigned long long>(thief_->counts().frames),
                  static_cast<unsigned long long>(thief_->counts().replies));
    }
    if (asked_.attack == "strangers")
      std::printf("%-34s %llu\n", "strangers",
                  static_cast<unsigned long long>(strangers_->opened()));
    if (asked_.attack == "views")
      std::printf("%-34s %zu of %zu, another person's in %d of %d\n", "views", viewed_, kViews,
                  other_views_, asked_.pairs);
    for (const auto& [what, count] : Refusals())
      std::printf("%8llu  %s\n", static_cast<unsigned long long>(count), what.c_str());
  }

  std::map<std::string, uint64_t> Refusals() const {
    if (asked_.attack == "chair") return thief_->refusals();
    return asked_.attack == "strangers" ? strangers_->answers() : answers_;
  }

  Status End() {
    chair_->EndAt(NowS());
    if (!engine_->Run({Goal::kStream, 1, NowS() + kSetupWithin_s}) ||
        !engine_->Run({Goal::kSeal, 1, NowS() + kSetupWithin_s}))
      return Status(Code::kUnavailable, "the other chair could not finish: " + engine_->Problem());
    server_->Stop();
    ENAMEL_ASSIGN_OR_RETURN(const ReadBack read,
                            ReadEverythingBack(data_, {chair_}, [](double) {}));
    std::printf("%-34s %llu\n", "ticks_lost", static_cast<unsigned long long>(read.ticks_lost));
    if (!asked_.check) return Status::Ok();
    bool named = false;
    for (const auto& [what, count] : Refusals())
      named |= what.find("(budget ") != std::string::npos;
    if (read.ticks_lost > 0 || read.ticks_doubled > 0)
      return Status(Code::kConflict, "the other chair lost some of its recording");
    if (not_ready_ > 0) return Status(Code::kConflict, "/readyz was not 200");
    if (!named) return Status(Code::kConflict, "expected a refusal that names its budget");
    if (asked_.attack == "views" && other_views_ < asked_.pairs)
      return Status(Code::kConflict, "another person got no live view");
    return Status::Ok();
  }

  const Asked asked_;
  std::filesystem::path data_;
  School school_;
  std::optional<ServerProcess> server_;
  LinkTarget target_;
  std::optional<Thief> thief_;
  std::optional<Strangers> strangers_;
  std::optional<Engine> engine_;
  Station* chair_ = nullptr;
  std::vector<int> views_;
  size_t viewed_ = 0;
  int other_views_ = 0;
  std::map<std::string, uint64_t> answers_;
  std::vector<double> without_[4], with_[4], times_[4];
  double idle_rss_mb_ = 0;  // of the first stretch without
  std::vector<double> above_idle_mb_;
  uint64_t not_ready_ = 0, read_failures_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Measures what an attack costs everybody else");
  Asked asked;
  app.add_option("--attack", asked.attack, "chair, strangers or views")
      ->check(CLI::IsMember({"chair", "strangers", "views"}))
      ->capture_default_str();
  app.add_option(
      "--misuse", asked.misuse,
      "One misuse of a chair alone: unfinished, small, chunks, reconnects, tickets, offers "
      "or downloads");
  app.add_option("--seconds", asked.seconds, "Of each stretch, without and with")
      ->check(CLI::Range(0.5, 3600.0))
      ->capture_default_str();
  app.add_option("--pairs", asked.pairs, "Of stretches")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  app.add_flag("--postgres", asked.postgres, "On the server that ENAMEL_POSTGRES names");
  app.add_flag("--check", asked.check, "Fail where a refusal is unnamed or something is lost");
  app.add_option("--server-program", asked.server_program,
                 "enamel-server to start; else the one beside this program");
  CLI11_PARSE(app, argc, argv);
  std::signal(SIGPIPE, SIG_IGN);
  spdlog::set_level(spdlog::level::warn);
  if (asked.server_program.empty()) {
    asked.server_program =
        std::filesystem::read_symlink("/proc/self/exe").parent_path() / "enamel-server";
  }
  Benchmark benchmark(std::move(asked));
  const Status status = benchmark.Run();
  if (status.ok()) return 0;
  std::fprintf(stderr, "stolen_chair: %s\n", status.message().c_str());
  return 1;
}
