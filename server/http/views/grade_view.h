#pragma once

#include <boost/json.hpp>
#include <map>
#include <optional>
#include <vector>

#include "server/storage/store.h"
#include "server/training/grade.h"

namespace enamel::server::http {

// Results over several attempts (server/training/grade.h) as one viewer may see them. Only scores
// that a student may see count in the student's results, so nothing is revealed before its release.
// Lives for one request; blocks. Thread safety: none.
class GradeView {
 public:
  GradeView(Store& store, const Person& viewer) : store_(store), viewer_(viewer) {}

  // What one person made under an assignment; excused and returned attempts are left out.
  struct Work {
    Grade grade;
    std::vector<AttemptRow> attempts;  // newest first
  };
  // Whose work: of all, of one person, of a cohort's members.
  struct Whose {
    std::optional<Uuid> person{}, cohort{};
  };
  // By person. Requires: the viewer may see those people's attempts. Errors: the store's.
  Result<std::map<Uuid, Work>> WorkOf(const AssignmentRow& assignment, const Whose& whose);
  Result<std::map<Uuid, Grade>> Of(const AssignmentRow& assignment, const Whose& whose);
  // A cohort's students, its assignments and those for everybody, and a result for each of both.
  struct Book {
    std::vector<Person> students;
    std::vector<AssignmentRow> assignments;   // in the order in which they are due
    std::vector<std::vector<Grade>> results;  // by assignment, then by student
  };
  Result<Book> BookOf(const Uuid& cohort);
  // Schema Grade.
  static boost::json::object Json(const Grade& grade);
  // Schema GradeSummary.
  static boost::json::object Json(const GradeSummary& summary);

 private:
  Result<bool> IsGraded(const Uuid& exercise);
  Result<bool> IsScoredAgain(const AttemptRow& row, bool seen);

  Store& store_;
  const Person& viewer_;
  std::map<Uuid, bool> graded_;
};

}  // namespace enamel::server::http
