#include "server/jobs/backup_run.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <spdlog/spdlog.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <boost/json.hpp>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <functional>
#include <utility>
#include <vector>

#include "common/base/counted.h"
#include "common/base/fd.h"
#include "common/base/file.h"
#include "common/base/stoppable_sleep.h"
#include "common/base/unix_time.h"
#include "common/base/utf8.h"
#include "server/storage/backup/backup.h"
#include "server/storage/folder/disk.h"
#include "server/storage/store_engine.h"
#include "server/storage/verify/manifest.h"

extern char** environ;

namespace enamel::server {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;
using Clock = std::chrono::steady_clock;

// The server looks this often at a process that says nothing.
constexpr std::chrono::milliseconds kLook{50};
// After SIGKILL only a system call that hangs keeps a process.
constexpr std::chrono::seconds kDies{2};
constexpr char kDrillFolder[] = "drill";  // in the data folder, while one runs
constexpr size_t kMaxRows = 20;           // of the audit trail's kind "store.", all of them rare

uint64_t Number(const json::object& line, const char* name) {
  const json::value* value = line.if_contains(name);
  boost::system::error_code error;
  const uint64_t number = value != nullptr ? value->to_number<uint64_t>(error) : 0;
  return error ? 0 : number;
}

std::string Text(const json::object& line, const char* name) {
  const json::value* value = line.if_contains(name);
  return value != nullptr && value->is_string() ? std::string(value->get_string()) : "";
}

// `enamel-server … --report` and what it says, a line at a time.
class Child {
 public:
  Child() = default;
  // Ends it, at once and without waiting for longer than kDies.
  ~Child() {
    if (pid_ < 0) return;
    ::kill(pid_, SIGKILL);
    for (auto until = Clock::now() + kDies; !HasEnded() && Clock::now() < until;) {
      SleepUntilStopped({}, kLook);
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  Status Start(std::vector<std::string> words) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) {
      return Status(Code::kUnavailable, std::string("no pipe: ") + std::strerror(errno));
    }
    out_.emplace(ends[0]);
    const Fd theirs(ends[1]);
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    ::posix_spawn_file_actions_adddup2(&actions, theirs.get(), STDOUT_FILENO);
    // Standard error stays the server's log. Listeners and connections are not the child's.
    ::posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
    const int error =
        ::posix_spawn(&pid_, words.front().c_str(), &actions, nullptr, arguments.data(), environ);
    ::posix_spawn_file_actions_destroy(&actions);
    if (error == 0) return Status::Ok();
    pid_ = -1;
    return Status(Code::kUnavailable, "cannot start " + words.front() + ": " +
                                          std::strerror(error) +
                                          "; it is installed with the server");
  }

  // The next line; none: it said none within kLook.
  std::optional<std::string> Line() {
    if (const size_t end = said_.find('\n'); end != std::string::npos) {
      std::string line = said_.substr(0, end);
      said_.erase(0, end + 1);
      return line;
    }
    if (over_) {
      SleepUntilStopped({}, kLook);
      return std::nullopt;
    }
    pollfd wait{out_->get(), POLLIN, 0};
    if (::poll(&wait, 1, static_cast<int>(kLook.count())) <= 0) return std::nullopt;
    std::array<char, 4096> part;
    const ssize_t n = ::read(out_->get(), part.data(), part.size());
    if (n > 0) said_.append(part.data(), static_cast<size_t>(n));
    over_ = n == 0;
    return std::nullopt;
  }

  // The process has ended.
  bool HasEnded() {
    if (pid_ >= 0 && ::waitpid(pid_, &status_, WNOHANG) == pid_) pid_ = -1;
    return pid_ < 0;
  }
  bool said_all() const { return over_ && said_.find('\n') == std::string::npos; }
  std::string HowItEnded(const std::string& what) const {
    if (WIFSIGNALED(status_))
      return "the process of the " + what + " was ended by signal " +
             std::to_string(WTERMSIG(status_)) +
             ", by somebody or for want of memory; start it again";
    return "the process of the " + what + " ended with " + std::to_string(WEXITSTATUS(status_)) +
           " and no reason; see the server's log";
  }

 private:
  std::optional<Fd> out_;
  std::string said_;
  bool over_ = false;
  pid_t pid_ = -1;
  int status_ = 0;
};

std::string HungText(const std::string& what, const std::string& phase,
                     std::chrono::milliseconds time) {
  std::string where = phase.empty() ? "" : " while it copied the " + phase;
  const auto minutes = std::chrono::duration_cast<std::chrono::minutes>(time).count();
  return "the " + what + " was ended after " + Counted(static_cast<size_t>(minutes), "minute") +
         " without progress" + where +
         "; check the disk of the backup folder, and the S3 store if there is one";
}

std::string ProgramOf(const BackupRun::Place& place) {
  return (place.program.empty() ? OwnFolder() / "enamel-server" : place.program).string();
}

// How long a child may take, and where what it says goes.
struct Watch {
  const char* what;  // "backup"
  std::chrono::milliseconds silence, most;
  std::function<void(const std::string& phase, uint64_t done, uint64_t all)> progress;
};

// The child's last word, which has "files". Errors: what it said was the problem, or how it ended.
Result<json::object> Follow(std::vector<std::string> words, const Watch& watch,
                            const std::stop_token& stop) {
  Child child;
  ENAMEL_RETURN_IF_ERROR(child.Start(std::move(words)));
  const std::string what = watch.what;
  const auto begun = Clock::now();
  auto heard = begun;
  std::optional<json::object> outcome;
  std::string problem, phase;
  while (!child.said_all() || !child.HasEnded()) {
    if (stop.stop_requested()) return Status(Code::kUnavailable, "the server stops");
    const auto now = Clock::now();
    if (now - heard >= watch.silence) {
      return Status(Code::kUnavailable, HungText(what, phase, watch.silence));
    }
    if (now - begun >= watch.most) {
      const auto hours = std::chrono::duration_cast<std::chrono::hours>(watch.most).count();
      return Status(Code::kUnavailable, "the " + what + " was ended because it took longer than " +
                                            Counted(static_cast<size_t>(hours), "hour") +
                                            "; back up to a faster disk");
    }
    const auto line = child.Line();
    if (!line) continue;
    heard = Clock::now();
    boost::system::error_code error;
    const json::value said = json::parse(*line, error);
    if (error || !said.is_object()) continue;
    const json::object& facts = said.get_object();
    if (facts.contains("files")) {
      outcome = facts;
    } else if (facts.contains("problem")) {
      problem = Text(facts, "problem");
    } else {
      phase = Text(facts, "phase");
      if (watch.progress) watch.progress(phase, Number(facts, "done"), Number(facts, "all"));
    }
  }
  if (outcome) return *outcome;
  return Status(Code::kStorage, problem.empty() ? child.HowItEnded(what) : problem);
}

}  // namespace

std::string BackupName() {
  const std::time_t now = std::chrono::system_clock::to_time_t(WallClock());
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  std::array<char, 32> text;
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%dT%H%M%S", &utc)};
}

Status BackupRun::MustBeFree() const {
  const auto refuse = [](const std::string& why) { return Status(Code::kConflict, why); };
  if (place_.folder.empty()) {
    return refuse(
        "no folder for backups is set; ask IT to name one in the server's settings (backups = "
        "\"/var/backups/enamel\") and to restart it");
  }
  // Not made: where a disk is not mounted, the backup would fill the one below.
  std::error_code error;
  if (!fs::is_directory(place_.folder, error)) {
    return refuse("the folder for backups, " + place_.folder.string() +
                  ", does not exist; mount its disk, or make the folder");
  }
  const Status free = store_.engine->rewriter.UpkeepIsFree();
  return free.code() == Code::kUnavailable ? refuse(free.message()) : free;
}

Status BackupRun::Start(const Actor& by) {
  MutexLock lock(mutex_);
  if (running_) return Status(Code::kConflict, "a backup is running; wait until it is done");
  ENAMEL_RETURN_IF_ERROR(MustBeFree());
  const fs::path folder = fs::absolute(place_.folder) / place_.within;
  const auto made = NewBackupIn(folder, BackupName());
  // A backup that fails at its first step is seen where later failures are.
  if (!made.ok()) return NoteFailure(by, folder, made.status());
  const fs::path target = *made;
  ENAMEL_RETURN_IF_ERROR(store_.audit.NoteAudit(by, kBackupStarted, target.string(), "{}"));
  // Not in place: clang 14 takes it for something that cannot be made so.
  running_.emplace(Running{enamel::UnixMs()});
  thread_ =
      std::jthread([this, target, by](const std::stop_token& stop) { Work(target, by, stop); });
  return Status::Ok();
}

std::optional<BackupRun::Running> BackupRun::running() const {
  MutexLock lock(mutex_);
  return running_;
}

Result<BackupRun::State> BackupRun::Look() const {
  State out;
  out.folder = place_.folder / place_.within;
  ENAMEL_ASSIGN_OR_RETURN(out.drill, LastDrill(store_.audit));
  // First: when this one ends, its row is there already.
  out.running = running();
  if (out.running) return out;
  AuditFilter ours;
  ours.action = "store.";
  ours.limit = kMaxRows;
  ENAMEL_ASSIGN_OR_RETURN(const auto rows, store_.audit.FindAudit(ours));
  for (const AuditRow& row : rows) {
    // A backup has the row of its own beginning: what was restored from one shows no failure.
    if (row.action == kBackupMade || row.action == kRestored) break;
    if (row.action == kBackupFailed) {
      boost::system::error_code error;
      const json::value after = json::parse(row.after_json, error);
      out.failed = {row.at_ms,
                    !error && after.is_object() ? Text(after.get_object(), "problem") : ""};
      break;
    }
    if (row.action != kBackupStarted) continue;
    // Its process holds the upkeep for as long as it runs.
    if (store_.shared && store_.engine->rewriter.UpkeepIsFree().code() == Code::kUnavailable) {
      out.running = Running{row.at_ms, false};
    } else {
      out.failed = {row.at_ms, "the server stopped before the backup was done; start it again"};
    }
    break;
  }
  return out;
}

void BackupRun::Work(const fs::path& target, const Actor& by, const std::stop_token& stop) {
  spdlog::info("backup: writing {}", target.string());
  const Result<Made> made = Make(target, stop);
  // As after a crash: the row of its beginning stays the last one.
  if (stop.stop_requested() && !made.ok()) {
    spdlog::warn("backup: {} is unfinished: the server stops", target.string());
    return;
  }
  Status noted;
  if (made.ok()) {
    spdlog::info("backup: {} has {}, {} missing", target.string(), Counted(made->files, "file"),
                 made->missing);
    noted = store_.audit.NoteAudit(
        by, kBackupMade, target.string(),
        json::serialize(json::object{
            {"files", made->files}, {"bytes", made->bytes}, {"missing", made->missing}}));
  } else {
    noted = NoteFailure(by, target, made.status());
  }
  if (!noted.ok()) spdlog::error("backup: its end could not be noted: {}", noted.message());
  MutexLock lock(mutex_);
  running_.reset();
}

Status BackupRun::NoteFailure(const Actor& by, const fs::path& target, const Status& problem) {
  spdlog::error("backup: {} failed: {}", target.string(), problem.message());
  return store_.audit.NoteAudit(
      by, kBackupFailed, target.string(),
      json::serialize(json::object{{"problem", AsUtf8(problem.message())}}));
}

Result<BackupRun::Made> BackupRun::Make(const fs::path& target, const std::stop_token& stop) {
  std::vector<std::string> words = {
      ProgramOf(place_), "backup", target.string(), "--data", store_.engine->folder.string(),
      "--report"};
  if (!place_.keyring.empty()) {
    words.insert(words.end(), {"--keyring", place_.keyring.string()});
  }
  const auto progress = [this](const std::string& phase, uint64_t done, uint64_t all) {
    MutexLock lock(mutex_);
    running_->phase = phase;
    running_->done = done;
    running_->all = all;
  };
  const auto outcome =
      Follow(std::move(words), {"backup", place_.silence, place_.most, progress}, stop);
  if (outcome.ok()) {
    return Made{Number(*outcome, "files"), Number(*outcome, "bytes"), Number(*outcome, "missing")};
  }
  // A process that was killed cannot remove its part, and a full disk needs the room.
  std::error_code error;
  if (!stop.stop_requested()) fs::remove_all(target.string() + kPartSuffix, error);
  return outcome.status();
}

void BackupRun::Into(Place place) {
  place_ = std::move(place);
  if (place_.folder.empty()) return;
  drills_ = std::jthread([this](const std::stop_token& stop) { Drills(stop); });
}

// Apart from the caretaker: a drill takes hours.
void BackupRun::Drills(const std::stop_token& stop) {
  std::error_code error;
  // A server that was killed during a drill leaves people's data there.
  fs::remove_all(store_.engine->folder / kDrillFolder, error);
  while (!SleepUntilStopped(stop, place_.look)) {
    const auto due = DrillIsDue();
    if (due.ok() && *due) DrillOnce(stop);
  }
}

Result<std::optional<BackupRun::Drill>> BackupRun::LastDrill(AuditRows& audit) {
  ENAMEL_ASSIGN_OR_RETURN(const auto passed, audit.NewestOf(kDrillPassed));
  ENAMEL_ASSIGN_OR_RETURN(const auto failed, audit.NewestOf(kDrillFailed));
  const auto& last = !passed || (failed && passed->id < failed->id) ? failed : passed;
  if (!last) return std::optional<Drill>();
  Drill out{last->at_ms, last->object, {}};
  boost::system::error_code error;
  const json::value after = json::parse(last->after_json, error);
  if (!error && after.is_object()) out.problem = Text(after.get_object(), "problem");
  return std::optional(out);
}

Result<bool> BackupRun::DrillIsDue() const {
  if (running()) return false;
  ENAMEL_ASSIGN_OR_RETURN(const auto made, store_.audit.NewestOf(kBackupMade));
  if (!made) return false;
  // Also one that another server has under way, or that a stop broke off.
  ENAMEL_ASSIGN_OR_RETURN(const auto started, store_.audit.NewestOf(kDrillStarted));
  if (!started) return true;
  ENAMEL_ASSIGN_OR_RETURN(const auto passed, store_.audit.NewestOf(kDrillPassed));
  const auto wait = passed && started->id < passed->id ? place_.drill : place_.drill_again;
  // Either way: a clock that was set back must not end the drills.
  return std::abs(enamel::UnixMs() - started->at_ms) >= wait.count();
}

void BackupRun::DrillOnce(const std::stop_token& stop) {
  const auto backup = NewestBackup(fs::absolute(place_.folder) / place_.within);
  const std::string place = backup.ok() ? backup->string() : "";
  const Actor by{{}, "restore drill"};
  if (!store_.audit.NoteAudit(by, kDrillStarted, place, "{}").ok()) return;
  const Status tried = backup.ok() ? TryRestore(*backup, stop) : backup.status();
  if (stop.stop_requested()) return;
  Status noted;
  if (tried.ok()) {
    spdlog::info("restore drill: {} can be restored, and all of it agrees", place);
    noted = store_.audit.NoteAudit(by, kDrillPassed, place, "{}");
  } else {
    spdlog::error("restore drill: {} cannot be relied on: {}", place, tried.message());
    noted =
        store_.audit.NoteAudit(by, kDrillFailed, place,
                               json::serialize(json::object{{"problem", AsUtf8(tried.message())}}));
  }
  if (!noted.ok()) spdlog::error("restore drill: it could not be noted: {}", noted.message());
}

Status BackupRun::TryRestore(const fs::path& backup, const std::stop_token& stop) {
  const fs::path into = store_.engine->folder / kDrillFolder;
  std::error_code error;
  fs::remove_all(into, error);
  ENAMEL_ASSIGN_OR_RETURN(const auto manifest, ReadManifest(backup));
  uint64_t needed = 0;
  for (const Manifest::File& file : manifest.files) needed += file.bytes;
  // Twice what recordings need: they continue meanwhile.
  needed += needed / 10 + 2 * store_.health.Health().min_free_bytes;
  ENAMEL_ASSIGN_OR_RETURN(const uint64_t free, SystemDisk().FreeBytes(store_.engine->folder));
  if (free < needed) {
    return Status(Code::kStorage, "restoring " + backup.string() + " to try it needs " +
                                      std::to_string(needed >> 20) +
                                      " MiB on the data disk, which "
                                      "has " +
                                      std::to_string(free >> 20) +
                                      " MiB free; try it on another machine");
  }
  std::vector<std::string> words = {ProgramOf(place_), "restore",     backup.string(),
                                    "--data",          into.string(), "--report"};
  if (!place_.keyring.empty()) {
    words.insert(words.end(), {"--keyring", place_.keyring.string()});
  }
  const auto outcome =
      Follow(std::move(words), {"restore drill", place_.silence, place_.drill_most, {}}, stop);
  fs::remove_all(into, error);
  ENAMEL_RETURN_IF_ERROR(outcome.status());
  if (const uint64_t findings = Number(*outcome, "findings"); findings > 0) {
    return Status(Code::kStorage, Counted(findings, "finding") + " in what was restored from " +
                                      backup.string() + ", the first: " + Text(*outcome, "first"));
  }
  return Status::Ok();
}

}  // namespace enamel::server
