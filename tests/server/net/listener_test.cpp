#include "server/net/listener.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <boost/asio/post.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <future>
#include <mutex>
#include <thread>
#include <vector>

namespace enamel::server {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

// Sends its number when it begins, and ends when it is closed, or told to stop while it is idle.
class NumberedConnection : public AcceptedConnection,
                           public std::enable_shared_from_this<NumberedConnection> {
 public:
  NumberedConnection(tcp::socket socket, Strand strand, uint8_t number, std::string block)
      : socket_(std::move(socket)), strand_(strand), number_(number), block_(std::move(block)) {}

  void Run(std::function<void()> on_end) override {
    asio::post(strand_, [self = shared_from_this(), on_end = std::move(on_end)] {
      self->on_end_ = on_end;
      error_code ignored;
      asio::write(self->socket_, asio::buffer(&self->number_, 1), ignored);
    });
  }
  void BeginStop() override {
    asio::post(strand_, [self = shared_from_this()] {
      ++self->stops;
      if (!self->busy) self->End();
    });
  }
  void Close() override {
    asio::post(strand_, [self = shared_from_this()] { self->End(); });
  }
  GivesWay gives_way() const override { return when; }
  const std::string& block() const override { return block_; }

  std::atomic<GivesWay> when{GivesWay::kFirst};
  std::atomic<bool> busy{false};
  std::atomic<int> stops{0};

 private:
  void End() {
    error_code ignored;
    socket_.close(ignored);
    if (auto on_end = std::exchange(on_end_, nullptr)) on_end();
  }

  tcp::socket socket_;
  const Strand strand_;
  const uint8_t number_;
  const std::string block_;
  std::function<void()> on_end_;
};

class Peer {
 public:
  explicit Peer(uint16_t port) {
    socket_.connect({asio::ip::make_address("127.0.0.1"), port}, error_);
  }
  void Send(const std::string& bytes) {
    error_code ignored;
    asio::write(socket_, asio::buffer(bytes), ignored);
  }
  // What the server sends next; 0 when it ends the connection instead.
  int Read() {
    uint8_t byte = 0;
    error_code error;
    return asio::read(socket_, asio::buffer(&byte, 1), error) == 1 ? byte : 0;
  }
  bool connected() const { return !error_; }

 private:
  asio::io_context io_;
  error_code error_;
  tcp::socket socket_{io_};
};

class ListenerTest : public testing::Test {
 protected:
  static constexpr uint8_t kTurnedAway = 255;

  ~ListenerTest() override { StopAndJoin(); }

  // Connections count for `blocks` in turn.
  void Start(size_t max_connections, std::vector<std::string> blocks = {"a"},
             std::chrono::milliseconds stop = std::chrono::minutes(10)) {
    Start({"test", "127.0.0.1", 0, max_connections, stop}, std::move(blocks));
  }
  void Start(ListenerOptions options, std::vector<std::string> blocks = {"a"}) {
    blocks_ = std::move(blocks);
    listener_.emplace(
        io_, std::move(options),
        [this](tcp::socket socket, Strand strand, const std::string& peer) {
          std::lock_guard lock(mutex_);
          peers_.push_back(peer);
          size_t count = connections_.size();
          connections_.push_back(std::make_shared<NumberedConnection>(
              std::move(socket), strand, static_cast<uint8_t>(count + 1),
              blocks_[count % blocks_.size()]));
          return connections_.back();
        },
        [](tcp::socket socket, size_t) {
          error_code ignored;
          asio::write(socket, asio::buffer(&kTurnedAway, 1), ignored);
        });
    auto port = listener_->Start();
    ASSERT_TRUE(port.ok()) << port.status().message();
    port_ = *port;
    for (auto& thread : threads_) thread = std::thread([this] { io_.run(); });
  }

  void StopAndJoin() {
    if (listener_) listener_->Stop();
    for (auto& thread : threads_) {
      if (thread.joinable()) thread.join();
    }
  }

  NumberedConnection& At(size_t number) {
    std::lock_guard lock(mutex_);
    return *connections_.at(number - 1);
  }

  // Until those that have ended are forgotten.
  void WaitForOpen(size_t count) {
    while (listener_->open() != count) std::this_thread::yield();
  }

  asio::io_context io_;
  std::optional<Listener> listener_;
  uint16_t port_ = 0;
  std::array<std::thread, 2> threads_;
  std::vector<std::string> blocks_;
  std::mutex mutex_;
  std::vector<std::shared_ptr<NumberedConnection>> connections_;
  std::vector<std::string> peers_;
};

// As a proxy says it: a station at 192.0.2.`last` asked it.
std::string HeaderOf(uint8_t last) {
  const char bytes[] = {'\r', '\n', '\r', '\n', 0, '\r', '\n',   'Q', 'U', 'I',
                        'T',  '\n', 0x21, 0x11, 0, 12,   '\xC0', 0,   2,   static_cast<char>(last),
                        127,  0,    0,    1,    1, 2,    3,      4};
  return {bytes, sizeof bytes};
}

TEST_F(ListenerTest, OneTooManyClosesTheOldestOfTheAddressWithMost) {
  Start(3, {"a", "b", "b"});
  Peer first(port_), second(port_), third(port_);
  EXPECT_EQ(first.Read(), 1);
  EXPECT_EQ(second.Read(), 2);
  EXPECT_EQ(third.Read(), 3);
  Peer fourth(port_);
  EXPECT_EQ(fourth.Read(), 4);
  EXPECT_EQ(second.Read(), 0);
  WaitForOpen(3);
}

TEST_F(ListenerTest, WhoGivesWayAfterOthersIsClosedAfterThem) {
  Start(2);
  Peer first(port_), second(port_);
  EXPECT_EQ(first.Read(), 1);
  EXPECT_EQ(second.Read(), 2);
  At(1).when = GivesWay::kAfterOthers;
  Peer third(port_);
  EXPECT_EQ(third.Read(), 3);
  EXPECT_EQ(second.Read(), 0);
  WaitForOpen(2);
  At(3).when = GivesWay::kNever;
  Peer fourth(port_);
  EXPECT_EQ(fourth.Read(), 4);
  EXPECT_EQ(first.Read(), 0);
}

TEST_F(ListenerTest, WhenNoneGivesWayTheOneMoreIsTurnedAwayUntilAPlaceIsFree) {
  Start(1);
  Peer first(port_);
  EXPECT_EQ(first.Read(), 1);
  At(1).when = GivesWay::kNever;
  Peer second(port_);
  EXPECT_EQ(second.Read(), kTurnedAway);
  EXPECT_EQ(second.Read(), 0);
  At(1).Close();
  EXPECT_EQ(first.Read(), 0);
  WaitForOpen(0);
  Peer third(port_);
  EXPECT_EQ(third.Read(), 2);
}

TEST_F(ListenerTest, ForEachVisitsThoseThatHaveNotEnded) {
  Start(10);
  Peer first(port_), second(port_);
  EXPECT_EQ(first.Read(), 1);
  EXPECT_EQ(second.Read(), 2);
  At(1).Close();
  WaitForOpen(1);
  std::promise<const AcceptedConnection*> visited;  // a second visit would throw
  listener_->ForEach([&](AcceptedConnection& connection) { visited.set_value(&connection); });
  EXPECT_EQ(visited.get_future().get(), &At(2));
}

TEST_F(ListenerTest, StoppingClosesIdleConnectionsAtOnceAndRunsOutOfWork) {
  Start(10);
  Peer first(port_), second(port_);
  EXPECT_EQ(first.Read(), 1);
  EXPECT_EQ(second.Read(), 2);
  listener_->Stop();
  StopAndJoin();
  EXPECT_EQ(first.Read(), 0);
  EXPECT_EQ(second.Read(), 0);
  EXPECT_EQ(At(1).stops, 1) << "a second Stop changes nothing";
  EXPECT_FALSE(Peer(port_).connected());
}

TEST_F(ListenerTest, StoppingClosesWhatIsStillBusyAfterItsTime) {
  Start(10, {"a"}, std::chrono::milliseconds(50));
  Peer first(port_);
  EXPECT_EQ(first.Read(), 1);
  At(1).busy = true;
  StopAndJoin();
  EXPECT_EQ(At(1).stops, 1);
  EXPECT_EQ(first.Read(), 0);
}

TEST_F(ListenerTest, BehindAProxyThePeerIsWhomItNames) {
  Start({.name = "test", .address = "127.0.0.1", .proxies = {"127.0.0.1"}});
  Peer first(port_), second(port_);
  second.Send(HeaderOf(8));
  EXPECT_EQ(second.Read(), 1) << "nobody waits for the other";
  // In pieces, as a network may deliver it.
  const std::string header = HeaderOf(7);
  for (char byte : header) first.Send({byte});
  EXPECT_EQ(first.Read(), 2);
  std::lock_guard lock(mutex_);
  EXPECT_EQ(peers_, (std::vector<std::string>{"192.0.2.8", "192.0.2.7"}));
}

TEST_F(ListenerTest, TlsFromAProxysAddressComesFromSomebodyWithoutAName) {
  Start({.name = "test", .address = "127.0.0.1", .proxies = {"127.0.0.1"}});
  Peer peer(port_);
  peer.Send("\x16\x03\x01");
  EXPECT_EQ(peer.Read(), 1);
  std::lock_guard lock(mutex_);
  EXPECT_EQ(peers_, std::vector<std::string>{""});
}

TEST_F(ListenerTest, WhoIsNoProxyIsNotAskedForAHeader) {
  Start({.name = "test", .address = "127.0.0.1", .proxies = {"192.0.2.1"}});
  Peer peer(port_);
  EXPECT_EQ(peer.Read(), 1);
  std::lock_guard lock(mutex_);
  EXPECT_EQ(peers_, std::vector<std::string>{"127.0.0.1"});
}

TEST_F(ListenerTest, AProxyThatSaysSomethingElseIsClosed) {
  Start({.name = "test", .address = "127.0.0.1", .proxies = {"127.0.0.1"}});
  for (const std::string& bytes :
       {std::string("GET / HTTP/1.1\r\nHost: x\r\n\r\n"), std::string(4096, '\r'),
        HeaderOf(7).replace(13, 1, 1, '\x31')}) {
    Peer peer(port_);
    peer.Send(bytes);
    EXPECT_EQ(peer.Read(), 0);
  }
  WaitForOpen(0);
  EXPECT_TRUE(peers_.empty());
}

TEST_F(ListenerTest, AProxyThatSaysNothingIsClosedAfterItsTime) {
  Start({.name = "test",
         .address = "127.0.0.1",
         .proxies = {"127.0.0.1"},
         .introduction = std::chrono::milliseconds(20)});
  Peer silent(port_), half(port_);
  half.Send(HeaderOf(7).substr(0, 20));
  EXPECT_EQ(silent.Read(), 0);
  EXPECT_EQ(half.Read(), 0);
  WaitForOpen(0);
}

TEST_F(ListenerTest, WhoWasNotNamedYetGivesWayAndIsNotVisited) {
  Start({.name = "test", .address = "127.0.0.1", .max_connections = 1, .proxies = {"127.0.0.1"}});
  Peer first(port_);
  while (listener_->open() != 1) std::this_thread::yield();
  listener_->ForEach([](AcceptedConnection&) { FAIL() << "none is made yet"; });
  Peer second(port_);
  EXPECT_EQ(first.Read(), 0);
  second.Send(HeaderOf(7));
  EXPECT_EQ(second.Read(), 1);
  At(1).when = GivesWay::kNever;
  Peer third(port_);
  EXPECT_EQ(third.Read(), kTurnedAway);
}

TEST_F(ListenerTest, StoppingClosesWhomNobodyHasNamed) {
  Start({.name = "test", .address = "127.0.0.1", .proxies = {"127.0.0.1"}});
  Peer silent(port_);
  while (listener_->open() != 1) std::this_thread::yield();
  StopAndJoin();
  EXPECT_EQ(silent.Read(), 0);
}

TEST_F(ListenerTest, AProxysNameIsNoAddress) {
  ListenerOptions options{.name = "test", .address = "127.0.0.1", .proxies = {"127.0.0.01"}};
  EXPECT_EQ(Listener(io_, options, {}, {}).Start().status().field(), "proxies");
  options.proxies = {"proxy.example.edu"};
  EXPECT_EQ(Listener(io_, options, {}, {}).Start().status().field(), "proxies");
}

TEST_F(ListenerTest, PortInUseAndAddressThatIsNoneAreNamed) {
  Start(1);
  ListenerOptions options{.name = "second", .address = "127.0.0.1", .port = port_};
  Status in_use = Listener(io_, options, {}, {}).Start().status();
  EXPECT_EQ(in_use.code(), Code::kUnavailable);
  EXPECT_NE(in_use.message().find(":" + std::to_string(port_) + " in use"), std::string::npos);
  options.address = "localhost";
  EXPECT_EQ(Listener(io_, options, {}, {}).Start().status().field(), "address");
}

}  // namespace
}  // namespace enamel::server
