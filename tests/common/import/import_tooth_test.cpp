#include "common/import/import_tooth.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <random>

#include "common/base/file.h"
#include "common/base/uuid.h"
#include "common/import/child_process.h"
#include "common/import/scene_folder.h"
#include "common/mesh/mesh_repair.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/json/json.h"
#include "common/scene/plan.h"
#include "shapes.h"
#include "tests/common/import/made_teeth.h"
#include "tests/common/import/report_lines.h"
#include "tests/support/test_name.h"

namespace enamel::import {
namespace {

namespace fs = std::filesystem;
using cutting::Tissue;

const fs::path kShared = ENAMEL_SHARED_DATA;

double Solid_mm3(const cutting::Volume& v) {
  double sum = 0;
  for (double t : cutting::SolidVolume_m3(v)) sum += t * 1e9;
  return sum;
}

struct TempFolder {
  fs::path path = fs::temp_directory_path() / ("enamel-import-" + Uuid::New().Text());
  TempFolder() { fs::create_directories(path); }
  ~TempFolder() { fs::remove_all(path); }
  fs::path Write(const std::string& name, const std::string& text) const {
    std::ofstream(path / name) << text;
    return path / name;
  }
};

TEST(ImportTest, SphereHasTheVolumeOfASphere) {
  ImportOptions options{.tooth = 46};
  options.voxel_nm = 100'000;
  auto s = ImportTriangles(SphereMesh(5, 60), "test", options);
  ASSERT_TRUE(s.ok()) << s.status().message();
  double ideal = 4.0 / 3 * std::numbers::pi * 125;
  EXPECT_NEAR(Solid_mm3(s->volume) / ideal, 1, 0.005);
  EXPECT_NEAR(Solid_mm3(s->volume) / s->mesh_volume_mm3, 1, 0.002);
}

TEST(ImportTest, DistanceInTheVolumeIsTheSpheresDistance) {
  ImportOptions options{.tooth = 46};
  options.voxel_nm = 100'000;
  auto s = ImportTriangles(SphereMesh(5, 90), "test", options);
  ASSERT_TRUE(s.ok());
  dvec3 u = dvec3(2, 3, 6) / 7.0;
  for (double d = -0.35; d < 0.36; d += 0.05) {
    EXPECT_NEAR(s->volume.DistanceAt_m(u * (5 + d) * 1e-3) * 1e3, d, 0.01);
  }
}

TEST(ImportTest, OverlappingPartsBecomeOneSolidWithoutInnerWalls) {
  ImportOptions options{.tooth = 46};
  options.voxel_nm = 200'000;
  auto s = ImportTriangles(
      Joined(BoxMesh({-5, -3, -3}, {2, 3, 3}), BoxMesh({-2, -2.9, -2.9}, {5, 2.9, 2.9})), "test",
      options);
  ASSERT_TRUE(s.ok()) << s.status().message();
  double ideal = 7 * 36 + 3 * 5.8 * 5.8;
  EXPECT_NEAR(Solid_mm3(s->volume) / ideal, 1, 0.01);
}

TEST(ImportTest, TwoBodiesAreNoTooth) {
  const mesh::Triangles tooth = SphereMesh(4, 12), beside = SphereMesh(3, 12, {9, 0, 0});
  ImportOptions options{.tooth = 46};
  options.voxel_nm = 200'000;
  auto both = ImportTriangles(Joined(tooth, beside), "test", options);
  ASSERT_FALSE(both.ok());
  EXPECT_EQ(both.status().code(), Code::kInvalidInput);
  EXPECT_NE(both.status().message().find("found 2 bodies"), std::string::npos)
      << both.status().message();
  auto crumb = ImportTriangles(Joined(tooth, SphereMesh(0.5, 6, {6, 0, 0})), "test", options);
  EXPECT_TRUE(crumb.ok()) << crumb.status().message();
}

TEST(ImportTest, WrongUnitIsRefusedWithTheOneThatFits) {
  ImportOptions options{.tooth = 46};
  options.scale.unit = "m";
  Status refused = ImportTriangles(SphereMesh(6, 10), "test", options).status();
  EXPECT_EQ(refused.code(), Code::kInvalidInput);
  EXPECT_NE(refused.message().find("12000.00 mm"), std::string::npos) << refused.message();
  EXPECT_NE(refused.message().find("look like mm"), std::string::npos) << refused.message();
}

TEST(ImportTest, EveryUnitGivesTheSameTooth) {
  const std::pair<const char*, double> units[] = {
      {"um", 1e3}, {"cm", 0.1}, {"m", 1e-3}, {"inch", 1 / 25.4}};
  for (auto [name, factor] : units) {
    ImportOptions options{.tooth = 46};
    options.scale.unit = name;
    options.voxel_nm = 400'000;
    auto s = ImportTriangles(SphereMesh(5 * factor, 20), "test", options);
    ASSERT_TRUE(s.ok()) << name << s.status().message();
    EXPECT_NEAR(s->mesh_volume_mm3, 520, 10);
  }
}

TEST(ImportTest, BadOptionsAreRefusedByName) {
  ImportOptions options{.tooth = 46};
  options.scale.unit = "furlong";
  EXPECT_EQ(ImportTriangles(SphereMesh(5, 8), "test", options).status().field(), "unit");
  options = {.tooth = 46};
  for (const char* up : {"north", "", "1,2", "1,2,3,4", "0,0,0", "1,,2", "nan,0,1", "1e300,0,0"}) {
    options.up = up;
    EXPECT_EQ(ImportTriangles(SphereMesh(5, 8), "test", options).status().field(), "up") << up;
  }
  options = {.tooth = 46};
  options.voxel_nm = 1;
  EXPECT_EQ(ImportTriangles(SphereMesh(5, 8), "test", options).status().field(), "voxel_nm");
  options = {.tooth = 46};
  options.buccal = "outwards";
  EXPECT_EQ(ImportTriangles(SphereMesh(5, 8), "test", options).status().field(), "buccal");
  options.up = "+z", options.buccal = "-z";
  EXPECT_EQ(ImportTriangles(SphereMesh(5, 8), "test", options).status().field(), "buccal");
  for (int tooth : {0, 10, 19, 50, 56, 91}) {
    const Status refused = ImportTriangles(SphereMesh(5, 8), "test", {.tooth = tooth}).status();
    EXPECT_EQ(refused.field(), "tooth") << tooth;
    EXPECT_NE(refused.message().find("FDI number"), std::string::npos) << refused.message();
  }
}

TEST(ImportTest, GivenUpBecomesTheScenesZ) {
  ImportOptions options{.tooth = 46};
  options.voxel_nm = 200'000;
  options.up = "-x";
  auto s = ImportTriangles(BoxMesh({0, 0, 0}, {4, 6, 8}), "test", options);
  ASSERT_TRUE(s.ok());
  // 4 along z, the longer of the others along x, top of the box at z = 2.
  EXPECT_LT(s->volume.DistanceAt_m(dvec3(3.7, 2.7, 1.7) * 1e-3), 0);
  EXPECT_GT(s->volume.DistanceAt_m(dvec3(0, 0, 2.3) * 1e-3), 0);
  EXPECT_GT(s->volume.DistanceAt_m(dvec3(0, 3.3, 0) * 1e-3), 0);
  EXPECT_NEAR(s->scene.landmarks.at("occlusal_centre")[2], 2000, 2);
}

// A box of 4 x 6 x 8 mm, 4 mm high: a lower molar is longer from mesial to distal, a premolar
// across.
TEST(ImportTest, TheToothsNumberSaysWhichWayItsLongerSideLies) {
  for (int tooth : {11, 36, 46, 52, 74, 14, 16, 23, 34, 55}) {
    ImportOptions options{.tooth = tooth, .voxel_nm = 200'000, .up = "-x"};
    auto s = ImportTriangles(BoxMesh({0, 0, 0}, {4, 6, 8}), "test", options);
    ASSERT_TRUE(s.ok()) << s.status().message();
    EXPECT_EQ(s->scene.tooth, tooth);
    const bool along_x = tooth == 11 || tooth == 36 || tooth == 46 || tooth == 52 || tooth == 74;
    EXPECT_EQ(s->volume.DistanceAt_m({3.7e-3, 0, 0}) < 0, along_x) << tooth;
    EXPECT_EQ(s->volume.DistanceAt_m({0, 3.7e-3, 0}) < 0, !along_x) << tooth;
    EXPECT_FALSE(s->placement.buccal_given);
  }
}

// A wedge whose tall end is at +y of the file: it gets the given orientation.
TEST(ImportTest, AGivenBuccalDirectionBecomesTheScenesY) {
  mesh::Triangles wedge = BoxMesh({0, 0, 0}, {6, 8, 4});
  for (dvec3& v : wedge.vertices) {
    if (v.y < 4 && v.z > 2) v.z = 2;
  }
  for (const char* buccal : {"+y", "-y", "+x"}) {
    ImportOptions options{.tooth = 46, .voxel_nm = 200'000, .up = "+z", .buccal = buccal};
    auto s = ImportTriangles(wedge, "test", options);
    ASSERT_TRUE(s.ok()) << s.status().message();
    const double near_top = 1.2e-3, end = 3.5e-3;
    auto solid = [&](const dvec3& p) { return s->volume.DistanceAt_m(p) < 0; };
    EXPECT_EQ(solid({0, end, near_top}), std::string(buccal) == "+y") << buccal;
    EXPECT_EQ(solid({0, -end, near_top}), std::string(buccal) == "-y") << buccal;
    // +x of the file is buccal, so that its +y is at the scene's -x.
    EXPECT_EQ(solid({-end, 0, near_top}), std::string(buccal) == "+x") << buccal;
    EXPECT_TRUE(s->placement.buccal_given);
  }
}

TEST(ImportTest, SceneFolderReadsBackAndASwappedVolumeIsFound) {
  TempFolder folder;
  ImportOptions options{.tooth = 46};
  options.voxel_nm = 400'000;
  auto a = ImportTriangles(SphereMesh(5, 10), "test", options),
       b = ImportTriangles(SphereMesh(4, 10), "test", options);
  ASSERT_TRUE(a.ok() && b.ok());
  ASSERT_TRUE(WriteSceneFolder(folder.path / "a", *a).ok());
  ASSERT_TRUE(WriteSceneFolder(folder.path / "b", *b).ok());
  auto back = LoadSceneFolder(folder.path / "a");
  ASSERT_TRUE(back.ok()) << back.status().message();
  EXPECT_TRUE(back->volume == a->volume);
  EXPECT_EQ(scene::ToJson(back->scene), scene::ToJson(a->scene));
  fs::copy_file(folder.path / "b/volume.envb", folder.path / "a/volume.envb",
                fs::copy_options::overwrite_existing);
  EXPECT_EQ(LoadSceneFolder(folder.path / "a").status().code(), Code::kConflict);
  EXPECT_EQ(LoadSceneFolder(folder.path / "none").status().code(), Code::kNotFound);
}

TEST(ImportChildTest, AsciiStlOfACubeInCentimetresIsRead) {
  TempFolder folder;
  mesh::Triangles cube = BoxMesh(dvec3(0), dvec3(1));
  std::string text = "solid cube\n";
  for (const auto& t : cube.indices) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (uint32_t i : t) {
      const dvec3& v = cube.vertices[i];
      text += "vertex " + std::to_string(v.x) + " " + std::to_string(v.y) + " " +
              std::to_string(v.z) + "\n";
    }
    text += "endloop\nendfacet\n";
  }
  ImportOptions options{.tooth = 46};
  options.scale.unit = "cm";
  options.voxel_nm = 200'000;
  auto s = ImportTooth(folder.Write("Cube \xff\n1.STL", text + "endsolid cube\n"), options);
  ASSERT_TRUE(s.ok()) << s.status().message();
  EXPECT_NEAR(Solid_mm3(s->volume), 1000, 2);
  EXPECT_EQ(s->scene.name, "cube---1");
  EXPECT_TRUE(scene::SceneFromJson(scene::ToJson(s->scene)).ok());
}

TEST(ImportChildTest, ReaderOpensNoOtherFile) {
  TempFolder folder;
  fs::path trap = folder.path / "trap.mtl";
  // A pipe that nobody writes to: opening it would hang until the reader's deadline.
  ASSERT_EQ(mkfifo(trap.c_str(), 0600), 0);
  std::string text = "mtllib trap.mtl\n";
  mesh::Triangles cube = BoxMesh(dvec3(0), dvec3(10));
  for (const dvec3& v : cube.vertices) {
    text +=
        "v " + std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z) + "\n";
  }
  for (const auto& t : cube.indices) {
    text += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " +
            std::to_string(t[2] + 1) + "\n";
  }
  ImportOptions options{.tooth = 46};
  options.voxel_nm = 400'000;
  auto s = ImportTooth(folder.Write("cube.obj", text), options);
  ASSERT_TRUE(s.ok()) << s.status().message();
  EXPECT_NEAR(s->mesh_volume_mm3, 1000, 1e-6);
}

std::string ObjPart(const std::string& heading, const mesh::Triangles& mesh, size_t first_vertex) {
  std::string text = heading + "\n";
  for (const dvec3& v : mesh.vertices)
    text +=
        "v " + std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z) + "\n";
  for (const auto& t : mesh.indices)
    text += "f " + std::to_string(first_vertex + t[0]) + " " + std::to_string(first_vertex + t[1]) +
            " " + std::to_string(first_vertex + t[2]) + "\n";
  return text;
}

double TissueVolume(const ImportedScene& s, Tissue t) {
  return cutting::SolidVolume_m3(s.volume)[static_cast<size_t>(t)] * 1e9;
}

// Three nested boxes (walls between samples) as parts of one file, by objects, groups or materials,
// or as files.
class PartsTest : public testing::Test {
 protected:
  PartsTest() { options_.voxel_nm = 100'000, options_.up = "+z"; }
  std::string File(const std::string& kind, const std::array<const char*, 3>& names) const {
    std::string text = "mtllib none.mtl\n";
    size_t first = 1;
    for (size_t i = 0; i < 3; ++i) {
      text += ObjPart(kind + " " + names[i], boxes_[i], first);
      first += boxes_[i].vertices.size();
    }
    return text;
  }
  void ExpectBoxes(const Result<ImportedScene>& s) const {
    ASSERT_TRUE(s.ok()) << s.status().message();
    EXPECT_NEAR(TissueVolume(*s, Tissue::kEnamel), 1000 - 328.509, 5);
    EXPECT_NEAR(TissueVolume(*s, Tissue::kDentin), 328.509 - 24.389, 3);
    EXPECT_NEAR(TissueVolume(*s, Tissue::kPulp), 24.389, 1);
  }
  TempFolder folder_;
  ImportOptions options_{.tooth = 46};
  const std::array<mesh::Triangles, 3> boxes_ = {BoxMesh(dvec3(-5), dvec3(5)),
                                                 BoxMesh(dvec3(-3.45), dvec3(3.45)),
                                                 BoxMesh(dvec3(-1.45), dvec3(1.45))};
};

TEST_F(PartsTest, AreKnownByTheirNamesWhetherObjectsGroupsOrMaterials) {
  for (const char* kind : {"o", "g", "usemtl"})
    ExpectBoxes(ImportTooth(
        folder_.Write("t.obj", File(kind, {"Enamel_outer", "DENTIN", "the pulp"})), options_));
}

TEST_F(PartsTest, AreTakenByTheNamesGivenAndOthersAreListed) {
  const fs::path file = folder_.Write("t.obj", File("g", {"white", "yellow", "red"}));
  ExpectBoxes(ImportTooth(ImportSources{file, {"White", "yell", "red"}}, options_));
  ExpectBoxes(ImportTooth(
      ImportSources{{},
                    {file.string() + "#white", file.string() + "#yellow", file.string() + "#red"}},
      options_));
  const Status refused = ImportTooth(ImportSources{file, {"white", "blue", ""}}, options_).status();
  EXPECT_EQ(refused.field(), "dentin");
  EXPECT_NE(refused.message().find("'white', 'yellow', 'red'"), std::string::npos)
      << refused.message();
}

TEST_F(PartsTest, WholeCrownBesideFilesOfWhatIsInItIsTheEnamel) {
  const fs::path crown = folder_.Write("crown.obj", ObjPart("o crown", boxes_[0], 1)),
                 dentin = folder_.Write("d.obj", ObjPart("o a", boxes_[1], 1)),
                 pulp = folder_.Write("p.obj", ObjPart("o b", boxes_[2], 1));
  ExpectBoxes(ImportTooth(ImportSources{crown, {"", dentin.string(), pulp.string()}}, options_));
  ExpectBoxes(
      ImportTooth(ImportSources{{}, {crown.string(), dentin.string(), pulp.string()}}, options_));
  EXPECT_EQ(ImportTooth(ImportSources{crown, {crown.string(), dentin.string(), ""}}, options_)
                .status()
                .field(),
            "file");
  EXPECT_EQ(ImportTooth(ImportSources{}, options_).status().code(), Code::kInvalidInput);
}

TEST(ImportChildTest, MissingFileUnknownKindAndEmptyFileAreRefused) {
  TempFolder folder;
  EXPECT_EQ(ImportTooth(folder.path / "none.stl", {.tooth = 46}).status().code(), Code::kNotFound);
  EXPECT_EQ(ImportTooth(folder.Write("tooth.doc", "x"), {.tooth = 46}).status().code(),
            Code::kInvalidInput);
  Status empty = ImportTooth(folder.Write("tooth.stl", ""), {.tooth = 46}).status();
  EXPECT_NE(empty.message().find("empty"), std::string::npos) << empty.message();
}

fs::path OwnReader() {
  return fs::read_symlink("/proc/self/exe").parent_path() / "enamel-import-child";
}

// In a child: a kernel that takes no filter, then the mesh reader.
[[noreturn]] void BecomeUnconfinableReader(const fs::path& reader, const fs::path& file,
                                           int errors) {
  sock_filter steps[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_prctl, 0, 3),
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, args[0])),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, PR_SET_SECCOMP, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EINVAL),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  sock_fprog filter{6, steps};
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 ||
      prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter, 0, 0) != 0 ||
      dup2(errors, STDERR_FILENO) < 0)
    _exit(99);
  if (dup2(open(file.c_str(), O_RDONLY), STDIN_FILENO) < 0) _exit(97);
  execl(reader.c_str(), reader.c_str(), "stl", nullptr);
  _exit(98);
}

TEST(ImportChildTest, ReaderThatCannotBeConfinedReadsNothingAndSaysWhy) {
  TempFolder folder;
  const fs::path file = folder.Write("tooth.stl", "solid\nendsolid\n");
  const fs::path reader = OwnReader();
  int ends[2];  // a pipe: the reader may write no file, not even for its errors
  ASSERT_EQ(pipe2(ends, O_CLOEXEC), 0);
  const pid_t pid = fork();
  ASSERT_GE(pid, 0);
  if (pid == 0) BecomeUnconfinableReader(reader, file, ends[1]);
  close(ends[1]);
  char text[1000];
  const ssize_t size = read(ends[0], text, sizeof text);
  close(ends[0]);
  int status = 0;
  ASSERT_EQ(waitpid(pid, &status, 0), pid);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == 99) GTEST_SKIP() << "this kernel takes no filter to test with";
  EXPECT_EQ(WEXITSTATUS(status), 1);
  ASSERT_GT(size, 0);
  const std::string said(text, static_cast<size_t>(size));
  EXPECT_NE(said.find("not read unconfined"), std::string::npos) << said;
}

fs::path Script(TempFolder& folder, const std::string& text) {
  const fs::path script = folder.Write("reader.sh", "#!/bin/sh\n" + text);
  fs::permissions(script, fs::perms::owner_all);
  return script;
}

// Two reads would hash what nobody looked at.
TEST(ImportChildTest, HashIsOfWhatWasReadAlsoWhenTheFileIsWrittenMeanwhile) {
  TempFolder folder;
  const std::string before =
      "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
      "endloop\nendfacet\nendsolid\n";
  const fs::path file = folder.Write("tooth.stl", before);
  const fs::path child = Script(
      folder, "echo other > '" + file.string() + "'\nexec '" + OwnReader().string() + "' \"$1\"\n");
  auto read = ReadMeshInChild(file, child);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->mesh.mesh.indices.size(), 1u);
  EXPECT_EQ(read->sha256, HashSha256(AsBytes(before)));
  EXPECT_EQ(fs::file_size(file), 6u) << "the script was to change it";
}

TEST(ImportChildTest, ReasonOfTheReaderIsOneLineThatATerminalDoesNotObey) {
  TempFolder folder;
  const fs::path file = folder.Write("tooth.stl", "x");
  const fs::path child =
      Script(folder, "printf 'no\\177pe\\302\\233 \\033[1m\\nat all\\n' >&2\nexit 1\n");
  EXPECT_EQ(ReadMeshInChild(file, child).status().message(),
            "tooth.stl: no\\x7fpe\\x9b \\x1b[1m at all");
}

TEST(ImportChildTest, FileOfHundredsOfMegabytesIsRefusedBeforeItIsRead) {
  TempFolder folder;
  const fs::path file = folder.Write("huge.stl", "x");
  fs::resize_file(file, 500'000'084);  // ten million triangles; takes no room on the disk
  const Status refused = ImportTooth(file, {.tooth = 46}).status();
  EXPECT_NE(refused.message().find("at most 256 MiB, found one of 476 MiB"), std::string::npos)
      << refused.message();
}

TEST(ImportTest, ToothFarFromItsOriginIsRefusedWhereItsCoordinatesAreFloats) {
  mesh::Triangles far = SphereMesh(5, 20, {1e6, 0, 0});
  const ImportOptions options{.tooth = 46, .voxel_nm = 400'000};
  auto doubles = ImportTriangles(far, "test", options);
  EXPECT_TRUE(doubles.ok()) << doubles.status().message();
  for (dvec3& v : far.vertices) v = dvec3(glm::vec3(v));
  const Status refused = ImportTriangles(far, "test", options).status();
  EXPECT_NE(refused.message().find("steps of 119.2 um"), std::string::npos) << refused.message();
}

TEST(ImportTest, AnUnknownScaleIsNamedAndAGivenOneTaken) {
  ImportOptions options{.tooth = 46, .voxel_nm = 400'000};
  const Status refused = ImportTriangles(SphereMesh(42, 20), "test", options).status();
  EXPECT_NE(refused.message().find("give its longest side in mm"), std::string::npos)
      << refused.message();
  options.scale.factor = 0.125;
  auto taken = ImportTriangles(SphereMesh(42, 20), "test", options);
  ASSERT_TRUE(taken.ok()) << taken.status().message();
  EXPECT_NEAR(taken->mesh_volume_mm3, 600, 10);
  // The length in mm alone decides for a ball of 84 in the file; neither unit nor scale counts.
  options.scale = {"m", 1, 10.5};
  taken = ImportTriangles(SphereMesh(42, 20), "test", options);
  ASSERT_TRUE(taken.ok()) << taken.status().message();
  EXPECT_NEAR(taken->mesh_volume_mm3, 600, 10);
  options.scale.longest_mm = 41;
  EXPECT_EQ(ImportTriangles(SphereMesh(42, 20), "test", options).status().field(), "longest_mm");
  options.scale = {"mm", 0};
  EXPECT_EQ(ImportTriangles(SphereMesh(42, 20), "test", options).status().field(), "scale");
}

TEST(ImportChildTest, MissingReaderIsSaid) {
  TempFolder folder;
  ImportOptions options{.tooth = 46};
  options.child = folder.path / "no-such-program";
  EXPECT_EQ(ImportTooth(folder.Write("tooth.stl", "solid"), options).status().code(),
            Code::kNotFound);
}

TEST(ImportChildTest, ReaderThatFloodsItsOutputIsNoCrash) {
  TempFolder folder;
  fs::path fake =
      folder.Write("fake", "#!/bin/sh\nhead -c 300000 /dev/zero\nhead -c 100000 /dev/zero >&2\n");
  fs::permissions(fake, fs::perms::owner_all);
  ImportOptions options{.tooth = 46};
  options.child = fake;
  EXPECT_FALSE(ImportTooth(folder.Write("tooth.stl", "solid"), options).ok());
}

std::vector<fs::path> FilesIn(const fs::path& folder) {
  std::vector<fs::path> out;
  if (!fs::exists(folder)) return out;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) out.push_back(entry.path());
  }
  std::sort(out.begin(), out.end());
  return out;
}

// Volumes of the files' own triangles by the divergence theorem, computed apart from this project.
const std::map<std::string, double> kCrowns_mm3 = {
    {"fdi_11", 187.335}, {"fdi_13", 199.386}, {"fdi_14", 230.194}, {"fdi_16", 464.665},
    {"fdi_36", 417.822}, {"fdi_46", 465.268}, {"fdi_47", 328.003}};

TEST(RealCrownTest, EveryCrownImportsWithItsMeshsVolume) {
  auto files = FilesIn(kShared / "crowns");
  if (files.empty()) GTEST_SKIP() << "skipped: no shared data";
  for (const fs::path& file : files) {
    if (file.extension() != ".obj") continue;
    ImportOptions options{.tooth = 46};
    options.voxel_nm = 100'000;
    auto s = ImportTooth(file, options);
    ASSERT_TRUE(s.ok()) << s.status().message();
    EXPECT_GT(s->mesh_volume_mm3, 100);
    const auto known = kCrowns_mm3.find(file.stem().string());
    if (known != kCrowns_mm3.end()) {
      EXPECT_NEAR(Solid_mm3(s->volume) / known->second, 1, 0.002) << file;
    }
    EXPECT_NEAR(Solid_mm3(s->volume) / s->mesh_volume_mm3, 1, 0.002) << file;
    const auto& p = s->scene.landmarks.at("occlusal_centre");
    EXPECT_NEAR(s->volume.DistanceAt_m(dvec3(p[0], p[1], p[2]) * 1e-6), 0, 30e-6) << file;
    EXPECT_TRUE(scene::SceneFromJson(scene::ToJson(s->scene)).ok());
  }
}

mesh::Triangles SolidOf(const fs::path& file) {
  auto mesh = ReadMeshInChild(file);
  EXPECT_TRUE(mesh.ok()) << mesh.status().message();
  auto solid = mesh::MakeSolid(mesh->mesh.mesh);
  EXPECT_TRUE(solid.ok()) << solid.status().message();
  return solid->mesh;
}

mesh::Triangles Around(const mesh::Triangles& mesh, double scale, double noise_mm, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-noise_mm, noise_mm);
  dvec3 middle(0);
  for (const dvec3& v : mesh.vertices) middle += v / static_cast<double>(mesh.vertices.size());
  mesh::Triangles out = mesh;
  for (dvec3& v : out.vertices)
    v = middle + scale * (v - middle) + dvec3(uniform(random), uniform(random), uniform(random));
  return out;
}

// Noise of the size of a scan's, which folds the surfaces in places, and gaps and crossings of up
// to 0.1 mm between an enamel shell and its dentin.
TEST(RealCrownTest, NoisySurfacesPerTissueLeaveNoAirInside) {
  if (!fs::exists(kShared / "crowns")) GTEST_SKIP() << "skipped: no shared data";
  const mesh::Triangles crown = SolidOf(kShared / "crowns/fdi_46.obj");
  ImportOptions options{.tooth = 46};
  options.up = "+y";
  options.voxel_nm = 50'000;
  auto whole = ImportTriangles(crown, "test", options);
  auto layers = ImportLayers({Joined(crown, Reversed(Around(crown, 0.85, 0.015, 1))),
                              Around(crown, 0.853, 0.02, 2), Around(crown, 0.4, 0.01, 3)},
                             "test", options);
  ASSERT_TRUE(whole.ok());
  ASSERT_TRUE(layers.ok()) << layers.status().message();
  ASSERT_TRUE(whole->volume.spec() == layers->volume.spec());
  const ivec3 n = whole->volume.spec().voxels();
  int air = 0, thin = 0;  // three voxels below the outer surface
  for (int z = 0; z < n.z; ++z)
    for (int y = 0; y < n.y; ++y)
      for (int x = 0; x < n.x; ++x) {
        if (whole->volume.PhiAt({x, y, z}) > -3 * cutting::kPhiPerVoxel) continue;
        air += layers->volume.PhiAt({x, y, z}) > 0;
        thin += layers->volume.PhiAt({x, y, z}) > -cutting::kPhiPerVoxel;
      }
  EXPECT_EQ(air, 0);
  // Voxels near what is left of folds: of three million, and 2000 when every fold is kept.
  EXPECT_LT(thin, 300);
  EXPECT_NEAR(Solid_mm3(layers->volume) / Solid_mm3(whole->volume), 1, 1e-3);
}

TEST(ImportTest, EveryKindOfCrownHasAPulpAndThinEnamelWhereItIsPrimaryOrInFront) {
  std::mt19937 random(3);
  for (int tooth : {71, 85, 54, 12}) {
    const MadeTooth made = MakeTooth(tooth, random);
    ImportOptions options{.tooth = tooth, .voxel_nm = 200'000, .up = "+z"};
    auto s = ImportTriangles(made.mesh, "test", options);
    ASSERT_TRUE(s.ok()) << s.status().message();
    const double pulp = TissueVolume(*s, Tissue::kPulp), all = Solid_mm3(s->volume);
    EXPECT_GT(pulp, 0.005 * all) << tooth;
    EXPECT_LT(pulp, 0.15 * all) << tooth;
    if (tooth > 50) {
      EXPECT_NE(Lines(*s).find("enamel up to " + std::string(tooth == 71 ? "0." : "1.0")),
                std::string::npos)
          << tooth << Lines(*s);
    }
  }
}

// Straight in from a point outside, mm.
double EnamelAlong(const cutting::Volume& volume, dvec3 p_m, const dvec3& way) {
  const double step_m = 0.02e-3;
  double seen = 0;
  for (double gone = 0; gone < 12e-3; gone += step_m, p_m += step_m * way) {
    if (volume.DistanceAt_m(p_m) >= 0) continue;
    if (volume.TissueAtPoint(p_m) != Tissue::kEnamel) break;
    seen += step_m * 1e3;
  }
  return seen;
}

// A scanner sees a crown down to the gum. The proximal bound is the published range of
// premolars and twice its SD (tissues.cpp), taken half-way up; the bound of the fossa is chosen.
TEST(ImportTest, AScannedShellHasAPulpAndEnamelAsTeethHave) {
  std::mt19937 random(5);
  for (int tooth : {46, 37, 14, 24, 11}) {
    const MadeTooth made = MakeTooth(tooth, random);
    const mesh::Triangles shell = CutOpen(made.mesh, dvec3(0, 0, 1), 0.15, random);
    ImportOptions options{.tooth = tooth, .voxel_nm = 100'000, .up = "+z"};
    auto s = ImportTriangles(shell, "test", options);
    ASSERT_TRUE(s.ok()) << s.status().message();
    // The roof of the chamber is 2.9 mm below the fossa, and 0.4 mm above the cut nothing is pulp.
    const double below_mm =
        1e-3 * s->scene.landmarks.at("occlusal_centre")[2] + 0.5 * mesh::BoxOf(shell).size().z;
    const bool has_room = below_mm > 3.5;
    EXPECT_EQ(TissueVolume(*s, Tissue::kPulp) > 0.5, has_room) << tooth << Lines(*s);
    EXPECT_EQ(Lines(*s).find("no pulp has room") == std::string::npos, has_room) << Lines(*s);
    if (tooth == 11) continue;
    // Half-way up, under the fossa's ground.
    const double z_m = -0.05e-3 * mesh::BoxOf(shell).size().z;
    const double mean = 0.5 * (EnamelAlong(s->volume, {10e-3, 0, z_m}, {-1, 0, 0}) +
                               EnamelAlong(s->volume, {-10e-3, 0, z_m}, {1, 0, 0}));
    EXPECT_GT(mean, 0.86) << tooth;
    EXPECT_LT(mean, 1.75) << tooth;
    const double fossa = EnamelAlong(s->volume, {0, 0, 10e-3}, {0, 0, -1});
    EXPECT_GT(fossa, 0.5) << tooth;
    EXPECT_LT(fossa, 1.5) << tooth;
  }
}

// A ball has neither cusps nor a gum. What was said of it, given again, gives the same tooth.
TEST(ImportTest, PlacementNamesTheDirectionsAndWhetherTheyAreAGuess) {
  ImportOptions options{.tooth = 46, .voxel_nm = 400'000};
  auto guess = ImportTriangles(SphereMesh(5, 20), "test", options);
  ASSERT_TRUE(guess.ok());
  EXPECT_EQ(guess->placement.up_is, Placement::Up::kGuess);
  auto text = [](const dvec3& v) {
    return std::to_string(v.x) + "," + std::to_string(v.y) + "," + std::to_string(v.z);
  };
  options.up = text(guess->placement.up), options.buccal = text(guess->placement.buccal);
  auto given = ImportTriangles(SphereMesh(5, 20), "test", options);
  ASSERT_TRUE(given.ok()) << given.status().message();
  EXPECT_EQ(given->placement.up_is, Placement::Up::kGiven);
  EXPECT_TRUE(given->placement.by.empty());
  EXPECT_EQ(given->scene.volume, guess->scene.volume);
}

// A box of 4 x 6 x 8 whose up leans 30 degrees from its z to its x: 4 cos 30 + 8 sin 30 wide.
TEST(ImportTest, ADirectionBetweenTheFilesAxesIsTaken) {
  ImportOptions options{.tooth = 46, .voxel_nm = 200'000, .up = "1,0,1.7320508", .buccal = "+y"};
  auto s = ImportTriangles(BoxMesh({0, 0, 0}, {4, 6, 8}), "test", options);
  ASSERT_TRUE(s.ok()) << s.status().message();
  EXPECT_NEAR(s->size_mm.x, 7.4641, 1e-3);
  EXPECT_NEAR(s->size_mm.y, 6, 1e-6);
  EXPECT_NEAR(s->size_mm.z, 8.9282, 1e-3);
  EXPECT_NEAR(s->placement.up.x, 0.5, 1e-6);
}

TEST(RealCrownTest, ClassOneCavityOnAMolarKeepsClearOfThePulpAndMeetsEnamelFirst) {
  if (!fs::exists(kShared / "crowns")) GTEST_SKIP() << "skipped: no shared data";
  ImportOptions options{.tooth = 46};
  options.voxel_nm = 100'000;
  auto s = ImportTooth(kShared / "crowns/fdi_46.obj", options);
  ASSERT_TRUE(s.ok()) << s.status().message();
  auto exercise = scene::ClassOneExercise(s->scene, HashSha256(AsBytes(scene::ToJson(s->scene))));
  EXPECT_TRUE(scene::CompilePlan(s->scene, exercise, scene::BuiltinProfiles()[1]).ok());
  const auto& c = s->scene.landmarks.at("occlusal_centre");
  EXPECT_EQ(s->volume.TissueAtPoint(dvec3(c[0], c[1], c[2] - 200) * 1e-6), Tissue::kEnamel);
  bool dentin = false;
  for (int x = -2300; x <= 2300; x += 100)
    for (int y = -1500; y <= 1500; y += 100)
      for (int z = -2600; z <= 0; z += 100) {
        dvec3 p = dvec3(c[0] + x, c[1] + y, c[2] + z) * 1e-6;
        if (s->volume.DistanceAt_m(p) > 0) continue;
        ASSERT_NE(s->volume.TissueAtPoint(p), Tissue::kPulp);
        dentin |= s->volume.TissueAtPoint(p) == Tissue::kDentin;
      }
  EXPECT_TRUE(dentin);
}

// The outcome of each file in one unit: the tooth's volume, computed apart from this project by the
// divergence theorem over the file's own triangles (not_convex, two_objects and joined_tetrahedra:
// of the union), or a piece of the refusal.
struct Outcome {
  const char* file;
  const char* unit;
  double volume_mm3;  // 0: refused
  const char* says = "";
};

constexpr Outcome kOutcomes[] = {
    {"7_8ths_cube.stl", "mm", 55999.996},
    {"ballA.off", "mm", 1401.105},
    {"ballB.off", "mm", 1401.105},
    {"busted.STL", "mm", 526.4489},
    {"comments.off", "mm", 12.316808},
    {"cube.OBJ", "cm", 1000},
    {"cylinder.stl", "mm", 25.092388},
    {"empty.obj", "mm", 0, "holds no triangles"},
    {"empty.ply", "mm", 0, "holds no triangles"},
    {"empty.stl", "mm", 0, "no triangles"},
    {"emptyIO/obj_empty.obj", "mm", 0, "holds no triangles"},
    {"emptyIO/obj_points.obj", "mm", 0, "holds no triangles"},
    {"emptyIO/obj_wireframe.obj", "mm", 0, "holds no triangles"},
    {"emptyIO/ply_empty_ascii.ply", "mm", 0, "holds no triangles"},
    {"emptyIO/ply_empty_bin.ply", "mm", 0, "holds no triangles"},
    {"emptyIO/ply_empty_header.ply", "mm", 0, "holds no triangles"},
    {"emptyIO/ply_points_ascii.ply", "mm", 0, "holds no triangles"},
    {"emptyIO/ply_points_bin.ply", "mm", 0, "holds no triangles"},
    {"emptyIO/stl_empty_ascii.stl", "mm", 0, "holds no triangles"},
    {"emptyIO/stl_empty_bin.stl", "mm", 0, "holds no triangles"},
    {"face_in_group_name.obj", "mm", 0, "holds no triangles"},
    {"face_in_group_name_mid_file.obj", "mm", 0, "at least 4 triangles"},
    {"featuretype.STL", "mm", 11.627733},
    {"jacked.obj", "cm", 1000},
    {"joined_tetrahedra.obj", "cm", 866.025},
    {"metadata.ply", "mm", 0, "at least 4 triangles"},
    {"mirror.ply", "cm", 67.042},
    {"multi.ply", "cm", 0, "at least 4 triangles"},
    {"nancolor.obj", "cm", 1000},
    {"negative_indices.obj", "cm", 8000},
    {"not_convex.obj", "cm", 30.815},
    {"notenoughindices.obj", "mm", 0, "1000.00 mm"},
    {"obj_with_no_face_in_chunk.obj", "mm", 0, "at least 4 triangles"},
    {"origin_inside.STL", "cm", 968.75},
    {"plane.ply", "cm", 0, "at least 4 triangles"},
    {"plane_tri.ply", "cm", 0, "at least 4 triangles"},
    {"points_ascii.ply", "mm", 0, "holds no triangles"},
    {"points_ascii_with_lists.ply", "mm", 0, "holds no triangles"},
    {"points_bin.ply", "mm", 0, "holds no triangles"},
    {"points_emptyascii.ply", "mm", 0, "lines follow"},
    {"points_emptyface.ply", "mm", 0, "holds no triangles"},
    {"polygonfaces.obj", "mm", 0, "1000.00 mm"},
    {"reference.ply", "mm", 0, "188.56 mm"},
    {"shared.STL", "cm", 2000},
    {"singlevn.obj", "mm", 0, "1000.00 mm"},
    {"soup.stl", "cm", 0, "open sheet"},
    {"sphere.ply", "cm", 4152.74},
    {"tet.ply", "cm", 1333.333},
    {"tube.obj", "mm", 8.618539},
    {"two_objects.obj", "cm", 1000},
    {"two_objects_mixed_case_names.stl", "mm", 0, "2 bodies apart"},
    {"unit_cube.STL", "cm", 1000},
    {"unit_sphere.STL", "cm", 4152.741},
    {"whitespace.off", "mm", 12.316808},
    {"cube.OBJ", "mm", 0, "look like cm or inch"},
    {"unit_sphere.STL", "m", 0, "2000.00 mm"},
};

class OddMeshTest : public testing::TestWithParam<Outcome> {};

TEST_P(OddMeshTest, HasItsVolumeOrIsRefusedWithTheReason) {
  const Outcome& expected = GetParam();
  const fs::path file = kShared / "meshes_odd/models" / expected.file;
  if (!fs::exists(file)) GTEST_SKIP() << "skipped: no shared data";
  ImportOptions options{.tooth = 46};
  options.scale.unit = expected.unit;
  // About a ten-thousandth of the volume in a voxel, so that thin ones are met too.
  options.voxel_nm =
      std::clamp(static_cast<int>(std::cbrt(expected.volume_mm3) * 2e4), 50'000, 500'000);
  auto s = ImportTooth(file, options);
  if (expected.volume_mm3 > 0) {
    ASSERT_TRUE(s.ok()) << s.status().message();
    EXPECT_NEAR(Solid_mm3(s->volume) / expected.volume_mm3, 1, 0.03) << Lines(*s);
  } else {
    ASSERT_FALSE(s.ok()) << Lines(*s);
    EXPECT_EQ(s.status().code(), Code::kInvalidInput);
    EXPECT_NE(s.status().message().find(expected.says), std::string::npos) << s.status().message();
  }
}

INSTANTIATE_TEST_SUITE_P(Files, OddMeshTest, testing::ValuesIn(kOutcomes), [](const auto& i) {
  return test::TestName(std::string(i.param.file) + " as " + i.param.unit);
});

TEST(OddMeshFolderTest, EveryFileHasAnExpectedOutcome) {
  auto files = FilesIn(kShared / "meshes_odd/models");
  if (files.empty()) GTEST_SKIP() << "skipped: no shared data";
  // Files with parts that overlap or are turned, with no volume to compare with.
  const std::vector<std::string> others = {"multibody.stl", "wallhole.obj"};
  for (const fs::path& file : files) {
    const std::string name = file.lexically_relative(kShared / "meshes_odd/models").string();
    const bool known = std::any_of(std::begin(kOutcomes), std::end(kOutcomes),
                                   [&](const Outcome& o) { return name == o.file; });
    if (known) continue;
    EXPECT_NE(std::find(others.begin(), others.end(), name), others.end()) << name;
  }
}

}  // namespace
}  // namespace enamel::import
