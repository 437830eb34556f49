#include "server/http/tar.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "common/base/file.h"
#include "server/jobs/result_package.h"
#include "server/jobs/stored_tooth.h"
#include "tests/server/http/running_server.h"
#include "tests/server/http/school.h"
#include "tests/support/temp_folder.h"

namespace enamel::server::http {
namespace {

// The system's tar is the judge.
TEST(TarTest, AnyTarUnpacksWhatWasPutIn) {
  const test::TempFolder folder;
  Tar tar(1'793'880'000);
  const size_t sizes[] = {0, 1, 511, 512, 513, 100'000};
  auto content = [](size_t size) {
    Bytes out(size);
    for (size_t i = 0; i < size; ++i) out[i] = static_cast<uint8_t>(i * 7 + size);
    return out;
  };
  for (size_t size : sizes) tar.Add("file_" + std::to_string(size), InOnePiece(content(size)));
  tar.Add(std::string(100, 'n'), InOnePiece(content(3)));
  ASSERT_TRUE(WriteFileDurably(folder.path() / "all.tar", tar.Take(), 0600).ok());
  const std::string in = folder.path().string();
  ASSERT_EQ(std::system(("tar -xf " + in + "/all.tar -C " + in).c_str()), 0);
  for (size_t size : sizes) {
    const auto found = ReadFile(folder.path() / ("file_" + std::to_string(size)));
    ASSERT_TRUE(found.ok()) << size;
    EXPECT_EQ(*found, content(size));
  }
  EXPECT_TRUE(std::filesystem::exists(folder.path() / std::string(100, 'n')));
}

// Nothing holds the whole archive: it is read while it is sent.
TEST(TarTest, ASignedResultComesWithItsRecording) {
  School school;
  Store& store = *school.store;
  const Uuid id = school.sams_scored;
  AttemptResult result = *store.results.ResultOf(id);
  ResultDocument document;
  document.attempt = id;
  document.surface_file = HashSha256(*AttemptSurface(store.blobs, result));
  SignResult(document, trace::NewKeyPair());
  result.document = EncodeResult(document);
  ASSERT_TRUE(store.results.FinishAttempt(id, result, {}).ok());
  RunningServer server(school);
  Visitor ada(server.port(), "ada");
  const std::string target = "/api/v1/attempts/" + id.Text() + "/signed-result";
  const RawResponse answer = ada.Get(target);
  ASSERT_EQ(answer.status, 200) << answer.body;
  EXPECT_EQ(answer.headers.at("content-length"), std::to_string(answer.body.size()));
  EXPECT_EQ(ada.Get(target).body, answer.body) << "on the same connection or another";
  const test::TempFolder folder;
  folder.Write("result.tar", answer.body);
  const std::string in = folder.path().string();
  ASSERT_EQ(std::system(("tar -xf " + in + "/result.tar -C " + in).c_str()), 0);
  const auto recording = TraceFileOf(store, *store.attempts.AttemptById(id));
  ASSERT_TRUE(recording.ok()) << recording.status().message();
  EXPECT_EQ(*ReadFile(folder.path() / "recording.entrace"), *AllOf(*recording));
  // The recording is lost: refused before anything was sent.
  std::filesystem::remove_all(school.folder.path() / "data" / "blobs");
  EXPECT_EQ(ada.Get(target).status, 500);
}

}  // namespace
}  // namespace enamel::server::http
