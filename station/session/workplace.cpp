#include "station/session/workplace.h"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "common/base/unix_time.h"
#include "common/scene/attempt_documents.h"
#include "common/scene/json/json.h"
#include "common/scene/plan.h"
#include "common/scene/prepared_target.h"
#include "common/scene/volume_blob.h"
#include "station/session/practice_list.h"
#include "station/uplink/attempt_sender.h"

namespace enamel::station {
namespace {

// The server closes a connection that is silent for a minute.
constexpr std::chrono::seconds kPingEvery{20};
constexpr char kSignedOut[] = "has signed out",
               kLost[] = "is signed out: the connection to the server was lost";

// Exercise and profile, and the documents they name.
Result<PreparedAttempt> Assemble(const Sha256& exercise, const Sha256& profile,
                                 const scene::FetchContent& fetch) {
  PreparedAttempt out;
  out.exercise_hash = exercise;
  out.profile_hash = profile;
  ENAMEL_ASSIGN_OR_RETURN(auto documents, scene::ReadDocuments(exercise, profile, fetch));
  out.exercise = std::move(documents.exercise);
  out.scene = std::move(documents.scene);
  out.profile = std::move(documents.profile);
  ENAMEL_ASSIGN_OR_RETURN(auto blob, fetch(out.scene.volume));
  ENAMEL_ASSIGN_OR_RETURN(auto volume, scene::DecodeVolume(blob));
  out.volume = std::move(volume);
  ENAMEL_RETURN_IF_ERROR(scene::LoadPreparedTarget(out.volume, fetch, out.exercise.target));
  ENAMEL_ASSIGN_OR_RETURN(auto params, scene::CompilePlan(out.scene, out.exercise, out.profile));
  out.header = {{}, out.exercise.scene, out.scene.volume, params, SoftwareName(), {}};
  return out;
}

UploaderOptions UploaderOf(const WorkplaceOptions& options) {
  UploaderOptions out = options.uploader;
  out.retention = options.retention;
  return out;
}

// An attempt's size on disk until it ends: 3.7 bytes a tick, measured with simulated hands, plus
// the write-ahead log.
uint64_t RoomFor(const PreparedAttempt& prepared) {
  constexpr double kBytesPerTick = 4, kUsual_s = 1800, kLog_bytes = 4 << 20;
  const double time_s =
      prepared.exercise.time_limit_s > 0 ? prepared.exercise.time_limit_s : kUsual_s;
  return static_cast<uint64_t>(kLog_bytes +
                               kBytesPerTick * time_s * prepared.header.params.rate_hz);
}

}  // namespace

Result<std::unique_ptr<Workplace>> Workplace::Open(const WorkplaceOptions& options) {
  ENAMEL_ASSIGN_OR_RETURN(auto credentials, LoadCredentialsFor(options.data, options.server));
  ENAMEL_ASSIGN_OR_RETURN(auto spool, Spool::Open(options.data));
  return std::unique_ptr<Workplace>(
      new Workplace(options, std::move(credentials), std::move(spool)));
}

Workplace::Workplace(const WorkplaceOptions& options, Credentials credentials,
                     std::unique_ptr<Spool> spool)
    : data_(options.data),
      credentials_(std::move(credentials)),
      spool_(std::move(spool)),
      safe_(*spool_),
      uploader_(credentials_, *spool_, UploaderOf(options)),
      keep_alive_([this] { KeepAlive(); }) {}

Workplace::~Workplace() {
  {
    MutexLock lock(mutex_);
    stop_ = true;
    link_->Cancel();
    ForgetPerson(kSignedOut);
    changed_.notify_all();
  }
  // Last: until it has ended it may use the link, and Cancel ends its requests.
  keep_alive_.join();
  HandBackUnused();
}

void Workplace::KeepAlive() {
  for (;;) {
    {
      MutexLock lock(mutex_);
      const auto stopped = [&]() ENAMEL_REQUIRES(mutex_) { return stop_; };
      if (changed_.wait_for(mutex_, kPingEvery, stopped)) return;
      if (!person_) continue;
    }
    auto link = UseLink();
    // Without mutex_: a step that only asks for the person must not wait for the network.
    if (link->connected() && !link->Ping().ok()) link->Close();
    const bool lost = !link->connected();
    MutexLock lock(mutex_);
    // If one person signed out and another in meanwhile, the link is a different one.
    if (lost && link.link == link_) ForgetPerson(kLost);
  }
}

Status Workplace::ConnectForPeople(ServerLink& link) {
  if (Status s = link.Connect(credentials_); !s.ok()) {
    if (s.code() != Code::kUnavailable || IsStopped(s)) return s;
    return Status(
        s.code(),
        "the server is away: an attempt needs it to begin. Recordings made earlier are "
        "safe in " +
            data_.string() +
            " ('enamel-station upload' sends them). In the network's words: " + s.message(),
        kServerAway);
  }
  if (link.may_begin_attempts()) return Status::Ok();
  link.Close();
  return Status(Code::kVersion,
                "the server runs another version of the core: this station can "
                "upload recordings, not begin attempts; update it");
}

// A failed sign-in is logged without the typed login: it may be a password in the wrong field.
Result<Person> Workplace::Logged(Result<Person> person) const {
  if (person.ok()) {
    spdlog::info("person {} ({}) has signed in", person->id.Text(), person->role);
  } else if (!IsStopped(person.status())) {
    spdlog::warn("a sign-in failed: {}", person.status().message());
  }
  return person;
}

Result<Person> Workplace::SignIn(const std::string& login, const std::string& password) {
  return Logged(SignInAtServer(login, password, {}));
}

Result<Person> Workplace::SignInChoosing(const std::string& login, const std::string& one_time,
                                         const std::string& chosen) {
  return Logged(SignInAtServer(login, one_time, chosen));
}

// `chosen`: in place of a one-time password; empty: none is chosen.
Result<Person> Workplace::SignInAtServer(const std::string& login, const std::string& password,
                                         const std::string& chosen) {
  auto link = UseLink();
  const bool kept = link->connected();
  if (!kept) ENAMEL_RETURN_IF_ERROR(ConnectForPeople(*link));
  auto person = link->SignIn(login, password);
  if (!person.ok() && kept && person.status().code() == Code::kUnavailable) {
    // The server closes a connection on which nobody signed in.
    link->Close();
    ENAMEL_RETURN_IF_ERROR(ConnectForPeople(*link));
    person = link->SignIn(login, password);
  }
  ENAMEL_RETURN_IF_ERROR(person.status());
  uploader_.Retry();
  if (person->must_change_password && !chosen.empty()) {
    person = link->ChoosePassword(*person, password, chosen);
    // Ends the session that the one-time password began.
    if (!person.ok()) link->Close();
    ENAMEL_RETURN_IF_ERROR(person.status());
  }
  if (person->must_change_password) {
    const std::string page =
        link->page_url().empty() ? "the page of " + credentials_.server.host : link->page_url();
    link->Close();
    return Status(Code::kForbidden,
                  "this password is only good for choosing your own. Open " + page +
                      " on any computer, sign in there and choose your own; then sign in here "
                      "again",
                  kOneTimePassword);
  }
  MutexLock lock(mutex_);
  // Signed out during the request: the next person must not find this one signed in.
  if (link.link != link_)
    return Status(Code::kUnavailable, "signed out meanwhile", net::kCancelled);
  person_ = *person;
  return *person;
}

void Workplace::ForgetPerson(const char* how) {
  if (person_) spdlog::info("person {} {}", person_->id.Text(), how);
  person_.reset();
}

// A step that waits for the server holds the connection: this ends the step and closes the
// connection.
void Workplace::SignOut() {
  std::shared_ptr<ServerLink> left;  // closed once nothing is locked any more
  MutexLock lock(mutex_);
  left = std::exchange(link_, std::make_shared<ServerLink>());
  left->Cancel();
  ForgetPerson(kSignedOut);
}

Workplace::LinkInUse Workplace::UseLink() {
  std::unique_lock alone(link_mutex_);
  MutexLock lock(mutex_);
  return {std::move(alone), link_};
}

std::optional<Person> Workplace::person() const {
  MutexLock lock(mutex_);
  return person_;
}

Result<Person> Workplace::SignedIn(const ServerLink& link) {
  MutexLock lock(mutex_);
  const bool current = link_.get() == &link;
  if (current && !link.connected()) ForgetPerson(kLost);
  if (current && person_) return *person_;
  return Status(Code::kUnauthenticated,
                "nobody is signed in here, or the connection was lost since: sign in again");
}

Result<Catalogue> Workplace::Exercises() {
  auto link = UseLink();
  ENAMEL_ASSIGN_OR_RETURN(auto who, SignedIn(*link));
  return link->ListExercises(who);
}

Result<Catalogue::Facts> Workplace::FactsOf(const Sha256& name, const Fetch& fetch) {
  ENAMEL_ASSIGN_OR_RETURN(auto exercise_text, fetch(name));
  ENAMEL_ASSIGN_OR_RETURN(auto exercise, scene::ExerciseFromJson(AsText(exercise_text)));
  ENAMEL_ASSIGN_OR_RETURN(auto scene_text, fetch(exercise.scene));
  ENAMEL_ASSIGN_OR_RETURN(auto scene, scene::SceneFromJson(AsText(scene_text)));
  auto has = [&](cutting::Tissue tissue) {
    return std::ranges::find(scene.tissues, tissue, &scene::TissueSpec::tissue) !=
           scene.tissues.end();
  };
  return Catalogue::Facts{scene.tooth, exercise.target.landmark, has(cutting::Tissue::kCaries),
                          has(cutting::Tissue::kNeighbour), exercise.graded};
}

void Workplace::Describe(Catalogue& catalogue) {
  auto link = UseLink();
  BlobCache cache(data_ / "blobs");
  const auto fetch = [&](const Sha256& name) { return link->FetchBlob(name, cache); };
  bool practice = false;
  for (Catalogue::Exercise& listed : catalogue.exercises) {
    auto facts = FactsOf(listed.exercise, fetch);
    if (facts.ok()) listed.facts = std::move(*facts);
    if (!link->connected()) return;
    practice |= listed.facts && !listed.facts->graded && !listed.exam;
  }
  KeepPracticeList(data_, catalogue, UnixMs());
  // Few and small. Without them only devices that somebody has chosen here could be used.
  for (size_t i = 0; practice && i < catalogue.profiles.size() && link->connected(); ++i) {
    (void)fetch(catalogue.profiles[i].profile);
  }
}

Result<PreparedAttempt> Workplace::Prepare(const Catalogue::Exercise& exercise,
                                           const Catalogue::Profile& profile) {
  auto link = UseLink();
  ENAMEL_ASSIGN_OR_RETURN(auto who, SignedIn(*link));
  BlobCache cache(data_ / "blobs");
  auto prepared = Assemble(exercise.exercise, profile.profile,
                           [&](const Sha256& name) { return link->FetchBlob(name, cache); });
  if (prepared.ok()) prepared->assignment = exercise.assignment;
  return prepared;
}

Status Workplace::MakeReady(PreparedAttempt& prepared) {
  // The window calls this when the person opens the exercise, and again when the attempt begins.
  if (prepared.lock) return Status::Ok();
  auto lock = spool_->LockForRecording();
  Status ready = lock.ok() ? spool_->ProveWritable(RoomFor(prepared)) : lock.status();
  if (!ready.ok()) return Status(ready.code(), ready.message(), kRecordingHere);
  prepared.lock.emplace(std::move(*lock));
  return Status::Ok();
}

Status Workplace::TakeTicket(PreparedAttempt& prepared, bool as_reference) {
  HandBackUnused();
  ENAMEL_RETURN_IF_ERROR(MakeReady(prepared));
  Status taken = AskForTicket(prepared, as_reference);
  if (!taken.ok()) prepared.lock.reset();
  return taken;
}

Status Workplace::AskForTicket(PreparedAttempt& prepared, bool as_reference) {
  auto link = UseLink();
  ENAMEL_ASSIGN_OR_RETURN(auto who, SignedIn(*link));
  ENAMEL_RETURN_IF_ERROR(TellReturned(*link));
  ENAMEL_ASSIGN_OR_RETURN(
      auto issued,
      link->RequestTicket(credentials_, who,
                          {prepared.exercise_hash, prepared.profile_hash, prepared.assignment,
                           as_reference, false, prepared.header.hand}));
  // From here on the ticket counts at the server. If the program crashes before Begin, only the
  // ticket's expiry frees it.
  prepared.header.ticket = issued.ticket;
  prepared.hands = issued.hands;
  prepared.terms = issued.terms;
  MutexLock lock(mutex_);
  unused_ = issued.ticket.attempt;
  return Status::Ok();
}

// Neither login nor PIN is logged: either may be a password in the wrong field.
Result<std::string> Workplace::SignOff(const Uuid& attempt, SignedAt at, const std::string& login,
                                       const std::string& pin) {
  auto signer = SignOffAtServer(attempt, at, login, pin);
  const char* what = at == SignedAt::kStart ? "start" : "end";
  if (signer.ok()) {
    spdlog::info("the {} of attempt {} is signed", what, attempt.Text());
  } else if (!IsStopped(signer.status())) {
    spdlog::warn("the {} of attempt {} was not signed: {}", what, attempt.Text(),
                 signer.status().message());
  }
  return signer;
}

Result<std::string> Workplace::SignOffAtServer(const Uuid& attempt, SignedAt at,
                                               const std::string& login, const std::string& pin) {
  auto link = UseLink();
  // A lost connection took the sign-in with it. A signature needs none.
  auto connect = [&]() -> Status {
    (void)SignedIn(*link);
    return ConnectForPeople(*link);
  };
  const bool kept = link->connected();
  if (!kept) ENAMEL_RETURN_IF_ERROR(connect());
  auto signer = link->SignOff(attempt, at, login, pin);
  // That it was lost may show only now. The same signature twice is one.
  if (!kept || signer.ok() || link->connected()) return signer;
  ENAMEL_RETURN_IF_ERROR(connect());
  return link->SignOff(attempt, at, login, pin);
}

Status Workplace::TellReturned(ServerLink& link) {
  Bandwidth no_bound(0);
  return AttemptSender(link, *spool_, no_bound).ReturnTickets();
}

void Workplace::HandBackUnused() {
  const Uuid unused = [this] {
    MutexLock lock(mutex_);  // not during disk access: the window reads under it
    return std::exchange(unused_, {});
  }();
  if (unused.IsZero() || spool_->Get(unused).ok()) return;
  LockedTicket row;  // one that cannot be opened
  row.attempt = unused;
  if (Status kept = spool_->tickets().Put(row); !kept.ok()) {
    spdlog::warn("the ticket of attempt {}, which was not begun, cannot be handed back: {}",
                 unused.Text(), kept.message());
  }
  uploader_.Wake();
}

Result<std::unique_ptr<RunningAttempt>> Workplace::Begin(PreparedAttempt& prepared, Device& device,
                                                         const AttemptOptions& options) {
  // Begin without a ticket would record an attempt that no server accepts.
  ENAMEL_CHECK(!prepared.attempt().IsZero());
  ENAMEL_RETURN_IF_ERROR(MakeReady(prepared));
  // Released here if it cannot begin after all.
  std::optional<RecordingLock> recording = std::exchange(prepared.lock, std::nullopt);
  if (prepared.core) {
    // The gap lasts until now, not until the attempt was chosen.
    ENAMEL_RETURN_IF_ERROR(MeasureGap(prepared));
    if (prepared.clock_stepped) {
      spdlog::warn(
          "this computer's clock was changed since attempt {} was cut off: its gap of {:.1f} s is "
          "the least that passed",
          prepared.attempt().Text(), prepared.gap_ticks / double(prepared.header.params.rate_hz));
    }
    ENAMEL_RETURN_IF_ERROR(spool_->MarkResumed(prepared.attempt()));
  } else {
    ENAMEL_RETURN_IF_ERROR(spool_->BeginAttempt(prepared.header, prepared.exercise.name,
                                                prepared.profile.name, prepared.facts,
                                                prepared.terms));
  }
  if (prepared.terms.sign_off) uploader_.HoldSeal(prepared.attempt());
  {
    MutexLock lock(mutex_);
    if (unused_ == prepared.attempt()) unused_ = {};
  }
  spdlog::info("attempt {} {}: exercise '{}', person {}, {} at {} Hz, profile '{}'",
               prepared.attempt().Text(),
               prepared.core ? fmt::format("resumes after {} ticks and a gap of {}",
                                           prepared.place.next_tick, prepared.gap_ticks)
                             : "begins",
               prepared.exercise.name, prepared.header.ticket.person.Text(), device.Name(),
               prepared.header.params.rate_hz, prepared.profile.name);
  return std::make_unique<RunningAttempt>(credentials_.secret_key, *spool_, uploader_, prepared,
                                          device, options, std::move(*recording));
}

Result<PreparedAttempt> Workplace::FromCache(const Sha256& exercise, const Sha256& profile) const {
  BlobCache cache(data_ / "blobs");
  return Assemble(exercise, profile, [&](const Sha256& name) -> Result<Bytes> {
    // The cache is by content: it has the version asked for, even if the exercise has a newer one.
    if (auto cached = cache.Find(name)) return std::move(*cached);
    return Status(Code::kNotFound, "document " + name.Hex() + " is not on this station any more (" +
                                       (data_ / "blobs").string() +
                                       "): prepare the exercise once with the server at hand");
  });
}

Result<AttemptProgress> Workplace::Progress(const Uuid& attempt) {
  auto link = UseLink();
  ENAMEL_ASSIGN_OR_RETURN(auto who, SignedIn(*link));
  return link->AttemptStatus(who, attempt);
}

Result<Bytes> Workplace::Deviation(const Uuid& attempt) {
  auto link = UseLink();
  ENAMEL_ASSIGN_OR_RETURN(auto who, SignedIn(*link));
  return link->Deviation(who, attempt);
}

Status Workplace::MarkReference(const Uuid& attempt, const std::string& dentist, bool consent,
                                const std::string& anyway) {
  auto link = UseLink();
  ENAMEL_ASSIGN_OR_RETURN(auto who, SignedIn(*link));
  return link->MarkReference(who, attempt, dentist, consent, anyway);
}

}  // namespace enamel::station
