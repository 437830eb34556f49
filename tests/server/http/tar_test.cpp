#include "server/http/tar.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "common/base/file.h"
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

}  // namespace
}  // namespace enamel::server::http
