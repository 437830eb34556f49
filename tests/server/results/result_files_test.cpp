#include "server/results/result_files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>

#include "common/base/file.h"
#include "tests/support/temp_folder.h"

// A signed result and the files beside it: nothing in any of them can be changed unseen, by us or
// by schemas/verify_result.py.
namespace enamel::server {
namespace {

namespace fs = std::filesystem;

Bytes OfText(const std::string& text) { return Bytes(text.begin(), text.end()); }

struct Package {
  ResultDocument document;
  std::vector<ResultFile> files;  // without result.bin
};

Package MakePackage() {
  Package out;
  ResultDocument& d = out.document;
  const std::pair<const char*, Sha256 ResultDocument::*> texts[] = {
      {"score.json", &ResultDocument::score_file},
      {"tooth.envb", &ResultDocument::tooth_file},
      {"surface.ensf", &ResultDocument::surface_file},
      {"forces.json", &ResultDocument::series_file},
      {"exercise.json", &ResultDocument::exercise},
      {"rubric.json", &ResultDocument::rubric},
      {"scene.json", &ResultDocument::scene},
      {"start.envb", &ResultDocument::volume},
      {"profile.json", &ResultDocument::profile}};
  for (const auto& [name, hash] : texts) {
    out.files.push_back({name, OfText(std::string("what is in ") + name)});
    d.*hash = HashSha256(out.files.back().content);
  }
  auto recording = ReadFile(fs::path(ENAMEL_SOURCE_DIR) / "schemas/golden/trace/recording.bin");
  EXPECT_TRUE(recording.ok());
  auto trace = trace::DecodeTraceFile(*recording);
  EXPECT_TRUE(trace.ok() && trace->seal);
  d.attempt = trace->seal->attempt;
  d.header = HashSha256(trace->header);
  d.recording = trace->seal->last_chunk;
  d.points = 83.25;
  out.files.push_back({"recording.entrace", *recording});
  std::array<uint8_t, 32> seed;
  seed.fill(7);
  SignResult(d, trace::KeyPairFromSeed(seed));
  return out;
}

TEST(ResultFilesTest, AllAreAsSigned) {
  const Package package = MakePackage();
  const ResultCheck check = CheckResultFiles(package.document, package.files);
  EXPECT_EQ(check.as_signed.size(), BoundFileNames().size());
  EXPECT_TRUE(check.not_there.empty());
  EXPECT_TRUE(check.changed.empty()) << check.changed.front();
}

TEST(ResultFilesTest, AnyChangedBitOfAnyFileIsFoundInThatFile) {
  const Package package = MakePackage();
  for (const ResultFile& file : package.files) {
    ResultFile changed = file;
    for (size_t bit = 0; bit < file.content.size() * 8; ++bit) {
      changed.content[bit / 8] ^= static_cast<uint8_t>(1 << bit % 8);
      const ResultCheck check = CheckResultFiles(package.document, {changed});
      ASSERT_EQ(check.changed.size(), 1U) << file.name << ", bit " << bit;
      EXPECT_TRUE(check.changed[0].starts_with(file.name)) << check.changed[0];
      EXPECT_TRUE(check.as_signed.empty());
      changed.content[bit / 8] = file.content[bit / 8];
    }
  }
}

TEST(ResultFilesTest, AFileThatWasCutOffOrGrewOrIsAnotherIsFound) {
  const Package package = MakePackage();
  for (const ResultFile& file : package.files) {
    for (size_t size = 0; size < file.content.size(); ++size) {
      const ResultFile cut{
          file.name, Bytes(file.content.begin(), file.content.begin() + static_cast<long>(size))};
      EXPECT_EQ(CheckResultFiles(package.document, {cut}).changed.size(), 1U)
          << file.name << " of " << size;
    }
    ResultFile longer = file;
    longer.content.push_back(0);
    EXPECT_EQ(CheckResultFiles(package.document, {longer}).changed.size(), 1U) << file.name;
    const ResultFile other{file.name, package.files[file.name == "score.json" ? 1 : 0].content};
    EXPECT_EQ(CheckResultFiles(package.document, {other}).changed.size(), 1U) << file.name;
  }
}

TEST(ResultFilesTest, WhatIsNotThereIsSaid) {
  const Package package = MakePackage();
  const ResultCheck check = CheckResultFiles(package.document, {package.files[0]});
  EXPECT_EQ(check.as_signed, std::vector<std::string>{"score.json"});
  EXPECT_EQ(check.not_there.size(), BoundFileNames().size() - 1);
}

// The script is at most sixty lines, for whoever checks a grade reads it first.
TEST(ResultFilesTest, ThePythonScriptIsShortAndNeedsNothingOfOurs) {
  const auto script = ReadFile(fs::path(ENAMEL_SOURCE_DIR) / "schemas/verify_result.py");
  ASSERT_TRUE(script.ok());
  EXPECT_LE(std::ranges::count(*script, '\n'), 60);
}

// tests/server/results/verify_result_edits.py changes every bit of result.bin and of the small
// files, and cuts and lengthens each.
TEST(ResultFilesTest, ThePythonScriptFindsEveryEditToo) {
  if (std::system("python3 -c 'import cryptography' 2>/dev/null") != 0) {
    GTEST_SKIP() << "python3-cryptography is not installed";
  }
  const Package package = MakePackage();
  const test::TempFolder folder;
  for (const ResultFile& file : package.files) {
    ASSERT_TRUE(WriteFileDurably(folder.path() / file.name, file.content).ok());
  }
  ASSERT_TRUE(WriteFileDurably(folder.path() / kResultFile, EncodeResult(package.document)).ok());
  const std::string command = std::string("python3 -B ") + ENAMEL_SOURCE_DIR +
                              "/tests/server/results/verify_result_edits.py " +
                              folder.path().string();
  EXPECT_EQ(std::system(command.c_str()), 0);
}

}  // namespace
}  // namespace enamel::server
