#pragma once

#include <boost/asio/awaitable.hpp>

#include "server/http/routes.h"

// The handlers of the route table, by subject: *_handlers.cpp. They trust the table for session,
// role and CSRF, and decide themselves whose data the caller may see.
namespace enamel::server::http {

boost::asio::awaitable<Response> GetHealth(Call call);
Response GetMetrics(const Call& call);

boost::asio::awaitable<Response> SignIn(Call call);
boost::asio::awaitable<Response> ConfirmSession(Call call);
boost::asio::awaitable<Response> ChangePassword(Call call);
Response GetSession(const Call& call);
Response SignOut(const Call& call);
Response ListSessions(const Call& call);
Response EndSession(const Call& call);

Response ListPeople(const Call& call);
Response AddPerson(const Call& call);
Response GetPerson(const Call& call);
Response EditPerson(const Call& call);
Response ResetPassword(const Call& call);
Response ErasePerson(const Call& call);
Response ListSessionsOf(const Call& call);
Response EndSessionsOf(const Call& call);
Response ImportRoster(const Call& call);

Response ListExercises(const Call& call);
Response GetExercise(const Call& call);
Response GetExerciseDocument(const Call& call);
Response GetInitialSurface(const Call& call);
Response ListExerciseVersions(const Call& call);
Response ListReferences(const Call& call);
Response PutDraft(const Call& call);
Response ReplaceDraft(const Call& call);
Response DeleteDraft(const Call& call);
Response PublishDraft(const Call& call);
Response RetireExercise(const Call& call);
Response WithdrawReference(const Call& call);

Response ListAssignments(const Call& call);
Response AddAssignment(const Call& call);
Response GetAssignment(const Call& call);
Response ReplaceAssignment(const Call& call);
Response DeleteAssignment(const Call& call);
Response ReleaseAssignment(const Call& call);

Response ListProfiles(const Call& call);
Response PutProfile(const Call& call);
Response GetProfile(const Call& call);
boost::asio::awaitable<Response> GetProfileFeel(Call call);
Response ListProfileVersions(const Call& call);
Response ListProfileReports(const Call& call);
Response AddProfileReport(const Call& call);
Response GetProfileReport(const Call& call);
Response ListCalibrations(const Call& call);
Response AddCalibration(const Call& call);

Response ListAttempts(const Call& call);
Response GetAttempt(const Call& call);
Response GetScore(const Call& call);
Response GetSurface(const Call& call);
Response GetSeries(const Call& call);
Response GetLive(const Call& call);
Response ReleaseAttempt(const Call& call);
Response MakeReference(const Call& call);
Response WithdrawRelease(const Call& call);
Response PutOverride(const Call& call);
Response DeleteOverride(const Call& call);
Response Rescore(const Call& call);
Response Excuse(const Call& call);
Response ListResults(const Call& call);
Response ListAnnotations(const Call& call);
Response AddAnnotation(const Call& call);
Response ReplaceAnnotation(const Call& call);
Response DeleteAnnotation(const Call& call);
Response FileAppeal(const Call& call);
Response AnswerAppeal(const Call& call);

Response ListCohorts(const Call& call);
Response AddCohort(const Call& call);
Response GetCohort(const Call& call);
Response EditCohort(const Call& call);
Response ChangeMembers(const Call& call);

Response ListStations(const Call& call);
Response GetStation(const Call& call);
Response EditStation(const Call& call);
Response RevokeStation(const Call& call);
Response ListEnrolCodes(const Call& call);
Response AddEnrolCode(const Call& call);
Response WithdrawEnrolCode(const Call& call);

Response ListAudit(const Call& call);
Response ListJobs(const Call& call);
Response CancelJob(const Call& call);

}  // namespace enamel::server::http
