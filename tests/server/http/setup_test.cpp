#include <gtest/gtest.h>

#include "common/base/unix_time.h"
#include "common/scene/builtin/builtin.h"
#include "server/auth/first_admin.h"
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

TEST(BuiltinTeethTest, ListIsTheProgramsOwn) {
  School school;
  RunningServer server(school);
  const json::value list = Parsed(Visitor(server.port(), "root").Get("/api/v1/builtin-teeth"));
  ASSERT_EQ(list.at("teeth").as_array().size(), scene::BuiltinScenes().size());
  EXPECT_EQ(list.at("teeth").at(0).at("name").as_string(), scene::BuiltinScenes()[0].name);
}

}  // namespace
}  // namespace enamel::server::http
