#include "server/doctor/doctor.h"

#include <gtest/gtest.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <thread>

#include "common/net/web_question.h"
#include "server/app/data_folder.h"
#include "server/storage/engine/database.h"
#include "tests/support/temp_folder.h"

// Each thing that is wrong is found, with what to do.
namespace enamel::server::app {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using program::Finding;
using program::Verdict;

// Accepts one connection, reads a request and answers with `text`; with none it says nothing until
// the peer has gone.
class OneAnswer {
 public:
  explicit OneAnswer(std::string text)
      : acceptor_(io_, tcp::endpoint(asio::ip::address_v4::loopback(), 0)),
        thread_([this, text = std::move(text)] {
          tcp::socket socket = acceptor_.accept();
          std::string request;
          boost::system::error_code ended;
          asio::read_until(socket, asio::dynamic_buffer(request), "\r\n\r\n", ended);
          if (text.empty()) asio::read_until(socket, asio::dynamic_buffer(request), "never", ended);
          asio::write(socket, asio::buffer(text), ended);
        }) {}
  uint16_t port() const { return acceptor_.local_endpoint().port(); }

 private:
  asio::io_context io_;
  tcp::acceptor acceptor_;
  std::jthread thread_;
};

TEST(WebQuestionTest, AnAnswerIsReadAndWhatIsNoneIsNamed) {
  OneAnswer well("HTTP/1.1 503 Service Unavailable\r\nServer: x\r\n\r\n{\"status\":\"no\"}");
  const auto answer = net::Ask({"127.0.0.1", well.port(), false});
  ASSERT_TRUE(answer.ok()) << answer.status().message();
  EXPECT_EQ(answer->status, 503);
  EXPECT_EQ(answer->body, "{\"status\":\"no\"}");
  OneAnswer other("SSH-2.0-OpenSSH\r\n");
  EXPECT_EQ(net::Ask({"127.0.0.1", other.port(), false}).status().code(), Code::kInvalidInput);
  // As a proxy that answers half a head.
  OneAnswer half("HTTP/1.1 200 OK\r\nServer");
  EXPECT_EQ(net::Ask({"127.0.0.1", half.port(), false}).status().code(), Code::kInvalidInput);
}

TEST(WebQuestionTest, WhoDoesNotAnswerIsLeftAfterTheTime) {
  OneAnswer silent("");
  net::WebQuestion question{"127.0.0.1", silent.port(), false};
  question.within = std::chrono::milliseconds(50);
  const Status left = net::Ask(question).status();
  EXPECT_EQ(left.code(), Code::kUnavailable);
  EXPECT_NE(left.message().find("waiting for the answer"), std::string::npos) << left.message();
}

constexpr long kDay = 24 * 3600;

// Writes the certificate again as `to`, signed by the key beside it: valid from two days ago, for so many seconds from
// now.
bool ValidFor(const std::filesystem::path& certificate, const std::filesystem::path& to,
              long seconds) {
  const auto opened = [](const std::filesystem::path& file, const char* how) {
    return std::unique_ptr<FILE, int (*)(FILE*)>(std::fopen(file.c_str(), how), std::fclose);
  };
  std::filesystem::path key_file = certificate;
  key_file.replace_extension(".key");
  const std::unique_ptr<X509, decltype(&X509_free)> made(
      PEM_read_X509(opened(certificate, "r").get(), nullptr, nullptr, nullptr), X509_free);
  const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> key(
      PEM_read_PrivateKey(opened(key_file, "r").get(), nullptr, nullptr, nullptr), EVP_PKEY_free);
  return made && key && X509_gmtime_adj(X509_getm_notBefore(made.get()), -2 * kDay) != nullptr &&
         X509_gmtime_adj(X509_getm_notAfter(made.get()), seconds) != nullptr &&
         X509_sign(made.get(), key.get(), EVP_sha256()) > 0 &&
         PEM_write_X509(opened(to, "w").get(), made.get()) == 1;
}

class DoctorTest : public ::testing::Test {
 protected:
  DoctorTest() {
    serve_.data = folder_.path() / "server";
    serve_.http = "127.0.0.1:1";
    serve_.stations = "127.0.0.1:1";
    serve_.min_free_mib = 0;
    EXPECT_TRUE(OpenOrMake(serve_.data).ok());
    EXPECT_TRUE(EnsureIdentity(serve_.data).ok());
  }
  // Of all findings of this name the worst; none: a finding without a name.
  Finding Of(const std::string& what) const {
    Finding out;
    for (const Finding& finding : Examine(serve_)) {
      if (finding.what == what && (out.what.empty() || finding.verdict > out.verdict))
        out = finding;
    }
    return out;
  }

  test::TempFolder folder_;
  ServeOptions serve_;
};

TEST_F(DoctorTest, ANewServerHasNothingWrongButWhatIsStillToDo) {
  for (const Finding& finding : Examine(serve_)) {
    EXPECT_NE(finding.verdict, Verdict::kFail) << finding.what << ": " << finding.found;
    EXPECT_EQ(finding.verdict != Verdict::kOk, !finding.advice.empty()) << finding.what;
  }
  EXPECT_EQ(Of("data folder").verdict, Verdict::kOk);
  EXPECT_EQ(Of("schema").verdict, Verdict::kOk);
  EXPECT_EQ(Of("stations' link").verdict, Verdict::kOk);
  EXPECT_EQ(Of("backup").verdict, Verdict::kWarn) << "none yet";
  EXPECT_EQ(Of("server").verdict, Verdict::kWarn) << "it does not run";
}

TEST_F(DoctorTest, RestoreDrillThatFailedIsAWarningWithItsReason) {
  const auto note = [&](const char* action, const char* after) {
    EXPECT_TRUE(OpenForCommand(serve_.data)
                    .value()
                    ->audit.NoteAudit({{}, "test"}, action, "/b/1", after)
                    .ok());
  };
  note("store.backup", "{}");
  EXPECT_NE(Of("restore drill").found.find("no folder for backups"), std::string::npos);
  serve_.backups = "/b";
  EXPECT_EQ(Of("restore drill").verdict, Verdict::kOk) << "none was due";
  note("store.drill_failed", R"({"problem":"a key is missing"})");
  EXPECT_EQ(Of("restore drill").verdict, Verdict::kWarn);
  EXPECT_NE(Of("restore drill").found.find("a key is missing"), std::string::npos);
  note("store.drill", "{}");
  EXPECT_EQ(Of("restore drill").verdict, Verdict::kOk);
}

TEST_F(DoctorTest, AFolderThatOthersMayEnterOrThatIsNotThereFails) {
  std::filesystem::permissions(serve_.data, std::filesystem::perms(0755));
  EXPECT_EQ(Of("data folder").verdict, Verdict::kFail);
  EXPECT_NE(Of("data folder").advice.find("chmod 700"), std::string::npos);
  serve_.data = folder_.path() / "misspelt";
  EXPECT_EQ(Of("data folder").verdict, Verdict::kFail);
}

TEST_F(DoctorTest, ASecretThatOthersMayReadFails) {
  std::filesystem::permissions(serve_.data / "ticket.key", std::filesystem::perms(0644));
  EXPECT_EQ(Of("secret files").verdict, Verdict::kFail);
}

TEST_F(DoctorTest, ACertificateThatIsNoneOrWhoseKeyIsAnothersFails) {
  serve_.http_certificate = serve_.data / "station.crt";
  serve_.http_key = serve_.data / "station.key";
  EXPECT_EQ(Of("page's TLS").verdict, Verdict::kOk);
  serve_.http_key = serve_.data / "ticket.key";
  EXPECT_EQ(Of("page's TLS").verdict, Verdict::kFail);
}

TEST_F(DoctorTest, ACertificateIsToldAMonthBeforeItEnds) {
  const UnixMs now = UnixMs{std::time(nullptr)} * 1000, day = UnixMs{24} * 3600 * 1000;
  EXPECT_EQ(examined::Dates("x", now + 31 * day, "renew").verdict, Verdict::kOk);
  EXPECT_EQ(examined::Dates("x", now + 29 * day, "renew").verdict, Verdict::kWarn);
  EXPECT_EQ(examined::Dates("x", now - day, "renew").verdict, Verdict::kFail);
}

TEST_F(DoctorTest, ACertificateNearItsEndIsAWarningAndAnExpiredOneFails) {
  const std::string station = serve_.data / "station.crt", page = serve_.data / "page.crt";
  serve_.http_certificate = page;
  serve_.http_key = serve_.data / "station.key";
  ASSERT_TRUE(ValidFor(station, page, 40 * kDay));
  EXPECT_EQ(Of("page's TLS").verdict, Verdict::kOk);
  ASSERT_TRUE(ValidFor(station, page, 7 * kDay));
  EXPECT_EQ(Of("page's TLS").verdict, Verdict::kWarn);
  EXPECT_EQ(Of("page's TLS").found.find("valid until "), 0u) << Of("page's TLS").found;
  EXPECT_NE(Of("page's TLS").advice.find("renew it"), std::string::npos);
  ASSERT_TRUE(ValidFor(station, page, -kDay));
  EXPECT_EQ(Of("page's TLS").verdict, Verdict::kFail);
  EXPECT_EQ(Of("page's TLS").found.find("expired: it was valid until "), 0u);
  EXPECT_EQ(Of("stations' link").verdict, Verdict::kOk);
  ASSERT_TRUE(ValidFor(station, station, -kDay));
  EXPECT_EQ(Of("stations' link").verdict, Verdict::kFail);
  EXPECT_NE(Of("stations' link").advice.find("enrol every station again"), std::string::npos);
}

TEST_F(DoctorTest, ABackupDatedInTheFutureIsAWarningAndOneOfTodayIsNot) {
  const auto note = [&] {
    const auto store = OpenForCommand(serve_.data).value();
    return store->audit.NoteAudit({{}, "test"}, "store.backup", "/b/1", "{}");
  };
  ASSERT_TRUE(note().ok());
  EXPECT_EQ(Of("backup").verdict, Verdict::kOk) << Of("backup").found;
  // A server with a wrong clock notes such a row.
  auto db = OpenDatabase(serve_.data / "enamel.db", DbMode::kExisting).value();
  ASSERT_TRUE(db->Exec("INSERT INTO audit SELECT tenant, later, at_ms + 172800000, actor, via, "
                       "action, object, before_json, after_json, subject, state, salt, "
                       "content_hash, signature, chain, number + 1, previous FROM (SELECT *, "
                       "x'ffffffffffffffffffffffffffffffff' AS later FROM audit WHERE action "
                       "= 'store.backup')")
                  .ok());
  db.reset();
  EXPECT_EQ(Of("backup").verdict, Verdict::kWarn);
  EXPECT_NE(Of("backup").found.find("in the future: a clock was wrong"), std::string::npos);
  EXPECT_NE(Of("backup").advice.find("let a time server keep the clock"), std::string::npos);
}

TEST_F(DoctorTest, AnotherProgramAtThePagesPortFails) {
  OneAnswer other("HTTP/1.1 200 OK\r\n\r\n<html>somebody else</html>");
  serve_.http = "127.0.0.1:" + std::to_string(other.port());
  EXPECT_EQ(Of("server").verdict, Verdict::kFail);
}

TEST_F(DoctorTest, TooLittleRoomFails) {
  serve_.min_free_mib = 1 << 30;
  EXPECT_EQ(Of("disk").verdict, Verdict::kFail);
}

TEST_F(DoctorTest, ADatabaseFileThatNamesNoDatabaseFails) {
  std::ofstream(serve_.data / "database.json")
      << R"({"format": "enamel-database", "version": 1, "server": "host=/nowhere", "schema": "x"})";
  std::filesystem::permissions(serve_.data / "database.json", std::filesystem::perms(0600));
  EXPECT_EQ(Of("database").verdict, Verdict::kFail);
}

TEST_F(DoctorTest, PgOfTheDatabaseRoleStandbyAndClockAreTold) {
  const char* server = std::getenv("ENAMEL_POSTGRES");
  if (server == nullptr) GTEST_SKIP() << "ENAMEL_POSTGRES names no server";
  std::filesystem::remove(serve_.data / "enamel.db");
  std::ofstream(serve_.data / "database.json")
      << R"({"format": "enamel-database", "version": 1, "server": ")" << server
      << R"(", "schema": "doctor"})";
  std::filesystem::permissions(serve_.data / "database.json", std::filesystem::perms(0600));
  EXPECT_EQ(Of("database role").verdict, Verdict::kWarn) << "the tests' is a superuser";
  EXPECT_EQ(Of("standby").verdict, Verdict::kWarn) << "there is none";
  EXPECT_EQ(Of("database clock").verdict, Verdict::kOk);
  EXPECT_EQ(Of("connections").verdict, Verdict::kOk);
  EXPECT_EQ(Of("database settings").verdict, Verdict::kFail) << "the tests' has no fsync";
}

}  // namespace
}  // namespace enamel::server::app
