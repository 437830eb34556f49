#include "tests/load/marking.h"

#include <algorithm>

#include "common/protocol/messages.h"
#include "server/app/data_folder.h"
#include "server/app/publish.h"
#include "server/jobs/worker.h"
#include "server/ops/budgets.h"
#include "station/lab/cutting/attempt.h"
#include "tests/load/engine.h"
#include "tests/load/figures.h"
#include "tests/load/recording_copy.h"
#include "tests/load/school.h"
#include "tests/support/wire_seal.h"

namespace enamel::load {
namespace {

using namespace server;

constexpr auto kAnswerWithin = std::chrono::seconds(60);
constexpr auto kLook = std::chrono::milliseconds(200);
constexpr double kReferenceWithin_s = 1800;
// Extra depth of each further recording.
constexpr double kFloorStep_m = 50e-6;
// All of one station's attempts. Half of its budget: the server still counts a link that has just closed.
constexpr size_t kSealsAtOnce = ops::Budgets{}.station_links / 2;

// The operator, device and tooth.
struct Bench {
  Store& store;
  trace::KeyPair ticket_key, station_key;
  Uuid person, station;
  std::string credential;
  ExerciseRow exercise;
  Sha256 profile;
};

Result<Bench> SetUp(Store& store, const trace::KeyPair& ticket_key, int32_t voxel_nm) {
  const std::string tag = Uuid::New().Text();
  Bench out{store, ticket_key, trace::NewKeyPair(), {}, {}, "credential " + tag, {}, {}};
  Person person;
  person.login = "load-marked-" + tag;
  person.display_name = person.login;
  ENAMEL_ASSIGN_OR_RETURN(auto id, store.people.CreatePerson(person, "no password", {}, kLoadgen));
  out.person = id;
  const Sha256 code = HashSha256(AsBytes("code " + tag));
  ENAMEL_RETURN_IF_ERROR(store.stations.AddEnrolCode(code, kFarOff, kLoadgen).status());
  StationRow row;
  row.name = "load marked " + tag;
  row.public_key.assign(out.station_key.public_key.begin(), out.station_key.public_key.end());
  ENAMEL_ASSIGN_OR_RETURN(
      auto station, store.stations.EnrolStation(code, row, HashSha256(AsBytes(out.credential)), 0));
  out.station = station.id;
  ENAMEL_ASSIGN_OR_RETURN(auto scene,
                          app::PublishScene(store.blobs, store.scenes, "builtin:molar", voxel_nm));
  ENAMEL_ASSIGN_OR_RETURN(auto exercise,
                          app::PublishClassOne(store.blobs, store.exercises, scene, Uuid{}));
  out.exercise = exercise;
  ENAMEL_ASSIGN_OR_RETURN(auto profiles, store.profiles.Profiles());
  for (const ProfileRow& profile : profiles) {
    if (profile.name == "phantom_desktop") out.profile = profile.content;
  }
  return out;
}

Result<trace::Seal> Put(const Bench& bench, const station::lab::Attempt& recorded,
                        bool as_reference) {
  AttemptRow row;
  row.id = Uuid::New();
  row.person = bench.person;
  row.station = bench.station;
  row.exercise = bench.exercise.id;
  row.exercise_content = bench.exercise.content;
  row.profile_content = bench.profile;
  row.as_reference = as_reference;
  return CopyRecording(bench.store, {bench.ticket_key, bench.station_key}, row, recorded.header,
                       recorded.chunks, 0);
}

Status RunJobs(Store& store) {
  Worker worker(store);
  worker.Start();
  for (const double end = NowS() + kReferenceWithin_s; NowS() < end;) {
    std::this_thread::sleep_for(kLook);
    size_t open = 0;
    for (const char* state : {"queued", "running"}) {
      ENAMEL_ASSIGN_OR_RETURN(auto jobs, store.jobs.Jobs(state));
      open += jobs.size();
    }
    if (open == 0) return Status::Ok();
  }
  return Status(Code::kUnavailable, "the reference was not scored in time");
}

Status ScoreReference(const Bench& bench, const station::lab::Attempt& recorded) {
  ENAMEL_ASSIGN_OR_RETURN(auto seal, Put(bench, recorded, true));
  ENAMEL_RETURN_IF_ERROR(bench.store.seals.SealAttempt(seal, 1));
  ENAMEL_RETURN_IF_ERROR(RunJobs(bench.store));
  auto reference =
      bench.store.references.AddReference(seal.attempt, "a simulated dentist", true, kLoadgen);
  return reference.ok() ? RunJobs(bench.store) : reference.status();
}

}  // namespace

Marking::~Marking() = default;  // asks the thread to stop, and waits

Status Marking::Prepare(const std::filesystem::path& data, const Options& options,
                        const std::function<void(const std::string&)>& say) {
  data_ = data;
  ENAMEL_ASSIGN_OR_RETURN(auto store, app::OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(auto identity, app::EnsureIdentity(data));
  ENAMEL_ASSIGN_OR_RETURN(auto bench, SetUp(*store, identity.ticket_key, options.voxel_nm));
  station_ = bench.station;
  credential_ = bench.credential;
  const size_t processors = std::max(1u, std::thread::hardware_concurrency());
  std::vector<station::lab::Attempt> recorded(
      std::clamp<size_t>(options.different, 1, options.attempts));
  say("recording " + std::to_string(recorded.size()) + " attempts to be scored");
  ENAMEL_RETURN_IF_ERROR(InParallel(recorded.size(), processors, [&](size_t i) {
    station::lab::AttemptOptions how;
    how.voxel_nm = options.voxel_nm;
    how.ticks = static_cast<uint64_t>(options.minutes * 60'000);
    how.floor_extra_m = kFloorStep_m * static_cast<double>(i);
    auto made = station::lab::RecordAttempt(how);
    const Status status = made.status();
    if (made.ok()) recorded[i] = *std::move(made);
    return status;
  }));
  figures_.cutting_share = recorded[0].cutting_share;
  say("scoring the reference");
  ENAMEL_RETURN_IF_ERROR(ScoreReference(bench, recorded[0]));
  say("storing " + std::to_string(options.attempts) + " recordings");
  attempts_.resize(options.attempts);
  return InParallel(options.attempts, options.attempts, [&](size_t i) -> Status {
    auto seal = Put(bench, recorded[i % recorded.size()], false);
    if (seal.ok()) attempts_[i] = {seal->attempt, *seal};
    return seal.status();
  });
}

Status Marking::Seal(const Sealed& attempt) const {
  net::FrameClient link;
  ENAMEL_RETURN_IF_ERROR(link.Connect(server_, fingerprint_, kAnswerWithin));
  auto ask = [&](const wire::Request& request) -> Result<wire::Reply> {
    ENAMEL_RETURN_IF_ERROR(link.Send(protocol::Serialize(request)));
    ENAMEL_ASSIGN_OR_RETURN(auto frame, link.Receive(kAnswerWithin));
    return protocol::ParseReply(frame);
  };
  wire::Request hello;
  hello.set_id(1);
  hello.mutable_hello()->set_protocol_version(protocol::kProtocolVersion);
  hello.mutable_hello()->set_station_id(protocol::ToField(station_.view()));
  hello.mutable_hello()->set_credential(credential_);
  hello.mutable_hello()->set_core_version(core::kCoreVersion);
  auto welcome = ask(hello);
  if (!welcome.ok()) return welcome.status();
  wire::Request request;
  request.set_id(2);
  test::FillSeal(attempt.seal, *request.mutable_seal_attempt());
  ENAMEL_ASSIGN_OR_RETURN(auto reply, ask(request));
  if (reply.has_sealed()) return Status::Ok();
  return Status(Code::kUnavailable, "an attempt was not sealed: " + reply.error().message());
}

void Marking::Begin(const net::Endpoint& server, const Sha256& fingerprint) {
  server_ = server;
  fingerprint_ = fingerprint;
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

void Marking::Run(const std::stop_token& stop) {
  auto store = app::OpenForCommand(data_);
  outcome_ = store.status();
  const double from = NowS();
  if (outcome_.ok()) {
    outcome_ =
        InParallel(attempts_.size(), kSealsAtOnce, [&](size_t i) { return Seal(attempts_[i]); });
  }
  figures_.seal_s = NowS() - from;
  std::vector<double> replay;
  for (size_t i = 0; i < attempts_.size() && outcome_.ok() && !stop.stop_requested();) {
    auto row = (*store)->attempts.AttemptById(attempts_[i].attempt);
    outcome_ = row.status();
    if (!row.ok()) break;
    bool scored = row->state == AttemptState::kScored;
    if (!scored && row->state != AttemptState::kFailed) {
      std::this_thread::sleep_for(kLook);
      continue;
    }
    ++(scored ? figures_.scored : figures_.failed);
    ++i;
    auto result = (*store)->results.ResultOf(row->id);
    if (!result.ok()) continue;
    replay.push_back(result->replay_realtime_factor);
  }
  figures_.marked_s = NowS() - from;
  figures_.replay_realtime = Median(replay);
  done_ = true;
}

Result<Marking::Figures> Marking::Finish(double seconds) {
  for (const double end = NowS() + seconds; !done_ && NowS() < end;) {
    std::this_thread::sleep_for(kLook);
  }
  thread_.request_stop();
  thread_.join();
  if (!outcome_.ok()) return outcome_;
  return figures_;
}

}  // namespace enamel::load
