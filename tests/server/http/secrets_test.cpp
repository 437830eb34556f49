#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <boost/json.hpp>
#include <sstream>

#include "server/ops/metrics.h"
#include "tests/server/http/running_server.h"

// A secret appears only in the answer that gives it out: not in the most verbose log, the audit
// trail, the metrics, or any refusal.
namespace enamel::server::http {
namespace {

namespace json = boost::json;

constexpr char kJsonType[] = "application/json";

class SecretsTest : public testing::Test {
 protected:
  SecretsTest() : before_(spdlog::default_logger()) {
    auto sink = std::make_shared<spdlog::sinks::ostream_sink_mt>(log_);
    auto logger = std::make_shared<spdlog::logger>("test", sink);
    logger->set_level(spdlog::level::trace);
    spdlog::set_default_logger(logger);
    HttpOptions options;
    options.metrics = &metrics_;
    options.station_fingerprint = "f1f2";
    server_ = std::make_unique<RunningServer>(school_, options);
  }
  ~SecretsTest() override {
    server_.reset();
    spdlog::set_default_logger(before_);
  }

  RawResponse Send(Visitor& who, const std::string& target, const std::string& body,
                   const std::string& type = kJsonType, const std::string& method = "POST") {
    RawResponse response = who.Send(
        method, target, "X-Enamel-Csrf: " + who.csrf + "\r\nContent-Type: " + type + "\r\n", body);
    if (response.status >= 400) refusals_ += response.body + "\n";
    return response;
  }
  void SignIn(const std::string& login, const std::string& password) {
    Visitor visitor(server_->port());
    secrets_[password] = "password of " + login;
    RawResponse response =
        Send(visitor, "/api/v1/session",
             json::serialize(json::object{{"login", login}, {"password", password}}));
    if (response.status != 200) return;
    const std::string& set = response.headers["set-cookie"];
    secrets_[set.substr(15, 64)] = "session token of " + login;
    secrets_[std::string(Parsed(response).at("csrf").as_string())] = "csrf of " + login;
  }
  void Holds(const std::string& where, const std::string& text) {
    EXPECT_FALSE(text.empty()) << where;
    for (const auto& [secret, what] : secrets_) {
      EXPECT_EQ(text.find(secret), std::string::npos) << where << " has the " << what;
    }
  }

  std::ostringstream log_;
  std::shared_ptr<spdlog::logger> before_;
  School school_;
  ops::Metrics metrics_;
  std::unique_ptr<RunningServer> server_;
  std::string refusals_;
  std::map<std::string, std::string> secrets_;  // and what they are
};

TEST_F(SecretsTest, AreNotInLogAuditMetricsOrRefusals) {
  SignIn("sam", "wrong-password-of-sam");
  SignIn("password-typed-as-login", "another-wrong-password");
  SignIn("sam", kPassword);
  Visitor root(server_->port(), "root");
  secrets_[root.cookie.substr(15)] = "session token of root";
  secrets_[root.csrf] = "csrf of root";

  secrets_["not-the-password-of-root"] = "confirmation that failed";
  Send(root, "/api/v1/session/confirm", R"({"password":"not-the-password-of-root"})");
  secrets_["chosen-by-nobody-1"] = "new password that was refused";
  Send(root, "/api/v1/session/password",
       R"({"old_password":"not-the-password-of-root","new_password":"chosen-by-nobody-1"})");
  Send(root, "/api/v1/session/password",
       std::string(R"({"old_password":")") + kPassword + R"(","new_password":1})");

  json::value roster = Parsed(Send(root, "/api/v1/roster", "login\nkim\nlee\n", "text/csv"));
  for (const auto& made : roster.at("passwords").as_array()) {
    secrets_[std::string(made.at("password").as_string())] = "one-time password of a roster";
  }
  Send(root, "/api/v1/roster", "login,login\n", "text/csv");
  json::value code = Parsed(Send(root, "/api/v1/enrolment-codes", "{}"));
  secrets_[std::string(code.at("code").as_string()).substr(0, 32)] = "enrolment code";
  json::value reset =
      Parsed(Send(root, "/api/v1/people/" + school_.sam.Text() + "/password", "{}"));
  std::string once(reset.at("password").as_string());
  secrets_[once] = "one-time password of sam";
  Visitor sam(server_->port());
  RawResponse in = Send(sam, "/api/v1/session",
                        json::serialize(json::object{{"login", "sam"}, {"password", once}}));
  sam.cookie = in.headers["set-cookie"].substr(0, 79);
  ASSERT_EQ(in.status, 200) << in.body;
  sam.csrf = std::string(Parsed(in).at("csrf").as_string());
  secrets_[sam.cookie.substr(15)] = "session token of sam";
  secrets_[sam.csrf] = "csrf of sam";
  secrets_["a chosen one of sam's"] = "password that was chosen";
  RawResponse changed =
      Send(sam, "/api/v1/session/password",
           json::serialize(
               json::object{{"old_password", once}, {"new_password", "a chosen one of sam's"}}));
  ASSERT_EQ(changed.status, 200) << changed.body;
  secrets_[changed.headers["set-cookie"].substr(15, 64)] = "next session token of sam";
  secrets_["804217930516"] = "PIN of root";
  EXPECT_EQ(Send(root, "/api/v1/session/pin", R"({"pin":"804217930516"})", kJsonType, "PUT").status,
            204);
  secrets_["222222222222"] = "PIN that was refused";
  EXPECT_EQ(Send(root, "/api/v1/session/pin", R"({"pin":"222222222222"})", kJsonType, "PUT").status,
            400);
  root.Get("/api/v1/no/such/path");
  school_.authenticator->refusals().Settle();
  spdlog::info("the log is read");

  Holds("the audit trail", root.Get("/api/v1/audit?limit=1000").body);
  Holds("the metrics", root.Get("/metrics").body);
  Holds("a refusal", refusals_);
  Holds("a list", root.Get("/api/v1/people").body + root.Get("/api/v1/sessions").body +
                      root.Get("/api/v1/enrolment-codes").body);
  spdlog::default_logger()->flush();
  Holds("the log", log_.str());
  ASSERT_GE(secrets_.size(), 14u);
  // The search can find it: the answer to the reset has it.
  EXPECT_NE(json::serialize(reset).find(once), std::string::npos);
}

}  // namespace
}  // namespace enamel::server::http
