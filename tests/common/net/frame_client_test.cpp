#include "common/net/frame_client.h"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/asio/write.hpp>
#include <functional>
#include <mutex>
#include <thread>

#include "common/base/file.h"
#include "common/net/certificate.h"
#include "common/net/tls.h"
#include "common/protocol/frame.h"
#include "tests/support/read_message.h"
#include "tests/support/temp_folder.h"

namespace enamel::net {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using std::chrono::milliseconds;
using std::chrono::seconds;
using Stream = asio::ssl::stream<tcp::socket>;

constexpr auto kSoon = seconds(20);  // never waited for when all is well

// A scripted server on loopback: accepts one connection after the other on its own thread and runs
// the script on each, blocking.
class ScriptedServer {
 public:
  ScriptedServer(std::shared_ptr<SSL_CTX> context, std::function<void(Stream&)> script)
      : context_(std::move(context)),
        acceptor_(io_, tcp::endpoint(asio::ip::address_v4::loopback(), 0)),
        port_(acceptor_.local_endpoint().port()),
        thread_([this, script] { Run(script); }) {}

  ~ScriptedServer() {
    stopping_ = true;
    {
      std::lock_guard lock(mutex_);
      if (connection_ >= 0) ::shutdown(connection_, SHUT_RDWR);
    }
    tcp::socket wake(io_);
    boost::system::error_code ignored;
    wake.connect(tcp::endpoint(asio::ip::address_v4::loopback(), port_), ignored);
    thread_.join();
  }

  Endpoint endpoint() const { return {"127.0.0.1", port_}; }

 private:
  void Run(const std::function<void(Stream&)>& script) {
    while (!stopping_) {
      tcp::socket socket = acceptor_.accept();
      if (stopping_) return;
      Stream stream(std::move(socket), SSL_new(context_.get()));
      SetConnection(stream.next_layer().native_handle());
      try {
        stream.handshake(Stream::server);
        script(stream);
      } catch (const boost::system::system_error&) {
        // The client went away, or the test is over.
      }
      SetConnection(-1);
    }
  }

  void SetConnection(int fd) {
    std::lock_guard lock(mutex_);
    connection_ = fd;
    if (stopping_ && fd >= 0) ::shutdown(fd, SHUT_RDWR);
  }

  asio::io_context io_;
  std::shared_ptr<SSL_CTX> context_;
  tcp::acceptor acceptor_;
  uint16_t port_;
  std::atomic<bool> stopping_{false};
  std::mutex mutex_;
  int connection_ = -1;  // guarded by mutex_
  std::thread thread_;
};

using test::ReadMessage;

void WriteMessage(Stream& stream, ByteView message) {
  asio::write(stream, asio::buffer(*protocol::EncodeFrame(message)));
}

void Echo(Stream& stream) {
  for (;;) WriteMessage(stream, ReadMessage(stream));
}

// Holds the connection until the client ends it.
void Hold(Stream& stream) {
  uint8_t byte;
  stream.read_some(asio::buffer(&byte, 1));
}

class FrameClientTest : public testing::Test {
 protected:
  FrameClientTest() {
    auto pem = folder_ / "c.pem", key = folder_ / "k.pem";
    ENAMEL_CHECK(CreateCertificateFiles(pem, key, "enamel-test").ok());
    context_ = *MakeServerContext(pem, key);
    fingerprint_ = *CertificateFingerprint(*ReadFile(pem));
  }

  test::TempFolder temp_;
  const std::filesystem::path folder_ = temp_.path();
  std::shared_ptr<SSL_CTX> context_;
  Sha256 fingerprint_;
  FrameClient client_;
};

TEST_F(FrameClientTest, CarriesMessagesOfAllSizesBothWays) {
  ScriptedServer server(context_, Echo);
  ASSERT_TRUE(client_.Connect(server.endpoint(), fingerprint_, kSoon).ok());
  for (size_t size :
       {size_t{0}, size_t{1}, size_t{65536}, size_t{1000003}, protocol::kMaxFrameBytes}) {
    Bytes message(size);
    for (size_t i = 0; i < size; ++i) message[i] = static_cast<uint8_t>(i * 7);
    ASSERT_TRUE(client_.Send(message, kSoon).ok()) << size;
    auto back = client_.Receive(kSoon);
    ASSERT_TRUE(back.ok()) << back.status().message();
    EXPECT_EQ(*back, message) << size;
  }
}

TEST_F(FrameClientTest, KeepsTheOrderOfManyMessagesSentAtOnce) {
  ScriptedServer server(context_, Echo);
  ASSERT_TRUE(client_.Connect(server.endpoint(), fingerprint_, kSoon).ok());
  for (uint8_t i = 0; i < 100; ++i) ASSERT_TRUE(client_.Send(Bytes(i, i), kSoon).ok());
  for (uint8_t i = 0; i < 100; ++i) EXPECT_EQ(*client_.Receive(kSoon), Bytes(i, i));
}

TEST_F(FrameClientTest, RefusedConnectionSaysWhatToLookAt) {
  asio::io_context io;
  uint16_t port = 0;
  {
    tcp::acceptor taken(io, tcp::endpoint(asio::ip::address_v4::loopback(), 0));
    port = taken.local_endpoint().port();
  }
  Status status = client_.Connect({"127.0.0.1", port}, fingerprint_, kSoon);
  EXPECT_EQ(status.code(), Code::kUnavailable);
  EXPECT_FALSE(IsTimeout(status));
  EXPECT_NE(status.message().find("enamel-server"), std::string::npos) << status.message();
  EXPECT_FALSE(client_.connected());
}

TEST_F(FrameClientTest, OtherCertificateIsRefusedWithBothFingerprints) {
  ScriptedServer server(context_, Echo);
  Sha256 other = HashSha256(AsBytes("another server"));
  Status status = client_.Connect(server.endpoint(), other, kSoon);
  EXPECT_EQ(status.code(), Code::kUnauthenticated);
  EXPECT_NE(status.message().find(other.Hex()), std::string::npos) << status.message();
  EXPECT_NE(status.message().find(fingerprint_.Hex()), std::string::npos) << status.message();
  EXPECT_FALSE(client_.connected());
}

TEST_F(FrameClientTest, ServerWithoutTls13IsRefusedAsAVersion) {
  auto old = std::make_shared<asio::ssl::context>(asio::ssl::context::tls_server);
  old->use_certificate_chain_file((folder_ / "c.pem").string());
  old->use_private_key_file((folder_ / "k.pem").string(), asio::ssl::context::pem);
  SSL_CTX_set_max_proto_version(old->native_handle(), TLS1_2_VERSION);
  ScriptedServer server(std::shared_ptr<SSL_CTX>(old, old->native_handle()), Echo);
  EXPECT_EQ(client_.Connect(server.endpoint(), fingerprint_, kSoon).code(), Code::kVersion);
}

TEST_F(FrameClientTest, ServerThatNeverAnswersIsATimeout) {
  // Connections wait in the queue of a socket that nobody accepts from.
  asio::io_context io;
  tcp::acceptor silent(io, tcp::endpoint(asio::ip::address_v4::loopback(), 0));
  Status status = client_.Connect({"127.0.0.1", silent.local_endpoint().port()}, fingerprint_,
                                  milliseconds(50));
  EXPECT_TRUE(IsTimeout(status)) << status.message();
  EXPECT_FALSE(client_.connected());
}

TEST_F(FrameClientTest, TimeoutInTheMiddleOfAMessageLosesNothing) {
  Bytes message(1000, 0x42);
  ScriptedServer server(context_, [&](Stream& stream) {
    Bytes frame = *protocol::EncodeFrame(message);
    asio::write(stream, asio::buffer(frame.data(), 500));
    ReadMessage(stream);  // The client says when it has waited in vain.
    asio::write(stream, asio::buffer(frame.data() + 500, frame.size() - 500));
    Hold(stream);
  });
  ASSERT_TRUE(client_.Connect(server.endpoint(), fingerprint_, kSoon).ok());
  auto nothing = client_.Receive(milliseconds(20));
  ASSERT_FALSE(nothing.ok());
  EXPECT_TRUE(IsTimeout(nothing.status()));
  EXPECT_TRUE(client_.connected());
  ASSERT_TRUE(client_.Send(AsBytes("go on"), kSoon).ok());
  auto whole = client_.Receive(kSoon);
  ASSERT_TRUE(whole.ok()) << whole.status().message();
  EXPECT_EQ(*whole, message);
}

TEST_F(FrameClientTest, ReceiveWithoutWaitingTellsNothingHere) {
  ScriptedServer server(context_, Hold);
  ASSERT_TRUE(client_.Connect(server.endpoint(), fingerprint_, kSoon).ok());
  EXPECT_TRUE(IsTimeout(client_.Receive(milliseconds(0)).status()));
  EXPECT_TRUE(client_.connected());
}

TEST_F(FrameClientTest, ServerThatClosesIsNoticed) {
  ScriptedServer server(context_, [](Stream& stream) { ReadMessage(stream); });
  ASSERT_TRUE(client_.Connect(server.endpoint(), fingerprint_, kSoon).ok());
  ASSERT_TRUE(client_.Send(AsBytes("bye"), kSoon).ok());
  auto gone = client_.Receive(kSoon);
  EXPECT_EQ(gone.status().code(), Code::kUnavailable);
  EXPECT_FALSE(IsTimeout(gone.status()));
  EXPECT_FALSE(client_.connected());
  EXPECT_EQ(client_.Send(AsBytes("more"), kSoon).code(), Code::kUnavailable);
}

TEST_F(FrameClientTest, PeerThatDoesNotReadIsASendTimeout) {
  std::atomic<bool> over{false};
  ScriptedServer server(context_, [&](Stream&) { over.wait(false); });
  ASSERT_TRUE(client_.Connect(server.endpoint(), fingerprint_, kSoon).ok());
  Bytes message(protocol::kMaxFrameBytes);
  Status status;
  for (int i = 0; i < 64 && status.ok(); ++i) status = client_.Send(message, milliseconds(200));
  EXPECT_TRUE(IsTimeout(status)) << status.message();
  EXPECT_FALSE(client_.connected());
  over = true;
  over.notify_all();
}

TEST_F(FrameClientTest, FrameOverTheLimitFromTheServerEndsTheConnection) {
  ScriptedServer server(context_, [](Stream& stream) {
    ByteWriter length;
    length.U32(protocol::kMaxFrameBytes + 1);
    asio::write(stream, asio::buffer(length.bytes()));
    Hold(stream);
  });
  ASSERT_TRUE(client_.Connect(server.endpoint(), fingerprint_, kSoon).ok());
  EXPECT_EQ(client_.Receive(kSoon).status().code(), Code::kTooLarge);
  EXPECT_FALSE(client_.connected());
}

TEST_F(FrameClientTest, FrameOverTheLimitThatArrivesDuringASendIsRefusedByTheNextReceive) {
  ScriptedServer server(context_, [](Stream& stream) {
    ReadMessage(stream);
    ByteWriter length;
    length.U32(protocol::kMaxFrameBytes + 1);
    asio::write(stream, asio::buffer(length.bytes()));
    ReadMessage(stream);
    Hold(stream);
  });
  ASSERT_TRUE(client_.Connect(server.endpoint(), fingerprint_, kSoon).ok());
  EXPECT_TRUE(IsTimeout(client_.Receive(milliseconds(0)).status()));
  ASSERT_TRUE(client_.Send(AsBytes("first"), kSoon).ok());
  ASSERT_TRUE(client_.Send(Bytes(protocol::kMaxFrameBytes), kSoon).ok());
  EXPECT_EQ(client_.Receive(kSoon).status().code(), Code::kTooLarge);
}

TEST_F(FrameClientTest, MessageOverTheLimitIsNotSentAndTheConnectionStays) {
  ScriptedServer server(context_, Echo);
  ASSERT_TRUE(client_.Connect(server.endpoint(), fingerprint_, kSoon).ok());
  EXPECT_EQ(client_.Send(Bytes(protocol::kMaxFrameBytes + 1), kSoon).code(), Code::kTooLarge);
  ASSERT_TRUE(client_.Send(AsBytes("still here"), kSoon).ok());
  EXPECT_TRUE(client_.Receive(kSoon).ok());
}

TEST_F(FrameClientTest, ConnectsAgainAfterClose) {
  ScriptedServer server(context_, Echo);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(client_.Connect(server.endpoint(), fingerprint_, kSoon).ok());
    ASSERT_TRUE(client_.Send(AsBytes("x"), kSoon).ok());
    EXPECT_TRUE(client_.Receive(kSoon).ok());
    client_.Close();
    client_.Close();
    EXPECT_FALSE(client_.connected());
  }
}

TEST_F(FrameClientTest, CloseIsACleanEndForTheServer) {
  std::atomic<int> result{0};
  ScriptedServer server(context_, [&](Stream& stream) {
    uint8_t byte;
    boost::system::error_code error;
    stream.read_some(asio::buffer(&byte, 1), error);
    result = error == asio::error::eof ? 1 : 2;
    result.notify_all();
  });
  ASSERT_TRUE(client_.Connect(server.endpoint(), fingerprint_, kSoon).ok());
  client_.Close();
  result.wait(0);
  EXPECT_EQ(result, 1);
}

TEST_F(FrameClientTest, CancelWakesAReceiveOnAnotherThread) {
  ScriptedServer server(context_, Hold);
  ASSERT_TRUE(client_.Connect(server.endpoint(), fingerprint_, kSoon).ok());
  std::thread canceller([&] { client_.Cancel(); });
  auto result = client_.Receive(std::chrono::hours(1));
  canceller.join();
  EXPECT_EQ(result.status().code(), Code::kUnavailable);
  EXPECT_EQ(result.status().field(), "cancelled");
  EXPECT_EQ(client_.Connect(server.endpoint(), fingerprint_, kSoon).field(), "cancelled");
}

TEST(EndpointTest, ReadsNamesAddressesAndPorts) {
  EXPECT_EQ(ParseEndpoint("enamel.example:7443")->Text(), "enamel.example:7443");
  EXPECT_EQ(ParseEndpoint("[::1]:1")->host, "::1");
  EXPECT_EQ(ParseEndpoint("[::1]:1")->Text(), "[::1]:1");
  for (const char* bad : {"", "host", ":1", "host:", "host:0", "host:65536", "host:1x", "::1:7443",
                          "https://host:1", "[]:1"}) {
    EXPECT_FALSE(ParseEndpoint(bad).ok()) << bad;
  }
}

}  // namespace
}  // namespace enamel::net
