#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/trace/trace.h"
#include "server/training/revision.h"
#include "server/training/roster.h"
#include "server/training/types.h"

// The one interface to everything durable. SQLite behind it today (sqlite_store.h); a second
// backend must pass tests/server/storage/conformance. Every change is one transaction and leaves an
// audit row in the same transaction.
//
// Thread safety: any thread; calls block (the SQLite backend has one writer connection behind a
// mutex with group commit and a pool of readers). Coroutines call it through StorePool
// (storage/store_pool.h), never directly. Errors: kNotFound, kConflict, kStorage with what to do.
namespace enamel::server {

// Who does something, for the audit trail. Zero id: the system or the command line.
struct Actor {
  Uuid person;
  std::string via;  // "page", "station <name>", "command line", "job"
};

struct AttemptFilter {
  std::optional<Uuid> person{};
  std::optional<Uuid> cohort{};                 // attempts of its students
  std::optional<Uuid> visible_to_instructor{};  // attempts in any cohort of this instructor
  std::optional<Uuid> exercise{};
  std::optional<Uuid> assignment{};
  std::optional<AttemptState> state{};
  uint32_t flags = 0;            // with all of these bits of AttemptFlag
  bool open_appeal = false;      // only those with an appeal that nobody has answered
  std::optional<Uuid> before{};  // page: ids lower than this (newest first)
  uint32_t limit = 50;           // at most 200
};

struct AssignmentFilter {
  std::optional<Uuid> cohort{};
  std::optional<Uuid> of_instructor{};  // of this person's cohorts, and those for everybody
};

struct SessionRow {
  Sha256 token_hash;
  Uuid person;
  UnixMs created_ms = 0, last_used_ms = 0, expires_ms = 0;
  std::string via;          // "page" | "station"
  Uuid id{};                // what it is called where the token must not be; zero: made up
  UnixMs confirmed_ms = 0;  // when the password was given last; 0: when it was created
};

struct JobRow {
  Uuid id;
  std::string kind;  // "score"
  Uuid attempt;
  std::string state;  // "queued" | "running" | "done" | "failed" | "cancelled"
  uint32_t tries = 0;
  std::string error;
  std::string cause = "seal";  // "seal" | "reference" | "rescore" | "appeal"
  double progress = 0;         // 0..1 while running
};

struct JobFilter {
  std::string state{};           // empty: all
  std::optional<Uuid> before{};  // page: ids lower than this (newest first)
  uint32_t limit = 50;           // at most 200
};

struct AuditFilter {
  std::optional<Uuid> actor{};
  std::string action{};  // whole ("person.edit") or, with a dot at the end, a kind ("person.")
  std::string object{};  // whole
  UnixMs from_ms = 0;
  UnixMs until_ms = 0;           // 0: now
  std::optional<Uuid> before{};  // page: older than this row
  uint32_t limit = 100;          // at most 1000
};

struct AuditRow {
  UnixMs at_ms = 0;
  std::string actor;
  std::string action;  // "attempt.seal", "person.create"
  std::string object;
  std::string before_json, after_json;
  Uuid id{};
};

// What was removed with a person.
struct ErasureReport {
  size_t attempts = 0, references = 0, blobs = 0;
  // False: copies of what was erased may be in unused parts of the database until FinishErasures.
  bool finished = true;
};

// How long things are kept; no rule: for good.
//   "unfinished"  attempts that were never sealed, since their ticket; at least 14 days, as
//   stations
//                 may still upload (schemas/wire/README.md)
//   "recordings"  since sealing: trace, final volume, surface and force series go, the score stays
//   "attempts"    since sealing (quarantined ones: since their ticket): all of it
// Reference cuts, attempts with a job in the queue, with an appeal that waits for its answer, and
// students' graded work that is neither released nor excused are never touched; quarantined ones,
// being evidence, only by "attempts".
struct RetentionRule {
  std::string what;
  int32_t days = 0;
};

// Attempts a rule applies to now.
struct RetentionReport {
  std::vector<Uuid> unfinished, recordings, attempts;
  size_t blobs = 0;  // removed with them
  size_t held = 0;   // due as well, but kept for an appeal's answer or for their release
};

// How the store does. Counters are since it was opened.
struct StoreHealth {
  bool takes_recordings = true;
  std::string problem;  // why not, and what to do; names no path
  std::string waiting;  // why changes take longer than usual at the moment; empty: they do not
  uint64_t free_bytes = 0, min_free_bytes = 0, database_bytes = 0, log_bytes = 0;
  uint64_t commits = 0, writes = 0, failed_commits = 0;
  double commit_s = 0;  // time spent in commits
  uint64_t chunks = 0, chunk_bytes = 0, sealed = 0;
};

class Store {
 public:
  virtual ~Store() = default;

  // People. Passwords are verifier strings made by server/auth; never shown by any reader.
  // Together with the memberships or not at all. Errors: kConflict (the login is taken), kNotFound
  // with field "cohorts".
  virtual Result<Uuid> CreatePerson(const Person& person, const std::string& password_verifier,
                                    const std::vector<Uuid>& cohorts, const Actor& by) = 0;
  virtual Result<Person> PersonById(const Uuid& id) = 0;
  virtual Result<Person> PersonByLogin(const std::string& login) = 0;
  virtual Result<std::string> PasswordVerifier(const Uuid& person) = 0;
  // Ends the person's sessions. `for_one_use`: it has to be changed before anything else is done.
  virtual Status SetPassword(const Uuid& person, const std::string& verifier, bool for_one_use,
                             const Actor& by) = 0;
  // Disabling ends the person's sessions in the same transaction. Errors also: kConflict (the last
  // admin who may sign in).
  virtual Status SetDisabled(const Uuid& person, bool disabled, const Actor& by) = 0;
  virtual Result<std::vector<Person>> People() = 0;
  // By login.
  virtual Result<std::vector<Person>> FindPeople(const PeopleFilter& filter) = 0;
  // Another role and disabling end the person's sessions. Returns the person as it is then. Errors:
  // kConflict with field kStale (`revision` is not the stored one), without one (the last admin who
  // may sign in).
  virtual Result<Person> EditPerson(const Uuid& id, const PersonEdit& edit, int32_t revision,
                                    const Actor& by) = 0;
  // Carries out what PlanRoster says, all or nothing, and returns it; with `dry_run`, or with
  // problems in the plan, changes nothing.
  virtual Result<RosterPlan> ImportRoster(const std::vector<RosterRow>& rows, bool dry_run,
                                          const Actor& by) = 0;

  // Sessions: whether one still counts (idle, absolute end) is for server/auth to say.
  virtual Status CreateSession(const SessionRow& session) = 0;
  virtual Result<SessionRow> FindSession(const Sha256& token_hash) = 0;
  virtual Status TouchSession(const Sha256& token_hash, UnixMs now_ms) = 0;
  virtual Status EndSession(const Sha256& token_hash) = 0;
  // How many there were.
  virtual Result<size_t> EndSessionsOf(const Uuid& person, const Actor& by) = 0;
  // Newest first.
  virtual Result<std::vector<SessionRow>> SessionsOf(const Uuid& person) = 0;
  // Errors: kNotFound.
  virtual Result<SessionRow> SessionById(const Uuid& id) = 0;
  virtual Status EndSessionById(const Uuid& id, const Actor& by) = 0;
  // The password was given once more.
  virtual Status ConfirmSession(const Sha256& token_hash, UnixMs now_ms) = 0;

  virtual Result<Uuid> CreateCohort(const std::string& name, const Actor& by) = 0;
  virtual Result<Cohort> CohortById(const Uuid& id) = 0;
  // Errors: kConflict with field kStale, without one (the name is taken).
  virtual Result<Cohort> EditCohort(const Uuid& id, const CohortEdit& edit, int32_t revision,
                                    const Actor& by) = 0;
  // All or nothing; who is in already, or is not, stays so. Errors: kNotFound with the id that is
  // unknown.
  virtual Status ChangeMembers(const Uuid& cohort, const std::vector<Uuid>& add,
                               const std::vector<Uuid>& remove, const Actor& by) = 0;
  virtual Status AddToCohort(const Uuid& cohort, const Uuid& person, const Actor& by) = 0;
  virtual Result<std::vector<Cohort>> CohortsOf(
      const Uuid& person) = 0;  // as student or instructor
  virtual Result<std::vector<Cohort>> Cohorts() = 0;
  virtual Result<std::vector<Person>> CohortMembers(const Uuid& cohort) = 0;
  // True when the two share a cohort (a person shares one with itself only as a member of any).
  virtual Result<bool> ShareCohort(const Uuid& a, const Uuid& b) = 0;

  // Stations. A code works once and before it expires.
  virtual Result<Uuid> AddEnrolCode(const Sha256& code_hash, UnixMs expires_ms,
                                    const Actor& by) = 0;
  // Those that can still be used, the one that expires first at the front.
  virtual Result<std::vector<EnrolCodeRow>> OpenEnrolCodes(UnixMs now_ms) = 0;
  // Errors: kNotFound, kConflict (used already).
  virtual Status WithdrawEnrolCode(const Uuid& id, const Actor& by) = 0;
  // With an id: the station as it was enrolled before, under its old id, also where a restore has
  // forgotten it. Errors also: kConflict (that id has another key, or was revoked).
  virtual Result<StationRow> EnrolStation(const Sha256& code_hash, StationRow station,
                                          const Sha256& credential_hash, UnixMs now_ms) = 0;
  virtual Result<StationRow> StationByCredential(const Uuid& id, const Sha256& credential_hash) = 0;
  virtual Result<StationRow> StationById(const Uuid& id) = 0;
  // It connected.
  virtual Status TouchStation(const Uuid& id, const std::string& software, uint32_t core_version,
                              UnixMs now_ms) = 0;
  // Errors: kConflict with field kStale.
  virtual Result<StationRow> RenameStation(const Uuid& id, const std::string& name,
                                           int32_t revision, const Actor& by) = 0;
  // For good: a station that is to come back enrols anew.
  virtual Status RevokeStation(const Uuid& id, const Actor& by) = 0;
  virtual Result<std::vector<StationRow>> Stations() = 0;
  // Ids of those that were revoked; cheap, however many stations there are.
  virtual Result<std::vector<Uuid>> RevokedStations() = 0;

  // Content-addressed blobs: documents, volumes, sealed results. Write-once, durable on return.
  virtual Result<Sha256> PutBlob(ByteView data) = 0;
  virtual Result<Bytes> GetBlob(const Sha256& hash) = 0;
  virtual bool HasBlob(const Sha256& hash) = 0;
  // A blob that shows what the attempt's person did: kept under that person's key, readable through
  // GetBlob as long as the key exists. Errors also: kNotFound (attempt), kConflict (person erased).
  virtual Result<Sha256> PutAttemptBlob(const Uuid& attempt, ByteView data) = 0;

  // Name, title and content of `row` count: a new version of the profile of this name when the
  // content differs from the newest one.
  virtual Status PutProfile(const ProfileRow& row, const Actor& by) = 0;
  virtual Result<std::vector<ProfileRow>> Profiles() = 0;  // newest versions, by name
  // Newest first; empty when there is no such profile.
  virtual Result<std::vector<ProfileRow>> ProfileVersions(const std::string& name) = 0;
  // About the newest version. The same content again: the row that is there. Errors: kNotFound (the
  // profile, the blob).
  virtual Result<ProfileReportRow> AddProfileReport(const ProfileReportRow& row,
                                                    const Actor& by) = 0;
  virtual Result<std::vector<ProfileReportRow>> ProfileReports(const std::string& profile) = 0;
  virtual Result<ProfileReportRow> ProfileReportById(const Uuid& id) = 0;
  // The same document again: the row that is there. Errors: kNotFound (the profile).
  virtual Result<CalibrationRow> AddCalibration(const CalibrationRow& row, const Actor& by) = 0;
  // Newest measurement first.
  virtual Result<std::vector<CalibrationRow>> Calibrations(const std::string& profile) = 0;
  virtual Status PutScene(const SceneRow& row, const Actor& by) = 0;
  virtual Result<std::vector<SceneRow>> Scenes() = 0;
  // The picture of a scene before it is cut, for all scenes with this volume.
  virtual Status PutSceneSurface(const Sha256& volume, const Sha256& surface) = 0;
  // A new version of the exercise of this name when the content differs from the newest one;
  // returns the row as stored. Assigned to `cohort` from then on unless it is already; a zero
  // cohort: open to everybody. A draft of that name stays.
  virtual Result<ExerciseRow> PublishExercise(ExerciseRow row, const Uuid& cohort,
                                              const Actor& by) = 0;
  virtual Result<ExerciseRow> ExerciseById(const Uuid& id) = 0;
  virtual Result<ExerciseRow> ExerciseByContent(const Sha256& content) = 0;
  // Newest published versions assigned to everybody or to a cohort of the person's that is in use.
  virtual Result<std::vector<ExerciseRow>> ExercisesFor(const Uuid& person) = 0;
  virtual Result<std::vector<ExerciseRow>> AllExercises() = 0;
  // The newest version in this state of each name.
  virtual Result<std::vector<ExerciseRow>> ExercisesIn(ExerciseState state) = 0;
  // All of a name, the draft first, then newest first.
  virtual Result<std::vector<ExerciseRow>> ExerciseVersions(const std::string& name) = 0;
  // Drafts: name, title, content, scene and graded of `row` count. A `revision` that is not the
  // stored one: kConflict with field "revision", somebody else was first. Errors also: kConflict (a
  // draft of that name is there; not a draft), kNotFound (exercise, scene).
  virtual Result<ExerciseRow> PutDraft(const ExerciseRow& row, const Actor& by) = 0;
  virtual Result<ExerciseRow> ReplaceDraft(const ExerciseRow& row, const Actor& by) = 0;
  virtual Status DeleteDraft(const Uuid& id, int32_t revision, const Actor& by) = 0;
  // The draft becomes the next version; kConflict when it says what the newest one says.
  virtual Result<ExerciseRow> PublishDraft(const Uuid& id, int32_t revision, const Actor& by) = 0;
  // No version of the name is offered any more, until one is published again.
  virtual Status RetireExercise(const Uuid& id, const Actor& by) = 0;

  // Assignments; `revision` as for drafts. Errors: kNotFound (cohort, station, assignment),
  // kInvalidInput (no published exercise of that name).
  virtual Result<AssignmentRow> AddAssignment(const AssignmentRow& row, const Actor& by) = 0;
  virtual Result<AssignmentRow> ReplaceAssignment(const AssignmentRow& row, const Actor& by) = 0;
  // Errors also: kConflict with field "attempts" (some were made under it, which are released
  // through it; to end it, let it be due).
  virtual Status DeleteAssignment(const Uuid& id, int32_t revision, const Actor& by) = 0;
  virtual Result<AssignmentRow> AssignmentById(const Uuid& id) = 0;
  // By due time, those without one last.
  virtual Result<std::vector<AssignmentRow>> Assignments(const AssignmentFilter& filter) = 0;
  // Of the person's cohorts and for everybody, with a published version; exams first.
  virtual Result<std::vector<AssignedRow>> AssignmentsFor(const Uuid& person) = 0;
  // Releases every scored attempt under it; how many were not before.
  virtual Result<uint32_t> ReleaseAssignment(const Uuid& id, const Actor& by) = 0;

  // Attempts and their traces. `ticket` is what OpenAttempt's header must contain: one ticket, one
  // attempt, one header. With an assignment: kForbidden when its attempt limit is used up (field
  // "attempt_limit"), or, as an exam, when the person has another exam attempt that is not sealed
  // (field "exam"), unless kReadmitted is set; decided in the transaction, so that two stations
  // cannot both have the last one. Errors also: kNotFound with field "person", "station" or
  // "exercise" (which is not here), kConflict with field "person" (erased).
  virtual Status CreateAttempt(const AttemptRow& row, ByteView ticket, const Actor& by) = 0;
  // The attempt's ticket was handed back unused: sets kReturned, and the attempt can no longer be
  // opened. Again: nothing changes. Errors: kNotFound, kConflict (it was opened).
  virtual Status ReturnTicket(const Uuid& attempt, const Actor& by) = 0;
  // First or repeated; kConflict when another header is stored, or the ticket was returned. Whether
  // the ticket inside the header is genuine and in time is for the caller to have checked.
  virtual Status OpenAttempt(const Uuid& attempt, ByteView header) = 0;
  struct ChunkPut {
    Uuid attempt;
    trace::ChunkHead head;
    Sha256 hash;
    Bytes bytes;
    UnixMs received_ms = 0;
  };
  // Durable on return, kept under the person's key. Idempotent by (attempt, seq, hash). Same seq
  // with another hash: kConflict, the attempt is quarantined and both are kept. Out of order, or
  // not continuing the stored chain (first tick, previous hash): kInvalidInput naming what was
  // expected. Concurrent callers share one fsync. Sets kFasterThanTime when the attempt then has
  // more ticks and gaps than fit between its ticket and received_ms (2 s and 1 % more are granted,
  // for clocks), kOverTime beyond its limit.
  virtual Status AppendChunk(const ChunkPut& chunk) = 0;
  // Refuses a seal that does not match the committed chunks (kConflict). Moves the trace from rows
  // into one write-once blob (a trace file, schemas/trace_format.md) and queues a "score" job; an
  // exam made faster than time is quarantined instead, and Rescore is how an instructor accepts it.
  // Sets kLate when the ticks cannot have been made between ticket and due time, else kLateUpload
  // when the last chunk came after it. Idempotent.
  virtual Status SealAttempt(const trace::Seal& seal, UnixMs now_ms) = 0;
  virtual Result<AttemptRow> AttemptById(const Uuid& id) = 0;
  virtual Result<std::vector<AttemptRow>> Attempts(const AttemptFilter& filter) = 0;
  virtual Result<Bytes> AttemptHeader(const Uuid& attempt) = 0;
  virtual Result<std::vector<Bytes>> AttemptChunks(const Uuid& attempt) = 0;
  virtual Result<trace::Seal> AttemptSeal(const Uuid& attempt) = 0;
  // What the job leaves: score JSON, final volume blob, page data (surface with deviation, force
  // series).
  struct AttemptResult {
    double score = 0;
    bool critical_fail = false;
    Sha256 score_json, final_volume, surface, series;
    std::optional<Uuid> reference;      // none when the exercise has no reference yet
    double replay_realtime_factor = 0;  // recorded time / replay time: of the machine, not the work
  };
  // `job`: the run that made it, whose cause is kept with it; zero: none did, the cause is "seal".
  // Errors also: kUnavailable (that run was cancelled, or is over).
  virtual Status FinishAttempt(const Uuid& attempt, const AttemptResult& result,
                               const Uuid& job) = 0;
  virtual Status FailAttempt(const Uuid& attempt, const std::string& problem, const Uuid& job) = 0;
  virtual Result<AttemptResult> ResultOf(const Uuid& attempt) = 0;
  // Every run, newest first. Of earlier ones only the score and its reasons are kept.
  virtual Result<std::vector<ResultRow>> ResultsOf(const Uuid& attempt) = 0;
  // Of a run's attempt. kUnavailable: it was cancelled, or is over; stop.
  virtual Status SetProgress(const Uuid& job, double progress) = 0;
  // Judging: each of these, and another score, raises AttemptRow::revision when it changes
  // something. `revision`: the one that was seen; none: whatever it is. Errors also: kConflict with
  // field kStale.
  virtual Status ReleaseAttempt(const Uuid& attempt, const Actor& by,
                                std::optional<int32_t> revision = {}) = 0;
  virtual Status WithdrawRelease(const Uuid& attempt, const Actor& by,
                                 std::optional<int32_t> revision = {}) = 0;
  // None: the computed score counts again. Errors: kNotFound, kConflict (not scored).
  virtual Status OverrideScore(const Uuid& attempt, const std::optional<ScoreOverride>& score,
                               const Actor& by, std::optional<int32_t> revision = {}) = 0;
  // Sets bits of AttemptFlag, with the reason in the audit trail; nothing changes when they are
  // set.
  virtual Status FlagAttempt(const Uuid& attempt, uint32_t flags, const std::string& reason,
                             const Actor& by, std::optional<int32_t> revision = {}) = 0;
  // The chunks that contradict committed ones, as far as they were kept; by number.
  virtual Result<std::vector<ContradictionRow>> ContradictionsOf(const Uuid& attempt) = 0;
  // Queues a scoring run with the exercise's newest reference. Of a quarantined attempt this
  // accepts what is committed: one that was not sealed is sealed with that. Errors: kConflict (not
  // sealed, a run is queued, recording removed).
  virtual Status Rescore(const Uuid& attempt, const std::string& cause, const Actor& by) = 0;

  virtual Result<AnnotationRow> AddAnnotation(const AnnotationRow& row, const Actor& by) = 0;
  // Text, tick and point of `row` count; `revision` as for drafts.
  virtual Result<AnnotationRow> ReplaceAnnotation(const AnnotationRow& row, const Actor& by) = 0;
  virtual Status DeleteAnnotation(const Uuid& id, int32_t revision, const Actor& by) = 0;
  virtual Result<AnnotationRow> AnnotationById(const Uuid& id) = 0;
  // By tick.
  virtual Result<std::vector<AnnotationRow>> AnnotationsOf(const Uuid& attempt) = 0;

  // One per attempt (kConflict), of a released one.
  virtual Status FileAppeal(const Uuid& attempt, const std::string& text, const Actor& by) = 0;
  // With `regrade` as Rescore, in the same transaction. Errors: kNotFound, kConflict (answered).
  virtual Status AnswerAppeal(const Uuid& attempt, bool regrade, const std::string& answer,
                              const Actor& by) = 0;
  virtual Result<std::optional<AppealRow>> AppealOf(const Uuid& attempt) = 0;

  // A sealed and scored attempt becomes the exercise's reference (newest that is not withdrawn
  // wins); attempts of that exercise which were sealed without a reference are queued for scoring,
  // itself included (it then reads deviation 0). `consent`: students may see the name.
  virtual Result<ReferenceRow> AddReference(const Uuid& attempt, const std::string& dentist,
                                            bool consent, const Actor& by) = 0;
  virtual Result<ReferenceRow> ReferenceById(const Uuid& id) = 0;
  // Newest first, withdrawn ones too.
  virtual Result<std::vector<ReferenceRow>> References(const Uuid& exercise) = 0;
  // Scores made with it stay until they are made again.
  virtual Status WithdrawReference(const Uuid& id, const Actor& by) = 0;
  virtual Result<std::optional<ReferenceRow>> ReferenceFor(const Uuid& exercise) = 0;

  // Jobs as leases: a job whose lease ran out is taken again; after 3 tries it is "failed" and
  // shown. Taking a "score" job turns its attempt to "scoring"; its last failure to "failed", or
  // back to "scored" with `problem` set where an earlier run left a score.
  virtual Result<std::optional<JobRow>> LeaseJob(UnixMs now_ms, UnixMs lease_ms) = 0;
  // Of one that is not running (cancelled, or finished by who took it over): nothing changes.
  virtual Status FinishJob(const Uuid& job, bool ok, const std::string& error) = 0;
  // Stopped before its end through no fault of its own (shutdown): queued again, the try not
  // counted.
  virtual Status ReturnJob(const Uuid& job) = 0;
  virtual Result<std::vector<JobRow>> Jobs(const std::string& state) = 0;
  virtual Result<std::vector<JobRow>> FindJobs(const JobFilter& filter) = 0;
  // Queued or running; the attempt is "sealed" again, or "scored" if an earlier run left a score.
  // Its worker hears of it in SetProgress or FinishAttempt. Errors: kNotFound, kConflict (over).
  virtual Status CancelJob(const Uuid& job, const Actor& by) = 0;

  // Newest first.
  virtual Result<std::vector<AuditRow>> Audit(uint32_t limit) = 0;
  virtual Result<std::vector<AuditRow>> FindAudit(const AuditFilter& filter) = 0;
  // What the person did and what was done to the person and the person's attempts, oldest first.
  virtual Result<std::vector<AuditRow>> AuditAbout(const Uuid& person) = 0;
  // Something that changed nothing here but is to be known: a backup, an export.
  virtual Status NoteAudit(const Actor& by, const std::string& action, const std::string& object,
                           const std::string& after_json) = 0;

  // Erases a person: key, attempts with everything made from them, sessions, memberships, name. The
  // audit trail keeps the id, which nothing leads to any more, and a tombstone stays, so that the
  // person is erased again after a restore. Scores of others that were compared with a reference
  // cut of this person stay. Idempotent after a failure. Errors: kNotFound; kConflict (the person's
  // attempts are references and `with_references` is not set; the only admin who may sign in);
  // kUnavailable (a backup is running).
  virtual Result<ErasureReport> ErasePerson(const Uuid& person, bool with_references,
                                            const Actor& by) = 0;

  virtual Result<std::vector<RetentionRule>> RetentionRules() = 0;
  // Days 0: no rule. Errors: kInvalidInput.
  virtual Status SetRetention(const RetentionRule& rule, const Actor& by) = 0;
  // Removes what the rules say; with `dry_run` only tells. Errors: kUnavailable (a backup is
  // running).
  virtual Result<RetentionReport> ApplyRetention(UnixMs now_ms, bool dry_run, const Actor& by) = 0;
  // Ends what an erasure had to leave (ErasureReport::finished), or a crash; ApplyRetention does it
  // too. Writes wait meanwhile. Nothing to do: nothing. Errors: kUnavailable (a backup is running,
  // or another erasure; somebody reads), kStorage (no room); it is left for the next call.
  virtual Status FinishErasures() = 0;
  // The program is about to end: from now on no other process is waited for, and FinishErasures,
  // also as the end of ErasePerson, leaves the rest to the next start. Any thread.
  virtual void StopWaiting() = 0;

  // Never fails: trouble is what it tells.
  virtual StoreHealth Health() = 0;
  // After a write that failed: writes something small, so that Health knows whether writing works
  // again. Else nothing.
  virtual Status TryWrite() = 0;
};

}  // namespace enamel::server
