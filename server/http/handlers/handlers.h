#pragma once

#include <boost/asio/awaitable.hpp>

#include "server/http/routes.h"
#include "server/http/views/attempt_view.h"

// The handlers of the route table, by subject: *_handlers.cpp. They trust the table for session,
// role and CSRF, and decide themselves whose data the caller may see. A signature names the row
// classes its handler may touch.
namespace enamel::server::http {

boost::asio::awaitable<Response> GetAlive(Call call);
boost::asio::awaitable<Response> GetReady(Call call, Store& store);
boost::asio::awaitable<Response> GetMetrics(Call call);

boost::asio::awaitable<Response> SignIn(Call call);
boost::asio::awaitable<Response> ConfirmSession(Call call);
boost::asio::awaitable<Response> ChangePassword(Call call);
boost::asio::awaitable<Response> SetPin(Call call);
Response GetSession(const Call& call);
Response SetLanguage(const Call& call, PeopleRows& people);
Response SignOut(const Call& call);
Response ListSessions(const Call& call, SessionRows& sessions);
Response EndSession(const Call& call, SessionRows& sessions);

Response MakeFirstAdmin(const Call& call, PeopleRows& people);
Response ListBuiltinTeeth(const Call& call);
Response PutBuiltinTooth(const Call& call, Store& store);
Response BeginToothImport(const Call& call);
Response AddToothBytes(const Call& call);
Response GetToothImport(const Call& call);
Response GetToothImportSurface(const Call& call);
Response GetToothImportInside(const Call& call);
Response GiveUpToothImport(const Call& call);
Response BeginExerciseTrial(const Call& call, Store& store);
Response GetExerciseTrial(const Call& call);
Response GiveUpExerciseTrial(const Call& call);

Response ListPeople(const Call& call, PeopleRows& people_rows);
Response AddPerson(const Call& call, PeopleRows& people);
Response GetPerson(const Call& call, CohortRows& cohorts_rows, PeopleRows& people);
Response EditPerson(const Call& call, PeopleRows& people);
Response ResetPassword(const Call& call, PeopleRows& people);
Response ErasePerson(const Call& call, Erasures& erasures, PeopleRows& people);
Response ListSessionsOf(const Call& call, PeopleRows& people, SessionRows& sessions);
Response EndSessionsOf(const Call& call, PeopleRows& people, SessionRows& sessions);
Response ImportRoster(const Call& call, RosterRows& roster_rows);

// An exercise with the rubric that counts, its references and the caller's attempts of it.
Response ListExercises(const Call& call, Store& store);
Response GetExercise(const Call& call, Store& store);
Response GetExerciseDocument(const Call& call, Store& store);
Response GetInitialSurface(const Call& call, Store& store);
Response ListExerciseVersions(const Call& call, AttemptRows& attempts, ExerciseRows& exercises);
Response ListReferences(const Call& call, Store& store);
Response PutDraft(const Call& call, Store& store);
Response ReplaceDraft(const Call& call, Store& store);
Response DeleteDraft(const Call& call, Store& store);
Response PublishDraft(const Call& call, Store& store);
Response RetireExercise(const Call& call, AttemptRows& attempts, ExerciseRows& exercises);
Response OfferExerciseAgain(const Call& call, Store& store);
Response ShareExercise(const Call& call, Store& store);
Response WithdrawReference(const Call& call, Store& store);

Response ListScoringMetrics(const Call& call);
Response ListRubrics(const Call& call, Store& store);
Response PreviewRubricChange(const Call& call, Store& store);
Response PublishRubric(const Call& call, Store& store);
Response RescoreCohort(const Call& call, Store& store);
Response ListBatches(const Call& call, BatchRows& batches_rows, CohortRows& cohorts);
Response GetBatch(const Call& call, BatchRows& batches, CohortRows& cohorts);
Response CancelBatch(const Call& call, BatchRows& batches, CohortRows& cohorts);

Response ListAssignments(const Call& call, Store& store);
Response AddAssignment(const Call& call, Store& store);
Response GetAssignment(const Call& call, Store& store);
Response ReplaceAssignment(const Call& call, Store& store);
Response MoveAssignment(const Call& call, Store& store);
Response DeleteAssignment(const Call& call, Store& store);
Response ReleaseAssignment(const Call& call, Store& store);
Response FindStandard(const Call& call, Store& store);
Response BeginMarking(const Call& call, Store& store);
Response ListMarkings(const Call& call, Store& store);
Response GetMarking(const Call& call, Store& store);
Response SetMarkers(const Call& call, Store& store);
Response EndMarking(const Call& call, Store& store);
Response AddMark(const Call& call, Store& store);
Response GetMarkingTimeline(const Call& call, Store& store);
Response GetInsight(const Call& call, Store& store);
Response GetAssignmentGrading(const Call& call, Store& store);
Response GetCohortGrading(const Call& call, Store& store);
// A cohort's results and attempts as files for spreadsheets.
Response GetGradesFile(const Call& call, Store& store);
Response GetAttemptsFile(const Call& call, Store& store);

Response ListProfiles(const Call& call, StoredBlobs& blobs, ProfileRows& profiles_rows);
Response PutProfile(const Call& call, StoredBlobs& blobs, ProfileRows& profiles);
Response GetProfile(const Call& call, StoredBlobs& blobs, ProfileRows& profiles);
Response ListProfileVersions(const Call& call, ProfileRows& profiles);
Response ListProfileReports(const Call& call, ProfileRows& profiles);
Response AddProfileReport(const Call& call, StoredBlobs& blobs, ProfileRows& profiles);
Response GetProfileReport(const Call& call, StoredBlobs& blobs, ProfileRows& profiles);
Response ListCalibrations(const Call& call, ProfileRows& profiles);
Response AddCalibration(const Call& call, ProfileRows& profiles);

Response ListAttempts(const Call& call, Store& store);
Response GetAttempt(const Call& call, Store& store);
Response GetScore(const Call& call, Store& store);
Response GetSignedResult(const Call& call, Store& store);
Response GetSurface(const Call& call, Store& store);
Response GetTimeline(const Call& call, Store& store);
Response GetDeviation(const Call& call, Store& store);
Response GetStartTooth(const Call& call, StoredBlobs& blobs, TimelineRows& timelines);
Response GetSeries(const Call& call, Store& store);
Response GetTicks(const Call& call, Store& store);
Response GetLive(const Call& call, Store& store);
Response GetLiveCut(const Call& call, Store& store);
Response ListLiveRemarks(const Call& call, Store& store);
Response SendLiveRemark(const Call& call, Store& store);
Response ReleaseAttempt(const Call& call, Store& store);
Response MakeReference(const Call& call, Store& store);
Response WithdrawRelease(const Call& call, Store& store);
Response PutOverride(const Call& call, Store& store);
Response DeleteOverride(const Call& call, Store& store);
Response Rescore(const Call& call, Store& store);
Response Excuse(const Call& call, Store& store);
Response TakeExcuseBack(const Call& call, Store& store);
Response RestoreResult(const Call& call, Store& store);
Response ListResults(const Call& call, Store& store);
Response ListAnnotations(const Call& call, Store& store);
Response AddAnnotation(const Call& call, Store& store);
Response ReplaceAnnotation(const Call& call, Store& store);
Response DeleteAnnotation(const Call& call, Store& store);
Response ListSavedTexts(const Call& call, SavedTextRows& texts);
Response AddSavedText(const Call& call, SavedTextRows& texts);
Response ReplaceSavedText(const Call& call, SavedTextRows& texts);
Response DeleteSavedText(const Call& call, SavedTextRows& texts);
Response FileAppeal(const Call& call, Store& store);
Response AnswerAppeal(const Call& call, Store& store);

Response ListCohorts(const Call& call, CohortRows& cohorts_rows);
Response AddCohort(const Call& call, CohortRows& cohorts);
Response GetCohort(const Call& call, CohortRows& cohorts);
Response GetCohortGrades(const Call& call, Store& store);
Response EditCohort(const Call& call, CohortRows& cohorts);
Response ChangeMembers(const Call& call, CohortRows& cohorts);

Response ListStations(const Call& call, StationRows& stations_rows);
Response GetStation(const Call& call, StationRows& stations);
Response EditStation(const Call& call, StationRows& stations);
Response ListListedDevices(const Call& call, DeviceRows& devices_rows);
Response ListDevice(const Call& call, DeviceRows& devices);
Response UnlistDevice(const Call& call, DeviceRows& devices);
Response ListStationSettings(const Call& call, SettingRows& settings);
Response PutStationSetting(const Call& call, SettingRows& settings);
Response RemoveStationSetting(const Call& call, SettingRows& settings);
Response RevokeStation(const Call& call, StationRows& stations);
Response ListEnrolCodes(const Call& call, StationRows& stations);
Response AddEnrolCode(const Call& call, StationRows& stations_rows);
Response WithdrawEnrolCode(const Call& call, StationRows& stations);

Response GetServerHealth(const Call& call, Store& store);
Response StartBackup(const Call& call);
Response ListAudit(const Call& call, AuditRows& audit_rows);
Response ListJobs(const Call& call, JobRows& jobs_rows);
Response CancelJob(const Call& call, JobRows& jobs);

}  // namespace enamel::server::http
