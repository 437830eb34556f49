#include "common/import/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <string>

#include "common/base/fd.h"
#include "common/base/file.h"
#include "common/base/utf8.h"
#include "common/import/mesh_kind.h"

namespace enamel::import {
namespace {

using Clock = std::chrono::steady_clock;

// More than the child's 60 s of processor: on a machine that is busy those take longer.
constexpr auto kDeadline = std::chrono::seconds(90);
// A part takes at most 520: two numbers, and two texts of a byte's length (triangles.h).
constexpr size_t kMaxOutput = 64 + 24 * mesh::kMaxVertices + 12 * mesh::kMaxTriangles +
                              mesh::kMaxParts * 520 + mesh::kMaxNotes * 256;
constexpr size_t kMaxMessage = 2'000;

// A pipe whose ends close themselves.
struct Pipe {
  int ends[2] = {-1, -1};
  Pipe() {
    if (pipe2(ends, O_CLOEXEC) != 0) ends[0] = ends[1] = -1;
  }
  ~Pipe() {
    Close(0);
    Close(1);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  bool ok() const { return ends[0] >= 0; }
  void Close(int end) {
    if (ends[end] >= 0) close(ends[end]);
    ends[end] = -1;
  }
};

// Into a file in memory, which is then at its beginning again. False, and errno, when it fails.
bool Fill(int fd, ByteView bytes) {
  while (!bytes.empty()) {
    const ssize_t n = write(fd, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes = bytes.subspan(static_cast<size_t>(n));
  }
  return lseek(fd, 0, SEEK_SET) == 0;
}

int Spawn(const std::filesystem::path& child, std::string kind, int input, const Pipe& out,
          const Pipe& err, pid_t& pid) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  // The pipes themselves close with exec (O_CLOEXEC): the child holds no end but these two, or
  // reading here would never end.
  posix_spawn_file_actions_adddup2(&actions, out.ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err.ends[1], STDERR_FILENO);
  // Also what other code opened without O_CLOEXEC: listeners, and people's connections.
  posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
  std::string program = child.string();
  char* argv[] = {program.data(), kind.data(), nullptr};
  // The environment may hold secrets, such as the S3 store's.
  char* environment[] = {nullptr};
  int error = posix_spawn(&pid, program.c_str(), &actions, nullptr, argv, environment);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

// Appends what can be read now. False at the end of the stream or over the bound.
bool Drain(int fd, Bytes& to, size_t max_size) {
  uint8_t buffer[65536];
  ssize_t n = read(fd, buffer, sizeof buffer);
  if (n < 0) return errno == EINTR || errno == EAGAIN;
  if (n == 0) return false;
  to.insert(to.end(), buffer, buffer + n);
  return to.size() <= max_size;
}

// True when both streams ended by themselves within bounds and time.
bool Collect(Pipe& out, Pipe& err, Bytes& output, Bytes& message) {
  const auto end = Clock::now() + kDeadline;
  while (out.ends[0] >= 0 || err.ends[0] >= 0) {
    auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    if (left <= 0) return false;
    pollfd fds[2] = {{out.ends[0], POLLIN, 0}, {err.ends[0], POLLIN, 0}};
    if (poll(fds, 2, static_cast<int>(left)) < 0 && errno != EINTR) return false;
    // Whatever is said of it, also hang-up: read tells what it is.
    if (fds[0].revents != 0 && !Drain(out.ends[0], output, kMaxOutput)) out.Close(0);
    if (fds[1].revents != 0 && !Drain(err.ends[0], message, kMaxMessage)) err.Close(0);
  }
  return output.size() <= kMaxOutput;
}

int WaitFor(pid_t pid) {
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

// One printable line.
std::string Clean(const Bytes& message) {
  constexpr size_t kLongest = 400;
  std::string text(AsText(message).substr(0, kLongest));
  std::ranges::replace(text, '\n', ' ');
  while (text.ends_with(' ')) text.pop_back();
  return enamel::Printable(text);
}

// "stl" of "Crown.STL".
std::string KindOf(const std::filesystem::path& file) {
  std::string ext = file.extension().string();
  if (!ext.empty()) ext.erase(0, 1);
  std::transform(ext.begin(), ext.end(), ext.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return ext;
}

Status CheckFile(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    return Status(Code::kNotFound, "there is no mesh file " + file.string() +
                                       ": expected an STL, PLY, OBJ or OFF file");
  }
  if (const auto size = std::filesystem::file_size(file, error);
      !error && size > mesh::kMaxMeshFile) {
    return Status(Code::kTooLarge,
                  file.filename().string() + ": expected a file of at most " +
                      std::to_string(mesh::kMaxMeshFile >> 20) + " MiB, found one of " +
                      std::to_string(size >> 20) +
                      " MiB: reduce the mesh in a mesh program (a crown needs no more than 200000 "
                      "triangles)");
  }
  const Status kind = CheckMeshKind(KindOf(file));
  if (kind.ok()) return kind;
  return Status(kind.code(), file.filename().string() + ": " + kind.message());
}

}  // namespace

Result<ReadFileMesh> ReadMeshInChild(const std::filesystem::path& file,
                                     const std::filesystem::path& child) {
  ENAMEL_RETURN_IF_ERROR(CheckFile(file));
  const auto program = child.empty() ? OwnFolder() / "enamel-import-child" : child;
  // Read once, here: the hash is of the bytes that the reader gets, even when somebody changes the
  // file in between.
  ENAMEL_ASSIGN_OR_RETURN(auto bytes, ReadFile(file, mesh::kMaxMeshFile));
  const Fd input(memfd_create("mesh", MFD_CLOEXEC));
  if (input.get() < 0 || !Fill(input.get(), bytes)) {
    return Status(Code::kUnavailable,
                  std::string("no memory for the mesh reader's input: ") + std::strerror(errno));
  }
  Pipe out, err;
  if (!out.ok() || !err.ok())
    return Status(Code::kUnavailable,
                  std::string("no pipe for the mesh reader: ") + std::strerror(errno));
  pid_t pid = -1;
  if (int error = Spawn(program, KindOf(file), input.get(), out, err, pid); error != 0) {
    return Status(Code::kNotFound, "cannot start the mesh reader " + program.string() + ": " +
                                       std::strerror(error) +
                                       "; it is installed beside this program");
  }
  out.Close(1);
  err.Close(1);
  Bytes output, message;
  bool in_time = Collect(out, err, output, message);
  if (!in_time) kill(pid, SIGKILL);
  int status = WaitFor(pid);
  const std::string name = file.filename().string();
  if (!in_time || WIFSIGNALED(status)) {
    return Status(Code::kUnavailable, name +
                                          ": the mesh reader was stopped because the file takes "
                                          "too much time or memory, or breaks it: " +
                                          "export it again, from another program");
  }
  if (WEXITSTATUS(status) != 0) return Status(Code::kInvalidInput, name + ": " + Clean(message));
  ENAMEL_ASSIGN_OR_RETURN(auto mesh, mesh::DecodeMesh(output));
  return ReadFileMesh{std::move(mesh), HashSha256(bytes)};
}

}  // namespace enamel::import
