#include "station/session/workplace.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include "station/session/practice_list.h"
#include "tests/station/session/kept_attempt.h"
#include "tests/station/session/log_lines.h"
#include "tests/station/uplink/fake_server.h"
#include "tests/support/temp_folder.h"

namespace enamel::station {
namespace {

namespace fs = std::filesystem;

constexpr char kPin[] = "804217";

class WorkplaceTest : public testing::Test {
 protected:
  WorkplaceTest() {
    server_.emplace(folder_);
    Credentials credentials = server_->NewStation();
    credentials.ticket_key = ticket_keys_.public_key;
    EXPECT_TRUE(SaveCredentials(folder_ / "data", credentials).ok());
    workplace_ = std::move(*Workplace::Open({.data = folder_ / "data"}));
  }
  ~WorkplaceTest() override { workplace_.reset(); }

  // As the server would issue it.
  trace::Ticket Ticket() {
    trace::Ticket ticket;
    ticket.attempt = Uuid::New();
    ticket.station = workplace_->credentials().station;
    ticket.expires_unix_ms = int64_t{1} << 60;
    return ticket;
  }
  Status Prepare(const trace::Ticket& ticket) {
    EXPECT_TRUE(TicketSafe(workplace_->spool()).Put(ticket, {}, kPin).ok());
    return workplace_->PrepareReserved(ticket.attempt, kPin).status();
  }

  Uuid Reserved() {
    trace::Ticket ticket;
    ticket.attempt = Uuid::New();
    ticket.expires_unix_ms = int64_t{1} << 60;
    EXPECT_TRUE(TicketSafe(workplace_->spool()).Put(ticket, {}, kPin).ok());
    return ticket.attempt;
  }

  test::TempFolder temp_;
  const fs::path folder_ = temp_.path();
  trace::KeyPair ticket_keys_ = trace::NewKeyPair();
  std::optional<FakeServer> server_;
  std::unique_ptr<Workplace> workplace_;
};

TEST_F(WorkplaceTest, PractisesWithoutTheServerWhatItsCacheHasAndNothingGraded) {
  const KeptDocuments practice = KeepDocuments(folder_ / "data", "pointer", false);
  const KeptDocuments graded = KeepDocuments(folder_ / "data", "pointer", true);
  server_->assignments = {Uuid::New(), Uuid::New()};
  server_->describe = [&](size_t i, wire::ExerciseRef& ref) {
    ref.set_name(i == 0 ? practice.exercise.name : "graded");
    ref.set_exercise(protocol::ToField((i == 0 ? practice : graded).exercise_hash.view()));
  };
  server_->profiles = {{"pointer", practice.profile_hash}, {"omega3", HashSha256(AsBytes("lost"))}};
  EXPECT_FALSE(workplace_->RemembersPractice());
  ASSERT_TRUE(workplace_->SignIn("ada", "secret").ok());
  auto listed = workplace_->Exercises();
  ASSERT_TRUE(listed.ok());
  workplace_->Describe(*listed);
  workplace_->SignOut();
  server_.reset();
  EXPECT_TRUE(workplace_->RemembersPractice());
  Catalogue here = workplace_->Practices();
  ASSERT_EQ(here.exercises.size(), 1u);
  EXPECT_EQ(here.exercises[0].exercise, practice.exercise_hash);
  EXPECT_EQ(here.exercises[0].title, practice.exercise.title);
  EXPECT_FALSE(here.exercises[0].facts->graded);
  ASSERT_EQ(here.profiles.size(), 1u) << "the other is not in the cache";
  const auto prepared = workplace_->PreparePractice(here.exercises[0], here.profiles[0]);
  ASSERT_TRUE(prepared.ok()) << prepared.status().message();
  EXPECT_TRUE(prepared->attempt().IsZero());

  // Whoever writes that file makes no graded exercise practice.
  Catalogue forged = here;
  forged.exercises[0].exercise = graded.exercise_hash;
  KeepPracticeList(folder_ / "data", forged, 0);
  EXPECT_TRUE(workplace_->Practices().exercises.empty());
  EXPECT_EQ(workplace_->PreparePractice(forged.exercises[0], here.profiles[0]).status().code(),
            Code::kForbidden);
  KeepPracticeList(folder_ / "data", here, 0);

  // One document after the other is damaged: the cache checks them by their names.
  const std::string scene = practice.exercise.scene.Hex(),
                    volume = scene::SceneFromJson(AsText(*ReadFile(folder_ / "data/blobs" / scene)))
                                 ->volume.Hex();
  for (const std::string& name : {practice.exercise_hash.Hex(), scene, volume}) {
    const fs::path file = folder_ / "data/blobs" / name;
    const Bytes whole = *ReadFile(file);
    ASSERT_TRUE(WriteFileDurably(file, ByteView(whole).first(whole.size() - 1)).ok());
    EXPECT_TRUE(workplace_->Practices().exercises.empty()) << name;
    EXPECT_FALSE(workplace_->PreparePractice(here.exercises[0], here.profiles[0]).ok());
    ASSERT_TRUE(WriteFileDurably(file, whole).ok());
    EXPECT_EQ(workplace_->Practices().exercises.size(), 1u);
  }
}

TEST_F(WorkplaceTest, TicketIsGivenBackWithItsPin) {
  Uuid attempt = Reserved();
  EXPECT_EQ(workplace_->GiveBack(attempt, "804218").status().code(), Code::kUnauthenticated);
  EXPECT_EQ(workplace_->Reserved()->size(), 1u);
  auto given = workplace_->GiveBack(attempt, kPin);
  ASSERT_TRUE(given.ok()) << given.status().message();
  EXPECT_EQ(*given, HandedBack::kAtServer);
  EXPECT_TRUE(std::ranges::count(server_->returned(), attempt) > 0);
  EXPECT_TRUE(workplace_->Reserved()->empty());
  EXPECT_EQ(workplace_->GiveBack(attempt, kPin).status().code(), Code::kNotFound);
}

TEST_F(WorkplaceTest, WithoutTheServerItIsGivenBackHereAndReturnedLater) {
  Uuid attempt = Reserved();
  uint16_t port = server_->endpoint().port;
  server_.reset();
  auto given = workplace_->GiveBack(attempt, kPin);
  ASSERT_TRUE(given.ok()) << given.status().message();
  EXPECT_EQ(*given, HandedBack::kLater);
  EXPECT_TRUE(workplace_->Reserved()->empty());
  EXPECT_EQ(workplace_->PrepareReserved(attempt, kPin).status().code(), Code::kNotFound);
  server_.emplace(folder_, port);
  workplace_->uploader().Retry();
  while (!workplace_->spool().tickets().List()->empty()) std::this_thread::yield();
  EXPECT_EQ(server_->returned().front(), attempt);
}

TEST_F(WorkplaceTest, ForgottenPinNeedsASignInAndTheServersWord) {
  Uuid attempt = Reserved();
  EXPECT_EQ(workplace_->GiveBack(attempt).status().code(), Code::kUnauthenticated);
  ASSERT_TRUE(workplace_->SignIn("ada", "secret").ok());
  EXPECT_FALSE(workplace_->GiveBack(attempt).ok()) << "somebody else's, says the server";
  EXPECT_EQ(workplace_->Reserved()->size(), 1u);
  server_->seen.insert(attempt);
  auto given = workplace_->GiveBack(attempt);
  ASSERT_TRUE(given.ok()) << given.status().message();
  EXPECT_EQ(*given, HandedBack::kAtServer);
  EXPECT_TRUE(workplace_->person().has_value()) << "and is still signed in";
}

TEST_F(WorkplaceTest, WhoHasToChooseAPasswordIsToldWhere) {
  workplace_.reset();
  server_->must_change_password = true;
  server_->SetPageUrl("https://enamel.example.edu");
  workplace_ = std::move(*Workplace::Open({.data = folder_ / "data"}));
  Status refused = workplace_->SignIn("ada", "secret").status();
  EXPECT_EQ(refused.code(), Code::kForbidden);
  EXPECT_EQ(refused.field(), kOneTimePassword);
  EXPECT_NE(refused.message().find("Open https://enamel.example.edu on"), std::string::npos)
      << refused.message();
}

TEST_F(WorkplaceTest, ReservedTicketIsCheckedBeforeAnAttemptBeginsOnIt) {
  trace::Ticket right = Ticket();
  trace::SignTicket(right, ticket_keys_.secret_key);
  EXPECT_EQ(Prepare(right).code(), Code::kNotFound) << "its documents are not in the cache";

  trace::Ticket unsigned_one = Ticket();
  EXPECT_EQ(Prepare(unsigned_one).code(), Code::kForbidden);

  trace::Ticket elsewhere = Ticket();
  elsewhere.station = Uuid::New();
  trace::SignTicket(elsewhere, ticket_keys_.secret_key);
  EXPECT_EQ(Prepare(elsewhere).code(), Code::kForbidden);

  // The row may claim anything.
  trace::Ticket expired = Ticket();
  expired.expires_unix_ms = 1;
  trace::SignTicket(expired, ticket_keys_.secret_key);
  ASSERT_TRUE(
      TicketSafe(workplace_->spool(), [] { return int64_t{0}; }).Put(expired, {}, kPin).ok());
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open((folder_ / "data" / "spool.sqlite").c_str(), &db), SQLITE_OK);
  EXPECT_EQ(
      sqlite3_exec(db, "UPDATE tickets SET expires_unix_ms = 1 << 60", nullptr, nullptr, nullptr),
      SQLITE_OK);
  sqlite3_close(db);
  Status refused = workplace_->PrepareReserved(expired.attempt, kPin).status();
  EXPECT_EQ(refused.code(), Code::kForbidden);
  EXPECT_NE(refused.message().find("expired"), std::string::npos) << refused.message();
}

TEST_F(WorkplaceTest, ConnectionThatTheServerLetGoOfIsMadeAnewBySigningIn) {
  ASSERT_TRUE(workplace_->SignIn("ada", "secret").ok());
  uint16_t port = server_->endpoint().port;
  server_.reset();
  server_.emplace(folder_, port);
  auto person = workplace_->SignIn("ada", "secret");
  EXPECT_TRUE(person.ok()) << person.status().message();
}

TEST_F(WorkplaceTest, SignInsAndOutsAreLoggedByIdAndWithoutWhatWasTyped) {
  LogLines log;
  const std::string id = server_->person.Text();
  ASSERT_TRUE(workplace_->SignIn("ada-login", "ada-password").ok());
  workplace_->SignOut();
  workplace_->SignOut();  // nobody is
  ASSERT_TRUE(workplace_->SignIn("ada-login", "ada-password").ok());
  server_.reset();
  EXPECT_FALSE(workplace_->Exercises().ok()) << "finds that the connection is lost";
  EXPECT_EQ(workplace_->Exercises().status().code(), Code::kUnauthenticated);
  EXPECT_FALSE(workplace_->SignIn("ada-login", "ada-password").ok());
  const std::string said = log.text();
  auto count = [&](const std::string& words) {
    size_t n = 0;
    for (size_t at = 0; (at = said.find(words, at)) != std::string::npos; ++at) ++n;
    return n;
  };
  EXPECT_EQ(count("person " + id + " (student) has signed in"), 2u) << said;
  EXPECT_EQ(count("person " + id + " has signed out"), 1u) << said;
  EXPECT_EQ(count("person " + id + " is signed out: the connection"), 1u) << said;
  EXPECT_EQ(count("warning: a sign-in failed: "), 1u) << said;
  EXPECT_EQ(count("ada-"), 0u) << said;
}

TEST_F(WorkplaceTest, SecondPersonSignsWithoutASignInAndLeavesNothingHere) {
  LogLines log;
  const Uuid attempt = Uuid::New();
  auto signer = workplace_->SignOff(attempt, SignedAt::kStart, "ines-login", kPin);
  ASSERT_TRUE(signer.ok()) << signer.status().message();
  EXPECT_EQ(*signer, "Ada");
  ASSERT_EQ(server_->sign_offs().size(), 1u);
  const wire::SignOff first = server_->sign_offs()[0];
  EXPECT_EQ(first.attempt(), protocol::ToField(attempt.view()));
  EXPECT_EQ(first.at(), "start");
  EXPECT_EQ(first.login(), "ines-login");
  EXPECT_EQ(first.pin(), kPin);
  server_->refuse_sign_offs = Status(Code::kUnauthenticated, "login or PIN is wrong");
  EXPECT_EQ(workplace_->SignOff(attempt, SignedAt::kEnd, "ines-login", "271804").status().code(),
            Code::kUnauthenticated);
  EXPECT_EQ(server_->sign_offs()[1].at(), "end");
  const std::string said = log.text();
  for (const char* secret : {"ines-login", kPin, "271804"}) {
    EXPECT_EQ(said.find(secret), std::string::npos) << said;
  }
  EXPECT_NE(said.find(attempt.Text()), std::string::npos) << said;
}

TEST_F(WorkplaceTest, SignatureOverALostConnectionIsTriedOnceMoreOnANewOne) {
  ASSERT_TRUE(workplace_->SignIn("ada", "secret").ok());
  uint16_t port = server_->endpoint().port;
  server_.reset();
  const auto away = workplace_->SignOff(Uuid::New(), SignedAt::kEnd, "ines", kPin).status();
  EXPECT_EQ(away.code(), Code::kUnavailable);
  EXPECT_NE(away.message().find("the server is away"), std::string::npos) << away.message();
  EXPECT_FALSE(workplace_->person().has_value()) << "the sign-in went with its connection";
  server_.emplace(folder_, port);
  EXPECT_TRUE(workplace_->SignOff(Uuid::New(), SignedAt::kEnd, "ines", kPin).ok());
}

TEST_F(WorkplaceTest, SigningOutEndsAStepThatWaitsForAServerThatHangs) {
  ASSERT_TRUE(workplace_->SignIn("ada", "secret").ok());
  server_->silent = true;
  Status ended;
  std::thread asking([&] { ended = workplace_->Exercises().status(); });
  while (server_->unanswered == 0) std::this_thread::yield();
  workplace_->SignOut();
  asking.join();
  EXPECT_EQ(ended.field(), "cancelled") << "it waited to the end: " << ended.message();
  EXPECT_FALSE(workplace_->person().has_value());
  server_->silent = false;
  EXPECT_TRUE(workplace_->SignIn("ada", "secret").ok()) << "on a connection of its own";
  EXPECT_TRUE(workplace_->Exercises().ok());
}

TEST_F(WorkplaceTest, ASignInThatWasLeftDoesNotTakePlaceAfterAll) {
  server_->silent = true;
  Status ended;
  std::thread asking([&] { ended = workplace_->SignIn("ada", "secret").status(); });
  while (server_->unanswered == 0) std::this_thread::yield();
  workplace_->SignOut();
  asking.join();
  EXPECT_FALSE(ended.ok());
  EXPECT_FALSE(workplace_->person().has_value());
}

// A server that accepts the connection and never answers.
TEST_F(WorkplaceTest, ASignInThatIsLeftWhileConnectingIsNotLoggedAsFailed) {
  asio::io_context io;
  asio::ip::tcp::acceptor mute(io, {asio::ip::address_v4::loopback(), 0});
  workplace_.reset();
  workplace_ = std::move(
      *Workplace::Open({.data = folder_ / "data",
                        .server = "127.0.0.1:" + std::to_string(mute.local_endpoint().port())}));
  LogLines log;
  Status ended;
  const auto uploads = mute.accept();  // the upload's
  std::thread asking([&] { ended = workplace_->SignIn("ada", "secret").status(); });
  const auto asked = mute.accept();
  workplace_->SignOut();
  asking.join();
  EXPECT_TRUE(IsStopped(ended)) << ended.message();
  EXPECT_EQ(log.text().find("a sign-in failed"), std::string::npos) << log.text();
  workplace_.reset();
}

TEST_F(WorkplaceTest, WhatAPersonHandedInIsFoundNewestFirst) {
  ASSERT_TRUE(workplace_->SignIn("ada", "secret").ok());
  std::vector<Uuid> hers;
  for (int i = 0; i < 4; ++i) {
    trace::Header header = HeaderOf(i == 1 ? Uuid::New() : server_->person);
    ASSERT_TRUE(workplace_->spool().BeginAttempt(header, "class-1", "pointer").ok());
    trace::Seal seal;
    seal.attempt = header.ticket.attempt;
    if (i < 3) ASSERT_TRUE(workplace_->spool().PutSeal(seal).ok());
    if (i == 0 || i == 2) hers.push_back(header.ticket.attempt);
  }
  auto found = workplace_->HandedInOf(server_->person, 5);
  ASSERT_TRUE(found.ok());
  ASSERT_EQ(found->size(), 2u) << "neither somebody else's nor what has no end";
  EXPECT_EQ((*found)[0].id, hers[1]);
  EXPECT_EQ((*found)[1].id, hers[0]);
  EXPECT_EQ(workplace_->HandedInOf(server_->person, 1)->size(), 1u);
}

}  // namespace
}  // namespace enamel::station
