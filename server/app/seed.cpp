#include "server/app/seed.h"

#include <algorithm>
#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <iostream>

#include "common/base/file.h"
#include "server/app/data_folder.h"
#include "server/app/publish.h"
#include "server/auth/password.h"

namespace enamel::server::app {
namespace {

namespace json = boost::json;

struct DemoPerson {
  const char* login;
  const char* display_name;
  Role role;
  bool in_cohort;
};

constexpr DemoPerson kPeople[] = {
    {"admin", "Demo admin", Role::kAdmin, false},
    {"instructor", "Demo instructor", Role::kInstructor, true},
    {"student1", "Demo student 1", Role::kStudent, true},
    {"student2", "Demo student 2", Role::kStudent, true},
};
constexpr char kCohortName[] = "Demo cohort";
constexpr char kMolarName[] = "molar-46";
constexpr char kMolarSource[] = "builtin:molar";

// Public on purpose: documents print them, and `serve` refuses to be reached from elsewhere while
// one is good.
std::string DemoPassword(const char* login) { return std::string("enamel-demo-") + login; }

Result<Uuid> EnsurePerson(PeopleRows& people, const DemoPerson& demo) {
  // Existing people stay unchanged, also with another password or role: a second seeding undoes
  // nothing.
  auto found = people.PersonByLogin(demo.login);
  if (found.ok()) return found->id;
  if (found.status().code() != Code::kNotFound) return found.status();
  ENAMEL_ASSIGN_OR_RETURN(auto verifier, auth::HashPassword(DemoPassword(demo.login)));
  Person person;
  person.login = demo.login;
  person.display_name = demo.display_name;
  person.role = demo.role;
  return people.CreatePerson(person, verifier, {}, kCommandLine);
}

Result<Uuid> EnsureCohort(CohortRows& cohorts_rows) {
  ENAMEL_ASSIGN_OR_RETURN(auto cohorts, cohorts_rows.Cohorts());
  auto found = std::ranges::find(cohorts, kCohortName, &Cohort::name);
  if (found != cohorts.end()) return found->id;
  return cohorts_rows.CreateCohort(kCohortName, kCommandLine);
}

// Building takes seconds, so an existing molar is used unchanged.
Result<SceneRow> EnsureMolar(StoredBlobs& blobs, SceneRows& scenes_rows, int32_t voxel_nm,
                             const std::function<void(const std::string&)>& begin) {
  ENAMEL_ASSIGN_OR_RETURN(auto scenes, scenes_rows.Scenes());
  auto found = std::ranges::find(scenes, kMolarName, &SceneRow::name);
  if (found != scenes.end()) return *found;
  begin("building the molar (once)");
  return PublishScene(blobs, scenes_rows, kMolarSource, voxel_nm);
}

// A demo's class follows its exercise; a real class is moved by its instructors.
Status FollowNewest(AssignmentRows& assignments, const ExerciseRow& exercise, const Uuid& cohort) {
  ENAMEL_ASSIGN_OR_RETURN(const auto rows, assignments.Assignments({.cohort = cohort}));
  for (const AssignmentRow& row : rows) {
    if (row.exercise != exercise.name || row.version_id == exercise.id) continue;
    ENAMEL_RETURN_IF_ERROR(
        assignments.MoveAssignment(row.id, exercise.id, row.revision, false, kCommandLine)
            .status());
  }
  return Status::Ok();
}

json::object Facts(const ExerciseRow& exercise, bool has_reference) {
  json::array people;
  for (const DemoPerson& demo : kPeople) {
    people.push_back(json::object{{"login", demo.login},
                                  {"password", DemoPassword(demo.login)},
                                  {"role", RoleName(demo.role)}});
  }
  return {{"exercise", exercise.name},
          {"exercise_id", exercise.id.Text()},
          {"exercise_version", exercise.version},
          {"has_reference", has_reference},
          {"cohort", kCohortName},
          {"people", std::move(people)}};
}

}  // namespace

Result<std::vector<std::string>> LoginsWithDemoPassword(PeopleRows& people) {
  std::vector<std::string> out;
  for (const DemoPerson& demo : kPeople) {
    auto person = people.PersonByLogin(demo.login);
    if (!person.ok() && person.status().code() == Code::kNotFound) continue;
    ENAMEL_RETURN_IF_ERROR(person.status());
    ENAMEL_ASSIGN_OR_RETURN(auto verifier, people.PasswordVerifier(person->id));
    // Disabled is as good as another password. Asked first, because argon2id is slow on purpose.
    bool open = !person->disabled && auth::VerifyPassword(DemoPassword(demo.login), verifier);
    if (open) out.emplace_back(demo.login);
  }
  return out;
}

Status SeedDemo(const SeedOptions& options, const std::function<void(const std::string&)>& begin) {
  ENAMEL_ASSIGN_OR_RETURN(auto opened, OpenOrMake(options.data));
  Store& store = *opened;
  // Now and not with the first `serve`: a script that seeds asks for an enrolment code next.
  if (auto identity = EnsureIdentity(options.data); !identity.ok()) return identity.status();

  ENAMEL_ASSIGN_OR_RETURN(auto cohort, EnsureCohort(store.cohorts));
  for (const DemoPerson& demo : kPeople) {
    ENAMEL_ASSIGN_OR_RETURN(auto person, EnsurePerson(store.people, demo));
    if (demo.in_cohort)
      ENAMEL_RETURN_IF_ERROR(store.cohorts.AddToCohort(cohort, person, kCommandLine));
  }
  ENAMEL_RETURN_IF_ERROR(PublishProfiles(store));
  auto scene = EnsureMolar(store.blobs, store.scenes, options.voxel_um * 1000, begin);
  ENAMEL_RETURN_IF_ERROR(scene.status());
  begin("publishing the exercise of " + scene->name);
  auto exercise = PublishClassOne(store.blobs, store.exercises, *scene, cohort);
  // The last one published is the one that is reported: what the caller brought, where there is
  // one.
  if (exercise.ok() && !options.scene.empty()) {
    begin("publishing the exercise of " + options.scene);
    scene = PublishScene(store.blobs, store.scenes, options.scene, options.voxel_um * 1000);
    ENAMEL_RETURN_IF_ERROR(scene.status());
    exercise = PublishClassOne(store.blobs, store.exercises, *scene, cohort);
  }
  ENAMEL_RETURN_IF_ERROR(exercise.status());
  ENAMEL_RETURN_IF_ERROR(FollowNewest(store.assignments, *exercise, cohort));
  ENAMEL_ASSIGN_OR_RETURN(auto reference, store.references.ReferenceFor(exercise->id));

  std::cout << "demo data is there: exercise \"" << exercise->name << "\" version "
            << exercise->version << "; its passwords are public, keep this server on loopback"
            << std::endl;
  if (options.json.empty()) return Status::Ok();
  std::string text = json::serialize(Facts(*exercise, reference.has_value())) + "\n";
  return WriteFileDurably(options.json, AsBytes(text));
}

}  // namespace enamel::server::app
