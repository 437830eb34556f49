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
#include <cstring>
#include <ctime>
#include <utility>
#include <vector>

#include "common/base/counted.h"
#include "common/base/fd.h"
#include "common/base/file.h"
#include "common/base/stoppable_sleep.h"
#include "common/base/unix_time.h"
#include "common/base/utf8.h"
#include "server/storage/store_engine.h"

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
constexpr size_t kMostRows = 20;  // of the audit trail's kind "store.", all of them rare

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

// `enamel-server backup --report` and what it says, a line at a time.
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
  std::string HowItEnded() const {
    if (WIFSIGNALED(status_))
      return "the backup's process was ended by signal " + std::to_string(WTERMSIG(status_)) +
             ", by somebody or for want of memory; start the backup again";
    return "the backup's process ended with " + std::to_string(WEXITSTATUS(status_)) +
           " and no reason; see the server's log";
  }

 private:
  std::optional<Fd> out_;
  std::string said_;
  bool over_ = false;
  pid_t pid_ = -1;
  int status_ = 0;
};

std::string HungText(const std::optional<BackupRun::Running>& at, std::chrono::milliseconds time) {
  std::string where = at && !at->phase.empty() ? " while it copied the " + at->phase : "";
  const auto minutes = std::chrono::duration_cast<std::chrono::minutes>(time).count();
  return "the backup was ended after " + Counted(static_cast<size_t>(minutes), "minute") +
         " without progress" + where +
         "; check the disk of the backup folder, and the S3 store if there is one";
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
  const fs::path target = fs::absolute(place_.folder) / place_.within / BackupName();
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
  // First: when this one ends, its row is there already.
  out.running = running();
  if (out.running) return out;
  AuditFilter ours;
  ours.action = "store.";
  ours.limit = kMostRows;
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
  const Result<Made> made = Follow(target, stop);
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
    const std::string& problem = made.status().message();
    spdlog::error("backup: {} failed: {}", target.string(), problem);
    noted = store_.audit.NoteAudit(by, kBackupFailed, target.string(),
                                   json::serialize(json::object{{"problem", AsUtf8(problem)}}));
  }
  if (!noted.ok()) spdlog::error("backup: its end could not be noted: {}", noted.message());
  MutexLock lock(mutex_);
  running_.reset();
}

Result<BackupRun::Made> BackupRun::Follow(const fs::path& target, const std::stop_token& stop) {
  const fs::path program = place_.program.empty() ? OwnFolder() / "enamel-server" : place_.program;
  std::vector<std::string> words = {
      program.string(), "backup", target.string(), "--data", store_.engine->folder.string(),
      "--report"};
  if (!place_.keyring.empty()) {
    words.insert(words.end(), {"--keyring", place_.keyring.string()});
  }
  Child child;
  ENAMEL_RETURN_IF_ERROR(child.Start(std::move(words)));
  const auto begun = Clock::now();
  auto heard = begun;
  std::optional<Made> made;
  std::string problem;
  while (!child.said_all() || !child.HasEnded()) {
    if (stop.stop_requested()) return Status(Code::kUnavailable, "the server stops");
    const auto now = Clock::now();
    if (now - heard >= place_.silence) {
      return Status(Code::kUnavailable, HungText(running(), place_.silence));
    }
    if (now - begun >= place_.most) {
      return Status(
          Code::kUnavailable,
          "the backup was ended because it took longer than " +
              Counted(static_cast<size_t>(
                          std::chrono::duration_cast<std::chrono::hours>(place_.most).count()),
                      "hour") +
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
      made = {Number(facts, "files"), Number(facts, "bytes"), Number(facts, "missing")};
    } else if (facts.contains("problem")) {
      problem = Text(facts, "problem");
    } else {
      MutexLock lock(mutex_);
      running_->phase = Text(facts, "phase");
      running_->done = Number(facts, "done");
      running_->all = Number(facts, "all");
    }
  }
  if (made) return *made;
  // Of no use, and a full disk needs the room.
  std::error_code error;
  fs::remove_all(target, error);
  return Status(Code::kStorage, problem.empty() ? child.HowItEnded() : problem);
}

}  // namespace enamel::server
