#pragma once

#include <boost/asio/awaitable.hpp>

#include "server/http/handlers/attempt_view.h"
#include "server/http/routes.h"

// The handlers of the route table, by subject: *_handlers.cpp. They trust the table for session,
// role and CSRF, and decide themselves whose data the caller may see. A signature says what of the
// store its handler may touch.
namespace enamel::server::http {

boost::asio::awaitable<Response> GetHealth(Call call, UpkeepStore& store);
Response GetMetrics(const Call& call);

boost::asio::awaitable<Response> SignIn(Call call);
boost::asio::awaitable<Response> ConfirmSession(Call call);
boost::asio::awaitable<Response> ChangePassword(Call call);
Response GetSession(const Call& call);
Response SetLanguage(const Call& call, PeopleStore& store);
Response SignOut(const Call& call);
Response ListSessions(const Call& call, PeopleStore& store);
Response EndSession(const Call& call, PeopleStore& store);

Response MakeFirstAdmin(const Call& call, PeopleStore& store);
Response ListBuiltinTeeth(const Call& call);
Response PutBuiltinTooth(const Call& call, Parts<ContentStore, AuditStore> store);
Response BeginToothImport(const Call& call);
Response AddToothBytes(const Call& call);
Response GetToothImport(const Call& call);
Response GiveUpToothImport(const Call& call);

Response ListPeople(const Call& call, PeopleStore& store);
Response AddPerson(const Call& call, PeopleStore& store);
Response GetPerson(const Call& call, Parts<PeopleStore, TeachingStore> store);
Response EditPerson(const Call& call, PeopleStore& store);
Response ResetPassword(const Call& call, PeopleStore& store);
Response ErasePerson(const Call& call, Parts<PeopleStore, UpkeepStore> store);
Response ListSessionsOf(const Call& call, PeopleStore& store);
Response EndSessionsOf(const Call& call, PeopleStore& store);
Response ImportRoster(const Call& call, PeopleStore& store);

// An exercise with the rubric that counts, its references and the caller's attempts of it.
using ExerciseParts = Parts<ContentStore, RubricStore, TeachingStore, AttemptStore>;
Response ListExercises(const Call& call, ExerciseParts store);
Response GetExercise(const Call& call, ExerciseParts store);
Response GetExerciseDocument(const Call& call, Parts<ContentStore, AttemptStore> store);
Response GetInitialSurface(const Call& call, Parts<ContentStore, AttemptStore> store);
Response ListExerciseVersions(const Call& call, Parts<ContentStore, AttemptStore> store);
Response ListReferences(const Call& call, ExerciseParts store);
Response PutDraft(const Call& call, ExerciseParts store);
Response ReplaceDraft(const Call& call, ExerciseParts store);
Response DeleteDraft(const Call& call, ExerciseParts store);
Response PublishDraft(const Call& call, ExerciseParts store);
Response RetireExercise(const Call& call, Parts<ContentStore, AttemptStore> store);
Response OfferExerciseAgain(const Call& call, ExerciseParts store);
Response ShareExercise(const Call& call, ExerciseParts store);
Response WithdrawReference(const Call& call, Parts<TeachingStore, AttemptStore> store);

Response ListScoringMetrics(const Call& call);
Response ListRubrics(const Call& call, ExerciseParts store);
Response PreviewRubricChange(const Call& call, ExerciseParts store);
Response PublishRubric(const Call& call, ExerciseParts store);
using RescoreParts = Parts<ContentStore, TeachingStore, AttemptStore, BatchStore>;
Response RescoreCohort(const Call& call, RescoreParts store);
Response ListBatches(const Call& call, RescoreParts store);
Response GetBatch(const Call& call, RescoreParts store);
Response CancelBatch(const Call& call, RescoreParts store);

using AssignmentListParts = Parts<StationStore, ContentStore, TeachingStore, AttemptStore>;
Response ListAssignments(const Call& call, AssignmentListParts store);
Response AddAssignment(const Call& call, Parts<StationStore, ContentStore, TeachingStore> store);
Response GetAssignment(const Call& call, Parts<StationStore, ContentStore, TeachingStore> store);
Response ReplaceAssignment(const Call& call,
                           Parts<StationStore, ContentStore, TeachingStore> store);
Response MoveAssignment(const Call& call, Parts<StationStore, ContentStore, TeachingStore> store);
Response DeleteAssignment(const Call& call, Parts<StationStore, ContentStore, TeachingStore> store);
Response ReleaseAssignment(const Call& call, TeachingStore& store);
Response GetInsight(const Call& call, Parts<ContentStore, TeachingStore, AttemptStore> store);

Response ListProfiles(const Call& call, ContentStore& store);
Response PutProfile(const Call& call, ContentStore& store);
Response GetProfile(const Call& call, ContentStore& store);
boost::asio::awaitable<Response> GetProfileFeel(Call call, ContentStore& store);
Response ListProfileVersions(const Call& call, ContentStore& store);
Response ListProfileReports(const Call& call, ContentStore& store);
Response AddProfileReport(const Call& call, ContentStore& store);
Response GetProfileReport(const Call& call, ContentStore& store);
Response ListCalibrations(const Call& call, ContentStore& store);
Response AddCalibration(const Call& call, ContentStore& store);

Response ListAttempts(const Call& call, AttemptViewParts store);
Response GetAttempt(const Call& call, AttemptViewParts store);
Response GetScore(const Call& call, Parts<ContentStore, TeachingStore, AttemptStore> store);
Response GetSurface(const Call& call, Parts<ContentStore, TeachingStore, AttemptStore> store);
Response GetTimeline(const Call& call,
                     Parts<ContentStore, TeachingStore, AttemptStore, TimelineStore> store);
Response GetDeviation(const Call& call,
                      Parts<ContentStore, TeachingStore, AttemptStore, TimelineStore> store);
Response GetStartTooth(const Call& call, Parts<BlobStore, TimelineStore> store);
Response GetSeries(const Call& call, Parts<ContentStore, TeachingStore, AttemptStore> store);
Response GetTicks(const Call& call, Parts<ContentStore, TeachingStore, AttemptStore> store);
Response GetLive(const Call& call, Parts<ContentStore, TeachingStore, AttemptStore> store);
Response ListLiveRemarks(const Call& call, Parts<ContentStore, TeachingStore, AttemptStore> store);
Response SendLiveRemark(
    const Call& call,
    Parts<ContentStore, TeachingStore, JudgingStore, AttemptStore, AuditStore> store);
Response ReleaseAttempt(const Call& call, AttemptViewParts store);
Response MakeReference(const Call& call, Parts<ContentStore, TeachingStore, AttemptStore> store);
Response WithdrawRelease(const Call& call, AttemptViewParts store);
Response PutOverride(const Call& call, AttemptViewParts store);
Response DeleteOverride(const Call& call, AttemptViewParts store);
Response Rescore(const Call& call, AttemptViewParts store);
Response Excuse(const Call& call, AttemptViewParts store);
Response TakeExcuseBack(const Call& call, AttemptViewParts store);
Response RestoreResult(const Call& call, AttemptViewParts store);
Response ListResults(const Call& call, Parts<ContentStore, TeachingStore, AttemptStore> store);
Response ListAnnotations(const Call& call,
                         Parts<ContentStore, TeachingStore, JudgingStore, AttemptStore> store);
Response AddAnnotation(const Call& call,
                       Parts<ContentStore, TeachingStore, JudgingStore, AttemptStore> store);
Response ReplaceAnnotation(const Call& call,
                           Parts<ContentStore, TeachingStore, JudgingStore, AttemptStore> store);
Response DeleteAnnotation(const Call& call,
                          Parts<ContentStore, TeachingStore, JudgingStore, AttemptStore> store);
Response FileAppeal(const Call& call, AttemptViewParts store);
Response AnswerAppeal(const Call& call, AttemptViewParts store);

Response ListCohorts(const Call& call, TeachingStore& store);
Response AddCohort(const Call& call, TeachingStore& store);
Response GetCohort(const Call& call, TeachingStore& store);
Response GetCohortGrades(const Call& call, AssignmentListParts store);
Response EditCohort(const Call& call, TeachingStore& store);
Response ChangeMembers(const Call& call, TeachingStore& store);

Response ListStations(const Call& call, StationStore& store);
Response GetStation(const Call& call, StationStore& store);
Response EditStation(const Call& call, StationStore& store);
Response ListListedDevices(const Call& call, StationStore& store);
Response ListDevice(const Call& call, StationStore& store);
Response UnlistDevice(const Call& call, StationStore& store);
Response RevokeStation(const Call& call, StationStore& store);
Response ListEnrolCodes(const Call& call, StationStore& store);
Response AddEnrolCode(const Call& call, StationStore& store);
Response WithdrawEnrolCode(const Call& call, StationStore& store);

Response GetServerHealth(
    const Call& call, Parts<StationStore, AttemptStore, JobStore, AuditStore, UpkeepStore> store);
Response ListAudit(const Call& call, AuditStore& store);
Response ListJobs(const Call& call, JobStore& store);
Response CancelJob(const Call& call, JobStore& store);

}  // namespace enamel::server::http
