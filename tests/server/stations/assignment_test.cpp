#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "server/stations/session.h"
#include "server/training/access.h"
#include "tests/server/stations/link_world.h"

// Tickets under assignments: dates, limits, exams.
namespace enamel::server::stations {
namespace {

using namespace testing;

constexpr UnixMs kHour = 3'600'000;

class AssignmentTest : public StudentAtStation {
 protected:
  AssignmentTest() {
    open_ = world_.store->assignments.AssignmentsFor(world_.student)->front().assignment;
  }

  // A connection of its own.
  ScriptedStation::Ask Asking() {
    auto session = std::make_shared<Session>(world_.services, "127.0.0.1");
    return [session](const wire::Request& request) {
      return session->Handle(request).reply.value_or(wire::Reply());
    };
  }
  // The cohort's assignment with other terms.
  void Change(const std::function<void(AssignmentRow&)>& change) {
    change(open_);
    auto row = world_.store->assignments.ReplaceAssignment(open_, kSystem);
    ASSERT_TRUE(row.ok()) << row.status().message();
    open_ = *row;
  }
  void Remark(const Uuid& attempt, const Uuid& author, uint64_t tick, const std::string& text) {
    AnnotationRow row;
    row.attempt = attempt;
    row.author = author;
    row.tick = tick;
    row.text = text;
    const Actor by{author, "page"};
    ASSERT_TRUE(world_.store->remarks.AddAnnotation(row, by).ok());
  }
  wire::Reply Ask() { return station_.RequestTicket(world_.exercise.content, profile_); }
  AttemptRow RowOf(const wire::Reply& ticket) {
    EXPECT_TRUE(ticket.has_ticket_issued()) << ticket.error().message();
    return *world_.store->attempts.AttemptById(trace::DecodeTicket(TicketOf(ticket))->attempt);
  }
  wire::ExerciseRef Listed() {
    wire::Request list;
    list.mutable_list_exercises()->set_session(station_.session);
    auto reply = station_.Send(list);
    EXPECT_EQ(reply.exercises().exercises_size(), 1);
    return reply.exercises().exercises(0);
  }

  AssignmentRow open_;
};

TEST_F(AssignmentTest, StationIsToldDatesLimitsAndWhatIsInTheWay) {
  Change([&](AssignmentRow& row) {
    row.opens_ms = world_.now + kHour;
    row.due_ms = world_.now + 2 * kHour;
    row.attempt_limit = 2;
  });
  wire::ExerciseRef ref = Listed();
  EXPECT_EQ(ref.assignment(), protocol::ToField(open_.id.view()));
  EXPECT_EQ(ref.opens_unix_ms(), open_.opens_ms);
  EXPECT_EQ(ref.due_unix_ms(), open_.due_ms);
  EXPECT_EQ(ref.attempts_left(), 2u);
  EXPECT_EQ(ref.refusal().field(), "opens") << ref.refusal().message();
  EXPECT_EQ(Ask().error().code(), "forbidden");
  EXPECT_EQ(Ask().error().message(), ref.refusal().message());
  world_.now = open_.opens_ms;
  EXPECT_FALSE(Listed().has_refusal());
  AttemptRow row = RowOf(Ask());
  EXPECT_EQ(row.assignment, open_.id);
  EXPECT_EQ(row.due_ms, open_.due_ms);
  EXPECT_EQ(Listed().attempts_left(), 1u);
}

TEST_F(AssignmentTest, AfterItIsDueTicketsAreRefusedOrFlaggedLate) {
  Change([&](AssignmentRow& row) { row.due_ms = world_.now + kHour; });
  EXPECT_EQ(trace::DecodeTicket(TicketOf(Ask()))->expires_unix_ms, open_.due_ms)
      << "nothing begins after it is due";
  world_.now = open_.due_ms + 1;
  EXPECT_EQ(Ask().error().field(), "due");
  Change([](AssignmentRow& row) { row.late_allowed = true; });
  wire::Reply late = Ask();
  EXPECT_TRUE(late.ticket_issued().late());
  EXPECT_EQ(RowOf(late).flags, uint32_t{kLate});
}

TEST_F(AssignmentTest, LimitIsUsedUpUntilAnAttemptIsExcused) {
  Change([](AssignmentRow& row) { row.attempt_limit = 1; });
  AttemptRow first = RowOf(Ask());
  wire::Reply refused = Ask();
  EXPECT_EQ(refused.error().field(), "attempt_limit");
  EXPECT_NE(refused.error().message().find("1 is used"), std::string::npos)
      << refused.error().message();
  ASSERT_TRUE(world_.store->judging.FlagAttempt(first.id, kExcused, "power cut", kSystem).ok());
  EXPECT_TRUE(Ask().has_ticket_issued());
}

TEST_F(AssignmentTest, TicketHandedBackUnusedLeavesTheLimitAsItWas) {
  Change([](AssignmentRow& row) { row.attempt_limit = 1; });
  Bytes ticket = TicketOf(Ask());
  Uuid attempt = trace::DecodeTicket(ticket)->attempt;
  EXPECT_EQ(Ask().error().field(), "attempt_limit");
  for (int again = 0; again < 2; ++again) {
    wire::Reply reply = station_.ReturnTicket(attempt);
    ASSERT_TRUE(reply.has_ticket_returned()) << reply.error().message();
    EXPECT_EQ(reply.ticket_returned().attempt(), protocol::ToField(attempt.view()));
  }
  EXPECT_EQ(Listed().attempts_left(), 1u);
  Recording recording(world_, ticket, station_.keys, 1);
  wire::Reply opened = station_.Open(recording.header);
  EXPECT_EQ(opened.error().code(), "conflict") << "a returned ticket is void";
  EXPECT_EQ(opened.error().field(), "ticket");
  EXPECT_EQ(station_.Put(recording.chunks[0]).error().code(), "not_found");
  EXPECT_EQ(station_.OfferTickets({attempt}).attempts_wanted().revoked_size(), 1);
  EXPECT_TRUE(Ask().has_ticket_issued());
  EXPECT_EQ(Ask().error().field(), "attempt_limit");
}

TEST_F(AssignmentTest, TicketThatWasBegunWithIsNotTakenBack) {
  Change([](AssignmentRow& row) { row.attempt_limit = 1; });
  Recording recording(world_, TicketOf(Ask()), station_.keys, 1);
  const Uuid& attempt = recording.seal.attempt;
  auto refused = [&] { return station_.ReturnTicket(attempt).error().code(); };
  ASSERT_TRUE(station_.Open(recording.header).has_attempt_opened());
  EXPECT_EQ(refused(), "conflict") << "opened, no tick yet";
  ASSERT_TRUE(station_.Put(recording.chunks[0]).has_chunk_ack());
  EXPECT_EQ(refused(), "conflict");
  ASSERT_TRUE(station_.Seal(recording.seal).has_sealed());
  EXPECT_EQ(refused(), "conflict");
  EXPECT_EQ(Listed().attempts_left(), 0u);
}

TEST_F(AssignmentTest, StationHandsBackItsOwnTicketsOnly) {
  EXPECT_EQ(station_.ReturnTicket(Uuid::New()).error().code(), "not_found");
  wire::Request odd;
  odd.mutable_return_ticket()->set_attempt("short");
  EXPECT_EQ(station_.Send(odd).error().code(), "invalid_input");
  Uuid attempt = trace::DecodeTicket(TicketOf(Ask()))->attempt;
  ASSERT_TRUE(
      world_.store->stations.AddEnrolCode(HashSha256(AsBytes("c2")), UnixMs{1} << 60, kSystem)
          .ok());
  std::optional<Session> session(std::in_place, world_.services, "127.0.0.1");
  ScriptedStation other([&](const wire::Request& request) {
    return session->Handle(request).reply.value_or(wire::Reply());
  });
  ASSERT_TRUE(other.Enrol("c2", "bench-2").has_enrolled());
  session.emplace(world_.services, "127.0.0.1");
  ASSERT_TRUE(other.Hello().has_welcome());
  EXPECT_EQ(other.ReturnTicket(attempt).error().code(), "not_found");
  EXPECT_EQ(world_.store->attempts.AttemptById(attempt)->flags, 0u);
}

TEST_F(AssignmentTest, ExamIsTakenAtItsStationOneAtATimeAndBegunNow) {
  Uuid here = *Uuid::Parse(world_.store->stations.Stations()->front().id.Text());
  ASSERT_TRUE(
      world_.store->stations.AddEnrolCode(HashSha256(AsBytes("c2")), UnixMs{1} << 60, kSystem)
          .ok());
  StationRow other;
  other.name = "bench-2";
  other.public_key.assign(32, 9);
  Uuid elsewhere =
      world_.store->stations
          .EnrolStation(HashSha256(AsBytes("c2")), other, HashSha256(AsBytes("credential 2")), 1)
          ->id;
  Change([&](AssignmentRow& row) {
    row.exam = true;
    row.stations = {elsewhere};
  });
  EXPECT_EQ(Ask().error().field(), "stations");
  EXPECT_NE(Ask().error().message().find("bench-2"), std::string::npos);
  Change([&](AssignmentRow& row) { row.stations.push_back(here); });
  wire::Reply issued = Ask();
  EXPECT_TRUE(issued.ticket_issued().exam());
  EXPECT_TRUE(RowOf(issued).exam);
  EXPECT_EQ(trace::DecodeTicket(TicketOf(issued))->expires_unix_ms,
            world_.now + kExamTicketValidMs);
  wire::Reply second = Ask();
  EXPECT_EQ(second.error().field(), "exam") << "one at a time";
  wire::Request later;
  later.mutable_request_ticket()->set_session(station_.session);
  later.mutable_request_ticket()->set_exercise(protocol::ToField(world_.exercise.content.view()));
  later.mutable_request_ticket()->set_profile(protocol::ToField(profile_.view()));
  later.mutable_request_ticket()->set_for_later(true);
  later.mutable_request_ticket()->set_station_unix_ms(world_.now);
  EXPECT_EQ(station_.Send(later).error().field(), "for_later");
}

TEST_F(AssignmentTest, ExamShowsNoScoreAtTheStationBeforeItsRelease) {
  Change([](AssignmentRow& row) { row.exam = true; });
  wire::Reply issued = Ask();
  Recording recording(world_, TicketOf(issued), station_.keys, 1);
  ASSERT_TRUE(station_.Open(recording.header, true).has_attempt_opened());
  ASSERT_TRUE(station_.Put(recording.chunks[0]).has_chunk_ack());
  ASSERT_TRUE(station_.Seal(recording.seal).has_sealed());
  AttemptResult result;
  result.score_json = PutText(*world_.store, "{}");
  result.score = 84.5;
  ASSERT_TRUE(world_.store->results.FinishAttempt(recording.seal.attempt, result, {}).ok());
  wire::AttemptState state = station_.Status(recording.seal.attempt).attempt_state();
  EXPECT_EQ(state.state(), "scored");
  EXPECT_TRUE(state.exam());
  EXPECT_EQ(state.result_json(), "");
  EXPECT_FALSE(Listed().has_best_score());
  Remark(recording.seal.attempt, world_.instructor, 1, "too steep");
  EXPECT_EQ(Listed().last_remark(), "");
  ASSERT_EQ(state.flags_size(), 1);
  EXPECT_EQ(state.flags(0), "resumed");
  ASSERT_TRUE(world_.store->judging.ReleaseAttempt(recording.seal.attempt, kSystem).ok());
  state = station_.Status(recording.seal.attempt).attempt_state();
  EXPECT_TRUE(state.released());
  EXPECT_EQ(state.result_json(), "{}");
  EXPECT_EQ(Listed().best_score(), 84.5);
  EXPECT_EQ(Listed().last_remark(), "too steep");
  Remark(recording.seal.attempt, world_.student, 3, "I see");
  EXPECT_EQ(Listed().last_remark(), "too steep") << "not one's own";
  Remark(recording.seal.attempt, world_.instructor, 2, std::string(300, 'm'));
  EXPECT_EQ(Listed().last_remark(), std::string(200, 'm')) << "the newest, not the last by tick";
}

TEST_F(AssignmentTest, GradedWorkBeginsOnlyWhereTheClockIsRight) {
  ASSERT_TRUE(world_.exercise.graded);
  UnixMs off = 0;
  station_.clock = [&] { return world_.now + off; };
  for (const UnixMs near : {-kMaxStationClockOffMs, kMaxStationClockOffMs}) {
    off = near;
    EXPECT_TRUE(Ask().has_ticket_issued()) << off;
  }
  for (const UnixMs far : {-kMaxStationClockOffMs - 1, kMaxStationClockOffMs + 1}) {
    off = far;
    EXPECT_EQ(Ask().error().code(), "forbidden") << off;
    EXPECT_EQ(Ask().error().field(), "clock") << off;
  }
  station_.clock = [] { return std::numeric_limits<UnixMs>::max(); };
  EXPECT_EQ(Ask().error().field(), "clock");
  station_.clock = [] { return UnixMs{0}; };
  EXPECT_EQ(Ask().error().field(), "clock") << "none stated";
  AssignedRow practice{open_, world_.exercise, 0};
  practice.exercise.graded = false;
  EXPECT_TRUE(MayBeginByClock(practice, world_.now, 0).ok());
}

TEST_F(AssignmentTest, NobodyWorksAtTwoStationsAtOnce) {
  ASSERT_TRUE(
      world_.store->stations.AddEnrolCode(HashSha256(AsBytes("c2")), UnixMs{1} << 60, kSystem)
          .ok());
  ASSERT_TRUE(ScriptedStation(Asking()).Enrol("c2", "bench-2").has_enrolled());
  const std::vector<StationRow> stations = *world_.store->stations.Stations();
  const Uuid elsewhere = std::ranges::find(stations, "bench-2", &StationRow::name)->id;
  Recording recording(world_, TicketOf(Ask()), station_.keys, 1);
  const Uuid attempt = recording.seal.attempt;
  auto there = [&] {
    AttemptRow row = *world_.store->attempts.AttemptById(attempt);
    row.id = Uuid::New();
    row.station = elsewhere;
    row.ticketed_ms = world_.now;
    return world_.store->tickets.CreateAttempt(row, Bytes{1}, kSystem);
  };
  EXPECT_TRUE(there().ok()) << "a ticket alone is no work";
  ASSERT_TRUE(station_.Open(recording.header).has_attempt_opened());
  EXPECT_EQ(there().field(), "station") << "opened, no tick yet";
  world_.now += kElsewhereMs / 2;
  ASSERT_TRUE(station_.Put(recording.chunks[0]).has_chunk_ack());
  world_.now += kElsewhereMs;
  EXPECT_EQ(there().code(), Code::kForbidden);
  EXPECT_NE(there().message().find("scripted"), std::string::npos) << there().message();
  EXPECT_TRUE(Ask().has_ticket_issued()) << "at the same station";
  world_.now += 1;
  EXPECT_TRUE(there().ok()) << "nothing came for a minute: that station may have lost its power";
  world_.now -= 1;
  EXPECT_EQ(there().field(), "station");
  ASSERT_TRUE(station_.Seal(recording.seal).has_sealed());
  EXPECT_TRUE(there().ok()) << "sealed";
}

// Sent each time; unknown facts are not shown, and too much is refused.
TEST_F(AssignmentTest, FactsAreKeptAsTheStationSaidThemLast) {
  Recording recording(world_, TicketOf(Ask()), station_.keys, 1);
  const Uuid attempt = recording.seal.attempt;
  auto kept = [&] { return world_.store->attempts.AttemptById(attempt)->facts; };
  ASSERT_TRUE(station_.Open(recording.header).has_attempt_opened());
  EXPECT_EQ(kept(), protocol::FactsJson({}));
  protocol::AttemptFacts facts;
  facts.set_resumed(2);
  facts.GetReflection()->MutableUnknownFields(&facts)->AddLengthDelimited(1000, "later");
  ASSERT_TRUE(station_.Open(recording.header, facts).has_attempt_opened());
  EXPECT_EQ(kept(), protocol::FactsJson(facts));
  EXPECT_EQ(kept().find("later"), std::string::npos);
  const std::string told = kept();
  facts.GetReflection()->MutableUnknownFields(&facts)->AddLengthDelimited(1001,
                                                                          std::string(4096, 'x'));
  wire::Reply refused = station_.Open(recording.header, facts);
  EXPECT_EQ(refused.error().code(), "too_large");
  EXPECT_EQ(refused.error().field(), "facts");
  EXPECT_EQ(kept(), told);
}

TEST_F(AssignmentTest, StationMayNameTheAssignmentItAsksFor) {
  AssignmentRow exam = open_;
  exam.exam = true;
  exam = *world_.store->assignments.AddAssignment(exam, kSystem);
  EXPECT_EQ(RowOf(Ask()).assignment, exam.id) << "saying nothing does not dodge an exam";
  wire::Reply practice = station_.RequestTicketFor(open_.id, world_.exercise.content, profile_);
  EXPECT_EQ(RowOf(practice).assignment, open_.id);
  EXPECT_FALSE(RowOf(practice).exam);
  wire::Reply unknown = station_.RequestTicketFor(Uuid::New(), world_.exercise.content, profile_);
  EXPECT_EQ(unknown.error().code(), "forbidden");
}

TEST_F(AssignmentTest, InstructorsTryWhatTheyLike) {
  Change([&](AssignmentRow& row) {
    row.opens_ms = world_.now + kHour;
    row.attempt_limit = 1;
  });
  ASSERT_TRUE(station_.SignIn("instructor").has_signed_in());
  EXPECT_FALSE(RowOf(Ask()).assignment.has_value());
  EXPECT_TRUE(Ask().has_ticket_issued());
}

TEST_F(AssignmentTest, ReadmittedRecordingIsJudgedByTheTermsThereAre) {
  Change([&](AssignmentRow& row) {
    row.exam = true;
    row.attempt_limit = 1;
  });
  trace::Ticket ticket = *trace::DecodeTicket(TicketOf(Ask()));
  ticket.attempt = Uuid::New();  // as after a restore from a backup made before it
  trace::SignTicket(ticket, world_.services.ticket_key.secret_key);
  Recording recording(world_, trace::EncodeTicket(ticket), station_.keys, 1);
  wire::Reply opened = station_.Open(recording.header);
  ASSERT_TRUE(opened.has_attempt_opened()) << opened.error().message();
  AttemptRow row = *world_.store->attempts.AttemptById(ticket.attempt);
  EXPECT_TRUE(row.exam) << "a restore does not turn an exam into practice";
  EXPECT_EQ(row.assignment, open_.id);
  EXPECT_EQ(row.flags, uint32_t{kReadmitted});
}

// The station has the exam as a whole; the server was restored from a backup made before it.
TEST_F(AssignmentTest, ExamSentAgainAfterARestoreIsStillThatExam) {
  Change([&](AssignmentRow& row) {
    row.exam = true;
    row.attempt_limit = 1;
    row.due_ms = world_.now + kHour;
    row.late_allowed = true;
  });
  world_.now = open_.due_ms + 1;  // it was begun late
  trace::Ticket ticket = *trace::DecodeTicket(TicketOf(Ask()));
  ASSERT_TRUE(station_.ReturnTicket(ticket.attempt).has_ticket_returned());
  ticket.attempt = Uuid::New();
  trace::SignTicket(ticket, world_.services.ticket_key.secret_key);
  Recording recording(world_, trace::EncodeTicket(ticket), station_.keys, 1);
  wire::Request offer;
  offer.mutable_offer_attempts()->add_attempts()->set_attempt(
      protocol::ToField(ticket.attempt.view()));
  ASSERT_EQ(station_.Send(offer).attempts_wanted().attempts_size(), 1);
  world_.now += 24 * kHour;

  trace::Ticket forged = ticket;  // another person's name on it
  forged.person = world_.instructor;
  Recording forgery(world_, trace::EncodeTicket(forged), station_.keys, 1);
  EXPECT_EQ(station_.Open(forgery.header).error().code(), "forbidden");
  forged = ticket;
  forged.station = Uuid::New();
  trace::SignTicket(forged, world_.services.ticket_key.secret_key);
  Recording elsewhere(world_, trace::EncodeTicket(forged), station_.keys, 1);
  EXPECT_EQ(station_.Open(elsewhere.header).error().code(), "forbidden");

  ASSERT_TRUE(station_.Open(recording.header).has_attempt_opened());
  EXPECT_EQ(Ask().error().field(), "attempt_limit") << "it is the one attempt";
  ASSERT_TRUE(station_.Put(recording.chunks[0]).has_chunk_ack());
  ASSERT_TRUE(station_.Seal(recording.seal).has_sealed());
  AttemptRow row = *world_.store->attempts.AttemptById(ticket.attempt);
  EXPECT_EQ(row.person, world_.student);
  EXPECT_TRUE(row.exam);
  EXPECT_EQ(row.due_ms, open_.due_ms);
  EXPECT_EQ(row.flags & (kLate | kReadmitted), uint32_t{kLate | kReadmitted});
  Recording second(world_, trace::EncodeTicket(ticket), station_.keys, 2);
  second.header_fields.station_software = "again";
  EXPECT_EQ(station_.Open(trace::EncodeHeader(second.header_fields)).error().code(), "conflict")
      << "one ticket, one recording";
  Person student = *world_.store->people.PersonById(world_.student);
  EXPECT_FALSE(CanSeeScore(student, row, false, false)) << "no score before its release";
  station_.Send(offer);
  EXPECT_EQ(station_.Send(offer).attempts_wanted().attempts_size(), 0);
}

// The person is newer than the backup the server was restored from.
TEST_F(AssignmentTest, RecordingOfAPersonThatARestoreForgotWaitsUntilTheAdminBringsThemBack) {
  trace::Ticket ticket = *trace::DecodeTicket(TicketOf(Ask()));
  ticket.attempt = Uuid::New();
  ticket.person = Uuid::New();
  trace::SignTicket(ticket, world_.services.ticket_key.secret_key);
  Recording recording(world_, trace::EncodeTicket(ticket), station_.keys, 1);
  auto told = [&] {
    AuditFilter filter;
    filter.action = "attempt.awaits";
    filter.object = ticket.attempt.Text();
    return *world_.store->audit.FindAudit(filter);
  };
  for (int tries = 0; tries < 3; ++tries) {
    wire::Error error = station_.Open(recording.header).error();
    EXPECT_EQ(error.code(), "unavailable") << "nothing a station gives up for";
    EXPECT_EQ(error.field(), protocol::kAwaited);
    EXPECT_NE(error.message().find(ticket.person.Text()), std::string::npos) << error.message();
  }
  ASSERT_EQ(told().size(), 1u) << "told once";
  EXPECT_NE(told()[0].after_json.find(ticket.person.Text()), std::string::npos);
  world_.now += 60 * 24 * kHour;  // however long it takes
  Person back;
  back.id = ticket.person;
  back.login = "late";
  back.display_name = "Late";
  ASSERT_TRUE(world_.store->people.CreatePerson(back, "none", {world_.cohort}, kSystem).ok());
  wire::Reply opened = station_.Open(recording.header);
  ASSERT_TRUE(opened.has_attempt_opened()) << opened.error().message();
  ASSERT_TRUE(station_.Put(recording.chunks[0]).has_chunk_ack());
  ASSERT_TRUE(station_.Seal(recording.seal).has_sealed());
  EXPECT_EQ(world_.store->attempts.AttemptById(ticket.attempt)->person, ticket.person);
}

// A ticket does not say that it was for a reference cut, which is scored before there is any.
TEST_F(AssignmentTest, ReadmittedCutOfATeacherCanBecomeTheReference) {
  for (Role role : {Role::kInstructor, Role::kStudent}) {
    trace::Ticket ticket = *trace::DecodeTicket(TicketOf(Ask()));
    ticket.attempt = Uuid::New();
    ticket.person = AddPerson(*world_.store, std::string("back-") + RoleName(role), role);
    trace::SignTicket(ticket, world_.services.ticket_key.secret_key);
    Recording recording(world_, trace::EncodeTicket(ticket), station_.keys, 1);
    wire::Reply opened = station_.Open(recording.header);
    ASSERT_TRUE(opened.has_attempt_opened()) << opened.error().message();
    EXPECT_EQ(world_.store->attempts.AttemptById(ticket.attempt)->as_reference,
              role == Role::kInstructor);
  }
}

TEST_F(AssignmentTest, RecordingOfAPersonWhoWasErasedIsRefusedForGood) {
  trace::Ticket ticket = *trace::DecodeTicket(TicketOf(Ask()));
  ticket.attempt = Uuid::New();
  ticket.person = AddPerson(*world_.store, "erased", Role::kStudent);
  ASSERT_TRUE(world_.store->erasures.ErasePerson(ticket.person, false, kSystem).ok());
  trace::SignTicket(ticket, world_.services.ticket_key.secret_key);
  Recording recording(world_, trace::EncodeTicket(ticket), station_.keys, 1);
  EXPECT_EQ(station_.Open(recording.header).error().code(), "conflict");
}

TEST_F(AssignmentTest, RecordingOfAnExerciseThatARestoreForgotWaitsForIt) {
  trace::Ticket ticket = *trace::DecodeTicket(TicketOf(Ask()));
  Recording recording(world_, trace::EncodeTicket(ticket), station_.keys, 1);
  ticket.attempt = Uuid::New();
  ticket.exercise = HashSha256(AsBytes("published after the backup"));
  trace::SignTicket(ticket, world_.services.ticket_key.secret_key);
  recording.header_fields.ticket = ticket;
  wire::Error error = station_.Open(trace::EncodeHeader(recording.header_fields)).error();
  EXPECT_EQ(error.code(), "unavailable");
  EXPECT_EQ(error.field(), protocol::kAwaited);
  EXPECT_NE(error.message().find("exercise"), std::string::npos);
}

// The station is newer than the backup: it comes back as itself, and the server takes its
// recordings.
TEST_F(AssignmentTest, StationThatARestoreForgotComesBackWithWhatItHolds) {
  ScriptedStation forgotten(Asking());
  trace::Ticket ticket = *trace::DecodeTicket(TicketOf(Ask()));
  ticket.attempt = Uuid::New();
  ticket.station = Uuid::New();
  trace::SignTicket(ticket, world_.services.ticket_key.secret_key);
  forgotten.id = protocol::ToField(ticket.station.view());
  forgotten.credential = std::string(32, 'c');
  EXPECT_EQ(forgotten.Hello().error().code(), "unauthenticated");
  ASSERT_TRUE(
      world_.store->stations.AddEnrolCode(HashSha256(AsBytes("new code")), UnixMs{1} << 60, kSystem)
          .ok());
  ScriptedStation again(Asking());
  again.keys = forgotten.keys;
  wire::Reply enrolled = again.Enrol("new code", "bench 2", ticket.station);
  ASSERT_TRUE(enrolled.has_enrolled()) << enrolled.error().message();
  EXPECT_EQ(enrolled.enrolled().station_id(), protocol::ToField(ticket.station.view()));
  ScriptedStation back(Asking());
  back.keys = again.keys;
  back.id = again.id;
  back.credential = again.credential;
  ASSERT_TRUE(back.Hello().has_welcome());
  Recording recording(world_, trace::EncodeTicket(ticket), back.keys, 1);
  wire::Reply opened = back.Open(recording.header);
  ASSERT_TRUE(opened.has_attempt_opened()) << opened.error().message();
  ASSERT_TRUE(back.Put(recording.chunks[0]).has_chunk_ack());
  ASSERT_TRUE(back.Seal(recording.seal).has_sealed());
  EXPECT_EQ(world_.store->attempts.AttemptById(ticket.attempt)->station, ticket.station);
}

TEST_F(AssignmentTest, ReadmittedRecordingWhoseTermsAreLostIsShownOnceItIsReleased) {
  Change([&](AssignmentRow& row) { row.exam = true; });
  trace::Ticket ticket = *trace::DecodeTicket(TicketOf(Ask()));
  Change([&](AssignmentRow& row) { row.exam = false; });  // what the backup has: practice
  ticket.attempt = Uuid::New();
  trace::SignTicket(ticket, world_.services.ticket_key.secret_key);
  Recording recording(world_, trace::EncodeTicket(ticket), station_.keys, 1);
  wire::Reply opened = station_.Open(recording.header);
  ASSERT_TRUE(opened.has_attempt_opened()) << opened.error().message();
  AttemptRow row = *world_.store->attempts.AttemptById(ticket.attempt);
  EXPECT_FALSE(row.assignment.has_value()) << "an exam's ticket is for ten minutes";
  EXPECT_EQ(row.flags, uint32_t{kReadmitted});
  EXPECT_FALSE(row.released);
  Person student = *world_.store->people.PersonById(world_.student);
  EXPECT_FALSE(CanSeeScore(student, row, /*graded=*/false, /*teaches=*/false));
  row.released = true;
  EXPECT_TRUE(CanSeeScore(student, row, false, false));
}

}  // namespace
}  // namespace enamel::server::stations
