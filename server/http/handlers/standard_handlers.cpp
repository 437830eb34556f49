#include <charconv>

#include "server/agreement/standard.h"
#include "server/http/error_response.h"
#include "server/http/handlers/seen_teaching.h"
#include "server/http/operations.h"
#include "server/jobs/marked_work.h"

// A pass mark from marks that examiners made of an assignment's work.
namespace enamel::server::http {
namespace {

Result<std::optional<double>> CutOf(const Request& request) {
  const auto given = request.query.find("cut");
  if (given == request.query.end()) return std::optional<double>();
  const std::string& text = given->second;
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  if (error == std::errc() && rest == end) return std::optional(value);
  return Status(Code::kInvalidInput, "expected points from 0 to 100", "cut");
}

}  // namespace

Result<Response> FindStandard(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(AssignmentRow row, SeeAssignment(call, store.assignments, store.cohorts));
  const std::string_view type = call.request.Header("content-type");
  if (type.substr(0, type.find(';')) != "text/csv") {
    return ErrorResponse(415, "unsupported_media_type", "expected Content-Type: text/csv",
                         "content-type");
  }
  ENAMEL_ASSIGN_OR_RETURN(std::optional<double> cut, CutOf(call.request));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<Mark> marks, ReadMarks(call.request.body));
  // None scored yet: examiners' totals are the points then.
  if (auto works = ScoredUnder(store, row.id); works.ok()) {
    for (Mark& mark : ComputedMarks(*works)) marks.push_back(std::move(mark));
  } else if (works.status().code() != Code::kNotFound) {
    return works.status();
  }
  ENAMEL_ASSIGN_OR_RETURN(StandardSetting standard, SetStandard(marks, cut));
  Response response;
  response.content_type = "application/json";
  response.body = StandardJson(standard);
  return response;
}

}  // namespace enamel::server::http
