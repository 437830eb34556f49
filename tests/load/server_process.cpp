#include "tests/load/server_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <thread>

#include "common/base/hex.h"

extern char** environ;

namespace enamel::load {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kReadyWithin = std::chrono::seconds(60);
constexpr auto kStopWithin = std::chrono::seconds(15);

std::string EndOf(const std::filesystem::path& log) {
  std::ifstream in(log);
  std::stringstream text;
  text << in.rdbuf();
  std::string all = text.str();
  return all.size() > 500 ? all.substr(all.size() - 500) : all;
}

// The word after `name` and a space.
std::string WordAfter(const std::string& line, const std::string& name) {
  size_t at = line.find(name + " ");
  if (at == std::string::npos) return "";
  at += name.size() + 1;
  return line.substr(at, line.find_first_of(", \n", at) - at);
}

}  // namespace

ServerProcess::ServerProcess(std::filesystem::path program, std::filesystem::path data,
                             std::filesystem::path log, std::vector<std::string> more_arguments)
    : program_(std::move(program)),
      data_(std::move(data)),
      log_(std::move(log)),
      more_arguments_(std::move(more_arguments)) {}

ServerProcess::~ServerProcess() { Kill(); }

Status ServerProcess::Start() {
  std::vector<std::string> words = {program_.string(), "serve",         "--data",
                                    data_.string(),    "--http",        page_.Text(),
                                    "--stations",      stations_.Text()};
  words.insert(words.end(), more_arguments_.begin(), more_arguments_.end());
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);

  int out[2];
  if (::pipe2(out, O_CLOEXEC) != 0) return Status(Code::kUnavailable, "no pipe to be had");
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, log_.c_str(),
                                   O_WRONLY | O_CREAT | O_APPEND, 0600);
  int failed = ::posix_spawn(&pid_, program_.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(out[1]);
  Status status = failed == 0
                      ? ReadReadyLine(out[0])
                      : Status(Code::kUnavailable, "cannot start " + program_.string() + ": " +
                                                       std::strerror(failed) +
                                                       "; name the program with --server-program");
  if (failed != 0) pid_ = -1;
  ::close(out[0]);
  return status;
}

Status ServerProcess::ReadReadyLine(int fd) {
  std::string line;
  auto deadline = Clock::now() + kReadyWithin;
  while (line.find('\n') == std::string::npos && Clock::now() < deadline) {
    pollfd wait{fd, POLLIN, 0};
    if (::poll(&wait, 1, 100) <= 0) continue;
    char buffer[512];
    ssize_t n = ::read(fd, buffer, sizeof buffer);
    if (n <= 0) break;
    line.append(buffer, static_cast<size_t>(n));
  }
  auto stations = net::ParseEndpoint(WordAfter(line, "stations"));
  std::string url = WordAfter(line, "page");
  auto page =
      net::ParseEndpoint(url.substr(url.find("//") == std::string::npos ? 0 : url.find("//") + 2));
  auto fingerprint = FromHex(WordAfter(line, "fingerprint"));
  if (!stations.ok() || !page.ok() || !fingerprint.ok() || fingerprint->size() != 32) {
    Kill();
    return Status(Code::kUnavailable, "the server did not get ready; it says: " + EndOf(log_));
  }
  stations_ = *stations;
  page_ = *page;
  fingerprint_ = Sha256::FromBytes(*fingerprint);
  return Status::Ok();
}

void ServerProcess::Kill() {
  if (pid_ < 0) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
  pid_ = -1;
}

void ServerProcess::Stop() {
  if (pid_ < 0) return;
  ::kill(pid_, SIGTERM);
  auto deadline = Clock::now() + kStopWithin;
  while (Clock::now() < deadline) {
    if (::waitpid(pid_, nullptr, WNOHANG) == pid_) {
      pid_ = -1;
      return;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  Kill();
}

namespace {

struct StatFields {
  pid_t parent = 0;
  double cpu_s = 0;  // its own, and that of its children who have ended
};

StatFields StatOf(pid_t pid) {
  std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  std::getline(stat, text);
  // Fields 4 and 14 to 17, counted after the name in brackets, which may contain spaces (proc(5)).
  std::istringstream fields(
      text.substr(text.rfind(')') == std::string::npos ? 0 : text.rfind(')') + 1));
  StatFields out;
  std::string skipped;
  fields >> skipped >> out.parent;
  for (int i = 5; i < 14; ++i) fields >> skipped;
  double ticks = 0;
  for (int i = 14; i < 18; ++i) {
    double field = 0;
    fields >> field;
    ticks += field;
  }
  out.cpu_s = ticks / static_cast<double>(::sysconf(_SC_CLK_TCK));
  return out;
}

// These processes and all their descendants.
std::set<pid_t> WithChildren(const std::vector<pid_t>& pids) {
  std::map<pid_t, std::vector<pid_t>> children;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc", error)) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const auto pid = static_cast<pid_t>(std::stol(name));
    children[StatOf(pid).parent].push_back(pid);
  }
  std::set<pid_t> out;
  std::vector<pid_t> next = pids;
  while (!next.empty()) {
    const pid_t pid = next.back();
    next.pop_back();
    if (!out.insert(pid).second) continue;
    const auto& mine = children[pid];
    next.insert(next.end(), mine.begin(), mine.end());
  }
  return out;
}

}  // namespace

ProcessUse UseOf(const std::vector<pid_t>& pids) {
  ProcessUse out;
  for (const pid_t pid : WithChildren(pids)) {
    out.cpu_s += StatOf(pid).cpu_s;
    std::ifstream status("/proc/" + std::to_string(pid) + "/status");
    for (std::string name; status >> name;) {
      double kb = 0;
      if (name == "VmRSS:" && status >> kb) out.rss_mb += kb / 1024;
      if (name == "VmHWM:" && status >> kb) out.peak_rss_mb += kb / 1024;
    }
  }
  return out;
}

}  // namespace enamel::load
