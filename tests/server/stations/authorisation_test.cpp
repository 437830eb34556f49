#include <gtest/gtest.h>

#include <map>
#include <set>

#include "server/stations/session.h"
#include "tests/server/stations/link_world.h"
#include "tests/support/wire_seal.h"

// The access rights of the station link: every message of the protocol has a line here.
namespace enamel::server::stations {
namespace {

using namespace testing;

// The columns:
//   unknown  connected, has not said Hello
//   nobody   admitted station, nobody signed in
//   student  of the cohort; outsider: of none; instructor: of the cohort
//   once     a student with a password for one use
//   ended    a student who was disabled while signed in
//   revoked  admitted station until a moment ago, student signed in
// "ok", or the error's code.
constexpr const char* kColumns[] = {"unknown",    "nobody", "student", "outsider",
                                    "instructor", "once",   "ended",   "revoked"};

struct Line {
  const char* message;
  std::map<std::string, std::string> expected;
};

std::map<std::string, std::string> In(std::initializer_list<const char*> codes) {
  std::map<std::string, std::string> out;
  size_t i = 0;
  for (const char* code : codes) out[kColumns[i++]] = code;
  return out;
}

constexpr char kNo[] = "unauthenticated";

// clang-format off
std::vector<Line> Lines() {
  return {
  //                            unknown nobody        student       outsider      instructor    once          ended         revoked
    {"hello",          In({     "ok",   "invalid_input", "invalid_input", "invalid_input", "invalid_input", "invalid_input", "invalid_input", "invalid_input"})},
    {"enrol",          In({     kNo,    "invalid_input", "invalid_input", "invalid_input", "invalid_input", "invalid_input", "invalid_input", "invalid_input"})},
    {"sign_in",        In({     kNo,    "ok",         "ok",         "ok",         "ok",         "ok",         kNo,          kNo})},
    {"choose_password", In({    kNo,    kNo,          "forbidden",  "forbidden",  "forbidden",  "ok",         kNo,          kNo})},
    {"list_exercises", In({     kNo,    kNo,          "ok",         "ok",         "ok",         "forbidden",  kNo,          kNo})},
    {"get_blob",       In({     kNo,    "ok",         "ok",         "ok",         "ok",         "ok",         "ok",         kNo})},
    {"request_ticket", In({     kNo,    kNo,          "ok",         "forbidden",  "ok",         "forbidden",  kNo,          kNo})},
    {"open_attempt",   In({     kNo,    "ok",         "ok",         "ok",         "ok",         "ok",         "ok",         kNo})},
    {"put_chunk",      In({     kNo,    "ok",         "ok",         "ok",         "ok",         "ok",         "ok",         kNo})},
    {"seal_attempt",   In({     kNo,    "ok",         "ok",         "ok",         "ok",         "ok",         "ok",         kNo})},
    {"attempt_status", In({     kNo,    kNo,          "ok",         "not_found",  "ok",         "forbidden",  kNo,          kNo})},
    {"get_deviation",  In({     kNo,    kNo,          "conflict",   "not_found",  "conflict",   "forbidden",  kNo,          kNo})},
    {"mark_reference", In({     kNo,    kNo,          "forbidden",  "not_found",  "conflict",   "forbidden",  kNo,          kNo})},
    {"offer_attempts", In({     kNo,    "ok",         "ok",         "ok",         "ok",         "ok",         "ok",         kNo})},
    {"return_ticket",  In({     kNo,    "ok",         "ok",         "ok",         "ok",         "ok",         "ok",         kNo})},
    // Of an attempt that needs no signature; whoever is signed in does not matter (sign_off_test).
    {"sign_off",       In({     kNo,    "conflict",   "conflict",   "conflict",   "conflict",   "conflict",   "conflict",   kNo})},
    {"live_state",     In({     kNo,    "ok",         "ok",         "ok",         "ok",         "ok",         "ok",         kNo})},
    {"measure",        In({     kNo,    "invalid_input", "invalid_input", "invalid_input", "invalid_input", "invalid_input", "invalid_input", kNo})},
    {"ping",           In({     kNo,    "ok",         "ok",         "ok",         "ok",         "ok",         "ok",         kNo})},
  };
}
// clang-format on

class LinkAuthorisationTest : public ::testing::Test {
 protected:
  LinkAuthorisationTest() {
    // An attempt of the student's that was ticketed at this station and waits to be sent.
    EXPECT_TRUE(station_.Enrol().has_enrolled());
    Reconnect();
    EXPECT_TRUE(station_.Hello().has_welcome());
    EXPECT_TRUE(station_.SignIn("student").has_signed_in());
    auto reply = station_.RequestTicket(world_.exercise.content, profile_);
    EXPECT_TRUE(reply.has_ticket_issued()) << reply.error().message();
    recording_.emplace(world_, TicketOf(reply), station_.keys, 1);
    AddPerson(*world_.store, "once", Role::kStudent, world_.verifier);
    Uuid once = world_.store->people.PersonByLogin("once")->id;
    EXPECT_TRUE(world_.store->cohorts.AddToCohort(world_.cohort, once, kSystem).ok());
    EXPECT_TRUE(world_.store->people.SetPassword(once, world_.verifier, true, kSystem).ok());
    world_.GivePin(world_.instructor);
  }

  std::optional<wire::Reply> Carry(const wire::Request& request) {
    return CarryTo(session_, request).reply;
  }
  void Reconnect() {
    session_.End();
    std::destroy_at(&session_);
    std::construct_at(&session_, world_.services, "127.0.0.1");
  }
  // Brings the connection into the state that the column names.
  void Become(const std::string& column) {
    Reconnect();
    ASSERT_TRUE(world_.store->people.SetDisabled(world_.student, false, kSystem).ok());
    if (column == "unknown") return;
    ASSERT_TRUE(station_.Hello().has_welcome());
    if (column == "nobody") return;
    bool student = column == "ended" || column == "revoked";
    ASSERT_TRUE(station_.SignIn(student ? "student" : column).has_signed_in()) << column;
    if (column == "ended") {
      ASSERT_TRUE(world_.store->people.SetDisabled(world_.student, true, kSystem).ok());
    }
    if (column == "revoked") {
      ASSERT_TRUE(world_.store->stations.RevokeStation(session_.station()->id, kSystem).ok());
      world_.now += kAdmittedEveryMs;
    }
  }

  wire::Request RequestOf(const std::string& message) {
    wire::Request out;
    if (message == "hello") {
      out.mutable_hello()->set_protocol_version(1);
      out.mutable_hello()->set_station_id(station_.id);
      out.mutable_hello()->set_credential(station_.credential);
    } else if (message == "enrol") {
      out.mutable_enrol()->set_protocol_version(1);
      out.mutable_enrol()->set_code("used");
      out.mutable_enrol()->set_name("n");
      out.mutable_enrol()->set_public_key(protocol::ToField(station_.keys.public_key));
    } else if (message == "sign_in") {
      out.mutable_sign_in()->set_login("student");
      out.mutable_sign_in()->set_password(kPassword);
    } else if (message == "choose_password") {
      out.mutable_choose_password()->set_session(station_.session);
      out.mutable_choose_password()->set_old_password(kPassword);
      out.mutable_choose_password()->set_new_password("kettle orbit plum fence");
    } else if (message == "list_exercises") {
      out.mutable_list_exercises()->set_session(station_.session);
    } else if (message == "get_blob") {
      out.mutable_get_blob()->set_sha256(protocol::ToField(world_.exercise.content.view()));
    } else if (message == "request_ticket") {
      auto& ticket = *out.mutable_request_ticket();
      ticket.set_session(station_.session);
      ticket.set_station_unix_ms(world_.now);
      ticket.set_exercise(protocol::ToField(world_.exercise.content.view()));
      ticket.set_profile(protocol::ToField(profile_.view()));
    } else if (message == "open_attempt") {
      out.mutable_open_attempt()->set_header(protocol::ToField(recording_->header));
    } else if (message == "put_chunk") {
      (void)Carry(RequestOf("open_attempt"));
      out.mutable_put_chunk()->set_chunk(protocol::ToField(recording_->chunks[0]));
    } else if (message == "seal_attempt") {
      (void)Carry(RequestOf("put_chunk"));
      test::FillSeal(recording_->seal, *out.mutable_seal_attempt());
    } else if (message == "attempt_status") {
      out.mutable_attempt_status()->set_session(station_.session);
      out.mutable_attempt_status()->set_attempt(protocol::ToField(recording_->seal.attempt.view()));
    } else if (message == "get_deviation") {
      out.mutable_get_deviation()->set_session(station_.session);
      out.mutable_get_deviation()->set_attempt(protocol::ToField(recording_->seal.attempt.view()));
    } else if (message == "mark_reference") {
      auto& mark = *out.mutable_mark_reference();
      mark.set_session(station_.session);
      mark.set_attempt(protocol::ToField(recording_->seal.attempt.view()));
      mark.set_dentist("Dr. Vega");
      mark.set_consent(true);
    } else if (message == "offer_attempts") {
      out.mutable_offer_attempts();
    } else if (message == "return_ticket") {
      out.mutable_return_ticket()->set_attempt(protocol::ToField(recording_->seal.attempt.view()));
    } else if (message == "sign_off") {
      auto& sign = *out.mutable_sign_off();
      sign.set_attempt(protocol::ToField(recording_->seal.attempt.view()));
      sign.set_at("start");
      sign.set_login("instructor");
      sign.set_pin(kPin);
    } else if (message == "live_state") {
      out.mutable_live_state();
    } else if (message == "measure") {
      out.mutable_measure();
    } else if (message == "ping") {
      out.mutable_ping();
    } else {
      ADD_FAILURE() << "no request for " << message;
    }
    out.set_id(99);
    return out;
  }

  LinkWorld world_;
  Session session_{world_.services, "127.0.0.1"};
  ScriptedStation station_{[this](const wire::Request& request) { return *Carry(request); }};
  Sha256 profile_ = world_.Profile("phantom_desktop");
  std::optional<Recording> recording_;
};

TEST(LinkMessagesTest, EveryMessageOfTheProtocolHasALine) {
  std::set<std::string> lines, messages;
  for (const Line& line : Lines()) lines.insert(line.message);
  const auto* body = wire::Request::descriptor()->FindOneofByName("body");
  for (int i = 0; i < body->field_count(); ++i) messages.insert(body->field(i)->name());
  EXPECT_EQ(lines, messages);
}

// One fresh world for each cell: what one message changes does not colour the next.
class LinkCellTest : public LinkAuthorisationTest,
                     public ::testing::WithParamInterface<std::string> {};

std::vector<std::string> Messages() {
  std::vector<std::string> out;
  for (const Line& line : Lines()) out.emplace_back(line.message);
  return out;
}

INSTANTIATE_TEST_SUITE_P(Messages, LinkCellTest, ::testing::ValuesIn(Messages()),
                         [](const auto& info) { return info.param; });

TEST_P(LinkCellTest, GetsWhatTheTableSays) {
  std::map<std::string, std::string> expected;
  for (const Line& line : Lines()) {
    if (line.message == GetParam()) expected = line.expected;
  }
  // Those after which the world is another come last.
  for (const char* column : kColumns) {
    ASSERT_NO_FATAL_FAILURE(Become(column));
    auto reply = Carry(RequestOf(GetParam()));
    std::string code = !reply || !reply->has_error() ? "ok" : reply->error().code();
    EXPECT_EQ(code, expected.at(column))
        << GetParam() << " by " << column << ": " << (reply ? reply->error().message() : "");
  }
}

TEST_F(LinkAuthorisationTest, RevokedStationIsToldAndItsConnectionEnds) {
  ASSERT_NO_FATAL_FAILURE(Become("student"));
  ASSERT_TRUE(world_.store->stations.RevokeStation(session_.station()->id, kSystem).ok());
  EXPECT_FALSE(session_.Handle(RequestOf("get_blob")).close) << "not looked at yet";
  world_.now += kAdmittedEveryMs;
  Answer answer = session_.Handle(RequestOf("get_blob"));
  EXPECT_TRUE(answer.close);
  EXPECT_NE(answer.reply->error().message().find("no longer admitted"), std::string::npos);
  Reconnect();
  EXPECT_EQ(station_.Hello().error().code(), kNo);
}

TEST_F(LinkAuthorisationTest, RevokedStationSignsNobodyIn) {
  ASSERT_NO_FATAL_FAILURE(Become("revoked"));
  wire::Request request = RequestOf("sign_in");
  auto signed_in = world_.authenticator.SignInHere(*session_.SignInWanted(request));
  ASSERT_TRUE(signed_in.ok());
  Answer answer = session_.FinishSignIn(request, signed_in);
  EXPECT_TRUE(answer.close);
  EXPECT_FALSE(answer.reply->has_signed_in());
  EXPECT_FALSE(world_.authenticator.Authenticate(signed_in->token).ok());
}

TEST_F(LinkAuthorisationTest, PasswordForOneUseIsToldAtSignIn) {
  ASSERT_NO_FATAL_FAILURE(Become("nobody"));
  EXPECT_TRUE(station_.SignIn("once").signed_in().must_change_password());
  EXPECT_FALSE(station_.SignIn("student").signed_in().must_change_password());
}

TEST_F(LinkAuthorisationTest, OneTimePasswordIsUsedUpOnlyByTheNewOne) {
  constexpr char kNew[] = "kettle orbit plum fence";
  ASSERT_NO_FATAL_FAILURE(Become("once"));
  const auto refused = [&](const std::string& old, const std::string& fresh) {
    const wire::Error error = station_.ChoosePassword(old, fresh).error();
    return error.code() + " " + error.field();
  };
  EXPECT_EQ(refused(kPassword, "short"), "invalid_input new_password");
  EXPECT_EQ(refused(kPassword, std::string(300, 'x')), "invalid_input new_password");
  EXPECT_EQ(refused(kPassword, kPassword), "invalid_input new_password");
  EXPECT_EQ(refused("another one", kNew), "forbidden password");
  EXPECT_EQ(refused(std::string(300, 'x'), kNew), "forbidden password");
  EXPECT_TRUE(station_.SignIn("once").signed_in().must_change_password()) << "it still works";

  const std::string before = station_.session;
  const wire::Reply chosen = station_.ChoosePassword(kPassword, kNew);
  ASSERT_TRUE(chosen.has_signed_in()) << chosen.error().message();
  EXPECT_FALSE(chosen.signed_in().must_change_password());
  EXPECT_TRUE(Carry(RequestOf("list_exercises"))->has_exercises());
  EXPECT_EQ(refused(kNew, "another plum fence kettle"), "forbidden session") << "only at first";
  station_.session = before;
  EXPECT_EQ(Carry(RequestOf("list_exercises"))->error().code(), kNo) << "its session has ended";
  EXPECT_EQ(station_.SignIn("once").error().code(), kNo);
  EXPECT_TRUE(station_.SignIn("once", kNew).has_signed_in());
}

TEST_F(LinkAuthorisationTest, WrongOneTimePasswordsSlowDownAsSignInsDo) {
  ASSERT_NO_FATAL_FAILURE(Become("once"));
  wire::Reply reply;
  for (int i = 0; i < 100 && reply.error().field() != "throttled"; ++i) {
    reply = station_.ChoosePassword("another one", "kettle orbit plum fence");
  }
  EXPECT_EQ(reply.error().code(), "unavailable") << "tries without an end";
}

TEST_F(LinkAuthorisationTest, StationIsToldWhereThePageIs) {
  EXPECT_EQ(station_.Hello().welcome().page_url(), "");
  world_.services.page_url = "https://enamel.example.edu";
  ASSERT_NO_FATAL_FAILURE(Become("nobody"));
  Reconnect();
  EXPECT_EQ(station_.Hello().welcome().page_url(), "https://enamel.example.edu");
  ASSERT_TRUE(station_.SignIn("once").has_signed_in());
  wire::Reply refused = *Carry(RequestOf("list_exercises"));
  EXPECT_EQ(refused.error().code(), "forbidden");
  EXPECT_NE(refused.error().message().find("https://enamel.example.edu"), std::string::npos)
      << refused.error().message();
}

TEST_F(LinkAuthorisationTest, StationIsGivenTheNarrowestOfEachSetting) {
  ASSERT_FALSE(station_.Hello().welcome().has_policy());
  const std::string name = world_.store->stations.StationById(session_.station()->id)->name;
  const auto put = [&](const char* setting, const std::string& scope, const char* value,
                       bool fixed) {
    EXPECT_TRUE(world_.store->settings.PutSetting({setting, scope, value, fixed, 0}, kSystem).ok());
  };
  put("language", name, "zh", false);
  put("language", "*", "de", true);
  put("keep-days", name.substr(0, 2) + "*", "30", true);
  put("keep-days", name.substr(0, 1) + "*", "20", false);
  put("quality", "other-*", "low", true);
  Reconnect();
  const wire::Policy policy = station_.Hello().welcome().policy();
  ASSERT_EQ(policy.settings_size(), 2);
  EXPECT_EQ(policy.settings(0).name(), "keep-days");
  EXPECT_EQ(policy.settings(0).value(), "30");
  EXPECT_TRUE(policy.settings(0).fixed());
  EXPECT_EQ(policy.settings(1).value(), "zh");
  EXPECT_FALSE(policy.settings(1).fixed());
}

TEST_F(LinkAuthorisationTest, WhatAStationRunsIsCutBetweenCharacters) {
  wire::Request hello = RequestOf("hello");
  hello.mutable_hello()->set_software(std::string(199, 'x') + "\u00e9\u00e9");
  Reconnect();
  ASSERT_TRUE(Carry(hello)->has_welcome());
  EXPECT_EQ(world_.store->stations.StationById(session_.station()->id)->software,
            std::string(199, 'x'));
}

TEST_F(LinkAuthorisationTest, SoftwareThatIsNoNameIsRefused) {
  for (const char* software : {"x\x1b[2J", "a\nb", "\u202egnp"}) {
    wire::Request hello = RequestOf("hello");
    hello.mutable_hello()->set_software(software);
    Reconnect();
    EXPECT_EQ(Carry(hello)->error().field(), "software");
  }
}

// The world's server is 0.9.3.
TEST_F(LinkAuthorisationTest, AReleaseMoreThanAMinorVersionAwayIsRefused) {
  for (const char* near : {"", "0.8.0", "0.9.0", "0.10.7"}) {
    wire::Request hello = RequestOf("hello");
    hello.mutable_hello()->set_release(near);
    Reconnect();
    EXPECT_TRUE(Carry(hello)->has_welcome()) << near;
  }
  for (const char* message : {"hello", "enrol"}) {
    wire::Request request = RequestOf(message);
    if (request.has_hello()) request.mutable_hello()->set_release("0.11.0");
    if (request.has_enrol()) request.mutable_enrol()->set_release("0.11.0");
    Reconnect();
    const wire::Error error = Carry(request)->error();
    EXPECT_EQ(error.code(), "version") << message;
    EXPECT_EQ(error.field(), "release") << message;
    EXPECT_FALSE(session_.station().has_value());
  }
}

TEST_F(LinkAuthorisationTest, HelloLeavesWhatTheStationRuns) {
  wire::Request hello = RequestOf("hello");
  hello.mutable_hello()->set_software("enamel-station 0.1.0");
  hello.mutable_hello()->set_core_version(7);
  Reconnect();
  ASSERT_TRUE(Carry(hello)->has_welcome());
  StationRow row = *world_.store->stations.StationById(session_.station()->id);
  EXPECT_EQ(row.software, "enamel-station 0.1.0");
  EXPECT_EQ(row.core_version, 7u);
}

}  // namespace
}  // namespace enamel::server::stations
