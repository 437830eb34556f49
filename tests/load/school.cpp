#include "tests/load/school.h"

#include "common/base/hex.h"
#include "common/scene/json/json.h"
#include "common/scene/plan.h"
#include "server/app/data_folder.h"
#include "server/app/publish.h"
#include "server/auth/password.h"
#include "server/auth/token.h"
#include "tests/load/recording_copy.h"

namespace enamel::load {
namespace {

using namespace server;

constexpr char kProfile[] = "phantom_desktop";
constexpr int32_t kBlockVoxel_nm = 150'000;
constexpr auth::PasswordCost kCheapPassword{1, 8192};
// Number of concurrent writers, which share the store's commits.
constexpr size_t kWriters = 32;

Status AddPerson(Store& store, const std::string& login, Role role, const std::string& password,
                 const Uuid& cohort) {
  ENAMEL_ASSIGN_OR_RETURN(auto verifier, auth::HashPassword(password, kCheapPassword));
  Person person;
  person.login = login;
  person.display_name = login;
  person.role = role;
  ENAMEL_ASSIGN_OR_RETURN(auto id, store.people.CreatePerson(person, verifier, {}, kLoadgen));
  return store.cohorts.AddToCohort(cohort, id, kLoadgen);
}

Status Compile(Store& store, School& school) {
  auto text = [&](const Sha256& hash) { return store.blobs.GetBlob(hash); };
  ENAMEL_ASSIGN_OR_RETURN(auto scene_text, text(school.scene));
  ENAMEL_ASSIGN_OR_RETURN(auto exercise_text, text(school.exercise));
  ENAMEL_ASSIGN_OR_RETURN(auto profile_text, text(school.profile));
  auto scene = scene::SceneFromJson(AsText(scene_text));
  auto exercise = scene::ExerciseFromJson(AsText(exercise_text));
  auto profile = scene::ProfileFromJson(AsText(profile_text));
  if (!scene.ok()) return scene.status();
  if (!exercise.ok()) return exercise.status();
  if (!profile.ok()) return profile.status();
  ENAMEL_ASSIGN_OR_RETURN(auto params, scene::CompilePlan(*scene, *exercise, *profile));
  school.params = params;
  return Status::Ok();
}

Status Publish(Store& store, School& school) {
  ENAMEL_RETURN_IF_ERROR(app::PublishProfiles(store));
  ENAMEL_ASSIGN_OR_RETURN(
      auto scene, app::PublishScene(store.blobs, store.scenes, "builtin:block", kBlockVoxel_nm));
  ENAMEL_ASSIGN_OR_RETURN(auto exercise,
                          app::PublishClassOne(store.blobs, store.exercises, scene, Uuid{}));
  ENAMEL_ASSIGN_OR_RETURN(auto profiles, store.profiles.Profiles());
  for (const ProfileRow& row : profiles) {
    if (row.name == kProfile) school.profile = row.content;
  }
  school.exercise = exercise.content;
  school.scene = scene.content;
  school.volume = scene.volume;
  return Compile(store, school);
}

Status AddCodes(Store& store, School& school, size_t count) {
  for (size_t i = 0; i < count; ++i) school.codes.push_back(ToHex(auth::NewToken()));
  return InParallel(count, kWriters, [&](size_t i) {
    return store.stations.AddEnrolCode(HashSha256(AsBytes(school.codes[i])), kFarOff, kLoadgen)
        .status();
  });
}

}  // namespace

Result<School> FoundSchool(const std::filesystem::path& data, size_t stations) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, app::OpenOrMake(data));
  School school;
  std::string tag = ToHex(auth::NewToken()).substr(0, 8);
  school.login = "load-student-" + tag;
  school.instructor_login = "load-instructor-" + tag;
  school.admin_login = "load-admin-" + tag;
  school.password = ToHex(auth::NewToken());
  ENAMEL_ASSIGN_OR_RETURN(auto cohort, store->cohorts.CreateCohort("load " + tag, kLoadgen));
  ENAMEL_RETURN_IF_ERROR(AddPerson(*store, school.login, Role::kStudent, school.password, cohort));
  ENAMEL_RETURN_IF_ERROR(
      AddPerson(*store, school.instructor_login, Role::kInstructor, school.password, cohort));
  ENAMEL_RETURN_IF_ERROR(
      AddPerson(*store, school.admin_login, Role::kAdmin, school.password, cohort));
  ENAMEL_RETURN_IF_ERROR(Publish(*store, school));
  ENAMEL_RETURN_IF_ERROR(AddCodes(*store, school, stations));
  return school;
}

}  // namespace enamel::load
