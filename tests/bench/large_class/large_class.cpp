// A class of any size, as copies of what a school's students really did: every copy is a recording
// of its own, with a ticket, a signed chain and a signed result, so `enamel-server verify` agrees
// with it. Only the scoring runs are not repeated: a copy has the points of its original.
//
//   large_class DATA ASSIGNMENT STUDENTS
//
// DATA: a data folder that no server uses; it is changed. ASSIGNMENT: whose scored attempts are
// copied. Prints the ids of the new assignment and its cohort.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>

#include "common/base/unix_time.h"
#include "server/app/data_folder.h"
#include "server/results/result_document.h"
#include "tests/load/recording_copy.h"
#include "tests/load/school.h"
#include "tests/server/storage/all_chunks.h"

namespace {

using namespace enamel;
using namespace enamel::server;
using load::kLoadgen;

constexpr size_t kMaxStudents = 20'000;
constexpr size_t kWriters = 32;  // they share the store's commits
constexpr server::UnixMs kRunMs = 60'000;

// What is copied.
struct Original {
  AttemptRow row;
  trace::Header header;
  std::vector<Bytes> chunks;
  AttemptResult result;
  ResultDocument document;
  std::string score, series;
  Bytes tooth, deviation;
};

Result<Original> Read(Store& store, const AttemptRow& row) {
  Original out;
  out.row = row;
  ENAMEL_ASSIGN_OR_RETURN(const auto header, store.recordings.AttemptHeader(row.id));
  ENAMEL_ASSIGN_OR_RETURN(out.header, trace::DecodeHeader(header));
  ENAMEL_ASSIGN_OR_RETURN(out.chunks, AllChunks(store.recordings, row.id));
  ENAMEL_ASSIGN_OR_RETURN(out.result, store.results.ResultOf(row.id));
  ENAMEL_ASSIGN_OR_RETURN(const auto runs, store.results.ResultsOf(row.id));
  ENAMEL_ASSIGN_OR_RETURN(out.document, DecodeResult(runs.front().document));
  ENAMEL_ASSIGN_OR_RETURN(const auto score, store.blobs.GetBlob(out.result.score_json));
  ENAMEL_ASSIGN_OR_RETURN(const auto series, store.blobs.GetBlob(out.result.series));
  ENAMEL_ASSIGN_OR_RETURN(out.tooth, store.blobs.GetBlob(out.result.final_volume));
  ENAMEL_ASSIGN_OR_RETURN(out.deviation, store.blobs.GetBlob(out.result.deviation));
  out.score = AsText(score);
  out.series = AsText(series);
  return out;
}

Result<std::vector<Original>> ReadAll(Store& store, const Uuid& assignment) {
  AttemptFilter filter;
  filter.assignment = assignment;
  filter.state = AttemptState::kScored;
  ENAMEL_ASSIGN_OR_RETURN(const auto rows, store.attempts.Attempts(filter));
  std::vector<Original> out;
  for (const AttemptRow& row : rows) {
    ENAMEL_ASSIGN_OR_RETURN(auto original, Read(store, row));
    out.push_back(std::move(original));
  }
  if (out.empty()) return Status(Code::kNotFound, "expected scored attempts, found none");
  return out;
}

struct Copy {
  size_t original = 0;
  trace::Seal seal;
  Sha256 header;
};

class LargeClass {
 public:
  LargeClass(Store& store, const trace::KeyPair& ticket_key)
      : store_(store), keys_{ticket_key, trace::NewKeyPair()} {}

  Status Make(const Uuid& assignment, size_t students) {
    ENAMEL_ASSIGN_OR_RETURN(originals_, ReadAll(store_, assignment));
    ENAMEL_ASSIGN_OR_RETURN(AssignmentRow terms, store_.assignments.AssignmentById(assignment));
    const std::string name = "Class of " + std::to_string(students);
    ENAMEL_ASSIGN_OR_RETURN(cohort_, store_.cohorts.CreateCohort(name, kLoadgen));
    ENAMEL_ASSIGN_OR_RETURN(const auto members, store_.cohorts.CohortMembers(terms.cohort));
    for (const Person& member : members) {
      if (member.role != Role::kInstructor) continue;
      ENAMEL_RETURN_IF_ERROR(store_.cohorts.AddToCohort(cohort_, member.id, kLoadgen));
    }
    terms.cohort = cohort_;
    ENAMEL_ASSIGN_OR_RETURN(const auto made, store_.assignments.AddAssignment(terms, kLoadgen));
    assignment_ = made.id;
    ENAMEL_RETURN_IF_ERROR(AddChair());
    ENAMEL_RETURN_IF_ERROR(
        load::InParallel(students, kWriters, [&](size_t i) { return AddStudent(i); }));
    return load::InParallel(kWriters, kWriters, [&](size_t) { return KeepScores(); });
  }

  const Uuid& cohort() const { return cohort_; }
  const Uuid& assignment() const { return assignment_; }

 private:
  Status AddChair() {
    const Sha256 code = HashSha256(AsBytes(Uuid::New().Text()));
    ENAMEL_RETURN_IF_ERROR(store_.stations.AddEnrolCode(code, load::kFarOff, kLoadgen).status());
    StationRow row;
    row.name = "chair " + Uuid::New().Text();
    row.public_key.assign(keys_.station.public_key.begin(), keys_.station.public_key.end());
    ENAMEL_ASSIGN_OR_RETURN(const auto station, store_.stations.EnrolStation(code, row, code, 0));
    station_ = station.id;
    return Status::Ok();
  }

  Status AddStudent(size_t i) {
    const size_t from = i % originals_.size();
    const Original& original = originals_[from];
    Person person;
    person.login = "copy" + std::to_string(i) + "." + cohort_.Text().substr(24);
    person.display_name = original.row.person_name + " " + std::to_string(i + 1);
    ENAMEL_ASSIGN_OR_RETURN(const Uuid id,
                            store_.people.CreatePerson(person, "no password", {cohort_}, kLoadgen));
    AttemptRow row = original.row;
    row.id = Uuid::New();
    row.person = id;
    row.station = station_;
    row.assignment = assignment_;
    row.ticketed_ms = enamel::UnixMs();
    Copy copy;
    copy.original = from;
    const server::UnixMs received_ms = row.ticketed_ms + kRunMs * 10;
    ENAMEL_ASSIGN_OR_RETURN(copy.seal, load::CopyRecording(store_, keys_, row, original.header,
                                                           original.chunks, received_ms));
    ENAMEL_ASSIGN_OR_RETURN(const Bytes header, store_.recordings.AttemptHeader(row.id));
    copy.header = HashSha256(header);
    {
      const std::lock_guard lock(mutex_);
      copies_[row.id] = copy;
    }
    return store_.seals.SealAttempt(copy.seal, received_ms);
  }

  // Takes the queued runs and leaves the originals' results.
  Status KeepScores() {
    for (;;) {
      ENAMEL_ASSIGN_OR_RETURN(const auto job, store_.jobs.LeaseJob(enamel::UnixMs(), kRunMs));
      if (!job) return Status::Ok();
      Copy copy;
      {
        const std::lock_guard lock(mutex_);
        const auto found = copies_.find(job->attempt);
        if (found == copies_.end())
          return Status(Code::kConflict, "expected a school with an empty queue, found a run of " +
                                             job->attempt.Text());
        copy = found->second;
      }
      ENAMEL_RETURN_IF_ERROR(KeepScore(job->attempt, job->lease, copy));
    }
  }

  Status KeepScore(const Uuid& attempt, const Uuid& lease, const Copy& copy) {
    const Original& original = originals_[copy.original];
    AttemptResult result = original.result;
    ENAMEL_ASSIGN_OR_RETURN(result.score_json,
                            store_.blobs.PutAttemptText(attempt, original.score));
    ENAMEL_ASSIGN_OR_RETURN(result.series, store_.blobs.PutAttemptText(attempt, original.series));
    ENAMEL_ASSIGN_OR_RETURN(result.final_volume,
                            store_.blobs.PutAttemptBlob(attempt, original.tooth));
    ENAMEL_ASSIGN_OR_RETURN(result.deviation,
                            store_.blobs.PutAttemptBlob(attempt, original.deviation));
    ENAMEL_ASSIGN_OR_RETURN(const AttemptRow row, store_.attempts.AttemptById(attempt));
    result.scored_ms = enamel::UnixMs();
    result.same_judgement_as.reset();
    result.motion = {};
    result.near.reset();
    ResultDocument document = original.document;
    document.attempt = attempt;
    document.scored_ms = result.scored_ms;
    document.header = copy.header;
    document.recording = copy.seal.last_chunk;
    document.score_document = result.score_json;
    document.tooth = result.final_volume;
    document.deviation = result.deviation;
    document.series = result.series;
    document.flags = row.flags & kSignedFlags;
    SignResult(document, keys_.ticket);
    result.document = EncodeResult(document);
    return store_.results.FinishAttempt(attempt, result, lease);
  }

  Store& store_;
  const load::CopyKeys keys_;
  std::vector<Original> originals_;
  Uuid cohort_, assignment_, station_;
  std::mutex mutex_;
  std::map<Uuid, Copy> copies_;
};

int Fail(const Status& status) {
  std::fprintf(stderr, "large_class: %s\n", status.message().c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  const Result<Uuid> assignment = Uuid::Parse(argc == 4 ? argv[2] : "");
  const size_t students = argc == 4 ? std::strtoul(argv[3], nullptr, 10) : 0;
  if (!assignment.ok() || students == 0 || students > kMaxStudents) {
    return Fail({Code::kInvalidInput,
                 "expected DATA ASSIGNMENT STUDENTS, the id of an assignment and 1 to " +
                     std::to_string(kMaxStudents) + " students"});
  }
  const auto begun = std::chrono::steady_clock::now();
  auto store = app::OpenForCommand(argv[1]);
  if (!store.ok()) return Fail(store.status());
  auto identity = app::EnsureIdentity(argv[1]);
  if (!identity.ok()) return Fail(identity.status());
  LargeClass made(**store, identity->ticket_key);
  if (const Status status = made.Make(*assignment, students); !status.ok()) return Fail(status);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun;
  std::printf("assignment %s\ncohort %s\n%zu students in %.1f s\n",
              made.assignment().Text().c_str(), made.cohort().Text().c_str(), students,
              took.count());
  return 0;
}
