#include <gtest/gtest.h>

#include <boost/json/parse.hpp>
#include <functional>

#include "common/base/file.h"
#include "common/base/utf8.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/material.h"
#include "common/scene/volume_blob.h"
#include "server/app/data_folder.h"
#include "server/app/publish.h"
#include "server/app/seed.h"
#include "server/app/serve.h"
#include "server/auth/authenticator.h"
#include "server/commands/admin.h"
#include "server/commands/admin_people.h"
#include "server/commands/admin_stations.h"
#include "server/commands/init.h"
#include "server/commands/report.h"
#include "server/commands/say.h"
#include "server/commands/teaching.h"
#include "server/commands/upkeep.h"
#include "server/training/ticket_rules.h"
#include "tests/server/storage/store_world.h"

namespace enamel::server::app {
namespace {

using namespace server::testing;

class CommandsTest : public ::testing::Test {
 protected:
  std::filesystem::path Data() const { return folder_.path() / "data"; }
  std::unique_ptr<Store> OpenData() { return OpenStore(Data()); }

  CommandsTest() { EXPECT_TRUE(InitData(Data()).ok()); }

  TempFolder folder_;
};

TEST(StateTextTest, StatesAreCalledAsOnThePage) {
  const auto words =
      boost::json::parse(AsText(*ReadFile(ENAMEL_SOURCE_DIR "/schemas/words/en/page.json")));
  const auto& messages = words.at("messages").as_object();
  for (int i = 1; i <= static_cast<int>(AttemptState::kQuarantined); ++i) {
    const auto state = static_cast<AttemptState>(i);
    std::string text(
        messages.at(std::string("attempt_state.") + AttemptStateName(state)).as_string());
    text[0] = static_cast<char>(std::tolower(text[0]));
    EXPECT_EQ(StateText(state), text);
  }
}

TEST_F(CommandsTest, AFolderThatIsNoneIsNotMade) {
  const std::filesystem::path typo = folder_.path() / "dta";
  ReportOptions report;
  report.data = typo;
  report.attempt = Uuid::New().Text();
  const std::vector<Status> refused = {AddPerson(typo, {"ada", "Ada", "student"}),
                                       PublishExercise(typo, {"builtin:molar", ""}),
                                       ListCohorts(typo), Report(report)};
  for (const Status& status : refused) {
    EXPECT_EQ(status.code(), Code::kNotFound);
    EXPECT_NE(status.message().find(typo.string()), std::string::npos) << status.message();
    EXPECT_NE(status.message().find("init"), std::string::npos) << status.message();
  }
  EXPECT_FALSE(std::filesystem::exists(typo));
  std::filesystem::create_directory(typo);
  EXPECT_EQ(ListCohorts(typo).code(), Code::kNotFound) << "an empty one is none either";
  EXPECT_TRUE(std::filesystem::is_empty(typo));
}

TEST_F(CommandsTest, InitMakesAFolderForItsOwnerOnlyAndChangesNoneThatIsThere) {
  auto mode = [](const std::filesystem::path& path) {
    return std::filesystem::status(path).permissions();
  };
  EXPECT_EQ(mode(Data()), std::filesystem::perms::owner_all);
  const auto before = *ReadFile(Data() / "station.crt");
  ASSERT_TRUE(AddPerson(Data(), {"ada", "Ada", "student"}).ok());
  ASSERT_TRUE(InitData(Data()).ok());
  EXPECT_EQ(*ReadFile(Data() / "station.crt"), before);
  EXPECT_EQ(OpenData()->people.People()->size(), 1u);
}

TEST_F(CommandsTest, SeedingTwiceChangesNothing) {
  SeedOptions options;
  options.data = Data();
  options.voxel_um = 150;
  options.json = folder_.path() / "seed.json";
  std::vector<std::string> parts;
  const auto begin = [&](const std::string& part) { parts.push_back(part); };
  ASSERT_TRUE(SeedDemo(options, begin).ok());
  const std::string publishing = "publishing the exercise of molar-46";
  EXPECT_EQ(parts, (std::vector<std::string>{"building the molar (once)", publishing}));
  auto people = OpenData()->people.People();
  auto exercises = OpenData()->exercises.AllExercises();
  size_t changes = OpenData()->audit.Audit(1000)->size();
  parts.clear();
  ASSERT_TRUE(SeedDemo(options, begin).ok());
  EXPECT_EQ(parts, std::vector<std::string>{publishing});
  EXPECT_EQ(people->size(), 4u);
  EXPECT_EQ(OpenData()->exercises.AllExercises()->front().id, exercises->front().id);
  EXPECT_EQ(OpenData()->audit.Audit(1000)->size(), changes);

  auto facts = boost::json::parse(AsText(*ReadFile(options.json))).as_object();
  EXPECT_EQ(facts.at("exercise").as_string(), exercises->front().name);
  EXPECT_FALSE(facts.at("has_reference").as_bool());
  auto store = OpenData();
  EXPECT_EQ(store->profiles.Profiles()->size(), scene::BuiltinProfiles().size());
  EXPECT_EQ(store->exercises.ExercisesFor(store->people.PersonByLogin("student1")->id)->size(), 1u);
  auth::Authenticator authenticator(*store);
  EXPECT_TRUE(
      authenticator.SignInHere({"student1", "enamel-demo-student1", "127.0.0.1", "page"}).ok());
}

TEST_F(CommandsTest, SceneFolderIsRefusedWhenItIsIncompleteOrItsVolumeIsAnothers) {
  auto built = scene::BuildBuiltinScene("block", 500'000);
  std::filesystem::path folder = folder_.path() / "scene";
  std::filesystem::create_directories(folder);
  auto store = OpenData();
  EXPECT_EQ(PublishScene(store->blobs, store->scenes, folder, 0).status().code(), Code::kNotFound);
  auto write = [&](const char* name, ByteView content) {
    ASSERT_TRUE(WriteFileDurably(folder / name, content).ok());
  };
  write("scene.json", AsBytes(scene::ToJson(built->scene)));
  Status incomplete = PublishScene(store->blobs, store->scenes, folder, 0).status();
  EXPECT_EQ(incomplete.code(), Code::kNotFound);
  EXPECT_NE(incomplete.message().find("volume.envb"), std::string::npos) << incomplete.message();
  write("volume.envb", AsBytes("another"));
  EXPECT_EQ(PublishScene(store->blobs, store->scenes, folder, 0).status().code(), Code::kConflict);
  write("volume.envb", scene::EncodeVolume(built->volume));
  scene::Scene finer = built->scene;
  finer.voxel_nm /= 2;
  write("scene.json", AsBytes(scene::ToJson(finer)));
  Status other = PublishScene(store->blobs, store->scenes, folder, 0).status();
  EXPECT_EQ(other.code(), Code::kConflict) << "scene and volume disagree about the voxel";
  write("scene.json", AsBytes(scene::ToJson(built->scene)));
  auto row = PublishScene(store->blobs, store->scenes, folder, 0);
  ASSERT_TRUE(row.ok()) << row.status().message();
  EXPECT_TRUE(store->blobs.HasBlob(row->volume));

  // The same tooth with what another file says of its tissues is another scene.
  const auto material = folder_.path() / "soft.json";
  ASSERT_TRUE(WriteFileDurably(material, AsBytes(scene::ToJson(scene::ByLoadMaterial()))).ok());
  EXPECT_EQ(PublishScene(store->blobs, store->scenes, folder, 0, material).status().field(),
            "enamel")
      << "a file must fit the scene";
  scene::Material own = scene::ByLoadMaterial();
  own.tissues = {own.tissues.front()};
  own.tissues[0].name = "gypsum";
  ASSERT_TRUE(WriteFileDurably(material, AsBytes(scene::ToJson(own))).ok());
  auto soft = PublishScene(store->blobs, store->scenes, folder, 0, material);
  ASSERT_TRUE(soft.ok()) << soft.status().message();
  EXPECT_EQ(soft->name, row->name + "-soft");
  EXPECT_NE(soft->content, row->content);
  EXPECT_EQ(soft->volume, row->volume);
  EXPECT_EQ(
      PublishScene(store->blobs, store->scenes, folder, 0, "Soft enamel.json").status().field(),
      "material");
}

TEST_F(CommandsTest, RefusalsSayWhatIsAllowed) {
  EXPECT_NE(
      AddPerson(Data(), {"ada", "Ada", "dean"}).message().find("student, instructor or admin"),
      std::string::npos);
  EXPECT_EQ(AddPerson(Data(), {"a b", "", "student"}).field(), "login");
  EXPECT_EQ(AddToCohort(Data(), "none", "ada").code(), Code::kNotFound);
  EXPECT_EQ(PublishExercise(Data(), {"builtin:no-such-tooth", ""}).field(), "name");
  EXPECT_EQ(MarkReference(Data(), "not an id", "x", true).code(), Code::kInvalidInput);
  EXPECT_EQ(MarkReference(Data(), Uuid::New().Text(), "x", true).code(), Code::kNotFound);
  Status without = MarkReference(Data(), Uuid::New().Text(), "x", false);
  EXPECT_EQ(without.field(), "consent");
  EXPECT_NE(without.message().find("--consent"), std::string::npos) << without.message();
  ReportOptions report;
  report.data = Data();
  report.attempt = Uuid::New().Text();
  EXPECT_EQ(Report(report).code(), Code::kNotFound);
}

TEST_F(CommandsTest, ReportSaysWhyThereIsNoScore) {
  auto store = OpenData();
  World world(*store);
  ReportOptions report;
  report.data = Data();
  Uuid open = world.OpenedAttempt();
  report.attempt = open.Text();
  Status waiting = Report(report);
  EXPECT_EQ(waiting.code(), Code::kUnavailable);
  EXPECT_NE(waiting.message().find("recording"), std::string::npos) << waiting.message();
  ASSERT_TRUE(
      store->results.FailAttempt(open, Status(Code::kConflict, "witness differs at tick 7"), {})
          .ok());
  Status failed = Report(report);
  EXPECT_EQ(failed.code(), Code::kConflict);
  EXPECT_NE(failed.message().find("tick 7"), std::string::npos);
}

TEST_F(CommandsTest, ExercisesArePublishedAssignedAndRetiredFromTheCommandLine) {
  NewExercise exercise{"builtin:block", "", 500, "cross"};
  exercise.unassigned = true;
  ASSERT_TRUE(PublishExercise(Data(), exercise).ok());
  ASSERT_TRUE(PublishExercise(Data(), exercise).ok()) << "again changes nothing";
  ASSERT_TRUE(AddCohort(Data(), "Year 2").ok());
  NewAssignment exam;
  exam.exercise = "cross-block";
  exam.cohort = "Year 2";
  exam.due = "2026-12-01 12:00Z";
  exam.attempt_limit = 2;
  exam.exam = true;
  EXPECT_EQ(ListExercises(Data(), "").code(), Code::kOk);
  EXPECT_EQ(AssignExercise(Data(), exam).field(), "reference") << "an exam needs one";
  {
    AssignmentRow row;
    row.exercise = exam.exercise;
    row.due_ms = *TimeFromText(exam.due);
    row.attempt_limit = exam.attempt_limit;
    row.exam = true;
    ASSERT_TRUE(OpenData()->assignments.AddAssignment(row, kSystem).ok());
  }
  exam.stations = {"no such bench"};
  EXPECT_EQ(AssignExercise(Data(), exam).field(), "station");
  exam.stations.clear();
  exam.opens = exam.due;
  EXPECT_EQ(AssignExercise(Data(), exam).field(), "due_ms");
  exam.hands = "robots";
  EXPECT_EQ(AssignExercise(Data(), exam).field(), "hands");
  Uuid id;
  {
    auto store = OpenForCommand(Data());
    ASSERT_TRUE(store.ok());
    auto versions = (*store)->exercises.ExerciseVersions("cross-block");
    ASSERT_EQ(versions->size(), 1u);
    EXPECT_EQ(versions->front().version, 1);
    auto rows = (*store)->assignments.Assignments({});
    ASSERT_EQ(rows->size(), 1u) << "unassigned until assigned";
    EXPECT_EQ(rows->front().due_ms, 1'796'126'400'000);  // date -u -d "2026-12-01 12:00" +%s
    EXPECT_TRUE(rows->front().exam);
    EXPECT_EQ(rows->front().hands, HandsAllowed::kListed);
    id = rows->front().id;
  }
  EXPECT_TRUE(ReleaseAssignment(Data(), id.Text()).ok());
  ASSERT_TRUE(EndAssignment(Data(), id.Text()).ok());
  EXPECT_EQ(EndAssignment(Data(), id.Text()).code(), Code::kNotFound);
  ASSERT_TRUE(RetireExercise(Data(), "cross-block").ok());
  EXPECT_EQ(RetireExercise(Data(), "no such").code(), Code::kNotFound);
  EXPECT_EQ(PublishExercise(Data(), {"builtin:block", "", 500, "bridge"}).field(), "name");
}

TEST_F(CommandsTest, AGradedExerciseOfABuiltInSceneComesAsPracticeToo) {
  NewExercise exercise{"builtin:block", "", 150, "class-1"};
  ASSERT_TRUE(PublishExercise(Data(), exercise).ok());
  exercise.name = "cross";
  ASSERT_TRUE(PublishExercise(Data(), exercise).ok());
  auto store = OpenData();
  EXPECT_TRUE(store->exercises.ExerciseVersions("class-1-block")->front().graded);
  const auto practice = store->exercises.ExerciseVersions("practice-class-1-block");
  ASSERT_EQ(practice->size(), 1u);
  EXPECT_FALSE(practice->front().graded);
  EXPECT_EQ(practice->front().title, "Central box, as in a class I cavity");
  EXPECT_FALSE(store->exercises.ExerciseVersions("cross-block")->front().graded);
  EXPECT_TRUE(store->exercises.ExerciseVersions("practice-cross-block")->empty());
}

TEST_F(CommandsTest, ADryRunPrintsBothScoresAndPublishesNothing) {
  ASSERT_TRUE(PublishExercise(Data(), {"builtin:block", "", 150, "class-1"}).ok());
  std::filesystem::path file = Data() / "try.json";
  {
    auto store = OpenData();
    const auto row = store->exercises.ExerciseVersions("class-1-block")->front();
    auto exercise = scene::ExerciseFromJson(AsText(*store->blobs.GetBlob(row.content)));
    exercise->name = "tried";
    exercise->rubric.criteria = {{"time_s", "Time", "s", 20, {{0, 0.5}}, "slow", {}}};
    ASSERT_TRUE(WriteFileDurably(file, AsBytes(scene::ToJson(*exercise)), 0600).ok());
  }
  NewExercise tried;
  tried.document = file;
  tried.dry_run = true;
  ::testing::internal::CaptureStdout();
  ASSERT_TRUE(PublishExercise(Data(), tried).ok());
  const std::string said = ::testing::internal::GetCapturedStdout();
  EXPECT_NE(said.find("target cut exactly: "), std::string::npos) << said;
  EXPECT_NE(said.find("time_s costs 10.0 points"), std::string::npos) << said;
  EXPECT_NE(said.find("untouched tooth: 0.0 of 100 points"), std::string::npos) << said;
  EXPECT_NE(said.find("critical error: nothing_cut"), std::string::npos) << said;
  EXPECT_TRUE(OpenData()->exercises.ExerciseVersions("tried")->empty());
}

TEST_F(CommandsTest, VoxelsTooCoarseForTheBurAreRefusedForGradedWorkAndToldOfPractice) {
  NewExercise exercise{"builtin:block", "", 500, "class-1"};
  const Status refused = PublishExercise(Data(), exercise);
  EXPECT_EQ(refused.code(), Code::kInvalidInput);
  EXPECT_NE(refused.message().find("voxels of 500 um are too coarse"), std::string::npos)
      << refused.message();
  exercise.name = "cross";
  ::testing::internal::CaptureStdout();
  EXPECT_TRUE(PublishExercise(Data(), exercise).ok());
  EXPECT_NE(
      ::testing::internal::GetCapturedStdout().find("warning: voxels of 500 um are too coarse"),
      std::string::npos);
}

TEST_F(CommandsTest, ADueTimeThatHasPassedIsToldWhenItIsSet) {
  NewExercise exercise;
  exercise.scene = "builtin:block";
  exercise.voxel_um = 500;
  exercise.name = "cross";
  exercise.unassigned = true;
  ASSERT_TRUE(PublishExercise(Data(), exercise).ok());
  auto said = [&](const std::string& due, bool late) {
    NewAssignment assignment;
    assignment.exercise = "cross-block";
    assignment.due = due;
    assignment.late_allowed = late;
    ::testing::internal::CaptureStdout();
    EXPECT_TRUE(AssignExercise(Data(), assignment).ok());
    return ::testing::internal::GetCapturedStdout();
  };
  EXPECT_NE(said("2020-01-01 12:00", false).find("has passed: nobody can begin"),
            std::string::npos);
  EXPECT_NE(said("2020-01-01 12:00", true).find("every attempt will be late"), std::string::npos);
  EXPECT_EQ(said("", false).find("has passed"), std::string::npos);
}

TEST_F(CommandsTest, DemoPasswordsAreNotServedBeyondLoopback) {
  {
    auto store = OpenData();
    server::testing::AddPerson(*store, "student1", Role::kStudent,
                               *auth::HashPassword("enamel-demo-student1"));
    server::testing::AddPerson(*store, "admin", Role::kAdmin,
                               *auth::HashPassword("a drill and a spoon"));
    EXPECT_EQ(*LoginsWithDemoPassword(store->people), std::vector<std::string>{"student1"});
  }
  ServeOptions options;
  options.data = Data();
  options.http = "127.0.0.1:0";
  options.stations = "0.0.0.0:0";
  Status refused = Serve(options);
  EXPECT_EQ(refused.code(), Code::kInvalidInput);
  EXPECT_NE(refused.message().find("public ones for student1; "), std::string::npos)
      << refused.message();
  ASSERT_TRUE(SetDisabled(Data(), "Student1", true).ok()) << "a login in any case";
  EXPECT_TRUE(LoginsWithDemoPassword(OpenData()->people)->empty());
}

TEST_F(CommandsTest, StationOfAnExamIsOneThatIsAdmitted) {
  auto store = OpenData();
  std::vector<Uuid> ids;
  for (const char* code : {"one", "two"}) {
    ASSERT_TRUE(store->stations.AddEnrolCode(HashSha256(AsBytes(code)), 1000, kSystem).ok());
    StationRow row;
    row.name = "Lab 7";
    row.public_key = Bytes(32, static_cast<uint8_t>(code[0]));
    auto station = store->stations.EnrolStation(HashSha256(AsBytes(code)), row,
                                                HashSha256(AsBytes(row.name + code)), 1);
    ASSERT_TRUE(station.ok()) << station.status().message();
    ids.push_back(station->id);
  }
  EXPECT_NE(StationNamed(store->stations, "Lab 7").status().message().find("2 stations"),
            std::string::npos);
  ASSERT_TRUE(store->stations.RevokeStation(ids[0], kSystem).ok());
  EXPECT_EQ(StationNamed(store->stations, "Lab 7")->id, ids[1]);
  EXPECT_EQ(StationNamed(store->stations, ids[0].Text()).status().field(), "station");
}

// Names are checked when they are given (training/names.h); documents, what stations say of
// themselves and older databases may hold any.
TEST_F(CommandsTest, TerminalObeysNoTextOfAnyList) {
  const std::string evil = "x\x1b]0;owned\a\u202ey\u009b2J";
  const std::string golden = ENAMEL_SOURCE_DIR "/schemas/golden/scene_calibration.json";
  {
    auto store = OpenData();
    World world(*store);
    Uuid cohort = *store->cohorts.CreateCohort(evil, kSystem);
    Person person;
    person.login = "evil";
    person.display_name = evil;
    person.id = *store->people.CreatePerson(person, "none", {cohort}, kSystem);
    ASSERT_TRUE(store->sessions.CreateSession({HashSha256({}), person.id, 1, 1, 2, evil}).ok());
    ASSERT_TRUE(store->stations.RenameStation(world.station, evil, 1, kSystem).ok());
    ASSERT_TRUE(store->stations.TouchStation(world.station, evil, 1, 1).ok());
    ExerciseRow exercise = world.Exercise(evil, "another content");
    exercise.title = evil;
    auto published = store->exercises.PublishExercise(exercise, cohort, kSystem);
    ASSERT_TRUE(published.ok()) << published.status().message();
    world.exercise = *published;
    AttemptRow attempt = world.NewAttemptOf(person.id);
    ASSERT_TRUE(store->results.FailAttempt(attempt.id, Status(Code::kConflict, evil), {}).ok());
    ASSERT_TRUE(
        store->audit.NoteAudit({{}, evil}, "attempt.awaits", Uuid::New().Text(), evil).ok());
    ASSERT_TRUE(store->profiles.PutProfile({"device", "Device", world.profile}, kSystem).ok());
    CalibrationRow calibration;
    calibration.profile = "device";
    calibration.device = evil;
    calibration.document = AsText(*ReadFile(golden));
    ASSERT_TRUE(store->profiles.AddCalibration(calibration, kSystem).ok());
    ASSERT_TRUE(
        WriteFileDurably(folder_.path() / "roster.csv",
                         AsBytes("login,display_name,role," + evil + "\nann,Ann,student,\n"))
            .ok());
  }
  RosterCommand roster{Data(), folder_.path() / "roster.csv", true, true, "", "", ""};
  const std::pair<const char*, std::function<Status()>> lists[] = {
      {"people",
       [&] {
         return ListPeople({Data(), "", "", ""});
       }},
      {"cohorts", [&] { return ListCohorts(Data()); }},
      {"sessions", [&] { return ListSessions(Data(), "evil"); }},
      {"stations", [&] { return ListStations(Data()); }},
      {"awaited", [&] { return ListAwaited(Data()); }},
      {"calibrations", [&] { return ListCalibrations(Data(), "device"); }},
      {"exercises", [&] { return ListExercises(Data(), ""); }},
      {"assignments", [&] { return ListAssignments(Data()); }},
      {"attempts", [&] { return ListAttempts(Data(), 50); }},
      {"roster", [&] { return ImportRoster(roster); }},
  };
  for (const auto& [name, list] : lists) {
    SCOPED_TRACE(name);
    ::testing::internal::CaptureStdout();
    Status status = list();
    std::string text = ::testing::internal::GetCapturedStdout();
    EXPECT_TRUE(status.ok()) << status.message();
    for (const char* obeyed : {"\x1b", "\a", "\u202e", "\u009b"}) {
      EXPECT_EQ(text.find(obeyed), std::string::npos) << Printable(text);
    }
    EXPECT_NE(text.find("x1b]0;owned"), std::string::npos) << Printable(text);
  }
}

TEST_F(CommandsTest, ReferencesAreListedAndWithdrawnByTheirIdOrThatOfTheirAttempt) {
  Uuid first, second;
  {
    auto store = OpenData();
    World world(*store);
    for (Uuid* attempt : {&first, &second}) {
      *attempt = world.ScoredAttempt();
      ASSERT_TRUE(store->references.AddReference(*attempt, "Dr. Vega", true, kSystem).ok());
    }
  }
  auto said = [&](const std::function<Status()>& command) {
    ::testing::internal::CaptureStdout();
    Status status = command();
    EXPECT_TRUE(status.ok()) << status.message();
    return ::testing::internal::GetCapturedStdout();
  };
  auto list = [&] { return said([&] { return ListReferences(Data(), "exercise"); }); };
  EXPECT_NE(list().find("counts    attempt " + second.Text()), std::string::npos) << list();
  EXPECT_NE(list().find("counts    attempt " + first.Text()), std::string::npos) << list();
  EXPECT_NE(
      said([&] { return WithdrawReference(Data(), second.Text()); }).find("1 reference counts now"),
      std::string::npos);
  EXPECT_NE(list().find("withdrawn attempt " + second.Text()), std::string::npos) << list();
  EXPECT_NE(list().find("counts    attempt " + first.Text()), std::string::npos) << list();
  EXPECT_NE(said([&] { return WithdrawReference(Data(), second.Text()); }).find("withdrawn before"),
            std::string::npos);
  const Uuid id = OpenData()
                      ->references.ReferenceFor(OpenData()->attempts.AttemptById(first)->exercise)
                      ->value()
                      .id;
  EXPECT_NE(said([&] { return WithdrawReference(Data(), id.Text()); }).find("no reference now"),
            std::string::npos);
  EXPECT_EQ(WithdrawReference(Data(), Uuid::New().Text()).field(), "reference");
  EXPECT_EQ(ListReferences(Data(), "no such").field(), "exercise");
  EXPECT_EQ(OpenData()->attempts.AttemptById(first)->score, 80) << "scores stay";
  EXPECT_EQ(OpenData()->audit.FindAudit({.action = "reference.withdraw"})->size(), 2u);
}

TEST_F(CommandsTest, ProfileThatAnAdminHasPutStaysTheNewestWhenExercisesArePublished) {
  const scene::DeviceProfile ours = scene::BuiltinProfiles().front();
  NewExercise exercise;
  exercise.scene = "builtin:block";
  exercise.voxel_um = 500;
  exercise.name = "cross";
  ASSERT_TRUE(PublishExercise(Data(), exercise).ok());
  {
    auto store = OpenData();
    const Sha256 content = PutText(*store, "measured here");
    ASSERT_TRUE(store->profiles.PutProfile({ours.name, "Ours", content}, kCommandLine).ok());
  }
  ASSERT_TRUE(PublishExercise(Data(), exercise).ok());
  EXPECT_EQ(OpenData()->profiles.ProfileVersions(ours.name)->front().title, "Ours");
  // What an earlier program left is not the school's own.
  {
    auto store = OpenData();
    const scene::DeviceProfile other = scene::BuiltinProfiles().back();
    ASSERT_TRUE(store->profiles
                    .PutProfile({other.name, "Of before", PutText(*store, "earlier form")},
                                Actor{{}, "built-in profiles"})
                    .ok());
    ASSERT_TRUE(PublishProfiles(*store).ok());
    EXPECT_EQ(store->profiles.ProfileVersions(other.name)->front().title, other.title);
  }
}

TEST_F(CommandsTest, SharingNothingAndMovingNowhereSaySo) {
  NewExercise exercise;
  exercise.scene = "builtin:block";
  exercise.voxel_um = 500;
  exercise.name = "cross";
  ASSERT_TRUE(PublishExercise(Data(), exercise).ok());
  Sharing sharing;
  sharing.exercise = "cross-block";
  const Status nothing = ShareExercise(Data(), sharing);
  EXPECT_EQ(nothing.code(), Code::kInvalidInput);
  EXPECT_NE(nothing.message().find("--shared or --private"), std::string::npos);
  const Uuid assignment = OpenData()->assignments.Assignments({})->front().id;
  ::testing::internal::CaptureStdout();
  EXPECT_TRUE(MoveAssignment(Data(), assignment.Text(), 1, false).ok());
  EXPECT_NE(::testing::internal::GetCapturedStdout().find("nothing was changed"),
            std::string::npos);
}

TEST_F(CommandsTest, DocumentThatIsRefusedNamesItsMemberOnce) {
  const std::filesystem::path file = folder_.path() / "exercise.json";
  std::string text(AsText(*ReadFile(ENAMEL_SOURCE_DIR "/schemas/golden/scene_exercise.json")));
  text.replace(text.find("\"criteria\""), 10, "\"criterias\"");
  ASSERT_TRUE(WriteFileDurably(file, AsBytes(text)).ok());
  NewExercise exercise;
  exercise.document = file.string();
  const Status refused = PublishExercise(Data(), exercise);
  ASSERT_FALSE(refused.ok());
  const size_t first = refused.message().find("/rubric/");
  EXPECT_NE(first, std::string::npos) << refused.message();
  EXPECT_EQ(refused.message().find("/rubric/", first + 1), std::string::npos) << refused.message();
}

TEST_F(CommandsTest, RosterWhosePasswordsCannotBeWrittenAddsNobody) {
  const std::filesystem::path csv = folder_.path() / "roster.csv";
  ASSERT_TRUE(
      WriteFileDurably(csv, AsBytes("login,display_name,role,cohort\nada,Ada,student,\n")).ok());
  RosterCommand roster;
  roster.data = Data();
  roster.file = csv;
  roster.passwords = folder_.path() / "nowhere" / "passwords.csv";
  EXPECT_FALSE(ImportRoster(roster).ok());
  EXPECT_TRUE(OpenData()->people.People()->empty());
  roster.passwords = folder_.path() / "passwords.csv";
  ASSERT_TRUE(ImportRoster(roster).ok());
  const std::string passwords(AsText(*ReadFile(roster.passwords)));
  EXPECT_NE(passwords.find("\nada,Ada,,"), std::string::npos);
  EXPECT_EQ(passwords.find('\r'), std::string::npos) << "a shell reads it line by line";
}

TEST_F(CommandsTest, PublishingSaysOnStandardErrorWhatItDoes) {
  NewExercise exercise;
  exercise.scene = "builtin:block";
  exercise.name = "cross";
  exercise.voxel_um = 500;
  ::testing::internal::CaptureStderr();
  ASSERT_TRUE(PublishExercise(Data(), exercise).ok());
  EXPECT_EQ(::testing::internal::GetCapturedStderr(),
            "loading the tooth of builtin:block\npublishing cross-block\nchecking cross-block\n");
}

TEST_F(CommandsTest, RetentionWithoutDaysTakesNoRuleAway) {
  { auto store = OpenData(); }
  ASSERT_TRUE(Retention({Data(), "recordings", 730, false}).ok());
  Status refused = Retention({Data(), "recordings", std::nullopt, false});
  EXPECT_EQ(refused.field(), "days");
  EXPECT_EQ(OpenData()->retention.RetentionRules()->size(), 1u);
}

TEST_F(CommandsTest, IdentityIsMadeOnce) {
  OpenData();
  auto first = EnsureIdentity(Data());
  auto again = EnsureIdentity(Data());
  ASSERT_TRUE(first.ok() && again.ok());
  EXPECT_EQ(first->fingerprint, again->fingerprint);
  EXPECT_EQ(first->ticket_key.public_key, again->ticket_key.public_key);
  auto mode = std::filesystem::status(Data() / "ticket.key").permissions();
  EXPECT_EQ(mode & std::filesystem::perms::all,
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

TEST_F(CommandsTest, IdentityOfAnotherServerIsTakenIntoAFolderThatKeepsOthersOut) {
  OpenData();
  const auto theirs = EnsureIdentity(Data());
  ASSERT_TRUE(theirs.ok());
  const test::TempFolder parent;
  const auto open = std::filesystem::perms(0755);
  const auto mode = [](const std::filesystem::path& path) {
    return std::filesystem::status(path).permissions() & std::filesystem::perms::all;
  };
  const auto empty = parent.path() / "empty", used = parent.path() / "used";
  for (const auto& folder : {empty, used}) {
    std::filesystem::create_directory(folder);
    std::filesystem::permissions(folder, open);
  }
  ASSERT_TRUE(WriteFileDurably(used / "thesis.txt", AsBytes("x"), 0644).ok());
  EXPECT_EQ(TakeIdentity(used, Data()).code(), Code::kForbidden);
  EXPECT_FALSE(std::filesystem::exists(used / "ticket.key"));
  ASSERT_TRUE(TakeIdentity(empty, Data()).ok());
  EXPECT_EQ(mode(empty), std::filesystem::perms(0700));
  EXPECT_EQ(mode(empty / "station.key"), std::filesystem::perms(0600));
  EXPECT_EQ(EnsureIdentity(empty)->fingerprint, theirs->fingerprint);
  EXPECT_TRUE(TakeIdentity(empty, Data()).ok()) << "again";
  ASSERT_TRUE(WriteFileDurably(empty / "station.crt", AsBytes("another"), 0600).ok());
  EXPECT_EQ(TakeIdentity(empty, Data()).code(), Code::kConflict);
  EXPECT_EQ(TakeIdentity(parent.path() / "new", used).code(), Code::kNotFound);
}

}  // namespace
}  // namespace enamel::server::app
