#include <gtest/gtest.h>

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/json.hpp>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

#include "common/base/hex.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/timeline/timeline.h"
#include "server/http/api.h"
#include "server/http/etag.h"
#include "server/http/routes.h"
#include "server/storage/open_store.h"
#include "server/storage/store_engine.h"
#include "tests/server/http/school.h"

// The access rights of every route, in one table. A route without a line here fails the test, and
// so does a line without a route.
namespace enamel::server::http {
namespace {

namespace fs = std::filesystem;

// The columns:
//   nobody   no session
//   sam      student of cohort A; what the lines are about is sam's
//   sue      another student of cohort A
//   tom      student of cohort B
//   ada      instructor of cohort A
//   ben      instructor of cohort B
//   root     admin, password given just now
//   late     the same admin, ten minutes after giving the password
//   off      was signed in, is disabled since
//   fresh    student of cohort A with a password for one use
constexpr const char* kColumns[] = {"nobody", "sam",  "sue",  "tom", "ada",
                                    "ben",    "root", "late", "off", "fresh"};

struct Line {
  const char* route;  // as in the route table
  const char* what;   // which {id} or {name} stands in the path: a name in Things
  const char* body;  // "" none; "csv …" text/csv; "bytes …"; else JSON, with NAMES in it filled in
  const char* expected;  // statuses in the order of the columns
};

// clang-format off
const Line kLines[] = {
//   route                                      about             body                                   nobody sam sue tom ada ben root late off fresh
    {"GET /healthz",                            "",               "",                                    "200 200 200 200 200 200 200 200 200 200"},
    {"GET /livez",                              "",               "",                                    "200 200 200 200 200 200 200 200 200 200"},
    {"GET /readyz",                             "",               "",                                    "200 200 200 200 200 200 200 200 200 200"},
    {"GET /metrics",                            "",               "",                                    "404 404 404 404 404 404 404 404 404 404"},
    // The first steps of a new server; this one gave no link.
    {"POST /api/v1/first-admin",                "",               R"({"token":"x","login":"new","display_name":"New","password":"quite a long phrase"})",
                                                                                                         "403 403 403 403 403 403 403 403 403 403"},
    {"GET /api/v1/builtin-teeth",               "",               "",                                    "401 403 403 403 403 403 200 200 401 403"},
    {"POST /api/v1/builtin-teeth",              "",               R"({"name":"no such tooth"})",         "401 403 403 403 403 403 400 400 401 403"},
    {"POST /api/v1/tooth-imports",              "",               R"({"file_name":"a.stl","bytes":9,"unit":"mm","title":"t","tooth":46})",
                                                                                                         "401 403 403 403 403 403 201 201 401 403"},
    {"GET /api/v1/tooth-imports/{id}",          "attempt",        "",                                    "401 403 403 403 403 403 404 404 401 403"},
    {"PUT /api/v1/tooth-imports/{id}/bytes",    "attempt",        "bytes x",                             "401 403 403 403 403 403 404 404 401 403"},
    {"GET /api/v1/tooth-imports/{id}/surface",  "attempt",        "",                                    "401 403 403 403 403 403 404 404 401 403"},
    {"GET /api/v1/tooth-imports/{id}/start-tooth", "attempt",     "",                                    "401 403 403 403 403 403 404 404 401 403"},
    {"DELETE /api/v1/tooth-imports/{id}",       "attempt",        "",                                    "401 403 403 403 403 403 404 404 401 403"},
    // One's own session.
    {"POST /api/v1/session",                    "",               R"({"login":"x","password":"y"})",     "401 401 401 401 401 401 401 401 401 401"},
    {"GET /api/v1/session",                     "",               "",                                    "401 200 200 200 200 200 200 200 401 200"},
    {"DELETE /api/v1/session",                  "",               "",                                    "401 204 204 204 204 204 204 204 401 204"},
    {"POST /api/v1/session/confirm",            "",               R"({"password":"PASSWORD"})",          "401 204 204 204 204 204 204 204 401 204"},
    {"POST /api/v1/session/password",           "",               R"({"old_password":"PASSWORD","new_password":"quite another one"})",
                                                                                                         "401 200 200 200 200 200 200 200 401 200"},
    {"PUT /api/v1/session/pin",                 "",               R"({"pin":"804217"})",                 "401 403 403 403 204 204 204 403 401 403"},
    {"PUT /api/v1/session/language",            "",               R"({"language":"de"})",                "401 200 200 200 200 200 200 200 401 200"},
    {"GET /api/v1/sessions",                    "",               "",                                    "401 200 200 200 200 200 200 200 401 403"},
    {"DELETE /api/v1/sessions/{id}",            "sams session",   "",                                    "401 204 404 404 404 404 204 204 401 403"},
    // People.
    {"GET /api/v1/people",                      "",               "",                                    "401 403 403 403 403 403 200 200 401 403"},
    {"POST /api/v1/people",                     "",               R"({"login":"new","role":"student"})", "401 403 403 403 403 403 201 403 401 403"},
    {"GET /api/v1/people/{id}",                 "sam",            "",                                    "401 403 403 403 403 403 200 200 401 403"},
    {"PATCH /api/v1/people/{id}",               "sam",            R"({"display_name":"Samuel"})",        "401 403 403 403 403 403 200 200 401 403"},
    {"PATCH /api/v1/people/{id}",               "sam",            R"({"role":"instructor"})",            "401 403 403 403 403 403 200 403 401 403"},
    {"POST /api/v1/people/{id}/password",       "sam",            "",                                    "401 403 403 403 403 403 200 403 401 403"},
    {"POST /api/v1/people/{id}/erase",          "sam",            R"({"login":"sam"})",                  "401 403 403 403 403 403 409 403 401 403"},
    {"POST /api/v1/people/{id}/erase",          "tom",            R"({"login":"tom"})",                  "401 403 403 403 403 403 200 403 401 403"},
    {"GET /api/v1/people/{id}/sessions",        "sam",            "",                                    "401 403 403 403 403 403 200 200 401 403"},
    {"DELETE /api/v1/people/{id}/sessions",     "sam",            "",                                    "401 403 403 403 403 403 200 200 401 403"},
    {"POST /api/v1/roster",                     "",               "csv login\nnew\n",                    "401 403 403 403 403 403 200 403 401 403"},
    // Cohorts.
    {"GET /api/v1/cohorts",                     "",               "",                                    "401 403 403 403 200 200 200 200 401 403"},
    {"POST /api/v1/cohorts",                    "",               R"({"name":"New"})",                   "401 403 403 403 403 403 201 201 401 403"},
    {"GET /api/v1/cohorts/{id}",                "cohort A",       "",                                    "401 403 403 403 200 404 200 200 401 403"},
    {"GET /api/v1/cohorts/{id}/grades",         "cohort A",       "",                                    "401 403 403 403 200 404 200 200 401 403"},
    {"GET /api/v1/cohorts/{id}/grades.csv",     "cohort A",       "",                                    "401 403 403 403 200 404 200 200 401 403"},
    {"GET /api/v1/cohorts/{id}/attempts.csv",   "cohort A",       "",                                    "401 403 403 403 200 404 200 200 401 403"},
    {"GET /api/v1/cohorts/{id}/grading",        "cohort A",       "",                                    "401 403 403 403 200 404 200 200 401 403"},
    {"PATCH /api/v1/cohorts/{id}",              "cohort A",       R"({"archived":true})",                "401 403 403 403 403 403 200 200 401 403"},
    {"POST /api/v1/cohorts/{id}/members",       "cohort B",       R"({"add":["SAM"]})",                  "401 403 403 403 403 403 200 200 401 403"},
    // 409: may, and has nothing that could be scored again: the one scored attempt has a run
    // waiting.
    {"POST /api/v1/cohorts/{id}/rescore",       "cohort A",       R"({})",                               "401 403 403 403 409 404 409 409 401 403"},
    {"GET /api/v1/batches",                     "",               "",                                    "401 403 403 403 200 200 200 200 401 403"},
    {"GET /api/v1/batches/{id}",                "batch",          "",                                    "401 403 403 403 200 404 200 200 401 403"},
    {"POST /api/v1/batches/{id}/cancel",        "batch",          "",                                    "401 403 403 403 200 404 200 200 401 403"},
    // Stations.
    {"GET /api/v1/stations",                    "",               "",                                    "401 403 403 403 200 200 200 200 401 403"},
    {"GET /api/v1/stations/{id}",               "station",        "",                                    "401 403 403 403 200 200 200 200 401 403"},
    {"PATCH /api/v1/stations/{id}",             "station",        R"({"name":"Bench 7"})",               "401 403 403 403 403 403 200 200 401 403"},
    {"GET /api/v1/listed-devices",              "",               "",                                    "401 403 403 403 200 200 200 200 401 403"},
    {"POST /api/v1/listed-devices",             "",               R"({"name":"hid:1","title":"chair 3"})", "401 403 403 403 403 403 200 200 401 403"},
    {"POST /api/v1/listed-devices/remove",      "",               R"({"name":"hid:1"})",                 "401 403 403 403 403 403 404 404 401 403"},
    {"GET /api/v1/station-settings",            "",               "",                                    "401 403 403 403 403 403 200 200 401 403"},
    {"POST /api/v1/station-settings",           "",               R"({"name":"language","value":"de"})", "401 403 403 403 403 403 200 200 401 403"},
    {"POST /api/v1/station-settings/remove",    "",               R"({"name":"quality"})",               "401 403 403 403 403 403 404 404 401 403"},
    {"POST /api/v1/stations/{id}/revoke",       "station",        "",                                    "401 403 403 403 403 403 200 403 401 403"},
    {"GET /api/v1/enrolment-codes",             "",               "",                                    "401 403 403 403 403 403 200 200 401 403"},
    {"POST /api/v1/enrolment-codes",            "",               R"({"minutes":5})",                    "401 403 403 403 403 403 201 403 401 403"},
    {"DELETE /api/v1/enrolment-codes/{id}",     "code",           "",                                    "401 403 403 403 403 403 204 204 401 403"},
    // Device profiles.
    {"GET /api/v1/profiles",                    "",               "",                                    "401 200 200 200 200 200 200 200 401 403"},
    {"POST /api/v1/profiles",                   "",               "PROFILE",                             "401 403 403 403 403 403 201 201 401 403"},
    {"GET /api/v1/profiles/{name}",             "profile",        "",                                    "401 200 200 200 200 200 200 200 401 403"},
    {"GET /api/v1/profiles/{name}/versions",    "profile",        "",                                    "401 403 403 403 200 200 200 200 401 403"},
    {"GET /api/v1/profiles/{name}/reports",     "profile",        "",                                    "401 403 403 403 200 200 200 200 401 403"},
    {"POST /api/v1/profiles/{name}/reports",    "profile",        "{}",                                  "401 403 403 403 403 403 201 201 401 403"},
    {"GET /api/v1/profile-reports/{id}",        "report",         "",                                    "401 403 403 403 200 200 200 200 401 403"},
    {"GET /api/v1/profiles/{name}/calibrations", "profile",       "",                                    "401 403 403 403 200 200 200 200 401 403"},
    {"POST /api/v1/profiles/{name}/calibrations", "profile",      "CALIBRATION",                         "401 403 403 403 403 403 201 201 401 403"},
    // Exercises: the school's, shared with instructors, and seen by whoever has an attempt of it
    // (tom has). 400: may, and sends nothing useful; 409: may, and it is no draft.
    {"GET /api/v1/exercises",                      "",               "",                                    "401 200 200 200 200 200 200 200 401 403"},
    {"POST /api/v1/exercises",                     "",               R"({})",                               "401 403 403 403 400 400 400 400 401 403"},
    {"POST /api/v1/exercise-trials",               "",               R"({})",                               "401 403 403 403 400 400 400 400 401 403"},
    {"GET /api/v1/exercise-trials/{id}",           "exercise",       "",                                    "401 403 403 403 404 404 404 404 401 403"},
    {"DELETE /api/v1/exercise-trials/{id}",        "exercise",       "",                                    "401 403 403 403 404 404 404 404 401 403"},
    {"GET /api/v1/exercises/{id}",                 "exercise",       "",                                    "401 200 200 200 200 200 200 200 401 403"},
    {"PUT /api/v1/exercises/{id}",                 "exercise",       R"({})",                               "401 403 403 403 403 403 400 400 401 403"},
    {"DELETE /api/v1/exercises/{id}",              "exercise",       "",                                    "401 403 403 403 403 403 409 409 401 403"},
    {"GET /api/v1/exercises/{id}/document",        "exercise",       "",                                    "401 200 200 200 200 200 200 200 401 403"},
    {"GET /api/v1/exercises/{id}/initial-surface", "exercise",       "",                                    "401 200 200 200 200 200 200 200 401 403"},
    {"GET /api/v1/exercises/{id}/versions",        "exercise",       "",                                    "401 200 200 200 200 200 200 200 401 403"},
    {"GET /api/v1/exercises/{id}/references",      "exercise",       "",                                    "401 200 200 200 200 200 200 200 401 403"},
    {"POST /api/v1/exercises/{id}/publish",        "exercise",       "",                                    "401 403 403 403 403 403 409 409 401 403"},
    {"POST /api/v1/exercises/{id}/retire",         "exercise",       R"({"reason":"a test"})",              "401 403 403 403 403 403 204 204 401 403"},
    {"POST /api/v1/exercises/{id}/offer",          "exercise",       "",                                    "401 403 403 403 403 403 409 409 401 403"},
    {"PUT /api/v1/exercises/{id}/sharing",         "exercise",       R"({"shared":false})",                 "401 403 403 403 403 403 200 200 401 403"},
    {"GET /api/v1/exercises/{id}/rubrics",         "exercise",       "",                                    "401 403 403 403 200 200 200 200 401 403"},
    {"POST /api/v1/exercises/{id}/rubrics",        "exercise",       R"({})",                               "401 403 403 403 403 403 400 400 401 403"},
    {"POST /api/v1/exercises/{id}/rubrics/preview", "exercise",      R"({})",                               "401 403 403 403 400 400 400 400 401 403"},
    {"GET /api/v1/scoring-metrics",                "",               "",                                    "401 403 403 403 200 200 200 200 401 403"},
    {"POST /api/v1/references/{id}/withdraw",      "reference",      "",                                    "401 403 403 403 204 403 204 204 401 403"},
    // Ada's own, private, assigned to nobody: invisible to others.
    {"GET /api/v1/exercises/{id}",                 "adas",           "",                                    "401 404 404 404 200 404 200 200 401 403"},
    {"PUT /api/v1/exercises/{id}",                 "adas",           R"({})",                               "401 403 403 403 400 404 400 400 401 403"},
    {"DELETE /api/v1/exercises/{id}",              "adas",           "",                                    "401 403 403 403 409 404 409 409 401 403"},
    {"GET /api/v1/exercises/{id}/document",        "adas",           "",                                    "401 404 404 404 200 404 200 200 401 403"},
    {"GET /api/v1/exercises/{id}/initial-surface", "adas",           "",                                    "401 404 404 404 200 404 200 200 401 403"},
    {"GET /api/v1/exercises/{id}/versions",        "adas",           "",                                    "401 404 404 404 200 404 200 200 401 403"},
    {"GET /api/v1/exercises/{id}/references",      "adas",           "",                                    "401 404 404 404 200 404 200 200 401 403"},
    {"POST /api/v1/exercises/{id}/publish",        "adas",           "",                                    "401 403 403 403 409 404 409 409 401 403"},
    {"POST /api/v1/exercises/{id}/retire",         "adas",           "",                                    "401 403 403 403 204 404 204 204 401 403"},
    {"POST /api/v1/exercises/{id}/offer",          "adas",           "",                                    "401 403 403 403 409 404 409 409 401 403"},
    {"PUT /api/v1/exercises/{id}/sharing",         "adas",           R"({"shared":true})",                  "401 403 403 403 200 404 200 200 401 403"},
    {"GET /api/v1/exercises/{id}/rubrics",         "adas",           "",                                    "401 403 403 403 200 404 200 200 401 403"},
    {"POST /api/v1/exercises/{id}/rubrics",        "adas",           R"({})",                               "401 403 403 403 400 404 400 400 401 403"},
    {"POST /api/v1/exercises/{id}/rubrics/preview", "adas",          R"({})",                               "401 403 403 403 400 404 400 400 401 403"},
    // Ben's own draft, shared: other instructors read it, and change nothing of it.
    {"GET /api/v1/exercises/{id}",                 "bens draft",     "",                                    "401 404 404 404 200 200 200 200 401 403"},
    {"PUT /api/v1/exercises/{id}",                 "bens draft",     R"({})",                               "401 403 403 403 403 400 400 400 401 403"},
    {"DELETE /api/v1/exercises/{id}",              "bens draft",     "",                                    "401 403 403 403 403 204 204 204 401 403"},
    {"POST /api/v1/exercises/{id}/publish",        "bens draft",     "",                                    "401 403 403 403 403 200 200 200 401 403"},
    {"PUT /api/v1/exercises/{id}/sharing",         "bens draft",     R"({"owner_id":null})",                "401 403 403 403 403 200 200 200 401 403"},
    // Assignments to cohort A.
    {"GET /api/v1/assignments",                    "",               "",                                    "401 200 200 200 200 200 200 200 401 403"},
    {"POST /api/v1/assignments",                   "",               R"({"exercise":"class-1-occlusal","cohort_id":"COHORT"})", "401 403 403 403 201 403 201 201 401 403"},
    {"GET /api/v1/assignments/{id}",               "assignment",     "",                                    "401 200 200 404 200 404 200 200 401 403"},
    {"PUT /api/v1/assignments/{id}",               "assignment",     R"({"exercise":"class-1-occlusal","cohort_id":"COHORT"})", "401 403 403 403 200 404 200 200 401 403"},
    {"DELETE /api/v1/assignments/{id}",            "assignment",     "",                                    "401 403 403 403 204 404 204 204 401 403"},
    {"POST /api/v1/assignments/{id}/move",         "assignment",     R"({"exercise_id":"EXERCISE"})",       "401 403 403 403 200 404 200 200 401 403"},
    {"POST /api/v1/assignments/{id}/release",      "assignment",     "",                                    "401 403 403 403 200 404 200 200 401 403"},
    {"GET /api/v1/assignments/{id}/markings", "assignment", "", "401 403 403 403 200 404 200 200 401 403"},
    {"POST /api/v1/assignments/{id}/markings", "assignment", R"({"marker_ids":["SAM"]})", "401 403 403 403 400 404 400 400 401 403"},
    {"GET /api/v1/markings/{id}", "marking", "", "401 403 403 403 200 404 200 200 401 403"},
    {"PUT /api/v1/markings/{id}/markers", "marking", R"({"marker_ids":["SAM"]})", "401 403 403 403 400 404 400 400 401 403"},
    {"DELETE /api/v1/markings/{id}", "marking", "", "401 403 403 403 204 404 204 204 401 403"},
    {"POST /api/v1/marking-works/{id}/marks", "marking work", R"({"rating":3,"criteria":{"outline":{"points":5},"internal_form":{"points":5}}})", "401 403 403 403 204 404 204 204 401 403"},
    {"GET /api/v1/marking-works/{id}/timeline", "marking work", "", "401 403 403 403 503 404 503 503 401 403"},
    {"POST /api/v1/assignments/{id}/standard",     "assignment",     "csv work,criterion,marker,mark\na,rating,A,2\n", "401 403 403 403 200 404 200 200 401 403"},
    {"GET /api/v1/assignments/{id}/grading",       "assignment",     "",                                    "401 403 403 403 200 404 200 200 401 403"},
    {"GET /api/v1/assignments/{id}/insight",       "assignment",     "",                                    "401 403 403 403 200 404 200 200 401 403"},
    // Attempts: sam's, graded, scored, not released.
    {"GET /api/v1/attempts",                    "",               "",                                    "401 200 200 200 200 200 200 200 401 403"},
    {"GET /api/v1/attempts/{id}",               "attempt",        "",                                    "401 200 404 404 200 404 200 200 401 403"},
    {"GET /api/v1/attempts/{id}/score",         "attempt",        "",                                    "401 403 404 404 200 404 200 200 401 403"},
    {"GET /api/v1/attempts/{id}/signed-result", "attempt",        "",                                    "401 403 404 404 409 404 409 409 401 403"},
    {"GET /api/v1/attempts/{id}/surface",       "attempt",        "",                                    "401 403 404 404 200 404 200 200 401 403"},
    {"GET /api/v1/attempts/{id}/deviation",     "attempt",        "",                                    "401 403 404 404 200 404 200 200 401 403"},
    {"GET /api/v1/attempts/{id}/timeline",      "attempt",        "",                                    "401 403 404 404 200 404 200 200 401 403"},
    {"GET /api/v1/start-teeth/{name}",          "start tooth",    "",                                    "401 200 200 200 200 200 200 200 401 403"},
    {"GET /api/v1/attempts/{id}/series",        "attempt",        "",                                    "401 403 404 404 200 404 200 200 401 403"},
    {"GET /api/v1/attempts/{id}/ticks",         "attempt",        "",                                    "401 403 404 404 200 404 200 200 401 403"},
    {"GET /api/v1/attempts/{id}/live",          "recording",      "",                                    "401 403 403 403 200 404 200 200 401 403"},
    {"GET /api/v1/attempts/{id}/live-cut",      "recording",      "",                                    "401 403 403 403 200 404 200 200 401 403"},
    {"GET /api/v1/live/{id}/remarks",           "recording",      "",                                    "401 403 403 403 200 404 200 200 401 403"},
    {"POST /api/v1/live/{id}/remarks",          "recording",      R"({"text":"t"})",                     "401 403 403 403 201 404 201 201 401 403"},
    {"POST /api/v1/attempts/{id}/release",      "attempt",        "",                                    "401 403 403 403 204 404 204 204 401 403"},
    {"POST /api/v1/attempts/{id}/reference",    "attempt",        R"({"dentist":"Dr. Vega","consent":true,"anyway":"a test"})", "401 403 403 403 201 404 201 201 401 403"},
    {"DELETE /api/v1/attempts/{id}/release",       "appealed",       "",                                    "401 403 403 403 204 404 204 204 401 403"},
    {"PUT /api/v1/attempts/{id}/override",         "attempt",        R"({"score":50,"reason":"r"})",        "401 403 403 403 200 404 200 200 401 403"},
    {"DELETE /api/v1/attempts/{id}/override",      "attempt",        "",                                    "401 403 403 403 200 404 200 200 401 403"},
    {"POST /api/v1/attempts/{id}/rescore",         "attempt",        "",                                    "401 403 403 403 409 404 409 409 401 403"},
    {"POST /api/v1/attempts/{id}/excuse",          "attempt",        R"({"reason":"r"})",                   "401 403 403 403 200 404 200 200 401 403"},
    {"DELETE /api/v1/attempts/{id}/excuse",        "attempt",        "",                                    "401 403 403 403 200 404 200 200 401 403"},
    {"POST /api/v1/attempts/{id}/restore-result",  "attempt",        R"({"run":1})",                        "401 403 403 403 200 404 200 200 401 403"},
    {"GET /api/v1/attempts/{id}/results",          "attempt",        "",                                    "401 403 404 404 200 404 200 200 401 403"},
    {"GET /api/v1/attempts/{id}/annotations",      "attempt",        "",                                    "401 403 404 404 200 404 200 200 401 403"},
    {"POST /api/v1/attempts/{id}/annotations",     "attempt",        R"({"tick":1,"text":"t"})",            "401 403 403 403 201 404 201 201 401 403"},
    {"PUT /api/v1/annotations/{id}",               "annotation",     R"({"tick":1,"text":"u"})",            "401 403 403 403 200 404 403 403 401 403"},
    {"DELETE /api/v1/annotations/{id}",            "annotation",     "",                                    "401 403 403 403 204 404 403 403 401 403"},
    {"GET /api/v1/saved-texts",                    "",               "",                                    "401 403 403 403 200 200 200 200 401 403"},
    {"POST /api/v1/saved-texts",                   "",               R"({"text":"t"})",                     "401 403 403 403 201 201 201 201 401 403"},
    {"PUT /api/v1/saved-texts/{id}",               "saved text",     R"({"text":"u"})",                     "401 403 403 403 200 404 200 200 401 403"},
    {"PUT /api/v1/saved-texts/{id}",               "shared text",    R"({"text":"u"})",                     "401 403 403 403 200 403 200 200 401 403"},
    {"DELETE /api/v1/saved-texts/{id}",            "shared text",    "",                                    "401 403 403 403 204 403 204 204 401 403"},
    {"POST /api/v1/attempts/{id}/appeal",          "attempt",        R"({"text":"t"})",                     "401 409 404 404 403 404 403 403 401 403"},
    {"POST /api/v1/attempts/{id}/appeal/answer",   "appealed",       R"({"outcome":"reject","answer":"a"})", "401 403 403 403 200 404 200 200 401 403"},
    // Running it.
    {"GET /api/v1/audit",                       "",               "",                                    "401 403 403 403 403 403 200 200 401 403"},
    {"POST /api/v1/jobs/{id}/cancel",              "job",            "",                                    "401 403 403 403 403 403 204 204 401 403"},
    {"GET /api/v1/health",                      "",               "",                                    "401 403 403 403 403 403 200 200 401 403"},
    // No folder is set here.
    {"POST /api/v1/backups",                    "",               "",                                    "401 403 403 403 403 403 409 409 401 403"},
    {"GET /api/v1/jobs",                        "",               "",                                    "401 403 403 403 403 403 200 200 401 403"},
};
// clang-format on

std::vector<int> Statuses(const char* text) {
  std::istringstream in(text);
  std::vector<int> out;
  for (int status; in >> status;) out.push_back(status);
  return out;
}

// The routes of the whole table that a session with a one-time password reaches.
TEST(OneTimePasswordTest, ReachesItsOwnSessionAndNothingElse) {
  std::set<std::string> reached;
  for (const Line& line : kLines) {
    if (Statuses(line.expected).back() != 403) reached.insert(line.route);
  }
  EXPECT_EQ(reached,
            (std::set<std::string>{
                "GET /healthz", "GET /livez", "GET /metrics", "GET /readyz", "POST /api/v1/session",
                "GET /api/v1/session", "DELETE /api/v1/session", "POST /api/v1/session/confirm",
                "POST /api/v1/session/password", "PUT /api/v1/session/language"}));
}

// Cookie and csrf of somebody signed in.
struct Pass {
  std::string cookie, csrf;
};

// A school on disk with everybody signed in; each case starts from a copy.
class Template {
 public:
  Template() {
    std::string verifier = *school.authenticator->NewVerifier(kPassword, "nobody");
    Uuid off = Add("off", verifier), fresh = Add("fresh", verifier);
    EXPECT_TRUE(school.store->cohorts.AddToCohort(school.cohort_a, fresh, kBy).ok());
    EXPECT_TRUE(school.store->people.SetPassword(fresh, verifier, true, kBy).ok());
    // Signs in ten minutes before the others.
    school.now_ms -= 10 * 60'000;
    SignIn("late", "root");
    school.now_ms += 10 * 60'000;
    for (const char* login : {"sam", "sue", "tom", "ada", "ben", "root", "off", "fresh"}) {
      SignIn(login, login);
    }
    // What signing out of a disabled account leaves in a browser.
    EXPECT_TRUE(school.store->people.SetDisabled(off, true, kBy).ok());
    AddThings();
  }

  School school;
  std::map<std::string, Pass> passes;
  std::map<std::string, std::string> things;  // by the name in a Line
  std::map<std::string, std::string> bodies;  // NAMES in bodies
  LiveBoard live;
  StationBoard stations;
  std::unique_ptr<StationBoard::Connection> chair;  // shows remarks

 private:
  inline static const Actor kBy{{}, "test"};

  Uuid Add(const std::string& login, const std::string& verifier) {
    Person person;
    person.login = login;
    person.display_name = "Person " + login;
    return *school.store->people.CreatePerson(person, verifier, {}, kBy);
  }
  void SignIn(const std::string& column, const std::string& login) {
    auto signed_in = school.authenticator->SignInHere({login, kPassword, "203.0.113.7", "page"});
    ASSERT_TRUE(signed_in.ok()) << signed_in.status().message();
    passes[column] = {"enamel_session=" + ToHex(signed_in->token), signed_in->identity.csrf};
  }
  void AddThings() {
    Store& store = *school.store;
    things["sam"] = school.sam.Text();
    things["tom"] = school.tom.Text();
    things["sams session"] = store.sessions.SessionsOf(school.sam)->front().id.Text();
    things["cohort A"] = school.cohort_a.Text();
    things["cohort B"] = school.cohort_b.Text();
    things["station"] = school.station.Text();
    things["code"] =
        store.stations.AddEnrolCode(HashSha256(AsBytes("c")), UnixMs{1} << 60, kBy)->Text();
    things["profile"] = "phantom_desktop";
    ProfileReportRow report{
        {}, "phantom_desktop", 1, "text/html", *store.blobs.PutBlob(AsBytes("<p>")), 3};
    things["report"] = store.profiles.AddProfileReport(report, kBy)->id.Text();
    things["exercise"] = school.exercise.Text();
    things["attempt"] = school.sams_scored.Text();
    timeline::Head head;
    head.spec.bricks = ivec3(1);
    head.spec.voxel_nm = 100'000;
    head.rate_hz = head.frame_ticks = head.segment_frames = 1;
    const Sha256 tooth = *store.blobs.PutBlob(AsBytes("ENTS"));
    EXPECT_TRUE(store.timelines.PutStartTooth(*store.blobs.PutBlob(AsBytes("volume")), tooth).ok());
    things["start tooth"] = tooth.Hex();
    const Sha256 timeline =
        *store.blobs.PutAttemptBlob(school.sams_scored, timeline::EncodeHead(head));
    EXPECT_TRUE(store.timelines.PutTimeline(school.sams_scored, timeline).ok());
    things["recording"] = school.sams_recording.Text();
    chair = stations.Enter(school.station, true);
    bodies["PASSWORD"] = kPassword;
    bodies["SAM"] = school.sam.Text();
    bodies["PROFILE"] = scene::ToJson(scene::BuiltinProfiles().front());
    bodies["CALIBRATION"] =
        R"({"enamel_calibration":1,"device":"d","profile":"phantom_desktop","station":"","software":"s",)"
        R"("measured_ms":1,"rate_hz":1000,"method":"m",)"
        R"("measured":{"noise_nm":{"value":1,"uncertainty":1,"samples":1}}})";
    AddTeaching();
  }
  void AddTeaching() {
    Store& store = *school.store;
    Actor ada{school.ada, "page"}, sam{school.sam, "page"};
    bodies["EXERCISE"] = school.exercise.Text();
    bodies["COHORT"] = school.cohort_a.Text();
    things["assignment"] = store.assignments.Assignments({school.cohort_a, {}})->front().id.Text();
    EXPECT_TRUE(store.scenes
                    .PutSceneSurface(*store.blobs.PutBlob(AsBytes("volume")),
                                     *store.blobs.PutBlob(AsBytes("ENTM")))
                    .ok());
    AnnotationRow remark;
    remark.attempt = school.sams_scored;
    remark.author = school.ada;
    remark.text = "here";
    things["annotation"] = store.remarks.AddAnnotation(remark, ada)->id.Text();
    SavedText saved;
    saved.text = "too deep";
    things["saved text"] = store.saved_texts.AddSavedText(saved, ada)->id.Text();
    saved.text = "the wall leans";
    saved.shared = true;
    things["shared text"] = store.saved_texts.AddSavedText(saved, ada)->id.Text();
    // Another attempt of sam's: released, appealed against, and the exercise's reference.
    Uuid appealed = school.ScoredAttempt(school.sam);
    EXPECT_TRUE(store.judging.ReleaseAttempt(appealed, ada).ok());
    EXPECT_TRUE(store.appeals.FileAppeal(appealed, "please look again", sam).ok());
    things["appealed"] = appealed.Text();
    things["reference"] = store.references.AddReference(appealed, "Dr. Vega", true, ada)->id.Text();
    // Blind: ada and root mark an attempt of another student.
    const auto marking = store.markings.BeginMarking(
        store.assignments.Assignments({school.cohort_a, {}})->front().id,
        {school.ScoredAttempt(school.sue)}, {school.ada, school.root}, ada);
    things["marking"] = marking->id.Text();
    things["marking work"] = store.markings.WorksOf(marking->id)->front().id.Text();
    things["job"] = store.jobs.Jobs("queued")->front().id.Text();
    things["adas"] = school.OwnExercise(ada, "adas", true).id.Text();
    const ExerciseRow draft = school.OwnExercise(Actor{school.ben, "page"}, "bens", false);
    EXPECT_TRUE(store.exercises.ShareExercise(draft.id, {true, {}}, kBy).ok());
    things["bens draft"] = draft.id.Text();
    // Sue's is scored and waits for nothing, until a request includes it with others of cohort A.
    const Uuid again = school.ScoredAttempt(school.sue);
    JobFilter newest;
    newest.limit = 1;
    EXPECT_TRUE(store.jobs.CancelJob(store.jobs.FindJobs(newest)->front().id, ada).ok());
    BatchRow batch;
    batch.title = "cohort A";
    batch.cause = "rubric";
    batch.cohort = school.cohort_a;
    uint32_t left_out = 0;
    things["batch"] = store.batches.RescoreTogether(batch, {again}, left_out, ada)->id.Text();
  }
};

class AuthorisationTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { made_ = std::make_unique<Template>(); }
  static void TearDownTestSuite() { made_.reset(); }
  static std::unique_ptr<Template> made_;
};
std::unique_ptr<Template> AuthorisationTest::made_;

// The API on a store of its own, which starts as the template is.
class Case {
 public:
  Case(Template& from, bool own_copy) : from_(from), store_(from.school.store.get()) {
    if (own_copy) {
      fs::copy(from.school.folder.path() / "data", folder_.path() / "data",
               fs::copy_options::recursive);
      copy_ = std::move(OpenSqliteStore({folder_.path() / "data", false, 2, {}})).value();
      store_ = copy_.get();
    }
    auth::AuthOptions options;
    options.cost = {1, 8192};
    options.clock = [this] { return from_.school.now_ms; };
    authenticator_ = std::make_unique<auth::Authenticator>(*store_, options);
    api_ = std::make_shared<Api>(*store_, *authenticator_, Monitoring{}, 1, 4);
    api_->Show(from.live);
    api_->Show(from.stations);
    api_->Enrol("fingerprint");
  }

  Response Handle(const Request& request) {
    boost::asio::io_context io;
    Response out;
    boost::asio::co_spawn(
        io, [&]() -> boost::asio::awaitable<void> { out = co_await api_->Handle(request); },
        [](const std::exception_ptr& failed) { EXPECT_FALSE(failed); });
    io.run();
    return out;
  }
  Store& store() { return *store_; }

 private:
  Template& from_;
  test::TempFolder folder_;
  std::unique_ptr<Store> copy_;
  Store* store_;
  std::unique_ptr<auth::Authenticator> authenticator_;
  std::shared_ptr<Api> api_;
};

std::string Filled(std::string text, const std::map<std::string, std::string>& names) {
  for (const auto& [name, value] : names) {
    for (size_t at; (at = text.find(name)) != std::string::npos;) {
      text.replace(at, name.size(), value);
    }
  }
  return text;
}

Request RequestOf(const Template& made, const Line& line) {
  std::string route = line.route;
  Request request;
  request.peer = "203.0.113.7";
  for (Method method :
       {Method::kGet, Method::kPost, Method::kPut, Method::kPatch, Method::kDelete}) {
    if (route.starts_with(std::string(MethodName(method)) + " ")) request.method = method;
  }
  request.path = route.substr(route.find(' ') + 1);
  if (size_t place = request.path.find('{'); place != std::string::npos) {
    auto thing = made.things.find(line.what);
    EXPECT_NE(thing, made.things.end()) << route << " about " << line.what;
    if (thing != made.things.end()) {
      request.path.replace(place, request.path.find('}') - place + 1, thing->second);
    }
  }
  std::string body = line.body;
  bool csv = body.starts_with("csv ");
  if (csv) body = body.substr(4);
  const bool bytes = body.starts_with("bytes ");
  if (bytes) body = body.substr(6);
  request.body = Filled(body, made.bodies);
  request.headers["host"] = "localhost";
  request.headers["content-type"] = csv     ? "text/csv"
                                    : bytes ? "application/octet-stream"
                                            : "application/json";
  bool judged = line.what == std::string("attempt") || line.what == std::string("appealed");
  int32_t revision =
      judged ? made.school.store->attempts.AttemptById(*Uuid::Parse(made.things.at(line.what)))
                   ->revision
             : 1;
  request.headers["if-match"] = ETagOf(revision);
  return request;
}

void GiveOf(Request& request, const Pass& pass) {
  request.headers["cookie"] = pass.cookie;
  request.headers["x-enamel-csrf"] = pass.csrf;
}

bool IsUnsafe(const Request& request) { return request.method != Method::kGet; }

TEST_F(AuthorisationTest, EveryRouteStandsInTheTableAndNothingElse) {
  std::set<std::string> table, routes;
  for (const Line& line : kLines) table.insert(line.route);
  for (const Route& route : Routes()) {
    routes.insert(std::string(MethodName(route.method)) + " " + std::string(route.pattern));
  }
  for (const std::string& route : routes) {
    EXPECT_TRUE(table.contains(route)) << route << " has no line: say who may do it";
  }
  for (const std::string& line : table)
    EXPECT_TRUE(routes.contains(line)) << line << " is no route";
}

TEST_F(AuthorisationTest, EverybodyGetsWhatTheTableSays) {
  Case shared(*made_, false);
  for (const Line& line : kLines) {
    std::vector<int> expected = Statuses(line.expected);
    ASSERT_EQ(expected.size(), std::size(kColumns)) << line.route;
    for (size_t i = 0; i < expected.size(); ++i) {
      Request request = RequestOf(*made_, line);
      if (auto pass = made_->passes.find(kColumns[i]); pass != made_->passes.end()) {
        GiveOf(request, pass->second);
      }
      // Refused requests share a school, since they must change nothing. A refused sign-in does: it
      // counts against the next.
      const bool changes = IsUnsafe(request) && (expected[i] < 400 || expected[i] == 401);
      Response response = changes ? Case(*made_, true).Handle(request) : shared.Handle(request);
      EXPECT_EQ(response.status, expected[i])
          << line.route << " about " << line.what << " by " << kColumns[i] << ": "
          << response.body.substr(0, 300);
    }
  }
}

// With everything else right, by whoever may do most.
TEST_F(AuthorisationTest, NoChangeIsMadeForAnotherSitesPageOrWithoutTheCsrfValue) {
  const std::map<std::string, std::pair<std::string, std::string>> attacks = {
      {"no csrf value", {"x-enamel-csrf", ""}},
      {"another's csrf value", {"x-enamel-csrf", made_->passes.at("ada").csrf}},
      {"another origin", {"origin", "http://evil.example"}},
      {"an opaque origin", {"origin", "null"}},
      {"another site", {"sec-fetch-site", "cross-site"}},
      {"a sibling", {"sec-fetch-site", "same-site"}},
  };
  Case shared(*made_, false);
  auto done = [&] {  // rows of anything but refusals
    const auto rows = shared.store().audit.Audit(1000);
    return std::ranges::count_if(
        *rows, [](const AuditRow& row) { return row.action != "request.refused"; });
  };
  const auto before = done();
  for (const Line& line : kLines) {
    Request request = RequestOf(*made_, line);
    if (!IsUnsafe(request)) continue;
    GiveOf(request, made_->passes.at("root"));
    for (const auto& [what, header] : attacks) {
      bool signs_in = std::string(line.route) == "POST /api/v1/session";
      if (signs_in && header.first == "x-enamel-csrf") continue;  // there is none yet
      Request attack = request;
      attack.headers[header.first] = header.second;
      Response response = shared.Handle(attack);
      EXPECT_EQ(response.status, 403) << line.route << ", " << what;
    }
  }
  EXPECT_EQ(done(), before) << "nothing was done";
}

// Two schools of one installation: the same table, with requests at one about the other's things.
TEST_F(AuthorisationTest, OfAnotherSchoolNothingIsThere) {
  Template other;
  Case shared(other, false);
  size_t cells = 0, in_bodies = 0;
  for (const Line& line : kLines) {
    const std::vector<int> expected = Statuses(line.expected);
    const bool about = std::string_view(line.route).find("{id}") != std::string_view::npos;
    for (size_t i = 0; i < expected.size(); ++i) {
      const auto pass = other.passes.find(kColumns[i]);
      if (about) {
        // This school's path, the other's people.
        Request request = RequestOf(*made_, line);
        if (pass != other.passes.end()) GiveOf(request, pass->second);
        const int status = shared.Handle(request).status;
        // Whoever may not do it here either hears that first, and so does who sends nothing useful.
        const bool refused = expected[i] == 401 || expected[i] == 403 || expected[i] == 400;
        EXPECT_TRUE(status == 404 || (refused && status == expected[i]))
            << line.route << " about " << line.what << " by " << kColumns[i] << ": " << status;
        ++cells;
      }
      // The other school's path, this school's ids in the body. Fails before any change.
      if (Filled(line.body, made_->bodies) != Filled(line.body, other.bodies) &&
          expected[i] / 100 == 2) {
        Request request = RequestOf(other, line);
        request.body = Filled(line.body, made_->bodies);
        if (pass != other.passes.end()) GiveOf(request, pass->second);
        const Response response = Case(other, true).Handle(request);
        EXPECT_EQ(response.status / 100, 4)
            << line.route << " by " << kColumns[i] << ": " << response.body;
        ++in_bodies;
      }
      // This school's sessions are nobody's there.
      const auto mine = made_->passes.find(kColumns[i]);
      const bool signs_in = std::string_view(line.route) == "POST /api/v1/session";
      if (mine == made_->passes.end() || signs_in) continue;
      Request request = RequestOf(other, line);
      GiveOf(request, mine->second);
      EXPECT_EQ(shared.Handle(request).status, expected[0])
          << line.route << " with the session of another school's " << kColumns[i];
      ++cells;
    }
  }
  EXPECT_GT(cells, 1000u);
  EXPECT_GT(in_bodies, 2u);
}

// Cohort A's students are in ben's cohort too, which gives ben nothing of what was assigned to cohort A.
class SecondCohortTest : public AuthorisationTest {
 protected:
  SecondCohortTest() {
    for (const Uuid& id : {school_.sam, school_.sue}) {
      EXPECT_TRUE(store_.cohorts.AddToCohort(school_.cohort_b, id, {}).ok());
    }
  }
  void MakeAllUnder(const std::optional<Uuid>& assignment) {
    const Status made = store_.engine->rows.Write([&](sql::Db& db) {
      return Query(db, "UPDATE attempts SET assignment = ?2 WHERE tenant = ?1 AND person <> ?3")
          .Bind(assignment)
          .Bind(school_.tom)
          .Run();
    });
    EXPECT_TRUE(made.ok()) << made.message();
  }
  Uuid AssignedTo(const Uuid& cohort) {
    AssignmentRow row;
    row.exercise = "class-1-occlusal";
    row.cohort = cohort;
    return store_.assignments.AddAssignment(row, {})->id;
  }
  Response By(const char* who, Method method, const std::string& path,
              const std::string& query = {}, const std::string& body = {}) {
    Request request;
    request.method = method;
    request.path = path;
    request.body = body;
    request.headers = {{"host", "localhost"}, {"content-type", "application/json"}};
    if (!query.empty()) request.query["limit"] = query;
    GiveOf(request, made_->passes.at(who));
    return case_.Handle(request);
  }
  // The list of `who` holds exactly the attempts that open for `who`.
  void ExpectListsAgree(const char* who) {
    const std::string list = By(who, Method::kGet, "/api/v1/attempts", "200").body;
    const auto rows = store_.attempts.Attempts({.limit = 200});
    for (const AttemptRow& row : *rows) {
      const int status = By(who, Method::kGet, "/api/v1/attempts/" + row.id.Text()).status;
      EXPECT_EQ(list.find("{\"id\":\"" + row.id.Text()) != std::string::npos, status == 200) << who;
    }
  }
  // Lines that say something of one of these attempts.
  static bool IsAboutWork(const Line& line) {
    const std::set<std::string> work{"attempt", "appealed", "recording", "annotation", "reference"};
    return work.contains(line.what) &&
           std::string_view(line.route).find("tooth-imports") == std::string_view::npos;
  }

  School& school_ = made_->school;
  Case case_{*made_, true};
  Store& store_ = case_.store();
};

TEST_F(SecondCohortTest, WorkAssignedToAnotherCohortIsNotTheirs) {
  MakeAllUnder(AssignedTo(school_.cohort_a));
  size_t routes = 0;
  for (const Line& line : kLines) {
    if (!IsAboutWork(line)) continue;
    Request request = RequestOf(*made_, line);
    GiveOf(request, made_->passes.at("ben"));
    const Response response = case_.Handle(request);
    EXPECT_EQ(response.status, Statuses(line.expected)[5]) << line.route << ": " << response.body;
    ++routes;
  }
  EXPECT_GT(routes, 25u);
  for (const char* who : {"ada", "ben", "root"}) ExpectListsAgree(who);
  const std::string cohort = "/api/v1/cohorts/" + school_.cohort_b.Text();
  for (const char* list : {"/attempts.csv", "/grading"}) {
    const std::string body = By("ben", Method::kGet, cohort + list).body;
    EXPECT_NE(body.find(school_.toms_scored.Text()), std::string::npos) << body;
    EXPECT_EQ(body.find(school_.sams_scored.Text()), std::string::npos) << body;
  }
  // 409: each attempt that ben may score again has a run waiting.
  EXPECT_EQ(By("ben", Method::kPost, cohort + "/rescore", {}, "{}").status, 409);
}

TEST_F(SecondCohortTest, PracticeAndWorkForEverybodyIsAnyCohortsOfTheStudent) {
  for (const std::optional<Uuid>& assignment :
       {std::optional<Uuid>(), std::optional(AssignedTo({}))}) {
    MakeAllUnder(assignment);
    for (const Line& line : kLines) {
      if (!IsAboutWork(line) || !std::string_view(line.route).starts_with("GET ")) continue;
      Request request = RequestOf(*made_, line);
      GiveOf(request, made_->passes.at("ben"));
      EXPECT_EQ(case_.Handle(request).status, Statuses(line.expected)[4]) << line.route;
    }
    for (const char* who : {"ada", "ben", "root"}) ExpectListsAgree(who);
  }
}

TEST_F(AuthorisationTest, WhatMayNotBeSeenLooksLikeWhatIsNotThere) {
  Case shared(*made_, false);
  for (const Line& line : kLines) {
    std::vector<int> expected = Statuses(line.expected);
    Request there = RequestOf(*made_, line);
    if (IsUnsafe(there) || there.path.find(made_->school.sams_scored.Text()) == std::string::npos) {
      continue;
    }
    for (size_t i = 0; i < expected.size(); ++i) {
      if (expected[i] != 404) continue;
      GiveOf(there, made_->passes.at(kColumns[i]));
      Request missing = there;
      missing.path = Filled(missing.path, {{made_->school.sams_scored.Text(), Uuid::New().Text()}});
      EXPECT_EQ(shared.Handle(there).body, shared.Handle(missing).body)
          << line.route << " by " << kColumns[i];
    }
  }
}

}  // namespace
}  // namespace enamel::server::http
