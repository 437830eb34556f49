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
    blocks_ = std::move(blocks);
    listener_.emplace(
        io_, ListenerOptions{"test", "127.0.0.1", 0, max_connections, stop},
        [this](tcp::socket socket, Strand strand) {
          std::lock_guard lock(mutex_);
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
};

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
