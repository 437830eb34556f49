#include "station/hid/haptic_report.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <fstream>
#include <map>
#include <sstream>

namespace enamel::station::hid {
namespace {

namespace json = boost::json;

std::string Golden(const std::string& name) {
  std::ifstream in(std::string(ENAMEL_SOURCE_DIR) + "/schemas/golden/hid/" + name,
                   std::ios::binary);
  EXPECT_TRUE(in) << name;
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

json::object Values(const std::string& name) {
  return json::parse(Golden(name + ".json")).as_object();
}

template <typename T, size_t N>
std::array<T, N> Numbers(const json::object& values, const char* name) {
  std::array<T, N> out{};
  for (size_t i = 0; i < N; ++i) out[i] = values.at(name).as_array()[i].to_number<T>();
  return out;
}

InputReport GoldenInput() {
  json::object v = Values("input");
  InputReport r;
  r.status = v.at("status").to_number<uint8_t>();
  r.buttons = v.at("buttons").to_number<uint8_t>();
  r.sequence = v.at("sequence").to_number<uint32_t>();
  r.time_us = v.at("time_us").to_number<uint32_t>();
  r.counts = Numbers<int32_t, 3>(v, "counts");
  r.orientation = Numbers<int16_t, 4>(v, "orientation");
  r.bur_speed_krpm = v.at("bur_speed_krpm").to_number<uint16_t>();
  r.rest_nm = Numbers<int32_t, 3>(v, "rest_nm");
  r.share = v.at("share").to_number<uint16_t>();
  r.energy_nj = v.at("energy_nj").to_number<uint32_t>();
  r.work_nj = v.at("work_nj").to_number<uint32_t>();
  return r;
}

OutputReport GoldenOutput() {
  json::object v = Values("output");
  OutputReport r;
  r.motors_on = v.at("motors_on").as_bool();
  r.sequence = v.at("sequence").to_number<uint32_t>();
  r.force_100un = Numbers<int32_t, 3>(v, "force_100un");
  r.torque_un_m = Numbers<int32_t, 3>(v, "torque_un_m");
  r.watchdog_ms = v.at("watchdog_ms").to_number<uint16_t>();
  return r;
}

SpringReport GoldenSpring() {
  json::object v = Values("spring");
  SpringReport r;
  r.motors_on = v.at("motors_on").as_bool();
  r.spring_on = v.at("spring_on").as_bool();
  r.follow = v.at("follow").as_bool();
  r.sequence = v.at("sequence").to_number<uint32_t>();
  r.rest_nm = Numbers<int32_t, 3>(v, "rest_nm");
  r.force_100un = Numbers<int16_t, 3>(v, "force_100un");
  r.torque_20un_m = Numbers<int16_t, 3>(v, "torque_20un_m");
  r.share = v.at("share").to_number<uint16_t>();
  r.bound_mn = v.at("bound_mn").to_number<uint16_t>();
  r.cell_nm = Numbers<int16_t, 9>(v, "cell_nm");
  return r;
}

FeatureReport GoldenFeature() {
  json::object v = Values("feature");
  FeatureReport r;
  r.axes = v.at("axes").to_number<uint8_t>();
  r.tells_orientation = (v.at("flags").to_number<int>() & 1) != 0;
  r.resolution_nm = Numbers<uint32_t, 3>(v, "resolution_nm");
  r.peak_force_mn = Numbers<uint32_t, 3>(v, "peak_force_mn");
  r.max_watchdog_ms = v.at("max_watchdog_ms").to_number<uint16_t>();
  r.rate_hz = v.at("rate_hz").to_number<uint16_t>();
  r.name = std::string(v.at("name").as_string());
  r.profile = std::string(v.at("profile").as_string());
  r.spring_kc_mn_per_mm = v.at("spring_kc_mn_per_mm").to_number<uint32_t>();
  r.spring_rate_hz = v.at("spring_rate_hz").to_number<uint16_t>();
  r.spring_delay_ticks = v.at("spring_delay_ticks").to_number<uint8_t>();
  return r;
}

template <size_t N>
std::string Text(const std::array<uint8_t, N>& bytes) {
  return {bytes.begin(), bytes.end()};
}

TEST(HapticReportTest, EncodesTheGoldenBytes) {
  EXPECT_EQ(Text(EncodeInput(GoldenInput())), Golden("input.bin"));
  EXPECT_EQ(Text(EncodeOutput(GoldenOutput())), Golden("output.bin"));
  EXPECT_EQ(Text(EncodeSpring(GoldenSpring())), Golden("spring.bin"));
  EXPECT_EQ(Text(EncodeFeature(GoldenFeature())), Golden("feature.bin"));
}

TEST(HapticReportTest, DecodesTheGoldenBytes) {
  InputReport input;
  ASSERT_EQ(DecodeInput(AsBytes(Golden("input.bin")), input), ReportError::kNone);
  EXPECT_EQ(input, GoldenInput());
  OutputReport output;
  ASSERT_EQ(DecodeOutput(AsBytes(Golden("output.bin")), output), ReportError::kNone);
  EXPECT_EQ(output, GoldenOutput());
  SpringReport spring;
  ASSERT_EQ(DecodeSpring(AsBytes(Golden("spring.bin")), spring), ReportError::kNone);
  EXPECT_EQ(spring, GoldenSpring());
  FeatureReport feature;
  ASSERT_EQ(DecodeFeature(AsBytes(Golden("feature.bin")), feature), ReportError::kNone);
  EXPECT_EQ(feature, GoldenFeature());
}

// The published check value of CRC-16/CCITT-FALSE.
TEST(HapticReportTest, ChecksumIsThePublishedOne) {
  const ByteView bytes = AsBytes("123456789");
  EXPECT_EQ(EnCrc16(bytes.data(), bytes.size()), 0x29B1);
  EXPECT_EQ(EnCrc16(nullptr, 0), 0xFFFF);
}

TEST(HapticReportTest, EveryShorterReportIsRefusedAndLongerOnesAreTaken) {
  std::string bytes = Golden("input.bin");
  InputReport out;
  for (size_t n = 0; n < bytes.size(); ++n) {
    EXPECT_EQ(DecodeInput(AsBytes(std::string_view(bytes).substr(0, n)), out), ReportError::kShort)
        << n;
  }
  EXPECT_EQ(out, InputReport{});
  bytes.append(16, '\x55');
  EXPECT_EQ(DecodeInput(AsBytes(bytes), out), ReportError::kNone);
}

TEST(HapticReportTest, EveryFlippedBitIsRefusedForWhatItIs) {
  for (size_t i = 0; i < kInputBytes; ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string bytes = Golden("input.bin");
      bytes[i] = static_cast<char>(bytes[i] ^ 1 << bit);
      InputReport out;
      ReportError expected = i == 0   ? ReportError::kWrongId
                             : i == 1 ? ReportError::kVersion
                                      : ReportError::kChecksum;
      ASSERT_EQ(DecodeInput(AsBytes(bytes), out), expected) << i << "." << bit;
      ASSERT_EQ(out, InputReport{});
    }
  }
}

TEST(HapticReportTest, FeatureOutOfRangeIsRefused) {
  auto refused = [](auto change) {
    FeatureReport f = GoldenFeature(), out;
    change(f);
    return DecodeFeature(EncodeFeature(f), out) == ReportError::kRange;
  };
  EXPECT_TRUE(refused([](auto& f) { f.axes = 2; }));
  EXPECT_TRUE(refused([](auto& f) { f.axes = 7; }));
  EXPECT_TRUE(refused([](auto& f) { f.resolution_nm[1] = 0; }));
  EXPECT_TRUE(refused([](auto& f) { f.resolution_nm[2] = 1'000'001; }));
  EXPECT_TRUE(refused([](auto& f) { f.peak_force_mn[0] = 0; }));
  EXPECT_TRUE(refused([](auto& f) { f.max_watchdog_ms = 0; }));
  EXPECT_TRUE(refused([](auto& f) { f.rate_hz = 99; }));
  EXPECT_FALSE(refused([](auto& f) { f.axes = 6; }));
}

TEST(HapticReportTest, NamesLongerThanTheirFieldAreCut) {
  FeatureReport f = GoldenFeature(), out;
  f.name = std::string(40, 'n');
  ASSERT_EQ(DecodeFeature(EncodeFeature(f), out), ReportError::kNone);
  EXPECT_EQ(out.name, std::string(32, 'n'));
  EXPECT_EQ(out.profile, f.profile);
}

// Short items of HID 1.11, section 6.2.2: a prefix of size, type and tag, then the value.
TEST(HapticReportTest, GoldenDescriptorDeclaresTheReportsAsLongAsTheyAre) {
  const std::string d = Golden("descriptor.bin");
  std::map<std::pair<int, uint32_t>, size_t> bits;  // by main item and report id
  uint32_t page = 0, usage = 0, id = 0, size = 0, count = 0, first_page = 0, first_usage = 0;
  int depth = 0;
  for (size_t at = 0; at < d.size();) {
    auto prefix = static_cast<uint8_t>(d[at++]);
    size_t bytes = (prefix & 3) == 3 ? 4 : prefix & 3;
    uint32_t value = 0;
    for (size_t i = 0; i < bytes; ++i) {
      value |= static_cast<uint32_t>(static_cast<uint8_t>(d.at(at++))) << (8 * i);
    }
    switch (int item = prefix & 0xFC; item) {
      case 0x04:
        page = value;
        break;
      case 0x08:
        usage = value;
        break;
      case 0x84:
        id = value;
        break;
      case 0x74:
        size = value;
        break;
      case 0x94:
        count = value;
        break;
      case 0xA0:
        if (depth++ == 0) first_page = page, first_usage = usage;
        break;
      case 0xC0:
        --depth;
        break;
      case 0x80:
      case 0x90:
      case 0xB0:
        bits[{item, id}] += size_t{size} * count;
        break;
      default:
        break;
    }
  }
  EXPECT_EQ(depth, 0);
  EXPECT_EQ(first_page, kBoardUsagePage);
  EXPECT_EQ(first_usage, kBoardUsage);
  const std::map<std::pair<int, uint32_t>, size_t> expected = {
      {{0x80, kInputId}, 8 * (kInputBytes - 1)},
      {{0x90, kOutputId}, 8 * (kOutputBytes - 1)},
      {{0x90, kSpringId}, 8 * (kSpringBytes - 1)},
      {{0xB0, kFeatureId}, 8 * (kFeatureBytes - 1)}};
  EXPECT_EQ(bits, expected);
}

}  // namespace
}  // namespace enamel::station::hid
