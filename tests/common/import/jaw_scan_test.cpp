#include "common/import/jaw_scan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/import/import_tooth.h"
#include "common/mesh/cut_out.h"
#include "tests/common/import/made_jaw.h"
#include "tests/common/import/made_teeth.h"

namespace enamel::import {
namespace {

// 80 000 triangles of 0.2 mm, and 500 000 as in a scan of a whole jaw.
constexpr int kCoarse = 400, kFine = 1000;

TEST(JawTest, CutsTheCrownInsideTheCurveAndNothingElse) {
  const MadeJaw made = MakeJaw(14, kFine);
  const mesh::Jaw jaw(made.mesh);
  for (size_t crown : {0u, 5u, 13u}) {
    const auto cut = jaw.Crown(AlongGum(made, crown, 12));
    ASSERT_TRUE(cut.ok()) << cut.status().message();
    double highest = -1e9, farthest = -1e9;
    size_t inside = 0;
    for (const dvec3& p : cut->vertices) {
      highest = std::max(highest, p.z);
      farthest = std::max(farthest, Outside_mm(made.crowns[crown], p));
    }
    for (const dvec3& p : made.mesh.vertices) inside += Outside_mm(made.crowns[crown], p) < 0;
    EXPECT_NEAR(highest, made.crowns[crown].high_mm, 0.05) << crown;
    EXPECT_LT(farthest, 0.4) << "the curve, and a triangle's length: " << crown;
    EXPECT_GT(cut->vertices.size(), 0.97 * static_cast<double>(inside)) << crown;
  }
}

TEST(JawTest, HowTheScanLiesAndWhereTheCurveBeginsChangeNothing) {
  const MadeJaw made = MakeJaw(14, kCoarse);
  std::vector<dvec3> curve = AlongGum(made, 4, 12);
  const double area = mesh::SurfaceArea(*mesh::Jaw(made.mesh).Crown(curve));
  const dmat3 turn = QuarterTurns()[7];
  const mesh::Jaw turned(TurnedBy(made.mesh, turn));
  std::rotate(curve.begin(), curve.begin() + 5, curve.end());
  std::reverse(curve.begin(), curve.end());
  for (dvec3& p : curve) p = turn * p;
  EXPECT_NEAR(mesh::SurfaceArea(*turned.Crown(curve)), area, 0.005 * area);
}

TEST(JawTest, CurvesThatPartNoCrownAreRefusedWithWhatToDo) {
  const MadeJaw made = MakeJaw(14, kCoarse);
  const mesh::Jaw jaw(made.mesh);
  const std::vector<dvec3> good = AlongGum(made, 4, 12);
  auto refusal = [&](const std::vector<dvec3>& curve) {
    const auto cut = jaw.Crown(curve);
    EXPECT_FALSE(cut.ok());
    EXPECT_EQ(cut.status().field(), "around");
    return cut.ok() ? "" : cut.status().message();
  };
  EXPECT_NE(refusal({good[0], good[1]}).find("3 to 200 points"), std::string::npos);
  EXPECT_NE(refusal(std::vector<dvec3>(201, good[0])).find("found 201"), std::string::npos);
  // To and fro along one way.
  EXPECT_NE(refusal({good[0], good[1], good[2], good[1]}).find("parts nothing"), std::string::npos);
  EXPECT_NE(refusal({good[0], good[0], good[0]}).find("parts nothing"), std::string::npos);
  std::vector<dvec3> off = good;
  off[2].z -= 4;
  EXPECT_NE(refusal(off).find("found point 3 "), std::string::npos);
  off[2].z = NAN;
  EXPECT_NE(refusal(off).find("point 3"), std::string::npos);
  // Another piece of the file.
  mesh::Triangles two = made.mesh;
  const auto shift = static_cast<uint32_t>(two.vertices.size());
  for (const dvec3& v : made.mesh.vertices) two.vertices.push_back(v + dvec3(0, 0, 30));
  for (const auto& t : made.mesh.indices)
    two.indices.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  std::vector<dvec3> across = good;
  across[5].z += 30;
  const auto apart = mesh::Jaw(two).Crown(across);
  ASSERT_FALSE(apart.ok());
  EXPECT_NE(apart.status().message().find("does not join points 5 and 6"), std::string::npos)
      << apart.status().message();
  EXPECT_FALSE(mesh::Jaw(mesh::Triangles{}).Crown(good).ok());
}

class JawScanTest : public testing::Test {
 protected:
  static Result<ImportedScene> Import(const MadeJaw& jaw, const GumCurves& around,
                                      const std::string& unit = "mm") {
    ImportOptions options;
    options.tooth = 46;
    options.voxel_nm = 200'000;
    options.threads = 1;
    options.up = "+z";
    options.scale = {unit};
    options.around = around;
    return ImportTriangles(jaw.mesh, "made", options);
  }
};

TEST_F(JawScanTest, ACrownBecomesTheToothAndItsNeighboursStandBesideIt) {
  const MadeJaw made = MakeJaw(14, kCoarse);
  const auto alone = Import(made, {AlongGum(made, 6, 16)});
  ASSERT_TRUE(alone.ok()) << alone.status().message();
  const MadeCrown& crown = made.crowns[6];
  // Its axes are the file's; the crown stands within 7 degrees of them.
  EXPECT_NEAR(alone->size_mm.z, crown.high_mm, 0.5);
  const auto volumes = cutting::SolidVolume_m3(alone->volume);
  EXPECT_EQ(volumes[static_cast<size_t>(cutting::Tissue::kNeighbour)], 0);
  const auto with =
      Import(made, {AlongGum(made, 6, 16), AlongGum(made, 5, 16), AlongGum(made, 7, 16)});
  ASSERT_TRUE(with.ok()) << with.status().message();
  const auto beside = cutting::SolidVolume_m3(with->volume);
  for (size_t t = 1; t < cutting::kTissueCount; ++t) {
    if (static_cast<cutting::Tissue>(t) == cutting::Tissue::kNeighbour) continue;
    EXPECT_NEAR(beside[t] * 1e9, volumes[t] * 1e9, 0.2) << t << ": the tooth is the same";
  }
  // Their volume by the formula, within 2 mm of the tooth's box.
  const dvec3 up = with->placement.up, buccal = with->placement.buccal,
              mesial = glm::cross(buccal, up);
  auto turned = [&](const dvec3& p) { return dvec3(Dot(p, mesial), Dot(p, buccal), Dot(p, up)); };
  mesh::Triangles tooth = *mesh::Jaw(made.mesh).Crown(AlongGum(made, 6, 16));
  for (dvec3& v : tooth.vertices) v = turned(v);
  const mesh::Box box = mesh::BoxOf(tooth);
  double expected_mm3 = 0;
  constexpr double kStep_mm = 0.1;
  for (size_t i : {5u, 7u}) {
    const MadeCrown& n = made.crowns[i];
    const double reach = std::max(n.width_mm, n.depth_mm);
    for (double x = -reach; x < reach; x += kStep_mm)
      for (double y = -reach; y < reach; y += kStep_mm) {
        const dvec3 p = n.middle + dvec3(x, y, 0), q = turned(p);
        if (Outside_mm(n, p) > 0 || q.x < box.lo.x - 2 || q.x > box.hi.x + 2 ||
            q.y < box.lo.y - 2 || q.y > box.hi.y + 2)
          continue;
        expected_mm3 += kStep_mm * kStep_mm * std::max(0.0, HeightAt(made, p) - GumAt(made, p));
      }
  }
  const double neighbours_mm3 = beside[static_cast<size_t>(cutting::Tissue::kNeighbour)] * 1e9;
  EXPECT_NEAR(neighbours_mm3, expected_mm3, 0.1 * expected_mm3) << "their floors are flat fans";
  EXPECT_EQ(std::ranges::count(with->scene.tissues, cutting::Tissue::kNeighbour,
                               &scene::TissueSpec::tissue),
            1);
}

TEST_F(JawScanTest, RefusesWhatIsNoCrownOfATooth) {
  const MadeJaw made = MakeJaw(14, kCoarse);
  const GumCurves good = {AlongGum(made, 6, 16)};
  auto message = [&](const GumCurves& around, const std::string& unit = "mm") {
    const auto out = Import(made, around, unit);
    EXPECT_FALSE(out.ok());
    return out.ok() ? "" : out.status().message();
  };
  EXPECT_NE(message({good[0], good[0], good[0], good[0]}).find("at most two"), std::string::npos);
  EXPECT_NE(message({good[0], {good[0][0]}}).find("neighbour 1: expected 3 to 200"),
            std::string::npos);
  EXPECT_NE(message(good, "um").find("its numbers look like mm"), std::string::npos);
  EXPECT_NE(message({}).find("a scan of several teeth"), std::string::npos) << message({});
  // A curve on a tooth's top.
  std::vector<dvec3> small;
  for (const dvec3& p : AlongGum(made, 6, 16, -2.9)) small.push_back(p);
  EXPECT_NE(message({small}).find("draw it around one tooth"), std::string::npos);
}

}  // namespace
}  // namespace enamel::import
