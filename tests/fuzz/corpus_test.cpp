#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "common/base/file.h"

// Runs a fuzz target over its corpus in an ordinary build: whole files, every cut of them, and
// every byte changed; at most about kMaxCases of each, evenly spread over large files.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace enamel {
namespace {

#ifndef ENAMEL_CORPUS_CASES
#define ENAMEL_CORPUS_CASES 500
#endif
constexpr size_t kMaxCases = ENAMEL_CORPUS_CASES;

std::vector<std::filesystem::path> CorpusFiles() {
  std::vector<std::filesystem::path> files;
  std::stringstream folders(ENAMEL_CORPUS);
  for (std::string folder; std::getline(folders, folder, ':');) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (entry.is_regular_file()) files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

class CorpusTest : public testing::Test {
 protected:
  template <typename Case>
  void ForEachPlace(Case run) {
    for (const auto& path : CorpusFiles()) {
      SCOPED_TRACE(path.string());
      auto bytes = ReadFile(path);
      ASSERT_TRUE(bytes.ok()) << bytes.status().message();
      size_t step = bytes->size() / kMaxCases + 1;
      for (size_t i = 0; i < bytes->size(); i += step) run(*bytes, i);
    }
  }
  // In memory of exactly its size, so that a sanitizer sees a read past its end.
  static void Feed(ByteView input) {
    Bytes exact(input.begin(), input.end());
    LLVMFuzzerTestOneInput(exact.data(), exact.size());
  }
};

TEST_F(CorpusTest, HoldsForEveryFile) {
  auto files = CorpusFiles();
  ASSERT_FALSE(files.empty()) << ENAMEL_CORPUS;
  for (const auto& path : files) Feed(*ReadFile(path));
  Feed({});
}

TEST_F(CorpusTest, HoldsForEveryCut) {
  ForEachPlace([](const Bytes& bytes, size_t at) { Feed(ByteView(bytes).first(at)); });
}

TEST_F(CorpusTest, HoldsForEveryChangedByte) {
  ForEachPlace([](Bytes bytes, size_t at) {
    for (int change : {0x01, 0x80, 0xff}) {
      bytes[at] = static_cast<uint8_t>(bytes[at] ^ change);
      Feed(bytes);
      bytes[at] = static_cast<uint8_t>(bytes[at] ^ change);
    }
  });
}

}  // namespace
}  // namespace enamel
