#include "common/scene/json/json.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <filesystem>
#include <set>
#include <string>

#include "common/base/file.h"
#include "common/base/utf8.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/builtin/drawn.h"
#include "common/scene/calibration.h"
#include "common/scene/material.h"
#include "tests/support/test_name.h"

namespace enamel::scene {
namespace {

namespace json = boost::json;

std::string ReadText(const std::string& path) {
  Result<Bytes> bytes = ReadFile(std::filesystem::path(ENAMEL_SOURCE_DIR) / "schemas" / path);
  EXPECT_TRUE(bytes.ok()) << path;
  return bytes.ok() ? std::string(AsText(*bytes)) : std::string();
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

// Members of every object in `document`, as "/a/b" with array positions left out.
void CollectNames(const json::value& v, const std::string& path, std::set<std::string>& out) {
  if (v.is_array()) {
    for (const auto& item : v.get_array()) CollectNames(item, path, out);
  } else if (v.is_object()) {
    for (const auto& m : v.get_object()) {
      std::string own = path + "/" + std::string(m.key());
      out.insert(own);
      CollectNames(m.value(), own, out);
    }
  }
}

// `definitions`: where "$ref" leads, by "#/$defs/NAME".
void CollectSchemaNames(const json::object& schema, const json::object& definitions,
                        const std::string& path, std::set<std::string>& out) {
  constexpr std::string_view kDefinitions = "#/$defs/";
  if (const auto* ref = schema.if_contains("$ref")) {
    std::string_view name = ref->as_string();
    name.remove_prefix(kDefinitions.size());
    CollectSchemaNames(definitions.at(name).as_object(), definitions, path, out);
  }
  if (const auto* items = schema.if_contains("items"))
    CollectSchemaNames(items->as_object(), definitions, path, out);
  const auto* properties = schema.if_contains("properties");
  if (properties == nullptr) return;
  for (const auto& m : properties->as_object()) {
    std::string own = path + "/" + std::string(m.key());
    out.insert(own);
    CollectSchemaNames(m.value().as_object(), definitions, own, out);
  }
}

std::set<std::string> NamesOf(const std::string& text) {
  std::set<std::string> out;
  CollectNames(json::parse(text), "", out);
  return out;
}

std::set<std::string> SchemaNames(const std::string& file) {
  std::set<std::string> out;
  json::value document = json::parse(ReadText(file));
  const json::object& schema = document.as_object();
  const auto* definitions = schema.if_contains("$defs");
  CollectSchemaNames(schema, definitions ? definitions->as_object() : json::object(), "", out);
  return out;
}

TEST(SceneJsonTest, GoldenDocumentsReadBackToTheSameBytes) {
  std::string text = ReadText("golden/scene_molar.json");
  Result<Scene> scene = SceneFromJson(text);
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_EQ(ToJson(*scene), text);
  text = ReadText("golden/scene_block.json");
  scene = SceneFromJson(text);
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_EQ(ToJson(*scene), text);
  EXPECT_EQ(scene->burs.size(), 8u);
  EXPECT_EQ(scene->burs[2].shank_radius_um, 800);
  text = ReadText("golden/scene_exercise.json");
  Result<Exercise> exercise = ExerciseFromJson(text);
  ASSERT_TRUE(exercise.ok()) << exercise.status().message();
  EXPECT_EQ(ToJson(*exercise), text);
  text = ReadText("golden/scene_exercise_crown.json");
  exercise = ExerciseFromJson(text);
  ASSERT_TRUE(exercise.ok()) << exercise.status().message();
  EXPECT_EQ(ToJson(*exercise), text);
  EXPECT_EQ(exercise->bur_narrow_radius_um, 500);
  text = ReadText("golden/scene_exercise_cues.json");
  exercise = ExerciseFromJson(text);
  ASSERT_TRUE(exercise.ok()) << exercise.status().message();
  EXPECT_EQ(ToJson(*exercise), text);
  EXPECT_EQ(exercise->touch_cues, (TouchCueSpec{300, 120, 250, 800}));
  EXPECT_TRUE(exercise->graded);
}

TEST(SceneJsonTest, ATargetThatIsAPreparedToothHasNoParts) {
  const std::string text = ReadText("golden/scene_exercise_prepared.json");
  Result<Exercise> exercise = ExerciseFromJson(text);
  ASSERT_TRUE(exercise.ok()) << exercise.status().message();
  EXPECT_EQ(ToJson(*exercise), text);
  EXPECT_EQ(exercise->target.prepared.Hex().substr(0, 4), "5e5e");
  EXPECT_EQ(exercise->target.prepared_tooth, nullptr);
  auto field = [&](const char* from, const char* to) {
    Result<Exercise> e = ExerciseFromJson(Replaced(text, from, to));
    return e.ok() ? std::string("accepted") : e.status().field();
  };
  EXPECT_EQ(field("\"5e5e", "\"zz5e"), "/target/prepared_scene_sha256");
  EXPECT_EQ(field("\"container_um\": 500,",
                  "\"container_um\": 500, \"parts\": [{\"outline\": \"disc\", \"top_um\": [0, 0, "
                  "0], \"radius_um\": 800, \"depth_um\": 700}],"),
            "/target/prepared_scene_sha256");
}

TEST(SceneJsonTest, ATargetsPartsFitIntoItsBox) {
  const std::string text = ReadText("golden/scene_exercise_target.json");
  Result<Exercise> exercise = ExerciseFromJson(text);
  ASSERT_TRUE(exercise.ok()) << exercise.status().message();
  EXPECT_EQ(ToJson(*exercise), text);
  ASSERT_EQ(exercise->target.parts.size(), 4u);
  const PreparationPart& stump = exercise->target.parts[0];
  EXPECT_EQ(stump.outline, PreparationPart::Outline::kStump);
  EXPECT_EQ(stump.stump,
            (Stump{{{50, -100}, {4'000, 3'600}}, {{0, 50}, {3'500, 3'100}}, 1'500, 1'800}));
  EXPECT_EQ(exercise->target.parts[1].half_size_um, (std::array<int32_t, 2>{800, 800}));
  auto field = [&](const char* from, const char* to) {
    Result<Exercise> e = ExerciseFromJson(Replaced(text, from, to));
    return e.ok() ? std::string("accepted") : e.status().field();
  };
  EXPECT_EQ(field("\"outline\": \"disc\"", "\"outline\": \"star\""), "/target/parts/1/outline");
  EXPECT_EQ(field("\"top_um\": [-200, 100", "\"top_um\": [-5300, 100"), "/target/parts");
  EXPECT_EQ(field("\"table_below_um\": 1500", "\"table_below_um\": 6500"),
            "/target/parts/0/stump/table_below_um");
  EXPECT_EQ(field("[0, 700]", "[0, -700]"), "/target/parts/3/corners_um");
  EXPECT_EQ(field("[0, 700]", "[0, 0.5]"), "/target/parts/3/corners_um");
  EXPECT_EQ(field("[0, 700]", "[0, 700],\n          [600, 700],\n          [-600, 0]"),
            "/target/parts/3/corners_um");
  EXPECT_FALSE(
      SceneFromJson(Replaced(ReadText("golden/scene_block.json"), "\"disc\"", "\"polygon\"")).ok());
}

TEST(SceneJsonTest, ReliefsHaveAsManyDepthsAsPoints) {
  const std::string text = ReadText("golden/scene_exercise_relief.json");
  Result<Exercise> exercise = ExerciseFromJson(text);
  ASSERT_TRUE(exercise.ok()) << exercise.status().message();
  EXPECT_EQ(ToJson(*exercise), text);
  EXPECT_EQ(exercise->target.parts[0].relief.below_um[4], 2'600);
  EXPECT_EQ(exercise->target.parts[2].relief, (Relief{1'000, {1, 3}, {400, 300, 0}}));
  auto field = [&](const char* from, const char* to) {
    Result<Exercise> e = ExerciseFromJson(Replaced(text, from, to));
    return e.ok() ? std::string("accepted") : e.status().field();
  };
  EXPECT_EQ(field("[400, 300, 0]", "[400, 300]"), "/target/parts/2/relief/below_um");
  EXPECT_EQ(field("[400, 300, 0]", "[401, 300, 0]"), "/target/parts/2/relief/below_um");
  EXPECT_EQ(field("\"count\": [1, 3]", "\"count\": [1, 2]"), "/target/parts/2/relief/count");
  EXPECT_EQ(field("\"count\": [1, 3]", "\"count\": [1, 67]"), "/target/parts/2/relief/count");
  EXPECT_EQ(field("\"step_um\": 1000", "\"step_um\": 0"), "/target/parts/2/relief/step_um");
}

TEST(SceneJsonTest, AToothsOcclusalOrBuccalSideIsUp) {
  const std::string text = ReadText("golden/scene_turned.json");
  Result<Scene> scene = SceneFromJson(text);
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_EQ(scene->up, Up::kBuccal);
  EXPECT_EQ(ToJson(*scene), text);
  scene = SceneFromJson(Replaced(text, "\"buccal\"", "\"occlusal\""));
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_EQ(scene->up, Up::kOcclusal);
  EXPECT_EQ(SceneFromJson(Replaced(text, "\"buccal\"", "\"lingual\"")).status().field(), "/up");
}

TEST(SceneJsonTest, ASceneSaysItsToothsFdiNumberOrThatItIsNone) {
  const std::string text = ReadText("golden/scene_molar.json");
  EXPECT_EQ(SceneFromJson(text)->tooth, 46);
  EXPECT_EQ(SceneFromJson(ReadText("golden/scene_block.json"))->tooth, 0);
  for (const char* number : {"0", "9", "19", "49", "56", "86", "146"}) {
    const Status refused =
        SceneFromJson(Replaced(text, "\"tooth\": 46", std::string("\"tooth\": ") + number))
            .status();
    EXPECT_EQ(refused.field(), "/tooth") << number;
  }
  EXPECT_EQ(SceneFromJson(Replaced(text, "\"tooth\": 46", "\"tooth\": 85"))->tooth, 85);
}

TEST(SceneJsonTest, APriceHasTheSizesOfItsKind) {
  const std::string text = ReadText("golden/scene_exercise.json");
  auto field = [&](const char* from, const char* to) {
    Result<Exercise> e = ExerciseFromJson(Replaced(text, from, to));
    return e.ok() ? std::string("accepted") : e.status().field();
  };
  EXPECT_EQ(field("\"over_mm\": 0.45", "\"over_mm3\": 0.45"), "/rubric/prices/0/over_mm");
  EXPECT_EQ(field("\"over_mm3\": 1", "\"over_mm\": 1"), "/rubric/prices/3/over_mm3");
  EXPECT_EQ(field("\"points\": 14", "\"points\": -1"), "/rubric/prices/0/points");
  EXPECT_EQ(field("\"source\": \"chosen\"", "\"source\": \"\""), "/rubric/prices/0/source");
}

TEST(SceneJsonTest, ARubricNamesAMaterialAndWhatEachTolerates) {
  const std::string text = ReadText("golden/scene_exercise_restoration.json");
  Result<Exercise> exercise = ExerciseFromJson(text);
  ASSERT_TRUE(exercise.ok()) << exercise.status().message();
  EXPECT_EQ(ToJson(*exercise), text);
  const Rubric& rubric = exercise->rubric;
  EXPECT_EQ(rubric.restoration, Restoration::kAmalgam);
  ASSERT_EQ(rubric.restorations.size(), 2u);
  EXPECT_EQ(rubric.restorations[0].prices[0].over, 0.6);
  EXPECT_EQ(rubric.restorations[1].critical[0].limit, 50);
  auto refused = [&](const char* from, const char* to) {
    Result<Exercise> e = ExerciseFromJson(Replaced(text, from, to));
    return e.ok() ? Status(Code::kInternal, "accepted") : e.status();
  };
  const Status unknown = refused("\"restoration\": \"amalgam\",\n    \"restorations\"",
                                 "\"restoration\": \"gold\",\n    \"restorations\"");
  EXPECT_EQ(unknown.field(), "/rubric/restoration");
  EXPECT_NE(unknown.message().find("one of amalgam, composite, ceramic"), std::string::npos)
      << unknown.message();
  EXPECT_EQ(refused("\"source\": \"a textbook\"", "\"source\": \"\"").field(),
            "/rubric/restorations/0/source");
  EXPECT_EQ(refused("\"limit\"", "\"above\"").field(), "/rubric/restorations/1/critical/0/limit");
}

TEST(SceneJsonTest, ARubricByItselfSaysWhatItSaysInAnExercise) {
  const std::string text = ReadText("golden/scene_rubric.json");
  Result<Rubric> rubric = RubricFromJson(text);
  ASSERT_TRUE(rubric.ok()) << rubric.status().message();
  EXPECT_EQ(ToJson(*rubric), text);
  auto field = [&](const char* from, const char* to) {
    Result<Rubric> r = RubricFromJson(Replaced(text, from, to));
    return r.ok() ? std::string("accepted") : r.status().field();
  };
  EXPECT_EQ(field("\"version\": ", "\"verse\": "), "/version");
  EXPECT_EQ(field("\"of\": \"table\"", "\"for\": \"table\""), "/prices/0/of");
  EXPECT_FALSE(RubricFromJson("").ok());
}

TEST(SceneJsonTest, IsolationIsARubberDamOrNothing) {
  const std::string text = ReadText("golden/scene_exercise_restoration.json");
  Exercise e = *ExerciseFromJson(text);
  EXPECT_EQ(e.isolation, Isolation::kRubberDam);
  const auto refused = ExerciseFromJson(Replaced(text, "\"rubber_dam\"", "\"cotton\""));
  EXPECT_EQ(refused.status().field(), "/isolation");
  e.isolation = Isolation::kNone;
  EXPECT_EQ(ToJson(e).find("isolation"), std::string::npos);
  EXPECT_EQ(ExerciseFromJson(ToJson(e))->isolation, Isolation::kNone);
}

TEST(SceneJsonTest, TouchCuesNeedAForce) {
  const std::string text = ReadText("golden/scene_exercise_cues.json");
  auto field = [&](const char* from, const char* to) {
    Result<Exercise> e = ExerciseFromJson(Replaced(text, from, to));
    return e.ok() ? std::string("accepted") : e.status().field();
  };
  EXPECT_EQ(field("\"contact_mn\": 300", "\"contact_mn\": 2001"), "/touch_cues/contact_mn");
  EXPECT_EQ(field("\"chatter_mn\": 120", "\"chatter_mn\": -1"), "/touch_cues/chatter_mn");
  EXPECT_EQ(field("\"energy_uj\": 250", "\"energy_uj\": 0"), "/touch_cues/energy_uj");
  EXPECT_EQ(field("\"power_uw\": 800", "\"power_uw\": 10001"), "/touch_cues/power_uw");
  EXPECT_EQ(field("\"power_uw\": 800", "\"power_mw\": 1"), "/touch_cues/power_uw");
  Exercise e = *ExerciseFromJson(text);
  e.touch_cues.chatter_mn = 0;
  EXPECT_TRUE(ExerciseFromJson(ToJson(e)).ok());
  e.touch_cues.contact_mn = 0;
  EXPECT_EQ(ExerciseFromJson(ToJson(e)).status().field(), "/touch_cues/contact_mn");
  e.touch_cues = {};
  EXPECT_EQ(ToJson(e).find("touch_cues"), std::string::npos);
}

TEST(SceneJsonTest, BuiltinProfilesAreTheGoldenDocuments) {
  for (const DeviceProfile& profile : BuiltinProfiles()) {
    std::string text = ReadText("golden/scene_profile_" + profile.name + ".json");
    EXPECT_EQ(ToJson(profile), text);
    Result<DeviceProfile> back = ProfileFromJson(text);
    ASSERT_TRUE(back.ok()) << back.status().message();
    EXPECT_EQ(ToJson(*back), text);
  }
}

TEST(SceneJsonTest, AProfileNamesWhatNobodyPublished) {
  for (const DeviceProfile& profile : BuiltinProfiles()) {
    const bool asks = profile.name.starts_with("polhem") || profile.name.starts_with("wooden");
    std::vector<std::string> expected;
    if (asks) expected = {"damping_mn_s_per_m", "friction_mn", "mass_g", "continuous_force_mn"};
    if (profile.name == "inverse3") {
      expected = {"max_stiffness_mn_per_mm", "damping_mn_s_per_m", "friction_mn", "mass_g",
                  "bus_delay_ticks",         "workspace_radius_um"};
    }
    if (profile.name == "minverse") {
      expected = {"resolution_nm",
                  "max_stiffness_mn_per_mm",
                  "damping_mn_s_per_m",
                  "friction_mn",
                  "mass_g",
                  "peak_force_mn",
                  "continuous_force_mn",
                  "bus_delay_ticks",
                  "workspace_radius_um"};
    }
    if (profile.name == "falcon") {
      expected = {"damping_mn_s_per_m", "friction_mn", "mass_g", "continuous_force_mn",
                  "bus_delay_ticks"};
    }
    if (profile.name == "omega6" || profile.name == "omega7") {
      expected = {"damping_mn_s_per_m", "friction_mn", "mass_g", "bus_delay_ticks"};
    }
    if (profile.name == "touch" || profile.name == "touch_x") {
      expected = {"damping_mn_s_per_m", "friction_mn", "bus_delay_ticks"};
    }
    EXPECT_EQ(AskedFor(profile), expected) << profile.name;
  }
}

TEST(SceneJsonTest, ProfilesCarryWhatIsKnownBeyondTheNecessary) {
  std::string text = ReadText("golden/scene_profile_optional.json");
  Result<DeviceProfile> profile = ProfileFromJson(text);
  ASSERT_TRUE(profile.ok()) << profile.status().message();
  EXPECT_EQ(ToJson(*profile), text);
  EXPECT_EQ(profile->structural_mode_hz.value, 120);
}

TEST(SceneJsonTest, ProfilesSayWhetherTheirDelayAndFrictionWereMeasured) {
  std::string text = ReadText("golden/scene_profile_measured.json");
  Result<DeviceProfile> profile = ProfileFromJson(text);
  ASSERT_TRUE(profile.ok()) << profile.status().message();
  EXPECT_TRUE(profile->delay_measured);
  EXPECT_TRUE(profile->friction_measured);
  EXPECT_EQ(ToJson(*profile), text);
  profile->delay_measured = profile->friction_measured = false;
  Result<DeviceProfile> unsaid = ProfileFromJson(ToJson(*profile));
  ASSERT_TRUE(unsaid.ok()) << unsaid.status().message();
  EXPECT_FALSE(unsaid->delay_measured);
  EXPECT_FALSE(unsaid->friction_measured);
  profile = ProfileFromJson(Replaced(text, "\"measured\": true", "\"measured\": false"));
  ASSERT_FALSE(profile.ok()) << "what was not measured is not said";
  EXPECT_EQ(profile.status().field(), "/friction_mn/measured");
}

TEST(SceneJsonTest, TissuesSayHowTheyAreCutByLoad) {
  std::string text = ReadText("golden/scene_by_load.json");
  Result<Scene> scene = SceneFromJson(text);
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_EQ(scene->tissues[0].coulomb_mn, 300);
  EXPECT_EQ(scene->tissues[0].feed_exponent, cutting::FeedExponent::kHalf);
  EXPECT_EQ(scene->tissues[0].feed_um_per_s, 430);
  EXPECT_EQ(scene->tissues[0].bur_friction_permille, 500);
  EXPECT_EQ(ToJson(*scene), text);
  TissueSpec& gypsum = scene->tissues[0];
  gypsum.coulomb_mn = gypsum.feed_um_per_s = gypsum.bur_friction_permille = 0;
  gypsum.feed_exponent = cutting::FeedExponent::kOne;
  EXPECT_EQ(ToJson(*scene), ReadText("golden/scene_block.json"));
  auto field_of = [&](const char* from, const char* to) {
    return SceneFromJson(Replaced(text, from, to)).status().field();
  };
  EXPECT_EQ(field_of("\"1/2\"", "\"0.5\""), "/tissues/0/feed_exponent");
  EXPECT_EQ(field_of("\"feed_um_per_s\": 430,", ""), "/tissues/0/feed_um_per_s");
  EXPECT_EQ(field_of("\"feed_exponent\": \"1/2\",", ""), "/tissues/0/feed_um_per_s");
}

TEST(SceneJsonTest, ProfilesOfSixAxesSayWhatTheirTorqueIs) {
  const std::string text = ReadText("golden/scene_profile_torque.json");
  Result<DeviceProfile> profile = ProfileFromJson(text);
  ASSERT_TRUE(profile.ok()) << profile.status().message();
  EXPECT_EQ(ToJson(*profile), text);
  ASSERT_TRUE(profile->torque);
  EXPECT_EQ(profile->torque->coupling_un_m_per_rad.value, 90'000);
  EXPECT_EQ(profile->viscous_mn_s_per_m(), 2'000);
  ASSERT_TRUE(profile->board_spring);
  EXPECT_EQ(profile->board_spring->rate_hz, 8'000);
  auto FieldOf = [&](const std::string& from, const std::string& to) {
    Result<DeviceProfile> p = ProfileFromJson(Replaced(text, from, to));
    return p.ok() ? std::string("accepted") : p.status().field();
  };
  EXPECT_EQ(FieldOf("\"value\": 6,", "\"value\": 3,"), "/torque");
  EXPECT_EQ(FieldOf("\"value\": 350,", "\"value\": 61,"), "/torque/orientation_cell_urad/value");
  EXPECT_EQ(FieldOf("\"delay_ticks\": 1,", "\"delay_ticks\": 17,"), "/board_spring/delay_ticks");
  EXPECT_EQ(FieldOf("\"friction_un_m\"", "\"friction_mn_m\""), "/torque/friction_un_m");
  const std::string without = text.substr(0, text.find(",\n  \"torque\"")) + "\n}\n";
  Result<DeviceProfile> missing = ProfileFromJson(without);
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.status().field(), "/torque");
  EXPECT_NE(missing.status().message().find("axes is 6"), std::string::npos)
      << missing.status().message();
}

TEST(MaterialTest, ProfilesReadAndGiveAScenesTissuesWhatWasMeasured) {
  Result<Material> material = MaterialFromJson(ReadText("golden/material_cut.json"));
  ASSERT_TRUE(material.ok()) << material.status().message();
  ASSERT_EQ(material->tissues.size(), 2u);
  Result<Scene> molar = SceneFromJson(ReadText("golden/scene_molar.json"));
  ASSERT_TRUE(molar.ok());
  size_t count = molar->tissues.size();
  ASSERT_TRUE(ApplyMaterial(*material, &*molar).ok());
  ASSERT_EQ(molar->tissues.size(), count);
  for (const TissueSpec& t : molar->tissues) {
    if (t.tissue != cutting::Tissue::kEnamel) continue;
    EXPECT_EQ(t.damping_mn_s_per_mm, 6500);
    EXPECT_EQ(t.axial_damping_mn_s_per_mm, 9000);
    EXPECT_EQ(t.coulomb_mn, 500);
    EXPECT_EQ(t.feed_exponent, cutting::FeedExponent::kHalf);
    EXPECT_EQ(t.bur_friction_permille, 480);
  }
  Result<Scene> again = SceneFromJson(ToJson(*molar));
  ASSERT_TRUE(again.ok()) << again.status().message();
  EXPECT_EQ(ToJson(*again), ToJson(*molar));

  Result<Scene> block = SceneFromJson(ReadText("golden/scene_block.json"));
  std::string before = ToJson(*block);
  Status status = ApplyMaterial(*material, &*block);
  EXPECT_EQ(status.field(), "enamel") << "gypsum alone";
  EXPECT_EQ(ToJson(*block), before);
}

TEST(MaterialTest, WhatWasNotMeasuredIsLeftOutAndWhatIsWrongIsRefusedWithItsPath) {
  Result<Material> plain = MaterialFromJson(ReadText("golden/material.json"));
  ASSERT_TRUE(plain.ok()) << plain.status().message();
  EXPECT_EQ(plain->tissues[0].spec.coulomb_mn, 0);
  std::string text = ReadText("golden/material_cut.json");
  auto FieldOf = [&](const char* from, const char* to) {
    Result<Material> m = MaterialFromJson(Replaced(text, from, to));
    return m.ok() ? std::string("accepted") : m.status().field();
  };
  EXPECT_EQ(FieldOf("\"coulomb_low_mn\": 470,", ""), "/tissues/0/fit/coulomb_high_mn")
      << "both or none";
}

TEST(MaterialTest, TheProgramsOwnIsADocumentAndFitsEveryScene) {
  const Material& mine = ByLoadMaterial();
  Result<Material> read = MaterialFromJson(ToJson(mine));
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(ToJson(*read), ToJson(mine));
  for (const char* name : {"golden/scene_molar.json", "golden/scene_block.json"}) {
    Result<Scene> scene = SceneFromJson(ReadText(name));
    ASSERT_TRUE(scene.ok());
    CutByLoad(&*scene);
    for (const TissueSpec& t : scene->tissues)
      EXPECT_EQ(t.bur_friction_permille > 0, t.tissue != cutting::Tissue::kGypsum) << name;
  }
}

TEST(SceneJsonTest, MaterialSchemaNamesExactlyTheMembersOfTheDocuments) {
  EXPECT_EQ(NamesOf(ReadText("golden/material_cut.json")), SchemaNames("material.schema.json"));
}

TEST(SceneJsonTest, TheSchemaOfDrawnExercisesNamesExactlyTheirMembers) {
  std::set<std::string> drawn;
  for (const std::string_view text : DrawnDocuments()) drawn.merge(NamesOf(std::string(text)));
  EXPECT_EQ(drawn, SchemaNames("builtin_exercise.schema.json"));
}

TEST(SceneJsonTest, SchemasNameExactlyTheMembersOfTheDocuments) {
  auto exercise = NamesOf(ReadText("golden/scene_exercise_relief.json"));
  exercise.merge(NamesOf(ReadText("golden/scene_exercise_prepared.json")));
  exercise.merge(NamesOf(ReadText("golden/scene_exercise_restoration.json")));
  EXPECT_EQ(exercise, SchemaNames("exercise.schema.json"));
  auto rubric = NamesOf(ReadText("golden/scene_rubric.json"));
  constexpr std::string_view kRubric = "/rubric";
  for (const std::string& name : exercise) {
    if (name.starts_with("/rubric/restoration")) rubric.insert(name.substr(kRubric.size()));
  }
  EXPECT_EQ(rubric, SchemaNames("rubric.schema.json"));
  EXPECT_EQ(NamesOf(ReadText("golden/scene_profile_torque.json")),
            SchemaNames("device_profile.schema.json"));
  EXPECT_EQ(NamesOf(ReadText("golden/scene_calibration.json")),
            SchemaNames("calibration.schema.json"));
  auto scene = NamesOf(ReadText("golden/scene_turned.json"));
  std::erase_if(scene, [](const std::string& n) { return n.starts_with("/landmarks_um/"); });
  EXPECT_EQ(scene, SchemaNames("scene.schema.json"));
}

TEST(SceneJsonTest, CalibrationsReadBackToTheSameBytesAndLeaveOutWhatWasNotMeasured) {
  std::string text = ReadText("golden/scene_calibration.json");
  Result<Calibration> calibration = CalibrationFromJson(text);
  ASSERT_TRUE(calibration.ok()) << calibration.status().message();
  EXPECT_EQ(ToJson(*calibration), text);
  EXPECT_EQ(calibration->friction_mn, (Measured{25, 2, 15}));

  calibration->mass_g.reset();
  calibration->noise_nm.reset();
  Result<Calibration> fewer = CalibrationFromJson(ToJson(*calibration));
  ASSERT_TRUE(fewer.ok()) << fewer.status().message();
  EXPECT_EQ(*fewer, *calibration);

  Result<Calibration> none =
      CalibrationFromJson(text.substr(0, text.find("\"measured\": {")) + "\"measured\": {}\n}\n");
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.status().field(), "/measured");
  Result<Calibration> unknown = CalibrationFromJson(Replaced(text, "\"noise_nm\"", "\"noise_um\""));
  ASSERT_FALSE(unknown.ok());
  EXPECT_EQ(unknown.status().field(), "/measured/noise_um");
}

TEST(SceneJsonTest, MisspeltMemberIsRefusedWithItsPath) {
  std::string text = Replaced(ReadText("golden/scene_exercise.json"), "\"leeway_side_um\": 250,",
                              "\"leeway_side_um\": 250, \"leeway_sides_um\": 900,");
  Result<Exercise> e = ExerciseFromJson(text);
  ASSERT_FALSE(e.ok());
  EXPECT_EQ(e.status().field(), "/target/leeway_sides_um");
}

// Two bytes each, begun at an even and at an odd place: one of the two is cut in the middle of one.
TEST(SceneJsonTest, WhatWasFoundIsToldInWholeCharacters) {
  std::string umlauts;
  for (int i = 0; i < 40; ++i) umlauts += "\xc3\xa4";
  for (const std::string& before : {std::string(), std::string("x")}) {
    const Status refused = SceneFromJson(Replaced(ReadText("golden/scene_molar.json"), "50000",
                                                  "\"" + before + umlauts + "\""))
                               .status();
    EXPECT_TRUE(IsUtf8(refused.message())) << refused.message();
    EXPECT_NE(refused.message().find("\xc3\xa4..."), std::string::npos) << refused.message();
  }
}

TEST(SceneJsonTest, MissingMemberIsRefusedWithItsPath) {
  Result<Scene> s =
      SceneFromJson(Replaced(ReadText("golden/scene_molar.json"), "\"voxel_nm\": 50000,", ""));
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.status().field(), "/voxel_nm");
}

TEST(SceneJsonTest, MemberWrittenTwiceIsRefused) {
  std::string text = Replaced(ReadText("golden/scene_molar.json"), "\"voxel_nm\": 50000,",
                              "\"voxel_nm\": 50000, \"voxel_nm\": 100000,");
  EXPECT_EQ(SceneFromJson(text).status().code(), Code::kInvalidInput);
}

TEST(SceneJsonTest, ColonsAndQuotesInTextAreNoMembers) {
  Result<Scene> s =
      SceneFromJson(Replaced(ReadText("golden/scene_molar.json"), "no scan", R"(a \": b: \\)"));
  ASSERT_TRUE(s.ok()) << s.status().message();
  EXPECT_EQ(SceneFromJson(ToJson(*s))->provenance, s->provenance);
}

// A document, its own name for its kind, and its reader.
struct Kind {
  const char* file;
  std::string name;
  Status (*read)(std::string_view text);
};
const Kind kKinds[] = {
    {"golden/scene_molar.json", "enamel_scene",
     [](std::string_view text) { return SceneFromJson(text).status(); }},
    {"golden/scene_exercise.json", "enamel_exercise",
     [](std::string_view text) { return ExerciseFromJson(text).status(); }},
    {"golden/scene_profile_torque.json", "enamel_device_profile",
     [](std::string_view text) { return ProfileFromJson(text).status(); }},
    {"golden/scene_rubric.json", "enamel_rubric",
     [](std::string_view text) { return RubricFromJson(text).status(); }},
    {"golden/scene_calibration.json", "enamel_calibration",
     [](std::string_view text) { return CalibrationFromJson(text).status(); }},
    {"golden/material_cut.json", "enamel_material",
     [](std::string_view text) { return MaterialFromJson(text).status(); }},
};

TEST(SceneJsonTest, EveryDocumentSaysWhatItIsAndANewerFormatIsAVersionError) {
  for (const Kind& kind : kKinds) {
    const std::string text = ReadText(kind.file), member = "\"" + kind.name + "\": ";
    ASSERT_TRUE(kind.read(text).ok()) << kind.file;
    Status newer = kind.read(Replaced(text, member + "1", member + "2, \"new\": 1"));
    EXPECT_EQ(newer.code(), Code::kVersion) << kind.file;
    EXPECT_EQ(newer.field(), "/" + kind.name);
    Status other = kind.read(Replaced(text, member, "\"enamel_bur\": "));
    EXPECT_EQ(other.code(), Code::kInvalidInput) << kind.file;
    EXPECT_EQ(other.field(), "/" + kind.name);
  }
}

TEST(SceneJsonTest, DocumentsOfAnEarlierEnamelAreRefusedByName) {
  for (const Kind& kind : kKinds) {
    Status refused =
        kind.read(Replaced(ReadText(kind.file), "\"" + kind.name + "\"", "\"format\""));
    EXPECT_EQ(refused.code(), Code::kVersion) << kind.file;
    EXPECT_EQ(refused.field(), "/format");
    EXPECT_NE(refused.message().find("an earlier Enamel"), std::string::npos) << refused.message();
  }
}

TEST(SceneJsonTest, TextOverAMegabyteAndDeepNestingAreRefused) {
  EXPECT_EQ(SceneFromJson(std::string((1 << 20) + 1, ' ')).status().code(), Code::kTooLarge);
  EXPECT_EQ(SceneFromJson(std::string(100, '[') + std::string(100, ']')).status().code(),
            Code::kInvalidInput);
}

TEST(SceneJsonTest, EveryTruncationIsRefused) {
  std::string text = ReadText("golden/scene_exercise.json");
  for (size_t n = 0; n + 2 < text.size(); n += 7)
    EXPECT_FALSE(ExerciseFromJson(text.substr(0, n)).ok()) << n;
}

struct BadValue {
  const char* from;
  const char* to;
  const char* field;
};

std::string NameOf(const testing::TestParamInfo<BadValue>& info) {
  return test::TestName(std::string(info.param.field) + " " + info.param.to);
}

class BadSceneTest : public testing::TestWithParam<BadValue> {};

TEST_P(BadSceneTest, IsRefusedWithItsPath) {
  Result<Scene> s =
      SceneFromJson(Replaced(ReadText("golden/scene_block.json"), GetParam().from, GetParam().to));
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.status().code(), Code::kInvalidInput);
  EXPECT_EQ(s.status().field(), GetParam().field);
}

INSTANTIATE_TEST_SUITE_P(
    Values, BadSceneTest,
    testing::Values(
        BadValue{"\"gypsum\"", "\"plaster\"", "/tissues/0/tissue"},
        BadValue{"\"damping_mn_s_per_mm\": 4000", "\"damping_mn_s_per_mm\": 0",
                 "/tissues/0/damping_mn_s_per_mm"},
        BadValue{"\"voxel_nm\": 200000", "\"voxel_nm\": 100", "/voxel_nm"},
        BadValue{"\"sphere\"", "\"egg\"", "/burs/5/shape"},
        BadValue{"\"radius_um\": 500", "\"radius_um\": 0", "/burs/0/radius_um"},
        BadValue{"\"round-16\"", "\"fissure-10\"", "/burs/5/name"},
        BadValue{"\"narrow_radius_um\": 300", "\"narrow_radius_um\": 600",
                 "/burs/2/narrow_radius_um"},
        BadValue{"\"outline\": \"disc\"", "\"outline\": \"star\"",
                 "/preparations/0/parts/0/outline"},
        BadValue{"\"radius_um\": 2500", "\"half_size_um\": [2500, 2500]",
                 "/preparations/0/parts/0/radius_um"},
        BadValue{"\"depth_um\": 1500", "\"depth_um\": 0", "/preparations/0/parts/0/depth_um"},
        BadValue{"\"name\": \"cross\"", "\"name\": \"circle\"", "/preparations/1/name"}),
    NameOf);

class BadExerciseTest : public testing::TestWithParam<BadValue> {};

TEST_P(BadExerciseTest, IsRefusedWithItsPath) {
  Result<Exercise> e = ExerciseFromJson(
      Replaced(ReadText("golden/scene_exercise.json"), GetParam().from, GetParam().to));
  ASSERT_FALSE(e.ok());
  EXPECT_EQ(e.status().code(), Code::kInvalidInput);
  EXPECT_EQ(e.status().field(), GetParam().field);
}

INSTANTIATE_TEST_SUITE_P(
    Values, BadExerciseTest,
    testing::Values(BadValue{"\"maxwell\"", "\"spring\"", "/law"},
                    BadValue{"\"cylinder\"", "\"egg\"", "/bur/shape"},
                    BadValue{"\"rate_hz\": 1000", "\"rate_hz\": 1000.5", "/rate_hz"},
                    BadValue{"\"rate_hz\": 1000", "\"rate_hz\": 10", "/rate_hz"},
                    BadValue{"\"graded\": true", "\"graded\": 1", "/graded"},
                    BadValue{"[2000, 1200]", "[2000]", "/target/half_size_um"},
                    BadValue{"[8, 0]", "[1, 0]", "/rubric/criteria/0/map"},
                    BadValue{"[8, 0]", "[8, 1.5]", "/rubric/criteria/0/map"},
                    BadValue{"\"points\": 14", "\"points\": -1", "/rubric/prices/0/points"},
                    BadValue{"\"class-1-", "\"Class 1 ", "/name"}),
    NameOf);

TEST(SceneJsonTest, BursToChangeToAndTheirNumbersAreReadAndRefusedWithTheirPaths) {
  const std::string text = ReadText("golden/scene_exercise_relief.json");
  const Result<Exercise> exercise = ExerciseFromJson(text);
  ASSERT_TRUE(exercise.ok()) << exercise.status().message();
  EXPECT_EQ(ToJson(*exercise), text);
  ASSERT_EQ(exercise->burs().size(), 3u);
  EXPECT_EQ(exercise->burs()[1].shape, cutting::BurShape::kFlame);
  EXPECT_EQ(exercise->burs()[1].iso_number, "806 314 243 514 012");
  auto refused = [&](const char* from, const char* to) {
    return ExerciseFromJson(Replaced(text, from, to)).status().field();
  };
  EXPECT_EQ(refused("243 514 012", "243 514 012x"), "/other_burs/0/iso_number");
  EXPECT_EQ(refused("243 514 012", "243-514 012"), "/other_burs/0/iso_number");
  EXPECT_EQ(refused("243 514 012", "243 514 014"), "/other_burs/0/iso_number")
      << "another diameter";
  EXPECT_EQ(refused("\"flame\"", "\"egg\""), "/other_burs/0/shape");
  EXPECT_EQ(refused("\"radius_um\": 600", "\"radius\": 600"), "/other_burs/0/radius_um");
  Exercise twice = *exercise;
  twice.other_burs.push_back(twice.bur());
  EXPECT_EQ(ExerciseFromJson(ToJson(twice)).status().field(), "/other_burs");
  Exercise many = *exercise;
  for (int i = 0; i < 6; ++i) {
    many.other_burs.push_back(many.other_burs.back());
    many.other_burs.back().radius_um += 10;
  }
  EXPECT_EQ(ExerciseFromJson(ToJson(many)).status().field(), "/other_burs");
}

}  // namespace
}  // namespace enamel::scene
