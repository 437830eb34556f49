#include "station/lab/report/draw.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <optional>

#include "common/base/file.h"
#include "common/program/log.h"
#include "common/program/output.h"

namespace enamel::station::lab {
namespace {

namespace fs = std::filesystem;

constexpr int kNoProgram = 127;

std::optional<fs::path> Script() {
  // Installed: PREFIX/bin and PREFIX/share. Built: TREE/build/PRESET/bin and TREE/web.
  for (const char* place :
       {"../share/enamel/draw_report.mjs", "../../../web/dist_lab/draw_report.mjs"}) {
    fs::path file = (OwnFolder() / place).lexically_normal();
    std::error_code ignored;
    if (fs::exists(file, ignored)) return file;
  }
  return std::nullopt;
}

struct Outcome {
  int code = kNoProgram;
  std::string said;  // on standard error
};

Outcome RunNode(std::vector<std::string> arguments) {
  Outcome out;
  int ends[2];
  // Closed on exec: node only gets the end that replaced its standard error.
  if (::pipe2(ends, O_CLOEXEC) != 0) return out;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
  // From PATH, without a shell: file names are only arguments.
  std::string node = "node";
  std::vector<char*> argv{node.data()};
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  pid_t pid = 0;
  const int failed = ::posix_spawnp(&pid, node.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  if (failed == 0) {
    char buffer[4096];
    // Read before waiting: a child that writes more than a pipe holds would never end.
    for (ssize_t n; (n = ::read(ends[0], buffer, sizeof buffer)) > 0 || (n < 0 && errno == EINTR);)
      if (n > 0) out.said.append(buffer, static_cast<size_t>(n));
    int state = 0;
    while (::waitpid(pid, &state, 0) < 0 && errno == EINTR) continue;
    out.code = WIFEXITED(state) ? WEXITSTATUS(state) : 1;
  }
  ::close(ends[0]);
  // It becomes the message of an error, which is one line.
  while (out.said.ends_with('\n')) out.said.pop_back();
  return out;
}

}  // namespace

ReportFiles ReportFilesOf(const fs::path& path) {
  if (path.extension() != ".html") return {path / "qualification.json", path / "report.html"};
  fs::path document = path;
  return {document.replace_extension(".json"), path};
}

Status CheckReport(const fs::path& path, const char* option) {
  const ReportFiles files = ReportFilesOf(path);
  if (path.extension() != ".html")
    ENAMEL_RETURN_IF_ERROR(program::CheckOutputFolder(path, option));
  else
    ENAMEL_RETURN_IF_ERROR(program::CheckOutputFile(files.document, option));
  return path.extension() == ".html" ? program::CheckOutputFile(files.page, option) : Status::Ok();
}

Status WriteReport(const std::string& document, const fs::path& path) {
  const ReportFiles files = ReportFilesOf(path);
  std::error_code ignored;
  if (path.extension() != ".html") fs::create_directories(path, ignored);
  // The document first: it has the measurements, and can be drawn later or elsewhere.
  ENAMEL_RETURN_IF_ERROR(WriteFileDurably(files.document, AsBytes(document)));
  const std::optional<fs::path> script = Script();
  Outcome drawn;
  if (script) drawn = RunNode({script->string(), files.document.string(), files.page.string()});
  if (drawn.code == 0) return Status::Ok();
  // A failure of node is an error. A missing node is not: the document is complete without it.
  if (drawn.code != kNoProgram) return Status(Code::kStorage, drawn.said);
  program::SayWarning(
      files.document.string() + " is written but not drawn: " +
      (script ? "there is no program 'node' (Debian: nodejs)"
              : "there is no draw_report.mjs beside this program ('npm run build' in web makes it, "
                "'cmake --install BUILD --component lab' installs it)") +
      ". 'node draw_report.mjs " + files.document.string() + " " + files.page.string() +
      "' draws it, and so does the page of the server where it is attached to the device");
  return Status::Ok();
}

}  // namespace enamel::station::lab
