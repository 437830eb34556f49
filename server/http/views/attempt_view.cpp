#include "server/http/views/attempt_view.h"

#include <boost/json.hpp>

#include "common/base/utf8.h"
#include "common/scene/json/json.h"
#include "common/scoring/movement/motion.h"
#include "common/scoring/score.h"
#include "common/trace/trace.h"
#include "server/http/caller.h"
#include "server/http/error_response.h"
#include "server/http/etag.h"
#include "server/training/access.h"
#include "server/training/revision.h"

namespace enamel::server::http {
namespace json = boost::json;
namespace {

// An exam's attempt is compared with at most so many: each is a blob to read, from S3 a request.
constexpr uint32_t kMaxCompared = 100;
constexpr UnixMs kSignInBeforeMs = 15 * 60 * 1000;
constexpr uint32_t kMaxSignIns = 20;

Result<std::string> BlobText(StoredBlobs& blobs, const Sha256& hash) {
  ENAMEL_ASSIGN_OR_RETURN(Bytes bytes, blobs.GetBlob(hash));
  return std::string(AsText(bytes));
}

json::object PersonJson(const AttemptRow& row) {
  return {{"id", row.person.Text()}, {"display_name", row.person_name}};
}

}  // namespace

json::object HandJson(const Hand& hand) {
  return {{"kind", HandKindName(hand.kind)},
          {"device", AsUtf8(hand.device)},
          {"driver", AsUtf8(hand.driver)},
          {"unit", AsUtf8(hand.unit)}};
}

const ReferenceRow* AttemptView::Exercise::ReferenceCut(const std::string& attempt) const {
  const auto found = std::ranges::find_if(
      references, [&](const ReferenceRow& row) { return row.attempt.Text() == attempt; });
  return found == references.end() ? nullptr : &*found;
}

Result<const AttemptView::Exercise*> AttemptView::ExerciseOf(const AttemptRow& row) {
  // A list of 200 attempts is of a few exercises, stations and profiles: each is read once per
  // answer.
  if (auto found = exercises_.find(row.exercise); found != exercises_.end()) return &found->second;
  Exercise exercise;
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow stored, store_.exercises.ExerciseById(row.exercise));
  exercise.graded = stored.graded;
  ENAMEL_ASSIGN_OR_RETURN(exercise.references, store_.references.Counting(row.exercise));
  ENAMEL_ASSIGN_OR_RETURN(std::string text, BlobText(store_.blobs, row.exercise_content));
  // One that cannot be read any more costs duration and time limit, not the whole list.
  if (Result<scene::Exercise> document = scene::ExerciseFromJson(text); document.ok()) {
    exercise.rate_hz = document->rate_hz;
    exercise.time_limit_s = document->time_limit_s;
  }
  return &exercises_.emplace(row.exercise, std::move(exercise)).first->second;
}

Result<std::string> AttemptView::StationName(const Uuid& id) {
  // All stations at once, with the first attempt that asks: one query, where a list would make as
  // many as it has rows.
  if (!stations_) {
    ENAMEL_ASSIGN_OR_RETURN(std::vector<StationRow> rows, store_.stations.Stations());
    stations_.emplace();
    for (const StationRow& row : rows) stations_->emplace(row.id, row.name);
  }
  auto found = stations_->find(id);
  return found == stations_->end() ? std::string() : found->second;
}

Result<std::pair<std::string, std::string>> AttemptView::ProfileNameAndTitle(
    const Sha256& content) {
  if (auto found = profiles_.find(content); found != profiles_.end()) return found->second;
  ENAMEL_ASSIGN_OR_RETURN(std::string text, BlobText(store_.blobs, content));
  std::pair<std::string, std::string> names;
  if (Result<scene::DeviceProfile> profile = scene::ProfileFromJson(text); profile.ok()) {
    names = {profile->name, profile->title};
  }
  return profiles_.emplace(content, std::move(names)).first->second;
}

void AttemptView::IsTaught(const AttemptRow& row) {
  teaches_.emplace(std::pair(row.person, row.assignment), true);
}

Result<bool> AttemptView::Teaches(const AttemptRow& row) {
  // Nobody else's rights depend on it (server/training/access.h).
  if (viewer_.role != Role::kInstructor) return false;
  const auto key = std::pair(row.person, row.assignment);
  auto known = teaches_.find(key);
  if (known == teaches_.end()) {
    ENAMEL_ASSIGN_OR_RETURN(const bool teaches, store_.attempts.Teaches(viewer_.id, row.id));
    known = teaches_.emplace(key, teaches).first;
  }
  return known->second;
}

Result<bool> AttemptView::ScoreVisible(const AttemptRow& row, bool graded) {
  ENAMEL_ASSIGN_OR_RETURN(bool teaches, Teaches(row));
  if (viewer_.role != Role::kStudent && !hidden_) {
    ENAMEL_ASSIGN_OR_RETURN(hidden_, store_.markings.HiddenFrom(viewer_.id));
  }
  if (hidden_ && hidden_->contains(row.id)) return false;
  return CanSeeScore(viewer_, row, graded, teaches);
}

Result<json::object> AttemptView::Json(const AttemptRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(const Exercise* exercise, ExerciseOf(row));
  ENAMEL_ASSIGN_OR_RETURN(std::string station, StationName(row.station));
  ENAMEL_ASSIGN_OR_RETURN(auto profile, ProfileNameAndTitle(row.profile_content));
  ENAMEL_ASSIGN_OR_RETURN(bool visible, ScoreVisible(row, exercise->graded));

  json::value score, computed, critical_fail, assignment;
  // Left out and not sent as hidden: a browser's developer tools show all that it was sent.
  if (row.score && visible) {
    score = row.overridden ? row.overridden->score : *row.score;
    computed = *row.score;
    critical_fail = row.critical_fail;
  }
  if (row.assignment) assignment = row.assignment->Text();
  ENAMEL_ASSIGN_OR_RETURN(bool teaches, Teaches(row));
  ENAMEL_ASSIGN_OR_RETURN(json::value origin, DeviceOriginJson(row));
  const uint32_t hidden = CanReviewAttempt(viewer_, row, teaches) ? 0 : kReviewFlags;
  json::array flags;
  for (const char* name : AttemptFlagNames(row.flags & ~hidden)) flags.emplace_back(name);
  return json::object{
      {"id", row.id.Text()},
      {"person", PersonJson(row)},
      {"exercise",
       {{"id", row.exercise.Text()}, {"title", row.exercise_title}, {"graded", exercise->graded}}},
      {"station", {{"id", row.station.Text()}, {"name", station}}},
      {"profile", {{"name", profile.first}, {"title", profile.second}}},
      {"state", AttemptStateName(row.state)},
      {"as_reference", row.as_reference},
      {"is_reference", exercise->ReferenceCut(row.id.Text()) != nullptr},
      {"released", row.released},
      {"score", score},
      {"computed_score", computed},
      {"critical_fail", critical_fail},
      {"assignment_id", std::move(assignment)},
      {"exam", row.exam},
      {"due_ms", row.due_ms},
      {"flags", std::move(flags)},
      {"facts", json::parse(row.facts)},
      {"hand", HandJson(row.hand)},
      {"device_origin_um", std::move(origin)},
      {"progress", row.progress},
      {"ticketed_ms", row.ticketed_ms},
      {"sealed_ms", row.sealed_ms},
      {"ticks", row.ticks},
      {"gap_ticks", row.gap_ticks},
      {"chunks", row.chunks},
      {"trace_bytes", row.trace_bytes},
      {"problem", row.problem},
      {"problem_field", row.problem_field},
      {"recording_removed_ms", row.expired_ms},
      {"revision", row.revision}};
}

// Only viewers of what is being made need it.
Result<json::value> AttemptView::DeviceOriginJson(const AttemptRow& row) {
  if (row.state != AttemptState::kRecording) return json::value();
  const Result<Bytes> bytes = store_.recordings.AttemptHeader(row.id);
  if (bytes.status().code() == Code::kNotFound) return json::value();  // erased since
  ENAMEL_RETURN_IF_ERROR(bytes.status());
  const auto header = trace::DecodeHeader(*bytes);
  if (!header.ok()) return json::value();  // a station of another version
  json::array out;
  for (const int64_t nm : header->params.device_origin_nm) out.emplace_back(nm / 1000);
  return json::value(std::move(out));
}

Result<json::value> AttemptView::ComparedWithJson(const AttemptResult& result,
                                                  const Exercise& exercise) {
  ENAMEL_ASSIGN_OR_RETURN(std::string text, BlobText(store_.blobs, result.score_json));
  // From the score document and not from the exercise's present reference: the score refers to the
  // reference it was compared with then.
  Result<scoring::ScoreResult> score = scoring::ScoreFromJson(text);
  if (!score.ok() || score->reference_attempt.empty()) return json::value();
  json::value dentist;
  // Of one that does not count any more the attempt alone is named.
  const ReferenceRow* reference = exercise.ReferenceCut(score->reference_attempt);
  if (reference != nullptr && CanSeeDentist(viewer_, *reference)) dentist = reference->dentist;
  return json::value{{"attempt_id", score->reference_attempt}, {"dentist", std::move(dentist)}};
}

Result<json::value> AttemptView::OverrideJson(const AttemptRow& row, bool visible) {
  if (!row.overridden || !visible) return json::value();
  const ScoreOverride& override = *row.overridden;
  std::string by = "command line";
  if (!override.by.IsZero()) {
    Result<Person> person = store_.people.PersonById(override.by);
    // Not found: erased since. The override stays and names nobody.
    if (!person.ok() && person.status().code() != Code::kNotFound) return person.status();
    by = person.ok() ? person->display_name : "";
  }
  return json::value{{"score", override.score},
                     {"reason", override.reason},
                     {"by", by},
                     {"at_ms", override.at_ms}};
}

Result<json::value> AttemptView::AppealJson(const AttemptRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(std::optional<AppealRow> appeal, store_.appeals.AppealOf(row.id));
  if (!appeal) return json::value();
  return json::value{{"filed_ms", appeal->filed_ms},
                     {"text", appeal->text},
                     {"state", appeal->state},
                     {"answer", appeal->answer},
                     {"answered_ms", appeal->answered_ms}};
}

// The nearest earlier motion, for reviewers. Its owner only for viewers who may review that attempt
// too.
Result<json::value> AttemptView::NearnessJson(const AttemptRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(bool teaches, Teaches(row));
  if (!CanReviewAttempt(viewer_, row, teaches)) return json::value();
  ENAMEL_ASSIGN_OR_RETURN(std::optional<NearAttempt> near, store_.motions.NearestTo(row.id));
  if (!near) return json::value();
  constexpr double kMm = 1e-3;
  json::value attempt, person;
  if (Result<AttemptRow> other = store_.attempts.AttemptById(near->attempt); other.ok()) {
    ENAMEL_ASSIGN_OR_RETURN(bool teaches_other, Teaches(*other));
    if (CanReviewAttempt(viewer_, *other, teaches_other)) {
      attempt = other->id.Text();
      person = PersonJson(*other);
    }
  } else if (other.status().code() != Code::kNotFound) {
    return other.status();
  }
  json::value preset;
  if (near->presets > 0) {
    const auto nearest_um = static_cast<double>(near->preset_um);
    const double limit_um = scoring::kNearOfSize * static_cast<double>(near->size_um);
    preset = json::value{{"others", near->presets},
                         {"nearest_mm", nearest_um * kMm},
                         {"worth_a_look", nearest_um < limit_um}};
  }
  return json::value{{"attempt_id", std::move(attempt)},
                     {"person", std::move(person)},
                     {"others", near->others},
                     {"nearest_mm", static_cast<double>(near->nearest_um) * kMm},
                     {"median_mm", static_cast<double>(near->median_um) * kMm},
                     {"size_mm", static_cast<double>(near->size_um) * kMm},
                     {"worth_a_look", near->worth_a_look},
                     {"preset", std::move(preset)}};
}

// Where the person signed in shortly before and during the attempt. Without the network address,
// which only admins see.
Result<json::array> AttemptView::SignInsJson(const AttemptRow& row) {
  AuditFilter filter;
  filter.action = "session.begin";
  filter.object = row.person.Text();
  filter.from_ms = row.ticketed_ms - kSignInBeforeMs;
  filter.until_ms = row.sealed_ms;
  filter.limit = kMaxSignIns;
  ENAMEL_ASSIGN_OR_RETURN(const auto rows, store_.audit.FindAudit(filter));
  json::array out;
  for (const AuditRow& each : rows)
    out.push_back({{"at_ms", each.at_ms}, {"via", AsUtf8(each.via)}});
  return out;
}

// How the hand moved in an exam, for reviewers, beside the other attempts of the assignment.
Result<json::value> AttemptView::EvidenceJson(const AttemptRow& row) {
  if (!row.exam || !row.assignment || row.sealed_ms == 0) return json::value();
  ENAMEL_ASSIGN_OR_RETURN(const bool teaches, Teaches(row));
  if (!CanReviewAttempt(viewer_, row, teaches)) return json::value();
  ENAMEL_ASSIGN_OR_RETURN(const auto rows,
                          store_.motions.MotionsUnder(*row.assignment, kMaxCompared));
  std::vector<scoring::HandRecord> records;
  std::optional<size_t> own;
  for (const AssignedMotion& each : rows) {
    if (each.attempt == row.id) own = records.size();
    records.push_back(each.record);
  }
  if (!own) return json::value();
  const scoring::HandFigures& hand = records[*own].hand;
  json::value tremor, rank;
  if (hand.tremor_nm != scoring::HandFigures::kNoTremor) tremor = 1e-3 * hand.tremor_nm;
  if (const auto place = scoring::UnusualRank(records, *own)) rank = *place;
  constexpr double kPercent = 1e-4;  // of a millionth
  ENAMEL_ASSIGN_OR_RETURN(json::array sign_ins, SignInsJson(row));
  return json::value{{"tremor_um", std::move(tremor)},
                     {"least_tremor_um", scoring::kMinTremor_um},
                     {"too_calm", scoring::IsTooCalm(hand)},
                     {"still_percent", kPercent * hand.still_ppm},
                     {"late_percent", kPercent * hand.late_ppm},
                     {"gap_percent", kPercent * hand.gap_ppm},
                     {"rank", std::move(rank)},
                     {"of", records.size()},
                     {"sign_ins", std::move(sign_ins)}};
}

// Who signed at the chair, for reviewers; null where nobody had to.
Result<json::value> AttemptView::SignOffJson(const AttemptRow& row) {
  if (!row.sign_off) return json::value();
  ENAMEL_ASSIGN_OR_RETURN(const bool teaches, Teaches(row));
  if (!CanReviewAttempt(viewer_, row, teaches)) return json::value();
  ENAMEL_ASSIGN_OR_RETURN(const auto signatures, store_.sign_offs.SignOffsOf(row.id));
  json::object out{{"start", nullptr}, {"end", nullptr}};
  for (const SignOffRow& each : signatures) {
    out[SignedAtName(each.at)] = {{"by", AsUtf8(each.signer_name)}, {"at_ms", each.signed_ms}};
  }
  return json::value(std::move(out));
}

// Contradicting chunks, for reviewers.
Result<json::array> AttemptView::ContradictionsJson(const AttemptRow& row) {
  json::array out;
  if ((row.flags & kContradicted) == 0) return out;
  ENAMEL_ASSIGN_OR_RETURN(bool teaches, Teaches(row));
  if (!CanReviewAttempt(viewer_, row, teaches)) return out;
  ENAMEL_ASSIGN_OR_RETURN(std::vector<ContradictionRow> rows,
                          store_.recordings.ContradictionsOf(row.id));
  for (const ContradictionRow& chunk : rows) {
    out.push_back(
        {{"seq", chunk.seq}, {"sha256", chunk.hash.Hex()}, {"received_ms", chunk.received_ms}});
  }
  return out;
}

// What the viewer may do with it now, so that a page need not know the rules.
Result<json::array> AttemptView::MayDo(const AttemptRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(bool teaches, Teaches(row));
  ENAMEL_ASSIGN_OR_RETURN(std::optional<AppealRow> appeal, store_.appeals.AppealOf(row.id));
  bool reviews = CanReviewAttempt(viewer_, row, teaches);
  bool scored = row.state == AttemptState::kScored;
  // A recording that is whole and still here, which a new score or a reference needs.
  bool sealed = row.sealed_ms != 0 && row.expired_ms == 0;
  // Unsealed and quarantined: Rescore takes the committed part as the whole attempt.
  bool acceptable = row.state == AttemptState::kQuarantined && row.sealed_ms == 0 && row.chunks > 0;
  const struct {
    const char* name;
    bool may;
  } actions[] = {
      {"release", reviews && scored && !row.released},
      {"unrelease", reviews && row.released},
      {"override", reviews && row.score.has_value()},
      {"annotate", reviews},
      {"rescore", reviews && (sealed || acceptable) && row.state != AttemptState::kScoring},
      {"excuse", reviews && row.assignment && (row.flags & (kExcused | kReturned)) == 0},
      {"unexcuse", reviews && (row.flags & kExcused) != 0},
      {"mark_reference", scored && sealed && CanMarkReference(viewer_, row, teaches)},
      {"appeal", CanAppeal(viewer_, row) && !appeal},
      {"answer_appeal", reviews && appeal && appeal->state == "open"},
  };
  json::array out;
  for (const auto& action : actions) {
    if (action.may) out.emplace_back(action.name);
  }
  return out;
}

json::object ReferenceJson(const Person& viewer, const ReferenceRow& row) {
  json::value dentist;
  if (CanSeeDentist(viewer, row)) dentist = row.dentist;
  return {{"id", row.id.Text()},
          {"exercise_id", row.exercise.Text()},
          {"attempt_id", row.attempt.Text()},
          {"dentist", std::move(dentist)},
          {"consent", row.consent},
          {"version", row.version},
          {"created_ms", row.created_ms},
          {"withdrawn_ms", row.withdrawn_ms}};
}

Result<json::object> AttemptView::DetailJson(const AttemptRow& row) {
  Result<json::object> out = Json(row);
  ENAMEL_RETURN_IF_ERROR(out.status());
  ENAMEL_ASSIGN_OR_RETURN(const Exercise* exercise, ExerciseOf(row));
  ENAMEL_ASSIGN_OR_RETURN(bool visible, ScoreVisible(row, exercise->graded));
  json::value reference, fingerprint;
  if (visible && row.state == AttemptState::kScored) {
    ENAMEL_ASSIGN_OR_RETURN(AttemptResult result, store_.results.ResultOf(row.id));
    ENAMEL_ASSIGN_OR_RETURN(json::value compared, ComparedWithJson(result, *exercise));
    reference = std::move(compared);
    if (!result.document.empty()) fingerprint = HashSha256(result.document).Hex();
  }
  ENAMEL_ASSIGN_OR_RETURN(json::value overridden, OverrideJson(row, visible));
  ENAMEL_ASSIGN_OR_RETURN(json::value appeal, AppealJson(row));
  ENAMEL_ASSIGN_OR_RETURN(json::array contradictions, ContradictionsJson(row));
  ENAMEL_ASSIGN_OR_RETURN(json::value nearness, NearnessJson(row));
  ENAMEL_ASSIGN_OR_RETURN(json::value evidence, EvidenceJson(row));
  ENAMEL_ASSIGN_OR_RETURN(json::value sign_off, SignOffJson(row));
  ENAMEL_ASSIGN_OR_RETURN(json::array may, MayDo(row));
  // Gaps passed at the chair as well.
  double ticks = static_cast<double>(row.ticks + row.gap_ticks);
  double rate_hz = exercise->rate_hz;
  out->emplace("duration_s", rate_hz > 0 ? ticks / rate_hz : 0.0);
  out->emplace("reference", std::move(reference));
  out->emplace("result_fingerprint", std::move(fingerprint));
  out->emplace("time_limit_s", exercise->time_limit_s);
  out->emplace("override", std::move(overridden));
  out->emplace("appeal", std::move(appeal));
  out->emplace("contradictions", std::move(contradictions));
  out->emplace("nearness", std::move(nearness));
  out->emplace("evidence", std::move(evidence));
  out->emplace("sign_off", std::move(sign_off));
  out->emplace("may", std::move(may));
  return out;
}

Result<Response> JudgedMeanwhile(const Call& call, Store& store, const Status& status) {
  if (status.field() != kStale) return status;
  ENAMEL_ASSIGN_OR_RETURN(AttemptRow now, store.attempts.AttemptById(call.id));
  AttemptView view(store, call.caller->person);
  ENAMEL_ASSIGN_OR_RETURN(json::object out, view.DetailJson(now));
  return Stale(status, std::move(out), now.revision);
}

}  // namespace enamel::server::http
