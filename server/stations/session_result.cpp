#include <algorithm>

#include "server/stations/session.h"
#include "server/training/access.h"

// What a person may see of a scored attempt at the chair.
namespace enamel::server::stations {
namespace {

constexpr size_t kMaxScores = 50;
// A reply's frame holds 4 MiB.
constexpr size_t kMaxDeviationBytes = 3 << 20;

}  // namespace

Result<bool> Session::MaySeeScore(const Seen& seen) {
  ENAMEL_ASSIGN_OR_RETURN(const auto exercise,
                          services_.store.exercises.ExerciseById(seen.row.exercise));
  if (!CanSeeScore(seen.person, seen.row, exercise.graded, seen.teaches)) return false;
  if (seen.person.role == Role::kStudent) return true;
  // A blind marker sees no score before every marker is done.
  ENAMEL_ASSIGN_OR_RETURN(const auto hidden, services_.store.markings.HiddenFrom(seen.person.id));
  return !hidden.contains(seen.row.id);
}

// Of nobody else's attempts: a marker must not read there what MaySeeScore hides.
Status Session::AddScores(const Seen& seen, wire::AttemptState& out) {
  if (seen.person.id != seen.row.person) return Status::Ok();
  ENAMEL_ASSIGN_OR_RETURN(const auto exercise,
                          services_.store.exercises.ExerciseById(seen.row.exercise));
  AttemptFilter filter;
  filter.person = seen.row.person;
  filter.exercise = seen.row.exercise;
  filter.state = AttemptState::kScored;
  filter.limit = kMaxScores;
  ENAMEL_ASSIGN_OR_RETURN(auto rows, services_.store.attempts.Attempts(filter));
  std::ranges::reverse(rows);
  for (const AttemptRow& row : rows) {
    const std::optional<double> score =
        row.overridden ? std::optional(row.overridden->score) : row.score;
    if (!score || (row.flags & (kExcused | kReturned)) != 0) continue;
    if (!CanSeeScore(seen.person, row, exercise.graded, seen.teaches)) continue;
    wire::EarlierScore& earlier = *out.add_scores();
    earlier.set_attempt(protocol::ToField(row.id.view()));
    earlier.set_score(*score);
  }
  return Status::Ok();
}

Result<wire::Reply> Session::Do(const wire::AttemptStatus& request) {
  ENAMEL_ASSIGN_OR_RETURN(const auto seen, SeenAttempt(request.session(), request.attempt()));
  const AttemptRow& row = seen.row;
  wire::Reply reply;
  wire::AttemptState& state = *reply.mutable_attempt_state();
  state.set_attempt(request.attempt());
  state.set_state(AttemptStateName(row.state));
  state.set_progress(row.progress);
  state.set_exam(row.exam);
  state.set_released(row.released);
  for (const char* flag : AttemptFlagNames(row.flags & ~kReviewFlags)) state.add_flags(flag);
  if (!row.problem.empty()) {
    *state.mutable_problem() =
        protocol::ToError(Status(Code::kConflict, row.problem, row.problem_field));
  }
  if (row.state != AttemptState::kScored) return reply;
  ENAMEL_ASSIGN_OR_RETURN(const bool shown, MaySeeScore(seen));
  if (!shown) return reply;
  ENAMEL_ASSIGN_OR_RETURN(auto result, services_.store.results.ResultOf(row.id));
  ENAMEL_ASSIGN_OR_RETURN(auto json, services_.store.blobs.GetBlob(result.score_json));
  state.set_result_json(std::string(AsText(json)));
  ENAMEL_RETURN_IF_ERROR(AddScores(seen, state));
  return reply;
}

Result<wire::Reply> Session::Do(const wire::GetDeviation& request) {
  ENAMEL_ASSIGN_OR_RETURN(const auto seen, SeenAttempt(request.session(), request.attempt()));
  if (seen.row.state != AttemptState::kScored) {
    return Status(Code::kConflict, "this attempt is not scored yet", "attempt");
  }
  ENAMEL_ASSIGN_OR_RETURN(const bool shown, MaySeeScore(seen));
  if (!shown) {
    return Status(Code::kForbidden, "the score of this attempt is not released yet", "attempt");
  }
  if (seen.row.expired_ms != 0) {
    return Status(Code::kConflict, "the recording was removed by a retention rule", "attempt");
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto result, services_.store.results.ResultOf(seen.row.id));
  ENAMEL_ASSIGN_OR_RETURN(const auto bytes, services_.store.blobs.GetBlob(result.deviation));
  if (bytes.size() > kMaxDeviationBytes) {
    return Status(Code::kTooLarge, "the deviation has " + std::to_string(bytes.size()) + " bytes");
  }
  wire::Reply reply;
  reply.mutable_attempt_deviation()->set_attempt(request.attempt());
  reply.mutable_attempt_deviation()->set_deviation(protocol::ToField(bytes));
  return reply;
}

}  // namespace enamel::server::stations
