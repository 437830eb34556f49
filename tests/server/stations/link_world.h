#pragma once

#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>

#include "common/protocol/refusals.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/plan.h"
#include "server/app/data_folder.h"
#include "server/app/publish.h"
#include "server/auth/token.h"
#include "server/stations/session.h"
#include "tests/server/storage/store_world.h"
#include "tests/support/wire_seal.h"

// A server's side of the station link with real content, and a scripted station with keys of its
// own.
namespace enamel::server::stations::testing {

using namespace server::testing;

inline constexpr auth::PasswordCost kCheap{1, 8192};
inline constexpr char kPassword[] = "correct horse battery";
inline constexpr char kPin[] = "804217";

inline auth::AuthOptions CheapAuth() {
  auth::AuthOptions options;
  options.cost = kCheap;
  return options;
}

struct LinkWorld {
  LinkWorld() {
    verifier = *auth::HashPassword(kPassword, kCheap);
    student = AddPerson(*store, "student", Role::kStudent, verifier);
    instructor = AddPerson(*store, "instructor", Role::kInstructor, verifier);
    AddPerson(*store, "outsider", Role::kStudent, verifier);
    cohort = *store->cohorts.CreateCohort("year 1", kSystem);
    EXPECT_TRUE(store->cohorts.AddToCohort(cohort, student, kSystem).ok());
    EXPECT_TRUE(store->cohorts.AddToCohort(cohort, instructor, kSystem).ok());
    EXPECT_TRUE(app::PublishProfiles(*store).ok());
    scene = *app::PublishScene(store->blobs, store->scenes, "builtin:block", 150'000);
    exercise = *app::PublishClassOne(store->blobs, store->exercises, scene, cohort);
    EXPECT_TRUE(
        store->stations.AddEnrolCode(HashSha256(AsBytes("code")), UnixMs{1} << 60, kSystem).ok());
  }

  void GivePin(const Uuid& person) {
    EXPECT_TRUE(store->people.SetPin(person, *auth::HashPassword(kPin, kCheap), kSystem).ok());
  }

  Sha256 Profile(const std::string& name) {
    std::vector<ProfileRow> profiles = *store->profiles.Profiles();
    for (const ProfileRow& row : profiles) {
      if (row.name == name) return row.content;
    }
    return {};
  }

  TempFolder folder;
  std::unique_ptr<Store> store = OpenStore(folder.path());
  auth::Authenticator authenticator{*store, CheapAuth()};
  LiveBoard live;
  Content content{*store};
  static constexpr UnixMs kStart = 1'700'000'000'000;
  UnixMs now = kStart;
  Services services{*store,  authenticator,         live,
                    content, trace::NewKeyPair(),   "enamel-server test",
                    "0.9.3", [this] { return now; }};
  std::string verifier;
  Uuid student, instructor, cohort;
  SceneRow scene;
  ExerciseRow exercise;
};

// Carries a request to the session as a connection does.
inline Answer CarryTo(Session& session, const wire::Request& request) {
  auth::Authenticator& authenticator = session.authenticator();
  if (auto who = session.SignInWanted(request)) {
    return session.FinishSignIn(request, authenticator.SignInHere(*who));
  }
  if (session.welcomed() && request.has_choose_password()) {
    auto wanted = session.PasswordWanted(request);
    if (!wanted.ok()) return session.FinishSignIn(request, wanted.status());
    boost::asio::io_context io;
    std::optional<Result<auth::SignedIn>> changed;
    boost::asio::co_spawn(
        io,
        [&]() -> boost::asio::awaitable<void> {
          changed.emplace(co_await authenticator.ChangePassword(wanted->identity, wanted->change));
        },
        [](const std::exception_ptr& failed) { EXPECT_FALSE(failed); });
    io.run();
    return session.FinishSignIn(request, *changed);
  }
  if (auto who = session.SignOffWanted(request)) {
    return session.FinishSignOff(request, authenticator.CheckPinHere(*who));
  }
  return session.Handle(request);
}

// Forbidden, or no longer possible, to a person: the chair has a sentence for each reason.
inline void ExpectSayable(const wire::Request& request, const wire::Reply& reply) {
  const bool of_a_person = request.has_sign_in() || request.has_choose_password() ||
                           request.has_request_ticket() || request.has_sign_off() ||
                           request.has_mark_reference();
  if (!of_a_person || !reply.has_error()) return;
  const Status why = protocol::ToStatus(reply.error());
  if (why.code() != Code::kForbidden && why.code() != Code::kConflict) return;
  EXPECT_TRUE(protocol::IsListed(why.code(), why.field()))
      << CodeName(why.code()) << " \"" << why.field()
      << "\" is not in kRefusals: " << why.message();
}

// Makes requests; `Ask` carries one to the server and back, over a Session or over TLS.
class ScriptedStation {
 public:
  using Ask = std::function<wire::Reply(wire::Request)>;
  explicit ScriptedStation(Ask ask) : ask_(std::move(ask)) {}

  wire::Reply Send(wire::Request request) {
    request.set_id(++last_id_);
    wire::Reply reply = ask_(request);
    EXPECT_EQ(reply.reply_to(), last_id_);
    ExpectSayable(request, reply);
    return reply;
  }

  wire::Reply Enrol(const std::string& code = "code", const std::string& name = "scripted",
                    const std::optional<Uuid>& as = {}) {
    wire::Request request;
    wire::Enrol& enrol = *request.mutable_enrol();
    enrol.set_protocol_version(1);
    enrol.set_code(code);
    enrol.set_name(name);
    enrol.set_public_key(protocol::ToField(keys.public_key));
    if (as) enrol.set_station_id(protocol::ToField(as->view()));
    wire::Reply reply = Send(request);
    if (reply.has_enrolled()) {
      id = reply.enrolled().station_id();
      credential = reply.enrolled().credential();
    }
    return reply;
  }

  wire::Reply Hello(uint32_t version = 1) {
    wire::Request request;
    wire::Hello& hello = *request.mutable_hello();
    hello.set_protocol_version(version);
    hello.set_station_id(id);
    hello.set_credential(credential);
    hello.set_core_version(core_version);
    return Send(request);
  }

  wire::Reply SignIn(const std::string& login, const std::string& password = kPassword) {
    wire::Request request;
    request.mutable_sign_in()->set_login(login);
    request.mutable_sign_in()->set_password(password);
    wire::Reply reply = Send(request);
    if (reply.has_signed_in()) session = reply.signed_in().session();
    return reply;
  }

  wire::Reply ChoosePassword(const std::string& old_password, const std::string& new_password) {
    wire::Request request;
    wire::ChoosePassword& body = *request.mutable_choose_password();
    body.set_session(session);
    body.set_old_password(old_password);
    body.set_new_password(new_password);
    wire::Reply reply = Send(request);
    if (reply.has_signed_in()) session = reply.signed_in().session();
    return reply;
  }

  wire::Reply RequestTicket(const Sha256& exercise, const Sha256& profile,
                            bool as_reference = false) {
    wire::Request request;
    wire::RequestTicket& body = *request.mutable_request_ticket();
    body.set_station_unix_ms(clock());
    body.set_session(session);
    body.set_exercise(protocol::ToField(exercise.view()));
    body.set_profile(protocol::ToField(profile.view()));
    body.set_as_reference(as_reference);
    if (hand.kind != HandKind::kNotTold) protocol::SetHand(hand, *body.mutable_hand());
    return Send(request);
  }

  wire::Reply RequestTicketFor(const Uuid& assignment, const Sha256& exercise,
                               const Sha256& profile) {
    wire::Request request;
    wire::RequestTicket& body = *request.mutable_request_ticket();
    body.set_station_unix_ms(clock());
    body.set_session(session);
    body.set_exercise(protocol::ToField(exercise.view()));
    body.set_profile(protocol::ToField(profile.view()));
    body.set_assignment(protocol::ToField(assignment.view()));
    return Send(request);
  }

  wire::Reply SignOff(const Uuid& attempt, const std::string& at, const std::string& login,
                      const std::string& pin) {
    wire::Request request;
    wire::SignOff& body = *request.mutable_sign_off();
    body.set_attempt(protocol::ToField(attempt.view()));
    body.set_at(at);
    body.set_login(login);
    body.set_pin(pin);
    return Send(request);
  }

  wire::Reply ReturnTicket(const Uuid& attempt) {
    wire::Request request;
    request.mutable_return_ticket()->set_attempt(protocol::ToField(attempt.view()));
    return Send(request);
  }

  wire::Reply OfferTickets(const std::vector<Uuid>& attempts) {
    wire::Request request;
    for (const Uuid& attempt : attempts) {
      request.mutable_offer_attempts()->add_tickets(protocol::ToField(attempt.view()));
    }
    return Send(request);
  }

  wire::Reply Open(const Bytes& header, bool resumed = false) {
    protocol::AttemptFacts facts;
    facts.set_resumed(resumed ? 1 : 0);
    return Open(header, facts);
  }
  wire::Reply Open(const Bytes& header, const protocol::AttemptFacts& facts) {
    wire::Request request;
    request.mutable_open_attempt()->set_header(protocol::ToField(header));
    *request.mutable_open_attempt()->mutable_facts() = facts;
    return Send(request);
  }

  wire::Reply Put(const Bytes& chunk) {
    wire::Request request;
    request.mutable_put_chunk()->set_chunk(protocol::ToField(chunk));
    return Send(request);
  }

  wire::Reply Seal(const trace::Seal& seal) {
    wire::Request request;
    test::FillSeal(seal, *request.mutable_seal_attempt());
    return Send(request);
  }

  wire::Reply Status(const Uuid& attempt) {
    wire::Request request;
    request.mutable_attempt_status()->set_session(session);
    request.mutable_attempt_status()->set_attempt(protocol::ToField(attempt.view()));
    return Send(request);
  }

  wire::Reply Deviation(const Uuid& attempt) {
    wire::Request request;
    request.mutable_get_deviation()->set_session(session);
    request.mutable_get_deviation()->set_attempt(protocol::ToField(attempt.view()));
    return Send(request);
  }

  wire::Reply MarkReference(const Uuid& attempt, const std::string& dentist, bool consent,
                            const std::string& anyway = {}) {
    wire::Request request;
    wire::MarkReference& body = *request.mutable_mark_reference();
    body.set_session(session);
    body.set_attempt(protocol::ToField(attempt.view()));
    body.set_dentist(dentist);
    body.set_consent(consent);
    body.set_anyway(anyway);
    return Send(request);
  }

  trace::KeyPair keys = trace::NewKeyPair();
  // The station's own; as the server's at first.
  std::function<UnixMs()> clock = [] { return LinkWorld::kStart; };
  std::string id, credential, session;
  uint32_t core_version = core::kCoreVersion;

  Hand hand;  // that a ticket is asked for with

 private:
  Ask ask_;
  uint32_t last_id_ = 0;
};

// A recording made from a ticket: header and chunks, chained and signed.
struct Recording {
  Recording(LinkWorld& world, const Bytes& encoded_ticket, const trace::KeyPair& keys,
            uint32_t chunk_count, const Hand& hand = {.kind = HandKind::kProgram}) {
    header_fields.hand = hand;
    header_fields.ticket = *trace::DecodeTicket(encoded_ticket);
    header_fields.scene = world.scene.content;
    header_fields.volume = world.scene.volume;
    auto text = [&](const Sha256& hash) { return *world.store->blobs.GetBlob(hash); };
    header_fields.params =
        *scene::CompilePlan(*scene::SceneFromJson(AsText(text(world.scene.content))),
                            *scene::ExerciseFromJson(AsText(text(header_fields.ticket.exercise))),
                            *scene::ProfileFromJson(AsText(text(header_fields.ticket.profile))));
    header_fields.station_software = "scripted";
    header = trace::EncodeHeader(header_fields);
    Sha256 previous = HashSha256(header);
    for (uint32_t seq = 0; seq < chunk_count; ++seq) {
      chunks.push_back(Chunk(seq, previous, keys));
      previous = trace::DecodeChunkHead(chunks.back())->hash;
    }
    auto last = *trace::DecodeChunkHead(chunks.back());
    seal = {header_fields.ticket.attempt, chunk_count, uint64_t{chunk_count} * kTicks, last.hash,
            last.head.state_hash};
  }

  Bytes Chunk(uint32_t seq, const Sha256& previous, const trace::KeyPair& keys,
              int32_t salt = 0) const {
    std::vector<trace::Tick> ticks(kTicks);
    for (size_t i = 0; i < ticks.size(); ++i)
      ticks[i].input.counts[1] = static_cast<int32_t>(i) * 3 + salt;
    trace::ChunkHead head;
    head.attempt = header_fields.ticket.attempt;
    head.seq = seq;
    head.first_tick = uint64_t{seq} * kTicks;
    head.state_hash = 77 + seq;
    head.previous = previous;
    return trace::EncodeChunk(head, ticks, keys.secret_key);
  }

  static constexpr uint32_t kTicks = 100;
  trace::Header header_fields;
  Bytes header;
  std::vector<Bytes> chunks;
  trace::Seal seal;
};

inline Bytes TicketOf(const wire::Reply& reply) {
  ByteView view = AsBytes(reply.ticket_issued().ticket());
  return Bytes(view.begin(), view.end());
}

// The world's student, signed in at a station that is enrolled and connected; without TLS.
class StudentAtStation : public ::testing::Test {
 protected:
  StudentAtStation() {
    EXPECT_TRUE(station_.Enrol().has_enrolled());
    session_.End();
    std::destroy_at(&session_);
    std::construct_at(&session_, world_.services, "127.0.0.1");
    EXPECT_TRUE(station_.Hello().has_welcome());
    EXPECT_TRUE(station_.SignIn("student").has_signed_in());
    station_.clock = [this] { return world_.now; };
  }

  wire::Reply Carry(const wire::Request& request) {
    return CarryTo(session_, request).reply.value_or(wire::Reply());
  }

  LinkWorld world_;
  Session session_{world_.services, "127.0.0.1"};
  ScriptedStation station_{[this](const wire::Request& request) { return Carry(request); }};
  Sha256 profile_ = world_.Profile("phantom_desktop");
};

}  // namespace enamel::server::stations::testing
