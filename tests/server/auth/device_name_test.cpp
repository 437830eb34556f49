#include "server/auth/device_name.h"

#include <gtest/gtest.h>

#include <random>

namespace enamel::server::auth {
namespace {

// As the browsers send it.
TEST(DeviceNameTest, BrowsersAndSystemsAreRecognised) {
  EXPECT_EQ(DeviceName("Mozilla/5.0 (X11; Linux x86_64; rv:140.0) Gecko/20100101 Firefox/140.0"),
            "Firefox on Linux");
  EXPECT_EQ(DeviceName("Mozilla/5.0 (Windows NT 10.0; Win64; x64) AppleWebKit/537.36 (KHTML, like "
                       "Gecko) Chrome/131.0.0.0 Safari/537.36 Edg/131.0.0.0"),
            "Edge on Windows");
  EXPECT_EQ(DeviceName("Mozilla/5.0 (Macintosh; Intel Mac OS X 10_15_7) AppleWebKit/605.1.15 "
                       "(KHTML, like Gecko) Version/18.1 Safari/605.1.15"),
            "Safari on macOS");
  EXPECT_EQ(DeviceName("Mozilla/5.0 (Linux; Android 10; K) AppleWebKit/537.36 (KHTML, like Gecko) "
                       "Chrome/131.0.0.0 Mobile Safari/537.36"),
            "Chrome on Android");
  EXPECT_EQ(
      DeviceName("Mozilla/5.0 (iPhone; CPU iPhone OS 18_1 like Mac OS X) AppleWebKit/605.1.15 "
                 "(KHTML, like Gecko) CriOS/131.0.6778.73 Mobile/15E148 Safari/604.1"),
      "Chrome on iPhone");
  EXPECT_EQ(DeviceName("curl/7.88.1"), "curl");
  EXPECT_EQ(DeviceName("Links (2.28; Linux 6.1 x86_64)"), "a browser on Linux");
  EXPECT_EQ(DeviceName("<script>"), "");
  EXPECT_EQ(DeviceName(""), "");
}

TEST(DeviceNameTest, WhatComesLateDoesNotCount) {
  EXPECT_EQ(DeviceName(std::string(512, 'x') + " Firefox/140.0"), "");
}

TEST(DeviceNameTest, WhateverIsSentItSaysOurOwnWordsOnly) {
  std::mt19937 random(7);
  const std::string parts[] = {"Firefox/", "Edg/", "Linux", "Windows", "\r\n", "\"", "<b>", "\xff"};
  for (int i = 0; i < 2000; ++i) {
    std::string sent;
    for (int k = 0; k < 12; ++k) sent += parts[random() % std::size(parts)];
    const std::string name = DeviceName(sent);
    EXPECT_LE(name.size(), 40u);
    EXPECT_EQ(name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ "),
              std::string::npos)
        << name;
  }
}

}  // namespace
}  // namespace enamel::server::auth
