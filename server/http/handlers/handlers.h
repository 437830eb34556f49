#pragma once

#include <boost/asio/awaitable.hpp>

#include "server/http/routes.h"
#include "server/http/views/attempt_view.h"

// The handlers of the route table, by subject: *_handlers.cpp. They trust the table for session,
// role and CSRF, and decide themselves whose data the caller may see. A signature names the row
// classes its handler may touch.
namespace enamel::server::http {

boost::asio::awaitable<Result<Response>> GetAlive(Call call);
boost::asio::awaitable<Result<Response>> GetReady(Call call, Store& store);
boost::asio::awaitable<Result<Response>> GetMetrics(Call call);

boost::asio::awaitable<Result<Response>> SignIn(Call call);
boost::asio::awaitable<Result<Response>> ConfirmSession(Call call);
boost::asio::awaitable<Result<Response>> ChangePassword(Call call);
boost::asio::awaitable<Result<Response>> SetPin(Call call);
Result<Response> GetSession(const Call& call);
Result<Response> SetLanguage(const Call& call, PeopleRows& people);
Result<Response> SignOut(const Call& call);
Result<Response> ListSessions(const Call& call, SessionRows& sessions);
Result<Response> EndSession(const Call& call, SessionRows& sessions);

Result<Response> MakeFirstAdmin(const Call& call, PeopleRows& people);
Result<Response> ListBuiltinTeeth(const Call& call);
Result<Response> PutBuiltinTooth(const Call& call, Store& store);
Result<Response> BeginToothImport(const Call& call);
Result<Response> AddToothBytes(const Call& call);
Result<Response> GetToothImport(const Call& call);
Result<Response> GetToothImportSurface(const Call& call);
Result<Response> GetToothImportInside(const Call& call);
Result<Response> GiveUpToothImport(const Call& call);
Result<Response> BeginExerciseTrial(const Call& call, Store& store);
Result<Response> GetExerciseTrial(const Call& call);
Result<Response> GiveUpExerciseTrial(const Call& call);

Result<Response> ListPeople(const Call& call, PeopleRows& people_rows);
Result<Response> AddPerson(const Call& call, PeopleRows& people);
Result<Response> GetPerson(const Call& call, CohortRows& cohorts_rows, PeopleRows& people);
Result<Response> EditPerson(const Call& call, PeopleRows& people);
Result<Response> ResetPassword(const Call& call, PeopleRows& people);
Result<Response> ErasePerson(const Call& call, Erasures& erasures, PeopleRows& people);
Result<Response> ListSessionsOf(const Call& call, PeopleRows& people, SessionRows& sessions);
Result<Response> EndSessionsOf(const Call& call, PeopleRows& people, SessionRows& sessions);
Result<Response> ImportRoster(const Call& call, RosterRows& roster_rows);

// An exercise with the rubric that counts, its references and the caller's attempts of it.
Result<Response> ListExercises(const Call& call, Store& store);
Result<Response> GetExercise(const Call& call, Store& store);
Result<Response> GetExerciseDocument(const Call& call, Store& store);
Result<Response> GetInitialSurface(const Call& call, Store& store);
Result<Response> ListExerciseVersions(const Call& call, AttemptRows& attempts,
                                      ExerciseRows& exercises);
Result<Response> ListReferences(const Call& call, Store& store);
Result<Response> PutDraft(const Call& call, Store& store);
Result<Response> ReplaceDraft(const Call& call, Store& store);
Result<Response> DeleteDraft(const Call& call, Store& store);
Result<Response> PublishDraft(const Call& call, Store& store);
Result<Response> RetireExercise(const Call& call, AttemptRows& attempts, ExerciseRows& exercises);
Result<Response> OfferExerciseAgain(const Call& call, Store& store);
Result<Response> ShareExercise(const Call& call, Store& store);
Result<Response> WithdrawReference(const Call& call, Store& store);

Result<Response> ListScoringMetrics(const Call& call);
Result<Response> ListRubrics(const Call& call, Store& store);
Result<Response> PreviewRubricChange(const Call& call, Store& store);
Result<Response> PublishRubric(const Call& call, Store& store);
Result<Response> RescoreCohort(const Call& call, Store& store);
Result<Response> ListBatches(const Call& call, BatchRows& batches_rows, CohortRows& cohorts);
Result<Response> GetBatch(const Call& call, BatchRows& batches, CohortRows& cohorts);
Result<Response> CancelBatch(const Call& call, BatchRows& batches, CohortRows& cohorts);

Result<Response> ListAssignments(const Call& call, Store& store);
Result<Response> AddAssignment(const Call& call, Store& store);
Result<Response> GetAssignment(const Call& call, Store& store);
Result<Response> ReplaceAssignment(const Call& call, Store& store);
Result<Response> MoveAssignment(const Call& call, Store& store);
Result<Response> DeleteAssignment(const Call& call, Store& store);
Result<Response> ReleaseAssignment(const Call& call, Store& store);
Result<Response> FindStandard(const Call& call, Store& store);
Result<Response> BeginMarking(const Call& call, Store& store);
Result<Response> ListMarkings(const Call& call, Store& store);
Result<Response> GetMarking(const Call& call, Store& store);
Result<Response> SetMarkers(const Call& call, Store& store);
Result<Response> EndMarking(const Call& call, Store& store);
Result<Response> AddMark(const Call& call, Store& store);
Result<Response> GetMarkingTimeline(const Call& call, Store& store);
Result<Response> GetInsight(const Call& call, Store& store);
Result<Response> GetAssignmentGrading(const Call& call, Store& store);
Result<Response> GetCohortGrading(const Call& call, Store& store);
// A cohort's results and attempts as files for spreadsheets.
Result<Response> GetGradesFile(const Call& call, Store& store);
Result<Response> GetAttemptsFile(const Call& call, Store& store);

Result<Response> ListProfiles(const Call& call, StoredBlobs& blobs, ProfileRows& profiles_rows);
Result<Response> PutProfile(const Call& call, StoredBlobs& blobs, ProfileRows& profiles);
Result<Response> GetProfile(const Call& call, StoredBlobs& blobs, ProfileRows& profiles);
Result<Response> ListProfileVersions(const Call& call, ProfileRows& profiles);
Result<Response> ListProfileReports(const Call& call, ProfileRows& profiles);
Result<Response> AddProfileReport(const Call& call, StoredBlobs& blobs, ProfileRows& profiles);
Result<Response> GetProfileReport(const Call& call, StoredBlobs& blobs, ProfileRows& profiles);
Result<Response> ListCalibrations(const Call& call, ProfileRows& profiles);
Result<Response> AddCalibration(const Call& call, ProfileRows& profiles);

Result<Response> ListAttempts(const Call& call, Store& store);
Result<Response> GetAttempt(const Call& call, Store& store);
Result<Response> GetScore(const Call& call, Store& store);
Result<Response> GetSignedResult(const Call& call, Store& store);
Result<Response> GetSurface(const Call& call, Store& store);
Result<Response> GetTimeline(const Call& call, Store& store);
Result<Response> GetDeviation(const Call& call, Store& store);
Result<Response> GetStartTooth(const Call& call, StoredBlobs& blobs, TimelineRows& timelines);
Result<Response> GetSeries(const Call& call, Store& store);
Result<Response> GetTicks(const Call& call, Store& store);
Result<Response> GetLive(const Call& call, Store& store);
Result<Response> GetLiveCut(const Call& call, Store& store);
Result<Response> ListLiveRemarks(const Call& call, Store& store);
Result<Response> SendLiveRemark(const Call& call, Store& store);
Result<Response> ReleaseAttempt(const Call& call, Store& store);
Result<Response> MakeReference(const Call& call, Store& store);
Result<Response> WithdrawRelease(const Call& call, Store& store);
Result<Response> PutOverride(const Call& call, Store& store);
Result<Response> DeleteOverride(const Call& call, Store& store);
Result<Response> Rescore(const Call& call, Store& store);
Result<Response> Excuse(const Call& call, Store& store);
Result<Response> TakeExcuseBack(const Call& call, Store& store);
Result<Response> RestoreResult(const Call& call, Store& store);
Result<Response> ListResults(const Call& call, Store& store);
Result<Response> ListAnnotations(const Call& call, Store& store);
Result<Response> AddAnnotation(const Call& call, Store& store);
Result<Response> ReplaceAnnotation(const Call& call, Store& store);
Result<Response> DeleteAnnotation(const Call& call, Store& store);
Result<Response> ListSavedTexts(const Call& call, SavedTextRows& texts);
Result<Response> AddSavedText(const Call& call, SavedTextRows& texts);
Result<Response> ReplaceSavedText(const Call& call, SavedTextRows& texts);
Result<Response> DeleteSavedText(const Call& call, SavedTextRows& texts);
Result<Response> FileAppeal(const Call& call, Store& store);
Result<Response> AnswerAppeal(const Call& call, Store& store);

Result<Response> ListCohorts(const Call& call, CohortRows& cohorts_rows);
Result<Response> AddCohort(const Call& call, CohortRows& cohorts);
Result<Response> GetCohort(const Call& call, CohortRows& cohorts);
Result<Response> GetCohortGrades(const Call& call, Store& store);
Result<Response> EditCohort(const Call& call, CohortRows& cohorts);
Result<Response> ChangeMembers(const Call& call, CohortRows& cohorts);

Result<Response> ListStations(const Call& call, StationRows& stations_rows);
Result<Response> GetStation(const Call& call, StationRows& stations);
Result<Response> EditStation(const Call& call, StationRows& stations);
Result<Response> ListListedDevices(const Call& call, DeviceRows& devices_rows);
Result<Response> ListDevice(const Call& call, DeviceRows& devices);
Result<Response> UnlistDevice(const Call& call, DeviceRows& devices);
Result<Response> ListStationSettings(const Call& call, SettingRows& settings);
Result<Response> PutStationSetting(const Call& call, SettingRows& settings);
Result<Response> RemoveStationSetting(const Call& call, SettingRows& settings);
Result<Response> RevokeStation(const Call& call, StationRows& stations);
Result<Response> ListEnrolCodes(const Call& call, StationRows& stations);
Result<Response> AddEnrolCode(const Call& call, StationRows& stations_rows);
Result<Response> WithdrawEnrolCode(const Call& call, StationRows& stations);

Result<Response> GetServerHealth(const Call& call, Store& store);
Result<Response> StartBackup(const Call& call);
Result<Response> ListAudit(const Call& call, AuditRows& audit_rows);
Result<Response> ListJobs(const Call& call, JobRows& jobs_rows);
Result<Response> CancelJob(const Call& call, JobRows& jobs);

}  // namespace enamel::server::http
