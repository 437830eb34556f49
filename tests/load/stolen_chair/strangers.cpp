#include "tests/load/stolen_chair/strangers.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdlib>
#include <string_view>
#include <vector>

namespace enamel::load {
namespace {

constexpr size_t kBodyBytes = size_t{1} << 20;
constexpr timeval kPatience{20, 0};

sockaddr_in AddressOf(const net::Endpoint& page) {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_port = htons(page.port);
  ::inet_pton(AF_INET, page.host.c_str(), &out.sin_addr);
  return out;
}

// The first line, and the message of a refusal.
std::string Gist(std::string_view answer) {
  std::string out(answer.substr(0, answer.find('\r')));
  constexpr std::string_view kMessage = "\"message\":\"";
  const size_t at = answer.find(kMessage);
  if (at == std::string_view::npos) return out;
  answer.remove_prefix(at + kMessage.size());
  return out + " " + std::string(answer.substr(0, answer.find('"')));
}

}  // namespace

void GiveWay() {
  constexpr int kNice = 19;
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::syscall(SYS_gettid)), kNice);
}

void Strangers::Begin() {
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

void Strangers::Stop() {
  thread_ = {};  // asks it to stop and waits
}

void Strangers::Run(const std::stop_token& stop) {
  GiveWay();
  const sockaddr_in address = AddressOf(page_);
  // Another address than everybody else's here.
  const sockaddr_in from = AddressOf({"127.0.0.2", 0});
  std::string request =
      "POST /api/v1/session HTTP/1.1\r\nHost: " + page_.Text() +
      "\r\nContent-Type: application/json\r\nContent-Length: " + std::to_string(kBodyBytes) +
      "\r\n\r\n";
  request.resize(request.size() + kBodyBytes - 1, ' ');
  struct Peer {
    int fd = -1;
    size_t sent = 0;
  };
  std::vector<Peer> peers(count_);
  std::vector<pollfd> polled;
  std::vector<size_t> who;
  while (!stop.stop_requested()) {
    polled.clear();
    who.clear();
    for (size_t i = 0; i < peers.size(); ++i) {
      Peer& peer = peers[i];
      if (peer.fd < 0) {
        peer = {::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0), 0};
        (void)::bind(peer.fd, reinterpret_cast<const sockaddr*>(&from), sizeof from);
        (void)::connect(peer.fd, reinterpret_cast<const sockaddr*>(&address), sizeof address);
        ++opened_;
      }
      const short wanted = peer.sent < request.size() ? POLLIN | POLLOUT : POLLIN;
      polled.push_back({peer.fd, wanted, 0});
      who.push_back(i);
    }
    ::poll(polled.data(), polled.size(), 20);
    for (size_t i = 0; i < polled.size(); ++i) {
      Peer& peer = peers[who[i]];
      if ((polled[i].revents & POLLOUT) != 0) {
        const ssize_t n = ::send(peer.fd, request.data() + peer.sent, request.size() - peer.sent,
                                 MSG_NOSIGNAL | MSG_DONTWAIT);
        if (n > 0) peer.sent += static_cast<size_t>(n);
      }
      if ((polled[i].revents & (POLLIN | POLLHUP | POLLERR)) == 0) continue;
      char buffer[4096];
      const ssize_t n = ::recv(peer.fd, buffer, sizeof buffer, MSG_DONTWAIT);
      if (n > 0) {
        ++answers_[Gist({buffer, static_cast<size_t>(n)})];
      } else {
        ++answers_["closed"];
      }
      ::close(peer.fd);
      peer.fd = -1;
    }
  }
  for (const Peer& peer : peers) ::close(peer.fd);
}

Opened OpenStream(const net::Endpoint& page, const std::string& path, const std::string& cookie) {
  Opened out;
  out.fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  ::setsockopt(out.fd, SOL_SOCKET, SO_RCVTIMEO, &kPatience, sizeof kPatience);
  const sockaddr_in address = AddressOf(page);
  const std::string request =
      "GET " + path + " HTTP/1.1\r\nHost: " + page.Text() + "\r\nCookie: " + cookie + "\r\n\r\n";
  char buffer[4096];
  ssize_t n = -1;
  if (::connect(out.fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      ::send(out.fd, request.data(), request.size(), MSG_NOSIGNAL) > 0) {
    n = ::recv(out.fd, buffer, sizeof buffer, 0);
  }
  const std::string_view answer(buffer, n > 0 ? static_cast<size_t>(n) : 0);
  constexpr std::string_view kVersion = "HTTP/1.1 ";
  if (answer.starts_with(kVersion))
    out.status = std::atoi(std::string(answer.substr(kVersion.size(), 3)).c_str());
  out.text = Gist(answer);
  if (out.status == 200) return out;
  ::close(out.fd);
  out.fd = -1;
  return out;
}

}  // namespace enamel::load
