#include "common/program/private_memory.h"

#include <gtest/gtest.h>
#include <sys/prctl.h>

#include <cstdlib>

namespace enamel::program {
namespace {

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(PrivateMemoryTest, ProcessCannotBeReadOrDumped) {
  EXPECT_EXIT(
      {
        KeepMemoryPrivate();
        std::_Exit(prctl(PR_GET_DUMPABLE));
      },
      testing::ExitedWithCode(0), "");
}
#endif

}  // namespace
}  // namespace enamel::program
