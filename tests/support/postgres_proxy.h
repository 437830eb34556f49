#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/temp_folder.h"

namespace enamel::test {

// A proxy between libpq and PostgreSQL, on local sockets: passes everything on, and breaks one
// connection at a chosen message. Reads the protocol's frames (PostgreSQL 15, chapter 55.7): a
// type, a length of four bytes that counts itself, and the rest; a connection's first message has
// no type. Thread safety: any thread.
class PostgresProxy {
 public:
  enum class Cut {
    kBefore,  // the message never comes to the server
    kAfter,   // the server has it, and its answer is still under way
    kAnswer,  // the server has answered, and the answer never comes to the client
    kLate,    // the client is gone; the server gets it once another connection has asked something
  };

  // `server`: libpq's connection string, with "host=FOLDER" in it.
  explicit PostgresProxy(const std::string& server) {
    const size_t begin = server.find("host=") + 5, end = server.find(' ', begin);
    behind_ = server.substr(begin, end - begin) + "/.s.PGSQL.5432";
    words_ = "host=" + folder_.path().string() + server.substr(end);
    listener_ = Socket();
    const sockaddr_un address = Address(folder_.path() / ".s.PGSQL.5432");
    if (::bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
        ::listen(listener_, 64) != 0)
      throw std::runtime_error("cannot listen beside PostgreSQL");
    thread_ = std::thread([this] { Accept(); });
  }
  ~PostgresProxy() {
    stopping_ = true;
    thread_.join();
    for (std::thread& thread : connections_) thread.join();
    ::close(listener_);
  }
  PostgresProxy(const PostgresProxy&) = delete;
  PostgresProxy& operator=(const PostgresProxy&) = delete;

  // The connection string for clients.
  const std::string& server() const { return words_; }
  // Lets `skip` messages pass, then breaks the connection that sends the next.
  void CutAt(int skip, Cut cut) {
    std::lock_guard lock(mutex_);
    left_ = skip;
    cut_ = cut;
  }
  // From now on refuses new connections, as if the server were down; existing ones stay.
  void Refuse(bool on = true) { refusing_ = on; }
  int refused() const { return refused_; }
  // As a server whose processes are stopped: connections are open, also new ones, and nothing comes
  // from them until it ends.
  void Hang(bool on = true) { hanging_ = on; }
  // Number of requests for an answer so far: queries and ends of pipelines.
  int asked() const { return asked_; }
  // Whether a connection was broken; disables further breaks.
  bool Disarm() {
    std::lock_guard lock(mutex_);
    const bool cut = left_ == kCut;
    left_ = kIdle;
    return cut;
  }

 private:
  static constexpr int kIdle = -1, kCut = -2;
  static constexpr int kPoll_ms = 20;
  // Messages of a reconnection, until it has read whether a COMMIT was kept.
  static constexpr int kAskedAll = 12;

  static sockaddr_un Address(const std::string& path) {
    sockaddr_un out{};
    out.sun_family = AF_UNIX;
    if (path.size() >= sizeof out.sun_path) throw std::runtime_error("too long: " + path);
    std::memcpy(out.sun_path, path.c_str(), path.size() + 1);
    return out;
  }
  static int Socket() { return ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0); }

  void Accept() {
    while (!stopping_) {
      pollfd ready{listener_, POLLIN, 0};
      if (::poll(&ready, 1, kPoll_ms) != 1) continue;
      const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      if (client < 0) continue;
      if (refusing_) {
        ::close(client);
        ++refused_;
        continue;
      }
      connections_.emplace_back([this, client] { Serve(client); });
    }
  }

  // True: this is the chosen message.
  bool IsTheOne(Cut& cut) {
    std::lock_guard lock(mutex_);
    if (left_ < 0) return false;
    cut = cut_;
    if (left_-- > 0) return false;
    left_ = kCut;
    return true;
  }

  static bool Send(int to, const char* bytes, size_t size) {
    while (size > 0) {
      const ssize_t sent = ::send(to, bytes, size, MSG_NOSIGNAL);
      if (sent <= 0) return false;
      bytes += sent;
      size -= static_cast<size_t>(sent);
    }
    return true;
  }

  // The size of the message at the front; 0: incomplete.
  static size_t Front(const std::string& bytes, bool typed) {
    const size_t at = typed ? 1 : 0;
    if (bytes.size() < at + 4) return 0;
    size_t length = 0;
    for (size_t i = 0; i < 4; ++i) length = length << 8 | static_cast<uint8_t>(bytes[at + i]);
    return bytes.size() < at + length ? 0 : at + length;
  }

  // Waits until the server has answered everything: "ready for query".
  void AwaitAnswer(int server) {
    std::string bytes;
    std::array<char, 4096> part;
    for (int waited = 0; waited < 10'000 / kPoll_ms && !stopping_;) {
      pollfd ready{server, POLLIN, 0};
      if (::poll(&ready, 1, kPoll_ms) != 1) {
        ++waited;
        continue;
      }
      const ssize_t got = ::recv(server, part.data(), part.size(), 0);
      if (got <= 0) return;
      bytes.append(part.data(), static_cast<size_t>(got));
      for (size_t size; (size = Front(bytes, true)) > 0; bytes.erase(0, size)) {
        if (bytes[0] == 'Z') return;
      }
    }
  }

  // Until another connection has received an answer, or waits for its answer: then there is no
  // hurry.
  void AwaitOthers() {
    const int before = passed_;
    for (int waited = 0; waited < 10 && !stopping_ && passed_ < before + kAskedAll; ++waited)
      ::poll(nullptr, 0, kPoll_ms);
  }

  void Serve(int client) {
    const int server = Socket();
    const sockaddr_un address = Address(behind_);
    bool open = ::connect(server, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    std::string asked;
    bool typed = false;
    std::array<char, 65536> part;
    while (open && !stopping_) {
      std::array<pollfd, 2> ready{{{client, POLLIN, 0}, {server, POLLIN, 0}}};
      if (hanging_) {
        ::poll(nullptr, 0, kPoll_ms);
        continue;
      }
      if (::poll(ready.data(), ready.size(), kPoll_ms) < 1) continue;
      if (ready[1].revents != 0) {
        const ssize_t got = ::recv(server, part.data(), part.size(), 0);
        open = got > 0 && Send(client, part.data(), static_cast<size_t>(got));
      }
      if (!open || ready[0].revents == 0) continue;
      const ssize_t got = ::recv(client, part.data(), part.size(), 0);
      open = got > 0;
      if (open) asked.append(part.data(), static_cast<size_t>(got));
      for (size_t size; open && (size = Front(asked, typed)) > 0; asked.erase(0, size)) {
        Cut cut = Cut::kBefore;
        const char type = typed ? asked[0] : '\0';
        const bool the_one = typed && IsTheOne(cut);
        typed = true;
        if (!the_one) ++passed_;
        const bool asks = type == 'Q' || type == 'S';
        if (asks) ++asked_;
        if (the_one && cut == Cut::kLate) {
          ::shutdown(client, SHUT_RDWR);
          AwaitOthers();
        }
        open = !(the_one && cut == Cut::kBefore) && Send(server, asked.data(), size);
        if (!the_one) continue;
        if (open && cut == Cut::kAnswer && asks) AwaitAnswer(server);
        open = false;
      }
    }
    ::close(client);
    ::close(server);
  }

  TempFolder folder_;
  std::string behind_, words_;
  int listener_ = -1;
  std::atomic<bool> stopping_{false}, refusing_{false}, hanging_{false};
  std::atomic<int> passed_{0};  // messages that went through
  std::atomic<int> asked_{0}, refused_{0};
  std::mutex mutex_;
  int left_ = kIdle;                      // messages to let pass; guarded by mutex_
  Cut cut_{};                             // guarded by mutex_
  std::vector<std::thread> connections_;  // the accepting thread's
  std::thread thread_;
};

}  // namespace enamel::test
