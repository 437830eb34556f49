#include "server/doctor/scrub.h"

#include <gtest/gtest.h>

// What a support bundle shows of a log.
namespace enamel::server::app {
namespace {

const Scrubber kScrubber({"anna", "Anna Schmidt", "Schmidt", "Chair 1", "Zoë", "x", "Müller"});

TEST(ScrubberTest, NamesOfTheSchoolAreTakenOutInAnyCase) {
  EXPECT_EQ(kScrubber.Scrubbed("sign-in of ANNA refused"), "sign-in of [name] refused");
  EXPECT_EQ(kScrubber.Scrubbed("Anna Schmidt, Schmidt: late."), "[name], [name]: late.");
  EXPECT_EQ(kScrubber.Scrubbed("station Chair 1 at work"), "station [name] at work");
  EXPECT_EQ(kScrubber.Scrubbed("Müller and Zoë"), "[name] and [name]");
  EXPECT_EQ(kScrubber.Scrubbed("people/anna/x"), "people/[name]/x") << "one character is no name";
  EXPECT_EQ(kScrubber.Scrubbed("Annabel"), "Annabel") << "another word";
}

TEST(ScrubberTest, WhatIsQuotedMayBeAnybodysText) {
  EXPECT_EQ(kScrubber.Scrubbed("expected a name, found \"Jo\" here"),
            "expected a name, found \"[text]\" here");
  EXPECT_EQ(kScrubber.Scrubbed("it's the server's own"), "it's the server's own");
}

TEST(ScrubberTest, OfASettingOnlyWhatNamesSomebodyIsTakenOut) {
  EXPECT_EQ(kScrubber.Scrubbed("data = '/home/anna/enamel'", false),
            "data = '/home/[name]/enamel'");
}

TEST(ScrubberTest, AddressesTokensAndKeysAreTakenOutAndNumbersStay) {
  EXPECT_EQ(kScrubber.Scrubbed("a peer at 192.0.2.7: 408"), "a peer at [address]: 408");
  EXPECT_EQ(kScrubber.Scrubbed("192.0.2.7:8443 and 2001:db8::7, ::1"),
            "[address] and [address], [address]");
  EXPECT_EQ(kScrubber.Scrubbed("write to jo.doe@example.org."), "write to [mail].");
  EXPECT_EQ(kScrubber.Scrubbed("fingerprint 01ab23cd45ef67890123456789abcdef"),
            "fingerprint [secret]");
  EXPECT_EQ(kScrubber.Scrubbed("key VBTIwFIewbJKVYeXERJfACjIqmHDUdJ, in no digit"),
            "key [secret], in no digit");
  EXPECT_EQ(kScrubber.Scrubbed("Informationssicherheitsbeauftragte"),
            "Informationssicherheitsbeauftragte");
  EXPECT_EQ(kScrubber.Scrubbed("postgresql://enamel:hunter2hunter2hunter2@db/school"), "[mail]");
  EXPECT_EQ(kScrubber.Scrubbed("took 1234 ms at 2026-09-01 08:30:12.123, version 0.1.0"),
            "took 1234 ms at 2026-09-01 08:30:12.123, version 0.1.0");
  EXPECT_EQ(kScrubber.Scrubbed("recordings are unavailable, synchronous_standby_names"),
            "recordings are unavailable, synchronous_standby_names");
}

TEST(ScrubberTest, HostsAndAllOthersOfTheirDomainAreTakenOut) {
  const Scrubber scrubber(
      {}, {"SRV7.dental.example.edu", "molar", "enamel.school.test", "localhost", ""});
  EXPECT_EQ(scrubber.Scrubbed("https://srv7.dental.example.edu:8443/x"), "https://[host]:8443/x");
  EXPECT_EQ(scrubber.Scrubbed("srv7 asks db.dental.example.edu, Molar."),
            "[host] asks [host], [host].");
  EXPECT_EQ(scrubber.Scrubbed("www.school.test in /var/lib/enamel"), "[host] in /var/lib/enamel");
  EXPECT_EQ(scrubber.Scrubbed("localhost, molars.example.org"), "localhost, molars.example.org");
  EXPECT_EQ(scrubber.Scrubbed("page-url = 'https://molar/'", false),
            "page-url = 'https://[host]/'");
}

TEST(ScrubberTest, AnIdStaysTheSameWithinOneBundleAndIsAnotherInTheNext) {
  const std::string id = "01a213df-e6ae-700b-b588-6f4b2fe580f4", line = "attempt " + id + " done";
  const std::string once = kScrubber.Scrubbed(line);
  EXPECT_EQ(once.find(id), std::string::npos);
  EXPECT_EQ(once, kScrubber.Scrubbed(line));
  EXPECT_NE(once, Scrubber({}).Scrubbed(line));
}

}  // namespace
}  // namespace enamel::server::app
