#pragma once

#include <functional>
#include <memory>
#include <string>

#include "server/auth/authenticator.h"
#include "server/storage/audit/actor.h"
#include "server/storage/store.h"
#include "tests/support/temp_folder.h"

namespace enamel::scoring {
struct ScoreResult;
}

namespace enamel::server::http {

inline constexpr char kPassword[] = "correct horse battery";

// A real store in a temporary folder: two cohorts, one graded exercise, attempts in several states.
//   cohort A: ada (instructor), sam and sue (students); cohort B: ben (instructor), tom (student);
//   root (admin). All have kPassword. Time stands still until `now_ms` is changed.
// Of a scored attempt's tooth: the only one that was compared, at the surface.
inline constexpr ivec3 kComparedCell{7, 7, 9};

struct School {
  // `root_role`: another than an admin's leaves the school without one.
  explicit School(Role root_role = Role::kAdmin);

  // A sealed and scored attempt of the person; its blobs are `{...}` score, a surface of one point,
  // `{}` series.
  // `change` may give its row other terms.
  using Change = std::function<void(AttemptRow&)>;
  // `judge` may give its score criteria.
  using Judge = std::function<void(scoring::ScoreResult&)>;
  Uuid ScoredAttempt(const Uuid& person, const Change& change = {}, const Judge& judge = {});
  Uuid RecordingAttempt(const Uuid& person, const Change& change = {},
                        ByteView header = AsBytes("header"));
  // An exercise of this name by the actor, a draft or published, which nobody is to do.
  ExerciseRow OwnExercise(const Actor& by, const std::string& name, bool publish,
                          bool graded = true);

  // Asked before the store keeps something; true: it fails. Set while no request is under way.
  std::function<bool()> before_write;
  test::TempFolder folder;
  std::unique_ptr<Store> store;
  UnixMs now_ms = 0;
  std::unique_ptr<auth::Authenticator> authenticator;
  Uuid root, ada, ben, sam, sue, tom;
  Uuid cohort_a, cohort_b, station, exercise;
  Uuid sams_scored, sams_recording, toms_scored;

 private:
  Uuid AddPerson(const std::string& login, Role role);
  void AddDocuments();

  std::string verifier_;
  ExerciseRow exercise_row_;
  Sha256 profile_;
};

}  // namespace enamel::server::http
