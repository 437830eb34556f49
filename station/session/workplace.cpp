#include "station/session/workplace.h"

#include "common/scene/json.h"
#include "common/scene/plan.h"
#include "common/scene/volume_blob.h"

namespace enamel::station {
namespace {

constexpr std::chrono::hours kKeepCommitted{7 * 24};
constexpr std::chrono::seconds kPingEvery{20};

}  // namespace

Result<std::unique_ptr<Workplace>> Workplace::Open(const WorkplaceOptions& options) {
  auto credentials = LoadCredentialsFor(options.data, options.server);
  if (!credentials.ok()) return credentials.status();
  auto spool = Spool::Open(options.data);
  if (!spool.ok()) return spool.status();
  if (auto pruned = (*spool)->Prune(kKeepCommitted); !pruned.ok()) return pruned.status();
  return std::unique_ptr<Workplace>(
      new Workplace(options.data, std::move(*credentials), std::move(*spool)));
}

Workplace::Workplace(std::filesystem::path data, Credentials credentials,
                     std::unique_ptr<Spool> spool)
    : data_(std::move(data)),
      credentials_(std::move(credentials)),
      spool_(std::move(spool)),
      keep_alive_([this] { KeepAlive(); }) {}

Workplace::~Workplace() {
  {
    std::lock_guard lock(mutex_);
    stop_ = true;
    changed_.notify_all();
  }
  link_.Cancel();
  keep_alive_.join();
}

void Workplace::KeepAlive() {
  std::unique_lock lock(mutex_);
  while (!changed_.wait_for(lock, kPingEvery, [&] { return stop_; })) {
    if (!person_) continue;
    lock.unlock();
    {
      std::lock_guard link(link_mutex_);
      if (link_.connected() && !link_.Ping().ok()) link_.Close();
      bool lost = !link_.connected();
      lock.lock();
      if (lost) person_.reset();
    }
  }
}

Result<Person> Workplace::SignIn(const std::string& login, const std::string& password) {
  std::lock_guard link(link_mutex_);
  if (!link_.connected()) {
    if (Status s = link_.Connect(credentials_); !s.ok()) {
      if (s.code() != Code::kUnavailable) return s;
      return Status(s.code(), s.message() +
                                  ". An attempt needs the server to begin; recordings made "
                                  "earlier are safe in " +
                                  data_.string() + " ('enamel-station upload' sends them)");
    }
  }
  if (!link_.may_begin_attempts()) {
    return Status(Code::kVersion,
                  "the server runs another version of the core: this station can "
                  "upload recordings, not begin attempts; update it");
  }
  auto person = link_.SignIn(login, password);
  if (!person.ok()) return person.status();
  std::lock_guard lock(mutex_);
  person_ = *person;
  return *person;
}

void Workplace::SignOut() {
  std::lock_guard link(link_mutex_);
  link_.Close();
  std::lock_guard lock(mutex_);
  person_.reset();
}

std::optional<Person> Workplace::person() const {
  std::lock_guard lock(mutex_);
  return person_;
}

// Requires: link_mutex_ is held.
Status Workplace::MustBeSignedIn() {
  std::lock_guard lock(mutex_);
  if (!link_.connected()) person_.reset();
  if (person_) return Status::Ok();
  return Status(Code::kUnauthenticated,
                "nobody is signed in here, or the connection was lost since: sign in again");
}

Result<Catalogue> Workplace::Exercises() {
  std::lock_guard link(link_mutex_);
  ENAMEL_RETURN_IF_ERROR(MustBeSignedIn());
  return link_.ListExercises(*person());
}

Result<PreparedAttempt> Workplace::Prepare(const Catalogue::Exercise& exercise,
                                           const Catalogue::Profile& profile) {
  std::lock_guard link(link_mutex_);
  ENAMEL_RETURN_IF_ERROR(MustBeSignedIn());
  BlobCache cache(data_ / "blobs");
  auto exercise_json = link_.FetchBlob(exercise.exercise, cache);
  if (!exercise_json.ok()) return exercise_json.status();
  auto scene_json = link_.FetchBlob(exercise.scene, cache);
  if (!scene_json.ok()) return scene_json.status();
  auto profile_json = link_.FetchBlob(profile.profile, cache);
  if (!profile_json.ok()) return profile_json.status();
  auto volume_blob = link_.FetchBlob(exercise.volume, cache);
  if (!volume_blob.ok()) return volume_blob.status();
  auto parsed_exercise = scene::ExerciseFromJson(AsText(*exercise_json));
  if (!parsed_exercise.ok()) return parsed_exercise.status();
  auto parsed_scene = scene::SceneFromJson(AsText(*scene_json));
  if (!parsed_scene.ok()) return parsed_scene.status();
  auto parsed_profile = scene::ProfileFromJson(AsText(*profile_json));
  if (!parsed_profile.ok()) return parsed_profile.status();
  auto volume = scene::DecodeVolume(*volume_blob);
  if (!volume.ok()) return volume.status();
  auto params = scene::CompilePlan(*parsed_scene, *parsed_exercise, *parsed_profile);
  if (!params.ok()) return params.status();
  return PreparedAttempt{exercise.exercise,
                         profile.profile,
                         std::move(*parsed_scene),
                         std::move(*parsed_exercise),
                         std::move(*parsed_profile),
                         std::move(*volume),
                         {{}, exercise.scene, exercise.volume, *params, SoftwareName()}};
}

Status Workplace::TakeTicket(PreparedAttempt& prepared, bool as_reference) {
  std::lock_guard link(link_mutex_);
  ENAMEL_RETURN_IF_ERROR(MustBeSignedIn());
  auto ticket = link_.RequestTicket(credentials_, *person(), prepared.exercise_hash,
                                    prepared.profile_hash, as_reference);
  if (!ticket.ok()) return ticket.status();
  prepared.header.ticket = *ticket;
  return Status::Ok();
}

Result<std::unique_ptr<RunningAttempt>> Workplace::Begin(const PreparedAttempt& prepared,
                                                         Device& device,
                                                         const AttemptOptions& options) {
  ENAMEL_CHECK(!prepared.attempt().IsZero());
  ENAMEL_RETURN_IF_ERROR(
      spool_->BeginAttempt(prepared.header, prepared.exercise.name, prepared.profile.name));
  return std::make_unique<RunningAttempt>(credentials_, *spool_, prepared, device, options);
}

Result<AttemptProgress> Workplace::Progress(const Uuid& attempt) {
  std::lock_guard link(link_mutex_);
  ENAMEL_RETURN_IF_ERROR(MustBeSignedIn());
  return link_.AttemptStatus(*person(), attempt);
}

}  // namespace enamel::station
