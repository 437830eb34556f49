#include "tests/load/viewers.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <string_view>

namespace enamel::load {
namespace {

constexpr std::string_view kEvent = "\ndata:";
constexpr int kSmallBuffer = 4096;

}  // namespace

Viewers::Viewers(net::Endpoint page, const School& school, std::vector<Uuid> attempts, size_t count,
                 size_t slow)
    : page_(std::move(page)),
      school_(school),
      attempts_(std::move(attempts)),
      count_(count),
      slow_(slow),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

void Viewers::Stop() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

int Viewers::Watch(const Uuid& attempt, const std::string& cookie, bool slow) {
  int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (slow) ::setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &kSmallBuffer, sizeof kSmallBuffer);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(page_.port);
  ::inet_pton(AF_INET, page_.host.c_str(), &address.sin_addr);
  std::string request = "GET /api/v1/attempts/" + attempt.Text() +
                        "/live HTTP/1.1\r\nHost: " + page_.Text() + "\r\nCookie: " + cookie +
                        "\r\n\r\n";
  if (::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
      ::send(fd, request.data(), request.size(), MSG_NOSIGNAL) < 0) {
    problem_ = "a viewer cannot connect to " + page_.Text();
  }
  return fd;
}

void Viewers::Run(const std::stop_token& stop) {
  HttpClient client(page_);
  if (Status status = client.SignIn(school_.instructor_login, school_.password); !status.ok()) {
    problem_ = status.message();
    return;
  }
  std::vector<int> sockets, ignored;
  for (size_t i = 0; i < count_; ++i) {
    sockets.push_back(Watch(attempts_[i % attempts_.size()], client.cookie(), false));
  }
  for (size_t i = 0; i < slow_; ++i) {
    ignored.push_back(Watch(attempts_[i % attempts_.size()], client.cookie(), true));
  }
  ReadAll(sockets, stop);
  for (int fd : sockets) ::close(fd);
  for (int fd : ignored) ::close(fd);
}

void Viewers::ReadAll(std::vector<int>& sockets, const std::stop_token& stop) {
  std::vector<char> buffer(1 << 16);
  std::vector<bool> answered(sockets.size(), false);
  while (!stop.stop_requested()) {
    std::vector<pollfd> polled;
    for (int fd : sockets) polled.push_back({fd, POLLIN, 0});
    ::poll(polled.data(), polled.size(), 100);
    for (size_t i = 0; i < polled.size(); ++i) {
      if ((polled[i].revents & (POLLIN | POLLHUP | POLLERR)) == 0) continue;
      ssize_t n = ::recv(sockets[i], buffer.data(), buffer.size(), MSG_DONTWAIT);
      std::string_view text(buffer.data(), n > 0 ? static_cast<size_t>(n) : 0);
      if (!answered[i] && !text.starts_with("HTTP/1.1 200")) {
        problem_ = "a viewer was not let in: " + std::string(text.substr(0, 300));
      }
      answered[i] = true;
      if (n <= 0) {
        if (problem_.empty()) problem_ = "the server ended a viewer's stream";
        ::close(sockets[i]);
        sockets.erase(sockets.begin() + static_cast<long>(i));
        answered.erase(answered.begin() + static_cast<long>(i));
        break;
      }
      bytes_ += text.size();
      for (size_t at = 0; (at = text.find(kEvent, at)) != std::string_view::npos; ++at) ++events_;
    }
  }
}

}  // namespace enamel::load
