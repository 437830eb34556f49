#include "common/base/file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>

#include "tests/support/temp_folder.h"

namespace {
bool refuse_folders = false, refuse_files = false;
}  // namespace

// In place of the C library's: a disk that fails when asked to.
extern "C" int fsync(int fd) {
  struct stat info {};
  bool folder = ::fstat(fd, &info) == 0 && S_ISDIR(info.st_mode);
  if (folder ? refuse_folders : refuse_files) {
    errno = EIO;
    return -1;
  }
  return static_cast<int>(::syscall(SYS_fsync, fd));
}

namespace enamel {
namespace {

namespace fs = std::filesystem;

class FileTest : public testing::Test {
 protected:
  ~FileTest() override { refuse_folders = refuse_files = false; }
  size_t Entries() const {
    return static_cast<size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  test::TempFolder temp_;
  const fs::path folder_ = temp_.path();
};

TEST_F(FileTest, ReplacesTheContentAndLeavesNothingElse) {
  const fs::path file = folder_ / "a";
  ASSERT_TRUE(WriteFileDurably(file, AsBytes("old")).ok());
  ASSERT_TRUE(WriteFileDurably(file, AsBytes("new")).ok());
  EXPECT_EQ(AsText(*ReadFile(file)), "new");
  EXPECT_EQ(Entries(), 1u);
}

TEST_F(FileTest, AFolderThatCannotBeSyncedIsReported) {
  refuse_folders = true;
  Status status = WriteFileDurably(folder_ / "a", AsBytes("new"));
  EXPECT_EQ(status.code(), Code::kStorage);
  EXPECT_NE(status.message().find("folder"), std::string::npos) << status.message();
}

TEST_F(FileTest, AFileThatCannotBeSyncedIsReportedAndTheOldOneStays) {
  const fs::path file = folder_ / "a";
  ASSERT_TRUE(WriteFileDurably(file, AsBytes("old")).ok());
  refuse_files = true;
  EXPECT_EQ(WriteFileDurably(file, AsBytes("new")).code(), Code::kStorage);
  EXPECT_EQ(AsText(*ReadFile(file)), "old");
  EXPECT_EQ(Entries(), 1u);
}

TEST_F(FileTest, NothingIsPutInThePlaceOfADevice) {
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(WriteFileDurably(pipe, AsBytes("new")).code(), Code::kInvalidInput);
  EXPECT_TRUE(fs::is_fifo(pipe));
  EXPECT_EQ(Entries(), 1u);
}

}  // namespace
}  // namespace enamel
