#include <gtest/gtest.h>

#include "common/base/pin.h"
#include "server/http/etag.h"
#include "server/http/routes.h"
#include "tests/server/http/running_server.h"

namespace enamel::server::http {
namespace {

const std::string kJson = "Content-Type: application/json\r\n";

class SessionTest : public testing::Test {
 protected:
  School school_;
  RunningServer server_{school_};
  Visitor nobody_{server_.port()};

  RawResponse SignIn(const std::string& login, const std::string& password,
                     const std::string& headers = kJson) {
    return nobody_.Send("POST", "/api/v1/session", headers,
                        R"({"login":")" + login + R"(","password":")" + password + R"("})");
  }
};

TEST_F(SessionTest, SignInSetsAStrictCookieThatOpensTheSession) {
  RawResponse response = SignIn("sam", kPassword);
  ASSERT_EQ(response.status, 200) << response.body;
  std::string cookie = response.headers["set-cookie"];
  EXPECT_TRUE(cookie.starts_with("enamel_session="));
  EXPECT_EQ(cookie.find("; Path=/; HttpOnly; SameSite=Strict, "), 79u) << cookie;
  EXPECT_EQ(Parsed(response).at("person").at("role"), "student");
  Visitor sam(server_.port(), "sam");
  boost::json::value session = Parsed(sam.Get("/api/v1/session"));
  EXPECT_EQ(session.at("person").at("id"), school_.sam.Text().c_str());
  EXPECT_EQ(session.at("csrf"), sam.csrf.c_str());
}

TEST_F(SessionTest, WrongPasswordAndUnknownLoginGetTheSameAnswer) {
  RawResponse wrong = SignIn("sam", "not the password");
  RawResponse unknown = SignIn("nobody", "not the password");
  EXPECT_EQ(wrong.status, 401);
  EXPECT_EQ(unknown.status, 401);
  EXPECT_EQ(wrong.body, unknown.body);
  EXPECT_FALSE(wrong.headers.contains("set-cookie"));
}

TEST_F(SessionTest, GuessingIsSlowedDownWith429) {
  RawResponse last;
  for (int i = 0; i < 40 && last.status != 429; ++i) last = SignIn("sam", "not the password");
  EXPECT_EQ(last.status, 429);
  EXPECT_EQ(ErrorCode(last), "throttled");
  EXPECT_TRUE(last.headers.contains("retry-after"));
}

TEST_F(SessionTest, ABrowserThatSignedInIsNotDelayedByGuessesFromItsAddress) {
  const std::string cookies = SignIn("sam", kPassword).headers["set-cookie"];
  const std::string device = cookies.substr(cookies.find("enamel_device="));
  EXPECT_TRUE(device.ends_with("; Path=/; HttpOnly; SameSite=Strict; Max-Age=2592000")) << device;
  nobody_.cookie.clear();
  for (int i = 0; i < 12; ++i) (void)SignIn("sam", "not the password");
  EXPECT_EQ(SignIn("sam", kPassword).status, 429);
  nobody_.cookie = device.substr(0, device.find(';'));
  EXPECT_EQ(SignIn("sam", kPassword).status, 200);
}

TEST_F(SessionTest, InstructorChoosesAPinThatSigns) {
  Visitor ada(server_.port(), "ada");
  auto choose = [&](const std::string& pin) {
    return ada.Send("PUT", "/api/v1/session/pin", kJson + "X-Enamel-Csrf: " + ada.csrf + "\r\n",
                    R"({"pin":")" + pin + "\"}");
  };
  auto holds = [&](const std::string& pin) {
    return school_.authenticator->CheckPinHere({"Ada", pin, "127.0.0.1", auth::kViaStation}).ok();
  };
  EXPECT_FALSE(holds("")) << "none yet";
  ASSERT_EQ(choose("804217").status, 204);
  EXPECT_TRUE(holds("804217"));
  for (const auto& [pin, rule] : {std::pair{"12345", "pin"},
                                  {"121212", "pin_repeats"},
                                  {"123456", "pin_run"},
                                  {"240699", "pin_date"}}) {
    RawResponse refused = choose(pin);
    EXPECT_EQ(refused.status, 400) << pin;
    EXPECT_EQ(Parsed(refused).at("error").at("field"), rule) << pin;
  }
  EXPECT_TRUE(holds("804217")) << "what was refused changes nothing";
  ASSERT_EQ(choose("271804").status, 204);
  EXPECT_TRUE(holds("271804"));
  EXPECT_FALSE(holds("804217"));
  EXPECT_EQ(SignIn("ada", "271804").status, 401) << "it does not sign in";
}

TEST_F(SessionTest, LockedPinIsShownAndANewOneUnlocksItWithThePassword) {
  Visitor ada(server_.port(), "ada");
  auto choose = [&] {
    return ada.Send("PUT", "/api/v1/session/pin", kJson + "X-Enamel-Csrf: " + ada.csrf + "\r\n",
                    R"({"pin":"804217"})");
  };
  const auto is_locked = [&] { return Parsed(ada.Get("/api/v1/session")).at("pin_locked"); };
  auto check = [&] {
    return school_.authenticator->CheckPinHere({"ada", "804217", "127.0.0.1", auth::kViaStation});
  };
  EXPECT_EQ(is_locked(), false);
  ASSERT_EQ(choose().status, 204);
  const Uuid id = school_.store->people.PersonByLogin("ada")->id;
  for (int i = 0; i < 10; ++i) (void)school_.store->people.TryPin(id);
  EXPECT_EQ(is_locked(), true);
  EXPECT_EQ(check().status().field(), kPinLocked);
  ASSERT_EQ(choose().status, 204) << "signed in with the password just now";
  EXPECT_EQ(is_locked(), false);
  EXPECT_TRUE(check().ok());
}

TEST_F(SessionTest, TheLanguageThatSomebodyChoseIsThereAtTheNextSignIn) {
  EXPECT_EQ(Parsed(SignIn("sam", kPassword)).at("language"), "");
  Visitor sam(server_.port(), "sam");
  auto choose = [&](const std::string& body) {
    return sam.Send("PUT", "/api/v1/session/language",
                    kJson + "X-Enamel-Csrf: " + sam.csrf + "\r\n", body);
  };
  RawResponse chosen = choose(R"({"language":"de"})");
  ASSERT_EQ(chosen.status, 200) << chosen.body;
  EXPECT_EQ(Parsed(chosen).at("language"), "de");
  EXPECT_EQ(Parsed(sam.Get("/api/v1/session")).at("language"), "de");
  EXPECT_EQ(Parsed(SignIn("sam", kPassword)).at("language"), "de");
  EXPECT_EQ(Parsed(SignIn("sue", kPassword)).at("language"), "") << "another's stays";
  for (const char* body : {R"({"language":"fr"})", R"({"language":"DE"})", R"({"language":1})",
                           R"({})", R"({"language":"de","person":"x"})"}) {
    RawResponse refused = choose(body);
    EXPECT_EQ(refused.status, 400) << body;
  }
  EXPECT_EQ(Parsed(choose(R"({"language":""})")).at("language"), "");
}

TEST_F(SessionTest, RefusesBodiesThatAreNotTheTwoTexts) {
  for (const char* body :
       {"", "[]", "{", R"({"login":"sam"})", R"({"login":"sam","password":1})",
        R"({"login":"","password":"x"})", R"({"login":"sam","password":"x","role":"admin"})"}) {
    RawResponse response = nobody_.Send("POST", "/api/v1/session", kJson, body);
    EXPECT_EQ(response.status, 400) << body;
    EXPECT_EQ(ErrorCode(response), "invalid_input");
  }
  EXPECT_EQ(SignIn("sam", kPassword, "Content-Type: text/plain\r\n").status, 415);
}

TEST_F(SessionTest, MemberThatIsThereTwiceIsRefusedByName) {
  for (const char* body : {R"({"login":"sue","login":"sam","password":"x"})",
                           R"({"login":"sue","password":"x","\u006cogin":"sam"})",
                           R"({"login":"sue","password":"x","more":[{"login":1,"login":2}]})"}) {
    RawResponse response = nobody_.Send("POST", "/api/v1/session", kJson, body);
    EXPECT_EQ(response.status, 400) << body;
    EXPECT_EQ(Parsed(response).at("error").at("field"), "login") << body;
  }
}

TEST_F(SessionTest, RefusesSignInFromAnotherSite) {
  RawResponse response = SignIn("sam", kPassword, kJson + "Origin: http://evil.example\r\n");
  EXPECT_EQ(response.status, 403);
  EXPECT_EQ(SignIn("sam", kPassword, kJson + "Sec-Fetch-Site: cross-site\r\n").status, 403);
  EXPECT_EQ(SignIn("sam", kPassword, kJson + "Origin: http://localhost\r\n").status, 200);
}

TEST_F(SessionTest, WithoutASessionOnlySignInAndHealthAnswer) {
  EXPECT_EQ(nobody_.Get("/healthz").status, 200);
  for (const Route& route : Routes()) {
    if (route.need == Need::kNobody) continue;
    std::string target(route.pattern);
    if (size_t place = target.find("{id}"); place != std::string::npos) {
      target.replace(place, 4, school_.sams_scored.Text());
    }
    if (size_t place = target.find("{name}"); place != std::string::npos) {
      target.replace(place, 6, "phantom_desktop");
    }
    RawResponse response = nobody_.Send(MethodName(route.method), target, "");
    EXPECT_EQ(response.status, 401) << target;
    EXPECT_EQ(ErrorCode(response), "unauthenticated");
  }
}

TEST_F(SessionTest, ExpiredSessionIsRefused) {
  Visitor sam(server_.port(), "sam");
  EXPECT_EQ(sam.Get("/api/v1/session").status, 200);
  school_.now_ms += 24 * 60 * 60 * 1000;
  RawResponse late = sam.Get("/api/v1/session");
  EXPECT_EQ(late.status, 401);
  EXPECT_NE(late.body.find("sign in again"), std::string::npos);
}

TEST_F(SessionTest, MadeUpTokensAreRefused) {
  for (const char* cookie : {"enamel_session=", "enamel_session=00", "enamel_session=zz"}) {
    nobody_.cookie = cookie;
    EXPECT_EQ(nobody_.Get("/api/v1/session").status, 401) << cookie;
  }
}

TEST_F(SessionTest, SignOutEndsTheSessionAndRemovesTheCookie) {
  Visitor sam(server_.port(), "sam");
  RawResponse out = sam.Send("DELETE", "/api/v1/session", "X-Enamel-Csrf: " + sam.csrf + "\r\n");
  EXPECT_EQ(out.status, 204);
  EXPECT_NE(out.headers["set-cookie"].find("Max-Age=0"), std::string::npos);
  EXPECT_EQ(out.headers["clear-site-data"], "\"cache\"") << "recordings that the browser kept";
  EXPECT_EQ(sam.Get("/api/v1/session").status, 401);
}

TEST_F(SessionTest, RefusalsAndSignOutsAreInAuditAndFiguresWithTheAddress) {
  ops::Metrics metrics;
  HttpOptions options;
  options.metrics = &metrics;
  RunningServer counted(school_, options);
  Visitor root(counted.port(), "root"), sam(counted.port(), "sam");
  Visitor(counted.port())
      .Send("POST", "/api/v1/session", kJson, R"({"login":"sam","password":"wrong"})");
  EXPECT_EQ(sam.Get("/api/v1/people").status, 403);
  EXPECT_EQ(sam.Send("DELETE", "/api/v1/session", "").status, 403) << "without csrf";
  EXPECT_EQ(sam.Send("DELETE", "/api/v1/session", "X-Enamel-Csrf: " + sam.csrf + "\r\n").status,
            204);
  school_.authenticator->refusals().Settle();
  auto one = [&](const std::string& action) {
    auto rows = Parsed(root.Get("/api/v1/audit?action=" + action)).at("audit").as_array();
    EXPECT_EQ(rows.size(), 1u) << action;
    if (rows.empty()) return std::string();
    EXPECT_EQ(rows[0].at("object"), school_.sam.Text().c_str()) << action;
    return std::string(rows[0].at("after").as_string());
  };
  EXPECT_EQ(one("session.refused"), R"({"address":"127.0.0.1","count":"1","reason":"password"})");
  EXPECT_EQ(
      one("request.refused"),
      R"({"address":"127.0.0.1","count":"1","reason":"forbidden","request":"GET /api/v1/people"})");
  EXPECT_EQ(one("session.end"), R"({"address":"127.0.0.1"})");
  const std::string figures = root.Get("/metrics").body;
  for (const char* line : {"enamel_sign_ins_total{outcome=\"refused\"} 1\n",
                           "enamel_sign_outs_total 1\n", "enamel_http_forbidden_total 2\n"}) {
    EXPECT_NE(figures.find(line), std::string::npos) << line << figures;
  }
}

TEST_F(SessionTest, ChangesNeedTheCsrfValueOfThisSession) {
  Visitor ada(server_.port(), "ada"), ben(server_.port(), "ben");
  const std::string target = "/api/v1/attempts/" + school_.sams_scored.Text() + "/release";
  EXPECT_EQ(ada.Send("POST", target, "").status, 403);
  EXPECT_EQ(ada.Send("POST", target, "X-Enamel-Csrf: " + ben.csrf + "\r\n").status, 403);
  EXPECT_EQ(ada.Send("POST", target, "X-Enamel-Csrf: " + ada.csrf + "\r\nOrigin: null\r\n").status,
            403);
  EXPECT_FALSE(school_.store->attempts.AttemptById(school_.sams_scored)->released);
  const std::string seen =
      ETagOf(school_.store->attempts.AttemptById(school_.sams_scored)->revision);
  EXPECT_EQ(
      ada.Send("POST", target, "X-Enamel-Csrf: " + ada.csrf + "\r\nIf-Match: " + seen + "\r\n")
          .status,
      204);
  EXPECT_TRUE(school_.store->attempts.AttemptById(school_.sams_scored)->released);
}

}  // namespace
}  // namespace enamel::server::http
