#include <array>
#include <atomic>
#include <boost/json.hpp>

#include "common/base/unix_time.h"
#include "common/base/utf8.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "server/auth/first_admin.h"
#include "server/http/caller.h"
#include "server/http/error_response.h"
#include "server/http/json_body.h"
#include "server/http/operations.h"
#include "server/http/query.h"
#include "server/http/views/person_view.h"
#include "server/jobs/builtin_content.h"
#include "server/jobs/tooth_import.h"
#include "server/training/access.h"
#include "server/training/names.h"

// The first steps of a new server: its first admin, and teeth to work on.
namespace enamel::server::http {
namespace json = boost::json;
namespace {

constexpr size_t kTokenDigits = 64;
constexpr size_t kMaxPasswordBytes = 1024;
constexpr size_t kMaxToothName = 64;
constexpr size_t kMaxFileName = 255;
// As enamel-server admin publish-exercise.
constexpr int32_t kVoxelNm = 50'000;

struct Newcomer {
  std::string token, password;
  Person person;
};

Result<Newcomer> NewcomerOf(const Call& call) {
  BodyReader body(call.request);
  Newcomer out;
  out.token = body.Text("token", 1, kTokenDigits);
  const std::string login = body.Text("login", 1, kMaxLoginBytes);
  const std::string name = body.Text("display_name", 1, kMaxNameBytes);
  out.password = body.Text("password", 1, kMaxPasswordBytes);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  ENAMEL_ASSIGN_OR_RETURN(out.person.login, CheckedLogin(login));
  ENAMEL_ASSIGN_OR_RETURN(out.person.display_name, CheckedPersonName(name, "display_name"));
  out.person.role = Role::kAdmin;
  return out;
}

Result<Person> MakeAdmin(const Call& call, PeopleRows& people, const Newcomer& newcomer) {
  PeopleFilter admins;
  admins.role = Role::kAdmin;
  admins.limit = 1;
  ENAMEL_ASSIGN_OR_RETURN(const auto there, people.FindPeople(admins));
  if (!there.empty()) {
    return Status(Code::kConflict,
                  "this server has an admin already; ask that person for an account");
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto verifier,
                          call.authenticator.NewVerifier(newcomer.password, newcomer.person.login,
                                                         newcomer.person.display_name));
  ENAMEL_ASSIGN_OR_RETURN(const auto id, people.CreatePerson(newcomer.person, verifier, {},
                                                             Actor{{}, "first admin's link"}));
  return people.PersonById(id);
}

// Building one takes seconds of a thread and hundreds of megabytes: one at a time.
std::atomic_flag building;

class Building {
 public:
  Building() : first_(!building.test_and_set()) {}
  ~Building() {
    if (first_) building.clear();
  }
  Building(const Building&) = delete;
  Building& operator=(const Building&) = delete;
  bool first() const { return first_; }

 private:
  const bool first_;
};

json::object ToothJson(const SceneRow& row, const std::vector<ExerciseRow>& published) {
  json::array exercises;
  for (const ExerciseRow& exercise : published) {
    exercises.push_back({{"id", exercise.id.Text()},
                         {"name", exercise.name},
                         {"title", exercise.title},
                         {"version", exercise.version}});
  }
  return {{"name", row.name}, {"title", row.title}, {"exercises", std::move(exercises)}};
}

Result<json::object> PutTooth(const Call& call, Store& parts, const std::string& name) {
  Store& store = parts;
  const Actor by = ActorOf(call);
  const Building mine;
  if (!mine.first()) {
    return Status(Code::kUnavailable, "another tooth is being made; try again in a moment");
  }
  ENAMEL_RETURN_IF_ERROR(PutFirstProfiles(parts));
  ENAMEL_ASSIGN_OR_RETURN(const auto row,
                          StoreBuiltinScene(store.blobs, store.scenes, name, kVoxelNm, by));
  ENAMEL_ASSIGN_OR_RETURN(const auto text, store.blobs.GetBlob(row.content));
  ENAMEL_ASSIGN_OR_RETURN(const auto scene, scene::SceneFromJson(AsText(text)));
  ENAMEL_ASSIGN_OR_RETURN(const auto published,
                          PublishExercisesOf(store.blobs, store.exercises, scene, row.content, by));
  return ToothJson(row, published);
}

// "stl" of "Crown.STL".
std::string KindOf(const std::string& file_name) {
  const size_t dot = file_name.find_last_of('.');
  std::string kind = dot == std::string::npos ? "" : file_name.substr(dot + 1);
  for (char& c : kind) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return kind;
}

json::array Triple(const dvec3& v) { return {v.x, v.y, v.z}; }

json::value StanceJson(const ToothImport::About& about) {
  if (!about.placement) return nullptr;
  constexpr std::array kUpIs = {"given", "found", "guess"};
  const import::Placement& placement = *about.placement;
  json::array by;
  for (import::Witness witness : placement.by) by.push_back(json::value(WitnessName(witness)));
  return {{"up", Triple(placement.up)},
          {"buccal", Triple(placement.buccal)},
          {"up_is", kUpIs[static_cast<size_t>(placement.up_is)]},
          {"by", std::move(by)},
          {"buccal_given", placement.buccal_given},
          {"size_mm", Triple(about.size_mm)}};
}

json::object ImportJson(const ToothImport::About& about) {
  json::value problem, tooth;
  if (!about.problem.ok()) {
    problem = {{"code", CodeName(about.problem.code())},
               {"message", AsUtf8(about.problem.message())},
               {"field", about.problem.field()}};
  }
  if (about.scene) tooth = ToothJson(*about.scene, about.exercises);
  json::array findings;
  for (const std::string& line : about.findings) findings.push_back(json::value(AsUtf8(line)));
  return {{"id", about.id.Text()},
          {"state", StateName(about.state)},
          {"received", about.received},
          {"bytes", about.bytes},
          {"phase", about.phase},
          {"share", about.share},
          {"findings", std::move(findings)},
          {"stance", StanceJson(about)},
          {"problem", std::move(problem)},
          {"tooth", std::move(tooth)}};
}

// Who may import at all, and, with an id, whether it is the caller's own. Another's import does not exist for an
// instructor.
Status MayImport(const Call& call) {
  const Person& caller = call.caller->person;
  if (!CanImportTeeth(caller)) {
    return Status(Code::kForbidden,
                  "expected an admin, or an instructor whom an admin has allowed to import teeth");
  }
  if (call.id.IsZero() || caller.role == Role::kAdmin) return Status::Ok();
  return call.teeth->MustBeOf(call.id, caller.id);
}

Result<Response> PictureResponse(const Call& call, ToothImport::Picture picture) {
  ENAMEL_RETURN_IF_ERROR(MayImport(call));
  ENAMEL_ASSIGN_OR_RETURN(const auto bytes, call.teeth->PictureOf(call.id, picture));
  Response response;
  response.content_type = "application/octet-stream";
  response.body = AsText(*bytes);
  return response;
}

Result<Response> ImportResponse(const Result<ToothImport::About>& about, int status = 200) {
  ENAMEL_RETURN_IF_ERROR(about.status());
  return JsonResponse(ImportJson(*about), status);
}

}  // namespace

Result<Response> MakeFirstAdmin(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(Newcomer newcomer, NewcomerOf(call));
  if (call.first_admin == nullptr) {
    return Status(Code::kForbidden, "this server has an admin already, or gives no link", "token");
  }
  // Before the password is hashed, which costs memory and time: a stranger gets none of either.
  ENAMEL_RETURN_IF_ERROR(call.first_admin->Take(newcomer.token, enamel::UnixMs()));
  Result<Person> made = MakeAdmin(call, store.people, newcomer);
  if (made.ok()) return JsonResponse(PersonJson(*made), 201);
  call.first_admin->GiveBack();
  return made.status();
}

Result<Response> ListBuiltinTeeth(const Call&, Store&) {
  json::array teeth;
  for (const scene::BuiltinScene& tooth : scene::BuiltinScenes()) {
    teeth.push_back({{"name", tooth.name}, {"summary", tooth.summary}});
  }
  return JsonResponse({{"teeth", std::move(teeth)}});
}

Result<Response> PutBuiltinTooth(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  BodyReader body(call.request);
  const std::string name = body.Text("name", 1, kMaxToothName);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  Result<json::object> put = PutTooth(call, store, name);
  if (put.ok()) return JsonResponse(*put, 201);
  // An unknown name is a mistake in the body and no missing page.
  const Status& why = put.status();
  if (why.code() != Code::kNotFound) return why;
  return Status(Code::kInvalidInput, why.message(), "name");
}

Result<Response> BeginToothImport(const Call& call, Store& store) {
  ENAMEL_RETURN_IF_ERROR(MayImport(call));
  if (!IsJson(call.request)) return NotJson();
  BodyReader body(call.request);
  ToothImport::Wanted wanted;
  wanted.kind = KindOf(body.Text("file_name", 1, kMaxFileName));
  wanted.bytes = static_cast<uint64_t>(body.Integer("bytes", 0, int64_t{1} << 40));
  wanted.unit = body.Text("unit", 1, kMaxToothName);
  wanted.title = body.Text("title", 1, kMaxNameBytes);
  wanted.prepared_of = body.MaybeId("prepared_of");
  if (body.Has("jaw")) wanted.jaw = body.Flag("jaw");
  if (body.Has("tooth") || (!wanted.prepared_of && !wanted.jaw))
    wanted.tooth = static_cast<int>(body.Integer("tooth", 11, 85));
  if (body.Has("placed")) wanted.placed = body.Flag("placed");
  if (body.Has("scale")) wanted.scale = body.Number("scale", 1e-6, 1e6);
  if (body.Has("longest_mm")) {
    wanted.longest_mm = body.Number("longest_mm", mesh::kTooth.min_mm, mesh::kScan.max_mm);
  }
  if (body.Has("up")) wanted.up = body.Text("up", 2, kMaxToothName);
  if (body.Has("buccal")) wanted.buccal = body.Text("buccal", 2, kMaxToothName);
  if (body.Has("publish")) wanted.publish = body.Flag("publish");
  if (body.Has("practice")) wanted.practice = body.Flag("practice");
  wanted.mesh_of = body.MaybeId("mesh_of");
  for (const auto& curve : body.Curves("around", import::kMaxGumCurves)) {
    auto& points = wanted.around.emplace_back();
    for (const auto& [x, y, z] : curve) points.emplace_back(x, y, z);
  }
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  if (wanted.prepared_of) {
    const auto exercise = store.exercises.ExerciseById(*wanted.prepared_of);
    if (!exercise.ok() || !CanUseExercise(call.caller->person, *exercise))
      return Status(Code::kInvalidInput, "there is no such exercise", "prepared_of");
  }
  return ImportResponse(call.teeth->Begin(wanted, ActorOf(call), enamel::UnixMs()), 201);
}

Result<Response> AddToothBytes(const Call& call, Store&) {
  ENAMEL_RETURN_IF_ERROR(MayImport(call));
  const std::string_view type = call.request.Header("content-type");
  if (type.substr(0, type.find(';')) != "application/octet-stream") {
    return ErrorResponse(415, "unsupported_media_type",
                         "expected Content-Type: application/octet-stream", "content-type");
  }
  ENAMEL_ASSIGN_OR_RETURN(uint64_t offset, QueryOffset(call.request, "offset"));
  return ImportResponse(
      call.teeth->Append(call.id, offset, AsBytes(call.request.body), enamel::UnixMs()));
}

Result<Response> GetToothImport(const Call& call, Store&) {
  ENAMEL_RETURN_IF_ERROR(MayImport(call));
  return ImportResponse(call.teeth->Get(call.id));
}

Result<Response> GetToothImportSurface(const Call& call, Store&) {
  return PictureResponse(call, ToothImport::Picture::kSurface);
}

Result<Response> GetToothImportInside(const Call& call, Store&) {
  return PictureResponse(call, ToothImport::Picture::kStartTooth);
}

Result<Response> GiveUpToothImport(const Call& call, Store&) {
  ENAMEL_RETURN_IF_ERROR(MayImport(call));
  return DoneOr(call.teeth->GiveUp(call.id));
}

}  // namespace enamel::server::http
