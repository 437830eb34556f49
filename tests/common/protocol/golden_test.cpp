#include <google/protobuf/util/json_util.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/base/file.h"
#include "common/base/hex.h"
#include "common/protocol/frame.h"
#include "common/protocol/messages.h"

namespace enamel::protocol {
namespace {

namespace pb = google::protobuf;

std::filesystem::path Folder() {
  return std::filesystem::path(ENAMEL_SOURCE_DIR) / "schemas/golden/wire";
}

Bytes Read(const std::string& name) {
  auto bytes = ReadFile(Folder() / name);
  EXPECT_TRUE(bytes.ok()) << bytes.status().message();
  return bytes.ok() ? *bytes : Bytes();
}

Bytes OnlyMessageOf(ByteView stream) {
  FrameReader reader;
  while (!reader.done() && !stream.empty()) {
    auto space = reader.Prepare();
    size_t n = std::min(space.size(), stream.size());
    std::copy_n(stream.begin(), n, space.begin());
    EXPECT_TRUE(reader.Resume(n).ok());
    stream = stream.subspan(n);
  }
  EXPECT_TRUE(reader.done() && stream.empty());
  return reader.done() ? reader.Take() : Bytes();
}

class WireGoldenTest : public testing::TestWithParam<std::string> {
 protected:
  std::string name_ = GetParam();
  bool is_request_ = name_.starts_with("request");

  std::unique_ptr<pb::Message> New() const {
    if (is_request_) return std::make_unique<wire::Request>();
    return std::make_unique<wire::Reply>();
  }
  // Protobuf's own JSON form: bytes are base64, 64-bit numbers text.
  std::unique_ptr<pb::Message> Described() const {
    auto message = New();
    Bytes text = Read(name_ + ".json");
    auto status = pb::util::JsonStringToMessage(std::string(AsText(text)), message.get());
    EXPECT_TRUE(status.ok()) << status.ToString();
    return message;
  }
};

TEST_P(WireGoldenTest, FrameReadsAsDescribed) {
  Bytes bytes = OnlyMessageOf(Read(name_ + ".bin"));
  auto expected = Described();
  if (is_request_) {
    auto request = ParseRequest(bytes);
    ASSERT_TRUE(request.ok()) << request.status().message();
    EXPECT_TRUE(pb::util::MessageDifferencer::Equals(*request, *expected));
  } else {
    auto reply = ParseReply(bytes);
    ASSERT_TRUE(reply.ok()) << reply.status().message();
    EXPECT_TRUE(pb::util::MessageDifferencer::Equals(*reply, *expected));
  }
}

TEST_P(WireGoldenTest, DescriptionIsWrittenToTheSameFrame) {
  EXPECT_EQ(ToHex(*EncodeFrame(Serialize(*Described()))), ToHex(Read(name_ + ".bin")));
}

// Every description there is: a message is added by adding one.
std::vector<std::string> Names() {
  std::vector<std::string> out;
  for (const auto& entry : std::filesystem::directory_iterator(Folder())) {
    if (entry.path().extension() == ".json") out.push_back(entry.path().stem().string());
  }
  std::ranges::sort(out);
  return out;
}

TEST(WireGoldenFolderTest, FramesHaveDescriptionsAndThereAreAtLeastSixteen) {
  size_t frames = 0;
  for (const auto& entry : std::filesystem::directory_iterator(Folder())) {
    frames += entry.path().extension() == ".bin";
  }
  EXPECT_EQ(frames, Names().size());
  EXPECT_GE(frames, 16u);
}

INSTANTIATE_TEST_SUITE_P(Messages, WireGoldenTest, testing::ValuesIn(Names()),
                         [](const auto& message) { return message.param; });

}  // namespace
}  // namespace enamel::protocol
