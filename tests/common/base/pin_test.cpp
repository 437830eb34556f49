#include "common/base/pin.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <set>
#include <string>

namespace enamel {
namespace {

std::string FieldOf(const std::string& pin) { return CheckPin(pin).field(); }

TEST(PinTest, EachRuleRefusesItsPinsByItsName) {
  struct Case {
    const char* pin;
    const char* field;  // "": it is taken
  };
  for (const auto& [pin, field] : {
           Case{"", kPinDigits},
           {"12345", kPinDigits},
           {"1212", kPinDigits},
           {"1234567890123", kPinDigits},
           {"12345a", kPinDigits},
           {"12 456", kPinDigits},
           {"\xd9\xa1\xd9\xa2\xd9\xa3", kPinDigits},
           {"000000", kPinRepeats},
           {"111111", kPinRepeats},
           {"121212", kPinRepeats},
           {"7070707", kPinRepeats},
           {"222222222222", kPinRepeats},
           {"012345", kPinRun},
           {"123456", kPinRun},
           {"987654", kPinRun},
           {"567890", kPinRun},
           {"321098", kPinRun},
           {"123456789012", kPinRun},
           {"240699", kPinDate},    // DDMMYY
           {"062499", kPinDate},    // MMDDYY
           {"990624", kPinDate},    // YYMMDD
           {"290200", kPinDate},    // a leap day
           {"061999", kPinDate},    // MMYYYY
           {"199906", kPinDate},    // YYYYMM
           {"24061999", kPinDate},  // DDMMYYYY
           {"06241999", kPinDate},  // MMDDYYYY
           {"19990624", kPinDate},  // YYYYMMDD
           {"804217", ""},
           {"121213", kPinDate},
           {"321398", ""},
           {"300299", ""},  // no such day
           {"24061899", ""},
           {"24062100", ""},
           {"2406199", ""},
           {"112233445566", ""},
       }) {
    const Status status = CheckPin(pin);
    EXPECT_EQ(status.field(), field) << pin;
    EXPECT_EQ(status.ok(), *field == '\0') << pin;
    if (status.ok()) continue;
    EXPECT_EQ(status.code(), Code::kInvalidInput) << pin;
    EXPECT_NE(status.message().find("choose digits"), std::string::npos) << status.message();
  }
}

// The calendar of the standard library against the rule's own table of months.
TEST(PinTest, OfSixDigitsTheDatesOfTheCalendarAreRefusedAndNoOthers) {
  using std::chrono::sys_days, std::chrono::year_month_day, std::chrono::days;
  std::set<std::string> dates;
  const auto add = [&](auto... parts) {
    char text[16];
    std::snprintf(text, sizeof text, parts...);
    dates.insert(text);
  };
  // 2000 to 2099 have each year of two digits once; their leap years do, too. A leap day in
  // another year is a date for the rule as well.
  const sys_days leap_year = std::chrono::year(2000) / 1 / 1;
  for (int i = 0; i < 366; ++i) {
    const year_month_day day(leap_year + days(i));
    const unsigned m = unsigned(day.month()), d = unsigned(day.day());
    for (unsigned y = 0; y < 100; ++y) {
      add("%02u%02u%02u", d, m, y);
      add("%02u%02u%02u", m, d, y);
      add("%02u%02u%02u", y, m, d);
    }
    for (unsigned y = 1900; y < 2100; ++y) {
      add("%02u%04u", m, y);
      add("%04u%02u", y, m);
    }
  }
  EXPECT_EQ(dates.size(), 86'344u);
  int differ = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    char pin[8];
    std::snprintf(pin, sizeof pin, "%06d", i);
    const std::string field = FieldOf(pin);
    const bool other = field == kPinRepeats || field == kPinRun;
    if (!other && (field == kPinDate) != dates.contains(pin)) ++differ;
  }
  EXPECT_EQ(differ, 0);
}

}  // namespace
}  // namespace enamel
