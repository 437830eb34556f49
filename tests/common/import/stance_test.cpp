#include "common/import/stance.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "common/base/file.h"
#include "common/import/mesh_reader.h"
#include "tests/common/import/made_teeth.h"

namespace enamel::import {
namespace {

namespace fs = std::filesystem;

struct Crown {
  std::string name;
  mesh::Triangles mesh;
  int tooth;
  dvec3 up;
};

// Scanned crowns by their number: the files keep the arch's frame, where upper teeth point down.
std::vector<Crown> ScannedCrowns() {
  std::vector<Crown> out;
  const fs::path folder = fs::path(ENAMEL_SHARED_DATA) / "crowns";
  for (int tooth : {11, 13, 14, 16, 36, 46, 47}) {
    const fs::path file = folder / ("fdi_" + std::to_string(tooth) + ".obj");
    if (!fs::exists(file)) continue;
    auto mesh = ReadMesh(*ReadFile(file, mesh::kMaxMeshFile), "obj");
    EXPECT_TRUE(mesh.ok()) << mesh.status().message();
    out.push_back(
        {"scanned " + std::to_string(tooth), mesh->mesh, tooth, dvec3(0, tooth < 30 ? -1 : 1, 0)});
  }
  return out;
}

Crown Made(int tooth, std::mt19937& random) {
  return {"made " + std::to_string(tooth), MakeTooth(tooth, random).mesh, tooth, dvec3(0, 0, 1)};
}

enum class Work { kNone, kCavity, kReduced };

Crown Worked(const Crown& crown, Work work, bool open, std::mt19937& random) {
  Crown out = crown;
  const bool front = crown.tooth % 10 <= 3;
  if (work == Work::kCavity) {
    out.mesh = WithCavity(crown.mesh, crown.up, front ? 1.0 : 1.6, 1.5);
    out.name += ", cavity";
  } else if (work == Work::kReduced) {
    out.mesh = ReducedAbove(crown.mesh, crown.up, 0.3, crown.tooth > 50 ? 0.5 : 0.9);
    out.name += ", reduced";
  }
  if (open) {
    out.mesh = CutOpen(out.mesh, crown.up, 0.2, random);
    out.name += ", open";
  }
  return out;
}

struct Tally {
  int all = 0, wrong = 0, wrong_and_found = 0, guesses = 0;
  void Print(const char* what) const {
    std::printf("%s: %d stood up, %d wrong, %d of them said to be found, %d a guess\n", what, all,
                wrong, wrong_and_found, guesses);
  }
};

std::string Names(const std::vector<Witness>& by) {
  std::string out;
  for (Witness witness : by) out += std::string(WitnessName(witness)) + " ";
  return out;
}

void StandUp(const Crown& crown, const dmat3& turn, Tally& tally) {
  auto solid = mesh::MakeSolid(TurnedBy(crown.mesh, turn));
  ASSERT_TRUE(solid.ok()) << crown.name << ": " << solid.status().message();
  const FoundStance found = FindStance(*solid, crown.tooth);
  // 45 degrees: the gum's plane leans by as much against a front tooth's long axis.
  const bool wrong = Dot(found.stance.up, turn * crown.up) < 0.7;
  ++tally.all;
  tally.wrong += wrong;
  tally.guesses += !found.stance.certain;
  tally.wrong_and_found += wrong && found.stance.certain;
  EXPECT_FALSE(wrong && found.stance.certain) << crown.name << " by " << Names(found.by);
  if (wrong) std::printf("  wrong: %s\n", crown.name.c_str());
}

// Half a minute of processor for each hundred: a sample stands for all in ./check.
bool WholeTable() { return std::getenv("ENAMEL_FULL") != nullptr; }

TEST(StanceTest, ScannedCrownsStandUprightWhicheverAxisIsUp) {
  const auto crowns = ScannedCrowns();
  if (crowns.empty()) GTEST_SKIP() << "skipped: no shared data";
  std::mt19937 random(11);
  const auto turns = QuarterTurns();
  Tally tally;
  size_t next = 0;
  for (const Crown& crown : crowns)
    for (bool open : {false, true})
      for (Work work : {Work::kNone, Work::kCavity, Work::kReduced}) {
        if (!WholeTable() && work != Work::kNone) continue;
        const Crown worked = Worked(crown, work, open, random);
        for (size_t k = 0; k < (WholeTable() ? turns.size() : 1); ++k)
          StandUp(worked, turns[(7 * next++ + 3) % turns.size()], tally);
      }
  tally.Print("scanned");
  EXPECT_LE(tally.wrong, tally.all / 100);
  EXPECT_LE(tally.guesses, (WholeTable() ? 0.1 : 0.15) * tally.all);
}

TEST(StanceTest, MadeCrownsOfEveryKindStandUpright) {
  constexpr int kNumbers[] = {11, 46, 14, 13, 26, 85, 31, 71, 12, 33, 44, 17, 51, 63,
                              74, 37, 15, 48, 54, 22, 42, 25, 35, 28, 53, 83, 55, 64};
  // Another seed than the one on which stance.cpp was weighed.
  std::mt19937 random(20);
  const auto turns = QuarterTurns();
  Tally tally;
  size_t next = 0;
  for (int round = 0; round < (WholeTable() ? 4 : 1); ++round)
    for (int tooth : kNumbers) {
      if (!WholeTable() && next >= 16) break;
      const Crown crown = Made(tooth, random);
      for (bool open : {false, true})
        for (Work work : {Work::kNone, Work::kCavity, Work::kReduced}) {
          if (!WholeTable() && work != Work::kNone) continue;
          const Crown worked = Worked(crown, work, open, random);
          StandUp(worked, turns[(7 * next++ + 3) % turns.size()], tally);
        }
    }
  tally.Print("made");
  EXPECT_LE(tally.wrong, WholeTable() ? tally.all / 50 : 0);
  EXPECT_LE(tally.guesses, (WholeTable() ? 0.12 : 0.25) * tally.all);
}

// Crowns that other programs cut out of a jaw, whose hole is the gum, turned any way.
TEST(StanceTest, HolesOfBorderMeshesAreTheGum) {
  const fs::path folder = fs::path(ENAMEL_SHARED_DATA) / "borders/meshes";
  if (!fs::exists(folder)) GTEST_SKIP() << "skipped: no shared data";
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().stem();
    if (!name.starts_with("open_")) continue;
    auto mesh = ReadMesh(*ReadFile(entry.path(), mesh::kMaxMeshFile), "stl");
    ASSERT_TRUE(mesh.ok());
    auto solid = mesh::MakeSolid(mesh->mesh);
    ASSERT_TRUE(solid.ok());
    dvec3 cap(0);
    for (const auto& t : solid->mesh.indices) {
      if (std::max({t[0], t[1], t[2]}) < solid->first_cap_vertex) continue;
      const dvec3& a = solid->mesh.vertices[t[0]];
      cap += glm::cross(solid->mesh.vertices[t[1]] - a, solid->mesh.vertices[t[2]] - a);
    }
    const FoundStance found = FindStance(*solid, name == "open_incisor" ? 12 : 46);
    EXPECT_GT(Dot(found.stance.up, -glm::normalize(cap)), 0.95)
        << name << " by " << Names(found.by);
  }
}

}  // namespace
}  // namespace enamel::import
