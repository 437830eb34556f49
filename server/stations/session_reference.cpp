#include "common/base/log_request.h"
#include "common/protocol/refusals.h"
#include "server/jobs/reference_check.h"
#include "server/stations/session.h"
#include "server/training/access.h"
#include "server/training/names.h"
#include "server/training/revision.h"

// An instructor's word, at the station, that an attempt is what others are compared with.
namespace enamel::server::stations {
namespace {

static_assert(kAnyway == protocol::kAnyway);  // the store's and the link's name of one field

constexpr size_t kMaxDentistBytes = 200;

Status CheckWords(const wire::MarkReference& request) {
  if (request.dentist().empty() || request.dentist().size() > kMaxDentistBytes) {
    return Status(Code::kInvalidInput,
                  "expected the dentist's name in 1 to " + std::to_string(kMaxDentistBytes) +
                      " bytes, found " + std::to_string(request.dentist().size()),
                  "dentist");
  }
  if (!request.anyway().empty()) {
    ENAMEL_RETURN_IF_ERROR(CheckedReason(request.anyway(), "anyway").status());
  }
  return CheckConsent(request.consent());
}

}  // namespace

Result<wire::Reply> Session::Do(const wire::MarkReference& request) {
  ENAMEL_ASSIGN_OR_RETURN(const auto seen, SeenAttempt(request.session(), request.attempt()));
  const AttemptRow& row = seen.row;
  const LogAttempt logged(row.id);
  if (!CanMarkReference(seen.person, row, seen.teaches)) {
    return Status(Code::kForbidden, "only instructors and admins make an attempt the reference",
                  "as_reference");
  }
  ENAMEL_RETURN_IF_ERROR(CheckWords(request));
  if (row.state != AttemptState::kScored) {
    return Status(Code::kConflict,
                  std::string("expected a scored attempt, this one is ") +
                      AttemptStateName(row.state) + "; wait for the score",
                  "attempt");
  }
  ENAMEL_ASSIGN_OR_RETURN(
      auto reference,
      MakeReference(services_.store, row.id, request.dentist(), request.consent(), request.anyway(),
                    Actor{seen.person.id, "station " + station_->name}));
  wire::Reply reply;
  reply.mutable_reference_marked()->set_attempt(request.attempt());
  reply.mutable_reference_marked()->set_version(reference.version);
  return reply;
}

}  // namespace enamel::server::stations
