#include <boost/json.hpp>
#include <map>

#include "server/http/caller.h"
#include "server/http/error_response.h"
#include "server/http/etag.h"
#include "server/http/handlers/seen_teaching.h"
#include "server/http/json_body.h"
#include "server/http/operations.h"
#include "server/http/paging.h"
#include "server/http/query.h"
#include "server/http/views/grade_view.h"
#include "server/training/names.h"
#include "server/training/revision.h"

namespace enamel::server::http {
namespace json = boost::json;
namespace {

constexpr size_t kMaxMembersAtOnce = 1000;

json::object SummaryJson(const Cohort& cohort) {
  return {{"id", cohort.id.Text()},
          {"name", cohort.name},
          {"archived_ms", cohort.archived_ms},
          {"revision", cohort.revision}};
}

Result<json::object> CohortJson(CohortRows& cohorts, const Cohort& cohort) {
  ENAMEL_ASSIGN_OR_RETURN(std::vector<Person> people, cohorts.CohortMembers(cohort.id));
  json::array members;
  for (const Person& person : people) {
    members.push_back({{"id", person.id.Text()},
                       {"login", person.login},
                       {"display_name", person.display_name},
                       {"role", RoleName(person.role)}});
  }
  json::object out = SummaryJson(cohort);
  out["members"] = std::move(members);
  return out;
}

Result<Response> CohortResponse(CohortRows& cohorts, const Cohort& cohort, int status = 200) {
  ENAMEL_ASSIGN_OR_RETURN(json::object out, CohortJson(cohorts, cohort));
  return WithETag(JsonResponse(out, status), cohort.revision);
}

Result<CohortEdit> EditOf(const Call& call) {
  CohortEdit edit;
  BodyReader body(call.request);
  // An absent member stays unchanged; `Has` distinguishes it from an empty one.
  if (body.Has("name")) edit.name = body.Text("name", 1, kMaxNameBytes);
  if (body.Has("archived")) edit.archived = body.Flag("archived", false);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  if (!edit.name) return edit;
  ENAMEL_ASSIGN_OR_RETURN(std::string name, CheckedName(*edit.name, "name"));
  edit.name = name;
  return edit;
}

}  // namespace

Result<Response> ListCohorts(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(Page page, PageOf(call.request, kDefaultPage, kMaxPage));
  ENAMEL_ASSIGN_OR_RETURN(std::optional<bool> archived, QueryFlag(call.request, "archived"));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<Cohort> rows, VisibleCohorts(call, store.cohorts));
  std::erase_if(rows, [&](const Cohort& cohort) {
    // Active cohorts, unless the request asks for the archive.
    return (cohort.archived_ms != 0) != archived.value_or(false);
  });
  json::value next = CutPage(rows, page, [](const Cohort& cohort) { return cohort.name; });
  // A school has hundreds of cohorts, of some 30 members each: a list counts the students.
  std::vector<Uuid> ids;
  for (const Cohort& row : rows) ids.push_back(row.id);
  ENAMEL_ASSIGN_OR_RETURN(const auto sizes, store.cohorts.SizesOf(ids));
  json::array cohorts;
  for (size_t i = 0; i < rows.size(); ++i) {
    json::object cohort = SummaryJson(rows[i]);
    cohort["students"] = sizes[i].students;
    cohort["instructors"] = json::value_from(sizes[i].instructors);
    cohorts.push_back(std::move(cohort));
  }
  return JsonResponse({{"cohorts", std::move(cohorts)}, {"next", std::move(next)}});
}

Result<Response> GetCohort(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(Cohort cohort, VisibleCohort(call, store.cohorts));
  return CohortResponse(store.cohorts, cohort);
}

// A row for each student, a grade for each assignment of the cohort and for everybody. Not in
// pages: a cohort is a class, and a result of it is a result of all of it.
Result<Response> GetCohortGrades(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(Cohort cohort, VisibleCohort(call, store.cohorts));
  GradeView view(store, call.caller->person);
  ENAMEL_ASSIGN_OR_RETURN(GradeView::Book book, view.BookOf(call.id));
  json::array assignments, students;
  for (size_t i = 0; i < book.assignments.size(); ++i) {
    const AssignmentRow& row = book.assignments[i];
    assignments.push_back({{"id", row.id.Text()},
                           {"exercise",
                            {{"name", row.exercise},
                             {"title", row.title},
                             {"version", row.version},
                             {"graded", row.graded}}},
                           {"everybody", row.cohort.IsZero()},
                           {"exam", row.exam},
                           {"counting", CountingName(row.counting)},
                           {"summary", GradeView::Json(SummaryOf(book.results[i]))}});
  }
  for (size_t i = 0; i < book.students.size(); ++i) {
    const Person& person = book.students[i];
    json::array grades;
    for (const auto& results : book.results) grades.push_back(GradeView::Json(results[i]));
    students.push_back({{"person",
                         {{"id", person.id.Text()},
                          {"login", person.login},
                          {"display_name", person.display_name}}},
                        {"grades", std::move(grades)}});
  }
  return JsonResponse({{"assignments", std::move(assignments)}, {"students", std::move(students)}});
}

Result<Response> AddCohort(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  BodyReader body(call.request);
  std::string wanted = body.Text("name", 1, kMaxNameBytes);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  ENAMEL_ASSIGN_OR_RETURN(std::string name, CheckedName(wanted, "name"));
  ENAMEL_ASSIGN_OR_RETURN(Uuid id, store.cohorts.CreateCohort(name, ActorOf(call)));
  ENAMEL_ASSIGN_OR_RETURN(Cohort cohort, store.cohorts.CohortById(id));
  return CohortResponse(store.cohorts, cohort, 201);
}

Result<Response> EditCohort(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(CohortEdit edit, EditOf(call));
  ENAMEL_ASSIGN_OR_RETURN(int32_t seen, IfMatch(call.request));
  Result<Cohort> cohort = store.cohorts.EditCohort(call.id, edit, seen, ActorOf(call));
  if (cohort.ok()) return CohortResponse(store.cohorts, *cohort);
  if (cohort.status().field() != kStale) return cohort.status();
  ENAMEL_ASSIGN_OR_RETURN(Cohort current, store.cohorts.CohortById(call.id));
  return Stale(cohort.status(), SummaryJson(current), current.revision);
}

Result<Response> ChangeMembers(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  BodyReader body(call.request);
  std::vector<Uuid> add = body.Ids("add", kMaxMembersAtOnce);
  std::vector<Uuid> remove = body.Ids("remove", kMaxMembersAtOnce);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  // Without If-Match: two people who add students to a cohort at once both mean it, and neither
  // undoes the other.
  ENAMEL_RETURN_IF_ERROR(store.cohorts.ChangeMembers(call.id, add, remove, ActorOf(call)));
  ENAMEL_ASSIGN_OR_RETURN(Cohort cohort, store.cohorts.CohortById(call.id));
  return CohortResponse(store.cohorts, cohort);
}

}  // namespace enamel::server::http
