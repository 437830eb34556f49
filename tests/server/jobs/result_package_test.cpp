#include "server/jobs/result_package.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/scene/json/json.h"
#include "server/jobs/score_job.h"
#include "server/jobs/stored_tooth.h"
#include "tests/server/jobs/job_school.h"

// A score that leaves the house with all that it was made from.
namespace enamel::server {
namespace {

using test::JobSchool;
using test::World;

class ResultPackageTest : public ::testing::Test {
 protected:
  void Score() {
    const Status status = RunScoreJob(*school_->store, attempt_, {}, nullptr, {}, &key_);
    ASSERT_TRUE(status.ok()) << status.message();
  }
  std::vector<ResultFile> Files() {
    std::vector<ResultFile> out;
    const Status status =
        ForEachResultFile(*school_->store, school_->Row(attempt_), surface_,
                          [&](std::string_view name, const Result<BytePieces>& content) -> Status {
                            ENAMEL_RETURN_IF_ERROR(content.status());
                            ENAMEL_ASSIGN_OR_RETURN(Bytes all, AllOf(*content));
                            EXPECT_EQ(all.size(), content->size) << name;
                            out.push_back({std::string(name), std::move(all)});
                            return Status::Ok();
                          });
    EXPECT_TRUE(status.ok()) << status.message();
    return out;
  }
  static ResultCheck Check(const std::vector<ResultFile>& files) {
    EXPECT_EQ(files.at(0).name, kResultFile);
    const auto document = DecodeResult(files.at(0).content);
    EXPECT_TRUE(document.ok() && VerifyResult(*document));
    return document.ok() ? CheckResultFiles(*document, files) : ResultCheck{};
  }

  const trace::KeyPair key_ = trace::NewKeyPair();
  std::unique_ptr<JobSchool> school_ = JobSchool::WithReference();
  const Uuid attempt_ = school_->Record({});
  std::function<Result<Bytes>(const AttemptResult&)> surface_ = [this](const AttemptResult& of) {
    return AttemptSurface(school_->store->blobs, of);
  };
};

TEST_F(ResultPackageTest, HasEveryFileThatTheResultBindsAsItWasSigned) {
  Score();
  const ResultCheck check = Check(Files());
  EXPECT_TRUE(check.changed.empty()) << check.changed.front();
  EXPECT_TRUE(check.not_there.empty()) << check.not_there.front();
  EXPECT_EQ(check.as_signed.size(), BoundFileNames().size());
}

TEST_F(ResultPackageTest, AnEditedFieldOfTheScoreIsFound) {
  Score();
  std::vector<ResultFile> files = Files();
  const auto score = std::ranges::find(files, "score.json", &ResultFile::name);
  ASSERT_NE(score, files.end());
  std::string text(AsText(score->content));
  const size_t at = text.find("\"points\":");
  ASSERT_NE(at, std::string::npos);
  text.insert(at + 9, "1");
  score->content.assign(text.begin(), text.end());
  const ResultCheck check = Check(files);
  ASSERT_EQ(check.changed.size(), 1U);
  EXPECT_TRUE(check.changed[0].starts_with("score.json: changed")) << check.changed[0];
}

// A correction that counts for the next run does not change what this one was judged by.
TEST_F(ResultPackageTest, KeepsTheRubricThatCounted) {
  Score();
  scene::Rubric rubric = World::Get().exercise.rubric;
  rubric.version += 1;
  rubric.prices[0].points /= 2;
  const Sha256 content = *school_->store->blobs.PutBlob(AsBytes(scene::ToJson(rubric)));
  ASSERT_TRUE(
      school_->store->rubrics
          .PublishRubric({school_->exercise, rubric.version, content, "why", 0}, Actor{{}, "test"})
          .ok());
  EXPECT_TRUE(Check(Files()).changed.empty());
  Score();
  const ResultCheck after = Check(Files());
  EXPECT_TRUE(after.changed.empty()) << after.changed.front();
}

TEST_F(ResultPackageTest, HasTheSurfaceThatTheCallerMakes) {
  Score();
  surface_ = [](const AttemptResult&) { return Result<Bytes>(Bytes{1, 2, 3}); };
  const auto files = Files();
  const auto surface = std::ranges::find(files, "surface.ensf", &ResultFile::name);
  ASSERT_NE(surface, files.end());
  EXPECT_EQ(surface->content, (Bytes{1, 2, 3}));
}

TEST_F(ResultPackageTest, WithoutAScoreOrASignatureItSaysSo) {
  auto none = [](std::string_view, const Result<BytePieces>& content) { return content.status(); };
  EXPECT_EQ(ForEachResultFile(*school_->store, school_->Row(attempt_), surface_, none).code(),
            Code::kConflict);
  ASSERT_TRUE(RunScoreJob(*school_->store, attempt_, {}).ok());
  const Status unsigned_score =
      ForEachResultFile(*school_->store, school_->Row(attempt_), surface_, none);
  EXPECT_EQ(unsigned_score.code(), Code::kConflict);
  EXPECT_NE(unsigned_score.message().find("not signed"), std::string::npos);
}

}  // namespace
}  // namespace enamel::server
