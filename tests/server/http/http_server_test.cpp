#include "server/http/wire/http_server.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <future>
#include <list>
#include <vector>

#include "server/http/request_places.h"
#include "server/http/server_context.h"
#include "server/http/site.h"
#include "server/http/wire/request_reader.h"
#include "server/storage/folder/disk.h"
#include "server/storage/folder/store_options.h"
#include "server/storage/open_store.h"
#include "tests/server/http/running_server.h"

namespace enamel::server::http {
namespace {

constexpr char kHealth[] = "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n";

HttpOptions Impatient() {
  HttpOptions options;
  options.deadlines.idle = options.deadlines.head = options.deadlines.body =
      std::chrono::milliseconds(200);
  return options;
}

class HttpServerTest : public testing::Test {
 protected:
  HttpServerTest() {
    page_.Write("index.html", "<!doctype html>page");
    page_.Write("main-4XKQ7B2D.js", "script");
    options_.web_root = page_.path();
  }

  test::TempFolder page_;
  School school_;
  HttpOptions options_;
};

TEST_F(HttpServerTest, KeepsTheConnectionForPipelinedRequests) {
  RunningServer server(school_, options_);
  RawClient client(server.port());
  client.Send(std::string(kHealth) + kHealth + kHealth);
  for (int i = 0; i < 3; ++i) {
    auto response = client.Read();
    ASSERT_TRUE(response);
    EXPECT_EQ(response->status, 200);
    EXPECT_EQ(response->body, R"({"status":"ok","problem":"","waiting":""})");
  }
}

// A connection to the server, which does not run yet: the system takes it, and what is sent.
class EarlyClient {
 public:
  EarlyClient(uint16_t port, const std::string& bytes)
      : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
    EXPECT_EQ(::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }
  ~EarlyClient() { ::close(socket_); }
  EarlyClient(const EarlyClient&) = delete;
  EarlyClient& operator=(const EarlyClient&) = delete;
  bool answered() const {
    pollfd look{socket_, POLLIN, 0};
    return ::poll(&look, 1, 0) == 1;
  }

 private:
  const int socket_;
};

TEST_F(HttpServerTest, LivenessDoesNotWaitBehindBodies) {
  constexpr size_t kBodies = 40, kBytes = 200'000;
  boost::asio::io_context io;
  options_.port = 0;
  options_.store_threads = 1;
  HttpServer server(io, options_, *school_.store, *school_.authenticator);
  const uint16_t port = *server.Start();
  const std::string request =
      "POST /api/v1/session HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
      "Content-Length: " +
      std::to_string(kBytes) + "\r\n\r\n" + std::string(kBytes, 'x');
  std::list<EarlyClient> bodies;
  for (size_t i = 0; i < kBodies; ++i) bodies.emplace_back(port, request);
  const EarlyClient looks(port, "GET /livez HTTP/1.1\r\nHost: localhost\r\n\r\n");
  while (!looks.answered()) ASSERT_GT(io.run_one(), 0u);
  EXPECT_EQ(std::ranges::count_if(bodies, &EarlyClient::answered), 0)
      << "answered before, though it came last";
  while (!std::ranges::all_of(bodies, &EarlyClient::answered)) ASSERT_GT(io.run_one(), 0u);
  server.Stop();
  io.run();
}

TEST_F(HttpServerTest, ClosesWhenAsked) {
  RunningServer server(school_, options_);
  RawClient client(server.port());
  client.Send("GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_EQ(client.Read()->headers["connection"], "close");
  EXPECT_TRUE(client.ClosedByServer());
}

TEST_F(HttpServerTest, AcceptsARequestSplitAtEveryByte) {
  RunningServer server(school_, options_);
  const std::string body = R"({"login":"sam","password":"wrong"})";
  RawClient client(server.port());
  for (char c : std::string(kHealth)) client.Send(std::string(1, c));
  EXPECT_EQ(client.Read()->status, 200);
  std::string post =
      "POST /api/v1/session HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
      "Content-Length: " +
      std::to_string(body.size()) + "\r\n\r\n" + body;
  for (char c : post) client.Send(std::string(1, c));
  EXPECT_EQ(client.Read()->status, 401);
}

TEST_F(HttpServerTest, ReadsChunkedBodies) {
  RunningServer server(school_, options_);
  RawClient client(server.port());
  client.Send(
      "POST /api/v1/session HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
      "Transfer-Encoding: "
      "chunked\r\n\r\n10\r\n{\"login\":\"sam\",\"\r\n12\r\npassword\":\"wrong\"}\r\n0\r\n\r\n");
  EXPECT_EQ(client.Read()->status, 401);
}

TEST_F(HttpServerTest, DateIsAsTheStandardWritesIt) {
  EXPECT_EQ(HttpDate(784111777), "Sun, 06 Nov 1994 08:49:37 GMT");  // RFC 9110, 5.6.7
}

TEST_F(HttpServerTest, EveryAnswerCarriesTheSecurityHeaders) {
  RunningServer server(school_, options_);
  Visitor nobody(server.port());
  for (const char* target :
       {"/", "/main-4XKQ7B2D.js", "/healthz", "/api/v1/session", "/api/none", "/x.js"}) {
    RawResponse response = nobody.Get(target);
    EXPECT_TRUE(response.headers["content-security-policy"].starts_with(
        "default-src 'none'; script-src 'self';"))
        << target;
    EXPECT_EQ(response.headers["x-content-type-options"], "nosniff") << target;
    EXPECT_EQ(response.headers["referrer-policy"], "no-referrer") << target;
    EXPECT_EQ(response.headers["cross-origin-opener-policy"], "same-origin") << target;
    EXPECT_EQ(response.headers["cross-origin-embedder-policy"], "require-corp") << target;
    EXPECT_EQ(response.headers["cross-origin-resource-policy"], "same-origin") << target;
    EXPECT_TRUE(response.headers.contains("permissions-policy")) << target;
    EXPECT_TRUE(response.headers.contains("cache-control")) << target;
    EXPECT_FALSE(response.headers.contains("server")) << target;
    EXPECT_EQ(response.headers["date"].size(), 29u) << target;
    EXPECT_EQ(response.headers.contains("www-authenticate"), response.status == 401) << target;
    // One policy by name, for the one worker: no "*", no "allow-duplicates", nothing after it.
    EXPECT_TRUE(response.headers["content-security-policy"].ends_with(
        "; require-trusted-types-for 'script'; trusted-types enamel-worker"))
        << target;
    EXPECT_NE(response.headers["content-security-policy"].find("; worker-src 'self'; "),
              std::string::npos);
  }
}

TEST_F(HttpServerTest, HeadAnswersLikeGetWithoutTheBody) {
  RunningServer server(school_, options_);
  RawClient client(server.port());
  for (const char* target : {"/", "/main-4XKQ7B2D.js", "/healthz"}) {
    client.Send(std::string("HEAD ") + target + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
    auto head = client.Read(true);
    client.Send(std::string("GET ") + target + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
    auto get = client.Read();
    ASSERT_TRUE(head && get) << target;
    EXPECT_EQ(head->status, 200);
    // Each request has an id of its own.
    EXPECT_EQ(head->headers.erase("x-request-id"), 1u);
    EXPECT_EQ(get->headers.erase("x-request-id"), 1u);
    // And on a loaded machine a second of its own.
    EXPECT_EQ(head->headers.erase("date"), 1u);
    EXPECT_EQ(get->headers.erase("date"), 1u);
    EXPECT_EQ(head->headers, get->headers);
    EXPECT_EQ(std::to_string(get->body.size()), head->headers["content-length"]);
  }
}

TEST_F(HttpServerTest, UnknownApiPathsAre404AndOtherPathsArePages) {
  RunningServer server(school_, options_);
  Visitor nobody(server.port());
  RawResponse unknown = nobody.Get("/api/v1/nothing");
  EXPECT_EQ(unknown.status, 404);
  EXPECT_EQ(ErrorCode(unknown), "not_found");
  EXPECT_EQ(nobody.Get("/api").status, 404);
  EXPECT_EQ(nobody.Get("/attempts/1").body, "<!doctype html>page");
  EXPECT_EQ(nobody.Get("/missing.js").status, 404);
  RawResponse put = nobody.Send("PUT", "/api/v1/session", "");
  EXPECT_EQ(put.status, 405);
  EXPECT_EQ(put.headers["allow"], "POST, GET, HEAD, DELETE");
}

TEST_F(HttpServerTest, NoPathLeadsOutOfThePage) {
  RunningServer server(school_, options_);
  Visitor nobody(server.port());
  for (const char* target : {"/%252e%252e/%252e%252e/etc/passwd.js", "/%c0%ae%c0%ae/etc/passwd.js",
                             "/\xc0\xae\xc0\xae/etc/passwd.js", "/assets/..%2f..%2fetc/passwd.js",
                             "/\\..\\..\\etc\\passwd.js", "/../../etc/passwd",
                             "/%2e%2e/%2e%2e/etc/passwd", "/..%5c..%5cetc%5cpasswd",
                             "//etc/passwd.txt", "/%00.js", "/main-4XKQ7B2D.js%00.txt", "/.."}) {
    RawResponse response = nobody.Get(target);
    EXPECT_TRUE(response.status == 404 || response.status == 400)
        << target << " " << response.status;
    EXPECT_EQ(response.body.find("root:"), std::string::npos);
  }
}

TEST_F(HttpServerTest, HostNamesOfOthersAreMisdirected) {
  RunningServer server(school_, options_);
  for (const char* host : {"evil.example", "evil.example:80", "localhost.evil.example"}) {
    RawClient client(server.port());
    client.Send(std::string("GET / HTTP/1.1\r\nHost: ") + host + "\r\n\r\n");
    EXPECT_EQ(client.Read()->status, 421) << host;
  }
}

TEST_F(HttpServerTest, OversizedHeadIsRefusedWith431) {
  RunningServer server(school_, options_);
  RawClient client(server.port());
  client.Send("GET / HTTP/1.1\r\nHost: localhost\r\nX: " + std::string(kMaxHeadBytes, 'a'));
  auto response = client.Read();
  ASSERT_TRUE(response);
  EXPECT_EQ(response->status, 431);
  EXPECT_EQ(ErrorCode(*response), "too_large");
}

TEST_F(HttpServerTest, OversizedBodyIsRefusedWith413) {
  RunningServer server(school_, options_);
  const std::string big(kMaxBodyBytes + 1, 'a');
  Visitor nobody(server.port());
  EXPECT_EQ(
      nobody.Send("POST", "/api/v1/session", "Content-Type: application/json\r\n", big).status,
      413);
  RawClient chunked(server.port());
  chunked.Send(
      "POST /api/v1/session HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: "
      "chunked\r\n\r\n100001\r\n" +
      big);
  EXPECT_EQ(chunked.Read()->status, 413);
}

TEST_F(HttpServerTest, AHugeAnnouncedBodyIsRefusedBeforeItIsSent) {
  RunningServer server(school_, options_);
  RawClient client(server.port());
  client.Send(
      "POST /api/v1/session HTTP/1.1\r\nHost: localhost\r\nContent-Length: 999999999999\r\n\r\n");
  EXPECT_EQ(client.Read()->status, 413);
}

TEST_F(HttpServerTest, AnswersExpectContinue) {
  RunningServer server(school_, options_);
  RawClient client(server.port());
  client.Send(
      "POST /api/v1/session HTTP/1.1\r\nHost: localhost\r\nExpect: 100-continue\r\nContent-Length: "
      "2\r\n"
      "Content-Type: application/json\r\n\r\n");
  EXPECT_EQ(client.Read()->status, 100);
  client.Send("{}");
  EXPECT_EQ(client.Read()->status, 400);
}

TEST_F(HttpServerTest, ClosesAConnectionThatStaysIdle) {
  RunningServer server(school_, Impatient());
  RawClient client(server.port());
  EXPECT_TRUE(client.ClosedByServer());
}

TEST_F(HttpServerTest, ASlowDripDoesNotExtendTheDeadline) {
  HttpOptions options = Impatient();
  options.deadlines.idle = std::chrono::seconds(30);
  RunningServer server(school_, options);
  RawClient head(server.port());
  head.Send("GET /healthz HTTP/1.1\r\nHost: loc");
  EXPECT_TRUE(head.ClosedByServer());
  RawClient dripping(server.port());
  bool open = true;
  for (int i = 0; open && i < 600; ++i) {
    open = dripping.Send("G");
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_FALSE(open);
  RawClient body(server.port());
  body.Send("POST /api/v1/session HTTP/1.1\r\nHost: localhost\r\nContent-Length: 10\r\n\r\n12");
  EXPECT_TRUE(body.ClosedByServer());
}

// The machine's, but that it does not say how much is free before `asked` returns.
class HangingDisk final : public Disk {
 public:
  explicit HangingDisk(std::function<void()> asked) : asked_(std::move(asked)) {}
  Result<uint64_t> FreeBytes(const std::filesystem::path& folder) override {
    asked_();
    return disk_.FreeBytes(folder);
  }
  Status Replace(const std::filesystem::path& path, ByteView data) override {
    return disk_.Replace(path, data);
  }
  Status MakeFolder(const std::filesystem::path& path) override { return disk_.MakeFolder(path); }
  Status SyncFolder(const std::filesystem::path& path) override { return disk_.SyncFolder(path); }
  Status Remove(const std::filesystem::path& path) override { return disk_.Remove(path); }
  Status Shred(const std::filesystem::path& path) override { return disk_.Shred(path); }
  Result<Content> Hash(const std::filesystem::path& path) override { return disk_.Hash(path); }
  Result<Copied> Copy(const std::filesystem::path& from, const std::filesystem::path& to,
                      bool link) override {
    return disk_.Copy(from, to, link);
  }
  Status SyncAll(const std::filesystem::path& folder) override { return disk_.SyncAll(folder); }

 private:
  Disk& disk_ = SystemDisk();
  const std::function<void()> asked_;
};

TEST_F(HttpServerTest, DiskThatHangsHoldsUpWhoAsksForHealthAndNobodyElse) {
  std::promise<void> asked, release;
  HangingDisk disk([&, may_go_on = release.get_future().share()] {
    asked.set_value();
    may_go_on.wait();
  });
  school_.authenticator.reset();
  school_.store.reset();
  StoreOptions hanging{.folder = school_.folder.path() / "data", .disk = &disk};
  auto store = OpenSqliteStore(hanging);
  ASSERT_TRUE(store.ok()) << store.status().message();
  school_.store = std::move(*store);
  school_.authenticator = std::make_unique<auth::Authenticator>(*school_.store);
  RunningServer server(school_, options_);
  RawClient patient(server.port()), other(server.port());
  patient.Send(kHealth);
  bool hangs = asked.get_future().wait_for(std::chrono::seconds(60)) == std::future_status::ready;
  other.Send("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  auto page = other.Read();
  release.set_value();
  EXPECT_TRUE(hangs);
  ASSERT_TRUE(page.has_value());
  EXPECT_EQ(page->status, 200);
  EXPECT_EQ(patient.Read()->status, 200);
}

class SlowStoreTest : public HttpServerTest {
 protected:
  // Signs in, then has every write wait for `go_on_`.
  SlowStoreTest() {
    options_.deadlines.work = std::chrono::milliseconds(300);
    RunningServer patient(school_);
    Visitor root(patient.port(), "root");
    signed_in_ = "Cookie: " + root.cookie + "\r\nX-Enamel-Csrf: " + root.csrf + "\r\n";
    school_.before_write = [may_go_on = go_on_.get_future().share()] {
      may_go_on.wait();
      return false;
    };
  }

  void AskForCohort(RawClient& client, char name) {
    client.Send("POST /api/v1/cohorts HTTP/1.1\r\nHost: localhost\r\n" + signed_in_ +
                "Content-Type: application/json\r\nContent-Length: 12\r\n\r\n" + R"({"name":")" +
                name + R"("})");
  }

  std::promise<void> go_on_;
  std::string signed_in_;
};

TEST_F(SlowStoreTest, WorkThatDoesNotEndIsAnsweredInTimeAndItsConnectionGivesWay) {
  options_.max_connections = 1;
  RunningServer server(school_, options_);
  RawClient stuck(server.port());
  AskForCohort(stuck, 'x');
  auto refused = stuck.Read();
  RawClient other(server.port());
  other.Send("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  auto page = other.Read();
  go_on_.set_value();
  ASSERT_TRUE(refused.has_value());
  EXPECT_EQ(refused->status, 503);
  EXPECT_EQ(ErrorCode(*refused), "unavailable");
  EXPECT_EQ(refused->headers["retry-after"], "5");
  ASSERT_TRUE(page.has_value());
  EXPECT_EQ(page->status, 200);
}

TEST_F(SlowStoreTest, WorkThatWasNotBegunInItsTimeIsNotDoneLater) {
  std::optional<RunningServer> server(std::in_place, school_, options_);  // two store threads
  std::list<RawClient> clients;
  for (char name : std::string("xyz")) {
    clients.emplace_back(server->port());
    AskForCohort(clients.back(), name);
  }
  for (RawClient& client : clients) {
    auto refused = client.Read();
    EXPECT_TRUE(refused && refused->status == 503);
  }
  go_on_.set_value();
  server.reset();  // what its threads had begun is done
  auto cohorts = school_.store->cohorts.Cohorts();
  ASSERT_TRUE(cohorts.ok());
  auto asked_for = [](const Cohort& c) { return c.name == "x" || c.name == "y" || c.name == "z"; };
  EXPECT_LE(std::ranges::count_if(*cohorts, asked_for), 2);
}

TEST_F(HttpServerTest, HealthIsToldWhileAllOthersWaitForTheDatabase) {
  constexpr auto kEnough = std::chrono::seconds(60);
  options_.deadlines.work = 2 * kEnough;  // none of the changes is given up, however slow we are
  RunningServer server(school_, options_);
  Visitor root(server.port(), "root");
  std::promise<void> held, go_on;
  std::atomic<bool> first{true};
  school_.before_write = [&, may_go_on = go_on.get_future().share()] {
    if (first.exchange(false)) held.set_value();
    may_go_on.wait();
    return false;
  };
  std::vector<std::future<int>> changes;
  for (size_t i = 0; i < static_cast<size_t>(ops::Budgets{}.person_requests); ++i) {
    changes.push_back(std::async(std::launch::async, [&, i] {
      std::string body = R"({"name":"cohort )" + std::to_string(i) + R"("})";
      return Visitor(root).Post("/api/v1/cohorts", body).status;
    }));
  }
  EXPECT_EQ(held.get_future().wait_for(kEnough), std::future_status::ready);
  auto health = std::async(std::launch::async, [&] {
    int well = 0;
    for (int i = 0; i < 20; ++i) well += Visitor(server.port()).Get("/healthz").status == 200;
    return well;
  });
  EXPECT_EQ(health.wait_for(kEnough), std::future_status::ready);
  go_on.set_value();
  EXPECT_EQ(health.get(), 20);
  for (auto& change : changes) EXPECT_EQ(change.get(), 201);
}

TEST_F(HttpServerTest, HalfSentHeadsDoNotTakeThePageFromOthers) {
  options_.max_connections = 4;
  RunningServer server(school_, options_);
  std::list<RawClient> stuck;
  for (int i = 0; i < 4; ++i) {
    stuck.emplace_back(server.port());
    stuck.back().Send("GET /healthz HTTP/1.1\r\n");
  }
  for (int i = 0; i < 20; ++i) {
    RawClient client(server.port());
    client.Send(kHealth);
    auto answer = client.Read();
    ASSERT_TRUE(answer) << i;
    EXPECT_EQ(answer->status, 200) << i;
    stuck.emplace_back(server.port());
    stuck.back().Send("GET /healthz HTTP/1.1\r\n");
  }
  EXPECT_TRUE(stuck.front().ClosedByServer());
}

TEST_F(HttpServerTest, ConnectionForWhichNobodyCanMakeRoomIsTurnedAway) {
  options_.max_connections = 0;
  RunningServer server(school_, options_);
  RawClient client(server.port());
  EXPECT_EQ(client.Read()->status, 503);
  EXPECT_TRUE(client.ClosedByServer());
}

TEST_F(HttpServerTest, StopClosesIdleConnectionsAndRunsOutOfWork) {
  options_.deadlines.stop = std::chrono::minutes(10);
  RunningServer server(school_, options_);
  RawClient client(server.port());
  client.Send(kHealth);
  EXPECT_EQ(client.Read()->status, 200);
  server.server().Stop();
  server.server().Stop();
  server.Join();
  EXPECT_TRUE(client.ClosedByServer());
  RawClient late(server.port());
  EXPECT_FALSE(late.Send(kHealth) && late.Read());
}

TEST_F(HttpServerTest, StopDoesNotWaitForAStuckRequest) {
  options_.deadlines.stop = std::chrono::milliseconds(100);
  RunningServer server(school_, options_);
  RawClient client(server.port());
  client.Send(
      "POST /api/v1/session HTTP/1.1\r\nHost: localhost\r\nExpect: 100-continue\r\nContent-Length: "
      "10\r\n\r\n");
  EXPECT_EQ(client.Read()->status, 100);
  server.server().Stop();
  server.Join();
  EXPECT_TRUE(client.ClosedByServer());
}

TEST_F(HttpServerTest, SaysThatThePortIsInUse) {
  RunningServer server(school_, options_);
  boost::asio::io_context io;
  options_.port = server.port();
  HttpServer second(io, options_, *school_.store, *school_.authenticator);
  Result<uint16_t> started = second.Start();
  ASSERT_FALSE(started.ok());
  EXPECT_EQ(started.status().code(), Code::kUnavailable);
  EXPECT_NE(started.status().message().find(":" + std::to_string(server.port()) + " in use"),
            std::string::npos)
      << started.status().message();
}

TEST_F(HttpServerTest, RefusesToSpeakPlainHttpBeyondLoopback) {
  boost::asio::io_context io;
  for (const char* address : {"0.0.0.0", "::", "192.0.2.1"}) {
    options_.address = address;
    HttpServer server(io, options_, *school_.store, *school_.authenticator);
    Result<uint16_t> started = server.Start();
    ASSERT_FALSE(started.ok());
    EXPECT_EQ(started.status().code(), Code::kInvalidInput);
    EXPECT_NE(started.status().message().find("TLS"), std::string::npos);
  }
  options_.address = "localhost";
  HttpServer server(io, options_, *school_.store, *school_.authenticator);
  EXPECT_EQ(server.Start().status().field(), "address");
}

TEST_F(HttpServerTest, SaysThatThePageIsMissing) {
  boost::asio::io_context io;
  options_.web_root = page_.path() / "none";
  HttpServer server(io, options_, *school_.store, *school_.authenticator);
  EXPECT_EQ(server.Start().status().code(), Code::kNotFound);
}

TEST_F(HttpServerTest, AStoreFailureIsA500WithoutDetail) {
  RunningServer server(school_, options_);
  Visitor sam(server.port(), "sam");
  std::filesystem::remove_all(school_.folder.path() / "data" / "blobs");
  // Not what a test before this one may have read: documents are kept by their hash (DocumentOf).
  RawResponse response = sam.Get("/api/v1/exercises/" + school_.exercise.Text() + "/document");
  EXPECT_EQ(response.status, 500);
  EXPECT_EQ(ErrorCode(response), "internal");
  EXPECT_EQ(response.body.find(school_.folder.path().string()), std::string::npos);
}

TEST_F(HttpServerTest, ServesAnOldVersionOnceAndTheAbsoluteFormOfATarget) {
  RunningServer server(school_, options_);
  RawClient old(server.port());
  old.Send("GET /healthz HTTP/1.0\r\nHost: localhost\r\nConnection: keep-alive\r\n\r\n");
  EXPECT_EQ(old.Read()->status, 200);
  EXPECT_TRUE(old.ClosedByServer());
  RawClient absolute(server.port());
  absolute.Send("GET http://localhost/healthz HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(absolute.Read()->status, 200);
  absolute.Send("GET /%zz?a=%&b=[\xc3\xa4] HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(absolute.Read()->status, 404);  // understood, and no file of the page
}

TEST_F(HttpServerTest, ABodyThatIsPackedIsRefusedUnread) {
  RunningServer server(school_, options_);
  RawClient client(server.port());
  client.Send(
      "POST /api/v1/session HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
      "Content-Encoding: gzip\r\nContent-Length: 1000000\r\n\r\n");
  auto answer = client.Read();
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 415);
  EXPECT_EQ(answer->headers["connection"], "close");
}

// Bodies of 1 MiB of which not a byte comes, each from a connection of its own.
class BegunBodies {
 public:
  // False: this one is refused.
  bool Begin(uint16_t port, const std::string& headers) {
    RawClient& client = clients_.emplace_back(port);
    client.Send("POST /api/v1/session HTTP/1.1\r\n" + headers +
                "Expect: 100-continue\r\nContent-Length: 1048576\r\n\r\n");
    const auto answer = client.Read();
    EXPECT_TRUE(answer);
    EXPECT_TRUE(!answer || answer->status == 100 || answer->status == 503) << answer->status;
    return answer && answer->status == 100;
  }

  RawClient& first() { return clients_.front(); }

 private:
  std::list<RawClient> clients_;
};
const size_t kBegunAtOnce = ops::LimitOf(ops::kBodies, {}) / kMaxBodyBytes;

TEST_F(HttpServerTest, BodiesThatHaveOnlyBegunTakeABoundedMemory) {
  RunningServer server(school_, options_);
  BegunBodies bodies;
  const std::string host = "Host: localhost\r\n";
  for (size_t i = 0; i < kBegunAtOnce; ++i) ASSERT_TRUE(bodies.Begin(server.port(), host)) << i;
  EXPECT_FALSE(bodies.Begin(server.port(), host));
}

class ProxyTest : public HttpServerTest {
 protected:
  ProxyTest() {
    options_.trusted_proxies = {"127.0.0.1"};
    options_.host_names = {"teeth.example"};
  }
  std::optional<RawResponse> Ask(uint16_t port, const std::string& headers) {
    RawClient client(port);
    client.Send("GET /api/v1/session HTTP/1.1\r\nHost: teeth.example\r\n" + headers + "\r\n");
    return client.Read();
  }
};

TEST_F(ProxyTest, AnswersWhatTheProxyPassesOnAsOverTls) {
  RunningServer server(school_, options_);
  auto answer = Ask(server.port(),
                    "X-Forwarded-For: 203.0.113.9, 198.51.100.7\r\nX-Forwarded-Proto: https\r\n");
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 401);
  EXPECT_TRUE(answer->headers.contains("strict-transport-security"));
}

TEST_F(ProxyTest, RefusesAProxyThatDoesNotSayWhoAsksAndHow) {
  RunningServer server(school_, options_);
  for (const char* headers : {"", "X-Forwarded-For: 203.0.113.9\r\n",
                              "X-Forwarded-For: 203.0.113.9\r\nX-Forwarded-Proto: http\r\n",
                              "X-Forwarded-For: unknown\r\nX-Forwarded-Proto: https\r\n",
                              "X-Forwarded-Proto: https\r\n"}) {
    EXPECT_EQ(Ask(server.port(), headers)->status, 403) << headers;
  }
}

// Else one stranger behind the proxy would keep everybody's out.
TEST_F(ProxyTest, CountsBegunBodiesForWhoeverTheProxyNames) {
  RunningServer server(school_, options_);
  BegunBodies bodies;
  const auto from = [](const char* address) {
    return std::string("Host: teeth.example\r\nX-Forwarded-Proto: https\r\nX-Forwarded-For: ") +
           address + "\r\n";
  };
  for (size_t i = 0; i < kBegunAtOnce; ++i)
    ASSERT_TRUE(bodies.Begin(server.port(), from("203.0.113.9"))) << i;
  EXPECT_FALSE(bodies.Begin(server.port(), from("203.0.113.9")));
  EXPECT_TRUE(bodies.Begin(server.port(), from("198.51.100.7")));
  const auto broken_off = bodies.first().Read();
  ASSERT_TRUE(broken_off);
  EXPECT_EQ(broken_off->status, 503);
  EXPECT_NE(broken_off->body.find("(budget bodies_mib: 48 MiB)"), std::string::npos);
}

TEST_F(ProxyTest, RefusesEverybodyElse) {
  options_.trusted_proxies = {"192.0.2.1"};
  RunningServer server(school_, options_);
  EXPECT_EQ(
      Ask(server.port(), "X-Forwarded-For: 203.0.113.9\r\nX-Forwarded-Proto: https\r\n")->status,
      403);
}

TEST_F(ProxyTest, TellsItsHealthToTheProxyItself) {
  RunningServer server(school_, options_);
  RawClient client(server.port());
  client.Send("GET /healthz HTTP/1.1\r\nHost: teeth.example\r\n\r\n");
  EXPECT_EQ(client.Read()->status, 200);
}

TEST_F(ProxyTest, WantsNumericAddressesAndHostNames) {
  boost::asio::io_context io;
  options_.trusted_proxies = {"proxy.example"};
  HttpServer named(io, options_, *school_.store, *school_.authenticator);
  EXPECT_EQ(named.Start().status().field(), "trusted_proxies");
  options_.trusted_proxies = {"127.0.0.1"};
  options_.host_names.clear();
  HttpServer nameless(io, options_, *school_.store, *school_.authenticator);
  EXPECT_EQ(nameless.Start().status().field(), "host_names");
}

}  // namespace
}  // namespace enamel::server::http
