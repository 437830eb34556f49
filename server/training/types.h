#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "common/hands/hand.h"

// The domain: people, cohorts, stations, exercises, attempts. Plain values, no I/O.
// Times are milliseconds since the Unix epoch (UTC).
namespace enamel::server {

using UnixMs = int64_t;

enum class Role : uint8_t { kStudent = 1, kInstructor = 2, kAdmin = 3 };
const char* RoleName(Role role);  // "student", "instructor", "admin"
std::optional<Role> RoleFromName(std::string_view name);

// That the page speaks, by the codes of schemas/words.md.
inline constexpr std::array<std::string_view, 3> kPageLanguages = {"en", "de", "zh"};

struct Person {
  Uuid id;
  std::string login;  // lower case, unique within the school
  std::string display_name;
  Role role = Role::kStudent;
  bool disabled = false;
  UnixMs created_ms = 0;
  bool must_change_password = false;  // it was made up here and is good for changing it only
  UnixMs password_ms = 0;             // when it was set
  int32_t revision = 1;               // server/training/revision.h
  std::string language;               // of the page, of kPageLanguages; empty: the browser's
  bool pin_locked = false;            // PeopleRows::TryPin
  bool may_import_teeth = false;      // as an instructor (CanImportTeeth)
};

// Which people; nothing set: all.
struct PeopleFilter {
  std::optional<Role> role{};
  std::optional<Uuid> cohort{};
  std::optional<bool> disabled{};
  std::string text{};         // each of its words is part of login or display name (SearchWords)
  std::string after_login{};  // page: logins beyond this (they are sorted by it)
  uint32_t limit = 50;        // at most 1000
};

// Set members are changed.
struct PersonEdit {
  std::optional<std::string> display_name{};
  std::optional<Role> role{};
  std::optional<bool> disabled{};
  std::optional<bool> may_import_teeth{};
};

struct Cohort {
  Uuid id;
  std::string name;
  UnixMs archived_ms = 0;  // 0: in use. Archived: kept with its attempts, offered no exercises
  int32_t revision = 1;
};

struct CohortEdit {
  std::optional<std::string> name{};
  std::optional<bool> archived{};
};

struct StationRow {
  Uuid id;
  std::string name;
  std::vector<uint8_t> public_key;  // Ed25519, 32 bytes
  bool revoked = false;
  UnixMs enrolled_ms = 0;
  UnixMs last_seen_ms = 0;
  UnixMs revoked_ms = 0;
  std::string software;       // as it said when it connected last; empty: never did
  uint32_t core_version = 0;  // likewise
  int32_t revision = 1;
};

// A one-time code for enrolling a station. The code itself is known to whoever made it only.
struct EnrolCodeRow {
  Uuid id;
  UnixMs created_ms = 0;
  UnixMs expires_ms = 0;
};

struct ProfileRow {
  std::string name;
  std::string title;
  Sha256 content;         // JSON blob
  int32_t version = 1;    // counts the contents it had
  UnixMs created_ms = 0;  // of this version
};

// What `enamel-lab qualify` wrote about one version of a profile.
struct ProfileReportRow {
  Uuid id;
  std::string profile;
  int32_t version = 1;
  std::string media_type;  // "application/json", "text/html"
  Sha256 content;          // blob
  uint64_t bytes = 0;
  UnixMs created_ms = 0;
};

// A measurement of a device.
struct CalibrationRow {
  Uuid id;
  std::string profile;
  std::string device;
  UnixMs measured_ms = 0;
  UnixMs added_ms = 0;
  std::string document;  // schemas/calibration.schema.json
};

// A haptic device that graded work is done with.
struct ListedDevice {
  std::string name;   // ListedAs: its unit, "hid:1209:0001:A7", or its model
  std::string title;  // for people: "chair 3"
  UnixMs added_ms = 0;
  UnixMs shook_ms = 0;  // ticket of the newest attempt on it that has kShook; 0: none
};

// What stations are set to from here (schemas/station_settings.md, "Policy").
struct StationSetting {
  std::string name;
  std::string scope = "*";  // "*": every station; "lab2-*": those whose names begin so; else a name
  std::string value;
  bool fixed = false;  // before a station's own settings file
  UnixMs changed_ms = 0;
};

struct SceneRow {
  std::string name;
  std::string title;
  Sha256 content;  // JSON blob
  Sha256 volume;
  Sha256 surface{};  // ENTM blob of the volume before it is cut; zero: not made yet
};

// A draft can be replaced; only instructors and admins see it. A published version never changes;
// the newest published one of a name is offered. Retired: no longer offered, kept for its attempts.
// Stable names: "draft", "published", "retired".
enum class ExerciseState : uint8_t { kDraft = 1, kPublished = 2, kRetired = 3 };
const char* ExerciseStateName(ExerciseState state);
std::optional<ExerciseState> ExerciseStateFromName(std::string_view name);

struct ExerciseRow {
  Uuid id;
  std::string name;
  std::string title;
  int32_t version = 1;  // 0: draft
  Sha256 content;       // JSON blob of this version
  Sha256 scene;
  bool graded = true;
  UnixMs published_ms = 0;  // of a draft: when it was last put
  ExerciseState state = ExerciseState::kPublished;
  int32_t revision = 1;  // counts the changes of a draft and of the state
  // Of all versions of the name.
  Uuid owner{};              // zero: the school's
  std::string owner_name{};  // joined
  bool shared = true;        // other instructors may read and assign it
};

// Set members are changed.
struct SharingEdit {
  std::optional<bool> shared{};
  std::optional<Uuid> owner{};  // zero: the school
};

// What of several attempts under an assignment is a person's result. Stable names: "best", "last",
// "mean", "median".
enum class Counting : uint8_t { kBest = 1, kLast = 2, kMean = 3, kMedian = 4 };
const char* CountingName(Counting counting);
std::optional<Counting> CountingFromName(std::string_view name);

// In which work under an assignment the chair shows the target's outline on the tooth. Stable names:
// "practice", "always", "never".
enum class OutlineShown : uint8_t {
  kPractice = 1,  // in practice, not in graded work or exams
  kAlways = 2,
  kNever = 3
};
const char* OutlineShownName(OutlineShown shown);
std::optional<OutlineShown> OutlineShownFromName(std::string_view name);

// An exercise for a cohort: when, how often, and whether as an exam.
struct AssignmentRow {
  Uuid id;
  std::string exercise;        // name
  Uuid cohort;                 // zero: everybody
  std::string cohort_name;     // joined
  UnixMs opens_ms = 0;         // 0: at once
  UnixMs due_ms = 0;           // 0: never
  uint32_t attempt_limit = 0;  // per person; 0: as many as wanted. Excused attempts do not count
  bool exam = false;
  bool late_allowed = false;                   // attempts may begin after due_ms, and are flagged
  std::vector<Uuid> stations;                  // of an exam: where; none: anywhere
  HandsAllowed hands = HandsAllowed::kListed;  // of graded work and exams: what may hold the tool
  bool sign_off = false;  // of an exam: a second person signs at the chair (SignOffRow)
  int32_t revision = 1;   // counts the changes
  UnixMs created_ms = 0;
  Counting counting = Counting::kBest;
  OutlineShown outline = OutlineShown::kPractice;
  Uuid version_id{};  // the version that is to be done, until somebody moves the assignment
  // Joined, of that version.
  int32_t version = 0;
  std::string title{};
  bool retired = false;  // it is offered no more
  bool graded = false;
};

// What moving an assignment to another version of its exercise does, or would do.
struct AssignmentMove {
  AssignmentRow before, after;
  uint32_t attempts = 0;  // made under it with another version than the new one: they keep theirs
  uint32_t tickets = 0;   // of those, tickets with which nothing is begun yet
};

// An assignment as it stands for one person.
struct AssignedRow {
  AssignmentRow assignment;
  ExerciseRow exercise;  // the version that is to be done
  uint32_t attempts_used = 0;
};

// Life of an attempt. Stable names: "ticketed", "recording", "sealed", "scoring", "scored",
// "failed", "quarantined".
enum class AttemptState : uint8_t {
  kTicketed = 1,
  kRecording = 2,
  kSealed = 3,
  kScoring = 4,
  kScored = 5,
  kFailed = 6,
  kQuarantined = 7
};
const char* AttemptStateName(AttemptState state);
std::optional<AttemptState> AttemptStateFromName(std::string_view name);

// Facts that a reviewer must know about an attempt: bits of AttemptRow::flags. Stable names as
// below, without the k.
enum AttemptFlag : uint32_t {
  kLate = 1,            // begun, or for certain still being made, after its due time
  kLateUpload = 2,      // arrived after its due time; may have been made before
  kFasterThanTime = 4,  // more ticks than time since the ticket: not made in real time (--lockstep)
  kOverTime = 8,        // longer than the exercise's time limit; an exam counts up to there only
  kResumed = 16,        // the station broke off and went on from what it had spooled
  kExcused = 32,        // an instructor says: counts neither against the limit nor as running
  kContradicted = 256,  // a chunk came twice with different content
  kReadmitted = 64,     // its ticket was forgotten by a restore; its terms were worked out again
  kReturned = 128,      // its ticket was handed back unused: it counts for nothing
  kOtherHand = 512,     // held by what its assignment does not allow
  kNearAnother = 1024,  // its motion lies near an earlier attempt's; who reviews it alone is told
  kShook = 2048,  // hand and device swung (core::kSwingSeen): the unit is not as its profile says
  // A limit lies within the uncertainty of its value (ScoreResult::borderline): a person sets the score of graded work.
  kBorderlineScore = 4096,
};
// Flags that only reviewers of the attempt see: they point at other people.
inline constexpr uint32_t kReviewFlags = kNearAnother;
// {"late", "over_time"}.
std::vector<const char*> AttemptFlagNames(uint32_t flags);
std::optional<AttemptFlag> AttemptFlagFromName(std::string_view name);

// What an instructor says the score is.
struct ScoreOverride {
  double score = 0;  // 0..100
  std::string reason;
  Uuid by;  // zero: the command line
  UnixMs at_ms = 0;
};

struct AttemptRow {
  Uuid id;
  Uuid person;
  std::string person_name;   // display name, joined
  std::string person_login;  // joined
  Uuid station;
  Uuid exercise;
  std::string exercise_title;  // joined
  Sha256 exercise_content;
  Sha256 profile_content;
  AttemptState state = AttemptState::kTicketed;
  bool as_reference = false;  // recorded as a reference cut
  bool released = false;      // a graded score the student may see
  UnixMs ticketed_ms = 0;
  UnixMs sealed_ms = 0;
  uint32_t chunks = 0;  // committed
  uint64_t ticks = 0;
  uint64_t gap_ticks = 0;
  uint64_t trace_bytes = 0;     // header + committed chunks
  std::optional<double> score;  // computed
  Sha256 score_document;        // schemas/score.md; zero: there is none
  bool critical_fail = false;
  std::optional<ScoreOverride> overridden;  // counts instead of `score`
  double progress = 0;                      // 0..1 while scoring
  UnixMs expired_ms = 0;      // when a retention rule removed the recording; 0: it is there
  std::string problem;        // why failed or quarantined
  std::string problem_field;  // which problem (common/protocol/refusals.h)

  // Terms it was begun under, as they were then.
  std::optional<Uuid> assignment{};  // none: a reference cut, an instructor's try
  bool exam = false;
  UnixMs due_ms = 0;         // 0: none
  int32_t rate_hz = 0;       // 0: time is not checked
  uint64_t limit_ticks = 0;  // time limit; 0: none
  HandsAllowed hands = HandsAllowed::kAny;
  bool sign_off = false;
  uint32_t flags = 0;        // of AttemptFlag
  UnixMs last_chunk_ms = 0;  // when the newest chunk arrived
  int32_t revision = 1;      // of the judgement: score, override, release, excuse (revision.h)
  std::string facts = "{}";  // as the station said them last: protocol::FactsJson
  Hand hand{};               // what held the tool, of the header; not told until it is opened
};

// When a second person signs an attempt at the chair. Stable names: "start", "end".
enum class SignedAt : uint8_t { kStart = 1, kEnd = 2 };
const char* SignedAtName(SignedAt at);
std::optional<SignedAt> SignedAtFromName(std::string_view name);

// A signature at the station that recorded the attempt.
struct SignOffRow {
  SignedAt at = SignedAt::kStart;
  Uuid signer;
  std::string signer_name;  // joined; empty: erased
  UnixMs signed_ms = 0;
};

// A chunk that contradicts the one of its number that is committed.
struct ContradictionRow {
  uint32_t seq = 0;
  Sha256 hash;
  UnixMs received_ms = 0;
};

// One scoring run. The newest is the attempt's score.
struct ResultRow {
  int32_t run = 1;
  UnixMs scored_ms = 0;
  std::string cause;  // "seal", "reference", "rescore", "appeal", "rubric", "restore"
  double score = 0;
  bool critical_fail = false;
  Sha256 score_json;
  std::optional<Uuid> reference;      // the attempt it was compared with
  double replay_realtime_factor = 0;  // recorded time / replay time; 0: not known
  std::vector<uint8_t> document;      // signed (schemas/result.md); empty: not signed
  bool is_whole = false;  // all that it left is kept, and not the score and its reasons only
};

struct AnnotationRow {
  Uuid id;
  Uuid attempt;
  Uuid author;
  std::string author_name;  // joined; empty: erased
  uint64_t tick = 0;
  std::optional<std::array<int32_t, 3>> point_um;  // scene frame
  std::string text;
  bool to_chair = false;   // said at the chair, while the attempt was made
  uint64_t remark_id = 0;  // of one to the chair: ChairRemark::id; 0: not known
  UnixMs created_ms = 0;
  UnixMs edited_ms = 0;  // 0: never
  int32_t revision = 1;
};

// What somebody says again and again in remarks.
struct SavedText {
  Uuid id;
  Uuid owner;
  std::string owner_name;  // joined
  std::string text;
  bool shared = false;  // others who teach may use it
  UnixMs saved_ms = 0;
  int32_t revision = 1;
};

// How far a remark to the chair has come.
enum class RemarkState { kWaiting, kSent, kShown };

// A remark to the chair of an attempt in progress; an annotation keeps it.
struct ChairRemark {
  Uuid attempt;
  uint64_t id = 0;   // what its station knows it by: grows with each of the attempt's
  std::string text;  // protocol::CheckedRemark
  std::string from;  // the author's name
  uint64_t tick = 0;
  UnixMs sent_ms = 0;
  RemarkState state = RemarkState::kWaiting;
  UnixMs shown_ms = 0;  // when the station said so; 0: it has not
};

// A station that is connected to a server.
struct StationLink {
  Uuid station;
  bool shows_remarks = false;  // its newest connection has somebody to show them to
  bool operator==(const StationLink&) const = default;
};

struct AppealRow {
  Uuid attempt;
  UnixMs filed_ms = 0;
  std::string text;
  std::string state = "open";  // "open", "regraded", "rejected"
  std::string answer;
  Uuid answered_by;
  UnixMs answered_ms = 0;
};

struct ReferenceRow {
  Uuid id;
  Uuid exercise;
  Uuid attempt;
  std::string dentist;
  int32_t version = 1;
  UnixMs created_ms = 0;
  bool consent = true;      // the name may be shown to students
  UnixMs withdrawn_ms = 0;  // 0: counts
};

// A correction of a published exercise's rubric (schemas/rubric.schema.json).
struct RubricRow {
  Uuid exercise;        // this version of it
  int32_t version = 0;  // of the document, as scores name it; above that of what it corrects
  Sha256 content;
  std::string reason;
  UnixMs published_ms = 0;
};

}  // namespace enamel::server
