#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>

#include "common/trace/trace.h"
#include "tests/common/core/params.h"
#include "tests/server/http/running_server.h"

// Viewers of attempts in progress, as a browser's EventSource would be.
namespace enamel::server::http {
namespace {

namespace asio = boost::asio;

class LiveTest : public testing::Test {
 protected:
  LiveTest() { options_.live = &board_; }

  std::string Path(const Uuid& attempt) { return "/api/v1/attempts/" + attempt.Text() + "/live"; }

  static LiveSample Sample(const Uuid& attempt, uint64_t tick) {
    LiveSample sample;
    sample.attempt = attempt;
    sample.tick = tick;
    return sample;
  }

  School school_;
  LiveBoard board_;
  HttpOptions options_;
};

// A viewer's connection; the text it receives, up to its end.
class Stream {
 public:
  Stream(uint16_t port, const std::string& target, const std::string& cookie,
         const std::string& more = "") {
    socket_.connect({asio::ip::make_address("127.0.0.1"), port});
    std::string request = "GET " + target + " HTTP/1.1\r\nHost: localhost\r\nCookie: " + cookie +
                          "\r\n" + more + "\r\n";
    asio::write(socket_, asio::buffer(request));
  }
  std::string ReadUntilClosed() {
    std::string text;
    boost::system::error_code end;
    asio::read(socket_, asio::dynamic_buffer(text), end);
    return text;
  }

 private:
  asio::io_context io_;
  asio::ip::tcp::socket socket_{io_};
};

void WaitUntilWatched(const LiveBoard& board, const Uuid& attempt) {
  for (int i = 0; i < 2000 && !board.Watched(attempt); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_TRUE(board.Watched(attempt));
}

TEST_F(LiveTest, ViewerGetsTheNewestAndTheEnd) {
  RunningServer server(school_, options_);
  Visitor ada(server.port(), "ada");
  Stream stream(server.port(), Path(school_.sams_recording), ada.cookie);
  WaitUntilWatched(board_, school_.sams_recording);
  board_.Put(Sample(school_.sams_recording, 500));
  board_.Remove(school_.sams_recording);
  std::string text = stream.ReadUntilClosed();
  EXPECT_TRUE(text.starts_with("HTTP/1.1 200")) << text;
  EXPECT_NE(text.find("Content-Type: text/event-stream"), std::string::npos) << text;
  EXPECT_NE(text.find("Cache-Control: no-store, no-transform"), std::string::npos) << text;
  EXPECT_NE(text.find("X-Accel-Buffering: no"), std::string::npos) << text;
  EXPECT_NE(text.find("event: ticks\ndata: {\"tick\":500,"), std::string::npos) << text;
  EXPECT_TRUE(text.ends_with("event: end\ndata: {}\n\n")) << text;
  EXPECT_FALSE(board_.Watched(school_.sams_recording));
}

TEST_F(LiveTest, StreamEndsAfterItsTimeSoThatItsViewerIsAskedAgain) {
  options_.deadlines.events = std::chrono::milliseconds(300);
  RunningServer server(school_, options_);
  Visitor ada(server.port(), "ada");
  Stream stream(server.port(), Path(school_.sams_recording), ada.cookie);
  std::string text = stream.ReadUntilClosed();
  EXPECT_TRUE(text.starts_with("HTTP/1.1 200")) << text;
  EXPECT_EQ(text.find("event: end"), std::string::npos) << text;
}

TEST_F(LiveTest, StreamEndsSoonForWhomWatchingIsNoLongerAllowed) {
  options_.deadlines.allowed = std::chrono::milliseconds(100);
  const Actor by{{}, "test"};
  const std::vector<std::function<Status()>> ways = {
      [&] { return school_.store->people.SetDisabled(school_.ada, true, by); },
      [&] { return school_.store->sessions.EndSessionsOf(school_.ada, by).status(); },
      [&] { return school_.store->cohorts.ChangeMembers(school_.cohort_a, {}, {school_.ada}, by); },
  };
  RunningServer server(school_, options_);
  for (const auto& way : ways) {
    ASSERT_TRUE(school_.store->people.SetDisabled(school_.ada, false, by).ok());
    ASSERT_TRUE(school_.store->cohorts.AddToCohort(school_.cohort_a, school_.ada, by).ok());
    Visitor ada(server.port(), "ada");
    Stream stream(server.port(), Path(school_.sams_recording), ada.cookie);
    WaitUntilWatched(board_, school_.sams_recording);
    ASSERT_TRUE(way().ok());
    // Otherwise it would continue for five minutes.
    std::string text = stream.ReadUntilClosed();
    EXPECT_TRUE(text.starts_with("HTTP/1.1 200")) << text;
    EXPECT_EQ(text.find("event: end"), std::string::npos) << text;
  }
}

TEST_F(LiveTest, WatchingIsForTheCohortsInstructorsOnly) {
  RunningServer server(school_, options_);
  std::string path = Path(school_.sams_recording);
  EXPECT_EQ(Visitor(server.port(), "sam").Get(path).status, 403);
  EXPECT_EQ(Visitor(server.port(), "ben").Get(path).status, 404);
  RawClient nobody(server.port());
  nobody.Send("GET " + path + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(nobody.Read()->status, 401);
}

TEST_F(LiveTest, AnotherSitesPageIsRefused) {
  RunningServer server(school_, options_);
  Visitor ada(server.port(), "ada");
  std::string path = Path(school_.sams_recording);
  EXPECT_EQ(ada.Send("GET", path, "Origin: https://elsewhere.example\r\n").status, 403);
  EXPECT_EQ(ada.Send("GET", path, "Sec-Fetch-Site: cross-site\r\n").status, 403);
}

TEST_F(LiveTest, AttemptThatIsOverIsNotShown) {
  RunningServer server(school_, options_);
  Visitor ada(server.port(), "ada");
  EXPECT_EQ(ErrorCode(ada.Get(Path(school_.sams_scored))), "conflict");
  EXPECT_EQ(ada.Get(Path(Uuid::New())).status, 404);
}

TEST_F(LiveTest, WhereTheDevicesCentreLiesIsSaidWhileItIsBeingMade) {
  trace::Header header;
  header.hand.kind = HandKind::kProgram;
  header.params = test::ParamsFor({cutting::BurShape::kCylinder, 0.6e-3, 4e-3});
  header.params.device_origin_nm = {1'000'000, -2'500'000, 4'000'400};
  const Uuid made = school_.RecordingAttempt(school_.sam, {}, trace::EncodeHeader(header));
  RunningServer server(school_, options_);
  Visitor ada(server.port(), "ada");
  const auto origin = [&](const Uuid& attempt) {
    return boost::json::parse(ada.Get("/api/v1/attempts/" + attempt.Text()).body)
        .at("device_origin_um");
  };
  EXPECT_EQ(origin(made), boost::json::parse("[1000,-2500,4000]"));
  EXPECT_TRUE(origin(school_.sams_recording).is_null());  // of a header that is not read here
  EXPECT_TRUE(origin(school_.sams_scored).is_null());
}

TEST_F(LiveTest, StoppingDoesNotWaitForViewers) {
  auto server = std::make_unique<RunningServer>(school_, options_);
  Visitor ada(server->port(), "ada");
  Stream stream(server->port(), Path(school_.sams_recording), ada.cookie);
  WaitUntilWatched(board_, school_.sams_recording);
  server.reset();
  EXPECT_FALSE(board_.Watched(school_.sams_recording));
}

}  // namespace
}  // namespace enamel::server::http
