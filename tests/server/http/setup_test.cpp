#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>

#include "common/base/file.h"
#include "common/base/unix_time.h"
#include "common/import/prepared_tooth.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/preparation.h"
#include "server/auth/first_admin.h"
#include "server/jobs/builtin_content.h"
#include "server/jobs/tooth_import.h"
#include "tests/server/http/running_server.h"

// The first steps of a new server, over the wire.
namespace enamel::server::http {
namespace {

namespace json = boost::json;

constexpr char kGood[] = "quite a long phrase of mine";

HttpOptions Options(auth::FirstAdmin& first) {
  HttpOptions out;
  out.first_admin = &first;
  return out;
}

RawResponse Make(uint16_t port, const std::string& token, const std::string& password = kGood) {
  return Visitor(port).Post("/api/v1/first-admin",
                            json::serialize(json::object{{"token", token},
                                                         {"login", "head"},
                                                         {"display_name", "Head of School"},
                                                         {"password", password}}));
}

TEST(FirstAdminLinkTest, MakesOneAdminWhoCanSignInAndIsUsedUp) {
  School school(Role::kInstructor);
  auth::FirstAdmin first;
  RunningServer server(school, Options(first));
  const std::string token = first.Offer(enamel::UnixMs());
  EXPECT_EQ(Make(server.port(), std::string(64, 'a')).status, 403);
  RawResponse weak = Make(server.port(), token, "password1");
  EXPECT_EQ(weak.status, 400) << weak.body;
  EXPECT_EQ(Parsed(weak).at("error").at("field"), "password");
  RawResponse made = Make(server.port(), token);
  ASSERT_EQ(made.status, 201) << "what made no account left the link good: " << made.body;
  EXPECT_EQ(Parsed(made).at("role"), "admin");
  EXPECT_EQ(made.body.find(kGood), std::string::npos);
  EXPECT_EQ(Make(server.port(), token).status, 403) << "once";
  RawResponse in = Visitor(server.port())
                       .Post("/api/v1/session",
                             json::serialize(json::object{{"login", "head"}, {"password", kGood}}));
  EXPECT_EQ(in.status, 200) << in.body;
}

TEST(FirstAdminLinkTest, IsNoUseWhereThereIsAnAdmin) {
  School school;
  auth::FirstAdmin first;
  RunningServer server(school, Options(first));
  EXPECT_EQ(Make(server.port(), first.Offer(enamel::UnixMs())).status, 409);
}

// A mesh sent by an admin's page.
class ToothImportTest : public testing::Test {
 protected:
  json::value Begin(const std::string& file_name, size_t bytes, const std::string& unit,
                    const std::string& title, int tooth = 46, const json::object& more = {}) {
    json::object body{{"file_name", file_name},
                      {"bytes", bytes},
                      {"unit", unit},
                      {"title", title},
                      {"tooth", tooth}};
    for (const auto& member : more) body.insert(member);
    last_ = root_.Post("/api/v1/tooth-imports", json::serialize(body));
    return Parsed(last_);
  }
  RawResponse Put(const std::string& id, size_t offset, const std::string& part) {
    return root_.Send(
        "PUT", Path(id) + "/bytes?offset=" + std::to_string(offset),
        "X-Enamel-Csrf: " + root_.csrf + "\r\nContent-Type: application/octet-stream\r\n", part);
  }
  static std::string Path(const std::string& id) { return "/api/v1/tooth-imports/" + id; }
  // Sends a file in parts and waits until it is done or refused.
  json::value Import(const std::string& file_name, const std::string& file, const std::string& unit,
                     const std::string& title, int tooth = 46, const json::object& more = {}) {
    constexpr size_t kPart = 300'000;
    const json::value begun = Begin(file_name, file.size(), unit, title, tooth, more);
    if (last_.status != 201) return begun;
    const std::string id(begun.at("id").as_string());
    for (size_t at = static_cast<size_t>(begun.at("received").to_number<int64_t>());
         at < file.size(); at += kPart) {
      last_ = Put(id, at, file.substr(at, kPart));
      EXPECT_EQ(last_.status, 200) << last_.body;
      if (last_.status != 200) return {};
    }
    // Bounded by the reader's own time.
    for (int i = 0; i < 20'000; ++i) {
      const json::value now = Parsed(root_.Get(Path(id)));
      const std::string state(now.at("state").as_string());
      if (state == "done" || state == "refused") return now;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ADD_FAILURE() << "neither done nor refused";
    return {};
  }
  static std::string Shared(const std::string& name) {
    auto bytes = ReadFile(std::filesystem::path(ENAMEL_SHARED_DATA) / name);
    return bytes.ok() ? std::string(AsText(*bytes)) : std::string();
  }
  // A box of 8 x 8 x 6, as OBJ.
  static std::string Box() {
    return "v 0 0 0\nv 8 0 0\nv 8 8 0\nv 0 8 0\nv 0 0 6\nv 8 0 6\nv 8 8 6\nv 0 8 6\n"
           "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
  }

  // A plate of 30 x 30 mm with a crown of 8 x 8 x 6 in its middle, in steps of a millimetre.
  static std::string Plate() {
    std::string out;
    for (int y = 0; y <= 30; ++y)
      for (int x = 0; x <= 30; ++x) {
        const bool crown = std::abs(x - 15) <= 4 && std::abs(y - 15) <= 4;
        out += "v " + std::to_string(x) + " " + std::to_string(y) + (crown ? " 6\n" : " 0\n");
      }
    for (int y = 0; y < 30; ++y)
      for (int x = 1; x <= 30; ++x) {
        const int a = 31 * y + x;
        out += "f " + std::to_string(a) + " " + std::to_string(a + 1) + " " +
               std::to_string(a + 32) + " " + std::to_string(a + 31) + "\n";
      }
    return out;
  }
  // Around the crown: its middle line, corners between.
  static json::array PlateGum() {
    return {
        json::parse("[[10,10,0],[15,10,0],[20,10,0],[20,15,0],[20,20,0],[15,20,0],[10,20,0],"
                    "[10,15,0]]")};
  }

  School school_;
  RunningServer server_{school_};
  Visitor root_{server_.port(), "root"};
  RawResponse last_;
};

// A person sends the file once, and looks at it as often as needed.
TEST_F(ToothImportTest, ACrownIsCutOutOfAScanThatWasSentOnce) {
  const std::string scan = Plate();
  const json::value jaw =
      Import("plate.obj", scan, "mm", "Sextant", 46, {{"jaw", true}, {"publish", false}});
  ASSERT_EQ(jaw.at("state").as_string(), "done") << json::serialize(jaw);
  EXPECT_TRUE(jaw.at("stance").is_null());
  const json::value id = jaw.at("id");
  EXPECT_EQ(root_.Get(Path(std::string(id.as_string())) + "/surface").body.substr(0, 4), "ENTM");
  EXPECT_EQ(root_.Get(Path(std::string(id.as_string())) + "/start-tooth").status, 404);
  const json::value shown =
      Import("plate.obj", scan, "mm", "Sextant", 46,
             {{"publish", false}, {"mesh_of", id}, {"around", PlateGum()}, {"up", "+z"}});
  ASSERT_EQ(shown.at("state").as_string(), "done") << json::serialize(shown);
  EXPECT_NEAR(shown.at("stance").at("size_mm").at(2).as_double(), 6, 1e-9);
  EXPECT_NEAR(shown.at("stance").at("size_mm").at(0).as_double(), 10, 1e-9);
  Begin("plate.obj", scan.size(), "mm", "Sextant", 46, {{"mesh_of", id}});
  EXPECT_EQ(last_.status, 409) << "not the last one: " << last_.body;
  EXPECT_EQ(Parsed(last_).at("error").at("field").as_string(), "mesh_of");
  const json::value refused =
      Import("plate.obj", scan, "mm", "Sextant", 46,
             {{"publish", false},
              {"mesh_of", shown.at("id")},
              {"around", json::array{json::parse("[[1,1,0],[2,1,0],[1,1,0]]")}}});
  ASSERT_EQ(refused.at("state").as_string(), "refused") << json::serialize(refused);
  EXPECT_EQ(refused.at("problem").at("field").as_string(), "around");
  const json::value put = Import("plate.obj", scan, "mm", "Sextant", 46,
                                 {{"mesh_of", refused.at("id")},
                                  {"around", PlateGum()},
                                  {"up", "+z"},
                                  {"buccal", "+y"},
                                  {"practice", true}});
  ASSERT_EQ(put.at("state").as_string(), "done") << json::serialize(put);
  EXPECT_FALSE(put.at("tooth").at("exercises").as_array().empty());
  Begin("plate.obj", scan.size(), "mm", "Sextant", 46, {{"mesh_of", put.at("id")}});
  EXPECT_EQ(last_.status, 409) << "what was published is not kept: " << last_.body;
}

TEST_F(ToothImportTest, WhatAJawCannotBeIsRefusedWithTheField) {
  auto field = [&](const json::object& more) {
    Begin("plate.obj", 100, "mm", "Sextant", 46, more);
    EXPECT_EQ(last_.status, 400) << last_.body;
    return std::string(Parsed(last_).at("error").at("field").as_string());
  };
  EXPECT_EQ(field({{"jaw", true}}), "jaw") << "published";
  EXPECT_EQ(field({{"jaw", true}, {"publish", false}, {"around", PlateGum()}}), "jaw");
  EXPECT_EQ(field({{"around", json::parse("[[[1,2]]]")}}), "around");
  EXPECT_EQ(field({{"around", json::parse("[[[1,2,1e9]]]")}}), "around");
  EXPECT_EQ(field({{"around", json::parse("[[],[],[],[]]")}}), "around");
  EXPECT_EQ(field({{"around", json::parse("[[[1,2,3],[1,2,4]]]")}}), "around") << "too few points";
  EXPECT_EQ(field({{"around", 3}}), "around");
}

TEST_F(ToothImportTest, AnInstructorImportsOnceAnAdminAllowsItAndSeesNobodyElses) {
  const std::string body = json::serialize(json::object{{"file_name", "crown.obj"},
                                                        {"bytes", Box().size()},
                                                        {"unit", "mm"},
                                                        {"title", "Mine"},
                                                        {"tooth", 46},
                                                        {"practice", true}});
  Visitor ben(server_.port(), "ben");
  EXPECT_EQ(ben.Post("/api/v1/tooth-imports", body).status, 403);
  EXPECT_FALSE(Parsed(ben.Get("/api/v1/session")).at("may_import_teeth").as_bool());
  const Person before = *school_.store->people.PersonById(school_.ben);
  const RawResponse allowed = root_.Send("PATCH", "/api/v1/people/" + before.id.Text(),
                                         "X-Enamel-Csrf: " + root_.csrf +
                                             "\r\nContent-Type: application/json\r\nIf-Match: \"" +
                                             std::to_string(before.revision) + "\"\r\n",
                                         R"({"may_import_teeth":true})");
  ASSERT_EQ(allowed.status, 200) << allowed.body;
  EXPECT_TRUE(Parsed(ben.Get("/api/v1/session")).at("may_import_teeth").as_bool())
      << "the session goes on";
  const json::value others = Begin("crown.obj", Box().size(), "mm", "The admin's");
  ASSERT_EQ(last_.status, 201);
  const std::string theirs = Path(std::string(others.at("id").as_string()));
  EXPECT_EQ(ben.Get(theirs).status, 404) << "another's";
  EXPECT_EQ(root_.Send("DELETE", theirs, "X-Enamel-Csrf: " + root_.csrf + "\r\n", "").status, 204);
  const RawResponse begun = ben.Post("/api/v1/tooth-imports", body);
  ASSERT_EQ(begun.status, 201) << begun.body;
  const std::string own = Path(std::string(Parsed(begun).at("id").as_string()));
  ASSERT_EQ(
      ben.Send("PUT", own + "/bytes?offset=0",
               "X-Enamel-Csrf: " + ben.csrf + "\r\nContent-Type: application/octet-stream\r\n",
               Box())
          .status,
      200);
  json::value now = Parsed(ben.Get(own));
  // Bounded by the reader's own time.
  for (int i = 0; i < 20'000 && now.at("state") == "working"; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    now = Parsed(ben.Get(own));
  }
  ASSERT_EQ(now.at("state").as_string(), "done") << json::serialize(now);
  for (const ExerciseRow& row : *school_.store->exercises.AllExercises()) {
    if (row.title.find("Mine") != std::string::npos) EXPECT_EQ(row.owner, before.id) << row.name;
  }
}

std::string ObjOf(const mesh::Triangles& mesh) {
  std::string out;
  for (const dvec3& v : mesh.vertices) {
    out +=
        "v " + std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z) + "\n";
  }
  for (const auto& t : mesh.indices) {
    out += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " +
           std::to_string(t[2] + 1) + "\n";
  }
  return out;
}

TEST_F(ToothImportTest, AScanOfAPreparedToothBecomesTheTargetOfADraft) {
  constexpr int32_t kVoxel_nm = 200'000;
  Store& store = *school_.store;
  const Actor by{school_.root, "test"};
  const scene::BuiltScene block = *scene::BuildBuiltinScene("block", kVoxel_nm);
  const SceneRow row = *StoreBuiltinScene(store.blobs, store.scenes, "block", kVoxel_nm, by);
  const auto published =
      *PublishExercisesOf(store.blobs, store.exercises, block.scene, row.content, by);
  const auto exercises = scene::BuiltinExercises(block.scene, row.content);
  const auto shape = *scene::TargetShape(block.scene, exercises.front().target);
  const std::string scan = ObjOf(import::ToothSurface_mm(scene::Prepared(block.volume, shape)));
  const json::object of{{"prepared_of", published.front().id.Text()}, {"placed", true}};
  const json::value shown =
      Import("scan.obj", scan, "mm", "As cut by a dentist", 46,
             {{"prepared_of", of.at("prepared_of")}, {"placed", true}, {"publish", false}});
  ASSERT_EQ(last_.status, 200) << last_.body;
  ASSERT_EQ(shown.at("state").as_string(), "done") << json::serialize(shown);
  EXPECT_TRUE(shown.at("tooth").is_null() && shown.at("stance").is_null());
  const json::value done = Import("scan.obj", scan, "mm", "As cut by a dentist", 46, of);
  ASSERT_EQ(done.at("state").as_string(), "done") << json::serialize(done);
  const Uuid id =
      *Uuid::Parse(std::string_view(done.at("tooth").at("exercises").at(0).at("id").as_string()));
  const ExerciseRow draft = *store.exercises.ExerciseById(id);
  EXPECT_EQ(draft.state, ExerciseState::kDraft);
  EXPECT_EQ(draft.title, "As cut by a dentist");
  EXPECT_EQ(draft.graded, published.front().graded);
  const scene::Exercise document =
      *scene::ExerciseFromJson(AsText(*store.blobs.GetBlob(draft.content)));
  EXPECT_EQ(document.scene, row.content);
  EXPECT_FALSE(document.target.prepared.IsZero());
  const json::value another = Import("scan.obj", Box(), "mm", "Another", 46, of);
  EXPECT_EQ(another.at("state").as_string(), "refused") << json::serialize(another);
  Begin("scan.obj", scan.size(), "mm", "Of nothing", 46, {{"prepared_of", Uuid::New().Text()}});
  EXPECT_EQ(last_.status, 400) << last_.body;
}

TEST_F(ToothImportTest, MeshBecomesAToothWithItsExercises) {
  const json::value done = Import("Crown.OBJ", Box(), "mm", "Ein Würfel", 46);
  ASSERT_EQ(done.at("state").as_string(), "done") << json::serialize(done);
  EXPECT_EQ(done.at("tooth").at("name").as_string(), "ein-w-rfel-46");
  EXPECT_EQ(done.at("tooth").at("title").as_string(), "Ein Würfel");
  EXPECT_FALSE(done.at("tooth").at("exercises").as_array().empty());
  EXPECT_FALSE(done.at("findings").as_array().empty());
  auto scenes = *school_.store->scenes.Scenes();
  const auto row = std::ranges::find(scenes, "ein-w-rfel-46", &SceneRow::name);
  ASSERT_NE(row, scenes.end());
  const std::string document(AsText(*school_.store->blobs.GetBlob(row->content)));
  EXPECT_NE(document.find("\"tooth\": 46"), std::string::npos);
  EXPECT_EQ(document.find("Crown"), std::string::npos)
      << "what the sender calls the file is not kept";
  AuditFilter put;
  put.action = "scene.put";
  auto rows = *school_.store->audit.FindAudit(put);
  ASSERT_FALSE(rows.empty());
  EXPECT_TRUE(rows[0].actor.starts_with(school_.root.Text())) << rows[0].actor;
  // The same again is another tooth, not a version of this one's exercises.
  const json::value again = Import("crown.obj", Box(), "mm", "Ein Würfel", 46);
  EXPECT_EQ(again.at("tooth").at("name").as_string(), "ein-w-rfel-46-2");
}

// A box of 8 x 8 x 6 on its side, by its longest side: shown, turned, published as it was shown.
TEST_F(ToothImportTest, WhatIsShownIsPublishedOnlyWhenSentAgainAndStandsAsGiven) {
  const json::value shown = Import("box.obj", Box(), "m", "Box", 46,
                                   {{"publish", false}, {"longest_mm", 8}, {"up", "-z"}});
  ASSERT_EQ(last_.status, 200) << last_.body;
  ASSERT_EQ(shown.at("state").as_string(), "done") << json::serialize(shown);
  EXPECT_TRUE(shown.at("tooth").is_null());
  EXPECT_EQ(shown.at("stance").at("up").as_array(), json::parse("[0e0,0e0,-1e0]"));
  EXPECT_EQ(shown.at("stance").at("up_is").as_string(), "given");
  EXPECT_NEAR(shown.at("stance").at("size_mm").at(2).as_double(), 6, 1e-9);
  const std::string id(shown.at("id").as_string());
  EXPECT_EQ(root_.Get(Path(id) + "/surface").body.substr(0, 4), "ENTM");
  EXPECT_EQ(root_.Get(Path(id) + "/start-tooth").body.substr(0, 4), "ENTS");
  EXPECT_EQ(school_.store->scenes.Scenes()->size(), 1u) << "the school's own";
  const json::value put =
      Import("box.obj", Box(), "mm", "Box", 46,
             {{"practice", true}, {"up", "0.6,0,0.8"}, {"buccal", "-0.8,0,0.6"}});
  ASSERT_EQ(put.at("state").as_string(), "done") << json::serialize(put);
  EXPECT_NEAR(put.at("stance").at("buccal").at(0).as_double(), -0.8, 1e-9);
  const std::string exercise(put.at("tooth").at("exercises").at(0).at("id").as_string());
  EXPECT_FALSE(Parsed(root_.Get("/api/v1/exercises/" + exercise)).at("graded").as_bool());
  EXPECT_EQ(root_.Get(Path(id) + "/surface").status, 404) << "another began";
  EXPECT_EQ(root_.Get(Path(std::string(put.at("id").as_string())) + "/surface").status, 404);
}

// Boxes of 5.6 and 6.4 mm have pulps of 0.2 and 4 mm3: less than half a cubic millimetre is none.
TEST_F(ToothImportTest, AGradedExerciseNeedsAPulp) {
  const json::value small = Import("box.obj", Box(), "mm", "Small", 46, {{"longest_mm", 5.6}});
  ASSERT_EQ(small.at("state").as_string(), "refused") << json::serialize(small);
  EXPECT_EQ(small.at("problem").at("field").as_string(), "practice");
  const json::value practice =
      Import("box.obj", Box(), "mm", "Small", 46, {{"longest_mm", 5.6}, {"practice", true}});
  EXPECT_EQ(practice.at("state").as_string(), "done") << json::serialize(practice);
  const json::value graded = Import("box.obj", Box(), "mm", "Larger", 46, {{"longest_mm", 6.4}});
  EXPECT_EQ(graded.at("state").as_string(), "done") << json::serialize(graded);
}

TEST_F(ToothImportTest, WhatIsNoToothIsRefusedWithWhatToDo) {
  const json::value small = Import("box.obj", Box(), "um", "Too small");
  ASSERT_EQ(small.at("state").as_string(), "refused");
  EXPECT_EQ(small.at("problem").at("field").as_string(), "unit");
  const std::string text(small.at("problem").at("message").as_string());
  EXPECT_NE(text.find("expected"), std::string::npos) << text;
  EXPECT_NE(text.find("mm"), std::string::npos) << text;
  const json::value broken = Import("broken.stl", "solid x\nfacet", "mm", "Broken");
  EXPECT_EQ(broken.at("state").as_string(), "refused") << json::serialize(broken);
  for (const char* wrong :
       {R"({"file_name":"a.exe","bytes":9,"unit":"mm","title":"t"})",
        R"({"file_name":"a.stl","bytes":9,"unit":"ell","title":"t"})",
        R"({"file_name":"a.stl","bytes":0,"unit":"mm","title":"t"})",
        R"({"file_name":"a.stl","bytes":9,"unit":"mm","title":"t","tooth":59})",
        R"({"file_name":"a.stl","bytes":9,"unit":"mm","title":"t"})",
        R"({"file_name":"a.stl","bytes":9,"unit":"mm","title":"t","tooth":46,"up":"north"})",
        R"({"file_name":"a.stl","bytes":9,"unit":"mm","title":"t","tooth":46,"buccal":"y"})",
        R"({"file_name":"a.stl","bytes":9,"unit":"mm","title":"t","tooth":46,"scale":0})",
        R"({"file_name":"a.stl","bytes":9,"unit":"mm","title":"=1+1"})"}) {
    EXPECT_EQ(root_.Post("/api/v1/tooth-imports", wrong).status, 400) << wrong;
  }
  const RawResponse large =
      root_.Post("/api/v1/tooth-imports",
                 R"({"file_name":"a.stl","unit":"mm","title":"t","tooth":46,"bytes":)" +
                     std::to_string(ToothImport::kMaxFileBytes + 1) + "}");
  EXPECT_EQ(large.status, 413) << large.body;
  EXPECT_EQ(school_.store->scenes.Scenes()->size(), 1u) << "the school's own";
}

TEST_F(ToothImportTest, PartsComeInOrderAndOneFileAtATime) {
  const std::string id(Begin("a.obj", 10, "mm", "A").at("id").as_string());
  EXPECT_EQ(Put(id, 0, "01234").status, 200);
  EXPECT_EQ(Put(id, 0, "01234").status, 409) << "these were sent";
  EXPECT_EQ(Put(id, 7, "789").status, 409) << "some are missing";
  EXPECT_EQ(Put(id, 5, "567890").status, 413) << "more than was told";
  (void)Begin("b.obj", 10, "mm", "B");
  EXPECT_EQ(last_.status, 503) << last_.body;
  EXPECT_EQ(root_.Send("DELETE", Path(id), "X-Enamel-Csrf: " + root_.csrf + "\r\n").status, 204);
  EXPECT_EQ(root_.Get(Path(id)).status, 404);
  (void)Begin("b.obj", 10, "mm", "B");
  EXPECT_EQ(last_.status, 201) << last_.body;
}

TEST_F(ToothImportTest, OddMeshesFromElsewhereEndWithAReasonAndACrownIsTaken) {
  const std::string crown = Shared("crowns/fdi_46.obj");
  if (crown.empty()) GTEST_SKIP() << "skipped: no shared data";
  for (const char* odd : {"empty.stl", "busted.STL", "nancolor.obj", "notenoughindices.obj",
                          "points_ascii.ply", "plane.ply", "unit_cube.STL"}) {
    const std::string file = Shared(std::string("meshes_odd/models/") + odd);
    const json::value end = Import(odd, file, "mm", odd);
    if (file.empty()) {
      EXPECT_EQ(last_.status, 400) << odd;
      continue;
    }
    // Whichever it is, it is said why.
    if (end.at("state").as_string() == "done") {
      EXPECT_FALSE(end.at("findings").as_array().empty()) << odd;
      EXPECT_NE(std::string(odd), "unit_cube.STL") << "1 mm is no tooth";
      EXPECT_NE(std::string(odd), "points_ascii.ply") << "no surface";
      continue;
    }
    EXPECT_EQ(end.at("state").as_string(), "refused") << odd;
    EXPECT_GT(end.at("problem").at("message").as_string().size(), 30u) << odd;
  }
  const json::value done = Import("fdi_46.obj", crown, "mm", "Crown", 46);
  EXPECT_EQ(done.at("state").as_string(), "done") << json::serialize(done);
}

TEST(BuiltinTeethTest, ListIsTheProgramsOwn) {
  School school;
  RunningServer server(school);
  const json::value list = Parsed(Visitor(server.port(), "root").Get("/api/v1/builtin-teeth"));
  ASSERT_EQ(list.at("teeth").as_array().size(), scene::BuiltinScenes().size());
  EXPECT_EQ(list.at("teeth").at(0).at("name").as_string(), scene::BuiltinScenes()[0].name);
}

}  // namespace
}  // namespace enamel::server::http
