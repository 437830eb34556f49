#include <gtest/gtest.h>

#include "server/stations/session.h"
#include "tests/server/stations/link_world.h"

// What holds the tool in graded work: asked for with the ticket, recorded in the header, looked at
// when the attempt is opened.
namespace enamel::server::stations {
namespace {

using namespace testing;

const Hand kBoard = MakeHand(HandKind::kHaptic, "omega.3", "hid", "hid:1209:0001:A7");
const Hand kMouse = MakeHand(HandKind::kPointer, "mouse and keyboard", "mouse");
const Hand kDentist = MakeHand(HandKind::kProgram, "simulated device", "operator dentist");

class HandTest : public StudentAtStation {
 protected:
  HandTest() {
    terms_ = world_.store->assignments.AssignmentsFor(world_.student)->front().assignment;
    Allow(HandsAllowed::kListed);
  }

  void Allow(HandsAllowed hands) {
    terms_.hands = hands;
    auto row = world_.store->assignments.ReplaceAssignment(terms_, kSystem);
    ASSERT_TRUE(row.ok()) << row.status().message();
    terms_ = *row;
  }
  wire::Reply Ask(const Hand& hand) {
    station_.hand = hand;
    return station_.RequestTicket(world_.exercise.content, profile_);
  }
  // Opened, uploaded and sealed, as made with `hand`.
  AttemptRow Made(const wire::Reply& ticket, const Hand& hand) {
    EXPECT_TRUE(ticket.has_ticket_issued()) << ticket.error().message();
    Recording recording(world_, TicketOf(ticket), station_.keys, 1, hand);
    EXPECT_TRUE(station_.Open(recording.header).has_attempt_opened());
    EXPECT_TRUE(station_.Put(recording.chunks[0]).has_chunk_ack());
    EXPECT_TRUE(station_.Seal(recording.seal).has_sealed());
    return *world_.store->attempts.AttemptById(recording.header_fields.ticket.attempt);
  }

  AssignmentRow terms_;
};

TEST_F(HandTest, NewAssignmentAdmitsListedDevicesAlone) {
  EXPECT_EQ(AssignmentRow().hands, HandsAllowed::kListed);
  for (const Hand& hand : {kDentist, kMouse, kBoard, Hand()}) {
    const wire::Error error = Ask(hand).error();
    EXPECT_EQ(error.code(), "forbidden") << HandText(hand);
    EXPECT_EQ(error.field(), "hand") << HandText(hand);
  }
  ASSERT_TRUE(world_.store->devices.ListDevice("hid:1209:0001:A7", "chair 3", kSystem).ok());
  wire::Reply ticket = Ask(kBoard);
  ASSERT_TRUE(ticket.has_ticket_issued()) << ticket.error().message();
  EXPECT_EQ(ticket.ticket_issued().hands(), "listed");
  EXPECT_EQ(Ask(kDentist).error().field(), "hand") << "the list is of devices with motors";
  Hand other = kBoard;
  other.unit = "hid:1209:0001:A8";
  EXPECT_EQ(Ask(other).error().field(), "hand") << "another unit of the same model";
  ASSERT_TRUE(world_.store->devices.UnlistDevice("hid:1209:0001:A7", kSystem).ok());
  EXPECT_EQ(Ask(kBoard).error().field(), "hand");
}

TEST_F(HandTest, AssignmentAdmitsWhatItSays) {
  Allow(HandsAllowed::kHaptic);
  EXPECT_TRUE(Ask(kBoard).has_ticket_issued());
  EXPECT_EQ(Ask(kMouse).error().field(), "hand");
  Allow(HandsAllowed::kPointer);
  EXPECT_TRUE(Ask(kMouse).has_ticket_issued());
  EXPECT_EQ(Ask(kDentist).error().field(), "hand");
  Allow(HandsAllowed::kAny);
  EXPECT_TRUE(Ask(kDentist).has_ticket_issued());
  EXPECT_TRUE(Ask(Hand()).has_ticket_issued()) << "none named";
}

TEST_F(HandTest, ExamOfPracticeIsHeldToItTooAndPracticeIsNot) {
  AssignedRow practice{terms_, world_.exercise, 0};
  practice.exercise.graded = false;
  EXPECT_EQ(HandsFor(practice), HandsAllowed::kAny);
  practice.assignment.exam = true;
  EXPECT_EQ(HandsFor(practice), HandsAllowed::kListed);
}

TEST_F(HandTest, RecordingSaysWhatHeldTheTool) {
  Allow(HandsAllowed::kHaptic);
  AttemptRow row = Made(Ask(kBoard), kBoard);
  EXPECT_EQ(row.hand, kBoard);
  EXPECT_EQ(row.hands, HandsAllowed::kHaptic);
  EXPECT_EQ(row.flags & kOtherHand, 0u);
  EXPECT_EQ(row.state, AttemptState::kSealed);
}

// The station's program was changed, or the device was, between ticket and attempt.
TEST_F(HandTest, AttemptOfAHandThatItsTermsDoNotAdmitIsKeptAndNotScored) {
  Allow(HandsAllowed::kHaptic);
  AttemptRow row = Made(Ask(kBoard), kDentist);
  EXPECT_EQ(row.hand, kDentist);
  EXPECT_EQ(row.flags & kOtherHand, uint32_t{kOtherHand});
  EXPECT_EQ(row.state, AttemptState::kQuarantined);
  EXPECT_NE(row.problem.find("held the tool"), std::string::npos) << row.problem;
}

TEST_F(HandTest, TermsAreThoseOfTheTicket) {
  Allow(HandsAllowed::kAny);
  wire::Reply ticket = Ask(kDentist);
  Allow(HandsAllowed::kListed);
  EXPECT_EQ(Made(ticket, kDentist).state, AttemptState::kSealed);
}

TEST_F(HandTest, TicketForLaterNeedNotSayYetAndItsAttemptIsLookedAt) {
  Allow(HandsAllowed::kHaptic);
  wire::Request later;
  wire::RequestTicket& body = *later.mutable_request_ticket();
  body.set_session(station_.session);
  body.set_exercise(protocol::ToField(world_.exercise.content.view()));
  body.set_profile(protocol::ToField(profile_.view()));
  body.set_for_later(true);
  body.set_station_unix_ms(world_.now);
  wire::Reply ticket = station_.Send(later);
  ASSERT_TRUE(ticket.has_ticket_issued()) << ticket.error().message();
  EXPECT_EQ(ticket.ticket_issued().hands(), "haptic");
  EXPECT_EQ(Made(ticket, kMouse).state, AttemptState::kQuarantined);
  protocol::SetHand(kMouse, *body.mutable_hand());
  EXPECT_EQ(station_.Send(later).error().field(), "hand") << "said, it is looked at";
}

TEST_F(HandTest, TicketSaysWhetherTheOutlineIsShown) {
  ASSERT_TRUE(world_.exercise.graded);
  for (const auto& [outline, shown] : {std::pair{OutlineShown::kPractice, false},
                                       {OutlineShown::kAlways, true},
                                       {OutlineShown::kNever, false}}) {
    terms_.outline = outline;
    Allow(HandsAllowed::kAny);
    const wire::Reply ticket = Ask(kMouse);
    ASSERT_TRUE(ticket.has_ticket_issued()) << ticket.error().message();
    EXPECT_EQ(ticket.ticket_issued().outline(), shown) << OutlineShownName(outline);
  }
}

TEST_F(HandTest, StationIsToldInTheList) {
  Allow(HandsAllowed::kPointer);
  wire::Request list;
  list.mutable_list_exercises()->set_session(station_.session);
  EXPECT_EQ(station_.Send(list).exercises().exercises(0).hands(), "pointer");
}

}  // namespace
}  // namespace enamel::server::stations
