#include "server/stations/session.h"

#include <algorithm>

#include "common/base/utf8.h"
#include "common/protocol/release.h"
#include "server/auth/token.h"
#include "server/training/access.h"
#include "server/training/names.h"

// Identity: hello, enrolment, sign-in; and downloads of stations.
namespace enamel::server::stations {
namespace {

constexpr size_t kMaxStationNameBytes = 64;
constexpr size_t kMaxSoftwareBytes = 200;

Status CheckProtocolVersion(uint32_t version) {
  if (version == protocol::kProtocolVersion) return Status::Ok();
  const std::string spoken = version == 0 ? "that of an earlier Enamel" : std::to_string(version);
  return Status(Code::kVersion,
                "this server speaks protocol version " +
                    std::to_string(protocol::kProtocolVersion) + ", the station speaks " + spoken +
                    "; install matching versions",
                "protocol_version");
}

Answer AnswerOf(const wire::Request& request, const Result<wire::Reply>& result, bool close) {
  Answer out;
  out.close = close;
  out.reply.emplace();
  if (result.ok()) {
    *out.reply = *result;
  } else {
    *out.reply->mutable_error() = protocol::ToError(result.status());
  }
  out.reply->set_reply_to(request.id());
  return out;
}

}  // namespace

Status RevokedStation() {
  return Status(Code::kUnauthenticated,
                "this station is no longer admitted; enrol it with a new code");
}

Answer Session::Handle(const wire::Request& request) {
  bool introduces = request.has_hello() || request.has_enrol();
  if (!station_ && !introduces) {
    return AnswerOf(request, Status(Code::kUnauthenticated, "send Hello or Enrol first"), true);
  }
  if (introduces && station_) {
    return AnswerOf(request, Status(Code::kInvalidInput, "this connection has sent Hello already"),
                    true);
  }
  // A request of a newer station parses with an empty body: the station gets `unsupported` and may
  // continue with what both know.
  if (request.body_case() == wire::Request::BODY_NOT_SET) {
    wire::Reply reply;
    *reply.mutable_error() = protocol::UnsupportedError();
    return AnswerOf(request, reply, false);
  }
  if (station_) {
    if (Status admitted = StillAdmitted(); !admitted.ok()) {
      return AnswerOf(request, admitted, true);
    }
    NoteHeard();
  }
  // Has no answer: it comes up to 60 times a second, and the next one replaces it.
  if (request.has_live_state()) {
    Take(request.live_state());
    return {};
  }
  about_ = {};
  auto result = Dispatch(request);
  // Enrol ends the connection too (schemas/wire): the credential is first used on a new one.
  Answer out =
      AnswerOf(request, result, request.has_enrol() || (request.has_hello() && !result.ok()));
  out.attempt = about_;
  return out;
}

bool Session::KnownAdmitted() const {
  UnixMs now = services_.clock();
  // A clock that was set back would otherwise let a revoked station continue for as long.
  return !station_ || (now >= admitted_ms_ && now - admitted_ms_ < kAdmittedEveryMs);
}

Status Session::StillAdmitted() {
  UnixMs now = services_.clock();
  if (KnownAdmitted()) return Status::Ok();
  ENAMEL_ASSIGN_OR_RETURN(auto station, services_.store.stations.StationById(station_->id));
  if (station.revoked) return RevokedStation();
  admitted_ms_ = now;
  if (now - noted_ms_ < kNotedEveryMs) return Status::Ok();
  // A list that is a minute old tomorrow is no reason to turn the station away.
  (void)services_.store.stations.TouchStation(station_->id, software_, station_core_version_, now);
  noted_ms_ = now;
  return Status::Ok();
}

void Session::NoteHeard() {
  if (entered_) entered_->Heard(services_.clock());
}

Result<wire::Reply> Session::Dispatch(const wire::Request& request) {
  switch (request.body_case()) {
    case wire::Request::kHello:
      return Do(request.hello());
    case wire::Request::kEnrol:
      return Do(request.enrol());
    case wire::Request::kListExercises:
      return Do(request.list_exercises());
    case wire::Request::kGetBlob:
      return Do(request.get_blob());
    case wire::Request::kRequestTicket:
      return Do(request.request_ticket());
    case wire::Request::kOpenAttempt:
      return Do(request.open_attempt());
    case wire::Request::kPutChunk:
      return Do(request.put_chunk());
    case wire::Request::kSealAttempt:
      return Do(request.seal_attempt());
    case wire::Request::kAttemptStatus:
      return Do(request.attempt_status());
    case wire::Request::kGetDeviation:
      return Do(request.get_deviation());
    case wire::Request::kMarkReference:
      return Do(request.mark_reference());
    case wire::Request::kOfferAttempts:
      return Do(request.offer_attempts());
    case wire::Request::kReturnTicket:
      return Do(request.return_ticket());
    case wire::Request::kPing:
      return Do(request.ping());
    case wire::Request::kMeasure:
      return Status(Code::kInvalidInput, "expected this from another server, found a station");
    default:
      return Status(Code::kInternal, "request without a handler");
  }
}

Result<wire::Reply> Session::Do(const wire::Hello& hello) {
  ENAMEL_RETURN_IF_ERROR(CheckProtocolVersion(hello.protocol_version()));
  ENAMEL_RETURN_IF_ERROR(protocol::MayMeet(services_.release, hello.release()));
  ENAMEL_ASSIGN_OR_RETURN(auto id, protocol::ReadUuid(hello.station_id(), "station_id"));
  // Shortened and not refused: it is for a list that an admin reads, and no reason to turn a
  // station away.
  std::string software = ShortenedText(hello.software(), kMaxSoftwareBytes);
  if (!software.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(auto checked, CheckedName(software, "software"));
    software = checked;
  }
  auto station = services_.store.stations.StationByCredential(
      id, auth::TokenHash(AsBytes(hello.credential())));
  if (!station.ok() && station.status().code() != Code::kNotFound) return station.status();
  if (!station.ok() || station->revoked) {
    return Status(Code::kUnauthenticated,
                  "this server does not know the station or no longer admits it; enrol it with a "
                  "new code (if the server was restored from an older backup: with enrol --again, "
                  "so that recordings made here stay valid)");
  }
  const UnixMs now = services_.clock();
  const bool noted = station->last_seen_ms <= now && now - station->last_seen_ms < kNotedEveryMs &&
                     station->software == software && station->core_version == hello.core_version();
  // Else a station that connects again and again would write each time.
  if (!noted) {
    ENAMEL_RETURN_IF_ERROR(
        services_.store.stations.TouchStation(id, software, hello.core_version(), now));
  }
  station_ = *station;
  shows_remarks_ = hello.shows_remarks();
  if (services_.board != nullptr) entered_ = services_.board->Enter(id, shows_remarks_);
  station_core_version_ = hello.core_version();
  software_ = software;
  admitted_ms_ = now;
  noted_ms_ = noted ? station->last_seen_ms : now;
  NoteHeard();

  ENAMEL_ASSIGN_OR_RETURN(auto policy, services_.store.settings.PolicyFor(station->name));
  wire::Reply reply;
  wire::Welcome& welcome = *reply.mutable_welcome();
  welcome.set_protocol_version(protocol::kProtocolVersion);
  welcome.set_server_software(services_.software);
  welcome.set_core_version(core::kCoreVersion);
  welcome.set_server_unix_ms(services_.clock());
  welcome.set_ticket_key(protocol::ToField(services_.ticket_key.public_key));
  welcome.set_page_url(services_.page_url);
  if (policy.settings_size() > 0) *welcome.mutable_policy() = std::move(policy);
  return reply;
}

Result<wire::Reply> Session::Do(const wire::Enrol& enrol) {
  ENAMEL_RETURN_IF_ERROR(CheckProtocolVersion(enrol.protocol_version()));
  ENAMEL_RETURN_IF_ERROR(protocol::MayMeet(services_.release, enrol.release()));
  ENAMEL_ASSIGN_OR_RETURN(auto key, protocol::ReadKey(enrol.public_key(), "public_key"));
  if (enrol.name().empty() || enrol.name().size() > kMaxStationNameBytes) {
    return Status(Code::kInvalidInput,
                  "a station's name has 1 to " + std::to_string(kMaxStationNameBytes) + " bytes",
                  "name");
  }
  ENAMEL_ASSIGN_OR_RETURN(auto name, CheckedName(enrol.name(), "name"));
  StationRow row;
  row.name = name;
  row.public_key.assign(key.begin(), key.end());
  if (!enrol.station_id().empty()) {
    ENAMEL_ASSIGN_OR_RETURN(auto id, protocol::ReadUuid(enrol.station_id(), "station_id"));
    row.id = id;
  }
  // Made here and sent once; the store keeps its hash.
  Bytes credential = auth::NewToken();
  ENAMEL_ASSIGN_OR_RETURN(auto station, services_.store.stations.EnrolStation(
                                            HashSha256(AsBytes(enrol.code())), row,
                                            auth::TokenHash(credential), services_.clock()));

  wire::Reply reply;
  wire::Enrolled& enrolled = *reply.mutable_enrolled();
  enrolled.set_station_id(protocol::ToField(station.id.view()));
  enrolled.set_credential(protocol::ToField(credential));
  enrolled.set_ticket_key(protocol::ToField(services_.ticket_key.public_key));
  return reply;
}

std::optional<auth::SignInRequest> Session::SignInWanted(const wire::Request& request) const {
  if (!station_ || !request.has_sign_in()) return std::nullopt;
  return auth::SignInRequest{request.sign_in().login(),
                             request.sign_in().password(),
                             peer_address_,
                             auth::kViaStation,
                             station_->name,
                             {},
                             {},
                             {},
                             station_->id.Text()};
}

Answer Session::FinishSignIn(const wire::Request& request, const Result<auth::SignedIn>& result) {
  Status admitted = StillAdmitted();
  // Revoked while the password was being hashed: the session that came of it is of no use to
  // anybody.
  if (!admitted.ok() && result.ok()) {
    (void)services_.authenticator.SignOut(result->identity.token_hash);
  }
  if (!admitted.ok()) return AnswerOf(request, admitted, true);
  if (!result.ok()) return AnswerOf(request, result.status(), false);
  // The new password has ended it.
  if (request.has_choose_password()) {
    signed_in_.erase(auth::TokenHash(AsBytes(request.choose_password().session())));
  }
  if (signed_in_.size() >= kMaxSignedIn) {
    (void)services_.authenticator.SignOut(result->identity.token_hash);
    return AnswerOf(request,
                    Status(Code::kTooLarge, "too many people signed in on this connection"), false);
  }
  signed_in_.insert(result->identity.token_hash);
  wire::Reply reply;
  wire::SignedIn& out = *reply.mutable_signed_in();
  out.set_person_id(protocol::ToField(result->identity.person.id.view()));
  out.set_display_name(result->identity.person.display_name);
  out.set_role(RoleName(result->identity.person.role));
  out.set_session(protocol::ToField(result->token));
  out.set_must_change_password(result->identity.person.must_change_password);
  return AnswerOf(request, reply, false);
}

std::optional<auth::SignInRequest> Session::SignOffWanted(const wire::Request& request) const {
  if (!station_ || !request.has_sign_off()) return std::nullopt;
  return auth::SignInRequest{request.sign_off().login(),
                             request.sign_off().pin(),
                             peer_address_,
                             auth::kViaStation,
                             station_->name,
                             {},
                             {},
                             {},
                             station_->id.Text()};
}

Answer Session::FinishSignOff(const wire::Request& request, const Result<Person>& signer) {
  if (Status admitted = StillAdmitted(); !admitted.ok()) return AnswerOf(request, admitted, true);
  if (!signer.ok()) return AnswerOf(request, signer.status(), false);
  about_ = {};
  Answer out = AnswerOf(request, Do(request.sign_off(), *signer), false);
  out.attempt = about_;
  return out;
}

void Session::End() {
  // A failure leaves a session that nobody holds the token of; it ends by its idle time.
  for (const Sha256& hash : signed_in_) (void)services_.authenticator.SignOut(hash);
  signed_in_.clear();
}

Result<auth::Identity> Session::IdentityOf(const std::string& session_token) {
  // On this connection: a token that was read elsewhere does not work here.
  if (!signed_in_.contains(auth::TokenHash(AsBytes(session_token)))) {
    return Status(Code::kUnauthenticated,
                  "nobody is signed in with this session here; sign in again", "session");
  }
  return services_.authenticator.Authenticate(AsBytes(session_token));
}

Result<Session::PasswordChoice> Session::PasswordWanted(const wire::Request& request) {
  const wire::ChoosePassword& choice = request.choose_password();
  ENAMEL_RETURN_IF_ERROR(StillAdmitted());
  ENAMEL_ASSIGN_OR_RETURN(auto identity, IdentityOf(choice.session()));
  if (!identity.person.must_change_password) {
    return Status(Code::kForbidden,
                  "only a one-time password is replaced at a station; change yours on the page",
                  "session");
  }
  return PasswordChoice{identity,
                        {choice.old_password(), choice.new_password(), peer_address_,
                         auth::kViaStation, station_->name}};
}

Result<Person> Session::PersonOf(const std::string& session_token) {
  ENAMEL_ASSIGN_OR_RETURN(auto identity, IdentityOf(session_token));
  if (identity.person.must_change_password) {
    return Status(Code::kForbidden,
                  "this password is only good for choosing your own: open the page" +
                      (services_.page_url.empty() ? "" : ", " + services_.page_url) +
                      ", choose your own, and sign in here again",
                  "one_time_password");
  }
  return identity.person;
}

// Assigned exercises; for people who teach also the newest version of whatever they could assign:
// graded work needs a reference first, which they cut here.
Result<std::vector<ExerciseRow>> Session::ExercisesOf(const Person& person) {
  if (person.role == Role::kAdmin) return services_.store.exercises.AllExercises();
  ENAMEL_ASSIGN_OR_RETURN(auto out, services_.store.exercises.ExercisesFor(person.id));
  if (person.role == Role::kStudent) return out;
  ENAMEL_ASSIGN_OR_RETURN(const auto all, services_.store.exercises.AllExercises());
  for (const ExerciseRow& row : all) {
    const bool listed = std::ranges::find(out, row.id, &ExerciseRow::id) != out.end();
    if (CanUseExercise(person, row) && !listed) out.push_back(row);
  }
  // Of each name the newest first: a station that only knows a name takes the first.
  std::ranges::sort(out, [](const ExerciseRow& a, const ExerciseRow& b) {
    return a.name != b.name ? a.name < b.name : a.version > b.version;
  });
  return out;
}

Result<std::string> Session::StationsText(const AssignmentRow& assignment) {
  std::string out;
  for (const Uuid& id : assignment.stations) {
    ENAMEL_ASSIGN_OR_RETURN(auto station, services_.store.stations.StationById(id));
    out += (out.empty() ? "" : ", ") + station.name;
  }
  return out;
}

// An exercise without its scene cannot be made: it is left out.
Status Session::AddExercise(const ExerciseRow& row, const std::vector<SceneRow>& scenes,
                            wire::Exercises& out) {
  auto scene = std::ranges::find(scenes, row.scene, &SceneRow::content);
  if (scene == scenes.end()) return Status::Ok();
  wire::ExerciseRef& ref = *out.add_exercises();
  ref.set_name(row.name);
  ref.set_title(row.title);
  ref.set_exercise(protocol::ToField(row.content.view()));
  ref.set_scene(protocol::ToField(row.scene.view()));
  ref.set_volume(protocol::ToField(scene->volume.view()));
  return Status::Ok();
}

Result<std::string> Session::LastRemark(const Uuid& attempt, const Uuid& person) {
  constexpr size_t kMaxBytes = 200;
  ENAMEL_ASSIGN_OR_RETURN(const auto remarks, services_.store.remarks.AnnotationsOf(attempt));
  const AnnotationRow* newest = nullptr;
  for (const AnnotationRow& row : remarks) {
    if (row.author == person) continue;
    if (newest == nullptr || row.created_ms >= newest->created_ms) newest = &row;
  }
  return newest == nullptr ? std::string() : ShortenedText(newest->text, kMaxBytes);
}

// Of each assignment, of the attempts whose scores the person may see.
Result<std::map<Uuid, Session::Outcome>> Session::OutcomesOf(
    const Person& person, const std::vector<AssignedRow>& assigned) {
  constexpr uint32_t kPage = 200;
  // Older ones were about work that has been done again since.
  constexpr int kLookedAt = 3;
  std::map<Uuid, Outcome> out;
  AttemptFilter filter;
  filter.person = person.id;
  filter.state = AttemptState::kScored;
  filter.limit = kPage;
  for (;;) {
    ENAMEL_ASSIGN_OR_RETURN(const auto rows, services_.store.attempts.Attempts(filter));
    for (const AttemptRow& row : rows) {
      const std::optional<double> score =
          row.overridden ? std::optional(row.overridden->score) : row.score;
      const auto under = std::ranges::find_if(
          assigned, [&](const AssignedRow& a) { return row.assignment == a.assignment.id; });
      if (!score || (row.flags & (kExcused | kReturned)) != 0 || under == assigned.end()) continue;
      if (!CanSeeScore(person, row, under->exercise.graded, false)) continue;
      Outcome& outcome = out[under->assignment.id];
      outcome.best_score = std::max(outcome.best_score, *score);
      // The newest attempts come first.
      if (!outcome.last_remark.empty() || outcome.looked_at++ >= kLookedAt) continue;
      ENAMEL_ASSIGN_OR_RETURN(outcome.last_remark, LastRemark(row.id, person.id));
    }
    if (rows.size() < kPage) return out;
    filter.before = rows.back().id;
  }
}

Status Session::AddAssigned(const AssignedRow& row, const std::vector<SceneRow>& scenes,
                            wire::Exercises& out) {
  const int before = out.exercises_size();
  ENAMEL_RETURN_IF_ERROR(AddExercise(row.exercise, scenes, out));
  if (out.exercises_size() == before) return Status::Ok();
  wire::ExerciseRef& ref = *out.mutable_exercises(before);
  const AssignmentRow& terms = row.assignment;
  ref.set_assignment(protocol::ToField(terms.id.view()));
  ref.set_opens_unix_ms(terms.opens_ms);
  ref.set_due_unix_ms(terms.due_ms);
  ref.set_late_allowed(terms.late_allowed);
  ref.set_attempt_limit(terms.attempt_limit);
  ref.set_attempts_left(terms.attempt_limit - std::min(row.attempts_used, terms.attempt_limit));
  ref.set_exam(terms.exam);
  ref.set_hands(HandsAllowedName(HandsFor(row)));
  ref.set_sign_off(terms.sign_off);
  ENAMEL_ASSIGN_OR_RETURN(auto stations, StationsText(terms));
  ref.set_stations(stations);
  Status may = MayBegin(row, services_.clock(), station_->id, stations);
  // Listed with the reason, so that a student sees the exercise and why it cannot begin now.
  if (!may.ok()) *ref.mutable_refusal() = protocol::ToError(may);
  return Status::Ok();
}

Result<wire::Reply> Session::Do(const wire::ListExercises& request) {
  ENAMEL_ASSIGN_OR_RETURN(auto person, PersonOf(request.session()));
  ENAMEL_ASSIGN_OR_RETURN(auto scenes, services_.store.scenes.Scenes());
  ENAMEL_ASSIGN_OR_RETURN(auto profiles, services_.store.profiles.Profiles());

  wire::Reply reply;
  wire::Exercises& out = *reply.mutable_exercises();
  if (person.role == Role::kStudent) {
    ENAMEL_ASSIGN_OR_RETURN(auto assigned, services_.store.assignments.AssignmentsFor(person.id));
    for (const AssignedRow& row : assigned) {
      ENAMEL_RETURN_IF_ERROR(AddAssigned(row, scenes, out));
    }
    ENAMEL_ASSIGN_OR_RETURN(const auto outcomes, OutcomesOf(person, assigned));
    for (wire::ExerciseRef& ref : *out.mutable_exercises()) {
      ENAMEL_ASSIGN_OR_RETURN(const auto id, protocol::ReadUuid(ref.assignment(), "assignment"));
      const auto outcome = outcomes.find(id);
      if (outcome == outcomes.end()) continue;
      ref.set_best_score(outcome->second.best_score);
      ref.set_last_remark(outcome->second.last_remark);
    }
  } else {
    ENAMEL_ASSIGN_OR_RETURN(auto exercises, ExercisesOf(person));
    for (const ExerciseRow& row : exercises) {
      ENAMEL_RETURN_IF_ERROR(AddExercise(row, scenes, out));
    }
  }
  for (const ProfileRow& row : profiles) {
    wire::ProfileRef& ref = *out.add_profiles();
    ref.set_name(row.name);
    ref.set_title(row.title);
    ref.set_profile(protocol::ToField(row.content.view()));
  }
  return reply;
}

Result<wire::Reply> Session::Do(const wire::GetBlob& request) {
  ENAMEL_ASSIGN_OR_RETURN(auto hash, protocol::ReadSha256(request.sha256(), "sha256"));
  // Parts of one blob come one after the other: it is held between them, and let go with the last.
  if (!fetched_ || fetched_hash_ != hash) {
    fetched_.reset();
    ENAMEL_ASSIGN_OR_RETURN(auto blob, services_.content.Get(hash));
    fetched_ = blob;
    fetched_hash_ = hash;
  }
  uint64_t total = fetched_->size();
  if (request.offset() > total) {
    return Status(Code::kInvalidInput,
                  "offset " + std::to_string(request.offset()) + " is beyond the " +
                      std::to_string(total) + " bytes of this blob",
                  "offset");
  }
  uint64_t size = std::min<uint64_t>(kBlobPartBytes, total - request.offset());
  wire::Reply reply;
  wire::BlobPart& part = *reply.mutable_blob_part();
  part.set_offset(request.offset());
  part.set_total(total);
  part.set_data(fetched_->data() + request.offset(), size);
  if (request.offset() + size == total) fetched_.reset();
  return reply;
}

void Session::Take(const wire::LiveState& live) {
  auto attempt = protocol::ReadUuid(live.attempt(), "attempt");
  // No answer, hence no refusal: a picture of somebody else's attempt is dropped in silence.
  if (!attempt.ok() || !ours_.contains(*attempt)) return;
  if (live.anchor_um_size() != 3 || live.force_mn_size() != 3) return;
  LiveSample sample;
  sample.attempt = *attempt;
  sample.station = station_->id;
  sample.tick = live.tick();
  for (int i = 0; i < 3; ++i) {
    sample.anchor_um[static_cast<size_t>(i)] = live.anchor_um(i);
    sample.force_mn[static_cast<size_t>(i)] = live.force_mn(i);
  }
  sample.flags = live.flags();
  sample.received_ms = services_.clock();
  services_.live.Put(sample);
}

}  // namespace enamel::server::stations
