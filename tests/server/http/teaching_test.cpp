#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <future>
#include <map>
#include <set>
#include <thread>

#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/volume_blob.h"
#include "common/scoring/score.h"
#include "server/training/ticket_rules.h"
#include "tests/server/http/running_server.h"

// Exercises, assignments, releases, overrides, remarks, appeals and jobs, over the wire.
namespace enamel::server::http {
namespace {

namespace json = boost::json;

const scene::RubricCriterion kTime{"time_s", "Time", "s", 20, {{300, 1}, {600, 0}}, "too slow", {}};

class TeachingTest : public testing::Test {
 protected:
  TeachingTest() {
    for (const char* login : {"sam", "tom", "ada", "ben", "root"}) {
      visitors_.emplace(login, Visitor(server_.port(), login));
    }
  }
  Visitor& By(const std::string& login) { return visitors_.at(login); }
  // With If-Match when `etag` is not empty.
  RawResponse Send(const std::string& login, const std::string& method, const std::string& target,
                   const json::value& body, const std::string& etag = "") {
    Visitor& visitor = By(login);
    std::string headers =
        "X-Enamel-Csrf: " + visitor.csrf + "\r\nContent-Type: application/json\r\n";
    if (!etag.empty()) headers += "If-Match: " + etag + "\r\n";
    return visitor.Send(method, target, headers, body.is_null() ? "" : json::serialize(body));
  }
  RawResponse Post(const std::string& login, const std::string& target,
                   const json::value& body = {}, const std::string& etag = "") {
    return Send(login, "POST", target, body, etag);
  }
  std::string Scored(const std::string& rest = "") const {
    return "/api/v1/attempts/" + school_.sams_scored.Text() + rest;
  }
  json::object Terms(const Uuid& cohort) const {
    return {{"exercise", "class-1-occlusal"}, {"cohort_id", cohort.Text()}};
  }
  // Graded work can be assigned.
  void HaveReference() {
    auto reference = school_.store->references.AddReference(school_.toms_scored, "Dr. Vega", true,
                                                            {school_.ben, "page"});
    ASSERT_TRUE(reference.ok()) << reference.status().message();
  }
  json::value SamsAttempt(const std::string& login) { return Parsed(By(login).Get(Scored())); }
  static bool May(const json::value& attempt, const char* what) {
    const auto& may = attempt.at("may").as_array();
    return std::ranges::find(may, json::value(what)) != may.end();
  }

  School school_;
  RunningServer server_{school_};
  std::map<std::string, Visitor> visitors_;
};

// A block with a device that carries its exercises, as the program makes them.
class DraftTest : public TeachingTest {
 protected:
  DraftTest() {
    scene::BuiltScene built = *scene::BuildBuiltinScene("block", 150'000);
    Sha256 volume = *school_.store->blobs.PutBlob(scene::EncodeVolume(built.volume));
    Sha256 content = *school_.store->blobs.PutBlob(AsBytes(scene::ToJson(built.scene)));
    const Actor by{{}, "test"};
    EXPECT_TRUE(
        school_.store->scenes.PutScene({built.scene.name, built.scene.title, content, volume}, by)
            .ok());
    for (const scene::DeviceProfile& profile : scene::BuiltinProfiles()) {
      Sha256 blob = *school_.store->blobs.PutBlob(AsBytes(scene::ToJson(profile)));
      EXPECT_TRUE(school_.store->profiles.PutProfile({profile.name, profile.title, blob}, by).ok());
    }
    document_ = scene::ClassOneExercise(built.scene, content);
  }
  json::value Document() const { return json::parse(scene::ToJson(document_)); }

  scene::Exercise document_;
};

TEST_F(DraftTest, DraftIsPutReplacedPublishedAndOfferedByAnAssignment) {
  document_.graded = false;
  RawResponse put = Post("ben", "/api/v1/exercises", Document());
  ASSERT_EQ(put.status, 201) << put.body;
  json::value draft = Parsed(put);
  EXPECT_EQ(draft.at("state"), "draft");
  EXPECT_EQ(draft.at("version"), 0);
  std::string path = "/api/v1/exercises/" + std::string(draft.at("id").as_string());
  EXPECT_EQ(By("tom").Get(path).status, 404) << "students see no drafts";
  EXPECT_EQ(By("ada").Get(path).status, 404) << "nor do others until it is shared";
  EXPECT_EQ(By("root").Get(path).status, 200) << "admins see all";

  document_.title = "Another title";
  RawResponse without = Send("ben", "PUT", path, Document());
  EXPECT_EQ(without.status, 428) << without.body;
  RawResponse replaced = Send("ben", "PUT", path, Document(), put.headers["etag"]);
  ASSERT_EQ(replaced.status, 200) << replaced.body;
  RawResponse stale = Send("root", "PUT", path, Document(), put.headers["etag"]);
  EXPECT_EQ(stale.status, 412);
  EXPECT_EQ(Parsed(stale).at("current").at("title"), "Another title");
  EXPECT_EQ(stale.headers["etag"], replaced.headers["etag"]);

  RawResponse published = Send("ben", "POST", path + "/publish", {}, replaced.headers["etag"]);
  ASSERT_EQ(published.status, 200) << published.body;
  EXPECT_EQ(Parsed(published).at("version"), 1);
  EXPECT_EQ(By("tom").Get(path).status, 404) << "assigned to nobody yet";
  json::object terms{{"exercise", document_.name}, {"cohort_id", school_.cohort_b.Text()}};
  ASSERT_EQ(Post("ben", "/api/v1/assignments", terms).status, 201);
  EXPECT_EQ(By("tom").Get(path).status, 200);
  EXPECT_EQ(By("tom").Get(path + "/document").body, scene::ToJson(document_));
  EXPECT_EQ(Send("ben", "DELETE", path, {}, published.headers["etag"]).status, 409);

  EXPECT_EQ(Post("ben", path + "/retire", {{"reason", "a\u001b[2J"}}).status, 400);
  EXPECT_EQ(Post("ben", path + "/retire", {{"reason", "another one is better"}}).status, 204);
  EXPECT_EQ(By("tom").Get(path).status, 200) << "what is assigned can be finished";
  json::value mine = Parsed(By("tom").Get("/api/v1/assignments")).at("assignments").at(0);
  EXPECT_EQ(mine.at("exercise").at("retired"), true);
  EXPECT_EQ(mine.at("mine").at("refusal"), "");
  EXPECT_EQ(Post("ben", "/api/v1/assignments", terms).status, 400) << "and assigned no more";
  RawResponse offered = Post("ben", path + "/offer");
  EXPECT_EQ(offered.status, 200) << offered.body;
  EXPECT_EQ(Parsed(offered).at("state"), "published");
  EXPECT_EQ(Post("ben", path + "/offer").status, 409);
  EXPECT_EQ(Post("ben", path + "/retire", {{"reason", "another one is better"}}).status, 204);
  json::value versions = Parsed(By("ben").Get(path + "/versions"));
  EXPECT_EQ(versions.at("versions").at(0).at("state"), "retired");
}

TEST_F(DraftTest, DryRunSaysWhatIsWrongAndStoresNothing) {
  EXPECT_EQ(Post("ben", "/api/v1/exercises?dry_run=true", Document()).status, 200);
  EXPECT_TRUE(
      Parsed(By("ben").Get("/api/v1/exercises?state=draft")).at("exercises").as_array().empty());
  document_.rubric.criteria = {kTime};
  document_.rubric.criteria.front().unit = "N";
  RawResponse wrong = Post("ben", "/api/v1/exercises?dry_run=true", Document());
  EXPECT_EQ(wrong.status, 400);
  const std::string field(Parsed(wrong).at("error").at("field").as_string());
  EXPECT_TRUE(field.starts_with("rubric.criteria[0]")) << field;
  EXPECT_EQ(Post("ben", "/api/v1/exercises?dry_run=maybe", Document()).status, 400);
}

TEST_F(DraftTest, DryRunRefusesGradedWorkInVoxelsTooCoarseForItsBurAndWarnsOfPractice) {
  document_.bur_shape = cutting::BurShape::kInvertedCone;
  document_.bur_radius_um = 600;
  document_.bur_length_um = 1200;
  document_.bur_narrow_radius_um = 400;
  const RawResponse refused = Post("ben", "/api/v1/exercises?dry_run=true", Document());
  EXPECT_EQ(refused.status, 400) << refused.body;
  EXPECT_EQ(Parsed(refused).at("error").at("field"), "bur.radius_um");
  const std::string coarse = "voxels of 150 um are too coarse for the bur (inverted_cone";
  EXPECT_NE(refused.body.find(coarse), std::string::npos) << refused.body;
  document_.graded = false;
  const RawResponse warned = Post("ben", "/api/v1/exercises?dry_run=true", Document());
  EXPECT_EQ(warned.status, 200) << warned.body;
  EXPECT_NE(warned.body.find(coarse), std::string::npos) << warned.body;
}

TEST_F(DraftTest, TrialScoresTheTargetCutExactlyAndAnUntouchedTooth) {
  document_.rubric.criteria = {kTime};
  document_.rubric.criteria.front().map = {{0, 0.25}};  // never more than a quarter
  const RawResponse begun = Post("ben", "/api/v1/exercise-trials", Document());
  ASSERT_EQ(begun.status, 201) << begun.body;
  const std::string path =
      "/api/v1/exercise-trials/" + std::string(Parsed(begun).at("id").as_string());
  json::value trial = Parsed(begun);
  while (trial.at("state") == "waiting" || trial.at("state") == "working") {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    trial = Parsed(By("ben").Get(path));
  }
  ASSERT_EQ(trial.at("state"), "done") << trial;
  EXPECT_LT(trial.at("exact").at("score").to_number<double>(), 100);
  const json::value& lost = trial.at("exact").at("lost").at(0);
  EXPECT_EQ(lost.at("name").as_string(), kTime.metric);
  EXPECT_DOUBLE_EQ(lost.at("points").to_number<double>(), 0.75 * kTime.points);
  EXPECT_EQ(trial.at("untouched").at("score").to_number<double>(), 0);
  EXPECT_EQ(By("ada").Get(path).status, 404) << "it is ben's";
  EXPECT_EQ(Send("ben", "DELETE", path, nullptr).status, 204);
  EXPECT_EQ(By("ben").Get(path).status, 404);
  EXPECT_TRUE(
      Parsed(By("ben").Get("/api/v1/exercises?state=draft")).at("exercises").as_array().empty());
}

TEST_F(DraftTest, EverythingThatIsMeasuredCanBeChosen) {
  const json::value answer = Parsed(By("ben").Get("/api/v1/scoring-metrics"));
  const json::array& metrics = answer.at("metrics").as_array();
  ASSERT_EQ(metrics.size(), scoring::Metrics().size());
  EXPECT_EQ(metrics[0].at("name").as_string(), scoring::Metrics()[0].name);
  EXPECT_EQ(metrics[0].at("unit").as_string(), scoring::Metrics()[0].unit);
}

TEST_F(DraftTest, InstructorsExerciseIsForOthersOnlyWhenSharedAndThenToUseAndNotToChange) {
  RawResponse put = Post("ben", "/api/v1/exercises", Document());
  std::string path = "/api/v1/exercises/" + std::string(Parsed(put).at("id").as_string());
  ASSERT_EQ(Send("ben", "POST", path + "/publish", {}, put.headers["etag"]).status, 200);
  const char* published = "/api/v1/exercises?state=published";
  EXPECT_EQ(Parsed(By("ada").Get(published)).at("exercises").as_array().size(), 1u);
  EXPECT_EQ(By("ada").Get(path).status, 404);
  RawResponse taken = Post("ada", "/api/v1/exercises", Document());
  EXPECT_EQ(taken.status, 403) << taken.body;
  EXPECT_EQ(Parsed(taken).at("error").at("field"), "name");
  EXPECT_NE(taken.body.find("Person ben"), std::string::npos) << taken.body;

  EXPECT_EQ(Send("ada", "PUT", path + "/sharing", {{"shared", true}}).status, 404);
  EXPECT_EQ(Send("ben", "PUT", path + "/sharing", {{"shared", "yes"}}).status, 400);
  RawResponse shared = Send("ben", "PUT", path + "/sharing", {{"shared", true}});
  ASSERT_EQ(shared.status, 200) << shared.body;
  EXPECT_EQ(Parsed(shared).at("shared"), true);
  EXPECT_EQ(Parsed(By("ada").Get(published)).at("exercises").as_array().size(), 2u);
  json::value seen = Parsed(By("ada").Get(path));
  EXPECT_EQ(seen.at("owner").at("display_name"), "Person ben");
  EXPECT_EQ(seen.at("may"), (json::array{"assign"}));
  EXPECT_EQ(Parsed(By("ben").Get(path)).at("may"), (json::array{"change", "assign"}));
  EXPECT_EQ(Post("ada", path + "/retire").status, 403);
  EXPECT_EQ(Send("ada", "PUT", path + "/sharing", {{"shared", false}}).status, 403);

  json::object to_ada{{"owner_id", school_.ada.Text()}};
  EXPECT_EQ(Send("ben", "PUT", path + "/sharing", {{"owner_id", school_.sam.Text()}}).status, 400);
  ASSERT_EQ(Send("ben", "PUT", path + "/sharing", to_ada).status, 200);
  EXPECT_EQ(Post("ben", path + "/retire").status, 403);
  EXPECT_EQ(Post("ada", path + "/retire").status, 204);
}

TEST_F(TeachingTest, WhatHasNoReferenceIsAssignedAsPracticeOnly) {
  json::object terms = Terms(school_.cohort_a);
  auto refused = [](const RawResponse& response) {
    EXPECT_EQ(response.status, 409) << response.body;
    EXPECT_EQ(Parsed(response).at("error").at("field"), "reference") << response.body;
  };
  refused(Post("ada", "/api/v1/assignments", terms));
  school_.OwnExercise({school_.ada, "page"}, "practice", true, false);
  terms["exercise"] = "practice";
  RawResponse practice = Post("ada", "/api/v1/assignments", terms);
  ASSERT_EQ(practice.status, 201) << practice.body;
  std::string path = "/api/v1/assignments/" + std::string(Parsed(practice).at("id").as_string());
  terms["exam"] = true;
  refused(Post("ada", "/api/v1/assignments", terms));
  refused(Send("ada", "PUT", path, terms, practice.headers["etag"]));
  refused(Send("ada", "PUT", path, Terms(school_.cohort_a), practice.headers["etag"]));

  // Existing assignments can still be ended.
  const AssignmentRow offered =
      school_.store->assignments.Assignments({.cohort = school_.cohort_a})->front();
  ASSERT_EQ(offered.exercise, "class-1-occlusal");
  json::object ended = Terms(school_.cohort_a);
  ended["due_ms"] = 1000;
  EXPECT_EQ(Send("ada", "PUT", "/api/v1/assignments/" + offered.id.Text(), ended, "\"1\"").status,
            200);
}

TEST_F(TeachingTest, AssignmentIsMovedToAnotherVersionByWhoSaidSoAndHasSeenIt) {
  HaveReference();
  const Actor ada{school_.ada, "page"};
  ExerciseRow first = school_.OwnExercise(ada, "hers", true, false);
  json::object terms = Terms(school_.cohort_a);
  terms["exercise"] = "hers";
  RawResponse made = Post("ada", "/api/v1/assignments", terms);
  std::string path = "/api/v1/assignments/" + std::string(Parsed(made).at("id").as_string());
  school_.RecordingAttempt(school_.sam, [&](AttemptRow& row) {
    row.exercise = first.id;
    row.assignment = *Uuid::Parse(Parsed(made).at("id").as_string());
  });
  ExerciseRow second = first;
  second.title = "Another title";
  second.content = *school_.store->blobs.PutBlob(AsBytes("{}"));
  second = *school_.store->exercises.PutDraft(second, ada);
  second = *school_.store->exercises.PublishDraft(second.id, second.revision, ada);

  json::value seen = Parsed(By("sam").Get(path));
  EXPECT_EQ(seen.at("exercise").at("version"), 1) << "as it was assigned";
  EXPECT_EQ(std::string(seen.at("exercise").at("id").as_string()), first.id.Text());
  EXPECT_EQ(seen.at("exercise").at("newest_version"), 2);
  json::object to{{"exercise_id", second.id.Text()}};
  EXPECT_EQ(Post("sam", path + "/move", to, "\"1\"").status, 403);
  EXPECT_EQ(Post("ben", path + "/move", to, "\"1\"").status, 404);
  RawResponse look = Post("ada", path + "/move?dry_run=true", to);
  ASSERT_EQ(look.status, 200) << look.body;
  EXPECT_EQ(Parsed(look).at("moved"), false);
  EXPECT_EQ(Parsed(look).at("attempts"), 1);
  EXPECT_EQ(Parsed(look).at("tickets"), 0);
  EXPECT_EQ(Parsed(look).at("assignment").at("exercise").at("version"), 1);
  EXPECT_EQ(Post("ada", path + "/move", to).status, 428);
  EXPECT_EQ(Post("ada", path + "/move", to, "\"7\"").status, 412);
  EXPECT_EQ(Post("ada", path + "/move", {{"exercise_id", school_.exercise.Text()}}, "\"1\"").status,
            400)
      << "another exercise";
  RawResponse moved = Post("ada", path + "/move", to, look.headers["etag"]);
  ASSERT_EQ(moved.status, 200) << moved.body;
  EXPECT_EQ(Parsed(moved).at("moved"), true);
  seen = Parsed(By("sam").Get(path));
  EXPECT_EQ(seen.at("exercise").at("version"), 2);
  EXPECT_EQ(seen.at("exercise").at("title"), "Another title");
  EXPECT_EQ(By("ada").Get(path).headers["etag"], moved.headers["etag"]);
}

TEST_F(TeachingTest, AnothersPrivateExerciseIsNotAssigned) {
  const ExerciseRow hers = school_.OwnExercise({school_.ada, "page"}, "hers", true, false);
  json::object terms = Terms(school_.cohort_b);
  terms["exercise"] = "hers";
  RawResponse refused = Post("ben", "/api/v1/assignments", terms);
  EXPECT_EQ(refused.status, 400);
  EXPECT_EQ(Parsed(refused).at("error").at("field"), "exercise");
  ASSERT_TRUE(school_.store->exercises.ShareExercise(hers.id, {true, {}}, {{}, "test"}).ok());
  EXPECT_EQ(Post("ben", "/api/v1/assignments", terms).status, 201);
}

TEST_F(TeachingTest, StudentIsNotToldWhoseAnExerciseIs) {
  const Uuid hers = school_.OwnExercise({school_.ada, "page"}, "hers", true, false).id;
  ASSERT_EQ(Post("ada", "/api/v1/assignments",
                 {{"exercise", "hers"}, {"cohort_id", school_.cohort_a.Text()}})
                .status,
            201);
  json::value seen = Parsed(By("sam").Get("/api/v1/exercises/" + hers.Text()));
  EXPECT_TRUE(seen.at("owner").is_null());
  EXPECT_TRUE(seen.at("may").as_array().empty());
}

TEST_F(DraftTest, WholeDocumentIsShown) {
  document_.bur_shape = cutting::BurShape::kPear;
  document_.bur_narrow_radius_um = 300;
  document_.bur_shank_radius_um = 800;
  document_.bur_neck_um = 900;
  document_.handpiece = {2000, 300, 50000};
  document_.touch_cues = {300, 0, 150, 900};
  document_.isolation = scene::Isolation::kRubberDam;
  document_.time_limit_s = 600;
  Sha256 content = *school_.store->blobs.PutBlob(AsBytes(scene::ToJson(document_)));
  ExerciseRow row;
  row.name = document_.name;
  row.title = document_.title;
  row.content = content;
  row.scene = document_.scene;
  row = *school_.store->exercises.PublishExercise(row, school_.cohort_a, {{}, "test"});
  json::value shown = Parsed(By("sam").Get("/api/v1/exercises/" + row.id.Text()));
  EXPECT_EQ(shown.at("burs").at(0).at("shape"), "pear");
  EXPECT_EQ(shown.at("burs").at(0).at("narrow_radius_um"), 300);
  EXPECT_EQ(shown.at("burs").at(0).at("shank_radius_um"), 800);
  EXPECT_EQ(shown.at("burs").at(0).at("neck_um"), 900);
  EXPECT_EQ(shown.at("handpiece").at("stall_un_m"), 2000);
  EXPECT_EQ(shown.at("touch_cues").at("contact_mn"), 300);
  EXPECT_EQ(shown.at("touch_cues").at("chatter_mn"), 0);
  EXPECT_EQ(shown.at("touch_cues").at("energy_uj"), 150);
  EXPECT_EQ(shown.at("touch_cues").at("power_uw"), 900);
  EXPECT_EQ(shown.at("rubber_dam"), true);
  EXPECT_EQ(shown.at("time_limit_s"), 600);
  EXPECT_EQ(shown.at("rate_hz"), document_.rate_hz);
  EXPECT_EQ(shown.at("target").at("landmark"), document_.target.landmark.c_str());
  EXPECT_EQ(json::serialize(shown.at("target").at("landmark_um")), "[0,0,5000]");
  EXPECT_TRUE(shown.at("target").at("tooth").is_null()) << "a block";
  EXPECT_EQ(shown.at("target").at("up"), "occlusal");
  EXPECT_EQ(shown.at("rubric").at("name"), document_.rubric.name.c_str());

  scene::Scene turned = *scene::SceneFromJson(AsText(*school_.store->blobs.GetBlob(row.scene)));
  turned.tooth = 46;
  turned.up = scene::Up::kBuccal;
  row.id = {};
  row.name = document_.name = "turned";
  row.scene = document_.scene = *school_.store->blobs.PutBlob(AsBytes(scene::ToJson(turned)));
  ASSERT_TRUE(
      school_.store->scenes.PutScene({"turned", "Turned", row.scene, turned.volume}, {{}, "test"})
          .ok());
  row.content = *school_.store->blobs.PutBlob(AsBytes(scene::ToJson(document_)));
  row = *school_.store->exercises.PublishExercise(row, school_.cohort_a, {{}, "test"});
  shown = Parsed(By("sam").Get("/api/v1/exercises/" + row.id.Text()));
  EXPECT_EQ(shown.at("target").at("tooth"), 46);
  EXPECT_EQ(shown.at("target").at("up"), "buccal");
}

TEST_F(DraftTest, DocumentsThatCannotBeDoneAreRefusedWithTheField) {
  struct Bad {
    std::function<void(scene::Exercise&)> spoil;
    std::string field;
  };
  const Bad bads[] = {
      {[](scene::Exercise& e) { e.scene = HashSha256(AsBytes("other")); }, "scene_sha256"},
      {[](scene::Exercise& e) {
         e.rubric.criteria = {kTime};
         e.rubric.criteria[0].metric = "charm";
       },
       "rubric.criteria[0].metric"},
      {[](scene::Exercise& e) { e.rubric.prices[0].of = "charm"; }, "rubric.prices[0].of"},
  };
  for (const Bad& bad : bads) {
    scene::Exercise spoilt = document_;
    bad.spoil(spoilt);
    RawResponse refused = Post("ada", "/api/v1/exercises", json::parse(scene::ToJson(spoilt)));
    EXPECT_EQ(refused.status, 400) << refused.body;
    EXPECT_EQ(std::string(Parsed(refused).at("error").at("field").as_string()), bad.field)
        << refused.body;
  }
  json::value unknown = Document();
  unknown.as_object()["colour"] = "blue";
  EXPECT_EQ(Post("ada", "/api/v1/exercises", unknown).status, 400);
  scene::Exercise fast = document_;
  fast.rate_hz = 20000;
  RawResponse refused = Post("ada", "/api/v1/exercises", json::parse(scene::ToJson(fast)));
  EXPECT_EQ(refused.status, 400) << "no device goes that fast: " << refused.body;
  EXPECT_EQ(Post("sam", "/api/v1/exercises", Document()).status, 403);
  EXPECT_EQ(Send("ada", "POST", "/api/v1/exercises", "text").status, 400);
}

TEST_F(DraftTest, PictureBeforeTheCutIsMadeOnceAndTheSameForAll) {
  json::value draft = Parsed(Post("ada", "/api/v1/exercises", Document()));
  std::string path =
      "/api/v1/exercises/" + std::string(draft.at("id").as_string()) + "/initial-surface";
  RawResponse first = By("ada").Get(path);
  ASSERT_EQ(first.status, 200) << first.body;
  EXPECT_EQ(first.headers["content-type"], "application/octet-stream");
  EXPECT_EQ(first.body.substr(0, 4), "ENTM");
  EXPECT_EQ(static_cast<uint8_t>(first.body.at(6)) & 1, 0) << "no deviation";
  EXPECT_EQ(By("root").Get(path).body, first.body);
  EXPECT_EQ(By("sam").Get(path).status, 404);
}

TEST_F(DraftTest, PictureThatIsBeingMadeHoldsNobodyElseUp) {
  json::value draft = Parsed(Post("ada", "/api/v1/exercises", Document()));
  std::string path =
      "/api/v1/exercises/" + std::string(draft.at("id").as_string()) + "/initial-surface";
  std::promise<void> under_way, go_on;
  std::atomic<bool> first_write{true};
  school_.before_write = [&, may_go_on = go_on.get_future().share()] {
    if (first_write.exchange(false)) {
      under_way.set_value();
      may_go_on.wait();
    }
    return false;
  };
  RawResponse made;
  std::thread maker([&] { made = By("ada").Get(path); });
  EXPECT_EQ(under_way.get_future().wait_for(std::chrono::seconds(60)), std::future_status::ready);
  RawResponse meanwhile = By("root").Get(path);
  go_on.set_value();
  maker.join();
  EXPECT_EQ(meanwhile.status, 503) << meanwhile.body;
  EXPECT_NE(meanwhile.headers["retry-after"], "");
  EXPECT_EQ(made.status, 200) << made.body;
  EXPECT_EQ(By("root").Get(path).body, made.body);
}

TEST_F(TeachingTest, ExercisesAreListedByStateForWhoEditsThem) {
  EXPECT_EQ(By("ada").Get("/api/v1/exercises?state=draft").status, 200);
  EXPECT_EQ(
      Parsed(By("ben").Get("/api/v1/exercises?state=published")).at("exercises").as_array().size(),
      1u);
  EXPECT_TRUE(Parsed(By("ben").Get("/api/v1/exercises")).at("exercises").as_array().empty());
  EXPECT_EQ(By("sam").Get("/api/v1/exercises?state=draft").status, 403);
  EXPECT_EQ(By("ada").Get("/api/v1/exercises?state=lost").status, 400);
}

TEST_F(TeachingTest, InstructorAssignsToOwnCohortsAndAdminToEverybody) {
  HaveReference();
  EXPECT_EQ(Post("sam", "/api/v1/assignments", Terms(school_.cohort_a)).status, 403);
  EXPECT_EQ(Post("ben", "/api/v1/assignments", Terms(school_.cohort_a)).status, 403);
  json::object everybody{{"exercise", "class-1-occlusal"}};
  EXPECT_EQ(Post("ada", "/api/v1/assignments", everybody).status, 403);
  EXPECT_EQ(Post("root", "/api/v1/assignments", everybody).status, 201);
  json::object exam = Terms(school_.cohort_a);
  exam["exam"] = true;
  exam["attempt_limit"] = 2;
  exam["opens_ms"] = 4'000'000'000'000;
  exam["station_ids"] = json::array{school_.station.Text()};
  RawResponse made = Post("ada", "/api/v1/assignments", exam);
  ASSERT_EQ(made.status, 201) << made.body;
  EXPECT_EQ(Parsed(made).at("stations").at(0).at("name"), "bench-1");
  EXPECT_EQ(Parsed(made).at("cohort").at("name"), "A");
  std::string path = "/api/v1/assignments/" + std::string(Parsed(made).at("id").as_string());
  EXPECT_EQ(By("tom").Get(path).status, 404);
  EXPECT_EQ(By("ben").Get(path).status, 404);
  EXPECT_EQ(By("sam").Get(path).status, 200);

  json::value mine = Parsed(By("sam").Get("/api/v1/assignments"));
  const json::value& first = mine.at("assignments").at(0);
  EXPECT_EQ(first.at("exam"), true) << "exams first";
  EXPECT_EQ(first.at("mine").at("attempts_left"), 2);
  EXPECT_EQ(first.at("mine").at("refusal"), "opens") << json::serialize(first);
  EXPECT_EQ(Parsed(By("ada").Get("/api/v1/assignments")).at("assignments").as_array().size(), 3u);
  EXPECT_EQ(Parsed(By("ben").Get("/api/v1/assignments")).at("assignments").as_array().size(), 1u);
  EXPECT_EQ(Parsed(By("root").Get("/api/v1/assignments?cohort=" + school_.cohort_a.Text()))
                .at("assignments")
                .as_array()
                .size(),
            2u);
}

TEST_F(TeachingTest, AssignmentSaysWhatMayHoldTheTool) {
  HaveReference();
  RawResponse made = Post("ada", "/api/v1/assignments", Terms(school_.cohort_a));
  EXPECT_EQ(Parsed(made).at("hands"), "listed") << "unless somebody allows more";
  const std::string path = "/api/v1/assignments/" + std::string(Parsed(made).at("id").as_string());
  json::object terms = Terms(school_.cohort_a);
  terms["hands"] = "any";
  RawResponse edited = Send("ada", "PUT", path, terms, made.headers["etag"]);
  EXPECT_EQ(Parsed(edited).at("hands"), "any") << edited.body;
  // A client from before there was that term.
  RawResponse again = Send("ada", "PUT", path, Terms(school_.cohort_a), edited.headers["etag"]);
  EXPECT_EQ(Parsed(again).at("hands"), "any") << "what is not said is not changed";
}

TEST_F(TeachingTest, ExamCanRequireASecondPersonAtTheChair) {
  HaveReference();
  json::object terms = Terms(school_.cohort_a);
  EXPECT_FALSE(Parsed(Post("ada", "/api/v1/assignments", terms)).at("sign_off").as_bool());
  terms["exam"] = true;
  terms["sign_off"] = true;
  RawResponse made = Post("ada", "/api/v1/assignments", terms);
  EXPECT_TRUE(Parsed(made).at("sign_off").as_bool()) << made.body;
  const std::string path = "/api/v1/assignments/" + std::string(Parsed(made).at("id").as_string());
  EXPECT_TRUE(Parsed(By("ada").Get(path)).at("sign_off").as_bool());
  terms["sign_off"] = false;
  RawResponse edited = Send("ada", "PUT", path, terms, made.headers["etag"]);
  EXPECT_FALSE(Parsed(edited).at("sign_off").as_bool()) << edited.body;
}

TEST_F(TeachingTest, OutlineOnTheToothIsChosenByTheAssignment) {
  HaveReference();
  json::object terms = Terms(school_.cohort_a);
  EXPECT_EQ(Parsed(Post("ada", "/api/v1/assignments", terms)).at("outline"), "practice");
  terms["outline"] = "always";
  RawResponse made = Post("ada", "/api/v1/assignments", terms);
  EXPECT_EQ(Parsed(made).at("outline"), "always") << made.body;
  const std::string path = "/api/v1/assignments/" + std::string(Parsed(made).at("id").as_string());
  RawResponse edited = Send("ada", "PUT", path, Terms(school_.cohort_a), made.headers["etag"]);
  EXPECT_EQ(Parsed(edited).at("outline"), "always") << "what is not said is not changed";
  terms["outline"] = "never";
  edited = Send("ada", "PUT", path, terms, edited.headers["etag"]);
  EXPECT_EQ(Parsed(edited).at("outline"), "never") << edited.body;
  EXPECT_EQ(Parsed(By("ada").Get(path)).at("outline"), "never");
}

TEST_F(TeachingTest, DevicesAreListedNamedAnewAndTakenOffTheList) {
  const char* kPath = "/api/v1/listed-devices";
  EXPECT_TRUE(Parsed(By("ada").Get(kPath)).at("devices").as_array().empty());
  json::object device{{"name", "hid:1209:0001:A7"}, {"title", "chair 3"}};
  EXPECT_EQ(Post("root", kPath, device).status, 200);
  device["title"] = "chair 4";
  RawResponse listed = Post("root", kPath, device);
  json::value all = Parsed(listed);
  ASSERT_EQ(all.at("devices").as_array().size(), 1u) << listed.body;
  EXPECT_EQ(all.at("devices").at(0).at("title"), "chair 4");
  device["title"] = "";
  EXPECT_EQ(Post("root", kPath, device).status, 400);
  json::object name{{"name", "hid:1209:0001:A7"}};
  EXPECT_EQ(Post("root", std::string(kPath) + "/remove", name).status, 200);
  EXPECT_EQ(Post("root", std::string(kPath) + "/remove", name).status, 404);
}

TEST_F(TeachingTest, StationsAreSetFromHereAndWrongValuesRefused) {
  const std::string path = "/api/v1/station-settings";
  json::object setting{{"name", "language"}, {"value", "fr"}, {"scope", "lab2-*"}};
  RawResponse refused = Post("root", path, setting);
  EXPECT_EQ(refused.status, 400);
  EXPECT_NE(refused.body.find("one of en, de, zh"), std::string::npos) << refused.body;
  setting["value"] = "de";
  setting["scope"] = "lab*2";
  EXPECT_EQ(Post("root", path, setting).status, 400);
  setting["scope"] = "lab2-*";
  setting["fixed"] = true;
  EXPECT_EQ(Post("root", path, setting).status, 200);
  const json::value all = Parsed(Post("root", path, {{"name", "keep-days"}, {"value", "30"}}));
  ASSERT_EQ(all.at("settings").as_array().size(), 2u);
  EXPECT_EQ(all.at("settings").at(0).at("scope"), "*");
  EXPECT_EQ(all.at("settings").at(1).at("value"), "de");
  EXPECT_EQ(all.at("settings").at(1).at("fixed"), true);
  EXPECT_EQ(Post("root", path, {{"name", "data"}, {"value", "/tmp"}}).status, 400);
  EXPECT_EQ(Post("root", path + "/remove", {{"name", "language"}}).status, 404)
      << "for another scope";
  const json::object gone{{"name", "language"}, {"scope", "lab2-*"}};
  EXPECT_EQ(Post("root", path + "/remove", gone).status, 200);
  EXPECT_EQ(Parsed(By("root").Get(path)).at("settings").as_array().size(), 1u);
}

TEST_F(TeachingTest, TermsThatMakeNoSenseAreRefusedWithTheField) {
  HaveReference();
  const std::pair<json::object, std::string> bads[] = {
      {{{"opens_ms", 100}, {"due_ms", 50}}, "due_ms"},
      {{{"attempt_limit", -1}}, "attempt_limit"},
      {{{"attempt_limit", 1.5}}, "attempt_limit"},
      {{{"exam", "yes"}}, "exam"},
      {{{"sign_off", true}}, "sign_off"},
      {{{"station_ids", json::array{school_.station.Text()}}}, "station_ids"},
      {{{"exam", true}, {"station_ids", json::array{"x"}}}, "station_ids"},
      {{{"exam", true}, {"station_ids", json::array{Uuid::New().Text()}}}, "station_ids"},
      {{{"exercise", "no such exercise"}}, "exercise"},
      {{{"cohort_id", 7}}, "cohort_id"},
      {{{"hands", "robots"}}, "hands"},
      {{{"hands", 1}}, "hands"},
      {{{"outline", "sometimes"}}, "outline"},
      {{{"due", 7}}, "due"},
  };
  for (const auto& [change, field] : bads) {
    json::object terms = Terms(school_.cohort_a);
    for (const auto& member : change) terms[member.key()] = member.value();
    RawResponse refused = Post("ada", "/api/v1/assignments", terms);
    EXPECT_GE(refused.status, 400) << json::serialize(terms);
    EXPECT_LT(refused.status, 500) << refused.body;
    EXPECT_EQ(std::string(Parsed(refused).at("error").at("field").as_string()), field)
        << refused.body;
  }
}

TEST_F(TeachingTest, AssignmentIsEditedByWhoHasSeenItLast) {
  HaveReference();
  RawResponse made = Post("ada", "/api/v1/assignments", Terms(school_.cohort_a));
  std::string path = "/api/v1/assignments/" + std::string(Parsed(made).at("id").as_string());
  json::object terms = Terms(school_.cohort_a);
  terms["due_ms"] = 4'000'000'000'000;
  EXPECT_EQ(Send("ada", "PUT", path, terms).status, 428);
  RawResponse edited = Send("ada", "PUT", path, terms, made.headers["etag"]);
  ASSERT_EQ(edited.status, 200) << edited.body;
  EXPECT_EQ(Parsed(edited).at("due_ms"), 4'000'000'000'000);
  RawResponse stale = Send("root", "DELETE", path, {}, made.headers["etag"]);
  EXPECT_EQ(stale.status, 412);
  EXPECT_EQ(Parsed(stale).at("current").at("due_ms"), 4'000'000'000'000);
  EXPECT_EQ(Send("ben", "PUT", path, terms, edited.headers["etag"]).status, 404);
  json::object elsewhere = Terms(school_.cohort_b);
  EXPECT_EQ(Send("ada", "PUT", path, elsewhere, edited.headers["etag"]).status, 403);
  EXPECT_EQ(Send("ada", "DELETE", path, {}, edited.headers["etag"]).status, 204);
  EXPECT_EQ(By("ada").Get(path).status, 404);
}

TEST_F(TeachingTest, ReleaseIsTakenBackAndTheStudentSeesNothingAgain) {
  ASSERT_EQ(By("ada").Judge("POST", Scored(), "/release").status, 204);
  EXPECT_FALSE(SamsAttempt("sam").at("score").is_null());
  EXPECT_EQ(By("sam").Judge("DELETE", Scored(), "/release").status, 403);
  EXPECT_EQ(By("ben").Judge("DELETE", Scored(), "/release").status, 404);
  ASSERT_EQ(By("ada").Judge("DELETE", Scored(), "/release").status, 204);
  EXPECT_TRUE(SamsAttempt("sam").at("score").is_null());
  EXPECT_EQ(By("sam").Get(Scored("/results")).status, 403);
  EXPECT_EQ(By("sam").Get(Scored("/annotations")).status, 403);
}

TEST_F(TeachingTest, OverrideCountsTheComputedScoreStaysAndBothAreShown) {
  json::object better{{"score", 93}, {"reason", "the tooth was cracked"}};
  EXPECT_EQ(By("sam").Judge("PUT", Scored(), "/override", json::serialize(better)).status, 403);
  EXPECT_EQ(By("ben").Judge("PUT", Scored(), "/override", json::serialize(better)).status, 404);
  const RawResponse high =
      Send("ada", "PUT", Scored("/override"), {{"score", 100.9}, {"reason", "x"}});
  EXPECT_EQ(high.status, 400);
  EXPECT_NE(high.body.find("a number of 0 to 100, found 100.9\""), std::string::npos) << high.body;
  EXPECT_EQ(Send("ada", "PUT", Scored("/override"), {{"score", 93}}).status, 400);
  RawResponse made = By("ada").Judge("PUT", Scored(), "/override", json::serialize(better));
  ASSERT_EQ(made.status, 200) << made.body;
  EXPECT_TRUE(SamsAttempt("sam").at("override").is_null()) << "not released";
  By("ada").Judge("POST", Scored(), "/release");
  json::value seen = SamsAttempt("sam");
  EXPECT_EQ(seen.at("score").to_number<double>(), 93);
  EXPECT_EQ(seen.at("computed_score").to_number<double>(), 87.5);
  EXPECT_EQ(seen.at("override").at("reason"), "the tooth was cracked");
  EXPECT_EQ(seen.at("override").at("by"), "Person ada");
  ASSERT_EQ(By("ada").Judge("DELETE", Scored(), "/override").status, 200);
  EXPECT_EQ(SamsAttempt("sam").at("score").to_number<double>(), 87.5);
  json::value audit = Parsed(By("root").Get("/api/v1/audit?limit=1")).at("audit").at(0);
  EXPECT_EQ(audit.at("action"), "attempt.override");
  EXPECT_NE(std::string(audit.at("before").as_string()).find("cracked"), std::string::npos);
}

TEST_F(TeachingTest, WhoJudgesWithoutHavingSeenTheLastJudgementIsToldIt) {
  const std::string seen = By("ada").Get(Scored()).headers["etag"];
  json::object mine{{"score", 90}, {"reason", "careful work"}};
  json::object theirs{{"score", 40}, {"reason", "did not see the first"}};
  EXPECT_EQ(Send("ada", "PUT", Scored("/override"), mine).status, 428);
  EXPECT_EQ(Send("ada", "POST", Scored("/release"), {}).status, 428);
  RawResponse first = Send("ada", "PUT", Scored("/override"), mine, seen);
  ASSERT_EQ(first.status, 200) << first.body;
  EXPECT_NE(first.headers["etag"], seen);
  RawResponse second = Send("root", "PUT", Scored("/override"), theirs, seen);
  ASSERT_EQ(second.status, 412) << second.body;
  EXPECT_EQ(Parsed(second).at("current").at("override").at("reason"), "careful work");
  EXPECT_EQ(second.headers["etag"], first.headers["etag"]);
  EXPECT_EQ(Send("root", "DELETE", Scored("/override"), {}, seen).status, 412);
  EXPECT_EQ(Send("root", "POST", Scored("/release"), {}, seen).status, 412);
  EXPECT_EQ(Send("root", "POST", Scored("/excuse"), {{"reason", "ill"}}, seen).status, 412);
  EXPECT_EQ(Send("root", "PUT", Scored("/override"), theirs, second.headers["etag"]).status, 200);
}

TEST_F(TeachingTest, OfARecordingThatWasRemovedTheScoreStaysAndTheRestSaysWhenItWent) {
  ASSERT_EQ(By("ada").Judge("POST", Scored(), "/release").status, 204);
  while (auto job = *school_.store->jobs.LeaseJob(1, 1000)) {
    ASSERT_TRUE(school_.store->jobs.FinishJob(job->lease, true, "").ok());
    AttemptResult result = *school_.store->results.ResultOf(school_.sams_scored);
    (void)school_.store->results.FinishAttempt(job->attempt, result, {});
  }
  const UnixMs when = school_.now_ms + UnixMs{40} * 24 * 60 * 60 * 1000;
  ASSERT_TRUE(school_.store->retention.SetRetention({"recordings", 1}, Actor{}).ok());
  auto report = school_.store->retention.ApplyRetention(when, false, Actor{});
  ASSERT_TRUE(report.ok()) << report.status().message();
  ASSERT_EQ(SamsAttempt("sam").at("recording_removed_ms").to_number<int64_t>(), when);
  EXPECT_EQ(By("sam").Get(Scored("/score")).status, 200);
  for (const char* part : {"/surface", "/series"}) {
    RawResponse gone = By("sam").Get(Scored(part));
    EXPECT_EQ(gone.status, 409) << gone.body;
    EXPECT_NE(gone.body.find(TimeText(when)), std::string::npos) << gone.body;
    EXPECT_NE(gone.body.find("retention rule"), std::string::npos) << gone.body;
  }
}

TEST_F(TeachingTest, RemarksAreSeenAfterTheReleaseAndChangedByTheirAuthor) {
  json::object remark{{"tick", 500}, {"point_um", {100, -50, 900}}, {"text", "too steep here"}};
  EXPECT_EQ(Post("sam", Scored("/annotations"), remark).status, 403);
  RawResponse made = Post("ada", Scored("/annotations"), remark);
  ASSERT_EQ(made.status, 201) << made.body;
  EXPECT_EQ(By("sam").Get(Scored("/annotations")).status, 403);
  By("ada").Judge("POST", Scored(), "/release");
  json::value seen = Parsed(By("sam").Get(Scored("/annotations"))).at("annotations").at(0);
  EXPECT_EQ(seen.at("text"), "too steep here");
  EXPECT_EQ(seen.at("to_chair"), false);
  EXPECT_EQ(seen.at("point_um").at(1), -50);
  EXPECT_EQ(seen.at("author").at("display_name"), "Person ada");
  EXPECT_EQ(seen.at("mine"), false);
  std::string path = "/api/v1/annotations/" + std::string(seen.at("id").as_string());
  remark["text"] = "steep";
  EXPECT_EQ(Send("root", "PUT", path, remark, made.headers["etag"]).status, 403)
      << "not the author";
  EXPECT_EQ(Send("ben", "PUT", path, remark, made.headers["etag"]).status, 404);
  RawResponse edited = Send("ada", "PUT", path, remark, made.headers["etag"]);
  ASSERT_EQ(edited.status, 200) << edited.body;
  EXPECT_EQ(Send("ada", "PUT", path, remark, made.headers["etag"]).status, 412);
  EXPECT_EQ(Send("ada", "DELETE", path, {}, edited.headers["etag"]).status, 204);
  for (const json::object& bad :
       {json::object{{"tick", -1}, {"text", "x"}}, json::object{{"tick", 1}, {"text", ""}},
        json::object{{"tick", 1}, {"text", "bell \a"}}, json::object{{"text", "x"}},
        json::object{{"tick", 1}, {"text", "x"}, {"point_um", {1, 2}}}}) {
    EXPECT_EQ(Post("ada", Scored("/annotations"), bad).status, 400) << json::serialize(bad);
  }
}

TEST_F(TeachingTest, AppealIsTheStudentsAndItsAnswerTheInstructors) {
  json::object appeal{{"text", "the wall was given"}};
  EXPECT_EQ(Post("sam", Scored("/appeal"), appeal).status, 409) << "not released";
  By("ada").Judge("POST", Scored(), "/release");
  EXPECT_TRUE(May(SamsAttempt("sam"), "appeal"));
  EXPECT_EQ(Post("ada", Scored("/appeal"), appeal).status, 403);
  EXPECT_EQ(Post("tom", Scored("/appeal"), appeal).status, 404);
  RawResponse filed = Post("sam", Scored("/appeal"), appeal);
  ASSERT_EQ(filed.status, 201) << filed.body;
  EXPECT_EQ(Post("sam", Scored("/appeal"), appeal).status, 409) << "once";
  EXPECT_FALSE(May(SamsAttempt("sam"), "appeal"));
  json::value open = Parsed(By("ada").Get("/api/v1/attempts?appeal=open"));
  ASSERT_EQ(open.at("attempts").as_array().size(), 1u);
  EXPECT_TRUE(May(SamsAttempt("ada"), "answer_appeal"));

  json::object answer{{"outcome", "reject"}, {"answer", "it was measured twice"}};
  EXPECT_EQ(Post("sam", Scored("/appeal/answer"), answer).status, 403);
  EXPECT_EQ(Post("ada", Scored("/appeal/answer"), {{"outcome", "maybe"}, {"answer", "x"}}).status,
            400);
  ASSERT_EQ(Post("ada", Scored("/appeal/answer"), answer).status, 200);
  EXPECT_EQ(Post("ada", Scored("/appeal/answer"), answer).status, 409) << "once";
  EXPECT_EQ(SamsAttempt("sam").at("appeal").at("state"), "rejected");
  EXPECT_EQ(SamsAttempt("sam").at("appeal").at("answer"), "it was measured twice");
}

TEST_F(TeachingTest, RegradeKeepsTheEarlierResultBesideTheNewOne) {
  // The run that sealing queued is over.
  while (auto job = *school_.store->jobs.LeaseJob(1, 1000)) {
    ASSERT_TRUE(school_.store->jobs.FinishJob(job->lease, true, "").ok());
  }
  AttemptResult result;
  scoring::ScoreResult score;
  score.score = 87.5;
  result.score = score.score;
  result.score_json = *school_.store->blobs.PutBlob(AsBytes(scoring::ToJson(score)));
  ASSERT_TRUE(school_.store->results.FinishAttempt(school_.sams_scored, result, {}).ok());
  By("ada").Judge("POST", Scored(), "/release");
  ASSERT_EQ(Post("sam", Scored("/appeal"), {{"text", "please"}}).status, 201);
  json::object answer{{"outcome", "regrade"}, {"answer", "we look again"}};
  ASSERT_EQ(Post("ada", Scored("/appeal/answer"), answer).status, 200);
  json::value queued = Parsed(By("root").Get("/api/v1/jobs?state=queued")).at("jobs").at(0);
  EXPECT_EQ(queued.at("cause"), "appeal");
  EXPECT_EQ(queued.at("attempt_id"), school_.sams_scored.Text().c_str());
  auto job = *school_.store->jobs.LeaseJob(1, 1000);
  score.score = result.score = 90;
  result.score_json = *school_.store->blobs.PutBlob(AsBytes(scoring::ToJson(score)));
  ASSERT_TRUE(school_.store->results.FinishAttempt(school_.sams_scored, result, job->lease).ok());
  ASSERT_TRUE(school_.store->jobs.FinishJob(job->lease, true, "").ok());
  EXPECT_EQ(SamsAttempt("ada").at("released"), false) << "another score is released anew";
  EXPECT_EQ(By("sam").Get(Scored("/results")).status, 403);
  ASSERT_EQ(By("ada").Judge("POST", Scored(), "/release").status, 204);
  json::value results = Parsed(By("sam").Get(Scored("/results"))).at("results");
  ASSERT_EQ(results.as_array().size(), 3u);
  EXPECT_EQ(results.at(0).at("cause"), "appeal");
  EXPECT_EQ(results.at(0).at("score").at("score").to_number<double>(), 90);
  EXPECT_EQ(results.at(1).at("score").at("score").to_number<double>(), 87.5);
}

TEST_F(TeachingTest, JobIsCancelledByAnAdminAndQueuedAgainByAnInstructor) {
  json::value jobs = Parsed(By("root").Get("/api/v1/jobs?state=queued")).at("jobs");
  ASSERT_FALSE(jobs.as_array().empty());
  std::string path, attempt;
  for (const json::value& job : jobs.as_array()) {
    if (job.at("attempt_id") != school_.sams_scored.Text().c_str()) continue;
    path = "/api/v1/jobs/" + std::string(job.at("id").as_string()) + "/cancel";
  }
  EXPECT_EQ(Post("ada", path).status, 403);
  EXPECT_EQ(Post("root", path).status, 204);
  EXPECT_EQ(Post("root", path).status, 409);
  EXPECT_EQ(Parsed(By("root").Get("/api/v1/jobs?state=cancelled")).at("jobs").as_array().size(),
            1u);
  EXPECT_EQ(Post("sam", Scored("/rescore")).status, 403);
  RawResponse queued = Post("ada", Scored("/rescore"));
  EXPECT_EQ(queued.status, 202) << queued.body;
  EXPECT_EQ(Post("ada", Scored("/rescore")).status, 409);
  EXPECT_EQ(Post("root", "/api/v1/jobs/" + Uuid::New().Text() + "/cancel").status, 404);
}

TEST_F(TeachingTest, ARubricIsCorrectedOverTheVersionThatWasSeen) {
  ASSERT_TRUE(
      school_.store->exercises.ShareExercise(school_.exercise, {{}, school_.ada}, {{}, "test"})
          .ok());
  const std::string path = "/api/v1/exercises/" + school_.exercise.Text() + "/rubrics";
  EXPECT_EQ(By("sam").Get(path).status, 403);
  json::value versions = Parsed(By("ada").Get(path)).at("rubrics");
  ASSERT_EQ(versions.as_array().size(), 1u);
  json::object rubric = versions.at(0).at("document").as_object();
  const int64_t own = versions.at(0).at("version").as_int64();
  const std::string seen = "\"" + std::to_string(own) + "\"";

  json::object body{{"reason", "one criterion was too strict"}, {"rubric", rubric}};
  RawResponse same = Post("ada", path, body, seen);
  EXPECT_EQ(same.status, 409) << "it says nothing new: " << same.body;
  rubric.at("criteria").at(0).at("points") = 77;
  body["rubric"] = rubric;
  EXPECT_EQ(Post("ada", path, body).status, 428) << "without saying what was corrected";
  EXPECT_EQ(Post("ada", path, body, "\"99\"").status, 412);
  RawResponse published = Post("ada", path, body, seen);
  ASSERT_EQ(published.status, 201) << published.body;
  EXPECT_EQ(Parsed(published).at("version"), own + 1);
  EXPECT_EQ(Parsed(published).at("document").at("version"), own + 1);
  RawResponse late = Post("root", path, body, seen);
  EXPECT_EQ(late.status, 412) << "somebody else was first";
  EXPECT_EQ(Parsed(late).at("current").at("version"), own + 1);

  versions = Parsed(By("ada").Get(path)).at("rubrics");
  ASSERT_EQ(versions.as_array().size(), 2u);
  EXPECT_EQ(versions.at(0).at("reason"), "one criterion was too strict");
  EXPECT_EQ(versions.at(1).at("version"), own);
  json::value shown = Parsed(By("sam").Get("/api/v1/exercises/" + school_.exercise.Text()));
  EXPECT_EQ(shown.at("rubric").at("version"), own + 1);
  EXPECT_EQ(shown.at("rubric").at("criteria").at(0).at("points").to_number<double>(), 77);

  json::array& prices = body["rubric"].at("prices").as_array();
  prices.erase(prices.begin());
  const std::string now = "\"" + std::to_string(own + 1) + "\"";
  RawResponse unpriced = Post("ada", path, body, now);
  EXPECT_EQ(unpriced.status, 400);
  EXPECT_NE(unpriced.body.find("which the current rubric has"), std::string::npos) << unpriced.body;

  body["rubric"].at("criteria").at(0).at("metric") = "no_such_metric";
  RawResponse unknown = Post("ada", path, body, now);
  EXPECT_EQ(unknown.status, 400);
  EXPECT_NE(unknown.body.find("no_such_metric"), std::string::npos) << unknown.body;
}

// The handler answers with the row that it published. The newest version may be another person's by
// then.
TEST_F(TeachingTest, APublishedRubricIsAnsweredWithItselfAlone) {
  const std::string path = "/api/v1/exercises/" + school_.exercise.Text() + "/rubrics";
  json::object first = Parsed(By("root").Get(path)).at("rubrics").at(0).as_object();
  json::object rubric = first.at("document").as_object();
  auto publish = [&](double points, int64_t seen) {
    rubric.at("criteria").at(0).at("points") = points;
    return Post("root", path, json::object{{"reason", std::to_string(points)}, {"rubric", rubric}},
                "\"" + std::to_string(seen) + "\"");
  };
  const int64_t own = first.at("version").as_int64();
  ASSERT_EQ(publish(77, own).status, 201);
  ASSERT_EQ(publish(78, own + 1).status, 201);
  const std::string earlier =
      school_.store->rubrics.Rubrics(school_.exercise)->back().content.Hex();
  ASSERT_TRUE(std::filesystem::remove(school_.folder.path() / "data" / "blobs" /
                                      earlier.substr(0, 2) / earlier));
  const RawResponse published = publish(79, own + 2);
  ASSERT_EQ(published.status, 201) << published.body;
  EXPECT_EQ(Parsed(published).at("version"), own + 3);
  EXPECT_EQ(published.headers.at("etag"), "\"" + std::to_string(own + 3) + "\"");
}

TEST_F(TeachingTest, APreviewShowsOwnCohortsAlone) {
  const std::string path = "/api/v1/exercises/" + school_.exercise.Text() + "/rubrics";
  json::value rubric = Parsed(By("ada").Get(path)).at("rubrics").at(0).at("document");
  auto attempts = [&](const std::string& login) {
    RawResponse preview = Post(login, path + "/preview", rubric.as_object());
    EXPECT_EQ(preview.status, 200) << preview.body;
    std::set<std::string> out;
    const json::value shown = Parsed(preview);
    for (const json::value& row : shown.at("attempts").as_array()) {
      out.insert(std::string(row.at("attempt_id").as_string()));
    }
    return out;
  };
  EXPECT_TRUE(attempts("ada").count(school_.sams_scored.Text()));
  EXPECT_FALSE(attempts("ada").count(school_.toms_scored.Text()));
  EXPECT_TRUE(attempts("ben").count(school_.toms_scored.Text()));
  EXPECT_FALSE(attempts("ben").count(school_.sams_scored.Text()));
  EXPECT_TRUE(attempts("root").count(school_.sams_scored.Text()));
  EXPECT_TRUE(attempts("root").count(school_.toms_scored.Text()));
  EXPECT_EQ(Post("sam", path + "/preview", rubric.as_object()).status, 403);
}

TEST_F(TeachingTest, ACohortIsScoredAgainInOneBatch) {
  const std::vector<JobRow> waiting = *school_.store->jobs.Jobs("queued");
  for (const JobRow& job : waiting) {
    ASSERT_TRUE(school_.store->jobs.CancelJob(job.id, Actor{school_.root, "page"}).ok());
  }
  const std::string path = "/api/v1/cohorts/" + school_.cohort_a.Text() + "/rescore";
  EXPECT_EQ(Post("sam", path).status, 403);
  EXPECT_EQ(Post("ben", path).status, 404);
  RawResponse queued = Post("ada", path, {{"exercise_id", school_.exercise.Text()}});
  ASSERT_EQ(queued.status, 202) << queued.body;
  json::value batch = Parsed(queued);
  EXPECT_EQ(batch.at("queued"), 1);
  EXPECT_EQ(batch.at("left_out"), 0);
  EXPECT_FALSE(batch.at("over").as_bool());
  EXPECT_EQ(Post("ada", path, json::object()).status, 409) << "it waits already";
  EXPECT_EQ(Post("ada", path, {{"exercise_id", Uuid::New().Text()}}).status, 400);

  const std::string one = "/api/v1/batches/" + std::string(batch.at("id").as_string());
  EXPECT_EQ(By("ben").Get(one).status, 404);
  EXPECT_TRUE(Parsed(By("ben").Get("/api/v1/batches")).at("batches").as_array().empty());
  EXPECT_EQ(Parsed(By("ada").Get("/api/v1/batches")).at("batches").as_array().size(), 1u);
  RawResponse cancelled = Post("ada", one + "/cancel");
  EXPECT_EQ(cancelled.status, 200) << cancelled.body;
  EXPECT_EQ(Parsed(cancelled).at("cancelled"), 1);
  EXPECT_TRUE(Parsed(By("ada").Get(one)).at("over").as_bool());
  EXPECT_EQ(Post("ada", one + "/cancel").status, 409);
}

TEST_F(TeachingTest, ReferencesAreListedAndWithdrawnAndNamesShownWithConsentOnly) {
  const std::string list = "/api/v1/exercises/" + school_.exercise.Text() + "/references";
  ASSERT_EQ(Post("ada", Scored("/reference"),
                 {{"dentist", "Dr. Vega"}, {"consent", true}, {"anyway", "a test's"}})
                .status,
            201);
  // Kept from a time when a reference could be without it.
  auto second = school_.store->references.AddReference(
      school_.ScoredAttempt(school_.sam), "Dr. Lyra", false, Actor{school_.ada, "page"});
  ASSERT_TRUE(second.ok()) << second.status().message();
  json::value rows = Parsed(By("sam").Get(list)).at("references");
  EXPECT_TRUE(rows.at(0).at("dentist").is_null());
  EXPECT_EQ(rows.at(1).at("dentist"), "Dr. Vega");
  EXPECT_EQ(Parsed(By("ada").Get(list)).at("references").at(0).at("dentist"), "Dr. Lyra");
  std::string path = "/api/v1/references/" + second->id.Text() + "/withdraw";
  EXPECT_EQ(Post("sam", path).status, 403);
  EXPECT_EQ(Post("ben", path).status, 403);
  EXPECT_EQ(Post("ada", path).status, 204);
  EXPECT_NE(Parsed(By("ada").Get(list)).at("references").at(0).at("withdrawn_ms"), 0);
  EXPECT_EQ(school_.store->references.ReferenceFor(school_.exercise)->value().dentist, "Dr. Vega");
}

TEST_F(TeachingTest, StudentSeesHowTheReferenceWasCutOnceTheComparedScoreIsReleased) {
  const Uuid cut = school_.toms_scored;
  const std::string path = "/api/v1/attempts/" + cut.Text();
  const auto seen_by = [&](const std::string& login) {
    return By(login).Get(path + "/series").status;
  };
  auto reference =
      school_.store->references.AddReference(cut, "Dr. Vega", true, Actor{school_.ben, "page"});
  ASSERT_TRUE(reference.ok()) << reference.status().message();
  const Actor ada{school_.ada, "page"};
  // Scored, released, and compared with nothing.
  ASSERT_EQ(By("ada").Judge("POST", Scored(), "/release").status, 204);
  EXPECT_EQ(seen_by("sam"), 404);
  const Uuid own = school_.ScoredAttempt(
      school_.sam, {}, [&](scoring::ScoreResult& score) { score.reference_attempt = cut.Text(); });
  EXPECT_EQ(seen_by("sam"), 404) << "not released";
  ASSERT_TRUE(school_.store->judging.ReleaseAttempt(own, ada).ok());
  EXPECT_EQ(seen_by("sam"), 200);
  EXPECT_EQ(By("sam").Get(path + "/timeline").status, 503) << "it is being made";
  for (const char* more :
       {"", "/results", "/surface", "/deviation", "/ticks", "/annotations", "/signed-result"})
    EXPECT_EQ(By("sam").Get(path + more).status, 404) << more;
  EXPECT_EQ(seen_by("ada"), 404) << "an instructor of another cohort";
  ASSERT_TRUE(school_.store->references.WithdrawReference(reference->id, ada).ok());
  EXPECT_EQ(seen_by("sam"), 404) << "withdrawn";
  ASSERT_TRUE(school_.store->references.AddReference(cut, "Dr. Vega", false, ada).ok());
  EXPECT_EQ(seen_by("sam"), 404) << "without consent";
}

TEST_F(TeachingTest, ExcuseIsTakenBackByWhoMayExcuse) {
  const std::string path = Scored("");
  ASSERT_EQ(By("ada").Judge("POST", path, "/excuse", R"({"reason":"ill"})").status, 200);
  EXPECT_EQ(By("sam").Judge("DELETE", path, "/excuse").status, 403);
  EXPECT_EQ(Send("ada", "DELETE", Scored("/excuse"), nullptr).status, 428) << "as it was seen";
  const RawResponse back = By("ada").Judge("DELETE", path, "/excuse");
  ASSERT_EQ(back.status, 200) << back.body;
  EXPECT_TRUE(Parsed(back).at("flags").as_array().empty());
  EXPECT_EQ(By("ada").Judge("DELETE", path, "/excuse").status, 200) << "twice is once";
}

TEST_F(TeachingTest, EarlierScoreIsMadeToCountAgainByWhoMayScoreAgain) {
  const std::string path = Scored("");
  const Uuid attempt = *Uuid::Parse(path.substr(path.rfind('/') + 1));
  AttemptResult result = *school_.store->results.ResultOf(attempt);
  result.score = 12;
  ASSERT_TRUE(school_.store->results.FinishAttempt(attempt, result, {}).ok());
  json::value runs = Parsed(By("ada").Get(path + "/results")).at("results");
  EXPECT_EQ(runs.at(0).at("restorable"), false) << "it counts";
  EXPECT_EQ(runs.at(1).at("restorable"), true);
  EXPECT_EQ(By("sam").Judge("POST", path, "/restore-result", R"({"run":1})").status, 403);
  EXPECT_EQ(By("ada").Judge("POST", path, "/restore-result", R"({"run":7})").status, 404);
  EXPECT_EQ(By("ada").Judge("POST", path, "/restore-result", R"({"run":0})").status, 400);
  EXPECT_EQ(By("ada").Judge("POST", path, "/restore-result", R"({})").status, 400);
  const RawResponse back = By("ada").Judge("POST", path, "/restore-result", R"({"run":1})");
  ASSERT_EQ(back.status, 200) << back.body;
  EXPECT_EQ(Parsed(back).at("computed_score"), 87.5);
  EXPECT_EQ(Parsed(By("ada").Get(path + "/results")).at("results").at(0).at("cause"), "restore");
}

TEST_F(TeachingTest, ExamAttemptShowsNothingBeforeItsRelease) {
  AssignmentRow terms;
  terms.exercise = "class-1-occlusal";
  terms.cohort = school_.cohort_a;
  terms.exam = true;
  AssignmentRow exam = *school_.store->assignments.AddAssignment(terms, {{}, "test"});
  Uuid attempt = school_.ScoredAttempt(school_.sam, [&](AttemptRow& row) {
    row.assignment = exam.id;
    row.exam = true;
  });
  std::string path = "/api/v1/attempts/" + attempt.Text();
  json::value seen = Parsed(By("sam").Get(path));
  EXPECT_EQ(seen.at("exam"), true);
  EXPECT_TRUE(seen.at("score").is_null());
  EXPECT_TRUE(seen.at("computed_score").is_null());
  for (const char* part : {"/score", "/surface", "/series", "/results", "/annotations"}) {
    EXPECT_EQ(By("sam").Get(path + part).status, 403) << part;
  }
  EXPECT_EQ(By("sam").Judge("POST", path, "/excuse", R"({"reason":"x"})").status, 403);
  EXPECT_EQ(By("ada").Judge("POST", path, "/excuse", R"({"reason":"power cut"})").status, 200);
  EXPECT_EQ(Parsed(By("ada").Get("/api/v1/attempts?flag=excused")).at("attempts").as_array().size(),
            1u);
  EXPECT_EQ(Parsed(By("ada").Get("/api/v1/attempts?assignment=" + exam.id.Text()))
                .at("attempts")
                .as_array()
                .size(),
            1u);
  std::string release = "/api/v1/assignments/" + exam.id.Text() + "/release";
  EXPECT_EQ(Post("sam", release).status, 403);
  EXPECT_EQ(Post("ben", release).status, 404);
  EXPECT_EQ(Parsed(Post("ada", release)).at("released"), 1);
  EXPECT_EQ(By("sam").Get(path + "/score").status, 200);
}

}  // namespace
}  // namespace enamel::server::http
