#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/base/result.h"

// The `admin` commands about exercises and assignments. As those of admin.h.
namespace enamel::server::app {

struct NewExercise {
  std::string scene;   // PublishScene's source
  std::string cohort;  // name; empty: open to everybody
  int32_t voxel_um = 50;
  std::string name;         // of a built-in exercise, or its kind; empty: all the scene has
  bool unassigned = false;  // assigned to nobody, instead of to the cohort
  std::string document;     // file with an exercise document, instead of scene and name
  std::string material;     // file that says what cutting the scene's tissues takes
  std::string prepared;     // folder of `enamel-station target`, made for the scene
  bool dry_run = false;     // only checks and tries the document, and prints what comes of it
};
Status PublishExercise(const std::filesystem::path& data, const NewExercise& exercise);
// `reason` goes to the audit trail.
Status RetireExercise(const std::filesystem::path& data, const std::string& name,
                      const std::string& reason = {});
// Takes that back.
Status OfferExercise(const std::filesystem::path& data, const std::string& name);
// `state`: "draft", "published", "retired"; empty: all.
Status ListExercises(const std::filesystem::path& data, const std::string& state);

// The owner, and whether other instructors may use it. Empty members stay unchanged.
struct Sharing {
  std::string exercise;  // name
  std::string owner;     // login of an instructor
  bool school = false;   // instead: the school's
  bool shared = false, is_private = false;
};
Status ShareExercise(const std::filesystem::path& data, const Sharing& sharing);

struct NewAssignment {
  std::string exercise, cohort;  // names; no cohort: everybody
  std::string opens, due;        // TimeFromText; empty: no such bound
  uint32_t attempt_limit = 0;
  bool exam = false, late_allowed = false, sign_off = false;
  std::vector<std::string> stations;  // names, of an exam
  std::string hands = "listed";       // HandsAllowedName
  std::string counting = "best";      // CountingFromName
  std::string outline = "practice";   // OutlineShownFromName
};
Status AssignExercise(const std::filesystem::path& data, const NewAssignment& assignment);
// Moves an assignment to another version of its exercise (0: the newest); prints what moves and
// what stays. `dry_run`: only prints.
Status MoveAssignment(const std::filesystem::path& data, const std::string& id, int32_t version,
                      bool dry_run);
Status EndAssignment(const std::filesystem::path& data, const std::string& id);
Status ListAssignments(const std::filesystem::path& data);
// Lets students see every scored attempt under it.
Status ReleaseAssignment(const std::filesystem::path& data, const std::string& id);

struct CommandGroup;
// On the command line (command_line.h), by subject.
void DeclareExercises(CommandGroup admin);
void DeclareAssignments(CommandGroup admin);

}  // namespace enamel::server::app
