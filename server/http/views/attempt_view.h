#pragma once

#include <boost/json/object.hpp>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "common/base/result.h"
#include "server/http/routes.h"
#include "server/storage/store.h"
#include "server/storage/teaching/exercise_rows.h"

namespace enamel::server::http {

boost::json::object HandJson(const Hand& hand);

// Attempts as one viewer sees them (schemas Attempt and AttemptDetail): joins names, hides a graded
// score that is not released. Keeps what it looked up, so a page of attempts costs a look-up per
// station, profile and exercise. Lives for one request; blocks. Thread safety: none.
class AttemptView {
 public:
  AttemptView(Store& store, const Person& viewer) : store_(store), viewer_(viewer) {}

  // Requires: the viewer may see the attempt (CanSeeAttempt). Errors: the store's.
  Result<boost::json::object> Json(const AttemptRow& row);
  Result<boost::json::object> DetailJson(const AttemptRow& row);
  // The store found it among what the viewer teaches (AttemptFilter::taught_by), and need not be asked again.
  void IsTaught(const AttemptRow& row);

 private:
  struct Exercise {
    bool graded = true;
    int32_t rate_hz = 0;  // 0: the document cannot be read
    int32_t time_limit_s = 0;
    std::vector<ReferenceRow> references;                                // that count
    const ReferenceRow* ReferenceCut(const std::string& attempt) const;  // null: not among them
  };
  Result<const Exercise*> ExerciseOf(const AttemptRow& row);
  Result<std::string> StationName(const Uuid& id);
  Result<std::pair<std::string, std::string>> ProfileNameAndTitle(const Sha256& content);
  Result<bool> Teaches(const AttemptRow& row);
  Result<bool> ScoreVisible(const AttemptRow& row, bool graded);
  Result<boost::json::value> ComparedWithJson(const AttemptResult& result,
                                              const Exercise& exercise);
  Result<boost::json::value> DeviceOriginJson(const AttemptRow& row);
  Result<boost::json::value> OverrideJson(const AttemptRow& row, bool visible);
  Result<boost::json::value> AppealJson(const AttemptRow& row);
  Result<boost::json::value> NearnessJson(const AttemptRow& row);
  Result<boost::json::value> EvidenceJson(const AttemptRow& row);
  Result<boost::json::value> SignOffJson(const AttemptRow& row);
  Result<boost::json::array> SignInsJson(const AttemptRow& row);
  Result<boost::json::array> ContradictionsJson(const AttemptRow& row);
  Result<boost::json::array> MayDo(const AttemptRow& row);

  Store& store_;
  const Person& viewer_;
  std::map<Uuid, Exercise> exercises_;
  // By whose work it is and its assignment, which decide.
  std::map<std::pair<Uuid, std::optional<Uuid>>, bool> teaches_;
  std::optional<std::map<Uuid, std::string>> stations_;
  std::optional<std::map<Uuid, MarkingRows::Hidden>> hidden_;  // what the viewer marks blind
  std::map<Sha256, std::pair<std::string, std::string>> profiles_;
};

// Why a judgement (release, override, excuse) did not happen: when somebody else judged since then,
// 412 with the attempt as it is now.
Result<Response> JudgedMeanwhile(const Call& call, Store& store, const Status& status);

// Schema Reference: without the dentist's name if the viewer may not see it.
boost::json::object ReferenceJson(const Person& viewer, const ReferenceRow& row);

}  // namespace enamel::server::http
