#include "server/stations/station_server.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <sqlite3.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/write.hpp>
#include <list>
#include <map>
#include <mutex>
#include <thread>

#include "common/base/log_request.h"
#include "common/net/certificate.h"
#include "common/net/frame_client.h"
#include "common/protocol/frame.h"
#include "server/stations/link_budget.h"
#include "tests/server/stations/link_world.h"
#include "tests/server/storage/all_chunks.h"

// Real bytes over TLS on loopback: deadlines, limits, shutdown.
namespace enamel::server::stations {
namespace {

using namespace testing;
using namespace std::chrono_literals;

// A school beside world_, whose stations use the same link.
class Neighbour final : public OtherSchools {
 public:
  Result<std::shared_ptr<Services>> ServicesOf(const wire::Request&) override {
    return std::shared_ptr<Services>();
  }
  std::vector<std::shared_ptr<Services>> All() override { return {services_}; }
  LinkWorld& world() { return world_; }

 private:
  LinkWorld world_;
  const std::shared_ptr<Services> services_{&world_.services, [](Services*) {}};
};

class StationServerTest : public ::testing::Test {
 protected:
  ~StationServerTest() override { StopAndJoin(); }

  void Start(LinkDeadlines deadlines = {}, size_t max_connections = 100,
             std::vector<std::string> proxies = {}) {
    auto identity = app::EnsureIdentity(world_.folder.path());
    ASSERT_TRUE(identity.ok()) << identity.status().message();
    fingerprint_ = identity->fingerprint;
    StationServerOptions options;
    options.port = 0;
    options.certificate = identity->certificate;
    options.private_key = identity->private_key;
    options.deadlines = deadlines;
    options.max_connections = max_connections;
    options.proxies = std::move(proxies);
    server_.emplace(io_, options, world_.services, pool_, &others_);
    auto port = server_->Start();
    ASSERT_TRUE(port.ok()) << port.status().message();
    at_ = {"127.0.0.1", *port};
    for (auto& thread : threads_) thread = std::thread([this] { io_.run(); });
  }

  void StopAndJoin() {
    if (server_) server_->Stop();
    for (auto& thread : threads_) {
      if (thread.joinable()) thread.join();
    }
  }

  void Connect(net::FrameClient& client) {
    Status status = client.Connect(at_, fingerprint_, 10s);
    ASSERT_TRUE(status.ok()) << status.message();
  }

  static wire::Reply Exchange(net::FrameClient& client, const wire::Request& request) {
    EXPECT_TRUE(client.Send(protocol::Serialize(request)).ok());
    return Receive(client);
  }

  static wire::Reply Receive(net::FrameClient& client) {
    auto frame = client.Receive(10s);
    EXPECT_TRUE(frame.ok()) << frame.status().message();
    if (!frame.ok()) return {};
    return *protocol::ParseReply(*frame);
  }

  // True when the server ends the connection.
  static bool Ends(net::FrameClient& client) {
    auto frame = client.Receive(10s);
    return !frame.ok() && !net::IsTimeout(frame.status());
  }

  void StartWithStudent() {
    Start();
    Connect(client_);
    ASSERT_TRUE(station_.Enrol().has_enrolled());
    Connect(client_);
    ASSERT_TRUE(station_.Hello().has_welcome());
    ASSERT_TRUE(station_.SignIn("student").has_signed_in());
  }

  LinkWorld world_;
  Neighbour others_;
  boost::asio::io_context io_;
  StorePool pool_{2};
  std::optional<StationServer> server_;
  std::array<std::thread, 2> threads_;
  Sha256 fingerprint_;
  net::Endpoint at_;
  net::FrameClient client_;
  ScriptedStation station_{
      [this](const wire::Request& request) { return Exchange(client_, request); }};
};

TEST_F(StationServerTest, AttemptIsUploadedOverTls) {
  StartWithStudent();
  auto ticket = station_.RequestTicket(world_.exercise.content, world_.Profile("omega3"));
  ASSERT_TRUE(ticket.has_ticket_issued()) << ticket.error().message();
  Recording recording(world_, TicketOf(ticket), station_.keys, 5);
  ASSERT_TRUE(station_.Open(recording.header).has_attempt_opened());

  // Without waiting for each: answers come in order.
  for (uint32_t seq = 0; seq < 5; ++seq) {
    wire::Request request;
    request.set_id(100 + seq);
    request.mutable_put_chunk()->set_chunk(protocol::ToField(recording.chunks[seq]));
    ASSERT_TRUE(client_.Send(protocol::Serialize(request)).ok());
  }
  for (uint32_t seq = 0; seq < 5; ++seq) {
    wire::Reply reply = Receive(client_);
    EXPECT_EQ(reply.reply_to(), 100 + seq);
    EXPECT_TRUE(reply.chunk_ack().committed()) << reply.error().message();
  }
  EXPECT_TRUE(station_.Seal(recording.seal).has_sealed());
  EXPECT_EQ(AllChunks(world_.store->recordings, recording.seal.attempt)->size(), 5u);
}

// What is logged, and of which attempt.
class Story final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  std::multimap<std::string, std::string> lines;  // by attempt

 protected:
  void sink_it_(const spdlog::details::log_msg& line) override {
    lines.emplace(LogAttempt::Current(), std::string(line.payload.data(), line.payload.size()));
  }
  void flush_() override {}
};

TEST_F(StationServerTest, EveryLineAboutARecordingNamesItsAttempt) {
  const auto story = std::make_shared<Story>();
  const auto before = spdlog::default_logger();
  spdlog::set_default_logger(std::make_shared<spdlog::logger>("story", story));
  StartWithStudent();
  std::vector<std::string> attempts;
  for (int i = 0; i < 2; ++i) {
    auto ticket = station_.RequestTicket(world_.exercise.content, world_.Profile("omega3"));
    Recording recording(world_, TicketOf(ticket), station_.keys, 2);
    attempts.push_back(recording.seal.attempt.Text());
    ASSERT_TRUE(station_.Open(recording.header).has_attempt_opened());
    EXPECT_EQ(station_.Put(recording.chunks[1]).error().code(), "conflict");
    for (const Bytes& chunk : recording.chunks) EXPECT_TRUE(station_.Put(chunk).has_chunk_ack());
    EXPECT_TRUE(station_.Seal(recording.seal).has_sealed());
  }
  StopAndJoin();
  spdlog::set_default_logger(before);
  for (const std::string& attempt : attempts) {
    std::string all;
    const auto [from, to] = story->lines.equal_range(attempt);
    for (auto at = from; at != to; ++at) all += at->second + "\n";
    for (const char* part :
         {"sends a recording from chunk 0 on", "conflict", "is whole: 2 chunks"}) {
      EXPECT_NE(all.find(part), std::string::npos) << part << " in\n" << all;
    }
  }
}

TEST_F(StationServerTest, OversizedFrameBeforeHelloIsNamedAndEndsTheConnection) {
  Start();
  Connect(client_);
  ASSERT_TRUE(client_.Send(Bytes(protocol::kMaxFrameBytesBeforeHello + 1, 0)).ok());
  EXPECT_EQ(Receive(client_).error().code(), "too_large");
  EXPECT_TRUE(Ends(client_));
}

TEST_F(StationServerTest, TroubleOfTheStoreIsToldWithoutThePathsInIt) {
  Start();
  sqlite3* handle = nullptr;
  ASSERT_EQ(sqlite3_open((world_.folder.path() / "enamel.db").c_str(), &handle), SQLITE_OK);
  ASSERT_EQ(
      sqlite3_exec(handle, "ALTER TABLE enrol_codes RENAME TO gone", nullptr, nullptr, nullptr),
      SQLITE_OK);
  sqlite3_close(handle);
  net::FrameClient client;
  Connect(client);
  ScriptedStation station([&](const wire::Request& request) { return Exchange(client, request); });
  wire::Error error = station.Enrol().error();
  EXPECT_EQ(error.code(), "internal");
  EXPECT_EQ(error.message().find("enamel.db"), std::string::npos) << error.message();
  EXPECT_EQ(error.message().find("/"), std::string::npos) << error.message();
}

TEST_F(StationServerTest, StationIsToldThatItsRequestStillWaitsWhileTheDatabaseHoldsIt) {
  LinkDeadlines deadlines;
  deadlines.still_waiting = 5ms;
  Start(deadlines);
  sqlite3* handle = nullptr;
  ASSERT_EQ(sqlite3_open((world_.folder.path() / "enamel.db").c_str(), &handle), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(handle, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  Connect(client_);
  int waiting = 0;
  ScriptedStation station([&](const wire::Request& request) {
    wire::Reply reply = Exchange(client_, request);
    for (; reply.has_still_waiting(); reply = Receive(client_)) {
      EXPECT_EQ(reply.reply_to(), request.id());
      if (++waiting == 2) sqlite3_close(handle);
    }
    return reply;
  });
  EXPECT_TRUE(station.Enrol().has_enrolled());
  EXPECT_GE(waiting, 2);
}

// A server may run on the proxy's machine, and is asked from there.
TEST_F(StationServerTest, FromAProxysAddressOnlyAnotherServerConnectsDirectly) {
  world_.services.measure = [] {
    wire::Measured out;
    out.set_timeline(7);
    return out;
  };
  Start({}, 100, {"127.0.0.1"});
  Connect(client_);
  wire::Request request;
  request.set_id(5);
  request.mutable_measure();
  const wire::Reply reply = Exchange(client_, request);
  EXPECT_EQ(reply.reply_to(), 5u);
  EXPECT_EQ(reply.measured().timeline(), 7);
  EXPECT_TRUE(Ends(client_));
  Connect(client_);
  request.mutable_hello();
  const wire::Error refused = Exchange(client_, request).error();
  EXPECT_EQ(refused.code(), "invalid_input");
  EXPECT_NE(refused.message().find("PROXY protocol"), std::string::npos) << refused.message();
  EXPECT_TRUE(Ends(client_));
}

TEST_F(StationServerTest, FrameThatIsNoMessageIsNamedAndEndsTheConnection) {
  Start();
  Connect(client_);
  ASSERT_TRUE(client_.Send(Bytes(10, 0xff)).ok());
  EXPECT_EQ(Receive(client_).error().code(), "invalid_input");
  EXPECT_TRUE(Ends(client_));
}

TEST_F(StationServerTest, SilentConnectionIsEndedAtItsDeadline) {
  LinkDeadlines deadlines;
  deadlines.introduction = 200ms;
  Start(deadlines);
  Connect(client_);
  EXPECT_TRUE(Ends(client_));
}

TEST_F(StationServerTest, ConnectionThatNeverShakesHandsIsEndedAtItsDeadline) {
  LinkDeadlines deadlines;
  deadlines.introduction = 200ms;
  Start(deadlines);
  boost::asio::io_context io;
  boost::asio::ip::tcp::socket socket(io);
  socket.connect({boost::asio::ip::make_address("127.0.0.1"), at_.port});
  uint8_t byte = 0;
  boost::system::error_code error;
  EXPECT_EQ(socket.read_some(boost::asio::buffer(&byte, 1), error), 0u);
  EXPECT_TRUE(error);
}

TEST_F(StationServerTest, StoppingTellsIdleStationsAndRunsOutOfWork) {
  Start();
  Connect(client_);
  ASSERT_TRUE(station_.Enrol().has_enrolled());
  Connect(client_);
  ASSERT_TRUE(station_.Hello().has_welcome());
  server_->Stop();
  EXPECT_EQ(Receive(client_).error().code(), "unavailable");
  client_.Close();
  StopAndJoin();
  EXPECT_FALSE(client_.Connect(at_, fingerprint_, 2s).ok());
}

// TLS by hand, for bytes that a FrameClient would never send.
class RawPeer {
 public:
  explicit RawPeer(uint16_t port) {
    socket_.next_layer().connect({boost::asio::ip::make_address("127.0.0.1"), port});
    socket_.handshake(boost::asio::ssl::stream_base::client);
  }
  bool Send(ByteView bytes) {
    boost::system::error_code error;
    boost::asio::write(socket_, boost::asio::buffer(bytes.data(), bytes.size()), error);
    return !error;
  }
  // The answer to a request; empty: the server has ended the connection.
  wire::Reply Ask(const wire::Request& request) {
    EXPECT_TRUE(Send(*protocol::EncodeFrame(protocol::Serialize(request))));
    return Read();
  }
  wire::Reply Read() {
    protocol::FrameReader reader;
    boost::system::error_code error;
    while (!reader.done()) {
      const std::span<uint8_t> space = reader.Prepare();
      const size_t n = socket_.read_some(boost::asio::buffer(space.data(), space.size()), error);
      if (error || !reader.Resume(n).ok()) return {};
    }
    return *protocol::ParseReply(reader.Take());
  }
  int fd() { return socket_.next_layer().native_handle(); }
  // Closes without reading the answers: the system answers the rest with a reset.
  void Vanish() {
    boost::system::error_code ignored;
    socket_.next_layer().set_option(boost::asio::socket_base::linger(true, 0), ignored);
    socket_.next_layer().close(ignored);
  }

 private:
  boost::asio::io_context io_;
  boost::asio::ssl::context tls_{boost::asio::ssl::context::tls_client};
  boost::asio::ssl::stream<boost::asio::ip::tcp::socket> socket_{io_, tls_};
};

TEST_F(StationServerTest, PeersThatNeverSayWhoTheyAreDoNotTakeTheLinkFromStations) {
  Start({}, 3);
  Connect(client_);
  ASSERT_TRUE(station_.Enrol().has_enrolled());
  std::list<boost::asio::ip::tcp::socket> silent;
  auto hold = [&] {
    auto& socket = silent.emplace_back(io_);
    socket.connect({boost::asio::ip::make_address("127.0.0.1"), at_.port});
  };
  for (int i = 0; i < 6; ++i) hold();
  Connect(client_);
  ASSERT_TRUE(station_.Hello().has_welcome());
  for (int i = 0; i < 6; ++i) hold();
  EXPECT_TRUE(station_.SignIn("student").has_signed_in()) << "a station that is in stays";
}

TEST_F(StationServerTest, StationThatIsRevokedWhileItSaysNothingIsToldAndItsConnectionEnds) {
  Start();
  Connect(client_);
  ASSERT_TRUE(station_.Enrol().has_enrolled());
  Connect(client_);
  ASSERT_TRUE(station_.Hello().has_welcome());
  net::FrameClient other;
  ScriptedStation neighbour{[&](const wire::Request& request) { return Exchange(other, request); }};
  Connect(other);
  ASSERT_TRUE(
      world_.store->stations.AddEnrolCode(HashSha256(AsBytes("second")), UnixMs{1} << 60, kSystem)
          .ok());
  ASSERT_TRUE(neighbour.Enrol("second").has_enrolled());
  Connect(other);
  ASSERT_TRUE(neighbour.Hello().has_welcome());
  auto id = protocol::ReadUuid(station_.id, "id");
  ASSERT_TRUE(world_.store->stations.RevokeStation(*id, kSystem).ok());
  EXPECT_NE(Receive(client_).error().message().find("no longer admitted"), std::string::npos);
  EXPECT_TRUE(Ends(client_));
  EXPECT_TRUE(neighbour.SignIn("student").has_signed_in());
}

TEST_F(StationServerTest, AStationThatAnotherSchoolRevokedStays) {
  Start();
  Connect(client_);
  ASSERT_TRUE(station_.Enrol().has_enrolled());
  Connect(client_);
  ASSERT_TRUE(station_.Hello().has_welcome());
  net::FrameClient second;
  ScriptedStation own{[&](const wire::Request& request) { return Exchange(second, request); }};
  Connect(second);
  ASSERT_TRUE(
      world_.store->stations.AddEnrolCode(HashSha256(AsBytes("second")), UnixMs{1} << 60, kSystem)
          .ok());
  ASSERT_TRUE(own.Enrol("second").has_enrolled());
  Connect(second);
  ASSERT_TRUE(own.Hello().has_welcome());
  // A station may be enrolled under the id that it has elsewhere.
  const Uuid id = *protocol::ReadUuid(station_.id, "id");
  Store& theirs = *others_.world().store;
  const Sha256 code = HashSha256(AsBytes("code"));
  StationRow row;
  row.id = id;
  row.name = "copy";
  row.public_key.assign(station_.keys.public_key.begin(), station_.keys.public_key.end());
  const auto copy = theirs.stations.EnrolStation(code, row, code, 0);
  ASSERT_TRUE(copy.ok()) << copy.status().message();
  ASSERT_EQ(copy->id, id);
  ASSERT_TRUE(theirs.stations.RevokeStation(id, kSystem).ok());
  // Told at the same look as whoever the other school revoked.
  ASSERT_TRUE(
      world_.store->stations.RevokeStation(*protocol::ReadUuid(own.id, "id"), kSystem).ok());
  EXPECT_NE(Receive(second).error().message().find("no longer admitted"), std::string::npos);
  EXPECT_TRUE(Ends(second));
  EXPECT_TRUE(station_.SignIn("student").has_signed_in());
}

TEST_F(StationServerTest, AStationHasFewConnectionsAndTheOldestGivesWay) {
  StartWithStudent();
  std::list<net::FrameClient> links;
  for (int i = 0; i < ops::Budgets{}.station_links; ++i) {
    net::FrameClient& link = links.emplace_back();
    Connect(link);
    ScriptedStation again{[&](const wire::Request& request) { return Exchange(link, request); }};
    again.id = station_.id;
    again.credential = station_.credential;
    ASSERT_TRUE(again.Hello().has_welcome());
  }
  const wire::Error refused = Receive(client_).error();
  EXPECT_EQ(refused.field(), "station_links");
  EXPECT_NE(refused.message().find("(budget station_links: 8)"), std::string::npos);
  EXPECT_TRUE(Ends(client_));
}

TEST_F(StationServerTest, FramesThatHaveOnlyBegunCostTheirOwnStation) {
  Start();
  Connect(client_);
  ASSERT_TRUE(station_.Enrol().has_enrolled());
  ASSERT_TRUE(
      world_.store->stations.AddEnrolCode(HashSha256(AsBytes("second")), UnixMs{1} << 60, kSystem)
          .ok());
  Connect(client_);
  ScriptedStation other{[&](const wire::Request& request) { return Exchange(client_, request); }};
  ASSERT_TRUE(other.Enrol("second").has_enrolled());
  const Bytes head{0, 0, 64, 0};  // of a frame of kMaxFrameBytes
  const auto begin = [&](RawPeer& peer, const ScriptedStation& as) {
    ScriptedStation on{[&](const wire::Request& request) { return peer.Ask(request); }};
    on.id = as.id;
    on.credential = as.credential;
    ASSERT_TRUE(on.Hello().has_welcome());
    ASSERT_TRUE(peer.Send(head));
  };
  static_assert(ops::Budgets{}.station_links * (protocol::kMaxFrameBytes >> 20) ==
                ops::Budgets{}.station_frames_mib);
  std::list<RawPeer> stolen;
  std::vector<pollfd> ends;
  for (int i = 0; i < ops::Budgets{}.station_links; ++i) {
    begin(stolen.emplace_back(at_.port), station_);
    ends.push_back({stolen.back().fd(), POLLIN, 0});
  }
  RawPeer honest(at_.port);
  begin(honest, other);
  // The oldest for the other's, or the last where the other's came first.
  ASSERT_EQ(::poll(ends.data(), ends.size(), 10'000), 1);
  size_t i = 0;
  for (RawPeer& peer : stolen) {
    if (ends[i++].revents != 0) EXPECT_EQ(peer.Read().error().field(), "station_frames_mib");
  }
  ASSERT_TRUE(honest.Send(Bytes(protocol::kMaxFrameBytes, 0)));
  EXPECT_EQ(honest.Read().error().code(), "invalid_input") << "its frame was taken whole";
}

TEST_F(StationServerTest, FrameThatDripsIsEndedAtItsDeadlineAndOthersGoOn) {
  LinkDeadlines deadlines;
  deadlines.introduction = 400ms;
  Start(deadlines);
  Connect(client_);
  ASSERT_TRUE(station_.Enrol().has_enrolled());
  Connect(client_);
  ASSERT_TRUE(station_.Hello().has_welcome());
  RawPeer dripping(at_.port);
  ASSERT_TRUE(dripping.Send(Bytes{200, 0, 0, 0}));
  // A byte now and then does not extend the time.
  int sent = 0;
  while (sent < 196 && dripping.Send(Bytes{0})) {
    std::this_thread::sleep_for(50ms);
    ++sent;
  }
  EXPECT_LT(sent, 196);
  wire::Request ping;
  ping.mutable_ping()->set_nonce(5);
  EXPECT_EQ(station_.Send(ping).pong().nonce(), 5u);
}

TEST_F(StationServerTest, PeersThatVanishBeforeTheirAnswerHarmNobody) {
  Start();
  wire::Request request;
  request.set_id(1);
  request.mutable_enrol()->set_code("guess");
  Bytes frame = *protocol::EncodeFrame(protocol::Serialize(request));
  for (int i = 0; i < 20; ++i) {
    RawPeer peer(at_.port);
    peer.Send(frame);
    peer.Vanish();
  }
  Connect(client_);
  EXPECT_TRUE(station_.Enrol().has_enrolled());
}

TEST_F(StationServerTest, PingsWithoutAnEndLeaveRoomForOthers) {
  Start();
  Connect(client_);
  ASSERT_TRUE(station_.Enrol().has_enrolled());
  Connect(client_);
  ASSERT_TRUE(station_.Hello().has_welcome());
  for (int i = 0; i < 200; ++i) {
    wire::Request ping;
    ping.set_id(static_cast<uint32_t>(i + 1));
    ping.mutable_ping()->set_nonce(static_cast<uint64_t>(i));
    ASSERT_TRUE(client_.Send(protocol::Serialize(ping)).ok());
  }
  for (uint64_t i = 0; i < 200; ++i) EXPECT_EQ(Receive(client_).pong().nonce(), i);
}

TEST_F(StationServerTest, PortInUseIsNamed) {
  Start();
  StationServerOptions options;
  options.port = at_.port;
  options.certificate = world_.folder.path() / "station.crt";
  options.private_key = world_.folder.path() / "station.key";
  StationServer second(io_, options, world_.services, pool_);
  auto refused = second.Start();
  EXPECT_EQ(refused.status().code(), Code::kUnavailable);
  EXPECT_NE(refused.status().message().find("another"), std::string::npos)
      << refused.status().message();
}

TEST_F(StationServerTest, StationWithAnotherFingerprintRefusesTheServer) {
  Start();
  EXPECT_EQ(client_.Connect(at_, HashSha256(AsBytes("another")), 10s).code(),
            Code::kUnauthenticated);
}

}  // namespace
}  // namespace enamel::server::stations
