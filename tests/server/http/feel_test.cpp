#include <gtest/gtest.h>

#include <boost/json.hpp>

#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "server/http/handlers/feel_maps.h"
#include "tests/server/http/running_server.h"

// The forces that a hand can feel on a device, over the wire.
namespace enamel::server::http {
namespace {

namespace json = boost::json;
const Actor kBy{{}, "test"};

class FeelTest : public testing::Test {
 protected:
  void AddProfile(const scene::DeviceProfile& profile) {
    Result<Sha256> content = school_.store->blobs.PutBlob(AsBytes(scene::ToJson(profile)));
    ASSERT_TRUE(content.ok());
    ASSERT_TRUE(
        school_.store->profiles.PutProfile({profile.name, profile.title, *content}, kBy).ok());
  }
  void AddScene(const std::string& name, std::vector<scene::TissueSpec> tissues) {
    scene::Scene scene;
    scene.name = name;
    scene.title = "The " + name;
    scene.volume = HashSha256(AsBytes("volume"));
    scene.voxel_nm = 50'000;
    scene.tissues = std::move(tissues);
    scene.landmarks["occlusal_centre"] = {0, 0, 0};
    scene.provenance = "generated";
    Result<Sha256> content = school_.store->blobs.PutBlob(AsBytes(scene::ToJson(scene)));
    ASSERT_TRUE(content.ok());
    ASSERT_TRUE(
        school_.store->scenes.PutScene({scene.name, scene.title, *content, scene.volume}, kBy)
            .ok());
  }
  json::value Feel(const std::string& name) {
    RawResponse response = root_.Get("/api/v1/profiles/" + name + "/feel");
    EXPECT_EQ(response.status, 200) << response.body;
    return Parsed(response);
  }

  School school_;
  RunningServer server_{school_};
  Visitor root_{server_.port(), "root"};
};

TEST_F(FeelTest, WithoutAReadableSceneTheBuiltInTissuesAreMapped) {
  AddProfile(scene::BuiltinProfiles().front());
  json::value feel = Feel("omega3");
  EXPECT_EQ(feel.at("tissues_of_scenes"), false);
  EXPECT_EQ(feel.at("delay_ticks"), 1);
  EXPECT_EQ(feel.at("delay_measured"), false);
  EXPECT_EQ(feel.at("coupling_mn_per_mm"), 3000) << "2 b f/4 of b = 6 N s/m at 1 kHz";
  const json::array& tissues = feel.at("tissues").as_array();
  ASSERT_EQ(tissues.size(), 6u);
  EXPECT_EQ(tissues.front().at("names"), json::value({"enamel", "neighbour"}))
      << "they feel the same";
  const json::array& cells = feel.at("cells").as_array();
  ASSERT_EQ(cells.size(), tissues.size() * 4 * 2);
  // The same figures as the library gives.
  fidelity::Cell same =
      fidelity::Simulate(fidelity::Attached(scene::BuiltinProfiles().front())->device,
                         {"enamel", 8700}, 0.1e-3, fidelity::Motion::kSteady);
  EXPECT_DOUBLE_EQ(cells.front().at("law").at("error").to_number<double>(), same.law.error);
  EXPECT_EQ(cells.front().at("verdict").as_string(), fidelity::VerdictName(same.verdict));
  EXPECT_TRUE(cells.front().at("law").at("lag_s").is_null());
  EXPECT_FALSE(cells.at(1).at("law").at("lag_s").is_null());
  for (const json::value& threshold : feel.at("thresholds").as_array())
    EXPECT_FALSE(threshold.at("source").as_string().empty());
}

TEST_F(FeelTest, TissuesAreThoseOfTheScenesHardToSoftAndOnce) {
  using cutting::Tissue;
  AddScene("block", {{Tissue::kGypsum, 4000, "measured"}});
  AddScene("slab", {{Tissue::kGypsum, 4000, "measured"}, {Tissue::kEnamel, 9000, "measured"}});
  json::value feel = Feel("phantom_desktop");
  EXPECT_EQ(feel.at("tissues_of_scenes"), true);
  const json::array& tissues = feel.at("tissues").as_array();
  ASSERT_EQ(tissues.size(), 2u);
  EXPECT_EQ(tissues.at(0).at("damping_mn_s_per_mm"), 9000);
  EXPECT_EQ(tissues.at(1).at("scenes"), json::value({"The block", "The slab"}));
  EXPECT_EQ(feel.at("cells").as_array().size(), 16u);
}

TEST_F(FeelTest, MoreTissuesThanAMapHoldsAreCountedAndLeftOut) {
  for (int32_t i = 0; i < 14; ++i)
    AddScene("scene-" + std::to_string(i), {{cutting::Tissue::kEnamel, 8000 + i, "measured"}});
  json::value feel = Feel("phantom_desktop");
  EXPECT_EQ(feel.at("tissues").as_array().size(), 12u);
  EXPECT_EQ(feel.at("tissues_left_out"), 2);
}

TEST_F(FeelTest, ADeviceWithoutMotorsHasNoMapAndOneThatIsNotPassiveIsRefused) {
  scene::DeviceProfile pointer;
  for (const scene::DeviceProfile& p : scene::BuiltinProfiles()) {
    if (p.name == "pointer") pointer = p;
  }
  ASSERT_EQ(pointer.name, "pointer");
  AddProfile(pointer);
  json::value feel = Feel("pointer");
  EXPECT_EQ(feel.at("has_motors"), false);
  EXPECT_TRUE(feel.at("cells").as_array().empty());

  scene::DeviceProfile undamped = scene::BuiltinProfiles().front();
  undamped.name = "undamped";
  undamped.damping_mn_s_per_m.value = 0;
  AddProfile(undamped);
  RawResponse refused = root_.Get("/api/v1/profiles/undamped/feel");
  EXPECT_EQ(refused.status, 409) << refused.body;
  EXPECT_NE(refused.body.find("calibrate"), std::string::npos)
      << "says what to do: " << refused.body;
  EXPECT_EQ(root_.Get("/api/v1/profiles/none/feel").status, 404);
}

TEST(FeelMapsTest, AMapIsComputedOnceAndTheOldestGoes) {
  FeelMaps maps;
  // Few ticks: a slow loop and soft tissue.
  fidelity::Device device{"any", 1e-6, 5000, 0.01, 0, 10, 10};
  auto first = maps.Of(device, {{"a", 10}});
  device.name = "another name";
  EXPECT_EQ(maps.Of(device, {{"b", 10}}), first) << "names are not part of it";
  EXPECT_EQ(maps.computed(), 1u);
  for (size_t i = 0; i < FeelMaps::kKept; ++i)
    maps.Of(device, {{"a", 11.0 + static_cast<double>(i)}});
  EXPECT_EQ(maps.computed(), 1 + FeelMaps::kKept);
  maps.Of(device, {{"a", 10}});
  EXPECT_EQ(maps.computed(), 2 + FeelMaps::kKept) << "it was the oldest";
}

}  // namespace
}  // namespace enamel::server::http
