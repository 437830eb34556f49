#include <boost/json.hpp>

#include "common/base/utf8.h"
#include "common/scoring/trial.h"
#include "server/http/caller.h"
#include "server/http/error_response.h"
#include "server/http/handlers/checked_exercise.h"
#include "server/http/json_body.h"
#include "server/http/operations.h"
#include "server/jobs/exercise_trial.h"

// Trials of drafts: the target cut exactly, and an untouched tooth, judged by the draft's rubric.
namespace enamel::server::http {
namespace json = boost::json;
namespace {

json::object ScoreJson(const scoring::ScoreResult& score) {
  json::array errors, lost;
  for (const scoring::CriticalResult& critical : score.critical)
    errors.push_back(json::value(critical.error));
  for (const scoring::LostItem& each : scoring::LostItems(score)) {
    lost.push_back({{"name", each.name}, {"points", each.points}});
  }
  return {{"score", score.score},
          {"failed", score.critical_fail},
          {"critical", std::move(errors)},
          {"lost", std::move(lost)}};
}

json::object TrialJson(const ExerciseTrials::About& about) {
  json::value problem, exact, untouched;
  if (!about.problem.ok()) {
    problem = {{"code", CodeName(about.problem.code())},
               {"message", AsUtf8(about.problem.message())},
               {"field", about.problem.field()}};
  }
  if (about.trial) {
    exact = ScoreJson(about.trial->exact);
    untouched = ScoreJson(about.trial->untouched);
  }
  return {{"id", about.id.Text()},
          {"state", StateName(about.state)},
          {"ahead", about.ahead},
          {"share", about.share},
          {"took_s", about.took_s},
          {"exact", std::move(exact)},
          {"untouched", std::move(untouched)},
          {"problem", std::move(problem)}};
}

Result<Response> TrialResponse(const Result<ExerciseTrials::About>& about, int status = 200) {
  ENAMEL_RETURN_IF_ERROR(about.status());
  return JsonResponse(TrialJson(*about), status);
}

}  // namespace

Result<Response> BeginExerciseTrial(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(scene::Exercise exercise, CheckedExercise(call, store));
  return TrialResponse(call.trials->Begin(call.caller->person.id, std::move(exercise)), 201);
}

Result<Response> GetExerciseTrial(const Call& call, Store&) {
  return TrialResponse(call.trials->Get(call.caller->person.id, call.id));
}

Result<Response> GiveUpExerciseTrial(const Call& call, Store&) {
  return DoneOr(call.trials->GiveUp(call.caller->person.id, call.id));
}

}  // namespace enamel::server::http
