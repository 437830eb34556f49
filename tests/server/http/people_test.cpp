#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <set>

#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "tests/server/http/running_server.h"

// People, sessions, rosters, cohorts, stations and device profiles, over the wire.
namespace enamel::server::http {
namespace {

namespace json = boost::json;

class PeopleTest : public testing::Test {
 protected:
  static HttpOptions Options() {
    HttpOptions options;
    options.station_fingerprint = "f1f2";
    return options;
  }
  // As `who`, with csrf; `more` are further header lines.
  RawResponse Send(Visitor& who, const std::string& method, const std::string& target,
                   const std::string& body = "", const std::string& more = "",
                   const std::string& type = "application/json") {
    return who.Send(method, target,
                    "X-Enamel-Csrf: " + who.csrf + "\r\nContent-Type: " + type + "\r\n" + more,
                    body);
  }
  RawResponse Patch(const std::string& target, const std::string& body, const std::string& etag) {
    return Send(root_, "PATCH", target, body, "If-Match: " + etag + "\r\n");
  }
  // Signs in; the visitor has cookie and csrf then.
  RawResponse SignIn(Visitor& who, const std::string& login, const std::string& password) {
    RawResponse response =
        who.Send("POST", "/api/v1/session", "Content-Type: application/json\r\n",
                 json::serialize(json::object{{"login", login}, {"password", password}}));
    if (response.status == 200) {
      const std::string& set = response.headers["set-cookie"];
      who.cookie = set.substr(0, set.find(';'));
      who.csrf = std::string(Parsed(response).at("csrf").as_string());
    }
    return response;
  }
  std::string Sam(const std::string& rest = "") const {
    return "/api/v1/people/" + school_.sam.Text() + rest;
  }
  void PassMinutes(int minutes) { school_.now_ms += minutes * 60'000; }

  School school_;
  RunningServer server_{school_, Options()};
  Visitor root_{server_.port(), "root"};
};

TEST_F(PeopleTest, EditNeedsTheETagThatWasReadAndTellsWhatIsThereNow) {
  RawResponse read = root_.Get(Sam());
  std::string etag = read.headers["etag"];
  EXPECT_EQ(Send(root_, "PATCH", Sam(), R"({"display_name":"Samuel"})").status, 428);
  RawResponse edited = Patch(Sam(), R"({"display_name":"Samuel"})", etag);
  ASSERT_EQ(edited.status, 200) << edited.body;
  EXPECT_NE(edited.headers["etag"], etag);
  RawResponse stale = Patch(Sam(), R"({"display_name":"Sammy"})", etag);
  EXPECT_EQ(stale.status, 412);
  EXPECT_EQ(Parsed(stale).at("current").at("display_name"), "Samuel");
  EXPECT_EQ(stale.headers["etag"], edited.headers["etag"]);
  EXPECT_EQ(ErrorCode(stale), "precondition_failed");
  EXPECT_EQ(Patch(Sam(), R"({"display_name":"=cmd"})", stale.headers["etag"]).status, 400);
  EXPECT_EQ(Patch(Sam(), R"({"nickname":"S"})", stale.headers["etag"]).status, 400);
}

TEST_F(PeopleTest, PeopleAreFilteredAndComeInPages) {
  auto logins = [&](const std::string& query) {
    std::string out;
    json::value body = Parsed(root_.Get("/api/v1/people" + query));
    for (const auto& person : body.at("people").as_array()) {
      out += std::string(person.at("login").as_string()) + " ";
    }
    return out;
  };
  EXPECT_EQ(logins(""), "ada ben root sam sue tom ");
  EXPECT_EQ(logins("?role=instructor"), "ada ben ");
  EXPECT_EQ(logins("?cohort=" + school_.cohort_b.Text()), "ben tom ");
  EXPECT_EQ(logins("?text=sam%20PERS"), "sam ") << "each word, in any order and case";
  EXPECT_EQ(logins("?disabled=true"), "");
  std::string walked, query = "?limit=4";
  for (int page = 0; page < 5; ++page) {
    json::value body = Parsed(root_.Get("/api/v1/people" + query));
    walked += logins(query);
    if (body.at("next").is_null()) break;
    query = "?limit=4&cursor=" + std::string(body.at("next").as_string());
  }
  EXPECT_EQ(walked, "ada ben root sam sue tom ");
  for (const char* bad : {"?role=dean", "?cohort=x", "?disabled=1", "?limit=0", "?cursor=zz"}) {
    EXPECT_EQ(root_.Get(std::string("/api/v1/people") + bad).status, 400) << bad;
  }
}

TEST_F(PeopleTest, NewPersonSignsInOnceAndChoosesAPassword) {
  RawResponse made = Send(root_, "POST", "/api/v1/people",
                          R"({"login":"Zoe","display_name":"Zoë","role":"student","cohorts":[")" +
                              school_.cohort_a.Text() + "\"]}");
  ASSERT_EQ(made.status, 201) << made.body;
  std::string once(Parsed(made).at("password").as_string());
  constexpr int64_t kWeekMs = int64_t{7} * 24 * 60 * 60 * 1000;
  EXPECT_GE(Parsed(made).at("password_until_ms").as_int64(),
            Parsed(made).at("created_ms").as_int64() + kWeekMs);
  Visitor zoe(server_.port());
  RawResponse in = SignIn(zoe, "zoe", once);
  ASSERT_EQ(in.status, 200) << in.body;
  EXPECT_EQ(Parsed(in).at("must_change_password"), true);
  RawResponse refused = zoe.Get("/api/v1/exercises");
  EXPECT_EQ(refused.status, 403);
  EXPECT_EQ(ErrorCode(refused), "change_password");
  EXPECT_EQ(zoe.Get("/api/v1/session").status, 200);

  Visitor thief(server_.port());
  EXPECT_EQ(SignIn(thief, "zoe", once).status, 200) << "until zoe has chosen a password";

  auto change = [&](const std::string& from, const std::string& to) {
    return Send(zoe, "POST", "/api/v1/session/password",
                json::serialize(json::object{{"old_password", from}, {"new_password", to}}));
  };
  EXPECT_EQ(change("not the password", "a good long one").status, 403);
  RawResponse weak = change(once, "password");
  EXPECT_EQ(weak.status, 400);
  EXPECT_EQ(Parsed(weak).at("error").at("field"), "new_password");
  EXPECT_EQ(change(once, once).status, 400);
  RawResponse changed = change(once, "a good long one");
  ASSERT_EQ(changed.status, 200) << changed.body;
  EXPECT_EQ(Parsed(changed).at("must_change_password"), false);
  EXPECT_EQ(zoe.Get("/api/v1/session").status, 401) << "the old session has ended";
  EXPECT_EQ(thief.Get("/api/v1/session").status, 401);
  EXPECT_EQ(SignIn(thief, "zoe", once).status, 401);
  const std::string& set = changed.headers["set-cookie"];
  zoe.cookie = set.substr(0, set.find(';'));
  EXPECT_EQ(zoe.Get("/api/v1/exercises").status, 200);
  Visitor again(server_.port());
  EXPECT_EQ(SignIn(again, "zoe", once).status, 401);
  EXPECT_EQ(SignIn(again, "zoe", "a good long one").status, 200);
}

TEST_F(PeopleTest, SensitiveChangesAskForThePasswordAgainAfterFiveMinutes) {
  const std::string person = R"({"login":"new","role":"student"})";
  PassMinutes(6);
  RawResponse asked = Send(root_, "POST", "/api/v1/people", person);
  EXPECT_EQ(asked.status, 403);
  EXPECT_EQ(ErrorCode(asked), "confirm_password");
  EXPECT_EQ(Send(root_, "POST", Sam("/password")).status, 403);
  EXPECT_EQ(Patch(Sam(), R"({"role":"instructor"})", "\"1\"").status, 403);
  EXPECT_EQ(Patch(Sam(), R"({"display_name":"Samuel"})", "\"1\"").status, 200) << "harmless";
  EXPECT_EQ(Send(root_, "POST", "/api/v1/session/confirm", R"({"password":"wrong one"})").status,
            403);
  EXPECT_EQ(Send(root_, "POST", "/api/v1/people", person).status, 403);
  EXPECT_EQ(Send(root_, "POST", "/api/v1/session/confirm",
                 std::string(R"({"password":")") + kPassword + "\"}")
                .status,
            204);
  EXPECT_EQ(Send(root_, "POST", "/api/v1/people", person).status, 201);
  PassMinutes(4);
  EXPECT_EQ(Send(root_, "POST", Sam("/password")).status, 200);
  PassMinutes(2);
  EXPECT_EQ(Send(root_, "POST", Sam("/password")).status, 403);
}

TEST_F(PeopleTest, GuessingAtTheConfirmationIsSlowedDownAsSignInIs) {
  RawResponse last;
  for (int i = 0; i < 40 && last.status != 429; ++i) {
    last = Send(root_, "POST", "/api/v1/session/confirm", R"({"password":"wrong one"})");
  }
  EXPECT_EQ(last.status, 429);
}

TEST_F(PeopleTest, SessionsAreListedAndEndedByTheirOwnerAndByAdmins) {
  Visitor sam(server_.port(), "sam"), other(server_.port(), "sam"), sue(server_.port(), "sue");
  json::value listed = Parsed(sam.Get("/api/v1/sessions"));
  ASSERT_EQ(listed.at("sessions").as_array().size(), 2u);
  std::string not_this;
  for (const auto& session : listed.at("sessions").as_array()) {
    EXPECT_EQ(session.at("address"), "127.0.0.1");
    EXPECT_EQ(session.at("device"), "") << "these visitors say nothing of themselves";
    if (!session.at("current").as_bool()) not_this = session.at("id").as_string();
  }
  EXPECT_EQ(Send(sue, "DELETE", "/api/v1/sessions/" + not_this).status, 404);
  EXPECT_EQ(Send(sam, "DELETE", "/api/v1/sessions/" + not_this).status, 204);
  EXPECT_EQ(other.Get("/api/v1/session").status, 401);
  EXPECT_EQ(sam.Get("/api/v1/session").status, 200);
  EXPECT_EQ(Parsed(root_.Get(Sam("/sessions"))).at("sessions").as_array().size(), 1u);
  EXPECT_EQ(Parsed(Send(root_, "DELETE", Sam("/sessions"))).at("ended"), 1);
  EXPECT_EQ(sam.Get("/api/v1/session").status, 401);
}

TEST_F(PeopleTest, ErasureAsksForTheLoginAndNobodyErasesOneself) {
  EXPECT_EQ(Send(root_, "POST", Sam("/erase"), R"({"login":"sue"})").status, 400);
  std::string self = "/api/v1/people/" + school_.root.Text() + "/erase";
  EXPECT_EQ(Send(root_, "POST", self, R"({"login":"root"})").status, 409);
  RawResponse erased = Send(root_, "POST", Sam("/erase"), R"({"login":"sam"})");
  ASSERT_EQ(erased.status, 200) << erased.body;
  EXPECT_EQ(Parsed(erased).at("attempts"), 2);
  EXPECT_EQ(root_.Get(Sam()).status, 404);
}

TEST_F(PeopleTest, ErasureTellsWhatWentAndWhereOthersTypedTheName) {
  const Actor by{school_.ada, "test"};
  AnnotationRow remark;
  remark.attempt = school_.toms_scored;
  remark.author = school_.ada;
  remark.text = "as Sam cut it";
  ASSERT_TRUE(school_.store->remarks.AddAnnotation(remark, by).ok());
  const Uuid cohort = *school_.store->cohorts.CreateCohort("sam's group", by);
  const RawResponse erased = Send(root_, "POST", Sam("/erase"), R"({"login":"sam"})");
  ASSERT_EQ(erased.status, 200) << erased.body;
  const json::value told = Parsed(erased);
  EXPECT_EQ(told.at("attempts"), 2);
  EXPECT_EQ(told.at("references"), 0);
  EXPECT_GT(told.at("blobs").to_number<int>(), 0);
  const auto place = [](const Uuid& id) { return json::array{id.Text()}; };
  const json::array mentions{
      {{"kind", "attempt"}, {"count", 1}, {"places", place(school_.toms_scored)}},
      {{"kind", "cohort"}, {"count", 1}, {"places", place(cohort)}}};
  EXPECT_EQ(told.at("mentions"), mentions);
}

TEST_F(PeopleTest, RosterOverTheApiIsTriedRefusedAndImported) {
  const std::string csv =
      "login,display_name,role,cohort\nzoe,Zoë,student,Year 3\nyan,Yan,instructor,Year 3\n";
  auto post = [&](const std::string& query, const std::string& body,
                  const std::string& type = "text/csv") {
    return Send(root_, "POST", "/api/v1/roster" + query, body, "", type);
  };
  EXPECT_EQ(post("", csv, "application/json").status, 415);
  json::value tried = Parsed(post("?dry_run=true", csv));
  EXPECT_EQ(tried.at("done"), false);
  EXPECT_EQ(tried.at("created"), 2);
  EXPECT_TRUE(tried.at("passwords").as_array().empty());
  EXPECT_EQ(school_.store->people.PersonByLogin("zoe").status().code(), Code::kNotFound);

  RawResponse wrong = post("", csv + "a b,,dean,\n");
  EXPECT_EQ(wrong.status, 400);
  EXPECT_EQ(Parsed(wrong).at("problems").as_array().size(), 2u);
  EXPECT_EQ(Parsed(wrong).at("problems").at(0).at("row"), 4);
  EXPECT_EQ(ErrorCode(wrong), "invalid_input");
  EXPECT_FALSE(school_.store->people.PersonByLogin("zoe").ok()) << "all or nothing";

  json::value done = Parsed(post("?cohort=Else", csv));
  EXPECT_EQ(done.at("done"), true);
  std::string password(done.at("passwords").at(0).at("password").as_string());
  Visitor zoe(server_.port());
  EXPECT_EQ(SignIn(zoe, "zoe", password).status, 200);
  json::value again = Parsed(post("", csv));
  EXPECT_EQ(again.at("unchanged"), 2);
  EXPECT_EQ(post("?unknown_columns=what", csv).status, 400);
  EXPECT_EQ(post("?unknown_columns=ignore", "login,mail\nkim,k@x.example\n").status, 200);
}

TEST_F(PeopleTest, WhoMayNotIsToldTheirRole) {
  const RawResponse refused = Visitor(server_.port(), "ada").Get("/api/v1/people");
  EXPECT_EQ(refused.status, 403);
  EXPECT_NE(refused.body.find("only admins can do this; your role is instructor"),
            std::string::npos)
      << refused.body;
}

TEST_F(PeopleTest, EveryPasswordOfARosterSignsInAlsoOfSomebodyInTwoCohorts) {
  const RawResponse done = Send(root_, "POST", "/api/v1/roster",
                                "login,role,cohort\nzoe,,Section 1\nyan,,Section 1\n"
                                "zoe,,Section 2\nzoe,,Section 3\n",
                                "", "text/csv");
  ASSERT_EQ(done.status, 200) << done.body;
  const json::value made = Parsed(done);
  ASSERT_EQ(made.at("passwords").as_array().size(), 2u);
  for (const json::value& each : made.at("passwords").as_array()) {
    Visitor visitor(server_.port());
    EXPECT_EQ(SignIn(visitor, each.at("login").as_string().c_str(),
                     each.at("password").as_string().c_str())
                  .status,
              200)
        << each;
  }
}

TEST_F(PeopleTest, ARosterIsItsBytesAndMayBeReadOtherwise) {
  auto post = [&](const std::string& query) {
    return Send(root_, "POST", "/api/v1/roster?dry_run=true" + query,
                "login,display_name\nmue,M\xfcller\n", "", "application/octet-stream");
  };
  const json::value latin = Parsed(post(""));
  EXPECT_EQ(latin.at("reading"), "windows-1252");
  EXPECT_EQ(latin.at("people").at(0).at("display_name"), "Müller");
  EXPECT_NE(post("&reading=windows-1251").body.find("Mьller\\\", which mixes several"),
            std::string::npos)
      << "a wrong reading is found out";
  EXPECT_EQ(post("&reading=utf-8").status, 400);
  EXPECT_EQ(post("&reading=ebcdic").status, 400);
  EXPECT_EQ(post("&other_cohorts=leave").status, 200);
  EXPECT_EQ(post("&other_cohorts=what").status, 400);
}

TEST_F(PeopleTest, CohortIsMadeRenamedFilledAndArchived) {
  RawResponse made = Send(root_, "POST", "/api/v1/cohorts", R"({"name":"Year 3"})");
  ASSERT_EQ(made.status, 201) << made.body;
  EXPECT_EQ(Send(root_, "POST", "/api/v1/cohorts", R"({"name":"Year 3"})").status, 409);
  std::string target = "/api/v1/cohorts/" + std::string(Parsed(made).at("id").as_string());
  RawResponse filled = Send(root_, "POST", target + "/members",
                            R"({"add":[")" + school_.sam.Text() + R"("],"remove":[]})");
  ASSERT_EQ(filled.status, 200) << filled.body;
  EXPECT_EQ(Parsed(filled).at("members").at(0).at("display_name"), "Person sam");
  EXPECT_EQ(Parsed(filled).at("members").at(0).at("login"), "sam");
  EXPECT_EQ(Send(root_, "POST", target + "/members", R"({"add":[")" + Uuid::New().Text() + R"("]})")
                .status,
            404);
  RawResponse archived = Patch(target, R"({"name":"2030","archived":true})", made.headers["etag"]);
  ASSERT_EQ(archived.status, 200) << archived.body;
  EXPECT_EQ(Patch(target, R"({"archived":false})", made.headers["etag"]).status, 412);
  auto names = [&](const std::string& query) {
    std::string out;
    json::value listed = Parsed(root_.Get("/api/v1/cohorts" + query));
    for (const auto& cohort : listed.at("cohorts").as_array()) {
      out += std::string(cohort.at("name").as_string()) + " ";
    }
    return out;
  };
  const json::value first = Parsed(root_.Get("/api/v1/cohorts")).at("cohorts").at(0);
  EXPECT_EQ(first.at("students"), 2);
  EXPECT_EQ(json::serialize(first.at("instructors")), R"(["Person ada"])");
  EXPECT_FALSE(first.as_object().contains("members")) << "a school has thousands";
  EXPECT_EQ(names(""), "A B ");
  EXPECT_EQ(names("?archived=true"), "2030 ");
}

TEST_F(PeopleTest, StationIsRenamedAndRevokedAndStaysSo) {
  std::string target = "/api/v1/stations/" + school_.station.Text();
  RawResponse read = root_.Get(target);
  RawResponse renamed = Patch(target, R"({"name":"Bench 7"})", read.headers["etag"]);
  ASSERT_EQ(renamed.status, 200) << renamed.body;
  EXPECT_EQ(Patch(target, R"({"name":"Bench 8"})", read.headers["etag"]).status, 412);
  RawResponse both = Patch(target, R"({"name":"Bench 9","revoked":true})", renamed.headers["etag"]);
  EXPECT_EQ(both.status, 400) << "not renamed and left admitted";
  EXPECT_NE(both.body.find("/revoke"), std::string::npos) << both.body;
  EXPECT_EQ(Parsed(root_.Get(target)).at("name"), "Bench 7");
  ASSERT_EQ(Send(root_, "POST", target + "/revoke").status, 200);
  json::value revoked = Parsed(root_.Get(target));
  EXPECT_EQ(revoked.at("revoked"), true);
  EXPECT_GT(revoked.at("revoked_ms").as_int64(), 0);
  RawResponse back = Patch(target, R"({"revoked":false})", "\"3\"");
  EXPECT_EQ(back.status, 409);
  EXPECT_NE(back.body.find("enrol it again"), std::string::npos) << back.body;
  EXPECT_TRUE(
      Parsed(root_.Get("/api/v1/stations?revoked=false")).at("stations").as_array().empty());
}

TEST_F(PeopleTest, EnrolmentCodeIsShownOnceListedAndWithdrawn) {
  RawResponse made = Send(root_, "POST", "/api/v1/enrolment-codes", R"({"minutes":5})");
  ASSERT_EQ(made.status, 201) << made.body;
  std::string code(Parsed(made).at("code").as_string());
  EXPECT_TRUE(code.ends_with("@f1f2")) << code;
  EXPECT_EQ(Parsed(made).at("station_port"), 0) << "nothing listens for stations here";
  RawResponse listed = root_.Get("/api/v1/enrolment-codes");
  EXPECT_EQ(listed.body.find(code.substr(0, 32)), std::string::npos);
  std::string id(Parsed(listed).at("codes").at(0).at("id").as_string());
  EXPECT_EQ(id, std::string(Parsed(made).at("id").as_string()));
  EXPECT_EQ(Send(root_, "DELETE", "/api/v1/enrolment-codes/" + id).status, 204);
  EXPECT_TRUE(Parsed(root_.Get("/api/v1/enrolment-codes")).at("codes").as_array().empty());
  StationRow row;
  row.name = "s";
  row.public_key.assign(32, 1);
  EXPECT_FALSE(school_.store->stations
                   .EnrolStation(HashSha256(AsBytes(code.substr(0, 32))), row, Sha256{}, 1)
                   .ok());
}

TEST_F(PeopleTest, ProfileIsJudgedWithFiguresBeforeItIsStored) {
  scene::DeviceProfile profile = scene::BuiltinProfiles().front();
  auto post = [&](const std::string& query) {
    return Send(root_, "POST", "/api/v1/profiles" + query, scene::ToJson(profile));
  };
  json::value tried = Parsed(post("?dry_run=true"));
  EXPECT_EQ(tried.at("stored"), false);
  EXPECT_EQ(tried.at("acceptable"), true);
  EXPECT_EQ(tried.at("criteria").as_array().size(), 4u);
  RawResponse stored = post("");
  ASSERT_EQ(stored.status, 201) << stored.body;
  EXPECT_EQ(Parsed(stored).at("version"), 1);
  EXPECT_EQ(Parsed(post("")).at("version"), 1) << "the same again";

  profile.coupling_mn_per_mm.value *= 10;
  RawResponse refused = post("");
  EXPECT_EQ(refused.status, 400);
  json::value judgement = Parsed(refused);
  EXPECT_EQ(judgement.at("error").at("field"), "coupling_mn_per_mm");
  EXPECT_EQ(judgement.at("criteria").at(0).at("met"), false);
  EXPECT_GT(judgement.at("criteria").at(0).at("value").as_double(),
            judgement.at("criteria").at(0).at("limit").as_double());
  EXPECT_EQ(school_.store->profiles.ProfileVersions(profile.name)->size(), 1u);
  EXPECT_EQ(Send(root_, "POST", "/api/v1/profiles", R"({"enamel_device_profile":9})").status, 400);
  profile.coupling_mn_per_mm.value /= 10;
  profile.title = "Second";
  EXPECT_EQ(Parsed(post("")).at("version"), 2);
  json::value versions =
      Parsed(root_.Get("/api/v1/profiles/" + profile.name + "/versions?limit=1"));
  EXPECT_EQ(versions.at("versions").at(0).at("version"), 2);
  json::value older =
      Parsed(root_.Get("/api/v1/profiles/" + profile.name +
                       "/versions?limit=1&cursor=" + std::string(versions.at("next").as_string())));
  EXPECT_EQ(older.at("versions").at(0).at("version"), 1);
  EXPECT_TRUE(older.at("next").is_null());
  EXPECT_EQ(root_.Get("/api/v1/profiles/none").status, 404);
  EXPECT_EQ(root_.Get("/api/v1/profiles/No%20Name").status, 400);
}

TEST_F(PeopleTest, AProfileOfSixAxesShowsItsTorqueAndIsJudgedByIt) {
  scene::DeviceProfile profile = scene::BuiltinProfiles().back();
  ASSERT_EQ(profile.name, "sigma7");
  profile.electrical_damping_mn_s_per_m = {100, "measured"};
  auto post = [&] { return Send(root_, "POST", "/api/v1/profiles", scene::ToJson(profile)); };
  ASSERT_EQ(post().status, 201);
  json::value shown = Parsed(root_.Get("/api/v1/profiles/sigma7"));
  EXPECT_EQ(shown.at("criteria").as_array().size(), 7u);
  std::set<std::string> names;
  for (const json::value& number : shown.at("numbers").as_array()) {
    EXPECT_FALSE(number.at("source").as_string().empty());
    names.insert(std::string(number.at("name").as_string()));
  }
  EXPECT_EQ(names.size(), 20u);
  for (const char* name : {"electrical_damping", "axes", "peak_torque", "torque_coupling",
                           "torque_damping", "torque_friction", "orientation_cell"}) {
    EXPECT_TRUE(names.contains(name)) << name;
  }
  profile.torque->friction_un_m.value = 239;
  RawResponse refused = post();
  EXPECT_EQ(refused.status, 400);
  EXPECT_EQ(Parsed(refused).at("error").at("field"), "torque/friction_un_m");
}

TEST_F(PeopleTest, ReportIsServedAsAnAttachmentOnlyAndCalibrationsAreKept) {
  std::string target = "/api/v1/profiles/phantom_desktop";
  RawResponse added =
      Send(root_, "POST", target + "/reports", "<script>alert(1)</script>", "", "text/html");
  ASSERT_EQ(added.status, 201) << added.body;
  RawResponse report =
      root_.Get("/api/v1/profile-reports/" + std::string(Parsed(added).at("id").as_string()));
  EXPECT_EQ(report.body, "<script>alert(1)</script>");
  EXPECT_TRUE(report.headers["content-disposition"].starts_with("attachment"));
  EXPECT_NE(report.headers["content-security-policy"].find("default-src 'none'"),
            std::string::npos);
  EXPECT_EQ(Send(root_, "POST", target + "/reports", "{", "").status, 400);
  EXPECT_EQ(Send(root_, "POST", target + "/reports", "x", "", "image/svg+xml").status, 415);

  const std::string calibration =
      R"({"enamel_calibration":1,"device":"hid:1","profile":"phantom_desktop","station":"","software":"s",)"
      R"("measured_ms":1000,"rate_hz":1000,"method":"m",)"
      R"("measured":{"friction_mn":{"value":25,"uncertainty":2,"samples":9}}})";
  EXPECT_EQ(Send(root_, "POST", target + "/calibrations", calibration).status, 201);
  EXPECT_EQ(Send(root_, "POST", target + "/calibrations", calibration).status, 201);
  json::value kept = Parsed(root_.Get(target + "/calibrations"));
  ASSERT_EQ(kept.at("calibrations").as_array().size(), 1u) << "twice is once";
  EXPECT_EQ(
      kept.at("calibrations").at(0).at("document").at("measured").at("friction_mn").at("value"),
      25);
  EXPECT_EQ(Send(root_, "POST", "/api/v1/profiles/omega3/calibrations", calibration).status, 400);
}

TEST_F(PeopleTest, AuditIsFilteredAndComesInPages) {
  ASSERT_EQ(Patch(Sam(), R"({"display_name":"Samuel"})", "\"1\"").status, 200);
  json::value edits =
      Parsed(root_.Get("/api/v1/audit?action=person.edit&actor=" + school_.root.Text()));
  ASSERT_EQ(edits.at("audit").as_array().size(), 1u);
  EXPECT_EQ(edits.at("audit").at(0).at("object"), school_.sam.Text().c_str());
  EXPECT_NE(std::string(edits.at("audit").at(0).at("after").as_string()).find("Samuel"),
            std::string::npos);
  json::value page = Parsed(root_.Get("/api/v1/audit?limit=1"));
  json::value next =
      Parsed(root_.Get("/api/v1/audit?limit=1&cursor=" + std::string(page.at("next").as_string())));
  EXPECT_NE(page.at("audit").at(0), next.at("audit").at(0));
  for (const char* bad : {"?actor=x", "?from_ms=x", "?until_ms=-1", "?cursor=00"}) {
    EXPECT_EQ(root_.Get(std::string("/api/v1/audit") + bad).status, 400) << bad;
  }
}

}  // namespace
}  // namespace enamel::server::http
