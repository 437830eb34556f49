#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "server/storage/blobs.h"
#include "server/storage/engine/database.h"
#include "server/storage/engine/folder_lock.h"
#include "server/storage/engine/readers.h"
#include "server/storage/engine/rewrite.h"
#include "server/storage/engine/space_guard.h"
#include "server/storage/engine/writer.h"
#include "server/storage/keyring.h"
#include "server/storage/master_key.h"
#include "server/storage/sql/audit_row.h"
#include "server/storage/sql/query.h"
#include "server/storage/sql/sealed_rows.h"
#include "server/storage/sql/sign_in_rows.h"
#include "server/storage/sqlite_store.h"
#include "server/storage/transactions.h"

// Private to server/storage: the class behind OpenSqliteStore, with a source in this folder for each
// subject; opening, blobs and health are in storage/sqlite_store.cpp.
namespace enamel::server::sqlite {

class SqliteStore final : public Store {
 public:
  // What a store is opened on: a connection that writes, and how one is made that reads.
  struct Database {
    std::unique_ptr<Db> writer;
    std::function<Result<std::unique_ptr<Db>>()> open_reader;
    // Another that writes; none where no other server has its rows in this database.
    std::function<Result<std::unique_ptr<Db>>()> open_writer{};
  };
  // What is in S3 stores: clients, and what keys are wrapped with; none: in the folder.
  struct Buckets {
    std::unique_ptr<s3::S3Client> blobs, keys;
    std::optional<MasterKey> master;
  };
  // `server` is zero where no other has its rows in this database.
  SqliteStore(const SqliteOptions& options, Database database, FolderLock lock,
              const trace::SecretKey& ticket_key, const Uuid& server, Buckets buckets);

  Result<Uuid> CreatePerson(const Person& person, const std::string& password_verifier,
                            const std::vector<Uuid>& cohorts, const Actor& by) override;
  Result<Person> PersonById(const Uuid& id) override;
  Result<Person> PersonByLogin(const std::string& login) override;
  Result<std::string> PasswordVerifier(const Uuid& person) override;
  Status UseOneTimePassword(const Uuid& person) override;
  Status SetPassword(const Uuid& person, const std::string& verifier, bool for_one_use,
                     const Actor& by) override;
  Status SetLanguage(const Uuid& person, const std::string& language) override;
  Status SetDisabled(const Uuid& person, bool disabled, const Actor& by) override;
  Result<std::vector<Person>> People() override;
  Result<std::vector<Person>> FindPeople(const PeopleFilter& filter) override;
  Result<Person> EditPerson(const Uuid& id, const PersonEdit& edit, int32_t revision,
                            const Actor& by) override;
  Result<RosterPlan> ImportRoster(const std::vector<RosterRow>& rows, bool dry_run,
                                  const Actor& by) override;
  Status CreateSession(const SessionRow& session) override;
  Result<SessionRow> FindSession(const Sha256& token_hash) override;
  Status TouchSession(const Sha256& token_hash, UnixMs now_ms) override;
  Status EndSession(const Sha256& token_hash) override;
  Result<size_t> EndSessionsOf(const Uuid& person, const Actor& by) override;
  Result<std::vector<SessionRow>> SessionsOf(const Uuid& person) override;
  Result<SessionRow> SessionById(const Uuid& id) override;
  Status EndSessionById(const Uuid& id, const Actor& by) override;
  Status ChangeSignIns(const std::vector<Sha256>& keys, const SignInChange& change) override {
    return sign_ins_.Change(keys, change);
  }
  Status ConfirmSession(const Sha256& token_hash, UnixMs now_ms) override;
  Result<Uuid> CreateCohort(const std::string& name, const Actor& by) override;
  Result<Cohort> CohortById(const Uuid& id) override;
  Result<Cohort> EditCohort(const Uuid& id, const CohortEdit& edit, int32_t revision,
                            const Actor& by) override;
  Status ChangeMembers(const Uuid& cohort, const std::vector<Uuid>& add,
                       const std::vector<Uuid>& remove, const Actor& by) override;
  Status AddToCohort(const Uuid& cohort, const Uuid& person, const Actor& by) override;
  Result<std::vector<Cohort>> CohortsOf(const Uuid& person) override;
  Result<std::vector<Cohort>> Cohorts() override;
  Result<std::vector<Person>> CohortMembers(const Uuid& cohort) override;
  Result<bool> ShareCohort(const Uuid& a, const Uuid& b) override;

  Result<Uuid> AddEnrolCode(const Sha256& code_hash, UnixMs expires_ms, const Actor& by) override;
  Result<std::vector<EnrolCodeRow>> OpenEnrolCodes(UnixMs now_ms) override;
  Status WithdrawEnrolCode(const Uuid& id, const Actor& by) override;
  Result<bool> IsEnrolCode(const Sha256& code_hash) override;
  Result<StationRow> EnrolStation(const Sha256& code_hash, StationRow station,
                                  const Sha256& credential_hash, UnixMs now_ms) override;
  Result<StationRow> StationByCredential(const Uuid& id, const Sha256& credential_hash) override;
  Result<StationRow> StationById(const Uuid& id) override;
  Status TouchStation(const Uuid& id, const std::string& software, uint32_t core_version,
                      UnixMs now_ms) override;
  Result<StationRow> RenameStation(const Uuid& id, const std::string& name, int32_t revision,
                                   const Actor& by) override;
  Status RevokeStation(const Uuid& id, const Actor& by) override;
  Result<std::vector<StationRow>> Stations() override;
  Result<std::vector<Uuid>> RevokedStations() override;
  Result<std::vector<SchoolRow>> Schools() override;
  Status AddSchool(const SchoolRow& row, const Actor& by) override;
  Status ChangeSchool(const SchoolRow& row, const Actor& by) override;
  Status RemoveSchool(const std::string& name, const Actor& by) override;
  Result<std::vector<ListedDevice>> ListedDevices() override;
  Status ListDevice(const std::string& name, const std::string& title, const Actor& by) override;
  Status UnlistDevice(const std::string& name, const Actor& by) override;
  Result<bool> IsListed(const Hand& hand) override;

  Result<Sha256> PutBlob(ByteView data) override;
  Result<Sha256> PutAttemptBlob(const Uuid& attempt, ByteView data) override;
  Result<Bytes> GetBlob(const Sha256& hash) override;
  bool HasBlob(const Sha256& hash) override { return blobs_.Has(hash); }
  Status PutProfile(const ProfileRow& row, const Actor& by) override;
  Result<std::vector<ProfileRow>> Profiles() override;
  Result<std::vector<ProfileRow>> ProfileVersions(const std::string& name) override;
  Result<ProfileReportRow> AddProfileReport(const ProfileReportRow& row, const Actor& by) override;
  Result<std::vector<ProfileReportRow>> ProfileReports(const std::string& profile) override;
  Result<ProfileReportRow> ProfileReportById(const Uuid& id) override;
  Result<CalibrationRow> AddCalibration(const CalibrationRow& row, const Actor& by) override;
  Result<std::vector<CalibrationRow>> Calibrations(const std::string& profile) override;
  Status PutScene(const SceneRow& row, const Actor& by) override;
  Result<std::vector<SceneRow>> Scenes() override;
  Status PutSceneSurface(const Sha256& volume, const Sha256& surface) override;
  Result<ExerciseRow> PublishExercise(ExerciseRow row, const Uuid& cohort,
                                      const Actor& by) override;
  Result<ExerciseRow> ExerciseById(const Uuid& id) override;
  Result<ExerciseRow> ExerciseByContent(const Sha256& content) override;
  Result<std::vector<ExerciseRow>> ExercisesFor(const Uuid& person) override;
  Result<std::vector<ExerciseRow>> AllExercises() override;
  Result<std::vector<ExerciseRow>> ExercisesIn(ExerciseState state) override;
  Result<std::vector<ExerciseRow>> ExerciseVersions(const std::string& name) override;
  Result<ExerciseRow> ShareExercise(const Uuid& id, const SharingEdit& edit,
                                    const Actor& by) override;
  Result<ExerciseRow> PutDraft(const ExerciseRow& row, const Actor& by) override;
  Result<ExerciseRow> ReplaceDraft(const ExerciseRow& row, const Actor& by) override;
  Status DeleteDraft(const Uuid& id, int32_t revision, const Actor& by) override;
  Result<ExerciseRow> PublishDraft(const Uuid& id, int32_t revision, const Actor& by) override;
  Status RetireExercise(const Uuid& id, const Actor& by, const std::string& reason = {}) override;
  Status OfferExerciseAgain(const Uuid& id, const Actor& by) override;
  Result<AssignmentRow> AddAssignment(const AssignmentRow& row, const Actor& by) override;
  Result<AssignmentRow> ReplaceAssignment(const AssignmentRow& row, const Actor& by) override;
  Result<AssignmentMove> MoveAssignment(const Uuid& id, const Uuid& version, int32_t revision,
                                        bool look_only, const Actor& by) override;
  Status DeleteAssignment(const Uuid& id, int32_t revision, const Actor& by) override;
  Result<AssignmentRow> AssignmentById(const Uuid& id) override;
  Result<std::vector<AssignmentRow>> Assignments(const AssignmentFilter& filter) override;
  Result<std::vector<AssignedRow>> AssignmentsFor(const Uuid& person) override;
  Result<uint32_t> ReleaseAssignment(const Uuid& id, const Actor& by) override;

  Status CreateAttempt(const AttemptRow& row, ByteView ticket, const Actor& by) override;
  Status ReturnTicket(const Uuid& attempt, const Actor& by) override;
  Status OpenAttempt(const Uuid& attempt, ByteView header) override;
  Status KeepFacts(const Uuid& attempt, const std::string& facts) override;
  Status AppendChunk(const ChunkPut& chunk) override;
  Status SealAttempt(const trace::Seal& seal, UnixMs now_ms) override;
  Result<AttemptRow> AttemptById(const Uuid& id) override;
  Result<std::vector<AttemptRow>> Attempts(const AttemptFilter& filter) override;
  Result<Bytes> AttemptHeader(const Uuid& attempt) override;
  Result<std::vector<Bytes>> AttemptChunks(const Uuid& attempt) override;
  Result<std::vector<Bytes>> NewestChunks(const Uuid& attempt, uint32_t from,
                                          uint32_t most) override;
  Result<trace::Seal> AttemptSeal(const Uuid& attempt) override;
  Status FinishAttempt(const Uuid& attempt, const AttemptResult& result,
                       const Uuid& lease) override;
  Status FailAttempt(const Uuid& attempt, const std::string& problem, const Uuid& lease) override;
  Result<AttemptResult> ResultOf(const Uuid& attempt) override;
  Status SetProgress(const Uuid& lease, double progress) override;
  Result<std::vector<ResultRow>> ResultsOf(const Uuid& attempt) override;
  Status ReleaseAttempt(const Uuid& attempt, const Actor& by,
                        std::optional<int32_t> revision) override;
  Status WithdrawRelease(const Uuid& attempt, const Actor& by,
                         std::optional<int32_t> revision) override;
  Status OverrideScore(const Uuid& attempt, const std::optional<ScoreOverride>& score,
                       const Actor& by, std::optional<int32_t> revision) override;
  Status FlagAttempt(const Uuid& attempt, uint32_t flags, const std::string& reason,
                     const Actor& by, std::optional<int32_t> revision) override;
  Result<std::vector<ContradictionRow>> ContradictionsOf(const Uuid& attempt) override;
  Result<std::vector<MotionRow>> MotionsBefore(const Uuid& attempt, uint32_t limit) override;
  Result<std::optional<NearAttempt>> NearestTo(const Uuid& attempt) override;
  Status ClearExcuse(const Uuid& attempt, const Actor& by,
                     std::optional<int32_t> revision) override;
  Status Rescore(const Uuid& attempt, const std::string& cause, const Actor& by) override;
  Status RestoreResult(const Uuid& attempt, int32_t run, const Actor& by,
                       std::optional<int32_t> revision) override;
  Result<AnnotationRow> AddAnnotation(const AnnotationRow& row, const Actor& by) override;
  Result<AnnotationRow> ReplaceAnnotation(const AnnotationRow& row, const Actor& by) override;
  Status DeleteAnnotation(const Uuid& id, int32_t revision, const Actor& by) override;
  Result<AnnotationRow> AnnotationById(const Uuid& id) override;
  Result<std::vector<AnnotationRow>> AnnotationsOf(const Uuid& attempt) override;
  Status FileAppeal(const Uuid& attempt, const std::string& text, const Actor& by) override;
  Status AnswerAppeal(const Uuid& attempt, bool regrade, const std::string& answer,
                      const Actor& by) override;
  Result<std::optional<AppealRow>> AppealOf(const Uuid& attempt) override;
  Result<ReferenceRow> AddReference(const Uuid& attempt, const std::string& dentist, bool consent,
                                    const Actor& by, const std::string& anyway = {}) override;
  Result<ReferenceRow> ReferenceById(const Uuid& id) override;
  Result<std::vector<ReferenceRow>> References(const Uuid& exercise) override;
  Status WithdrawReference(const Uuid& id, const Actor& by) override;
  Result<std::optional<ReferenceRow>> ReferenceFor(const Uuid& exercise) override;

  Result<std::optional<RubricRow>> RubricFor(const Uuid& exercise) override;
  Result<std::vector<RubricRow>> Rubrics(const Uuid& exercise) override;
  Result<RubricRow> PublishRubric(const RubricRow& row, const Actor& by) override;

  Result<BatchRow> RescoreTogether(const BatchRow& row, const std::vector<Uuid>& attempts,
                                   uint32_t& left_out, const Actor& by) override;
  Result<std::vector<BatchRow>> Batches() override;
  Result<BatchRow> BatchById(const Uuid& id) override;
  Status CancelBatch(const Uuid& id, const Actor& by) override;
  Result<std::optional<Uuid>> TakeTimeline() override;
  Status KeepTimeline(const Uuid& attempt) override;
  Status ReturnTimeline(const Uuid& attempt) override;
  Status PutTimeline(const Uuid& attempt, const Sha256& content) override;
  Status FailTimeline(const Uuid& attempt, const std::string& problem, bool again) override;
  Result<TimelineRow> TimelineOf(const Uuid& attempt) override;
  Result<Sha256> StartToothOf(const Sha256& volume) override;
  Status PutStartTooth(const Sha256& volume, const Sha256& content) override;
  Result<bool> IsStartTooth(const Sha256& content) override;

  Result<std::vector<ChairRemark>> ChairRemarks(UnixMs since_ms) override;
  Status MoveRemarks(const std::vector<ChairRemark>& moved) override;
  Status KeepLinks(const std::vector<StationLink>& come, const std::vector<Uuid>& gone,
                   bool anew) override;
  Result<std::vector<StationLink>> LinksElsewhere() override;

  Result<std::optional<JobRow>> LeaseJob(UnixMs now_ms, UnixMs lease_ms) override;
  Status KeepLease(const Uuid& lease, UnixMs until_ms) override;
  Status FinishJob(const Uuid& lease, bool ok, const std::string& error) override;
  Status ReturnJob(const Uuid& lease) override;
  Result<std::vector<JobRow>> Jobs(const std::string& state) override;
  Status CancelJob(const Uuid& job, const Actor& by) override;
  Result<std::vector<JobRow>> FindJobs(const JobFilter& filter) override;
  Result<std::vector<AuditRow>> Audit(uint32_t limit) override;
  Result<std::vector<AuditRow>> FindAudit(const AuditFilter& filter) override;
  Result<std::vector<AuditRow>> AuditAbout(const Uuid& person) override;
  Status NoteAudit(const Actor& by, const std::string& action, const std::string& object,
                   const std::string& after_json) override;
  Result<ErasureReport> ErasePerson(const Uuid& person, bool with_references,
                                    const Actor& by) override;
  Result<std::vector<RetentionRule>> RetentionRules() override;
  Status SetRetention(const RetentionRule& rule, const Actor& by) override;
  Result<RetentionReport> ApplyRetention(UnixMs now_ms, bool dry_run, const Actor& by) override;
  StoreHealth Health() override;
  Status MatchIdentity(ServerPart part, const std::optional<Sha256>& fingerprint) override;
  bool IsShared() const override { return many_; }
  Status LookAtDatabase() override;
  Status TryWrite() override;
  Status FinishErasures() override;
  void StopWaiting() override { writer_.StopWaiting(); }

  // For what copies all of it (engine/backup.h, engine/move.h).
  Blobs& blobs() { return blobs_; }
  Keyring& keyring() { return keyring_; }
  Result<Rewriter::Upkeep> TakeUpkeep() { return rewriter_.TakeUpkeep(); }
  Transactions OwnTransactions();
  // Nothing is deleted in the background any more.
  Status FinishSealed() { return sealed_rows_ ? sealed_rows_->Finish() : Status::Ok(); }
  // That were heard within LiveStore::kServerSilentMs, besides this one.
  Result<size_t> OtherServers();

  // What is erased here, in the key ring or in the database, is erased in both: after a restore of
  // either, and after a crash in between. Leaves the rest to FinishErasures.
  Status Reconcile();

 private:
  // `read` is called as Result<T>(Db&) on a connection of the pool.
  template <typename F>
  auto Read(const F& read) -> std::invoke_result_t<F, Db&> {
    ENAMEL_ASSIGN_OR_RETURN(auto db, readers_.Take());
    Readers::Lease lease(readers_, std::move(db));
    auto result = read(lease.db());
    if (lease.db().damaged()) damaged_ = true;
    return result;
  }
  Status Write(const Writer::Work& work) { return writer_.Run(work); }
  Status Write(const std::function<Status(Db&)>& work) {
    return writer_.Run([&](Db& db, bool&) { return work(db); });
  }
  // For what comes with every chunk and every job: `work` first locks (Db::RowLock) the attempt or job
  // that it decides on. Servers that work on others do not meet.
  Status WriteRow(const Writer::Work& work) { return writer_.Run(work, sql::Isolation::kRowLocks); }
  Status WriteRow(const std::function<Status(Db&)>& work) {
    return WriteRow(Writer::Work([&](Db& db, bool&) { return work(db); }));
  }
  // Errors: kNotFound.
  Result<Uuid> PersonOf(const Uuid& attempt);
  // With a key that counts while the person's key is of this generation, 0: however that is. False: it does not count,
  // or the chunk is not the next one, and nothing was done: it is to be sent with a key that was asked for.
  struct KeyForChunk {
    Uuid person;
    DataKey key;
    int64_t generation = 0;
  };
  Result<bool> AppendWith(const KeyForChunk& key, const ChunkPut& chunk);
  void CountChunk(const ChunkPut& chunk);
  // The key under which things of this attempt are kept. Errors: kNotFound, kConflict (erased).
  struct PersonKey {
    Uuid person;
    DataKey key;
  };
  Result<PersonKey> KeyOf(const Uuid& attempt);
  std::unique_ptr<Blobs> MakeBlobs(const SqliteOptions& options, std::unique_ptr<s3::S3Client> s3);
  std::unique_ptr<Keyring> MakeKeyring(const SqliteOptions& options, Buckets& buckets);
  std::optional<Rewriter::Shared> SharedWith(
      const std::function<Result<std::unique_ptr<Db>>()>& open_writer);
  // By the key ring or the database, and from now on by both, unless the key ring is away: then
  // FinishErasures asks again. Errors: those of Keyring but kUnavailable.
  Result<std::vector<Tombstone>> AllErased();
  // Who is among them and in the database: it was restored, or an erasure broke off.
  Status EraseAgain();
  // Whether recordings may come in now. Errors: kUnavailable, so that a station keeps what it has
  // and comes back.
  Status MayRecord();
  // Before this server's first lease: those of an earlier one are over.
  Status EndEarlierLeases();

  Status RepeatedAfterSeal(const ChunkPut& chunk);
  Status MoveTraceToBlob(const trace::Seal& seal, Sha256& blob);
  // Flags the attempt when the seal is of another recording than what is committed.
  Status NoteOtherSeal(const trace::Seal& seal);
  // Seals a quarantined attempt that was not, with what is committed.
  Status AcceptCommitted(const Uuid& attempt, const Actor& by);

  static constexpr size_t kMaxRemembered = 50'000;

  const std::filesystem::path folder_;
  const FolderLock lock_;
  const AuditSigner signer_;  // goes with the writer's connection
  const Uuid owner_;          // of the leases
  const bool many_;           // other servers have their rows here too
  SpaceGuard space_;
  Rewriter rewriter_;
  Writer writer_;
  Readers readers_;
  const std::unique_ptr<Blobs> owned_blobs_;
  Blobs& blobs_;
  const std::unique_ptr<Keyring> owned_keyring_;
  Keyring& keyring_;
  SignInRows sign_ins_;
  std::optional<SealedRows> sealed_rows_;  // the server's; others' rows go with the seal
  std::mutex leases_mutex_;
  bool earlier_leases_;  // there may be some; guarded by leases_mutex_
  std::mutex people_mutex_;
  std::unordered_map<std::string, Uuid> person_of_;  // attempt to person; guarded by people_mutex_
  std::atomic<bool> damaged_{false};                 // a reader found the database damaged
  std::atomic<bool> erasures_due_{false};            // the key ring was away
  std::atomic<int64_t> clock_ahead_ms_{0};
  std::atomic<Standby> standby_{Standby::kNotKept};
  std::atomic<uint64_t> chunks_{0}, chunk_bytes_{0}, sealed_{0};
};

// OpenStore, for what copies all of a school: everything that it opens is a SqliteStore.
Result<std::unique_ptr<SqliteStore>> OpenWholeStore(const SqliteOptions& options);

// Shared by the sources.
using Json = std::string;
// {"name":value,…} of text values, for audit rows.
Json JsonOf(std::initializer_list<std::pair<const char*, std::string>> members);
// Adds a row, signed, with the state of what the action decides about (decisions.h) as it is now:
// called after the change. The connection is the writer's, which has the signer with it.
Status WriteAudit(Db& db, const Actor& by, const char* action, const std::string& object,
                  const Json& before, const Json& after);
// The same about a subject that action and object do not tell.
Status WriteAuditAbout(Db& db, const std::string& subject, const Actor& by, const char* action,
                       const std::string& object, const Json& before, const Json& after);
// Where one chain ends, or each. None: no row is in it.
Result<std::optional<AuditHead>> FindAuditHead(Db& db, const Uuid& chain);
Result<std::vector<AuditHead>> AuditHeads(Db& db);
// kConflict from a UNIQUE constraint, in words.
Status Explain(Status status, const std::string& conflict);
Status QueueScoreJob(Db& db, const Uuid& attempt, const std::string& cause,
                     const std::optional<Uuid>& batch = {});
Status CancelRun(Db& db, JobRow job, const Actor& by);
// Queued and running.
Result<std::vector<JobRow>> OpenJobsOf(Db& db, const Uuid& batch);
Result<std::vector<JobRow>> OpenRunsOf(Db& db, const Uuid& attempt);
Result<ExerciseRow> FindExercise(Db& db, const Uuid& id);
// The newest published version of a name; none: no version is offered.
Result<std::optional<ExerciseRow>> OfferedVersion(Db& db, const std::string& name);
// kConflict with field "assignment" while an exam with this exercise is open or being taken; of one
// assignment, when it is named.
Status NoExamMustBeOpen(Db& db, const std::string& name, const std::optional<Uuid>& assignment);
// Of ENAMEL_EXERCISE_COLUMNS (exercise_rows.h), which begin at `first`.
ExerciseRow ExerciseOf(const Query& q, int first);
// An exercise name that nobody owns belongs to the actor from now on (content_store.h says how).
Status OwnName(Db& db, const std::string& name, const Actor& by);
// The audit row of an assignment that was just made.
Status NoteAssignment(Db& db, const Uuid& id, const Actor& by);
// A name of which no exercise is left can be anybody's again.
Status FreeUnusedName(Db& db, const std::string& name, const Actor& by);
// What the person owns is the school's from now on.
Status GiveNamesToSchool(Db& db, const Uuid& owner, const Actor& by);
// kConflict with field "revision" unless they are the same.
Status MustBeRevision(int32_t stored, int32_t expected);
// kForbidden when the terms of the row's assignment leave no attempt to its person.
Status MayBeIssued(Db& db, const AttemptRow& row);
Result<bool> IsListedIn(Db& db, const Hand& hand);
Status SetReleased(Db& db, const Uuid& attempt, bool released, const Actor& by);
// Sets bits of AttemptFlag that are not set, with an audit row.
Status SetFlags(Db& db, const Uuid& attempt, uint32_t flags, const std::string& reason,
                const Actor& by);
Status RaiseRevision(Db& db, const Uuid& attempt);
// kConflict when the person is the only admin who may sign in.
Status MustNotBeTheOnlyAdmin(Db& db, const Person& person);
// Jobs that a worker of an earlier process of this server held may be taken again at once.
Status EndLeases(Db& db, const Uuid& owner);
// kUnavailable unless the run with this lease is under way; locks its job. Zero: no run is meant.
Status MustBeRunning(Db& db, const Uuid& lease);
// The job of this run is done. In the transaction that keeps its result: a worker that died in between would be
// followed by another, with a second result. Zero: no run is meant.
Status FinishRun(Db& db, const Uuid& lease);
// What the row "attempt.score" of the audit trail tells, or that of an earlier run which counts
// again: score, signed result, why the run was made, where its motion lies.
inline constexpr char kAuditScore[] = "attempt.score", kAuditRestore[] = "attempt.restore";
Result<Json> ScoredJson(Db& db, const Uuid& attempt, const Sha256& score_json, ByteView document);
Result<AttemptRow> FindAttempt(Db& db, const Uuid& id);
// Every blob that a row names.
Result<std::set<Sha256>> NamedBlobs(Db& db);
// timelines.cpp: a scored attempt waits for its timeline, unless it has one already; and
// the timeline goes, its blob into `blobs`.
Status WaitForTimeline(Db& db, const Uuid& attempt);
Status DropTimeline(Db& db, const Uuid& attempt, std::set<Sha256>& blobs);
// motions.cpp: what a run says of the motion, with its flag; and it goes, its blob into `blobs`.
Status KeepMotion(Db& db, const Uuid& attempt, const Store::AttemptResult& result);
Status DropMotion(Db& db, const Uuid& attempt, std::set<Sha256>& blobs);
// Deletes attempts with all that hangs on them (chunks, evidence, jobs, references); adds the blobs
// they named to `blobs`. Others' scores that were compared with them stay, without naming them.
Status DeleteAttempts(Db& db, const std::vector<Uuid>& attempts, std::set<Sha256>& blobs);
// Deletes the person's rows, keeps the tombstone, writes the audit row.
Status DeletePerson(Db& db, const Uuid& person, const Tombstone& tombstone, const Actor& by,
                    ErasureReport& report, std::set<Sha256>& blobs);
Result<std::vector<Tombstone>> ErasuresIn(Db& db);

}  // namespace enamel::server::sqlite
